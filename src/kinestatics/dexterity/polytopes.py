"""Velocity and force polytopes: all that an arm can do, and all that it can push, within the limits of its joints.

Ellipsoids say it for unit sums of squares; these say it for the limits themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP, Frame
from ..kinematics import configuration, jacobian, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..quantities import Jacobian, numeric
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, ROW_NAMES, WRENCH_NAMES
from ..statics import gravity_torques, missing_masses
from ..statics.limits import Limits, joint_limits
from ..tasks import characteristic_length, task_of, without_rounding
from .polytope import Polytope
from .rows import TaskName, row_weights
from .shapes import image_of_box, let_through


def velocity_polytope(
    model: RobotModel,
    q: Any,
    *,
    task: TaskName = "auto",
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    velocity_limits: Limits = None,
) -> Polytope:
    """All velocities that a link can have while no joint turns or slides faster than its limit.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m].
        task: the rows looked at, as in `find_task`: up to six. "auto" takes the arm's own rows, but of these the linear ones
            alone where they mix metres and radians. The rows taken are in the result.
        at, point, frame: as in `jacobian`.
        velocity_limits: (n) instead of the robot's own, the same both ways; or (lower, upper), (n) each; or {joint: limit}
            for some of the joints [rad/s, m/s for a sliding joint].

    Returns:
        Polytope [m/s, or rad/s for angular rows], a zonotope; with corners and faces for up to three rows. Flat where a
        direction of motion is lost.

    Raises:
        ConfigurationError: KS366, a joint that moves the link has no velocity limit; KS368, no row moves; KS301, KS303.
        UnknownNameError: KS310, KS311, KS313, KS318. ArrayTypeError: KS302.

    Law: {J q̇ : l <= q̇ <= u}. Source: Yoshikawa, "Foundations of Robotics" (1990), section 4.4; Gouttefarde, Krut (2010).

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("ur5e")
        >>> polytope = ks.velocity_polytope(arm, [0, -1, 1.5, -0.5, 1.2, 0])
        >>> polytope.rows, polytope.unit, len(polytope.vertices)
        (('vx', 'vy', 'vz'), 'm/s', 20)
        >>> bool(polytope.contains([0.1, 0.2, 0.3]))
        True
    """
    J, array = _one_jacobian(model, q, at, point, frame)
    rows = _rows_of(J, task)
    lower, upper = joint_limits(model, velocity_limits, "velocity").of_carrying(model, array)
    labels = _labels(model, J, rows, ROW_NAMES, ("m/s", "rad/s"))
    return image_of_box(array[list(rows)], lower, upper, unit_weights(model, rows, at), kind="velocity", **labels)


def force_polytope(
    model: RobotModel,
    q: Any,
    *,
    task: TaskName = "auto",
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    effort_limits: Limits = None,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
) -> Polytope:
    """All forces that a link can exert on its surroundings, at rest, while no joint needs more than its effort limit.

    The other components of the wrench are zero: a force without a moment about the origin of the frame. A redundant arm has
    no choice of torques: at rest all n of them are those of the force, τ = Jᵀ f + τ_gravity, and each must be within its
    limits; other torques of the same force would set its spare joints moving.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m].
        task: the rows looked at, as in `velocity_polytope`; "vx" stands for fx, "wx" for the moment mx.
        at, point, frame: as in `jacobian`.
        effort_limits: (n) instead of the robot's own, the same both ways; or (lower, upper), (n) each; or {joint: limit} for
            some of the joints [N m, N for a sliding joint]. Infinite: this joint sets no limit.
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.

    Returns:
        Polytope [N, or N m for moments]. Unbounded where the structure holds a force and no joint feels it (a straight leg);
        empty where no push at all would let the arm hold itself.

    Raises:
        ConfigurationError: KS366, a joint that moves the link has no effort limit; KS368, no row moves; KS301, KS303.
        MissingMassError: KS320. UnknownNameError: KS310, KS311, KS313, KS318. ArrayTypeError: KS302.

    Law: {f : l <= Jᵀ f + τ_gravity <= u}; for symmetric limits and no weight the polar set of the hull of ±J_i / u_i.
    Source: Chiacchio, Bouffard-Vercelli, Pierrot, "Force polytope and force ellipsoid for redundant manipulators", J. of
    Robotic Systems 14(8), 1997; note 004, "standing with bent legs".

    Example:
        >>> import kinestatics as ks
        >>> leg = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
        >>> bent = ks.force_polytope(leg, [0.7854, 1.5708], gravity=None, effort_limits=(250, 250))
        >>> round(bent.extent([0, 1])), bent.limiting_facet([0, 1])
        (822, ('joint2 at its lower limit',))
        >>> straight = ks.force_polytope(leg, [1.5707963267948966, 0], gravity=None, effort_limits=(250, 250))
        >>> straight.is_bounded, float(straight.extent([0, 1]))
        (False, inf)
    """
    J, array = _one_jacobian(model, q, at, point, frame)
    rows = _rows_of(J, task)
    limits = joint_limits(model, effort_limits, "effort")
    limits.require(model, np.any(array != 0, axis=0) & ~limits.given)
    held = np.zeros(model.n)
    if gravity is not None:
        if not model.has_masses:
            raise missing_masses(model, "its description gives none; gravity=None leaves the weight of the arm out")
        held = gravity_torques(model, numeric(as_array(q)[0]), gravity=gravity)
    labels = _labels(model, J, rows, WRENCH_NAMES, ("N", "N m"))
    notes = ("the weight of the arm is left out",) if gravity is None else ()
    lower, upper = limits.lower - held, limits.upper - held
    return let_through(array[list(rows)].T, lower, upper, unit_weights(model, rows, at), kind="force", notes=notes, **labels)


def _one_jacobian(
    model: RobotModel, q: Any, at: str, point: Sequence[float] | None, frame: Frame | None
) -> tuple[Jacobian, Array]:
    J, array = numeric_jacobian(model, q, at, point, frame)
    if array.ndim > 2:
        raise ConfigurationError("KS303", f"q is a batch of shape {array.shape[:-2]}", "one configuration at a time")
    return J, array


def numeric_jacobian(
    model: RobotModel, q: Any, at: str, point: Sequence[float] | None, frame: Frame | None, check_finite: bool = True
) -> tuple[Jacobian, Array]:
    """The Jacobian at numbers of any library, and its NumPy array (..., 6, n) without rounding.

    Raises:
        ArrayTypeError: KS302 for symbols. Others as in `jacobian`.
    """
    require_model(model)
    array, xp = configuration(model, q, check_finite)
    if xp.name == "sympy":
        raise ArrayTypeError("KS302", "limits are compared with numbers; q holds symbols", "put numbers in place of them")
    values = numeric(array).astype(np.float64)
    J = jacobian(model, values, at=at, point=point, frame=frame, check_finite=False)
    return J, without_rounding(model, J.array)


def _rows_of(J: Jacobian, task: TaskName) -> tuple[int, ...]:
    """The rows looked at; those of the arm's own task that have one unit, linear before angular, for "auto".

    Raises:
        ConfigurationError: KS368. UnknownNameError: KS318.
    """
    rows = task_of(J, task).rows
    if isinstance(task, str) and task == "auto":
        rows = tuple(row for row in rows if row in LINEAR_ROWS) or rows
    if not rows:
        raise ConfigurationError("KS368", f"no joint moves {J.link!r}: there is nothing to show", "choose another link: at=")
    return rows


def _labels(
    model: RobotModel, J: Jacobian, rows: Sequence[int], names: Sequence[str], units: tuple[str, str]
) -> dict[str, Any]:
    """What a polytope is told of its coordinates."""
    used = dict.fromkeys(units[row in ANGULAR_ROWS] for row in rows)
    named = {"rows": tuple(names[row] for row in rows), "unit": ", ".join(used), "joints": model.joint_names}
    return named | {"frame": J.frame, "link": J.link, "robot": model.name}


def unit_weights(model: RobotModel, rows: Sequence[int], at: str) -> Array:
    """(k) what makes angular rows comparable with linear ones where the rank is judged."""
    mixed = any(row in LINEAR_ROWS for row in rows) and any(row in ANGULAR_ROWS for row in rows)
    return row_weights(rows, characteristic_length(model, at) if mixed else 1.0)
