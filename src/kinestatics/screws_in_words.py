"""Twists and wrenches as a person would name them: along which axis, about which line, with what pitch. Floor 4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .frames import Frame
from .namespaces import Array
from .quantities import format_number, plain, wrapped
from .spatial import ANGULAR, LINEAR

PURE = 1e-7
"""A part this small beside the other (angles, relative lengths) is not mentioned: a turning of this share is none."""


@dataclass(frozen=True, eq=False)
class Screw:
    """A twist or wrench taken apart (Ball 1900; MLS section 2.3): one, or arrays for a batch.

    Attributes:
        kind: "translation", "rotation" or "screw" for a twist; "force", "couple" or "wrench" for a wrench; "rest" and
            "none" for zeros. (...) text of NumPy for a batch.
        direction: (..., 3) unit vector of the axis; zeros where there is none.
        point: (..., 3) the axis' point nearest to the origin of the frame [m]; where there is none, None, in a batch NaN.
        pitch: (...) advance per radian, or moment per force, along the axis [m]; infinite for a translation or couple, NaN
            for zeros.
        text: the same in words; empty for a batch.
        magnitude: (...) speed of the turning [rad/s], without turning of the motion [m/s]; the force [N], without force the
            moment [N m]. None where a mere direction was taken apart.
        tolerance: the share below which a part counted as none.

    Example:
        >>> import kinestatics as ks
        >>> found = ks.screw(ks.Wrench.on_robot(force=(0, 0, -10), torque=(0, 20, 0)))
        >>> found.kind, found.point, found.pitch
        ('force', array([2., 0., 0.]), 0.0)
    """

    kind: Any
    direction: Array
    point: Array | None
    pitch: Any
    text: str
    magnitude: Any = None
    tolerance: float = PURE

    def to_dict(self) -> dict[str, Any]:
        """For JSON; an infinite pitch is null."""
        size = {} if self.magnitude is None else {"magnitude": plain(self.magnitude)}
        return {
            "kind": plain(self.kind),
            "direction": plain(self.direction),
            "point": plain(self.point),
            "pitch": plain(self.pitch),
            "text": self.text,
            **size,
        }

    def __str__(self) -> str:
        if self.text:
            return wrapped("", self.text, hang=2)
        kinds, counts = np.unique(self.kind, return_counts=True)
        found = ", ".join(f"{count} {kind}" for kind, count in zip(kinds, counts, strict=True))
        return wrapped("", f"screws, batch of shape {np.shape(self.kind)}: {found or 'empty'}", hang=2)


def _direction_words(direction: Array, axes: str) -> str:
    for k, name in enumerate("xyz"):
        if abs(abs(direction[k]) - 1.0) < PURE:
            return f"{name} of {axes}"
    numbers = ", ".join(format_number(x) for x in direction)
    return f"({numbers}) in axes of {axes}"


def _point_words(point: Array, length: float, axes: str, origin: str) -> str:
    if np.linalg.norm(point) < PURE * length:
        return f"through the origin of {origin}"
    numbers = ", ".join(format_number(x) for x in point)
    return f"through the origin of {origin} + ({numbers}) m in axes of {axes}"


class Parts(NamedTuple):
    """Screws as arrays: direction and point (or NaN) (..., 3); pitch, magnitude, whether pure, whether zero (...)."""

    direction: Array
    point: Array
    pitch: Array
    magnitude: Array
    pure: Array
    zero: Array


def take_apart(along: Array, turning: Array, length: float, tolerance: float = PURE) -> Parts:
    """Axis, pitch and magnitude of screws with line vectors `turning` and moments `along`: ω and v, or f and τ.

    Law: moment = point × line + pitch · line, the point being at right angles to the line (MLS section 2.3).

    Args:
        along, turning: (..., 3) NumPy, finite.
        length: [m] that makes the two comparable; tolerance: turning · length below this share of `along` is none, and
            a pitch below this share of the length is zero.
    """
    largest = np.maximum(np.abs(along).max(-1), np.abs(turning).max(-1))
    zero = largest == 0
    scale = np.where(zero, 1.0, largest)
    v, w = along / scale[..., None], turning / scale[..., None]  # so that no square leaves the range of floats
    shift, size = (np.linalg.norm(x, axis=-1) for x in (v, w))
    pure = size * length <= tolerance * shift
    magnitude = np.where(pure, shift, size)
    direction = np.where(pure[..., None], v, w) / np.where(zero, 1.0, magnitude)[..., None]
    size = np.where(pure, 1.0, size)
    pitch = (direction * v).sum(-1) / size
    pitch = np.where(np.abs(pitch) < tolerance * length, 0.0, pitch)
    pitch = np.where(zero, np.nan, np.where(pure, np.inf, pitch))
    point = np.where(pure[..., None], np.nan, np.cross(direction, v) / size[..., None])
    return Parts(direction + 0.0, point + 0.0, pitch, magnitude * scale, pure, zero)  # no minus before a zero


def _take_apart(along: Array, turning: Array, length: float) -> tuple[Array, Array | None, float]:
    """Direction, point and pitch of one screw."""
    parts = take_apart(along, turning, length)
    return parts.direction, None if parts.pure else parts.point, float(parts.pitch)


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


KINDS = {"twist": ("rest", "translation", "rotation", "screw"), "wrench": ("none", "couple", "force", "wrench")}
"""What a screw is called: of nothing, without turning (or force), without pitch, in general."""


def describe_screw(six: Array, of: str, frame: Frame, length: float, tolerance: float = PURE) -> Screw:
    """A twist or wrench, or a batch of them, with its magnitude.

    Args:
        six: (..., 6) NumPy, finite; of: "twist" or "wrench"; frame: it is written in.

    Example:
        >>> print(describe_screw(np.array([0.0, 0, 0, 0, 0, -2]), "twist", Frame.spatial(), 1.0))
        rotation about -z of base, through the origin of base, 2 rad/s
    """
    halves = (six[..., LINEAR], six[..., ANGULAR])
    parts = take_apart(*(halves if of == "twist" else halves[::-1]), length, tolerance)
    form = np.select([parts.zero, parts.pure, parts.pitch == 0], [0, 1, 2], 3)
    if six.ndim > 1:
        return Screw(np.array(KINDS[of])[form], parts.direction, parts.point, parts.pitch, "", parts.magnitude, tolerance)
    kind, point, pitch = KINDS[of][int(form)], None if parts.pure else parts.point, float(parts.pitch)
    text = _in_words(kind, parts.direction, point, pitch, float(parts.magnitude), frame, length)
    return Screw(kind, parts.direction, point, pitch, text, float(parts.magnitude), tolerance)


_HEADS = {
    "translation": ("translation along", "m/s"),
    "rotation": ("rotation about", "rad/s"),
    "screw": ("screw motion about", "rad/s"),
    "force": ("force along", "N"),
    "couple": ("couple about", "N m"),
    "wrench": ("force along", "N"),
}


def _in_words(
    kind: str, direction: Array, point: Array | None, pitch: float, magnitude: float, frame: Frame, length: float
) -> str:
    if kind in ("rest", "none"):
        return "no motion" if kind == "rest" else "no force and no moment"
    head, unit = _HEADS[kind]
    origin = frame.origin
    if any(frame.offset):
        origin += f" + ({', '.join(format_number(x) for x in frame.offset)}) m in its axes"
    words = [f"{head} {_signed_words(direction, frame.axes)}"]
    if point is not None:
        words.append(_point_words(point, length, frame.axes, origin))
    words.append(f"{format_number(magnitude)} {unit}")
    if kind == "screw":
        words.append(f"pitch {format_number(pitch)} m/rad")
    if kind == "wrench":
        words.append(f"with {format_number(pitch)} N m of moment per N")
    return ", ".join(words)


def _signed_words(direction: Array, axes: str) -> str:
    words = _direction_words(direction, axes)
    along = int(np.argmax(np.abs(direction)))
    return f"-{words}" if words[0] in "xyz" and direction[along] < 0 else words
