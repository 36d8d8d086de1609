"""The least contact forces within round friction cones: programs over edges, to which edges are added. Needs SciPy."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..namespaces import Array
from ..spatial import size_weights
from .cones import Cones, Edges
from .solvers import linear_program, nearest_in_cone, no_answer

BALANCE: Final = 1e-9
"""A load counts as held when what is missing is no more than this share of it."""

_TANGENT, _XY, _MOMENT = [0, 1, 3], [0, 1], [2]  # of fx, fy, fz, mz; and of these
_ROOM = 1e-7  # by this share the largest force may be exceeded where the sum is minimized after it
_STILL = 1e-12  # a way this short, in shares of friction, is rounding
_ROUNDS = 100  # of edges added to the cones


class ForceSearch:
    """Weights of edges whose wrenches add up to a target; edges are added until no point of a cone is of use.

    Weights belong to the first edges: later ones have been added since.
    """

    def __init__(self, cones: Cones, rows: tuple[int, ...], rims: Edges) -> None:
        self.cones, self.rows, self.rims = cones, list(rows), rims
        self.scales = size_weights(1.0 / cones.size)

    @property
    def columns(self) -> Array:
        """(rows, K) scaled wrenches of the edges."""
        return (self.scales * self.rims.wrenches)[:, self.rows].T

    def wrench(self, weights: Array) -> Array:
        """The scaled wrench of a sum of edges."""
        return self.columns[:, : len(weights)] @ weights

    def forces(self, weights: Array) -> Array:
        """(n, 4) contact forces of a sum of edges."""
        return self.cones.forces(self.rims.take(np.arange(len(weights))), weights)

    def nearest(self, target: Array) -> Array:
        """Weights whose sum comes nearest to a target of size 1."""
        for _ in range(_ROUNDS):
            weights = nearest_in_cone(self.columns, target)
            rest = target - self.wrench(weights)
            size = float(np.linalg.norm(rest))
            if size <= BALANCE or not self._gains(rest / size, np.zeros(len(self.cones.contacts))):
                break
        return weights

    def least(self, target: Array, cost: tuple[float, float], shares: Array, caps: Array) -> tuple[Array, float] | None:
        """Weights that sum to the target, and z, with the least cost[0] · (sum of normal forces) + cost[1] · z.

        No normal force is above z times its entry of `shares`, nor above that of `caps`, where these are finite. None
        where the solver gives up.
        """
        shared, capped = np.flatnonzero(np.isfinite(shares)), np.flatnonzero(np.isfinite(caps))
        best: tuple[Array, float] | None = None
        for _ in range(_ROUNDS):
            K = len(self.rims)
            by_contact = (self.rims.owner == np.arange(len(caps))[:, None]).astype(float)
            equal = np.column_stack([self.columns, np.zeros(len(target))]), target
            rows = np.vstack([by_contact[shared], by_contact[capped]])
            of_z = np.r_[-shares[shared], np.zeros(len(capped))]
            most = np.column_stack([rows, of_z]), np.r_[np.zeros(len(shared)), caps[capped]]
            found = linear_program(np.r_[np.full(K, cost[0]), cost[1]], equal, most if len(rows) else None, (0.0, None))
            if found is None:
                break
            best = found.x[:K], float(found.x[K])
            costs = np.full(len(caps), cost[0])
            np.add.at(costs, np.r_[shared, capped], -found.of_inequalities)
            if not self._gains(found.of_equalities, costs):
                break
        return best

    def _gains(self, prices: Array, costs: Array) -> bool:
        """Whether some edge is worth more than it costs (n) at prices of scaled wrenches; it is then added."""
        twist = np.zeros(6)
        twist[self.rows] = prices
        twist = self.scales * twist
        worth = self.cones.reach(twist[None])[0] - costs
        useful = np.flatnonzero(worth > BALANCE * max(1.0, float(np.abs(prices).max())))
        if len(useful):
            self.rims = self.rims.plus(self.cones.furthest(twist, useful))
        return len(useful) > 0


def least_forces(search: ForceSearch, wanted: Array, limits: Array, minimize: str) -> tuple[Array, float]:
    """(n, 4) forces, and the share of the load that they hold; 0 where they only come nearest to it.

    Raises:
        ConfigurationError: KS375.
    """
    scaled = (search.scales * wanted)[search.rows]
    size = float(np.linalg.norm(scaled))
    if size == 0:
        return np.zeros((len(limits), 4)), 1.0
    weights = search.nearest(scaled / size)
    target = search.wrench(weights)
    if float(np.linalg.norm(target - scaled / size)) > BALANCE:
        return size * search.forces(weights), 0.0
    caps, free, only_z = limits / size, np.full(len(limits), np.inf), (0.0, 1.0)
    if np.any(np.isfinite(caps)):
        weights, z = _found(search.least(target, only_z, caps, free))
        if z > 1 + BALANCE:
            return size / z * _rested(search, search.forces(weights)), 1.0 / z
        caps = caps * max(1.0, z)
    scale, fallback = 1.0, None
    if minimize == "largest":
        fallback = search.least(target, only_z, np.ones(len(caps)), caps)
        scale = _found(fallback)[1]
        caps = np.minimum(caps, scale * (1 + _ROOM))
    found = search.least(target / scale, (1.0, 0.0), free, caps / scale)  # in numbers of size 1, for its tolerances
    weights = scale * found[0] if found is not None else _found(fallback)[0]
    return size * _rested(search, search.forces(weights)), 1.0


def _found(result: tuple[Array, float] | None) -> tuple[Array, float]:
    if result is None:
        raise no_answer("the linear program of contact forces did not end with an optimum")
    return result


def _rested(search: ForceSearch, forces: Array) -> Array:
    """The same normal forces and the same sum, with as little friction as the cones allow on the way to the least.

    A linear program ends in a corner, with friction at work against friction. The shares s of the friction allowed that
    have the least |s| for the same sum lie on a straight way from there, every point of which has that sum.
    """
    cones = search.cones
    allowed = forces[:, 2, None] * np.column_stack([cones.friction, cones.friction, cones.torsion])
    used = np.divide(forces[:, _TANGENT], allowed, out=np.zeros(allowed.shape), where=allowed > 0)
    columns = np.moveaxis((search.scales[:, None] * cones.maps)[:, search.rows][..., _TANGENT], 1, 0) * allowed
    matrix = columns.reshape(len(search.rows), -1)
    way = (np.linalg.pinv(matrix) @ (matrix @ used.ravel())).reshape(used.shape) - used
    step = min(1.0, _reach_of_circle(used[:, _XY], way[:, _XY]), _reach_of_circle(used[:, _MOMENT], way[:, _MOMENT]))
    rested = forces.copy()
    rested[:, _TANGENT] = (used + step * way) * allowed
    return rested


def _reach_of_circle(start: Array, way: Array) -> float:
    """How many steps `way` lead from points within unit circles (n, d) to the first rim."""
    a, b, c = (way**2).sum(-1), (start * way).sum(-1), np.minimum((start**2).sum(-1) - 1.0, 0.0)
    moving = a > _STILL**2
    a, b, c = a[moving], b[moving], c[moving]
    return float(((np.sqrt(b * b - a * c) - b) / a).min(initial=np.inf))
