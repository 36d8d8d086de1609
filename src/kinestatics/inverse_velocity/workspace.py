"""DAQP for one problem after the other in the same arrays, by the quickest way that its installed version gets right.

A workspace that stays, and reads our arrays where they lie, needs no more than the word that they have changed. That is
not promised by every version of DAQP (0.8.7 to 0.9.1 then lose the bounds without a word), so that the ways are tried on
problems with known answers, from the quickest to the plainest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from .quadratic import Bounded, solve, solver

_SETTINGS = {"primal_tol": 1e-10}
_RIGHT = 1e-6  # of costs and rates, relative: what tells a wrong way from the rounding of squares
_INSIDE = 1e-10  # relative; bounds met less exactly than that are cut off


class Arrays(NamedTuple):
    """H (n, n), f (n), upper and lower (n): min xᵀHx/2 + fᵀx with lower <= x <= upper."""

    H: Array
    f: Array
    upper: Array
    lower: Array


class Workspace(NamedTuple):
    """How the problem that stands in the arrays is solved.

    Attributes:
        tell: to be called when the arrays have changed.
        solve: → rates, cost, flag (1: solved), information.
        exact: whether bounds are met to 1e-10, so that nothing need be cut off.
        way: what opens another one like it, on the problem that stands in the arrays.
    """

    tell: Callable[[], Any]
    solve: Callable[[], Any]
    exact: bool = True
    way: Callable[[Arrays], Any] | None = None


def open_workspace(arrays: Arrays, trials: Sequence[Bounded]) -> Workspace:
    """The quickest way that solves the trials.

    Args:
        arrays: they stay where they are and are written to by the caller.
        trials: problems with finite bounds of the variables; the arrays hold the last of them afterwards.

    Raises:
        MissingExtraError: KS400. ConfigurationError: KS356, where no way solves them.
    """
    known = [solve(trial, np.clip(np.zeros(len(arrays.f)), trial.lower, trial.upper)) for trial in trials]
    for way in (_told_of_H, _told_of_all, _anew):
        _write(arrays, trials[0])
        if (found := way(arrays)) is None:
            continue
        excess = max(_excess(found, arrays, trial, x) for trial, x in zip(trials, known, strict=True))
        if excess <= _RIGHT:
            return found._replace(exact=excess <= _INSIDE, way=way)
    message = "the installed DAQP does not solve problems whose answers are known"
    raise ConfigurationError("KS356", message, "pip install --upgrade daqp")


def _told_of_H(arrays: Arrays) -> Workspace | None:
    """A workspace that reads all arrays anew when it is told that H has changed."""
    if (model := _model(arrays)) is None:
        return None
    return Workspace(partial(model.update, arrays.H), model.solve)


def _told_of_all(arrays: Arrays) -> Workspace | None:
    """A workspace to which all arrays are handed over every time."""
    if (model := _model(arrays)) is None:
        return None
    return Workspace(partial(model.update, arrays.H, arrays.f, None, arrays.upper, arrays.lower), model.solve)


def _anew(arrays: Arrays) -> Workspace:
    """No workspace: every problem is the first."""
    n = len(arrays.f)
    others = np.zeros((0, n)), arrays.upper, arrays.lower, np.zeros(n, dtype=np.intc)
    return Workspace(lambda: None, partial(solver().solve, arrays.H, arrays.f, *others, **_SETTINGS))


def _model(arrays: Arrays) -> Any:
    """A workspace set up with the problem that stands in the arrays; None where DAQP is too old to have one."""
    if not hasattr(solver(), "Model"):
        return None
    model, n = solver().Model(), len(arrays.f)
    model.settings = _SETTINGS
    model.setup(arrays.H, arrays.f, np.zeros((0, n)), arrays.upper, arrays.lower, np.zeros(n, dtype=np.intc))
    return model


def _write(arrays: Arrays, trial: Bounded) -> None:
    arrays.H[:] = trial.A.T @ trial.A + trial.damping**2 * np.eye(len(arrays.f))
    arrays.f[:] = -trial.A.T @ trial.b
    arrays.upper[:], arrays.lower[:] = trial.upper, trial.lower


def _excess(found: Workspace, arrays: Arrays, trial: Bounded, known: Array) -> float:
    """How far a way misses an answer: what it exceeds a bound by, relative, or far more where the cost is not the least."""
    _write(arrays, trial)
    found.tell()
    x, _, flag, _ = found.solve()
    if flag != 1 or not np.all(np.isfinite(x)):
        return np.inf
    lost = _cost(trial, x) - _cost(trial, known)
    if abs(lost) > _RIGHT * float(trial.b @ trial.b):
        return np.inf
    size = 1.0 + np.maximum(np.abs(trial.upper), np.abs(trial.lower))
    return float(np.max(np.maximum(x - trial.upper, trial.lower - x) / size, initial=0.0))


def _cost(trial: Bounded, x: Array) -> float:
    rest = trial.A @ x - trial.b
    return float(rest @ rest + trial.damping**2 * (x @ x))
