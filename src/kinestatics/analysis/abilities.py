"""The part of an analysis that says how fast and how strong the arm is: ellipsoids, greatest speeds, pushes and payload."""

from __future__ import annotations

import numpy as np

from ..dexterity import Ellipsoid, force_ellipsoid, speed_capacity, velocity_ellipsoid
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Jacobian
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, ROW_NAMES
from ..statics import Capacity, force_capacity, payload_capacity
from ..tasks import Task
from .result import Ability

_UNKNOWN_SPEEDS = "velocity limits are unknown for some joints: greatest speeds are left out"
_UNKNOWN_EFFORTS = "effort limits are unknown for some joints: greatest forces and the payload are left out"


def ellipsoids(J: Jacobian, task: Task) -> tuple[Ellipsoid | None, Ellipsoid | None]:
    """Of velocity and force, in the rows in play of one unit: the linear ones, or the angular ones where none is linear."""
    rows = [row for row in task.rows if row in LINEAR_ROWS] or [row for row in task.rows if row in ANGULAR_ROWS]
    if not rows or not J.joint_names:
        return None, None
    return velocity_ellipsoid(J, task=rows), force_ellipsoid(J, task=rows)


def abilities(
    model: RobotModel, q: Array, J: Jacobian, task: Task, gravity: Array, notes: list[str]
) -> tuple[tuple[Ability, ...], tuple[str, ...]]:
    """Greatest speed and push along ± each axis of base that has a linear row in play; the rows a speed keeps at rest."""
    linear = [row for row in task.rows if row in LINEAR_ROWS]
    fast, strong = _known(J, model.velocity_limits), model.has_masses and _known(J, model.effort_limits)
    if linear and not fast:
        notes.append(_UNKNOWN_SPEEDS)
    if linear and model.has_masses and not strong:
        notes.append(_UNKNOWN_EFFORTS)
    if not linear or not (fast or strong):
        return (), ()
    words = [f"{sign}{ROW_NAMES[row][-1]}" for row in linear for sign in "+-"]
    directions = np.array([size * np.eye(3)[row] for row in linear for size in (1.0, -1.0)])
    speeds = speed_capacity(model, q, directions, task=task.rows, at=J.link, check_finite=False) if fast else None
    pushes = force_capacity(model, q, directions, at=J.link, gravity=gravity, check_finite=False) if strong else None
    found = []
    for k, word in enumerate(words):
        speed, fastest = (None, ()) if speeds is None else (float(speeds.value[k]), tuple(speeds.limiting_joints[k]))
        push, strongest = (None, None) if pushes is None else (float(pushes.value[k]), pushes.limiting_joint[k])
        found.append(Ability(word, speed, fastest, push, (strongest,) if strongest else ()))
    return tuple(found), () if speeds is None else speeds.rows


def _known(J: Jacobian, limits: Array) -> bool:
    """Whether every joint that moves the link has a limit."""
    return bool(np.all(np.isfinite(limits[np.any(J.array != 0, axis=0)])))


def greatest_payload(model: RobotModel, q: Array, J: Jacobian, gravity: Array) -> Capacity | None:
    """The greatest mass at the origin of the link, where masses and the efforts that matter are known."""
    if not model.has_masses or not model.n or not _known(J, model.effort_limits):
        return None
    return payload_capacity(model, q, at=J.link, gravity=gravity, check_finite=False)
