"""The rows of a Jacobian that a task asks for: those of `tasks`, and of a bare array what can be said without a robot."""

from __future__ import annotations

import operator
from typing import Any

from ..errors import ConfigurationError, UnknownNameError
from ..quantities import Jacobian
from ..statics.symbols import with_numbers
from ..tasks import TASKS, find_task, model_of, named_rows, relative_to


def task_rows(J: Any, task: Any, rows: int) -> tuple[int, ...]:
    """The rows of J that count, from 0.

    Args:
        task: as in `find_task`; of a bare array of six rows not "auto", of any other numbers only.
        rows: how many J has.

    Raises:
        UnknownNameError: KS318. ConfigurationError: KS351 for what only a Jacobian with a robot has.
    """
    bare, named = not isinstance(J, Jacobian), isinstance(task, str)
    if bare and named and (task == "auto" or rows != 6):
        remedy = "pass the Jacobian itself, or say which rows: " + ("'vx,vy', [0, 1]" if rows == 6 else "[0, 1]")
        raise ConfigurationError("KS351", f"task={task!r} was given with a bare array of {rows} rows", remedy)
    if rows != 6:
        return _numbered(task, rows)
    if named and task == "auto":
        return _automatic(J)
    return TASKS[task] if named and task in TASKS else named_rows(task)


def _automatic(J: Jacobian) -> tuple[int, ...]:
    """The rows that the arm can move; those of a symbolic arm with numbers in place of its symbols."""
    model = model_of(J)
    numbers = with_numbers(model) if model.is_symbolic else model
    return find_task(numbers, "auto", J.link, J.frame, relative_to=relative_to(J)).rows


def _numbered(task: Any, rows: int) -> tuple[int, ...]:
    """Row numbers of a bare array of any number of rows."""
    try:
        found = sorted({operator.index(row) for row in task})
    except TypeError:
        found = []
    if not found or any(isinstance(row, bool) for row in task) or not 0 <= found[0] <= found[-1] < rows:
        raise UnknownNameError("KS318", f"task {task!r} is not known", f"row numbers from 0 to {rows - 1}, such as [0]")
    return tuple(found)
