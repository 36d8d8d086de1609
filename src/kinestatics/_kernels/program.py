"""From a RobotModel to the program the kernels run.

Every joint gets a canonical frame whose z axis is the joint's axis. Between two such frames lies a fixed rotation
Rz(a) Rx(α) Rz(b): the turn a about the axis before is added to that joint's angle, b to the joint's own, so that only
Rx(α) is left, and it is often a right angle. Turns of whole quarters are counted as integers and stay exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR, LINEAR, rotation_z, split_pose

REVOLUTE, PRISMATIC, HELICAL = 0, 1, 2
_NONE, _PLUS_90, _MINUS_90, _GENERAL, _MATRIX = 0, 1, 2, 3, 4
_CLEAN = 1e-15  # entries of a rotation this close to 0 or ±1 are rounding noise of a right angle

JOINT = np.dtype(
    [
        ("turn", "i4"),
        ("shift_mask", "i4"),
        ("kind", "i4"),
        ("quarter", "i4"),
        ("column", "i4"),
        ("parent", "i4"),
        ("add", "i4"),
        ("branches", "i4"),
        ("plain", "i4"),
        ("ca", "f8"),
        ("sa", "f8"),
        ("p", "f8", 3),
        ("scale", "f8"),
        ("offset", "f8"),
        ("lift", "f8"),
        ("lift0", "f8"),
        ("cosine", "f8"),
        ("sine", "f8"),
        ("matrix", "f8", 9),
        ("mass", "f8"),
        ("subtree_mass", "f8"),
        ("moment", "f8", 3),
        ("rounder", "f8"),
    ],
    align=True,
)


@dataclass
class _Canonical:
    """One joint while the program is being made: the canonical frame seen from the joint's own, and what is known so far."""

    kind: int
    pitch: float
    R_joint_axis: Array
    p_joint_axis: Array
    turned: float = 0.0  # rotation about z given away by the frame behind (a of the next joint)
    matrix: Array = field(default_factory=lambda: np.eye(3))
    alpha: tuple[float, float] = (1.0, 0.0)
    p: Array = field(default_factory=lambda: np.zeros(3))
    own: float = 0.0  # b
    whole: bool = False  # the fixed rotation is kept as a matrix


def _clean(R: Array) -> Array:
    R = R.copy()
    for value in (-1.0, 0.0, 1.0):
        R[np.abs(R - value) < _CLEAN] = value
    return R


def _axis_frame(screw: Array) -> _Canonical:
    """The frame with z along the axis of a unit screw; right-angled permutations where the axis is a coordinate axis."""
    v, w = screw[LINEAR], screw[ANGULAR]
    turns = bool(np.any(w))
    z = w if turns else v
    pitch = float(v @ w) if turns else 1.0
    point = np.cross(w, v) if turns else np.zeros(3)
    kind = PRISMATIC if not turns else HELICAL if abs(pitch) > 1e-15 * (1.0 + float(np.abs(v).max())) else REVOLUTE
    k = int(np.argmax(np.abs(z)))
    x = np.zeros(3)
    x[(k + 1) % 3] = 1.0
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return _Canonical(kind, pitch, _clean(np.stack([x, np.cross(z, x), z], axis=1)), point)


def _split(R: Array) -> tuple[float, tuple[float, float], float]:
    """a, (cos α, sin α), b with R = Rz(a) Rx(α) Rz(b); of the two solutions the one with the smaller turns."""
    sine = math.hypot(R[0, 2], R[1, 2])
    if sine < _CLEAN:
        cosine = 1.0 if R[2, 2] > 0 else -1.0
        return math.atan2(R[1, 0], R[0, 0]), (cosine, 0.0), 0.0
    options = []
    for sign in (1.0, -1.0):
        a = math.atan2(sign * R[0, 2], -sign * R[1, 2])
        M = rotation_z(-a) @ R  # Rx(α) Rz(b): b from its first row is well determined, however small sin α is
        b = math.atan2(-M[0, 1], M[0, 0])
        options.append((abs(a) + abs(b) + (0.01 if sign < 0 else 0.0), a, b, sign * sine))
    _, a, b, sine = min(options)
    return a, (float(R[2, 2]), sine), b


def _quarters(angle: float) -> tuple[int, float]:
    """Whole quarter turns and the rest; the rest is exactly zero at the double nearest to a right angle."""
    quarter = round(angle / (math.pi / 2))
    rest = angle - quarter * (math.pi / 2)
    return quarter % 4, 0.0 if abs(rest) < 1e-15 else rest


def _link(before: _Canonical | None, P: Array, joint: _Canonical, keep_whole: bool) -> None:
    """The fixed part between the canonical frames of two joints; P is a placement in the frame of the one before."""
    R, p = split_pose(P)
    R = R @ joint.R_joint_axis
    p = p + split_pose(P)[0] @ joint.p_joint_axis
    if before is not None:
        Rt = before.R_joint_axis.T
        R, p = Rt @ R, Rt @ (p - before.p_joint_axis)
    joint.whole = keep_whole
    if before is None or keep_whole:
        if before is not None:  # the frame behind may already have been turned for another child
            R, p = rotation_z(-before.turned) @ R, rotation_z(-before.turned) @ p
        joint.matrix, joint.p = _clean(R), p
        return
    before.turned, joint.alpha, joint.own = _split(_clean(R))
    joint.p = _turned_back(p, before.turned)


