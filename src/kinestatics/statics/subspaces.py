"""What the rank of a Jacobian leaves over: wrenches held for free, twists lost with them, motion that moves nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .._kernels import ALL_ROWS
from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace, as_array
from ..quantities import Jacobian, JacobianMatrix
from ..spatial import size_weights, transpose
from . import symbols

RANK_TOLERANCE = 1e-10
"""Singular values below this fraction of the largest count as zero (lengths scaled by the characteristic length)."""
SAFE = 64
"""Times the rounding of a number: below this share of the largest, no singular value can be told from zero."""
_ONE = "loop over a batch, or take free_wrench_projector(J): ranks may differ, projectors have one shape"


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
        tolerance: singular values below this fraction of the largest count as zero; at least what single precision allows
            where J is in it.

    Law: free wrenches span null(Jᵀ); lost twists are what is at right angles to all reachable ones, in that size.
    """
    given = np.asarray(J)
    if given.dtype == np.float32:
        tolerance = max(tolerance, SAFE * rounding(given))
    matrix = np.asarray(given, dtype=float)
    if matrix.ndim != 2 or not np.all(np.isfinite(matrix)):
        raise ConfigurationError("KS303", f"expected one finite Jacobian (6, n), got {matrix.shape}", _ONE)
    check_length(length)
    weights = size_weights(length)
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
        unit = np.eye(size)[i]
        if np.linalg.norm(basis.T @ basis[:, i] - unit) < RANK_TOLERANCE:  # its distance from the space
            found.append(unit)
    if len(found) < k:
        rest = basis - sum((np.outer(basis @ e, e) for e in found), np.zeros_like(basis))
        _, _, Vt = np.linalg.svd(rest)
        found += [v * (1.0 if v[int(np.argmax(np.abs(v)))] > 0 else -1.0) for v in Vt[: k - len(found)]]
    return np.array(found)


class Spectrum(NamedTuple):
    """Singular values and vectors of W J, W = diag(1, 1, 1, length, length, length), in any library.

    Attributes:
        U: (..., 6, k) and V: (..., n, k), k = min(6, n); values: (..., k), descending.
        kept: (..., k) of bool, the ones that count.
        weights: (6) the diagonal of W; size: (...) the largest value; tolerance: the share of it that counts as zero.
    """

    U: Array
    V: Array
    values: Array
    kept: Array
    weights: Array
    tolerance: float

    @property
    def inverse_values(self) -> Array:
        """1/σ where σ counts, else 0."""
        return self.kept / (self.kept * self.values + ~self.kept)

    def reached(self, six: Array) -> Array:
        """The part of a scaled six-vector (..., 6) in the range of W J."""
        return ((self.U * self.kept[..., None, :]) @ (transpose(self.U) @ six[..., None]))[..., 0]

    def projector(self) -> Array:
        """(..., 6, 6) onto the range of W J."""
        return (self.U * self.kept[..., None, :]) @ transpose(self.U)


def spectrum(
    matrix: Array,
    xp: Namespace,
    length: float,
    tolerance: float,
    rows: Sequence[int] = ALL_ROWS,
    of: Array | None = None,
) -> Spectrum:
    """Singular values of a Jacobian's array (..., 6, n), without a decision that depends on numbers.

    Args:
        rows: in play; the others count as zero, and U is zero there.
        of: (..., k) singular values of which the tolerance is a share; default those found.
    """
    weights, chosen = xp.constant(size_weights(length), matrix), xp.constant(mask_of(rows)[:, None], matrix)
    U, values, Vt = xp.linalg.svd(weights[:, None] * chosen * matrix, full_matrices=False)
    U = chosen * U
    share = max(tolerance, SAFE * rounding(matrix))
    kept = values > share * (values if of is None else of)[..., :1]
    return Spectrum(U, transpose(Vt), values, kept, weights, share)


def mask_of(rows: Sequence[int]) -> Array:
    """(6) ones at the rows, else zeros."""
    mask = np.zeros(6)
    mask[list(rows)] = 1.0
    return mask


def rounding(array: Array) -> float:
    """The relative rounding of the numbers of an array, of NumPy, JAX or PyTorch."""
    return float(np.finfo(str(array.dtype).removeprefix("torch.")).eps)


def check_length(length: float) -> None:
    """Raises ConfigurationError (KS303) unless the characteristic length is positive and finite."""
    if not 0 < length < np.inf:
        raise ConfigurationError("KS303", f"characteristic length is {length}", "a positive length in metres")


