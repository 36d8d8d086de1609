"""Polytopes from matrices: the image of a box, {J x : l <= x <= u}, and what a box lets through, {x : l <= A x <= u}.

Both are worked out in round coordinates, those of the singular value decomposition of the matrix: there a nearly singular
arm looks like any other, and no unit matters but for the rank.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..namespaces import Array
from ..quantities import format_number
from ..statics import RANK_TOLERANCE
from .halfspaces import Outline, outline
from .linear_programs import Optimum, deepest, maximize
from .polytope import Polytope
from .round_coordinates import rank_of, round_coordinates
from .surfaces import turned
from .zonotopes import zonotope

_EMPTY = 1e-10  # limits may contradict one another by so much of their range before nothing is left
_HAIR = 1e-3
_UNFELT = 1e-12  # a joint that feels less than this share of the others does not limit a force
_DRAWN = 3  # corners and faces are found for so many coordinates at most
_ALL = Outline(np.zeros((1, 0)), np.zeros((0, 0)), (), (), 0)  # where no row feels anything


def image_of_box(J: Array, lower: Array, upper: Array, weights: Array, **labels: Any) -> Polytope:
    """{J x : lower <= x <= upper} for (k, n) and finite (n) limits.

    Args:
        weights: (k) what the rows are multiplied by before the rank is judged.
        labels: kind, unit, rows, joints, ... of the polytope.

    Law: support h(d) = d · J m + Σ |d · J_i| w_i, with m the middle and w half the width of the box.
    """
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    generators, center, k = (J * half).T, J @ middle, len(J)
    round_ = round_coordinates(generators.T, weights)
    shape = zonotope(round_.columns)
    lost = round_.beside
    normals = _unit(np.vstack([shape.normals @ round_.normals, lost, -lost]))
    planes = np.r_[lost, -lost] @ center
    small = np.abs(planes) <= RANK_TOLERANCE * np.linalg.norm(generators, axis=1).sum()
    states = np.vstack([shape.sides, np.zeros((2 * len(lost), J.shape[1]))]).astype(np.int8)
    drawn = k <= _DRAWN and shape.corners is not None
    notes = [f"flat: within the limits no joint moves it along {_arrow(line)}" for line in lost]
    return Polytope(
        normals=normals,
        offsets=np.r_[_supports(generators, center, normals[: len(shape.normals)]), np.where(small, 0.0, planes)],
        states=states,
        corners=center + shape.corners @ generators if drawn else None,
        rays=np.zeros((0, k)),
        free=np.zeros((0, k)),
        faces=turned(shape.faces, round_.points) if drawn else (),
        center=center,
        generators=generators,
        dimension=len(round_.points),
        is_empty=False,
        is_bounded=True,
        tolerance=RANK_TOLERANCE,
        **labels | {"notes": (*labels.get("notes", ()), *notes)},
    )


def _supports(generators: Array, center: Array, normals: Array) -> Array:
    return normals @ center + np.abs(normals @ generators.T).sum(axis=1)


class _HalfSpaces(NamedTuple):
    """Half-spaces in round coordinates (rows · y <= limits) and in x (normals · x <= offsets); states: whose limits.

    back (r, k) turns round coordinates into x; free (f, k) are the directions of which no row knows.
    """

    rows: Array
    limits: Array
    normals: Array
    offsets: Array
    states: Array
    back: Array
    free: Array

    def chosen(self, which: Array) -> _HalfSpaces:
        """Some of them."""
        parts = {name: getattr(self, name)[which] for name in ("rows", "limits", "normals", "offsets", "states")}
        return self._replace(**parts)


def let_through(A: Array, lower: Array, upper: Array, weights: Array, **labels: Any) -> Polytope:
    """{x : lower <= A x <= upper} for (n, k) and (n) limits, infinite where there is none.

    Args:
        weights: (k) what the columns are multiplied by before the rank is judged.
        labels: kind, unit, rows, joints, ... of the polytope.
    """
    spaces = _half_spaces(A, lower, upper, weights)
    inner = deepest(spaces.rows, spaces.limits)
    felt = np.linalg.norm(spaces.rows, axis=1) > _UNFELT
    shared: dict[str, Any] = {"generators": None, "tolerance": RANK_TOLERANCE, **labels}
    if inner.value < -_EMPTY:
        return _nothing(spaces.chosen(felt), np.abs(spaces.states[inner.multipliers > _EMPTY]).any(axis=0), **shared)
    shared |= {"center": inner.point @ spaces.back, "free": spaces.free, "is_empty": False}
    shared["notes"] = (*labels.get("notes", ()), *_remarks(spaces))
    spaces = spaces.chosen(felt)
    return _drawn(spaces, inner, **shared) if A.shape[1] <= _DRAWN else _undrawn(spaces, inner, **shared)


def _remarks(spaces: _HalfSpaces) -> list[str]:
    """What must be said of a set that has points."""
    free = [f"without end along {_arrow(line)}, both ways: no joint feels it" for line in spaces.free]
    outside = np.any(spaces.limits < -_EMPTY)
    return [*free, "zero is not in it: the joints cannot hold the arm without a push"] if outside else free


def _half_spaces(A: Array, lower: Array, upper: Array, weights: Array) -> _HalfSpaces:
    n = len(A)
    share = _shares(lower, upper)
    limited = np.isfinite(lower) | np.isfinite(upper)
    round_ = round_coordinates((A * np.where(limited, 1.0 / share, 0.0)[:, None]).T, weights)
    joint, side = np.tile(np.arange(n), 2), np.repeat([1.0, -1.0], n)
    limits = np.r_[upper, -lower]
    known = np.isfinite(limits)
    joint, side, limits = joint[known], side[known], limits[known]
    lengths = np.linalg.norm(A[joint], axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    return _HalfSpaces(
        rows=side[:, None] * round_.columns[joint],
        limits=limits / share[joint],
        normals=side[:, None] * A[joint] / lengths[:, None],
        offsets=limits / lengths,
        states=((joint[:, None] == np.arange(n)) * side[:, None]).astype(np.int8),
        back=round_.normals,  # the columns of Aᵀ are normals of the planes that bound x
        free=round_.beside,
    )


def _shares(lower: Array, upper: Array) -> Array:
    """(n) the size of each joint's range: half its width, but no hair's breadth beside its limits or those of the others."""
    ends = np.abs(np.where(np.isfinite([lower, upper]), [lower, upper], 0.0)).max(axis=0)
    with np.errstate(invalid="ignore"):
        half = 0.5 * (upper - lower)
    half = np.where(np.isfinite(half), half, ends)
    floor = np.maximum(_HAIR * ends, _HAIR**2 * max(ends.max(initial=0.0), half.max(initial=0.0)))
    share = np.maximum(half, floor)
    return np.where(share > 0, share, 1.0)


def _arrow(direction: Array) -> str:
    sign = 1.0 if direction[int(np.argmax(np.abs(direction) > 0.5 * np.abs(direction).max()))] > 0 else -1.0
    return f"({', '.join(format_number(x) for x in sign * direction)})"


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _nothing(spaces: _HalfSpaces, blamed: Array, **shared: Any) -> Polytope:
    """The empty set, and which joints' limits contradict one another."""
    k = spaces.normals.shape[1]
    names = [repr(name) for name, found in zip(shared["joints"], blamed, strict=True) if found]
    whose = f"joint {names[0]}" if len(names) == 1 else f"joints {', '.join(names)} at once"
    notes = (*shared.pop("notes", ()), f"empty: nothing keeps the limits of {whose}")
    return Polytope(
        normals=spaces.normals,
        offsets=spaces.offsets,
        states=spaces.states,
        corners=np.zeros((0, k)) if k <= _DRAWN else None,
        rays=np.zeros((0, k)),
        free=np.zeros((0, k)),
        faces=(),
        center=None,
        dimension=-1,
        is_empty=True,
        is_bounded=True,
        notes=notes,
        **shared,
    )


