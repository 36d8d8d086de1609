"""The components of a singular set as conditions on factors, and where on a domain they are excluded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..namespaces import Array
from ..progress import Job
from .components import Component
from .enclosure import Domain, Enclosure, Terms
from .equations import Equation, Space
from .factor_bounds import Bounds, FactorTable

_ROUNDED = 0.02  # of a radius: from that share of rounding on, halving gains little and intervals are asked
_TABLES = 64


@dataclass(frozen=True, eq=False)
class Part:
    """Some components, by the factors that they are made of.

    Attributes:
        components: their places among all; table: their factors, at the places `columns` among all.
        conditions: (c, w) columns of the table: of each condition the factors one of which vanishes, the last one repeated.
        owners: (c) the component of each condition, as a place in `components`.
    """

    components: tuple[int, ...]
    columns: tuple[int, ...]
    table: FactorTable
    conditions: Array
    owners: Array

    def excluded(self, known: Array) -> Array:
        """(p, components) whether a condition of theirs has no zero, from (p, f) whether a factor has none."""
        holds = known[:, self.conditions].all(-1)
        return np.stack([holds[:, self.owners == k].any(-1) for k in range(len(self.components))], -1)

    def blamed(self, share: Array, k: int) -> Array:
        """(p) the factor by which a component is nearest to being excluded, from (p, f) |value| over radius."""
        mine = self.conditions[self.owners == k]
        least = share[:, mine].argmin(-1)
        here = np.arange(len(share))
        weakest = np.take_along_axis(share[:, mine], least[..., None], -1)[..., 0].argmax(-1)
        return mine[weakest, least[here, weakest]]


@dataclass(frozen=True, eq=False)
class Exclusion:
    """Components as conditions, each a product of factors: one is absent where no factor of one condition vanishes.

    Made once for a singular set; its certificates read it.
    """

    components: tuple[Component, ...]
    space: Space

    @cached_property
    def factors(self) -> tuple[Terms, ...]:
        """The distinct factors, exact."""
        space = self.space
        return tuple(Terms.of(space.half, space.waves(F), space.exact) for F in self._polynomials.values())

    @cached_property
    def conditions(self) -> tuple[tuple[tuple[int, ...], ...], ...]:
        """Of each component: its conditions, each as places in `factors`."""
        places = {key: place for place, key in enumerate(self._polynomials)}
        return tuple(
            tuple(tuple(places[str(F)] for e in group for F in e.parts) for group in _groups(c)) for c in self.components
        )

    @cached_property
    def _polynomials(self) -> dict[str, Any]:
        return {str(F): F for component in self.components for group in _groups(component) for e in group for F in e.parts}

    @cached_property
    def _whole(self) -> FactorTable:
        return FactorTable.of(self.factors, self.space.model.n)

    @cached_property
    def _parts(self) -> dict[tuple[int, ...], Part]:
        return {}

    def part(self, components: Sequence[int]) -> Part:
        """Some components."""
        key = tuple(components)
        if key not in self._parts:
            if len(self._parts) >= _TABLES:
                self._parts.clear()
            self._parts[key] = self._made(key)
        return self._parts[key]

    def _made(self, components: tuple[int, ...]) -> Part:
        listed = [(k, condition) for k, c in enumerate(components) for condition in self.conditions[c]]
        columns = sorted({place for _, condition in listed for place in condition})
        width = max(len(condition) for _, condition in listed)
        padded = [[columns.index(x) for x in (*c, *c[-1:] * (width - len(c)))] for _, c in listed]
        return Part(
            components,
            tuple(columns),
            self._whole.restricted(columns),
            np.array(padded, dtype=int),
            np.array([k for k, _ in listed]),
        )


class Intervals:
    """Enclosures of factors on one domain, made when they are asked for: slow, and to many digits."""

    def __init__(self, exclusion: Exclusion, domain: Domain, job: Job) -> None:
        self._exclusion, self._domain, self._job = exclusion, domain, job
        self._made: dict[int, Enclosure] = {}

    def exclude(self, component: int, low: Array, high: Array) -> bool:
        """Whether a component is absent from a piece, proved; not looked at where the time is up."""
        if self._job.late:
            return False
        return any(all(self._of(f).sign(low, high) for f in c) for c in self._exclusion.conditions[component])

    def _of(self, factor: int) -> Enclosure:
        if factor not in self._made:
            self._made[factor] = Enclosure(self._exclusion.factors[factor], self._domain)
        return self._made[factor]


def still_open(part: Part, bounds: Bounds, intervals: Intervals, low: Array, high: Array, before: Array) -> Array:
    """(p, components) what is left of what was open: looked at in floats, and where these lose to rounding in intervals."""
    left = before & ~part.excluded(bounds.known)
    if not left.any():
        return left
    lost = bounds.rounding > _ROUNDED * bounds.radius
    lost |= ~np.isfinite(bounds.radius)
    for k, component in enumerate(part.components):
        mine = np.unique(part.conditions[part.owners == k])
        for p in np.flatnonzero(left[:, k] & lost[:, mine].any(-1)):
            left[p, k] = not intervals.exclude(component, low[p], high[p])
    return left


def longest(part: Part, bounds: Bounds, left: Array) -> Array:
    """(p) the parameter that adds most to the bounds by which components were not excluded."""
    measure = np.zeros(bounds.half.shape)
    here = np.arange(len(measure))
    for k in range(len(part.components)):
        rows = np.flatnonzero(left[:, k])
        f = part.blamed(bounds.share, k)
        reach = bounds.half * np.abs(bounds.slopes[here, :, f]) + bounds.bends[here, :, f]
        measure[rows] += (reach / (reach.sum(-1, keepdims=True) + np.finfo(float).tiny))[rows]
    measure = np.where(np.isfinite(measure), measure, 0.0)
    return np.where(measure.any(-1), measure.argmax(-1), bounds.half.argmax(-1))


def _groups(component: Component) -> list[list[Equation]]:
    """Products of equations, one of which vanishes."""
    return [[equation] for equation in component.equations] + [list(group) for group in component.others]
