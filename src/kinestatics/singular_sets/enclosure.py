"""Factors of the singular set as exact terms, and their enclosures on boxes and lines of postures by intervals (Arb)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..symbolic.halfangle import HalfAngleRing, Waves
from ..symbolic.ring import flint

PRECISION = 128
"""Bits of Arb: for the amplitudes, and for pieces on which floats do not decide."""
_PIECES = 4096


@dataclass(frozen=True, eq=False)
class Domain:
    """q = origin + Σ s_i directions_i with every s_i in [-1, 1]: a box, or a straight piece of a path.

    Attributes:
        origin: (n); directions: (k, n): floats, taken as the exact numbers they are.
        slack: (n) the postures that are meant lie this close to such a q, joint by joint: what rounding took.
    """

    origin: Array
    directions: Array
    slack: Array

    @classmethod
    def of_box(cls, lower: Array, upper: Array) -> Domain:
        """The box between two corners; joints that stand still take no parameter."""
        centre = lower / 2.0 + upper / 2.0
        half = np.maximum(upper - centre, centre - lower)
        moves = upper > lower
        half = np.where(moves, half + 2.0 * np.spacing(np.maximum(np.abs(lower), np.abs(upper))), 0.0)  # covers the corners
        return cls(np.where(moves, centre, lower), np.diag(half)[moves], np.zeros(len(half)))

    @classmethod
    def of_segment(cls, first: Array, last: Array) -> Domain:
        """The straight line between two postures, both included.

        Middle and half difference are rounded by at most one unit of the last place of the larger end in all: the slack is
        two, so that no posture between the floats given is missed.
        """
        origin, direction = first / 2.0 + last / 2.0, last / 2.0 - first / 2.0
        moves = first != last
        slack = np.where(moves, 2.0 * np.spacing(np.maximum(np.abs(first), np.abs(last))), 0.0)
        origin = np.where(moves, origin, first)
        return cls(origin, np.where(moves, direction, 0.0)[None][: int(moves.any())], slack)

    def at(self, s: Array) -> Array:
        """(..., n) for s (..., k)."""
        return self.origin + s @ self.directions


@dataclass(frozen=True, eq=False)
class Terms:
    """A factor as Σ (A cos φ + B sin φ) Π q_j^powers_j with φ = Σ frequencies_j q_j / 2, proved.

    Attributes:
        frequencies: (m, n) whole multiples of half angles; powers: (m, n) of joints that slide; all rows
            differ.
        cosines, sines: (m) A and B as intervals of Arb, constant angles and lengths in them.
    """

    frequencies: Array
    powers: Array
    cosines: tuple[Any, ...]
    sines: tuple[Any, ...]

    @classmethod
    def of(cls, half: HalfAngleRing, waves: Waves, exact: Mapping[Any, Any]) -> Terms:
        """The terms of a factor.

        Args:
            half: its ring; waves: of the factor; exact: numbers of its symbols.

        Raises:
            ConfigurationError: KS398 for a number that intervals do not hold.
        """
        with flint().ctx.workprec(PRECISION):
            arb, ring, n = flint().arb, half.ring, len(half.ring.joints)
            turning, slides = [j for j, turns in enumerate(ring.turns) if turns], list(ring.slides)
            constants = [number(x, exact) for x in ring.constants]
            lengths = [number(x, exact) for x in ring.parameters] + [arb(p).sqrt() for p in ring.roots]
            found: dict[tuple[tuple[int, ...], tuple[int, ...]], list[Any]] = {}
            for k, group in waves.items():
                turn = sum((arb(x) / 2 * c for x, c in zip(k[len(turning) :], constants, strict=True)), arb(0))
                s, c = turn.sin_cos()
                for exponents, (a, b) in group.items():
                    size = arb(1)
                    for x, e in zip(lengths, exponents[len(slides) :], strict=True):
                        size *= x**e
                    A, B = size * _fraction(a), size * _fraction(b)
                    both = found.setdefault((k[: len(turning)], exponents[: len(slides)]), [arb(0), arb(0)])
                    both[0] += A * c + B * s
                    both[1] += (B * c - A * s) if any(k[: len(turning)]) else 0
            frequencies, powers = np.zeros((len(found), n), dtype=int), np.zeros((len(found), n), dtype=int)
            for row, (turned, moved) in enumerate(found):
                frequencies[row, turning], powers[row, slides] = turned, moved
            return cls(frequencies, powers, tuple(x for x, _ in found.values()), tuple(x for _, x in found.values()))


class Enclosure:
    """A factor on a domain, in intervals.

    Law: on a piece with centre c and half widths h, f lies in f(c) + Σ ∂f/∂s_i(piece) · [-h_i, h_i] (mean value form).
    """

    def __init__(self, terms: Terms, domain: Domain) -> None:
        arb = flint().arb
        self._n, self._terms = len(domain.origin), terms
        self._origin = [arb(float(x), float(r)) for x, r in zip(domain.origin, domain.slack, strict=True)]
        self._directions = [[arb(float(x)) for x in row] for row in domain.directions]

    def sign(self, low: Array, high: Array) -> int:
        """1 or -1 where the factor certainly has that sign on a piece, 0 where that is not known."""
        with flint().ctx.workprec(PRECISION):
            return self._sign(low, high)

    def _sign(self, low: Array, high: Array) -> int:
        arb, k = flint().arb, len(low)
        ends = [(arb(float(a)), arb(float(b))) for a, b in zip(low, high, strict=True)]
        spread = [(a - b) / 2 * arb(0, 1) for a, b in ends]
        centre = _moved(self._origin, [(a + b) / 2 for a, b in ends], self._directions)
        piece = _moved(centre, spread, self._directions)
        value, slopes = arb(0), [arb(0)] * k
        for K, E, A, B in zip(
            self._terms.frequencies.tolist(),
            self._terms.powers.tolist(),
            self._terms.cosines,
            self._terms.sines,
            strict=True,
        ):
            rates = [_sum(arb(f) / 2 * x for f, x in zip(K, d, strict=True) if f) for d in self._directions]
            phase = _sum(arb(f) / 2 * x for f, x in zip(K, centre, strict=True) if f)
            s, c = phase.sin_cos()
            value += (A * c + B * s) * _monomial(centre, E)
            s, c = (phase + _sum(r * x for r, x in zip(rates, spread, strict=True))).sin_cos()
            wave, bend, whole = A * c + B * s, B * c - A * s, _monomial(piece, E)
            for row, direction in enumerate(self._directions):
                lowered = _sum(
                    direction[j] * e * _monomial(piece, [x - (i == j) for i, x in enumerate(E)])
                    for j, e in enumerate(E)
                    if e
                )
                slopes[row] += rates[row] * bend * whole + wave * lowered
        value += _sum(d * x for d, x in zip(slopes, spread, strict=True))
        return 1 if value > 0 else -1 if value < 0 else 0


def _sum(parts: Any) -> Any:
    return sum(parts, flint().arb(0))


def _moved(start: Sequence[Any], steps: Sequence[Any], directions: Sequence[Sequence[Any]]) -> list[Any]:
    """start + Σ steps_i directions_i."""
    return [x + _sum(s * row[j] for s, row in zip(steps, directions, strict=True)) for j, x in enumerate(start)]


def _monomial(q: Sequence[Any], powers: Sequence[int]) -> Any:
    product = flint().arb(1)
    for x, e in zip(q, powers, strict=True):
        if e:
            product *= x**e
    return product


def _fraction(x: Any) -> Any:
    return flint().arb(flint().fmpq(int(x.numerator), int(x.denominator)))


def number(expression: Any, exact: Mapping[Any, Any]) -> Any:
    """A SymPy number as an interval: fractions, pi, and sums, products, powers and elementary functions of them.

    Raises:
        ConfigurationError: KS398 for anything else.
    """
    import sympy

    x = sympy.sympify(expression).subs(exact)
    found = _enclosed(x)
    if found is None or not found.is_finite():
        hint = "fractions, pi, roots, and sines, tangents and their inverses"
        raise ConfigurationError("KS398", f"{x} is no number that intervals can hold", hint)
    return found


_FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log")


def _enclosed(x: Any) -> Any:
    """An interval that holds a SymPy number; None where it is of another kind."""
    import sympy

    arb = flint().arb
    if x.is_Rational:
        return arb(flint().fmpq(int(x.p), int(x.q)))
    if x.is_Float:
        return _enclosed(sympy.Rational(x))
    if x is sympy.pi or x is sympy.E:
        return arb.pi() if x is sympy.pi else arb.const_e()
    parts = [_enclosed(y) for y in x.args]
    if not parts or any(part is None for part in parts):
        return None
    if x.is_Add:
        return _sum(parts)
    if x.is_Mul:
        product = arb(1)
        for part in parts:
            product *= part
        return product
    if x.is_Pow:
        return parts[0] ** (int(x.exp) if x.exp.is_Integer else parts[1])
    name = type(x).__name__
    return getattr(parts[0], name)() if name in _FUNCTIONS and len(parts) == 1 else None


def proved_free_on_circle(half: HalfAngleRing, waves: Waves, exact: Mapping[Any, Any], joint: int, n: int) -> bool:
    """Whether a factor of one angle is proved to vanish nowhere."""
    directions = np.zeros((1, n))
    directions[0, joint] = 3.2  # a little more than half a turn each way
    form = Enclosure(Terms.of(half, waves, exact), Domain(np.zeros(n), directions, np.zeros(n)))
    pieces, count = [(-1.0, 1.0)], 0
    while pieces:
        low, high = pieces.pop()
        count += 1
        if count > _PIECES:
            return False
        if not form.sign(np.array([low]), np.array([high])):
            pieces += [(low, (low + high) / 2.0), ((low + high) / 2.0, high)]
    return True
