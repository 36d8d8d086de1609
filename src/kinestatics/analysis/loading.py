"""The static part of an analysis: what weight and loads ask of motors, structure and bearings."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Jacobian, Wrench
from ..statics import Loads, applied_loads, gravity_torques, joint_reactions, joint_torques, potential_energy
from ..tasks import characteristic_length
from .checks import finite_array
from .result import AppliedLoad


def held(
    model: RobotModel, q: Array, J: Jacobian, loads: Loads, gravity: Array, notes: list[str], brief: bool = False
) -> dict[str, Any]:
    """Gravity, loads and reactions at one configuration, under the names that `Analysis` gives them."""
    asked = [_applied(model, q, name, wrench) for name, wrench in _at_the_tip(model, J, loads)]
    for_loads = finite_array(sum((load.joint_torques for load in asked), np.zeros(model.n)), "the joint torques")
    found = _weight(model, q, gravity, notes, brief)
    own = found["gravity_torques"]
    if asked and not np.all(np.isfinite(model.effort_limits)):
        notes.append("effort limits are unknown for some joints: torques are not compared with them")
    known = own is not None or bool(asked)
    reactions = None
    if known and not brief:
        wrenches = [(load.link, load.wrench) for load in asked]
        down = None if own is None else gravity
        reactions = joint_reactions(model, q, wrenches, gravity=down, check_finite=False)
    return {
        **found,
        "loads": tuple(asked),
        "joint_torques": for_loads if asked else None,
        "holding_torques": (for_loads if own is None else own + for_loads) if known else None,
        "reactions": reactions,
    }


def _at_the_tip(model: RobotModel, J: Jacobian, loads: Loads) -> list[tuple[str, Wrench]]:
    """Each load with the name of its link and its frame named; a bare Wrench acts at the link of the analysis."""
    given: Loads = {J.link: loads} if isinstance(loads, Wrench) else loads
    return [(model.link_name(load.link), load.wrench) for load in applied_loads(model, given)]


def _applied(model: RobotModel, q: Array, link: str, wrench: Wrench) -> AppliedLoad:
    six = wrench.array
    if not isinstance(six, np.ndarray) or six.shape != (6,) or six.dtype == object:
        hint = "loop over a batch, or use joint_torques"
        raise ConfigurationError("KS303", "analyze takes wrenches of six finite numbers", hint)
    finite_array(six, "the wrench")
    J = jacobian(model, q, at=link, frame=wrench.frame, check_finite=False)
    named = Wrench(six, J.frame, wrench.acts_on)
    torques = finite_array(joint_torques(J, named), "the joint torques")
    return AppliedLoad(link, named, torques, J, characteristic_length(model, link))


def _weight(model: RobotModel, q: Array, gravity: Array, notes: list[str], brief: bool) -> dict[str, Any]:
    if not model.has_masses:
        notes.append("no masses are known: gravity torques are left out")
        return {"gravity_torques": None, "gravity_by_link": None, "potential_energy": None}
    by_link = None
    if not brief:
        torques_by_link = gravity_torques(model, q, gravity=gravity, by_link=True, check_finite=False)
        named = zip(model.link_names, model.masses, torques_by_link, strict=True)
        by_link = {name: torques for name, mass, torques in named if mass > 0}
    return {
        "gravity_torques": gravity_torques(model, q, gravity=tuple(gravity.tolist()), check_finite=False),
        "gravity_by_link": by_link,
        "potential_energy": None if brief else float(potential_energy(model, q, gravity=gravity, check_finite=False)),
    }
