"""`singularities`: from a robot to the closed form of its singular set."""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping, Sequence
from math import comb
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..kinematics import jacobian, require_model
from ..model import RobotModel
from ..spatial import LINEAR_ROWS
from ..symbolic.branches import Splitter
from ..symbolic.chain import ExactChain, determinant
from ..symbolic.exact import exact, free_symbols
from ..symbolic.halfangle import HalfAngleRing
from ..symbolic.printing import shortest
from ..symbolic.ring import Polynomial
from ..symbolic.values import in_numbers
from ..tasks import Task, find_task
from .components import Component, components_of
from .equations import Equation, Space, equations
from .singular_set import SingularSet

_BUDGET = 20.0
_RESIDUAL_SAMPLES = 32
_WITH_SAMPLES = 1.5  # of the budget, at which components are no longer sampled
_MOST_MINORS = 500
_MOST_ANGLES = 3  # that are general: with more, polynomials of a robot of numbers grow beyond use
_SHORT = 40  # terms of a factor whose zeros are looked for while conditions are split


def singularities(
    model: RobotModel,
    task: str | Sequence[str] | Sequence[int] = "auto",
    *,
    at: str = TIP,
    lengths: str | Mapping[Any, float] = "auto",
    tolerance: float = 1e-5,
    budget: float = _BUDGET,
) -> SingularSet:
    """Where an arm is singular, in closed form.

    Args:
        model: the robot; its lengths may be symbols.
        task: the rows in play, as in `find_task`.
        at: the link.
        lengths: of a robot of numbers: "auto", "named" (a2, d4, ... after Denavit and Hartenberg) or "numbers". "auto" takes
            names unless the numbers are special, so that more factors. Of a robot of symbols: numbers for them, where known.
        tolerance: as in `exact`.
        budget: [s] after which conditions are no longer split.

    Returns:
        SingularSet.

    Raises:
        ConfigurationError: KS391 for screw joints and odd mimic ratios; KS397 for values that are missing or no numbers;
            KS399 for more joints, or more general angles, than can be gone through.
        ArrayTypeError: KS390. UnknownNameError: KS310, KS318. MissingExtraError: KS400.

    Law: rank J(q) < rank of the task at almost every q. The determinant is computed in the frame of a middle link and
    factored in sines and cosines of half angles, which is complete over the rationals.

    Example:
        >>> import kinestatics as ks
        >>> found = ks.singularities(ks.load("puma_560"))
        >>> [str(component.name) for component in found.components]
        ['shoulder', 'elbow', 'wrist']
    """
    require_model(model)
    began, started = time.perf_counter(), time.monotonic()
    numeric, chain, values, given = _prepared(model, at, lengths, tolerance)
    found_task = find_task(numeric, task, at=at)
    half = HalfAngleRing(chain.ring)
    minors = _minors(chain, found_task)
    if (
        lengths == "auto"
        and not model.is_symbolic
        and chain.lengths
        and _special(model, at, tolerance, found_task, minors, half)
    ):
        chain = ExactChain.of(exact(model, tolerance), at)
        half, values = HalfAngleRing(chain.ring), {}
        minors = _minors(chain, found_task)
    space = Space(half, numeric, values, given, {} if model.is_symbolic else chain.lengths)
    lifted = [half.lifted(minor) for minor in minors]
    if _is_square(found_task, chain):
        expression, factors, candidates = _of_determinant(lifted[0], space, found_task, at)
        components, complete = [c for c in candidates if len(c.points)], True
    else:
        expression, factors = None, ()
        components, candidates, complete = _of_minors(lifted, space, found_task, at, budget, started)
    residual = 0.0 if model.is_symbolic else _residual(model, numeric, at)
    named = {} if model.is_symbolic else chain.lengths
    return SingularSet(
        numeric,
        at,
        found_task,
        expression,
        factors,
        tuple(components),
        tuple(candidates),
        complete,
        named,
        residual,
        time.perf_counter() - began,
        space,
        lifted[0] if _is_square(found_task, chain) else None,
    )


def _prepared(
    model: RobotModel, at: str, lengths: Any, tolerance: float
) -> tuple[RobotModel, ExactChain, dict[Any, float], bool]:
    """The robot in numbers, its exact chain, numbers for the symbols, and whether these are its own."""
    if not model.is_symbolic:
        if lengths not in ("auto", "named", "numbers"):
            hint = "a robot of numbers takes 'auto', 'named' or 'numbers'"
            raise ConfigurationError("KS397", f"lengths is {lengths!r}", hint)
        nominal = exact(model, tolerance)
        chain = ExactChain.of(nominal, at)
        if len(chain.ring.constants) > _MOST_ANGLES:
            message = f"{len(chain.ring.constants)} angles of the robot are no right angles, nor multiples of 15 degrees"
            hint = "of a calibrated robot, singularities(arm, tolerance=0.01) finds the nominal form"
            raise ConfigurationError("KS399", message, hint)
        chain = chain if lengths == "numbers" else chain.named()
        return in_numbers(nominal, {}), chain, {s: float(v) for s, v in chain.lengths.items()}, True
    symbols = sorted(free_symbols(model), key=str)
    values, given = _values(symbols, lengths)
    return in_numbers(model, values), ExactChain.of(model, at), values, given


