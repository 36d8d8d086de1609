"""Ellipsoids and polytopes as things to draw: lines, points that span them, and lines that go on. Floor 9."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations, product

import numpy as np

from .dexterity import Polytope
from .namespaces import Array

_AROUND = 96  # points of a closed curve
_ON = 1e-8  # of its size: how far a corner may be from a facet that holds it
_FADE = 0.5  # of the length at which a line without end is cut: how far it goes on, dashed


@dataclass(frozen=True, eq=False)
class Body:
    """A convex body, in the coordinates and the unit of its rows.

    Attributes:
        points: (p, k) whose hull it is, as far as it is drawn.
        lines: (m, k) its lines; fading: (2, k) from where a line without end is cut to where its drawing ends.
        faces: (m, k) its flat faces, in order around them; none where it is round.
    """

    points: Array
    lines: tuple[Array, ...]
    fading: tuple[Array, ...] = ()
    faces: tuple[Array, ...] = ()


def ellipsoid_body(axes: Array, radii: Array, clip: float) -> Body:
    """An ellipsoid by its principal sections; where it is unbounded, a strip, cylinder or slab that is cut at `clip`.

    Args:
        axes: (k, k) columns are unit directions; radii: (k) half-lengths, 0 where flat, inf where unbounded.
        clip: half-length at which axes without end are cut.
    """
    endless = [clip * axes[:, i] for i in np.flatnonzero(np.isinf(radii))]
    spokes = [radii[i] * axes[:, i] for i in np.flatnonzero(np.isfinite(radii))]
    corners = [_sum(signs, endless, len(axes)) for signs in product((-1.0, 1.0), repeat=len(endless))]
    lines = [end + section for section in _sections(spokes) for end in corners[:2]]
    if len(spokes) == len(axes) <= 2:
        lines += [np.array([-spoke, spoke]) for spoke in spokes]
    fading = []
    for along, foot in product(endless, _feet(spokes, len(axes))):
        lines.append(np.array([foot - along, foot + along]))
        fading += [np.array([foot + sign * along, foot + sign * (1 + _FADE) * along]) for sign in (-1.0, 1.0)]
    surface = _surface(spokes, len(axes))
    points = np.concatenate([surface + end for end in corners])
    return Body(points, tuple(line for line in lines if np.ptp(line, axis=0).any()), tuple(fading))


def _sum(signs: tuple[float, ...], vectors: list[Array], k: int) -> Array:
    return np.array([sign * vector for sign, vector in zip(signs, vectors, strict=True)]).reshape(-1, k).sum(axis=0)


def _circle(count: int = _AROUND) -> Array:
    """(count + 1, 2): a closed unit circle, its ends the very same point."""
    turns = 2 * np.pi * (np.arange(count + 1) % count) / count
    return np.stack([np.cos(turns), np.sin(turns)], -1)


def _sections(spokes: list[Array]) -> list[Array]:
    """The ellipses through each two half-axes."""
    return [_circle() @ np.stack(pair) for pair in combinations(spokes, 2)]


def _feet(spokes: list[Array], k: int) -> list[Array]:
    """The ends of the finite half-axes, each once; the centre where there are none."""
    ends = {tuple(sign * spoke + 0.0) for spoke in spokes for sign in (-1.0, 1.0)}
    longer = [np.array(end) for end in sorted(ends) if np.any(end)]
    return longer or [np.zeros(k)]


def _surface(spokes: list[Array], k: int) -> Array:
    """Points whose hull is the bounded part."""
    if len(spokes) < 3:
        return np.concatenate([np.array(_feet(spokes, k)), *_sections(spokes)])
    return _ball() @ np.stack(spokes)


@cache
def _ball() -> Array:
    """Points all over a unit sphere."""
    around, height = _circle(36)[:-1], np.sin(np.linspace(-np.pi / 2, np.pi / 2, 19))
    return np.array([[*(np.sqrt(1 - h * h) * c), h] for h in height for c in around])


def polytope_body(polytope: Polytope, clip: float) -> Body:
    """A polytope by its faces; where it is unbounded, by its edges, those without end cut at `clip` beyond its corners.

    Args:
        polytope: of up to three rows, not empty. clip: in its unit.
    """
    corners = np.zeros((0, len(polytope.rows))) if polytope.corners is None else polytope.corners
    if polytope.is_bounded:
        faces = tuple(corners[[*face, face[0]]] for face in polytope.faces if len(face) > 2)
        segments = tuple(corners[list(face)] for face in polytope.faces if len(face) == 2)
        return Body(corners, segments if not faces else (), faces=faces)
    lines: list[Array] = []
    fading: list[Array] = []
    for end in _ends(polytope.free, clip):
        lines += [np.array([a, b]) + end for a, b in _edges(polytope, corners)]
    endless = [(corner, ray) for corner in corners for ray in polytope.rays if _is_edge(polytope, corner, corner, ray)]
    endless += [(corner, sign * line) for corner in corners for line in polytope.free for sign in (1.0, -1.0)]
    for corner, ray in endless:
        lines.append(np.array([corner, corner + clip * ray]))
        fading.append(np.array([corner + clip * ray, corner + (1 + _FADE) * clip * ray]))
    cut = [corner + clip * ray for corner in corners for ray in polytope.rays]
    points = np.concatenate([np.array([*corners, *cut]) + end for end in _ends(polytope.free, clip)])
    return Body(points, tuple(lines), tuple(fading))


def _ends(free: Array, clip: float) -> list[Array]:
    """Where a body that goes on along lines is cut: every combination of their two ends."""
    return [_sum(signs, list(clip * free), free.shape[1]) for signs in product((-1.0, 1.0), repeat=len(free))]


def _edges(polytope: Polytope, corners: Array) -> list[tuple[Array, Array]]:
    """The pairs of corners that an edge joins."""
    return [(a, b) for a, b in combinations(corners, 2) if _is_edge(polytope, a, b, b - a)]


def _is_edge(polytope: Polytope, a: Array, b: Array, along: Array) -> bool:
    """Whether the facets that hold two points, and the direction from one on, leave this direction alone."""
    slack = _ON * (polytope.size or 1.0)
    inside = np.abs(polytope.normals @ along) <= _ON * float(np.linalg.norm(along))
    holding = inside & (np.abs(polytope.normals @ a - polytope.offsets) <= slack)
    holding &= np.abs(polytope.normals @ b - polytope.offsets) <= slack
    if not np.any(holding):
        return len(polytope.rows) - len(polytope.free) == 1
    rank = int(np.linalg.matrix_rank(polytope.normals[holding], tol=1e-6))
    return rank == len(polytope.rows) - len(polytope.free) - 1
