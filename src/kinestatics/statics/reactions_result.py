"""What `joint_reactions` returns: numbers for every joint, printed as two tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import UnknownNameError, nearest
from ..namespaces import Array
from ..quantities import TIED, WIDTH, format_number, numeric, plain, table, wrapped
from ..spatial import WRENCH_NAMES

_BEARING = ("radial", "axial", "bending", "torsion", "drive")
_UNITS = ("N", "N", "N m", "N m", "N m")


@dataclass(frozen=True, eq=False)
class JointReactions:
    """What every joint carries while the arm is held still. `print` it, or take `to_dict()`.

    A wrench is what the body before the joint exerts, through the joint, on all that lies behind it.

    Attributes:
        robot: name; joints: (m) every moving joint, followers of a mimic joint included, parents first; kinds: of them.
        axes: "joint" or "base": the axes of `wrenches`.
        wrenches: (..., m, 6) (f, τ) at the origin of each joint's frame [N, N m].
        base: (..., 6) what the ground exerts on the whole arm, base axes, base origin [N, N m].
        torques: (..., n) what the motors supply: `drive` folded with the multipliers of mimic joints [N m or N].
        radial: (..., m) size of the force across the joint's axis; axial: force along it, signed [N].
        bending: (..., m) size of the moment across the axis, about the point of the axis nearest to the origin of the
            joint's frame; torsion: moment about the axis, signed: the motor's of a turning joint, the guide's of a
            sliding one [N m].
        drive: (..., m) the component along the joint's screw, which the motor supplies [N m, N for a sliding joint].
        imbalance: (..., m + 2, 6) what is left when all that acts on the whole arm, on the base, and on each joint's
            body is summed about another point than the one used to find the wrenches; zero but for rounding [N, N m].
        residual: (...) its largest entry [N or N m]; None for symbols.
        relative_residual: (...) the same as a share of the forces (or moments) at play; None for symbols.

    Example:
        >>> import kinestatics as ks
        >>> r = ks.joint_reactions(ks.load("planar_2r"), [0.0, 0.0], gravity=(0, 0, -10))
        >>> r.base, r.bending
        (array([  0.,   0.,  20.,   0., -20.,   0.]), array([20.,  5.]))
    """

    robot: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    axes: str
    wrenches: Array
    base: Array
    torques: Array
    radial: Array
    axial: Array
    bending: Array
    torsion: Array
    drive: Array
    imbalance: Array
    residual: Array | None
    relative_residual: Array | None

    def wrench(self, joint: str) -> Array:
        """(..., 6) of one joint, by name; KS313 for a name that is not there."""
        if joint not in self.joints:
            raise UnknownNameError(
                "KS313", f"robot {self.robot!r} has no moving joint {joint!r}", nearest(joint, self.joints)
            )
        return self.wrenches[..., self.joints.index(joint), :]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; symbols become text."""
        names = ("wrenches", "base", "torques", *_BEARING, "residual", "relative_residual")
        return {
            "robot": self.robot,
            "joints": list(self.joints),
            "axes": self.axes,
            **{name: plain(getattr(self, name)) for name in names},
        }

    def __str__(self) -> str:
        head = f"{self.robot}: what each joint passes on to the links behind it"
        if self.base.ndim > 1:
            return f"{head}\nbatch of shape {tuple(self.base.shape[:-1])}, {len(self.joints)} joints"
        if self.residual is None or self.relative_residual is None:
            return f"{head}\nexpressions of symbols: take .wrenches, .base, .torques"
        where = "axes of the joint" if self.axes == "joint" else "axes of base"
        names = [*self.joints, "ground"]
        wrenches = [*numeric(self.wrenches), numeric(self.base)]
        units = dict(zip(WRENCH_NAMES, ("N", "N", "N", "N m", "N m", "N m"), strict=True))
        bearing = [*np.stack([numeric(getattr(self, name)) for name in _BEARING], -1)]
        parts = [
            head,
            f"({where}, at the origin of its frame; ground: axes and origin of base)",
            *rows_of_numbers(names, [f"{name} [{unit}]" for name, unit in units.items()], wrenches),
        ]
        if self.joints:
            parts.append("what a bearing must bear, and the motor supply (drive: N for a sliding joint)")
            titles = [f"{name} [{unit}]" for name, unit in zip(_BEARING, _UNITS, strict=True)]
            parts += rows_of_numbers(self.joints, titles, bearing)
        share = f"{float(self.relative_residual):.1e} of what is at play"
        text = f"every body balances about another point but for {float(self.residual):.1e} N or N m ({share})"
        return "\n".join([*parts, wrapped("", text)])


def rows_of_numbers(names: Sequence[str], titles: Sequence[str], values: Sequence[Any]) -> list[str]:
    """A table with a row a name; where it grows too wide the rows are numbered, and the names stand below."""
    cells = [[format_number(x) for x in row] for row in values]
    named = table([["", *titles], *([name, *row] for name, row in zip(names, cells, strict=True))])
    if max(len(line) for line in named.splitlines()) <= WIDTH:
        return [named]
    numbers = [str(k + 1) for k in range(len(names))]
    listed = ", ".join(f"{k}{TIED}{name}" for k, name in zip(numbers, names, strict=True))
    numbered = table([["", *titles], *([k, *row] for k, row in zip(numbers, cells, strict=True))])
    return [numbered, wrapped("rows: ", listed)]
