"""From MuJoCo's compiled bodies to links and joints, with a name for each. Floor 4."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..errors import Finding
from ..namespaces import Array, as_array
from ..spatial import pose_matrix, quaternion_to_rotation, screw_motion
from .checks import unlimited
from .description import JointDescription, LinkDescription
from .mjcf_source import Source

KINDS = {"slide": "prismatic", "ball": "ball", "free": "floating"}


class Names:
    """Names of links and joints: MuJoCo's own where there are any, else stable ones made from the place in the tree.

    Attributes:
        links: of each body; joints: of each joint; sites: of each site, as a link, None where it has no name.
        findings: what was renamed.
    """

    def __init__(self, answer: dict[str, Any], source: Source) -> None:
        bodies, joints, sites = answer["bodies"], answer["joints"], answer["sites"]
        self.findings: list[Finding] = []
        self._links = {body["name"] for body in bodies if body["name"]}
        self._joints = {joint["name"] for joint in joints if joint["name"]}
        self.links = [body["name"] or self.link(f"body{body['id']}") for body in bodies]
        self.joints = [joint["name"] or self.joint(f"{self.links[joint['body']]}_joint") for joint in joints]
        self.sites = [self._site(site, source) if site["name"] else None for site in sites]

    def link(self, wanted: str) -> str:
        """A link name that is still free."""
        return _free(wanted, self._links)

    def joint(self, wanted: str) -> str:
        """A joint name that is still free."""
        return _free(wanted, self._joints)

    def _site(self, site: dict[str, Any], source: Source) -> str:
        name: str = site["name"]
        if name not in self._links:
            return self.link(name)
        other = self.link(f"{name}_site")
        message = f"site {name!r} has the name of a body; as a link it is called {other!r}"
        self.findings.append(Finding("KS126", message, source.place(site["line"])))
        return other


def _free(wanted: str, taken: set[str]) -> str:
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted}{number}"
    taken.add(name)
    return name


def pose(entry: dict[str, Any]) -> Array:
    """(4, 4) of a body or site in its parent body."""
    xp, position = _numpy(entry["position"])
    return pose_matrix(quaternion_to_rotation(*entry["quaternion"]), position, xp)


def _numpy(value: Iterable[float]) -> tuple[Any, Array]:
    array, xp = as_array(np.array(list(value), dtype=float))
    return xp, array


def links_of(answer: dict[str, Any], names: Names, source: Source) -> list[LinkDescription]:
    """The bodies, with the masses that MuJoCo has compiled; inertias about the centre of mass, in link axes."""
    links = []
    for body, name in zip(answer["bodies"], names.links, strict=True):
        R = quaternion_to_rotation(*body["axes"])
        inertia = R @ np.array(body["inertia"]) @ R.T
        mass = 0.0 if name == "world" else body["mass"]
        links.append(LinkDescription(name, mass, np.array(body["center"]), inertia, source.place(body["line"])))
    return links


def joints_of(
    answer: dict[str, Any], names: Names, source: Source
) -> tuple[list[JointDescription], dict[int, int], list[LinkDescription]]:
    """The joints in the order of the tree, where each of MuJoCo's stands among them, and the massless links between two.

    MuJoCo moves a body by its joints in turn, each seen in the body's own axes as the joints before have left them, from the
    position that `ref` names: body = placement · Π exp((q - ref) · screw).
    """
    of_body: dict[int, list[dict[str, Any]]] = {}
    for joint in answer["joints"]:
        of_body.setdefault(joint["body"], []).append(joint)
    joints: list[JointDescription] = []
    index: dict[int, int] = {}
    between: list[LinkDescription] = []
    for body in answer["bodies"]:
        if body["id"] == 0:
            continue
        child, T = names.links[body["id"]], pose(body)
        parent, place = names.links[body["parent"]], source.place(body["line"])
        own = of_body.get(body["id"], [])
        if not own:
            joints.append(JointDescription(names.joint(f"{child}_fixed"), "fixed", parent, child, T, place=place))
        for number, joint in enumerate(own, start=1):
            reached = child
            if number < len(own):
                reached = names.link(f"{child}_before_{names.joints[own[number]['id']]}")
                between.append(LinkDescription(reached, place=place))
            index[joint["id"]] = len(joints)
            joints.append(_joint(joint, names.joints[joint["id"]], parent, reached, T, source))
            parent, T = reached, np.eye(4)
    return joints, index, between


def _joint(joint: dict[str, Any], name: str, parent: str, child: str, T: Array, source: Source) -> JointDescription:
    place = source.place(joint["line"])
    if joint["kind"] in ("ball", "free"):
        return JointDescription(name, KINDS[joint["kind"]], parent, child, T, place=place)
    axis, anchor = np.array(joint["axis"]), np.array(joint["anchor"])
    slides = joint["kind"] == "slide"
    screw = np.concatenate([axis, np.zeros(3)] if slides else [np.cross(anchor, axis), axis])
    if joint["reference"] != 0.0:
        xp, back = _numpy([-joint["reference"]])
        R, p = screw_motion(screw[None], back, xp)
        T = T @ pose_matrix(R[0], p[0], xp)
    kind = "prismatic" if slides else "continuous" if joint["range"] is None else "revolute"
    lower, upper = unlimited(*joint["range"]) if joint["range"] else (-np.inf, np.inf)
    return JointDescription(name, kind, parent, child, T, screw, lower, upper, place=place)


def sites_of(answer: dict[str, Any], names: Names, source: Source) -> tuple[list[LinkDescription], list[JointDescription]]:
    """Named sites as links that are fixed to their bodies."""
    links, joints = [], []
    for site, name in zip(answer["sites"], names.sites, strict=True):
        if name is None:
            continue
        place = source.place(site["line"])
        links.append(LinkDescription(name, place=place))
        parent = names.links[site["body"]]
        joints.append(JointDescription(names.joint(f"{name}_fixed"), "fixed", parent, name, pose(site), place=place))
    return links, joints


def default_tip(answer: dict[str, Any], names: Names) -> str | None:
    """The only moving body at the end of a branch, or the only site on it; None where there are several ends.

    Sites along the arm are no ends: without this every one of them would be a possible tip.
    """
    parents = {body["parent"] for body in answer["bodies"]}
    jointed = {joint["body"] for joint in answer["joints"]}
    moving: set[int] = set()
    for body in answer["bodies"]:  # parents come before their children
        if body["id"] in jointed or body["parent"] in moving:
            moving.add(body["id"])
    leaves = [body["id"] for body in answer["bodies"] if body["id"] in moving and body["id"] not in parents]
    if len(leaves) != 1:
        return None
    on_leaf = [name for site, name in zip(answer["sites"], names.sites, strict=True) if name and site["body"] == leaves[0]]
    return on_leaf[0] if len(on_leaf) == 1 else names.links[leaves[0]]
