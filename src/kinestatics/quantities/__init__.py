"""Pose, Twist, Wrench, Acceleration, Jacobian: an array and the frame it is written in. Floor 3. No physics.

Every six-vector knows its axes and its point; a mismatch is an error that names both frames and the remedy. The array
may be of any library and have leading batch axes.
"""

from .arrays import check_batches, checked_poses, in_one_library, numeric, plain
from .frozen import Frozen
from .jacobians import Hessian, Jacobian, JacobianMatrix, JacobianRate, Locate, seen_from
from .poses import Pose
from .printing import TIED, WIDTH, format_number, largest, named_table, numbered, table, wrapped
from .six_vectors import (
    Acceleration,
    SixVector,
    Twist,
    Wrench,
    gains_terms,
    require_one_frame,
    require_one_side,
    rewritten,
)

__all__ = [
    "TIED",
    "WIDTH",
    "Acceleration",
    "Frozen",
    "Hessian",
    "Jacobian",
    "JacobianMatrix",
    "JacobianRate",
    "Locate",
    "Pose",
    "SixVector",
    "Twist",
    "Wrench",
    "check_batches",
    "checked_poses",
    "format_number",
    "gains_terms",
    "in_one_library",
    "largest",
    "named_table",
    "numbered",
    "numeric",
    "plain",
    "require_one_frame",
    "require_one_side",
    "rewritten",
    "seen_from",
    "table",
    "wrapped",
]

for _quantity in (Acceleration, Hessian, Jacobian, JacobianMatrix, JacobianRate, Pose, Twist, Wrench):
    _quantity.__module__ = __name__  # so that a pickle does not depend on the files of this folder
