"""Which rows of a Jacobian count, and the rank they can have: the arm's task, found from its structure. Floor 6."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import definition
from ._kernels import ALL_ROWS
from .errors import UnknownNameError
from .frames import TIP, Frame
from .kinematics import jacobian
from .model import RobotModel
from .namespaces import Array, as_array
from .spatial import ANGULAR, ANGULAR_ROWS, LINEAR, LINEAR_ROWS, ROW_NAMES

TASKS = {"full": ALL_ROWS, "position": LINEAR_ROWS, "orientation": ANGULAR_ROWS}
_SAMPLES = 24
_STRUCTURAL = 1e-9


@dataclass(frozen=True)
class Task:
    """The rows in play and the rank the arm reaches in them at almost every configuration.

    Attributes:
        rows: indices 0..5 of (vx, vy, vz, wx, wy, wz).
        rank: the rank at almost every configuration; less is singular.
        name: what was asked for: "auto", "position", ...
        reason: a sentence that says why these rows.
    """

    rows: tuple[int, ...]
    rank: int
    name: str
    reason: str

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names such as "vx"."""
        return tuple(ROW_NAMES[r] for r in self.rows)

    def __str__(self) -> str:
        return f"{', '.join(self.row_names) or '(none)'} (rank {self.rank}): {self.reason}"


def characteristic_length(model: RobotModel, at: str = TIP) -> float:
    """Reach of the chain to a link: the sum of the distances from joint axis to joint axis and to the tip [m].

    It turns radians into metres where the two are compared (ranks, condition numbers); every result that uses it shows it.
    A prismatic joint with limits adds the middle of its range.

    Example:
        >>> import kinestatics as ks
        >>> ks.characteristic_length(ks.load("planar_2r"))
        2.0
    """
    path = model.path(model.link_joints[model.link(at)])
    q = np.array(
        [
            0.5 * (lo + hi) if np.isfinite(lo) and np.isfinite(hi) else 0.0
            for lo, hi in zip(model.lower, model.upper, strict=True)
        ]
    )
    array, xp = as_array(q)
    poses = definition.joint_poses(model, array, xp)
    points = [poses.p[joint] + poses.R[joint] @ _axis_point(model.screws[joint]) for joint in path]
    _, end = definition.link_pose(model, poses, model.link(at), array, xp)
    if not points:
        return 1e-9
    hops = [float(np.linalg.norm(b - a)) for a, b in zip(points, [*points[1:], end], strict=True)]
    return max(sum(hops), 1e-9)


def _axis_point(screw: Array) -> Array:
    """The point of a joint's axis nearest to its frame's origin."""
    return np.cross(screw[ANGULAR], screw[LINEAR])


def find_task(
    model: RobotModel, task: str | Sequence[str] | Sequence[int] = "auto", at: str = TIP, frame: Frame | None = None
) -> Task:
    """The rows in play for an arm.

    Args:
        model: the robot.
        task: "auto", "full", "position", "orientation", or rows such as ("vx", "vy", "wz").
        at, frame: as in `jacobian`.

    Returns:
        Task. "auto" drops rows that are zero at every configuration; where position alone accounts for all motion
        (a 2R arm, an RRP arm), the rows are those of position; otherwise all rows that move stay in play.

    Raises:
        UnknownNameError: KS318.

    Example:
        >>> import kinestatics as ks
        >>> ks.find_task(ks.load("planar_2r")).row_names
        ('vx', 'vy')
    """
    samples = _samples(model, at, frame)
    if not isinstance(task, str):
        rows = _named_rows(task)
        return Task(rows, _rank(samples, rows), "rows", "the rows asked for")
    if task in TASKS:
        return Task(TASKS[task], _rank(samples, TASKS[task]), task, f"the task asked for is {task!r}")
    if task != "auto":
        raise UnknownNameError(
            "KS318", f"task {task!r} is not known", "say 'auto', 'full', 'position', 'orientation' or row names"
        )
    return _automatic(samples)


def _named_rows(rows: Sequence[str] | Sequence[int]) -> tuple[int, ...]:
    found = []
    for row in rows:
        index = ROW_NAMES.index(row) if row in ROW_NAMES else row
        if not isinstance(index, int) or not 0 <= index < 6:
            raise UnknownNameError("KS318", f"row {row!r} is not known", f"rows are {', '.join(ROW_NAMES)}, or 0 to 5")
        found.append(index)
    return tuple(sorted(set(found)))


def _samples(model: RobotModel, at: str, frame: Frame | None) -> Array:
    """Jacobians at fixed pseudo-random configurations, with lengths in units of the arm's reach: (samples, 6, n)."""
    rng = np.random.default_rng(20261124)
    q = rng.uniform(-np.pi, np.pi, (_SAMPLES, model.n))
    scaled = np.array(jacobian(model, q, at=at, frame=frame).array)
    lengths = scaled[:, list(LINEAR_ROWS)]
    largest = np.abs(lengths).max(initial=0.0)
    if largest > 0:
        scaled[:, list(LINEAR_ROWS)] = lengths / largest
    return scaled


def _rank(samples: Array, rows: Sequence[int]) -> int:
    if not rows or not samples.shape[-1]:
        return 0
    sigma = np.linalg.svd(samples[:, list(rows)], compute_uv=False)
    return int((sigma > _STRUCTURAL * sigma.max(initial=0.0)).sum(-1).max())


def _automatic(samples: Array) -> Task:
    live = tuple(r for r in range(6) if np.abs(samples[:, r]).max(initial=0.0) > _STRUCTURAL)
    rank = _rank(samples, live)
    linear = tuple(r for r in live if r in LINEAR_ROWS)
    dead = [ROW_NAMES[r] for r in range(6) if r not in live]
    never = f"{', '.join(dead)} never move" if dead else "all rows move"
    if rank < len(live) and rank == _rank(samples, linear):
        return Task(linear, rank, "auto", f"{never}; position alone accounts for all {rank} freedoms")
    if rank < len(live):
        return Task(live, rank, "auto", f"{never}; {rank} freedoms, fewer than rows")
    return Task(live, rank, "auto", never)
