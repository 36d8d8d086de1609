"""Polytope: {x : A x <= b}, with the joint limits that make each facet, its corners and its surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..frames import Frame
from ..namespaces import Array, as_array
from ..quantities import Frozen, plain
from .linear_programs import maximize
from .polytope_text import in_words
from .round_coordinates import round_coordinates
from .surfaces import Faces, enclosed

_ALONG = 1e-12  # a direction this nearly along a facet does not meet it
_BESIDE = 1e-9  # and one this nearly within a flat set does not leave it
_ROUNDING = 1e-14  # of the numbers that a point was made of
_NEAR = 1e-6  # of the largest distance from the center to a facet: what is nearer is not scaled up any more


@dataclass(frozen=True, eq=False, repr=False)
class Polytope:
    """A convex set {x : A x <= b} of k = 1 to 6 coordinates; made by `velocity_polytope` and `force_polytope`.

    It may be flat (a direction of motion is lost), unbounded (the structure holds a force for free) or empty (the arm cannot
    hold its own weight); `is_flat`, `is_bounded` and `is_empty` say so, and `notes` in words.

    Attributes:
        normals: (m, k) outward unit normals; offsets: (m) [unit]: inside, normals · x <= offsets. Up to three coordinates
            each row is a facet, and a flat set has pairs of opposite rows besides; beyond, some rows may be idle.
        states: (m, n) whose limits make the facet: 1 for a joint's upper one, -1 for its lower one, 0 for neither.
        corners: (v, k) [unit]; None for k > 3. With rays and free directions they are the whole set: the hull of the
            corners, plus the cone of the rays, plus all that lies along the free directions.
        rays: (u, k) unit directions of edges that do not end. free: (f, k) basis of the lines that lie in the set.
        faces: indices of corners, for a bounded set of k <= 3. In space the polygon of each facet, counter-clockwise seen
            from outside; else one cell: a polygon (in the plane counter-clockwise), a segment or a point.
        center: (k) of symmetry, for velocities; for forces, where the tightest joint has the most of its range to spare.
            None when empty.
        generators: (n, k) for velocities: the set is center + Σ s_i generators_i with |s_i| <= 1; else None.
        dimension: of the smallest plane that holds the set; -1 when empty.
        is_empty, is_bounded: as they say; tolerance: share of the largest singular value that counts as zero.
        kind: "velocity" or "force"; unit: such as "m/s"; rows: (k) names of the coordinates; joints: (n) names.
        frame, link, robot: where the coordinates are written, and whose they are.
        notes: sentences on what is special about the set.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.velocity_polytope(ks.load("planar_2r"), [0.0, 1.0], velocity_limits=(1, 1)))
        velocity polytope of planar_2r at tip: vx, vy [m/s]
        axes of base, at the origin of tip
        4 facets, 4 corners, area 3.3659 (m/s)^2
        from the origin as far as
          +vx 0.5463: joint2 at its lower limit
          -vx 0.5463: joint2 at its upper limit
          +vy 1: joint1 at its upper limit
          -vy 1: joint1 at its lower limit
    """

    normals: Array
    offsets: Array
    states: Array
    corners: Array | None
    rays: Array
    free: Array
    faces: Faces
    center: Array | None
    generators: Array | None
    dimension: int
    is_empty: bool
    is_bounded: bool
    tolerance: float
    kind: str
    unit: str
    rows: tuple[str, ...]
    joints: tuple[str, ...]
    frame: Frame | None = None
    link: str = ""
    robot: str = ""
    notes: tuple[str, ...] = ()

    @property
    def vertices(self) -> Array | None:
        """(v, k) the corners of a bounded set, whose hull it is; None when it is unbounded or k > 3."""
        return self.corners if self.is_bounded else None

    @property
    def is_flat(self) -> bool:
        """Whether it has points but no inner ones."""
        return 0 <= self.dimension < len(self.rows)

    @cached_property
    def limiting(self) -> tuple[tuple[str, ...], ...]:
        """(m) words for each facet: the joints whose limits make it, such as ("joint1 at its upper limit",)."""
        return tuple(self._words(i) for i in range(len(self.offsets)))

    def _words(self, facet: int) -> tuple[str, ...]:
        state = self.states[facet]
        found = [f"{self.joints[i]} at its {'upper' if state[i] > 0 else 'lower'} limit" for i in np.flatnonzero(state)]
        return tuple(found) or ("within the limits no joint moves that way",)

    @cached_property
    def size(self) -> float:
        """The largest distance of a facet's plane from the origin of coordinates [unit]."""
        return float(np.abs(self.offsets).max(initial=0.0))

    @cached_property
    def volume(self) -> float:
        """Volume, area or length [unit to the power k]; 0 when flat or empty, infinite when unbounded.

        Raises:
            ConfigurationError: KS303 for more than three rows.
        """
        if self.is_empty or self.is_flat:
            return 0.0
        if not self.is_bounded:
            return float("inf")
        if self.corners is None:
            raise ConfigurationError(
                "KS303", f"no volume is computed for {len(self.rows)} rows", "choose three rows or fewer"
            )
        return enclosed(self.corners, self.faces)

    @cached_property
    def _reach(self) -> float:
        """What velocities are made of, before they cancel; 0 for forces [unit]."""
        return 0.0 if self.generators is None else float(np.linalg.norm(self.generators, axis=1).sum())

    @cached_property
    def _lost(self) -> Array:
        """(m) which planes are those of directions that no joint moves along."""
        return ~np.any(self.states != 0, axis=1)

    def _excess(self, x: Array, tolerance: float) -> Array:
        """How far points (..., k) are beyond the facet they are farthest beyond, rounding and a share of each taken off."""
        slack = tolerance * np.where(self._lost, self._reach, np.abs(self.offsets))
        rounding = _ROUNDING * (np.linalg.norm(x, axis=-1) + self._reach)
        return (x @ self.normals.T - self.offsets - slack).max(axis=-1, initial=-np.inf) - rounding

    def contains(self, points: Any, tolerance: float = 1e-9) -> Any:
        """Whether points are in the set.

        Args:
            points: (..., k) [unit].
            tolerance: how far beyond a facet still counts, as a share of the facet's distance from the origin; of the
                largest velocities where the set is flat.

        Returns:
            (...) of booleans.

        Raises:
            ConfigurationError: KS303, KS301. ArrayTypeError: KS302.
        """
        inside = (self._excess(self._coordinates(points, "points"), tolerance) <= 0) & (not self.is_empty)
        return bool(inside) if np.ndim(inside) == 0 else inside

    def extent(self, direction: Any) -> Any:
        """How far the set reaches from the origin of coordinates along a direction.

        Args:
            direction: (..., k), of any length but zero.

        Returns:
            (...) [unit] the greatest t for which t times the unit vector is in the set: infinite when it never leaves it, 0
            where a flat set does not have the direction. If the origin itself is outside, the far end of the line's way
            through the set, negative when the set lies behind; -inf when the line misses it.

        Raises:
            ConfigurationError: KS303, KS301; KS367 for a direction of zeros. ArrayTypeError: KS302.

        Law: sup{t : t d in the set}; `support` is larger where the set reaches farther beside the direction.
        """
        d = self._directions(direction)
        forth, back = self._crossings(d)
        leaves, enters = forth.min(axis=-1, initial=np.inf), -back.min(axis=-1, initial=np.inf)
        probe = np.where(np.isfinite(leaves), leaves, np.where(np.isfinite(enters), enters, 0.0))
        missed = (self._excess(probe[..., None] * d, 1e-9) > 0) | self.is_empty
        return np.where(missed, -np.inf, leaves)[()]

    def _crossings(self, d: Array) -> tuple[Array, Array]:
        """(..., m) where the line along unit vectors leaves each half-space, forwards and backwards; infinite for never."""
        slope = d @ self.normals.T
        along = np.where(self._lost, _BESIDE, _ALONG)
        steps = self.offsets / np.where(np.abs(slope) > along, slope, 1.0)
        return np.where(slope > along, steps, np.inf), np.where(slope < -along, -steps, np.inf)

    def limiting_facet(self, direction: Any) -> tuple[str, ...]:
        """The joint limits that end the way from the origin along one direction (k); () when nothing does.

        Raises:
            ConfigurationError: KS303, KS301; KS367 for a direction of zeros. ArrayTypeError: KS302.
        """
        d = self._directions(direction)
        if d.ndim != 1:
            raise ConfigurationError(
                "KS303", f"directions have shape {d.shape}; expected ({len(self.rows)},)", "one at a time"
            )
        if not np.isfinite(self.extent(d)):
            return ()
        return self._words(int(np.argmin(self._crossings(d)[0])))

    def support(self, direction: Any) -> Any:
        """The largest component of any point of the set along a direction.

        Args:
            direction: (..., k); the answer grows with its length.

        Returns:
            (...) max d · x, infinite when unbounded, -inf when the set is empty.

        Raises:
            ConfigurationError: KS303, KS301, KS367; KS369 where forces of four rows or more defy the linear program.
            ArrayTypeError: KS302.
        """
        d = self._directions(direction)
        lengths = np.linalg.norm(self._coordinates(direction, "direction"), axis=-1)
        if self.is_empty:
            return np.full(lengths.shape, -np.inf)[()]
        if self.generators is not None:
            return (lengths * (d @ self.center + np.abs(d @ self.generators.T).sum(axis=-1)))[()]
        endless = np.any(np.abs(d @ self.free.T) > 1e-9, axis=-1) | np.any(d @ self.rays.T > 1e-9, axis=-1)
        if self.corners is not None:
            farthest = (d @ self.corners.T).max(axis=-1)
        else:
            farthest = np.array([self._farthest(one) for one in d.reshape(-1, d.shape[-1])]).reshape(lengths.shape)
        return np.where(endless, np.inf, lengths * farthest)[()]

    def _farthest(self, d: Array) -> float:
        """The support along one unit vector, by a linear program in round coordinates around the center."""
        slack = self.offsets - self.normals @ self.center
        near = np.maximum(slack, _NEAR * slack.max(initial=0.0))
        near = np.where(near > 0, near, 1.0)
        ones = np.ones(len(d))
        rounded = round_coordinates((self.normals / near[:, None]).T, ones, rank=len(d) - len(self.free))
        goal = rounded.normals @ d
        size = float(np.linalg.norm(goal))
        if size == 0:
            return float(d @ self.center)
        best = maximize(goal / size, rounded.columns, np.maximum(slack, 0.0) / near, 0.0 * goal)
        return float(d @ self.center) + size * best.value

    def _coordinates(self, values: Any, what: str) -> Array:
        if isinstance(values, Frozen):
            message = f"{what}: a {type(values).__name__}; its frame would be lost"
            raise ArrayTypeError("KS302", message, f"numbers for {', '.join(self.rows)}")
        array, xp = as_array(values, what)
        if xp.name == "sympy":
            raise ArrayTypeError("KS302", f"{what}: symbols in a polytope of numbers", "put numbers in place of them")
        numbers = np.asarray(array.detach() if hasattr(array, "detach") else array, dtype=float)
        k = len(self.rows)
        if numbers.shape[-1:] != (k,):
            hint = f"one number for each of {', '.join(self.rows)}"
            raise ConfigurationError("KS303", f"{what} have shape {numbers.shape}; expected (..., {k})", hint)
        if not np.all(np.isfinite(numbers)):
            raise ConfigurationError("KS301", f"{what} are not finite", "pass finite numbers")
        return numbers

    def _directions(self, direction: Any) -> Array:
        """Unit vectors along (..., k), however long they were given."""
        numbers = self._coordinates(direction, "direction")
        largest = np.abs(numbers).max(axis=-1, initial=0.0)[..., None]
        if not np.all(largest > 0):
            raise ConfigurationError("KS367", "a direction of zeros points nowhere", "pass a direction of any other length")
        scaled = numbers / largest
        return scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; None for what is infinite or not there."""
        arrays = ("normals", "offsets", "vertices", "rays", "free", "center")
        return {
            "kind": self.kind,
            "robot": self.robot or None,
            "link": self.link or None,
            "rows": list(self.rows),
            "unit": self.unit,
            "frame": None if self.frame is None else self.frame.to_dict(),
            "empty": self.is_empty,
            "flat": self.is_flat,
            "bounded": self.is_bounded,
            "dimension": self.dimension,
            "volume": plain(self.volume) if len(self.rows) <= 3 else None,
            **{name: plain(getattr(self, name)) for name in arrays},
            "faces": [list(face) for face in self.faces],
            "limiting": [list(words) for words in self.limiting],
            "tolerance": self.tolerance,
            "notes": list(self.notes),
        }

    def __repr__(self) -> str:
        shape = "empty" if self.is_empty else f"{len(self.offsets)} facets"
        return f"<Polytope: {self.kind} of {self.link}, {', '.join(self.rows)} [{self.unit}], {shape}>"

    def __str__(self) -> str:
        return in_words(self)
