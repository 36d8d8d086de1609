"""How a measure changes with the joints: the gradient that resolved-rate control and posture optimisation climb.

A singular value moves as σi' = uiᵀ J' vi. Measures that treat all singular values alike (Yoshikawa's, isotropy) are smooth
where two of them meet, and have a kink only at a singularity. The smallest and the largest one have a kink where they
meet others. What is returned at a kink is said in `manipulability_gradient`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, UnknownNameError, nearest
from ..frames import TIP, Frame
from ..kinematics import hessian, jacobian
from ..model import RobotModel
from ..namespaces import Array, Namespace
from ..spatial import transpose
from .measures import isotropy_of, ratio_of
from .rows import RowsInPlay, TaskName, decomposed, rows_in_play


def manipulability_gradient(
    model: RobotModel,
    q: Any,
    *,
    measure: str = "manipulability",
    task: TaskName = "auto",
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    length: float | None = None,
    check_finite: bool = True,
) -> Array:
    """The gradient of a measure by the joints: the direction in which the posture becomes better.

    Args:
        model: the robot.
        q: (..., n) [rad or m]; NumPy, JAX or PyTorch.
        measure: "manipulability", "smallest_singular_value", "inverse_condition" or "isotropy".
        task, length: as in `manipulability` and `singular_values`.
        at, point, frame, check_finite: as in `jacobian`.

    Returns:
        (..., n) in the unit of the measure per rad or m.

        Where k singular values are equal, smallest_singular_value and inverse_condition have a kink: what is returned is
        the mean of the k gradients, which does not depend on the choice of singular vectors and is an element of the
        generalised gradient (Clarke); 0 at an isotropic posture, which no step makes rounder.

        At a singular posture all measures have a kink, where one singular value vanishes: the measure grows in two
        opposite directions. With NumPy, what is returned is one of the two directions of steepest ascent (that whose
        first large entry is positive) times the one-sided slope in it. Where two or more vanish it is 0: the measure
        grows slower than the step, or is at a minimum. The isotropy of three and more singular values rises with
        infinite slope: its entries are ±inf, or NaN where two and more vanish and no direction can be named. JAX and
        PyTorch do not branch on values, and return finite numbers there that mean nothing.

    Raises:
        UnknownNameError: KS365 for the measure; KS318, KS310. ConfigurationError: KS360, KS303, KS301.
        ArrayTypeError: KS302; for symbols differentiate `manipulability` itself.

    Law: ∂σi/∂q_k = uiᵀ (∂J/∂q_k) vi; ∂w/∂q_k = Σi (Π_{j≠i} σj) ∂σi/∂q_k, which divides by nothing.
    Source: Park, Chung, Youm, "Computation of gradient of manipulability for kinematically redundant manipulators
        including dual manipulators system", Trans. Control, Automation and Systems Engineering 1(1), 1999; Haviland, Corke,
        "Manipulator differential kinematics, part 2", IEEE RAM 2023; Golub, Van Loan, section 8.6, for σi'.

    Example:
        >>> import kinestatics as ks
        >>> ks.manipulability_gradient(ks.load("planar_2r"), [0.0, 0.0])
        array([0., 1.])
    """
    if measure not in _GRADIENTS:
        raise UnknownNameError("KS365", f"measure {measure!r} is not known", nearest(str(measure), _GRADIENTS))
    options: dict[str, Any] = {"at": at, "point": point, "frame": frame, "check_finite": check_finite}
    J = jacobian(model, q, **options)
    found = rows_in_play(J, task, length, needs_length=measure != "manipulability")
    if found.xp.name == "sympy":
        hint = "sympy.diff(ks.manipulability(J), q[k])"
        raise ArrayTypeError("KS302", "manipulability_gradient computes with numbers", hint)
    rates = _scaled_rates(hessian(model, q, **options).array, found)
    if not found.rank:
        return rates.sum((-3, -2)) * 0
    U, sigma, Vt = decomposed(found.array, found.xp)
    slopes = _slopes(U, rates, Vt)[..., : found.rank, :]
    sigma = sigma[..., : found.rank]
    result = _GRADIENTS[measure](sigma, slopes, found.tolerance, found.xp)
    return _at_singularities(result, measure, found, sigma, rates) if found.xp.name == "numpy" else result


def _scaled_rates(H: Array, found: RowsInPlay) -> Array:
    """∂J/∂q (..., r, n, n) of the rows in play, with their weights."""
    rows = found.task.rows if found.task is not None else ()
    chosen = H[..., np.array(rows, dtype=int), :, :]
    weights = found.row_weights[:, None, None] * found.column_weights[:, None]
    return chosen * found.xp.constant(weights, chosen)


def _slopes(U: Array, rates: Array, Vt: Array) -> Array:
    """(..., k, n): uiᵀ ∂J/∂q vi for every singular value and joint."""
    *batch, r, n, m = rates.shape
    across = transpose(U) @ rates.reshape(*batch, r, n * m)
    return (Vt[..., :, None, :] @ across.reshape(*batch, U.shape[-1], n, m))[..., 0, :]


def _mean_slope(sigma: Array, slopes: Array, index: int, tolerance: float) -> Array:
    """(..., n): the mean of the slopes of all singular values that are equal to one of them."""
    alike = abs(sigma - sigma[..., index, None]) <= tolerance * sigma[..., :1]
    weights = alike * (0 * sigma + 1)
    return (weights[..., None] * slopes).sum(-2) / (weights.sum(-1) + (weights.sum(-1) == 0))[..., None]


def _of_product(sigma: Array, slopes: Array, tolerance: float, xp: Namespace) -> Array:
    del tolerance
    return (_products_of_others(sigma, xp)[..., None] * slopes).sum(-2)


def _products_of_others(sigma: Array, xp: Namespace) -> Array:
    """(..., k): the product of all but one, for each."""
    k = sigma.shape[-1]
    others = [xp.concat([sigma[..., :i], sigma[..., i + 1 :]], -1).prod(-1) for i in range(k)]
    return xp.stack(others, -1)


def _of_smallest(sigma: Array, slopes: Array, tolerance: float, xp: Namespace) -> Array:
    del xp
    return _mean_slope(sigma, slopes, -1, tolerance)


def _of_ratio(sigma: Array, slopes: Array, tolerance: float, xp: Namespace) -> Array:
    del xp
    ratio = ratio_of(sigma, sigma.shape[-1], tolerance)[..., None]
    first = sigma[..., :1] + (sigma[..., :1] == 0)
    return (_mean_slope(sigma, slopes, -1, tolerance) - ratio * _mean_slope(sigma, slopes, 0, tolerance)) / first


def _of_isotropy(sigma: Array, slopes: Array, tolerance: float, xp: Namespace) -> Array:
    del tolerance, xp
    k, value = sigma.shape[-1], isotropy_of(sigma, sigma.shape[-1])[..., None]
    safe = sigma + (sigma == 0)
    first = safe[..., :1]
    scaled = sigma / first
    squares = (scaled * scaled).sum(-1)[..., None]
    weights = 2 * value * (1 / (k * safe) - scaled / (squares + (squares == 0)) / first)
    return (weights[..., None] * slopes).sum(-2)


_GRADIENTS: dict[str, Callable[[Array, Array, float, Namespace], Array]] = {
    "manipulability": _of_product,
    "smallest_singular_value": _of_smallest,
    "inverse_condition": _of_ratio,
    "isotropy": _of_isotropy,
}


def _at_singularities(result: Array, measure: str, found: RowsInPlay, sigma: Array, rates: Array) -> Array:
    """The gradient with its values at singular postures replaced by the steepest one-sided ascent."""
    result = np.where(np.isnan(sigma[..., :1]), np.nan, result)
    vanished = np.sum(sigma <= found.tolerance * sigma[..., :1], axis=-1)
    for index in map(tuple, np.argwhere(vanished > 0)):
        count = int(vanished[index])
        U, _, Vt = np.linalg.svd(found.array[index], full_matrices=True)
        kept = found.rank - count
        slope = _steepest(U[:, kept:], rates[index], Vt[kept:]) if count == 1 else np.zeros(rates.shape[-1])
        result[index] = _one_sided(measure, sigma[index], count, slope)
    return result + 0.0  # no minus before a zero


def _steepest(lost: Array, rates: Array, idle: Array) -> Array:
    """(n): the direction in which the vanished singular value grows fastest, times its slope there.

    To first order it is the size of Lᵀ (Σ ∂J/∂q_k δ_k) N, with L the lost directions and N the motions that move nothing.
    """
    n = rates.shape[-1]
    change = np.einsum("rl,rjk,ij->lik", lost, rates, idle).reshape(-1, n)
    _, slopes, directions = np.linalg.svd(change, full_matrices=False)
    if not slopes.size:
        return np.zeros(n)
    direction = directions[0]
    large = np.flatnonzero(np.abs(direction) > 0.5 * np.abs(direction).max())[0]
    return slopes[0] * direction * np.sign(direction[large])


def _one_sided(measure: str, sigma: Array, count: int, slope: Array) -> Array:
    """The slope of a measure where the last `count` singular values vanish, from that of the last."""
    k = len(sigma)
    if measure == "manipulability":
        return slope * np.prod(sigma[: k - 1])
    if measure == "smallest_singular_value":
        return slope
    first = sigma[0] if sigma[0] > 0 else 1.0
    if measure == "inverse_condition":
        return slope / first if k > 1 else 0 * slope
    if 2 * count > k:  # w^(2/k) grows slower than the step
        return 0 * slope
    if k == 2:
        return 2 * slope / first
    if count > 1:
        return np.full_like(slope, np.nan)
    rises = np.abs(slope) > 1e-12 * np.abs(slope).max(initial=0.0)
    return np.where(rises, np.copysign(np.inf, slope), 0.0)
