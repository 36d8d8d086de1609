"""What `payload_capacity` and `force_capacity` return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..quantities import format_number, plain, table, wrapped


@dataclass(frozen=True, eq=False)
class Capacity:
    """The greatest payload, force or wrench that the efforts of the joints allow. `print` it, or take `to_dict()`.

    Attributes:
        what: "payload", "force" or "wrench"; unit: of the value, "kg", "N" or "times the wrench".
        robot: name; link: that holds or pushes; joints: (n) names; kinds: of the joints.
        value: (...), infinite where no joint feels it, 0 where the arm cannot hold its own weight, NaN where unknown.
        limiting: (...) index of the joint whose limit binds first, or that the weight overloads most; -1 for none.
        torques: (..., n) at the limit, weight included [N m or N]; where the value is infinite, those of the weight.
        gravity_torques: (..., n) what holds the arm's own weight; None when it was left out.
        unit_torques: (..., n) what each kg, newton or multiple of the wrench adds.
        effort_limits: (n) [N m or N], infinite where unknown.
        margin: (...) the share of its effort limit that the weight leaves in the most loaded joint; negative where the
            arm cannot hold itself, by the share that is missing.
        holds_itself: (...) whether the arm holds its own weight.
        held_by_structure: (...) whether no joint feels the load: the structure holds it.
        tolerance: a joint feels what causes more than this share of the torque it could cause in another direction.
        notes: sentences about what is unknown or left out.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.payload_capacity(ks.load("ur5e"), [0, 0, 0, 0, 0, 0]))
        payload capacity of ur5e at tool0: 11.2569 kg, limited by joint
        'shoulder_lift_joint'
                               weight   per kg  at the limit  effort limit
        shoulder_pan_joint          0        0             0           150  N m
        shoulder_lift_joint  -59.7564  -8.0167          -150           150  N m
        elbow_joint          -18.4392  -3.8475      -61.7499           150  N m
        wrist_1_joint               0        0             0            28  N m
        wrist_2_joint               0        0             0            28  N m
        wrist_3_joint               0        0             0            28  N m
    """

    what: str
    unit: str
    robot: str
    link: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    value: Any
    limiting: Any
    torques: Array
    gravity_torques: Array | None
    unit_torques: Array
    effort_limits: Array
    margin: Any
    holds_itself: Any
    held_by_structure: Any
    tolerance: float
    notes: tuple[str, ...]

    @property
    def limiting_joint(self) -> Any:
        """Name of the joint whose limit binds first, None where none does; nested lists of names for a batch."""
        names = np.array([*self.joints, None], dtype=object)[self.limiting]
        return names.tolist() if isinstance(names, np.ndarray) else names

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; infinite and unknown values are None."""
        numbers = ("value", "torques", "gravity_torques", "unit_torques", "effort_limits", "margin")
        return {
            "what": self.what,
            "unit": self.unit,
            "robot": self.robot,
            "link": self.link,
            "joints": list(self.joints),
            "limiting_joint": self.limiting_joint,
            **{name: plain(getattr(self, name)) for name in numbers},
            "holds_itself": np.asarray(self.holds_itself).tolist(),
            "held_by_structure": np.asarray(self.held_by_structure).tolist(),
            "tolerance": self.tolerance,
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        head = f"{self.what} capacity of {self.robot} at {self.link}: "
        notes = [wrapped("note: ", note) for note in self.notes]
        if np.ndim(self.value):
            return "\n".join([wrapped("", head + self._range()), *notes])
        return "\n".join([wrapped("", head + self.verdict), *self._table(), *notes])

    def _range(self) -> str:
        finite = np.asarray(self.value)[np.isfinite(self.value)]
        shape = f"batch of shape {np.shape(self.value)}"
        return (
            f"{shape}, {format_number(finite.min())} to {format_number(finite.max())} {self.unit}" if finite.size else shape
        )

    @property
    def verdict(self) -> str:
        """The value of one configuration in words."""
        joint = self.limiting_joint
        if np.isnan(self.value):
            return "unknown, as q or the limits are"
        if not self.holds_itself:
            needs = (
                f"{1.0 - self.margin:.3g} times its effort limit"
                if np.isfinite(self.margin)
                else "an effort, its limit is 0"
            )
            return f"0; the arm cannot hold its own weight: joint {joint!r} needs {needs}"
        if self.held_by_structure:
            return "unlimited: held by the structure, no joint feels it"
        return f"{format_number(self.value)} {self.unit}, limited by joint {joint!r}"

    def _table(self) -> list[str]:
        if not self.joints:
            return []
        columns: dict[str, Array] = {} if self.gravity_torques is None else {"weight": self.gravity_torques}
        per = {"kg": "per kg", "N": "per N"}.get(self.unit, "of the wrench")
        columns |= {per: self.unit_torques, "at the limit": self.torques, "effort limit": self.effort_limits}
        rows = [["", *columns, ""]]
        for k, name in enumerate(self.joints):
            numbers = [format_number(x[k]) if np.isfinite(x[k]) else "unknown" for x in columns.values()]
            rows.append([name, *numbers, "N" if self.kinds[k] == "prismatic" else "N m"])
        return [table(rows)]
