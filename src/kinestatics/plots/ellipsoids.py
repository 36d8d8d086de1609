"""`velocity_ellipsoid`, `force_ellipsoid`: what unit joint speeds and torques amount to, drawn at the tip of an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bodies import ellipsoid_body
from ..dexterity import Ellipsoid, force_ellipsoid as force, velocity_ellipsoid as velocity
from ..frames import TIP
from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..skeleton import Skeleton
from ..spatial import LINEAR
from ..tasks import without_rounding
from .canvas import Canvas, Flat
from .shapes import begin, clip_length, draw_body, metres_per_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def velocity_ellipsoid(
    model: RobotModel,
    q: Any = None,
    *,
    ax: Any = None,
    at: str = TIP,
    scale: float | None = None,
    joint_scale: Any = None,
    with_arm: bool = True,
    frames: bool | str = "tip",
    view: tuple[float, float] | None = None,
) -> Axes:
    """The velocities of the tip at joint speeds within the unit ball, drawn at the tip in base axes.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        ax, at, frames, view: as in `arm`.
        scale: metres of the picture per m/s; default such that a metre stands for a round number of m/s. The key says it.
        joint_scale: (n) speeds of the joints instead of 1 rad/s and 1 m/s, as in `kinestatics.velocity_ellipsoid`.
        with_arm: whether the arm is drawn too; False to add an ellipsoid to a picture of it.

    Returns:
        The axes.

    Raises:
        As in `arm`; ConfigurationError: KS382 for a scale, KS362 for joint_scale; UnknownNameError: KS311 without a tip.

    Law: {J q̇ : |q̇| ≤ 1}, with the linear rows of the Jacobian in base axes: half-axes are singular values times the left
    singular vectors. Source: Yoshikawa, IJRR 4(2), 1985; note 000.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.velocity_ellipsoid(ks.load("planar_2r"), [0.4, 0.9])
        >>> ax.get_legend().get_texts()[0].get_text().splitlines()[1]
        '(scale: 1 m = 2 m/s)'
    """
    canvas, bones, values = begin(model, q, ax, at, with_arm, frames, view)
    ellipsoid = velocity(_rows(canvas, model, values, at), joint_scale=joint_scale)
    _draw(canvas, bones, ellipsoid, scale, f"velocity ellipsoid{_ball(model, joint_scale, 'velocity')}")
    return canvas.finish()


def force_ellipsoid(
    model: RobotModel,
    q: Any = None,
    *,
    ax: Any = None,
    at: str = TIP,
    scale: float | None = None,
    joint_scale: Any = None,
    with_arm: bool = True,
    frames: bool | str = "tip",
    view: tuple[float, float] | None = None,
) -> Axes:
    """The forces that the tip holds at joint torques within the unit ball, drawn at the tip in base axes.

    Where a direction is held by the structure, and costs no torque, the ellipsoid has no end: it is cut, and dashed lines
    show that it goes on.

    Args:
        model, q, ax, at, with_arm, frames, view: as in `velocity_ellipsoid`.
        scale: metres of the picture per N; default such that a metre stands for a round number of N. The key says it.
        joint_scale: (n) torques of the joints instead of 1 N m and 1 N, as in `kinestatics.force_ellipsoid`.

    Returns:
        The axes.

    Raises: as in `velocity_ellipsoid`.

    Law: {f : |Jᵀ f| ≤ 1}: the axes of the velocity ellipsoid, and the reciprocals of its radii.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.force_ellipsoid(ks.load("planar_2r"), [0.4, 0.0])
        >>> ax.get_legend().get_texts()[0].get_text().splitlines()[1]
        '(scale: 1 m = 1 N; dashed: without end)'
    """
    canvas, bones, values = begin(model, q, ax, at, with_arm, frames, view)
    ellipsoid = force(_rows(canvas, model, values, at), joint_scale=joint_scale)
    _draw(canvas, bones, ellipsoid, scale, f"force ellipsoid{_ball(model, joint_scale, 'force')}")
    return canvas.finish()


def _rows(canvas: Canvas, model: RobotModel, q: Array, at: str) -> Array:
    """The linear rows of the Jacobian (k, n): along the picture's axes in the plane, in base axes in space."""
    linear = without_rounding(model, jacobian(model, q, at=at).array)[LINEAR]
    return canvas.plane @ linear if isinstance(canvas, Flat) else linear


def _ball(model: RobotModel, joint_scale: Any, kind: str) -> str:
    """What bounds the joints, in words."""
    if joint_scale is not None:
        return ", scaled joints"
    symbol, turning, sliding = (r"\dot q", "rad/s", "m/s") if kind == "velocity" else (r"\tau", "N m", "N")
    units = sorted({sliding if joint == "prismatic" else turning for joint in model.joint_kinds}, reverse=True)
    return rf", $|{symbol}| \leq 1$ {', '.join(units)}".rstrip()


def _draw(canvas: Canvas, bones: Skeleton, ellipsoid: Ellipsoid, scale: float | None, words: str) -> None:
    """An ellipsoid of linear rows at the tip, and its entry in the key."""
    radii = ellipsoid.radii
    finite = radii[np.isfinite(radii)]
    metres = metres_per_unit(scale, float(finite.max(initial=0.0)), bones, len(finite) == len(radii))
    body = ellipsoid_body(ellipsoid.axes, radii, clip_length(bones, metres))
    lift = canvas.plane if isinstance(canvas, Flat) else np.eye(3)
    draw_body(canvas, bones, body, lift, metres, ellipsoid.kind, words)
