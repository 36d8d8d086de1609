"""The points an arm is drawn through: joints, links and frames at one posture, in base axes. Floor 9."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import definition
from .errors import ArrayTypeError, ConfigurationError, UnknownNameError
from .frames import TIP
from .kinematics import configuration, require_model
from .model import RobotModel
from .namespaces import Array, as_array
from .spatial import ANGULAR, LINEAR
from .tasks import characteristic_length

_SAME = 1e-9  # sines of angles, and lengths as a share of the size, below which two things are one


@dataclass(frozen=True, eq=False)
class DrawnJoint:
    """A moving joint: where it is, and about or along which direction it moves.

    Attributes:
        name, kind: of the joint; column: of the Jacobian.
        point: (3) on its axis, fixed in the link before [m]; end: (3) the same point moved by the joint.
        direction: (3) unit vector.
    """

    name: str
    kind: str
    column: int
    point: Array
    end: Array
    direction: Array


@dataclass(frozen=True, eq=False)
class Skeleton:
    """An arm at one posture, as points in base axes [m].

    Attributes:
        links: (2, 3) lines of the links; rods: (2, 3) lines along which joints have slid.
        joints: all moving joints, parents first; frames: their (R, p).
        tip: (R, p) of the link asked for, or None; tip_link: its name.
        size: length by which signs are scaled [m].
    """

    links: tuple[Array, ...]
    rods: tuple[Array, ...]
    joints: tuple[DrawnJoint, ...]
    frames: tuple[tuple[Array, Array], ...]
    tip: tuple[Array, Array] | None
    tip_link: str
    size: float

    @property
    def tip_point(self) -> Array:
        """(3) origin of the link asked for; the base's origin where there is none."""
        return np.zeros(3) if self.tip is None else self.tip[1]

    @property
    def points(self) -> Array:
        """(k, 3) everything the picture must hold."""
        ends = [point for line in (*self.links, *self.rods) for point in line]
        return np.array([np.zeros(3), *ends, *(joint.point for joint in self.joints)])


def one_configuration(model: RobotModel, q: Any) -> Array:
    """q (n) in NumPy; the home of the robot for None.

    Raises:
        ArrayTypeError: KS302 for another array library or symbols; ConfigurationError: KS303 for a batch.
    """
    require_model(model)
    if model.is_symbolic:
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths", "put numbers in place of the symbols")
    array, xp = configuration(model, model.home if q is None else q)
    if xp.name != "numpy":
        raise ArrayTypeError("KS302", f"pictures are drawn with NumPy; q is an array of {xp.name}", "np.asarray(q) first")
    if array.ndim != 1:
        hint = f"draw them one by one; got shape {tuple(array.shape)}"
        raise ConfigurationError("KS303", "a picture shows one configuration", hint)
    return np.array(array, dtype=np.float64)


def skeleton(model: RobotModel, q: Array, at: str = TIP, required: bool = False) -> Skeleton:
    """The points of an arm at q (n); `required` asks for a tip, which a tree need not have."""
    tip_index = model.link(at) if required else _tip_index(model, at)
    array, xp = as_array(q)
    poses = definition.joint_poses(model, array, xp)
    joints = _joints(model, poses, q)
    lines = [
        line for i, p in enumerate(model.parents) for line in _link(joints, p, joints[i].point, _foot(joints, poses, i, p))
    ]
    leaves = [i for i in range(len(joints)) if i not in model.parents]
    lines += [line for i in leaves for line in _link(joints, i, _leaf(model, poses, i, q))]
    tip = None
    if tip_index is not None:
        tip = definition.link_pose(model, poses, tip_index, array, xp)
        lines += _link(joints, model.link_joints[tip_index], tip[1])
    size = _size(model, [*(joint.point for joint in joints), *(end for _, end in lines)], at if tip is not None else None)
    rods = [(joint.point, joint.end) for joint in joints]
    return Skeleton(
        links=_distinct(lines, size),
        rods=_distinct(rods, size),
        joints=tuple(joints),
        frames=tuple(zip(poses.R, poses.p, strict=True)),
        tip=tip,
        tip_link="" if tip_index is None else model.link_name(tip_index),
        size=size,
    )


