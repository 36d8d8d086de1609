"""A robot as a file tells it: links, joints, and where each stands. Floor 4.

Every reader (URDF, MJCF, DH rows, screws, the catalogue) ends here; `assemble` makes the RobotModel.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..errors import Finding, Place
from ..model import RobotFile
from ..namespaces import Array

KINDS = ("revolute", "continuous", "prismatic", "helical", "fixed")


def _zeros(*shape: int) -> Array:
    return np.zeros(shape)


class Mimic(NamedTuple):
    """This joint moves by multiplier · (value of `joint`) + offset [rad or m]."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class LinkDescription:
    """A rigid body.

    Attributes:
        name: unique in the robot.
        mass: [kg].
        center_of_mass: (3) in link axes [m].
        inertia: (3, 3) about the centre of mass, in link axes [kg m²].
        place: where it stands in its file.
    """

    name: str
    mass: float = 0.0
    center_of_mass: Array = field(default_factory=lambda: _zeros(3))
    inertia: Array = field(default_factory=lambda: _zeros(3, 3))
    place: Place | None = None


@dataclass(frozen=True)
class JointDescription:
    """A joint: the child link's frame is placement · exp(value · screw), seen from the parent link.

    Attributes:
        name: unique in the robot.
        kind: one of KINDS.
        parent, child: link names.
        placement: (4, 4) joint frame at zero, seen from the parent link [m].
        screw: (6) unit screw in the joint frame, linear part first; zero for a fixed joint.
        lower, upper: position limits [rad or m]; velocity, effort: limits, infinite where unknown.
        mimic: the joint it follows, or None.
        home: its value in the "home" configuration, or None.
        place: where it stands in its file.
    """

    name: str
    kind: str
    parent: str
    child: str
    placement: Array = field(default_factory=lambda: np.eye(4))
    screw: Array = field(default_factory=lambda: _zeros(6))
    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    effort: float = np.inf
    mimic: Mimic | None = None
    home: float | None = None
    place: Place | None = None


@dataclass(frozen=True)
class RobotDescription:
    """All links and joints of a robot, in the order of the file.

    Attributes:
        name: name of the robot.
        links, joints: what it is made of.
        source: where the numbers come from (a path, a document).
        tip: the link to use as tip when the user names none; None: the only leaf.
        findings: warnings met while reading.
        file: the file that was read, None where there is none; digest: SHA-256 of its bytes, or of the catalogue's.
    """

    name: str
    links: tuple[LinkDescription, ...]
    joints: tuple[JointDescription, ...]
    source: str = ""
    tip: str | None = None
    findings: tuple[Finding, ...] = ()
    file: RobotFile | None = None
    digest: str = ""
