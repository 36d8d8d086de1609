"""`closed_form`: kinematic and static quantities of a robot as short expressions, exact and without simplification. Floor 7.

`Mechanism` holds the joints and links in question as exact polynomials; the quantities below are sums, products and
derivatives of these; `Writer` prints polynomials. Polynomials are canonical, so that nothing is left to be simplified.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..errors import (
    ArrayTypeError,
    ConfigurationError,
    FrameMismatchError,
    MissingMassError,
    UnknownNameError,
    nearest,
)
from ..frames import BASE, TIP, Frame
from ..kinematics import named_frame, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..quantities import Wrench, wrapped
from ..spatial import LINEAR_ROWS, ROW_NAMES, WRENCH_NAMES
from ..tasks import find_task
from .chain import (
    WHOLE_TASKS,
    ExactChain,
    Joint,
    Pose,
    Vector,
    _axis_frame,
    _carried,
    _kind,
    _length_name,
    _Reader,
    _turning,
    _whole,
    compose,
    crossed,
    determinant,
    inverse,
    transposed,
    turned,
)
from .exact import exact, fraction, free_symbols, joint_symbols, sympy_module
from .halfangle import HalfAngleRing
from .printing import _values
from .ring import Exponents, Matrix, Polynomial, TrigonometricRing, atoms_of, expanded

_Z = 2
_FACTORED = 600
"""Determinants of more terms are printed as they are: their half-angle polynomials are too long to factor."""
_SEED = 20261127
_LOOKED_AT = 5
_LONG = 100  # whole numbers from here on are lengths in disguise


# Mechanism: exact poses and Jacobians of any link of a tree of joints, seen from any body


@dataclass(frozen=True, eq=False)
class Mechanism:
    """The joints that carry some links of a robot, each with a frame whose z lies along its axis where that is exact.

    Attributes:
        ring: of the polynomials; symbols: (n) of the joints.
        parents: joint → the joint before, -1 for the base; joints: joint → it, placed in the frame of its parent.
        links: link → (joint that carries it, its frame seen from the joint's).
        values: what the symbols that `named` put in place of numbers stand for [m].
    """

    model: RobotModel
    ring: TrigonometricRing
    parents: Mapping[int, int]
    joints: Mapping[int, Joint]
    links: Mapping[int, tuple[int, Pose]]
    values: Mapping[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, model: RobotModel, links: Iterable[int], entries: Iterable[Any] = (), symbols: Iterable[Any] = ()
    ) -> Mechanism:
        """The joints between the base and some links of an exact model.

        Args:
            links: indices of the links.
            entries: expressions whose angles, lengths and roots the ring must hold besides.
            symbols: that it must hold as parameters.

        Raises:
            ConfigurationError: KS391. ArrayTypeError: KS390.
        """
        wanted = sorted(set(links))
        used = sorted({i for link in wanted for i in model.path(model.link_joints[link])})
        screws = {i: expanded(model.screws[i]) for i in used}
        frames = {i: _axis_frame(screws[i], model.moving_names[i]) for i in used}
        placements = {i: expanded(model.placements[i]) for i in used}
        places = {link: expanded(model.link_placements[link]) for link in wanted}
        offsets = dict(zip(used, expanded(_objects(model.offsets[i] for i in used)), strict=True))
        found = [x for T in (*placements.values(), *places.values(), *frames.values()) for row in T for x in row]
        found += [*_turning(list(offsets.values()), list(screws.values())), *expanded(_objects(entries))]
        constants, parameters, roots = atoms_of(found)
        extra = tuple(x for x in symbols if x not in parameters)
        joints = tuple(joint_symbols(model))
        ring = TrigonometricRing(joints, _turns(model, screws), constants, (*parameters, *extra), roots)
        reader, own, made = _Reader(ring), {}, {}
        for i in used:
            own[i] = reader.pose(frames[i])
            placed = reader.pose(placements[i])
            before = model.parents[i]
            placed = compose(ring, compose(ring, inverse(ring, own[before]), placed) if before >= 0 else placed, own[i])
            slides, direction = _kind(screws[i])[1], _kind(screws[i])[0]
            seen = turned(ring, transposed(own[i].R), [ring.read(x) for x in direction])
            ratio = _whole(model.multipliers[i], slides, model, i)
            made[i] = Joint(placed, seen, slides, model.columns[i], ratio, offsets[i])
        placed_links = {}
        for link, T in places.items():
            i = model.link_joints[link]
            placed_links[link] = i, reader.pose(T) if i < 0 else compose(ring, inverse(ring, own[i]), reader.pose(T))
        return cls(model, ring, {i: model.parents[i] for i in used}, made, placed_links)._slid()

    def _slid(self) -> Mechanism:
        """The same with frames moved along their axes to where they are nearest to the axis before, as in a table of
        Denavit and Hartenberg; done where axes are at right angles or parallel."""
        ring = self.ring
        along = {-1: ring.zero}  # from where a frame lies now to where it lay
        joints = {}
        for i, joint in self.joints.items():
            R, p = joint.placed
            p = [*p[:_Z], p[_Z] + along[self.parents[i]]]
            along[i], z = ring.zero, [row[_Z] for row in R]
            if joint.direction[:_Z] == [ring.zero] * 2 and all(x in (ring.zero, ring.one, -ring.one) for x in z):
                along[i] = ring.total(a * b for a, b in zip(p, z, strict=True))
                p = [ring.reduced(x - along[i] * a) for x, a in zip(p, z, strict=True)]
            joints[i] = joint._replace(placed=Pose(R, p))
        links = {link: (i, Pose(T.R, [*T.p[:_Z], T.p[_Z] + along[i]])) for link, (i, T) in self.links.items()}
        return replace(self, joints=joints, links=links)

    def named(self) -> Mechanism:
        """The same with symbols for lengths that are numbers: d along the axis of the joint before, a (and b) across."""
        import sympy

        old, found = self.ring, dict[tuple[str, Any], Any]()
        taken = {str(x) for x in (*old.parameters, *old.joints)} | {str(x) for x in free_symbols(self.model)}

        def plan(before: int, T: Pose) -> list[Any]:
            if before < 0:
                return [None] * 3
            return [_length_name(self.joints[before], T, k, found, taken) for k in range(3)]

        joint_plans = {i: plan(self.parents[i], joint.placed) for i, joint in self.joints.items()}
        link_plans = {link: plan(i, T) for link, (i, T) in self.links.items()}
        values = {symbol: sympy.Rational(int(size.p), int(size.q)) for (_, size), symbol in found.items()}
        ring = replace(old, parameters=(*old.parameters, *sorted(values, key=str)))

        def carried(T: Pose, names: list[Any]) -> Pose:
            R = [[_carried(old, x, ring) for x in row] for row in T.R]
            return Pose(R, [_carried(old, x, ring) if n is None else ring.read(n) for x, n in zip(T.p, names, strict=True)])

        joints = {
            i: joint._replace(
                placed=carried(joint.placed, joint_plans[i]), direction=[_carried(old, x, ring) for x in joint.direction]
            )
            for i, joint in self.joints.items()
        }
        links = {link: (i, carried(T, link_plans[link])) for link, (i, T) in self.links.items()}
        return Mechanism(self.model, ring, self.parents, joints, links, values)

    @cached_property
    def steps(self) -> dict[int, Pose]:
        """joint → its frame, moved, seen from the moved frame of the joint before."""
        ring = self.ring
        motion = ExactChain(ring, (), _unmoved(ring), self.model.n).motion
        return {i: compose(ring, joint.placed, motion(joint)) for i, joint in self.joints.items()}

    @cached_property
    def _seen(self) -> dict[int, dict[int, Pose]]:
        return {}

    def seen_from(self, body: int) -> dict[int, Pose]:
        """The moved frames of all joints, and the base (-1), seen from the moved frame of one of them."""
        if body in self._seen:
            return self._seen[body]
        ring = self.ring
        found = {body: _unmoved(ring)}
        here, k = found[body], body
        while k >= 0:
            here = compose(ring, here, inverse(ring, self.steps[k]))
            k = self.parents[k]
            found[k] = here
        for i, step in self.steps.items():
            if i not in found:
                found[i] = compose(ring, found[self.parents[i]], step)
        self._seen[body] = found
        return found

    def point(self, link: int, offset: Sequence[Any], body: int) -> Vector:
        """A point of a link, given in the link's axes, seen from a body."""
        joint, T = self.links[link]
        ring = self.ring
        local = [ring.read(exact_value(x)) for x in offset]
        return compose(ring, compose(ring, self.seen_from(body)[joint], T), Pose(T.R, local)).p

    def pose(self, link: int, offset: Sequence[Any] = (0, 0, 0), body: int = -1) -> Pose:
        """A link's axes, at a point of it, seen from a body."""
        joint, T = self.links[link]
        placed = compose(self.ring, self.seen_from(body)[joint], T)
        return Pose(placed.R, self.point(link, offset, body))

    def path(self, link: int) -> list[int]:
        """The joints that carry a link, base first."""
        found, i = [], self.links[link][0]
        while i >= 0:
            found.append(i)
            i = self.parents[i]
        return found[::-1]

    def jacobian(
        self, link: int, body: int, origin: Vector | None = None, axes: Matrix | None = None
    ) -> list[list[Polynomial]]:
        """(6, n) the Jacobian of a link, linear rows first.

        Args:
            body: joint whose moved frame the columns are found in, -1 for the base.
            origin: (3) where the velocity is taken, seen from the body; default its origin.
            axes: (3, 3) rotation of the axes of the rows, seen from the body; default the body's.
        """
        ring, seen = self.ring, self.seen_from(body)
        point = [ring.zero] * 3 if origin is None else origin
        columns = [[ring.zero] * len(ROW_NAMES) for _ in range(self.model.n)]
        for i in self.path(link):
            joint, (R, p) = self.joints[i], seen[i]
            z = turned(ring, R, joint.direction)
            arm = [ring.reduced(a - b) for a, b in zip(point, p, strict=True)]
            halves = (z, [ring.zero] * 3) if joint.slides else (crossed(ring, z, arm), z)
            six = [x for half in halves for x in (half if axes is None else turned(ring, transposed(axes), half))]
            factor, own = ring.number(joint.multiplier), columns[joint.column]
            columns[joint.column] = [ring.reduced(a + factor * b) for a, b in zip(own, six, strict=True)]
        return [[column[r] for column in columns] for r in range(len(ROW_NAMES))]

    def jacobian_in(self, link: int, frame: Frame, offset: Sequence[Any]) -> list[list[Polynomial]]:
        """(6, n) the Jacobian of a link in axes of one link, at a point of another."""
        axes, origin = self.model.link(frame.axes), self.model.link(frame.origin)
        body, T = self.links[axes]
        return self.jacobian(link, body, self.point(origin, offset, body), T.R)

    def middle(self, link: int) -> int:
        """The joint in the middle of those that carry a link; -1 where there is none."""
        path = self.path(link)
        return path[(len(path) - 1) // 2] if path else -1

    def slope(self, p: Polynomial, column: int) -> Polynomial:
        """∂p/∂q of a joint."""
        ring = self.ring
        if column in ring.slides:
            return p.derivative(ring.slides[column])
        angle = ring.angle_of(column)
        by_sine = p.derivative(angle.sine) * ring.generator(angle.cosine)
        return ring.reduced(by_sine - p.derivative(angle.cosine) * ring.generator(angle.sine))


def _turns(model: RobotModel, screws: Mapping[int, list[Any]]) -> tuple[bool, ...]:
    """(n) whether a joint turns.

    Raises:
        ConfigurationError: KS391 where one coordinate turns some joints and slides others.
    """
    found: dict[int, bool] = {}
    for i, screw in screws.items():
        slides = _kind(screw)[1]
        if found.setdefault(model.columns[i], not slides) == slides:
            message = f"joint {model.joint_names[model.columns[i]]!r} turns one joint and slides another"
            raise ConfigurationError("KS391", message, "closed forms need one kind of joint for each coordinate")
    return tuple(found.get(j, True) for j in range(model.n))


def _unmoved(ring: TrigonometricRing) -> Pose:
    return Pose([[ring.one if i == j else ring.zero for j in range(3)] for i in range(3)], [ring.zero] * 3)


def _objects(entries: Iterable[Any]) -> Array:
    values = list(entries)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


# Writer: short expressions for polynomials

Part = tuple[Any, ...]
"""Of one group of angles: (c, s), the powers of cosine and sine; or, of several angles, (frequencies, 0 cos | 1 sin)."""
Key = tuple[tuple[Part, ...], Exponents]
Table = dict[Key, Fraction]
Sums = dict[Key, dict[tuple[int, ...], tuple[Fraction, Fraction]]]
"""Σ (a + b i) e^(i f·x) of one group, for each key without it."""
Term = tuple[Fraction, dict[int, int]]
"""A coefficient, and the powers of factors by their number."""


class Writer:
    """Polynomials as SymPy expressions: cosines of sums of angles where that is shorter, common factors taken out."""

    def __init__(self, ring: TrigonometricRing) -> None:
        self.ring = ring
        self.values = _values(ring)
        self.trigonometric = {place for angle in ring.angles for place in (angle.cosine, angle.sine)}
        self.plain = [k for k in range(len(self.values)) if k not in self.trigonometric]

    def matrix(self, M: Matrix) -> Any:
        """A SymPy matrix."""
        import sympy

        return sympy.ImmutableDenseMatrix([[self(p) for p in row] for row in M])

    def __call__(self, p: Polynomial) -> Any:
        """One expression."""
        angles, table = self._table(p)
        groups: list[tuple[int, ...]] = [(a,) for a in angles]
        for g in range(len(groups)):
            table = min(table, _with_sines(table, g), _with_multiples(table, g), key=_size)
        size, tried = _size(table), set[tuple[Any, ...]]()
        while pair := next((p for p in itertools.combinations(groups, 2) if p not in tried), None):
            tried.add(pair)
            x, y = map(groups.index, pair)
            if _worth(table, x, y) and (cost := _size(merged := _merged(table, x, y))) < size:
                groups, table, size = [*(g for g in groups if g not in pair), pair[0] + pair[1]], merged, cost
        atoms: dict[Any, int] = {}
        terms = [self._term(groups, key, value, atoms) for key, value in table.items()]
        return _nested(terms, list(atoms))

    def _table(self, p: Polynomial) -> tuple[list[int], Table]:
        terms = {tuple(map(int, e)): Fraction(int(c.p), int(c.q)) for e, c in p.to_dict().items()}
        pairs = [(angle.cosine, angle.sine) for angle in self.ring.angles]
        present = [a for a, (c, s) in enumerate(pairs) if any(e[c] or e[s] for e in terms)]
        table = {}
        for e, coefficient in terms.items():
            parts = tuple((e[pairs[a][0]], e[pairs[a][1]]) for a in present)
            table[parts, tuple(e[k] for k in self.plain if k < len(e))] = coefficient
        return present, table

    def _term(self, groups: list[tuple[int, ...]], key: Key, value: Fraction, atoms: dict[Any, int]) -> Term:
        import sympy

        factors: dict[int, int] = {}
        for group, part in zip(groups, key[0], strict=True):
            angles = [self.ring.angles[a].expression for a in group]
            if not isinstance(part[0], tuple):
                wave = [(sympy.cos(angles[0]), part[0]), (sympy.sin(angles[0]), part[1])]
            else:
                phase = sympy.Add(*[f * x for f, x in zip(part[0], angles, strict=True)])
                wave = [(_wave_of(phase, part[1]), 1)] if phase != 0 else []
            for x, power in wave:
                if power:
                    _raise(factors, atoms.setdefault(x, len(atoms)), power)
        for place, power in zip(self.plain, key[1], strict=False):
            if power:
                x = self.values[place]
                _raise(factors, atoms.setdefault(x, len(atoms)), power)
        return value, factors


def _wave_of(phase: Any, kind: int) -> Any:
    """The cosine (0) or sine (1) of a phase; of a constant one as it is written, where its roots would be a sum."""
    import sympy

    function = sympy.sin if kind else sympy.cos
    wave = function(phase)
    return function(phase, evaluate=False) if wave.is_Add else wave


def _raise(factors: dict[int, int], atom: int, power: int) -> None:
    factors[atom] = factors.get(atom, 0) + power


def _trivial(part: Part) -> bool:
    return not any(part[0]) if isinstance(part[0], tuple) else part == (0, 0)


def _size(table: Table) -> int:
    """About the number of operations."""
    return sum(
        1 + (abs(value) != 1) + sum(not _trivial(part) for part in parts) + sum(others)
        for (parts, others), value in table.items()
    )


def _squared(table: Table, g: int) -> bool:
    """Whether an angle of its own occurs in more than the first power."""
    return any(not isinstance(parts[g][0], tuple) and sum(parts[g]) > 1 for parts, _ in table)


def _with_sines(table: Table, g: int) -> Table:
    """The table with 1 - s² for the squares of one cosine."""
    if not _squared(table, g):
        return table
    found: Table = {}
    for (parts, others), value in table.items():
        c, s = parts[g]
        for k in range(c // 2 + 1):
            part = (c % 2, s + 2 * k)
            key = ((*parts[:g], part, *parts[g + 1 :]), others)
            found[key] = found.get(key, Fraction(0)) + value * math.comb(c // 2, k) * (-1) ** k
    return {key: value for key, value in found.items() if value}


def _with_multiples(table: Table, g: int) -> Table:
    """The table with multiples of one angle for powers of its cosine: a constant one comes from a common part of several."""
    if not _squared(table, g):
        return table
    sums: Sums = {}
    for (parts, others), value in table.items():
        group = sums.setdefault(((*parts[:g], *parts[g + 1 :]), others), {})
        for f, (a, b) in _wave(parts[g]):
            real, imaginary = group.get(f, (Fraction(0), Fraction(0)))
            group[f] = real + value * a, imaginary + value * b
    return {((*key[0][:g], key[0][-1], *key[0][g:-1]), key[1]): value for key, value in _real(sums).items()}


def _partner(part: Part) -> Part | None:
    """The same wave a quarter of a turn on."""
    if isinstance(part[0], tuple):
        return None if _trivial(part) else (part[0], 1 - part[1])
    return part[::-1] if sum(part) == 1 else None


def _worth(table: Table, x: int, y: int) -> bool:
    """Whether cosines and sines of two groups come in the pairs that make one cosine of a sum."""
    both = pairs = 0
    for (parts, others), value in table.items():
        a, b = _partner(parts[x]), _partner(parts[y])
        if a is None or b is None:
            continue
        both += 1
        other = list(parts)
        other[x], other[y] = a, b
        pairs += abs(table.get((tuple(other), others), 0)) == abs(value)
    return 2 * pairs >= both > 0


def _merged(table: Table, x: int, y: int) -> Table:
    """The table with two groups as one, last, in waves."""
    sums: Sums = {}
    for (parts, others), value in table.items():
        rest = tuple(part for k, part in enumerate(parts) if k not in (x, y))
        group = sums.setdefault((rest, others), {})
        for f, (a, b) in _wave(parts[x]):
            for g, (c, d) in _wave(parts[y]):
                real, imaginary = group.get(f + g, (Fraction(0), Fraction(0)))
                group[f + g] = real + value * (a * c - b * d), imaginary + value * (a * d + b * c)
    return _real(sums)


def _real(sums: Sums) -> Table:
    """From coefficients of e^(i f·x) to those of cosines and sines, as a last part of the key."""
    found: Table = {}
    for (rest, others), group in sums.items():
        for f, (real, imaginary) in group.items():
            lead = next((k for k in f if k), 0)
            if lead < 0:
                continue
            for kind, size in ((0, 2 * real if lead else real), (1, -2 * imaginary if lead else Fraction(0))):
                if size:
                    found[(*rest, (f, kind)), others] = size
    return found


@lru_cache(maxsize=4096)
def _wave(part: Part) -> tuple[tuple[tuple[int, ...], tuple[Fraction, Fraction]], ...]:
    """A part as Σ (a + b i) e^(i f·x)."""
    half, none = Fraction(1, 2), Fraction(0)
    if isinstance(part[0], tuple):
        f, kind = part
        if not any(f):
            return ((f, (Fraction(1), none)),)
        pair = ((none, -half), (none, half)) if kind else ((half, none), (half, none))
        return ((f, pair[0]), (tuple(-k for k in f), pair[1]))
    waves = {0: (Fraction(1), none)}
    cosine, sine = ((1, (half, none)), (-1, (half, none))), ((1, (none, -half)), (-1, (none, half)))
    for factor in [cosine] * part[0] + [sine] * part[1]:
        product: dict[int, tuple[Fraction, Fraction]] = {}
        for k, (a, b) in waves.items():
            for f, (c, d) in factor:
                real, imaginary = product.get(k + f, (none, none))
                product[k + f] = real + a * c - b * d, imaginary + a * d + b * c
        waves = product
    return tuple(((k,), pair) for k, pair in waves.items())


def _nested(terms: list[Term], atoms: list[Any]) -> Any:
    """A sum of products with common factors taken out, those first that save most."""
    import sympy

    if not terms:
        return sympy.Integer(0)
    common, content = _common(terms), _content([value for value, _ in terms])
    rest = [(value / content, _without(factors, common)) for value, factors in terms]
    shared = [sympy.Rational(content.numerator, content.denominator), *(atoms[x] ** e for x, e in common.items())]
    if len(rest) == 1:
        return sympy.Mul(*shared)
    if (square := _square(rest, atoms)) is not None:
        return sympy.Mul(*shared, square)
    parts = []
    while (best := _best(rest)) is not None:
        parts.append(_nested([term for term in rest if best in term[1]], atoms))
        rest = [term for term in rest if best not in term[1]]
    parts += [_nested([term], atoms) for term in rest]
    return sympy.Mul(*shared, sympy.Add(*parts))


def _square(terms: list[Term], atoms: list[Any]) -> Any:
    """sin² for 1 - cos² and cos² for 1 - sin²; None for other sums."""
    import sympy

    if len(terms) != 2 or terms[0][0] != -terms[1][0]:
        return None
    (value, one), (_, other) = sorted(terms, key=lambda term: len(term[1]))
    if one or len(other) != 1 or [*other.values()] != [2]:
        return None
    wave = atoms[next(iter(other))]
    partner = {sympy.cos: sympy.sin, sympy.sin: sympy.cos}.get(type(wave))
    return (
        None
        if partner is None
        else sympy.Mul(sympy.Rational(value.numerator, value.denominator), partner(wave.args[0]) ** 2)
    )


def _best(terms: list[Term]) -> int | None:
    """The factor that saves most when it is taken out of all terms that hold it, with all that these have in common."""
    counts: dict[int, int] = {}
    for _, factors in terms:
        for x in factors:
            counts[x] = counts.get(x, 0) + 1
    often = sorted((x for x, count in counts.items() if count > 1), key=lambda x: (-counts[x], x))[:_LOOKED_AT]
    if not often:
        return None
    return max(often, key=lambda x: (counts[x] - 1) * sum(_common([t for t in terms if x in t[1]]).values()))


def _common(terms: list[Term]) -> dict[int, int]:
    common = dict(terms[0][1])
    for _, factors in terms:
        for x in [x for x, e in common.items() if factors.get(x, 0) < e]:
            if x in factors:
                common[x] = factors[x]
            else:
                del common[x]
        if not common:
            break
    return common


def _without(factors: dict[int, int], common: dict[int, int]) -> dict[int, int]:
    return {x: e - common.get(x, 0) for x, e in factors.items() if e > common.get(x, 0)}


def _content(values: list[Fraction]) -> Fraction:
    """What numbers have in common, with the sign that most of them have."""
    sign = -1 if sum(value < 0 for value in values) * 2 > len(values) else 1
    top = math.gcd(*(value.numerator for value in values))
    return Fraction(sign * top, math.lcm(*(value.denominator for value in values)))


# The quantities


@dataclass(frozen=True, eq=False)
class Question:
    """What a closed form answers, so that it can be derived step by step and compared with numbers.

    Attributes:
        model: exact; mechanism: its polynomials; link: name of the link; point: (3) of it.
        frame: axes and origin of the rows, None where they do not matter or are those of a middle joint.
        automatic: whether the frame is left to the answer.
        offset: (3) of the frame's origin, exact; rows: the rows in play.
        qd, qdd, wrench, gravity: as given, exact.
    """

    quantity: str
    model: RobotModel
    mechanism: Mechanism
    link: str
    point: tuple[Any, ...]
    frame: Frame | None
    automatic: bool
    offset: tuple[Any, ...]
    rows: tuple[int, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]
    wrench: tuple[Any, ...]
    gravity: tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A quantity of a robot as an expression in its joints, lengths, rates.

    Attributes:
        quantity: "pose", "jacobian", ...; robot, link: names.
        expression: SymPy; a matrix, or for a determinant one expression.
        frame: axes and origin of the rows; None where they do not matter.
        where: the same in words.
        symbols: "joints" (n), and where they occur "rates", "accelerations", "wrench", "parameters" (lengths, masses).
        values: numbers that symbols stand for, where lengths="symbols" put them in.
        row_names, column_names: of the matrix; () where it has none.
        factors: of a determinant, with multiplicities; the first is what does not depend on the joints.
        operations: of the expression, nothing shared; `generate_code` shares what occurs twice.
        question: what was asked.
    """

    quantity: str
    robot: str
    link: str
    expression: Any
    frame: Frame | None
    where: str
    symbols: Mapping[str, tuple[Any, ...]]
    values: Mapping[Any, Any]
    row_names: tuple[str, ...]
    column_names: tuple[str, ...]
    factors: tuple[tuple[Any, int], ...]
    operations: int
    question: Question = field(repr=False)

    @property
    def entries(self) -> list[tuple[str, Any]]:
        """(label, expression) of every entry that is not zero; the label is empty for a single expression."""
        if not hasattr(self.expression, "shape"):
            return [("", self.expression)]
        rows, columns = self.row_names or ("",) * self.expression.rows, self.column_names or ("",) * self.expression.cols
        return [
            (", ".join(filter(None, (row, column))), self.expression[i, j])
            for i, row in enumerate(rows)
            for j, column in enumerate(columns)
            if self.expression[i, j] != 0
        ]

    def __str__(self) -> str:
        """Every entry that is not zero on a line of its own; numbers to 6 digits."""
        words = self.quantity.replace("_", " ")
        where = f", {self.where}" if self.where else ""
        lines = [wrapped("", f"{words} of {self.link} of {self.robot}{where} ({self.operations} operations)", hang=2)]
        entries = self.entries
        for label, expression in entries:
            lines.append(wrapped(f"  {label + ' = ' if label else ''}", rounded_text(expression), hang=2))
        if not entries:
            lines.append("  0")
        elif hasattr(self.expression, "shape") and len(entries) < len(self.expression):
            lines.append("  all other entries are 0")
        if self.values:
            lines.append(wrapped("with ", ", ".join(f"{x} = {float(v):.6g}" for x, v in self.values.items())))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; expressions as text that SymPy reads."""
        matrix = hasattr(self.expression, "shape")
        found = [[str(x) for x in row] for row in self.expression.tolist()] if matrix else str(self.expression)
        return {
            "quantity": self.quantity,
            "robot": self.robot,
            "link": self.link,
            "expression": found,
            "rows": list(self.row_names),
            "columns": list(self.column_names),
            "frame": None if self.frame is None else self.frame.to_dict(),
            "where": self.where,
            "symbols": {kind: [str(x) for x in several] for kind, several in self.symbols.items()},
            "values": {str(x): float(v) for x, v in self.values.items()},
            "factors": [{"expression": str(x), "multiplicity": times} for x, times in self.factors],
            "operations": self.operations,
        }


def rounded_text(expression: Any) -> str:
    """An expression as text, fractions as decimals of 6 digits where their denominators are long."""
    import sympy

    if not hasattr(expression, "atoms"):
        return str(expression)
    constant = {x: sympy.Symbol(str(x)) for x in expression.atoms(sympy.cos, sympy.sin) if not x.free_symbols}
    plain = expression.xreplace(constant)
    long = {x: sympy.Float(f"{float(x):.6g}") for x in plain.atoms(sympy.Rational) if x.q > 12 or abs(x.p) > 1e6}
    return str(sympy.sstr(plain.xreplace(long), full_prec=False))


_OPTIONS = {
    "pose": {"point"},
    "jacobian": {"point", "frame", "task"},
    "velocity": {"point", "frame", "task", "qd"},
    "acceleration": {"point", "frame", "task", "qd", "qdd"},
    "gravity_torques": {"gravity"},
    "joint_torques": {"point", "frame", "wrench"},
    "determinant": {"point", "frame", "task"},
    "minors": {"point", "frame", "task"},
}
QUANTITIES = tuple(_OPTIONS)


def closed_form(
    quantity: str,
    model: RobotModel,
    *,
    at: str = TIP,
    point: Sequence[Any] | None = None,
    frame: Frame | str = "auto",
    task: str | Sequence[str] | Sequence[int] | None = None,
    qd: Sequence[Any] | None = None,
    qdd: Sequence[Any] | None = None,
    wrench: Wrench | Sequence[Any] | None = None,
    gravity: Sequence[Any] | None = None,
    lengths: str = "numbers",
) -> ClosedForm:
    """A quantity of a robot as a short exact expression in its joints, and in whatever symbols its description holds.

    Args:
        quantity: "pose" (4, 4) of a link; "jacobian" (6, n) of a link; "velocity" (6) J q̇; "acceleration" (6) J q̈ + J̇ q̇;
            "gravity_torques" (n) that hold the arm's weight; "joint_torques" (n) Jᵀ w; "determinant" of the rows of a task;
            "minors", all the largest ones of a task whose Jacobian is not square.
        model: a robot of numbers (taken by `ks.exact`) or of symbols.
        at: link, default the tip.
        point: (3) of that link, in its axes [m]; numbers or symbols.
        frame: axes and origin of the rows, as in `ks.jacobian`. "auto": a Jacobian in the frame that makes it shortest, of
            base, link and the links between; a determinant that is the same in every frame in that of a middle joint; all
            else in the geometric frame, Frame("base", at).
        task: rows, as in `ks.find_task`; default all six, for determinants and minors "auto".
        qd, qdd: (n) rates and accelerations, numbers or polynomials of symbols; default symbols qd1, qdd1, ...
        wrench: (6) at the frame's origin in its axes, on the environment, numbers or symbols, default fx ... mz; or a
            Wrench, whose side decides the sign and whose frame must be that of the rows.
        gravity: (3) in base axes, numbers or symbols [m/s²]; default (0, 0, -9.81).
        lengths: "numbers" as they are, or "symbols" a2, d4, ... in their place, with `values` that say what they are.

    Returns:
        ClosedForm.

    Raises:
        UnknownNameError: KS393, no such quantity; KS310, no such link; KS318, no such row.
        ConfigurationError: KS391, screw joints and broken ratios; KS393, an option that the quantity does not take; KS394, a
            determinant of a Jacobian that is not square; KS303, wrong shapes.
        ArrayTypeError: KS390, lengths or angles that are no polynomials.
        MissingMassError: KS320. FrameMismatchError: KS330. MissingExtraError: KS400.

    Law: the expression at numbers is what `ks.pose`, `ks.jacobian`, `ks.acceleration`, `ks.gravity_torques`,
    `ks.joint_torques` give. Source: note 004 for a = jacobian(v, q̇) q̈ + jacobian(v, q) q̇; note 000 for gravity and Jᵀ w.

    Example:
        >>> import kinestatics as ks
        >>> print(closed_form("determinant", ks.load("planar_2r"), lengths="symbols"))
        determinant of tip of planar_2r, rows vx, vy, axes of base, at the origin of tip
          (3 operations)
          a1**2*sin(q2)
        with a1 = 1
    """
    require_model(model)
    sympy_module()
    given = {"point": point, "task": task, "qd": qd, "qdd": qdd, "wrench": wrench, "gravity": gravity}
    given["frame"] = None if isinstance(frame, str) and frame == "auto" else frame
    _check_options(quantity, given, lengths)
    if quantity == "gravity_torques":
        _require_masses(model)
    question = _asked(quantity, exact(model), model, at, given)
    if lengths == "symbols":
        question = replace(question, mechanism=question.mechanism.named())
    return _ANSWERS[quantity](question)


def _check_options(quantity: Any, given: Mapping[str, Any], lengths: Any) -> None:
    if not isinstance(quantity, str) or quantity not in _OPTIONS:
        hint = nearest(str(quantity), QUANTITIES) or f"known: {', '.join(QUANTITIES)}"
        raise UnknownNameError("KS393", f"there is no closed form of {quantity!r}", hint)
    for name, value in given.items():
        if value is not None and name not in _OPTIONS[quantity]:
            takes = ", ".join(sorted(_OPTIONS[quantity]))
            raise ConfigurationError("KS393", f"{quantity!r} takes no {name}=", f"it takes {takes}")
    if lengths not in ("numbers", "symbols"):
        raise ConfigurationError("KS393", f"lengths is {lengths!r}", "say lengths='numbers' or lengths='symbols'")


def _require_masses(model: RobotModel) -> None:
    if not model.has_masses:
        hint = "its description gives none; a result of zero would be wrong, not light"
        raise MissingMassError("KS320", f"robot {model.name!r} has no masses", hint)


def _asked(quantity: str, model: RobotModel, numbers: RobotModel, at: str, given: Mapping[str, Any]) -> Question:
    """The question, its arguments exact and its mechanism built."""
    import sympy

    link = model.link(at)
    name = model.link_name(link)
    point = exact_values("point", given["point"], 3) or (sympy.Integer(0),) * 3
    frame, offset = _frame_of(model, name, point, given)
    rows = _rows_of(quantity, numbers, name, frame, given["task"])
    taken = {str(x) for x in free_symbols(model)} | {str(x) for x in joint_symbols(model)}
    taken |= {str(x) for value in (*point, *offset) for x in value.free_symbols}
    letter = str(joint_symbols(model)[0]).rstrip("0123456789") if model.n else "q"
    n = model.n
    qd = exact_values("qd", given["qd"], n) or fresh([f"{letter}d{k + 1}" for k in range(n)], taken)
    qdd = exact_values("qdd", given["qdd"], n) or fresh([f"{letter}dd{k + 1}" for k in range(n)], taken)
    wrench = _wrench_of(model, frame, name, given["wrench"]) or fresh(WRENCH_NAMES, taken)
    gravity = exact_values("gravity", given["gravity"], 3) or tuple(map(fraction, STANDARD_GRAVITY))
    links = [link, *_links_of(quantity, model, link, frame, given["frame"] is None)]
    used = {"velocity": qd, "acceleration": (*qd, *qdd), "joint_torques": wrench}.get(quantity, ())
    entries, symbols = [*point, *offset], [x for x in used if x.is_Symbol]
    entries += [x for x in used if not x.is_Symbol]
    if quantity == "gravity_torques":
        entries += [*gravity, *(x for i in links for x in (exact_value(model.masses[i]), *center_of(model, i)))]
    mechanism = Mechanism.of(model, links, entries, symbols)
    automatic = given["frame"] is None
    return Question(quantity, model, mechanism, name, point, frame, automatic, offset, rows, qd, qdd, wrench, gravity)


def _frame_of(
    model: RobotModel, name: str, point: tuple[Any, ...], given: Mapping[str, Any]
) -> tuple[Frame, tuple[Any, ...]]:
    """The frame asked for, or the geometric one, and the exact offset of its origin; that of the frame is in numbers."""
    frame = given["frame"]
    if frame is None:
        frame, offset = Frame(BASE, name), point
    else:
        if not isinstance(frame, Frame):
            hint = "frame='auto', or ks.Frame.body(), ks.Frame.spatial(), ks.Frame(axes, origin)"
            raise ArrayTypeError("KS302", f"frame is {frame!r}; expected a Frame", hint)
        own = model.link(frame.origin) == model.link(name) and given["point"] is not None
        offset = point if own else tuple(exact_value(x) for x in frame.offset)
    plain = all(x.is_number for x in offset)
    x, y, z = map(float, offset) if plain else (0.0, 0.0, 0.0)
    named = named_frame(model, frame._replace(offset=(x, y, z)))
    return named, offset


def _rows_of(quantity: str, model: RobotModel, name: str, frame: Frame, task: Any) -> tuple[int, ...]:
    if quantity not in ("determinant", "minors") and task is None:
        return tuple(range(len(ROW_NAMES)))
    return find_task(in_numbers(model), "auto" if task is None else task, name, frame).rows


def _wrench_of(model: RobotModel, frame: Frame, name: str, wrench: Any) -> tuple[Any, ...]:
    if not isinstance(wrench, Wrench):
        return exact_values("wrench", wrench, len(WRENCH_NAMES))
    written = wrench.frame if wrench.frame != Frame() else Frame(BASE, name, frame.offset)
    if named_frame(model, written) != frame:
        hint = "closed_form(..., frame=wrench.frame), or the six numbers as they are in this frame"
        raise FrameMismatchError(
            "KS330", f"the rows ({frame}) and the wrench ({wrench.frame}) are written in different frames", hint
        )
    six = exact_values("wrench", wrench.array, len(WRENCH_NAMES))
    return six if wrench.acts_on == "environment" else tuple(-x for x in six)


def _links_of(quantity: str, model: RobotModel, link: int, frame: Frame, automatic: bool) -> list[int]:
    """The other links whose frames or masses are needed."""
    if quantity == "gravity_torques":
        moved = [i for i, joint in enumerate(model.link_joints) if joint >= 0]
        return [i for i in moved if exact_value(model.masses[i]) != 0]
    found = [model.link(frame.axes), model.link(frame.origin)]
    if quantity == "jacobian" and automatic:
        found += between(model, link)
    return found


def between(model: RobotModel, link: int) -> list[int]:
    """One link for each joint that carries a link, base first; the last is the link itself."""
    path = model.path(model.link_joints[link])
    found = [model.link_joints.index(i) if i in model.link_joints else -1 for i in path]
    return [i for i in found[:-1] if i >= 0] + [link] * bool(path)


def exact_value(x: Any) -> Any:
    """A number as a fraction; an expression as it is."""
    import sympy

    if isinstance(x, sympy.Basic):
        return x
    return fraction(x)


def exact_values(what: str, values: Any, size: int) -> tuple[Any, ...]:
    """(size) exact values; () where none are given.

    Raises:
        ConfigurationError: KS303.
    """
    if values is None:
        return ()
    try:
        array, xp = as_array(values, what)
    except (ArrayTypeError, ValueError):
        array, xp = np.zeros(0), None
    if xp is None or tuple(array.shape) != (size,) or (xp.name != "sympy" and not np.all(np.isfinite(np.asarray(array)))):
        raise ConfigurationError(
            "KS303", f"{what} {values!r} is not {size} finite numbers or symbols", "a list, one after another"
        )
    return tuple(exact_value(x) for x in array)


def fresh(names: Sequence[str], taken: set[str]) -> tuple[Any, ...]:
    """Real symbols of these names, with underscores behind those that are taken."""
    import sympy

    tail = ""
    while taken & {name + tail for name in names}:
        tail += "_"
    taken |= {name + tail for name in names}
    return tuple(sympy.Symbol(name + tail, real=True) for name in names)


def center_of(model: RobotModel, link: int) -> tuple[Any, ...]:
    """(3) exact centre of mass of a link, in its axes."""
    return tuple(exact_value(x) for x in model.centers_of_mass[link])


def in_numbers(model: RobotModel, values: Mapping[Any, float] | None = None) -> RobotModel:
    """The model with numbers for its symbols; without values, pseudo-random ones."""
    symbols = sorted(free_symbols(model), key=str)
    if values is None:
        drawn = np.random.default_rng(_SEED).uniform(0.3, 1.7, len(symbols))
        values = dict(zip(symbols, drawn.tolist(), strict=True))

    def number(x: Any) -> float:
        return float(x.xreplace(values)) if getattr(x, "free_symbols", None) else float(x)

    def numbers(array: Array) -> Array:
        if array.dtype != object:
            return array
        return np.array([number(x) for x in array.flat], dtype=np.float64).reshape(array.shape)

    return replace(model.map(numbers))


# Answers


def _answer(
    question: Question, expression: Any, where: str, rows: Sequence[str], columns: Sequence[str], **more: Any
) -> ClosedForm:
    import sympy

    mechanism, model = question.mechanism, question.model
    found = expression.free_symbols
    symbols = {"joints": tuple(mechanism.ring.joints)}
    used = [("rates", question.qd), ("accelerations", question.qdd), ("wrench", question.wrench)]
    for kind, several in used:
        if found & set(several) and len({x for x in several if x.is_Symbol}) == len(several):
            symbols[kind] = tuple(several)
    known = {x for several in symbols.values() for x in several}
    if rest := tuple(sorted(found - known, key=str)):
        symbols["parameters"] = rest
    options = {"frame": question.frame, "factors": ()} | more
    values = {x: v for x, v in mechanism.values.items() if x in found}
    return ClosedForm(
        question.quantity,
        model.name,
        question.link,
        expression,
        options["frame"],
        where,
        symbols,
        values,
        tuple(rows),
        tuple(columns),
        options["factors"],
        int(sympy.count_ops(expression)),
        question,
    )


def frame_in_words(frame: Frame, offset: Sequence[Any]) -> str:
    """Axes and origin, the offset exact."""
    text = str(frame._replace(offset=(0.0, 0.0, 0.0)))
    return f"{text} + ({', '.join(map(str, offset))})" if any(x != 0 for x in offset) else text


def _pose(question: Question) -> ClosedForm:
    import sympy

    mechanism = question.mechanism
    writer = Writer(mechanism.ring)
    R, p = mechanism.pose(question.model.link(question.link), question.point)
    rows = [[*map(writer, row), writer(x)] for row, x in zip(R, p, strict=True)]
    T = sympy.ImmutableDenseMatrix([*rows, [0, 0, 0, 1]])
    at = f" at ({', '.join(map(str, question.point))})" if any(x != 0 for x in question.point) else ""
    return _answer(
        question, T, f"seen from {question.model.base}{at}", "xyz1", ("x axis", "y axis", "z axis", "origin"), frame=None
    )


def jacobian_rows(question: Question) -> list[list[Polynomial]]:
    """(rows, n) the Jacobian in the frame of the question, as polynomials."""
    assert question.frame is not None
    model = question.model
    J = question.mechanism.jacobian_in(model.link(question.link), question.frame, question.offset)
    return [J[r] for r in question.rows]


def _row_names(question: Question, names: Sequence[str] = ROW_NAMES) -> list[str]:
    return [names[r] for r in question.rows]


def _jacobian(question: Question) -> ClosedForm:
    mechanism = question.mechanism
    assert question.frame is not None
    writer = Writer(mechanism.ring)
    columns = [str(x) for x in mechanism.ring.joints]
    best = None
    for frame, offset in _candidates(question):
        asked = replace(question, frame=frame, offset=offset)
        J = jacobian_rows(asked)
        size = sum(sum(1 + sum(map(bool, e)) for e in p.to_dict()) for row in J for p in row)
        if best is None or size < best[0]:
            best = size, asked, J
    assert best is not None
    _, asked, J = best
    assert asked.frame is not None
    return _answer(asked, writer.matrix(J), frame_in_words(asked.frame, asked.offset), _row_names(asked), columns)


def _candidates(question: Question) -> list[tuple[Frame, tuple[Any, ...]]]:
    """The frames among which the shortest is sought, the geometric one first; one alone where it was asked for."""
    import sympy

    assert question.frame is not None
    found, model = [(question.frame, question.offset)], question.model
    path = between(model, model.link(question.link))
    if not question.automatic or not path or question.rows not in WHOLE_TASKS:
        return found
    name, zero = question.link, (sympy.Integer(0),) * 3
    found.append((question.frame._replace(axes=name), question.offset))
    if question.rows != LINEAR_ROWS:
        for i in path[:-1]:
            found.append((Frame.body(model.link_name(i)), zero))
    else:
        found += [(question.frame._replace(axes=model.link_name(i)), question.offset) for i in path[:-1]]
    return found


def _combination(ring: TrigonometricRing, M: Matrix, values: Sequence[Polynomial]) -> list[Polynomial]:
    return [ring.total(a * b for a, b in zip(row, values, strict=True)) for row in M]


def velocity_rows(question: Question) -> list[Polynomial]:
    """J q̇."""
    ring = question.mechanism.ring
    return _combination(ring, jacobian_rows(question), [ring.read(x) for x in question.qd])


def _velocity(question: Question) -> ClosedForm:
    return _column(question, velocity_rows(question), _row_names(question))


def _column(question: Question, entries: Sequence[Polynomial], rows: Sequence[str]) -> ClosedForm:
    assert question.frame is not None
    writer = Writer(question.mechanism.ring)
    where = frame_in_words(question.frame, question.offset)
    return _answer(question, writer.matrix([[p] for p in entries]), where, rows, ())


def acceleration_rows(question: Question) -> list[Polynomial]:
    """jacobian(v, q̇) q̈ + jacobian(v, q) q̇ with v = J q̇."""
    mechanism, ring = question.mechanism, question.mechanism.ring
    J, rates = jacobian_rows(question), [ring.read(x) for x in question.qd]
    first = _combination(ring, J, [ring.read(x) for x in question.qdd])
    found = []
    for row, part in zip(J, first, strict=True):
        v = ring.total(a * b for a, b in zip(row, rates, strict=True))
        moving = (mechanism.slope(v, j) * rate for j, rate in enumerate(rates))
        found.append(ring.total([part, *moving]))
    return found


def _acceleration(question: Question) -> ClosedForm:
    return _column(question, acceleration_rows(question), [f"d{name}" for name in _row_names(question)])


def potential_energy(question: Question) -> Polynomial:
    """-Σ m gᵀ p of the centres of mass of the links that move."""
    mechanism, model = question.mechanism, question.model
    ring = mechanism.ring
    down = [ring.read(x) for x in question.gravity]
    moments: dict[int, Vector] = {}
    masses: dict[int, Polynomial] = {}
    for link, (joint, T) in mechanism.links.items():
        mass = exact_value(model.masses[link])
        if joint < 0 or mass == 0:
            continue
        m = ring.read(expanded(_objects([mass]))[0])
        center = [ring.read(x) for x in expanded(_objects(center_of(model, link)))]
        place = compose(ring, T, Pose(T.R, center)).p
        before = moments.get(joint, [ring.zero] * 3)
        moments[joint] = [ring.reduced(a + m * b) for a, b in zip(before, place, strict=True)]
        masses[joint] = masses.get(joint, ring.zero) + m
    seen, parts = mechanism.seen_from(-1), []
    for joint, moment in moments.items():
        R, p = seen[joint]
        for g, a, b in zip(down, turned(ring, R, moment), p, strict=True):
            parts.append(-g * (a + masses[joint] * b))
    return ring.total(parts)


def _gravity(question: Question) -> ClosedForm:
    mechanism = question.mechanism
    energy, writer = potential_energy(question), Writer(mechanism.ring)
    torques = [[mechanism.slope(energy, j)] for j in range(question.model.n)]
    names = [f"tau{j + 1}" for j in range(question.model.n)]
    where = f"gravity ({', '.join(map(rounded_text, question.gravity))}) m/s² in axes of {question.model.base}"
    return _answer(question, writer.matrix(torques), where, names, (), frame=None)


def torque_rows(question: Question) -> list[Polynomial]:
    """Jᵀ w."""
    ring = question.mechanism.ring
    columns = list(zip(*jacobian_rows(question), strict=True))
    return _combination(ring, columns, [ring.read(x) for x in question.wrench])


def _torques(question: Question) -> ClosedForm:
    return _column(question, torque_rows(question), [f"tau{j + 1}" for j in range(question.model.n)])


def task_matrix(question: Question) -> tuple[Matrix, str]:
    """The rows in play, in the frame of a middle joint where their determinants are the same in all; and where, in words."""
    model, mechanism = question.model, question.mechanism
    assert question.frame is not None
    link = model.link(question.link)
    if not same_everywhere(question):
        return jacobian_rows(
            question
        ), f"rows {', '.join(_row_names(question))}, {frame_in_words(question.frame, question.offset)}"
    body = mechanism.middle(link)
    origin = None
    if question.rows == LINEAR_ROWS:
        origin = mechanism.point(model.link(question.frame.origin), question.offset, body)
    J = mechanism.jacobian(link, body, origin)
    name = model.moving_names[body] if body >= 0 else model.base
    at = "" if origin is None else f" at {frame_in_words(question.frame, question.offset).partition(', at ')[2]}"
    alike = "the same in every frame" if origin is None else "the same in all axes"
    of_joint = f"{'that' if origin is None else 'those'} of joint {name}" if body >= 0 else name
    return [J[r] for r in question.rows], f"rows {', '.join(_row_names(question))}{at}, {alike}, found in {of_joint}"


def _determinant(question: Question) -> ClosedForm:
    import sympy

    rows, n = len(question.rows), question.model.n
    if rows != n:
        message = f"the Jacobian of {question.link} has {rows} rows ({', '.join(_row_names(question))}) and {n} columns"
        raise ConfigurationError(
            "KS394", f"{message}: it has no determinant", "closed_form('minors', ...), or task= with as many rows"
        )
    M, where = task_matrix(question)
    factors = factored(question.mechanism.ring, determinant(question.mechanism.ring, M))
    expression = sympy.Mul(*(x**times for x, times in factors))
    return _answer(question, expression, where, (), (), frame=_frame_if_it_matters(question), factors=tuple(factors))


def same_everywhere(question: Question) -> bool:
    """Whether determinants of the rows are the same in all axes; of fewer columns than rows they are not."""
    return question.rows in WHOLE_TASKS and question.model.n >= len(question.rows)


def _frame_if_it_matters(question: Question) -> Frame | None:
    return None if same_everywhere(question) else question.frame


def _minors(question: Question) -> ClosedForm:
    import sympy

    ring = question.mechanism.ring
    M, where = task_matrix(question)
    rows, n = len(M), question.model.n
    size = min(rows, n)
    names, found = [], []
    for kept in itertools.combinations(range(max(rows, n)), size):
        part = [[row[j] for j in kept] for row in M] if n >= rows else [M[r] for r in kept]
        left = [k for k in range(max(rows, n)) if k not in kept]
        labels = [str(x) for x in ring.joints] if n >= rows else _row_names(question)
        names.append(f"without {', '.join(labels[k] for k in left)}" if left else "all")
        found.append(sympy.Mul(*(x**times for x, times in factored(ring, determinant(ring, part)))))
    return _answer(question, sympy.ImmutableDenseMatrix([found]).T, where, names, (), frame=_frame_if_it_matters(question))


def factored(ring: TrigonometricRing, p: Polynomial) -> list[tuple[Any, int]]:
    """Factors of a polynomial as expressions, complete over the rationals; the first does not depend on the joints."""
    import sympy

    writer = Writer(ring)
    if p == 0:
        return [(sympy.Integer(0), 1)]
    if len(p.to_dict()) > _FACTORED:
        return [(sympy.Integer(1), 1), (writer(p), 1)]
    half = HalfAngleRing(ring)
    constant, parts = half.factored(half.lifted(p))
    whole, odd = dict[str, tuple[Polynomial, int]](), list[Polynomial]()
    for F, times in parts:
        if any(d % 2 for d in half.degrees(F)):
            odd += [F] * times
        else:
            _count(whole, half.full_angles(F), times)
    if any(d % 2 for d in half.degrees(constant)):
        odd, constant = [*odd, constant], half.context.constant(1)
    for F in _paired(half, odd):
        _count(whole, half.full_angles(F), 1)
    scale, found = half.full_angles(constant), []
    for F, times in whole.values():
        size = ring.number(_scale(ring, F))
        expression = writer(F / size.leading_coefficient())
        if _mostly_negative(expression):
            expression, size = -expression, -size
        scale = scale * size**times
        found.append((expression, times))
    found.sort(key=lambda pair: (len(pair[0].free_symbols), str(pair[0])))
    return [(writer(scale), 1), *found]


def _scale(ring: TrigonometricRing, F: Polynomial) -> Fraction:
    """What to divide a factor by, so that its numbers are small and whole, or lengths in metres."""
    values = [Fraction(int(c.p), int(c.q)) for c in F.to_dict().values()]
    size = abs(_content(values))
    largest = max(abs(value) for value in values) / size
    first = ring.parameter_place(0)
    given = any(e[k] for e in F.to_dict() for k in range(first, first + len(ring.parameters)))
    return size if given or largest < _LONG else size * 10 ** len(str(int(largest)))


def _mostly_negative(expression: Any) -> bool:
    terms = expression.args if expression.is_Add else (expression,)
    return sum(bool(term.as_coeff_Mul()[0].is_negative) for term in terms) * 2 > len(terms)


def _count(found: dict[str, tuple[Polynomial, int]], F: Polynomial, times: int) -> None:
    key = str(F)
    found[key] = F, times + (found[key][1] if key in found else 0)


def _length(half: HalfAngleRing, F: Polynomial, G: Polynomial) -> tuple[int, bool]:
    """How long a product is in whole angles; of two alike, one with another comes first."""
    whole = half.full_angles(F * G)
    return (0 if whole is None else len(whole.to_dict())), bool(F == G)


def _paired(half: HalfAngleRing, odd: list[Polynomial]) -> list[Polynomial]:
    """Products of factors that are odd in some angle, even in all: two of one kind where there are, the rest together."""
    rest, found, left = list(odd), [], None
    while rest:
        F = rest.pop(0)
        kind = [d % 2 for d in half.degrees(F)]
        partners = [k for k, G in enumerate(rest) if [d % 2 for d in half.degrees(G)] == kind]
        if partners:
            best = min(partners, key=lambda k: _length(half, F, rest[k]))
            found.append(F * rest.pop(best))
        else:
            left = F if left is None else left * F
    return found if left is None else [*found, left]


_ANSWERS = {
    "pose": _pose,
    "jacobian": _jacobian,
    "velocity": _velocity,
    "acceleration": _acceleration,
    "gravity_torques": _gravity,
    "joint_torques": _torques,
    "determinant": _determinant,
    "minors": _minors,
}


__all__ = ["QUANTITIES", "ClosedForm", "closed_form"]
