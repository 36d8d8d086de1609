"""Force closure: whether contacts can resist every wrench on an object, and how well. MLS section 5.3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from ..quantities import Twist, Wrench, format_number, wrapped
from ..screws_in_words import describe_free_wrench
from ..spatial import ANGULAR, LINEAR, WRENCH_NAMES, size_weights
from ..statics import RANK_TOLERANCE, decompose
from ..statics.subspaces import check_length
from .cones import Cones, Edges, checked_edges
from .contacts import OBJECT, Contact, stacked_forces
from .grasp_map import checked_rows, numeric_grasp
from .solvers import hull_planes, linear_program, no_answer

SEPARATION: Final = 1e-9
"""A direction counts as unresisted when no unit contact force has more than this share of power along it."""

_ROUNDS = 100  # of edges added to the cones; each divides the error by about four
_FACETS, _POINTS = 20_000, 40  # facets at which a hull is fine enough, points added in a round
_REPEATED = 1e-4  # points of a hull this near to each other, of its size, are one


@dataclass(frozen=True, eq=False)
class ForceClosure:
    """Whether the contacts of a grasp resist every wrench. `print` it, or take `to_dict()`.

    Attributes:
        closed: whether they do, friction cones taken as they are, round.
        rank: of the wrenches that the contacts can exert, out of len(rows).
        rows: rows of the wrench that count, 0..5.
        margin: radius of the largest ball of wrenches, of size |(f, τ / length)|, that the contacts resist with normal
            forces that add up to 1 N; 0 unless closed; None when it was not asked for. It is a lower bound;
        margin_at_most: and this is an upper one. Without friction, and in the plane, they are the same.
        length: characteristic length in these sizes [m].
        squeeze: (Σm) an internal force strictly within all cones, largest normal force 1 N, in contact axes; None unless
            closed.
        unresisted: a load on the object, of size 1, that no contact forces balance; None when closed.
        escape: the motion, of size |(v, length · ω)| = 1, along which no contact force has negative power, so that the load
            moves the object that way; None when closed.
        tolerance: the share of a unit force's power, moments divided by the largest lever arm, that counts as none.
        contacts: the grasp.

    Example:
        >>> print(force_closure([Contact.with_friction((x, 0, 0), (-x, 0, 0), 0.5) for x in (1, -1)], rows="planar"))
        force closure in fx, fy, mz: yes (rank 3 of 3)
        margin           0.3333 N for normal forces of 1 N in all (at most 0.3333 N;
                         moments divided by 1 m)
        internal force   normal forces of 1 N, 1 N, and nothing slips
    """

    closed: bool
    rank: int
    rows: tuple[int, ...]
    margin: float | None
    margin_at_most: float | None
    length: float
    squeeze: Array | None
    unresisted: Wrench | None
    escape: Twist | None
    tolerance: float
    contacts: tuple[Contact, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON."""
        return {
            "closed": self.closed,
            "rank": self.rank,
            "rows": [WRENCH_NAMES[row] for row in self.rows],
            "margin": self.margin,
            "margin_at_most": self.margin_at_most,
            "length": self.length,
            "squeeze": None if self.squeeze is None else self.squeeze.tolist(),
            "unresisted": None if self.unresisted is None else np.asarray(self.unresisted).tolist(),
            "escape": None if self.escape is None else np.asarray(self.escape).tolist(),
            "tolerance": self.tolerance,
            "contacts": [contact.to_dict() for contact in self.contacts],
        }

    def __str__(self) -> str:
        names = "" if len(self.rows) == 6 else f" in {', '.join(WRENCH_NAMES[row] for row in self.rows)}"
        lines = [f"force closure{names}: {'yes' if self.closed else 'no'} (rank {self.rank} of {len(self.rows)})"]
        if self.margin is not None and self.margin_at_most is not None and self.closed:
            text = f"{self.margin:.4g} N for normal forces of 1 N in all (at most {self.margin_at_most:.4g} N; "
            lines.append(wrapped("margin           ", f"{text}moments divided by {format_number(self.length)} m)"))
        if self.squeeze is not None:
            forces = ", ".join(f"{format_number(f)} N" for f in _normals(self.squeeze, self.contacts))
            lines.append(wrapped("internal force   ", f"normal forces of {forces}, and nothing slips"))
        if self.unresisted is not None and self.escape is not None:
            load = describe_free_wrench(np.asarray(self.unresisted), OBJECT.axes, OBJECT.origin, self.length)
            numbers = ", ".join(format_number(x) for x in np.asarray(self.unresisted))
            lines.append(wrapped("cannot resist    ", f"{load.text}: ({numbers}) [N, N m] on the object"))
        return "\n".join(lines)


