"""Enclosures of a factor on boxes and lines of postures, by interval arithmetic with outward rounding (Arb)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..symbolic.halfangle import HalfAngleRing, Waves
from ..symbolic.ring import flint

_PIECES = 4096


@dataclass(frozen=True, eq=False)
class Domain:
    """q = origin + Σ s_i directions_i with every s_i in [-1, 1]: a box, or a straight piece of a path."""

    origin: Array
    directions: Array

    @classmethod
    def of_box(cls, lower: Array, upper: Array) -> Domain:
        """The box between two corners; joints that stand still take no parameter."""
        centre = (lower + upper) / 2.0
        half = np.maximum(upper - centre, centre - lower)
        half = np.where(
            half > 0, half + 2.0 * np.spacing(np.maximum(np.abs(lower), np.abs(upper))), 0.0
        )  # covers the corners
        return cls(centre, np.diag(half)[half > 0])

    def at(self, s: Array) -> Array:
        """(..., n) for s (..., k)."""
        return self.origin + s @ self.directions


class Enclosure:
    """An equation's factor on a domain, as intervals."""

    def __init__(self, half: HalfAngleRing, waves: Waves, exact: Mapping[Any, Any], domain: Domain) -> None:
        arb = flint().arb
        ring = half.ring
        turning = [j for j, turns in enumerate(ring.turns) if turns]
        constants = [_number(x, exact) for x in ring.constants]
        lengths = [_number(exact[x], exact) for x in ring.parameters] + [arb(p).sqrt() for p in ring.roots]
        slides = len(ring.slides)
        origin = [arb(float(x)) for x in domain.origin]
        directions = [[arb(float(x)) for x in row] for row in domain.directions]
        self.terms: list[tuple[Any, Any, Any, list[Any]]] = []
        for k, group in waves.items():
            cosine = sine = arb(0)
            for exponents, (a, b) in group.items():
                size = arb(1)
                for x, e in zip(lengths, exponents[slides:], strict=True):
                    size *= x**e
                cosine += size * arb(flint().fmpq(a.numerator, a.denominator))
                sine += size * arb(flint().fmpq(b.numerator, b.denominator))
            weights = [arb(x) / 2 for x in k]
            phase = sum((w * x for w, x in zip(weights[len(turning) :], constants, strict=True)), arb(0))
            phase += sum((w * origin[j] for w, j in zip(weights, turning, strict=False)), arb(0))
            rates = [sum((w * row[j] for w, j in zip(weights, turning, strict=False)), arb(0)) for row in directions]
            self.terms.append((cosine, sine, phase, rates))

    def sign(self, low: Array, high: Array) -> int:
        """1 or -1 where the factor certainly has that sign on a piece, 0 where that is not known."""
        arb = flint().arb
        centre = [arb(float(x)) for x in (low + high) / 2.0]
        spread = [arb(0, float(x)) for x in np.nextafter((high - low) / 2.0, np.inf) * (1.0 + 1e-15)]
        value = arb(0)
        slopes = [arb(0)] * len(centre)
        for cosine, sine, phase, rates in self.terms:
            at = phase + sum((r * c for r, c in zip(rates, centre, strict=True)), arb(0))
            s, c = at.sin_cos()
            value += cosine * c + sine * s
            if any(r != 0 for r in rates):
                s, c = (at + sum((r * x for r, x in zip(rates, spread, strict=True)), arb(0))).sin_cos()
                bend = sine * c - cosine * s
                slopes = [d + r * bend for d, r in zip(slopes, rates, strict=True)]
        value += sum((d * x for d, x in zip(slopes, spread, strict=True)), arb(0))
        return 1 if value > 0 else -1 if value < 0 else 0


def _number(expression: Any, exact: Mapping[Any, Any]) -> Any:
    """A SymPy number as an interval."""
    import sympy

    arb, x = flint().arb, sympy.sympify(expression).subs(exact)
    if x.is_Rational:
        return arb(flint().fmpq(int(x.p), int(x.q)))
    ratio = x / sympy.pi
    if ratio.is_Rational:
        return arb.pi() * arb(flint().fmpq(int(ratio.p), int(ratio.q)))
    raise ConfigurationError("KS398", f"{x} is no number that intervals can hold", "rational lengths, and parts of pi")


def proved_free_on_circle(half: HalfAngleRing, waves: Waves, exact: Mapping[Any, Any], joint: int, n: int) -> bool:
    """Whether a factor of one angle is proved to vanish nowhere."""
    directions = np.zeros((1, n))
    directions[0, joint] = 3.2  # a little more than half a turn each way
    form = Enclosure(half, waves, exact, Domain(np.zeros(n), directions))
    pieces, count = [(-1.0, 1.0)], 0
    while pieces:
        low, high = pieces.pop()
        count += 1
        if count > _PIECES:
            return False
        if not form.sign(np.array([low]), np.array([high])):
            pieces += [(low, (low + high) / 2.0), ((low + high) / 2.0, high)]
    return True
