"""`on_boundary`: whether other branches of the arm reach beyond a singular posture, as far as many starts say."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..kinematics import configuration
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import plain, wrapped
from ..spatial import size_weights, transpose
from ..tasks import Task
from .second_order import SecondOrder
from .task_map import TaskMap, task_map

_STEP = 1e-3  # how far beyond the pose a target lies, in reaches and radians
_ARRIVED = 1e-9
_KANTOROVICH = 0.05  # of 0.5, so that rounding in the numbers compared does not matter
_ROUNDING = 1e-14  # of a residual
_STARTS, _ROUND = 256, 64
_ITERATIONS, _BACK_ITERATIONS = 60, 30
_OFF = 1e-9  # from a limit, [rad] or in reaches
_FOLLOWED = 8
_FLOOR = 1e-14  # of the damping, so that a matrix can be factored
_BACK = (0.5, 0.25, 0.1, 0.0)


@dataclass(frozen=True, eq=False)
class Boundary:
    """What a search over other branches says of a posture.

    Attributes:
        verdict: "inside": not on the boundary of the workspace; "boundary": a step beyond was not reached, as far as
            `starts` starts say; "undecided": the time ran out before.
        proved: whether "inside" comes with a posture at the same pose that is regular and off all limits, around which every
            pose is reached; without, it is an observation a step of 0.001 reaches away.
        posture: (n) that posture, or one that reaches beyond; None where there is none [rad or m].
        targets: (t, 6) displacements from the pose that were looked for (v, ω) [m, rad], base axes at the link's origin;
            reached: whether each was.
        starts: how many were tried for each target; limits: whether joint limits were kept; seconds: what it took.
        text: the same in words.
    """

    verdict: str
    proved: bool
    posture: Array | None
    targets: Array
    reached: tuple[bool, ...]
    starts: int
    limits: bool
    seconds: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "verdict": self.verdict,
            "proved": self.proved,
            "posture": None if self.posture is None else plain(self.posture),
            "targets": plain(self.targets),
            "reached": list(self.reached),
            "starts": self.starts,
            "limits": self.limits,
            "seconds": plain(self.seconds),
            "text": self.text,
        }

    def __str__(self) -> str:
        return wrapped(f"{self.verdict}: ", self.text)


def on_boundary(
    model: RobotModel,
    q: Any,
    task: Task,
    at: str,
    second: SecondOrder,
    budget_seconds: float = 5.0,
    seed: int = 0,
    *,
    limits: bool = True,
    starts: int = _STARTS,
) -> Boundary:
    """Whether the tip at a posture is on the boundary of the workspace, as far as a search over branches says.

    Args:
        model, task, at: as in `second_order`; q: (n) one posture, NumPy or a list [rad or m].
        second: the class of that posture, from `second_order`.
        budget_seconds: the search ends then; with enough of it the answer does not depend on the machine.
        seed: of the starts, uniform within the limits, or within a turn and one reach where there are none.
        limits: whether joint limits count; without, joints turn and slide freely.
        starts: how many, for each target.

    Returns:
        Boundary. Targets lie a step to the side that a barrier does not reach, for other classes a step to both sides along
        every lost direction; what arrives there is followed back to the pose itself. "boundary" is an observation and no
        proof, except for an arm with fewer freedoms than rows.

    Raises:
        ArrayTypeError: KS302; ConfigurationError: KS303, KS301; UnknownNameError: KS310.

    Law: a posture with the same pose at which J has full row rank, off all limits, has a neighbourhood of the pose as image.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics.singular_sets.second_order import second_order
        >>> arm, q = ks.load("planar_2r"), [0.0, 0.0]
        >>> task = ks.find_task(arm)
        >>> print(on_boundary(arm, q, task, "tip", second_order(arm, q, task), starts=64))
        boundary: no branch reaches a step beyond, as far as 64 starts say; no proof
    """
    begun = time.monotonic()
    if not isinstance(second, SecondOrder):
        message = f"second is a {type(second).__name__}; expected a SecondOrder"
        raise ArrayTypeError("KS302", message, "second_order(arm, q, task) gives one")
    if not budget_seconds > 0 or starts < 1 or seed < 0:
        message = f"budget_seconds {budget_seconds}, starts {starts}, seed {seed}"
        raise ConfigurationError("KS303", message, "a positive budget, one start or more, a seed from 0 on")
    of = task_map(model, task, at, second.scale)
    array, xp = configuration(model, q)
    if xp.name != "numpy" or array.ndim != 1:
        raise ConfigurationError("KS303", "on_boundary takes one posture, as numbers", "loop over a batch")
    posture = np.array(array, dtype=float)
    free = np.full(model.n, np.inf)
    lower, upper = (model.lower, model.upper) if limits else (-free, free)
    R, p = of.place(posture / of.travel)
    search = _Search(of, R, p, lower / of.travel, upper / of.travel, begun + budget_seconds, seed, starts)
    found = _at_once(search, posture, second, task) or _searched(search, second)
    verdict, proved, witness, targets, reached, tried, text = found
    return Boundary(verdict, proved, witness, targets, reached, tried, limits, time.monotonic() - begun, text)


class _Finding(NamedTuple):
    verdict: str
    proved: bool
    posture: Array | None
    targets: Array
    reached: tuple[bool, ...]
    starts: int
    text: str


class _Search(NamedTuple):
    """The pose (R, p) of the link that is in question, limits of y (infinite where there are none), and the effort."""

    of: TaskMap
    R: Array
    p: Array
    lower: Array
    upper: Array
    deadline: float
    seed: int
    starts: int

    @property
    def late(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() > self.deadline

    def solved(self, y: Array, offset: Array, iterations: int) -> tuple[Array, Array]:
        """(s, n) starts after damped Gauss-Newton steps within the limits, and (s) how far from the target they are.

        The target is `offset` (k) from the pose, in the rows of the task. The damping falls with the residual, so that
        convergence is quick at singular targets too.
        """
        damping = np.full(len(y), 1e-2)
        r = self.of.residual(y, self.R, self.p) - offset
        cost = (r**2).sum(-1)
        for _ in range(iterations):
            if not np.any(cost > (1e-4 * _ARRIVED) ** 2) or self.late:
                break
            J = self.of.jacobian(y)
            system = J @ transpose(J) + (_FLOOR + damping * cost)[:, None, None] * np.eye(J.shape[-2])
            step = (transpose(J) @ np.linalg.solve(system, r[..., None]))[..., 0]
            size = np.linalg.norm(step, axis=-1, keepdims=True)
            new = np.clip(y - step / np.maximum(size, 1.0), self.lower, self.upper)
            r_new = self.of.residual(new, self.R, self.p) - offset
            cost_new = (r_new**2).sum(-1)
            better = cost_new < cost
            y, r = np.where(better[:, None], new, y), np.where(better[:, None], r_new, r)
            cost = np.where(better, cost_new, cost)
            damping = np.clip(np.where(better, damping / 4, damping * 8), 1e-9, 1e9)
        return y, np.sqrt(cost)

    def off_limits(self, y: Array, by: float = 0.0) -> bool:
        """Whether a posture is inside all limits, at none of them."""
        return bool(np.all((y > self.lower + by + _OFF) & (y < self.upper - by - _OFF)))

    def proved(self, y: Array) -> bool:
        """Whether next to a posture there is one at the pose itself, regular and off all limits.

        Kantorovich's theorem: Newton's steps of least length arrive, within 2 |r| / σ, where |H| |r| / σ² < 1/2, and J is
        regular there. A posture that merely came close to a singular solution has a small σ for its residual r.
        """
        r = float(np.linalg.norm(self.of.residual(y, self.R, self.p))) + _ROUNDING
        sigma = np.linalg.svd(self.of.jacobian(y), compute_uv=False)
        if len(sigma) < self.of.live.shape[1] or not sigma[-1] > 0:
            return False
        bend = float(np.linalg.norm(self.of.hessian(y)))
        return bend * r < _KANTOROVICH * sigma[-1] ** 2 and self.off_limits(y, 2 * r / float(sigma[-1]))

    def random(self) -> Array:
        """(starts, n) y, the same for every target."""
        model = self.of.model
        if np.any(np.isfinite(self.lower) | np.isfinite(self.upper)):
            return model.random_configurations(self.starts, self.seed) / self.of.travel
        turns = np.array([kind != "prismatic" for kind in model.joint_kinds], dtype=bool)
        reach = np.where(turns, np.pi, 1.0)
        return np.random.default_rng(self.seed).uniform(-reach, reach, (self.starts, model.n))

    def beyond(self, offset: Array) -> tuple[Array | None, Array | None, int]:
        """A regular posture at the pose itself, a posture at the target (each or None), and how many starts were tried."""
        every, there, tried = self.random(), None, 0
        while tried < self.starts and not self.late:
            y, away = self.solved(every[tried : tried + _ROUND], offset, _ITERATIONS)
            arrived = y[away <= _ARRIVED]
            for other in arrived[:_FOLLOWED]:
                there = other if there is None else there
                if (home := self.back(other, offset)) is not None:
                    return home, other, tried + len(y)
            if self.late and not len(arrived):
                break
            tried += len(y)
        return None, there, tried

    def back(self, y: Array, offset: Array) -> Array | None:
        """What is beyond the pose, followed back to it; None unless it comes to be regular and off all limits there."""
        path, away = y[None], np.zeros(1)
        for share in _BACK:
            path, away = self.solved(path, share * offset, _BACK_ITERATIONS)
        return path[0] if away[0] <= _ARRIVED and self.proved(path[0]) else None


def _at_once(search: _Search, q: Array, second: SecondOrder, task: Task) -> _Finding | None:
    """What needs no search."""
    nothing: tuple[Array, tuple[bool, ...], int] = (np.zeros((0, 6)), (), 0)
    if search.of.live.shape[1] > task.rank:
        text = (
            f"the arm has {task.rank} freedoms in {search.of.live.shape[1]} rows: every pose it reaches is on the boundary"
        )
        return _Finding("boundary", True, None, *nothing, text)
    if second.kind not in ("regular", "crossable") or not search.off_limits(q / search.of.travel):
        return None
    words = "is regular" if second.kind == "regular" else "lets the arm pass to both sides of what it loses"
    text = f"the posture {words}, off all limits: every pose near it is reached"
    return _Finding("inside", True, q, *nothing, text)


def _offsets(search: _Search, second: SecondOrder) -> Array:
    """(t, k) targets in the rows of the task."""
    of = search.of
    directions = second.directions if second.kind != "regular" else np.zeros((0, 6))
    w = (directions * size_weights(of.length))[:, list(of.rows)] @ of.live
    w = w / np.linalg.norm(w, axis=-1, keepdims=True)
    return -_STEP * w[:1] if second.kind == "barrier" else np.concatenate([_STEP * w, -_STEP * w])


def _searched(search: _Search, second: SecondOrder) -> _Finding:
    """Looks for each target in turn."""
    offsets, of = _offsets(search, second), search.of
    targets = of.six(offsets) * of.length / size_weights(of.length)
    reached: list[bool] = []
    counts: list[int] = []
    there = None
    for offset in offsets:
        home, other, count = search.beyond(offset)
        reached.append(other is not None)
        counts.append(count)
        there = other if there is None else there
        if home is not None:
            text = "another branch reaches the same pose, regular and off all limits: every pose near it is reached"
            return _Finding("inside", True, home * of.travel, targets[: len(reached)], tuple(reached), count, text)
    posture = None if there is None else there * of.travel
    tried = max(
        (count for count, arrived in zip(counts, reached, strict=True) if not arrived), default=max(counts, default=0)
    )
    finding = (posture, targets, tuple(reached), tried)
    if not reached:
        text = "the posture is at a limit, and no direction of motion is lost: nothing was looked for"
        return _Finding("undecided", False, *finding, text)
    if all(reached):
        sides = "the side that this branch does not reach" if second.kind == "barrier" else "both sides of all that is lost"
        return _Finding("inside", False, *finding, f"a step of {_STEP:g} reaches to {sides} is reached by another posture")
    if tried < search.starts:
        return _Finding("undecided", False, *finding, f"the time ran out after {tried} of {search.starts} starts")
    text = f"no branch reaches a step beyond, as far as {tried} starts say; no proof"
    return _Finding("boundary", False, *finding, text)
