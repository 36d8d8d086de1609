"""Planes through vectors and corners of planes in space, with floating numbers taken as the exact fractions they are.

Where vectors are coplanar, or planes meet in one point, but for the last digits, rounded signs contradict one another:
then these decide. Bare NumPy arrays.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cmp_to_key
from itertools import combinations

import numpy as np

from ..namespaces import Array

_CLEAR = 1e-6  # what rounding never comes near to, for rows of unit length


def _whole(vector: Array) -> Array:
    """Whole numbers along a vector, exactly."""
    fractions = [Fraction(float(x)) for x in vector]
    common = max(f.denominator for f in fractions)  # all are powers of two
    return np.array([f.numerator * (common // f.denominator) for f in fractions], dtype=object)


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def _unit(vector: Array) -> Array:
    """Whole numbers of any size as a unit vector of floats."""
    largest = max(abs(x) for x in vector)
    scaled = np.array([float(Fraction(x, largest)) for x in vector])
    return scaled / np.linalg.norm(scaled)


def _sign(x: int) -> int:
    return (x > 0) - (x < 0)


def exact_directions(generators: Array) -> tuple[Array, Array, Array]:
    """Directions (c, 3), class (n) and sign (n) of generators, exactly parallel ones together; -1 and 0 for zero ones.

    A direction is the first generator of its class itself, not made a unit vector, which would round it.
    """
    directions: list[Array] = []
    of, signs = np.full(len(generators), -1), np.zeros(len(generators))
    for i, generator in enumerate(generators):
        if not np.any(generator):
            continue
        whole = _whole(generator)
        for c, direction in enumerate(directions):
            other = _whole(direction)
            if not np.any(_cross(whole, other)):
                of[i], signs[i] = c, 1.0 if whole @ other > 0 else -1.0
                break
        else:
            of[i], signs[i] = len(directions), 1.0
            directions.append(generator)
    return np.array(directions), of, signs


def exact_planes(directions: Array) -> tuple[Array, Array, list[tuple[Array, Array]]]:
    """The planes that (c, 3) vectors span in pairs.

    Returns:
        Unit normals (m, 3); sides (m, c) of the vectors, +1, -1 or 0 in the plane; and for each plane the order of the
        vectors in it by the direction of their lines, with the signs that turn them to one side.
    """
    whole = [_whole(direction) for direction in directions]
    stacked, known = np.array(whole), set[bytes]()
    normals, sides, turns = [], [], []
    for i, j in combinations(range(len(whole)), 2):
        normal = _cross(whole[i], whole[j])
        side = np.array([(x > 0) - (x < 0) for x in stacked @ normal], dtype=float)
        if (key := (side == 0).tobytes()) in known:
            continue
        known.add(key)
        normals.append(_unit(normal))
        sides.append(side)
        turns.append(_exact_turns([whole[k] for k in np.flatnonzero(side == 0)], normal))
    return np.array(normals), np.array(sides), turns


def _exact_turns(vectors: list[Array], normal: Array) -> tuple[Array, Array]:
    first = vectors[0]
    signs = [1 if k == 0 or normal @ _cross(first, v) > 0 else -1 for k, v in enumerate(vectors)]
    turned = [sign * v for sign, v in zip(signs, vectors, strict=True)]

    def before(a: int, b: int) -> int:
        return -_sign(normal @ _cross(turned[a], turned[b]))

    order = sorted(range(len(turned)), key=cmp_to_key(before))
    return np.array(order), np.array(signs, dtype=float)


def exact_corners(A: Array, b: Array) -> tuple[Array, Array, tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]:
    """The bounded set {x : A x <= b} in space, (m, 3) and (m).

    Returns:
        Corners (v, 3); which rows (v, m) meet in them; the rows of each facet; its polygon, counter-clockwise from outside.
    """
    rows = np.array([_whole(row) for row in np.c_[A, -b]])
    corners: list[Array] = []
    known = dict[bytes, Array]()
    for i, j, k in _candidates(A, b):
        corner = _meeting(rows[i], rows[j], rows[k])
        if corner is None or np.any((slack := rows @ corner) > 0):
            continue
        on = np.array([x == 0 for x in slack])
        if on.tobytes() not in known:
            known[on.tobytes()] = on
            corners.append(corner)
    on = np.array(list(known.values())).reshape(-1, len(b))
    groups: dict[bytes, list[int]] = {}
    for i in np.flatnonzero(on.sum(axis=0) >= 3):
        groups.setdefault(on[:, i].tobytes(), []).append(int(i))
    heads = [group[0] for group in groups.values()]
    faces = tuple(_walked(corners, on[:, heads], f, rows[head]) for f, head in enumerate(heads))
    points = np.array([[float(Fraction(x, corner[-1])) for x in corner[:-1]] for corner in corners]).reshape(-1, 3)
    return points, on, tuple(tuple(group) for group in groups.values()), faces


def _candidates(A: Array, b: Array) -> Array:
    """Triples of rows (s, 3) that may meet in a corner: all but those that clearly break another row."""
    triples = np.array(list(combinations(range(len(b)), 3)), dtype=int)
    determinants = np.einsum("si,si->s", np.cross(A[triples[:, 0]], A[triples[:, 1]]), A[triples[:, 2]])
    clear = np.abs(determinants) > _CLEAR
    points = np.linalg.solve(A[triples[clear]], b[triples[clear]][..., None])[..., 0]
    doubtful = ~clear
    doubtful[clear] = np.all(points @ A.T <= b + _CLEAR * (1.0 + np.abs(points).max(axis=1))[:, None], axis=1)
    return triples[doubtful]


def _meeting(p: Array, q: Array, r: Array) -> Array | None:
    """The point (x, y, z, w) with w > 0 where three planes (a, -b) meet; None where they meet in no point."""
    minors = []
    for skip in range(4):
        a, b, c = (np.delete(row, skip) for row in (p, q, r))
        minors.append((-1) ** skip * (a @ _cross(b, c)))
    sign = _sign(minors[-1])
    return np.array([sign * x for x in minors], dtype=object) if sign else None


def _walked(corners: list[Array], on: Array, facet: int, plane: Array) -> tuple[int, ...]:
    """The corners (v) of a facet, of which `on` (v, f) knows all others too, in order around it."""
    members = [int(i) for i in np.flatnonzero(on[:, facet])]
    shared = on[members].T
    edges = [[members[i] for i in np.flatnonzero(ends)] for ends in shared if ends.sum() == 2]
    walk = [members[0]]
    while len(walk) < len(members):
        onward = [a if b == walk[-1] else b for a, b in edges if walk[-1] in (a, b)]
        walk.append(next(i for i in onward if i not in walk[-2:]))
    (a, u), (b, v), (c, w) = ((corners[i][:-1], corners[i][-1]) for i in (walk[0], walk[1], walk[2]))
    turn = _sign(plane[:-1] @ _cross(b * u - a * v, c * u - a * w))
    return tuple(walk) if turn > 0 else tuple(reversed(walk))
