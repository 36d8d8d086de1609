"""Statics: the transpose of the Jacobian. Joint torques, gravity, wrenches held for free, twists lost with them. Floor 6.

Signs: `joint_torques` and `gravity_torques` return what the motors must supply to hold still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import definition
from ._kernels import STANDARD_GRAVITY, Chain, chain_arguments
from .errors import ArrayTypeError, ConfigurationError, MissingMassError
from .frames import BASE
from .kinematics import configuration, require_model
from .model import RobotModel
from .namespaces import Array, as_array
from .quantities import Jacobian, Wrench, check_batches
from .spatial import ANGULAR, rotate, transpose

RANK_TOLERANCE = 1e-10
"""Singular values below this fraction of the largest count as zero (lengths scaled by the characteristic length)."""


def joint_torques(J: Jacobian, wrench: Wrench) -> Array:
    """The joint torques that hold a wrench in equilibrium.

    Args:
        J: Jacobian (..., 6, n) of the link the wrench acts at.
        wrench: (..., 6) in the frame of J; `Wrench.on_environment` or `Wrench.on_robot` decides the sign.

    Returns:
        (..., n) [N m, or N for a prismatic joint]: Jᵀ w for what the robot exerts, -Jᵀ w for a load on the robot.

    Raises:
        FrameMismatchError: KS330, with the remedy.

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
    sign = 1 if wrench.acts_on == "environment" else -1
    (six, of_wrench), (matrix, of_J) = as_array(wrench.array), as_array(J.array, "the Jacobian")
    if of_wrench.name == "numpy" != of_J.name:
        six = of_J.constant(six, matrix)
    elif of_J.name == "numpy" != of_wrench.name:
        matrix = of_wrench.constant(matrix, six)
    check_batches("the Jacobian", matrix.shape[:-2], "the wrench", six.shape[:-1])
    return sign * rotate(transpose(matrix), six)


def gravity_torques(
    model: RobotModel,
    q: Any,
    *,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    by_link: bool = False,
    check_finite: bool = True,
) -> Array:
    """The joint torques that hold the arm still against gravity.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        gravity: (3) acceleration of free fall in base axes [m/s²]; turn it for a mounted base.
        by_link: one row for each link instead of the sum.

    Returns:
        (..., n) or (..., L, n) [N m, or N for a prismatic joint].

    Raises:
        MissingMassError: KS320, when the robot's file gives no masses.
        ConfigurationError: KS303, when gravity is not three finite numbers (or symbols).

    Law: τ = -Σ J_comᵀ m g, the gradient of the potential energy. Source: note 000, "gravity compensation".

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(-0.5, 0, 0)])
        >>> ks.gravity_torques(arm, [0.0], gravity=(0, -9.81, 0))
        array([9.81])
    """
    require_model(model)
    if not model.has_masses:
        raise missing_masses(model)
    array, xp = configuration(model, q, check_finite)
    gravity = checked_gravity(gravity)
    if by_link:
        return definition.gravity_torques_by_link(model, array, gravity, xp)
    if xp.name == "numpy" and model.masses.dtype != object:
        return _gravity_chain(model, tuple(float(g) for g in gravity)).gravity_torques(array)
    return definition.gravity_torques(model, array, gravity, xp)


def missing_masses(model: RobotModel) -> MissingMassError:
    """The error for a static question to an arm whose masses are unknown."""
    hint = "its file gives none; a result of zero would be wrong, not light"
    return MissingMassError("KS320", f"robot {model.name!r} has no masses", hint)


def checked_gravity(gravity: Sequence[float]) -> Any:
    """Gravity as an array (3) of numbers or of symbols.

    Raises:
        ConfigurationError: KS303, when it is not three finite numbers.
    """
    hint = "m/s², in base axes: (0, 0, -9.81)"
    try:
        vector, xp = as_array(gravity, "gravity")
    except (ArrayTypeError, ValueError):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 numbers", hint) from None
    if tuple(vector.shape) != (3,) or (xp.name == "numpy" and not np.all(np.isfinite(vector))):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 finite numbers", hint)
    return vector


def _gravity_chain(model: RobotModel, gravity: tuple[float, ...]) -> Chain:
    chains: dict[tuple[float, ...], Chain] = model.__dict__.setdefault("_gravity_chains", {})
    if gravity not in chains:
        if len(chains) >= 16:
            chains.clear()
        chains[gravity] = Chain(*chain_arguments(model, model.link(BASE), gravity=(gravity[0], gravity[1], gravity[2])))
    return chains[gravity]


