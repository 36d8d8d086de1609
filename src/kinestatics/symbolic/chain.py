"""The exact Jacobian of a chain of joints, in the frame of a middle link, where its entries are shortest. Floor 7.

Every joint has a frame of its own with z along its axis where that can be said exactly, so that a turn is a c and an s. The
determinant of a task that knows no direction (all six rows, position, orientation) is the same in every frame; the frame of
a middle link makes it a hundred times cheaper, since columns near to it depend on few joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..frames import TIP
from ..model import RobotModel
from ..spatial import ANGULAR, ANGULAR_ROWS, LINEAR, LINEAR_ROWS
from .exact import exact, joint_symbols
from .ring import Matrix, Polynomial, TrigonometricRing, atoms_of, expanded

Vector = list[Polynomial]
WHOLE_TASKS = ((*LINEAR_ROWS, *ANGULAR_ROWS), LINEAR_ROWS, ANGULAR_ROWS)
"""Tasks whose determinant is the same in all axes."""
_AXIS = 2  # z


class Pose(NamedTuple):
    """A rotation (3, 3) and a point (3) of polynomials."""

    R: Matrix
    p: Vector


class Joint(NamedTuple):
    """One moving joint: the fixed pose before it, its unit screw there, and how its column moves it.

    Attributes:
        placed: frame of the joint at zero seen from the frame of the joint before.
        direction: (3) of the axis, which goes through the origin; slides: whether it moves along it.
        column, multiplier, offset: it moves by multiplier · q[column] + offset.
    """

    placed: Pose
    direction: Vector
    slides: bool
    column: int
    multiplier: Any
    offset: Any


@dataclass(frozen=True, eq=False)
class ExactChain:
    """The joints between the base and a link, exactly.

    Attributes:
        ring: of the polynomials; joints: base first; end: the link's frame seen from the last joint's.
        columns: number of columns of the Jacobian.
        lengths: what the symbols that `named` put in place of numbers stand for [m].
    """

    ring: TrigonometricRing
    joints: tuple[Joint, ...]
    end: Pose
    columns: int
    lengths: Mapping[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, model: RobotModel, at: str = TIP) -> ExactChain:
        """The chain from the base to a link.

        Raises:
            ConfigurationError: KS391 for a screw joint, or a mimic joint whose ratio is no whole number.
            ArrayTypeError: KS390.
        """
        model = model if model.is_symbolic else exact(model)
        link = model.link(at)
        path = model.path(model.link_joints[link])
        placements = [expanded(model.placements[i]) for i in path]
        screws = [expanded(model.screws[i]) for i in path]
        last = expanded(model.link_placements[link])
        offsets = expanded(np.array([model.offsets[i] for i in path], dtype=object))
        frames = [_axis_frame(screw, model.moving_names[i]) for screw, i in zip(screws, path, strict=True)]
        entries = [x for matrix in (*placements, last) for row in matrix[:-1] for x in row]
        entries += [x for frame in frames for row in frame for x in row]
        turning = {model.columns[i]: not slides for i, (*_, slides) in zip(path, map(_kind, screws), strict=True)}
        turns = tuple(turning.get(j, True) for j in range(model.n))
        constants, parameters, roots = atoms_of([*entries, *_turning(offsets, screws)])
        ring = TrigonometricRing(tuple(joint_symbols(model)), turns, constants, parameters, roots)
        reader = _Reader(ring)
        joints, before = [], None
        for i, placement, screw, frame, offset in zip(path, placements, screws, frames, offsets, strict=True):
            own = reader.pose(frame)
            placed = reader.pose(placement)
            placed = compose(ring, placed if before is None else compose(ring, inverse(ring, before), placed), own)
            slides = _kind(screw)[-1]
            given = screw[LINEAR] if slides else screw[ANGULAR]
            direction = turned(ring, transposed(own.R), [ring.read(x) for x in given])
            multiplier = model.multipliers[i]
            joints.append(Joint(placed, direction, slides, model.columns[i], _whole(multiplier, slides, model, i), offset))
            before = own
        end = reader.pose(last)
        end = end if before is None else compose(ring, inverse(ring, before), end)
        return cls(ring, *_slid(ring, joints, end), model.n)

    def named(self) -> ExactChain:
        """The same chain with symbols for its lengths: d along the axis of the joint before, a (and b) across it.

        Equal lengths of a letter share a symbol, since such arms have closed forms of their own. The lengths are positive;
        signs stay in the formulas.
        """
        import sympy

        found: dict[tuple[str, Any], Any] = {}
        taken = {str(x) for x in (*self.ring.parameters, *self.ring.joints)}
        plans = []
        for joint, pose in zip(self.joints, [x.placed for x in self.joints[1:]] + [self.end], strict=True):
            plans.append([_length_name(joint, pose, k, found, taken) for k in range(3)])
        lengths = {symbol: sympy.Rational(int(size.p), int(size.q)) for (_, size), symbol in found.items()}
        parameters = tuple(sorted({*self.ring.parameters, *lengths}, key=str))
        ring = replace(self.ring, parameters=parameters)

        def carried(old: Pose, plan: list[Any] | None) -> Pose:
            R = [[_carried(self.ring, x, ring) for x in row] for row in old.R]
            names = plan or [None] * 3
            pairs = zip(old.p, names, strict=True)
            return Pose(R, [_carried(self.ring, x, ring) if n is None else ring.read(n) for x, n in pairs])

        joints = []
        for k, joint in enumerate(self.joints):
            direction = [_carried(self.ring, x, ring) for x in joint.direction]
            joints.append(joint._replace(placed=carried(joint.placed, plans[k - 1] if k else None), direction=direction))
        end = carried(self.end, plans[-1] if plans else None)
        return ExactChain(ring, tuple(joints), end, self.columns, lengths)

    @cached_property
    def _rows_at_middle(self) -> tuple[Matrix, Pose]:
        return self.jacobian_at(len(self.joints) // 2)

    def motion(self, joint: Joint) -> Pose:
        """The joint's own motion, seen from its frame at zero."""
        ring = self.ring
        zero, one = ring.zero, ring.one
        identity = [[one if i == j else zero for j in range(3)] for i in range(3)]
        if joint.slides:
            q = ring.generator(ring.slides[joint.column]) * ring.number(joint.multiplier) + ring.read(joint.offset)
            return Pose(identity, [ring.reduced(x * q) for x in joint.direction])
        c, s = ring.multiple(ring.angle_of(joint.column), int(joint.multiplier))
        if joint.offset != 0:
            import sympy

            c0, s0 = ring.read(sympy.cos(joint.offset)), ring.read(sympy.sin(joint.offset))
            c, s = ring.reduced(c * c0 - s * s0), ring.reduced(s * c0 + c * s0)
        x, y, z = joint.direction
        W = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
        square = product(ring, W, W)
        R = [[ring.total((identity[i][j], s * W[i][j], (one - c) * square[i][j])) for j in range(3)] for i in range(3)]
        return Pose(R, [zero] * 3)

    def jacobian_at(self, middle: int) -> tuple[Matrix, Pose]:
        """(6, n) Jacobian in the frame of joint `middle` before it moves, at its origin; and the end seen from there."""
        ring = self.ring
        columns: list[Vector] = [[ring.zero] * 6 for _ in range(self.columns)]
        here = _identity(ring)
        for joint in self.joints[middle:]:
            here = here if joint is self.joints[middle] else compose(ring, here, joint.placed)
            self._add(columns, joint, here)
            here = compose(ring, here, self.motion(joint))
        end = compose(ring, here, self.end)
        here = _identity(ring)
        for k in range(min(middle, len(self.joints) - 1), 0, -1):
            joint = self.joints[k - 1]
            here = compose(ring, here, inverse(ring, self.joints[k].placed))
            here = compose(ring, here, inverse(ring, self.motion(joint)))
            self._add(columns, joint, here)
        return [[column[r] for column in columns] for r in range(6)], end

    def _add(self, columns: list[Vector], joint: Joint, here: Pose) -> None:
        """The column of a joint whose frame is seen at `here`."""
        ring = self.ring
        z = turned(ring, here.R, joint.direction)
        v, w = (z, [ring.zero] * 3) if joint.slides else (crossed(ring, here.p, z), z)
        factor = ring.number(joint.multiplier)
        own = columns[joint.column]
        columns[joint.column] = [ring.reduced(a + factor * b) for a, b in zip(own, [*v, *w], strict=True)]

    def task_rows(self, rows: tuple[int, ...]) -> Matrix:
        """Rows of the Jacobian at the link's origin: in axes of a middle link where that leaves minors alone, else base."""
        if rows in WHOLE_TASKS:
            J, end = self._rows_at_middle
            point = end.p if rows == LINEAR_ROWS else None
        else:
            J, end = self.jacobian_at(0)
            J = _turned_rows(self.ring, self.joints[0].placed.R if self.joints else _identity(self.ring).R, J)
            point = turned(self.ring, self.joints[0].placed.R, end.p) if self.joints else None
        if point is not None:
            J = _moved(self.ring, J, point)
        return [J[r] for r in rows]


