"""`least_in_box`: a small convex quadratic in a box, for a drag of the mouse: no optional library, nothing set up before."""

from __future__ import annotations

import numpy as np

from ..namespaces import Array

_WRONG = 1e-12  # a slope below this share of the largest presses on no bound
_ROUNDS = 8  # times the number of joints


def least_in_box(G: Array, g: Array, lower: Array, upper: Array) -> Array:
    """min xᵀ G x / 2 - gᵀ x with lower <= x <= upper, 0 inside, and G positive definite.

    Law: at the optimum the slope g - G x is 0 where x is free, and pushes outwards where x is at a bound. A primal active
    set finds it in finitely many steps; should rounding make it turn in circles, it ends at the best x it has.
    Source: Stark, Parker, "Bounded-variable least squares", Computational Statistics 10 (1995).
    """
    x = np.zeros(len(g))
    free = ~(((x >= upper) & (g > 0)) | ((x <= lower) & (g < 0)))
    for _ in range(_ROUNDS * len(g) + 1):
        goal = x.copy()
        if free.any():
            goal[free] = np.linalg.solve(G[np.ix_(free, free)], g[free] - G[np.ix_(free, ~free)] @ x[~free])
        outside = (goal < lower) | (goal > upper)
        if outside.any():
            x = _to_first_bound(x, goal, outside, lower, upper, free)
            continue
        x = goal
        slope = g - G @ x
        inwards = np.where(x >= upper, -slope, slope)
        inwards[free | (lower >= upper)] = 0.0
        worst = int(np.argmax(inwards))
        if inwards[worst] <= _WRONG * np.abs(g).max(initial=0.0):
            break
        free[worst] = True
    return x


def _to_first_bound(x: Array, goal: Array, outside: Array, lower: Array, upper: Array, free: Array) -> Array:
    """As far towards the goal as the first bound, whose joint is no longer free."""
    bound = np.where(goal > upper, upper, lower)
    shares = np.where(outside, (bound - x) / np.where(outside, goal - x, 1.0), np.inf)
    first = int(np.argmin(shares))
    x = x + shares[first] * (goal - x)
    x[first] = bound[first]
    free[first] = False
    return x
