"""How far a posture is from a component of the singular set, in joint space: the nearest posture of it, and a bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..quantities import format_number
from ..symbolic.functions import WaveFunction
from .components import Component

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


def free_radius(f: WaveFunction, q: Array) -> float:
    """The r with |f| - |∇f| r - ‖H‖ r²/2 = 0, H a bound of the second derivatives: f does not vanish nearer than that."""
    if f.slides:
        return 0.0
    value = abs(float(f.value(q))) - 1e-13 * f.scale
    slope, bend = float(np.linalg.norm(f.gradient(q))), float(np.linalg.norm(f.hessian_bound, 2))
    if value <= 0 or slope + bend == 0:
        return 0.0
    return (1.0 - SLACK) * 2.0 * value / (slope + np.sqrt(slope * slope + 2.0 * bend * value))
