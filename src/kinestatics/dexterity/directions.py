"""How fast a link can be moved along one direction: the linear program behind the velocity polytope."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .._kernels import ALL_ROWS
from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP, Frame
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..quantities import Frozen, Jacobian, check_batches, numeric
from ..spatial import ANGULAR_ROWS, LINEAR, ROW_NAMES
from ..statics import RANK_TOLERANCE
from ..statics.limits import Limits, joint_limits
from ..tasks import task_of
from .linear_programs import maximize
from .polytopes import numeric_jacobian, unit_weights
from .round_coordinates import rank_of
from .rows import TaskName
from .speed_result import SpeedCapacity

_BESIDE = 1e-9  # a direction is lost of which more than this share is out of reach
_BINDING = 1e-9  # a limit that changes the value by less than this share of the others does not make it


def speed_capacity(
    model: RobotModel,
    q: Any,
    direction: Any,
    *,
    hold: str = "orientation",
    task: TaskName = "auto",
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    velocity_limits: Limits = None,
    check_finite: bool = True,
) -> SpeedCapacity:
    """The greatest speed of a link straight along a direction, while no joint passes its velocity limit.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        direction: (..., 3) in the axes of the frame, of any length: a velocity of the point there, and no other; or
            (..., 6): a twist (v, ω), of which the result says how many times it can be had.
        hold: "orientation": the link does not turn, in the rows in play (a planar arm of two joints turns as it must);
            "nothing": it may turn as it likes. Makes no difference to a twist, which says how it turns.
        task: rows in play, as in `find_task`; those of the direction always are. Rows that are not in play are free.
        at, point, frame: as in `jacobian`.
        velocity_limits: (n) instead of the robot's own, the same both ways; or (lower, upper), (n) each, with zero between;
            or {joint: limit} for some of the joints [rad/s, m/s for a sliding joint].
        check_finite: refuse NaN and infinite entries of q; they give NaN else.

    Returns:
        SpeedCapacity: value (...) [m/s, or times the twist], rates (..., n) that reach it, and the joints whose limits stop
        it. 0 in a direction that is lost. Spare joints help: it is the greatest speed of all rates that go that way.

    Raises:
        ConfigurationError: KS366, a joint that moves the link has no velocity limit; KS367, a direction of zeros; KS301,
            KS303. UnknownNameError: KS310, KS311, KS313, KS318. ArrayTypeError: KS302.

    Law: max s with J q̇ = s d and l <= q̇ <= u; the extent of the velocity polytope of the same rows along d.
    Source: Chiu, "Task compatibility of manipulator postures", IJRR 7(5), 1988, with limits in place of a unit ball.

    Example:
        >>> import kinestatics as ks
        >>> arm, q = ks.load("ur5e"), [0, -1, 1.5, -0.5, 1.2, 0]
        >>> straight = ks.speed_capacity(arm, q, (0, 0, 1))
        >>> round(straight.value, 3), straight.limiting_joints
        (1.461, ['wrist_1_joint'])
        >>> round(ks.speed_capacity(arm, q, (0, 0, 1), hold="nothing").value, 3)
        2.672
    """
    J, array = numeric_jacobian(model, q, at, point, frame, check_finite)
    twist, shown, unit = _twist(direction)
    check_batches("q", array.shape[:-2], "direction", twist.shape[:-1])
    own = _followed(J, task, _turns(hold) and unit == "m/s")
    rows = tuple(sorted(own | _needed(twist.reshape(-1, 6))))
    limits = joint_limits(model, velocity_limits, "velocity")
    bounds = _with_rest(*limits.of_carrying(model, array))
    found = _solved(array, twist, own, bounds, unit_weights(model, ALL_ROWS, at))
    return SpeedCapacity(
        robot=model.name,
        link=J.link,
        joints=model.joint_names,
        kinds=model.joint_kinds,
        direction=shown,
        value=_bare(found.value),
        unit=unit,
        rates=found.rates,
        limiting=found.limiting,
        lower=limits.lower,
        upper=limits.upper,
        rows=tuple(ROW_NAMES[row] for row in rows),
        held=tuple(ROW_NAMES[row] for row in rows if row in ANGULAR_ROWS and unit == "m/s"),
        is_lost=_bare(found.lost),
        frame=J.frame,
        tolerance=RANK_TOLERANCE,
    )


class _Fastest(NamedTuple):
    """Value, rates (n), limiting (n) and whether the direction is lost; of one configuration or a batch."""

    value: Any
    rates: Array
    limiting: Array
    lost: Any


def _bare(array: Any) -> Any:
    """A single number as Python writes it; a batch as it is."""
    return array.item() if np.ndim(array) == 0 else array


def _turns(hold: str) -> bool:
    """Whether the link may turn as it likes."""
    if hold not in ("orientation", "nothing"):
        raise ConfigurationError("KS303", f"hold={hold!r} is not known", "say 'orientation' or 'nothing'")
    return hold == "nothing"


def _with_rest(lower: Array, upper: Array) -> tuple[Array, Array]:
    if np.any(lower > 0) or np.any(upper < 0):
        hint = "lower limits of zero or less, upper ones of zero or more"
        raise ConfigurationError("KS303", "a joint that cannot stand still leaves no pure motion along a direction", hint)
    return lower, upper


def _twist(direction: Any) -> tuple[Array, Array, str]:
    """The twist (..., 6) that is asked for, the direction as shown, and the unit of the answer."""
    if isinstance(direction, Frozen):
        message = f"direction is a {type(direction).__name__}; its frame would be lost"
        raise ArrayTypeError("KS302", message, "numbers: (x, y, z), or (vx, vy, vz, wx, wy, wz), in the axes of frame=")
    array, xp = as_array(direction, "direction")
    if xp.name == "sympy":
        raise ArrayTypeError("KS302", "direction holds symbols", "put numbers in place of them")
    values = numeric(array).astype(np.float64)
    if values.shape[-1:] not in ((3,), (6,)):
        hint = "(x, y, z) of a velocity, or (vx, vy, vz, wx, wy, wz)"
        raise ConfigurationError("KS303", f"direction has shape {values.shape}; expected (..., 3) or (..., 6)", hint)
    if not np.all(np.isfinite(values)):
        raise ConfigurationError("KS301", "direction is not finite", "pass finite numbers")
    largest = np.abs(values).max(axis=-1, keepdims=True)
    if not np.all(largest > 0):
        raise ConfigurationError("KS367", "a direction of zeros points nowhere", "pass a direction of any other length")
    if values.shape[-1] == 6:
        return values, values, "times the twist"
    unit = values / largest
    unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
    twist = np.zeros((*unit.shape[:-1], 6))
    twist[..., LINEAR] = unit
    return twist, unit, "m/s"


def _followed(J: Jacobian, task: TaskName, may_turn: bool) -> set[int]:
    """The rows in play that every direction keeps to: no angular ones where the link may turn."""
    return {row for row in task_of(J, task).rows if not (may_turn and row in ANGULAR_ROWS)}


def _needed(twists: Array) -> set[int]:
    """The rows in which any of the twists (m, 6) is not zero."""
    return {int(row) for row in np.flatnonzero(np.any(twists != 0, axis=0))}


def _solved(J: Array, wanted: Array, own: set[int], bounds: tuple[Array, Array], weights: Array) -> _Fastest:
    """One after the other, for J (..., 6, n) and twists (..., 6): each follows its own rows and those it needs."""
    batch, n = np.broadcast_shapes(J.shape[:-2], wanted.shape[:-1]), J.shape[-1]
    matrices = np.broadcast_to(J, (*batch, 6, n)).reshape(-1, 6, n)
    found = []
    for A, d in zip(matrices, np.broadcast_to(wanted, (*batch, 6)).reshape(-1, 6), strict=True):
        if not np.all(np.isfinite(A)):
            found.append(_Fastest(np.nan, np.full(n, np.nan), np.zeros(n, dtype=np.int8), False))
            continue
        rows = sorted(own | _needed(d[None]))
        found.append(_fastest(A[rows], d[rows], bounds, weights[rows]))
    return _Fastest(
        value=np.array([one.value for one in found]).reshape(batch),
        rates=np.array([one.rates for one in found]).reshape(*batch, n),
        limiting=np.array([one.limiting for one in found], dtype=np.int8).reshape(*batch, n),
        lost=np.array([one.lost for one in found], dtype=bool).reshape(batch),
    )


def _fastest(rows: Array, wanted: Array, bounds: tuple[Array, Array], weights: Array) -> _Fastest:
    """max s with rows · q̇ = s wanted, the rates as shares of the joints' larger limits; locked joints left out."""
    scale = np.maximum(-bounds[0], bounds[1])
    moving = scale > 0
    limits = [bound[moving] / scale[moving] for bound in bounds]
    best = _largest_share(rows[:, moving] * weights[:, None] * scale[moving], weights * wanted, limits[0], limits[1])
    rates, limiting = np.zeros(len(scale)), np.zeros(len(scale), dtype=np.int8)
    rates[moving], limiting[moving] = scale[moving] * best.rates, best.limiting
    return best._replace(rates=rates, limiting=limiting)


def _largest_share(rows: Array, wanted: Array, lower: Array, upper: Array) -> _Fastest:
    """max s with rows · u = s wanted and lower <= u <= upper: a linear program in s and the motions that move no row."""
    n = rows.shape[1]
    U, sigma, Vt = np.linalg.svd(rows, full_matrices=True)
    rank = rank_of(sigma)
    within = U[:, :rank].T @ wanted
    if np.linalg.norm(wanted - U[:, :rank] @ within) > _BESIDE * np.linalg.norm(wanted):
        return _Fastest(0.0, np.zeros(n), np.zeros(n, dtype=np.int8), True)
    rates = Vt[:rank].T @ (within / sigma[:rank])
    size = np.linalg.norm(rates)
    basis = np.column_stack([rates / size, Vt[rank:].T])
    goal = np.eye(basis.shape[1])[0]
    best = maximize(goal, np.vstack([basis, -basis]), np.r_[upper, -lower], np.zeros(len(goal)))
    binding = (best.multipliers > _BINDING * best.multipliers.max()).reshape(2, n)
    return _Fastest(best.value / size, basis @ best.point, binding[0].astype(np.int8) - binding[1], False)
