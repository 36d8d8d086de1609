"""Corners, rays and facets of {x : A x <= b} without lines in it, in at most three dimensions. Bare NumPy arrays.

A corner is known by the rows that meet in it: two points in which the same rows meet are one, however they were found.
Source: Minkowski and Weyl: such a set is the hull of its corners plus the cone of its rays; Ziegler, "Lectures on
polytopes" (1995), theorem 1.2 and proposition 2.3.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..namespaces import Array
from .exact import exact_corners
from .surfaces import Faces, cell, closes, ordered, plane_bases

_TOLERANCES = (1e-10, 1e-12, 1e-14)
"""Distances below this count as zero, for sets of about unit size. The next is tried where planes meet so nearly in a point
that the surface does not close; after the last, the rows are taken as exact numbers."""


class Outline(NamedTuple):
    """What {x : A x <= b} is made of.

    Attributes:
        corners: (v, r); rays: (u, r) unit directions of the edges that do not end.
        facets: for each facet the rows (indices) that make it, more than one where they coincide.
        faces: the polygon of each facet of a bounded set in space; one cell (r < 3, or flat); nothing when unbounded.
        dimension: of the smallest plane that holds the set.
    """

    corners: Array
    rays: Array
    facets: tuple[tuple[int, ...], ...]
    faces: Faces
    dimension: int


def outline(A: Array, b: Array) -> Outline:
    """Corners, rays, facets and polygons of {x : A x <= b}, which has points, unit rows (m, r) and contains no line."""
    for tolerance in _TOLERANCES:
        found, whole = _outlined(A, b, tolerance)
        if whole:
            return found
    if found.dimension < 3 or len(found.rays):
        return found
    corners, _, facets, faces = exact_corners(A, b)
    return Outline(corners, found.rays, facets, faces, 3)


def _outlined(A: Array, b: Array, tolerance: float) -> tuple[Outline, bool]:
    """The outline at one tolerance, and whether it is whole: some corner, and no gaps in the surface."""
    r = A.shape[1]
    corners, on = _corners(A, b, tolerance)
    if not len(corners):
        return Outline(corners, corners, (), (), 0), False
    rays, along = _rays(A, tolerance)
    spread = np.vstack([corners[1:] - corners[0], rays])
    sigma = np.linalg.svd(spread, compute_uv=False) if len(spread) else np.zeros(0)
    dimension = int((sigma > tolerance * max(1.0, sigma.max(initial=0.0))).sum())
    facets = _facets(np.vstack([on, along]), len(on), dimension, r)
    if len(rays):
        return Outline(corners, rays, facets, (), dimension), True
    if dimension < 2:  # one or two corners, others are the same but for rounding
        kept = list(cell(corners, dimension)[0])
        return Outline(corners[kept], rays, facets, (tuple(range(len(kept))),), dimension), True
    if dimension == 2:
        whole = r > 2 or len(facets) == len(corners)
        return Outline(corners, rays, facets, cell(corners, dimension), dimension), whole
    faces = []
    for facet, plane in zip(facets, plane_bases(A[[facet[0] for facet in facets]]), strict=True):
        members = np.flatnonzero(on[:, facet[0]])
        faces.append(tuple(int(members[i]) for i in ordered(corners[members] @ plane.T)))
    return Outline(corners, rays, facets, tuple(faces), dimension), closes(tuple(faces), len(corners))


def _corners(A: Array, b: Array, tolerance: float) -> tuple[Array, Array]:
    """Points (v, r) where r independent rows meet and no row is broken, and which rows (v, m) meet there."""
    m, r = A.shape
    subsets = np.array(list(combinations(range(m), r)), dtype=int).reshape(-1, r)
    determinants = _determinants(A[subsets])
    subsets = subsets[np.abs(determinants) > tolerance]
    subsets = subsets[np.argsort(-np.abs(determinants[np.abs(determinants) > tolerance]), kind="stable")]
    points = np.linalg.solve(A[subsets], b[subsets][..., None])[..., 0]
    slack = b - points @ A.T
    small = tolerance * (1.0 + np.abs(points).max(axis=1, initial=0.0))[:, None]
    kept = np.all(slack >= -small, axis=1)
    points, on = points[kept], np.abs(slack[kept]) <= small[kept]
    chosen = _maximal(on)
    return points[chosen], on[chosen]


def _determinants(rows: Array) -> Array:
    if rows.shape[-1] == 1:
        return rows[:, 0, 0]
    if rows.shape[-1] == 2:
        return rows[:, 0, 0] * rows[:, 1, 1] - rows[:, 0, 1] * rows[:, 1, 0]
    return np.einsum("si,si->s", np.cross(rows[:, 0], rows[:, 1]), rows[:, 2])


def _maximal(on: Array) -> list[int]:
    """The first of each set of rows (s, m) that no larger one contains."""
    _, first = np.unique(np.packbits(on, axis=1), axis=0, return_index=True)
    distinct = [int(i) for i in np.sort(first)]
    sizes, shared = on[distinct].sum(axis=1), on[distinct].astype(int) @ on[distinct].astype(int).T
    contained = np.any((shared == sizes[:, None]) & (sizes > sizes[:, None]), axis=1)
    return [i for i, inner in zip(distinct, contained, strict=True) if not inner]


def _rays(A: Array, tolerance: float) -> tuple[Array, Array]:
    """Unit directions (u, r) along which r - 1 rows never end and none is broken, and which rows (u, m) those are."""
    m, r = A.shape
    if r == 1:
        lines = np.ones((1, 1))
    elif r == 2:
        lines = np.stack([-A[:, 1], A[:, 0]], axis=1)
    else:
        subsets = np.array(list(combinations(range(m), 2)), dtype=int).reshape(-1, 2)
        lines = np.cross(A[subsets[:, 0]], A[subsets[:, 1]])
        lengths = np.linalg.norm(lines, axis=1)
        lines = lines[lengths > tolerance] / lengths[lengths > tolerance][:, None]
    directions = np.vstack([lines, -lines])
    slope = directions @ A.T
    directions = directions[np.all(slope <= tolerance, axis=1)]
    on = np.abs(directions @ A.T) <= tolerance
    chosen = _maximal(on) if len(on) else []
    return directions[chosen], on[chosen]


def _facets(on: Array, corners: int, dimension: int, r: int) -> tuple[tuple[int, ...], ...]:
    """The rows of each facet, from which corners and rays (v + u, m) lie on which row.

    A set of full dimension has one facet for each set of r or more points on a row; of a flat one, every row is kept that
    holds as much of it as a facet does, since rows of different slopes hold the same points.
    """
    enough = [i for i in range(on.shape[1]) if on[:corners, i].any() and on[:, i].sum() >= dimension]
    if dimension < r:
        return tuple((i,) for i in enough)
    groups: dict[bytes, list[int]] = {}
    for i in enough:
        groups.setdefault(on[:, i].tobytes(), []).append(i)
    return tuple(tuple(group) for group in groups.values())
