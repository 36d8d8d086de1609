"""Equations of the singular set: a factor, or two that belong together, as an expression and as a function of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..model import RobotModel
from ..namespaces import Array
from ..quantities import format_number
from ..symbolic.functions import WaveFunction
from ..symbolic.halfangle import HalfAngleRing, Waves
from ..symbolic.printing import shortest
from ..symbolic.ring import Polynomial
from ..symbolic.writer import rounded_text
from .enclosure import proved_free_on_circle

_TRIES, _REAL, _STEPS = 200, 1e-12, 40
_ROUNDING = 1e-9
DIGITS = 60  # of numbers in an expression, beyond which decimals stand for them
_TERMS = 1000  # of an equation nobody reads
_READABLE = 600  # characters of an equation
_DOUBLE = 1e-14  # of a discriminant: two roots that floats do not tell apart


@dataclass(frozen=True, eq=False)
class Space:
    """What equations are written in: ring, robot, and numbers for the lengths.

    Attributes:
        half: the ring; model: with numbers.
        values: numbers for the symbols.
        given: whether these are the robot's own; where its lengths are symbols without numbers, they are samples.
        lengths: exact numbers of symbols that were named.
    """

    half: HalfAngleRing
    model: RobotModel
    values: Mapping[Any, float]
    given: bool
    lengths: Mapping[Any, Any]
    _waves: dict[str, Waves] = field(default_factory=dict, repr=False)

    @cached_property
    def exact(self) -> dict[Any, Any]:
        """Exact numbers of the symbols: those of the names, and the decimals that were given."""
        import sympy

        return {s: self.lengths.get(s, sympy.Rational(repr(float(value)))) for s, value in self.values.items()}

    def waves(self, F: Polynomial) -> Waves:
        """The exact waves of a factor, kept."""
        key = str(F)
        if key not in self._waves:
            self._waves[key] = self.half.waves(F)
        return self._waves[key]

    def random(self, count: int, seed: int) -> Array:
        """(count, n) configurations: angles anywhere, slides within twice their limits' middle or 1 m."""
        rng = np.random.default_rng(seed)
        q = rng.uniform(-np.pi, np.pi, (count, self.model.n))
        slides = [j for j, turns in enumerate(self.half.ring.turns) if not turns]
        if slides:
            lower, upper = self.model.lower[slides], self.model.upper[slides]
            bounded = np.isfinite(lower) & np.isfinite(upper) & (upper - lower < 1e3)
            lower, upper = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
            q[:, slides] = rng.uniform(lower, upper, (count, len(slides)))
        return q


