"""Singular curves in a plane of two joints, by continuation; and the cusps of an arm with three joints.

A curve f = 0 is followed in small steps along its tangent, and brought back onto it by Newton steps along the gradient. A
cusp is where the motion that is lost nothing by, the kernel of J, is tangent to the singular surface: there the arm can
change its posture without becoming singular (Wenger, "A new general formalism for the kinematic analysis of all
nonredundant manipulators" 1992).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kinematics import jacobian, pose
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR, LINEAR, split_pose
from ..symbolic.functions import WaveFunction
from ..tasks import Task
from .components import Component

_GRID, _MOST, _NEWTON = 96, 20000, 6
_ON, _FLAT, _ON_AXIS = 1e-13, 1e-9, 1e-3
_SAME = 1e-6
_SLOPE = 1e-6  # of ∇f · k somewhere on a curve, f in shares of its amplitude: less is rounding


@dataclass(frozen=True, eq=False)
class Curve:
    """One singular curve in the plane of two joints, the others held.

    Attributes:
        component: the component it belongs to.
        points: (k, n) postures along it, angles running on over half turns.
        closed: whether it comes back to where it began, up to whole turns.
    """

    component: Component
    points: Array
    closed: bool


@dataclass(frozen=True, eq=False)
class Cusp:
    """A posture of an arm with three joints at which three solutions of the inverse problem meet.

    Attributes:
        q: (n) the posture; radius, height: where the tip is, seen along the first axis [m].
        residual: |∇f · k|, k the unit kernel of J and f the equation in shares of its amplitude.
    """

    q: Array
    radius: float
    height: float
    residual: float


def trace(
    component: Component, joints: tuple[int, int], q: Array, step: float, functions: tuple[WaveFunction, ...] | None = None
) -> tuple[Curve, ...]:
    """The curves of a component of one equation in the plane of two joints.

    Args:
        component: of one equation; functions: its factors to follow, default all.
        joints: columns of the two joints; q: (n) where the others are held.
        step: between points [rad or m].
    """
    found: list[Curve] = []
    for f in component.equations[0].functions if functions is None else functions:
        plane = _Plane(f, joints, q, tuple(component.space.half.ring.turns[j] for j in joints))
        curves: list[Array] = []
        for seed in plane.seeds():
            if any(plane.apart(seed, points).min() < 1.5 * step for points in curves):
                continue
            points, closed = plane.followed(seed, step)
            if len(points) > 1:
                curves.append(points)
                found.append(Curve(component, plane.whole(points), closed))
    return tuple(found)


class _Plane:
    """A function on the plane of two joints."""

    def __init__(self, f: WaveFunction, joints: tuple[int, int], q: Array, turns: tuple[bool, ...]) -> None:
        self.f, self.joints, self.q, self.turns = f, list(joints), q, np.array(turns)

    def whole(self, x: Array) -> Array:
        q = np.broadcast_to(self.q, (*x.shape[:-1], len(self.q))).copy()
        q[..., self.joints] = x
        return q

    def value(self, x: Array) -> Array:
        return self.f.value(self.whole(x)) / self.f.scale

    def gradient(self, x: Array) -> Array:
        return self.f.gradient(self.whole(x))[..., self.joints] / self.f.scale

    def apart(self, x: Array, points: Array) -> Array:
        """Distances, whole turns apart from angles."""
        difference = points - x
        turned = np.mod(difference + np.pi, 2 * np.pi) - np.pi
        return np.linalg.norm(np.where(self.turns, turned, difference), axis=-1)

    def onto(self, x: Array) -> Array:
        """Points moved onto the curve along the gradient."""
        for _ in range(_NEWTON):
            g = self.gradient(x)
            x = x - (self.value(x) / np.maximum((g * g).sum(-1), _FLAT**2))[..., None] * g
        return x

    def seeds(self) -> Array:
        """Points on the curves, from changes of sign along the lines of a grid."""
        axes = [np.linspace(-np.pi, np.pi, _GRID, endpoint=False) + 0.0123 for _ in self.joints]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
        values = self.value(grid)
        found = []
        for axis in (0, 1):
            ahead = np.eye(2)[axis] * (2 * np.pi / _GRID)
            beyond = self.value(grid + ahead)  # not the first again: half angles change sign once around
            changes = tuple(np.argwhere(values * beyond < 0).T)
            start, share, other = grid[changes], values[changes], beyond[changes]
            found.append(start + (share / (share - other))[:, None] * ahead)
        x = self.onto(np.concatenate(found))
        return x[np.abs(self.value(x)) <= _ON] if len(x) else x

    def followed(self, seed: Array, step: float) -> tuple[Array, bool]:
        """The curve through a point: until it closes, or both ways to where it ends or meets itself."""
        ahead, closed = self._walked(seed, step, 1.0)
        if closed:
            return ahead, True
        behind, _ = self._walked(seed, step, -1.0)
        return np.concatenate([behind[:0:-1], ahead]), False

    def _walked(self, seed: Array, step: float, way: float) -> tuple[Array, bool]:
        points, x, before = [seed], seed, None
        for k in range(_MOST):
            g = self.gradient(x)
            size = float(np.linalg.norm(g))
            if size <= _FLAT:
                break
            tangent = way * np.array([-g[1], g[0]]) / size
            if before is not None and tangent @ before < 0:
                tangent = -tangent
            x, before = self.onto((x + step * tangent)[None])[0], tangent
            if abs(float(self.value(x[None])[0])) > 1e-9 or np.any(~self.turns & (np.abs(x) > np.pi)):
                break
            points.append(x)
            if k > 2 and self.apart(seed, x[None])[0] < 0.75 * step:
                return np.array(points), True
        return np.array(points), False


def cusps_of(component: Component, model: RobotModel, task: Task, at: str, step: float) -> tuple[Cusp, ...]:
    """The cusps on a component of an arm of three joints, of which the first does not change the determinant."""
    q = np.zeros(model.n)
    found: list[Cusp] = []
    for f in component.equations[0].functions:
        if not {1, 2} <= set(f.joints):  # with q2 or q3 alone the curve is straight, and the kernel may lie in it all along
            continue
        for curve in trace(component, (1, 2), q, step, (f,)):
            points = np.vstack([curve.points, curve.points[:1] + _turns(curve)]) if curve.closed else curve.points
            kernels = np.linalg.svd(_rows(model, points, task, at))[2][:, -1]
            slopes = (f.gradient(points) * kernels).sum(-1) / f.scale
            turned = np.sign((kernels[1:] * kernels[:-1]).sum(-1))
            signs = np.concatenate([[1.0], np.cumprod(turned)])
            slopes = slopes * signs
            if np.abs(slopes).max() < _SLOPE:
                continue
            for k in np.flatnonzero(slopes[1:] * slopes[:-1] < 0):
                cusp = _refined(f, model, task, at, points[k], points[k + 1])
                if cusp is not None and all(np.abs(np.sin((cusp.q - c.q) / 2)).max() > _SAME for c in found):
                    found.append(cusp)
    return tuple(sorted(found, key=lambda c: (-c.radius, -c.height)))


def _turns(curve: Curve) -> Array:
    """The whole turns between the end of a closed curve and its beginning."""
    return 2 * np.pi * np.round((curve.points[-1] - curve.points[0]) / (2 * np.pi))


def _rows(model: RobotModel, q: Array, task: Task, at: str) -> Array:
    return jacobian(model, q, at=at, check_finite=False).array[..., list(task.rows), :]


def _refined(f: WaveFunction, model: RobotModel, task: Task, at: str, a: Array, b: Array) -> Cusp | None:
    """The zero of ∇f · k between two points of a curve, by bisection; None where k turns the first joint only."""

    def slope(q: Array, like: Array) -> tuple[float, Array]:
        kernel = np.linalg.svd(_rows(model, q[None], task, at))[2][0, -1]
        kernel = kernel if kernel @ like >= 0 else -kernel
        return float(f.gradient(q) @ kernel) / f.scale, kernel

    def onto(q: Array) -> Array:
        for _ in range(8):
            g = f.gradient(q)
            g[0] = 0.0
            q = q - f.value(q) * g / max(float(g @ g), 1e-300)
        return q

    first, kernel = slope(a, np.ones(len(a)))
    for _ in range(60):
        middle = onto((a + b) / 2.0)
        here, kernel = slope(middle, kernel)
        if here * first > 0:
            a = middle
        else:
            b = middle
    if float(np.linalg.norm(kernel[1:])) < _ON_AXIS:
        return None
    p = pose(model, a, at=at, check_finite=False).translation
    axis, origin = first_axis(model, at)
    height = float((p - origin) @ axis)
    radius = float(np.linalg.norm(p - origin - height * axis))
    if radius < _ON_AXIS * float(np.abs(p - origin).max()):
        return None
    return Cusp(np.pi - np.mod(np.pi - a, 2 * np.pi), radius, height, abs(slope(a, kernel)[0]))


def first_axis(model: RobotModel, at: str) -> tuple[Array, Array]:
    """Direction and a point of the first joint's axis on the way to a link, base axes."""
    joint = model.path(model.link_joints[model.link(at)])[0]
    R, p = split_pose(model.placements[joint])
    w, v = model.screws[joint][ANGULAR], model.screws[joint][LINEAR]
    return R @ w, R @ np.cross(w, v) + p
