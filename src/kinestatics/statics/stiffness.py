"""The tip on springs: how far it gives way under a wrench when the joints are elastic, and how stiff that makes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, FrameMismatchError
from ..frames import Frame
from ..namespaces import Array, Namespace, as_array
from ..quantities import Hessian, Jacobian, Wrench, check_batches, format_number, in_one_library, table
from ..spatial import ANGULAR, ROW_NAMES, WRENCH_NAMES, transpose
from .subspaces import RANK_TOLERANCE, decompose


@dataclass(frozen=True, eq=False)
class TipStiffness:
    """How stiff the tip is on elastic joints, and in which directions it does not give way at all.

    Attributes:
        matrix: (6, 6) wrench [N, N m] per displacement (m, rad) on the subspace that the elastic joints can reach; of the
            wrenches that cause a displacement, the smallest. Symmetric without a preload.
        compliance: (6, 6) displacement per wrench: J K⁻¹ Jᵀ.
        rank: of both.
        rigid: (6 - rank, 6) basis of the displacements (m, rad) at right angles to the reachable ones: infinite stiffness.
        held: (6 - rank, 6) basis of the wrenches that move nothing: the structure and the rigid joints hold them.
        characteristic_length: the size of a displacement is |(d, length · φ)| [m]; tolerance: of the rank.
        frame: in which the matrix is written, with link names; None where J was a bare array.

    Example:
        >>> import kinestatics as ks
        >>> stiffness = ks.tip_stiffness(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]), (1000.0, np.inf))
        >>> stiffness.rank, round(float(stiffness.compliance[1, 1]), 12)
        (1, 0.004)
    """

    matrix: Array
    compliance: Array
    rank: int
    rigid: Array
    held: Array
    characteristic_length: float
    tolerance: float
    frame: Frame | None

    def to_dict(self) -> dict[str, Any]:
        """Plain lists and numbers, for JSON."""
        names = ("matrix", "compliance", "rigid", "held")
        return {
            **{name: getattr(self, name).tolist() for name in names},
            "rank": self.rank,
            "characteristic_length": self.characteristic_length,
            "tolerance": self.tolerance,
        }

    def __str__(self) -> str:
        names = [name.replace("v", "d").replace("w", "r") for name in ROW_NAMES]
        rows = [[name, *(f"{x:.4g}" for x in row)] for name, row in zip(WRENCH_NAMES, self.matrix + 0.0, strict=True)]
        where = "" if self.frame is None else f": {self.frame}"
        lines = [f"tip stiffness{where}", "wrench [N, N m] per displacement [m, rad]", table([["", *names], *rows])]
        if len(self.rigid):
            lines.append(f"rigid directions (infinite stiffness), {len(self.rigid)} of 6")
            lines += ["  " + ", ".join(format_number(x) for x in row) for row in self.rigid]
        return "\n".join(lines)


def tip_compliance(J: Any, joint_stiffness: Any, *, wrench: Wrench | None = None, hessian: Hessian | None = None) -> Array:
    """How far the tip gives way under a wrench, each joint being a spring: displacement (m, rad) per wrench (N, N m).

    Args:
        J: Jacobian (..., 6, n) of the point where the wrench acts; displacement and wrench are in its frame.
        joint_stiffness: (n) or (..., n) [N m/rad, or N/m for a sliding joint], positive; infinite for a rigid joint.
        wrench: a preload under which the arm is at rest already, in the frame of J, whose components stay what they are
            while the arm gives way. It softens or stiffens the arm: K becomes K - K_G.
        hessian: with a preload, `hessian(...)` of the same link in the same frame. The weight of the arm is no part of it.

    Returns:
        (..., 6, 6), symmetric without a preload.

    Raises:
        ArrayTypeError: KS302. FrameMismatchError: KS330. ConfigurationError: KS303; KS326, a stiffness that is not
        positive; KS327, under this preload there is no stable equilibrium: the arm buckles.

    Law: C = J K⁻¹ Jᵀ; with a preload w on the robot C = J (K - K_G)⁻¹ Jᵀ, K_G[j, k] = Σ_r w_r ∂J[r, j]/∂q_k.
    Source: Salisbury, "Active stiffness control of a manipulator in Cartesian coordinates", CDC 1980; Chen, Kao,
    "Conservative congruence transformation for joint and Cartesian stiffness matrices of robotic hands and fingers",
    IJRR 19(9), 2000.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> ks.tip_compliance(J, (1000.0, 500.0))[1]
        array([0.   , 0.006, 0.   , 0.   , 0.   , 0.004])
    """
    matrix, softness, xp = _elastic(J, joint_stiffness)
    columns = matrix * softness[..., None, :]
    if wrench is None:
        return columns @ transpose(matrix)
    bent = _bent(J, wrench, hessian, matrix, xp)
    if xp.linalg is None:
        raise ArrayTypeError("KS302", "a preload needs a linear solver; J holds symbols", "evaluate J at numbers first")
    n = matrix.shape[-1]
    system = xp.constant(np.eye(n), matrix) - bent * softness[..., None, :]
    if xp.name == "numpy":
        _require_stable(bent, softness)
    return columns @ xp.linalg.solve(system, transpose(matrix))


def tip_stiffness(
    J: Any, joint_stiffness: Any, *, length: float = 1.0, wrench: Wrench | None = None, hessian: Hessian | None = None
) -> TipStiffness:
    """How stiff the tip is when each joint is a spring: finite where the elastic joints can move it, infinite elsewhere.

    Args:
        J: one Jacobian (6, n), of numbers; the result is in its frame.
        joint_stiffness: (n) [N m/rad, or N/m for a sliding joint], positive; infinite for a rigid joint.
        length: characteristic length: the size of a displacement is |(d, length · φ)| [m]. It decides the rank, and which
            of the wrenches that cause a displacement `matrix` gives; the energy ½ δᵀ matrix δ does not depend on it.
        wrench, hessian: a preload, as in `tip_compliance`.

    Returns:
        TipStiffness, of which `rigid` spans the directions of infinite stiffness.

    Raises:
        As `tip_compliance`.

    Law: matrix is the generalized inverse of C = J K⁻¹ Jᵀ: C S C = C, S C S = S. Source: as `tip_compliance`.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> stiffness = ks.tip_stiffness(ks.jacobian(arm, [0.0, 1.5707963267948966]), (1000.0, 500.0))
        >>> stiffness.rank, len(stiffness.rigid)
        (2, 4)
    """
    matrix, softness, xp = _elastic(J, joint_stiffness)
    if xp.name != "numpy" or matrix.ndim != 2 or softness.ndim != 1:
        hint = "np.asarray(J), one at a time; tip_compliance takes batches and every library"
        raise ConfigurationError("KS303", f"tip_stiffness takes one numeric Jacobian, got {tuple(matrix.shape)}", hint)
    half = np.sqrt(softness)
    parts = decompose((matrix * half).astype(matrix.dtype), range(6), length)
    weights = np.ones(6)
    weights[ANGULAR] = length
    U, sigma, Vt = np.linalg.svd(weights[:, None] * matrix * half, full_matrices=False)
    r = parts.rank
    U, sigma, Vt = U[:, :r] * weights[:, None], sigma[:r], Vt[:r]
    core = np.eye(r)
    if wrench is not None:
        bent = _bent(J, wrench, hessian, matrix, xp)
        _require_stable(bent, softness)
        within = np.eye(len(half)) - half[:, None] * bent * half
        core = np.linalg.inv(Vt @ np.linalg.solve(within, Vt.T))
    return TipStiffness(
        matrix=(U / sigma) @ core @ (U / sigma).T,
        compliance=tip_compliance(J, joint_stiffness, wrench=wrench, hessian=hessian),
        rank=r,
        rigid=parts.lost_twists,
        held=parts.free_wrenches,
        characteristic_length=length,
        tolerance=RANK_TOLERANCE,
        frame=J.frame if isinstance(J, Jacobian) else None,
    )


def _elastic(J: Any, joint_stiffness: Any) -> tuple[Array, Array, Namespace]:
    """The Jacobian's array, one over the stiffness of each joint, and their common library."""
    bare = J.array if isinstance(J, Jacobian) else J
    (matrix, stiffness), xp = in_one_library({"J": bare, "joint_stiffness": joint_stiffness})
    if matrix.ndim < 2 or matrix.shape[-2] != 6:
        raise ConfigurationError("KS303", f"J has shape {tuple(matrix.shape)}; expected (..., 6, n)", "ks.jacobian(arm, q)")
    n = matrix.shape[-1]
    if stiffness.ndim < 1 or stiffness.shape[-1] != n:
        found = tuple(stiffness.shape)
        raise ConfigurationError("KS303", f"joint stiffness has shape {found}; expected ({n},)", "one for each joint")
    check_batches("J", matrix.shape[:-2], "joint_stiffness", stiffness.shape[:-1])
    given, own = as_array(joint_stiffness)
    if own.name == "numpy" and not np.all(given > 0):
        hint = "N m/rad, or N/m for a sliding joint; np.inf for a rigid one"
        raise ConfigurationError("KS326", f"joint stiffness {given.tolist()} is not positive", hint)
    return matrix, 1 / stiffness, xp


