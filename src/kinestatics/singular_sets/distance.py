"""How far a posture is from a component of the singular set, in joint space: the nearest posture of it, and a bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..quantities import format_number
from ..symbolic.functions import WaveFunction
from .components import Component
from .equations import Equation

_STARTS, _WALK, _NEWTON = 64, 80, 12
SLACK = 1e-9  # the bound is kept this much below what floats say, relative


@dataclass(frozen=True, eq=False)
class Distance:
    """The distance of a posture from one component, or from what of it lies inside the joint limits.

    Attributes:
        component: the component.
        value: √Σ(q - nearest)², the shortest found [rad, and m where joints slide]; infinite where no point was found.
        nearest: (n) the singular posture there; None where no point was found.
        at_least: no point is nearer than this: proved from bounds of derivatives, to rounding. Infinite where none is
            inside the limits.
        inside: whether it is of points inside the joint limits, and not of all.
    """

    component: Component
    value: float
    nearest: Array | None
    at_least: float
    inside: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        nearest = None if self.nearest is None else self.nearest.tolist()
        value, at_least = (x if np.isfinite(x) else None for x in (self.value, self.at_least))
        return {
            "name": self.component.name, "value": value, "nearest": nearest, "at_least": at_least, "inside": self.inside,
        }  # fmt: skip

    def __str__(self) -> str:
        name, unit = self.component.label, "rad" if all(self.component.space.half.ring.turns) else "rad, m"
        degrees = f" ({format_number(np.degrees(self.value))}°)" if unit == "rad" else ""
        where = " inside the joint limits" if self.inside else ""
        if not np.isfinite(self.value):
            return f"{name}: no posture {'was found' if np.isfinite(self.at_least) else 'is'}{where}"
        text = f"{name}: {format_number(self.value)} {unit}{degrees}{where}, at least {format_number(self.at_least)}"
        return text + (", outside the joint limits" if not self.inside and self.component.within_limits is False else "")


def distance_to(component: Component, q: Array, seed: int = 0) -> Distance:
    """The distance of one posture (n) from a component.

    Law: the nearest point x satisfies f(x) = 0 and q - x = Gᵀ λ, G the gradients of the equations (Lagrange). One joint's
    equations are solved exactly; others from many starts, each walked along the component and polished by Newton steps.
    """
    single = [equation for equation in component.equations if equation.solutions is not None]
    if len(single) == len(component.equations) and len({e.columns for e in single}) == len(single) and not component.others:
        nearest = q.copy()
        for equation in single:
            nearest[equation.columns[0]] = _closest(equation, q)
        value = float(np.linalg.norm(nearest - q))
        return Distance(component, value, nearest, value * (1.0 - SLACK))
    at_least = lower_bound(component, q)
    starts = np.concatenate([q[None], component.points, q + _spread(component, q, seed)])
    x, solved = component.projected(starts, wrap=False)
    x = _nearest_turn(component, x[solved], q)
    if not len(x):
        return Distance(component, float("inf"), None, at_least)
    x = _polished(component, _walked(component, x, q), q)
    lengths = np.linalg.norm(x - q, axis=-1)
    lengths[np.abs(component.residuals(x)[0]).max(-1) > 1e-11] = np.inf
    best = int(lengths.argmin())
    if not np.isfinite(lengths[best]):
        return Distance(component, float("inf"), None, at_least)
    return Distance(component, float(lengths[best]), x[best], at_least)


def lower_bound(component: Component, q: Array) -> float:
    """A radius around q in which an equation of the component certainly does not vanish."""
    radii = [0.0]
    for equation in component.equations:
        if equation.solutions is not None:
            radii.append(abs(_closest(equation, q) - q[equation.columns[0]]) * (1.0 - SLACK))
        else:
            radii.append(min(free_radius(f, q) for f in equation.functions))
    return max(radii)


def free_radius(f: WaveFunction, q: Array) -> float:
    """The r with |f| - |∇f| r - ‖H‖ r²/2 = 0, H a bound of the second derivatives: f does not vanish nearer than that."""
    if f.slides:
        return 0.0
    value = abs(float(f.value(q))) - 1e-13 * f.scale
    slope, bend = float(np.linalg.norm(f.gradient(q))), float(np.linalg.norm(f.hessian_bound, 2))
    if value <= 0 or slope + bend == 0:
        return 0.0
    return (1.0 - SLACK) * 2.0 * value / (slope + np.sqrt(slope * slope + 2.0 * bend * value))


def _closest(equation: Equation, q: Array) -> float:
    """The value nearest to where the joint is at which its equation holds."""
    j = equation.columns[0]
    values = np.array(equation.solutions)
    if equation.space.half.ring.turns[j]:
        values = values + 2 * np.pi * np.round((q[j] - values) / (2 * np.pi))
    return float(values[np.abs(values - q[j]).argmin()])


def _spread(component: Component, q: Array, seed: int) -> Array:
    """Steps of all sizes in the joints that matter."""
    rng = np.random.default_rng(seed)
    steps = np.zeros((_STARTS, len(q)))
    columns = list(component.columns)
    steps[:, columns] = rng.normal(size=(_STARTS, len(columns))) * np.geomspace(0.02, 2.0, _STARTS)[:, None]
    return steps


def _nearest_turn(component: Component, x: Array, q: Array) -> Array:
    """The same postures with whole turns taken off, as near to q as can be."""
    turns = np.array(component.space.half.ring.turns, dtype=bool)
    return np.where(turns, x - 2 * np.pi * np.round((x - q) / (2 * np.pi)), x)


def _walked(component: Component, x: Array, q: Array) -> Array:
    """Points moved along the component towards q, back onto it after every step; only steps that come nearer are taken."""
    share = np.full(len(x), 1.0)
    for _ in range(_WALK):
        _, slopes = component.residuals(x)
        inverse = np.linalg.pinv(slopes, rcond=1e-9)
        towards = q - x
        along = towards - np.einsum("kij,kj->ki", inverse, np.einsum("kij,kj->ki", slopes, towards))
        trial = x + share[:, None] * along
        for _ in range(4):
            values, slopes = component.residuals(trial)
            trial = trial - np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=1e-9), values)
        on = np.abs(component.residuals(trial)[0]).max(-1) <= 1e-7
        nearer = on & (np.linalg.norm(trial - q, axis=-1) < np.linalg.norm(x - q, axis=-1))
        x = np.where(nearer[:, None], trial, x)
        share = np.where(nearer, np.minimum(1.0, 1.5 * share), 0.5 * share)
    return x


def _polished(component: Component, x: Array, q: Array) -> Array:
    """Newton steps for f = 0 and q - x = Gᵀλ."""
    n = x.shape[1]
    for _ in range(_NEWTON):
        values, slopes = component.residuals(x)
        e = values.shape[1]
        multipliers = np.einsum("kji,kj->ki", np.linalg.pinv(slopes, rcond=1e-9), q - x)
        curved = np.einsum("ke,keij->kij", multipliers, component.curvatures(x))
        matrix = np.zeros((len(x), n + e, n + e))
        matrix[:, :n, :n] = np.eye(n) + curved
        matrix[:, :n, n:], matrix[:, n:, :n] = np.swapaxes(slopes, 1, 2), slopes
        right = np.concatenate([q - x - np.einsum("kei,ke->ki", slopes, multipliers), -values], axis=1)
        step = np.einsum("kij,kj->ki", np.linalg.pinv(matrix, rcond=1e-12), right)[:, :n]
        size = np.linalg.norm(step, axis=-1, keepdims=True)
        x = x + step * np.minimum(1.0, 0.2 / np.maximum(size, 1e-30))
    return x
