"""Proofs that a box of postures, or a path, is free of singularities: interval arithmetic with outward rounding (Arb).

A component is absent where one of its equations has no zero. On a piece with centre c and half widths h an equation lies
in f(c) + Σ ∂f/∂q_i(piece) · [-h_i, h_i] (mean value form); a piece where that holds 0 is halved. Amplitudes are exact
numbers of the nominal robot, so that "free" is a theorem about it.
"""

from __future__ import annotations

import heapq
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..symbolic.ring import Polynomial, flint
from .components import Component
from .equations import Equation, Space

FREE, SINGULAR, UNDECIDED = "free", "singular", "undecided"
_PIECES, _SMALLEST = 4000, 1e-7
_ON = 1e-12


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is proved about a box or a path.

    Attributes:
        verdict: "free": no singular posture, proved for the nominal robot; "singular": with a witness; "undecided": neither.
        witness: (n) a singular posture inside, to rounding; None for the others.
        component: the one it lies on, or the first that could not be excluded.
        pieces: how many pieces were looked at; seconds: what it took.
    """

    verdict: str
    witness: Array | None
    component: Component | None
    pieces: int
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "verdict": self.verdict,
            "witness": None if self.witness is None else self.witness.tolist(),
            "component": None if self.component is None else self.component.name,
            "pieces": self.pieces,
        }

    def __str__(self) -> str:
        if self.verdict == FREE:
            return f"free of singularities: proved in {self.pieces} pieces"
        name = "" if self.component is None else f" ({self.component.name})"
        if self.verdict == SINGULAR:
            return f"singular{name}: for one at {np.array2string(np.asarray(self.witness), precision=6)}"
        return f"undecided{name} after {self.pieces} pieces: smaller boxes or a larger budget may decide"


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

    def __init__(self, F: Polynomial, space: Space, exact: dict[Any, Any], domain: Domain) -> None:
        arb = flint().arb
        ring = space.half.ring
        turning = [j for j, turns in enumerate(ring.turns) if turns]
        constants = [_number(x, exact) for x in ring.constants]
        lengths = [_number(exact[x], exact) for x in ring.parameters] + [arb(p).sqrt() for p in ring.roots]
        slides = len(ring.slides)
        origin = [arb(float(x)) for x in domain.origin]
        directions = [[arb(float(x)) for x in row] for row in domain.directions]
        self.terms: list[tuple[Any, Any, Any, list[Any]]] = []
        for k, group in space.waves(F).items():
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


def _number(expression: Any, exact: dict[Any, Any]) -> Any:
    """A SymPy number as an interval."""
    import sympy

    arb, x = flint().arb, sympy.sympify(expression).subs(exact)
    if x.is_Rational:
        return arb(flint().fmpq(int(x.p), int(x.q)))
    ratio = x / sympy.pi
    if ratio.is_Rational:
        return arb.pi() * arb(flint().fmpq(int(ratio.p), int(ratio.q)))
    raise ConfigurationError("KS398", f"{x} is no number that intervals can hold", "rational lengths, and parts of pi")


def certify(
    components: tuple[Component, ...], domain: Domain, exact: dict[Any, Any], budget: float, began: float
) -> Certificate:
    """Whether a domain is free of all components."""
    pieces = 0
    open_component = None
    for component in components:
        verdict, witness, count = _excluded(component, domain, exact, began + budget)
        pieces += count
        if verdict == SINGULAR:
            return Certificate(SINGULAR, witness, component, pieces, time.monotonic() - began)
        if verdict == UNDECIDED and open_component is None:
            open_component = component
    verdict = FREE if open_component is None else UNDECIDED
    return Certificate(verdict, None, open_component, pieces, time.monotonic() - began)


def _excluded(component: Component, domain: Domain, exact: dict[Any, Any], deadline: float) -> tuple[str, Array | None, int]:
    """ "free" where a piece-wise proof succeeds, "singular" with a posture inside, else "undecided"; and the pieces used."""
    groups = [[equation] for equation in component.equations] + [list(group) for group in component.others]
    forms = [[Enclosure(F, component.space, exact, domain) for e in group for F in e.parts] for group in groups]
    k = len(domain.directions)
    queue: list[tuple[float, int, Array, Array]] = [(0.0, 0, -np.ones(k), np.ones(k))]
    count = serial = 0
    while queue:
        _, _, low, high = heapq.heappop(queue)
        count += 1
        if any(all(form.sign(low, high) for form in group) for group in forms):
            continue
        if count <= 1 or count in (16, 128, 1024):
            witness = _witness(component, domain, low, high)
            if witness is not None:
                return SINGULAR, witness, count
        if k == 0 or count >= _PIECES or time.monotonic() > deadline or (high - low).max() < _SMALLEST:
            return UNDECIDED, None, count
        i = _longest(domain, component, low, high)
        middle = (low[i] + high[i]) / 2.0
        for a, b in ((low[i], middle), (middle, high[i])):
            serial += 1
            lower, upper = low.copy(), high.copy()
            lower[i], upper[i] = a, b
            heapq.heappush(queue, (-float((upper - lower).max()), serial, lower, upper))
    return FREE, None, count


def _longest(domain: Domain, component: Component, low: Array, high: Array) -> int:
    """The parameter along which the component's joints travel farthest."""
    travel = np.abs(domain.directions[:, list(component.columns)]).max(axis=1, initial=0.0)
    return int(((high - low) * travel).argmax()) if travel.max() > 0 else int((high - low).argmax())


def _witness(component: Component, domain: Domain, low: Array, high: Array) -> Array | None:
    """A posture of the component inside a piece, found by Gauss-Newton steps in the parameters from a few points of it."""
    k = len(domain.directions)
    starts = np.stack(
        [(low + high) / 2.0, *(np.clip((low + high) / 2.0 + 0.45 * (high - low) * w, low, high) for w in _corners(k))]
    )
    s = starts
    for _ in range(20):
        values, slopes = component.residuals(domain.at(s))
        if k:
            step = np.einsum("kij,kj->ki", np.linalg.pinv(slopes @ domain.directions.T, rcond=1e-9), values)
            s = np.clip(s - step, -1.0, 1.0)
    values, _ = component.residuals(domain.at(s))
    good = np.abs(values).max(-1) <= _ON
    return domain.at(s[good][0]) if good.any() else None


def _corners(k: int) -> Array:
    """A few fixed directions in k dimensions."""
    return np.random.default_rng(11).choice([-1.0, 1.0], size=(6, k))


def check_equations(components: tuple[Component, ...]) -> None:
    """Raises ConfigurationError (KS398) where a joint slides: enclosures are of angles only."""
    for component in components:
        for equation in (*component.equations, *(e for group in component.others for e in group)):
            if any(f.slides for f in _functions(equation)):
                hint = "distance and the equations themselves hold for sliding joints too"
                raise ConfigurationError("KS398", f"{equation.expression} = 0 has a joint that slides", hint)


def _functions(equation: Equation) -> Any:
    return equation.functions
