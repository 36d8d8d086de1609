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
from .components import Component
from .enclosure import Domain, Enclosure
from .equations import Equation

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
        residual: how far the nominal robot, of which it is, is from the one given.
    """

    verdict: str
    witness: Array | None
    component: Component | None
    pieces: int
    seconds: float
    residual: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "verdict": self.verdict,
            "witness": None if self.witness is None else self.witness.tolist(),
            "component": None if self.component is None else self.component.name,
            "pieces": self.pieces,
            "residual": self.residual,
        }

    def __str__(self) -> str:
        if self.verdict == FREE:
            text = f"free of singularities: proved in {self.pieces} pieces"
            return text + self._of_nominal()
        name = "" if self.component is None else f" ({self.component.name})"
        if self.verdict == SINGULAR:
            where = np.array2string(np.asarray(self.witness), precision=6)
            return f"singular{name}: for one at {where}{self._of_nominal()}"
        return self._undecided(name)

    def _of_nominal(self) -> str:
        known = self.residual <= 1e-9
        return "" if known else f", for the nominal robot; the one given differs by up to {self.residual:.1e}"

    def _undecided(self, name: str) -> str:
        return f"undecided{name} after {self.pieces} pieces: smaller boxes or a larger budget may decide"


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
    space = component.space
    forms = [[Enclosure(space.half, space.waves(F), exact, domain) for e in group for F in e.parts] for group in groups]
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
