"""Axes of joints as lines in space, what holds among them at a posture, and what holds among them always."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .. import definition
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..spatial import ANGULAR, LINEAR
from ..tasks import prismatic_columns

TOLERANCE = 1e-7
GENERAL = 1e-6  # at random postures nothing but a structural relation comes this close
_SAMPLES = 6


class Axes(NamedTuple):
    """The axes of the joints that move a link: directions (m, 3), points (m, 3) (NaN for sliding ones), the tip (3)."""

    u: Array
    p: Array
    tip: Array
    size: float

    @property
    def turning(self) -> list[int]:
        """Those that have a place."""
        return [i for i in range(len(self.p)) if np.isfinite(self.p[i, 0])]

    def parallel(self, i: int, j: int) -> float:
        """Sine of the angle between two axes."""
        return _size_of_cross(self.u[i], self.u[j])

    def off(self, point: Array, i: int) -> float:
        """Distance of a point from an axis, in reaches."""
        return _size_of_cross(self.u[i], point - self.p[i]) / self.size

    def meeting(self, i: int, j: int, tolerance: float) -> Array | None:
        """The point in which two axes that are not parallel meet."""
        normal = np.cross(self.u[i], self.u[j])
        square = float(normal @ normal)
        if square <= tolerance**2:
            return None
        apart = self.p[j] - self.p[i]
        if abs(apart @ normal) / np.sqrt(square) > tolerance * self.size:
            return None
        return np.asarray(self.p[i] + (np.cross(apart, self.u[j]) @ normal / square) * self.u[i])

    def plane(self, i: int, j: int, tolerance: float) -> tuple[Array, Array] | None:
        """A point and the normal of the plane through axis i that is parallel to axis j; None where it is not one plane."""
        if self.parallel(i, j) > tolerance:
            normal = np.cross(self.u[i], self.u[j])
        else:
            apart = self.p[j] - self.p[i]
            normal = np.cross(self.u[i], apart)
            if np.linalg.norm(normal) <= tolerance * self.size:
                return None
        return self.p[i], normal / np.linalg.norm(normal)


def _size_of_cross(a: Array, b: Array) -> float:
    """The length of the cross product of two vectors, without the overhead of arrays."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return math.hypot(y * w - z * v, z * u - x * w, x * v - y * u)


def axes_at(model: RobotModel, q: Array, at: str, size: float) -> Axes:
    """The axes at one posture, in base axes at the base origin."""
    return axes_along(model, np.asarray(q)[None], at, size)[0]


def axes_along(model: RobotModel, postures: Array, at: str, size: float) -> list[Axes]:
    """The axes at postures (k, n), each in base axes at the base origin."""
    link = model.link(at)
    array, xp = as_array(postures)
    poses = definition.joint_poses(model, array, xp)
    path = list(model.path(model.link_joints[link]))
    _, tips = definition.link_pose(model, poses, link, array, xp)
    if not path:
        return [Axes(np.zeros((0, 3)), np.zeros((0, 3)), tip, size) for tip in tips]
    twists = definition.spatial_twists(model, poses, xp)[..., path, :]
    v, w = twists[..., LINEAR], twists[..., ANGULAR]
    turns = np.linalg.norm(w, axis=-1, keepdims=True) > 0.5  # unit screws
    points, directions = np.where(turns, np.cross(w, v), np.nan), np.where(turns, w, v)
    return [Axes(*of_one, size) for of_one in zip(directions, points, tips, strict=True)]


class Structure(NamedTuple):
    """The axes at random postures: what holds at all of them is structure and not news."""

    samples: tuple[Axes, ...]

    def always(self, holds: Callable[[Axes], bool]) -> bool:
        """Whether something holds at every sample."""
        return all(holds(axes) for axes in self.samples)

    def parallel(self, i: int, j: int) -> bool:
        """Whether two axes are always parallel."""
        return self.always(lambda axes: axes.parallel(i, j) <= GENERAL)

    def point(self, joints: Sequence[int]) -> bool:
        """Whether the axes of joints always meet in one point."""
        return self.always(lambda axes: common_point(axes, joints, GENERAL) is not None)


def random_postures(model: RobotModel, size: float) -> Array:
    """(k, n) the postures at which what holds is structure; sliding joints within the reach given."""
    rng = np.random.default_rng(20260207)
    return np.asarray(rng.uniform(-np.pi, np.pi, (_SAMPLES, model.n)) * np.where(prismatic_columns(model), size, 1.0))


def structure_of(model: RobotModel, at: str, size: float) -> Structure:
    """The structure of a link's chain, from its axes at a few random postures."""
    return Structure(tuple(axes_along(model, random_postures(model, size), at, size)))


def common_point(axes: Axes, joints: Sequence[int], tolerance: float) -> Array | None:
    """The one point in which the axes of joints meet; None where they do not, or line up."""
    if not set(joints) <= set(axes.turning):
        return None
    for i, j in itertools.combinations(joints, 2):
        if (point := axes.meeting(i, j, tolerance)) is not None:
            return point if all(axes.off(point, k) <= tolerance for k in joints) else None
    return None


def plane_of(axes: Axes, joints: Sequence[int], tolerance: float) -> Array | None:
    """The normal of the plane of parallel axes on at least three different lines."""
    first = joints[0]
    if any(axes.parallel(first, j) > tolerance for j in joints):
        return None
    distinct = [first]
    for j in joints[1:]:
        if all(axes.off(axes.p[j], i) > tolerance for i in distinct):
            distinct.append(j)
    if len(distinct) < 3:
        return None
    across = np.cross(axes.u[first], axes.p[distinct[1:]] - axes.p[first]) / axes.size
    _, sigma, Vt = np.linalg.svd(across)
    return np.asarray(Vt[0]) if sigma[1] <= tolerance * max(1.0, sigma[0]) else None
