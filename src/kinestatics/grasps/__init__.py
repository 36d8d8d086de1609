"""Grasps: fingers on an object. Contacts, the grasp matrix, internal forces, force closure, and what holds a load. Floor 8.

Contacts, wrenches and motions are written in one frame of the object, `Frame.body("object")`; forces at a contact are those
of the finger on the object. The object is part of the robot's environment.
"""

from .closure import ForceClosure, force_closure
from .contacts import Contact
from .equilibrium import GraspEquilibrium, grasp_equilibrium
from .grasp_map import contact_wrench, grasp_matrix, internal_forces

__all__ = [
    "Contact",
    "ForceClosure",
    "GraspEquilibrium",
    "contact_wrench",
    "force_closure",
    "grasp_equilibrium",
    "grasp_matrix",
    "internal_forces",
]
