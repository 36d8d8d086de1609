"""Least squares inside bounds: min |A x - b|² + λ² |x - x0|² with lower <= C x <= upper, and levels of them in strict order.

The solver DAQP (Arnström, Bemporad, Axehill, IEEE Trans. Automatic Control 67(8), 2022) finds which bounds are met. What
it found is then computed anew from the singular values of A on the bounds that are met and checked: feasible, and no
multiplier of the wrong sign (Karush, Kuhn, Tucker). Where that check fails, for want of digits in the squares of A, a
primal active-set method goes on from a feasible point (Nocedal, Wright, "Numerical Optimization", section 16.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import missing_extra
from ..namespaces import Array

_INFINITE = 1e30  # what DAQP takes for "no bound"
_EQUALITY, _LOWER_BIT, _ACTIVE = 5, 2, 1
_FEASIBLE = 1e-13  # relative to the bounds and C x
_PROPER = 1e-12  # relative size below which a multiplier is zero
_FOLLOWS = 1e-9  # of its length: a row this near to combinations of others is one of them
_PASSES, _GAIN = 60, 1e-12
_GUESS = 1e-5  # least damping DAQP is asked with, relative to the largest singular value


def solver() -> Any:
    """The module daqp.

    Raises:
        MissingExtraError: KS400.
    """
    try:
        import daqp
    except ImportError:
        raise missing_extra("daqp", "qp", "a quadratic program (method 'qp', priorities with limits, RateSolver)") from None
    return daqp


@dataclass(frozen=True, eq=False)
class Bounded:
    """min |A x - b|² + λ² |x - x0|² subject to lower <= C x <= upper.

    Attributes:
        A: (r, d), b: (r), x0: (d), C: (m, d), lower, upper: (m), damping: λ > 0, so that the answer is unique.
    """

    A: Array
    b: Array
    x0: Array
    C: Array
    lower: Array
    upper: Array
    damping: float

    def least_squares(self, rows: Sequence[int], sides: Array) -> Array:
        """The optimum with C x = the bound (`sides`: 1 upper, -1 lower) on some independent rows and no others."""
        d = self.A.shape[1]
        x, free = np.zeros(d), np.eye(d)
        if len(rows):
            chosen = list(rows)
            Q, R = np.linalg.qr(self.C[chosen].T, mode="complete")
            k = len(chosen)
            values = np.where(sides[chosen] > 0, self.upper[chosen], self.lower[chosen])
            x, free = Q[:, :k] @ np.linalg.solve(R[:k].T, values), Q[:, k:]
        if not free.shape[1]:
            return x
        U, sigma, Vt = np.linalg.svd(self.A @ free)
        k, square = len(sigma), self.damping**2
        wanted = square * (Vt @ (free.T @ self.x0))
        wanted[:k] += sigma * (U.T @ (self.b - self.A @ x))[:k]
        weights = np.full(free.shape[1], square)
        weights[:k] += sigma**2
        return x + free @ (Vt.T @ (wanted / weights))

    def violation(self, x: Array) -> Array:
        """(m) by how much a bound is exceeded, relative to its size; 0 inside."""
        y = self.C @ x
        size = np.abs(self.C) @ np.abs(x) + np.minimum(np.abs(self.lower), np.abs(self.upper)) + np.finfo(float).tiny
        size = np.where(np.isfinite(size), size, np.abs(y) + 1.0)
        return np.maximum(np.maximum(y - self.upper, self.lower - y), 0.0) / size

    def multipliers(self, x: Array, rows: Sequence[int], sides: Array) -> Array:
        """What each bound that is met holds back, positive where it rightly does; 0 for less than rounding."""
        residual = self.A @ x - self.b
        slope = self.A.T @ residual + self.damping**2 * (x - self.x0)
        size = np.abs(self.A.T) @ (np.abs(self.A) @ np.abs(x) + np.abs(self.b)) + self.damping**2 * np.abs(x - self.x0)
        found = -np.linalg.lstsq(self.C[list(rows)].T, slope, rcond=None)[0] * sides[list(rows)]
        largest = max(float(np.abs(self.C[list(rows)]).max()), np.finfo(float).tiny)
        rounding = _PROPER * float(size.max(initial=0.0)) / largest
        return np.where(np.abs(found) <= rounding, 0.0, found)

    def fixed(self) -> Array:
        """(m) rows whose two bounds are one."""
        least = np.minimum(np.abs(self.upper), np.abs(self.lower))
        return np.isfinite(least) & (self.upper - self.lower <= 4e-16 * np.where(np.isfinite(least), least, 0.0))


def solve(problem: Bounded, start: Array) -> Array:
    """The optimum (d), from a point inside the bounds (which it need not be near).

    Raises:
        MissingExtraError: KS400.
    """
    alone = problem.least_squares((), np.zeros(0))
    if np.all(problem.violation(alone) <= _FEASIBLE):
        return alone
    guess, flag = _daqp(problem)
    if flag > 0 and (found := _confirmed(problem, guess)) is not None:
        return found
    return _active_set(problem, np.array(start))


def _daqp(problem: Bounded) -> tuple[Array, int]:
    """DAQP's answer and flag, in coordinates in which the cost is |y - y*|²/2."""
    _, sigma, Vt = np.linalg.svd(problem.A)
    d = problem.A.shape[1]
    spread = np.zeros(d)
    spread[: len(sigma)] = sigma
    damping = max(problem.damping, _GUESS * float(spread.max(initial=0.0)))
    weights = np.sqrt(spread**2 + damping**2)
    back = Vt.T / weights
    wanted = back.T @ (problem.A.T @ problem.b + damping**2 * problem.x0)
    G = np.ascontiguousarray(problem.C @ back)
    lower, upper = np.maximum(problem.lower, -_INFINITE), np.minimum(problem.upper, _INFINITE)
    sense = np.where(problem.fixed(), _EQUALITY, 0).astype(np.intc)
    y, _, flag, _ = solver().solve(np.eye(d), -wanted, G, upper, lower, sense, primal_tol=1e-9)
    return back @ y, int(flag)