@dataclass(frozen=True, eq=False)
class Equation:
    """f(q) = 0, where f is irreducible or a product of two factors that print better together: sin q = 2 sin q/2 cos q/2.

    Attributes:
        parts: irreducible polynomials in half angles; it holds where one of them vanishes.
        space: what they are written in.
    """

    parts: tuple[Polynomial, ...]
    space: Space

    @cached_property
    def polynomial(self) -> Polynomial:
        """The product, scaled so that the numbers of its expression have no common factor and are mostly positive."""
        return self._unscaled[0] / self.scale

    @property
    def scale(self) -> Any:
        """What the product of the parts was divided by, a rational number of python-flint."""
        from ..symbolic.ring import flint

        scale = _scale(self._unscaled[1])
        return flint().fmpq(int(scale.p), int(scale.q))

    @cached_property
    def _unscaled(self) -> tuple[Polynomial, Any]:
        product = self.parts[0]
        for part in self.parts[1:]:
            product = product * part
        if digits_of(product) <= DIGITS:
            return product, shortest(self.space.half, product)
        largest = max(map(abs, product.coeffs()))
        return product / largest, self._in_decimals(product / largest)

    def _in_decimals(self, F: Polynomial) -> Any:
        """A sum of waves whose exact numbers nobody could read, with those of floats."""
        import sympy

        f, joints = WaveFunction.of(self.space.half, F, {}), self.space.half.ring.joints
        terms = []
        for k, powers, cosine, sine in zip(f.frequencies, f.powers, f.cosines, f.sines, strict=True):
            phase = sympy.Add(*[sympy.Rational(round(2 * x), 2) * q for x, q in zip(k, joints, strict=True) if x])
            slides = sympy.Mul(*[q ** int(x) for x, q in zip(powers, joints, strict=True) if x])
            terms += [sympy.Float(cosine) * sympy.cos(phase) * slides] if cosine else []
            terms += [sympy.Float(sine) * sympy.sin(phase) * slides] if sine else []
        return sympy.Add(*terms)

    @cached_property
    def expression(self) -> Any:
        """SymPy, in the joints' symbols and the lengths; decimals where exact numbers would have dozens of digits."""
        expression = self._unscaled[1]
        return (expression / _scale(expression)).expand(mul=True, deep=False, power_base=False, power_exp=False)

    @cached_property
    def functions(self) -> tuple[WaveFunction, ...]:
        """The parts as functions of numbers."""
        return tuple(WaveFunction.of(self.space.half, part, self.space.values) for part in self.parts)

    @cached_property
    def columns(self) -> tuple[int, ...]:
        """The joints it depends on, from 0."""
        return tuple(sorted({j for part in self.parts for j in self.space.half.joints_of(part)}))

    @property
    def joints(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.space.model.joint_names[j] for j in self.columns)

    def value(self, q: Array) -> Array:
        """(...) the smallest of the parts, in shares of their amplitudes."""
        values = np.stack([f.value(q) / f.scale for f in self.functions])
        return np.take_along_axis(values, np.abs(values).argmin(0)[None], 0)[0]

    @cached_property
    def solutions(self) -> tuple[float, ...] | None:
        """Values of its joint where it depends on one, ascending, angles in (-π, π]; None where it depends on several."""
        if len(self.columns) != 1:
            return None
        j, found = self.columns[0], []
        for part in self.parts:
            if self.space.half.ring.turns[j]:
                found += _angles(part, self.space, j)
            else:
                found += _places(part, self.space, j)
        return tuple(sorted(x + 0.0 for x in found))

    @cached_property
    def real(self) -> bool | None:
        """Whether it has real zeros: True with a witness or root, False with a proof, None where that is not decided."""
        if self.solutions is not None:
            if not self.space.given and len(self.polynomial.to_dict()) > 1 and not _plain(self.expression):
                return None
            return True if self.solutions else False if self._proved_void() else None
        if not self.space.given:
            return None
        states = [_has_zeros(f, self.space) for f in self.functions]
        return True if True in states else None if None in states else False

    def _proved_void(self) -> bool:
        """Whether intervals prove that no value of its one joint solves it; floats do not tell a double root from none."""
        space, j = self.space, self.columns[0]
        if not space.half.ring.turns[j]:
            place = 2 * len(space.half.ring.angles) + list(space.half.ring.slides).index(j)
            return all(part.degrees()[place] == 2 for part in self.parts)  # its discriminant is not close to 0
        exact = space.exact
        return all(proved_free_on_circle(space.half, space.waves(F), exact, j, space.model.n) for F in self.parts)

    @property
    def long(self) -> bool:
        """Whether its expression is nothing to read."""
        return sum(map(len, self.parts)) > _TERMS or len(str(self.expression)) > _READABLE

    @property
    def shown(self) -> str:
        """The expression, or f(q2, q3, ...) for one that is long."""
        joints = ", ".join(str(self.space.half.ring.joints[j]) for j in self.columns)
        return f"f({joints})" if self.long else rounded_text(self.expression)

    def text(self) -> str:
        """As a person writes it: "sin(q5) = 0", with the joint's values in degrees where it depends on one."""
        if self.solutions is None:
            waves = f", a sum of {sum(len(f.cosines) for f in self.functions)} waves (.expression has it)"
            return f"{self.shown} = 0{waves if self.long else ''}"
        if not self.solutions:
            return f"{self.shown} = 0 (no solution was found)"
        turns = self.space.half.ring.turns[self.columns[0]]
        shown = ", ".join(f"{format_number(np.degrees(x))}°" if turns else f"{format_number(x)} m" for x in self.solutions)
        return f"{self.shown} = 0  ({self.space.half.ring.joints[self.columns[0]]} = {shown})"


def digits_of(F: Polynomial) -> int:
    """Digits of the longest number of a polynomial."""
    return max((len(str(x)) for x in F.coeffs()), default=0)


def equations(parts: Sequence[tuple[Polynomial, int]], space: Space) -> list[tuple[Equation, int]]:
    """Factors with multiplicities as equations: those that are odd in some joint joined to the partner that prints best."""
    half = space.half
    even = [(Equation((F,), space), m) for F, m in parts if not any(d % 2 for d in half.degrees(F))]
    odd = [(F, m) for F, m in parts if any(d % 2 for d in half.degrees(F))]
    while odd:
        F, times = odd.pop(0)
        signature = [d % 2 for d in half.degrees(F)]
        joints = half.joints_of(F)
        partners = [
            k
            for k, (G, m) in enumerate(odd)
            if m == times and half.joints_of(G) == joints and [d % 2 for d in half.degrees(G)] == signature
        ]
        if partners:
            k = min(partners, key=lambda k: sum(len(p) for _, p in half.in_whole_angles(F * odd[k][0])))
            even.append((Equation((F, odd.pop(k)[0]), space), times))
        else:
            even.append((Equation((F,), space), times))
    return even if len(even) == 1 else sorted(even, key=lambda x: (x[0].columns, str(x[0].parts)))


