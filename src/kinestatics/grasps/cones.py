"""Friction cones in numbers: their edges, and how far they reach in a direction. NumPy only.

The cones are round. Programs over them are solved exactly, by edges: the directions in which a cone reaches furthest along
the prices of the last solution are added until none helps. Every set of edges lies within the cones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array, as_array
from ..spatial import ANGULAR, LINEAR_ROWS
from .contacts import COMPONENTS, Contact, object_wrenches


@dataclass(frozen=True, eq=False)
class Edges:
    """Contact forces of unit normal force on the rims of the cones.

    Attributes:
        owner: (K) which contact.
        local: (K, 4) fx, fy, fz, τz in contact axes.
        wrenches: (K, 6) on the object.
    """

    owner: Array
    local: Array
    wrenches: Array

    def __len__(self) -> int:
        return len(self.owner)

    def plus(self, more: Edges) -> Edges:
        """These and those."""
        pairs = ((self.owner, more.owner), (self.local, more.local), (self.wrenches, more.wrenches))
        return Edges(*(np.concatenate(pair) for pair in pairs))

    def take(self, which: Array) -> Edges:
        """Some of them."""
        return Edges(self.owner[which], self.local[which], self.wrenches[which])


@dataclass(frozen=True, eq=False)
class Cones:
    """The friction cones of one grasp.

    Attributes:
        contacts: (n).
        maps: (n, 6, 4) object's wrench for fx, fy, fz, τz of each contact, whatever its kind.
        friction, torsion: (n), as used: divided by the safety factor.
    """

    contacts: tuple[Contact, ...]
    maps: Array
    friction: Array
    torsion: Array

    @classmethod
    def of(cls, contacts: Sequence[Contact], safety: float = 1.0) -> Cones:
        """From contacts in numbers."""
        like, xp = as_array(np.zeros(1))
        maps = np.stack([object_wrenches(contact, COMPONENTS["soft"], like, xp).T for contact in contacts])
        friction, torsion = (np.array([getattr(c, name) for c in contacts]) / safety for name in ("friction", "torsion"))
        return cls(tuple(contacts), maps, friction, torsion)

    @property
    def size(self) -> float:
        """Length that makes moments comparable with forces in the solvers: the largest lever arm or torsion [m]."""
        levers = self.maps[:, ANGULAR, : len(LINEAR_ROWS)]
        most = max(float(np.abs(levers).max()), float(self.torsion.max()))
        return most if most > 0 else 1.0

    def reach(self, twists: Array) -> Array:
        """How much power a unit of normal force can have on twists (T, 6), at each contact: (T, n)."""
        v = np.einsum("kic,ti->tkc", self.maps, twists)
        return v[..., 2] + self.friction * np.hypot(v[..., 0], v[..., 1]) + self.torsion * np.abs(v[..., 3])

    def edges(self, count: int) -> Edges:
        """`count` edges around every cone, twice as many with torsion; one where there is no friction."""
        angles = 2 * np.pi * np.arange(count) / count
        circle = np.stack([np.cos(angles), np.sin(angles)], -1)
        circle[np.abs(circle) < 1e-15] = 0.0
        owners, locals_ = [], []
        for k, (friction, torsion) in enumerate(zip(self.friction, self.torsion, strict=True)):
            tangent = friction * circle if friction > 0 else np.zeros((1, 2))
            for moment in (torsion, -torsion) if torsion > 0 else (0.0,):
                ones = np.ones((len(tangent), 1))
                locals_.append(np.hstack([tangent, ones, moment * ones]))
                owners.append(np.full(len(tangent), k))
        return self._edges(np.concatenate(owners), np.concatenate(locals_))

    def furthest(self, twists: Array, which: Array) -> Edges:
        """The edge of contact which[k] that has the most power on twists[k]: (T, 6), (T), or one twist (6) for all."""
        v = np.einsum("kic,ki->kc", self.maps[which], np.broadcast_to(twists, (len(which), 6)))
        slip = np.hypot(v[:, 0], v[:, 1])
        share = self.friction[which] / np.where(slip > 0, slip, 1.0)
        moments = self.torsion[which] * np.sign(v[:, 3])
        return self._edges(which, np.stack([share * v[:, 0], share * v[:, 1], np.ones(len(which)), moments], -1))

    def _edges(self, owner: Array, local: Array) -> Edges:
        return Edges(owner, local, np.einsum("kic,kc->ki", self.maps[owner], local))

    def forces(self, edges: Edges, weights: Array) -> Array:
        """(n, 4) contact forces that are a weighted sum of edges."""
        total = np.zeros((len(self.contacts), 4))
        np.add.at(total, edges.owner, weights[:, None] * edges.local)
        return total


def checked_edges(edges: int) -> int:
    """How many edges a cone starts with.

    Raises:
        ConfigurationError: KS374.
    """
    if not isinstance(edges, int | np.integer) or isinstance(edges, bool) or not 3 <= edges <= 1000:
        hint = "8 is enough: more are found where they are needed"
        raise ConfigurationError("KS374", f"edges={edges!r}; expected a whole number from 3 to 1000", hint)
    return int(edges)