@dataclass(frozen=True)
class Decomposition:
    """Rank and the directions beyond it, for chosen rows of one Jacobian.

    Attributes:
        singular_values: (k) of the rows, angular rows multiplied by the characteristic length [m].
        rank: how many of them count; tolerance: the fraction of the largest below which one does not.
        free_wrenches: (f, 6) basis of the wrenches that no joint feels, zero outside the rows [N, N m].
        lost_twists: (f, 6) the directions of motion lost with them [m, rad].
        null_motion: (n - rank, n) basis of the joint motions that do not move the rows.
        characteristic_length: [m].
    """

    singular_values: Array
    rank: int
    tolerance: float
    free_wrenches: Array
    lost_twists: Array
    null_motion: Array
    characteristic_length: float


def decompose(J: Any, rows: Sequence[int], length: float, tolerance: float = RANK_TOLERANCE) -> Decomposition:
    """Rank, free wrenches, lost twists and null motion of chosen rows of a Jacobian.

    Args:
        J: one Jacobian, (6, n).
        rows: rows in play, 0..5.
        length: characteristic length [m]: a twist's size is |(v, length · ω)|.
        tolerance: singular values below this fraction of the largest count as zero.

    Law: free wrenches span null(Jᵀ); lost twists are what is at right angles to all reachable ones, in that size.
    """
    matrix = np.asarray(J, dtype=float)
    if matrix.ndim != 2 or not np.all(np.isfinite(matrix)):
        raise ConfigurationError("KS303", f"expected one finite Jacobian (6, n), got {matrix.shape}", "loop over a batch")
    if not 0 < length < np.inf:
        raise ConfigurationError("KS303", f"characteristic length is {length}", "a positive length in metres")
    weights = np.ones(6)
    weights[ANGULAR] = length
    chosen = list(rows)
    scaled = weights[chosen, None] * matrix[chosen]
    U, sigma, Vt = np.linalg.svd(scaled, full_matrices=True)
    largest = sigma.max(initial=0.0)
    rank = int((sigma > tolerance * largest).sum()) if largest > 0 else 0
    unreachable = np.zeros((len(chosen) - rank, 6))
    unreachable[:, chosen] = _readable(U[:, rank:].T)
    return Decomposition(sigma, rank, tolerance, unreachable * weights, unreachable / weights, Vt[rank:], length)


def _readable(basis: Array) -> Array:
    """Another orthonormal basis of the same space, with coordinate directions first where the space contains them."""
    k, size = basis.shape
    if k < 2:
        return basis if k == 0 else basis * (1.0 if basis[0, int(np.argmax(np.abs(basis[0])))] > 0 else -1.0)
    found: list[Array] = []
    for i in range(size):
        within = basis.T @ basis[:, i]
        if abs(within[i] - 1.0) < 1e-9:
            found.append(np.eye(size)[i])
    if len(found) < k:
        rest = basis - sum((np.outer(basis @ e, e) for e in found), np.zeros_like(basis))
        _, _, Vt = np.linalg.svd(rest)
        found += [v * (1.0 if v[int(np.argmax(np.abs(v)))] > 0 else -1.0) for v in Vt[: k - len(found)]]
    return np.array(found)


def free_wrenches(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the wrenches that the structure holds and no joint feels: null(Jᵀ).

    Args:
        J: one Jacobian (6, n).
        length: characteristic length for the rank decision [m].

    Returns:
        (6 - rank, 6), (f, τ) in the frame of J.

    Law: Jᵀ w = 0. Source: note 000, "wrenches resisted for free".

    Example:
        >>> import kinestatics as ks
        >>> ks.free_wrenches(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    return decompose(J, range(6), length).free_wrenches


def lost_twists(J: Jacobian, length: float = 1.0) -> Array:
    """A basis of the directions of motion at right angles to everything the arm can do: those lost with the free wrenches.

    Args:
        J: one Jacobian (6, n).
        length: characteristic length: the size of a twist is |(v, length · ω)| [m].

    Returns:
        (6 - rank, 6), (v, ω) in the frame of J.

    Example:
        >>> import kinestatics as ks
        >>> ks.lost_twists(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]))[0]
        array([1., 0., 0., 0., 0., 0.])
    """
    return decompose(J, range(6), length).lost_twists
