"""Coordinates in which the columns of a matrix spread evenly: there no unit and no near singularity makes a difference."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..namespaces import Array
from ..statics import RANK_TOLERANCE


class RoundCoordinates(NamedTuple):
    """Coordinates y (r) of the space that the columns of a matrix (k, n) span, in which Σ column columnᵀ = 1.

    Attributes:
        columns: (n, r) the columns of the matrix in them.
        points: (r, k) y @ points are points in x where the columns are points; normals: (r, k) y @ normals where the columns
            are normals of planes that bound x.
        beside: (k - r, k) unit vectors at right angles to all columns.
    """

    columns: Array
    points: Array
    normals: Array
    beside: Array


def round_coordinates(matrix: Array, weights: Array, rank: int | None = None) -> RoundCoordinates:
    """Round coordinates of a matrix (k, n); unless the rank is known, it is judged with rows multiplied by weights (k)."""
    U, sigma, Vt = np.linalg.svd(matrix * weights[:, None], full_matrices=True)
    rank = rank_of(sigma) if rank is None else rank
    if rank == len(matrix):  # all rows count: none of them need lose digits to larger ones
        weights = 1.0 / np.abs(matrix).max(axis=1)
        U, sigma, Vt = np.linalg.svd(matrix * weights[:, None], full_matrices=True)
    beside = U[:, rank:].T * weights
    return RoundCoordinates(
        columns=Vt[:rank].T * np.any(matrix != 0, axis=0)[:, None],  # a column of zeros is not even rounding
        points=(U[:, :rank] * sigma[:rank]).T / weights,
        normals=(U[:, :rank] / sigma[:rank]).T * weights,
        beside=beside / np.linalg.norm(beside, axis=1, keepdims=True),
    )


def rank_of(sigma: Array) -> int:
    """How many singular values count."""
    return int((sigma > RANK_TOLERANCE * sigma.max(initial=0.0)).sum())
