"""Names of joints: each beside its joint, off the links and off each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..namespaces import Array

_ANGLES = np.radians([0.0, 180.0, 90.0, 270.0, 30.0, 150.0, 210.0, 330.0, 60.0, 120.0, 240.0, 300.0])
_DISTANCES = (8.0, 13.0, 20.0, 28.0)  # from the joint to the rim of its name [points]


def spread(names: Sequence[tuple[float, float]], joints: Array, lines: Array, room: Array, point: float) -> Array:
    """(k, 2) middles of names, found one after the other: the place with least in its way, near ones first.

    Args:
        names: width and height of each; joints: (k, 2) where they belong; lines: (p, 2) points they should not cover.
        room: (2, 2) corners of the paper they should stay in; point: the length of a point. All in pixels.
    """
    placed: list[Array] = []  # corners (2, 2)
    middles = []
    occupied = np.concatenate([lines.reshape(-1, 2), joints])
    for (width, height), joint in zip(names, joints, strict=True):
        half = 0.5 * np.array([width, height])
        best, least = joint, np.inf
        for step, distance in enumerate(_DISTANCES):
            for order, angle in enumerate(_ANGLES):
                u = np.array([np.cos(angle), np.sin(angle)])
                middle = joint + u * (distance * point + half)
                cost = _in_the_way(np.array([middle - half, middle + half]), placed, occupied, room)
                cost += 1.5 * step + 0.01 * order
                if cost < least:
                    best, least = middle, cost
        middles.append(best)
        placed.append(np.array([best - half, best + half]))
    return np.array(middles).reshape(-1, 2)


def _in_the_way(box: Array, placed: Sequence[Array], occupied: Array, room: Array) -> float:
    """How much lies under a box: other names by their share of it, points of the arm by number, paper that is not there."""
    area = float(np.prod(box[1] - box[0])) or 1.0
    shared = sum(float(np.prod(np.maximum(np.minimum(box[1], o[1]) - np.maximum(box[0], o[0]), 0.0))) for o in placed)
    covered = int(np.all((occupied > box[0]) & (occupied < box[1]), axis=1).sum())
    outside = float(np.maximum(room[0] - box[0], 0.0).max() + np.maximum(box[1] - room[1], 0.0).max())
    return 40.0 * shared / area + covered + outside


def between(lines: Sequence[Array], count: int = 24) -> Array:
    """(p, k) points along lines of two ends each."""
    steps = np.linspace(0.0, 1.0, count)[:, None]
    return np.concatenate([a + steps * (b - a) for a, b in lines]) if lines else np.zeros((0, 3))


def place_names(ax: Any, texts: Sequence[Any], joints: Array, lines: Array) -> list[tuple[float, float]]:
    """How far [points] to move each text from its joint; joints (k, 2) and points of lines (p, 2) in data coordinates."""
    point = ax.figure.dpi / 72
    boxes = [text.get_window_extent() for text in texts]
    sizes = [(float(box.width), float(box.height)) for box in boxes]
    on_paper = ax.transData.transform
    room = np.array(ax.figure.bbox.extents).reshape(2, 2)
    anchors = on_paper(joints)
    middles = spread(sizes, anchors, on_paper(lines) if len(lines) else lines.reshape(-1, 2), room, point)
    return [(float(x), float(y)) for x, y in (middles - anchors) / point]
