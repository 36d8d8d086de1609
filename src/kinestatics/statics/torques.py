"""Joint torques that hold a wrench: the transpose of the Jacobian. Source: note 000; MLS section 3.4."""

from __future__ import annotations

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array
from ..quantities import Jacobian, Wrench, check_batches, in_one_library
from ..spatial import WRENCH_NAMES, rotate, transpose


def joint_torques(J: Jacobian, wrench: Wrench) -> Array:
    """The joint torques that hold a wrench in equilibrium.

    Args:
        J: Jacobian (..., 6, n) of the link the wrench acts at.
        wrench: (..., 6) in the frame of J; `Wrench.on_environment` or `Wrench.on_robot` decides the sign. Finite: NaN
            is a free component of a twist, a wrench has 0 where there is no force.

    Returns:
        (..., n) [N m, or N for a prismatic joint]: Jᵀ w for what the robot exerts, -Jᵀ w for a load on the robot.

    Raises:
        FrameMismatchError: KS330, with the remedy.
        ConfigurationError: KS301 numbers of NumPy that are not finite, KS303 batches that do not fit.

    Law: virtual work, τ · δq = w · V. Source: note 000; MLS eq. 3.61 (errata E001-3 for the sign).

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> ks.joint_torques(J, ks.Wrench.on_robot(force=(0, -10, 0)))
        array([20., 10.])
    """
    if not (isinstance(J, Jacobian) and isinstance(wrench, Wrench)):
        found = f"{type(J).__name__} and {type(wrench).__name__}"
        hint = "J = ks.jacobian(arm, q); Wrench.on_robot(force=...) for a load, Wrench.on_environment(...) for a push"
        raise ArrayTypeError("KS302", f"joint_torques takes a Jacobian and a Wrench, not {found}", hint)
    J.require_frame(wrench.frame, "wrench")
    require_finite(wrench.array, "the wrench")
    (matrix, six), _ = in_one_library({"the Jacobian": J.array, "the wrench": wrench.array})
    check_batches("the Jacobian", matrix.shape[:-2], "the wrench", six.shape[:-1])
    torques = rotate(transpose(matrix), six)
    return torques if wrench.acts_on == "environment" else 0 - torques  # 0 - x has no minus before a zero


def require_finite(six: Array, what: str, most: float = np.inf) -> None:
    """Raises ConfigurationError (KS301) where a wrench (..., 6) of NumPy holds NaN, or numbers not below `most`.

    Arrays of other libraries pass as they are: under jit they have no numbers yet.
    """
    if not isinstance(six, np.ndarray) or six.dtype == object:
        return
    good = np.isfinite(six) if most == np.inf else np.abs(six) < most
    if good.all():
        return
    *place, row = (int(i) for i in np.argwhere(~good)[0])
    where = f" of wrench [{', '.join(map(str, place))}]" if place else ""
    message = f"{what} is not finite: {WRENCH_NAMES[row]}{where} is {six[(*place, row)]:g}"
    below = "" if most == np.inf else f", numbers below {most:g} elsewhere"
    raise ConfigurationError("KS301", message, f"0 where there is no force or moment{below}; NaN as free is for twists")