def _drawn(spaces: _HalfSpaces, inner: Optimum, **shared: Any) -> Polytope:
    """With corners and faces: up to three coordinates."""
    rank, k = spaces.back.shape
    lengths = np.linalg.norm(spaces.rows, axis=1)
    room = np.maximum(spaces.limits - spaces.rows @ inner.point, 0.0)  # around the deepest point
    found = outline(spaces.rows / lengths[:, None], room / lengths) if rank else _ALL
    bounded = rank == k and not len(found.rays)
    heads = [facet[0] for facet in found.facets]
    states = [spaces.states[list(facet)].sum(axis=0) for facet in found.facets]
    return Polytope(
        normals=spaces.normals[heads],
        offsets=spaces.offsets[heads],
        states=np.array(states, dtype=np.int8).reshape(-1, spaces.states.shape[1]),
        corners=(inner.point + found.corners) @ spaces.back,
        rays=_unit(found.rays @ spaces.back),
        faces=turned(found.faces, spaces.back) if bounded else (),
        dimension=found.dimension + k - rank,
        is_bounded=bounded,
        **shared,
    )


def _undrawn(spaces: _HalfSpaces, inner: Optimum, **shared: Any) -> Polytope:
    """With its half-spaces alone, idle ones among them: more than three coordinates."""
    rank, k = spaces.back.shape
    flat = 0 if inner.value > _EMPTY else _always_met(spaces.rows, spaces.limits, inner)
    return Polytope(
        normals=spaces.normals,
        offsets=spaces.offsets,
        states=spaces.states,
        corners=None,
        rays=np.zeros((0, k)),
        faces=(),
        dimension=k - flat,
        is_bounded=rank == k and _ends(spaces.rows),
        **shared,
    )


def _always_met(rows: Array, limits: Array, inner: Optimum) -> int:
    """How many independent rows hold with equality at every point."""
    room = np.maximum(limits - rows @ inner.point, 0.0)
    start = np.zeros(rows.shape[1])
    met = [maximize(-row, rows, room, start).value + most <= 10 * _EMPTY for row, most in zip(rows, room, strict=True)]
    return rank_of(np.linalg.svd(rows[met], compute_uv=False)) if any(met) else 0


def _ends(rows: Array) -> bool:
    """Whether {y : rows · y <= limits} is bounded, of rows that leave no line free: no direction goes down all rows."""
    down = -rows.sum(axis=0)
    cone = maximize(down, np.vstack([rows, down]), np.r_[np.zeros(len(rows)), 1.0], np.zeros(rows.shape[1]))
    return bool(cone.value < 0.5)