def _confirmed(problem: Bounded, guess: Array) -> Array | None:
    """The optimum on the bounds that a guess meets, if it is the optimum of the whole."""
    y = problem.C @ guess
    size = 1e-7 * (np.abs(problem.C) @ np.abs(guess) + np.finfo(float).tiny)
    sides = np.where(np.abs(y - problem.upper) <= size, 1, np.where(np.abs(y - problem.lower) <= size, -1, 0))
    fixed = problem.fixed()
    rows = _independent(problem.C, [*np.flatnonzero(fixed), *np.flatnonzero((sides != 0) & ~fixed)])
    for _ in range(len(rows) + 1):
        x = problem.least_squares(rows, sides)
        if np.any(problem.violation(x) > _FEASIBLE):
            return None
        if not rows:
            return x
        pressing = problem.multipliers(x, rows, sides)
        pressing[fixed[rows]] = 0.0
        if np.all(pressing >= 0.0):
            return x
        rows.pop(int(np.argmin(pressing)))  # met by chance: it does not hold anything back
    return None


def _independent(C: Array, rows: Sequence[Any]) -> list[int]:
    """Those of the rows, in their order, that are no combinations of rows before them."""
    found: list[int] = []
    basis = np.zeros((0, C.shape[1]))
    for row in rows:
        rest = C[row]
        for _ in range(2):
            rest = rest - (basis @ rest) @ basis
        size = float(np.linalg.norm(rest))
        if size > _FOLLOWS * float(np.linalg.norm(C[row])):
            found.append(int(row))
            basis = np.vstack([basis, rest / size])
    return found


def _active_set(problem: Bounded, x: Array) -> Array:
    """The primal active-set method from a feasible point; ends at the optimum, or at the best found in many steps."""
    sides, rows = np.zeros(len(problem.lower)), _independent(problem.C, list(np.flatnonzero(problem.fixed())))
    sides[rows] = 1
    for _ in range(20 * (len(problem.lower) + len(x) + 1)):
        target = problem.least_squares(rows, sides)
        entering, step = _first_met(problem, x, target - x, rows)
        if entering is not None:
            sides[entering] = np.sign(problem.C[entering] @ (target - x))
            x = x + step * (target - x)
            rows.append(entering)
            continue
        x = target
        if not rows:
            break
        pressing = problem.multipliers(x, rows, sides)
        pressing[problem.fixed()[rows]] = 0.0
        if np.all(pressing >= 0.0):
            break
        rows.pop(int(np.argmin(pressing)))
    return x


