"""THE definition of the kinematics: bare arrays in and out, any array library, no checks. Floor 4.

Everything is built from one object, the *spatial twists* of the joints: column i is the twist, written in base axes at
the base origin, that unit rate of moving joint i gives to everything behind it. Its derivative is a Lie bracket:

    ∂S_i/∂q_k = [S_k, S_i]  if joint k carries joint i, else 0                       (MLS eq. 3.54 and section 2.3)

A Jacobian is a selection of these columns, rewritten in the frame asked for, with mimic joints folded together.
`_kernels` repeats these quantities for NumPy float64; nothing else does. Batch axes come first everywhere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .model import RobotModel
from .namespaces import Array, Namespace
from .spatial import ANGULAR, LINEAR, change_twist_frame, cross, lie_bracket, rotate, screw_motion, split_pose, transpose


class Target(NamedTuple):
    """What a Jacobian describes and where it is written; links are indices of `model.link_names`.

    Attributes:
        link: the body whose motion is described.
        axes: link whose axes are used.
        origin: link at whose origin the linear part is taken, displaced by
        offset: (3) in the axes of that link [m].
        relative_to: link whose motion is subtracted, or None.
    """

    link: int
    axes: int
    origin: int
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    relative_to: int | None = None


class JointPoses(NamedTuple):
    """Frames of all moving joints in base axes: R[i] (..., 3, 3) and p[i] (..., 3)."""

    R: tuple[Array, ...]
    p: tuple[Array, ...]


def in_library(model: RobotModel, q: Array, xp: Namespace) -> RobotModel:
    """The model with its arrays in the library, type and device of q."""
    return model.map(lambda array: xp.constant(array, q))


def joint_steps(model: RobotModel, q: Array, xp: Namespace) -> tuple[Array, Array]:
    """Frames of all moving joints, each seen from the one before: (..., m, 3, 3) and (..., m, 3); q is (..., n), m > 0."""
    moved = xp.stack([q[..., column] for column in model.columns], -1) * model.multipliers + model.offsets
    turns, shifts = screw_motion(model.screws, moved, xp)
    R_parent_joint, p_parent_joint = split_pose(model.placements)
    return R_parent_joint @ turns, p_parent_joint + rotate(R_parent_joint, shifts)


def joint_poses(model: RobotModel, q: Array, xp: Namespace) -> JointPoses:
    """Frames of all moving joints, one sweep from the base; q is (..., n)."""
    R: list[Array] = []
    p: list[Array] = []
    if not model.parents:
        return JointPoses((), ())
    R_step, p_step = joint_steps(model, q, xp)
    for i, parent in enumerate(model.parents):
        R_i, p_i = R_step[..., i, :, :], p_step[..., i, :]
        R.append(R_i if parent < 0 else R[parent] @ R_i)
        p.append(p_i if parent < 0 else p[parent] + rotate(R[parent], p_i))
    return JointPoses(tuple(R), tuple(p))


def link_pose(
    model: RobotModel, poses: JointPoses, link: int, q: Array, xp: Namespace, offset: Array | None = None
) -> tuple[Array, Array]:
    """Rotation (..., 3, 3) and origin (..., 3) of a link in base axes; the origin displaced by `offset` in link axes."""
    joint = model.link_joints[link]
    R, p = split_pose(model.link_placements[link, ...])
    if offset is not None:
        p = p + rotate(R, offset)
    if joint < 0:
        return xp.broadcast(R, (*q.shape[:-1], 3, 3)), xp.broadcast(p, (*q.shape[:-1], 3))
    return poses.R[joint] @ R, poses.p[joint] + rotate(poses.R[joint], p)


def spatial_twists(model: RobotModel, poses: JointPoses, xp: Namespace) -> Array:
    """(..., m, 6): twist of unit rate of every moving joint, base axes, base origin."""
    columns = []
    for i in range(len(model.parents)):
        w = rotate(poses.R[i], model.screws[i, ANGULAR])
        v = rotate(poses.R[i], model.screws[i, LINEAR]) + cross(poses.p[i], w, xp)
        columns.append(xp.concat([v, w], -1))
    return xp.stack(columns, -2)


def _carries(model: RobotModel, link: int) -> Array:
    """(m) ones for the moving joints that move a link; whole numbers, so that symbols stay exact."""
    joint = model.link_joints[link]
    return model.ancestry[joint] if joint >= 0 else np.zeros(len(model.parents))


def _selection(model: RobotModel, target: Target) -> Array:
    selected = _carries(model, target.link)
    return selected if target.relative_to is None else selected - _carries(model, target.relative_to)


def _place(model: RobotModel, poses: JointPoses, q: Array, target: Target, xp: Namespace) -> tuple[Array, Array]:
    """Axes (rotation) and origin of the target's frame, in base axes at the base origin."""
    R, _ = link_pose(model, poses, target.axes, q, xp)
    offset = xp.constant(np.asarray(target.offset), q) if any(target.offset) else None
    _, p = link_pose(model, poses, target.origin, q, xp, offset)
    return R, p


