"""`Chart`: where the tip is in a section of the workspace, with derivatives; the nearest place that an arm reaches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kinematics import hessian, jacobian, pose
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import LINEAR, transpose
from ..tasks import characteristic_length, prismatic_columns
from .tracing import first_axis

_ON_AXIS = 1e-9  # in reaches
_ITERATIONS, _SHORTEST, _LONGEST = 80, 1e-7, 0.6
_FLAT, _SOFT, _PRESS = 1e-14, 1e-10, 1e-6
ARRIVED = 1e-10
"""In reaches: a place this near to a target is at it."""


@dataclass(frozen=True, eq=False)
class Chart:
    """Places in a plane, in reaches: (distance from axis 1, height along it), or (x, y) of an arm that moves in that plane.

    Attributes:
        model, at: whose tip; length: the reach [m]; around: whether the plane is the half plane through axis 1.
        axis, origin: (3) direction of axis 1 and a point on it.
        travel: (n) [rad or m] of a joint for one unit of y, q = travel · y; lower, upper: (n) limits of y.
    """

    model: RobotModel
    at: str
    length: float
    around: bool
    axis: Array
    origin: Array
    travel: Array
    lower: Array
    upper: Array

    @classmethod
    def of(cls, model: RobotModel, at: str, around: bool, limits: bool) -> Chart:
        """The chart of an arm, joints that turn within their limits or freely; those that slide always within theirs."""
        axis, origin = first_axis(model, at)
        length = characteristic_length(model, at)
        slides = prismatic_columns(model)
        travel = np.where(slides, length, 1.0)
        held = slides | (np.isfinite(model.lower) & np.isfinite(model.upper) & limits)
        lower, upper = np.where(held, model.lower, -np.inf), np.where(held, model.upper, np.inf)
        return cls(model, at, length, around, axis, origin, travel, lower / travel, upper / travel)

    def random(self, count: int, rng: np.random.Generator) -> Array:
        """(count, n) y within the limits, or a turn; of half of them a fifth of the joints at a limit."""
        held = np.isfinite(self.lower)
        lower, upper = np.where(held, self.lower, -np.pi), np.where(held, self.upper, np.pi)
        y = rng.uniform(lower, upper, (count, self.model.n))
        side = rng.integers(0, 10, y.shape)
        rim = (np.arange(count) % 2 == 0)[:, None] & held
        return np.where(rim & (side == 0), lower, np.where(rim & (side == 1), upper, y))

    def place(self, y: Array) -> Array:
        """(k, 2)."""
        p = (pose(self.model, y * self.travel, at=self.at, check_finite=False).translation - self.origin) / self.length
        if not self.around:
            return np.asarray(p[..., :2])
        height = p @ self.axis
        return np.stack([np.linalg.norm(p - height[..., None] * self.axis, axis=-1), height], -1)

    def slopes(self, y: Array) -> tuple[Array, Array, Array]:
        """(k, 2) places, (k, 2, n) their derivatives by y and (k, 2, n, n) second ones."""
        q = y * self.travel
        p = (pose(self.model, q, at=self.at, check_finite=False).translation - self.origin) / self.length
        J = jacobian(self.model, q, at=self.at, check_finite=False).array[..., LINEAR, :] * self.travel / self.length
        H = hessian(self.model, q, at=self.at, check_finite=False).array[..., LINEAR, :, :]
        H = H * self.travel[:, None] * self.travel / self.length
        if not self.around:
            return p[..., :2], J[..., :2, :], H[..., :2, :, :]
        height = p @ self.axis
        out = p - height[..., None] * self.axis
        radius = np.linalg.norm(out, axis=-1)
        safe = np.maximum(radius, _ON_AXIS)
        unit = out / safe[..., None]
        axes = np.stack([unit, np.broadcast_to(self.axis, unit.shape)], -2)
        first = axes @ J
        second = np.einsum("...ck,...kij->...cij", axes, H)
        across = J - transpose(axes) @ first  # what turns about the axis moves the tip away from it, to second order
        second[..., 0, :, :] += transpose(across) @ across / safe[..., None, None]
        return np.stack([radius, height], -1), first, second

    def nearest(self, y: Array, targets: Array) -> tuple[Array, Array]:
        """(k, n) postures moved, within the limits, to where the tip is nearest to targets (k, 2), and the (k) distances.

        Newton's steps for |w - t|² / 2 with the curvatures made positive, joints at a limit that press on it held.
        """
        y = np.clip(y, self.lower, self.upper)
        share, going = np.ones(len(y)), np.arange(len(y))
        cost = ((self.place(y) - targets) ** 2).sum(-1) / 2
        for _ in range(_ITERATIONS):
            going = going[(cost[going] > ARRIVED**2 / 8) & (share[going] > _SHORTEST)]
            if not len(going):
                break
            here = y[going]
            w, J, H = self.slopes(here)
            r = w - targets[going]
            g = np.einsum("kci,kc->ki", J, r)
            held = ((here >= self.upper) & (g < 0)) | ((here <= self.lower) & (g > 0))
            step = self._down(transpose(J) @ J + np.einsum("kc,kcij->kij", r, H), np.where(held, 0.0, g), held)
            trial = np.clip(here + share[going, None] * step, self.lower, self.upper)
            new = ((self.place(trial) - targets[going]) ** 2).sum(-1) / 2
            better = new < cost[going]
            y[going[better]], cost[going[better]] = trial[better], new[better]
            share[going] = np.where(better, np.minimum(3.0 * share[going], 1.0), 0.3 * share[going])
            going = going[np.abs((np.where(held, 0.0, g) * step).sum(-1)) > _FLAT * cost[going]]
        return y, np.sqrt(2 * cost)

    @staticmethod
    def _down(H: Array, g: Array, held: Array) -> Array:
        """(k, n) steps down, none in the joints held."""
        H = np.where(held[:, :, None] | held[:, None, :], 0.0, H)
        values, vectors = np.linalg.eigh(H)
        along = np.einsum("kij,ki->kj", vectors, g) / np.maximum(np.abs(values), _SOFT)
        along = np.where(np.abs(values) > _SOFT, along, 0.0)
        step = -np.where(held, 0.0, np.einsum("kij,kj->ki", vectors, along))
        size = np.linalg.norm(step, axis=-1, keepdims=True)
        return np.asarray(step * np.minimum(1.0, _LONGEST / np.maximum(size, 1e-30)))

    def presses(self, y: Array, normals: Array) -> Array:
        """(k) whether a joint at its limit keeps the tip from going on along outward normals (k, 2)."""
        pull = np.einsum("kci,kc->ki", self.slopes(y)[1], normals)
        at_limit = ((y >= self.upper) & (pull > _PRESS)) | ((y <= self.lower) & (pull < -_PRESS))
        return np.asarray(at_limit.any(-1))