def _bent(J: Any, wrench: Wrench, hessian: Any, matrix: Array, xp: Namespace) -> Array:
    """K_G (..., n, n): how the torques of a load that stays the same change as the arm gives way."""
    if not (isinstance(J, Jacobian) and isinstance(wrench, Wrench) and isinstance(hessian, Hessian)):
        found = f"{type(J).__name__}, {type(wrench).__name__} and {type(hessian).__name__}"
        hint = "J = ks.jacobian(arm, q), hessian=ks.hessian(arm, q), both with the same at= and frame="
        raise ArrayTypeError("KS302", f"a preload takes a Jacobian, a Wrench and a Hessian, not {found}", hint)
    J.require_frame(wrench.frame, "wrench")
    if (hessian.frame, hessian.link) != (J.frame, J.link):
        message = f"the Jacobian of {J.link} ({J.frame}) does not go with the Hessian of {hessian.link} ({hessian.frame})"
        raise FrameMismatchError("KS330", message, "ks.hessian(arm, q, at=..., frame=...) as for the Jacobian")
    six, _ = as_array(wrench.array)
    six = xp.constant(six, matrix) if isinstance(six, np.ndarray) and xp.name != "numpy" else six
    sign = 1 if wrench.acts_on == "robot" else -1
    return sign * (six[..., :, None, None] * hessian.array).sum(-3)


def _require_stable(bent: Array, softness: Array) -> None:
    """Raises ConfigurationError (KS327) where K - K_G has lost its positive directions, with the share of the load."""
    half = np.sqrt(softness)
    share = np.linalg.eigvals(half[..., :, None] * bent * half[..., None, :]).real.max(initial=0.0)
    if share >= 1.0:
        message = f"the arm buckles under this preload: it holds {1.0 / float(share):.3g} of it"
        raise ConfigurationError("KS327", message, "stiffer joints, or a smaller load")