def _first_met(problem: Bounded, x: Array, step: Array, rows: list[int]) -> tuple[int | None, float]:
    """The bound met first on the way, and at which share of the step; (None, 1) when there is none."""
    slope, y = problem.C @ step, problem.C @ x
    rest = np.where(slope > 0, problem.upper - y, y - problem.lower)
    ahead = np.abs(slope) > 1e-13 * (np.abs(problem.C) @ np.abs(step))
    ahead[rows] = False
    if rows:  # a bound that follows from those that are met is not met on the way; its slope is rounding
        Q = np.linalg.qr(problem.C[rows].T)[0]
        beside = np.linalg.norm(problem.C - (problem.C @ Q) @ Q.T, axis=1)
        ahead &= beside > _FOLLOWS * np.linalg.norm(problem.C, axis=1)
    shares = np.where(ahead, np.maximum(rest, 0.0) / np.where(ahead, np.abs(slope), 1.0), np.inf)
    if not len(shares) or float(shares.min()) >= 1.0:
        return None, 1.0
    first = int(np.argmin(shares))
    return first, float(shares[first])


def in_strict_order(
    levels: Sequence[tuple[Array, Array]], C: Array, lower: Array, upper: Array, start: Array | None, tolerance: float
) -> Array | None:
    """Levels of least squares A_k x ~ b_k, none of which may spoil those before, inside lower <= C x <= upper.

    Args:
        levels: (A_k, b_k), the most important first.
        start: (d) a point inside the bounds, or None where none is known.
        tolerance: singular values below this fraction of a level's largest count as zero.

    Returns:
        (d), or None where no x is inside the bounds.

    Law: level k is solved in x + N z, with N spanning what leaves A_1 x ... A_(k-1) x as they are. Its optimum A_k x is
    unique, since the bounds are convex, so that keeping it is keeping the optimum. Source: Kanoun, Lamiraux, Wieber,
    IEEE Trans. Robotics 27(4), 2011; Escande, Mansard, Wieber, IJRR 33(7), 2014.
    """
    free = np.eye(C.shape[1])
    x = _point_inside(C, lower, upper) if start is None else np.array(start)
    if x is None:
        return None
    for A, b in levels:
        A_free, C_free = A @ free, C @ free
        size = float(np.linalg.norm(A, 2)) if A.size else 0.0
        kept = np.linalg.norm(C_free, axis=1) > 1e-12 * np.linalg.norm(C, axis=1)
        y = C @ x
        shifted = (np.minimum((lower - y)[kept], 0.0), np.maximum((upper - y)[kept], 0.0))
        zero = np.zeros(free.shape[1])
        problem = Bounded(A_free, b - A @ x, zero, C_free[kept], *shifted, damping=least_damping(A_free, size))
        x = x + free @ _undamped(problem, zero)
        _, sigma, Vt = np.linalg.svd(A_free)
        free = free @ Vt[int(np.sum(sigma > tolerance * size)) :].T
        if not free.shape[1]:
            break
    return x


def _undamped(problem: Bounded, start: Array) -> Array:
    """What the damping only decides between equals for: damped again towards the last answer, until nothing is gained.

    Source: Rockafellar, "Monotone operators and the proximal point algorithm", SIAM J. Control 14(5), 1976.
    """
    x = solve(problem, start)
    for _ in range(_PASSES):
        nearer = solve(replace(problem, x0=x), x)
        gained = float(np.linalg.norm(problem.A @ (nearer - x)))
        x = nearer
        if gained <= _GAIN * (float(np.linalg.norm(problem.b)) + problem.damping * float(np.linalg.norm(x))):
            break
    return x


def _point_inside(C: Array, lower: Array, upper: Array) -> Array | None:
    """The smallest x with lower <= C x <= upper, or None: a program without small numbers, which DAQP is trusted with."""
    d = C.shape[1]
    problem = Bounded(np.zeros((0, d)), np.zeros(0), np.zeros(d), C, lower, upper, 1.0)
    guess, flag = _daqp(problem)
    return None if flag == -1 else solve(problem, guess)


def least_damping(A: Array, size: float | None = None) -> float:
    """A damping that only decides between equals: 1e-6 of the largest singular value, which costs (1e-6 σ_max/σ)²."""
    largest = float(np.linalg.norm(A, 2)) if A.size and size is None else size or 0.0
    return 1e-6 * largest if largest > 0 else 1.0
