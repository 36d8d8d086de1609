"""kinestatics: differential kinematics and statics of robot arms.

    >>> import kinestatics as ks
    >>> arm = ks.load("ur5e")
    >>> J = ks.jacobian(arm, arm.home)

Conventions (docs/conventions.md): SI units and radians; batch axes first; six-vectors linear first; the default Jacobian
is Frame("base", "tip"), the geometric Jacobian of textbooks.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import _kernels as kernels, plots as plots  # noqa: F401
    from .analysis import (
        Analysis as Analysis,
        analyze as analyze,
    )
    from .conventions import (
        CONVENTIONS as CONVENTIONS,
    )
    from .dexterity import (
        Ellipsoid as Ellipsoid,
        Polytope as Polytope,
        SpeedCapacity as SpeedCapacity,
        asada as asada,
        condition_number as condition_number,
        force_ellipsoid as force_ellipsoid,
        force_polytope as force_polytope,
        inverse_condition as inverse_condition,
        isotropy as isotropy,
        manipulability as manipulability,
        manipulability_gradient as manipulability_gradient,
        singular_values as singular_values,
        smallest_singular_value as smallest_singular_value,
        speed_capacity as speed_capacity,
        velocity_ellipsoid as velocity_ellipsoid,
        velocity_polytope as velocity_polytope,
    )
    from .errors import (
        ArrayTypeError as ArrayTypeError,
        ConfigurationError as ConfigurationError,
        FrameMismatchError as FrameMismatchError,
        KinestaticsError as KinestaticsError,
        KinestaticsWarning as KinestaticsWarning,
        MissingExtraError as MissingExtraError,
        MissingMassError as MissingMassError,
        RobotDefinitionError as RobotDefinitionError,
        RobotFileError as RobotFileError,
        UnknownNameError as UnknownNameError,
    )
    from .evaluator import (
        Evaluator as Evaluator,
    )
    from .explorer import (
        Explorer as Explorer,
        explore as explore,
    )
    from .frames import (
        Frame as Frame,
    )
    from .grasps import (
        Contact as Contact,
        ForceClosure as ForceClosure,
        GraspEquilibrium as GraspEquilibrium,
        contact_wrench as contact_wrench,
        force_closure as force_closure,
        grasp_equilibrium as grasp_equilibrium,
        grasp_matrix as grasp_matrix,
        internal_forces as internal_forces,
    )
    from .inverse_velocity import (
        JointRates as JointRates,
        PrioritizedRates as PrioritizedRates,
        RateLimits as RateLimits,
        RateSolver as RateSolver,
        SelfMotion as SelfMotion,
        TipMotion as TipMotion,
        joint_rates as joint_rates,
        move_tip as move_tip,
        prioritized_rates as prioritized_rates,
        self_motion as self_motion,
    )
    from .kinematics import (
        acceleration as acceleration,
        com_jacobians as com_jacobians,
        hessian as hessian,
        jacobian as jacobian,
        jacobian_rate as jacobian_rate,
        pose as pose,
        relative_jacobian as relative_jacobian,
    )
    from .model import (
        RobotModel as RobotModel,
    )
    from .notebook import (
        Shown as Shown,
        show as show,
    )
    from .quantities import (
        Acceleration as Acceleration,
        Hessian as Hessian,
        Jacobian as Jacobian,
        JacobianRate as JacobianRate,
        Pose as Pose,
        Twist as Twist,
        Wrench as Wrench,
    )
    from .recognition import (
        Recognition as Recognition,
        which_convention as which_convention,
    )
    from .robots.catalogue import (
        catalogue_names as catalogue_names,
    )
    from .robots.dh import (
        from_dh as from_dh,
    )
    from .robots.inspection import (
        Inspection as Inspection,
        inspect_robot as inspect_robot,
    )
    from .robots.loading import (
        load as load,
    )
    from .robots.screws import (
        from_screws as from_screws,
        screw_axis as screw_axis,
    )
    from .scene.arm_scene import (
        View as View,
    )
    from .screws_in_words import (
        Screw as Screw,
    )
    from .singular_sets import (
        SingularSet as SingularSet,
        singularities as singularities,
    )
    from .six_vectors import (
        adjoint as adjoint,
        bracket_matrix as bracket_matrix,
        change_frame as change_frame,
        net_wrench as net_wrench,
        power as power,
        screw as screw,
    )
    from .statics import (
        Capacity as Capacity,
        CenterOfMass as CenterOfMass,
        JointReactions as JointReactions,
        LoadSplit as LoadSplit,
        TipStiffness as TipStiffness,
        WrenchEstimate as WrenchEstimate,
        center_of_mass as center_of_mass,
        force_capacity as force_capacity,
        free_wrench_projector as free_wrench_projector,
        free_wrenches as free_wrenches,
        gravity_in_base as gravity_in_base,
        gravity_torques as gravity_torques,
        holding_torques as holding_torques,
        joint_reactions as joint_reactions,
        joint_torques as joint_torques,
        lost_twists as lost_twists,
        mass_matrix as mass_matrix,
        payload_capacity as payload_capacity,
        potential_energy as potential_energy,
        split_load as split_load,
        tip_compliance as tip_compliance,
        tip_stiffness as tip_stiffness,
        wrench_from_torques as wrench_from_torques,
    )
    from .symbolic.closed_form import (
        ClosedForm as ClosedForm,
        closed_form as closed_form,
    )
    from .symbolic.code import (
        generate_code as generate_code,
    )
    from .symbolic.derivation import (
        derivation as derivation,
    )
    from .symbolic.exact import (
        exact as exact,
        joint_symbols as joint_symbols,
    )
    from .symbolic.latex import (
        to_latex as to_latex,
    )
    from .tasks import (
        Task as Task,
        characteristic_length as characteristic_length,
        find_task as find_task,
    )

__version__ = "0.1.0"

_CONTENTS = {  # what is public and where it is defined; a module is imported when a name of it is first used
    "analysis": (
        "Analysis",
        "analyze",
    ),
    "conventions": ("CONVENTIONS",),
    "errors": (
        "ArrayTypeError",
        "ConfigurationError",
        "FrameMismatchError",
        "KinestaticsError",
        "KinestaticsWarning",
        "MissingExtraError",
        "MissingMassError",
        "RobotDefinitionError",
        "RobotFileError",
        "UnknownNameError",
    ),
    "evaluator": ("Evaluator",),
    "explorer": (
        "Explorer",
        "explore",
    ),
    "frames": ("Frame",),
    "grasps": (
        "Contact",
        "ForceClosure",
        "GraspEquilibrium",
        "contact_wrench",
        "force_closure",
        "grasp_equilibrium",
        "grasp_matrix",
        "internal_forces",
    ),
    "inverse_velocity": (
        "JointRates",
        "PrioritizedRates",
        "RateLimits",
        "RateSolver",
        "SelfMotion",
        "TipMotion",
        "joint_rates",
        "move_tip",
        "prioritized_rates",
        "self_motion",
    ),
    "kinematics": (
        "acceleration",
        "com_jacobians",
        "hessian",
        "jacobian",
        "jacobian_rate",
        "pose",
        "relative_jacobian",
    ),
    "dexterity": (
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
    ),
    "model": ("RobotModel",),
    "notebook": (
        "Shown",
        "show",
    ),
    "quantities": (
        "Acceleration",
        "Hessian",
        "Jacobian",
        "JacobianRate",
        "Pose",
        "Twist",
        "Wrench",
    ),
    "recognition": (
        "Recognition",
        "which_convention",
    ),
    "robots.catalogue": ("catalogue_names",),
    "robots.dh": ("from_dh",),
    "robots.inspection": (
        "Inspection",
        "inspect_robot",
    ),
    "robots.loading": ("load",),
    "robots.screws": (
        "from_screws",
        "screw_axis",
    ),
    "scene.arm_scene": ("View",),
    "screws_in_words": ("Screw",),
    "singular_sets": (
        "SingularSet",
        "singularities",
    ),
    "six_vectors": (
        "adjoint",
        "bracket_matrix",
        "change_frame",
        "net_wrench",
        "power",
        "screw",
    ),
    "statics": (
        "Capacity",
        "CenterOfMass",
        "JointReactions",
        "LoadSplit",
        "TipStiffness",
        "WrenchEstimate",
        "center_of_mass",
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
        "payload_capacity",
        "potential_energy",
        "split_load",
        "tip_compliance",
        "tip_stiffness",
        "wrench_from_torques",
    ),
    "symbolic.closed_form": (
        "ClosedForm",
        "closed_form",
    ),
    "symbolic.code": ("generate_code",),
    "symbolic.derivation": ("derivation",),
    "symbolic.exact": (
        "exact",
        "joint_symbols",
    ),
    "symbolic.latex": ("to_latex",),
    "tasks": (
        "Task",
        "characteristic_length",
        "find_task",
    ),
}
_HOMES = {name: module for module, names in _CONTENTS.items() for name in names}
_MODULES = {"kernels": "_kernels", "plots": "plots"}

__all__ = [  # noqa: PLE0604 - the names are listed once, above
    *sorted([*_HOMES, *_MODULES]),
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        value: Any = import_module(f".{_MODULES[name]}", __name__)
    elif name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
