"""Which rows of a Jacobian count, and the rank they can have: the arm's task, found from its structure. Floor 6."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from . import definition
from ._kernels import ALL_ROWS
from .errors import ArrayTypeError, UnknownNameError
from .frames import TIP, Frame
from .kinematics import Locator, jacobian, named_frame, relative_jacobian, require_model
from .model import RobotModel
from .namespaces import Array, as_array
from .quantities import Jacobian
from .spatial import ANGULAR, ANGULAR_ROWS, LINEAR, LINEAR_ROWS, ROW_NAMES, split_pose

TASKS = {"full": ALL_ROWS, "position": LINEAR_ROWS, "orientation": ANGULAR_ROWS}
_SAMPLES = 24
_STRUCTURAL = 1e-9
_CACHED_SAMPLES = 64
_ROUNDING = 1e-13  # lengths below this share of the robot's largest dimension are rounding, not geometry


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
    A prismatic joint adds the middle of its range, or its home where it has no limits; a helical joint its pitch. A chain
    without any extent, such as a spherical wrist with the tip at its centre, moves no point and has no reach: there it is
    the largest length in the robot's description, or 1 m when there is none.

    Example:
        >>> import kinestatics as ks
        >>> ks.characteristic_length(ks.load("planar_2r"))
        2.0
    """
    _require_numbers(model)
    link = model.link(at)
    known: dict[int, float] = model.__dict__.setdefault("_lengths", {})  # of a model that cannot change
    if link not in known:
        known[link] = _reach(model, link)
    return known[link]


def _reach(model: RobotModel, link: int) -> float:
    """The sum of the hops from axis to axis, and to the link, in the middle of the joints' ranges [m]."""
    path = model.path(model.link_joints[link])
    q = np.array(
        [
            0.5 * (lo + hi) if np.isfinite(lo) and np.isfinite(hi) else home
            for lo, hi, home in zip(model.lower, model.upper, model.home, strict=True)
        ]
    )
    array, xp = as_array(q)
    poses = definition.joint_poses(model, array, xp)
    points = [poses.p[joint] + poses.R[joint] @ _axis_point(model.screws[joint]) for joint in path]
    _, end = definition.link_pose(model, poses, link, array, xp)
    hops = [float(np.linalg.norm(b - a)) for a, b in zip(points, [*points[1:], end], strict=True)] if points else []
    hops += [abs(float(screw[ANGULAR] @ screw[LINEAR])) for screw in model.screws[list(path)]]
    reach, largest = sum(hops), _largest_dimension(model)
    return reach if reach > _ROUNDING * largest else largest or 1.0


def _largest_dimension(model: RobotModel) -> float:
    """The largest length in the description of the robot [m]: what rounding errors of positions are measured by."""
    if (known := model.__dict__.get("_largest")) is not None:
        return float(known)
    turning = model.screws[np.any(model.screws[:, ANGULAR] != 0, axis=-1)]  # of a prismatic screw it is a direction
    lengths = (split_pose(model.placements)[1], split_pose(model.link_placements)[1], turning[:, LINEAR])
    largest = max(float(np.abs(length).max(initial=0.0)) for length in lengths)
    model.__dict__["_largest"] = largest
    return largest


def prismatic_columns(model: RobotModel) -> Array:
    """(n) whether a joint coordinate is a length [m] and not an angle [rad]."""
    return np.array([kind == "prismatic" for kind in model.joint_kinds], dtype=bool)


def without_rounding(model: RobotModel, array: Array) -> Array:
    """A Jacobian's array (..., 6, n) with zeros for the lengths in it that are nothing but rounding.

    A wrist whose tip lies on all its axes has linear entries of about 1e-17 m where geometry says 0, and no larger ones
    to show that they are small. Columns of prismatic joints hold no lengths.
    """
    floor = np.where(prismatic_columns(model), 0.0, _ROUNDING * _largest_dimension(model))
    cleaned = np.array(array)
    cleaned[..., LINEAR, :] = np.where(np.abs(cleaned[..., LINEAR, :]) < floor, 0.0, cleaned[..., LINEAR, :])
    return cleaned


def _axis_point(screw: Array) -> Array:
    """The point of a joint's axis nearest to its frame's origin."""
    return np.cross(screw[ANGULAR], screw[LINEAR])


