"""What a MuJoCo model says besides its tree: force limits, couplings, the home position, unknown masses. Floor 4.

Each function takes the joints of the tree and returns them completed; what cannot be taken over is a finding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import Finding, Place, RobotFileError, nearest
from .checks import leaders, unsound_inertia
from .description import JointDescription, LinkDescription, Mimic
from .mjcf_source import Source
from .mjcf_tree import Names


def with_efforts(
    joints: Sequence[JointDescription], index: dict[int, int], answer: dict[str, Any], findings: list[Finding]
) -> list[JointDescription]:
    """Effort limits from the joint's actuatorfrcrange and from the actuators that drive it, whichever is less."""
    completed = list(joints)
    driving: dict[str, list[dict[str, Any]]] = {}
    for actuator in answer["actuators"]:
        driving.setdefault(actuator["joint"], []).append(actuator)
    for joint in answer["joints"]:
        ranges = [joint["force"]] if joint["force"] is not None else []
        actuators = driving.get(joint["name"], []) if joint["name"] else []
        if actuators and all(actuator["force"] is not None for actuator in actuators):
            ranges.append([sum(actuator["force"][end] for actuator in actuators) for end in (0, 1)])
        if joint["kind"] not in ("hinge", "slide") or not ranges:
            continue
        low, high = max(r[0] for r in ranges), min(r[1] for r in ranges)
        i = index[joint["id"]]
        if low < 0 < high:
            completed[i] = replace(joints[i], effort=float(min(-low, high)))
        if low != -high:
            taken = "the smaller is used" if low < 0 < high else "it is taken as unknown"
            message = f"joint {joints[i].name!r}: force limits {low:g} and {high:g} are not symmetric; {taken}"
            findings.append(Finding("KS156", message, joints[i].place))
    return completed


def with_couplings(
    joints: Sequence[JointDescription],
    index: dict[int, int],
    answer: dict[str, Any],
    source: Source,
    findings: list[Finding],
) -> list[JointDescription]:
    """<equality><joint> with a straight line as its polynomial makes a follower; other equalities are findings.

    MuJoCo: y - y0 = a0 + a1 (x - x0) + ..., with x0 and y0 the references of the two joints.

    Raises:
        RobotFileError: KS170, a joint that is not there.
    """
    completed = list(joints)
    by_name = {joint["name"]: joint for joint in answer["joints"] if joint["name"]}
    for equality in answer["equalities"]:
        place = source.place(equality["line"])
        if not equality["active"]:
            continue
        if equality["type"] != "joint":
            message = f"<equality><{equality['type']}> is not modelled: a closed loop is taken as open there"
            findings.append(Finding("KS173", message, place))
            continue
        for name in (equality["follower"], equality["leader"]):
            if name and name not in by_name:
                message = f"<equality> names joint {name!r}, which does not exist"
                raise RobotFileError("KS170", message, nearest(name, by_name), place)
        trouble = _couple(equality, completed, index, by_name)
        if trouble:
            message = f"the coupling of joint {equality['follower']!r} is not modelled: {trouble}; it moves freely"
            findings.append(Finding("KS174", message, place))
    return completed


def _couple(
    equality: dict[str, Any], joints: list[JointDescription], index: dict[int, int], by_name: dict[str, dict[str, Any]]
) -> str:
    """Makes one joint follow another; else says why not."""
    a0, a1, *rest = equality["coefficients"]
    if not equality["leader"]:
        return "it holds the joint at a value (hold it with joints={...})"
    if any(rest):
        return "its polynomial is no straight line"
    follower, leader = by_name[equality["follower"]], by_name[equality["leader"]]
    if not {follower["kind"], leader["kind"]} <= {"hinge", "slide"}:
        return "a joint of several freedoms takes part"
    i = index[follower["id"]]
    if joints[i].mimic is not None:
        return "it already follows another joint"
    offset = follower["reference"] + a0 - a1 * leader["reference"]
    before = joints[i]
    joints[i] = replace(before, mimic=Mimic(joints[index[leader["id"]]].name, a1, offset))
    try:
        leaders(joints)
    except RobotFileError:
        joints[i] = before
        return "the joints follow one another in a circle"
    return ""


def with_home(
    joints: Sequence[JointDescription],
    index: dict[int, int],
    answer: dict[str, Any],
    source: Source,
    findings: list[Finding],
) -> list[JointDescription]:
    """The keyframe called "home"; without one, where MuJoCo starts: every joint at its reference."""
    completed = list(joints)
    for joint in answer["joints"]:
        if joint["kind"] in ("hinge", "slide"):
            i = index[joint["id"]]
            completed[i] = replace(joints[i], home=joint["reference"])
    home = answer["home"]
    if not home:
        return completed
    if source.partial or len(home) != answer["nq"]:
        message = f"keyframe 'home' has {len(home)} numbers for {answer['nq']} coordinates; it is not used"
        findings.append(Finding("KS157", message, Place(str(source.path))))
        return completed
    for joint in answer["joints"]:
        if joint["kind"] in ("hinge", "slide"):
            i = index[joint["id"]]
            completed[i] = replace(joints[i], home=home[joint["address"]])
    return completed


def settle_masses(
    links: Sequence[LinkDescription],
    answer: dict[str, Any],
    names: Names,
    base: str | None,
    findings: list[Finding],
) -> list[LinkDescription]:
    """The links with their masses, or all without: where one that counts is unknown, gravity must be an error, not wrong."""
    jointed = {joint["body"] for joint in answer["joints"]}
    moving: set[int] = set()
    unknown = []
    for body, link in zip(answer["bodies"], links, strict=True):
        i = body["id"]
        if i in jointed or (i and body["parent"] in moving):
            moving.add(i)
        if body["own_inertia"]:
            findings.extend(unsound_inertia(link.inertia, link.mass, f"link {link.name!r}", link.place))
        if body["mass_unknown"] and i:
            unknown.append(i)
            why = answer.get("mesh_trouble", "").partition("\n")[0] or "the mesh that gives it is missing"
            findings.append(Finding("KS165", f"link {link.name!r}: mass is unknown: {why}", link.place))
        elif link.mass == 0 and i in jointed:
            findings.append(Finding("KS161", f"link {link.name!r} has no mass: it weighs nothing", link.place))
    at_root = base in (None, names.links[0])
    if any(i in moving or not at_root or answer["total_mass_is_set"] for i in unknown):
        findings.append(Finding("KS165", "masses are left out: one that counts is unknown", links[unknown[0]].place))
        return [replace(link, mass=0.0, inertia=np.zeros((3, 3))) for link in links]
    return list(links)