def _length_name(joint: Joint, pose: Pose, k: int, found: dict[tuple[str, Any], Any], taken: set[str]) -> Any:
    """The signed symbol of a number in a pose behind a joint; None where it is 0 or not a number."""
    import sympy

    value = pose.p[k]
    if value == 0 or not value.is_constant():
        return None
    size = value.to_dict()[next(iter(value.to_dict()))]
    letter = "d" if k == _AXIS else "b" if k == 1 and pose.p[0] != 0 else "a"
    key = (letter, abs(size))
    if key not in found:
        name = f"{letter}{joint.column + 1}"
        while name in taken:
            name += "_"
        taken.add(name)
        found[key] = sympy.Symbol(name, positive=True)
    return found[key] if size > 0 else -found[key]


def _carried(old: TrigonometricRing, p: Polynomial, new: TrigonometricRing) -> Polynomial:
    """A polynomial in a ring with more parameters."""
    first = old.parameter_place(0)
    places = [new.parameter_place(new.parameters.index(x)) for x in old.parameters]
    places += [new.parameter_place(len(new.parameters) + k) for k in range(len(old.roots))]
    size = len(new.context.names())
    terms = {}
    for exponents, coefficient in p.to_dict().items():
        moved = [*exponents[:first], *[0] * (size - first)]
        for place, power in zip(places, exponents[first:], strict=False):
            moved[place] = power
        terms[tuple(moved)] = coefficient
    return new.context.from_dict(terms) if terms else new.zero


