"""Gravity: the torques that hold an arm's own weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import definition
from .._kernels import STANDARD_GRAVITY, Chain, chain_arguments
from ..errors import ArrayTypeError, ConfigurationError, MissingMassError
from ..frames import BASE
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array


def gravity_torques(
    model: RobotModel,
    q: Any,
    *,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    by_link: bool = False,
    check_finite: bool = True,
) -> Array:
    """The joint torques that hold the arm still against gravity.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        gravity: (3) acceleration of free fall in base axes [m/s²]; turn it for a mounted base.
        by_link: one row for each link instead of the sum.

    Returns:
        (..., n) or (..., L, n) [N m, or N for a prismatic joint].

    Raises:
        MissingMassError: KS320, when the robot's file gives no masses.
        ConfigurationError: KS303, when gravity is not three finite numbers (or symbols).

    Law: τ = -Σ J_comᵀ m g, the gradient of the potential energy. Source: note 000, "gravity compensation".

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(-0.5, 0, 0)])
        >>> ks.gravity_torques(arm, [0.0], gravity=(0, -9.81, 0))
        array([9.81])
    """
    require_model(model)
    if not model.has_masses:
        raise missing_masses(model)
    array, xp = configuration(model, q, check_finite)
    gravity = checked_gravity(gravity)
    if by_link:
        return definition.gravity_torques_by_link(model, array, gravity, xp)
    if xp.name == "numpy" and model.masses.dtype != object:
        return _gravity_chain(model, tuple(float(g) for g in gravity)).gravity_torques(array)
    return definition.gravity_torques(model, array, gravity, xp)


def missing_masses(model: RobotModel) -> MissingMassError:
    """The error for a static question to an arm whose masses are unknown."""
    hint = "its file gives none; a result of zero would be wrong, not light"
    return MissingMassError("KS320", f"robot {model.name!r} has no masses", hint)


def checked_gravity(gravity: Sequence[float]) -> Any:
    """Gravity as an array (3) of numbers or of symbols.

    Raises:
        ConfigurationError: KS303, when it is not three finite numbers.
    """
    hint = "m/s², in base axes: (0, 0, -9.81)"
    try:
        vector, xp = as_array(gravity, "gravity")
    except (ArrayTypeError, ValueError):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 numbers", hint) from None
    if tuple(vector.shape) != (3,) or (xp.name == "numpy" and not np.all(np.isfinite(vector))):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 finite numbers", hint)
    return vector


def _gravity_chain(model: RobotModel, gravity: tuple[float, ...]) -> Chain:
    chains: dict[tuple[float, ...], Chain] = model.__dict__.setdefault("_gravity_chains", {})
    if gravity not in chains:
        if len(chains) >= 16:
            chains.clear()
        chains[gravity] = Chain(*chain_arguments(model, model.link(BASE), gravity=(gravity[0], gravity[1], gravity[2])))
    return chains[gravity]
