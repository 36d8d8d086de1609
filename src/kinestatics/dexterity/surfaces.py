"""Polygons of a polytope's surface: their order, whether they close, and what they enclose. Bare NumPy arrays."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ..namespaces import Array

Faces = tuple[tuple[int, ...], ...]
"""Indices of corners, a tuple for each polygon, in order around it."""


def plane_bases(normals: Array) -> Array:
    """(m, 2, 3) two unit vectors that make a right-handed system with each unit normal (m, 3)."""
    helpers = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(helpers, normals)
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normals, first)], axis=1)


def ordered(points: Array) -> tuple[int, ...]:
    """Indices of the corners of a convex polygon (v, 2), counter-clockwise."""
    spokes = points - points.mean(axis=0)
    return tuple(int(i) for i in np.argsort(np.arctan2(spokes[:, 1], spokes[:, 0]), kind="stable"))


def closes(faces: Faces, corners: int) -> bool:
    """Whether polygons make one closed surface: every edge is walked once each way, and V - E + F = 2."""
    edges = Counter(edge for face in faces for edge in zip(face, (*face[1:], face[0]), strict=True))
    paired = all(count == 1 and edges[b, a] == 1 for (a, b), count in edges.items())
    return paired and corners - len(edges) // 2 + len(faces) == 2


def cell(corners: Array, dimension: int) -> Faces:
    """The one cell of a bounded set of dimension 0, 1 or 2, (v, k) corners: a point, a segment, a polygon in order."""
    if dimension == 0:
        return ((0,),)
    spokes = corners - corners.mean(axis=0)
    axes = np.eye(2) if corners.shape[-1] == dimension == 2 else np.linalg.svd(spokes, full_matrices=False)[2]
    if dimension == 1:
        along = spokes @ axes[0]
        return ((int(np.argmin(along)), int(np.argmax(along))),)
    return (ordered(spokes @ axes[:2].T),)


def turned(faces: Faces, matrix: Array) -> Faces:
    """The polygons after a matrix (r, k): turned round where it is a mirror, so that their order stays what it was."""
    if matrix.shape[0] != matrix.shape[1] or np.linalg.slogdet(matrix)[0] > 0:
        return faces
    return tuple(face[:1] + face[:0:-1] for face in faces)


def enclosed(corners: Array, faces: Faces) -> float:
    """Length, area or volume of a bounded set with inner points: (v, k) corners, k <= 3, and its polygons."""
    k = corners.shape[-1]
    if k == 1:
        return float(np.ptp(corners))
    U, sigma, _ = np.linalg.svd(corners - corners.mean(axis=0), full_matrices=False)
    spokes = U * np.sqrt(len(corners))  # round: a body a billion times as long as thick would lose its volume in rounding
    unit = float(np.prod(sigma / np.sqrt(len(corners))))
    if k == 2:
        a = spokes[list(faces[0])]
        b = np.roll(a, -1, axis=0)
        return unit * 0.5 * abs(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])))
    return unit * abs(sum(_fan(spokes[list(face)]) for face in faces)) / 6.0


def _fan(polygon: Array) -> float:
    """Six times the volume between a polygon and the origin."""
    normals = np.cross(polygon[1:-1] - polygon[0], polygon[2:] - polygon[0])
    return float(polygon[0] @ normals.sum(axis=0))
