"""`velocity_polytope`, `force_polytope`: all that the limits of the joints allow, drawn at the tip of an arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..bodies import polytope_body
from ..dexterity import Polytope, force_polytope as force, velocity_polytope as velocity
from ..frames import TIP
from ..model import RobotModel
from ..palette import FORCE
from ..skeleton import Skeleton
from .canvas import Canvas, Flat
from .shapes import begin, clip_length, draw_body, metres_per_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def velocity_polytope(
    model: RobotModel,
    q: Any = None,
    *,
    ax: Any = None,
    at: str = TIP,
    scale: float | None = None,
    velocity_limits: Any = None,
    with_arm: bool = True,
    frames: bool | str = "tip",
    view: tuple[float, float] | None = None,
) -> Axes:
    """All velocities of the tip while no joint is faster than its limit, drawn at the tip in base axes.

    Args:
        model, q, ax, at, scale, with_arm, frames, view: as in `velocity_ellipsoid`.
        velocity_limits: instead of the robot's own, as in `kinestatics.velocity_polytope`.

    Returns:
        The axes.

    Raises:
        As in `velocity_ellipsoid`; ConfigurationError: KS366 where a velocity limit is unknown.

    Law: {J q̇ : l ≤ q̇ ≤ u}, with the linear rows of the Jacobian in base axes.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.velocity_polytope(ks.load("planar_2r"), [0.4, 0.9], velocity_limits=(1, 1))
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['velocity polytope of the joint limits\\n(scale: 1 m = 5 m/s)']
    """
    canvas, bones, values = begin(model, q, ax, at, with_arm, frames, view)
    polytope = velocity(model, values, task=_task(canvas), at=at, velocity_limits=velocity_limits)
    _draw(canvas, bones, polytope, scale, "velocity polytope of the joint limits")
    return canvas.finish()


def force_polytope(
    model: RobotModel,
    q: Any = None,
    *,
    ax: Any = None,
    at: str = TIP,
    scale: float | None = None,
    effort_limits: Any = None,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    with_arm: bool = True,
    frames: bool | str = "tip",
    view: tuple[float, float] | None = None,
) -> Axes:
    """All forces that the tip can push with while no joint needs more than its effort limit, drawn at the tip in base axes.

    The origin of the forces is the tip; with the weight of the arm the polytope does not lie evenly around it. Edges without
    end, along forces that the structure holds, are cut, and dashed lines show that they go on.

    Args:
        model, q, ax, at, with_arm, frames, view: as in `velocity_ellipsoid`.
        scale: metres of the picture per N; default such that a metre stands for a round number of N. The key says it.
        effort_limits, gravity: as in `kinestatics.force_polytope`.

    Returns:
        The axes.

    Raises:
        As in `velocity_ellipsoid`; ConfigurationError: KS366 where an effort limit is unknown; MissingMassError: KS320.

    Law: {f : l ≤ Jᵀ f + τ_gravity ≤ u}.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> ax = ks.plots.force_polytope(arm, [0.4, 0.9], effort_limits=(10, 10), gravity=None)
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['force polytope of the joint limits, without weight\\n(scale: 1 m = 50 N)']
    """
    canvas, bones, values = begin(model, q, ax, at, with_arm, frames, view)
    polytope = force(model, values, task=_task(canvas), at=at, effort_limits=effort_limits, gravity=gravity)
    weight = "" if gravity is not None else ", without weight"
    _draw(canvas, bones, polytope, scale, f"force polytope of the joint limits{weight}")
    return canvas.finish()


def _task(canvas: Canvas) -> str | list[str]:
    """The linear rows: the two of the picture's plane where it is a plane of the base, else all three."""
    if isinstance(canvas, Flat) and np.all((canvas.plane == 0) | (canvas.plane == 1)):
        return [f"v{'xyz'[int(np.argmax(direction))]}" for direction in canvas.plane]
    return "position"


def _draw(canvas: Canvas, bones: Skeleton, polytope: Polytope, scale: float | None, words: str) -> None:
    """A polytope of linear rows at the tip, and its entry in the key."""
    if polytope.is_empty:
        metres_per_unit(scale, 0.0, bones, True)
        canvas.key(f"{words}:\nempty, the arm cannot hold its own weight", color=FORCE, linewidth=1.6)
        return
    corners = np.zeros((0, 3)) if polytope.corners is None else polytope.corners
    largest = float(np.linalg.norm(corners, axis=-1).max(initial=0.0))
    metres = metres_per_unit(scale, largest, bones, polytope.is_bounded)
    body = polytope_body(polytope, clip_length(bones, metres))
    lift = np.eye(3)[["xyz".index(row[-1]) for row in polytope.rows]]
    draw_body(canvas, bones, body, lift, metres, polytope.kind, words)