def find_task(
    model: RobotModel,
    task: str | Sequence[str] | Sequence[int] = "auto",
    at: str = TIP,
    frame: Frame | None = None,
    *,
    relative_to: str | None = None,
) -> Task:
    """The rows in play for an arm.

    Args:
        model: the robot.
        task: "auto", "full", "position", "orientation", or rows such as ("vx", "vy", "wz") or "vx,vy,wz".
        at, frame: as in `jacobian`; relative_to: as in `relative_jacobian`.

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
    _require_numbers(model)
    samples, known = _samples(model, at, frame, relative_to)
    asked = task if isinstance(task, str) else named_rows(task)
    if (found := known.get(asked)) is None:
        if len(known) >= _CACHED_SAMPLES:
            known.clear()
        found = known[asked] = _task_in_words(samples, asked)
    return found


def _task_in_words(samples: Array, task: str | tuple[int, ...]) -> Task:
    if task == "auto":
        return _automatic(samples)
    if isinstance(task, str) and task in TASKS:
        return Task(TASKS[task], _rank(samples, TASKS[task]), task, f"the task asked for is {task!r}")
    rows = named_rows(task)
    return Task(rows, _rank(samples, rows), "rows", "the rows asked for")


def task_of(J: Jacobian, task: str | Sequence[str] | Sequence[int] = "auto") -> Task:
    """The rows in play for a Jacobian: those of its robot, link and frame, as in `find_task`.

    Example:
        >>> import kinestatics as ks
        >>> task_of(ks.jacobian(ks.load("planar_2r"), [0.0, 0.5])).row_names
        ('vx', 'vy')
    """
    return find_task(model_of(J), task, J.link, J.frame, relative_to=relative_to(J))


def relative_to(J: Jacobian) -> str | None:
    """The link that a relative Jacobian takes to stand still; None for any other."""
    return cast(Locator, J._locate).relative_to


def model_of(J: Jacobian) -> RobotModel:
    """The robot a Jacobian was made from."""
    return cast(Locator, J._locate).model


def _require_numbers(model: RobotModel) -> None:
    require_model(model)
    if model.is_symbolic:
        hint = "put numbers in place of the symbols first"
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths, and its structure is sampled", hint)


def named_rows(rows: Any) -> tuple[int, ...]:
    """Indices of rows given as names or numbers; one name, or several with commas between, may come as text."""
    if isinstance(rows, str):
        named = [row.strip() for row in rows.split(",")]
        if not set(named) & set(ROW_NAMES):
            hint = "say 'auto', 'full', 'position', 'orientation' or rows such as 'vx,vy,wz'"
            raise UnknownNameError("KS318", f"task {rows!r} is not known", hint)
        rows = named
    try:
        found = tuple(sorted({_row_index(row) for row in rows}))
    except TypeError:
        found = ()
    if not found:
        raise UnknownNameError("KS318", f"task {rows!r} is not known", "give rows as a list, such as ['vx', 'wz']")
    return found


def _row_index(row: Any) -> int:
    if isinstance(row, str) and row in ROW_NAMES:
        return ROW_NAMES.index(row)
    hint = f"rows are {', '.join(ROW_NAMES)}, or 0 to 5"
    if isinstance(row, str | bool) or not hasattr(row, "__index__") or not 0 <= operator.index(row) < 6:
        raise UnknownNameError("KS318", f"row {row!r} is not known", hint)
    return operator.index(row)


def _samples(
    model: RobotModel, at: str, frame: Frame | None, relative_to: str | None = None
) -> tuple[Array, dict[str | tuple[int, ...], Task]]:
    """Jacobians at fixed pseudo-random configurations, with lengths in units of the arm's reach: (samples, 6, n).

    Kept for the next question, together with the tasks found in them.
    """
    reference = None if relative_to is None else model.link(relative_to)
    key = (model.link(at), frame if frame is None else named_frame(model, frame), reference)
    known: dict[Any, tuple[Array, dict[str | tuple[int, ...], Task]]] = model.__dict__.setdefault("_samples", {})
    if (found := known.get(key)) is None:
        if len(known) >= _CACHED_SAMPLES:
            known.clear()
        found = known[key] = (_sampled(model, at, frame, relative_to), {})
    return found


def _sampled(model: RobotModel, at: str, frame: Frame | None, relative_to: str | None) -> Array:
    rng = np.random.default_rng(20261124)
    q = rng.uniform(-np.pi, np.pi, (_SAMPLES, model.n))
    size = np.where(prismatic_columns(model), _largest_dimension(model) or 1.0, 1.0)
    q = q * size
    if relative_to is None:
        J = jacobian(model, q, at=at, frame=frame, check_finite=False)
    else:
        J = relative_jacobian(model, q, at=at, relative_to=relative_to, frame=frame, check_finite=False)
    scaled = without_rounding(model, J.array) * size  # travel by the robot's own size, so that it may have any
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


def moving_columns(
    model: RobotModel, rows: Sequence[int], at: str = TIP, frame: Frame | None = None, relative_to: str | None = None
) -> Array:
    """(n) whether a joint moves these rows in any posture."""
    known: dict[Any, Array] = model.__dict__.setdefault("_moving", {})  # of a model that cannot change
    key = (model.link(at), frame, relative_to)
    if key not in known:
        if len(known) >= _CACHED_SAMPLES:
            known.clear()
        known[key] = np.abs(_samples(model, at, frame, relative_to)[0]).max(axis=0, initial=0.0) > _STRUCTURAL
    return np.any(known[key][list(rows)], axis=0)


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
