"""Small solids and how they are turned: what the signs and the arm of a scene are made of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ..namespaces import Array

_SLENDER = 1e-9


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles in the axes of a link.

    Attributes:
        vertices: (k, 3) [m]; faces: (m, 3) indices of vertices; color: red, green, blue 0 to 255, or None.
    """

    vertices: Array
    faces: Array
    color: tuple[int, int, int] | None = None


@cache
def cylinder(sides: int = 20) -> Solid:
    """A cylinder of radius 1 about z, from z = 0 to 1; of four sides, a block."""
    turns = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], -1)
    vertices = np.concatenate([ring, ring + np.array([0.0, 0.0, 1.0]), [[0, 0, 0], [0, 0, 1]]])
    k = np.arange(sides)
    after, bottom, top = (k + 1) % sides, np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    faces = [(k, after, after + sides), (k, after + sides, k + sides), (after, k, bottom), (k + sides, after + sides, top)]
    return Solid(vertices, np.concatenate([np.stack(face, -1) for face in faces]))


def between(start: Array, end: Array, radius: float) -> tuple[Array, Array, tuple[float, float, float]]:
    """Where the cylinder stands that reaches from a point to another: quaternion, position and scale."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < _SLENDER:
        return np.array([1.0, 0.0, 0.0, 0.0]), start, (radius, radius, _SLENDER)
    return quaternions(turned_to(along / length)), start, (radius, radius, length)


def turned_to(direction: Array) -> Array:
    """(3, 3) a rotation that takes z to a unit direction."""
    aside = np.eye(3)[int(np.argmin(np.abs(direction)))]
    x = np.cross(aside, direction)
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction], -1)


def quaternions(R: Array) -> Array:
    """(..., 4) unit quaternions, real part first and not negative, of rotations (..., 3, 3).

    Each is the row of 4 q qᵀ that is the longest: no difference of nearly equal numbers. Source: Shepperd, J. Guidance and
    Control 1(3), 1978.

    Example:
        >>> quaternions(np.eye(3))
        array([1., 0., 0., 0.])
    """
    x, y, z = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    twice = [
        [1 + x + y + z, R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]],
        [R[..., 2, 1] - R[..., 1, 2], 1 + x - y - z, R[..., 1, 0] + R[..., 0, 1], R[..., 0, 2] + R[..., 2, 0]],
        [R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] + R[..., 0, 1], 1 - x + y - z, R[..., 2, 1] + R[..., 1, 2]],
        [R[..., 1, 0] - R[..., 0, 1], R[..., 0, 2] + R[..., 2, 0], R[..., 2, 1] + R[..., 1, 2], 1 - x - y + z],
    ]
    products = np.stack([np.stack(row, -1) for row in twice], -2)
    longest = np.argmax(np.einsum("...ii->...i", products), -1)
    q = np.take_along_axis(products, longest[..., None, None], -2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)
