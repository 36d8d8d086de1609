"""Measures of a Jacobian: functions of its rows only. Floor 8.

Determinants of J Jᵀ lose half the digits near a singularity; everything here goes through singular values.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array, as_array


def _matrix(rows: Any) -> Array:
    array, xp = as_array(np.asarray(rows), "the Jacobian")
    if xp.name != "numpy":
        raise ArrayTypeError("KS302", "singular values need numbers", "evaluate the Jacobian at numbers first")
    return array


def singular_values(rows: Any) -> Array:
    """Singular values of the rows given, descending.

    Args:
        rows: (..., r, n), for example J.linear; rows of one unit only, or scaled by a characteristic length.

    Returns:
        (..., min(r, n)).

    Source: Golub, Van Loan, "Matrix Computations", section 2.4.

    Example:
        >>> singular_values([[3.0, 0.0], [0.0, 4.0]])
        array([4., 3.])
    """
    return np.linalg.svd(_matrix(rows), compute_uv=False)


def manipulability(rows: Any) -> Array:
    """Yoshikawa's measure w = σ1 ... σk, the volume of the velocity ellipsoid but for a constant.

    Args:
        rows: (..., r, n), for example J.linear.

    Returns:
        (...), in the product of the rows' units.

    Law: w = √det(J Jᵀ) where J has at most as many rows as columns; √det(Jᵀ J) where it has more.
    Source: Yoshikawa, "Manipulability of robotic mechanisms", IJRR 4(2), 1985; note 000.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 1.5707963267948966])
        >>> round(float(ks.manipulability(J.array[:2])), 12)
        1.0
    """
    return np.prod(singular_values(rows), axis=-1)


def condition_number(rows: Any) -> Array:
    """σ_max / σ_min, infinite at a singularity: 1 where all directions are alike.

    Args:
        rows: (..., r, n), as in `singular_values`.

    Example:
        >>> float(condition_number([[2.0, 0.0], [0.0, 1.0]]))
        2.0
    """
    sigma = singular_values(rows)
    if not sigma.shape[-1]:
        return np.full(sigma.shape[:-1], np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(sigma[..., -1] > 0, sigma[..., 0] / sigma[..., -1], np.inf)
