"""Velocity and force ellipsoids: what unit joint speeds make a link do, and what unit joint torques let it hold.

The velocity ellipsoid is the image of the unit ball under J: its radii are the singular values. The force ellipsoid is
its polar dual, with the same axes and the reciprocal radii: along a direction in which the link moves slowly it holds
much, and along one in which it cannot move it holds everything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import Frame
from ..namespaces import Array, as_array
from ..quantities import check_batches, numeric, plain
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, ROW_NAMES, WRENCH_NAMES, rotate, transpose
from .ellipsoid_views import circle, frame_dict, in_words, sphere
from .rows import RowsInPlay, TaskName, decomposed, rows_in_play

VELOCITY, FORCE = "velocity", "force"
_UNITS = {VELOCITY: ("m/s", "rad/s"), FORCE: ("N", "N m")}
_ROUNDING = 1e-14  # of the longest radius: what a coordinate may be wrong by


@dataclass(frozen=True, eq=False, repr=False)
class Ellipsoid:
    """An ellipsoid of velocities or forces, or a batch of them; made by `velocity_ellipsoid` and `force_ellipsoid`.

    Attributes:
        kind: "velocity" or "force".
        axes: (..., k, k) columns are unit directions, together a rotation matrix; a column's first large entry is positive,
            but for the last, which makes the set right-handed.
        radii: (..., k) half-lengths along the axes: descending for velocities, ascending for forces. 0 in a direction that
            is out of reach, inf in one that the structure holds for free.
        rows: (k) names of the coordinates, such as "vx" or "fx"; () for bare rows.
        unit: of the radii, per unit joint speed or torque (or per unit of `joint_scale`); "" for bare rows.
        frame, link: where the coordinates are written, and whose they are; None and "" for bare rows.
        characteristic_length: L [m] where rows or joints mix metres and radians. Where the rows do, the coordinates are
            (v, L ω) and (f, τ/L), all in the unit of the first. None where nothing is scaled.
        joint_scale: (n) or (..., n), as given.
        tolerance: the fraction of the largest singular value below which one counts as zero.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.velocity_ellipsoid(ks.jacobian(ks.load("planar_2r"), [0.0, 1.5707963267948966])))
        velocity ellipsoid of tip: axes of base, at the origin of tip
        radii [m/s] at unit joint speeds, and their directions
        radius       vx       vy
         1.618   0.8507  -0.5257
         0.618   0.5257   0.8507
    """

    kind: str
    axes: Array
    radii: Array
    rows: tuple[str, ...]
    unit: str
    frame: Frame | None
    link: str
    characteristic_length: float | None
    joint_scale: Array | None
    tolerance: float

    @property
    def center(self) -> Array:
        """(..., k) zeros: joints at rest, or joints without torque."""
        return np.zeros_like(self.radii)

    @property
    def is_flat(self) -> Any:
        """(...) whether a direction is out of reach."""
        return _plain(np.any(self.radii == 0, axis=-1))

    @property
    def is_bounded(self) -> Any:
        """(...) whether no direction is held for free."""
        return _plain(~np.any(np.isinf(self.radii), axis=-1))

    @property
    def volume(self) -> Array:
        """(...) in the unit of the radii to the power k; 0 where flat, inf where unbounded.

        Law: π^(k/2) / Γ(k/2 + 1) times the product of the radii: Yoshikawa's measure times a constant.
        """
        k = self.radii.shape[-1]
        with np.errstate(over="ignore", under="ignore"):
            return math.pi ** (k / 2) / math.gamma(k / 2 + 1) * np.prod(self.radii, axis=-1)

    def support(self, direction: Any) -> Array:
        """The largest component of any of its points along a direction: how fast, or how strong, the link can be that way.

        Args:
            direction: (..., k) in the coordinates of `rows`, of any length but zero.

        Returns:
            (...) in `unit`; inf unless the direction is at right angles to all unbounded axes.

        Raises:
            ConfigurationError: KS303, for a direction of no length or another shape.

        Law: max d·x = |diag(radii) axesᵀ d| for a unit d. The force ellipsoid's extent along d is its reciprocal.
        """
        along = self._along_axes(direction)
        unbounded = np.isinf(self.radii)
        reach = np.linalg.norm(np.where(unbounded, 0.0, self.radii) * along, axis=-1)
        return np.where(np.any(unbounded & (along != 0), axis=-1), np.inf, reach)[()]

    def extent(self, direction: Any) -> Array:
        """The distance from the centre to the surface along a direction: Chiu's transmission ratio.

        What the link can do in exactly that direction and no other: `support` may be larger, at a point off the direction.

        Args, Raises: as in `support`.

        Returns:
            (...) in `unit`; 0 unless a flat ellipsoid contains the direction, inf where the direction is unbounded.

        Law: 1/√(dᵀ (J Jᵀ)⁻¹ d) for velocities, 1/√(dᵀ J Jᵀ d) for forces, for a unit d.
        Source: Chiu, "Task compatibility of manipulator postures", IJRR 7(5), 1988.
        """
        along = self._along_axes(direction)
        flat = self.radii == 0
        shrunk = np.linalg.norm(along / np.where(flat, np.inf, self.radii), axis=-1)
        out = np.any(flat & (along != 0), axis=-1)
        held = (shrunk == 0) & ~out
        ratio = 1.0 / np.where(held | out, 1.0, shrunk)
        return np.where(out, 0.0, np.where(held, np.inf, ratio))[()]

    def contains(self, points: Any) -> Any:
        """Whether points lie inside or on the surface, within the tolerance.

        Args:
            points: (..., k) in the coordinates of `rows` and the unit of the radii; batch axes go with those of the radii.

        Returns:
            (...) of booleans.

        Raises:
            ConfigurationError: KS303.
        """
        along = np.abs(self._in_axes(points, "points"))
        largest = np.where(np.isinf(self.radii), 0.0, self.radii).max(axis=-1, initial=0.0, keepdims=True)
        flat = self.radii == 0
        inside = np.maximum(along - _ROUNDING * largest, 0.0) / np.where(flat, 1.0, self.radii)
        ball = np.sum(np.where(flat, 0.0, inside) ** 2, axis=-1) <= 1 + 2 * self.tolerance
        return _plain(ball & np.all(~flat | (along <= self.tolerance * largest), axis=-1))

    def points(self, count: int = 64, clip: float | None = None) -> Array:
        """Points of the surface, for a drawing.

        Args:
            count: points around; the first and the last are the same.
            clip: half-length at which longer axes are cut, in the unit of the radii; needed where one is unbounded.

        Returns:
            (..., count, 2), a closed curve, for two rows; (3, ..., count, count), a mesh X, Y, Z, for three.

        Raises:
            ConfigurationError: KS364 for one row or more than three; KS363 where unbounded and not clipped; KS303.

        Example:
            >>> velocity_ellipsoid([[2.0, 0.0], [0.0, 1.0]]).points(5).round(12) + 0.0
            array([[ 2.,  0.],
                   [ 0.,  1.],
                   [-2.,  0.],
                   [ 0., -1.],
                   [ 2.,  0.]])
        """
        k = self.radii.shape[-1]
        if k not in (2, 3):
            hint = "choose two or three rows: task='position', task=['vx', 'vy'], J.linear"
            raise ConfigurationError("KS364", f"an ellipsoid of {k} rows cannot be drawn", hint)
        scaled = circle(count) if k == 2 else sphere(count)
        radii = self._clipped(clip).reshape(*self.radii.shape[:-1], *[1] * (k - 1), k)
        axes = self.axes.reshape(*self.axes.shape[:-2], *[1] * (k - 1), k, k)
        surface = rotate(axes, scaled * radii)
        return surface if k == 2 else np.moveaxis(surface, -1, 0)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for machines; None for what is infinite or unknown."""
        scale = self.joint_scale
        return {
            "kind": self.kind,
            "link": self.link or None,
            "frame": frame_dict(self.frame),
            "rows": list(self.rows),
            "unit": self.unit,
            "center": plain(self.center),
            "axes": plain(self.axes),
            "radii": plain(self.radii),
            "volume": plain(self.volume),
            "flat": np.asarray(self.is_flat).tolist(),
            "bounded": np.asarray(self.is_bounded).tolist(),
            "characteristic_length": self.characteristic_length,
            "joint_scale": None if scale is None else plain(scale),
            "tolerance": self.tolerance,
        }

    def __repr__(self) -> str:
        return f"<Ellipsoid of {self.kind}, radii of shape {tuple(self.radii.shape)}>"

    def __str__(self) -> str:
        return in_words(self)

    def _along_axes(self, direction: Any) -> Array:
        """(..., k): a unit direction in the axes; what is nothing but rounding is 0 where an axis is flat or unbounded."""
        vector = self._in_axes(direction, "the direction")
        size = np.linalg.norm(vector, axis=-1, keepdims=True)
        if not np.all(size > 0):
            raise ConfigurationError("KS303", "the direction has no length", "any vector but zero; it is made a unit vector")
        unit = vector / size
        degenerate = np.any((self.radii == 0) | np.isinf(self.radii), axis=-1, keepdims=True)
        return np.where(degenerate & (np.abs(unit) <= self.tolerance), 0.0, unit)

    def _in_axes(self, vectors: Any, what: str) -> Array:
        array, xp = as_array(vectors, what)
        k = self.radii.shape[-1]
        if xp.name == "sympy" or tuple(array.shape[-1:]) != (k,):
            names = ", ".join(self.rows) or "one entry for each row"
            raise ConfigurationError("KS303", f"{what} has shape {tuple(array.shape)}; expected (..., {k})", names)
        values = np.asarray(numeric(array), dtype=np.float64)
        if not np.all(np.isfinite(values)):
            raise ConfigurationError("KS301", f"{what} holds NaN or infinity", "pass finite numbers")
        check_batches("the ellipsoid", self.radii.shape[:-1], what, values.shape[:-1])
        return rotate(transpose(self.axes), values)

    def _clipped(self, clip: float | None) -> Array:
        if clip is None:
            if np.all(self.is_bounded):
                return self.radii
            hint = "clip=100.0 cuts the axes there, in the unit of the radii"
            raise ConfigurationError("KS363", "an unbounded ellipsoid was to be drawn whole", hint)
        if not 0 < clip < np.inf:
            raise ConfigurationError("KS303", f"clip is {clip!r}", "a positive half-length, in the unit of the radii")
        return np.minimum(self.radii, clip)


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


def _plain(flags: Array) -> Any:
    """A Python bool of one ellipsoid; the array of a batch."""
    return bool(flags) if np.ndim(flags) == 0 else flags
