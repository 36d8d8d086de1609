"""How things of a scene are turned and stretched."""

from __future__ import annotations

import numpy as np

from ..namespaces import Array

_SLENDER = 1e-9


def between(start: Array, end: Array, radius: float) -> tuple[Array, Array, tuple[float, float, float]]:
    """Where a cylinder of radius 1 and length 1 reaches from a point to another: quaternion, position and scale."""
    along, middle = end - start, (start + end) / 2
    length = float(np.linalg.norm(along))
    if length < _SLENDER:
        return np.array([1.0, 0.0, 0.0, 0.0]), middle, (radius, radius, _SLENDER)
    return quaternions(turned_to(along / length)), middle, (radius, radius, length)


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