def _normals(stacked: Array, contacts: Sequence[Contact]) -> list[float]:
    """Normal forces out of stacked contact forces."""
    ends = np.cumsum([len(contact.components) for contact in contacts])
    return [
        float(stacked[end - len(c.components) + c.components.index("fz")]) for end, c in zip(ends, contacts, strict=True)
    ]


def force_closure(
    contacts: Sequence[Contact],
    *,
    rows: Any = "full",
    length: float = 1.0,
    accuracy: float | None = 0.01,
    edges: int = 8,
) -> ForceClosure:
    """Whether contacts resist every wrench on the object, and with what margin. Needs SciPy (extra "grasp").

    Friction cones are round. Whether they close is decided on them as they are; the margin lies between two bounds, which
    are brought together to `accuracy` where the geometry allows it within a second or so.

    Args:
        contacts: one grasp, in numbers.
        rows: rows of the wrench that must be resisted: "full", "planar" (fx, fy, mz; something else holds the others), or
            numbers out of 0..5.
        length: characteristic length: the size of a wrench is |(f, τ / length)| [m]. It changes the margin, not the answer.
        accuracy: relative distance of the two bounds of the margin; None leaves the margin out, which is quicker.
        edges: of each cone to begin with; more are added where they matter.

    Raises:
        MissingExtraError: KS400, without SciPy.
        ArrayTypeError: KS302 for what is no contact, or symbols.
        ConfigurationError: KS372 no contacts, KS373 rows, KS374 edges or accuracy, KS303 batches, KS375 no answer.

    Law: closed when the positive combinations of all contact wrenches are all wrenches: G has full rank and some internal
    force lies within all cones (MLS proposition 5.3). The margin is the quality of Ferrari and Canny for a total normal
    force of 1 N: min over |V| = 1 of max_i (v_z + μ |v_t| + γ |ω_z|), with the contact's velocities along V.
    Source: MLS section 5.3; Ferrari, Canny, "Planning optimal grasps", ICRA 1992.

    Example:
        >>> pinch = [Contact.soft((x, 0, 0), (-x, 0, 0), 0.5, 0.01) for x in (0.1, -0.1)]
        >>> force_closure(pinch, length=0.1).closed
        True
        >>> print(force_closure([Contact.with_friction((x, 0, 0), (-x, 0, 0), 0.5) for x in (0.1, -0.1)]))
        force closure: no (rank 5 of 6)
        cannot resist    couple about x of object: (0, 0, 0, 1, 0, 0) [N, N m] on the
                         object
    """
    listed, chosen = numeric_grasp(contacts), checked_rows(rows)
    check_length(length)
    if accuracy is not None and not 0 < accuracy < 1:
        raise ConfigurationError("KS374", f"accuracy is {accuracy}", "between 0 and 1: 0.01 for one percent; None for none")
    cones = Cones.of(listed)
    rims = cones.edges(checked_edges(edges))
    parts = decompose(rims.wrenches.T, chosen, 1.0 / cones.size)  # sizes of wrenches, not of twists
    if parts.rank < len(chosen):
        escape: Array | None = parts.free_wrenches[0]
    else:
        escape, rims = _separate(cones, rims, chosen)
    common = (chosen, length, listed)
    if escape is not None:
        return _open(parts.rank, escape, accuracy, *common)
    low, high = (None, None) if accuracy is None else _margin(cones, rims, chosen, length, accuracy)
    squeeze = stacked_forces(listed, _squeeze(cones, rims, chosen))
    return ForceClosure(True, parts.rank, chosen, low, high, length, squeeze, None, None, SEPARATION, listed)


def _open(
    rank: int, escape: Array, accuracy: float | None, rows: tuple[int, ...], length: float, contacts: Any
) -> ForceClosure:
    """The result for a grasp that does not close."""
    sizes = size_weights(length)
    twist = escape / np.linalg.norm(sizes * escape)
    load, motion = sizes**2 * twist, Twist.of(twist[LINEAR], twist[ANGULAR], OBJECT)
    unresisted = Wrench.on_robot(load[LINEAR], load[ANGULAR], OBJECT)
    margin = None if accuracy is None else 0.0
    return ForceClosure(False, rank, rows, margin, margin, length, None, unresisted, motion, SEPARATION, contacts)


def _scales(rows: Sequence[int], length: float) -> Array:
    """(6): wrenches times this are of one unit; zero in rows that do not count."""
    scales = np.zeros(6)
    scales[list(rows)] = size_weights(1.0 / length)[list(rows)]
    return scales