def together(F: Polynomial, G: Polynomial, half: HalfAngleRing) -> bool:
    """Whether two factors are the halves of one sine or cosine: of one joint, odd, and short together."""
    joints = half.joints_of(F)
    if joints != half.joints_of(G) or len(joints) != 1 or F == G:
        return False
    if not all(any(d % 2 for d in half.degrees(x)) for x in (F, G)):
        return False
    whole = half.full_angles(F * G)
    return whole is not None and len(whole.to_dict()) == 1


def _scale(expression: Any) -> Any:
    """The number that all terms have in common, with the sign that most of them have."""
    import sympy

    number, rest = expression.as_coeff_Mul()
    if not rest.is_Add:
        return number
    numbers = [term.as_coeff_Mul()[0] for term in rest.args]
    common = sympy.gcd_list(numbers) if all(x.is_Rational for x in numbers) else sympy.Integer(1)
    negative = sum(bool(x < 0) for x in numbers)
    return number * common * (-1 if 2 * negative > len(numbers) else 1)


def _plain(expression: Any) -> bool:
    """Whether an expression holds no lengths: where it vanishes does not hang on them."""
    return len(expression.free_symbols) == 1


def _numbers(part: Polynomial, space: Space, places: Sequence[int]) -> Array:
    """(degree + 1) coefficients of a polynomial of one joint by powers of its last generator, highest first."""
    ring = space.half.ring
    degree = max(sum(e[i] for i in places) for e in part.to_dict())
    found = np.zeros(degree + 1)
    first = 2 * len(ring.angles) + len(ring.slides)
    numbers = [float(space.values[x]) for x in ring.parameters] + [float(p) ** 0.5 for p in ring.roots]
    constants = [float(x.subs(space.values)) / 2.0 for x in ring.constants]
    for exponents, coefficient in part.to_dict().items():
        e = [int(x) for x in exponents]
        size = float(coefficient.p) / float(coefficient.q)
        for a, x in enumerate(constants, start=sum(ring.turns)):
            size *= np.sin(x) ** e[2 * a] * np.cos(x) ** e[2 * a + 1]
        for x, power in zip(numbers, e[first:], strict=False):
            size *= x**power
        found[degree - e[places[0]]] += size
    return found


def _angles(part: Polynomial, space: Space, joint: int) -> list[float]:
    """Angles where a homogeneous polynomial in t, u of one joint vanishes."""
    a = sum(space.half.ring.turns[:joint])
    coefficients = _numbers(part, space, (2 * a, 2 * a + 1))
    found, size = [], np.abs(coefficients).max()
    if abs(coefficients[0]) <= _REAL * size:
        found.append(np.pi)  # u = 0
    for root in _real_roots(coefficients):
        angle = 2.0 * np.arctan(root)
        found.append(np.pi if angle <= -np.pi + _REAL else float(angle))
    return found


def _places(part: Polynomial, space: Space, joint: int) -> list[float]:
    ring = space.half.ring
    place = 2 * len(ring.angles) + list(ring.slides).index(joint)
    return _real_roots(_numbers(part, space, (place,)))


def _real_roots(coefficients: Array) -> list[float]:
    trimmed = np.trim_zeros(np.where(np.abs(coefficients) <= _REAL * np.abs(coefficients).max(), 0.0, coefficients), "f")
    if len(trimmed) == 3:
        a, b, c = trimmed
        inside = b * b - 4 * a * c
        if abs(inside) <= _DOUBLE * (b * b + abs(4 * a * c)):
            return [float(-b / (2 * a))]
        if inside < 0:
            return []
        w = -0.5 * (b + np.copysign(np.sqrt(inside), b))
        return [float(w / a), float(c / w)] if w else [0.0]
    roots = np.roots(trimmed)
    return [float(r.real) for r in roots if abs(r.imag) <= _ROUNDING * (1.0 + abs(r))]


def _has_zeros(f: WaveFunction, space: Space) -> bool | None:
    """Whether a function of several joints vanishes somewhere."""
    constant = np.all(f.frequencies == 0, axis=1)
    size = np.hypot(f.cosines, f.sines)
    if not f.slides and abs(f.cosines[constant].sum()) > size[~constant].sum() * (1.0 + 1e-9):
        return False
    values = f.value(space.random(_TRIES, seed=1))
    if values.min() < 0 < values.max():
        return True
    q = space.random(_TRIES, seed=2)
    for _ in range(_STEPS):
        g = f.gradient(q)
        q = q - (f.value(q) / np.maximum((g * g).sum(-1), 1e-30))[:, None] * g
    return True if np.any(np.abs(f.value(q)) <= _REAL * f.scale) else None
