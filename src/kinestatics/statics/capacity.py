"""How much an arm can hold or push with the efforts it has: the inequality of which joint binds first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..kinematics import configuration, jacobian, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..quantities import Frozen, check_batches
from ..spatial import ANGULAR, LINEAR, rotate, transpose
from ..tasks import without_rounding
from .capacity_result import Capacity
from .gravity import checked_gravity, gravity_torques, missing_masses
from .limits import joint_limits
from .subspaces import RANK_TOLERANCE

EffortLimits = Sequence[float] | Mapping[str, float] | None
_ROUNDING = 1e-12
_LARGEST = 1e50
_UNKNOWN = "effort_limits=(...) one for each joint, or {'joint': limit} [N m, N for a sliding joint]"


def payload_capacity(
    model: RobotModel,
    q: Any,
    *,
    at: str = TIP,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    effort_limits: EffortLimits = None,
    check_finite: bool = True,
) -> Capacity:
    """The greatest mass at a point that the motors still hold, the arm's own weight taken off.

    Args:
        model: the robot.
        q: (..., n) NumPy or lists [rad or m].
        at: link that holds the mass; point: (3) of its centre, in the axes of that link [m].
        gravity: (3) in base axes [m/s²]. None leaves the weight of the arm out, and hangs the mass in standard gravity.
        effort_limits: (n) or {joint: limit} [N m or N] instead of the robot's own; infinite means unknown.
        check_finite: refuse NaN and infinite entries of q; they give NaN else.

    Returns:
        Capacity: value (...) [kg], the joint whose limit binds first, the torques then. Infinite where the structure holds
        the mass without any motor; 0, with `holds_itself` false, where the arm cannot even hold itself.

    Raises:
        MissingMassError: KS320. ConfigurationError: KS303; KS323, no joint that feels the mass has an effort limit.
        UnknownNameError: KS310, KS311, KS313. ArrayTypeError: KS302, symbols or another library.

    Law: the greatest m ≥ 0 with |τ_gravity - m J_vᵀ g| ≤ τ_max in every joint. Source: note 000; Spong section 4.10.

    Example:
        >>> import kinestatics as ks
        >>> capacity = ks.payload_capacity(ks.load("iiwa_14"), [0, 1.5708, 0, 0, 0, 0, 0], gravity=None)
        >>> round(capacity.value, 2), capacity.limiting_joint
        (32.36, 'joint_a6')
    """
    values, limits, held = _arguments(model, q, gravity, effort_limits, check_finite)
    down = np.asarray(STANDARD_GRAVITY if gravity is None else checked_gravity(gravity))
    weight = np.zeros(6)
    weight[LINEAR] = -down  # what the robot must exert on a mass of 1 kg
    notes = ["the weight of the arm is left out"] if gravity is None else []
    return _capacity(model, values, weight, (at, point), limits, held, ("payload", "kg", notes))


def force_capacity(
    model: RobotModel,
    q: Any,
    direction: Any,
    *,
    at: str = TIP,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    effort_limits: EffortLimits = None,
    check_finite: bool = True,
) -> Capacity:
    """The greatest force along a direction that the robot can exert on its surroundings, all else being zero.

    Args:
        model: the robot.
        q: (..., n) NumPy or lists [rad or m].
        direction: (..., 3) in base axes, of any length: a pure force, in newtons along it; or (..., 6): a wrench (f, τ)
            at the point, of which the result says how many times it can be exerted.
        at: link that pushes; point: (3) where, in the axes of that link [m].
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.
        effort_limits: (n) or {joint: limit} [N m or N] instead of the robot's own; infinite means unknown.
        check_finite: refuse NaN and infinite entries of q; they give NaN else.

    Returns:
        Capacity: value (...) [N, or times the wrench], the joint whose limit binds first, the torques then. Infinite
        where the structure carries the force without any motor: a straight leg.

    Raises:
        As `payload_capacity`; ConfigurationError: KS303 also for a direction without length.

    Law: the greatest λ ≥ 0 with |τ_gravity + λ Jᵀ w| ≤ τ_max in every joint. Source: note 004, "standing with bent legs".

    Example:
        >>> import kinestatics as ks
        >>> leg = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
        >>> push = ks.force_capacity(leg, [0.7854, 1.5708], (0, 1, 0), gravity=None, effort_limits=(250, 250))
        >>> round(push.value), push.limiting_joint
        (822, 'joint2')
        >>> straight = ks.force_capacity(leg, [1.5707963267948966, 0], (0, 1, 0), gravity=None, effort_limits=(250, 250))
        >>> straight.value, straight.limiting_joint
        (inf, None)
    """
    values, limits, held = _arguments(model, q, gravity, effort_limits, check_finite)
    wrench, unit = _wrench(direction)
    what = "force" if unit == "N" else "wrench"
    notes = ["the weight of the arm is left out"] if gravity is None else []
    return _capacity(model, values, wrench, (at, point), limits, held, (what, unit, notes))


def _arguments(
    model: RobotModel, q: Any, gravity: Any, effort_limits: EffortLimits, check_finite: bool
) -> tuple[Array, Array, Array | None]:
    """q, the limits, and the torques that hold the arm's own weight (None: left out)."""
    require_model(model)
    if gravity is not None and not model.has_masses:
        raise missing_masses(model, "its description gives none; gravity=None leaves the weight of the arm out")
    array, xp = configuration(model, q, check_finite)
    down = None if gravity is None else checked_gravity(gravity)
    if xp.name != "numpy" or object in (model.masses.dtype, getattr(down, "dtype", None)):
        found = f"q is an array of {xp.name}" if xp.name != "numpy" else "masses or gravity are symbols"
        raise ArrayTypeError("KS302", f"capacities are computed with NumPy numbers; {found}", "np.asarray(q) first")
    values, limits = array.astype(np.float64), checked_effort_limits(model, effort_limits)
    if down is None:
        return values, limits, None
    return values, limits, gravity_torques(model, values, gravity=down, check_finite=False)


