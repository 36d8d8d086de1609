"""kinestatics: differential kinematics and statics of robot arms.

    >>> import kinestatics as ks
    >>> arm = ks.load("ur5e")
    >>> J = ks.jacobian(arm, arm.home)

Conventions (docs/conventions.md): SI units and radians; batch axes first; six-vectors linear first; the default Jacobian
is Frame("base", "tip"), the geometric Jacobian of textbooks.
"""

from . import _kernels as kernels
from .analysis import Analysis, analyze
from .conventions import CONVENTIONS
from .errors import (
    ArrayTypeError,
    ConfigurationError,
    FrameMismatchError,
    KinestaticsError,
    KinestaticsWarning,
    MissingExtraError,
    MissingMassError,
    RobotDefinitionError,
    RobotFileError,
    UnknownNameError,
)
from .evaluator import Evaluator
from .frames import Frame
from .kinematics import (
    acceleration,
    com_jacobians,
    hessian,
    jacobian,
    jacobian_rate,
    pose,
    relative_jacobian,
)
from .manipulability import condition_number, manipulability, singular_values
from .model import RobotModel
from .quantities import Acceleration, Hessian, Jacobian, JacobianRate, Pose, Twist, Wrench
from .recognition import Recognition, which_convention
from .robots.catalogue import catalogue_names
from .robots.dh import from_dh
from .robots.loading import load
from .robots.screws import from_screws, screw_axis
from .statics import free_wrenches, gravity_torques, joint_torques, lost_twists
from .tasks import Task, characteristic_length, find_task

__version__ = "0.1.0"

__all__ = [
    "CONVENTIONS",
    "Acceleration",
    "Analysis",
    "ArrayTypeError",
    "ConfigurationError",
    "Evaluator",
    "Frame",
    "FrameMismatchError",
    "Hessian",
    "Jacobian",
    "JacobianRate",
    "KinestaticsError",
    "KinestaticsWarning",
    "MissingExtraError",
    "MissingMassError",
    "Pose",
    "Recognition",
    "RobotDefinitionError",
    "RobotFileError",
    "RobotModel",
    "Task",
    "Twist",
    "UnknownNameError",
    "Wrench",
    "acceleration",
    "analyze",
    "catalogue_names",
    "characteristic_length",
    "com_jacobians",
    "condition_number",
    "find_task",
    "free_wrenches",
    "from_dh",
    "from_screws",
    "gravity_torques",
    "hessian",
    "jacobian",
    "jacobian_rate",
    "joint_torques",
    "kernels",
    "load",
    "lost_twists",
    "manipulability",
    "pose",
    "relative_jacobian",
    "screw_axis",
    "singular_values",
    "which_convention",
]
