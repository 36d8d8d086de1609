"""Pose: where a link is."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..spatial import rotation_to_rpy, split_pose
from ..surfaces import surface
from .arrays import numeric
from .frozen import Frozen, set_once
from .printing import format_number, table, wrapped


class Pose(Frozen):
    """Axes and origin of a link, seen from another: T_base_link, (..., 4, 4) [m].

    Attributes:
        array: (..., 4, 4) homogeneous matrix.
        link: whose frame; seen_from: in whose axes, from whose origin.

    Example:
        >>> import kinestatics as ks
        >>> ks.pose(ks.load("planar_2r"), [0, 0]).translation
        array([2., 0., 0.])
    """

    __slots__ = ("array", "link", "seen_from")
    array: Array
    link: str
    seen_from: str

    def __init__(self, array: Array, link: str, seen_from: str) -> None:
        set_once(self, "array", array)
        set_once(self, "link", link)
        set_once(self, "seen_from", seen_from)

    @property
    def rotation(self) -> Array:
        """(..., 3, 3); its columns are the axes of the link."""
        return split_pose(self.array)[0]

    @property
    def translation(self) -> Array:
        """(..., 3) [m]."""
        return split_pose(self.array)[1]

    @property
    def rpy(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw [rad] of one pose: R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
        if self.array.ndim != 2:
            raise ConfigurationError("KS303", f"rpy of a batch of shape {tuple(self.array.shape)}", "loop over the poses")
        return rotation_to_rpy(numeric(self.rotation))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(numeric(self.array), dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<Pose of {self.link} seen from {self.seen_from}, shape {tuple(self.array.shape)}>"

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        if self.array.ndim > 2:
            return repr(self)
        rows = [[""] + [format_number(x) for x in row] for row in numeric(self.array)[:-1]]
        return wrapped("", f"pose of {self.link} seen from {self.seen_from} [m]", hang=2) + "\n" + table(rows)