def _empty(q: Array, *shape: int) -> Array:
    """An array without columns, for a model without joints."""
    return np.zeros((*q.shape[:-1], *shape))


def pose(model: RobotModel, q: Array, target: Target, xp: Namespace) -> tuple[Array, Array]:
    """Rotation and position of the target's axes and origin, in base axes."""
    model = in_library(model, q, xp)
    return _place(model, joint_poses(model, q, xp), q, target, xp)


def jacobian(model: RobotModel, q: Array, target: Target, xp: Namespace) -> Array:
    """(..., 6, n): J q̇ is the twist of the target's link in the target's frame."""
    folding, selection = xp.constant(model.folding, q), xp.constant(_selection(model, target), q)
    model = in_library(model, q, xp)
    if not model.parents:
        return _empty(q, 6, 0)
    poses = joint_poses(model, q, xp)
    R, p = _place(model, poses, q, target, xp)
    twists = spatial_twists(model, poses, xp) * selection[:, None]
    return transpose(change_twist_frame(twists, R[..., None, :, :], p[..., None, :], xp)) @ folding


def hessian(model: RobotModel, q: Array, target: Target, xp: Namespace) -> Array:
    """(..., 6, n, n): entry [r, j, k] is ∂J[r, j]/∂q_k of the matrix that `jacobian` returns, its frame moving included.

    With X = (v, ω) a column at the frame's origin in base axes, and o, R the frame's origin and axes:
    ∂/∂q_k Rᵀ X = Rᵀ (∂X - ω_k × X), with ω_k the rate of turning of the axes; ∂X adds ω × ∂o to the bracket.
    """
    folding = xp.constant(model.folding, q)
    before = xp.constant(model.ancestry - np.eye(len(model.parents)), q)
    selected, turning, moving = (
        xp.constant(mask, q)
        for mask in (_selection(model, target), _carries(model, target.axes), _carries(model, target.origin))
    )
    model = in_library(model, q, xp)
    if not model.parents:
        return _empty(q, 6, 0, 0)
    poses = joint_poses(model, q, xp)
    R, p = _place(model, poses, q, target, xp)
    twists = spatial_twists(model, poses, xp)
    v, w = twists[..., LINEAR], twists[..., ANGULAR]
    v = v + cross(w, p[..., None, :], xp)  # at the frame's origin
    of_i, of_k = (..., slice(None), None, slice(None)), (..., None, slice(None), slice(None))  # column i, moving joint k
    bracket = lie_bracket(twists[of_k], twists[of_i], xp) * before[:, :, None]
    dw, origin_rate, axes_rate = bracket[..., ANGULAR], v * moving[:, None], w * turning[:, None]
    dv = bracket[..., LINEAR] + cross(dw, p[..., None, None, :], xp) + cross(w[of_i], origin_rate[of_k], xp)
    dv, dw = dv - cross(axes_rate[of_k], v[of_i], xp), dw - cross(axes_rate[of_k], w[of_i], xp)
    Rt = transpose(R)[..., None, None, :, :]
    rows = xp.concat([rotate(Rt, dv), rotate(Rt, dw)], -1)
    rows = rows * selected[:, None, None]
    by_row = xp.stack([rows[..., r] for r in range(6)], -3)
    return transpose(transpose(by_row @ folding) @ folding)


def jacobian_rate(model: RobotModel, q: Array, qd: Array, target: Target, xp: Namespace) -> Array:
    """(..., 6, n): d/dt of the matrix that `jacobian` returns, Σ_k ∂J/∂q_k q̇_k (the classical one)."""
    return rotate_last(hessian(model, q, target, xp), qd)


