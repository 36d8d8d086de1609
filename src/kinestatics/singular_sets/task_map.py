"""`task_map`: the rows of a task as a map without units, taken apart, polished and followed where they lose rank.

Lengths are in reaches of the arm, and joints that slide too: y is the posture in these units, q = travel · y.
Law: postures of one corank c solve Jᵀ W = 0, W₀ᵀ W = 1 in y and W (k, c) together: W is a basis of what is lost, W₀ a guess
of it. These equations have full rank where the singular set has that corank all around, though σ_min has no slope there.
With the tip held besides, their solutions are the *self-motions*: postures that hold the tip still, all as singular.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..kinematics import configuration, hessian, jacobian, pose, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import size_weights, split_pose, transpose
from ..statics.subspaces import check_length
from ..tasks import Task, characteristic_length, prismatic_columns, without_rounding

EPS = float(np.finfo(float).eps)
_STRUCTURAL = 1e-9
_SAMPLES = 8
_POLISH_STEPS, _CUT = 40, 1e-9  # singular values of a Newton step below this share of the largest are left out
_ARCS, _ARC_STEPS = (0.05, 0.015, 0.005), 4  # [rad] of null motion, each way: near other singularities long ones lose it
_STANDS = 1e-11  # how still the tip stands, in reaches and radians
_TURNED = 1e-6


def rotation_vectors(R: Array) -> Array:
    """(..., 3) axis times angle in [0, π] of rotations (..., 3, 3).

    Law: R - Rᵀ = 2 sin φ [n]×, tr R = 1 + 2 cos φ; near φ = π the axis n is from R + Rᵀ = 2 cos φ 1 + 2 (1 - cos φ) n nᵀ.

    Example:
        >>> import numpy as np
        >>> rotation_vectors(np.diag([-1.0, -1.0, 1.0])) / np.pi
        array([0., 0., 1.])
    """
    odd = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], -1) / 2
    sine, cosine = np.linalg.norm(odd, axis=-1), (np.trace(R, axis1=-2, axis2=-1) - 1) / 2
    angle = np.arctan2(sine, cosine)
    near_half = (cosine < 0) & (sine < 1e-4)  # there the axis is any column of (1 - cos) n nᵀ
    columns = (R + transpose(R)) / 2 - cosine[..., None, None] * np.eye(3)
    longest = np.argmax(np.linalg.norm(columns, axis=-2), axis=-1)
    axis = np.take_along_axis(columns, longest[..., None, None], -1)[..., 0]
    axis = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), EPS)
    axis = np.where((axis * odd).sum(-1, keepdims=True) < 0, -axis, axis)
    share = np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)
    return np.where(near_half[..., None], angle[..., None] * axis, share[..., None] * odd)


@dataclass(frozen=True, eq=False)
class TaskMap:
    """The task's rows as a map without units: lengths in reaches of the arm, joints that slide in reaches too.

    Attributes:
        model, rows, at: what is asked; length: the reach [m].
        live: (r, k) orthonormal basis of what the rows do at all; directions in which they never move are left out.
        travel: (n) [rad or m] of a joint for one unit of y: q = travel · y.
    """

    model: RobotModel
    rows: tuple[int, ...]
    at: str
    length: float
    live: Array
    travel: Array

    @cached_property
    def weights(self) -> Array:
        """(r) units of the rows."""
        return (size_weights(self.length) / self.length)[list(self.rows)]

    def jacobian(self, y: Array) -> Array:
        """(..., k, n)."""
        J = jacobian(self.model, y * self.travel, at=self.at, check_finite=False).array
        J = without_rounding(self.model, J)[..., list(self.rows), :]
        return self.live.T @ (self.weights[:, None] * J * self.travel)

    def hessian(self, y: Array) -> Array:
        """(k, n, n), the derivative of `jacobian`."""
        H = hessian(self.model, y * self.travel, at=self.at, check_finite=False).array[list(self.rows)]
        return np.einsum("rk,rjl->kjl", self.live, self.weights[:, None, None] * H * self.travel[:, None] * self.travel)

    def place(self, y: Array) -> tuple[Array, Array]:
        """Rotation and position of the link."""
        R, p = split_pose(pose(self.model, y * self.travel, at=self.at, check_finite=False).array)
        return R, p

    def residual(self, y: Array, R: Array, p: Array) -> Array:
        """(..., k) by how much the rows are beyond a place. Angular rows are those of the rotation vector."""
        R_here, p_here = self.place(y)
        six = np.concatenate([p_here - p, rotation_vectors(R_here @ transpose(R))], -1)
        return (six[..., list(self.rows)] * self.weights) @ self.live

    def six(self, w: Array) -> Array:
        """(..., 6) unit vectors of rows in the place of the six, from (..., k)."""
        result = np.zeros((*w.shape[:-1], 6))
        result[..., list(self.rows)] = w @ self.live.T
        return result


def task_map(model: RobotModel, task: Task, at: str = TIP, length: float | None = None) -> TaskMap:
    """The task's rows in units of the arm's reach, or of another length [m].

    Raises:
        ArrayTypeError: KS302, no model or no task. ConfigurationError: KS303, a length that is not positive.

    Law: J of y is Wₗ J of q · diag(travel), with the weights Wₗ = 1/L of linear rows and 1 of angular ones, L the length.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> of = task_map(arm, ks.find_task(arm))
        >>> of.length, of.jacobian([0.0, 0.0] / of.travel).shape
        (2.0, (2, 2))
    """
    require_model(model)
    if model.is_symbolic:
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths", "put numbers in their place first")
    if not isinstance(task, Task):
        hint = 'task = ks.find_task(arm, "full")'
        raise ArrayTypeError("KS302", f"task is a {type(task).__name__}; expected a Task", hint)
    size = characteristic_length(model, at) if length is None else length
    check_length(size)
    travel = np.where(prismatic_columns(model), size, 1.0)
    every = TaskMap(model, task.rows, at, size, np.eye(len(task.rows)), travel)
    y = np.random.default_rng(20260204).uniform(-np.pi, np.pi, (_SAMPLES, model.n))
    stacked = np.moveaxis(every.jacobian(y), 0, 1).reshape(len(task.rows), -1)
    U, sigma, _ = np.linalg.svd(stacked)
    live = int((sigma > _STRUCTURAL * sigma.max(initial=0.0)).sum()) if sigma.size else 0
    if live == len(task.rows):
        return every
    return TaskMap(model, task.rows, at, size, U[:, :live], travel)


class Singular(NamedTuple):
    """A singular posture taken apart: y, J, singular values, rank, W (k, c) of null(Jᵀ) and N (n, m) of ker J."""

    y: Array
    J: Array
    sigma: Array
    rank: int
    W: Array
    N: Array


def taken_apart(of: TaskMap, y: Array, rank: int | None, tolerance: float) -> Singular:
    """A posture taken apart, of the rank given, or by singular values above `tolerance` shares of the largest."""
    J = of.jacobian(y)
    U, sigma, Vt = np.linalg.svd(J)
    if rank is None:
        rank = int((sigma > tolerance * sigma.max(initial=0.0)).sum()) if sigma.max(initial=0.0) > 0 else 0
    return Singular(y, J, sigma, rank, U[:, rank:], Vt[rank:].T)


class _Bordered(NamedTuple):
    """The equations Jᵀ W = 0, W₀ᵀ W = 1 in (y, W): postures of one corank; optionally with the tip held and a pin."""

    of: TaskMap
    W0: Array
    held: tuple[Array, Array] | None = None

    def equations(self, y: Array, W: Array, pin: tuple[Array, float] | None = None) -> tuple[Array, Array]:
        """Their values, and derivatives by (y, W)."""
        J, H = self.of.jacobian(y), self.of.hessian(y)
        k, n = J.shape
        c = W.shape[1]
        values = [(J.T @ W).ravel(), (self.W0.T @ W - np.eye(c)).ravel()]
        by_y = np.einsum("kjl,ki->jil", H, W).reshape(n * c, n)
        by_W = np.kron(J.T, np.eye(c))
        slopes = [np.hstack([by_y, by_W]), np.hstack([np.zeros((c * c, n)), np.kron(self.W0.T, np.eye(c))])]
        if self.held is not None:
            values.append(self.of.residual(y, *self.held))
            slopes.append(np.hstack([J, np.zeros((k, k * c))]))
        if pin is not None:
            values.append(np.array([pin[0] @ y - pin[1]]))
            slopes.append(np.r_[pin[0], np.zeros(k * c)][None])
        return np.concatenate(values), np.vstack(slopes)

    def solved(self, y: Array, W: Array, pin: tuple[Array, float] | None = None) -> tuple[Array, Array, float]:
        """y, W and the residual after Gauss-Newton steps that move the posture the least; the best that was met."""
        best = (y, W, np.inf)
        for _ in range(_POLISH_STEPS):
            values, slopes = self.equations(y, W, pin)
            size = float(np.linalg.norm(values))
            if not size < best[2]:
                break
            best = (y, W, size)
            if size <= 4 * EPS:
                break
            by_y, by_W = slopes[:, : len(y)], slopes[:, len(y) :]
            Q, _ = np.linalg.qr(by_W, mode="complete")
            rest = Q[:, W.size :]  # the equations that W cannot meet: the posture has to
            step = np.linalg.lstsq(rest.T @ by_y, -rest.T @ values, rcond=_CUT)[0]
            turn = np.linalg.lstsq(by_W, -values - by_y @ step, rcond=EPS)[0]
            y, W = y + step, W + turn.reshape(W.shape)
        return best


def polished(
    model: RobotModel, q: Any, task: Task, at: str = TIP, corank: int = 1, length: float | None = None
) -> tuple[Array, float]:
    """The nearest posture, by Gauss-Newton steps, at which the rank of a task's rows falls by `corank`, to rounding.

    Args:
        q: (n) a posture near it [rad or m].
        corank: by how much the rank falls below that of almost every posture.

    Returns:
        The posture (n), and how singular it is: the largest singular value that should be zero, in shares of the largest.
        It is not small where there is no such posture near.

    Law: Jᵀ W = 0 with W of full rank, solved for q and W together: Newton's step is regular where the corank is that of the
    neighbours on the singular set, though σ_min itself has no slope at zero.

    Example:
        >>> import numpy as np
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> q, left = polished(arm, [0.3, 0.01], ks.find_task(arm))
        >>> bool(np.abs(q - [0.3, 0.0]).max() < 1e-9), left < 1e-15
        (True, True)
    """
    of = task_map(model, task, at, length)
    y = one_posture(model, q) / of.travel
    rank = task.rank - corank
    if not 0 <= rank < task.rank:
        raise ConfigurationError("KS303", f"corank is {corank}; the rank is {task.rank}", f"1 to {task.rank}")
    y, sigma = nearest_singular(of, y, rank)
    return y * of.travel, float(sigma[rank] / sigma[0]) if sigma[0] > 0 else 0.0


def nearest_singular(of: TaskMap, y: Array, rank: int) -> tuple[Array, Array]:
    """The nearest posture of a rank, unmoved where it is singular to rounding, and its singular values."""
    here = taken_apart(of, y, rank, 0.0)
    if rank < len(here.sigma) and here.sigma[rank] > 4 * EPS * here.sigma[0]:
        moved, _, _ = _Bordered(of, here.W).solved(y, here.W)
        sigma = np.linalg.svd(of.jacobian(moved), compute_uv=False)
        if sigma[rank] < here.sigma[rank]:
            return moved, sigma
    return y, here.sigma


def one_posture(model: RobotModel, q: Any) -> Array:
    """(n) one posture as floats; anything but one posture in numbers is refused."""
    array, xp = configuration(model, q)
    if xp.name != "numpy" or array.ndim != 1:
        raise ConfigurationError("KS303", "expected one posture, as numbers", "loop over a batch")
    return np.array(array, dtype=float)


class StandsStill(NamedTuple):
    """Whether null motions integrate to postures, as singular as this one, at which the tip stands still."""

    all_of_it: bool
    part: bool
    turns: bool

    @classmethod
    def along(cls, of: TaskMap, found: Singular, radical: Array) -> StandsStill:
        """Follows one general direction of the radical both ways; a proper part of it would not hold that direction."""
        if not radical.shape[1]:
            return cls(True, False, False)
        weights = np.random.default_rng(20260205).normal(size=radical.shape[1])
        direction = found.N @ radical @ (weights / np.linalg.norm(weights))
        system = _Bordered(of, found.W, of.place(found.y))
        for arc in _ARCS:
            ends = [cls._followed(system, found, way * direction, arc) for way in (1.0, -1.0)]
            bases = [np.linalg.qr(W)[0] for W in ends if W is not None]
            if len(bases) == len(ends):
                apart = (np.linalg.norm(found.W - basis @ (basis.T @ found.W)) for basis in bases)
                return cls(True, False, bool(max(apart) > _TURNED))
        return cls(False, cls._part(system, found, radical), False)

    @staticmethod
    def _followed(system: _Bordered, found: Singular, tangent: Array, arc: float) -> Array | None:
        """What is lost at the end of a null motion of a few steps; None where the tip does not stand still along it."""
        y, W = found.y, found.W
        for _ in range(_ARC_STEPS):
            there = y + arc * tangent
            new, W, size = system.solved(there, W, (tangent, float(tangent @ there)))
            if size > _STANDS or np.linalg.norm(new - there) > arc:
                return None
            y, tangent = new, (new - y) / np.linalg.norm(new - y)
        return W

    @staticmethod
    def _part(system: _Bordered, found: Singular, radical: Array) -> bool:
        """Whether the tip stands still along some direction at least."""
        if radical.shape[1] < 2:
            return False
        for arc, column in itertools.product(_ARCS, (found.N @ radical).T):
            y, _, size = system.solved(found.y + arc * column, found.W)
            if size <= _STANDS and np.linalg.norm(y - found.y) > 0.3 * arc:
                return True
        return False
