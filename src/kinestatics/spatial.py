"""Algebra of rotations, poses and six-vectors on bare arrays of any library. Floor 2.

The only file that knows that rows 0..2 of a six-vector are the linear ones: (v, ω) for a twist, (f, τ) for a wrench.
Batch axes come first; rotations are (..., 3, 3), points (..., 3), six-vectors (..., 6). No checks here.
Source: Murray, Li, Sastry, "A Mathematical Introduction to Robotic Manipulation" (1994), chapter 2.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from .namespaces import Array, Namespace

LINEAR: Final = slice(0, 3)
ANGULAR: Final = slice(3, 6)
ROW_NAMES: Final = ("vx", "vy", "vz", "wx", "wy", "wz")
WRENCH_NAMES: Final = ("fx", "fy", "fz", "mx", "my", "mz")
LINEAR_ROWS: Final = (0, 1, 2)
ANGULAR_ROWS: Final = (3, 4, 5)


def size_weights(length: float) -> Array:
    """(6) NumPy: metres for radians. |weights · V| is the size |(v, length · ω)|, |w / weights| is |(f, τ / length)|."""
    return np.array([1.0, 1.0, 1.0, length, length, length])


def swap_order(six: Array, axis: int = -1) -> Array:
    """A NumPy six-vector array with its linear and angular halves exchanged along `axis`."""
    return np.roll(six, 3, axis=axis)


def rotate(R: Array, v: Array) -> Array:
    """R v for (..., 3, 3) and (..., 3)."""
    return (R @ v[..., None])[..., 0]


def transpose(R: Array) -> Array:
    """The last two axes exchanged."""
    return R.swapaxes(-1, -2)


def cross(a: Array, b: Array, xp: Namespace) -> Array:
    """a × b along the last axis."""
    return xp.stack(
        [
            a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
            a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
            a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
        ],
        -1,
    )


def hat(w: Array, xp: Namespace) -> Array:
    """The matrix of w ×: (..., 3) → (..., 3, 3)."""
    x, y, z = w[..., 0], w[..., 1], w[..., 2]
    zero = 0 * x
    rows = [xp.stack([zero, -z, y], -1), xp.stack([z, zero, -x], -1), xp.stack([-y, x, zero], -1)]
    return xp.stack(rows, -2)


def screw_motion(screw: Array, q: Array, xp: Namespace) -> tuple[Array, Array]:
    """exp(q [screw]) as (R, p), for unit screws: |ω| = 1 (revolute, helical) or ω = 0, |v| = 1 (prismatic).

    With W = [ω]× and the part of v along the axis, v∥ = v + W² v (the whole of it for a prismatic joint):
    R = I + sin q W + (1 - cos q) W²,  p = q v∥ + sin q (v - v∥) + (1 - cos q) W v. No branch, no division and no joint
    type; q leaves the trigonometric functions only along the axis, so that large angles lose nothing.
    MLS eqs. 2.14 and 2.36, rewritten for unit screws.

    Args:
        screw: (m, 6).
        q: (..., m) [rad or m].

    Returns:
        R (..., m, 3, 3) and p (..., m, 3).
    """
    v, W = screw[..., LINEAR], hat(screw[..., ANGULAR], xp)
    WW, Wv = W @ W, rotate(W, v)
    along = v + rotate(WW, v)
    angle = q[..., None]
    sine, versine = xp.sin(angle), 1 - xp.cos(angle)
    identity = xp.constant(np.eye(3), q)
    R = identity + sine[..., None] * W + versine[..., None] * WW
    return R, angle * along + sine * (v - along) + versine * Wv


def pose_matrix(R: Array, p: Array, xp: Namespace) -> Array:
    """(..., 4, 4) from (..., 3, 3) and (..., 3)."""
    zero = 0 * p[..., 0]
    last = xp.stack([zero, zero, zero, zero + 1], -1)
    return xp.concat([xp.concat([R, p[..., None]], -1), last[..., None, :]], -2)


def split_pose(T: Array) -> tuple[Array, Array]:
    """Rotation and translation of a (..., 4, 4) pose."""
    return T[..., :3, :3], T[..., :3, 3]


def inverse_pose(T: Array) -> Array:
    """Inverse of a (..., 4, 4) NumPy pose by transposition."""
    R, p = split_pose(T)
    result = T.copy()
    result[..., :3, :3] = transpose(R)
    result[..., :3, 3] = -rotate(transpose(R), p)
    return result


def pose_residual(T: Array) -> float:
    """By how much NumPy poses (..., 4, 4) miss being rotations and translations; the entries are finite."""
    R, _ = split_pose(T)
    misses = (transpose(R) @ R - np.eye(3), np.linalg.det(R) - 1, T[..., 3, :] - [0, 0, 0, 1])
    return max(float(np.abs(miss).max(initial=0.0)) for miss in misses)


def change_twist_frame(twist: Array, R: Array, p: Array, xp: Namespace) -> Array:
    """A twist written in axes A at A's origin, rewritten in axes B at B's origin.

    R = R_A_B and p = p_A_B are the pose of B seen from A:  ω' = Rᵀ ω,  v' = Rᵀ (v + ω × p)  (MLS eq. 2.58, inverted).
    """
    v, w = twist[..., LINEAR], twist[..., ANGULAR]
    Rt = transpose(R)
    return xp.concat([rotate(Rt, v + cross(w, p, xp)), rotate(Rt, w)], -1)


def change_wrench_frame(wrench: Array, R: Array, p: Array, xp: Namespace) -> Array:
    """A wrench written in axes A at A's origin, rewritten in axes B at B's origin.

    f' = Rᵀ f,  τ' = Rᵀ (τ - p × f): the transpose of the twist's inverse map, so that power is the same in both.
    """
    f, m = wrench[..., LINEAR], wrench[..., ANGULAR]
    Rt = transpose(R)
    return xp.concat([rotate(Rt, f), rotate(Rt, m - cross(p, f, xp))], -1)


def lie_bracket(a: Array, b: Array, xp: Namespace) -> Array:
    """[a, b] of twists: (ω_a × v_b - ω_b × v_a, ω_a × ω_b). MLS section 2.3, page 68 (with the sign of ad_a b)."""
    va, wa, vb, wb = a[..., LINEAR], a[..., ANGULAR], b[..., LINEAR], b[..., ANGULAR]
    return xp.concat([cross(wa, vb, xp) - cross(wb, va, xp), cross(wa, wb, xp)], -1)


def adjoint_matrix(R: Array, p: Array, xp: Namespace) -> Array:
    """(..., 6, 6) matrix Ad of a pose (R_a_b, p_a_b): V_a = Ad V_b of twists, F_b = Adᵀ F_a of wrenches (MLS eq. 2.58)."""
    upper = xp.concat([R, hat(p, xp) @ R], -1)
    return xp.concat([upper, xp.concat([0 * R, R], -1)], -2)


def bracket_matrix(twist: Array, xp: Namespace) -> Array:
    """(..., 6, 6) matrix ad of a twist: ad_a b = [a, b] of `lie_bracket`."""
    turning, moving = hat(twist[..., ANGULAR], xp), hat(twist[..., LINEAR], xp)
    upper = xp.concat([turning, moving], -1)
    return xp.concat([upper, xp.concat([0 * turning, turning], -1)], -2)


# The functions below are for NumPy only: they build models and print results, and are not part of the definition.


def rotation_z(angle: float) -> Array:
    """Rotation about z by `angle` [rad], (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_to_rpy(R: Array) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] with R = Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF; yaw = 0 at pitch = ±90°."""
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) < 1e-12:
        return math.atan2(-R[1, 2], R[1, 1]), pitch, 0.0
    return math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])


def rpy_to_rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), (3, 3)."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def quaternion_to_rotation(w: float, x: float, y: float, z: float) -> Array:
    """Rotation of a quaternion of any length but 0, scalar part first, (3, 3)."""
    n = 2.0 / (w * w + x * x + y * y + z * z)
    return np.array(
        [
            [1 - n * (y * y + z * z), n * (x * y - w * z), n * (x * z + w * y)],
            [n * (x * y + w * z), 1 - n * (x * x + z * z), n * (y * z - w * x)],
            [n * (x * z - w * y), n * (y * z + w * x), 1 - n * (x * x + y * y)],
        ]
    )
