"""`Map`: the regions of a landscape, joined from postures by ways on which it surely keeps its sign."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..namespaces import Array
from ..progress import Job
from .landscape import Landscape

_ROUNDS, _STONES, _MOST = 6, 3, 6000
_NEIGHBOURS, _CHUNK, _SOME = 14, 256, 1000
_SAME, _PUSH = 1e-3, 1e-3
_MANY_FACES = 300
_MEMBERS, _PAIRS = 400, 12


class Regions(NamedTuple):
    """Regions of one group of factors: (k, d) a posture of each in its joints, and what was found on the way."""

    joints: tuple[int, ...]
    postures: Array
    extrema: int
    passes: int
    proved: bool
    settled: bool


@dataclass
class Map:
    """Postures of a landscape, and which of them are known to lie in one region."""

    land: Landscape
    starts: int
    seed: int
    job: Job
    places: Array = field(init=False)
    parents: list[int] = field(init=False)
    passes: int = 0

    def regions(self) -> Regions:
        """Rounds of postures until one changes nothing."""
        self.places, self.parents = np.zeros((0, len(self.land.joints))), []
        before, settled = -1, False
        for turn in range(_ROUNDS):
            self.job.tell("regions between singular postures", turn / _ROUNDS)
            self._round(turn)
            now = len(self._roots())
            settled = now == before
            if settled or self.job.late:
                break
            before = now
        best: dict[int, int] = {}
        height = np.abs(self.land.f.value(self.places))
        for k in range(len(self.places)):
            root = self._root(k)
            if root not in best or height[k] > height[best[root]]:
                best[root] = k
        postures = self.places[sorted(best.values())]
        return Regions(self.land.joints, postures, self._extrema(), self.passes, False, settled)

    def _round(self, turn: int) -> None:
        rng = np.random.default_rng([self.seed, turn])
        first, before = len(self.places), self._roots() if turn else []
        stones = self._stones(rng, turn)
        stones = stones[self.land.sure(stones)]
        for some in np.array_split(stones, max(1, len(stones) // _SOME)):
            if self.job.late and len(self.places):
                break
            begin = len(self.places)
            self._add(some)
            self._add(self.land.climbed(some), range(begin, begin + len(some)))
        self._join(np.arange(first, len(self.places)))
        if len(self._roots()) > 1 and not (turn > 1 and len(before) == len(self._roots())):
            self._cross(rng)

    def _stones(self, rng: Any, turn: int) -> Array:
        """Postures anywhere in the box; some on faces, the first time its corners too."""
        land, d = self.land, len(self.land.joints)
        lower, upper = np.where(land.round, -np.pi, land.lower), np.where(land.round, np.pi, land.upper)
        turns = np.prod(np.maximum((upper - lower) / (2 * np.pi), 1.0))
        count = int(min(_STONES * self.starts * float(turns), max(_MOST, self.starts)))
        x = rng.uniform(lower, upper, (count, d))
        side = rng.integers(0, 4, x.shape)  # a quarter of the joints of a third of the postures at each limit
        rim = (np.arange(count) % 3 == 0)[:, None] & ~land.round
        x = np.where(rim & (side == 0), lower, np.where(rim & (side == 1), upper, x))
        if turn == 0:
            ends = [(0.0,) if whole else (low, high) for whole, low, high in zip(land.round, lower, upper, strict=True)]
            x = np.concatenate([np.array(list(itertools.product(*ends))).reshape(-1, d), x])
        return x

    def _add(self, x: Array, of: range | None = None) -> None:
        """New places, each in the region of an older one or in one of its own."""
        first = len(self.places)
        self.places = np.concatenate([self.places, x])
        self.parents += range(first, first + len(x))
        for k, other in enumerate(of or ()):
            self._unite(first + k, other)

    def _join(self, new: Array) -> None:
        """Joins places to near ones by straight pieces, the nearest first."""
        charted = self.land.chart(self.places)
        squares, count = (charted**2).sum(-1), min(_NEIGHBOURS + 1, len(self.places))
        for chunk in np.array_split(new, max(1, len(new) // _CHUNK)):
            if self.job.late:
                return
            lengths = squares - 2 * charted[chunk] @ charted.T
            near = np.argpartition(lengths, count - 1, axis=1)[:, :count]
            near = np.take_along_axis(near, np.take_along_axis(lengths, near, 1).argsort(1), 1)[:, 1:]
            for column in near.T:
                self._unite_where_sure(chunk, column)

    def _unite_where_sure(self, one: Array, other: Array) -> None:
        """Joins pairs of places between which a straight piece surely keeps the sign."""
        x = self.places
        apart = np.array([self._root(int(a)) != self._root(int(b)) for a, b in zip(one, other, strict=True)], dtype=bool)
        a, b = one[apart], other[apart]
        same = np.sign(self.land.f.value(x[a])) == np.sign(self.land.f.value(x[b]))
        a, b = a[same], b[same]
        if len(a):
            sure = self.land.keeps_sign(x[a], self.land.step_to(x[a], x[b]))
            for i, j in zip(a[sure], b[sure], strict=True):
                self._unite(int(i), int(j))

    def _cross(self, rng: Any) -> None:
        """Joins regions by passes of the box and of its faces: walks up both ways, which end near places known."""
        land = self.land
        choices = [(0,) if whole else (0, -1, 1) for whole in land.round]
        middles = self._middles()
        faces = sorted(itertools.product(*choices), key=lambda face: sum(side != 0 for side in face))[:_MANY_FACES]
        for face in faces:
            free = np.array([side == 0 for side in face], dtype=bool)
            if self.job.late or not free.any():
                break
            count = max(24, self.starts // 2 ** int((~free).sum()))
            lower, upper = np.where(land.round, -np.pi, land.lower), np.where(land.round, np.pi, land.upper)
            x = np.concatenate([rng.uniform(lower, upper, (count, len(face))), middles])
            x = np.where(free, x, np.where(np.array(face) < 0, lower, upper))
            self._walk_from(*land.passes(_distinct(land, land.critical(x, free)), free))

    def _middles(self) -> Array:
        """Middles of the shortest ways between places of different regions of one sign: near a pass, if there is one."""
        roots = np.array([self._root(k) for k in range(len(self.places))])
        signs, charted = np.sign(self.land.f.value(self.places)), self.land.chart(self.places)
        found = [np.zeros((0, len(self.land.joints)))]
        for root in np.unique(roots):
            own, others = np.flatnonzero(roots == root), np.flatnonzero((roots != root) & (signs == signs[root]))
            if not len(others):
                continue
            own = own[:_MEMBERS]
            squares = (charted[others] ** 2).sum(-1) - 2 * charted[own] @ charted[others].T
            nearest = squares.argmin(1)
            lengths = squares[np.arange(len(own)), nearest] + (charted[own] ** 2).sum(-1)
            best = np.argsort(lengths)[:_PAIRS]
            a, b = self.places[own[best]], self.places[others[nearest[best]]]
            found.append(a + self.land.step_to(a, b) / 2)
        return np.concatenate(found)

    def _walk_from(self, points: Array, ways: Array) -> None:
        self.passes += len(points)
        if not len(points):
            return
        land, first = self.land, len(self.places)
        self._add(points)
        for side in (_PUSH, -_PUSH):
            start = np.clip(points + side * ways, land.lower, land.upper)
            kept = land.keeps_sign(points, start - points)
            begin = len(self.places)
            self._add(land.climbed(start[kept]))
            for k, of in enumerate(np.flatnonzero(kept)):
                self._unite(begin + k, first + int(of))
        self._join(np.arange(first, len(self.places)))

    def _extrema(self) -> int:
        """Distinct places that |f| does not rise from."""
        land, x = self.land, self.places
        slope = land.f.gradient(x) * np.sign(land.f.value(x))[:, None]
        level = np.linalg.norm(land.inwards(x, slope), axis=-1) <= 1e-6 * land.scale
        x = x[level]
        free = np.all(np.linalg.eigvalsh(land.f.hessian(x) * np.sign(land.f.value(x))[:, None, None])[:, -1:] < 0, axis=-1)
        held = np.any((x == land.lower) | (x == land.upper), axis=-1)
        return len(_distinct(land, x[free | held]))

    def _roots(self) -> list[int]:
        return sorted({self._root(k) for k in range(len(self.parents))})

    def _root(self, k: int) -> int:
        while self.parents[k] != k:
            self.parents[k] = self.parents[self.parents[k]]
            k = self.parents[k]
        return k

    def _unite(self, a: int, b: int) -> None:
        one, other = self._root(a), self._root(b)
        self.parents[max(one, other)] = min(one, other)


def _distinct(land: Landscape, x: Array) -> Array:
    """The places, each once."""
    kept: list[int] = []
    for k in range(len(x)):
        if not kept or np.linalg.norm(land.step_to(x[k], x[kept]), axis=-1).min() > _SAME:
            kept.append(k)
    return x[kept]
