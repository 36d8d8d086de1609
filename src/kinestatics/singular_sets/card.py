"""The card of a posture: is it singular, which one is it, what is lost, what is held for free, and what it is good for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import format_number, plain, wrapped
from ..screws_in_words import Screw, describe_free_wrench, describe_lost_twist
from ..spatial import size_weights
from ..statics.subspaces import Decomposition, decompose
from ..tasks import Task, characteristic_length, prismatic_columns, without_rounding
from .axes import AxisRelation, axis_relations
from .distance import Distance
from .reach import Boundary
from .second_order import SecondOrder

_NEAR = 3
_MOVES = 0.05  # of the largest entry: joints that take part in a motion


@dataclass(frozen=True, eq=False)
class Card:
    """What is to be known about one posture.

    Attributes:
        model, at, task: the robot, the link, the rows in play; q: (n) the posture [rad or m].
        decomposition: rank, singular values, lost twists, free wrenches and null motion, with the tolerance.
        on: names of the components it lies on; near: distances from the components, the nearest first.
        lost, free: the lost twists and the wrenches held for free, in words.
        axes: what holds among the axes here and not everywhere.
        second_order: whether it is a wall, a passage or a standstill; None where it is not singular.
        boundary: what a search over other branches says; None where it was not asked for, or the posture is not singular.
        weakest: (6) the twist that costs the most joint motion, of size 1; rates: (n) the joint rates for it, infinite rates
            as a unit vector; gain: the rates' size, infinite where singular.
        residual: how far the nominal robot, of which all this is, is from the one given.
        complete: whether all components are known; else `on` and `near` may lack some.
    """

    model: RobotModel
    at: str
    task: Task
    q: Array
    decomposition: Decomposition
    on: tuple[str, ...]
    near: tuple[Distance, ...]
    lost: tuple[Screw, ...]
    free: tuple[Screw, ...]
    axes: tuple[AxisRelation, ...]
    second_order: SecondOrder | None
    boundary: Boundary | None
    weakest: Array
    rates: Array
    gain: float
    residual: float
    complete: bool = True

    @property
    def rank(self) -> int:
        """Rank of the rows in play here."""
        return self.decomposition.rank

    @property
    def is_singular(self) -> bool:
        """Whether it is less than at almost every posture."""
        return self.rank < self.task.rank

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "q": self.q.tolist(),
            "rows": list(self.task.row_names),
            "rank": self.rank,
            "rank_elsewhere": self.task.rank,
            "singular": self.is_singular,
            "singular_values": self.decomposition.singular_values.tolist(),
            "characteristic_length": self.decomposition.characteristic_length,
            "on": list(self.on),
            "near": [distance.to_dict() for distance in self.near],
            "complete": self.complete,
            "lost_twists": [screw.to_dict() for screw in self.lost],
            "free_wrenches": [screw.to_dict() for screw in self.free],
            "null_motion": self.decomposition.null_motion.tolist(),
            "axes": [relation.to_dict() for relation in self.axes],
            "second_order": None if self.second_order is None else self.second_order.to_dict(),
            "boundary": None if self.boundary is None else self.boundary.to_dict(),
            "weakest": plain(self.weakest),
            "rates": plain(self.rates),
            "gain": plain(np.array(self.gain)),
            "residual": self.residual,
        }

    def __str__(self) -> str:
        state = "not singular"
        if self.is_singular:
            state = f"singular: {' and '.join(self.on) or 'on no component that was found'}"
        lines = [wrapped("", f"{state}; rank {self.rank}, elsewhere {self.task.rank} ({', '.join(self.task.row_names)})")]
        lines += [wrapped("  lost   ", screw.text) for screw in self.lost]
        lines += [wrapped("  free   ", f"{screw.text}: no joint feels it") for screw in self.free]
        lines += [wrapped("  axes   ", relation.text) for relation in self.axes]
        if self.is_singular and len(self.decomposition.null_motion):
            moved = "; ".join(self._motion(row) for row in self.decomposition.null_motion)
            lines.append(wrapped("  null   ", f"these joint motions do not move the rows: {moved}"))
        if self.second_order is not None:
            lines.append(wrapped("  class  ", self.second_order.text))
        if self.boundary is not None:
            lines.append(wrapped("  reach  ", self.boundary.text))
        if self.residual > 1e-9:
            note = f"all this is of the nominal robot; the robot as given differs by up to {format_number(self.residual)}"
            lines.append(wrapped("  note   ", note))
        lines.append(wrapped("  speed  ", self.speed_words))
        lines.append(wrapped("  force  ", self.force_words))
        lines += [wrapped("  near   ", str(distance)) for distance in self.near[:_NEAR]]
        if not self.complete:
            lines.append(wrapped("  near   ", "others may be nearer: not all components were found in time"))
        return "\n".join(lines)

    def _motion(self, row: Array) -> str:
        """A joint motion: "joint4 1, joint6 -1"."""
        scale = row / np.abs(row).max()
        pairs = zip(self.model.joint_names, scale, strict=True)
        return ", ".join(f"{name} {format_number(round(float(x), 6))}" for name, x in pairs if abs(x) > 1e-7)

    def _joints(self) -> str:
        """The joints that make the weakest motion."""
        shares = np.abs(self.rates) / np.abs(self.rates).max(initial=np.finfo(float).tiny)
        return ", ".join(name for name, share in zip(self.model.joint_names, shares, strict=True) if share > _MOVES)

    def _weakest_words(self) -> str:
        length = self.decomposition.characteristic_length
        return describe_lost_twist(self.weakest, "base", self.at, length).text.removeprefix("no ")

    @property
    def speed_words(self) -> str:
        if not np.isfinite(self.gain):
            return f"near here the lost motion takes rates without bound of {self._joints()}"
        unit = "rad/s" if not np.any(prismatic_columns(self.model)) else "rad/s or m/s"
        size = f"a twist of size 1, {format_number(self.decomposition.characteristic_length)} m times the turning"
        return f"{self._weakest_words()} takes the most: {format_number(self.gain)} {unit} for {size}, by {self._joints()}"

    @property
    def force_words(self) -> str:
        if not np.isfinite(self.gain):
            return "the structure carries what is held for free, as a straight leg does: large forces for no torque"
        size = format_number(100.0 / self.gain)
        return f"a wrench of size 100 against that motion takes joint torques of size {size}"


def card_of(
    model: RobotModel,
    at: str,
    task: Task,
    q: Array,
    on: tuple[str, ...],
    near: tuple[Distance, ...],
    second: SecondOrder | None,
    boundary: Boundary | None,
    tolerance: float,
    residual: float,
) -> Card:
    """The card of a posture (n)."""
    J = without_rounding(model, jacobian(model, q, at=at, check_finite=False).array)
    length = characteristic_length(model, at)
    parts = decompose(J, task.rows, length, tolerance)
    spare = max(0, task.rank - parts.rank)  # rows that never move count as lost everywhere, and are left out
    always = len(parts.lost_twists) - spare
    lost, free = parts.lost_twists, parts.free_wrenches
    if always > 0:
        lost, free = _without_structural(model, at, task, parts, length)
    weakest, rates, gain = _weakest(J, task, length, parts)
    return Card(
        model,
        at,
        task,
        q,
        parts,
        on,
        near,
        tuple(describe_lost_twist(t, "base", at, length) for t in lost),
        tuple(describe_free_wrench(w, "base", at, length) for w in free),
        axis_relations(model, q, at),
        second,
        boundary,
        weakest,
        rates,
        gain,
        residual,
    )


def _without_structural(model: RobotModel, at: str, task: Task, parts: Decomposition, length: float) -> tuple[Array, Array]:
    """Lost twists and free wrenches without the directions in which the rows never move at any posture."""
    samples = jacobian(model, model.random_configurations(8, seed=6), at=at, check_finite=False).array
    weights = size_weights(length)
    columns = (weights[:, None] * samples)[:, list(task.rows)].transpose(1, 0, 2).reshape(len(task.rows), -1)
    U, sigma, _ = np.linalg.svd(columns)
    live = np.zeros((6, int((sigma > 1e-9 * sigma.max(initial=0.0)).sum())))
    live[list(task.rows)] = U[:, : live.shape[1]]
    lost = (parts.lost_twists * weights) @ live
    _, sizes, Vt = np.linalg.svd(lost) if len(lost) else (None, np.zeros(0), np.zeros((0, live.shape[1])))
    kept = Vt[: int((sizes > 1e-6).sum())] @ live.T
    return kept / weights, kept * weights


def _weakest(J: Array, task: Task, length: float, parts: Decomposition) -> tuple[Array, Array, float]:
    """The twist of size 1 that costs the most joint motion, the rates for it, and their size."""
    weights = size_weights(length)
    rows = list(task.rows)
    U, sigma, Vt = np.linalg.svd(weights[rows, None] * J[rows], full_matrices=False)
    k = min(task.rank, len(sigma)) - 1
    twist = np.zeros(6)
    if k < 0:
        return twist, np.zeros(J.shape[1]), float("inf")
    twist[rows] = U[:, k]
    if parts.rank < task.rank:
        return twist / weights, Vt[k], float("inf")
    return twist / weights, Vt[k] / sigma[k], float(1.0 / sigma[k])
