"""The check of generated code: its steps, the expression and the numeric definition agree at random numbers. Floor 7."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ... import definition
from ...errors import KinestaticsError
from ...kinematics import acceleration, jacobian, pose
from ...namespaces import Array, as_array
from ..closed_form import ClosedForm
from ..exact import free_symbols
from ..values import in_numbers
from .arithmetic import evaluated
from .programs import Program
from .steps import Steps

_CLOSE = 1e-12
_SEED = 20261128
_DRAWS = 2


class Numbers(NamedTuple):
    """Numbers for every symbol of a closed form and of its robot."""

    q: Array
    values: Mapping[Any, float]


def drawn(form: ClosedForm, seed: int = 0) -> Numbers:
    """Pseudo-random numbers for the symbols of a closed form."""
    rng = np.random.default_rng(_SEED + seed)
    asked, joints = form.question, form.symbols["joints"]
    q = rng.uniform(-2.0, 2.0, len(joints))
    found = set(free_symbols(asked.model)) | set(form.expression.free_symbols)
    for several in (asked.qd, asked.qdd, asked.wrench, asked.gravity, asked.point, asked.offset):
        found |= set().union(*(x.free_symbols for x in several))
    others = sorted(found - set(joints), key=str)
    values = {x: float(form.values[x]) if x in form.values else float(rng.uniform(0.3, 1.7)) for x in others}
    return Numbers(q, values | dict(zip(joints, q.tolist(), strict=True)))


def by_definition(form: ClosedForm, numbers: Numbers) -> Array:
    """The quantity of a closed form by the numeric definition, in the shape of its expression."""
    asked, values = form.question, numbers.values
    model = in_numbers(asked.model, values)

    def several(entries: Iterable[Any]) -> Array:
        return np.array([evaluated(x, values) for x in entries])

    if form.quantity == "pose":
        return pose(model, numbers.q, at=form.link, point=several(asked.point).tolist(), check_finite=False).array
    if form.quantity == "gravity_torques":
        array, xp = as_array(numbers.q)
        return definition.gravity_torques(model, array, several(asked.gravity), xp)[:, None]
    assert asked.frame is not None
    frame = asked.frame._replace(offset=tuple(several(asked.offset).tolist()))
    options: dict[str, Any] = {"at": form.link, "frame": frame, "check_finite": False}
    rows = list(asked.rows)
    if form.quantity == "acceleration":
        found = acceleration(model, numbers.q, several(asked.qd), several(asked.qdd), **options)
        return found.array[rows][:, None]
    J = jacobian(model, numbers.q, **options).array[rows]
    if form.quantity == "velocity":
        return (J @ several(asked.qd))[:, None]
    if form.quantity == "joint_torques":
        return (J.T @ several(asked.wrench))[:, None]
    if form.quantity == "determinant":
        return np.array(np.linalg.det(J))
    return _minors(J) if form.quantity == "minors" else J


def _minors(J: Array) -> Array:
    """(k, 1) all the largest ones."""
    wide = J if J.shape[1] >= J.shape[0] else J.T
    kept = itertools.combinations(range(wide.shape[1]), len(wide))
    return np.array([[np.linalg.det(wide[:, columns])] for columns in kept])


def check_steps(program: Program, steps: Steps) -> None:
    """Raises KinestaticsError (KS396) unless steps, expression and definition agree at random numbers."""
    for seed in range(_DRAWS):
        expected, values = None, dict[Any, float]()
        if program.form is not None:
            numbers = drawn(program.form, seed)
            values = dict(numbers.values)
            expected = by_definition(program.form, numbers).ravel()
        rng = np.random.default_rng(_SEED + seed)
        symbols = [x for argument in program.arguments for x in argument.symbols]
        values |= {x: float(rng.uniform(0.2, 0.9)) for x in symbols if x not in values}
        try:
            plain = np.array([evaluated(entry, values) for entry in program.entries])
            for symbol, x in steps.assignments:
                values[symbol] = evaluated(x, values)
            found = np.array([evaluated(x, values) for x in steps.results])
        except KinestaticsError:
            raise
        except (ArithmeticError, ValueError, TypeError) as error:
            hint = "check=False leaves the check out"
            raise KinestaticsError("KS396", f"the code could not be checked: at random numbers, {error}", hint) from None
        _compare(found, plain, "the expression")
        if expected is not None:
            _compare(found, expected, "the numeric definition")


def _compare(found: Array, expected: Array, what: str) -> None:
    off = np.abs(found - expected).max(initial=0.0)
    if not off <= _CLOSE * max(1.0, float(np.abs(expected).max(initial=0.0))):
        raise KinestaticsError(
            "KS396", f"the code differs from {what} by {off:.2g}", "this is a fault of kinestatics: please report it"
        )
