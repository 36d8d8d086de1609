"""Measures of a Jacobian: how well, and how evenly, an arm moves in a posture.

All of them are functions of singular values. Determinants of J Jᵀ lose half the digits near a singularity, and are taken
of symbols only. `rows` says which rows are looked at and how many of their singular values count.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError
from ..namespaces import Array, Namespace, as_array
from ..quantities import Jacobian, check_batches
from ..spatial import transpose
from ..tasks import task_of
from . import symbols
from .rows import RowsInPlay, TaskName, decomposed, rows_in_play, singular

_DEFINITE = 1e-12  # eigenvalues of a mass matrix below this share of its largest entry are rounding


def singular_values(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """Singular values of a Jacobian's rows, descending.

    Args:
        rows: a Jacobian, whose rows in play are found, or bare rows (..., r, n) such as J.linear, which all count.
            NumPy, JAX, PyTorch; SymPy where r or n is at most 2.
        task: other rows of a Jacobian, as in `find_task`.
        length: characteristic length [m], needed where the rows of a Jacobian mix metres and radians: angular rows are
            multiplied by it, and prismatic columns where the joints mix both.

    Returns:
        (..., min(r, n)) in the unit of the rows. NaN where a NumPy matrix is not finite.

    Raises:
        ConfigurationError: KS360 where a length is needed, KS361 for task or length with bare rows, KS303 for shapes.
        ArrayTypeError: KS302. UnknownNameError: KS318.

    Law: J = U diag(σ) Vᵀ. Source: Golub, Van Loan, "Matrix Computations", section 2.4.

    Example:
        >>> singular_values([[3.0, 0.0], [0.0, 4.0]])
        array([4., 3.])
    """
    found = rows_in_play(rows, task, length)
    if found.xp.name == "sympy":
        return symbols.each(found.array, symbols.singular_values)
    return singular(found.array, found.xp)


def manipulability(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """Yoshikawa's measure w = σ1 ... σk, the volume of the velocity ellipsoid but for a constant.

    A planar arm is measured in its plane, a SCARA arm in its four freedoms: k is the rank that the arm reaches in its
    rows at almost every posture. It has no natural unit where the joints are of both kinds; compare it between postures
    of one arm, not between arms of different sizes.

    Args:
        rows, task: as in `singular_values`; SymPy expressions of any size, slow beyond three rows. Floats among symbols are
            read as the decimal fractions they print as.
        length: characteristic length [m]; without it rows and joints are taken as they are.

    Returns:
        (...), in the product of the rows' units; 0 at a singularity and for an arm that cannot move.

    Law: w = √det(J Jᵀ) where J has full row rank; √det(Jᵀ J) where it has full column rank; |det J| where both.
    Source: Yoshikawa, "Manipulability of robotic mechanisms", IJRR 4(2), 1985; note 000.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 1.5707963267948966])
        >>> round(float(ks.manipulability(J)), 12)
        1.0
    """
    found = rows_in_play(rows, task, length, needs_length=False)
    if found.xp.name == "sympy":
        return symbols.each(found.array, lambda matrix: symbols.volume(matrix, found.rank))
    return product_of(singular(found.array, found.xp), found.rank)


def smallest_singular_value(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """σk: the speed in the slowest direction, at unit speed of the joints.

    Args, Raises: as in `singular_values`.

    Returns:
        (...), in the unit of the rows; 0 at a singularity. 1/σk bounds the joint speeds that a unit twist can need.

    Source: Klein, Blaho, "Dexterity measures for the design and control of kinematically redundant manipulators",
        IJRR 6(2), 1987.

    Example:
        >>> float(smallest_singular_value([[2.0, 0.0], [0.0, 1.0]]))
        1.0
    """
    found = rows_in_play(rows, task, length)
    if found.xp.name == "sympy":
        return symbols.each(found.array, lambda matrix: symbols.smallest(matrix, found.rank))
    return smallest_of(singular(found.array, found.xp), found.rank)


def inverse_condition(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """σk/σ1, from 0 at a singularity to 1 where all directions are alike: the local conditioning index.

    Args, Raises: as in `singular_values`.

    Returns:
        (...), without a unit; exactly 0 where σk is not above 1e-10 of σ1 (1e-5 in single precision).

    Source: Salisbury, Craig, "Articulated hands", IJRR 1(1), 1982; Gosselin, Angeles, "A global performance index for
        the kinematic optimization of robotic manipulators", ASME J. Mech. Des. 113, 1991.

    Example:
        >>> float(inverse_condition([[2.0, 0.0], [0.0, 1.0]]))
        0.5
    """
    found = rows_in_play(rows, task, length)
    if found.xp.name == "sympy":
        return symbols.each(found.array, lambda matrix: symbols.inverse_condition(matrix, found.rank))
    return ratio_of(singular(found.array, found.xp), found.rank, found.tolerance)


def condition_number(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """σ1/σk: 1 where all directions are alike, infinite at a singularity.

    Args, Raises: as in `singular_values`.

    Returns:
        (...), without a unit; infinite where σk is not above 1e-10 of σ1 (1e-5 in single precision).

    Law: condition_number = 1 / inverse_condition. Source: Golub, Van Loan, section 2.6; Salisbury, Craig 1982.

    Example:
        >>> float(condition_number([[2.0, 0.0], [0.0, 1.0]]))
        2.0
    """
    found = rows_in_play(rows, task, length)
    if found.xp.name == "sympy":
        return symbols.each(found.array, lambda matrix: symbols.condition(matrix, found.rank))
    return condition_of(singular(found.array, found.xp), found.rank, found.tolerance)


def isotropy(rows: Any, *, task: TaskName = "auto", length: float | None = None) -> Array:
    """The geometric mean of σ1² ... σk² over their arithmetic mean: 1 where all directions are alike, 0 at a singularity.

    Unlike the condition number it counts all singular values, and is smooth where two of them are equal. (Some authors
    take the means of σ instead of those of σ².)

    Args, Raises: as in `singular_values`; SymPy expressions of any size.

    Returns:
        (...), without a unit.

    Law: Δ = det(J Jᵀ)^(1/k) / (trace(J Jᵀ)/k).
    Source: Kim, Khosla, "Dexterity measures for design and control of manipulators", IROS 1991, pp. 758-763.

    Example:
        >>> float(isotropy([[2.0, 0.0], [0.0, 1.0]]))
        0.8
    """
    found = rows_in_play(rows, task, length)
    if found.xp.name == "sympy":
        return symbols.each(found.array, lambda matrix: symbols.isotropy(matrix, found.rank))
    return isotropy_of(singular(found.array, found.xp), found.rank)


def asada(
    rows: Any, mass_matrix: Any, *, task: TaskName = "auto", length: float | None = None, others: str = "free"
) -> Array:
    """How round the generalised inertia ellipsoid is: smallest over largest inertia felt in the rows.

    Args:
        rows, task, length: as in `singular_values`; joints of both kinds need no length, the mass matrix weighs them.
        mass_matrix: M (..., n, n), symmetric and positive definite [kg m², kg m, kg], with or without the rotors.
        others: what the rows that are not in play do: "free" to move, or "held" still, which makes the arm heavier.

    Returns:
        (...), from 0 at a singularity to 1; without a unit.

    Raises:
        ConfigurationError: KS303 where M does not fit or is not positive definite, KS301 where it is not finite; KS360,
            KS361 (others="held" needs the Jacobian too). UnknownNameError: KS365 for another word. ArrayTypeError: KS302.

    Law: λmin/λmax of Λ = (J M⁻¹ Jᵀ)⁻¹ for the rows in play, "free"; of the block of Λ of all rows, "held". With all rows
        of an arm in play both are the same.
    Source: Asada, "A geometrical representation of manipulator dynamics and its application to arm design", ASME J. Dyn.
        Syst. Meas. Control 105, 1983; Khatib, IEEE J. Robotics and Automation 3(1), 1987, for Λ.

    Example:
        >>> round(float(asada([[2.0, 0.0], [0.0, 1.0]], [[4.0, 0.0], [0.0, 4.0]])), 12)
        0.25
    """
    if others not in ("free", "held"):
        raise UnknownNameError("KS365", f"others={others!r} is not known", "the other rows are 'free' or 'held'")
    found = rows_in_play(rows, task, length, weigh_joints=False)
    if found.xp.name == "sympy":
        raise ArrayTypeError("KS302", "asada computes with numbers", "put numbers in place of the symbols first")
    half, M = _half_root(found, mass_matrix), found.array
    columns = _over(half, M, found.xp)
    if not found.rank or not columns.shape[-1]:
        return _zeros(singular(columns, found.xp))
    sigma, rank = singular(columns, found.xp), found.rank
    if others == "held":
        held, rank = _others(rows, found)
        largest = sigma[..., :1]
        columns = _beside(columns, _over(half, held, found.xp), found)
        sigma = singular(columns, found.xp)
        sigma = sigma * (sigma > found.tolerance * largest)
    return ratio_of(sigma, rank, found.tolerance) ** 2


def product_of(sigma: Array, rank: int) -> Array:
    """(...) product of the first `rank` singular values; 0 where there are none."""
    if not rank:
        return _zeros(sigma)
    with np.errstate(over="ignore", under="ignore"):
        return sigma[..., :rank].prod(-1)


def smallest_of(sigma: Array, rank: int) -> Array:
    """(...) the last singular value that counts; 0 where there is none."""
    return sigma[..., rank - 1] if rank else _zeros(sigma)


def ratio_of(sigma: Array, rank: int, tolerance: float) -> Array:
    """(...) σ_rank/σ1; 0 where it is not above the tolerance."""
    if not rank:
        return _zeros(sigma)
    first, last = sigma[..., 0], sigma[..., rank - 1]
    safe = first + (first == 0)  # a sum, not a branch: JAX differentiates it
    return last / safe * ~(last <= tolerance * first)  # NaN stays NaN


def condition_of(sigma: Array, rank: int, tolerance: float) -> Array:
    """(...) σ1/σ_rank; infinite where σ_rank is not above the tolerance."""
    ratio = ratio_of(sigma, rank, tolerance)
    with np.errstate(divide="ignore"):
        return 1.0 / ratio


def isotropy_of(sigma: Array, rank: int) -> Array:
    """(...) geometric over arithmetic mean of the first `rank` squares; 0 where there are none."""
    if not rank:
        return _zeros(sigma)
    first = sigma[..., 0]
    scaled = sigma[..., :rank] / (first + (first == 0))[..., None]
    with np.errstate(under="ignore"):
        mean = (scaled * scaled).sum(-1) / rank
        return scaled.prod(-1) ** (2.0 / rank) / (mean + (first == 0))


def _zeros(sigma: Array) -> Array:
    """(...) zeros of the library and type of sigma (..., k)."""
    return sigma.sum(-1) * 0


def _half_root(found: RowsInPlay, mass_matrix: Any) -> Array:
    """L (..., n, n) with M = L Lᵀ, in the library of the rows."""
    M, own = as_array(mass_matrix, "the mass matrix")
    n = int(found.array.shape[-1])
    if own.name == "sympy" or tuple(M.shape[-2:]) != (n, n):
        raise ConfigurationError("KS303", f"the mass matrix has shape {tuple(M.shape)}; expected (..., {n}, {n})", "numbers")
    check_batches("the Jacobian", found.array.shape[:-2], "the mass matrix", M.shape[:-2])
    if own.name == "numpy":
        _check_definite(M)
        M = found.xp.constant(M, found.array)
    elif own.name != found.xp.name:
        message = f"the Jacobian is an array of {found.xp.name}, the mass matrix of {own.name}"
        raise ArrayTypeError("KS302", message, "pass both of one library")
    return found.xp.linalg.cholesky(M)


def _check_definite(M: Array) -> None:
    if not np.all(np.isfinite(M)):
        raise ConfigurationError("KS301", "the mass matrix holds NaN or infinity", "pass finite numbers")
    size = np.abs(M).max(axis=(-2, -1), initial=0.0, keepdims=True)
    try:
        if not np.all(np.abs(M - transpose(M)) <= 1e-6 * size):
            raise np.linalg.LinAlgError
        if M.size and np.any(np.linalg.eigvalsh(M) <= _DEFINITE * size[..., 0]):
            raise np.linalg.LinAlgError
    except np.linalg.LinAlgError:
        hint = "the joint-space inertia matrix at q; every joint must move some mass or rotor, or an inertia about its axis"
        raise ConfigurationError("KS303", "the mass matrix is not symmetric and positive definite", hint) from None


def _over(half: Array, rows: Array, xp: Namespace) -> Array:
    """L⁻¹ Jᵀ (..., n, r): its singular values squared are the eigenvalues of J M⁻¹ Jᵀ."""
    batch = np.broadcast_shapes(tuple(half.shape[:-2]), tuple(rows.shape[:-2]))
    wide = (*batch, *rows.shape[-2:])
    return xp.linalg.solve(xp.broadcast(half, (*batch, *half.shape[-2:])), transpose(xp.broadcast(rows, wide)))


def _others(rows: Any, found: RowsInPlay) -> tuple[Array, int]:
    """The moving rows that are not in play, and the rank that is left for those in play while they are held."""
    if not isinstance(rows, Jacobian) or found.task is None:
        hint = "pass the Jacobian and task='position' instead of J.linear"
        raise ConfigurationError("KS361", "others='held' was given with a bare array", hint)
    every = task_of(rows, "auto").rows
    held = tuple(row for row in every if row not in found.task.rows)
    array = rows.array[..., np.array(held, dtype=int), :]
    if not held:
        return array, found.rank
    both = task_of(rows, tuple(sorted({*held, *found.task.rows})))
    return array, both.rank - task_of(rows, held).rank


def _beside(columns: Array, held: Array, found: RowsInPlay) -> Array:
    """The part of the columns at right angles to those held, in the metric of the mass matrix."""
    if not held.shape[-1]:
        return columns
    U, sigma, _ = decomposed(held, found.xp)
    span = U * (sigma > found.tolerance * sigma[..., :1])[..., None, :]
    return columns - span @ (transpose(span) @ columns)
