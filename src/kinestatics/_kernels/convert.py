"""What the kernels do with arguments that are not plain float64 arrays. Called from C; not on the fast path."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array, as_array
from ..quantities import JacobianMatrix, Pose, Twist, Wrench


def to_float64(value: Any, what: str) -> Array:
    """`value` as a new or the same C-contiguous, aligned float64 array of exact type numpy.ndarray.

    Raises:
        ArrayTypeError: KS302, for arrays of other libraries, symbols, masked and complex arrays.
    """
    if isinstance(value, Twist | Wrench | Pose | JacobianMatrix):
        raise ArrayTypeError(
            "KS302",
            f"{what} is a {type(value).__name__}; an Evaluator takes bare arrays, and would drop its frame and sign",
            "use the functions (kinestatics.joint_torques(J, wrench), ...), or pass its .array in the Evaluator's frame",
        )
    array, xp = as_array(value, what)
    if xp.name != "numpy":
        raise ArrayTypeError(
            "KS302",
            f"{what} is an array of {xp.name}; an Evaluator computes with NumPy",
            f"use the functions (kinestatics.jacobian(arm, q), ...), which run on {xp.name}",
        )
    return np.require(np.array(array, dtype=np.float64, order="C", copy=None, subok=False), requirements=["C", "A"])
