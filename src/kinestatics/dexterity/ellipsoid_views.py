"""How an ellipsoid is drawn, printed and written down."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..quantities import format_number, table, wrapped

if TYPE_CHECKING:
    from .ellipsoid import Ellipsoid


def circle(count: int) -> Array:
    """(count, 2) points of the unit circle; the last is the first."""
    angle = _angles(count)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def sphere(count: int) -> Array:
    """(count, count, 3) points of the unit sphere by polar angle and longitude, closed."""
    around = circle(count)
    polar = np.linspace(0.0, np.pi, count)
    ring = np.sin(polar)
    ring[-1] = 0.0
    height = np.repeat(np.cos(polar)[:, None], count, axis=1)
    return np.stack([ring[:, None] * around[:, 0], ring[:, None] * around[:, 1], height], axis=-1)


def _angles(count: int) -> Array:
    if isinstance(count, bool) or not hasattr(count, "__index__") or count < 4:
        raise ConfigurationError("KS303", f"count is {count!r}", "a whole number of points, 4 or more")
    angle = np.linspace(0.0, 2 * np.pi, count)
    angle[-1] = 0.0
    return angle


def in_words(e: Ellipsoid) -> str:
    """The title, the units, and the radii of one ellipsoid with their directions."""
    return "\n".join([_title(e), _legend(e), *([] if e.radii.ndim > 1 else [_axes_table(e)])])


def _title(e: Ellipsoid) -> str:
    whose = f" of {e.link}" if e.link else ""
    where = f": {e.frame}" if e.frame is not None else ""
    return wrapped("", f"{e.kind} ellipsoid{whose}{where}", hang=2)


def _legend(e: Ellipsoid) -> str:
    what = "joint speeds" if e.kind == "velocity" else "joint torques"
    unit = f" [{e.unit}]" if e.unit else ""
    scaled = f"{what} within their scale" if e.joint_scale is not None else f"unit {what}"
    lines = [f"radii{unit} at {scaled}, and their directions"]
    if e.characteristic_length is not None:
        lines.append(f"lengths and angles compared by L = {format_number(e.characteristic_length)} m")
    if e.radii.ndim > 1:
        lines.append(f"batch of shape {tuple(e.radii.shape[:-1])}")
    return "\n".join(lines)


def _axes_table(e: Ellipsoid) -> str:
    names = e.rows or tuple(f"row {i + 1}" for i in range(e.radii.shape[-1]))
    lines = [["radius", *names]]
    for radius, axis in zip(e.radii, e.axes.T, strict=True):
        word = "unbounded" if np.isinf(radius) else "flat" if radius == 0 else format_number(radius)
        lines.append([word, *(format_number(x) for x in axis)])
    width = max(len(line[0]) for line in lines)
    return table([[line[0].rjust(width), *line[1:]] for line in lines])
