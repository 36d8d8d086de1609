"""What `speed_capacity` returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..frames import Frame
from ..namespaces import Array
from ..quantities import format_number, plain, table, wrapped


@dataclass(frozen=True, eq=False, repr=False)
class SpeedCapacity:
    """The greatest speed along a direction that the velocity limits of the joints allow. `print` it, or take `to_dict()`.

    Attributes:
        robot: name; link: that moves; joints: (n) names; kinds: of the joints.
        direction: (..., 3) unit vectors, or (..., 6) the twist as given; in the axes of `frame`, at its origin.
        value: (...) [unit], 0 in a direction that is lost; unit: "m/s" or "times the twist".
        rates: (..., n) joint rates that reach it [rad/s or m/s]; where others do too, those of one corner.
        limiting: (..., n) 1 for a joint whose upper limit makes the value what it is, -1 for a lower one, 0 for the others.
        lower, upper: (n) the velocity limits.
        rows: names of the rows that follow the direction (of a batch, of any: each follows those in play and its own);
            held: those of rotation that stay zero; all others are free.
        is_lost: (...) whether no motion of the joints within their limits goes that way.
        tolerance: singular values below this share of the largest count as zero.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.speed_capacity(ks.load("ur5e"), [0, -1, 1.5, -0.5, 1.2, 0], (1, 0, 0)))
        speed capacity of ur5e at tool0 along (1, 0, 0): 0.9103 m/s, limited by joint
        'elbow_joint'
        axes of base, at the origin of tool0; held: wx, wy, wz
                                rate  lower limit  upper limit
        shoulder_pan_joint         0      -3.1416       3.1416  rad/s
        shoulder_lift_joint  -1.8844      -3.1416       3.1416  rad/s
        elbow_joint           3.1416      -3.1416       3.1416  rad/s
        wrist_1_joint        -1.2572      -3.1416       3.1416  rad/s
        wrist_2_joint              0      -3.1416       3.1416  rad/s
        wrist_3_joint              0      -3.1416       3.1416  rad/s
    """

    robot: str
    link: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    direction: Array
    value: Any
    unit: str
    rates: Array
    limiting: Array
    lower: Array
    upper: Array
    rows: tuple[str, ...]
    held: tuple[str, ...]
    is_lost: Any
    frame: Frame
    tolerance: float

    @property
    def limiting_joints(self) -> Any:
        """Names of the joints whose limits make the value what it is; nested lists of them for a batch."""
        return _names(self.limiting, self.joints)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; unknown limits are None."""
        numbers = ("direction", "value", "rates", "limiting", "lower", "upper")
        return {
            "robot": self.robot,
            "link": self.link,
            "joints": list(self.joints),
            "unit": self.unit,
            **{name: plain(getattr(self, name)) for name in numbers},
            "limiting_joints": self.limiting_joints,
            "rows": list(self.rows),
            "held": list(self.held),
            "lost": np.asarray(self.is_lost).tolist(),
            "frame": self.frame.to_dict(),
            "tolerance": self.tolerance,
        }

    def __repr__(self) -> str:
        return f"<SpeedCapacity of {self.link}: {self.value} {self.unit}>"

    def __str__(self) -> str:
        head = f"speed capacity of {self.robot} at {self.link}"
        held = f"held: {', '.join(self.held)}" if self.held else "free to turn" if len(self.rows) <= 3 else ""
        where = wrapped("", "; ".join([str(self.frame), *([held] if held else [])]))
        if np.ndim(self.value):
            values = np.asarray(self.value)
            span = f", {format_number(values.min())} to {format_number(values.max())} {self.unit}" if values.size else ""
            return "\n".join([wrapped("", f"{head}: batch of shape {values.shape}{span}"), where])
        along = ", ".join(format_number(x) for x in self.direction)
        return "\n".join([wrapped("", f"{head} along ({along}): {self._verdict()}"), where, *self._table()])

    def _verdict(self) -> str:
        if np.isnan(self.value):
            return "unknown, as q is"
        if self.is_lost:
            without = " without turning it" if self.held else ""
            return f"0; within the limits no motion of the joints moves it that way{without}"
        names = ", ".join(repr(name) for name in self.limiting_joints)
        return f"{format_number(self.value)} {self.unit}, limited by joint{'s' * (len(self.limiting_joints) > 1)} {names}"

    def _table(self) -> list[str]:
        if not self.joints:
            return []
        rows = [["", "rate", "lower limit", "upper limit", ""]]
        for k, name in enumerate(self.joints):
            numbers = [format_number(x[k]) if np.isfinite(x[k]) else "unknown" for x in (self.rates, self.lower, self.upper)]
            rows.append([name, *numbers, "m/s" if self.kinds[k] == "prismatic" else "rad/s"])
        return [table(rows)]


def _names(limiting: Array, joints: tuple[str, ...]) -> Any:
    if limiting.ndim > 1:
        return [_names(one, joints) for one in limiting]
    return [name for name, side in zip(joints, limiting, strict=True) if side]
