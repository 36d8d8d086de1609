"""`singularities`: from a robot to the closed form of its singular set."""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import comb
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..kinematics import jacobian, require_model
from ..model import RobotModel
from ..progress import Job, Progress
from ..spatial import LINEAR_ROWS
from ..symbolic.branches import Splitter
from ..symbolic.chain import ExactChain, determinant
from ..symbolic.exact import FRACTIONS, MOST_KEPT, exact, free_symbols
from ..symbolic.halfangle import HalfAngleRing
from ..symbolic.ring import Polynomial
from ..symbolic.values import in_numbers
from ..tasks import Task, find_task
from .components import Component, components_of
from .equations import Equation, Space, equations
from .singular_set import SingularSet

_BUDGET = 20.0
_RESIDUAL_SAMPLES = 32
_TO_SPLIT = 0.7  # of the time, for splitting conditions; the rest is for sampling components
_MOST_MINORS = 500
_SHORT = 40  # terms of a factor whose zeros are looked for while conditions are split


def singularities(
    model: RobotModel,
    task: str | Sequence[str] | Sequence[int] = "auto",
    *,
    at: str = TIP,
    limits: bool = True,
    lengths: str | Mapping[Any, float] = "auto",
    tolerance: float = 1e-5,
    budget: float = _BUDGET,
    progress: Progress | None = None,
) -> SingularSet:
    """Where an arm is singular, in closed form.

    Args:
        model: the robot; its lengths may be symbols.
        task: the rows in play, as in `find_task`.
        at: the link.
        limits: whether the joints' limits count, where it is said which components lie within them; else joints are free.
        lengths: of a robot of numbers: "auto", "named" (a2, d4, ... after Denavit and Hartenberg) or "numbers". "auto" takes
            names unless the numbers are special, so that more factors. Of a robot of symbols: numbers for them, where known.
        tolerance: as in `exact`.
        budget: [s] after which conditions are no longer split; a step of algebra that has begun is ended.
        progress: told what is being done; what it raises ends the search.

    Returns:
        SingularSet.

    Raises:
        ConfigurationError: KS391 for screw joints and odd mimic ratios; KS397 for values that are missing or no numbers;
            KS399 for more joints than can be gone through; KS353 for a budget that is none.
        ArrayTypeError: KS390. UnknownNameError: KS310, KS318. MissingExtraError: KS400.

    Law: rank J(q) < rank of the task at almost every q. The determinant is computed in the frame of a middle link and
    factored in sines and cosines of half angles, which is complete over the rationals. The rotations of an arm with more
    than three general angles, such as a calibrated one, are those of fractions, as in `exact(arm, angles="fractions")`:
    the determinant is then a sum of at most a few hundred waves.

    Example:
        >>> import kinestatics as ks
        >>> found = ks.singularities(ks.load("puma_560"))
        >>> [str(component.name) for component in found.components]
        ['shoulder', 'elbow', 'wrist']
    """
    require_model(model)
    began, job = time.perf_counter(), Job.of(budget, progress)
    numeric, chain, values, given = _prepared(model, at, lengths, tolerance)
    if not limits:
        free = np.full(model.n, np.inf)
        numeric = replace(numeric, lower=-free, upper=free)
    found_task = find_task(numeric, task, at=at)
    half = HalfAngleRing(chain.ring)
    minors = _minors(chain, found_task, job)
    by_name = lengths == "auto" and not model.is_symbolic and bool(chain.lengths)
    if by_name and _special(model, at, tolerance, found_task, minors, half, job):
        chain = ExactChain.of(exact(model, tolerance), at)
        half, values = HalfAngleRing(chain.ring), {}
        minors = _minors(chain, found_task, job)
    space = Space(half, numeric, values, given, {} if model.is_symbolic else chain.lengths)
    lifted = [half.lifted(minor) for minor in minors]
    if _is_square(found_task, chain):
        constant, factors, candidates = _of_determinant(lifted[0], space, found_task, at)
        components, complete = [c for c in candidates if len(c.points)], True
    else:
        constant, factors = None, ()
        components, candidates, complete = _of_minors(lifted, space, found_task, at, job)
    residual = 0.0 if model.is_symbolic else _residual(model, numeric, at)
    named = {} if model.is_symbolic else chain.lengths
    return SingularSet(
        numeric,
        at,
        found_task,
        constant,
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
        general = len(chain.ring.constants) > MOST_KEPT
        if general:
            nominal = exact(model, tolerance, angles=FRACTIONS)
            chain = ExactChain.of(nominal, at)
        chain = chain.named() if lengths == "named" or (lengths == "auto" and not general) else chain
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


def _minors(chain: ExactChain, task: Task, job: Job) -> list[Polynomial]:
    """The minors of the size of the rank of the task: rank is lost where all of them vanish.

    Raises:
        ConfigurationError: KS399 where there are too many of them, or time is up before they are known.
    """
    rows = chain.task_rows(task.rows)
    columns = [j for j in range(chain.columns) if any(row[j] != 0 for row in rows)]
    count = comb(len(rows), task.rank) * comb(len(columns), task.rank)
    if count > _MOST_MINORS:
        message = f"{len(columns)} joints and {len(rows)} rows of rank {task.rank} have {count} minors"
        hint = "hold some joints (joints={...} of ks.load, --hold), or choose fewer rows"
        raise ConfigurationError("KS399", message, hint)
    found, done = [], 0
    for chosen in itertools.combinations(range(len(rows)), task.rank):
        for kept in itertools.combinations(columns, task.rank):
            job.tell("determinants", done / count)
            if done and job.late:
                message = f"{done} of {count} minors were found before time was up"
                raise ConfigurationError("KS399", message, "a larger budget, held joints, or fewer rows")
            M = [[rows[r][c] for c in kept] for r in chosen]
            done += 1
            if (minor := determinant(chain.ring, M)) != 0:
                found.append(minor)
    return found


def _special(
    model: RobotModel, at: str, tolerance: float, task: Task, named: Sequence[Polynomial], half: HalfAngleRing, job: Job
) -> bool:
    """Whether the numbers of a robot are such that its determinant factors further than that of its kind."""
    if len(named) != 1:
        return False
    chain = ExactChain.of(exact(model, tolerance), at)
    numbers = _minors(chain, task, job)
    if len(numbers) != 1:
        return True
    own = HalfAngleRing(chain.ring)

    def count(ring: HalfAngleRing, p: Polynomial) -> int:
        return sum(times for _, times in ring.factored(ring.lifted(p))[1])

    return count(own, numbers[0]) > count(half, named[0])


def _of_determinant(
    lifted: Polynomial, space: Space, task: Task, at: str
) -> tuple[Polynomial, tuple[tuple[Equation, int], ...], list[Component]]:
    """Of the determinant what is the same at all postures, its factors, and as components those that may have real zeros."""
    constant, parts = space.half.factored(lifted)
    found = equations(parts, space)
    candidates = [Component((e,), task, at, space, multiplicity=m) for e, m in found if e.real is not False]
    return constant, tuple(found), candidates


def _of_minors(
    lifted: Sequence[Polynomial], space: Space, task: Task, at: str, job: Job
) -> tuple[list[Component], list[Component], bool]:

    def void(factor: Polynomial) -> bool:
        return space.given and len(factor.to_dict()) <= _SHORT and Equation((factor,), space).real is False

    branches = Splitter(space.half, job.within(_TO_SPLIT), void).split(lifted)
    kept, candidates, whole = components_of(branches, space, task, at, job)
    return kept, candidates, whole and all(not branch.others for branch in branches)


def _residual(model: RobotModel, nominal: RobotModel, at: str) -> float:
    """The largest difference of the two Jacobians' entries, lengths in shares of the largest."""
    q = model.random_configurations(_RESIDUAL_SAMPLES, seed=5)
    both = [jacobian(x, q, at=at).array for x in (model, nominal)]
    sizes = np.abs(both[0]).max(axis=(0, 2), initial=0.0)
    reach = max(sizes[list(LINEAR_ROWS)].max(), np.finfo(float).tiny)
    scale = np.array([reach if r in LINEAR_ROWS else 1.0 for r in range(6)])
    return float((np.abs(both[0] - both[1]) / scale[:, None]).max(initial=0.0))
