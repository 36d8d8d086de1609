"""`self_motion`: the arm moves and its tip does not, followed from a posture both ways.

Law: the postures that hold the rows in play where they are solve f(q) = f(q₀). Along a curve of them the tangent is in
ker J; a step of length h along it is brought back by Gauss-Newton steps on f(q) - f(q₀) = 0 and |q - q_k| = h together, so
that the postures are evenly spaced (Allgower, Georg, "Introduction to numerical continuation methods", 1990, chapter 6).
Where the rank of J falls, a direction of ker J need not belong to any curve: at a stretched elbow the tip leaves its place
to second order. Then no posture at distance h solves the equations, and what is given is the straight line along it.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..frames import TIP
from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import format_number, plain, wrapped
from ..statics import decompose
from ..tasks import without_rounding
from .problem import checked_positive
from .tip_map import Place, TipMap, length_of, one_posture, tip_map

_ROUNDS = 30  # of Gauss-Newton steps for one posture
_CUT = 1e-9  # singular values below this share of the largest are left out of a step
_SPACED = 1e-9  # relative to the step: how evenly postures are spaced
_ONWARDS = 0.5  # cosine of the sharpest turn from one posture to the next
_SHORT = 0.2  # length of a bare null direction, each way [rad or m]
_FULL = 1e-13  # of what is missing: rounding
_STILL = 1e-14  # of what the tip moved [m]: rounding, told as 0
_NULL = 1e-6  # singular values below this share of the largest leave a direction in the null space of a tangent


@dataclass(frozen=True, eq=False)
class SelfMotion:
    """Postures among which the tip stands still; made by `self_motion`.

    Attributes:
        q: (k, n) the postures [rad or m]; the one asked about is where s = 0.
        s: (k) how far along the motion, in joint space: Σ |q_j - q_(j-1)| [rad; a joint that slides counts in m].
        held: (k) how far the rows in play are from where they began: |(Δp, length · angle)| [m].
        tangent: (k, n) the unit direction of the joint motion.
        finite: whether the tip stands still all along; False: to first order at s = 0 only.
        reason: how far it goes, and why it ends there.
        directions: how many null directions the posture has; direction: which of them was followed, from 0.
        task: the rows at rest, by name; length: the characteristic length [m]; joint_names: (n).

    Example:
        >>> import kinestatics as ks
        >>> print(ks.self_motion(ks.load("planar_2r"), [0.0, 3.141592653589793], length=0.5))
        self-motion: s = -0.5 to 0.5 [rad or m], 101 postures
        at s = 0: joint1 1
        at rest: vx, vy in base axes, within 0 m
        followed from s = -0.5 to 0.5
    """

    q: Array
    s: Array
    held: Array
    tangent: Array
    finite: bool
    reason: str
    directions: int
    direction: int
    task: tuple[str, ...]
    length: float
    joint_names: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        numbers = {name: plain(getattr(self, name)) for name in ("q", "s", "held", "tangent", "length")}
        names = {"task": list(self.task), "joint_names": list(self.joint_names)}
        counts = {"directions": self.directions, "direction": self.direction}
        return {**numbers, **names, **counts, "finite": self.finite, "reason": self.reason}

    def __str__(self) -> str:
        kind = "self-motion" if self.finite else "null motion, instantaneous only"
        which = f", null direction {self.direction} of 0 to {self.directions - 1}" if self.directions > 1 else ""
        start = self.tangent[int(np.argmin(np.abs(self.s)))]
        moving = [f"{name} {format_number(x)}" for name, x in zip(self.joint_names, start, strict=True) if abs(x) > 5e-5]
        span = f"s = {format_number(self.s[0])} to {format_number(self.s[-1])} [rad or m], {len(self.s)} postures"
        rows = f"{', '.join(self.task)} in base axes, within {0.0 if self.held.max() < _STILL else self.held.max():.1g} m"
        lines = [wrapped(f"{kind}{which}: ", span), wrapped("at s = 0: ", ", ".join(moving))]
        return "\n".join([*lines, wrapped("at rest: " if self.finite else "leaving: ", rows), wrapped("", self.reason)])

    def __repr__(self) -> str:
        return f"<SelfMotion: {'finite' if self.finite else 'instantaneous'}, {len(self.s)} postures>"


def self_motion(
    model: RobotModel,
    q: Any,
    *,
    at: str = TIP,
    task: str | Sequence[str] | Sequence[int] = "auto",
    direction: int = 0,
    length: float = 1.0,
    step: float = 0.01,
    tolerance: float = 1e-10,
) -> SelfMotion:
    """The joint motion that leaves the tip at rest, followed from a posture both ways, inside the position limits.

    Args:
        model: the robot.
        q: (n) the posture [rad or m]. A joint beyond a limit may come in, and goes no further out.
        at: link that stays at rest; task: its rows that do, in base axes, as in `find_task`.
        direction: which null direction of the posture, from 0, in the order of `decompose(J, ...).null_motion`. Where none
            of the curves through a singular posture goes along it, the nearest that does is followed.
        length: how far, each way [rad or m in joint space]; step: from posture to posture.
        tolerance: what the tip may be off its place [characteristic lengths; rad].

    Returns:
        SelfMotion, s from -length to length, less where a joint limit is met.

    Raises:
        ConfigurationError: KS379, a posture without null motion, or without this direction; KS301, KS303 for q; KS353 for
        numbers. ArrayTypeError: KS302. UnknownNameError: KS310, KS311, KS318.

    Law: f(q(s)) = f(q(0)), J q' = 0, |q'| = 1: see the head of this module.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_3r")
        >>> found = ks.self_motion(arm, [0.1, 0.8, 0.6], task="position", length=0.5)
        >>> len(found.s), bool(found.held.max() < 1e-9), found.finite
        (101, True, True)
    """
    start = one_posture(model, q)
    of = tip_map(model, at, task)
    steps = _counted(checked_positive(length, "length", "in rad or m"), checked_positive(step, "step", "in rad or m"))
    checked_positive(tolerance, "tolerance", "a small share, such as 1e-10")
    null = _null_motion(of, start)
    chosen = _chosen(of, null, direction)
    curve = _Curve(of, of.place(start), np.minimum(model.lower, start), np.maximum(model.upper, start), step, tolerance)
    ahead = curve.followed(start, chosen, steps)
    back = -curve.tangent(start, ahead.postures[0] - start) if ahead.postures else -chosen
    behind = curve.followed(start, back, steps)
    finite = bool(ahead.postures or behind.postures) or not (ahead.lost or behind.lost)
    if finite and (ahead.postures or behind.postures):
        first, last = (behind.postures or [start])[0], (ahead.postures or [start])[0]
        chosen = curve.tangent(start, last - first)
    elif not finite:
        ahead, behind = (curve.straight(start, way * chosen, min(steps, _counted(_SHORT, step))) for way in (1.0, -1.0))
    return _told(curve, start, chosen, (behind, ahead), finite, (len(null), int(direction)))


class _Way(NamedTuple):
    """One way along a curve: postures and tangents after the first, why it ends, whether the tip left its place there."""

    postures: list[Array]
    tangents: list[Array]
    end: str
    lost: bool


class _Curve(NamedTuple):
    """The postures that hold the rows in play at a place."""

    of: TipMap
    home: Place
    lower: Array
    upper: Array
    step: float
    tolerance: float

    def followed(self, q: Array, tangent: Array, steps: int) -> _Way:
        """Postures one step apart, until a limit, the end, or where the tip would leave its place."""
        postures: list[Array] = []
        tangents: list[Array] = []
        for _ in range(steps):
            further = self.next_to(q, tangent)
            if further is None:
                return _Way(postures, tangents, "the tip would leave its place", True)
            if (met := self.limit_met(further)) is not None:
                return _Way(postures, tangents, met, False)
            tangent = self.tangent(further, further - q)
            q = further
            postures.append(q)
            tangents.append(tangent)
        return _Way(postures, tangents, "", False)

    def straight(self, q: Array, tangent: Array, steps: int) -> _Way:
        """Postures along a straight line, until a limit."""
        postures: list[Array] = []
        for k in range(1, steps + 1):
            further = q + k * self.step * tangent
            if (met := self.limit_met(further)) is not None:
                return _Way(postures, [tangent] * len(postures), met, False)
            postures.append(further)
        return _Way(postures, [tangent] * len(postures), "", False)

    def next_to(self, before: Array, tangent: Array) -> Array | None:
        """The posture one step on that holds the tip; None where there is none."""
        q, best = before + self.step * tangent, None
        least, share = np.inf, self.step * _SPACED
        for _ in range(_ROUNDS):
            way = q - before
            far = length_of(way)
            missing = self.of.missing(q, self.home)
            off = length_of(missing) + abs(far - self.step)
            if length_of(missing) <= self.tolerance and abs(far - self.step) <= share and off < least:
                best = q
            if best is not None and (off <= _FULL or off >= least):
                break
            least = min(least, off)
            rows = np.vstack([self.of.jacobian(q) / self.of.travel, way / max(far, self.step * _SPACED)])
            q = q + np.linalg.lstsq(rows, np.r_[missing, self.step - far], rcond=_CUT)[0]
            if length_of(q - before) > 4.0 * self.step:
                break
        return best if best is not None and (best - before) @ tangent >= _ONWARDS * self.step else None

    def tangent(self, q: Array, along: Array) -> Array:
        """The unit null direction that goes on as a move did."""
        null = _null_space(self.of.jacobian(q) / self.of.travel)
        onwards = null.T @ (null @ along)
        size = length_of(onwards)
        return np.asarray(onwards / size if size > 0 else along / length_of(along))

    def limit_met(self, q: Array) -> str | None:
        """What limit a posture is beyond, in words."""
        for k, name in enumerate(self.of.model.joint_names):
            if q[k] > self.upper[k] or q[k] < self.lower[k]:
                return f"joint {name!r} meets its {'upper' if q[k] > self.upper[k] else 'lower'} limit"
        return None


def _null_space(J: Array) -> Array:
    """(m, n) null directions of a Jacobian on a curve, where postures are known to the tolerance only; at least one."""
    _, sigma, Vt = np.linalg.svd(J)
    rank = int((sigma > _NULL * sigma.max(initial=0.0)).sum())
    return np.asarray(Vt[min(rank, len(Vt) - 1) :])


def _null_motion(of: TipMap, q: Array) -> Array:
    """(m, n) null directions of the rows in play.

    Raises:
        ConfigurationError: KS379, where there is none.
    """
    J = without_rounding(of.model, jacobian(of.model, q, at=of.at).array)
    found = decompose(J, of.rows, of.length)
    if not len(found.null_motion):
        rows, smallest = ", ".join(of.task.row_names), found.singular_values[-1] / found.singular_values[0]
        message = f"this posture has no null motion: every joint motion moves {rows} of {of.at!r}"
        hint = f"a singular posture (here σ_min/σ_max is {format_number(smallest)}), a redundant arm, or fewer rows"
        raise ConfigurationError("KS379", message, hint)
    return found.null_motion


def _chosen(of: TipMap, null: Array, direction: Any) -> Array:
    """The null direction asked for, its largest entry positive.

    Raises:
        ConfigurationError: KS379.
    """
    known = not isinstance(direction, bool) and hasattr(direction, "__index__")
    if not known or not 0 <= operator.index(direction) < len(null):
        count = f"1 null direction: {0}" if len(null) == 1 else f"{len(null)} null directions: 0 to {len(null) - 1}"
        raise ConfigurationError("KS379", f"direction is {direction!r}", f"this posture of {of.model.name!r} has {count}")
    v = null[operator.index(direction)]
    largest = int(np.argmax(np.abs(v) > (1.0 - 1e-9) * np.abs(v).max()))
    return np.asarray(v * np.sign(v[largest]) / length_of(v))


def _counted(length: float, step: float) -> int:
    """Whole steps in a length, at least one."""
    return max(1, int(length / step + 1e-9))


def _told(
    curve: _Curve, q: Array, chosen: Array, ways: tuple[_Way, _Way], finite: bool, which: tuple[int, int]
) -> SelfMotion:
    """The result of both ways."""
    behind, ahead = ways
    postures = np.array([*behind.postures[::-1], q, *ahead.postures])
    tangents = np.array([*(-t for t in behind.tangents[::-1]), chosen, *ahead.tangents])
    s = curve.step * np.arange(-len(behind.postures), len(ahead.postures) + 1)
    of = curve.of
    held = np.array([of.length * length_of(of.missing(posture, curve.home)) for posture in postures])
    for array in (postures, s, held, tangents):
        array.setflags(write=False)
    arrays = (postures, s, held, tangents)
    words, rows, names = _reason(curve, ways, finite), of.task.row_names, of.model.joint_names
    return SelfMotion(*arrays, finite, words, *which, rows, of.length, names)


def _reason(curve: _Curve, ways: tuple[_Way, _Way], finite: bool) -> str:
    """How far each way, and why it ends."""
    far = [format_number(way * curve.step * len(one.postures)) for way, one in zip((-1, 1), ways, strict=True)]
    ends = [f"at s = {end} {one.end}" for end, one in zip(far, ways, strict=True) if one.end]
    span = "; ".join([f"from s = {far[0]} to {far[1]}", *ends])
    if finite:
        return f"followed {span}"
    return f"instantaneous only: the tip leaves its place to second order; the straight null direction is shown {span}"
