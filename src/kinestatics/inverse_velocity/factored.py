"""Rates through QR, and exactly at symbols. Both need full rank and say where it is missing.

QR without exchange of columns is the fast route where there are many Jacobians: half the time of the SVD. For a single
one NumPy's QR is no faster than its SVD.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..spatial import rotate, transpose

_TRUSTED = 1e7
"""Condition number up to which the triangular factor is solved with; above it, and without full rank, the SVD decides."""
_NOTHING = 1e-9  # of entries of about 1, at random values of symbols
_SHORT = 120  # operations up to which an expression is simplified


def qr_rates(matrix: Array, target: Array) -> tuple[Array, Array]:
    """Minimum norm or least squares by QR, for NumPy.

    Args:
        matrix: (..., r, n); target: (..., r), whose batch axes go together.

    Returns:
        (..., n) and (...) whether J had full rank and a condition number that QR without exchange of columns can be
        trusted with; the rates are 0 where it had not.

    Law: Jᵀ = Q R, q̇ = Q R⁻ᵀ ξ where J is wide; J = Q R, q̇ = R⁻¹ Qᵀ ξ where it is tall. Source: note 000 (backslash).
    """
    r, n = matrix.shape[-2:]
    batch = np.broadcast_shapes(matrix.shape[:-2], target.shape[:-1])
    if not r or not n:
        return np.zeros((*batch, n)), np.zeros(batch, dtype=bool)
    wide, k = r <= n, min(r, n)
    Q, R = np.linalg.qr(transpose(matrix) if wide else matrix)
    pivots = np.abs(np.diagonal(R, axis1=-2, axis2=-1))
    trusted = pivots.min(-1) * _TRUSTED > pivots.max(-1)
    if not trusted.all():
        R = np.where(trusted[..., None, None], R, np.eye(k))
    inverse = np.linalg.inv(R)
    largest = np.abs(R).max((-2, -1)) * np.abs(inverse).max((-2, -1))  # pivots alone do not show every lack of rank
    trusted = trusted & (k * largest <= _TRUSTED)
    safe = np.where(trusted[..., None, None], inverse, 0.0)
    rates = rotate(Q, rotate(transpose(safe), target)) if wide else rotate(safe, rotate(transpose(Q), target))
    return rates, np.broadcast_to(trusted, batch)


def symbolic_rates(matrix: Array, target: Array, secondary: Any) -> Array:
    """The pseudoinverse at symbols: exact, for matrices of full rank but for rows that are zero.

    Args:
        matrix: (r, n), target: (r), of SymPy expressions; secondary: (n) or None.

    Raises:
        ConfigurationError: KS303 for a batch; KS355 where the rank is not full at almost all values of the symbols.

    Law: J⁻¹ ξ; Jᵀ(J Jᵀ)⁻¹ ξ where J is wide; (Jᵀ J)⁻¹ Jᵀ ξ where it is tall; + (I - J⁺ J) b. Source: note 000.
    """
    import sympy

    if matrix.ndim != 2 or target.ndim != 1:
        raise ConfigurationError("KS303", "symbols are solved for one Jacobian and one twist", "loop over the batch")
    numbers = _at_random_values(matrix)
    rows = [k for k in range(matrix.shape[0]) if np.abs(numbers[:, k]).max(initial=0.0) > _NOTHING]
    J, xi = sympy.Matrix(matrix[rows]), sympy.Matrix(target[rows])
    r, n = len(rows), matrix.shape[1]
    if not r or not n:
        return np.array([sympy.Integer(0)] * n, dtype=object) if secondary is None else np.asarray(secondary)
    rank = int(np.linalg.matrix_rank(numbers[:, rows], rtol=_NOTHING).max())
    if rank < min(r, n):
        message = f"the Jacobian's {r} x {n} rows that count have rank {rank} at almost all values of the symbols"
        hint = "free rows that depend on others (NaN in the twist), or put numbers in place of the symbols"
        raise ConfigurationError("KS355", message, hint)
    inverse = J.T * _inverse(J * J.T) if r < n else _inverse(J.T * J) * J.T if r > n else _inverse(J)
    rates = inverse * xi
    if secondary is not None:
        rates = rates + (sympy.eye(n) - inverse * J) * sympy.Matrix(secondary)
    return np.array([_tidy(x) for x in rates], dtype=object)


def _inverse(square: Any) -> Any:
    """adj(A) / det(A): no division but one, so that no pivot can be zero unseen."""
    return square.adjugate() / _tidy(square.det(method="berkowitz"))


def _tidy(x: Any) -> Any:
    """Simplified where that takes no time; a long expression stays as it is."""
    import sympy

    return sympy.simplify(x) if x.count_ops() <= _SHORT else x


def _at_random_values(matrix: Array) -> Array:
    """(3, r, n) the matrix at random values of its symbols: what holds there holds almost everywhere."""
    import sympy

    expressions = sympy.Matrix(matrix)
    symbols = sorted(expressions.free_symbols, key=str)
    rng = np.random.default_rng(20261126)
    evaluate = sympy.lambdify(symbols, expressions, "numpy")
    drawn = rng.uniform(0.5, 1.5, (3, len(symbols)))
    return np.array([np.array(evaluate(*values), dtype=float).reshape(matrix.shape) for values in drawn])
