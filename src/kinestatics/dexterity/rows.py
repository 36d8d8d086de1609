"""The rows a measure looks at, how many of their singular values count, and what makes metres and radians comparable.

A bare array is taken as it is: all its rows count. For a `Jacobian` the rows in play are found by `tasks`, and the
characteristic length is asked for where they mix metres and radians. This is the one definition of all that: measures,
ellipsoids, gradients and the analysis go through it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import Frame
from ..model import RobotModel
from ..namespaces import Array, Namespace, as_array
from ..quantities import Jacobian, JacobianMatrix, Pose, SixVector
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS
from ..statics import RANK_TOLERANCE
from ..statics.symbols import with_numbers
from ..tasks import Task, find_task, model_of, moving_columns, prismatic_columns, relative_to, without_rounding

ANGULAR_SCALED, PRISMATIC_SCALED = "angular rows", "prismatic columns"
_SINGLE = 1e-5  # of single precision, what RANK_TOLERANCE is of double
_CACHED = 64
_SAMPLES, _STRUCTURAL = 24, 1e-9  # as in `tasks`

TaskName = str | Sequence[str] | Sequence[int]
"""Rows in play, as in `find_task`."""


@dataclass(frozen=True, eq=False)
class RowsInPlay:
    """The rows a measure looks at.

    Attributes:
        array: (..., r, n), scaled by the characteristic length where `scaled` says so.
        xp: its array library.
        rank: how many singular values count: what the arm reaches at almost every posture; min(r, n) for a bare array.
        task: the rows of a Jacobian; None for a bare array.
        frame, link: those of a Jacobian; None and "".
        length: characteristic length [m]; None where nothing is scaled.
        scaled: which of "angular rows" and "prismatic columns" are multiplied by it.
        row_weights: (r) and column_weights (n): what the rows and columns of the Jacobian were multiplied by.
    """

    array: Array
    xp: Namespace
    rank: int
    task: Task | None
    frame: Frame | None
    link: str
    length: float | None
    scaled: tuple[str, ...]
    row_weights: Array
    column_weights: Array

    @property
    def tolerance(self) -> float:
        """Singular values below this fraction of the largest count as zero."""
        return RANK_TOLERANCE if self.xp.name == "sympy" or self.array.dtype.itemsize >= 8 else _SINGLE


def rows_in_play(
    rows: Any, task: TaskName = "auto", length: Any = None, *, needs_length: bool = True, weigh_joints: bool = True
) -> RowsInPlay:
    """The rows of a Jacobian, or of a bare array, that a measure looks at.

    Args:
        rows: a `Jacobian`, or any array (..., r, n).
        task: which rows of a Jacobian, as in `find_task`.
        length: characteristic length [m], for a Jacobian whose rows or joints mix metres and radians.
        needs_length: whether the answer depends on it where the rows do.
        weigh_joints: whether prismatic columns are multiplied by it where the joints mix (not if they have scales of their
            own, or a mass matrix).

    Raises:
        ArrayTypeError: KS302 for a twist, a Hessian, text, ...
        ConfigurationError: KS303 for a shape without rows and columns, or a length that is not positive; KS360 where rows
            of metres and radians meet without a length; KS361 for task or length with a bare array.
        UnknownNameError: KS318 for a task or row that does not exist.
    """
    if not isinstance(rows, Jacobian):
        return _bare(rows, task, length)
    array, xp = as_array(rows.array, "the Jacobian")
    model = model_of(rows)
    found, scaled = _structure(rows, model, task)
    if xp.name == "numpy":
        array = without_rounding(model, array)
    if not weigh_joints:
        scaled = tuple(word for word in scaled if word != PRISMATIC_SCALED)
    if needs_length and length is None and ANGULAR_SCALED in scaled:
        raise _length_missing(found)
    size = None if length is None else _checked_length(length, xp)
    scaled = scaled if size is not None else ()
    by_joint: Any = size if PRISMATIC_SCALED in scaled else 1
    weights = row_weights(found.rows, size if ANGULAR_SCALED in scaled else 1)
    columns = np.where(prismatic_columns(model), by_joint, 1)
    chosen = array[..., np.array(found.rows, dtype=int), :]
    if scaled:
        chosen = chosen * xp.constant(weights[:, None] * columns, array)
    used = size if scaled else None
    return RowsInPlay(chosen, xp, found.rank, found, rows.frame, rows.link, used, scaled, weights, columns)


def _structure(J: Jacobian, model: RobotModel, task: TaskName) -> tuple[Task, tuple[str, ...]]:
    """The rows in play and what mixes in them, kept with the model: they are sampled, and do not depend on q."""
    named = task if isinstance(task, str) or not isinstance(task, Iterable) else tuple(map(repr, task))
    key = (named, J.link, J.frame, relative_to(J))
    known: dict[Any, tuple[Task, tuple[str, ...]]] = model.__dict__.setdefault("_structures", {})
    if (structure := known.get(key)) is None:
        numbers = with_numbers(model) if model.is_symbolic else model
        found = find_task(numbers, task, J.link, J.frame, relative_to=relative_to(J))
        if len(known) >= _CACHED:
            known.clear()
        structure = known[key] = found, mixed_units(found, numbers, J.link, J.frame, relative_to(J))
    return structure


def _bare(rows: Any, task: TaskName, length: Any) -> RowsInPlay:
    if isinstance(rows, JacobianMatrix | SixVector | Pose):
        hint = "J = ks.jacobian(arm, q), or an array (..., rows, joints)"
        raise ArrayTypeError("KS302", f"expected a Jacobian or its rows, not a {type(rows).__name__}", hint)
    array, xp = as_array(rows, "the Jacobian")
    if array.ndim < 2:
        hint = "rows and joints last: (..., r, n), such as J.linear"
        raise ConfigurationError("KS303", f"the rows have shape {tuple(array.shape)}", hint)
    if length is not None or not (isinstance(task, str) and task == "auto"):
        word = "length" if length is not None else "task"
        hint = "pass the Jacobian itself, or choose and scale the rows yourself"
        raise ConfigurationError("KS361", f"{word}= was given with a bare array, whose rows are not known by name", hint)
    r, n = (int(size) for size in array.shape[-2:])
    return RowsInPlay(array, xp, min(r, n), None, None, "", None, (), np.ones(r), np.ones(n))


def row_weights(rows: Sequence[int], length: Any) -> Array:
    """(r) ones for linear rows and the characteristic length for angular ones."""
    return np.array([length if row in ANGULAR_ROWS else 1 for row in rows])  # no 1.0 in symbols


def mixed_units(
    task: Task, model: RobotModel, at: str, frame: Frame | None = None, relative: str | None = None
) -> tuple[str, ...]:
    """Where radians stand beside metres, in the rows or in the joints, and the characteristic length comes in."""
    angular = [row in ANGULAR_ROWS for row in task.rows]
    found = (ANGULAR_SCALED,) if any(angular) and not all(angular) else ()
    prismatic, moving = prismatic_columns(model), moving_columns(model, task.rows, at, frame, relative)
    mixed_joints = bool(np.any(moving & prismatic) and np.any(moving & ~prismatic))
    return (*found, PRISMATIC_SCALED) if mixed_joints else found


def manipulability_unit(task: Task, model: RobotModel, at: str) -> str:
    """Unit of the manipulability without a length: that of the minors of the rows, where all have the same one."""
    linear = sum(row in LINEAR_ROWS for row in task.rows)
    if (task.rank < len(task.rows) and linear not in (0, len(task.rows))) or not task.rank:
        return "mixed units" if task.rank else "1"
    prismatic, moving = prismatic_columns(model), moving_columns(model, task.rows, at)
    travelling = int(np.sum(moving & prismatic))
    if travelling and travelling < moving.sum() != task.rank:
        return "mixed units"
    power = (task.rank if linear == len(task.rows) else linear) - min(travelling, task.rank)
    return "1" if power == 0 else "m" if power == 1 else f"m^{power}"


def _length_missing(task: Task) -> ConfigurationError:
    names = ", ".join(task.row_names)
    hint = "length=ks.characteristic_length(arm), or rows of one unit: task='position', task='orientation', J.linear"
    return ConfigurationError("KS360", f"the rows {names} mix metres and radians, and the answer depends on how", hint)


def _checked_length(length: Any, xp: Namespace) -> Any:
    if xp.name == "sympy" and hasattr(length, "free_symbols"):
        return length
    try:
        value = float(length)
    except (TypeError, ValueError):
        value = np.nan
    if not 0 < value < np.inf:
        hint = "a positive length in metres, such as ks.characteristic_length(arm)"
        raise ConfigurationError("KS303", f"characteristic length is {length!r}", hint)
    return value


def decomposed(array: Array, xp: Namespace) -> tuple[Array, Array, Array]:
    """U (..., r, k), σ (..., k) descending and Vᵀ (..., k, n) of (..., r, n); NaN where a NumPy matrix is not finite."""
    if xp.name != "numpy":
        return tuple(xp.linalg.svd(array, full_matrices=False))
    clean, bad = _finite(array)
    U, sigma, Vt = np.linalg.svd(clean, full_matrices=False)
    return U, np.where(bad[..., None], np.nan, sigma), Vt


def singular(array: Array, xp: Namespace) -> Array:
    """(..., k) singular values, descending; NaN where a NumPy matrix is not finite."""
    if xp.name != "numpy":
        return xp.linalg.svdvals(array)
    clean, bad = _finite(array)
    return np.where(bad[..., None], np.nan, np.linalg.svd(clean, compute_uv=False))


def _finite(array: Array) -> tuple[Array, Array]:
    """The array with zeros for matrices that are not finite, and which those are: LAPACK refuses a whole batch for one."""
    bad = ~np.all(np.isfinite(array), axis=(-2, -1))
    return (np.where(bad[..., None, None], 0.0, array) if np.any(bad) else array), bad
