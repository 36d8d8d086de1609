"""`Grid`: which nodes of a grid over a section of the workspace an arm reaches, and the nearest places to others.

Nodes are tried next to random postures, and beside each that is reached its neighbours, so that thin rims which random
postures hardly ever meet are found from within.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..progress import Job
from .chart import ARRIVED, Chart

RANDOM, STARTS = 60000, 8
"""Random postures that are looked at, and of these starts for each place that is looked for."""
_KEPT, _PAD = 12, 2
_NEAR = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)])


@dataclass
class Grid:
    """Nodes of a square grid: what is known of each.

    Attributes:
        chart: the map; corner: (2) of node (0, 0); step: between nodes; inside: (a, b) whether nodes are reached.
        pool: (k, n) postures, and places: (k, 2) where their tips are.
    """

    chart: Chart
    corner: Array
    step: float
    inside: Array
    pool: Array
    places: Array

    @classmethod
    def of(cls, chart: Chart, cells: int, rng: Any) -> Grid:
        """A grid with so many cells along the longer side of what random postures reach."""
        pool = chart.random(RANDOM, rng)
        places = chart.place(pool)
        low, high = places.min(0), places.max(0)
        step = float((high - low).max()) / cells
        corner = low - _PAD * step
        if chart.around:
            corner[0] = -0.5 * step  # nodes half a step beyond the axis: the outline may end there
            if low[0] > step:
                corner[0] += step * np.floor(low[0] / step - 0.5)
        sizes = np.ceil((high - corner) / step).astype(int) + 1 + _PAD
        few = _few_of_each(np.floor((places - corner) / step).astype(int))
        return cls(chart, corner, step, np.zeros(sizes, dtype=bool), pool[few], places[few])

    def node(self, index: Any) -> Array:
        return np.asarray(self.corner + self.step * np.asarray(index))

    def is_beyond(self, index: Any) -> Array:
        """Whether nodes lie on the other side of the axis."""
        return np.asarray(self.node(index)[..., 0] < 0) & self.chart.around

    def flood(self, job: Job) -> None:
        """Tries nodes next to places that are reached, until none is left."""
        hit = np.zeros(np.array(self.inside.shape) - 1, dtype=bool)
        cells = np.floor((self.places - self.corner) / self.step).astype(int)
        hit[tuple(cells.T)] = True
        padded = np.pad(hit, 1)
        around = padded[1:, 1:].astype(int) + padded[:-1, 1:] + padded[1:, :-1] + padded[:-1, :-1]
        self.inside = around == 4
        tried = self.inside.copy()
        todo = {tuple(index) for index in np.argwhere((around > 0) & (around < 4))}
        while todo and not job.late:
            job.tell("outline of the workspace")
            nodes = np.array(sorted(todo))
            nodes = nodes[~self.is_beyond(nodes)]
            tried[tuple(np.array(sorted(todo)).T)] = True
            todo = set()
            if not len(nodes):
                break
            y, away = self.best(self.node(nodes), STARTS)
            reached = away <= 10 * ARRIVED
            self.inside[tuple(nodes[reached].T)] = True
            self.remember(y)
            self._widen(nodes[reached])
            for index in (nodes[reached][:, None] + _NEAR).reshape(-1, 2):
                i, j = (int(x) for x in index)
                if 0 <= i < tried.shape[0] and 0 <= j < tried.shape[1] and not tried[i, j]:
                    todo.add((i, j))
            tried = np.pad(tried, [(0, a - b) for a, b in zip(self.inside.shape, tried.shape, strict=True)])

    def _widen(self, reached: Array) -> None:
        """Room for nodes beyond the last ones reached; the low sides have a rim of their own."""
        if len(reached):
            need = reached.max(0) + 1 + _PAD
            grow = np.maximum(need - np.array(self.inside.shape), 0)
            self.inside = np.pad(self.inside, [(0, int(g)) for g in grow])

    def remember(self, y: Array) -> None:
        self.pool, self.places = np.concatenate([self.pool, y]), np.concatenate([self.places, self.chart.place(y)])

    def best(self, targets: Array, count: int, more: Array | None = None) -> tuple[Array, Array]:
        """(t, n) the posture that comes nearest to each target, from postures whose tips are near it, and (t) how near."""
        starts = self._starts(targets, count)
        if more is not None:
            starts = np.concatenate([starts, more], axis=1)
        t, s, n = starts.shape
        y, away = self.chart.nearest(starts.reshape(-1, n), np.repeat(targets, s, axis=0))
        chosen = away.reshape(t, s).argmin(1)
        return y.reshape(t, s, n)[np.arange(t), chosen], away.reshape(t, s).min(1)

    def _starts(self, targets: Array, count: int) -> Array:
        """(t, count, n) of the pool: half of them the nearest, half by chance among a few times as many."""
        found = np.zeros((len(targets), count), dtype=int)
        squares = (self.places**2).sum(-1)
        for begin in range(0, len(targets), 64):
            some = targets[begin : begin + 64]
            lengths = squares - 2 * some @ self.places.T
            near = np.argpartition(lengths, 8 * count, axis=1)[:, : 8 * count]
            near = np.take_along_axis(near, np.take_along_axis(lengths, near, 1).argsort(1), 1)
            half = count // 2
            found[begin : begin + 64] = np.concatenate(
                [near[:, :half], near[:, half :: 8 - half // count][:, : count - half]], 1
            )
        return self.pool[found]


def _few_of_each(cells: Array) -> Array:
    """Places of at most so many in each cell."""
    order = np.lexsort(cells.T)
    new = np.r_[True, np.any(np.diff(cells[order], axis=0) != 0, axis=1)]
    begin = np.flatnonzero(new)
    rank = np.arange(len(order)) - np.repeat(begin, np.diff(np.r_[begin, len(order)]))
    return np.asarray(order[rank < _KEPT])
