"""Judges of singular sets: NumPy's determinants and minima of the least singular value, which read no formula, and shortest
ways to the zeros of a component's equations, from many starts. All of them take many postures at once.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

import kinestatics as ks
from kinestatics.singular_sets.components import Component, spectrum
from kinestatics.singular_sets.singular_set import SingularSet
from kinestatics.spatial import ANGULAR, LINEAR

Array = np.ndarray[Any, Any]
SINGULAR = 1e-10  # σ_min in shares of the largest: polished
ON = 1e-11  # of an equation's amplitude: on a component
_DESCENT, _POLISH, _TRIES = 25, 60, 40
_ONTO, _EARLY, _LATE, _NEWTON, _KEPT = 12, 20, 50, 12, 12


@dataclass
class Found:
    """What the judges say of one robot.

    Attributes:
        determinant: largest difference from NumPy's, in shares of the largest value; None where J is not square.
        formula: the same for the file's formula.
        points: of components, and nearest ones; unsound: those where rank is kept.
        worst: the largest relative singular value of component points that should be zero.
        minima: polished minima of σ_min; missed: those further than 1e-6 from every component; apart: the furthest.
        longer: distances of ours that are longer than the shortest way found; shorter: shorter ones (the judge's fault).
        over: lower bounds above it; unfound: components without a distance; gap: the largest difference.
        asked: how many distances; seconds: CPU time of one distance call (all components).
    """

    determinant: float | None = None
    formula: float | None = None
    points: int = 0
    unsound: int = 0
    worst: float = 0.0
    minima: int = 0
    missed: int = 0
    apart: float = 0.0
    asked: int = 0
    longer: int = 0
    shorter: int = 0
    over: int = 0
    unfound: int = 0
    gap: float = 0.0
    seconds: float = 0.0


def values_at(expression: Any, n: int, q: Array, lengths: dict[str, float]) -> Array:
    """(k) an expression of the joints q1 ... and of lengths."""
    by_name = {str(s): s for s in expression.free_symbols}
    names = [*(f"q{k + 1}" for k in range(n)), *lengths]
    function = sympy.lambdify([by_name.get(name, sympy.Symbol(name)) for name in names], expression, "numpy")
    return np.broadcast_to(function(*q.T, *lengths.values()), len(q))


def rows_and_slopes(arm: ks.RobotModel, q: Array, rows: list[int]) -> tuple[Array, Array]:
    """(k, r, n) rows of the Jacobian and (k, r, n, n) their derivatives: ∂J_i/∂q_j = ω_min × v_max, ω_j × ω_i for j < i."""
    J = ks.jacobian(arm, q, check_finite=False).array
    v, w = np.swapaxes(J[:, LINEAR], 1, 2), np.swapaxes(J[:, ANGULAR], 1, 2)
    H = np.zeros((*J.shape, arm.n))
    for i, j in itertools.product(range(arm.n), repeat=2):
        H[:, LINEAR, i, j] = np.cross(w[:, min(i, j)], v[:, max(i, j)])
        if j < i:
            H[:, ANGULAR, i, j] = np.cross(w[:, j], w[:, i])
    return J[:, rows], H[:, rows]


def singular_postures(found: SingularSet, count: int, seed: int) -> Array:
    """(count, n) postures where rank is lost: Newton steps on σ_min = 0, then on Jᵀw = 0, |w| = 1, from random postures."""
    arm, task = found.model, found.task
    rows, kept, rng = list(task.rows), [], np.random.default_rng(seed)
    for _ in range(_TRIES):
        q = found.space.random(count, int(rng.integers(1 << 31)))
        for _ in range(_DESCENT):
            J, H = rows_and_slopes(arm, q, rows)
            U, sigma, Vt = np.linalg.svd(J)
            last = task.rank - 1
            g = np.einsum("kr,krij,ki->kj", U[:, :, last], H, Vt[:, last])
            step = -(sigma[:, last] / np.maximum((g * g).sum(-1), 1e-12))[:, None] * g
            q = q + step * np.minimum(1.0, 0.2 / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-30))
        w = np.linalg.svd(rows_and_slopes(arm, q, rows)[0])[0][:, :, task.rank - 1]
        for _ in range(_POLISH):
            q, w = _polished(*rows_and_slopes(arm, q, rows), q, w)
        good = spectrum(arm, q, task, found.link)[:, task.rank - 1] <= SINGULAR
        kept.append(q[good])
        if sum(map(len, kept)) >= count:
            break
    return np.concatenate(kept)[:count]


def _polished(J: Array, H: Array, q: Array, w: Array) -> tuple[Array, Array]:
    """A damped Gauss-Newton step on Jᵀw = 0, (|w|² - 1) / 2 = 0."""
    count, r, n = J.shape
    residual = np.concatenate([np.einsum("kri,kr->ki", J, w), ((w * w).sum(-1, keepdims=True) - 1) / 2], 1)
    A = np.zeros((count, n + 1, n + r))
    A[:, :n, :n], A[:, :n, n:], A[:, n, n:] = np.einsum("kr,krij->kij", w, H), np.swapaxes(J, 1, 2), w
    U, sigma, Vt = np.linalg.svd(A, full_matrices=False)
    damping = 1e-3 * (residual * residual).sum(-1, keepdims=True) + 1e-28
    inverse = sigma / (sigma**2 + damping)
    step = -np.einsum("kij,ki->kj", Vt, inverse * np.einsum("kij,ki->kj", U, residual))
    step *= np.minimum(1.0, 0.3 / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-30))
    return q + step[:, :n], w + step[:, n:]


def apart_from(component: Component, q: Array) -> Array:
    """(k) how far postures are from the point of a component that Newton steps lead to; infinite where they do not."""
    moved, _ = component.projected(q, wrap=False)
    apart = np.linalg.norm(moved - q, axis=-1)
    return np.where(np.abs(component.residuals(moved)[0]).max(-1) <= ON, apart, np.inf)


def shortest(component: Component, q: Array, starts: int, seed: int) -> Array:
    """(k) the shortest way from postures (k, n) to a component, from `starts` postures around each."""
    best = np.full(len(q), np.inf)
    n, rng = q.shape[1], np.random.default_rng(seed)
    spread = np.zeros((len(q), starts, n))
    columns = list(component.columns)
    sizes = np.geomspace(0.02, 3.0, starts)[:, None]
    spread[:, :, columns] = rng.normal(size=(len(q), starts, len(columns))) * sizes
    for functions in itertools.product(*(equation.functions for equation in component.equations)):
        way = _Ways(functions)
        goal = np.repeat(q, starts, 0)
        x = way.onto(goal + spread.reshape(-1, n), _ONTO)
        for steps, kept in ((_EARLY, starts // 3), (_LATE, _KEPT)):
            x = way.along(x, goal, steps)
            lengths = way.lengths(x, goal).reshape(len(q), -1)
            nearest = np.argsort(lengths, 1)[:, :kept]
            x = np.take_along_axis(x.reshape(*lengths.shape, n), nearest[:, :, None], 1).reshape(-1, n)
            goal = np.repeat(q, nearest.shape[1], 0)
        for ends in (x, way.polished(x, goal)):
            best = np.minimum(best, way.lengths(ends, goal).reshape(len(q), -1).min(1))
    return best


def pulled_back(G: Array, r: Array) -> Array:
    """(k, n) the shortest steps with G step = r."""
    inner = G @ np.swapaxes(G, 1, 2)
    if G.shape[1] == 1:
        weights = r / np.maximum(inner[:, 0], 1e-18)
    else:
        trace = np.trace(inner, axis1=1, axis2=2)[:, None, None]
        weights = np.linalg.solve(inner + (1e-12 * trace + 1e-18) * np.eye(G.shape[1]), r[:, :, None])[:, :, 0]
    return np.einsum("kij,ki->kj", G, weights)


class _Ways:
    """Postures moved on the zero set of functions."""

    def __init__(self, functions: tuple[Any, ...]) -> None:
        self.functions = functions

    def values(self, x: Array) -> Array:
        return np.stack([f.value(x) / f.scale for f in self.functions], -1)

    def slopes(self, x: Array) -> Array:
        return np.stack([f.gradient(x) / f.scale for f in self.functions], -2)

    def lengths(self, x: Array, goal: Array) -> Array:
        on = np.abs(self.values(x)).max(-1) <= ON
        return np.where(on, np.linalg.norm(x - goal, axis=-1), np.inf)

    def onto(self, x: Array, steps: int) -> Array:
        for _ in range(steps):
            step = -pulled_back(self.slopes(x), self.values(x))
            x = x + step * np.minimum(1.0, 1.0 / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-30))
        return x

    def along(self, x: Array, goal: Array, steps: int) -> Array:
        """Down the distance along the set, back onto it after each step."""
        share = np.full(len(x), 0.7)
        for _ in range(steps):
            G = self.slopes(x)
            step = goal - x - pulled_back(G, np.einsum("kij,kj->ki", G, goal - x))
            trial = self.onto(x + share[:, None] * step, 2)
            good = np.abs(self.values(trial)).max(-1) <= 1e-6
            good &= np.linalg.norm(trial - goal, axis=-1) < np.linalg.norm(x - goal, axis=-1)
            x = np.where(good[:, None], trial, x)
            share = np.where(good, np.minimum(1.0, 1.3 * share), 0.5 * share)
        return self.onto(x, 4)

    def polished(self, x: Array, goal: Array) -> Array:
        """Newton steps on x - q + Gᵀλ = 0, f = 0."""
        n, m = x.shape[1], len(self.functions)
        G = self.slopes(x)
        multiplier = np.einsum("kji,kj->ki", np.linalg.pinv(G, rcond=1e-12), goal - x)
        for _ in range(_NEWTON):
            G = self.slopes(x)
            bent = sum(multiplier[:, k, None, None] * f.hessian(x) / f.scale for k, f in enumerate(self.functions))
            M = np.zeros((len(x), n + m, n + m))
            M[:, :n, :n], M[:, :n, n:], M[:, n:, :n] = np.eye(n) + bent, np.swapaxes(G, 1, 2), G
            right = np.concatenate([goal - x - np.einsum("kei,ke->ki", G, multiplier), -self.values(x)], 1)
            step = np.einsum("kij,kj->ki", np.linalg.pinv(M, rcond=1e-13), right)
            step *= np.minimum(1.0, 0.3 / np.maximum(np.linalg.norm(step[:, :n], axis=-1, keepdims=True), 1e-30))
            x, multiplier = x + step[:, :n], multiplier + step[:, n:]
        return self.onto(x, 2)


def judge_points(result: Found, found: SingularSet, count: int, seed: int) -> None:
    """Soundness: `count` postures moved onto every component lose rank."""
    for component in found.components:
        q, solved = component.projected(found.space.random(count, seed))
        q = np.concatenate([component.points, q[solved]])
        lost = spectrum(found.model, q, found.task, found.link)[:, found.task.rank - 1]
        result.points += len(q)
        result.unsound += int((lost > 1e-9).sum())
        result.worst = max(result.worst, float(lost.max(initial=0.0)))


def judge_minima(result: Found, found: SingularSet, count: int, seed: int) -> Array:
    """Completeness: minima of σ_min lie on components; those that do not are handed back."""
    q = singular_postures(found, count, seed)
    if not len(q):
        return q
    apart = np.min([apart_from(c, q) for c in found.components], axis=0) if found.components else np.full(len(q), np.inf)
    result.minima += len(q)
    result.missed += int((apart > 1e-6).sum())
    result.apart = max(result.apart, float(apart.max()))
    return q[apart > 1e-6]


def judge_distances(result: Found, found: SingularSet, count: int, starts: int, seed: int) -> list[tuple[Any, ...]]:
    """Distances and their bounds; where they differ from the shortest way: (component, q, ours, bound, shortest)."""
    import time

    q, wrong = found.space.random(count, seed), []
    began = time.process_time()
    ours = [{id(d.component): d for d in found.distance(posture)} for posture in q]
    result.seconds = (time.process_time() - began) / count
    for component in found.components:
        if component.others:
            continue
        nearest = [d[id(component)].nearest for d in ours if d[id(component)].nearest is not None]
        if nearest:
            lost = spectrum(found.model, np.array(nearest), found.task, found.link)[:, found.task.rank - 1]
            result.points += len(nearest)
            result.unsound += int((lost > 1e-9).sum())
        for posture, known, best in zip(q, ours, shortest(component, q, starts, seed), strict=True):
            d = known[id(component)]
            gap = d.value - best if np.isfinite(d.value) else np.inf
            result.asked += 1
            result.unfound += int(not np.isfinite(d.value))
            result.longer += int(gap > 1e-6)
            result.shorter += int(gap < -1e-6)
            result.over += int(d.at_least > min(best, d.value) + 1e-12)
            result.gap = max(result.gap, float(abs(gap)))
            if abs(gap) > 1e-6 or d.at_least > best + 1e-12:
                wrong.append((component.label, posture, d.value, d.at_least, best))
    return wrong
