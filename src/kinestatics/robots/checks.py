"""Is it a tree? Structural checks that all readers share, each with a code, a place and a remedy. Floor 4."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ..errors import Finding, Place, RobotFileError, nearest
from ..namespaces import Array
from .description import JointDescription, LinkDescription, Mimic, RobotDescription

NOT_YET = ("floating", "planar", "ball", "spherical")
"""Kinds of joints with several freedoms."""

MAX_JOINTS = 2000
"""In a row, from the base to a tip."""
MAX_MOVING = 5000
"""In all: matrices of joints by joints must fit into memory. Fixed joints cost nothing and are not counted."""
_SHOWN = 12
LARGEST = 1e50
"""Numbers above this overflow once lengths, masses and multipliers meet; no robot has them."""


def checked(
    name: str,
    links: Sequence[LinkDescription],
    joints: Sequence[JointDescription],
    *,
    source: str,
    base: str | None,
    findings: Sequence[Finding],
    tip: str | None = None,
) -> RobotDescription:
    """The description, after all structural checks; trees that do not hang on `base` are left out, with a finding.

    Raises:
        RobotFileError: KS106, KS121, KS130-KS137, KS152, KS153, KS155, KS170-KS172.
    """
    where = Place(source)
    if not links:
        raise RobotFileError("KS121", "robot has no <link>", "", where)
    _unique(links, "link", "KS130")
    _unique(joints, "joint", "KS131")
    _known_links(links, joints)
    _one_parent(joints)
    _no_loops(joints)
    _depth(joints)
    _limits(joints)
    _mimics(joints)
    kept, dropped = _component(links, joints, base, where)
    notes = [*findings]
    if dropped:
        shown = ", ".join(repr(link) for link in dropped[:5])
        notes.append(Finding("KS136", f"links not connected to the base are left out: {shown}", where))
    names = set(kept)
    return RobotDescription(
        name,
        tuple(link for link in links if link.name in names),
        tuple(joint for joint in joints if joint.parent in names),
        source,
        tip,
        tuple(notes),
    )


def below(
    links: list[LinkDescription], joints: list[JointDescription], base: str | None, findings: list[Finding]
) -> tuple[list[LinkDescription], list[JointDescription]]:
    """Without joints of several freedoms: only what hangs below `base` is kept, and none of them may be left there."""
    if not any(joint.kind in NOT_YET for joint in joints):
        return links, joints
    children: dict[str, list[JointDescription]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint)
    kept, stack = {base}, [base]
    while stack:
        for joint in children.get(stack.pop() or "", ()):
            if joint.kind in NOT_YET:
                message = f"joint {joint.name!r}: type {joint.kind!r} has several freedoms, which is not supported yet"
                raise RobotFileError("KS140", message, "make it fixed, or pass base= a link behind it", joint.place)
            if joint.child not in kept:
                kept.add(joint.child)
                stack.append(joint.child)
    findings.append(Finding("KS140", f"only the links below {base!r} are read: a joint of several freedoms lies elsewhere"))
    return [link for link in links if link.name in kept], [joint for joint in joints if joint.parent in kept]


def unsound_inertia(inertia: Array, mass: float, what: str, place: Place | None) -> list[Finding]:
    """What is wrong with an inertia about the centre of mass; nothing for a point mass."""
    moments = np.linalg.eigvalsh(inertia)
    slack = 1e-6 * float(np.abs(moments).max())
    if moments[0] < -slack or (mass > 0 and moments[0] <= 0 and moments[2] > slack):
        return [Finding("KS162", f"{what}: inertia is not positive definite", place)]
    if moments[0] + moments[1] < moments[2] - slack:
        return [Finding("KS163", f"{what}: no rigid body has this inertia (triangle inequality)", place)]
    return []


def unlimited(lower: float, upper: float) -> tuple[float, float]:
    """Limits as some exporters write "none", the largest double, made infinite: their distance must not overflow."""
    return (-math.inf if lower < -LARGEST else lower, math.inf if upper > LARGEST else upper)


def _unique(things: Sequence[LinkDescription] | Sequence[JointDescription], what: str, code: str) -> None:
    seen: dict[str, Place | None] = {}
    for thing in things:
        if thing.name in seen:
            first = seen[thing.name]
            line = f"; first at line {first.line}" if first is not None else ""
            raise RobotFileError(code, f"{what} {thing.name!r} is defined twice{line}", "rename one of them", thing.place)
        seen[thing.name] = thing.place


def _known_links(links: Sequence[LinkDescription], joints: Sequence[JointDescription]) -> None:
    names = [link.name for link in links]
    known = set(names)
    for joint in joints:
        for code, word, link in (("KS132", "parent", joint.parent), ("KS133", "child", joint.child)):
            if link not in known:
                message = f"joint {joint.name!r}: {word} link {link!r} does not exist"
                raise RobotFileError(code, message, nearest(link, names), joint.place)


def _one_parent(joints: Sequence[JointDescription]) -> None:
    above: dict[str, JointDescription] = {}
    for joint in joints:
        if joint.parent == joint.child:
            _loop([joint.child, joint.child], joint.place)
        if (other := above.get(joint.child)) is not None:
            message = f"link {joint.child!r} has two parents: joints {other.name!r} and {joint.name!r}"
            raise RobotFileError("KS137", message, "a robot must be a tree; closed chains are not supported", joint.place)
        above[joint.child] = joint


def _loop(links: Sequence[str], place: Place | None) -> None:
    raise RobotFileError(
        "KS135", f"loop: {_arrows(links)}", "a robot must be a tree; closed chains are not supported", place
    )


def _arrows(names: Sequence[str]) -> str:
    shown = names if len(names) <= _SHOWN else [*names[: _SHOWN - 2], "...", names[-1]]
    return " -> ".join(shown)


def _no_loops(joints: Sequence[JointDescription]) -> None:
    above = {joint.child: joint for joint in joints}
    settled: set[str] = set()
    for joint in joints:
        walk: dict[str, None] = {}  # in order, and quick to look up
        link = joint.child
        while link in above and link not in settled:
            if link in walk:
                passed = [*walk]
                loop = passed[passed.index(link) :][::-1]
                _loop([*loop, loop[0]], above[link].place)
            walk[link] = None
            link = above[link].parent
        settled.update(walk)


def _depth(joints: Sequence[JointDescription]) -> None:
    """Chains are bounded, and so is the number of joints that move; a link may have any number of fixed children."""
    moving = sum(joint.kind != "fixed" for joint in joints)
    if moving > MAX_MOVING:
        raise RobotFileError("KS106", f"{moving} joints that move; the limit is {MAX_MOVING}", "", joints[-1].place)
    above = {joint.child: joint for joint in joints}
    depth: dict[str, int] = {}
    for joint in joints:
        walk: list[str] = []
        link = joint.child
        while link in above and link not in depth:
            walk.append(link)
            link = above[link].parent
        for i, passed in enumerate(reversed(walk), start=depth.get(link, 0) + 1):
            depth[passed] = i
    deepest = max(depth.values(), default=0)
    if deepest > MAX_JOINTS:
        raise RobotFileError("KS106", f"{deepest} joints in a row; the limit is {MAX_JOINTS}", "", joints[-1].place)


def _limits(joints: Sequence[JointDescription]) -> None:
    for joint in joints:
        if joint.lower > joint.upper:
            message = f"joint {joint.name!r}: lower limit {joint.lower:g} is above upper limit {joint.upper:g}"
            raise RobotFileError("KS152", message, "exchange them", joint.place)
        if joint.lower > LARGEST or joint.upper < -LARGEST:
            message = f"joint {joint.name!r}: no position lies within its limits [{joint.lower:g}, {joint.upper:g}]"
            raise RobotFileError("KS155", message, "exchange their signs", joint.place)
        for word, value in (("effort", joint.effort), ("velocity", joint.velocity)):
            if value < 0:
                raise RobotFileError(
                    "KS153", f"joint {joint.name!r}: {word} limit is negative", "limits are sizes", joint.place
                )


def _mimics(joints: Sequence[JointDescription]) -> None:
    by_name: Mapping[str, JointDescription] = {joint.name: joint for joint in joints}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in by_name:
            message = f"joint {joint.name!r} mimics joint {joint.mimic.joint!r}, which does not exist"
            raise RobotFileError("KS170", message, nearest(joint.mimic.joint, by_name), joint.place)
    for name, (_, multiplier, offset) in leaders(joints).items():
        if not max(abs(multiplier), abs(offset)) <= LARGEST:
            message = f"joint {name!r}: the mimic multipliers in a row come to more than {LARGEST:g}"
            raise RobotFileError("KS172", message, "look for a wrong unit", by_name[name].place)


def leaders(joints: Sequence[JointDescription], held: Collection[str] = ()) -> dict[str, tuple[str, float, float]]:
    """For every joint: the joint that finally drives it, the multiplier and the offset, chains of followers multiplied out.

    Args:
        joints: all of a robot.
        held: joints that are held: they follow no more, and lead their own followers.

    Raises:
        RobotFileError: KS171, when no joint leads.
    """
    by_name = {joint.name: joint for joint in joints}
    found: dict[str, tuple[str, float, float]] = {}
    for joint in joints:
        walk: dict[str, Mimic] = {}
        name = joint.name
        while name not in found and name not in held and (mimic := by_name[name].mimic) is not None:
            walk[name], name = mimic, mimic.joint
            if name in walk:
                what = "itself" if len(walk) == 1 else _arrows([*walk, name])
                raise RobotFileError("KS171", f"joint {joint.name!r} mimics {what}", "one joint must lead", joint.place)
        found.setdefault(name, (name, 1.0, 0.0))
        for follower, mimic in reversed(walk.items()):
            leader, multiplier, offset = found[mimic.joint]
            found[follower] = (leader, mimic.multiplier * multiplier, mimic.multiplier * offset + mimic.offset)
    return found


def _component(
    links: Sequence[LinkDescription], joints: Sequence[JointDescription], base: str | None, where: Place
) -> tuple[list[str], list[str]]:
    """The links connected to the base, and the others; the base is the only root unless named."""
    children = {joint.child for joint in joints}
    roots = [link for link in links if link.name not in children]
    neighbours: dict[str, list[str]] = {link.name: [] for link in links}
    for joint in joints:
        neighbours[joint.parent].append(joint.child)
        neighbours[joint.child].append(joint.parent)
    if len(roots) > 1 and base not in neighbours:
        shown = ", ".join(repr(root.name) for root in roots[:8]) + (" ..." if len(roots) > 8 else "")
        both = "both " if len(roots) == 2 else ""
        raise RobotFileError("KS136", f"links {shown} {both}have no parent", "pass base=...", roots[1].place or where)
    start = base if base in neighbours else roots[0].name
    reached, stack = {start}, [start]
    while stack:
        for link in neighbours[stack.pop()]:
            if link not in reached:
                reached.add(link)
                stack.append(link)
    return [link.name for link in links if link.name in reached], [link.name for link in links if link.name not in reached]