def _turned_back(p: Array, angle: float) -> Array:
    """Rz(-angle) p, exact for whole quarter turns."""
    quarter, rest = _quarters(angle)
    if rest == 0.0:
        x, y = p[0], p[1]
        x, y = ((x, y), (y, -x), (-x, -y), (-y, x))[quarter]
        return np.array([x, y, p[2]])
    return rotation_z(-angle) @ p


def compile_joints(model: RobotModel, joints: tuple[int, ...], base: Array | None = None, masses: bool = False) -> Array:
    """The program (structured array JOINT) of a chain or tree of moving joints, parents first.

    Args:
        model: the robot, with float64 arrays.
        joints: indices of moving joints; the parent of each, if it has one, is among them.
        base: (3, 3) rotation put before everything, or None.
        masses: fill in the masses and first moments that each joint carries.
    """
    place = {joint: i for i, joint in enumerate(joints)}
    canonical = [_axis_frame(model.screws[joint]) for joint in joints]
    with_child: set[int] = set()
    for i, joint in enumerate(joints):
        parent = model.parents[joint]
        P = model.placements[joint]
        if parent < 0:
            P = P if base is None else _turn_pose(base, P)
            _link(None, P, canonical[i], keep_whole=True)
        else:
            _link(canonical[place[parent]], P, canonical[i], keep_whole=parent in with_child)
            with_child.add(parent)
    program = np.zeros(len(joints), dtype=JOINT)
    seen: set[int] = set()
    for i, joint in enumerate(joints):
        _write(program[i], canonical[i], model, joint, model.columns[joint] in seen)
        seen.add(model.columns[joint])
        parent = model.parents[joint]
        program[i]["parent"] = place[parent] if parent >= 0 else -1
        if parent >= 0 and place[parent] != i - 1:
            program[place[parent]]["branches"] = 1
    if masses:
        _write_masses(program, canonical, model, joints)
    return program


def _turn_pose(R: Array, P: Array) -> Array:
    turned = P.copy()
    turned[:3] = R @ P[:3]
    return turned


def _write(row: Array, joint: _Canonical, model: RobotModel, index: int, shared: bool) -> None:
    multiplier, offset = float(model.multipliers[index]), float(model.offsets[index])
    quarter, rest = _quarters(joint.own + joint.turned)
    ca, sa = joint.alpha
    row["turn"] = _MATRIX if joint.whole else _turn_code(ca, sa)
    row["matrix"] = joint.matrix.ravel()
    row["ca"], row["sa"], row["p"] = ca, sa, joint.p
    row["shift_mask"] = sum(1 << k for k in range(3) if joint.p[k] != 0)
    row["kind"], row["column"], row["add"] = joint.kind, model.columns[index], shared
    row["scale"] = multiplier
    row["lift"], row["lift0"] = joint.pitch * multiplier, joint.pitch * offset
    if joint.kind == REVOLUTE:
        row["lift"] = row["lift0"] = 0.0
    if joint.kind == PRISMATIC:
        cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarter]
        row["cosine"] = math.cos(rest) * cosine - math.sin(rest) * sine
        row["sine"] = math.sin(rest) * cosine + math.cos(rest) * sine
    else:
        row["quarter"], row["offset"] = quarter, rest + offset


def _turn_code(ca: float, sa: float) -> int:
    return {(1.0, 0.0): _NONE, (0.0, 1.0): _PLUS_90, (0.0, -1.0): _MINUS_90}.get((ca, sa), _GENERAL)


def compile_tail(model: RobotModel, link: int, offset: tuple[float, float, float], joints: tuple[int, ...]) -> Array:
    """(12) rotation and position of the link's frame, displaced by `offset` in its axes, behind the last joint's frame.

    The last joint of a chain gives no turn away (its frame is not followed by another), so its canonical frame is final.
    """
    R, p = split_pose(model.link_placements[link])
    p = p + R @ np.asarray(offset)
    if joints:
        last = _axis_frame(model.screws[joints[-1]])
        R, p = last.R_joint_axis.T @ R, last.R_joint_axis.T @ (p - last.p_joint_axis)
    return np.concatenate([_clean(R).ravel(), p])


def _write_masses(program: Array, canonical: list[_Canonical], model: RobotModel, joints: tuple[int, ...]) -> None:
    place = {joint: i for i, joint in enumerate(joints)}
    for link, carrier in enumerate(model.link_joints):
        if carrier < 0 or model.masses[link] == 0:
            continue
        row, joint = program[place[carrier]], canonical[place[carrier]]
        R, p = split_pose(model.link_placements[link])
        center = R @ model.centers_of_mass[link] + p
        behind = joint.R_joint_axis.T @ (center - joint.p_joint_axis)
        row["mass"] += model.masses[link]
        row["moment"] += model.masses[link] * _turned_back(behind, joint.turned)
    for i in range(len(program) - 1, -1, -1):
        program[i]["subtree_mass"] += program[i]["mass"]
        if program[i]["parent"] >= 0:
            program[program[i]["parent"]]["subtree_mass"] += program[i]["subtree_mass"]


def gravity_base(gravity: tuple[float, float, float]) -> tuple[Array | None, float]:
    """A rotation that turns `gravity` to -z, and its strength: the kernels then need two rows of each frame."""
    g = np.asarray(gravity, dtype=np.float64)
    strength = float(np.linalg.norm(g))
    if strength == 0 or (g[0] == 0 and g[1] == 0 and g[2] < 0):
        return None, strength
    z = -g / strength
    k = int(np.argmin(np.abs(z)))
    x = np.cross(np.eye(3)[k], z)
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z]), strength
