"""Names of joints: each beside its joint, those at one place as one; off the arm, off each other and on the paper."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..namespaces import Array
from .boxes import LEADER, Surroundings, Wanted, boxes_about, leaders_to, spread
from .layout import box_of, fixed_boxes, room_of

_ONE_PLACE = 5.0  # joints closer than this on paper [points] have one name
_LONGEST = 18  # letters of names that stand side by side


def merged(words: Sequence[str]) -> str:
    """One name for joints at one place: "joint4-6", "joint4, 6"; names that do not count are listed.

    Example:
        >>> merged(["joint4", "joint5", "joint6"]), merged(["arm_joint5", "arm_joint6"]), merged(["pan", "lift"])
        ('joint4\N{EN DASH}6', 'arm_joint5, 6', 'pan, lift')
    """
    words = list(dict.fromkeys(words))
    counted = [re.fullmatch(r"(.*?)(\d+)", word, flags=re.DOTALL) for word in words]
    prefixes = {match[1] for match in counted if match}
    if len(words) > 1 and len(prefixes) == 1 and all(counted):
        return prefixes.pop() + _numbers([match[2] for match in counted if match])
    return (", " if sum(map(len, words)) <= _LONGEST else ",\n").join(words)


def _numbers(digits: Sequence[str]) -> str:
    """Numbers in words: three and more that follow each other as a range."""
    runs: list[list[str]] = []
    for number in digits:
        if runs and int(number) == int(runs[-1][-1]) + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{run[0]}\N{EN DASH}{run[-1]}" if len(run) > 2 else ", ".join(run) for run in runs)


def places(points: Array, near: float) -> list[list[int]]:
    """Points (k, 2) by place: each joins the first place whose first point is near, else begins one."""
    found: list[list[int]] = []
    for k, point in enumerate(points):
        for place in found:
            if float(np.hypot(*(points[place[0]] - point))) <= near:
                place.append(k)
                break
        else:
            found.append([k])
    return found


def place_names(
    ax: Any, place: Any, names: Sequence[Any], joints: Array, letters: Sequence[Any], ends: Array, segments: Array
) -> tuple[list[tuple[int, Array, Array | None]], list[Array]]:
    """Finds places for names and letters, once axes have theirs; names at one place become one, the others are removed.

    Args:
        ax, place: the axes. names, letters: their texts. joints, ends: (k, 2) where they belong, in data coordinates.
        segments: (s, 2, 2) the lines of the arm, in data coordinates.

    Returns:
        For every name that is left its number, how far to move it [points], and how far its leader line goes, or None;
        for every letter how far to move it.
    """
    point, on_paper = ax.figure.dpi / 72, ax.transData.transform
    anchors, tips = on_paper(joints.reshape(-1, 2)), on_paper(ends.reshape(-1, 2))
    groups = places(anchors, _ONE_PLACE * point)
    for group in groups:
        names[group[0]].set_text(merged([names[k].get_text() for k in group]))
        for k in group[1:]:
            names[k].remove()
    kept = [names[group[0]] for group in groups]
    middles = [anchors[group[0]] for group in groups]
    wanted = [Wanted(_size(ax, text), end, True) for text, end in zip(letters, tips, strict=True)]
    wanted += [Wanted(_size(ax, text), middle) for text, middle in zip(kept, middles, strict=True)]
    boxes = fixed_boxes(ax, {*letters, *kept})
    lines = on_paper(segments.reshape(-1, 2)).reshape(-1, 2, 2)
    found = spread(wanted, Surroundings(boxes, lines, room_of(ax, place), point))
    moves = [(middle - word.anchor) / point for middle, word in zip(found, wanted, strict=True)]
    result = []
    for group, word, middle, move in zip(groups, wanted[len(tips) :], found[len(tips) :], moves[len(tips) :], strict=True):
        start, end = leaders_to(word.anchor, boxes_about(middle, word.size)[None])[0]
        leader = (end - start) / point
        result.append((group[0], move, leader if float(np.hypot(*leader)) > LEADER else None))
    return result, moves[: len(tips)]


def _size(ax: Any, text: Any) -> Array:
    box = box_of(ax, text)
    return np.array([box.width, box.height])
