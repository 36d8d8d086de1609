"""What the links of a robot look like, as its file tells it: shapes to draw, never to compute with. Floor 4."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import Finding, Place, RobotFileError
from ..namespaces import Array

Kind = Literal["mesh", "box", "cylinder", "sphere", "capsule", "ellipsoid"]

FARTHEST = 1e6
"""A size or distance above this [m] is a slip of the pen, and too much for the single precision of a screen."""

SIZES = {"mesh": 0, "box": 3, "cylinder": 2, "sphere": 1, "capsule": 2, "ellipsoid": 3}
"""How many numbers say the size of each kind."""


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape, fixed to a link.

    Attributes:
        link: the link that carries it.
        kind: "mesh", "box", "cylinder", "sphere", "capsule" or "ellipsoid".
        T_link_visual: (4, 4) where it stands in the axes of its link [m].
        size: of a box its three edges, of a cylinder radius and length along z, of a sphere its radius, of a capsule the
            radius and the length along z without its caps, of an ellipsoid its half-axes; of a mesh nothing [m].
        file: of a mesh, the file: it is there, and inside the folders that may be looked in. Else None.
        scale: (3) by which a mesh is stretched along its own axes.
        color: (red, green, blue, opacity), each from 0 to 1, or None where the file gives none.
        name: the file's own name for it, or "".
    """

    link: str
    kind: Kind
    T_link_visual: Array
    size: tuple[float, ...] = ()
    file: Path | None = None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    color: tuple[float, float, float, float] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        T = np.array(self.T_link_visual, dtype=float)
        T.setflags(write=False)
        object.__setattr__(self, "T_link_visual", T)


@dataclass(frozen=True, eq=False)
class Visuals:
    """The shapes of a robot, and what could not be shown.

    Attributes:
        shapes: in the order of the file; on links that the model has.
        findings: what is missing or wrong. None of it stops the rest from being drawn.
    """

    shapes: tuple[Visual, ...] = field(default=())
    findings: tuple[Finding, ...] = field(default=())


def checked_shape(shape: Visual, place: Place) -> Visual:
    """The shape, after a look at its numbers.

    Raises:
        RobotFileError: KS148 larger than a screen can show, KS164 a size that is not above 0.
    """
    what = f"link {shape.link!r}: {shape.kind}"
    if not all(size > 0 for size in shape.size) or 0.0 in shape.scale:
        raise RobotFileError("KS164", f"{what} has a size that is not above 0", "a size is above 0", place)
    largest = float(np.max(np.abs([*shape.size, *shape.scale, *shape.T_link_visual.ravel()])))
    if not largest <= FARTHEST:
        message = f"{what} is larger or farther away than {FARTHEST:g} m"
        raise RobotFileError("KS148", message, "look for a wrong unit", place)
    return shape


def gathered(findings: list[Finding]) -> tuple[Finding, ...]:
    """One finding for all meshes that are missing, and one for all that lie outside: a robot has dozens of them."""
    kept: list[Finding] = []
    for code in dict.fromkeys(finding.code for finding in findings):
        same = [finding for finding in findings if finding.code == code]
        if code in ("KS111", "KS180") and len(same) > 1:
            more = len(same) - 1
            first = same[0]
            same = [first._replace(message=f"{first.message}; and {more} more file{'s' * (more > 1)}")]
        kept.extend(same)
    return tuple(kept)
