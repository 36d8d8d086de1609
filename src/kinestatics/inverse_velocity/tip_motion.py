"""`move_tip`: where the arm goes when its tip is pulled towards a place; how it gets there is in `pull`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Pose, format_number, named_table, plain, wrapped
from ..spatial import pose_residual, split_pose
from .limits import position_range
from .problem import checked_positive
from .pull import Here, Pull
from .tip_map import Place, at_their_limits, one_posture, reached_limits, tip_map

STEP = 0.05
"""Largest move of a joint between two postures of a path [rad or m]."""

_TOLD, _NOTHING = 5e-7, 1e-12  # [m, rad]: what a sentence speaks of, and what is rounding
_RIGID = 1e-6  # by how much a target may miss being a pose


@dataclass(frozen=True, eq=False)
class TipMotion:
    """Where the arm went; made by `move_tip`.

    Attributes:
        q: (n) the posture it ended in [rad or m].
        path: (k, n) the postures on the way, from the first to `q`.
        reached: whether distance and angle are within the tolerances.
        distance: what is left in the linear rows in play [m]; angle: in the angular ones [rad]; 0 where there are none.
        at_limit: joints at a position limit (with its margin) in the end, by name: "lower" or "upper".
        singularity: the smallest relative singular value met on the way: of the rows in play, their freedoms counted,
            angular rows multiplied by `length`; 0 is singular.
        reason: a sentence: "reached", or what keeps the arm.
        task: the rows in play, by name; length: the characteristic length [m]; joint_names: (n).

    Example:
        >>> import kinestatics as ks
        >>> print(ks.move_tip(ks.load("planar_2r"), [0.0, 0.5], [3.0, 0.0, 0.0]).reason)
        out of reach from here: 1 m away
    """

    q: Array
    path: Array
    reached: bool
    distance: float
    angle: float
    at_limit: dict[str, str]
    singularity: float
    reason: str
    task: tuple[str, ...]
    length: float
    joint_names: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        numbers = {name: plain(getattr(self, name)) for name in ("q", "path", "distance", "angle", "singularity", "length")}
        names = {"task": list(self.task), "joint_names": list(self.joint_names), "at_limit": dict(self.at_limit)}
        return {**numbers, **names, "reached": self.reached, "reason": self.reason}

    def __str__(self) -> str:
        rows = [["[rad or m]", "from", "to", ""]]
        for name, first, last in zip(self.joint_names, self.path[0], self.q, strict=True):
            side = self.at_limit.get(name, "")
            rows.append([name, format_number(first), format_number(last), f"at its {side} limit" if side else ""])
        left = f"{_length_words(self.distance)} and {format_number(self.angle)} rad, in {', '.join(self.task)} in base axes"
        steps = len(self.path) - 1
        return "\n".join(
            [
                wrapped("motion of the tip: ", f"{self.reason}, after {steps} step{'s' * (steps != 1)}"),
                named_table(rows, "joints"),
                wrapped("left: ", left),
                wrapped("nearest to singular: ", f"{format_number(self.singularity)} of the largest singular value"),
            ]
        )

    def __repr__(self) -> str:
        return f"<TipMotion: {self.reason}, {len(self.path)} postures>"


def move_tip(
    model: RobotModel,
    q: Any,
    target: Any,
    *,
    at: str = TIP,
    task: str | Sequence[str] | Sequence[int] = "auto",
    margin: Any = 0.0,
    step: float = STEP,
    tolerance: float = 1e-6,
    angle_tolerance: float = 1e-6,
    most_steps: int = 200,
) -> TipMotion:
    """Where the arm goes when its tip is pulled towards a place: small steps, inside the position limits.

    Args:
        model: the robot; its velocity limits play no part: the path has no time.
        q: (n) the posture it starts in [rad or m]. A joint beyond a limit may come in, and goes no further out.
        target: (4, 4) pose T_base_link, or a Pose; or (3) a position in base axes, which leaves the orientation free [m].
        at: link that is pulled.
        task: rows in play, in base axes, as in `find_task`. "auto" leaves the orientation out besides, where the arm has
            fewer freedoms than the rows.
        margin: (n) or a number: distance kept from the position limits [rad or m].
        step: the largest move of a joint from one posture to the next [rad or m].
        tolerance [m], angle_tolerance [rad]: what may be left of a place that is reached; the last steps aim for less.
        most_steps: after which the arm stops.

    Returns:
        TipMotion. The place may be reachable all the same where it says it is not: from another posture, by another branch.

    Raises:
        ConfigurationError: KS301, KS303 for q; KS353, KS354 for numbers; KS378, a target that is none. ArrayTypeError:
        KS302. UnknownNameError: KS310, KS311, KS318.

    Law: min |J x - e|² + λ² |x|² in the box of limits, λ² ~ |e|: see the head of `pull`.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> found = ks.move_tip(arm, [0.0, 0.5], [1.0, 1.0, 0.0])
        >>> found.reason, ks.pose(arm, found.q).translation.round(9)
        ('reached', array([1., 1., 0.]))
    """
    start = one_posture(model, q)
    goal, has_rotation = _place_of(target)
    of = tip_map(model, at, task, position_only=not has_rotation)
    if task == "auto" and of.task.rank < len(of.rows) and of.linear.any():
        of = tip_map(model, at, task, position_only=True)
    limits = (model.lower, model.upper) if margin == 0.0 else position_range(model, margin)
    near = (
        checked_positive(tolerance, "tolerance", "in metres"),
        checked_positive(angle_tolerance, "angle_tolerance", "in rad"),
    )
    if isinstance(most_steps, bool) or not hasattr(most_steps, "__index__") or most_steps < 0:
        raise ConfigurationError("KS353", f"most_steps is {most_steps!r}", "a whole number, 0 or more")
    pull = Pull(of, goal, *limits, checked_positive(step, "step", "in rad or m"), *near)
    path, kept = pull.followed(start, int(most_steps))
    return _told(pull, np.array(path), kept)


def _place_of(target: Any) -> tuple[Place, bool]:
    """A place from a pose or a position, and whether it has an orientation.

    Raises:
        ArrayTypeError: KS302. ConfigurationError: KS378.
    """
    hint = "a pose T_base_link (4, 4), or a position (3) in base axes [m]"
    try:
        array = np.array(target.array if isinstance(target, Pose) else target, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArrayTypeError("KS302", f"the target is a {type(target).__name__}, not an array of numbers", hint) from None
    if array.shape not in ((3,), (4, 4)):
        raise ConfigurationError("KS378", f"the target has shape {array.shape}", hint)
    if not np.all(np.isfinite(array)):
        raise ConfigurationError("KS378", "the target is not finite", hint)
    if array.shape == (3,):
        return (np.eye(3), array), False
    if (miss := pose_residual(array)) > _RIGID:
        message = f"the target is no pose: it misses a rotation and a translation by {miss:.2g}"
        raise ConfigurationError("KS378", message, "rows: rotation and position, and below 0 0 0 1")
    return split_pose(array), True


def _told(pull: Pull, path: Array, kept: str) -> TipMotion:
    """The result of a path."""
    of, q = pull.of, path[-1]
    missing = of.missing(q, pull.goal)
    distance, angle = of.left(missing)
    sigma = np.linalg.svd(of.jacobian(path), compute_uv=False)
    rank = of.task.rank
    largest = sigma[:, 0] if rank else np.zeros(len(path))
    relative = sigma[:, rank - 1] / np.where(largest > 0, largest, 1.0) if rank else largest
    limits = reached_limits(of.model, q, pull.lower, pull.upper)
    pressed = [name for name, yes in zip(of.model.joint_names, pull.pressed(Here(q, missing)), strict=True) if yes]
    reason = _reason(kept, {name: limits[name] for name in pressed if name in limits}, _left_words(distance, angle))
    path.setflags(write=False)
    names, told = of.model.joint_names, (kept == "reached", distance, angle, limits, float(relative.min()))
    return TipMotion(path[-1], path, *told, reason, of.task.row_names, of.length, names)


def _reason(kept: str, pressed: dict[str, str], left: str) -> str:
    if kept == "reached":
        return "reached"
    if kept == "steps":
        return f"not there after the steps allowed: {left} away"
    if pressed:
        return f"{at_their_limits(pressed)}: {left} away"
    if kept == "saddle":
        return f"singular: the wanted direction is lost, {left} away"
    return f"out of reach from here: {left} away"


def _left_words(distance: float, angle: float) -> str:
    """What is left, in the units in which there is something."""
    told = [_length_words(distance)] if distance > _TOLD or angle <= _TOLD else []
    return " and ".join(told + ([f"{format_number(angle)} rad"] if angle > _TOLD else []))


def _length_words(distance: float) -> str:
    return f"{format_number(0.0 if distance < _NOTHING else distance)} m"
