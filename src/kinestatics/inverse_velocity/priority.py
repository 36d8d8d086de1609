"""prioritized_rates: several tasks in strict order, none of which disturbs those before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array
from ..quantities import WIDTH, Jacobian, Twist, check_batches, format_number, table, wrapped
from ..spatial import rotate, transpose
from ..statics import RANK_TOLERANCE
from .given_limits import read_limits
from .limits import RateLimits
from .problem import Problem, checked_positive, read_problem
from .quadratic import in_strict_order, solver
from .spectral import damped_gain, spectrum
from .text import joint_units, rates_table


class TaskOutcome(NamedTuple):
    """What became of one task.

    Attributes:
        name: the link of its Jacobian, or "task 1".
        twist: as given.
        achieved: J q̇, a Twist or a bare array.
        residual: (..., r) what is missing, 0 where a component is free; angular rows in [rad/s].
        missing: (...) size of the residual, |(v, length · ω)|.
        achieved_fully: (...) whether nothing is missing but rounding.
    """

    name: str
    twist: Any
    achieved: Any
    residual: Array
    missing: Array
    achieved_fully: Array


@dataclass(frozen=True, eq=False, repr=False)
class PrioritizedRates:
    """Joint rates for tasks in strict order; made by `prioritized_rates`. `np.asarray` gives the bare rates.

    Attributes:
        array: (..., n) joint rates [rad/s or m/s].
        given: the tasks, (J, twist) each, the most important first.
        tolerance, length, damping, limits: as asked for.
        problems: the tasks in the form they were solved in.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_3r")
        >>> tip, elbow = ks.jacobian(arm, [0, 0.5, 1]), ks.jacobian(arm, [0, 0.5, 1], at="link2")
        >>> found = ks.prioritized_rates([(tip.linear, [1, 0, 0]), (elbow.linear, [0, 0, 0])])
        >>> [bool(task.achieved_fully) for task in found.tasks]
        [True, False]
    """

    array: Array
    given: tuple[tuple[Any, Any], ...]
    tolerance: float
    length: float
    damping: float
    limits: RateLimits | None
    problems: tuple[Problem, ...]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.array, dtype=dtype, copy=copy)

    @cached_property
    def tasks(self) -> tuple[TaskOutcome, ...]:
        """What became of each task, in their order."""
        found = []
        for k, ((J, twist), problem) in enumerate(zip(self.given, self.problems, strict=True)):
            made = rotate(problem.plain, self.array)
            rest = problem.target - problem.sizes * np.where(problem.asked, made, 0.0)
            missing = np.linalg.norm(rest, axis=-1)
            size = np.linalg.norm(problem.target, axis=-1) + np.linalg.norm(problem.matrix, axis=(-2, -1)) * np.linalg.norm(
                self.array, axis=-1
            )
            name = J.link if isinstance(J, Jacobian) else f"task {k + 1}"
            achieved = Twist(made, J.frame) if isinstance(J, Jacobian) else made
            found.append(TaskOutcome(name, twist, achieved, rest / problem.sizes, missing, missing <= 1e-9 * size))
        return tuple(found)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """(n) names of the joints; "q1" ... where no task has a Jacobian with names."""
        named = [J.joint_names for J, _ in self.given if isinstance(J, Jacobian)]
        return named[0] if named else tuple(f"q{k + 1}" for k in range(self.array.shape[-1]))

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        tasks = [
            {
                "name": task.name,
                "achieved": np.asarray(task.achieved).tolist(),
                "residual": task.residual.tolist(),
                "missing": task.missing.tolist(),
                "achieved_fully": task.achieved_fully.tolist(),
            }
            for task in self.tasks
        ]
        numbers = {"tolerance": self.tolerance, "length": self.length, "damping": self.damping}
        return {"joint_names": list(self.joint_names), "rates": self.array.tolist(), "tasks": tasks, **numbers}

    def __repr__(self) -> str:
        return f"<PrioritizedRates for {len(self.given)} tasks, shape {self.array.shape}>"

    def __str__(self) -> str:
        if self.array.ndim > 1:
            return repr(self)
        units = next((joint_units(J, 0) for J, _ in self.given if isinstance(J, Jacobian)), ("",) * self.array.shape[-1])
        rows = [
            [f"  {k + 1} {task.name}", "achieved" if task.achieved_fully else f"missing {format_number(task.missing)}"]
            for k, task in enumerate(self.tasks)
        ]
        told = table(rows)
        if max(len(line) for line in told.splitlines()) > WIDTH:
            told = "\n".join(wrapped("", "  ".join(row), hang=4) for row in rows)
        head = "joint rates for tasks in strict order" + (", inside limits" if self.limits is not None else "")
        return f"{head}\n{rates_table(self.joint_names, self.array, units)}\ntasks\n{told}"


def prioritized_rates(
    tasks: Sequence[tuple[Any, Any]],
    *,
    damping: float = 0.0,
    limits: Any = None,
    length: float = 1.0,
    tolerance: float = RANK_TOLERANCE,
) -> PrioritizedRates:
    """Joint rates for several tasks in strict order: each does what it can without disturbing those before it.

    Args:
        tasks: (J, twist) each, the most important first; any links, frames and rows, NaN in a twist is a free component.
        damping: λ [the unit of the rows] of every level; 0: none. The order is kept whatever it is.
        limits: as in `joint_rates`: kept before all tasks, by a cascade of quadratic programs (package daqp).
        length: a twist's size is |(v, length · ω)| [m].
        tolerance: singular values of what is left of a task below this fraction of the task's largest count as zero.

    Returns:
        PrioritizedRates; `.array` (..., n). Of all rates that serve the tasks equally well, the smallest.

    Raises:
        As `joint_rates`; KS303 for tasks of different numbers of joints, KS351 for damping together with limits.

    Law: q̇_k = q̇_(k-1) + (J_k P_(k-1))⁺ (ξ_k - J_k q̇_(k-1)), P_k the projector on the null space of J_1 ... J_k together.
    Source: Siciliano, Slotine, "A general framework for managing multiple tasks in highly redundant robotic systems",
    ICAR 1991; with limits: Kanoun, Lamiraux, Wieber, IEEE Trans. Robotics 27(4), 2011.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("panda")
        >>> tip, elbow = ks.jacobian(arm, arm.home), ks.jacobian(arm, arm.home, at="panda_link4")
        >>> stay = ks.Twist.of(frame=elbow.frame)
        >>> found = ks.prioritized_rates([(tip, ks.Twist.of((0, 0.1, 0))), (elbow, stay)])
        >>> [bool(task.achieved_fully) for task in found.tasks]
        [True, False]
    """
    given = _read_tasks(tasks)
    problems = tuple(read_problem(J, twist, length) for J, twist in given)
    _check_together(problems)
    _check_one_robot(given)
    small = max(p.tolerance(checked_positive(tolerance, "tolerance", "such as 1e-10")) for p in problems)
    if damping != 0.0:
        checked_positive(damping, "damping", "or 0, in the unit of the rows")
    batch: tuple[int, ...] = ()
    for k, p in enumerate(problems):
        check_batches("the tasks before", batch, f"task {k + 1}", p.batch)
        batch = np.broadcast_shapes(batch, p.batch)
    if limits is None:
        return PrioritizedRates(_recursive(problems, batch, damping, small), given, small, length, damping, None, problems)
    if damping != 0.0:
        raise ConfigurationError("KS351", "damping together with limits", "the limits already bound the rates: damping=0")
    named = next((J for J, _ in given if isinstance(J, Jacobian)), given[0][0])
    bounds = read_limits(limits, problems[0], batch, named)
    rates = _inside(problems, batch, bounds, small)
    return PrioritizedRates(rates, given, small, length, damping, bounds, problems)


def _recursive(problems: Sequence[Problem], batch: tuple[int, ...], damping: float, tolerance: float) -> Array:
    """One level after the other; what earlier levels use is kept as an orthonormal basis, so that nothing leaks into it.

    A level's directions are judged against the size of its own Jacobian, not of what is left of it: what rounding leaves
    of a task that is in conflict is no direction.
    """
    n = problems[0].n
    rates, used = np.zeros((*batch, n)), np.zeros((*batch, n, 0))
    for p in problems:
        left = _outside(np.broadcast_to(p.matrix, (*batch, *p.matrix.shape[-2:])), used)
        own = np.linalg.norm(p.matrix, 2, axis=(-2, -1)) if min(p.matrix.shape[-2:]) else np.zeros(p.matrix.shape[:-2])
        found = spectrum(left, p.xp, tolerance)
        counted = found.sigma > tolerance * np.asarray(own)[..., None]
        found = type(found)(found.U, found.sigma, found.Vt, counted, found.xp)
        gain = np.where(counted, damped_gain(found, damping), 0.0)
        step = found.rates(p.target - rotate(p.matrix, rates), gain)
        rates = rates + _outside(step[..., None, :], used)[..., 0, :]  # weak directions carry rounding of the strong ones
        used = np.concatenate([used, _new_basis(found.Vt, counted, used)], axis=-1)
    return rates


def _outside(rows: Array, used: Array) -> Array:
    """Rows (..., r, n) without their parts in the span of `used` (..., n, k); twice, since once leaves rounding."""
    for _ in range(2):
        rows = rows - (rows @ used) @ transpose(used)
    return rows


def _new_basis(Vt: Array, counted: Array, used: Array) -> Array:
    """(..., n, k) orthonormal directions that a level adds, zero columns in the place of those that do not count.

    Singular values descend, so that those that count come first, and QR makes them orthonormal in their own span.
    """
    fresh = _outside(np.where(counted[..., None], Vt, 0.0), used)
    Q, _ = np.linalg.qr(transpose(fresh))
    return np.where(counted[..., None, : Q.shape[-1]], Q, 0.0)


def _inside(problems: Sequence[Problem], batch: tuple[int, ...], limits: RateLimits, tolerance: float) -> Array:
    """A cascade of quadratic programs, and the smallest rates last."""
    solver()
    n = problems[0].n
    lower, upper = (np.broadcast_to(bound, (*batch, n)) for bound in (limits.lower, limits.upper))
    matrices = [np.broadcast_to(p.matrix, (*batch, *p.matrix.shape[-2:])) for p in problems]
    targets = [np.broadcast_to(p.target, (*batch, p.target.shape[-1])) for p in problems]
    rates = np.zeros((*batch, n))
    for k in np.ndindex(batch):
        levels = [(A[k], b[k]) for A, b in zip(matrices, targets, strict=True)] + [(np.eye(n), np.zeros(n))]
        start = np.clip(np.zeros(n), lower[k], upper[k])
        x = in_strict_order(levels, np.eye(n), lower[k], upper[k], start, tolerance)
        rates[k] = np.clip(start if x is None else x, lower[k], upper[k])  # never None: a point inside was given
    return rates


def _read_tasks(tasks: Any) -> tuple[tuple[Any, Any], ...]:
    try:
        given = tuple((J, twist) for J, twist in tasks)
    except (TypeError, ValueError):
        hint = "[(J_tip, twist), (J_elbow, other)], the most important first"
        raise ArrayTypeError("KS302", "tasks are no pairs of a Jacobian and a twist", hint) from None
    if not given:
        raise ConfigurationError("KS303", "there are no tasks", "[(J, twist), ...]")
    return given


def _check_one_robot(given: Sequence[tuple[Any, Any]]) -> None:
    """Raises ConfigurationError (KS303) where two Jacobians have joints of other names."""
    jacobians = [(k, J) for k, (J, _) in enumerate(given) if isinstance(J, Jacobian)]
    for k, J in jacobians[1:]:
        if J.joint_names != jacobians[0][1].joint_names:
            message = f"task {k + 1} has other joints than task {jacobians[0][0] + 1}: {', '.join(J.joint_names)}"
            raise ConfigurationError("KS303", message, "Jacobians of one robot")


def _check_together(problems: Sequence[Problem]) -> None:
    for k, p in enumerate(problems):
        if p.xp.name != "numpy":
            raise ArrayTypeError("KS302", f"task {k + 1} is in arrays of {p.xp.name}", "priorities run on NumPy")
        if p.n != problems[0].n:
            message = f"task {k + 1} has {p.n} joints, task 1 has {problems[0].n}"
            raise ConfigurationError("KS303", message, "Jacobians of one robot")
