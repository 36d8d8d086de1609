"""Velocity and force ellipsoids: what unit joint speeds make a link do, and what unit joint torques let it hold.

The velocity ellipsoid is the image of the unit ball under J: its radii are the singular values. The force ellipsoid is
its polar dual, with the same axes and the reciprocal radii: along a direction in which the link moves slowly it holds
much, and along one in which it cannot move it holds everything.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, as_array
from ..quantities import check_batches, numeric
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, ROW_NAMES, WRENCH_NAMES
from .ellipsoid import Ellipsoid
from .rows import RowsInPlay, TaskName, decomposed, rows_in_play

VELOCITY, FORCE = "velocity", "force"
_UNITS = {VELOCITY: ("m/s", "rad/s"), FORCE: ("N", "N m")}


def velocity_ellipsoid(
    rows: Any, *, task: TaskName = "auto", length: float | None = None, joint_scale: Any = None
) -> Ellipsoid:
    """The velocities of a link at joint speeds within the unit ball: radii are singular values.

    Args:
        rows: a Jacobian, whose rows in play are found, or bare rows (..., r, n) such as J.linear, which all count.
            NumPy, or concrete arrays of JAX and PyTorch.
        task: other rows of a Jacobian, as in `find_task`.
        length: characteristic length L [m], needed where the rows of a Jacobian mix metres and radians: the coordinates
            are then (v, L ω). Where the joints mix both and have no `joint_scale`, prismatic ones run at L times the
            speed.
        joint_scale: (n) or (..., n) speeds [rad/s or m/s], such as `arm.velocity_limits`: joint i at unit speed runs at
            joint_scale[i]. The unit ball is then Σ (q̇i/joint_scale[i])² ≤ 1, which lies within the limits.

    Returns:
        Ellipsoid of k = r coordinates; with fewer joints than rows, or in a singular posture, it is flat.

    Raises:
        ConfigurationError: KS360 where a length is needed, KS361 for task or length with bare rows, KS362 for joint_scale,
            KS303 for shapes. ArrayTypeError: KS302. UnknownNameError: KS318.

    Law: {J S q̇ : |q̇| ≤ 1} with S = diag(joint_scale); J S = U diag(σ) Vᵀ gives axes U and radii σ.
    Source: Yoshikawa, "Manipulability of robotic mechanisms", IJRR 4(2), 1985; note 000, "manipulability".

    Example:
        >>> import kinestatics as ks
        >>> e = ks.velocity_ellipsoid(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))
        >>> e.radii.round(6), e.is_flat
        (array([2.236068, 0.      ]), True)
    """
    return _ellipsoid(VELOCITY, rows, task, length, joint_scale)


def force_ellipsoid(
    rows: Any, *, task: TaskName = "auto", length: float | None = None, joint_scale: Any = None
) -> Ellipsoid:
    """The wrenches that a link holds at joint torques within the unit ball: radii are reciprocal singular values.

    Args:
        rows, task: as in `velocity_ellipsoid`.
        length: characteristic length L [m], needed where the rows of a Jacobian mix metres and radians: the coordinates
            are then (f, τ/L). Where the joints mix both and have no `joint_scale`, prismatic ones push with 1/L.
        joint_scale: (n) or (..., n) torques [N m or N], such as `arm.effort_limits`: joint i at unit torque gives
            joint_scale[i]. The unit ball is then Σ (τi/joint_scale[i])² ≤ 1, which lies within the limits.

    Returns:
        Ellipsoid: the polar dual of velocity_ellipsoid(rows, joint_scale=1/joint_scale), with its axes and the reciprocals
        of its radii. In a singular posture it is unbounded: what the structure holds costs no torque.

    Raises: as in `velocity_ellipsoid`.

    Law: {w : |S⁻¹ Jᵀ w| ≤ 1} with S = diag(joint_scale); x·w ≤ 1 for every x of its dual. Gravity is left out.
    Source: Yoshikawa, "Foundations of Robotics" (1990), chapter 4; Chiu, IJRR 7(5), 1988.

    Example:
        >>> import kinestatics as ks
        >>> e = ks.force_ellipsoid(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))
        >>> e.radii.round(6), e.is_bounded
        (array([0.447214,      inf]), False)
    """
    return _ellipsoid(FORCE, rows, task, length, joint_scale)


def _ellipsoid(kind: str, rows: Any, task: TaskName, length: float | None, joint_scale: Any) -> Ellipsoid:
    found = rows_in_play(rows, task, length, weigh_joints=joint_scale is None)
    if found.xp.name == "sympy":
        raise ArrayTypeError("KS302", "an ellipsoid has numbers for radii", "put numbers in place of the symbols first")
    array = np.asarray(numeric(found.array))
    scale = None if joint_scale is None else _checked_scale(joint_scale, array)
    if scale is not None:
        array = array * (scale if kind == VELOCITY else 1.0 / scale)[..., None, :]
    axes, sigma = _principal(array, found)
    if kind == FORCE:
        with np.errstate(over="ignore"):
            sigma = np.where(sigma == 0, np.inf, 1.0 / np.where(sigma == 0, 1.0, sigma))
    names, unit = _names_and_unit(kind, found)
    return Ellipsoid(
        kind=kind,
        axes=axes,
        radii=sigma,
        rows=names,
        unit=unit,
        frame=found.frame,
        link=found.link,
        characteristic_length=found.length,
        joint_scale=scale,
        tolerance=found.tolerance,
    )


def _principal(array: Array, found: RowsInPlay) -> tuple[Array, Array]:
    """U (..., r, r), right-handed, and the r singular values, exactly 0 where they count as zero."""
    r, n = array.shape[-2:]
    if n < r:  # columns of zeros add no direction
        array = np.concatenate([array, np.zeros((*array.shape[:-1], r - n))], axis=-1)
    U, sigma, _ = decomposed(array, as_array(array)[1])
    largest = sigma[..., :1]
    small = (sigma <= found.tolerance * largest) | (np.arange(r) >= found.rank)
    sigma = np.where(small & ~np.isnan(sigma), 0.0, sigma)
    large = np.abs(U) > 0.5 * np.abs(U).max(axis=-2, keepdims=True, initial=0.0)
    if not r:
        return U, sigma
    first = np.take_along_axis(U, np.argmax(large, axis=-2)[..., None, :], axis=-2)
    U = U * np.where(first < 0, -1.0, 1.0) + 0.0  # no minus before a zero
    U[..., -1] *= np.where(np.linalg.det(U) < 0, -1.0, 1.0)[..., None]
    return U, sigma


def _checked_scale(joint_scale: Any, array: Array) -> Array:
    n = array.shape[-1]
    hint = "one positive number for each joint; limits that are unknown are infinite: choose a number there"
    try:
        scale = np.array(numeric(as_array(joint_scale, "joint_scale")[0]), dtype=np.float64)
    except (TypeError, ValueError):
        raise ConfigurationError("KS362", f"joint_scale {joint_scale!r} is not {n} numbers", hint) from None
    if scale.ndim < 1 or scale.shape[-1] != n or not np.all((scale > 0) & np.isfinite(scale)):
        shown = np.array2string(scale, threshold=8, precision=4)
        raise ConfigurationError("KS362", f"joint_scale is {shown}; expected {n} positive finite numbers", hint)
    check_batches("the Jacobian", array.shape[:-2], "joint_scale", scale.shape[:-1])
    return scale


def _names_and_unit(kind: str, found: RowsInPlay) -> tuple[tuple[str, ...], str]:
    if found.task is None:
        return (), ""
    rows = found.task.rows
    names = tuple((ROW_NAMES if kind == VELOCITY else WRENCH_NAMES)[row] for row in rows)
    mixed = any(row in ANGULAR_ROWS for row in rows) and any(row in LINEAR_ROWS for row in rows)
    linear = mixed or not any(row in ANGULAR_ROWS for row in rows)
    return names, _UNITS[kind][0 if linear else 1]
