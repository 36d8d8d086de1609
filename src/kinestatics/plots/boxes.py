"""Where words go on paper: boxes beside their points, off each other, off the arm and inside the room. No matplotlib.

All lengths are pixels, all boxes (2, 2) corners, lower left first. Every place that is tried has a cost, and the least is
taken: the same picture every time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..namespaces import Array

LEADER = 15.0
"""A word farther than this from its point [points] has a leader line."""
_ANGLES = np.radians([0, 180, 90, 270, 30, 150, 210, 330, 60, 120, 240, 300, 15, 165, 195, 345, 75, 105, 255, 285])
_GAPS = (8.0, 11.0, 14.0, 18.0, 23.0, 30.0, 39.0, 50.0, 63.0, 78.0)  # from a point to the rim of its word [points]
_LETTER_GAPS = (4.0, 7.0, 10.0, 14.0, 19.0)  # from where a letter would be to where there is room for it [points]
_GRID, _PASSES, _RIM = 6.0, 3, 1.2  # of the places all over the room [points]; at most; white around words [points]
_CLEAR = 0.8  # white between words and the arm [points]
_ON_ARM, _CROSSED = 8.0, 60.0  # what words on the arm cost at least; a leader line and words that cross
_READABLE = 5.0  # length of lines [points] beyond which a letter on them is no worse
_BAD = 1000.0  # what words on each other, or off the paper, cost at least


@dataclass(frozen=True, eq=False)
class Wanted:
    """Words that look for a place: their size (2), the point (2) they belong to; a letter may lie on its point."""

    size: Array
    anchor: Array
    is_letter: bool = False


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What words must not lie on (boxes (b, 2, 2)), should not (segments (s, 2, 2)), the room (2, 2), a point in pixels."""

    boxes: Array
    segments: Array
    room: Array
    point: float


@dataclass(frozen=True, eq=False)
class _Places:
    """Places for a word: boxes (c, 2, 2), lines to them (c, 2, 2), and what each costs before other words are placed (c)."""

    boxes: Array
    leaders: Array
    costs: Array


class _Choice:
    """The places a word may have: near its point, and when they are asked for, all over the room."""

    def __init__(self, word: Wanted, others: Sequence[Wanted], around: Surroundings) -> None:
        self.word, self.others, self.around = word, others, around
        self.near = _places(word, _near(word, around.point), others, around)
        self.enough = _BAD if word.is_letter else 2.5 * _ON_ARM

    @cached_property
    def anywhere(self) -> _Places:
        return _places(self.word, _anywhere(self.word, self.around), self.others, self.around)

    def best(self, placed: Sequence[tuple[Wanted, Array]]) -> tuple[Array, float]:
        """The box (2, 2) that costs least among those of other words, and what: anywhere where nothing near is good."""
        box, cost = _least(self.near, self.word, placed, self.around.point)
        if cost <= self.enough:
            return box, cost
        return min((box, cost), _least(self.anywhere, self.word, placed, self.around.point), key=lambda found: found[1])


def spread(wanted: Sequence[Wanted], around: Surroundings) -> Array:
    """(k, 2) middles of words. Where not all find good places, other words are let choose first, and the best is kept."""
    choices = [_Choice(word, [w for w in wanted if w is not word], around) for word in wanted]
    anchors = np.array([word.anchor for word in wanted]).reshape(-1, 2)
    first = np.arange(len(wanted))
    best, least = np.zeros((0, 2, 2)), np.inf
    for order in (first, first[::-1], np.lexsort(anchors.T), np.lexsort(-anchors.T)):
        boxes, costs = _settled(choices, order)
        if costs.sum() < least:
            best, least = boxes, float(costs.sum())
        if costs.max(initial=0.0) <= 3.0 * _ON_ARM:
            break
    return np.asarray(best.mean(axis=1))


def _settled(choices: Sequence[_Choice], order: Array) -> tuple[Array, Array]:
    """Boxes (k, 2, 2) and costs (k) of words that are placed in an order and then again, each among all the others."""
    boxes: dict[int, Array] = {}
    costs = np.zeros(len(choices))
    for _ in range(_PASSES):
        moved = False
        for k in order.tolist():
            best, costs[k] = choices[k].best([(choices[j].word, box) for j, box in boxes.items() if j != k])
            moved = moved or k not in boxes or not np.array_equal(best, boxes[k])
            boxes[k] = best
        if not moved:
            break
    return np.array([boxes[k] for k in range(len(choices))]).reshape(-1, 2, 2), costs


def _near(word: Wanted, point: float) -> Array:
    """(c, 2) middles around the point of a word, the better ones first."""
    turns = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
    if word.is_letter:
        steps = np.array(_LETTER_GAPS)[:, None, None] * point * turns
        return word.anchor + np.concatenate([np.zeros((1, 2)), steps.reshape(-1, 2)])
    reach = np.array(_GAPS)[:, None, None] * point * turns + 0.5 * word.size * turns
    return (word.anchor + reach).reshape(-1, 2)


def _anywhere(word: Wanted, around: Surroundings) -> Array:
    """(c, 2) middles all over the room."""
    lower, upper = around.room[0] + 0.5 * word.size, around.room[1] - 0.5 * word.size
    steps = [np.arange(a, max(a, b) + 1e-9, _GRID * around.point) for a, b in zip(lower, upper, strict=True)]
    return np.stack(np.meshgrid(*steps, indexing="ij"), -1).reshape(-1, 2)