def _slid(ring: TrigonometricRing, joints: list[Joint], end: Pose) -> tuple[tuple[Joint, ...], Pose]:
    """The same chain with frames moved along their axes to where they meet, or are nearest to, the axis before.

    As in a table of Denavit and Hartenberg; done where axes are at right angles or parallel.
    """
    along = ring.zero  # from where the frame before lies now to where it lay
    slid: list[Joint] = []
    for k, joint in enumerate(joints):
        R, p = joint.placed
        p = [*p[:_AXIS], p[_AXIS] + along]
        along, z = ring.zero, [row[_AXIS] for row in R]
        plain = joint.direction[:_AXIS] == [ring.zero] * 2 and all(x in (ring.zero, ring.one, -ring.one) for x in z)
        if k and plain:
            along = ring.total(a * b for a, b in zip(p, z, strict=True))
            p = [ring.reduced(x - along * a) for x, a in zip(p, z, strict=True)]
        slid.append(joint._replace(placed=Pose(R, p)))
    return tuple(slid), Pose(end.R, [*end.p[:_AXIS], end.p[_AXIS] + along])


def determinant(ring: TrigonometricRing, M: Matrix) -> Polynomial:
    """The determinant, by expansion along the emptiest row or column, in canonical form at every step."""
    n = len(M)
    if n == 0:
        return ring.one
    if n == 1:
        return M[0][0]
    if n == 2:
        return ring.reduced(M[0][0] * M[1][1] - M[0][1] * M[1][0])
    filled = [(sum(x != 0 for x in row), False, i) for i, row in enumerate(M)]
    filled += [(sum(row[j] != 0 for row in M), True, j) for j in range(n)]
    _, by_column, k = min(filled)
    parts = []
    for i in range(n):
        r, c = (i, k) if by_column else (k, i)
        if M[r][c] == 0:
            continue
        minor = [[row[j] for j in range(n) if j != c] for a, row in enumerate(M) if a != r]
        term = M[r][c] * determinant(ring, minor)
        parts.append(term if (r + c) % 2 == 0 else -term)
    return ring.total(parts)


