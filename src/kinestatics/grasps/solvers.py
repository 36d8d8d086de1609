"""Solvers behind grasps: linear programs, nonnegative least squares, convex hulls. SciPy, imported when used."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, missing_extra
from ..namespaces import Array

TIGHT = 1e-10
"""Feasibility tolerance asked of the linear programs, whose data are of size 1."""


class Solution(NamedTuple):
    """Of a linear program: x, its value, and the prices of its equalities and inequalities."""

    x: Array
    value: float
    of_equalities: Array
    of_inequalities: Array


def _scipy(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(f"scipy.{name}")
    except ImportError:
        raise missing_extra("scipy", "grasp", "friction cones and their closure") from None


def linear_program(
    cost: Array, equal: tuple[Array, Array] | None, most: tuple[Array, Array] | None, bounds: Any
) -> Solution | None:
    """Least cost · x with A x = b for `equal`, A x <= b for `most`, and bounds; None where the solver gives up."""
    A_eq, b_eq = equal if equal is not None else (None, None)
    A_ub, b_ub = most if most is not None else (None, None)
    solve = _scipy("optimize").linprog
    for presolve in (True, False):  # without, where presolving leaves too little accuracy
        options = {"primal_feasibility_tolerance": TIGHT, "dual_feasibility_tolerance": TIGHT, "presolve": presolve}
        result = solve(cost, A_ub=A_ub, b_ub=b_ub, A_eq=A_eq, b_eq=b_eq, bounds=bounds, method="highs", options=options)
        if result.status == 0:
            return Solution(result.x, float(result.fun), result.eqlin.marginals, result.ineqlin.marginals)
    return None


def nearest_in_cone(columns: Array, target: Array) -> Array:
    """Weights >= 0 of the columns whose sum comes nearest to the target.

    Raises:
        ConfigurationError: KS375, where the solver gives up.
    """
    try:
        weights, _ = _scipy("optimize").nnls(columns, target, maxiter=30 * columns.shape[1] + 300)
    except RuntimeError as error:
        raise no_answer(f"nonnegative least squares ended with: {error}") from None
    return np.asarray(weights)


def hull_planes(points: Array) -> tuple[Array, Array, float] | None:
    """Outward unit normals (F, d) and offsets (F) of the facets of a convex hull, and how far they may be off.

    Symmetric grasps have many facets of many points, over which Qhull stumbles; it therefore moves the points by a little
    more than rounding ("QJ"). None where it gives up all the same.
    """
    spatial = _scipy("spatial")
    try:
        planes = spatial.ConvexHull(points, qhull_options="QJ").equations
    except spatial.QhullError:
        return None
    normals, offsets = planes[:, :-1], -planes[:, -1]
    moved = float(np.abs((normals @ points.T).max(1) - offsets).max())
    return normals, offsets, moved


def no_answer(why: str) -> ConfigurationError:
    """The error for numbers that a solver cannot cope with (KS375)."""
    hint = "are lengths in metres, and no two contacts the same to rounding?"
    return ConfigurationError("KS375", f"no answer: {why}", hint)
