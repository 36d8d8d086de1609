"""Outlines on paper: convex hulls and arrows. Imports no drawing library."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..namespaces import Array


def hull(points: Array) -> Array:
    """The corners of the convex hull of points in the plane (k, 2), anticlockwise (Andrew's monotone chain)."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)

    def half(candidates: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in candidates:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))


def arrow_outline(start: Array, end: Array, width: float, head: float) -> Array:
    """(7, 2) outline of an arrow in the plane. A head longer than the arrow is made shorter; one without shaft is kept."""
    along = end - start
    length = float(np.hypot(*along)) or 1.0
    head = min(head, 0.8 * length) if width else head
    u = along / length
    n = np.array([-u[1], u[0]])
    neck = end - head * u
    half, wing = 0.5 * width * n, 0.36 * head * n
    return np.array([start + half, neck + half, neck + wing, end, neck - wing, neck - half, start - half])