def _places(word: Wanted, middles: Array, others: Sequence[Wanted], around: Surroundings) -> _Places:
    """Places with their costs: what lies under them, how far they are, whether they seem to belong to another point."""
    boxes = boxes_about(middles, word.size)
    leaders = leaders_to(word.anchor, boxes)
    outside = np.maximum(around.room[0] - boxes[:, 0], 0.0).max(1) + np.maximum(boxes[:, 1] - around.room[1], 0.0).max(1)
    wide = boxes + _CLEAR * around.point * np.array([[-1.0], [1.0]])
    on_arm = lengths_inside(wide, around.segments).sum(1) / around.point
    if word.is_letter:
        on_arm = np.minimum(on_arm, _READABLE)  # better on a line than far from its arrow
    costs = _on_words(boxes, around.boxes, around.point) + np.where(outside > 0, _BAD + outside, 0.0)
    costs += np.where(on_arm > 0, _ON_ARM + on_arm, 0.0)
    points = np.array([w.anchor for w in others if w.is_letter or not word.is_letter]).reshape(-1, 2)
    if word.is_letter:
        moved = np.linalg.norm(middles - word.anchor, axis=1) / around.point
        return _Places(boxes, leaders, costs + 1.2 * moved + 3.0 * _confusion(boxes, moved, points, around.point))
    far = np.linalg.norm(leaders[:, 1] - leaders[:, 0], axis=1) / around.point
    costs += 0.6 * far + 1e-3 * (np.arange(len(costs)) % len(_ANGLES))
    crossed = np.sum(lengths_inside(around.boxes, leaders) > 0, axis=0)
    costs += np.where(far > LEADER, 5.0 + _CROSSED * crossed, _confusion(boxes, far, points, around.point))
    return _Places(boxes, leaders, costs)


def _least(places: _Places, word: Wanted, placed: Sequence[tuple[Wanted, Array]], point: float) -> tuple[Array, float]:
    """The box that costs least, and what, with the words that are placed and what leader lines cross."""
    taken = np.array([box for _, box in placed]).reshape(-1, 2, 2)
    costs = places.costs + _on_words(places.boxes, taken, point)
    lines = np.array([leaders_to(w.anchor, box[None])[0] for w, box in placed if not w.is_letter]).reshape(-1, 2, 2)
    led = lines[_lengths(lines) > LEADER * point]
    costs += _CROSSED * np.sum(lengths_inside(places.boxes, led) > 0, axis=1)
    if not word.is_letter:
        crossed = np.sum(lengths_inside(taken, places.leaders) > 0, axis=0) + 0.5 * _crossings(places.leaders, lines)
        costs += np.where(_lengths(places.leaders) > LEADER * point, _CROSSED * crossed, 0.0)
    k = int(np.argmin(costs))
    return places.boxes[k], float(costs[k])


def _lengths(segments: Array) -> Array:
    return np.asarray(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1))


def _on_words(boxes: Array, others: Array, point: float) -> Array:
    """(c) what it costs to lie on other words."""
    shared = _shared(boxes, others, _RIM * point)
    return np.where(shared > 0, _BAD * (1 + shared), 0.0)


def boxes_about(middles: Array, size: Array) -> Array:
    """(..., 2, 2) corners of boxes of one size about their middles (..., 2)."""
    return np.stack([middles - 0.5 * size, middles + 0.5 * size], -2)


def leaders_to(anchor: Array, boxes: Array) -> Array:
    """(c, 2, 2) from a point (2) to the nearest point of each box."""
    ends = np.clip(anchor, boxes[:, 0], boxes[:, 1])
    return np.stack([np.broadcast_to(anchor, ends.shape), ends], -2)


def _confusion(boxes: Array, far: Array, others: Array, point: float) -> Array:
    """(c) what it costs that a word without a leader line lies nearer to the point of another."""
    if not len(others):
        return np.zeros(len(boxes))
    ends = np.clip(others, boxes[:, :1], boxes[:, 1:])
    nearest = np.linalg.norm(ends - others, axis=2).min(1) / point
    return np.where(nearest < far + 2.0, 6.0, 0.0)


def _shared(boxes: Array, others: Array, rim: float) -> Array:
    """(c) the share of each box that lies on others, which have a rim."""
    lower = np.maximum(boxes[:, None, 0], others[:, 0] - rim)
    upper = np.minimum(boxes[:, None, 1], others[:, 1] + rim)
    area = np.prod(boxes[:, 1] - boxes[:, 0], axis=1)
    return np.asarray(np.prod(np.maximum(upper - lower, 0.0), axis=2).sum(1) / np.maximum(area, 1e-9))


def lengths_inside(boxes: Array, segments: Array) -> Array:
    """(c, s) the length of each segment (s, 2, 2) that lies in each box (c, 2, 2) (Liang and Barsky's clipping)."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    along = np.where(np.abs(along) < 1e-9, 1e-9, along)
    first = (boxes[:, None, 0] - start) / along
    second = (boxes[:, None, 1] - start) / along
    enters = np.minimum(first, second).max(2, initial=0.0)
    leaves = np.maximum(first, second).min(2, initial=1.0)
    return np.asarray(np.maximum(leaves - enters, 0.0) * np.linalg.norm(along, axis=1))


def _crossings(lines: Array, others: Array) -> Array:
    """(c) how many of the other segments (k, 2, 2) each segment (c, 2, 2) crosses."""

    def side(a: Array, b: Array, p: Array) -> Array:
        return np.sign((b - a)[..., 0] * (p - a)[..., 1] - (b - a)[..., 1] * (p - a)[..., 0])

    a, b = lines[:, None, 0], lines[:, None, 1]
    c, d = others[None, :, 0], others[None, :, 1]
    apart = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return np.asarray(apart.sum(1))
