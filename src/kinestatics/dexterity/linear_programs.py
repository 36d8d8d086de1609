"""Linear programs of a few variables: the best point of {x : A x <= b}, and the deepest one. Bare NumPy arrays.

An active-set simplex: it climbs along faces and edges until the rows it leans on prove that no point is higher. It lets go
of rows by the smallest index (Bland), and of rows met together leans on the steepest, passing others by a hair (Harris).

Source: Nocedal, Wright, "Numerical Optimization" (2006), chapters 13 and 16; Bland, "New finite pivoting rules for the
simplex method", Math. of Operations Research 2(2), 1977; Harris, "Pivot selection methods of the Devex LP code", Math.
Programming 5, 1973.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array

_TOLERANCE = 1e-11  # of slopes, multipliers and steps, for rows of about unit length
_GIVE = 1e-11  # by so much a limit may be passed where that avoids leaning on two nearly parallel ones
_STEPS = 4  # for each constraint and variable, after which the walk goes on with ten times the tolerance
_DECADES = 5


class Optimum(NamedTuple):
    """Where a linear program ends.

    Attributes:
        value: c · x there, infinite when the program is unbounded.
        point: (k) the optimum, or the last point before the unbounded edge.
        multipliers: (m) what a unit more of each b would add to the value: the proof that no point is better.
    """

    value: float
    point: Array
    multipliers: Array


def maximize(c: Array, A: Array, b: Array, start: Array) -> Optimum:
    """The greatest c · x over {x : A x <= b}.

    Args:
        c: (k).
        A, b: (m, k), (m), b finite; rows of about unit length.
        start: (k) a point that obeys them.

    Raises:
        ConfigurationError: KS369, when the walk does not end.

    Law: c = Aᵀ λ with λ >= 0, and λ > 0 only where A x = b.
    """
    x, active = np.array(start, dtype=float), np.zeros(len(b), dtype=bool)
    size, patience = max(float(np.linalg.norm(c)), np.finfo(float).tiny), _STEPS * (len(b) + len(c) + 1)
    for step in range(_DECADES * patience):
        small = _TOLERANCE * size * 10.0 ** (step // patience)  # limits that all but coincide may lead in circles
        uphill, weights = _along(c, A[active])
        if np.linalg.norm(uphill) <= small:
            if np.all(weights >= -small):
                break
            active[np.flatnonzero(active)[np.flatnonzero(weights < -small)[0]]] = False
            continue
        uphill = uphill / np.linalg.norm(uphill)
        entering, length = _first_met(A, b, x, uphill, active)
        if entering < 0:
            return Optimum(np.inf, x, np.zeros(len(b)))
        x, active[entering] = x + length * uphill, True
    else:
        hint = "limits that differ by many orders of magnitude can do this"
        raise ConfigurationError("KS369", f"a linear program of {len(b)} limits did not settle", hint)
    multipliers = np.zeros(len(b))
    if np.any(active):
        x = x + np.linalg.lstsq(A[active], b[active] - A[active] @ x, rcond=None)[0]
        multipliers[active] = np.maximum(weights, 0.0)
    return Optimum(float(c @ x), x, multipliers)


def _along(c: Array, rows: Array) -> tuple[Array, Array]:
    """What is left of c along the planes of independent rows (a, k), and c as their combination but for that."""
    if not len(rows):
        return c, np.zeros(0)
    Q, R = np.linalg.qr(rows.T)  # rows that all but coincide spoil the weights, but not what is left
    within = Q.T @ c
    left = np.zeros_like(c) if len(rows) == len(c) else c - Q @ within
    return left, np.linalg.lstsq(R, within, rcond=None)[0]


def _first_met(A: Array, b: Array, x: Array, direction: Array, active: Array) -> tuple[int, float]:
    """The constraint met first on the way, and how far that is; (-1, inf) when there is none."""
    slope = A @ direction
    ahead = ~active & (slope > _TOLERANCE)
    if not np.any(ahead):
        return -1, np.inf
    steps, reach = np.full(len(b), np.inf), np.full(len(b), np.inf)
    slack = np.maximum(b - A @ x, 0.0)[ahead]
    steps[ahead], reach[ahead] = slack / slope[ahead], (slack + _GIVE) / slope[ahead]
    entering = int(np.argmax(np.where(steps <= reach.min(), slope, -np.inf)))
    return entering, float(steps[entering])


def deepest(A: Array, b: Array) -> Optimum:
    """The point with the greatest least slack: max s with A x + s <= b.

    The value is s: negative when no point obeys all rows. The multipliers then name rows that contradict one another.
    """
    m, k = A.shape
    rows = np.vstack([np.c_[A, np.ones(m)], np.r_[np.zeros(k), 1.0]])
    goal, ceiling = np.r_[np.zeros(k), 1.0], 1.0 + float(np.abs(b).max(initial=0.0))
    point = np.zeros(k)
    for _ in range(2):  # the second time around the point of the first, where what is left of the limits is small
        limits = np.r_[b - A @ point, ceiling]
        found = maximize(goal, rows, limits, np.r_[np.zeros(k), float(limits.min())])
        point = point + found.point[:k]
    least = float((b - A @ point).min(initial=ceiling))
    return Optimum(least, point, found.multipliers[:m])
