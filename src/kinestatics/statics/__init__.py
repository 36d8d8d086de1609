"""Statics: the transpose of the Jacobian. Joint torques, gravity, wrenches held for free, twists lost with them. Floor 7.

Signs: `joint_torques` and `gravity_torques` return what the motors must supply to hold still.
"""

from .gravity import checked_gravity, gravity_torques, missing_masses
from .subspaces import RANK_TOLERANCE, Decomposition, decompose, free_wrenches, lost_twists
from .torques import joint_torques

__all__ = [
    "RANK_TOLERANCE",
    "Decomposition",
    "checked_gravity",
    "decompose",
    "free_wrenches",
    "gravity_torques",
    "joint_torques",
    "lost_twists",
    "missing_masses",
]
