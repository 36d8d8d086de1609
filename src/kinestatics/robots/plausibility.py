"""What no rule forbids and hardly anybody means: misspelt words, wrong units, joints that cannot move. Floor 4.

A strict reader has to read `<orgin>` as an element that is none of its business, and 180 as an angle in radians. Here it is
said that they were probably meant otherwise, with a code, a place and the numbers.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping

import numpy as np

from ..errors import Finding, Place
from .checks import LARGEST
from .description import JointDescription, LinkDescription, RobotDescription
from .xml import Element

ELEMENTS: Mapping[str, tuple[str, ...]] = {
    "robot": ("link", "joint", "material", "transmission", "gazebo", "sensor"),
    "link": ("inertial", "visual", "collision"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "calibration", "dynamics", "safety_controller"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry", "contact_coefficients", "material"),
    "geometry": ("box", "cylinder", "sphere", "mesh", "capsule"),
}
"""What may stand in each element of a URDF file."""
ATTRIBUTES: Mapping[str, tuple[str, ...]] = {
    "link": ("name", "type"),
    "joint": ("name", "type"),
    "origin": ("xyz", "rpy"),
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "mimic": ("joint", "multiplier", "offset"),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "mesh": ("filename", "scale"),
}
_ONCE = ("origin", "parent", "child", "axis", "limit", "mimic", "inertial", "mass", "inertia")
_ALIKE = 0.75
_TURNS = 4 * math.pi  # [rad] no wrist turns further; cables do not allow it
_DEGREES = 3600.0  # [rad] beyond, a limit says "none" rather than an angle in degrees
_FAR = 20.0  # [m] from joint to joint, or from a joint to a centre of mass
_HEAVY = 20_000.0  # [kg]
_WIDE, _POINT = 3.0, 1e-4  # [m] radius of gyration of a link


def misspelt(root: Element) -> Iterator[Finding]:
    """KS420, KS421 and KS422: elements and attributes that are not read, and were probably meant to be."""
    stack = [root]
    while stack:
        element = stack.pop()
        if element.tag not in ELEMENTS:
            continue
        stack.extend(reversed(element.children))
        seen: set[str] = set()
        for child in element.children:
            if child.tag in seen and child.tag in _ONCE:
                message = f"<{child.tag}> stands twice in {_called(element)}; the first is read, this one is not"
                yield Finding("KS422", message, child.place)
            seen.add(child.tag)
            yield from _element(child, element)
            yield from _attributes(child, element)


def _called(element: Element) -> str:
    name = element.attributes.get("name")
    return f"<{element.tag}>" if name is None else f"<{element.tag}> {name!r}"


def _element(child: Element, parent: Element) -> Iterator[Finding]:
    known = ELEMENTS[parent.tag]
    if child.tag in known:
        return
    if (meant := _meant(child.tag, known)) is not None:
        yield Finding("KS420", f"<{child.tag}> in {_called(parent)} is not read; <{meant}> may be meant", child.place)
    elif parent.tag != "robot" and child.tag in ("origin", "axis", "limit", "mimic", "mass", "inertia", "inertial"):
        homes = [f"<{home}>" for home, inside in ELEMENTS.items() if child.tag in inside]
        message = f"<{child.tag}> in {_called(parent)} is not read; it belongs into {' or '.join(homes)}"
        yield Finding("KS420", message, child.place)


def _attributes(element: Element, parent: Element) -> Iterator[Finding]:
    known = ATTRIBUTES.get(element.tag, ())
    for name in element.attributes:
        if known and name not in known and (meant := _meant(name, known)) is not None and meant not in element.attributes:
            where = _called(element if "name" in element.attributes else parent)
            message = f"<{element.tag}> of {where}: {name!r} is not read; {meant!r} may be meant"
            yield Finding("KS421", message, element.place)


def _meant(word: str, known: tuple[str, ...]) -> str | None:
    """The known word that this one is nearly."""
    small = word[:40].lower()
    close = difflib.get_close_matches(small, known, n=1, cutoff=_ALIKE)
    close += [known_word for known_word in known if sorted(known_word) == sorted(small)]  # letters exchanged in a short one
    return close[0] if close else None


def implausible(robot: RobotDescription) -> Iterator[Finding]:
    """KS423 to KS428: joints and links that no arm has."""
    for joint in robot.joints:
        yield from _limits(joint)
        if (away := float(np.linalg.norm(joint.placement[:-1, -1]))) > _FAR:
            message = f"joint {joint.name!r} stands {away:g} m from its parent link"
            yield Finding("KS425", message, joint.place)
    for link in robot.links:
        yield from _body(link)
    moving = any(joint.kind != "fixed" for joint in robot.joints)
    if moving and all(link.mass == 0 for link in robot.links):
        where = Place(robot.source)
        yield Finding("KS428", "no link has a mass: what gravity asks of the joints is not known", where)


def _limits(joint: JointDescription) -> Iterator[Finding]:
    """Limits of a joint that is not fixed."""
    lower, upper = joint.lower, joint.upper
    unit = "m" if joint.kind == "prismatic" else "rad"
    if joint.kind == "fixed" or joint.mimic is not None or not (math.isfinite(lower) or math.isfinite(upper)):
        return
    if lower == upper:
        message = f"joint {joint.name!r} cannot move: its limits are both {lower:g} {unit}"
        yield Finding("KS423", message, joint.place)
    elif not lower <= 0 <= upper and joint.home is None:
        nearest = lower if lower > 0 else upper
        message = (
            f"joint {joint.name!r}: 0 lies outside its limits [{lower:g}, {upper:g}] {unit}; home is {nearest:g} {unit}"
        )
        yield Finding("KS427", message, joint.place)
    widest = max(abs(x) for x in (lower, upper) if math.isfinite(x))
    if joint.kind == "revolute" and _TURNS < widest <= _DEGREES:
        turns = widest / (2 * math.pi)
        message = f"joint {joint.name!r}: limits [{lower:g}, {upper:g}] rad are {turns:.1f} turns; are they degrees?"
        yield Finding("KS424", message, joint.place)
    elif joint.kind == "prismatic" and _FAR < widest < LARGEST:
        message = f"joint {joint.name!r}: limits [{lower:g}, {upper:g}] m; are they millimetres?"
        yield Finding("KS424", message, joint.place)


def _body(link: LinkDescription) -> Iterator[Finding]:
    """Mass, centre and inertia of a link."""
    if (away := float(np.linalg.norm(link.center_of_mass))) > _FAR:
        yield Finding("KS425", f"link {link.name!r}: centre of mass {away:g} m from its origin", link.place)
    if link.mass > _HEAVY:
        yield Finding("KS426", f"link {link.name!r} weighs {link.mass:g} kg; are they grams?", link.place)
    if link.mass <= 0:
        return
    gyration = math.sqrt(max(float(np.trace(link.inertia)), 0.0) / (2 * link.mass))
    if gyration > _WIDE or 0 < gyration < _POINT:
        message = f"link {link.name!r}: inertia is that of {link.mass:g} kg at {gyration:.3g} m from the centre of mass"
        yield Finding("KS426", message, link.place)
