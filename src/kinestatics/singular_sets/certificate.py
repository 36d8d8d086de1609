"""Proofs that a box of postures, or a path, is free of singularities.

A component is absent where one of its equations has no zero. On a piece, values and slopes at its centre and a bound of the
second derivatives bound every factor (`factor_bounds`: floats, their rounding accounted for); a piece where a component
remains is halved. Where rounding decides, intervals of many digits do (`enclosure`: Arb). Amplitudes are exact numbers of
the nominal robot, so that "free" is a theorem about it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..progress import Job, Progress
from .components import Component
from .enclosure import Domain
from .exclusion import Exclusion, Intervals, longest, still_open
from .witness import witness

FREE, SINGULAR, UNDECIDED = "free", "singular", "undecided"
_WORST = (SINGULAR, UNDECIDED, FREE)
_PIECES, _AT_ONCE, _SMALLEST = 200_000, 256, 1e-7
_NUMBERS = 1_000_000  # in an array, at most
_LOOKS = (1, 16, 128, 1024)  # pieces after which a witness is looked for
_FROM = 3  # pieces from which


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


def certify(exclusion: Exclusion, domain: Domain, job: Job) -> Certificate:
    """Whether a domain is free of all components."""
    began = time.monotonic()
    search = _Search(exclusion, domain, job)
    verdict, posture, component = search.run()
    found = None if component is None else exclusion.components[component]
    return Certificate(verdict, posture, found, search.count, time.monotonic() - began)


def certify_path(exclusion: Exclusion, postures: Array, budget: float, progress: Progress | None) -> Certificate:
    """Whether the straight lines between postures (m, n) are free: the worst of their certificates, up to a singular one."""
    worst, count, seconds = None, 0, 0.0
    last = len(postures) - 1
    for k in range(last):
        share = k / last
        job = Job.of(budget, None if progress is None else partial(_of_path, progress, f"line {k + 1} of {last}", share))
        job.tell("begins")
        found = certify(exclusion, Domain.of_segment(postures[k], postures[k + 1]), job)
        count, seconds = count + found.pieces, seconds + found.seconds
        if worst is None or _WORST.index(found.verdict) < _WORST.index(worst.verdict):
            worst = found
        if found.verdict == SINGULAR:
            break
    if worst is None:
        raise ValueError("a path has two postures or more")
    return replace(worst, pieces=count, seconds=seconds)


def _of_path(progress: Progress, name: str, share: float, what: str, _: float | None) -> None:
    """Tells what is done on one line of a path, and the share of the path that is done."""
    progress(f"{name}: {what}", share)


class _Search:
    """Halving of pieces, the largest first, until every component is excluded from every piece."""

    def __init__(self, exclusion: Exclusion, domain: Domain, job: Job) -> None:
        self.exclusion, self.domain, self.job = exclusion, domain, job
        self.intervals = Intervals(exclusion, domain, job)
        self.count = 0
        self._looks = list(_LOOKS)

    def run(self) -> tuple[str, Array | None, int | None]:
        """The verdict, a witness, and the component it is of or that is left."""
        k = len(self.domain.directions)
        low, high = -np.ones((1, k)), np.ones((1, k))
        components = tuple(range(len(self.exclusion.components)))
        left = np.ones((1, len(components)), dtype=bool)
        while components:
            low, high, left, cut = self._looked(components, low, high, left)
            kept = left.any(0)
            components, left = tuple(c for c, stays in zip(components, kept, strict=True) if stays), left[:, kept]
            if not components:
                break
            found = self._witnessed(components, low, high, left)
            if found is not None:
                return SINGULAR, *found
            if self.job.late or not k or self.count + 2 * len(low) > _PIECES or (high - low).max(-1).min() < _SMALLEST:
                return UNDECIDED, None, components[0]
            self.job.tell(f"{self.count} pieces looked at, {len(low)} to be halved")
            low, high = _halves(low, high, cut)
            left = np.concatenate([left, left])
        return FREE, None, None

    def _looked(self, components: tuple[int, ...], low: Array, high: Array, before: Array) -> tuple[Array, ...]:
        """Pieces from which some component is not excluded, which these are, and where to halve."""
        part = self.exclusion.part(components)
        kept, lefts, cuts = [], [], []
        together = max(1, min(_AT_ONCE, _NUMBERS // (part.table.waves * max(1, low.shape[1]))))
        for first in range(0, len(low), together):
            here = slice(first, first + together)
            bounds = part.table.bounds(self.domain, low[here], high[here])
            left = still_open(part, bounds, self.intervals, low[here], high[here], before[here])
            self.count += len(left)
            rows = np.flatnonzero(left.any(-1))
            kept.append(first + rows)
            lefts.append(left[rows])
            if len(rows) and bounds.half.shape[1]:
                cuts.append(longest(part, bounds, left)[rows])
        places = np.concatenate(kept)
        return low[places], high[places], np.concatenate(lefts), np.concatenate(cuts or [np.zeros(0, dtype=int)])

    def _witnessed(self, components: tuple[int, ...], low: Array, high: Array, left: Array) -> tuple[Array, int] | None:
        """A singular posture and its component, where it is time to look for one."""
        if not self._looks or self.count < self._looks[0]:
            return None
        while self._looks and self.count >= self._looks[0]:
            self._looks.pop(0)
        for k, component in enumerate(components):
            part = self.exclusion.part((component,))
            for p in np.flatnonzero(left[:, k])[:_FROM]:
                posture = witness(part, self.domain, low[p], high[p])
                if posture is not None:
                    return posture, component
        return None


def _halves(low: Array, high: Array, cut: Array) -> tuple[Array, Array]:
    """Both halves of every piece."""
    here = np.arange(len(low))
    middle = (low[here, cut] + high[here, cut]) / 2.0
    left, right = high.copy(), low.copy()
    left[here, cut], right[here, cut] = middle, middle
    return np.concatenate([low, right]), np.concatenate([left, high])


def checked_corners(n: int, box: Any, path: Any) -> Array:
    """(2, n) corners of a box, lower first, or (m, n) postures of a path.

    Raises:
        ConfigurationError: KS303.
    """
    if (box is None) == (path is None):
        raise ConfigurationError("KS303", "certify_free takes a box or a path", "one of the two")
    corners = np.asarray(path if box is None else box, dtype=float)
    expected = corners.ndim == 2 and corners.shape[1] == n and len(corners) >= 2
    if not expected or not np.all(np.isfinite(corners)) or (box is not None and len(corners) != 2):
        hint = f"a box is (2, {n}), a path (m, {n}), of finite numbers"
        raise ConfigurationError("KS303", f"found shape {corners.shape}", hint)
    if box is not None and np.any(corners[0] > corners[1]):
        raise ConfigurationError("KS303", "the box has a lower corner above the upper one", "lower first")
    return corners
