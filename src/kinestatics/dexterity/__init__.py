"""Dexterity: measures, ellipsoids and polytopes; functions of a Jacobian and limits only. Floor 8."""

from .directions import speed_capacity
from .ellipsoid import Ellipsoid
from .ellipsoids import force_ellipsoid, velocity_ellipsoid
from .gradients import manipulability_gradient
from .measures import (
    asada,
    condition_number,
    inverse_condition,
    isotropy,
    manipulability,
    singular_values,
    smallest_singular_value,
)
from .polytope import Polytope
from .polytopes import force_polytope, velocity_polytope
from .speed_result import SpeedCapacity

__all__ = [
    "Ellipsoid",
    "Polytope",
    "SpeedCapacity",
    "asada",
    "condition_number",
    "force_ellipsoid",
    "force_polytope",
    "inverse_condition",
    "isotropy",
    "manipulability",
    "manipulability_gradient",
    "singular_values",
    "smallest_singular_value",
    "speed_capacity",
    "velocity_ellipsoid",
    "velocity_polytope",
]
