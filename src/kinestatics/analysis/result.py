"""What an analysis holds: every number a surface may show, and the same as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..quantities import Jacobian, Pose, Wrench
from ..screws_in_words import Screw
from ..tasks import Task


@dataclass(frozen=True)
class Margin:
    """How far a joint is from its nearest position limit.

    Attributes:
        joint: name; limit: "lower" or "upper"; distance: [rad or m], negative outside; near: within 5 % of the range,
        or outside it; locked: the limits leave it a single position.
    """

    joint: str
    limit: str
    distance: float
    near: bool
    locked: bool = False


@dataclass(frozen=True, eq=False)
class Analysis:
    """What an arm can do at one configuration. `print` it, or take `to_dict()`.

    Attributes:
        robot, base, tip: names; joints: names of the columns; kinds: of the joints.
        configuration: (n) [rad or m].
        pose: of the tip.
        jacobian: with its frame.
        task: the rows in play and the rank they can have.
        rank: here; singular when it is less than task.rank.
        singular_values: (k) of the rows in play. Where the task mixes metres and radians, angular rows are multiplied by
            the characteristic length; where the arm mixes prismatic and turning joints, prismatic columns are (a metre
            of travel then counts as the angle that moves the arm's reach by a metre). No unit of length changes the
            condition.
        condition: σ_max / σ_min over the task's rank, infinite when singular.
        characteristic_length: [m]; scaled: what it multiplied, "angular rows", "prismatic columns", both or nothing.
        manipulability: product of the singular values of the bare rows in play (note 000); unit: of that product.
        tolerance: singular values below this fraction of the largest count as zero.
        lost_twists, free_wrenches: within the rows in play, in words and numbers.
        gravity_torques: (n) what holds the arm [N m or N], or None when no masses are known.
        wrench: what was asked about, or None; joint_torques: (n) what holds it, or None.
        effort_limits: (n) [N m or N], infinite where unknown.
        margins: one for each joint with limits.
        notes: sentences about missing data.
    """

    robot: str
    base: str
    tip: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    configuration: Array
    pose: Pose
    jacobian: Jacobian
    task: Task
    rank: int
    singular_values: Array
    condition: float
    characteristic_length: float
    scaled: tuple[str, ...]
    manipulability: float
    manipulability_unit: str
    tolerance: float
    lost_twists: tuple[Screw, ...]
    free_wrenches: tuple[Screw, ...]
    gravity_torques: Array | None
    wrench: Wrench | None
    joint_torques: Array | None
    effort_limits: Array
    margins: tuple[Margin, ...]
    notes: tuple[str, ...]

    @property
    def is_singular(self) -> bool:
        """Whether the rank is less than the arm can have in these rows."""
        return self.rank < self.task.rank

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; unknown and infinite values are None."""
        J = self.jacobian
        return {
            "robot": self.robot,
            "base": self.base,
            "tip": self.tip,
            "joints": list(self.joints),
            "configuration": self.configuration.tolist(),
            "pose": np.asarray(self.pose).tolist(),
            "jacobian": {
                "array": np.asarray(J).tolist(),
                "axes": J.frame.axes,
                "origin": J.frame.origin,
                "rows": list(J.rows),
            },
            "task": {
                "name": self.task.name,
                "rows": list(self.task.row_names),
                "rank": self.task.rank,
                "reason": self.task.reason,
            },
            "rank": self.rank,
            "singular": self.is_singular,
            "singular_values": self.singular_values.tolist(),
            "condition": _finite(self.condition),
            "characteristic_length": self.characteristic_length,
            "scaled": list(self.scaled),
            "tolerance": self.tolerance,
            "manipulability": self.manipulability,
            "manipulability_unit": self.manipulability_unit,
            "lost_twists": [screw.to_dict() for screw in self.lost_twists],
            "free_wrenches": [screw.to_dict() for screw in self.free_wrenches],
            "gravity_torques": None if self.gravity_torques is None else self.gravity_torques.tolist(),
            "wrench": None if self.wrench is None else _wrench_dict(self.wrench),
            "joint_torques": None if self.joint_torques is None else self.joint_torques.tolist(),
            "effort_limits": [_finite(x) for x in self.effort_limits],
            "limits": [asdict(margin) for margin in self.margins],
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        from .text import paragraphs

        return "\n\n".join(paragraphs(self))


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _wrench_dict(wrench: Wrench) -> dict[str, Any]:
    return {
        "force": np.asarray(wrench.force).tolist(),
        "torque": np.asarray(wrench.torque).tolist(),
        "acts_on": wrench.acts_on,
        "axes": wrench.frame.axes,
        "origin": wrench.frame.origin,
        "offset": list(wrench.frame.offset),
    }