def rigid_lines(model: RobotModel, at: str = TIP) -> tuple[tuple[int, Array], ...]:
    """The lines of the links, each with what carries it: they move with it, and keep their shape at every posture.

    Returns:
        Pairs of a moving joint (-1: the base) and (2, 3) in the axes of its frame [m].

    Example:
        >>> import kinestatics as ks
        >>> lines = rigid_lines(ks.load("planar_2r"))
        >>> [(carrier, round(float(np.linalg.norm(line[1] - line[0])), 9)) for carrier, line in lines]
        [(0, 1.0), (1, 1.0)]
    """
    q = one_configuration(model, None)
    array, xp = as_array(q)
    poses = definition.joint_poses(model, array, xp)
    joints = _joints(model, poses, q)
    found = [(p, _link(joints, p, joints[i].point, _foot(joints, poses, i, p))) for i, p in enumerate(model.parents)]
    found += [(i, _link(joints, i, _leaf(model, poses, i, q))) for i in range(len(joints)) if i not in model.parents]
    if (tip := _tip_index(model, at)) is not None:
        carrier = model.link_joints[tip]
        found.append((carrier, _link(joints, carrier, definition.link_pose(model, poses, tip, array, xp)[1])))
    size = _size(model, [*(joint.point for joint in joints), *(end for _, line in found for _, end in line)], None)
    kept: list[tuple[int, Array]] = []
    for carrier in sorted({carrier for carrier, _ in found}):
        R, p = (np.eye(3), np.zeros(3)) if carrier < 0 else (poses.R[carrier], poses.p[carrier])
        lines = [line for owner, several in found if owner == carrier for line in several]
        kept += [(carrier, (line - p) @ R) for line in _distinct(lines, size)]
    return tuple(kept)


def _tip_index(model: RobotModel, at: str) -> int | None:
    """The link asked for; None where a robot without a tip is drawn as a whole."""
    try:
        return model.link(at)
    except UnknownNameError:
        if at == TIP and model.tip is None:
            return None
        raise


def _joints(model: RobotModel, poses: definition.JointPoses, q: Array) -> list[DrawnJoint]:
    """All moving joints, parents first."""
    return [_joint(model, poses, i, q) for i in range(len(model.parents))]


def _joint(model: RobotModel, poses: definition.JointPoses, i: int, q: Array) -> DrawnJoint:
    """A joint, drawn at its frame's origin; where its axis passes elsewhere, at its point nearest to that origin."""
    R, p, screw = poses.R[i], poses.p[i], model.screws[i]
    v, w = R @ screw[LINEAR], R @ screw[ANGULAR]
    direction = w if np.any(w) else v
    moved = model.multipliers[i] * q[model.columns[i]] + model.offsets[i]
    advance = moved * float(v @ direction)
    foot = p + np.cross(w, v)
    on_axis = not np.any(w) or float(np.linalg.norm(np.cross(w, v))) < _SAME
    end = p if on_axis else foot
    return DrawnJoint(model.moving_names[i], model.kinds[i], model.columns[i], end - advance * direction, end, direction)


def _link(joints: list[DrawnJoint], carrier: int, point: Array, foot: Array | None = None) -> list[tuple[Array, Array]]:
    """The lines of a link, as in a DH table: from its joint along the axis, straight across to a foot, then to the point."""
    if carrier < 0:
        return [(np.zeros(3), point)]
    foot = point if foot is None else foot
    start, direction = joints[carrier].end, joints[carrier].direction
    corner = start + direction * float(direction @ (foot - start))
    return [(start, corner), (corner, foot), (foot, point)]


