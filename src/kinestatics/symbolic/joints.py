"""Joints as exact polynomials, each with a frame on its axis, and symbols for the lengths between them. Floor 7.

Every joint has a frame of its own with z along its axis where that can be said exactly, so that a turn is a c and an s.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..errors import ConfigurationError
from ..model import RobotModel
from ..spatial import ANGULAR, LINEAR
from .exact import cosine_sine
from .poses import Pose, Vector, identity, product
from .ring import Polynomial, TrigonometricRing

AXIS = 2
"""z, along which a joint's axis lies in its frame where that can be said exactly."""


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


def axis_of(screw: list[Any]) -> tuple[list[Any], bool]:
    """The direction of a screw's axis, and whether it slides."""
    slides = all(x == 0 for x in screw[ANGULAR])
    return screw[LINEAR] if slides else screw[ANGULAR], slides


def axis_frame(screw: list[Any], name: str) -> list[list[Any]]:
    """(4, 4) a frame on the axis of a unit screw: z along it where a coordinate of the direction is zero, else unturned.

    Raises:
        ConfigurationError: KS391 for a screw joint.
    """
    import sympy

    direction, slides = axis_of(screw)
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


def whole_ratio(multiplier: Any, slides: bool, model: RobotModel, i: int) -> Any:
    """The ratio between a joint and its coordinate, a whole number where it turns.

    Raises:
        ConfigurationError: KS391.
    """
    import sympy

    value = sympy.nsimplify(multiplier, rational=True)
    if not slides and not value.is_Integer:
        master = model.joint_names[model.columns[i]]
        message = f"joint {model.moving_names[i]!r} turns {multiplier} times as far as {master!r}"
        raise ConfigurationError("KS391", message, "closed forms need whole ratios between joints that turn")
    return value


def motion(ring: TrigonometricRing, joint: Joint) -> Pose:
    """The joint's own motion, seen from its frame at zero."""
    still = identity(ring)
    if joint.slides:
        q = ring.generator(ring.slides[joint.column]) * ring.number(joint.multiplier) + ring.read(joint.offset)
        return Pose(still.R, [ring.reduced(x * q) for x in joint.direction])
    c, s = ring.multiple(ring.angle_of(joint.column), int(joint.multiplier))
    if joint.offset != 0:
        c0, s0 = (ring.read(x) for x in cosine_sine(joint.offset))
        c, s = ring.reduced(c * c0 - s * s0), ring.reduced(s * c0 + c * s0)
    zero, one = ring.zero, ring.one
    x, y, z = joint.direction
    W = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    square = product(ring, W, W)
    R = [[ring.total((still.R[i][j], s * W[i][j], (one - c) * square[i][j])) for j in range(3)] for i in range(3)]
    return Pose(R, still.p)


class LengthNames:
    """Symbols for lengths that are numbers: d along the axis of the joint before, a (and b) across it.

    Equal lengths of a letter share a symbol, since such arms have closed forms of their own. The lengths are positive; signs
    stay in the formulas.
    """

    def __init__(self, taken: set[str]) -> None:
        self.taken = taken
        self.known: dict[tuple[str, Any], Any] = {}

    def of(self, before: Joint | None, T: Pose) -> list[Any]:
        """(3) signed symbols for the point of a pose behind a joint; None for what is 0, no number, or behind no joint."""
        return [None] * 3 if before is None else [self._signed(before, T, k) for k in range(3)]

    def _signed(self, before: Joint, T: Pose, k: int) -> Any:
        import sympy

        value = T.p[k]
        if value == 0 or not value.is_constant():
            return None
        size = value.to_dict()[next(iter(value.to_dict()))]
        letter = "d" if k == AXIS else "b" if k == 1 and T.p[0] != 0 else "a"
        key = (letter, abs(size))
        if key not in self.known:
            name = f"{letter}{before.column + 1}"
            while name in self.taken:
                name += "_"
            self.taken.add(name)
            self.known[key] = sympy.Symbol(name, positive=True)
        return self.known[key] if size > 0 else -self.known[key]

    @property
    def values(self) -> dict[Any, Any]:
        """symbol → the number it stands for."""
        import sympy

        return {symbol: sympy.Rational(int(size.p), int(size.q)) for (_, size), symbol in self.known.items()}


def carried(old: TrigonometricRing, p: Polynomial, new: TrigonometricRing) -> Polynomial:
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


def carried_pose(old: TrigonometricRing, T: Pose, new: TrigonometricRing, names: list[Any]) -> Pose:
    """A pose in a ring with more parameters, with names in place of coordinates of its point where they are not None."""
    R = [[carried(old, x, new) for x in row] for row in T.R]
    return Pose(R, [carried(old, x, new) if n is None else new.read(n) for x, n in zip(T.p, names, strict=True)])
