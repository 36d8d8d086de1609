"""Statics: the transpose of the Jacobian. Joint torques, gravity, wrenches held for free, twists lost with them. Floor 7.

Signs: `joint_torques` and `gravity_torques` return what the motors must supply to hold still.
"""

from .capacity import force_capacity, payload_capacity
from .capacity_result import Capacity
from .estimate_result import WrenchEstimate
from .estimation import wrench_from_torques
from .gravity import checked_gravity, gravity_in_base, gravity_torques, missing_masses
from .loads import Load, Loads, applied_loads, holding_torques
from .masses import CenterOfMass, center_of_mass, mass_matrix, potential_energy
from .reactions import joint_reactions
from .reactions_result import JointReactions
from .splits import LoadSplit, split_load
from .stiffness import TipStiffness, tip_compliance, tip_stiffness
from .subspaces import RANK_TOLERANCE, Decomposition, decompose, free_wrench_projector, free_wrenches, lost_twists
from .torques import joint_torques

__all__ = [
    "RANK_TOLERANCE",
    "Capacity",
    "CenterOfMass",
    "Decomposition",
    "JointReactions",
    "Load",
    "LoadSplit",
    "Loads",
    "TipStiffness",
    "WrenchEstimate",
    "applied_loads",
    "center_of_mass",
    "checked_gravity",
    "decompose",
    "force_capacity",
    "free_wrench_projector",
    "free_wrenches",
    "gravity_in_base",
    "gravity_torques",
    "holding_torques",
    "joint_reactions",
    "joint_torques",
    "lost_twists",
    "mass_matrix",
    "missing_masses",
    "payload_capacity",
    "potential_energy",
    "split_load",
    "tip_compliance",
    "tip_stiffness",
    "wrench_from_torques",
]
