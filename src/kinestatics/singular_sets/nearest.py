"""The nearest posture of a component, anywhere or inside the joint limits, and a bound that none is nearer."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..namespaces import Array
from .components import Component
from .distance import SLACK, Distance, free_radius

_EDGE = 1e-10  # [rad or m] a joint's solution this little beyond a limit is at the limit
_SAME = 1e-9
_STARTS, _FEWEST = 96, 24  # for all choices of the joints whose own equations hold, and for each of these
_ARRIVE, _WALK, _RETURN, _POLISH = 20, 30, 3, 12
_KEPT = 16  # walks that are polished
_PASSES = 8
_ON, _NEARLY = 1e-11, 1e-7
_LONGEST = 1.0  # step towards the component
_REGULAR = 1e-13


def nearest_posture(component: Component, q: Array, within_limits: bool, seed: int = 0) -> Distance:
    """The distance of one posture (n) from a component, or from what of it lies inside the joint limits.

    Law: the nearest point x satisfies f(x) = 0 and x = clip(q - Gᵀλ), G the gradients of the equations: a joint stands at a
    limit exactly where it would go beyond. One joint's equations are solved exactly; others from many starts, each walked
    along the component inside the limits and polished by Newton steps that hold and release joints by that law.
    """
    limits = _limits_of(component, within_limits)
    settled = _settled(component, limits, q)
    if not all(map(len, settled.values())):
        return Distance(component, float("inf"), None, float("inf"), within_limits)
    coupled = replace(component, equations=tuple(e for e in component.equations if e.solutions is None))
    nearest = np.clip(q, limits.lower, limits.upper)
    for j, values in settled.items():
        nearest[j] = values[0]
    if not coupled.equations and not coupled.others:
        value = float(np.linalg.norm(nearest - q))
        return Distance(component, value, nearest, value * (1.0 - SLACK), within_limits)
    at_least = _bound(coupled, nearest - q, q)
    boxes = _boxes(coupled, limits, settled, nearest)
    found = (_shortest(box, _starts(component, box, limits, q, len(boxes), seed), q) for box in boxes)
    best = min((x for x in found if x is not None), key=lambda x: float(np.linalg.norm(x - q)), default=None)
    value = float("inf") if best is None else float(np.linalg.norm(best - q))
    return Distance(component, value, best, at_least, within_limits)


def _limits_of(component: Component, within_limits: bool) -> _Limits:
    """The joint limits of the robot, or none."""
    model, turns = component.space.model, np.array(component.space.half.ring.turns)
    if within_limits:
        return _Limits(model.lower, model.upper, turns)
    return _Limits(np.full(len(turns), -np.inf), np.full(len(turns), np.inf), turns)


@dataclass(frozen=True, eq=False)
class _Limits:
    """(n) limits of the joints, infinite where there are none, and which of them turn."""

    lower: Array
    upper: Array
    turns: Array

    def turned(self, j: int, value: float, q: float) -> float | None:
        """The same place of a joint after whole turns, as near to q as the limits let it; None where none is inside."""
        lower, upper = float(self.lower[j]), float(self.upper[j])
        if self.turns[j]:
            fewest, most = (lower - _EDGE - value) / math.tau, (upper + _EDGE - value) / math.tau
            turns = round((q - value) / math.tau)
            turns = math.ceil(fewest) if turns < fewest else math.floor(most) if turns > most else turns
            value += math.tau * turns
        return min(max(value, lower), upper) if lower - _EDGE <= value <= upper + _EDGE else None

    def window(self, q: Array) -> tuple[Array, Array]:
        """(n) ends of a whole turn or less inside the limits, as near to q as can be: where the nearest postures are."""
        span = self.upper - self.lower
        half = np.where(self.turns, np.pi, np.where(np.isfinite(span), span, 1.0))
        low = np.maximum(self.lower, np.minimum(self.upper, q + half) - 2 * half)
        return low, np.minimum(self.upper, low + 2 * half)


def _settled(component: Component, limits: _Limits, q: Array) -> dict[int, list[float]]:
    """By column, the values inside the limits at which the equations of that joint alone hold, the nearest first."""
    found: dict[int, list[float]] = {}
    for equation in component.equations:
        if equation.solutions is None:
            continue
        j = equation.columns[0]
        if j in found:
            found[j] = [x for x in found[j] if any(_same(x - y, limits.turns[j]) for y in equation.solutions)]
        else:
            turned = (limits.turned(j, value, float(q[j])) for value in equation.solutions)
            found[j] = sorted((x for x in turned if x is not None), key=lambda x: abs(x - q[j]))
    return found


def _same(apart: float, turns: bool) -> bool:
    """Whether two places of a joint are one, but for whole turns."""
    return abs(math.remainder(apart, math.tau) if turns else apart) <= _SAME


def _bound(coupled: Component, needed: Array, q: Array) -> float:
    """No posture is nearer: joints go at least as far as needed (n), and those of an equation together its free radius."""
    needed = needed * (1.0 - SLACK)
    lengths = [float(np.linalg.norm(needed))]
    for equation in coupled.equations:
        own = np.isin(np.arange(len(q)), equation.columns)
        radius = max(min(free_radius(f, q) for f in equation.functions), float(np.linalg.norm(needed[own])))
        lengths.append(float(np.hypot(radius, np.linalg.norm(needed[~own]))))
    return max(lengths)


@dataclass(frozen=True, eq=False)
class _Box:
    """Postures between two corners (n), equal for joints that are settled, and equations of several joints to hold there."""

    component: Component
    lower: Array
    upper: Array

    def on_tangent(self, x: Array, target: Array) -> Array:
        """(k, n) the points nearest to a target among those in the box at which the equations, made linear at x, hold.

        Joints are held at a limit where they would go beyond, and released where not; in later passes only held.
        """
        values, slopes = self.component.residuals(x)
        size = _REGULAR * np.einsum("kei,kei->k", slopes, slopes) + 1e-300
        small = size[:, None, None] * np.eye(values.shape[1])
        moved, held, place = target, np.zeros(x.shape, dtype=bool), target
        for k in range(_PASSES):
            beyond = (moved < self.lower) | (moved > self.upper) | (self.lower == self.upper)
            before, held = held, beyond | held if k >= _PASSES // 2 else beyond
            if k and np.array_equal(held, before):
                break
            place = np.where(beyond, np.clip(moved, self.lower, self.upper), place)
            free = np.where(held[:, None], 0.0, slopes)
            start = np.where(held, place, target)
            right = values + np.einsum("kei,ki->ke", slopes, start - x)
            multipliers = np.linalg.solve(free @ np.swapaxes(free, 1, 2) + small, right[..., None])[..., 0]
            moved = target - np.einsum("kei,ke->ki", slopes, multipliers)
        return np.clip(np.where(held, place, moved), self.lower, self.upper)

    def arrived(self, x: Array, steps: int) -> Array:
        """Gauss-Newton steps towards the component."""
        for _ in range(steps):
            step = self.on_tangent(x, x) - x
            x = x + step * _at_most(step, _LONGEST)
        return x

    def off(self, x: Array) -> Array:
        """(k) how far from zero the equations are."""
        return np.asarray(np.abs(self.component.residuals(x)[0]).max(-1))

    def walked(self, x: Array, q: Array) -> Array:
        """Points moved along the component towards q, back onto it after every step; only nearer ones are taken."""
        reach, length = np.full(len(x), 0.5), np.linalg.norm(x - q, axis=-1)
        for _ in range(_WALK):
            step = self.on_tangent(x, np.broadcast_to(q, x.shape)) - x
            trial = self.arrived(x + step * _at_most(step, reach[:, None]), _RETURN)
            tried = np.linalg.norm(trial - q, axis=-1)
            nearer = (self.off(trial) <= _NEARLY) & (tried < length)
            x, length = np.where(nearer[:, None], trial, x), np.where(nearer, tried, length)
            reach = np.where(nearer, 1.5 * reach, 0.4 * np.minimum(reach, np.linalg.norm(step, axis=-1)))
        return x

    def polished(self, x: Array, q: Array) -> Array:
        """Newton steps for f = 0 and x = clip(q - Gᵀλ)."""
        n = x.shape[1]
        multipliers = None
        for _ in range(_POLISH):
            values, slopes = self.component.residuals(x)
            e = values.shape[1]
            if multipliers is None:
                free = (x > self.lower) & (x < self.upper)
                inverse = np.linalg.pinv(np.where(free[:, None], slopes, 0.0), rcond=1e-9)
                multipliers = np.einsum("kie,ki->ke", inverse, q - x)
            moved = q - np.einsum("kei,ke->ki", slopes, multipliers)
            held = (moved < self.lower) | (moved > self.upper) | (self.lower == self.upper)
            matrix = np.zeros((len(x), n + e, n + e))
            matrix[:, :n, :n] = np.eye(n) + np.einsum("ke,keij->kij", multipliers, self.component.curvatures(x))
            matrix[:, :n, n:], matrix[:, n:, :n] = np.swapaxes(slopes, 1, 2), slopes
            matrix[:, :n] = np.where(held[..., None], np.eye(n, n + e), matrix[:, :n])
            goal = np.where(held, np.clip(moved, self.lower, self.upper), moved)
            right = np.concatenate([goal - x, -values], axis=1)
            step = np.einsum("kij,kj->ki", np.linalg.pinv(matrix, rcond=1e-13), right)
            share = _at_most(step[:, :n], 0.2)
            x = np.clip(x + share * step[:, :n], self.lower, self.upper)
            multipliers = multipliers + share * step[:, n:]
        return self.arrived(x, 2)


def _at_most(step: Array, longest: float | Array) -> Array:
    """(k, 1) the share of a step that is no longer than that."""
    return np.minimum(1.0, longest / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-300))


def _boxes(coupled: Component, limits: _Limits, settled: Mapping[int, list[float]], nearest: Array) -> list[_Box]:
    """A box for each choice of settled joints that other equations depend on; the rest stand where they are nearest."""
    equations = [*coupled.equations, *itertools.chain.from_iterable(coupled.others)]
    moving = {j for equation in equations for j in equation.columns}
    shared = [j for j in settled if j in moving]
    lower, upper = nearest.copy(), nearest.copy()
    open_joints = sorted(moving - set(shared))
    lower[open_joints], upper[open_joints] = limits.lower[open_joints], limits.upper[open_joints]
    boxes = []
    for choice in itertools.product(*(settled[j] for j in shared)):
        lower[shared] = upper[shared] = choice
        boxes.append(_Box(coupled, lower.copy(), upper.copy()))
    return boxes


def _starts(component: Component, box: _Box, limits: _Limits, q: Array, shares: int, seed: int) -> Array:
    """(k, n) the posture itself, points of the component, postures around it at all distances, and any, all in the box."""
    rng, count = np.random.default_rng(seed), max(_FEWEST, _STARTS // shares)
    low, high = limits.window(q)
    points = component.points[: count // 4]
    points = np.where(limits.turns, low + np.mod(points - low, 2 * np.pi), points)
    around = q + rng.normal(size=(count // 4, len(q))) * np.geomspace(0.05, 2.0, count // 4)[:, None]
    anywhere = rng.uniform(low, high, (count // 2, len(q)))
    return np.clip(np.concatenate([q[None], points, around, anywhere]), box.lower, box.upper)


def _shortest(box: _Box, starts: Array, q: Array) -> Array | None:
    """(n) the posture of the box on the component that is nearest to q, of those found; None where none was."""
    x = box.arrived(starts, _ARRIVE)
    x = x[box.off(x) <= _NEARLY]
    if not len(x):
        return None
    x = box.walked(x, q)
    x = x[np.linalg.norm(x - q, axis=-1).argsort(kind="stable")][:_KEPT]
    x = np.concatenate([box.arrived(x, 2), box.polished(x, q)])
    x = x[box.off(x) <= _ON]
    return x[np.linalg.norm(x - q, axis=-1).argmin()] if len(x) else None
