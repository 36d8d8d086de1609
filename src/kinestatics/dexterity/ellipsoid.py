"""Ellipsoid: axes, radii and what follows from them; flat and unbounded ones included."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..frames import Frame
from ..namespaces import Array, as_array
from ..quantities import check_batches, numeric, plain
from ..spatial import rotate, transpose
from .ellipsoid_views import circle, in_words, sphere

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
            >>> import kinestatics as ks
            >>> ks.velocity_ellipsoid([[2.0, 0.0], [0.0, 1.0]]).points(5).round(12) + 0.0
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
            "frame": None if self.frame is None else self.frame.to_dict(),
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


def _plain(flags: Array) -> Any:
    """A Python bool of one ellipsoid; the array of a batch."""
    return bool(flags) if np.ndim(flags) == 0 else flags
