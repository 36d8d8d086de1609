"""How JointRates print."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..namespaces import Array
from ..quantities import TIED, Jacobian, Twist, format_number, named_table, numeric, wrapped
from ..spatial import ROW_NAMES
from ..tasks import model_of, prismatic_columns, task_of

if TYPE_CHECKING:
    from .result import JointRates


def joint_units(J: Any, n: int) -> tuple[str, ...]:
    """(n) "rad/s" or "m/s"; empty words for a bare array, whose joints are not known."""
    if not isinstance(J, Jacobian):
        return ("",) * n
    return tuple("m/s" if prismatic else "rad/s" for prismatic in prismatic_columns(model_of(J)))


def rates_table(names: tuple[str, ...], rates: Array, units: tuple[str, ...]) -> str:
    """One line a joint."""
    rows = [[f"  {name}", format_number(x), unit] for name, x, unit in zip(names, rates, units, strict=True)]
    return named_table(rows, "joints") if rows else "  (no joints)"


def described(found: JointRates) -> str:
    """One set of rates with everything a person wants to see; a batch in one line."""
    symbolic = found.problem.xp.name == "sympy"
    if len(found.array.shape) > 1:
        return f"{found!r}\n{found.reason}"
    rates = found.array if symbolic else np.asarray(found)
    names, units = found.joint_names, joint_units(found.jacobian, len(rates))
    lines = [f"joint rates by {found.method}{_how(found)}", rates_table(names, rates, units)]
    if found.task is not None:
        lines.append(wrapped("task: ", f"{', '.join(found.task)}; the rest is free"))
    if symbolic:
        return "\n".join(lines)
    lines.append(wrapped("", found.reason, hang=2))
    if not found.reachable and np.all(found.problem.asked):
        lines.append(wrapped("hint: ", _hint(found.jacobian)))
    lines.append(wrapped("achieved: ", _components(found.achieved, np.ones(len(found.problem.sizes), dtype=bool))))
    residual = np.asarray(found.residual)
    if np.abs(residual).max(initial=0.0) > 1e-12 * (1.0 + np.abs(numeric(found.problem.target)).max(initial=0.0)):
        lines.append(wrapped("residual: ", _components(found.residual, numeric(found.problem.asked))))
    return "\n".join(lines + _about_limits(found))


def _hint(J: Any) -> str:
    """What to do about a twist that asks for too much."""
    free = "a component given as NaN is free, and left out"
    if not isinstance(J, Jacobian) or len(auto := task_of(J).row_names) == len(ROW_NAMES):
        return free
    return f"task='auto' asks only for what this arm can do, {', '.join(auto) or 'nothing'}; {free}"


def row_names(typed: bool, count: int) -> tuple[str, ...]:
    """(count) "vx", ... of a Jacobian or Twist, "row 1", ... of a bare array."""
    return ROW_NAMES if typed else tuple(f"row{TIED}{k + 1}" for k in range(count))


def _how(found: JointRates) -> str:
    if found.method == "damped":
        return f", damping {format_number(found.damping)}"
    if found.method == "adaptive":
        return f", damping at most {format_number(np.max(np.asarray(numeric(found.damping)), initial=0.0))}"
    if found.method == "qr" and np.any(found.by_svd):
        return " (by SVD: not of full rank)"
    return ""


def _components(value: Any, shown: Array) -> str:
    array = np.asarray(value)
    names = row_names(isinstance(value, Twist), len(array))
    told = [f"{name}{TIED}{format_number(x)}" for name, x, yes in zip(names, array, shown, strict=True) if yes]
    return ", ".join(told) or "nothing is asked"


def _about_limits(found: JointRates) -> list[str]:
    if found.limits is None:
        return []
    met = "; ".join(word.replace(" ", TIED) for word in found.limiting) or "no limit is met"
    if found.method == "qp" and found.scale == 0.0 and not found.keeps_direction:
        return [wrapped("limits: ", f"no share of the speed fits; the closest inside them, in another direction: {met}")]
    if not found.keeps_direction and found.method != "qp":
        return [wrapped("limits: ", f"no share of the speed fits; joints are cut off singly, in another direction: {met}")]
    if found.scale < 1.0:
        return [wrapped("limits: ", f"slowed to {format_number(found.scale)} of the speed by {met}")]
    return [wrapped("limits: ", met)]
