"""Arrows for forces and translations, circular arrows for couples and rotations, on either canvas."""

from __future__ import annotations

import numpy as np

from ..namespaces import Array
from .arm import across
from .canvas import SIGN, TOP, Canvas, Flat

_TURN = np.radians(np.linspace(20.0, 310.0, 59))
_HEAD = 6.0  # points


def double_arrow(canvas: Canvas, middle: Array, along: Array, color: str, dashed: bool = False) -> None:
    """A line through a point with a head at either end: what may be of either sign. `along` is half of it."""
    ends = np.array([middle - along, middle + along])
    style = (0, (2.6, 1.6)) if dashed else "-"
    canvas.hold(ends)
    if isinstance(canvas, Flat) and _is_normal(canvas, along):
        canvas.towards(middle, True, TOP, color)
        return
    inner = np.array([middle - 0.95 * along, middle + 0.95 * along])
    canvas.lines([inner], SIGN, color=color, linewidth=1.3, linestyle=style)
    for start, end in (ends, ends[::-1]):
        canvas.arrow(start, end, TOP, width=0.0, head=_HEAD, color=color)


def turning_arrow(canvas: Canvas, center: Array, direction: Array, radius: float, color: str, dashed: bool = False) -> Array:
    """A circular arrow about a direction, by the right hand; returns the point half way along it.

    In the plane, a turning about an axis that lies in it is an arrow along the axis with two heads.
    """
    style = (0, (2.6, 1.6)) if dashed else "-"
    first, second = across(direction)
    if isinstance(canvas, Flat):
        if not _is_normal(canvas, direction):
            end = center + 2 * radius * direction
            for tip in (end, center + 1.6 * radius * direction):
                canvas.arrow(center, tip, TOP, width=1.3, head=_HEAD, color=color)
            canvas.hold(end)
            return center + radius * direction
        first = canvas.plane[0]
        second = np.cross(direction, first)
    arc = center + radius * (np.cos(_TURN)[:, None] * first + np.sin(_TURN)[:, None] * second)
    canvas.hold(arc)
    canvas.lines([arc[:-2]], SIGN, color=color, linewidth=1.3, linestyle=style)
    canvas.arrow(arc[-6], arc[-1], TOP, width=0.0, head=_HEAD, color=color)
    return arc[len(arc) // 2]


def _is_normal(canvas: Flat, direction: Array) -> bool:
    """Whether a direction is at right angles to the paper."""
    return abs(float(direction @ canvas.normal)) > 0.999 * float(np.linalg.norm(direction))
