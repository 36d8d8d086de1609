"""Zonotopes: what a box becomes under a linear map, {Σ s_i g_i : |s_i| <= 1}. Bare NumPy arrays.

Facets, corners and polygons are found from combinations of generators and told apart by the *state* of each generator:
+1 or -1 where it is at an end, 0 where it is free. All of it happens in round coordinates, in which Σ g_i g_iᵀ = 1: there
no unit and no near singularity makes one direction smaller than another.

Source: McMullen, "On zonotopes", Trans. AMS 159, 1971; Gouttefarde, Krut, "Characterization of parallel manipulator
available wrench set facets", Advances in Robot Kinematics, 2010 (facets by shifted hyperplanes).
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..namespaces import Array
from .exact import exact_directions, exact_planes
from .surfaces import Faces, closes, plane_bases

_TOLERANCES = (1e-10, 1e-12, 1e-14)
"""Sines below this count as zero. The next is tried where planes meet so nearly that the surface does not close; after the
last, the generators are taken as exact numbers."""
_NOTHING = 1e-13  # a generator shorter than this in round coordinates


class Shape(NamedTuple):
    """A zonotope in round coordinates.

    Attributes:
        normals: (m, r) outward unit normals of all facets.
        sides: (m, n) state of each generator on the facet.
        corners: (v, n) states of the corners; None for r > 3.
        faces: the polygon of each facet for r = 3, else one cell (r < 3) or nothing.
    """

    normals: Array
    sides: Array
    corners: Array | None
    faces: Faces


class Classes(NamedTuple):
    """Parallel generators taken together: (c, r) unit directions; class (n), -1 for none, and sign (n) of each generator."""

    directions: Array
    of: Array
    signs: Array

    def states(self, of_classes: Array) -> Array:
        """(m, n) states of the generators from those of their classes, (m, c)."""
        padded = np.zeros((len(of_classes), of_classes.shape[1] + 1), dtype=np.int8)
        padded[:, :-1] = of_classes
        return padded[:, self.of] * self.signs.astype(np.int8)


def zonotope(generators: Array) -> Shape:
    """Facets, and for r <= 3 corners and polygons, of generators (n, r) that span their space."""
    n, r = generators.shape
    if r == 0:
        return Shape(np.zeros((0, 0)), np.zeros((0, n)), np.zeros((1, n)), ((0,),))
    if r == 3:
        for tolerance in _TOLERANCES:
            classes = parallel_classes(generators, tolerance)
            if (found := _solid(classes, tolerance)) is not None:
                return found
        return _exact_solid(generators)
    classes = parallel_classes(generators, _TOLERANCES[0])
    normals, on = facet_normals(classes.directions, _TOLERANCES[0])
    sides = np.where(on, 0.0, np.sign(normals @ classes.directions.T))
    both, sides = np.vstack([normals, -normals]), classes.states(np.vstack([sides, -sides]))
    if r > 3:
        return Shape(both, sides, None, ())
    if r == 1:
        ends = np.array([[-1.0], [1.0]]) * np.sign(classes.directions[0])
        return Shape(both, sides, classes.states(ends), ((0, 1),))
    corners = _zonogon(*_turns(classes.directions))
    return Shape(both, sides, classes.states(corners), (tuple(range(len(corners))),))


def parallel_classes(generators: Array, tolerance: float) -> Classes:
    """Generators (n, r) grouped by direction; the longest of a class gives it its own."""
    lengths = np.linalg.norm(generators, axis=1)
    of, signs = np.full(len(generators), -1), np.zeros(len(generators))
    directions: list[Array] = []
    for i in np.argsort(-lengths, kind="stable"):
        if lengths[i] <= _NOTHING:
            continue
        unit = generators[i] / lengths[i]
        for c, direction in enumerate(directions):
            along = float(unit @ direction)
            if np.linalg.norm(unit - along * direction) <= tolerance:
                of[i], signs[i] = c, np.sign(along)
                break
        else:
            of[i], signs[i] = len(directions), 1.0
            directions.append(unit)
    return Classes(np.array(directions).reshape(-1, generators.shape[1]), of, signs)


def facet_normals(directions: Array, tolerance: float) -> tuple[Array, Array]:
    """Unit normals (m, r), one of each opposite pair, and which of the (c, r) unit directions lie in the facet, (m, c).

    Law: a facet is spanned by r - 1 independent generators, and holds all others at right angles to its normal.
    """
    c, r = directions.shape
    if r == 1:
        return np.ones((1, 1)), np.zeros((1, c), dtype=bool)
    subsets = np.array(list(combinations(range(c), r - 1)), dtype=int).reshape(-1, r - 1)
    normals, sines = _perpendicular(directions[subsets])
    order = np.argsort(-sines, kind="stable")  # the best conditioned subset speaks for its facet
    order = order[sines[order] > tolerance]
    normals = normals[order]
    on = np.abs(normals @ directions.T) <= tolerance
    _, first = np.unique(np.packbits(on, axis=1), axis=0, return_index=True)
    first = np.sort(first)
    return normals[first], on[first]


def _perpendicular(sets: Array) -> tuple[Array, Array]:
    """The unit vector at right angles to r - 1 unit vectors (s, r - 1, r), and how independent those are: Gram-Schmidt."""
    r = sets.shape[-1]
    basis: list[Array] = []
    sines = np.ones(len(sets))
    for k in range(r - 1):
        rest, length = _rest(sets[:, k], basis)
        sines = np.minimum(sines, length)
        basis.append(rest)
    taken = sum((b * b for b in basis), np.zeros((len(sets), r)))
    last, _ = _rest(np.eye(r)[np.argmin(taken, axis=1)], basis)  # the coordinate axis that is least used
    return last, sines


def _rest(vectors: Array, basis: list[Array]) -> tuple[Array, Array]:
    """What is left of unit vectors (s, r) beyond an orthonormal basis, as unit vectors, and its length."""
    rest, length = vectors, np.ones(len(vectors))
    for _ in range(2):  # twice: nearly dependent vectors lose digits
        for direction in basis:
            rest = rest - np.einsum("sr,sr->s", direction, rest)[:, None] * direction
        norm = np.sqrt(np.einsum("sr,sr->s", rest, rest))
        rest, length = rest / np.where(norm > 0, norm, 1.0)[:, None], length * norm
    return rest, length


def _turns(vectors: Array) -> tuple[Array, Array]:
    """The order (c) of vectors in the plane by the direction of their lines, and the signs that turn them to one side."""
    signs = np.where((vectors[:, 1] < 0) | ((vectors[:, 1] == 0) & (vectors[:, 0] < 0)), -1.0, 1.0)
    turned = vectors * signs[:, None]
    return np.argsort(np.arctan2(turned[:, 1], turned[:, 0]), kind="stable"), signs


def _zonogon(order: Array, signs: Array) -> Array:
    """(2c, c) states of the corners of Σ s_i v_i in the plane, counter-clockwise; no two of the c vectors are parallel."""
    states = -np.ones((len(order), len(order)))
    for step, i in enumerate(order[:-1]):
        states[step + 1 :, i] = 1.0
    return np.vstack([states * signs, -states * signs])


def _solid(classes: Classes, tolerance: float) -> Shape | None:
    """A zonotope in space; None where nearly coplanar generators leave its surface open."""
    c = len(classes.directions)
    normals, on = facet_normals(classes.directions, tolerance)
    sizes = on.sum(axis=1)
    if sizes.min() < 2 or int(np.sum(sizes * (sizes - 1))) != c * (c - 1):  # two directions span one plane, not more
        return None
    sides = np.where(on, 0.0, np.sign(normals @ classes.directions.T))
    turns = [_turns(classes.directions[inside] @ plane.T) for plane, inside in zip(plane_bases(normals), on, strict=True)]
    return _assembled(classes, normals, sides, turns)


def _exact_solid(generators: Array) -> Shape:
    """A zonotope in space with its generators as exact numbers: its surface closes, with facets as narrow as they are."""
    classes = Classes(*exact_directions(generators))
    found = _assembled(classes, *exact_planes(classes.directions))
    assert found is not None  # exact signs are those of some arrangement of planes, which has no gaps
    return found


def _assembled(classes: Classes, normals: Array, sides: Array, turns: list[tuple[Array, Array]]) -> Shape | None:
    """The polygons of a zonotope in space from the states of its facets; None when they leave gaps."""
    known: dict[bytes, int] = {}
    faces, outward, facets = [], [], []
    for normal, side, (order, signs) in zip(normals, sides, turns, strict=True):
        polygon = _zonogon(order, signs)
        for sign in (1.0, -1.0):
            corners = np.tile(sign * side + 0.0, (len(polygon), 1))
            corners[:, side == 0] = polygon if sign > 0 else polygon[::-1]
            faces.append(tuple(known.setdefault(state.tobytes(), len(known)) for state in corners))
            outward.append(sign * normal)
            facets.append(sign * side + 0.0)
    states = np.array([np.frombuffer(key) for key in known])
    if not closes(tuple(faces), len(known)):
        return None
    return Shape(np.array(outward), classes.states(np.array(facets)), classes.states(states), tuple(faces))
