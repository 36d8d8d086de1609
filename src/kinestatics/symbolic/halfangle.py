"""Factors of trigonometric polynomials, complete over the rationals. Floor 7.

Cosines and sines do not factor uniquely (s² = (1 - c)(1 + c)); their half angles do. With t = sin(x/2), u = cos(x/2)

    c = u² - t²,    s = 2 t u,    1 = t² + u²

a polynomial becomes homogeneous in every pair (t, u), and that ring is a polynomial ring. It also tells x = 0 (t) from
x = 180 degrees (u), which sin x does not.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any

from .ring import Exponents, Polynomial, TrigonometricRing, flint

_LARGE = 4000  # terms from which on it is worth looking at numbers first
_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89)
_BITS = 400  # of numbers that floats hold with room for products
Frequencies = tuple[int, ...]
"""One whole number for every angle, in half angles: (2, -1) is x1 - x2/2."""
Waves = dict[Frequencies, dict[Exponents, tuple[Fraction, Fraction]]]
"""Σ (a cos φ + b sin φ) · monomial: frequencies of φ → exponents of slides, parameters and roots → (a, b)."""


@dataclass(frozen=True, eq=False)
class HalfAngleRing:
    """The polynomials in t and u of every angle, and in slides, lengths and roots, of a trigonometric ring."""

    ring: TrigonometricRing
    context: Any = field(init=False)
    circles: tuple[Polynomial, ...] = field(init=False)
    pairs: tuple[tuple[Polynomial, Polynomial], ...] = field(init=False, repr=False)
    _others: tuple[int, ...] = field(init=False, repr=False)
    _origins: dict[int, tuple[Polynomial, Polynomial]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        module, ring = flint(), self.ring
        others = len(ring.slides) + len(ring.parameters) + len(ring.roots)
        names = tuple(f"h{i}" for i in range(max(2 * len(ring.angles) + others, 1)))
        object.__setattr__(self, "context", module.fmpq_mpoly_ctx.get(names, module.Ordering.lex))
        generators = tuple(self.context.gens())
        pairs = [(generators[2 * a], generators[2 * a + 1]) for a in range(len(ring.angles))]
        object.__setattr__(self, "pairs", tuple(pairs))
        object.__setattr__(self, "circles", tuple(t * t + u * u for t, u in pairs))
        places = [*ring.slides.values()]
        first = ring.parameter_place(0)
        places += range(first, first + len(ring.parameters) + len(ring.roots))
        object.__setattr__(self, "_others", tuple(places))
        object.__setattr__(self, "_origins", {})  # of large polynomials: what they were lifted from

    def lifted(self, p: Polynomial) -> Polynomial:
        """The same function in half angles, homogeneous in every pair."""
        terms = list(p.to_dict().items())
        if not terms:
            return self.context.constant(0)
        angles = self.ring.angles
        degrees = [max(e[x.cosine] + e[x.sine] for e, _ in terms) for x in angles]

        def descend(items: list[tuple[Exponents, Any]], level: int) -> Polynomial:
            if level == len(angles):
                head = (0,) * (2 * len(angles))
                collected = {head + tuple(e[i] for i in self._others): c for e, c in items}
                return self.context.from_dict(collected or {head: 0}) if head or collected else self.context.constant(0)
            (t, u), x = self.pairs[level], angles[level]
            groups: dict[tuple[int, int], list[tuple[Exponents, Any]]] = {}
            for e, c in items:
                groups.setdefault((e[x.cosine], e[x.sine]), []).append((e, c))
            total = self.context.constant(0)
            for (c, s), group in groups.items():
                basis = (u * u - t * t) ** c * (2 * t * u) ** s * (u * u + t * t) ** (degrees[level] - c - s)
                total += basis * descend(group, level + 1)
            return total

        F = descend(terms, 0)
        if len(F) > _LARGE:
            self._origins[len(F)] = (F, p)
        return F

    def degrees(self, F: Polynomial) -> tuple[int, ...]:
        """The degree in each pair (t, u)."""
        if F == 0:
            return (0,) * len(self.pairs)
        exponents = F.monomial(0)
        return tuple(int(exponents[2 * a] + exponents[2 * a + 1]) for a in range(len(self.ring.angles)))

    def joints_of(self, F: Polynomial) -> tuple[int, ...]:
        """The joints that a polynomial depends on."""
        ring, degrees = self.ring, self.degrees(F)
        turning = [j for j, turns in enumerate(ring.turns) if turns]
        found = [j for a, j in enumerate(turning) if degrees[a]]
        powers = F.degrees()
        first = 2 * len(ring.angles)
        found += [j for k, j in enumerate(ring.slides) if powers[first + k]]
        return tuple(sorted(found))

    def factored(self, F: Polynomial) -> tuple[Polynomial, list[tuple[Polynomial, int]]]:
        """What does not depend on the joints, and the irreducible factors that do, with multiplicities; t² + u² is 1."""
        if len(F) > _LARGE and self._is_irreducible(F):
            return self.context.constant(1), [(F, 1)]
        constant, found = F.factor()
        constant = self.context.constant(constant)
        kept = []
        for factor, times in found:
            if factor in self.circles:
                continue
            if self.joints_of(factor):
                size = _beyond_floats(factor)
                constant *= self.context.constant(size) ** int(times)
                kept.append((factor / size, int(times)))
            else:
                constant *= factor ** int(times)
        return constant, kept

    def _is_irreducible(self, F: Polynomial) -> bool:
        """Whether a polynomial is irreducible in the joints, seen at numbers for lengths and constant angles.

        A factorisation would remain one there, as long as no degree drops. False says nothing.
        """
        number, generators = flint().fmpq, self.context.gens()
        moving = {2 * a + k for a in range(sum(self.ring.turns)) for k in (0, 1)}
        first = 2 * len(self.ring.angles)
        moving |= {first + k for k in range(len(self.ring.slides))}
        values = [
            g if i in moving else self.context.constant(number(_PRIMES[i % 24], _PRIMES[(7 * i + 3) % 24]))
            for i, g in enumerate(generators)
        ]
        P = F.compose(*values, ctx=self.context)
        if any(P.degrees()[i] != F.degrees()[i] for i in moving):
            return False
        parts = [(factor, times) for factor, times in P.factor()[1] if self.joints_of(factor)]
        return len(parts) == 1 and parts[0][1] == 1

    def full_angles(self, F: Polynomial) -> Polynomial | None:
        """The polynomial in whole angles, in canonical form; None where the degree in a pair is odd."""
        if any(degree % 2 for degree in self.degrees(F)):
            return None
        if (known := self.origin(F)) is not None:
            return known
        return next((p for _, p in self.in_whole_angles(F)), self.ring.zero)

    def origin(self, F: Polynomial) -> Polynomial | None:
        """What a large polynomial was lifted from, where that is known."""
        known = self._origins.get(len(F))
        return known[1] if known is not None and known[0] == F else None

    def in_whole_angles(self, F: Polynomial) -> list[tuple[tuple[int, ...], Polynomial]]:
        """Polynomials in whole angles, each with what it is to be multiplied by: for every angle 1, or t (1) or u (2)."""
        ring, n = self.ring, len(self.ring.angles)
        half = ring.number(Fraction(1, 2))
        odd = [degree % 2 for degree in self.degrees(F)]
        known: dict[tuple[int, int, int], Polynomial] = {}

        def basis(a: int, t: int, u: int) -> Polynomial:
            if (a, t, u) not in known:
                c, s = ring.generator(ring.angles[a].cosine), ring.generator(ring.angles[a].sine)
                even = ((ring.one - c) * half) ** (t // 2) * ((ring.one + c) * half) ** (u // 2)
                known[a, t, u] = even * (s * half) if t % 2 else even
            return known[a, t, u]

        found: dict[tuple[int, ...], Polynomial] = {}
        for powers, coefficient in F.to_dict().items():
            exponents = [int(e) for e in powers]
            halves = [0] * n
            for a in range(n):
                if odd[a]:
                    halves[a] = 1 if exponents[2 * a] % 2 else 2
                    exponents[2 * a + halves[a] - 1] -= 1
            term = ring.context.constant(coefficient)
            for a in range(n):
                term *= basis(a, exponents[2 * a], exponents[2 * a + 1])
            for place, power in zip(self._others, exponents[2 * n :], strict=False):
                term *= ring.generator(place) ** power
            key = tuple(halves)
            found[key] = found.get(key, ring.zero) + term
        return [(key, ring.reduced(p)) for key, p in found.items()]

    def waves(self, F: Polynomial) -> Waves:
        """The polynomial as a sum of cosines and sines of sums of angles (exact)."""
        n = len(self.ring.angles)
        state: dict[tuple[int, ...], tuple[Any, Any]] = {}
        for powers, coefficient in F.to_dict().items():
            state[tuple(int(e) for e in powers)] = (coefficient, 0 * coefficient)
        for a in range(n):  # one angle after the other, so that what is equal meets early; (t, u) becomes (frequency, 0)
            spread: dict[tuple[int, ...], tuple[Any, Any]] = {}
            for key, (x, y) in state.items():
                for f, (c, d) in _power(key[2 * a], key[2 * a + 1]).items():
                    new = (*key[: 2 * a], f, 0, *key[2 * a + 2 :])
                    before = spread.get(new)
                    re, im = x * c - y * d, x * d + y * c
                    spread[new] = (re, im) if before is None else (before[0] + re, before[1] + im)
            state = spread
        found: Waves = {}
        for key, (x, y) in state.items():
            found.setdefault(key[0 : 2 * n : 2], {})[key[2 * n :]] = (_fraction(x), _fraction(y))
        return _real(found)


def _beyond_floats(F: Polynomial) -> Any:
    """The largest coefficient of a polynomial whose numbers, without a common factor, are beyond floats; else 1."""
    largest = max(map(abs, F.coeffs()))
    return largest if int(largest.p).bit_length() > _BITS else flint().fmpq(1)


@cache
def _power(t: int, u: int) -> dict[int, tuple[Any, Any]]:
    """sin(x/2)^t cos(x/2)^u as Σ (a + b i) e^(i k x/2)."""
    number = flint().fmpq
    zero, half = number(0), number(1, 2)
    one_t, one_u = {1: (zero, -half), -1: (zero, half)}, {1: (half, zero), -1: (half, zero)}
    p = {0: (number(1), zero)}
    for factor in [one_t] * t + [one_u] * u:
        r: dict[int, tuple[Any, Any]] = {}
        for k, (a, b) in p.items():
            for f, (c, d) in factor.items():
                before = r.get(k + f, (zero, zero))
                r[k + f] = (before[0] + a * c - b * d, before[1] + a * d + b * c)
        p = r
    return p


def _fraction(x: Any) -> Fraction:
    return Fraction(int(x.p), int(x.q))


def _real(found: Waves) -> Waves:
    """From coefficients of e^(iφ) to those of cos φ and sin φ, one of every pair φ, -φ; zeros left out."""
    real: Waves = {}
    for k, group in found.items():
        lead = next((x for x in k if x), 0)
        if lead < 0:
            continue
        scale = 1 if lead == 0 else 2
        kept = {e: (scale * a, -scale * b if lead else Fraction(0)) for e, (a, b) in group.items() if a or (b and lead)}
        if kept:
            real[k] = kept
    return real
