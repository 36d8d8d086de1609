"""From a description to a RobotModel: choose base and tip, hold side branches, fold mimic joints. Floor 4.

The links form a tree. It is hung up at `base`, which may be any link: a joint passed from child to parent is turned
round (its screw changes sign). Joints that are not asked for are held at a value, so that what hangs on them keeps its
place and its mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import RobotDefinitionError, UnknownNameError, nearest
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..spatial import inverse_pose, pose_matrix, screw_motion
from .arguments import checked_number
from .checks import leaders
from .description import JointDescription, RobotDescription


@dataclass(frozen=True)
class _Step:
    """One joint of the tree as met when walking away from the base."""

    joint: JointDescription
    reached: str
    reversed: bool


def assemble(
    robot: RobotDescription,
    base: str | None = None,
    tip: str | None = None,
    joints: Mapping[str, float] | None = None,
    whole_tree: bool = False,
) -> RobotModel:
    """The RobotModel of the chain from `base` to `tip`, or of the whole tree.

    Args:
        robot: a description whose structure has been checked.
        base, tip: link names; default the root, and the only moving leaf.
        joints: joints to hold, by name [rad or m]. Joints off the path are held at these values, or at home or zero.
        whole_tree: keep every moving joint as a column, on the path or not.

    Raises:
        UnknownNameError: KS310 or KS313, a link or joint of that name does not exist.
        RobotDefinitionError: KS314 several leaves and no tip.
    """
    names = [link.name for link in robot.links]
    base = _known_link(base, names) if base is not None else _root(robot)
    walk = _walk(robot, base)
    tip = _known_link(tip, names) if tip is not None else _default_tip(robot, base, walk, whole_tree)
    asked = dict(joints or {})
    driven_by = leaders(robot.joints, held=asked)
    masters = {joint.name: driven_by[joint.name] for joint in robot.joints if joint.kind != "fixed"}
    held = _held(robot, walk, tip, asked, masters, whole_tree)
    return _build(robot, base, tip, walk, held, masters)


def _known_link(name: str, names: list[str]) -> str:
    if name not in names:
        raise UnknownNameError("KS310", f"the robot has no link {name!r}", nearest(name, names))
    return name


def _root(robot: RobotDescription) -> str:
    children = {joint.child for joint in robot.joints}
    return next(link.name for link in robot.links if link.name not in children)


def _walk(robot: RobotDescription, base: str) -> list[_Step]:
    """Every joint reachable from the base, depth first in the order of the file, parents before children."""
    neighbours: dict[str, list[_Step]] = {link.name: [] for link in robot.links}
    for joint in robot.joints:
        neighbours[joint.parent].append(_Step(joint, joint.child, False))
        neighbours[joint.child].append(_Step(joint, joint.parent, True))
    steps: list[_Step] = []
    seen, stack = {base}, list(reversed(neighbours[base]))
    while stack:
        step = stack.pop()
        if step.reached in seen:
            continue
        seen.add(step.reached)
        steps.append(step)
        stack.extend(s for s in reversed(neighbours[step.reached]) if s.reached not in seen)
    return steps


def _path(walk: list[_Step], link: str) -> list[JointDescription]:
    """The joints from the base to `link`."""
    step_to = {step.reached: step for step in walk}
    path: list[JointDescription] = []
    while link in step_to:
        step = step_to[link]
        path.append(step.joint)
        link = step.joint.child if step.reversed else step.joint.parent
    return path[::-1]


def _default_tip(robot: RobotDescription, base: str, walk: list[_Step], whole_tree: bool) -> str | None:
    step_to = {step.reached: step for step in walk}
    if robot.tip is not None and robot.tip in step_to:
        return robot.tip
    parents = {joint.parent for joint in robot.joints}
    forward: list[str] = []
    moving: dict[str, bool] = {base: False}
    for step in walk:  # a leaf that cannot move, or that lies behind the base, is no tip
        before = step.joint.child if step.reversed else step.joint.parent
        moving[step.reached] = moving[before] or step.joint.kind != "fixed"
        if not step.reversed and step.reached not in parents and moving[step.reached]:
            forward.append(step.reached)
    if len(forward) == 1:
        return forward[0]
    if whole_tree:
        return None
    if not forward and not walk:
        return base
    leaves = forward or [step.reached for step in walk]
    shown = ", ".join(leaves[:20]) + (f" and {len(leaves) - 20} more" if len(leaves) > 20 else "")
    raise RobotDefinitionError(
        "KS314",
        f"robot {robot.name!r} has {len(leaves)} possible tips from base {base!r}: {shown}",
        f"pass tip={leaves[0]!r} or another for a chain, or whole_tree=True to keep all joints (in a shell: --tip)",
    )


def _rest(joint: JointDescription) -> float:
    """Where a joint is held when nobody says where: home, else zero, else the limit nearest to zero."""
    return joint.home if joint.home is not None else float(np.clip(0.0, joint.lower, joint.upper))


def _held(
    robot: RobotDescription,
    walk: list[_Step],
    tip: str | None,
    asked: dict[str, float],
    masters: dict[str, tuple[str, float, float]],
    whole_tree: bool,
) -> dict[str, float]:
    """The value of every joint that is not to move."""
    for name, value in asked.items():
        if name not in masters:
            raise UnknownNameError("KS313", f"the robot has no moving joint {name!r}", nearest(name, masters))
        try:
            asked[name] = checked_number(value, "the value")
        except RobotDefinitionError:
            message = f"joint {name!r} is held at {value!r}"
            raise RobotDefinitionError("KS301", message, "give a finite value in rad or m") from None
    path = _path(walk, tip) if tip is not None else []
    wanted = {masters[joint.name][0] for joint in path if joint.kind != "fixed"}
    by_name = {joint.name: joint for joint in robot.joints}
    held = {name: float(value) for name, value in asked.items()}
    for name, (master, multiplier, offset) in masters.items():
        if name in held:
            continue
        if by_name[master].kind == "fixed":  # a follower of a joint that does not move
            held[name] = offset
        elif master in asked:
            held[name] = multiplier * asked[master] + offset
        elif not whole_tree and master not in wanted:
            held[name] = multiplier * _rest(by_name[master]) + offset
    return held


def _motion(joint: JointDescription, value: float) -> Array:
    """joint.placement · exp(value · screw), (4, 4)."""
    if value == 0.0 or joint.kind == "fixed":
        return joint.placement
    q, xp = as_array(np.array([value]) if joint.screw.dtype != object else np.array([value], dtype=object))
    R, p = screw_motion(joint.screw[None], q, xp)
    return joint.placement @ pose_matrix(R[0], p[0], xp)


def _build(
    robot: RobotDescription,
    base: str,
    tip: str | None,
    walk: list[_Step],
    held: dict[str, float],
    masters: dict[str, tuple[str, float, float]],
) -> RobotModel:
    exact = any(object in (j.placement.dtype, j.screw.dtype) for j in robot.joints)
    identity = np.eye(4, dtype=int).astype(object) if exact else np.eye(4)
    carried: dict[str, tuple[int, Array]] = {base: (-1, identity)}
    moving: list[JointDescription] = []
    parents: list[int] = []
    placements: list[Array] = []
    screws: list[Array] = []
    for step in walk:
        joint = step.joint
        carrier, T = carried[joint.child if step.reversed else joint.parent]
        if joint.kind == "fixed" or joint.name in held:
            hop = _motion(joint, held.get(joint.name, 0.0))
            carried[step.reached] = (carrier, T @ (inverse_pose(hop) if step.reversed else hop))
            continue
        parents.append(carrier)
        placements.append(T if step.reversed else T @ joint.placement)
        screws.append(-joint.screw if step.reversed else joint.screw)
        carried[step.reached] = (len(moving), inverse_pose(joint.placement) if step.reversed else identity)
        moving.append(joint)
    columns = _column_order(moving, masters, [joint.name for joint in (_path(walk, tip) if tip else [])])
    drivers = {joint.name: joint for joint in robot.joints}
    links = [link for link in robot.links if link.name in carried]
    dtype = object if exact else float
    return RobotModel(
        name=robot.name,
        base=base,
        tip=tip,
        joint_names=tuple(columns),
        moving_names=tuple(joint.name for joint in moving),
        kinds=tuple(joint.kind for joint in moving),
        parents=tuple(parents),
        placements=np.array(placements, dtype=dtype).reshape(-1, 4, 4),
        screws=np.array(screws, dtype=dtype).reshape(-1, 6),
        columns=tuple(columns.index(masters[joint.name][0]) for joint in moving),
        multipliers=np.array([masters[joint.name][1] for joint in moving], dtype=float),
        offsets=np.array([masters[joint.name][2] for joint in moving], dtype=float),
        link_names=tuple(link.name for link in links),
        link_joints=tuple(carried[link.name][0] for link in links),
        link_placements=np.array([carried[link.name][1] for link in links], dtype=dtype).reshape(-1, 4, 4),
        masses=np.array([link.mass for link in links]),
        centers_of_mass=np.array([link.center_of_mass for link in links]).reshape(-1, 3),
        inertias=np.array([link.inertia for link in links]).reshape(-1, 3, 3),
        lower=np.array([drivers[name].lower for name in columns], dtype=float),
        upper=np.array([drivers[name].upper for name in columns], dtype=float),
        velocity_limits=np.array([drivers[name].velocity for name in columns], dtype=float),
        effort_limits=np.array([drivers[name].effort for name in columns], dtype=float),
        home=np.array([_rest(drivers[name]) for name in columns], dtype=float),
        frozen={name: value for name, value in held.items() if name in masters and masters[name][0] == name},
        source=robot.source,
        findings=robot.findings,
        file=robot.file,
        digest=robot.digest,
    )


def _column_order(
    moving: list[JointDescription], masters: dict[str, tuple[str, float, float]], path: list[str]
) -> list[str]:
    """Independent joints: first in the order of the path from base to tip, then as they are met in the tree."""
    met = {joint.name for joint in moving}
    order = [masters[name][0] for name in path if name in met] + [masters[joint.name][0] for joint in moving]
    return list(dict.fromkeys(order))
