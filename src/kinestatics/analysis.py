"""`analyze`: what can this arm do, here? One frozen result with every number a surface may show. Floor 9."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._kernels import STANDARD_GRAVITY
from .errors import ConfigurationError
from .frames import TIP, Frame
from .kinematics import configuration, jacobian, pose
from .model import RobotModel
from .namespaces import Array
from .quantities import Jacobian, Pose, Wrench, format_number
from .screws_in_words import Screw, describe_free_wrench, describe_lost_twist
from .spatial import ANGULAR_ROWS, LINEAR_ROWS
from .statics import Decomposition, decompose, gravity_torques, joint_torques
from .tasks import Task, characteristic_length, find_task

NEAR_LIMIT = 0.05
"""A joint closer to a limit than this share of its range is near it."""


@dataclass(frozen=True)
class Margin:
    """How far a joint is from its nearest position limit.

    Attributes:
        joint: name; limit: "lower" or "upper"; distance: [rad or m], negative outside; near: within 5 % of the range.
    """

    joint: str
    limit: str
    distance: float
    near: bool


@dataclass(frozen=True)
class Analysis:
    """What an arm can do at one configuration. `print` it, or take `to_dict()`.

    Attributes:
        robot, base, tip: names; joints: names of the columns; kinds: of the joints.
        configuration: (n) [rad or m].
        pose: of the tip.
        jacobian: with its frame.
        task: the rows in play and the rank they can have.
        rank: here; singular when it is less than task.rank.
        singular_values: (k) of the rows in play, angular rows times the characteristic length.
        condition: σ_max / σ_min over the task's rank, infinite when singular.
        characteristic_length: [m]; matters only where the task mixes metres and radians.
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
            "tolerance": self.tolerance,
            "manipulability": self.manipulability,
            "manipulability_unit": self.manipulability_unit,
            "lost_twists": [screw.to_dict() for screw in self.lost_twists],
            "free_wrenches": [screw.to_dict() for screw in self.free_wrenches],
            "gravity_torques": None if self.gravity_torques is None else self.gravity_torques.tolist(),
            "wrench": None if self.wrench is None else _wrench_dict(self.wrench),
            "joint_torques": None if self.joint_torques is None else self.joint_torques.tolist(),
            "effort_limits": [_finite(x) for x in self.effort_limits],
            "limits": [{"joint": m.joint, "limit": m.limit, "distance": m.distance, "near": m.near} for m in self.margins],
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        return "\n\n".join(_paragraphs(self))


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _wrench_dict(wrench: Wrench) -> dict[str, Any]:
    return {
        "force": np.asarray(wrench.force).tolist(),
        "torque": np.asarray(wrench.torque).tolist(),
        "acts_on": wrench.acts_on,
        "axes": wrench.frame.axes,
        "origin": wrench.frame.origin,
    }


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
        ConfigurationError: KS303 for a batch or a wrong length, KS301 for NaN.

    Example:
        >>> import kinestatics as ks
        >>> a = ks.analyze(ks.load("planar_2r"), [0.0, 0.0])
        >>> a.rank, a.lost_twists[0].text
        (1, 'no velocity along x of base')
    """
    given = model.home if q is None else q
    configured, xp = configuration(model, given)
    if configured.ndim != 1 or xp.name != "numpy":
        raise ConfigurationError(
            "KS303", "analyze takes one numeric configuration", "loop over a batch, or use an Evaluator"
        )
    values = np.array(configured, dtype=np.float64)
    J = jacobian(model, values, at=at)
    found = find_task(model, task, at=at)
    length = characteristic_length(model, at)
    parts = decompose(J, found.rows, length)
    notes: list[str] = []
    sigma = np.linalg.svd(np.asarray(J)[list(found.rows)], compute_uv=False)
    held = _gravity(model, values, gravity, notes)
    torques, asked = _hold(J, wrench)
    if not np.all(np.isfinite(model.effort_limits)) and torques is not None:
        notes.append("effort limits are unknown for some joints: torques are not compared with them")
    kinds = dict(zip(model.moving_names, model.kinds, strict=True))
    lost, free = _in_words(parts, J)
    return Analysis(
        robot=model.name,
        base=model.base,
        tip=J.link,
        joints=model.joint_names,
        kinds=tuple(kinds.get(name, "revolute") for name in model.joint_names),
        configuration=values,
        pose=pose(model, values, at=at),
        jacobian=J,
        task=found,
        rank=parts.rank,
        singular_values=parts.singular_values,
        condition=_condition(parts, found),
        characteristic_length=length,
        manipulability=float(np.prod(sigma[: found.rank])) if found.rank else 0.0,
        manipulability_unit=_unit(found),
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


def _condition(parts: Decomposition, task: Task) -> float:
    if task.rank == 0 or parts.rank < task.rank:
        return float("inf")
    return float(parts.singular_values[0] / parts.singular_values[task.rank - 1])


def _unit(task: Task) -> str:
    linear = sum(r in LINEAR_ROWS for r in task.rows)
    if task.rank < len(task.rows) and linear not in (0, len(task.rows)):
        return "mixed units"
    linear = task.rank if linear == len(task.rows) else linear
    return "m" if linear == 1 else f"m^{linear}" if linear else "1"


def _gravity(model: RobotModel, q: Array, gravity: Sequence[float], notes: list[str]) -> Array | None:
    if not model.has_masses:
        notes.append("no masses are known: gravity torques are left out")
        return None
    return gravity_torques(model, q, gravity=gravity)


def _hold(J: Jacobian, wrench: Wrench | None) -> tuple[Array | None, Wrench | None]:
    """The torques for a wrench in any frame, and the wrench with its frame named."""
    if wrench is None:
        return None, None
    frame = Frame("base", J.link, wrench.frame.offset) if wrench.frame == Frame() else wrench.frame
    written = J.change_frame(frame)
    named = Wrench(wrench.array, written.frame, wrench.acts_on)
    return joint_torques(written, named), named


def _in_words(parts: Decomposition, J: Jacobian) -> tuple[tuple[Screw, ...], tuple[Screw, ...]]:
    axes, origin, length = J.frame.axes, J.frame.origin, parts.characteristic_length
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
        margins.append(Margin(name, limit, float(distance), bool(distance < NEAR_LIMIT * span)))
    return tuple(margins)


# ---- printing: the same numbers as a person would want to read them, at most 80 columns where names allow ----------------


def _paragraphs(a: Analysis) -> list[str]:
    parts = [_heading(a), str(a.pose), str(a.jacobian), _rank_text(a), _direction_text(a), _torque_text(a), _limit_text(a)]
    if a.notes:
        parts.append("\n".join(f"note: {note}" for note in a.notes))
    return [part for part in parts if part]


def _heading(a: Analysis) -> str:
    q = ", ".join(format_number(x) for x in a.configuration)
    unit = {"prismatic": "m"}
    units = ", ".join(sorted({unit.get(kind, "rad") for kind in a.kinds}, reverse=True)) or "-"
    return f"{a.robot}: {len(a.joints)} joints, from {a.base} to {a.tip}\nq = ({q}) [{units}]"


def _rank_text(a: Analysis) -> str:
    verdict = "singular: the arm can have" if a.is_singular else "not singular: the arm can have"
    sigma = ", ".join(format_number(x) for x in a.singular_values)
    mixed = any(r in LINEAR_ROWS for r in a.task.rows) and any(r in ANGULAR_ROWS for r in a.task.rows)
    scaled = f" (angular rows times the characteristic length {format_number(a.characteristic_length)} m)" if mixed else ""
    lines = [
        f"task rows        {', '.join(a.task.row_names)} ({a.task.reason})",
        f"rank             {a.rank} ({verdict} {a.task.rank}; tolerance {a.tolerance:g} of the largest)",
        f"singular values  {sigma}",
        *([f"                {scaled}"] if mixed else []),
        f"condition        {format_number(a.condition) if np.isfinite(a.condition) else 'infinite'}",
        f"manipulability   {format_number(a.manipulability)} {a.manipulability_unit}",
    ]
    return "\n".join(lines)


def _direction_text(a: Analysis) -> str:
    if not a.lost_twists:
        return "no direction of the task is lost; every wrench in it is felt by some joint"
    lines = ["lost directions of motion"] + [f"  {screw.text}" for screw in a.lost_twists]
    lines += ["wrenches held for free (no joint torque)"] + [f"  {screw.text}" for screw in a.free_wrenches]
    return "\n".join(lines)


def _torque_text(a: Analysis) -> str:
    columns: list[tuple[str, Array]] = []
    if a.gravity_torques is not None:
        columns.append(("gravity", a.gravity_torques))
    if a.joint_torques is not None:
        columns.append(("wrench", a.joint_torques))
    if not columns:
        return ""
    if len(columns) == 2:
        columns.append(("both", columns[0][1] + columns[1][1]))
    width = max(len(name) for name in a.joints) if a.joints else 0
    head = "torques that hold the arm still [N m, N for a prismatic joint]"
    if a.wrench is not None:
        who = "a load on the robot" if a.wrench.acts_on == "robot" else "the robot pushes on its surroundings"
        values = ", ".join(format_number(x) for x in a.wrench.array)
        head = f"wrench ({values}) [N, N m]: {who}; {a.wrench.frame}\n" + head
    lines = [head, "  " + " " * width + "".join(f"{name:>12s}" for name, _ in columns) + "       limit"]
    for i, name in enumerate(a.joints):
        limit = format_number(a.effort_limits[i]) if np.isfinite(a.effort_limits[i]) else "unknown"
        over = "  over the limit" if abs(columns[-1][1][i]) > a.effort_limits[i] else ""
        lines.append(
            f"  {name:{width}s}" + "".join(f"{format_number(c[i]):>12s}" for _, c in columns) + f"{limit:>12s}{over}"
        )
    return "\n".join(lines)


def _limit_text(a: Analysis) -> str:
    near = [m for m in a.margins if m.near]
    if not near:
        return "no joint is near a position limit" if a.margins else ""
    lines = ["joints near a position limit"]
    for m in near:
        state = "outside by" if m.distance < 0 else "away"
        amount = format_number(abs(m.distance))
        lines.append(
            f"  {m.joint}: {m.limit} limit, {state} {amount}"
            if m.distance < 0
            else f"  {m.joint}: {amount} {state} from its {m.limit} limit"
        )
    return "\n".join(lines)
