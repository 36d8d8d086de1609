"""Twists and wrenches as a person would name them: along which axis, about which line, with what pitch. Floor 4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .namespaces import Array
from .quantities import format_number
from .spatial import ANGULAR, LINEAR

_PURE = 1e-7  # a part this small beside the other (angles, relative lengths) is not mentioned


@dataclass(frozen=True, eq=False)
class Screw:
    """A twist or wrench taken apart (Ball 1900; MLS section 2.3).

    Attributes:
        kind: "translation", "rotation" or "screw" for a twist; "force", "couple" or "wrench" for a wrench.
        direction: (3) unit vector of the axis.
        point: (3) the axis' point nearest to the origin of the frame [m], or None for a translation or couple.
        pitch: advance per radian, or moment per force, along the axis [m]; infinite for a translation or couple.
        text: the same in words.
    """

    kind: str
    direction: Array
    point: Array | None
    pitch: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """For JSON; an infinite pitch is null."""
        return {
            "kind": self.kind,
            "direction": self.direction.tolist(),
            "point": None if self.point is None else self.point.tolist(),
            "pitch": self.pitch if np.isfinite(self.pitch) else None,
            "text": self.text,
        }


def _direction_words(direction: Array, axes: str) -> str:
    for k, name in enumerate("xyz"):
        if abs(abs(direction[k]) - 1.0) < _PURE:
            return f"{name} of {axes}"
    numbers = ", ".join(format_number(x) for x in direction)
    return f"({numbers}) in axes of {axes}"


def _point_words(point: Array, length: float, axes: str, origin: str) -> str:
    if np.linalg.norm(point) < _PURE * length:
        return f"through the origin of {origin}"
    numbers = ", ".join(format_number(x) for x in point)
    return f"through the origin of {origin} + ({numbers}) m in axes of {axes}"


def _take_apart(along: Array, turning: Array, length: float) -> tuple[Array, Array | None, float]:
    """Direction, point and pitch of a screw with line vector `turning` and moment `along` (ω and v, f and τ)."""
    size = float(np.linalg.norm(turning))
    if size * length <= _PURE * float(np.linalg.norm(along)):
        return along / np.linalg.norm(along), None, np.inf
    direction = turning / size
    pitch = float(direction @ along) / size
    if abs(pitch) < _PURE * length:
        pitch = 0.0
    return direction, np.cross(turning, along) / size**2, pitch


def describe_lost_twist(twist: Array, axes: str, origin: str, length: float) -> Screw:
    """A direction of motion that is lost, (v, ω) at the frame's origin.

    Example:
        >>> describe_lost_twist(np.array([1.0, 0, 0, 0, 0, 0]), "base", "tip", 1.0).text
        'no velocity along x of base'
    """
    direction, point, pitch = _take_apart(twist[LINEAR], twist[ANGULAR], length)
    where = _direction_words(direction, axes)
    if point is None:
        return Screw("translation", direction, None, np.inf, f"no velocity along {where}")
    line = _point_words(point, length, axes, origin)
    if pitch == 0.0:
        return Screw("rotation", direction, point, 0.0, f"no rotation about {where}, {line}")
    text = f"no screw motion about {where}, {line}, pitch {format_number(pitch)} m/rad"
    return Screw("screw", direction, point, pitch, text)


def describe_free_wrench(wrench: Array, axes: str, origin: str, length: float) -> Screw:
    """A wrench that no joint feels, (f, τ) at the frame's origin.

    Example:
        >>> describe_free_wrench(np.array([0.0, 0, 0, 0, 1, 0]), "base", "tip", 1.0).text
        'couple about y of base'
    """
    direction, point, pitch = _take_apart(wrench[ANGULAR], wrench[LINEAR], length)
    where = _direction_words(direction, axes)
    if point is None:
        return Screw("couple", direction, None, np.inf, f"couple about {where}")
    line = _point_words(point, length, axes, origin)
    if pitch == 0.0:
        return Screw("force", direction, point, 0.0, f"force along {where}, {line}")
    text = f"force along {where}, {line}, with {format_number(pitch)} N m of moment per N"
    return Screw("wrench", direction, point, pitch, text)
