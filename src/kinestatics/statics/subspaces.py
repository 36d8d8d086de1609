"""What the rank of a Jacobian leaves over: wrenches held for free, twists lost with them, motion that moves nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..quantities import Jacobian
from ..spatial import ANGULAR

RANK_TOLERANCE = 1e-10
"""Singular values below this fraction of the largest count as zero (lengths scaled by the characteristic length)."""


@dataclass(frozen=True)
class Decomposition:
    """Rank and the directions beyond it, for chosen rows of one Jacobian.

    Attributes:
        singular_values: (k) of the rows, angular rows multiplied by the characteristic length [m].
        rank: how many of them count; tolerance: the fraction of the largest below which one does not.
        free_wrenches: (f, 6) basis of the wrenches that no joint feels, zero outside the rows [N, N m].
        lost_twists: (f, 6) the directions of motion lost with them [m, rad].
        null_motion: (n - rank, n) basis of the joint motions that do not move the rows.
        characteristic_length: [m].
    """

    singular_values: Array
    rank: int
    tolerance: float
    free_wrenches: Array
    lost_twists: Array
    null_motion: Array
    characteristic_length: float


def decompose(J: Any, rows: Sequence[int], length: float, tolerance: float = RANK_TOLERANCE) -> Decomposition:
    """Rank, free wrenches, lost twists and null motion of chosen rows of a Jacobian.

    Args:
        J: one Jacobian, (6, n).
        rows: rows in play, 0..5.
        length: characteristic length [m]: a twist's size is |(v, length · ω)|.
        tolerance: singular values below this fraction of the largest count as zero.

    Law: free wrenches span null(Jᵀ); lost twists are what is at right angles to all reachable ones, in that size.
    """
    matrix = np.asarray(J, dtype=float)
    if matrix.ndim != 2 or not np.all(np.isfinite(matrix)):
        raise ConfigurationError("KS303", f"expected one finite Jacobian (6, n), got {matrix.shape}", "loop over a batch")
    if not 0 < length < np.inf:
        raise ConfigurationError("KS303", f"characteristic length is {length}", "a positive length in metres")
    weights = np.ones(6)
    weights[ANGULAR] = length
    chosen = list(rows)
    scaled = weights[chosen, None] * matrix[chosen]
    U, sigma, Vt = np.linalg.svd(scaled, full_matrices=True)
    largest = sigma.max(initial=0.0)
    rank = int((sigma > tolerance * largest).sum()) if largest > 0 else 0
    unreachable = np.zeros((len(chosen) - rank, 6))
    unreachable[:, chosen] = _readable(U[:, rank:].T)
    return Decomposition(sigma, rank, tolerance, unreachable * weights, unreachable / weights, Vt[rank:], length)


def _readable(basis: Array) -> Array:
    """Another orthonormal basis of the same space, with coordinate directions first where the space contains them."""
    k, size = basis.shape
    if k < 2:
        return basis if k == 0 else basis * (1.0 if basis[0, int(np.argmax(np.abs(basis[0])))] > 0 else -1.0)
    found: list[Array] = []
    for i in range(size):
        within = basis.T @ basis[:, i]
        if abs(within[i] - 1.0) < 1e-9:
            found.append(np.eye(size)[i])
    if len(found) < k:
        rest = basis - sum((np.outer(basis @ e, e) for e in found), np.zeros_like(basis))
        _, _, Vt = np.linalg.svd(rest)
        found += [v * (1.0 if v[int(np.argmax(np.abs(v)))] > 0 else -1.0) for v in Vt[: k - len(found)]]
    return np.array(found)


def free_wrenches(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the wrenches that the structure holds and no joint feels: null(Jᵀ).

    Args:
        J: one Jacobian (6, n).
        length: characteristic length for the rank decision [m].

    Returns:
        (6 - rank, 6), (f, τ) in the frame of J.

    Law: Jᵀ w = 0. Source: note 000, "wrenches resisted for free".

    Example:
        >>> import kinestatics as ks
        >>> ks.free_wrenches(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    return decompose(J, range(6), length).free_wrenches


def lost_twists(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the directions of motion at right angles to everything the arm can do: those lost with the free wrenches.

    Args:
        J: one Jacobian (6, n).
        length: characteristic length: the size of a twist is |(v, length · ω)| [m].

    Returns:
        (6 - rank, 6), (v, ω) in the frame of J.

    Example:
        >>> import kinestatics as ks
        >>> ks.lost_twists(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    return decompose(J, range(6), length).lost_twists
