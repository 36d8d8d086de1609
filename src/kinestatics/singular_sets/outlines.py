"""The outline of what an arm reaches in a section of its workspace: found on a grid, then followed as closely as is asked.

A node of the grid that no posture reaches has a nearest place that one reaches, and that place is on the outline: as far as
the starts say, for the nearest of all may have been missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..namespaces import Array
from ..progress import Job
from .chart import ARRIVED
from .grid import RANDOM, STARTS, Grid

_ROUNDS, _REPAIRS, _MISSED = 30, 5, 8
_HALVINGS = 3
_CORNER = 2e-5  # in reaches: pieces are no shorter than that
_SAME, _AT_AXIS = 1e-8, 1e-7


class Loop(NamedTuple):
    """A closed outline in reaches: (k, 2) points, (k, 2) outward normals, (k, n) y, (k) whether on the axis (no outline)."""

    points: Array
    normals: Array
    postures: Array
    on_axis: Array


def loops(grid: Grid, tolerance: float, rng: Any, job: Job) -> tuple[list[Loop], bool]:
    """Closed outlines of a flooded grid, pieces between points no farther off than a tolerance [reaches]; whether in time.

    Random postures that turn out to be outside are starts for another look at the pieces next to them.
    """
    found = [loop for ring in _rings(grid.inside) if len((loop := _traced(grid, ring)).points) > 2]
    done = True
    for turn in range(_REPAIRS):
        refined = [_refined(grid, loop, tolerance, job) for loop in found]
        found, done = [loop for loop, _ in refined], all(in_time for _, in_time in refined)
        y = grid.chart.random(RANDOM, rng)
        places = grid.chart.place(y)
        y, places = y[~covered(found, places)], places[~covered(found, places)]
        missed = np.array([off(found, place) for place in places]) > 2 * tolerance if len(y) else np.zeros(0, dtype=bool)
        if not missed.any() or turn == _REPAIRS - 1 or job.late:
            break
        grid.remember(y[missed])
        nearest = np.array([[off([loop], place) for loop in found] for place in places[missed]]).argmin(1)
        chosen = [(loop, places[missed][nearest == k]) for k, loop in enumerate(found)]
        found = [_opened(grid, loop, some) if len(some) else loop for loop, some in chosen]
    return found, done


def covered(found: Sequence[Loop], places: Array) -> Array:
    """(k) whether places lie inside an odd number of loops."""
    inside = np.zeros(len(places), dtype=bool)
    for loop in found:
        a, b = loop.points, np.roll(loop.points, -1, axis=0)
        order = np.argsort(places[:, 1])
        sorted_ = places[order, 1]
        low, high = np.minimum(a[:, 1], b[:, 1]), np.maximum(a[:, 1], b[:, 1])
        begin, end = np.searchsorted(sorted_, low), np.searchsorted(sorted_, high)
        crossings = np.zeros(len(places), dtype=int)
        for k in np.flatnonzero(end > begin):
            here = order[begin[k] : end[k]]
            share = (places[here, 1] - a[k, 1]) / (b[k, 1] - a[k, 1])
            crossings[here] += places[here, 0] < a[k, 0] + share * (b[k, 0] - a[k, 0])
        inside ^= crossings % 2 == 1
    return inside


def off(found: Sequence[Loop], place: Array) -> float:
    """How far a place is from the nearest piece."""
    best = np.inf
    for loop in found:
        way = np.roll(loop.points, -1, axis=0) - loop.points
        share = ((place - loop.points) * way).sum(-1) / np.maximum((way * way).sum(-1), 1e-300)
        nearest = loop.points + np.clip(share, 0, 1)[:, None] * way
        best = min(best, float(np.linalg.norm(nearest - place, axis=-1).min()))
    return best


def _opened(grid: Grid, loop: Loop, places: Array) -> Loop:
    """A loop with the places farthest outside of it put into the pieces they are next to; each far from the others."""
    ahead = np.roll(loop.points, -1, axis=0) - loop.points
    squares = np.maximum((ahead * ahead).sum(-1), 1e-300)
    rest = np.array(places)
    for _ in range(_MISSED):
        share = np.clip(((rest[:, None] - loop.points) * ahead).sum(-1) / squares, 0, 1)
        way = rest[:, None] - (loop.points + share[..., None] * ahead)
        lengths = np.linalg.norm(way, axis=-1)
        far = int(lengths.min(1).argmax())
        piece = int(lengths[far].argmin())
        target = rest[far] + 0.25 * grid.step * way[far, piece] / lengths[far, piece]
        y, away = grid.best(target[None], 4 * STARTS)
        if away[0] > 1e3 * ARRIVED:
            new = _parts(grid, y, target[None])
            loop = Loop(*(np.insert(old, piece + 1, extra, axis=0) for old, extra in zip(loop, new, strict=True)))
            ahead = np.roll(loop.points, -1, axis=0) - loop.points
            squares = np.maximum((ahead * ahead).sum(-1), 1e-300)
        rest = rest[np.linalg.norm(rest - rest[far], axis=-1) > grid.step]
        if not len(rest):
            break
    return loop


def _rings(inside: Array) -> list[list[tuple[tuple[int, int], tuple[int, int]]]]:
    """Rings of pairs (node inside, node outside), inside to the left."""
    padded = np.pad(inside, 1)
    ahead: dict[tuple[int, int], list[tuple[tuple[int, int], Any]]] = {}
    # the side of the square around an inside node that faces an outside one, from corner to corner, anticlockwise
    sides = {(1, 0): ((1, 0), (1, 1)), (0, 1): ((1, 1), (0, 1)), (-1, 0): ((0, 1), (0, 0)), (0, -1): ((0, 0), (1, 0))}
    for i, j in np.argwhere(padded):
        for (di, dj), (begin, end) in sides.items():
            if not padded[i + di, j + dj]:
                pair = ((int(i) - 1, int(j) - 1), (int(i + di) - 1, int(j + dj) - 1))
                ahead.setdefault((int(i) + begin[0], int(j) + begin[1]), []).append(
                    ((int(i) + end[0], int(j) + end[1]), pair)
                )
    rings = []
    while ahead:
        corner = next(iter(ahead))
        ring: list[Any] = []
        while corner in ahead:
            exits = ahead[corner]
            nxt, pair = exits.pop(_turn(ring, exits))
            if not exits:
                del ahead[corner]
            ring.append(pair)
            corner = nxt
        rings.append(ring)
    return sorted(rings, key=len, reverse=True)


def _turn(ring: list[Any], exits: list[Any]) -> int:
    """Where two squares touch at a corner, the way that goes over to the other one: what is reached is rather one piece."""
    return next((k for k, (_, pair) in enumerate(exits) if ring and pair[0] != ring[-1][0]), 0)


def _traced(grid: Grid, ring: list[Any]) -> Loop:
    """Where the ways from nodes inside to nodes outside leave what is reached: the places nearest to there, in order."""
    first, last = (grid.node(np.array([pair[end] for pair in ring])) for end in (0, 1))
    beyond = grid.is_beyond(np.array([b for _, b in ring]))
    last = np.where(beyond[:, None], np.stack([np.zeros(len(ring)), first[:, 1]], -1), last)
    y, away = grid.best(last, STARTS)
    on_axis, targets = beyond & (away <= _AT_AXIS), last.copy()
    share = np.zeros((len(ring), 1))  # what is known to be reached of the way
    best = y.copy()
    for half in 0.5 ** np.arange(1, _HALVINGS + 1):
        some = ~on_axis
        trial = first + (share + half) * (last - first)
        found, away = grid.best(trial[some], STARTS, best[some, None])
        best[some] = found
        reached = np.zeros(len(ring), dtype=bool)
        reached[some] = away <= 10 * ARRIVED
        share = np.where(reached[:, None], share + half, share)
        out = some & ~reached
        targets[out], y[out] = trial[out], best[out]
    for by in (-1, 1):  # where the outline meets the axis
        ends = np.flatnonzero(~on_axis & np.roll(on_axis, -by))
        place = ends + (by > 0)
        away = np.sign(targets[ends, 1] - targets[(ends + by) % len(targets), 1])
        beyond = np.stack([np.zeros(len(ends)), targets[ends, 1] + away * grid.step], -1)
        found, _ = grid.best(beyond, STARTS, y[ends, None])
        y, targets = np.insert(y, place, found, axis=0), np.insert(targets, place, beyond, axis=0)
        on_axis = np.insert(on_axis, place, False)
    return _loop(grid, y, targets, on_axis)


def _loop(grid: Grid, y: Array, targets: Array, on_axis: Array) -> Loop:
    points = np.where(on_axis[:, None], targets, grid.chart.place(y))
    normals = targets - points
    size = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = np.where(on_axis[:, None], [-1.0, 0.0], normals / np.maximum(size, 1e-300))
    kept = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=-1) > _SAME
    kept &= on_axis | (size[:, 0] > ARRIVED)
    return Loop(points[kept], normals[kept], y[kept], on_axis[kept])


def _refined(grid: Grid, loop: Loop, tolerance: float, job: Job) -> tuple[Loop, bool]:
    """Points put between points, until pieces are straight to the tolerance, or as short as corners are shown."""
    closed = np.zeros(len(loop.points), dtype=bool)  # pieces in which nothing more was found
    for _ in range(_ROUNDS):
        piece = np.roll(loop.points, -1, axis=0) - loop.points
        length = np.linalg.norm(piece, axis=-1)
        ahead = np.roll(loop.normals, -1, axis=0)
        bend = np.linalg.norm(ahead - loop.normals, axis=-1)
        axis = loop.on_axis & np.roll(loop.on_axis, -1)
        wanted = (
            (length * bend / 8 > tolerance)
            | (length > 2 * grid.step)
            | (length * _slant(piece, loop.normals, ahead) > 4 * tolerance)
        )
        todo = np.flatnonzero(wanted & (length > _CORNER) & ~closed & ~axis)
        if not len(todo):
            return loop, True
        if job.late:
            return loop, False
        job.tell("outline of the workspace")
        y, targets, good = _between(grid, loop, todo, piece, length, ahead)
        closed[todo[~good]] = True
        place = todo[good] + 1
        new = _parts(grid, y[good], targets[good])
        loop = Loop(*(np.insert(old, place, extra, axis=0) for old, extra in zip(loop, new, strict=True)))
        closed = np.insert(closed, place, False)
    return loop, True


def _slant(piece: Array, normals: Array, ahead: Array) -> Array:
    """How far normals are from being across their piece."""
    along = piece / np.maximum(np.linalg.norm(piece, axis=-1, keepdims=True), 1e-300)
    return np.abs((along * normals).sum(-1) + (along * ahead).sum(-1))


def _parts(grid: Grid, y: Array, targets: Array) -> tuple[Array, Array, Array, Array]:
    points = grid.chart.place(y)
    normals = targets - points
    normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-300)
    return points, normals, y, np.zeros(len(y), dtype=bool)


def _between(grid: Grid, loop: Loop, todo: Array, piece: Array, length: Array, ahead: Array) -> tuple[Array, Array, Array]:
    """(t, n) postures between the ends of pieces, their (t, 2) targets, and (t) whether they are new places."""
    k = len(loop.points)
    outwards = np.stack([piece[todo, 1], -piece[todo, 0]], -1) / length[todo, None]
    mean = loop.normals[todo] + ahead[todo]
    outwards = np.where((mean * outwards).sum(-1, keepdims=True) < 0, -outwards, outwards)
    middle, y, targets = (
        loop.points[todo] + piece[todo] / 2,
        np.zeros((len(todo), grid.chart.model.n)),
        np.zeros((len(todo), 2)),
    )
    more = np.stack([loop.postures[(todo + by) % k] for by in (-1, 0, 1, 2)], 1)
    left, off = np.arange(len(todo)), np.maximum(0.5 * length[todo], 2e-4)
    for _ in range(4):
        targets[left] = middle[left] + off[left, None] * outwards[left]
        y[left], away = grid.best(targets[left], 2, more[left])
        left = left[away <= 1e3 * ARRIVED]  # the outline bulges beyond the target
        if not len(left):
            break
        off[left] *= 4
    good = _new(grid, loop, todo, piece, y)
    good[left] = False
    rest = np.flatnonzero(~good)  # the tip of a void may lie behind the piece
    inner = middle[rest] - 0.5 * length[todo[rest], None] * outwards[rest]
    found, away = grid.best(inner, STARTS, more[rest]) if len(rest) else (y[rest], np.zeros(0))
    open_ = rest[away > 1e3 * ARRIVED]
    y[open_], targets[open_] = found[away > 1e3 * ARRIVED], inner[away > 1e3 * ARRIVED]
    good[open_] = _new(grid, loop, todo[open_], piece, y[open_])
    return y, targets, good


def _new(grid: Grid, loop: Loop, todo: Array, piece: Array, y: Array) -> Array:
    """(t) whether tips lie between the ends of pieces, and at none of them."""
    points, k = grid.chart.place(y), len(loop.points)
    length = np.linalg.norm(piece[todo], axis=-1)
    ends = [np.linalg.norm(points - loop.points[(todo + by) % k], axis=-1) for by in (0, 1)]
    foot = ((points - loop.points[todo]) * piece[todo]).sum(-1) / length**2
    apart = (np.minimum(*ends) > _SAME) & (np.maximum(*ends) < 4 * length)
    return np.asarray(apart & (foot > 0.01) & (foot < 0.99))
