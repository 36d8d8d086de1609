"""What the pictures of velocities and forces share: the arm below them, their scale, and how a body is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..bodies import Body
from ..errors import ConfigurationError
from ..model import RobotModel
from ..namespaces import Array
from ..palette import FORCE, VELOCITY
from ..skeleton import Skeleton, one_configuration, skeleton
from .arm import check_frames, draw_arm
from .axes import canvas_for
from .canvas import BODY, Canvas
from .style import round_number, with_unit

_SHOWN, _SHOWN_BESIDE = 0.33, 0.2
"""Length at which the farthest point is drawn, as a share of the arm's size; and beside a direction without end."""
_COARSE = 4  # of the points of a curve: enough to keep words off it
_CUT = 0.3
"""Length at which a direction without end is cut, as a share of the arm's size."""


def begin(
    model: RobotModel, q: Any, ax: Any, at: str, with_arm: bool, frames: bool | str, view: tuple[float, float] | None
) -> tuple[Canvas, Skeleton, Array]:
    """The canvas with the arm on it, the arm's points, and q."""
    values = one_configuration(model, q)
    bones = skeleton(model, values, at, required=True)
    check_frames(frames)
    canvas = canvas_for(model, ax, view)
    if with_arm:
        draw_arm(canvas, bones, frames)
    return canvas, bones, values


def clip_length(bones: Skeleton, metres: float) -> float:
    """Where a direction without end is cut, in the unit of the body."""
    return _CUT * bones.size / metres


def metres_per_unit(scale: Any, largest: float, bones: Skeleton, bounded: bool) -> float:
    """Metres of the picture per unit of the body; a round number of units per metre where none is asked for.

    Raises:
        ConfigurationError: KS382.
    """
    if scale is None:
        length = (_SHOWN if bounded else _SHOWN_BESIDE) * bones.size
        return 1.0 / round_number(largest / length) if largest > 0 else 1.0
    try:
        value = float(scale)
    except (TypeError, ValueError):
        value = np.nan
    if not 0 < value < np.inf:
        hint = "metres of the picture per m/s, or per N: a positive number"
        raise ConfigurationError("KS382", f"scale is {scale!r}", hint)
    return value


def draw_body(canvas: Canvas, bones: Skeleton, body: Body, lift: Array, metres: float, kind: str, words: str) -> None:
    """A body of velocities or forces with its origin at the tip, `metres` per unit; lift (k, 3): its axes in base axes."""
    color, unit = (VELOCITY, "m/s") if kind == "velocity" else (FORCE, "N")

    def placed(points: Array) -> Array:
        return bones.tip_point + metres * points @ lift

    canvas.hold(placed(body.points))
    canvas.solid(placed(body.points), BODY, facecolor=color, edgecolor=color, alpha=0.13, linewidth=0.0)
    if body.faces:
        canvas.faces([placed(face) for face in body.faces], BODY, facecolor="none", edgecolor=color, linewidth=0.8)
    canvas.lines([placed(line) for line in body.lines], BODY, color=color, linewidth=0.9)
    canvas.avoided += [placed(line[:: _COARSE if len(line) > 2 else 1]) for line in (*body.lines, *body.faces)]
    for line in body.fading:
        start, end = placed(line)
        canvas.lines([np.array([start, end])], BODY, color=color, linewidth=0.9, linestyle=(0, (2.0, 1.6)))
        canvas.arrow(start, end, BODY, width=0.0, head=4.5, color=color)
        canvas.hold(np.array([start, end]))
    if body.fading or np.ptp(body.points, axis=0).any():
        goes_on = "; dashed: without end" if body.fading else ""
        words += f"\n(scale: 1 m = {with_unit(1 / metres, unit)}{goes_on})"
    else:
        words += "\n(a point: nothing is possible)"
    canvas.key(words, color=color, linewidth=1.6)
