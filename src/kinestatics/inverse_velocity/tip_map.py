"""`tip_map`: the rows in play of a link as a map without units, and what is missing to a place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..kinematics import configuration, hessian, jacobian, pose
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, size_weights, split_pose, transpose
from ..tasks import Task, characteristic_length, find_task, prismatic_columns

_CACHED = 64
_NEAR_HALF_TURN = 1e-4

Place = tuple[Array, Array]
"""Rotation (3, 3) and position (3) of a link in base axes."""


@dataclass(frozen=True, eq=False)
class TipMap:
    """The rows in play of a link, lengths in characteristic lengths, angles in radians.

    Attributes:
        model, at, task: what is asked; rows: those in play, from 0.
        length: the characteristic length [m].
        travel: (n) what a joint moves by for one unit of y [rad or m]: q = travel · y.
    """

    model: RobotModel
    at: str
    task: Task
    rows: list[int]
    length: float
    travel: Array
    weights: Array
    linear: Array

    def place(self, q: Array) -> Place:
        """Where the link is."""
        return split_pose(pose(self.model, q, at=self.at, check_finite=False).array)

    def jacobian(self, q: Array) -> Array:
        """(..., r, n) of y."""
        J = jacobian(self.model, q, at=self.at, check_finite=False).array
        return np.asarray(self.weights[:, None] * J[..., self.rows, :] * self.travel)

    def hessian(self, q: Array) -> Array:
        """(r, n, n), the derivative of `jacobian`."""
        H = hessian(self.model, q, at=self.at, check_finite=False).array[self.rows]
        return np.asarray(self.weights[:, None, None] * H * self.travel[:, None] * self.travel)

    def missing(self, q: Array, goal: Place) -> Array:
        """(r) what is missing to a place: a step to it, and the rotation vector of a turn to it, in base axes."""
        (R, p), (R_goal, p_goal) = self.place(q), goal
        six = np.concatenate([p_goal - p, rotation_vector(R_goal @ R.T)])
        return np.asarray(self.weights * six[self.rows])

    def left(self, missing: Array) -> tuple[float, float]:
        """What is missing in the linear rows [m] and in the angular ones [rad]."""
        linear, angular = missing[self.linear], missing[~self.linear]
        return self.length * length_of(linear), length_of(angular)


def tip_map(model: RobotModel, at: str, task: Any, position_only: bool = False) -> TipMap:
    """The rows of `find_task` as a map, found once for a model.

    Args:
        position_only: whether rows of the orientation are left out.

    Raises:
        ArrayTypeError: KS302. UnknownNameError: KS310, KS311, KS318.
        ConfigurationError: KS378, where no row is left.
    """
    key = (at, task if isinstance(task, str) else tuple(task) if isinstance(task, Sequence) else None, position_only)
    found = find_task(model, task, at=at)
    known: dict[Any, TipMap] = model.__dict__.setdefault("_tip_maps", {})
    if key[1] is None or (of := known.get(key)) is None:
        if len(known) >= _CACHED:
            known.clear()
        of = known[key] = _made(model, at, found, position_only)
    return of


def _made(model: RobotModel, at: str, task: Task, position_only: bool) -> TipMap:
    rows = [row for row in task.rows if row in LINEAR_ROWS or not position_only]
    if not rows:
        message = (
            f"the rows in play of {model.name!r} are {', '.join(task.row_names) or 'none'}, and no position is among them"
        )
        raise ConfigurationError("KS378", message, "a target of pose (4, 4), or task='position'")
    if len(rows) < len(task.rows):
        task = find_task(model, rows, at=at)
    length = characteristic_length(model, at)
    travel = np.where(prismatic_columns(model), length, 1.0)
    linear = np.array([row not in ANGULAR_ROWS for row in rows])
    return TipMap(model, at, task, rows, length, travel, size_weights(length)[rows] / length, linear)


def one_posture(model: RobotModel, q: Any) -> Array:
    """(n) one posture in numbers, as an array of its own.

    Raises:
        ConfigurationError: KS303, KS301. ArrayTypeError: KS302.
    """
    array, xp = configuration(model, q)
    if xp.name != "numpy" or array.ndim != 1:
        raise ConfigurationError(
            "KS303", f"q has shape {tuple(array.shape)}; expected ({model.n},)", "one posture, in numbers"
        )
    return np.array(array, dtype=np.float64)


def length_of(vector: Array) -> float:
    """|v|, quicker than the general norm."""
    return math.sqrt(float(vector @ vector))


def rotation_vector(R: Array) -> Array:
    """(3) axis times angle in [0, π] of one rotation (3, 3).

    Law: R - Rᵀ = 2 sin φ [n]×, tr R = 1 + 2 cos φ; near φ = π the axis is from R + Rᵀ = 2 cos φ 1 + 2 (1 - cos φ) n nᵀ.

    Example:
        >>> import numpy as np
        >>> rotation_vector(np.diag([1.0, -1.0, -1.0])) / np.pi
        array([1., 0., 0.])
    """
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    odd = ((h - f) / 2, (c - g) / 2, (d - b) / 2)
    sine, cosine = math.hypot(*odd), (a + e + i - 1) / 2
    angle = math.atan2(sine, cosine)
    if cosine > 0 or sine > _NEAR_HALF_TURN:
        share = angle / sine if sine > 0 else 1.0
        return np.array(odd) * share
    columns = (R + transpose(R)) / 2 - cosine * np.eye(3)
    axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
    axis = axis / np.linalg.norm(axis)
    return angle * (-axis if axis @ np.array(odd) < 0 else axis)


def reached_limits(model: RobotModel, q: Array, lower: Array, upper: Array) -> dict[str, str]:
    """Joints at or beyond a bound, by name: "lower" or "upper"."""
    found = {}
    for k, name in enumerate(model.joint_names):
        slack = _AT_LIMIT * (1.0 + abs(q[k]))
        if q[k] >= upper[k] - slack or q[k] <= lower[k] + slack:
            found[name] = "upper" if q[k] >= upper[k] - slack else "lower"
    return found


_AT_LIMIT = 1e-9  # relative to 1 + |q|


def at_their_limits(limits: dict[str, str]) -> str:
    """What a sentence says of joints at limits: "joint 'elbow' is at its upper limit"."""
    if len(limits) == 1:
        [(name, side)] = limits.items()
        return f"joint {name!r} is at its {side} limit"
    named = [f"{name!r} ({side})" for name, side in limits.items()]
    return f"joints {', '.join(named[:-1])} and {named[-1]} are at their limits"
