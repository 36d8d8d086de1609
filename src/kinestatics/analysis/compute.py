"""`analyze`: asks the floors below every question, and puts the answers together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP, Frame
from ..kinematics import configuration, jacobian, pose, require_model
from ..model import RobotModel
from ..namespaces import Array, Namespace
from ..quantities import Jacobian, Wrench
from ..screws_in_words import Screw, describe_free_wrench, describe_lost_twist
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS
from ..statics import Decomposition, checked_gravity, decompose, gravity_torques, joint_torques
from ..tasks import Task, characteristic_length, find_task, moving_columns, prismatic_columns, without_rounding
from .result import Analysis, Margin

NEAR_LIMIT = 0.05
"""A joint closer to a limit than this share of its range is near it; with one limit only, this many rad or m."""
LARGEST = 1e150
"""Numbers from here on cannot be squared: an analysis refuses them."""


def analyze(
    model: RobotModel,
    q: Any = None,
    wrench: Wrench | None = None,
    task: str | Sequence[str] | Sequence[int] = "auto",
    *,
    at: str = TIP,
    gravity: Sequence[float] = STANDARD_GRAVITY,
) -> Analysis:
    """What can this arm do, here?

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        wrench: a load on the robot or a push on its surroundings, in any frame of the robot; default base axes at the tip.
        task: rows in play, as in `find_task`.
        at: link that is the tip of the question.
        gravity: (3) in base axes [m/s²].

    Returns:
        Analysis.

    Raises:
        ConfigurationError: KS303 for a batch or a wrong length, of q, the wrench or gravity; KS301 for NaN or huge numbers.
        UnknownNameError: KS318 for a task or row that does not exist, KS310 for a link.

    Example:
        >>> import kinestatics as ks
        >>> a = ks.analyze(ks.load("planar_2r"), [0.0, 0.0])
        >>> a.rank, a.lost_twists[0].text
        (1, 'no velocity along x of base')
    """
    require_model(model)
    if wrench is not None and not isinstance(wrench, Wrench):
        hint = "Wrench.on_robot(force=...) for a load, Wrench.on_environment(force=...) for a push"
        raise ArrayTypeError("KS302", f"wrench is a {type(wrench).__name__}; who acts on whom?", hint)
    array, xp = configuration(model, model.home if q is None else q)
    values = _one_configuration(array, xp)
    J = jacobian(model, values, at=at, check_finite=False)
    found = find_task(model, task, at=at)
    length = characteristic_length(model, at)
    exact = without_rounding(model, _finite_array(J.array, "the Jacobian"))
    prismatic, moving = prismatic_columns(model), moving_columns(model, found.rows, at)
    scaled = _scaled(found, prismatic, moving)
    columns = np.where(prismatic, length, 1.0) if "prismatic columns" in scaled else np.ones(model.n)
    parts = decompose(exact * columns, found.rows, length if "angular rows" in scaled else 1.0)
    lost, free = _in_words(parts, J, length)
    torques, asked = _hold(J, wrench)
    notes: list[str] = []
    held = _gravity(model, values, gravity, notes)
    if not np.all(np.isfinite(model.effort_limits)) and torques is not None:
        notes.append("effort limits are unknown for some joints: torques are not compared with them")
    return Analysis(
        robot=model.name,
        base=model.base,
        tip=J.link,
        joints=model.joint_names,
        kinds=model.joint_kinds,
        configuration=values,
        pose=pose(model, values, at=at, check_finite=False),
        jacobian=J,
        task=found,
        rank=parts.rank,
        singular_values=parts.singular_values,
        condition=_condition(parts, found),
        characteristic_length=length,
        scaled=scaled,
        manipulability=_manipulability(exact, found),
        manipulability_unit=_unit(found, prismatic, moving),
        tolerance=parts.tolerance,
        lost_twists=lost,
        free_wrenches=free,
        gravity_torques=held,
        wrench=asked,
        joint_torques=torques,
        effort_limits=model.effort_limits,
        margins=_margins(model, values),
        notes=tuple(notes),
    )


def _one_configuration(array: Array, xp: Namespace) -> Array:
    if xp.name != "numpy":
        hint = "q = np.asarray(q) first; the functions (ks.jacobian, ...) take it as it is"
        raise ArrayTypeError("KS302", f"analyze computes with NumPy; q is an array of {xp.name}", hint)
    if array.ndim != 1:
        raise ConfigurationError(
            "KS303", "analyze takes one numeric configuration", "loop over a batch, or use an Evaluator"
        )
    return np.array(array, dtype=np.float64)


def _finite_array(values: Any, what: str) -> Array:
    """The values, unless they ran out of what a float holds: prismatic joints and loads can be given as 1e300."""
    array = np.asarray(values, dtype=np.float64)
    if np.abs(array).max(initial=0.0) < LARGEST:
        return array
    raise ConfigurationError("KS301", f"{what} holds numbers of {LARGEST:g} or more", "check the units: metres, radians, N")


def _scaled(task: Task, prismatic: Array, moving: Array) -> tuple[str, ...]:
    """Where radians stand beside metres, in the rows or in the joints, and the characteristic length comes in."""
    rows = [r in ANGULAR_ROWS for r in task.rows]
    found = ("angular rows",) if any(rows) and not all(rows) else ()
    mixed_joints = bool(np.any(moving & prismatic) and np.any(moving & ~prismatic))
    return (*found, "prismatic columns") if mixed_joints else found


def _condition(parts: Decomposition, task: Task) -> float:
    if task.rank == 0 or parts.rank < task.rank:
        return float("inf")
    return float(parts.singular_values[0] / parts.singular_values[task.rank - 1])


def _manipulability(J: Array, task: Task) -> float:
    if not task.rank:
        return 0.0
    return float(np.prod(np.linalg.svd(J[list(task.rows)], compute_uv=False)[: task.rank]))


def _unit(task: Task, prismatic: Array, moving: Array) -> str:
    """Unit of the manipulability: that of the minors of the rows in play, where all have the same one."""
    linear = sum(r in LINEAR_ROWS for r in task.rows)
    if (task.rank < len(task.rows) and linear not in (0, len(task.rows))) or not task.rank:
        return "mixed units" if task.rank else "1"
    travelling = int(np.sum(moving & prismatic))
    if travelling and travelling < moving.sum() != task.rank:
        return "mixed units"
    power = (task.rank if linear == len(task.rows) else linear) - min(travelling, task.rank)
    return "1" if power == 0 else "m" if power == 1 else f"m^{power}"


def _gravity(model: RobotModel, q: Array, gravity: Sequence[float], notes: list[str]) -> Array | None:
    vector = _finite_array(checked_gravity(gravity), "gravity")
    if not model.has_masses:
        notes.append("no masses are known: gravity torques are left out")
        return None
    return gravity_torques(model, q, gravity=tuple(vector.tolist()), check_finite=False)


def _hold(J: Jacobian, wrench: Wrench | None) -> tuple[Array | None, Wrench | None]:
    """The torques for a wrench in any frame, and the wrench with its frame named."""
    if wrench is None:
        return None, None
    if np.shape(wrench.array) != (6,) or not np.all(np.isfinite(np.asarray(wrench.array, dtype=float))):
        raise ConfigurationError(
            "KS303", "analyze takes one wrench of six finite numbers", "loop over a batch, or use joint_torques"
        )
    frame = Frame("base", J.link, wrench.frame.offset) if wrench.frame == Frame() else wrench.frame
    written = J.change_frame(frame)
    named = Wrench(wrench.array, written.frame, wrench.acts_on)
    return _finite_array(joint_torques(written, named), "the joint torques"), named


def _in_words(parts: Decomposition, J: Jacobian, length: float) -> tuple[tuple[Screw, ...], tuple[Screw, ...]]:
    axes, origin = J.frame.axes, J.frame.origin
    lost = tuple(describe_lost_twist(twist, axes, origin, length) for twist in parts.lost_twists)
    free = tuple(describe_free_wrench(wrench, axes, origin, length) for wrench in parts.free_wrenches)
    return lost, free


def _margins(model: RobotModel, q: Array) -> tuple[Margin, ...]:
    margins = []
    for name, x, lower, upper in zip(model.joint_names, q, model.lower, model.upper, strict=True):
        if not (np.isfinite(lower) or np.isfinite(upper)):
            continue
        limit, distance = ("lower", x - lower) if x - lower < upper - x else ("upper", upper - x)
        span = upper - lower if np.isfinite(upper - lower) else 1.0
        near = bool(distance <= NEAR_LIMIT * span)
        margins.append(Margin(name, limit, float(distance), near, bool(lower == upper)))
    return tuple(margins)
