"""URDF: the robot files of ROS. Floor 4.

Kinematics needs neither meshes nor sound inertias: what is wrong with them is a finding, not an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from ..errors import Finding, RobotFileError
from ..namespaces import Array
from ..spatial import rpy_to_rotation
from .arguments import unit_direction
from .checks import NOT_YET, below, checked, unlimited, unsound_inertia
from .description import JointDescription, LinkDescription, Mimic, RobotDescription
from .paths import Search
from .xml import MAX_BYTES, Element, check_name, parse_xml, read_file, read_number, read_vector, required

TYPES = ("revolute", "continuous", "prismatic", "fixed")


def read_urdf(
    path: Path, *, package_roots: Sequence[Path] = (), base: str | None = None, max_bytes: int = MAX_BYTES
) -> RobotDescription:
    """The robot in a URDF file.

    Args:
        path: the file.
        package_roots: folders in which package:// paths may be looked up; meshes are only looked for, never opened.
        base: link to start from, where the file holds several trees or joints that cannot be read yet lie above it.
        max_bytes: largest file to read.

    Raises:
        RobotFileError: KS100-KS180, with file, line and column.
    """
    data = read_file(path, max_bytes)
    found = parse_urdf(data, str(path), package_roots=package_roots, base=base, max_bytes=max_bytes)
    return replace(found, digest=sha256(data).hexdigest())


def parse_urdf(
    data: bytes, file: str, *, package_roots: Sequence[Path] = (), base: str | None = None, max_bytes: int = MAX_BYTES
) -> RobotDescription:
    """The robot in the bytes of a URDF file; `file` names it in messages and is where relative paths start."""
    root = parse_xml(data, file, max_bytes=max_bytes)
    if root.tag != "robot":
        hint = "SDF is not supported; convert it to URDF" if root.tag == "sdf" else ""
        message = f"root element is <{root.tag[:40]}>; expected <robot> or <mujoco>"
        raise RobotFileError("KS120", message, hint, root.place)
    findings: list[Finding] = []
    name = root.attributes.get("name", "")
    if not name:
        name = Path(file).stem
        findings.append(Finding("KS122", "robot has no name; taken from the file name", root.place))
    links = [_link(element, findings) for element in root.all("link")]
    if not links:
        raise RobotFileError("KS121", "robot has no <link>", "", root.place)
    joints = _joints(root, base, findings)
    links, joints = below(links, joints, base, findings)
    _masses(links, joints, findings)
    _meshes(root, Path(file).parent, package_roots, findings)
    return checked(name, links, joints, source=file, base=base, findings=findings)


def read_origin(element: Element, what: str) -> Array:
    """(4, 4) pose of an <origin>, the identity where there is none."""
    origin = element.first("origin")
    if origin is None:
        return np.eye(4)
    xyz = read_vector(origin.attributes.get("xyz", "0 0 0"), 3, f"{what}: origin xyz", origin.place)
    rpy = read_vector(origin.attributes.get("rpy", "0 0 0"), 3, f"{what}: origin rpy", origin.place)
    T = np.eye(4)
    T[:3, :3] = rpy_to_rotation(*rpy)
    T[:3, 3] = xyz
    return T


def _named(element: Element, what: str, findings: list[Finding]) -> str:
    name = required(element, "name", what)
    if (sentence := check_name(name, what)) is not None:
        findings.append(Finding("KS123", sentence, element.place))
    return name


def _link(element: Element, findings: list[Finding]) -> LinkDescription:
    name = _named(element, "link", findings)
    inertial = element.first("inertial")
    if inertial is None:
        return LinkDescription(name, place=element.place)
    what = f"link {name!r}"
    T = read_origin(inertial, f"{what}: inertial")
    mass_element = inertial.first("mass")
    mass = 0.0
    if mass_element is not None:
        mass = read_number(required(mass_element, "value", what), f"{what}: mass", mass_element.place)
        if mass < 0:
            raise RobotFileError("KS160", f"{what}: mass is negative", "a mass is at least 0", mass_element.place)
    inertia = _inertia(inertial, what, mass, findings)
    R = T[:3, :3]
    return LinkDescription(name, mass, T[:3, 3].copy(), R @ inertia @ R.T, element.place)


def _inertia(inertial: Element, what: str, mass: float, findings: list[Finding]) -> Array:
    element = inertial.first("inertia")
    if element is None:
        return np.zeros((3, 3))

    def entry(word: str) -> float:
        return read_number(element.attributes.get(word, "0"), f"{what}: inertia {word}", element.place)

    xx, yy, zz, xy, xz, yz = (entry(word) for word in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    findings.extend(unsound_inertia(matrix, mass, what, element.place))
    return matrix


def _joints(root: Element, base: str | None, findings: list[Finding]) -> list[JointDescription]:
    return [_joint(element, base, findings) for element in root.all("joint")]


def _end(element: Element, word: str, name: str) -> str:
    end = element.first(word)
    if end is None:
        raise RobotFileError("KS134", f"joint {name!r} has no <{word}>", f'add <{word} link="..."/>', element.place)
    return required(end, "link", f"joint {name!r}")


def _joint(element: Element, base: str | None, findings: list[Finding]) -> JointDescription:
    name = _named(element, "joint", findings)
    kind = element.attributes.get("type")
    if kind is None:
        raise RobotFileError("KS141", f"joint {name!r} has no type", f"one of {', '.join(TYPES)}", element.place)
    if kind in NOT_YET and base is None:
        raise RobotFileError(
            "KS140",
            f"joint {name!r}: type {kind!r} has several freedoms, which is not supported yet",
            "make it fixed, or pass base= a link behind it",
            element.place,
        )
    if kind not in TYPES and kind not in NOT_YET:
        hint = "a helical joint comes in by from_screws" if kind in ("helical", "screw") else ""
        raise RobotFileError(
            "KS140", f"joint {name!r}: type {kind!r}; allowed in URDF: {', '.join(TYPES)}", hint, element.place
        )
    parent, child = _end(element, "parent", name), _end(element, "child", name)
    placement = read_origin(element, f"joint {name!r}")
    if kind == "fixed" or kind in NOT_YET:
        return JointDescription(name, kind, parent, child, placement, place=element.place)
    axis = _axis(element, name, findings)
    screw = np.concatenate([axis, np.zeros(3)] if kind == "prismatic" else [np.zeros(3), axis])
    limits = _limits(element, name, kind, findings)
    return JointDescription(
        name, kind, parent, child, placement, screw, *limits, mimic=_mimic(element, name), place=element.place
    )


def _axis(element: Element, name: str, findings: list[Finding]) -> Array:
    found = element.first("axis")
    if found is None:
        return np.array([1.0, 0.0, 0.0])  # the default of the URDF specification
    axis = read_vector(found.attributes.get("xyz", "1 0 0"), 3, f"joint {name!r}: axis", found.place)
    direction, length = unit_direction(axis)
    if length == 0:
        message = f"joint {name!r}: axis is zero: the joint would look permanently singular"
        raise RobotFileError("KS142", message, 'give a direction, for example xyz="0 0 1"', found.place)
    if abs(length - 1) > 1e-5:
        findings.append(Finding("KS143", f"joint {name!r}: axis normalised from length {length:g}", found.place))
    return direction


def _limits(element: Element, name: str, kind: str, findings: list[Finding]) -> tuple[float, float, float, float]:
    limit = element.first("limit")
    if limit is None:
        if kind != "continuous":
            message = f"joint {name!r} has no <limit>: treated as unlimited; torque limit unknown"
            findings.append(Finding("KS150", message, element.place))
        return -np.inf, np.inf, np.inf, np.inf

    def value(word: str, default: float) -> float:
        text = limit.attributes.get(word)
        return default if text is None else read_number(text, f"joint {name!r}: limit {word}", limit.place, infinite=True)

    missing = [word for word in ("effort", "velocity") if word not in limit.attributes]
    if missing:
        message = f"joint {name!r}: {' and '.join(missing)} limit missing: margins are unavailable"
        findings.append(Finding("KS151", message, limit.place))
    if kind == "continuous":
        lower, upper = -np.inf, np.inf
    else:  # the specification's default for a missing bound is 0
        lower, upper = unlimited(value("lower", 0.0), value("upper", 0.0))
    sizes = {word: value(word, np.inf) for word in ("velocity", "effort")}
    for word, size in sizes.items():
        if size == 0:
            findings.append(Finding("KS154", f"joint {name!r}: {word} limit is 0; taken as unknown", limit.place))
            sizes[word] = np.inf
    return lower, upper, sizes["velocity"], sizes["effort"]


def _mimic(element: Element, name: str) -> Mimic | None:
    mimic = element.first("mimic")
    if mimic is None:
        return None
    what = f"joint {name!r}: mimic"
    multiplier = read_number(mimic.attributes.get("multiplier", "1"), f"{what} multiplier", mimic.place)
    offset = read_number(mimic.attributes.get("offset", "0"), f"{what} offset", mimic.place)
    return Mimic(required(mimic, "joint", what), multiplier, offset)


def _masses(links: list[LinkDescription], joints: list[JointDescription], findings: list[Finding]) -> None:
    moved = {joint.child for joint in joints if joint.kind != "fixed"}
    for link in links:
        if link.name in moved and link.mass == 0:
            findings.append(Finding("KS161", f"link {link.name!r} has no mass: it weighs nothing", link.place))


def _meshes(root: Element, folder: Path, roots: Sequence[Path], findings: list[Finding]) -> None:
    """Looks for mesh files, so that a viewer's user learns early what is missing; never opens one."""
    seen: set[str] = set()
    search = Search(folder, roots)
    for element in root.walk():
        name = element.attributes.get("filename") if element.tag == "mesh" else None
        if not name or name in seen:
            continue
        seen.add(name)
        try:
            found, tried = search.find(name, element.place)
        except RobotFileError as failure:
            findings.append(Finding("KS111", failure.message, element.place))
            continue
        if found is None:
            searched = ", ".join(str(path) for path in tried[:4]) or "nowhere (only package://, file:// and relative paths)"
            findings.append(Finding("KS180", f"mesh {name!r} not found; searched: {searched}", element.place))
