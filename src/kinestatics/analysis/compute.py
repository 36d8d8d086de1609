"""`analyze`: asks the floors below every question, and puts the answers together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..dexterity import isotropy, manipulability
from ..dexterity.rows import ANGULAR_SCALED, PRISMATIC_SCALED, manipulability_unit, mixed_units
from ..errors import ArrayTypeError, ConfigurationError
from ..frames import TIP
from ..kinematics import configuration, jacobian, pose, require_model
from ..model import RobotModel
from ..namespaces import Array, Namespace
from ..quantities import Jacobian
from ..screws_in_words import Screw, describe_free_wrench, describe_lost_twist
from ..statics import Decomposition, Loads, checked_gravity, decompose
from ..tasks import Task, characteristic_length, find_task, prismatic_columns, without_rounding
from .abilities import abilities, ellipsoids, greatest_payload
from .checks import finite_array
from .loading import held
from .near import singular_here
from .result import Analysis, Margin

NEAR_LIMIT = 0.05
"""A joint closer to a limit than this share of its range is near it; with one limit only, this many rad or m."""


def analyze(
    model: RobotModel,
    q: Any = None,
    wrench: Loads = None,
    task: str | Sequence[str] | Sequence[int] = "auto",
    *,
    at: str = TIP,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    singularities: bool = False,
    brief: bool = False,
) -> Analysis:
    """What can this arm do, here?

    Args:
        model: the robot; `arm.with_payload(...)` for one that holds something.
        q: (n) one configuration [rad or m]; default the robot's home.
        wrench: a load on the robot or a push on its surroundings, in any frame of the robot; default base axes at the tip.
            Several, or at other links: {link: Wrench or list of them}, or [(link, Wrench), ...].
        task: rows in play, as in `find_task`.
        at: link that is the tip of the question.
        gravity: (3) in base axes [m/s²]; `gravity_in_base("ceiling")` for a mounted base.
        singularities: whether to find the arm's singular set too, and how far it is from here (extra `symbolic`; about a
            second, more for arms with spare joints). Where it cannot be had, a note says why.
        brief: whether to leave out what the limits allow (abilities, payload), the bearings, the share of each link in
            gravity and the potential energy: a third of the time, for pages that follow a moving arm.

    Returns:
        Analysis.

    Raises:
        ConfigurationError: KS303 for a batch or a wrong length, of q, the wrench or gravity; KS301 for NaN or huge numbers.
        UnknownNameError: KS318 for a task or row that does not exist, KS310 for a link.

    Example:
        >>> import kinestatics as ks
        >>> a = ks.analyze(ks.load("planar_2r"), [0.0, 0.0])
        >>> a.rank, a.lost_twists[0].text
        (1, 'no velocity along x of base')
    """
    require_model(model)
    array, xp = configuration(model, model.home if q is None else q)
    values = _one_configuration(array, xp)
    J = jacobian(model, values, at=at, check_finite=False)
    found, length = find_task(model, task, at=at), characteristic_length(model, at)
    exact = without_rounding(model, finite_array(J.array, "the Jacobian"))
    scaled = mixed_units(found, model, at)
    columns = np.where(prismatic_columns(model), length, 1.0) if PRISMATIC_SCALED in scaled else np.ones(model.n)
    parts = decompose(exact * columns, found.rows, length if ANGULAR_SCALED in scaled else 1.0)
    lost, free = _in_words(parts, J, length)
    down = finite_array(checked_gravity(gravity), "gravity")
    notes: list[str] = []
    velocity, force = ellipsoids(J, found)
    singular_set, card = singular_here(model, values, found, at, notes) if singularities else (None, None)
    nowhere = () if singularities and not found.rank else None  # what never moves has no singularities
    able, speed_rows = ((), ()) if brief else abilities(model, values, J, found, down, notes)
    return Analysis(
        robot=model.name,
        base=model.base,
        tip=J.link,
        joints=model.joint_names,
        kinds=model.joint_kinds,
        configuration=values,
        pose=pose(model, values, at=at, check_finite=False),
        jacobian=J,
        task=found,
        rank=parts.rank,
        singular_values=parts.singular_values,
        condition=_condition(parts, found),
        isotropy=float(isotropy(J, task=found.rows, length=length)) if found.rank else 0.0,
        characteristic_length=length,
        scaled=scaled,
        manipulability=float(manipulability(J, task=found.rows)) if found.rank else 0.0,
        manipulability_unit=manipulability_unit(found, model, at),
        tolerance=parts.tolerance,
        lost_twists=lost,
        free_wrenches=free,
        velocity_ellipsoid=velocity,
        force_ellipsoid=force,
        abilities=able,
        speed_rows=speed_rows,
        payloads={name: float(model.masses[model.link(name)]) for name in model.payloads},
        payload_capacity=None if brief else greatest_payload(model, values, J, down),
        gravity=down,
        **held(model, values, J, wrench, down, notes, brief),
        effort_limits=model.effort_limits,
        margins=_margins(model, values),
        near=nowhere if card is None else card.near,
        singular_set=singular_set,
        card=card,
        notes=tuple(notes),
    )


def _one_configuration(array: Array, xp: Namespace) -> Array:
    if xp.name != "numpy":
        hint = "q = np.asarray(q) first; the functions (ks.jacobian, ...) take it as it is"
        raise ArrayTypeError("KS302", f"analyze computes with NumPy; q is an array of {xp.name}", hint)
    if array.ndim != 1:
        raise ConfigurationError(
            "KS303", "analyze takes one numeric configuration", "loop over a batch, or use an Evaluator"
        )
    return np.array(array, dtype=np.float64)


def _condition(parts: Decomposition, task: Task) -> float:
    if task.rank == 0 or parts.rank < task.rank:
        return float("inf")
    return float(parts.singular_values[0] / parts.singular_values[task.rank - 1])


def _in_words(parts: Decomposition, J: Jacobian, length: float) -> tuple[tuple[Screw, ...], tuple[Screw, ...]]:
    axes, origin = J.frame.axes, J.frame.origin
    lost = tuple(describe_lost_twist(twist, axes, origin, length) for twist in parts.lost_twists)
    free = tuple(describe_free_wrench(wrench, axes, origin, length) for wrench in parts.free_wrenches)
    return lost, free


def _margins(model: RobotModel, q: Array) -> tuple[Margin, ...]:
    margins = []
    for name, x, lower, upper in zip(model.joint_names, q, model.lower, model.upper, strict=True):
        if not (np.isfinite(lower) or np.isfinite(upper)):
            continue
        limit, distance = ("lower", x - lower) if x - lower < upper - x else ("upper", upper - x)
        span = upper - lower if np.isfinite(upper - lower) else 1.0
        near = bool(distance <= NEAR_LIMIT * span)
        margins.append(Margin(name, limit, float(distance), near, bool(lower == upper)))
    return tuple(margins)