def _is_square(task: Task, chain: ExactChain) -> bool:
    """Whether the rows make a square Jacobian whose determinant is not zero everywhere."""
    return len(task.rows) == chain.columns == task.rank


def _values(symbols: Sequence[Any], lengths: Any) -> tuple[dict[Any, float], bool]:
    """Numbers for symbols: those given, by symbol or name; or samples where none are."""
    if isinstance(lengths, str):
        rng = np.random.default_rng(7)
        return {symbol: float(rng.uniform(0.2, 1.0)) for symbol in symbols}, False
    by_name = {str(key): value for key, value in lengths.items()}
    missing = [str(symbol) for symbol in symbols if str(symbol) not in by_name]
    if missing:
        raise ConfigurationError(
            "KS397", f"no value for {', '.join(missing)}", "give a number for every symbol, or none at all"
        )
    try:
        return {symbol: float(by_name[str(symbol)]) for symbol in symbols}, True
    except (TypeError, ValueError):
        raise ArrayTypeError("KS302", f"lengths are {lengths!r}", "numbers, by symbol or by name") from None


def _minors(chain: ExactChain, task: Task) -> list[Polynomial]:
    """The minors of the size of the rank of the task: rank is lost where all of them vanish.

    Raises:
        ConfigurationError: KS399 where there are too many of them.
    """
    rows = chain.task_rows(task.rows)
    columns = [j for j in range(chain.columns) if any(row[j] != 0 for row in rows)]
    count = comb(len(rows), task.rank) * comb(len(columns), task.rank)
    if count > _MOST_MINORS:
        message = f"{len(columns)} joints and {len(rows)} rows of rank {task.rank} have {count} minors"
        hint = "hold some joints (joints={...} of ks.load, --hold), or choose fewer rows"
        raise ConfigurationError("KS399", message, hint)
    found = []
    for chosen in itertools.combinations(range(len(rows)), task.rank):
        for kept in itertools.combinations(columns, task.rank):
            M = [[rows[r][c] for c in kept] for r in chosen]
            if (minor := determinant(chain.ring, M)) != 0:
                found.append(minor)
    return found


def _special(
    model: RobotModel, at: str, tolerance: float, task: Task, named: Sequence[Polynomial], half: HalfAngleRing
) -> bool:
    """Whether the numbers of a robot are such that its determinant factors further than that of its kind."""
    if len(named) != 1:
        return False
    chain = ExactChain.of(exact(model, tolerance), at)
    numbers = _minors(chain, task)
    if len(numbers) != 1:
        return True
    own = HalfAngleRing(chain.ring)

    def count(ring: HalfAngleRing, p: Polynomial) -> int:
        return sum(times for _, times in ring.factored(ring.lifted(p))[1])

    return count(own, numbers[0]) > count(half, named[0])


def _of_determinant(
    lifted: Polynomial, space: Space, task: Task, at: str
) -> tuple[Any, tuple[tuple[Equation, int], ...], list[Component]]:
    """The determinant, its factors, and as components those that may have real zeros."""
    import sympy

    constant, parts = space.half.factored(lifted)
    found = equations(parts, space)
    leading = constant
    for equation, times in found:
        leading *= equation.scale**times
    expression = sympy.Mul(shortest(space.half, leading), *[e.expression**m for e, m in found])
    candidates = [Component((e,), task, at, space, multiplicity=m) for e, m in found if e.real is not False]
    return expression, tuple(found), candidates


def _of_minors(
    lifted: Sequence[Polynomial], space: Space, task: Task, at: str, budget: float, began: float
) -> tuple[list[Component], list[Component], bool]:
    deadline = began + budget

    def void(factor: Polynomial) -> bool:
        return space.given and len(factor.to_dict()) <= _SHORT and Equation((factor,), space).real is False

    branches = Splitter(space.half, deadline, void).split(lifted)
    kept, candidates, whole = components_of(branches, space, task, at, began + _WITH_SAMPLES * budget)
    return kept, candidates, whole and all(not branch.others for branch in branches)


def _residual(model: RobotModel, nominal: RobotModel, at: str) -> float:
    """The largest difference of the two Jacobians' entries, lengths in shares of the largest."""
    q = model.random_configurations(_RESIDUAL_SAMPLES, seed=5)
    both = [jacobian(x, q, at=at).array for x in (model, nominal)]
    sizes = np.abs(both[0]).max(axis=(0, 2), initial=0.0)
    reach = max(sizes[list(LINEAR_ROWS)].max(), np.finfo(float).tiny)
    scale = np.array([reach if r in LINEAR_ROWS else 1.0 for r in range(6)])
    return float((np.abs(both[0] - both[1]) / scale[:, None]).max(initial=0.0))
