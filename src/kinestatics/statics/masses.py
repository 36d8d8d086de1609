"""What the masses of an arm come to: their potential energy, their common centre, and the inertia the joints feel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import definition
from .._kernels import STANDARD_GRAVITY
from ..errors import ConfigurationError
from ..kinematics import configuration
from ..model import RobotModel
from ..namespaces import Array
from .gravity import require_masses, weighted


class CenterOfMass(NamedTuple):
    """Where a mass can be thought to be, and how much it is.

    Attributes:
        point: (..., 3) in base axes, from the base origin [m].
        mass: [kg].

    Example:
        >>> import kinestatics as ks
        >>> ks.center_of_mass(ks.load("ur5e"), ks.load("ur5e").home).mass
        17.7
    """

    point: Array
    mass: Any


def potential_energy(
    model: RobotModel,
    q: Any,
    *,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    by_link: bool = False,
    check_finite: bool = True,
) -> Array:
    """The potential energy of the arm's masses; a mass at the base origin has none.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        gravity: (3) in base axes [m/s²].
        by_link: one entry for each link instead of the sum.

    Returns:
        (...) or (..., L) [J].

    Raises:
        MissingMassError: KS320. ConfigurationError: KS301, KS303.

    Law: U = -Σ m gᵀ p_com; its gradient is `gravity_torques`. Source: MLS section 4.2.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(0, 0, 0)])
        >>> float(ks.potential_energy(arm, [0.0], gravity=(-10.0, 0, 0)))
        20.0
    """
    array, vector, xp = weighted(model, q, gravity, check_finite)
    energies = definition.potential_energy_by_link(model, array, vector, xp)
    return energies if by_link else energies.sum(-1)


def center_of_mass(model: RobotModel, q: Any, *, moving: bool = False, check_finite: bool = True) -> CenterOfMass:
    """The common centre of mass of the arm's links.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        moving: count only the links that some joint moves, not those that stand still with the base.

    Returns:
        CenterOfMass: point (..., 3) in base axes [m], and mass [kg].

    Raises:
        MissingMassError: KS320. ConfigurationError: KS301, KS303 (also where nothing that moves has mass).

    Law: p = Σ m p_com / Σ m.

    Example:
        >>> import kinestatics as ks
        >>> point, mass = ks.center_of_mass(ks.load("planar_2r"), [0.0, 0.0])
        >>> point, mass
        (array([1., 0., 0.]), 2.0)
    """
    require_masses(model)
    array, xp = configuration(model, q, check_finite)
    counted = model.masses * np.array([joint >= 0 or not moving for joint in model.link_joints])
    total = counted.sum()
    if total == 0:
        message = f"none of the links of robot {model.name!r} that move has mass"
        raise ConfigurationError("KS303", message, "moving=False counts the links that stand still")
    points = definition.centers_of_mass(model, array, xp)
    weights = xp.constant(counted / total, array)
    return CenterOfMass((points * weights[:, None]).sum(-2), total if model.masses.dtype == object else float(total))


def mass_matrix(model: RobotModel, q: Any, *, check_finite: bool = True) -> Array:
    """The inertia that the joints feel: force or torque of each joint per unit acceleration of each joint.

    Args:
        model: the robot. Only what its links weigh counts: no rotors, no armature.
        q: (..., n) [rad or m].

    Returns:
        (..., n, n), symmetric [kg m² between turning joints, kg between sliding ones, kg m between the two].

    Raises:
        MissingMassError: KS320. ConfigurationError: KS301, KS303.

    Law: kinetic energy = ½ q̇ᵀ M q̇; M = Σ J_comᵀ m J_com + J_ωᵀ I J_ω. Source: MLS section 4.3.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(-0.5, 0, 0)])
        >>> ks.mass_matrix(arm, [0.0])
        array([[0.5]])
    """
    require_masses(model)
    array, xp = configuration(model, q, check_finite)
    return definition.mass_matrix(model, array, xp)
