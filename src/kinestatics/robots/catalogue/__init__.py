"""The bundled arms: one TOML file each, every number with its source. Floor 4.

A file holds

    name, title          what to call the arm here, and what it is
    notes                what a user should know (frames, zeros, what is not published)
    base                 name of the base link
    convention           "standard" or "modified" Denavit-Hartenberg rows, or "screws"
    [[source]]           document, gives: where each kind of number was published
    [[joint]]            name, link, and
                         a, alpha, d, theta of the row (theta, or d of a prismatic joint, is its offset); or axis, point
                         type "R" (default) or "P"; lower, upper, velocity, effort, home; mass, center_of_mass, inertia
    [mount]              pose of the first row seen from the base link: xyz and rpy
    [tool]               link, and its pose behind the last row: xyz and rpy (or matrix rows for screws)

Numbers may be text such as "pi/2", "-3*pi/4" or "55 deg", so that exact values survive. Lengths are metres, angles
radians unless a text says deg. A missing limit is unknown; a missing mass is unknown, never guessed.
"""

from __future__ import annotations

import math
import re
from functools import cache
from hashlib import sha256
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from ...errors import RobotDefinitionError, UnknownNameError, nearest
from ...namespaces import Array
from ...spatial import rpy_to_rotation
from ..description import JointDescription, LinkDescription, RobotDescription
from ..dh import dh_joint
from ..screws import screw_axis

_ANGLE = re.compile(r"(?P<sign>-?)(?:(?P<number>\d+(?:\.\d+)?)\*?)?(?P<pi>pi)?(?:/(?P<divisor>\d+))?")


class Entry(NamedTuple):
    """A row of the list of bundled arms.

    Attributes:
        name: what `load` takes; title: what it is; joints: how many; source: the first document its numbers come from.
    """

    name: str
    title: str
    joints: int
    source: str


def catalogue_names() -> tuple[str, ...]:
    """The names that `load` knows without a file.

    Example:
        >>> "ur5e" in catalogue_names()
        True
    """
    return _names()


@cache
def _names() -> tuple[str, ...]:
    files = (entry.name for entry in resources.files(__package__).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))


def _read(name: str) -> dict[str, Any]:
    import tomllib

    if name not in catalogue_names():
        raise UnknownNameError("KS312", f"no catalogue robot {name!r}", nearest(name, catalogue_names()))
    return tomllib.loads(_bytes(name).decode("utf-8"))


def _bytes(name: str) -> bytes:
    return resources.files(__package__).joinpath(f"{name}.toml").read_bytes()


def catalogue_entries() -> tuple[Entry, ...]:
    """All bundled arms, by name."""
    found = ((name, _read(name)) for name in catalogue_names())
    return tuple(Entry(name, data["title"], len(data["joint"]), data["source"][0]["document"]) for name, data in found)


def read_catalogue(name: str) -> RobotDescription:
    """The links and joints of a bundled arm.

    Raises:
        UnknownNameError: KS312, with the nearest names.
    """
    data = _read(name)
    before = data["base"]
    links, joints = [LinkDescription(before)], []
    for index, row in enumerate(data["joint"]):
        mount = _pose(data["mount"]) if index == 0 and "mount" in data else np.eye(4)
        joints.append(_joint(row, data["convention"], before, mount))
        links.append(_link(row))
        before = row["link"]
    if (tool := data.get("tool")) is not None:
        joints.append(JointDescription(f"{tool['link']}_joint", "fixed", before, tool["link"], _pose(tool)))
        links.append(LinkDescription(tool["link"]))
        before = tool["link"]
    documents = "; ".join(source["document"] for source in data["source"])
    digest = sha256(_bytes(name)).hexdigest()
    return RobotDescription(data["name"], tuple(links), tuple(joints), documents, tip=before, digest=digest)


def exact_number(value: float | str) -> float:
    """A number of a data file: a float, a multiple of pi such as "-3*pi/4", or degrees such as "55 deg".

    Example:
        >>> exact_number("-pi/2") == -math.pi / 2, exact_number("90 deg") == math.pi / 2
        (True, True)
    """
    if not isinstance(value, str):
        return float(value)
    text = value.strip()
    if text.endswith("deg"):
        return math.radians(float(text.removesuffix("deg")))
    match = _ANGLE.fullmatch(text.replace(" ", ""))
    if not match or not (match["number"] or match["pi"]):
        raise RobotDefinitionError("KS203", f"{value!r} is not a number", 'write 0.5, "pi/2", "-3*pi/4" or "55 deg"')
    size = float(match["number"] or 1) * (math.pi if match["pi"] else 1.0) / float(match["divisor"] or 1)
    return -size if match["sign"] else size


def _joint(row: dict[str, Any], convention: str, before: str, mount: Array) -> JointDescription:
    letter = row.get("type", "R")
    if convention == "screws":
        pitch = math.inf if letter == "P" else exact_number(row.get("pitch", 0.0))
        screw = screw_axis(
            [exact_number(x) for x in row["axis"]], [exact_number(x) for x in row.get("point", (0, 0, 0))], pitch
        )
        placement = np.eye(4)
    else:
        numbers = [exact_number(row.get(word, 0.0)) for word in ("a", "alpha", "d", "theta")]
        placement, screw = dh_joint(numbers, letter, convention)
    limits: dict[str, Any] = {
        word: exact_number(row[word]) for word in ("lower", "upper", "velocity", "effort", "home") if word in row
    }
    kind = "prismatic" if letter == "P" else "revolute" if "lower" in limits else "continuous"
    return JointDescription(row["name"], kind, before, row["link"], mount @ placement, screw, **limits)


def _link(row: dict[str, Any]) -> LinkDescription:
    inertia = np.array(row.get("inertia", np.zeros((3, 3))), dtype=float)
    center = np.array([exact_number(x) for x in row.get("center_of_mass", (0.0, 0.0, 0.0))])
    return LinkDescription(
        row["link"], float(row.get("mass", 0.0)), center, np.diag(inertia) if inertia.ndim == 1 else inertia
    )


def _pose(data: dict[str, Any]) -> Array:
    if "matrix" in data:
        return np.array([[exact_number(x) for x in row] for row in data["matrix"]])
    T = np.eye(4)
    T[:3, :3] = rpy_to_rotation(*(exact_number(x) for x in data.get("rpy", (0, 0, 0))))
    T[:3, 3] = [exact_number(x) for x in data.get("xyz", (0, 0, 0))]
    return T