def rotate_last(tensor: Array, vector: Array) -> Array:
    """Σ_k tensor[..., r, j, k] vector[..., k]."""
    return (tensor @ vector[..., None, :, None])[..., 0]


def com_jacobians(model: RobotModel, q: Array, xp: Namespace) -> Array:
    """(..., L, 3, n): velocity of every link's centre of mass, base axes."""
    folding = xp.constant(model.folding, q)
    carried = [xp.constant(_carries(model, link), q) for link in range(len(model.link_names))]
    model = in_library(model, q, xp)
    if not model.parents:
        return _empty(q, len(model.link_names), 3, 0)
    poses = joint_poses(model, q, xp)
    twists = spatial_twists(model, poses, xp)
    v, w = twists[..., LINEAR], twists[..., ANGULAR]
    blocks = []
    for link, mask in enumerate(carried):
        _, center = link_pose(model, poses, link, q, xp, model.centers_of_mass[link, ...])
        velocity = (v + cross(w, center[..., None, :], xp)) * mask[:, None]
        blocks.append(transpose(velocity) @ folding)
    return xp.stack(blocks, -3)


def gravity_torques_by_link(model: RobotModel, q: Array, gravity: Array, xp: Namespace) -> Array:
    """(..., L, n): joint torques that hold each link's weight, -Σ J_comᵀ m g (note 000, "gravity compensation")."""
    masses = xp.constant(model.masses, q)
    J = com_jacobians(model, q, xp)
    weight = -masses[:, None] * xp.constant(np.asarray(gravity), q)
    return rotate(transpose(J), weight)


def gravity_torques(model: RobotModel, q: Array, gravity: Array, xp: Namespace) -> Array:
    """(..., n): the joint torques that hold the arm still against gravity, summed over its links."""
    return gravity_torques_by_link(model, q, gravity, xp).sum(-2)


def centers_of_mass(model: RobotModel, q: Array, xp: Namespace) -> Array:
    """(..., L, 3): every link's centre of mass, seen from the base."""
    model = in_library(model, q, xp)
    poses = joint_poses(model, q, xp)
    places = range(len(model.link_names))
    points = [link_pose(model, poses, link, q, xp, model.centers_of_mass[link, ...])[1] for link in places]
    return xp.stack(points, -2)


def potential_energy_by_link(model: RobotModel, q: Array, gravity: Array, xp: Namespace) -> Array:
    """(..., L): -m gᵀ p_com, zero for a mass at the base origin (MLS section 4.2)."""
    weights = xp.constant(model.masses, q)[:, None] * xp.constant(np.asarray(gravity), q)
    return -(centers_of_mass(model, q, xp) * weights).sum(-1)


def mass_matrix(model: RobotModel, q: Array, xp: Namespace) -> Array:
    """(..., n, n): Σ J_comᵀ m J_com + J_ωᵀ I J_ω over the links; the kinetic energy is ½ q̇ᵀ M q̇ (MLS section 4.3)."""
    heavy = (model.masses != 0) | (model.inertias != 0).any((-1, -2))
    moved = [link for link, joint in enumerate(model.link_joints) if joint >= 0 and heavy[link]]
    folding = xp.constant(model.folding, q)
    carried = {link: xp.constant(_carries(model, link), q) for link in moved}
    model = in_library(model, q, xp)
    if not moved:
        return xp.constant(np.zeros((*q.shape[:-1], model.n, model.n)), q)
    poses = joint_poses(model, q, xp)
    twists = spatial_twists(model, poses, xp)
    v, w = twists[..., LINEAR], twists[..., ANGULAR]
    total: Array = 0
    for link, mask in carried.items():
        R, center = link_pose(model, poses, link, q, xp, model.centers_of_mass[link, ...])
        velocity = (v + cross(w, center[..., None, :], xp)) * mask[:, None]
        turning = (w * mask[:, None]) @ R  # rows in the link's axes
        inertia = model.inertias[link, ...]
        total = total + model.masses[link] * (velocity @ transpose(velocity)) + turning @ inertia @ transpose(turning)
    return transpose(folding) @ total @ folding