def checked_effort_limits(model: RobotModel, effort_limits: Any) -> Array:
    """(n) the limits given, for some joints by name, or else the robot's own; the same both ways.

    Raises:
        ConfigurationError: KS303. UnknownNameError: KS313.
    """
    limits = joint_limits(model, effort_limits, "effort")
    if np.any(limits.lower != -limits.upper):
        raise ConfigurationError("KS303", f"effort limits {effort_limits!r} are not the same both ways", _UNKNOWN)
    return limits.upper


def _wrench(direction: Any) -> tuple[Array, str]:
    """The wrench per unit of the result, (..., 6), and that unit."""
    hint = "(x, y, z) of a force in base axes, or (fx, fy, fz, mx, my, mz)"
    if isinstance(direction, Frozen):
        message = f"direction is a {type(direction).__name__}; its frame and side would be lost"
        raise ArrayTypeError("KS302", message, hint)
    array, xp = as_array(direction, "direction")
    if xp.name != "numpy":
        raise ArrayTypeError(
            "KS302", f"capacities are computed with NumPy; direction is of {xp.name}", "np.asarray(...) first"
        )
    if array.ndim < 1 or array.shape[-1] not in (3, 6) or not np.all(np.isfinite(array)):
        raise ConfigurationError("KS303", f"direction {direction!r} is not 3 or 6 finite numbers", hint)
    array = array.astype(np.float64)
    largest = np.abs(array).max(-1, keepdims=True)
    if not np.all(largest > 0):
        raise ConfigurationError("KS303", f"direction {direction!r} has no length", hint)
    if array.shape[-1] == 6:
        if not np.all((largest > 1 / _LARGEST) & (largest < _LARGEST)):
            raise ConfigurationError("KS303", f"wrench {direction!r} is too small or too large to be counted in", hint)
        return array, "times the wrench"
    scaled = array / largest  # however long or short it was given
    wrench = np.zeros((*array.shape[:-1], 6))
    wrench[..., LINEAR] = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    return wrench, "N"