def product(ring: TrigonometricRing, A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    return [[ring.total(x * row[j] for x, row in zip(line, B, strict=True)) for j in range(3)] for line in A]


def turned(ring: TrigonometricRing, R: Matrix, v: Vector) -> Vector:
    """R v."""
    return [ring.total(a * b for a, b in zip(row, v, strict=True)) for row in R]


def crossed(ring: TrigonometricRing, a: Vector, b: Vector) -> Vector:
    """a × b."""
    return [ring.reduced(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) for i in range(3)]


def transposed(R: Matrix) -> Matrix:
    """Rᵀ."""
    return [list(column) for column in zip(*R, strict=True)]


def compose(ring: TrigonometricRing, A: Pose, B: Pose) -> Pose:
    """A B."""
    return Pose(product(ring, A.R, B.R), [ring.reduced(a + b) for a, b in zip(A.p, turned(ring, A.R, B.p), strict=True)])


def inverse(ring: TrigonometricRing, A: Pose) -> Pose:
    """A⁻¹."""
    R = transposed(A.R)
    return Pose(R, [-x for x in turned(ring, R, A.p)])


def _identity(ring: TrigonometricRing) -> Pose:
    return Pose([[ring.one if i == j else ring.zero for j in range(3)] for i in range(3)], [ring.zero] * 3)


def _turned_rows(ring: TrigonometricRing, R: Matrix, J: Matrix) -> Matrix:
    halves = (J[LINEAR], J[ANGULAR])
    return [row for half in halves for row in _times(ring, R, half)]


def _times(ring: TrigonometricRing, R: Matrix, half: Matrix) -> Matrix:
    columns = [turned(ring, R, list(column)) for column in zip(*half, strict=True)]
    return [list(row) for row in zip(*columns, strict=True)] if columns else [[], [], []]


def _moved(ring: TrigonometricRing, J: Matrix, point: Vector) -> Matrix:
    """The same Jacobian at another point: v + ω × point."""
    turning = list(zip(*J[ANGULAR], strict=True))
    shifts = [crossed(ring, list(w), point) for w in turning]
    linear = [[ring.reduced(x + shift[r]) for x, shift in zip(row, shifts, strict=True)] for r, row in enumerate(J[LINEAR])]
    return [*linear, *J[ANGULAR]]


def _kind(screw: list[Any]) -> tuple[list[Any], bool]:
    """The direction of a screw's axis, and whether it slides."""
    slides = all(x == 0 for x in screw[ANGULAR])
    return screw[LINEAR] if slides else screw[ANGULAR], slides


def _axis_frame(screw: list[Any], name: str) -> list[list[Any]]:
    """(4, 4) a frame on the axis of a unit screw: z along it where a coordinate of the direction is zero, else unturned.

    Raises:
        ConfigurationError: KS391 for a screw joint.
    """
    import sympy

    direction, slides = _kind(screw)
    w = sympy.Matrix(direction)
    point = sympy.zeros(3, 1) if slides else w.cross(sympy.Matrix(screw[LINEAR]))
    if not slides and sympy.expand(sympy.expand_trig(w.dot(sympy.Matrix(screw[LINEAR])))) != 0:
        hint = "closed forms are for joints that turn or slide"
        raise ConfigurationError("KS391", f"joint {name!r} turns and advances", hint)
    zeros = [k for k in range(3) if direction[k] == 0]
    R = sympy.eye(3)
    if zeros:
        x = R[:, zeros[0]]
        R = sympy.Matrix.hstack(x, w.cross(x), w)
    return [*([*R.row(i), point[i]] for i in range(3)), [*sympy.zeros(1, 3), sympy.Integer(1)]]


def _turning(offsets: list[Any], screws: list[list[Any]]) -> list[Any]:
    """What the offsets of the joints bring into the ring."""
    import sympy

    return [x if _kind(screw)[-1] else sympy.cos(x) for x, screw in zip(offsets, screws, strict=True)]


def _whole(multiplier: Any, slides: bool, model: RobotModel, i: int) -> Any:
    import sympy

    value = sympy.nsimplify(multiplier, rational=True)
    if not slides and not value.is_Integer:
        master = model.joint_names[model.columns[i]]
        message = f"joint {model.moving_names[i]!r} turns {multiplier} times as far as {master!r}"
        raise ConfigurationError("KS391", message, "closed forms need whole ratios between joints that turn")
    return value


class _Reader:
    """SymPy poses as polynomials."""

    def __init__(self, ring: TrigonometricRing) -> None:
        self.ring = ring

    def pose(self, T: Any) -> Pose:
        entries = [[self.ring.read(x) for x in row] for row in T[:-1]]
        return Pose([row[:-1] for row in entries], [row[-1] for row in entries])