def jacobian_array(J: Any, what: str) -> tuple[Array, Namespace]:
    """The array of a Jacobian, finite where it is one of NumPy.

    Raises:
        ArrayTypeError: KS302, anything but a Jacobian. ConfigurationError: KS301.
    """
    if not isinstance(J, Jacobian):
        raise ArrayTypeError("KS302", f"{what} takes a Jacobian, not a {type(J).__name__}", "J = ks.jacobian(arm, q)")
    array, xp = as_array(J.array, "the Jacobian")
    if xp.name == "numpy" and not np.all(np.isfinite(array)):
        raise ConfigurationError("KS301", "the Jacobian holds numbers that are not finite", "is q finite?")
    return array, xp


def free_wrench_projector(J: Jacobian, length: float = 1.0, tolerance: float = RANK_TOLERANCE) -> Array:
    """The part of a wrench that the structure holds and no joint feels, as a matrix: for batches, whose ranks may differ.

    Args:
        J: Jacobian (..., 6, n); NumPy, JAX or PyTorch.
        length: characteristic length: the size of a wrench is |(f, τ / length)| [m].
        tolerance: singular values below this fraction of the largest count as zero.

    Returns:
        P, (..., 6, 6), in the frame of J: P w is the part of w in null(Jᵀ), w - P w is at right angles to it in that size.
        Pᵀ V is the part of a twist V that the arm cannot make, at right angles to all it can, in the size |(v, length · ω)|.

    Raises:
        ArrayTypeError: KS302 for symbols, whose null space `free_wrenches` gives.

    Law: P P = P, Jᵀ P = 0, and P w = w where Jᵀ w = 0. P = W (1 - U Uᵀ) W⁻¹ with W = diag(1, 1, 1, length, length, length)
    and U an orthonormal basis of the range of W J: |W V| and |W⁻¹ w| are the two sizes.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [[0.0, 0.0], [0.0, 1.0]])
        >>> ks.free_wrench_projector(J)[0].diagonal().round(9)
        array([1., 0., 1., 1., 1., 0.])
    """
    matrix, xp = jacobian_array(J, "free_wrench_projector")
    check_length(length)
    if xp.name == "sympy":
        raise ArrayTypeError("KS302", "a projector needs numbers; the Jacobian holds symbols", "free_wrenches(J)")
    found = spectrum(matrix, xp, length, tolerance)
    identity = xp.constant(np.eye(6), matrix)
    return found.weights[:, None] * (identity - found.projector()) / found.weights


def free_wrenches(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the wrenches that the structure holds and no joint feels: null(Jᵀ).

    Args:
        J: one Jacobian (6, n), of numbers or SymPy expressions; for a batch there is `free_wrench_projector`.
        length: characteristic length for the rank decision [m].

    Returns:
        (6 - rank, 6), (f, τ) in the frame of J. Of symbols, the null space at almost all their values (a singular posture
        must be put in as such), not normed: each row has a 1 where all others have a 0.

    Raises:
        ConfigurationError: KS303 for a batch or a length that is not positive; KS336, expressions without a real value.

    Law: Jᵀ w = 0. Source: note 000, "wrenches resisted for free".

    Example:
        >>> import kinestatics as ks
        >>> ks.free_wrenches(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    if _is_symbolic(J):
        check_length(length)
        return symbols.null_space(_one(J).T)
    return decompose(J, range(6), length).free_wrenches


def lost_twists(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the directions of motion at right angles to everything the arm can do: those lost with the free wrenches.

    Args:
        J: one Jacobian (6, n), of numbers or SymPy expressions; for a batch there is `free_wrench_projector`, transposed.
        length: characteristic length: the size of a twist is |(v, length · ω)| [m].

    Returns:
        (6 - rank, 6), (v, ω) in the frame of J. Of symbols, at almost all their values and not normed.

    Raises:
        ConfigurationError: KS303 for a batch or a length that is not positive; KS336, expressions without a real value.

    Example:
        >>> import kinestatics as ks
        >>> ks.lost_twists(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    if _is_symbolic(J):
        check_length(length)
        return symbols.null_space(_one(J).T) / symbols.exact(size_weights(length)) ** 2
    return decompose(J, range(6), length).lost_twists


def _is_symbolic(J: Any) -> bool:
    return as_array(J.array if isinstance(J, JacobianMatrix) else J, "the Jacobian")[1].name == "sympy"


def _one(J: Any) -> Array:
    """The array of one Jacobian."""
    array = J.array if isinstance(J, JacobianMatrix) else np.asarray(J)
    if array.ndim != 2:
        raise ConfigurationError("KS303", f"expected one Jacobian (6, n), got {tuple(array.shape)}", "loop over the batch")
    return array
