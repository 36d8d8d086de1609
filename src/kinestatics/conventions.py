"""How other libraries and books write a Jacobian: row order, axes, reference point, layout. Floor 2.

Measured on a planar 2R arm, or read in the source or documentation (docs/conventions.md has the table with numbers).
"""

from __future__ import annotations

from typing import Final, NamedTuple

from .errors import UnknownNameError, nearest
from .frames import BASE, TIP

LINEAR_FIRST: Final = "linear-angular"
ANGULAR_FIRST: Final = "angular-linear"
ORDERS: Final = (LINEAR_FIRST, ANGULAR_FIRST)
MATRIX, FLAT_COLUMNS, TWO_ARRAYS = "6 x n", "flat, column after column", "two 3 x n arrays"


class Convention(NamedTuple):
    """One way to write the same Jacobian.

    Attributes:
        name: what to call it here, "library.variant".
        order: "linear-angular" (v, ω) or "angular-linear" (ω, v).
        axes, origin: "base" or "tip", as in `Frame`.
        layout: "6 x n", "flat, column after column" (dynibo) or "two 3 x n arrays" (MuJoCo: jacp, jacr).
        call: what returns it there.
    """

    name: str
    order: str
    axes: str
    origin: str
    layout: str
    call: str


_HYBRID, _SPATIAL, _BODY = (BASE, TIP), (BASE, BASE), (TIP, TIP)
CONVENTIONS: Final = {
    c.name: c
    for c in (
        Convention("pinocchio.WORLD", LINEAR_FIRST, *_SPATIAL, MATRIX, "computeFrameJacobian(..., WORLD)"),
        Convention("pinocchio.LOCAL", LINEAR_FIRST, *_BODY, MATRIX, "computeFrameJacobian(..., LOCAL)"),
        Convention("pinocchio.LOCAL_WORLD_ALIGNED", LINEAR_FIRST, *_HYBRID, MATRIX, "computeFrameJacobian(..., LWA)"),
        Convention("modern_robotics.space", ANGULAR_FIRST, *_SPATIAL, MATRIX, "JacobianSpace"),
        Convention("modern_robotics.body", ANGULAR_FIRST, *_BODY, MATRIX, "JacobianBody"),
        Convention("mls.spatial", LINEAR_FIRST, *_SPATIAL, MATRIX, "Murray, Li, Sastry eq. 3.54"),
        Convention("mls.body", LINEAR_FIRST, *_BODY, MATRIX, "Murray, Li, Sastry eq. 3.56"),
        Convention("drake", ANGULAR_FIRST, *_HYBRID, MATRIX, "CalcJacobianSpatialVelocity, expressed in the world"),
        Convention("mujoco", LINEAR_FIRST, *_HYBRID, TWO_ARRAYS, "mj_jac (jacp, jacr)"),
        Convention("roboticstoolbox.jacob0", LINEAR_FIRST, *_HYBRID, MATRIX, "Robot.jacob0"),
        Convention("roboticstoolbox.jacobe", LINEAR_FIRST, *_BODY, MATRIX, "Robot.jacobe"),
        Convention("matlab", ANGULAR_FIRST, *_HYBRID, MATRIX, "geometricJacobian"),
        Convention("klampt", ANGULAR_FIRST, *_HYBRID, MATRIX, "link.getJacobian"),
        Convention("skidy.hybrid", ANGULAR_FIRST, *_HYBRID, MATRIX, "hybrid_jacobian_matrix_ee"),
        Convention("kdl", LINEAR_FIRST, *_HYBRID, MATRIX, "ChainJntToJacSolver"),
        Convention("placo.world", LINEAR_FIRST, *_SPATIAL, MATRIX, "frame_jacobian(..., 'world')"),
        Convention("placo.local", LINEAR_FIRST, *_BODY, MATRIX, "frame_jacobian(..., 'local')"),
        Convention(
            "placo.local_world_aligned", LINEAR_FIRST, *_HYBRID, MATRIX, "frame_jacobian(..., 'local_world_aligned')"
        ),
        Convention("pink", LINEAR_FIRST, *_BODY, MATRIX, "Configuration.get_frame_jacobian"),
        Convention("mink", LINEAR_FIRST, *_BODY, MATRIX, "Configuration.get_frame_jacobian"),
        Convention("manipulapy.space", ANGULAR_FIRST, *_SPATIAL, MATRIX, "jacobian(..., frame='space')"),
        Convention("manipulapy.body", ANGULAR_FIRST, *_BODY, MATRIX, "jacobian(..., frame='body')"),
        Convention("dynibo", ANGULAR_FIRST, *_HYBRID, FLAT_COLUMNS, "Robot.jacobian"),
        Convention("frax", LINEAR_FIRST, *_HYBRID, MATRIX, "Manipulator.ee_jacobian"),
        Convention("pytorch_kinematics", LINEAR_FIRST, *_HYBRID, MATRIX, "SerialChain.jacobian"),
        Convention("kinpy", LINEAR_FIRST, *_HYBRID, MATRIX, "Chain.jacobian"),
        Convention("jparse", LINEAR_FIRST, *_HYBRID, MATRIX, "Robot.jacobian"),
        Convention("moro", LINEAR_FIRST, *_HYBRID, MATRIX, "Robot.J"),
    )
}


def find_convention(name: str) -> Convention:
    """The convention of that name.

    Raises:
        UnknownNameError: KS315, with the nearest names.
    """
    if (found := CONVENTIONS.get(name)) is None:
        raise UnknownNameError("KS315", f"no convention {name!r}", nearest(name, CONVENTIONS))
    return found
