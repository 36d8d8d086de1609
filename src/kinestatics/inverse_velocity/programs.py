"""Rates inside limits by quadratic programs: as close to the twist as possible, or along it as fast as possible."""

from __future__ import annotations

import numpy as np

from ..namespaces import Array
from .metric import Metric
from .quadratic import Bounded, in_strict_order, least_damping, solve, solver
from .scaling import scaled_into


def bounded_rates(
    matrix: Array, target: Array, secondary: Array, metric: Metric, lower: Array, upper: Array, damping: float | None
) -> tuple[Array, float, bool]:
    """The rates closest to the twist inside the limits.

    Args:
        matrix: (r, n), target: (r), secondary: (n) rates that are preferred.
        metric: what |q̇| is measured by; lower, upper: (n); damping: λ, or None for the least that decides.

    Returns:
        (n), the damping used, and whether no bound is met, so that the twist is that without limits.

    Law: min |J q̇ - ξ|² + λ² (q̇ - b)ᵀ W (q̇ - b) subject to lower <= q̇ <= upper.
    """
    solver()
    n = matrix.shape[1]
    back = np.eye(n) if metric.inverse_root is None else metric.inverse_root
    A, start = matrix @ back, np.clip(np.zeros(n), lower, upper)
    weight = least_damping(A) if damping is None else damping
    y0, y_start = (v if metric.root is None else metric.root @ v for v in (secondary, start))
    problem = Bounded(A, target, y0, back, lower, upper, weight)
    y = solve(problem, y_start)
    rates = np.clip(back @ y, lower, upper)
    room = 1e-9 * (1.0 + np.abs(rates))
    return rates, weight, bool(np.all((rates - lower > room) & (upper - rates > room)))


def rates_along(
    matrix: Array, target: Array, secondary: Array, metric: Metric, lower: Array, upper: Array, tolerance: float
) -> tuple[Array, float] | None:
    """The greatest s <= 1 with J q̇ = s ξ inside the limits, and the rates closest to `secondary` that make it.

    ξ is replaced by the closest reachable twist where it is not one.

    Returns:
        (n) and s; None where no rates along the twist, not even s = 0, are inside the limits.

    Law: q̇ = R⁻¹(s p + Z z), p = (J R⁻¹)⁺ ξ, Z a basis of the null space: J q̇ = s J J⁺ ξ for all z.
    """
    solver()
    n = matrix.shape[1]
    back = np.eye(n) if metric.inverse_root is None else metric.inverse_root
    U, sigma, Vt = np.linalg.svd(matrix @ back)
    rank = int(np.sum(sigma > tolerance * sigma.max(initial=0.0)))
    p = Vt[:rank].T @ ((U[:, :rank].T @ target) / sigma[:rank])
    Z = Vt[rank:].T
    y0 = secondary if metric.root is None else metric.root @ secondary
    free = scaled_into(back @ p, back @ (Z @ (Z.T @ y0)), lower, upper)
    if free.scale == 1.0 and np.array_equal(free.rates, back @ p + back @ (Z @ (Z.T @ y0))):
        return free.rates, 1.0
    k = Z.shape[1]
    C = np.zeros((n + 1, k + 1))
    C[:n, :k], C[:n, k], C[n, k] = back @ Z, back @ p, 1.0
    bounds = np.append(lower, 0.0), np.append(upper, 1.0)
    start = np.zeros(k + 1) if np.all((lower <= 0.0) & (upper >= 0.0)) else None
    share = np.zeros((1, k + 1))
    share[0, k] = 1.0
    x = in_strict_order([(share, np.ones(1)), (np.c_[Z, p], y0)], C, *bounds, start, tolerance)
    if x is None:
        return None
    x[k] = np.clip(x[k], 0.0, 1.0)
    return np.clip(C[:n] @ x, lower, upper), float(x[k])