def _foot(joints: list[DrawnJoint], poses: definition.JointPoses, joint: int, carrier: int) -> Array | None:
    """The origin of the frame that carries a joint, where it lies on the joint's axis; a DH frame does."""
    if carrier < 0:
        return None
    arm = poses.p[carrier] - joints[joint].point
    aside = float(np.linalg.norm(np.cross(arm, joints[joint].direction)))
    return poses.p[carrier] if aside <= _SAME * max(1.0, float(np.linalg.norm(arm))) else None


def _leaf(model: RobotModel, poses: definition.JointPoses, joint: int, q: Array) -> Array:
    """The farthest origin of the links behind a joint that carries no other."""
    array, xp = as_array(q)
    carried = [link for link, carrier in enumerate(model.link_joints) if carrier == joint]
    origins = [definition.link_pose(model, poses, link, array, xp)[1] for link in carried]
    return max(origins, key=lambda p: float(np.linalg.norm(p - poses.p[joint])), default=poses.p[joint])


def _size(model: RobotModel, points: list[Array], at: str | None) -> float:
    """The arm's reach to the tip, or the posture's largest extent where that is larger or there is no tip."""
    extent = float(np.ptp(np.array([np.zeros(3), *points]), axis=0).max())
    return max(characteristic_length(model, at) if at is not None else 0.0, extent) or 1.0


def _distinct(lines: list[tuple[Array, Array]], size: float) -> tuple[Array, ...]:
    """Lines that have a length, each once."""
    kept: dict[bytes, Array] = {}
    for a, b in lines:
        if float(np.linalg.norm(b - a)) > _SAME * size:
            line = np.array([a, b])
            kept.setdefault(np.round(line / (_SAME * size)).astype(np.int64).tobytes(), line)
    return tuple(kept.values())


def plane_of(model: RobotModel) -> Array | None:
    """(2, 3) unit vectors, in base axes, of the plane in which every joint moves every point; None for an arm of space.

    All axes of turning are at right angles to it, all directions of travel lie in it: true at one posture, true at all.
    xy, xz and yz of the base are taken as they are, seen with the first axis to the right and the second up.
    """
    q, xp = as_array(np.asarray(model.home, dtype=np.float64))
    poses = definition.joint_poses(model, q, xp)
    turning = [R @ screw[ANGULAR] for R, screw in zip(poses.R, model.screws, strict=True) if np.any(screw[ANGULAR])]
    sliding = [R @ screw[LINEAR] for R, screw in zip(poses.R, model.screws, strict=True) if not np.any(screw[ANGULAR])]
    pitches = [abs(float(screw[LINEAR] @ screw[ANGULAR])) for screw in model.screws]
    normal = turning[0] if turning else _normal_of(sliding)
    if normal is None or any(pitch > _SAME for pitch in pitches):
        return None
    if any(float(np.linalg.norm(np.cross(normal, w))) > _SAME for w in turning):
        return None
    if any(abs(float(normal @ v)) > _SAME for v in sliding):
        return None
    return _seen_from(normal)


def _normal_of(directions: list[Array]) -> Array | None:
    """Unit normal of the plane of two directions of travel, where they have one."""
    for v in directions[1:]:
        normal = np.cross(directions[0], v)
        if (length := float(np.linalg.norm(normal))) > _SAME:
            return normal / length
    return None


def _seen_from(normal: Array) -> Array:
    """The plane's axes to the right and up: those of the base where they lie in it, else level and rising."""
    for k, pair in ((2, (0, 1)), (1, (0, 2)), (0, (1, 2))):
        if abs(abs(float(normal[k])) - 1.0) < _SAME:
            return np.eye(3)[list(pair)]
    level = np.array([-normal[1], normal[0], 0.0]) / np.hypot(normal[0], normal[1])
    level = level if level[int(np.argmax(np.abs(level)))] > 0 else -level
    rising = np.cross(normal, level)
    return np.array([level, rising if rising[2] > 0 else -rising])