def _capacity(
    model: RobotModel,
    q: Array,
    wrench: Array,
    where: tuple[str, Sequence[float]],
    limits: Array,
    held: Array | None,
    asked: tuple[str, str, list[str]],
) -> Capacity:
    """The greatest multiple of a wrench at a point that the limits allow; `asked` says what it is called."""
    what, unit, notes = asked
    J = jacobian(model, q, at=where[0], point=where[1], check_finite=False)
    matrix = without_rounding(model, J.array)
    check_batches("q", matrix.shape[:-2], "direction", wrench.shape[:-1])
    per_unit = rotate(transpose(matrix), wrench)
    loaded = np.abs(per_unit) > RANK_TOLERANCE * _sizes(matrix, wrench)
    own = np.zeros(per_unit.shape) if held is None else np.broadcast_to(held, per_unit.shape)
    value, limiting, share = _first_bound(per_unit, loaded, own, limits)
    broken = ~np.all(np.isfinite(own + per_unit), axis=-1)
    holds, known = (share.max(-1, initial=0.0) <= 1.0) & ~broken, np.isfinite(limits)
    unknown = holds & loaded.any(-1) & ~(loaded & known).any(-1)
    if np.any(unknown) and not np.any(loaded & known):
        names = ", ".join(repr(name) for name in _where(model, loaded))
        raise ConfigurationError("KS323", f"the effort limits of all joints that feel it are unknown: {names}", _UNKNOWN)
    felt = loaded if held is None else np.ones(loaded.shape, dtype=bool)
    notes = [*notes, *_notes(model, limits, felt, unknown, holds)]
    value, margin = np.where(unknown | broken, np.nan, value), np.where(broken, np.nan, 1.0 - share.max(-1, initial=0.0))
    moved = np.where(np.isfinite(value), value, 0.0)[..., None] * np.where(loaded, per_unit, 0.0)
    moved = np.where(broken[..., None], np.nan, moved)
    return Capacity(
        what=what,
        unit=unit,
        robot=model.name,
        link=J.link,
        joints=model.joint_names,
        kinds=model.joint_kinds,
        value=_bare(value),
        limiting=_bare(np.where(broken, -1, limiting)),
        torques=own + moved,
        gravity_torques=None if held is None else own,
        unit_torques=per_unit,
        effort_limits=limits,
        margin=_bare(margin),
        holds_itself=_bare(holds),
        held_by_structure=_bare(holds & ~loaded.any(-1)),
        tolerance=RANK_TOLERANCE,
        notes=tuple(notes),
    )


def _bare(array: Any) -> Any:
    """A single number as Python writes it; a batch as it is."""
    return array.item() if np.ndim(array) == 0 else array


def _sizes(J: Array, wrench: Array) -> Array:
    """(..., n) the torque that a wrench of this size could at most cause in each joint."""
    halves = [
        np.linalg.norm(J[..., part, :], axis=-2) * np.linalg.norm(wrench[..., part], axis=-1)[..., None]
        for part in (LINEAR, ANGULAR)
    ]
    return halves[0] + halves[1]


def _first_bound(per_unit: Array, loaded: Array, own: Array, limits: Array) -> tuple[Array, Array, Array]:
    """The value, the index of the joint that stops it (-1: none), and the share of each limit that the weight takes."""
    slack = _ROUNDING * np.abs(own).max(-1, keepdims=True, initial=0.0)
    taken = np.where(np.abs(own) > slack, np.abs(own), 0.0)
    share = np.divide(taken, limits, out=np.where(taken > 0, np.inf, 0.0), where=limits > 0)
    share = np.where((share > 1.0) & (share < 1.0 + _ROUNDING), 1.0, share)
    room = np.maximum(limits - np.sign(per_unit) * own, 0.0)
    steps = np.divide(room, np.abs(per_unit), out=np.full(per_unit.shape, np.inf), where=loaded)
    if not per_unit.shape[-1]:
        return np.full(per_unit.shape[:-1], np.inf), np.full(per_unit.shape[:-1], -1), share
    holds = share.max(-1) <= 1.0
    value = np.where(holds, steps.min(-1), 0.0)
    limiting = np.where(holds, steps.argmin(-1), share.argmax(-1))
    return value, np.where(np.isinf(value), -1, limiting), share


def _where(model: RobotModel, joints: Array) -> list[str]:
    """Names of the joints for which (..., n) holds in any configuration."""
    return [name for name, found in zip(model.joint_names, joints.any(tuple(range(joints.ndim - 1))), strict=True) if found]


def _notes(model: RobotModel, limits: Array, felt: Array, unknown: Array, holds: Array) -> list[str]:
    """What the reader of a capacity must know of its limits."""
    notes = []
    if silent := _where(model, felt & np.isinf(limits)):
        notes.append(f"effort limits are unknown, and taken to suffice, for: {', '.join(silent)}")
    if zero := _where(model, np.broadcast_to(limits == 0, felt.shape)):
        notes.append(f"an effort limit of 0 stops every load; some files write it for unknown: {', '.join(zero)}")
    if np.any(unknown):
        notes.append("NaN where no joint that feels it has a known limit")
    if holds.ndim and not np.all(holds):
        notes.append(f"in {int((~holds).sum())} of {holds.size} configurations the arm cannot hold its own weight")
    return notes
