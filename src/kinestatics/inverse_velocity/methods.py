"""joint_rates: one question, several laws for what to do where the answer is not unique, does not exist or is too fast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError, nearest
from ..namespaces import Array
from ..spatial import rotate
from ..statics import RANK_TOLERANCE
from .factored import qr_rates, symbolic_rates
from .given_limits import read_limits
from .limits import RateLimits
from .metric import Metric
from .problem import Problem, checked_positive, read_problem, read_rates
from .programs import bounded_rates, rates_along
from .result import JointRates
from .scaling import scaled_into
from .spectral import Spectrum, adaptive_damping, damped_gain, inverse_gain, spectrum

METHODS = ("pseudoinverse", "weighted", "damped", "adaptive", "qr", "qp")
REGION = 0.02
"""Where "adaptive" begins to damp: singular values below this fraction of the largest."""
_TAKES = {
    "damping": ("damped", "adaptive", "qp"),
    "region": ("adaptive",),
    "weights": ("weighted", "damped", "adaptive", "qr", "qp"),
    "keep_direction": ("qp",),
}


class _Asked(NamedTuple):
    """The first fields of JointRates behind the array."""

    method: str
    jacobian: Any
    twist: Any
    tolerance: float
    length: float
    problem: Problem
    metric: Metric


class _Parts(NamedTuple):
    """Rates in the units of the metric: what makes the task, what moves nothing of it; damping; where the SVD stepped in."""

    task: Array
    null: Array | None
    damping: Any = None
    by_svd: Array = None


def joint_rates(
    J: Any,
    twist: Any,
    method: str = "pseudoinverse",
    *,
    task: str | Sequence[str] | Sequence[int] | None = None,
    damping: float | None = None,
    region: float | None = None,
    weights: Any = None,
    secondary: Any = None,
    limits: Any = None,
    keep_direction: bool = False,
    length: float = 1.0,
    tolerance: float = RANK_TOLERANCE,
) -> JointRates:
    """The joint rates that make a twist, or come closest to it.

    Methods:
        "pseudoinverse": of all rates that come closest, the smallest; right at singularities by construction.
        "weighted": smallest in q̇ᵀ W q̇, for joints of different kinds or strengths.
        "damped": gives up some of the twist for slower joints everywhere: |J q̇ - ξ|² + λ² |q̇|².
        "adaptive": the same, but only in directions that are nearly lost; elsewhere it is the pseudoinverse.
        "qr": the pseudoinverse without singular values, faster where there are many Jacobians of full rank; where rank is
            missing the SVD takes over, and `by_svd` says so.
        "qp": the least |J q̇ - ξ|² inside the limits (package daqp).

    Args:
        J: Jacobian of any link, or a bare array (..., r, n). NumPy, JAX (jit), PyTorch; SymPy for "pseudoinverse".
        twist: Twist in the frame of J, or a bare array (..., r) in its rows [m/s, rad/s]. NaN: that component is free.
        method: one of the above.
        task: the rows that count: "auto" (those this arm can move), "position", "orientation", "full", rows such as
            "vx,vy" or ["vx", "wz"], or their numbers from 0; all others are free, as if the twist were NaN there. None:
            every component of the twist that is not NaN. Of a bare array without six rows: numbers only.
        damping: λ [the unit of the rows]; needed by "damped"; the most that "adaptive" applies, default ε/√2; for "qp"
            the weight of |q̇|, default 1e-6 of the largest singular value.
        region: for "adaptive": ε as a fraction of the largest singular value, default 0.02.
        weights: W, (n) or symmetric (n, n); needed by "weighted", taken by all but "pseudoinverse".
        secondary: (n) or (..., n) joint motion b wanted beside the task: the part of it that does not disturb the task is
            added. For "qp": rates close to b are preferred.
        limits: RateLimits; or (n) sizes, the same both ways; or a pair (lower, upper) of (..., n) each; or of some joints
            {joint: size} or {joint: (lower, upper)}, the others without limit [rad/s or m/s]. Methods other than "qp"
            slow down: the greatest share s of the twist that the limits allow, the secondary motion giving way first.
        keep_direction: for "qp": the twist's direction is kept, J q̇ = s ξ (or s times the closest reachable twist), with
            the greatest s that any rates allow, and then the smallest rates.
        length: a twist's size is |(v, length · ω)| [m]: what "closest" means when J has six rows.
        tolerance: singular values below this fraction of the largest count as zero.

    Returns:
        JointRates; `.array` (..., n) [rad/s, or m/s for a prismatic joint].

    Raises:
        UnknownNameError: KS350; KS318 a task or row, KS313 a joint of the limits, that does not exist.
        ConfigurationError: KS301, KS303; KS351 an argument that the method or the bare array does not take, or that it
        needs; KS352 weights; KS353 numbers that are not positive; KS354 limits; KS355 symbols without full rank; KS356.
        FrameMismatchError: KS330. ArrayTypeError: KS302. MissingExtraError: KS400.

    Law: q̇ = V g(Σ) Uᵀ ξ + (I - J⁺J) b with J = U Σ Vᵀ and g = 1/σ, or σ/(σ² + λ²).
    Source: note 000, "Uses of the Pseudoinverse"; Nakamura, Hanafusa 1986; Wampler 1986; Chiaverini 1997.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.01])
        >>> ks.joint_rates(J.linear, [1.0, 0.0, 0.0]).array.round(3)
        array([  99.997, -199.998])
        >>> ks.joint_rates(J.linear, [1.0, 0.0, 0.0], "adaptive").array.round(3)
        array([ 1.978, -3.962])
        >>> ks.joint_rates(J, [1.0, 0.0, 0, 0, 0, 0], task="auto", limits=[2.0, 2.0]).array.round(3)
        array([ 1., -2.])
    """
    _check_arguments(method, damping, region, weights, keep_direction, limits)
    problem = read_problem(J, twist, length, task)
    metric = Metric.of(weights, problem.n)
    limit = problem.tolerance(checked_positive(tolerance, "tolerance", "a small fraction, such as 1e-10"))
    asked = _Asked(method, J, twist, limit, length, problem, metric)
    if problem.xp.name == "sympy":
        rates = _at_symbols(problem, method, secondary, limits)
        return JointRates(rates, *asked, scale=np.ones(problem.batch))
    b = None if secondary is None else read_rates(secondary, "secondary", problem)
    bounds = None if limits is None else read_limits(limits, problem, problem.batch, J)
    if method == "qp":
        return _by_program(b, bounds, damping, keep_direction, asked)
    motion = None if b is None else metric.enter(b, problem.xp)
    parts = _unlimited(problem, metric, method, damping, region, motion, limit)
    moves = metric.leave(parts.task, problem.xp)
    null = None if parts.null is None else metric.leave(parts.null, problem.xp)
    if bounds is None:
        rates = moves if null is None else moves + null
        whole = np.ones(rates.shape[:-1])
        return JointRates(rates, *asked, damping=parts.damping, scale=whole, by_svd=parts.by_svd)
    kept = scaled_into(moves, null, bounds.lower, bounds.upper)
    how = {"damping": parts.damping, "by_svd": parts.by_svd}
    return JointRates(kept.rates, *asked, **how, limits=bounds, scale=kept.scale, keeps_direction=kept.fits)


def _unlimited(
    problem: Problem, metric: Metric, method: str, damping: Any, region: Any, motion: Array | None, tolerance: float
) -> _Parts:
    """The rates without limits, in the units of the metric."""
    matrix, target, xp = metric.in_units(problem.matrix, problem.xp), problem.target, problem.xp
    if method == "qr":
        return _by_qr(matrix, target, motion, tolerance, problem)
    found = spectrum(matrix, xp, tolerance)
    null = None if motion is None else found.without_task(motion)
    if method == "damped":
        size = checked_positive(damping, "damping", "in the unit of the rows")
        return _Parts(found.rates(target, damped_gain(found, size)), null, size)
    if method == "adaptive":
        sizes = _adaptive(found, damping, region)
        return _Parts(found.rates(target, damped_gain(found, sizes)), null, sizes)
    return _Parts(found.rates(target, inverse_gain(found)), null)


def _adaptive(found: Spectrum, damping: Any, region: Any) -> Array:
    edge = checked_positive(REGION if region is None else region, "region", "a fraction of the largest singular value")
    most = None if damping is None else checked_positive(damping, "damping", "in the unit of the rows")
    return adaptive_damping(found, edge, most)


def _by_qr(matrix: Array, target: Array, motion: Array | None, tolerance: float, problem: Problem) -> _Parts:
    """QR where it can be trusted, the SVD elsewhere; the null part of a motion b is b - J⁺ J b."""
    if problem.xp.name != "numpy":
        raise ArrayTypeError("KS302", f"method 'qr' runs on NumPy, not on {problem.xp.name}", "method 'pseudoinverse'")
    if matrix.ndim == 2 and problem.asked.ndim == 1:  # rows that are left out take no rank away
        matrix, target = matrix[problem.asked], target[..., problem.asked]
    task, by_svd = _qr_or_svd(matrix, target, tolerance, problem)
    if motion is None:
        return _Parts(task, None, None, by_svd)
    moved, _ = _qr_or_svd(matrix, rotate(matrix, motion), tolerance, problem)
    return _Parts(task, motion - moved, None, by_svd)


def _qr_or_svd(matrix: Array, target: Array, tolerance: float, problem: Problem) -> tuple[Array, Array]:
    """J⁺ target, and (...) where the SVD was needed."""
    rates, trusted = qr_rates(matrix, target)
    if trusted.all():
        return rates, ~trusted
    shape = (*trusted.shape, *matrix.shape[-2:])
    rest, goal = np.broadcast_to(matrix, shape)[~trusted], np.broadcast_to(target, shape[:-1])[~trusted]
    found = spectrum(rest, problem.xp, tolerance)
    rates = np.array(np.broadcast_to(rates, (*trusted.shape, problem.n)))
    rates[~trusted] = found.rates(goal, inverse_gain(found))
    return rates, ~trusted


def _by_program(
    secondary: Array | None, limits: RateLimits | None, damping: Any, keep_direction: bool, asked: _Asked
) -> JointRates:
    """The quadratic program, one after the other where there is a batch."""
    tolerance, problem, metric = asked.tolerance, asked.problem, asked.metric
    if problem.xp.name != "numpy":
        raise ArrayTypeError("KS302", f"method 'qp' runs on NumPy, not on {problem.xp.name}", "convert the Jacobian first")
    size = None if damping is None else checked_positive(damping, "damping", "in the unit of the rows")
    n = problem.n
    bounds = limits or RateLimits(np.full(n, -np.inf), np.full(n, np.inf))
    batch = np.broadcast_shapes(problem.batch, bounds.lower.shape[:-1], () if secondary is None else secondary.shape[:-1])
    wanted = np.zeros(n) if secondary is None else secondary
    shapes = ((problem.matrix, (problem.matrix.shape[-2], n)), (problem.target, problem.target.shape[-1:]), (wanted, (n,)))
    arrays = [np.broadcast_to(array, (*batch, *last)) for array, last in shapes]
    lower, upper = (np.broadcast_to(bound, (*batch, n)) for bound in (bounds.lower, bounds.upper))
    rates, scale, kept = np.zeros((*batch, n)), np.ones(batch), np.zeros(batch, dtype=bool)
    used = np.zeros(batch)
    for k in np.ndindex(batch):
        A, b, x0 = (array[k] for array in arrays)
        if keep_direction:
            found = rates_along(A, b, x0, metric, lower[k], upper[k], tolerance)
            if found is not None:
                rates[k], scale[k], kept[k] = found[0], found[1], True
                continue
        rates[k], used[k], kept[k] = bounded_rates(A, b, x0, metric, lower[k], upper[k], size)
        scale[k] = 0.0 if keep_direction else 1.0
    weight = None if keep_direction else used
    return JointRates(rates, *asked, damping=weight, limits=limits, scale=scale, keeps_direction=kept)


def _at_symbols(problem: Problem, method: str, secondary: Any, limits: Any) -> Array:
    if method != "pseudoinverse" or limits is not None:
        raise ArrayTypeError("KS302", "symbols are solved by method 'pseudoinverse' without limits only", "put in numbers")
    motion = None if secondary is None else read_rates(secondary, "secondary", problem)
    return symbolic_rates(problem.matrix, problem.target, motion)


def _check_arguments(method: Any, damping: Any, region: Any, weights: Any, keep_direction: bool, limits: Any) -> None:
    """Raises UnknownNameError (KS350) for the method, ConfigurationError (KS351) for what it does not take or needs."""
    if method not in METHODS:
        raise UnknownNameError("KS350", f"method {method!r} is not known", nearest(str(method), METHODS))
    if method == "pseudoinverse" and damping is region is weights is None and not keep_direction:
        return
    given = {"damping": damping, "region": region, "weights": weights, "keep_direction": keep_direction or None}
    for name, value in given.items():
        if value is not None and method not in _TAKES[name]:
            takers = ", ".join(repr(word) for word in _TAKES[name])
            raise ConfigurationError("KS351", f"method {method!r} takes no {name}", f"methods that do: {takers}")
    needed = {"damped": ("damping", damping), "weighted": ("weights", weights)}.get(method)
    if needed is not None and needed[1] is None:
        remedy = {"damping": "damping=0.05, in the unit of the rows, or method 'adaptive'", "weights": "weights=[...]"}
        raise ConfigurationError("KS351", f"method {method!r} needs {needed[0]}", remedy[needed[0]])
    if keep_direction and (limits is None or damping is not None):
        message = "keep_direction without limits" if limits is None else "keep_direction takes no damping"
        raise ConfigurationError("KS351", message, "limits=ks.RateLimits.of(arm, q), and no damping=")