def _separate(cones: Cones, rims: Edges, rows: tuple[int, ...]) -> tuple[Array | None, Edges]:
    """A twist along which no contact force has negative power, or None; and the edges that decided it.

    The linear program looks for a direction V, in a box, with no power w · V > 0 for any edge w and with as much negative
    power as possible on the first edges, which span all wrenches: only V = 0 has none. A V that some round cone has power
    on is cut off by the edge that has most of it.
    """
    scales, sight = _scales(rows, cones.size), list(rows)
    first: Array | None = None
    for _ in range(_ROUNDS):
        walls = (scales * rims.wrenches)[:, sight]
        walls = walls / np.maximum(np.linalg.norm(walls, axis=1, keepdims=True), RANK_TOLERANCE)
        first = walls.sum(0) if first is None else first
        found = linear_program(first, None, (walls, np.zeros(len(walls))), (-1.0, 1.0))
        if found is None:
            raise no_answer("the linear program of escape did not end with an optimum")
        if found.value > -SEPARATION * len(walls):
            return None, rims
        V = np.zeros(6)
        V[sight] = found.x
        V = scales * V / np.linalg.norm(V)
        powers = cones.reach(V[None])[0]
        helped = np.flatnonzero(powers > SEPARATION)
        if not len(helped):
            return -V, rims
        rims = rims.plus(cones.furthest(V, helped))
    raise no_answer("between closed and open, closer than the tolerances of the linear programs")


def _squeeze(cones: Cones, rims: Edges, rows: tuple[int, ...]) -> Array:
    """(n, 4) contact forces that cancel, with as large a least weight of an edge as normal forces of 1 N allow."""
    scales, n, K = _scales(rows, cones.size), len(cones.contacts), len(rims)
    balance = (scales * rims.wrenches)[:, list(rows)].T
    by_contact = (rims.owner == np.arange(n)[:, None]).astype(float)
    # weights are s + t, s >= 0: every edge has at least t
    equal = np.hstack([balance, balance.sum(1, keepdims=True)])
    most = np.hstack([by_contact, by_contact.sum(1, keepdims=True)])
    cost = np.r_[np.zeros(K), -1.0]
    found = linear_program(cost, (equal, np.zeros(len(equal))), (most, np.ones(n)), (0.0, None))
    if found is None:
        raise no_answer("the linear program of internal forces did not end with an optimum")
    forces = cones.forces(rims, found.x[:K] + found.x[K])
    return forces / max(float(forces[:, 2].max()), RANK_TOLERANCE)


def _margin(cones: Cones, rims: Edges, rows: tuple[int, ...], length: float, accuracy: float) -> tuple[float, float]:
    """Bounds of the margin: the hull of the edges from below, the reach of the round cones along its facets from above."""
    scales, sight = _scales(rows, length), list(rows)
    points = np.unique((scales * rims.wrenches)[:, sight].round(12), axis=0)
    low, high, done = 0.0, np.inf, False
    while not done and (planes := _planes(points)) is not None:
        normals, offsets, moved = planes
        twists = np.zeros((len(normals), 6))
        twists[:, sight] = normals
        twists *= scales
        reach = cones.reach(twists)
        low, high = max(low, float(offsets.min()) - moved), min(high, float(reach.max(1).min()))
        near = np.argsort(offsets)[: int((offsets < high * (1 - accuracy)).sum())]
        ends = (scales * cones.furthest(twists[near], reach[near].argmax(1)).wrenches)[:, sight]
        added = _new_points(ends, points, 0.1 * np.sqrt(accuracy))
        done = low >= high * (1 - accuracy) or not len(added) or len(normals) > _FACETS
        points = np.concatenate([points, added])
    if not np.isfinite(high):
        hint = "say length=, of the object's size, so that moments and forces are alike; accuracy=None leaves the margin out"
        raise ConfigurationError("KS375", "no answer: the wrenches are too flat for a convex hull", hint)
    return low, max(low, high)


def _planes(points: Array) -> tuple[Array, Array, float] | None:
    """Facets of the hull; in one dimension, its two ends."""
    if points.shape[1] == 1:
        return np.array([[1.0], [-1.0]]), np.array([points.max(), -points.min()]), 0.0
    return hull_planes(points)


def _new_points(ends: Array, points: Array, apart: float) -> Array:
    """The first of `ends` that are new, and no two of them near each other."""
    size = float(np.linalg.norm(points, axis=1).max())
    cells = np.unique((ends / (apart * size)).round(), axis=0, return_index=True)[1]
    chosen = ends[np.sort(cells)]
    distances = np.linalg.norm(chosen[:, None] - points, axis=-1).min(1)
    return chosen[distances > _REPEATED * size][:_POINTS]
