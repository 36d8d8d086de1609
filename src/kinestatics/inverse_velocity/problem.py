"""What is asked: J q̇ = ξ on the rows that count, in arrays of one library, with shapes and values checked."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace, as_array
from ..quantities import Jacobian, JacobianMatrix, Pose, SixVector, Twist, check_batches
from ..spatial import ANGULAR
from ..tasks import model_of, without_rounding
from .rows import task_rows


@dataclass(frozen=True, eq=False)
class Problem:
    """J q̇ = ξ with the rows in their sizes and the free rows left out (set to zero: the same for least squares).

    Attributes:
        matrix: (..., r, n) rows in their sizes, zero where nothing is asked.
        target: (..., r) what they shall do, zero where nothing is asked.
        asked: (..., r) whether a row counts; False where the twist is NaN, and outside the task.
        sizes: (r) what each row was multiplied by: the length for angular rows.
        plain: (..., r, n) the Jacobian as given.
        xp: the array library.
        task: the rows of the task, from 0; None where it is all of them.
    """

    matrix: Array
    target: Array
    asked: Array
    sizes: Array
    plain: Array
    xp: Namespace
    task: tuple[int, ...] | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.matrix, self.target, self.asked, self.sizes, self.plain, self.task)

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.matrix.shape[-1])

    @property
    def batch(self) -> tuple[int, ...]:
        """The batch axes of Jacobian and twist together."""
        of_J, of_twist = tuple(self.matrix.shape[:-2]), tuple(self.target.shape[:-1])
        return np.broadcast_shapes(of_J, of_twist) if of_J and of_twist else of_J or of_twist

    def tolerance(self, wanted: float) -> float:
        """The tolerance asked for, or the rounding of the numbers at hand where that is coarser (single precision)."""
        if self.xp.name == "sympy":
            return wanted
        return max(wanted, 16 * max(self.matrix.shape[-2:]) * _rounding(self.matrix.dtype))


def _again(
    matrix: Array, target: Array, asked: Array, sizes: Array, plain: Array, task: tuple[int, ...] | None = None
) -> Problem:
    """The problem from what can be pickled of it."""
    return Problem(matrix, target, asked, sizes, plain, as_array(matrix)[1], task)


def read_problem(J: Any, twist: Any, length: float, task: Any = None) -> Problem:
    """The arrays of a Jacobian and a twist, its components outside the task free.

    Raises:
        ArrayTypeError: KS302. ConfigurationError: KS301 infinite, KS303 shapes, KS351 a task that a bare array has not.
        FrameMismatchError: KS330. UnknownNameError: KS318.
    """
    matrix, of_J = _read_jacobian(J)
    target, of_twist = _read_twist(twist, J)
    if of_J.name == "numpy" != of_twist.name:
        matrix = of_twist.constant(matrix, target)
    elif of_twist.name == "numpy" != of_J.name:
        target = of_J.constant(target, matrix)
    xp = of_twist if of_J.name == "numpy" else of_J
    rows = int(matrix.shape[-2])
    if target.shape[-1:] != (rows,):
        hint = f"one number for each row of the Jacobian: (..., {rows}); NaN where the component is free"
        raise ConfigurationError("KS303", f"the twist has shape {tuple(target.shape)}, the Jacobian {rows} rows", hint)
    if matrix.ndim > 2 and target.ndim > 1:
        check_batches("the Jacobian", matrix.shape[:-2], "the twist", target.shape[:-1])
    counted = None if task is None else task_rows(J, task, rows)
    if counted is not None and len(counted) < rows:
        target = _free_outside(target, counted, xp)
    plain, whole = matrix, False
    if xp.name == "numpy":
        whole = _checked_values(matrix, target)
        if isinstance(J, Jacobian) and not whole:  # the rows left may hold nothing but rounding
            matrix = without_rounding(model_of(J), matrix)
    size = 1.0 if length == 1.0 else checked_positive(length, "length", "the characteristic length in metres")
    sizes = np.ones(rows)
    if rows == 6:
        sizes[ANGULAR] = size
    asked = np.ones(target.shape, dtype=bool)
    if not whole:
        matrix, target, asked = _without_free_rows(matrix, target, xp)
    if size != 1.0 and rows == 6:
        weights = xp.constant(sizes, matrix)
        matrix, target = weights[:, None] * matrix, weights * target
    return Problem(matrix, target, asked, sizes, plain, xp, counted)


def _free_outside(target: Array, counted: tuple[int, ...], xp: Namespace) -> Array:
    """The target with NaN outside the rows that count."""
    inside = np.isin(np.arange(target.shape[-1]), counted)
    if xp.name in ("numpy", "sympy"):
        return np.where(inside, target, np.nan)
    return target + xp.constant(np.where(inside, 0.0, np.nan), target)  # NaN in every library, and under jit


def _without_free_rows(matrix: Array, target: Array, xp: Namespace) -> tuple[Array, Array, Array]:
    """Rows and target with zeros where the twist is NaN, and where it is not."""
    if xp.name == "sympy":
        asked = np.array([str(x) != "nan" for x in target.flat]).reshape(target.shape)
        return np.where(asked[..., None], matrix, 0), np.where(asked, target, 0), asked
    asked = target == target  # noqa: PLR0124 - False for NaN, in every library and under jit
    return select(xp, asked[..., None], matrix, 0.0), select(xp, asked, target, 0.0), asked


def _read_jacobian(J: Any) -> tuple[Array, Namespace]:
    if isinstance(J, SixVector | Pose) or (isinstance(J, JacobianMatrix) and not isinstance(J, Jacobian)):
        hint = "J = ks.jacobian(arm, q), or an array (..., rows, joints)"
        raise ArrayTypeError("KS302", f"expected a Jacobian or its array, not a {type(J).__name__}", hint)
    array, xp = as_array(J.array if isinstance(J, Jacobian) else J, "the Jacobian")
    if array.ndim < 2:
        raise ConfigurationError("KS303", f"the Jacobian has shape {tuple(array.shape)}; expected (..., rows, joints)")
    return array, xp


def _read_twist(twist: Any, J: Any) -> tuple[Array, Namespace]:
    if isinstance(twist, Twist):
        if not isinstance(J, Jacobian):
            hint = "pass the Jacobian itself, or twist.array where both are known to be in one frame"
            raise ArrayTypeError("KS302", "a Twist has a frame and a bare array none: they cannot be compared", hint)
        J.require_frame(twist.frame, "twist")
        return as_array(twist.array, "the twist")
    if isinstance(twist, SixVector | JacobianMatrix | Pose):
        hint = "ks.Twist.of(linear, angular), or an array (..., rows)"
        raise ArrayTypeError("KS302", f"expected a Twist or its array, not a {type(twist).__name__}", hint)
    array, xp = as_array(twist, "the twist")
    if array.ndim < 1:
        raise ConfigurationError("KS303", "the twist is a single number; expected (..., rows)")
    return array, xp


def _checked_values(matrix: Array, target: Array) -> bool:
    """Whether all components of the twist count; an error where a number is not finite."""
    if not np.isfinite(matrix).all():
        where = ", ".join(str(i) for i in np.argwhere(~np.isfinite(matrix))[0])
        raise ConfigurationError("KS301", f"the Jacobian is not finite at [{where}]", "pass finite numbers")
    if np.isfinite(target).all():
        return True
    if np.isinf(target).any():
        where = ", ".join(str(i) for i in np.argwhere(np.isinf(target))[0])
        raise ConfigurationError("KS301", f"the twist is infinite at [{where}]", "finite numbers, or NaN where it is free")
    return False


def read_rates(value: Any, name: str, problem: Problem) -> Array:
    """Joint rates (n) or (..., n) in the library of the problem, with batch axes that go with it.

    Raises:
        ArrayTypeError: KS302. ConfigurationError: KS303, KS301.
    """
    array, xp = as_array(value, name)
    if array.shape[-1:] != (problem.n,):
        hint = f"one for each joint: ({problem.n},) or (..., {problem.n})"
        raise ConfigurationError("KS303", f"{name} has shape {tuple(array.shape)}", hint)
    if xp.name == "numpy":
        if not np.isfinite(array).all():
            raise ConfigurationError("KS301", f"{name} is not finite", "pass finite numbers")
        array = problem.xp.constant(array, problem.matrix)
    elif xp.name != problem.xp.name:
        raise ArrayTypeError("KS302", f"{name} is an array of {xp.name}, the Jacobian of {problem.xp.name}", "use one")
    check_batches("the problem", problem.batch, name, tuple(array.shape[:-1]))
    return array


def checked_positive(value: Any, name: str, meaning: str) -> float:
    """A positive finite number.

    Raises:
        ConfigurationError: KS353.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not 0 < number < np.inf:
        raise ConfigurationError("KS353", f"{name} is {value!r}", f"a positive number: {meaning}")
    return number


def select(xp: Namespace, where: Array, one: Array, other: Any) -> Array:
    """`one` where true, `other` elsewhere: the only function of an array library that `Namespace` does not name."""
    library = {"numpy": "numpy", "sympy": "numpy", "jax": "jax.numpy", "torch": "torch"}[xp.name]
    return sys.modules[library].where(where, one, other)


@cache
def _rounding(dtype: Any) -> float:
    """The spacing of numbers of this type at 1."""
    torch = type(dtype).__module__ == "torch"
    return float((sys.modules["torch"] if torch else np).finfo(dtype).eps)
