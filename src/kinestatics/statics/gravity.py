"""Gravity: the torques that hold an arm's own weight, and which way is down for a base that is mounted otherwise."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import definition
from .._kernels import STANDARD_GRAVITY, Chain, chain_arguments
from ..errors import (
    ArrayTypeError,
    ConfigurationError,
    KinestaticsWarning,
    MissingMassError,
    UnknownNameError,
    nearest,
)
from ..frames import BASE
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array, Namespace, as_array
from ..spatial import rpy_to_rotation, transpose

MOUNTINGS: dict[str, tuple[tuple[float, ...], ...]] = {
    "floor": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "ceiling": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
    "wall": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),
}
"""R_world_base of the mountings that have a name, with the world's z axis up: I, Rx(180°), Ry(90°)."""
_ROTATION = 1e-6  # how far a matrix may be from a rotation: printed ones are rounded
_TURN = 2 * np.pi


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
        gravity: (3) acceleration of free fall in base axes [m/s²]; for a mounted base, `gravity_in_base(...)`.
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
    if not by_link and (chain := _compiled(model, gravity)) is not None:
        array, xp = configuration(model, q, check_finite)
        if xp.name == "numpy":
            return chain.gravity_torques(array)
    array, vector, xp = weighted(model, q, gravity, check_finite)
    if by_link:
        return definition.gravity_torques_by_link(model, array, vector, xp)
    if xp.name == "numpy" and not model.has_symbolic_masses:
        return _gravity_chain(model, tuple(float(g) for g in vector)).gravity_torques(array)
    return definition.gravity_torques(model, array, vector, xp)


def weighted(
    model: RobotModel, q: Any, gravity: Sequence[float], check_finite: bool = True
) -> tuple[Array, Array, Namespace]:
    """q and gravity, checked for a question about the weight of the links; q as symbols where gravity has some.

    Raises:
        MissingMassError: KS320. ConfigurationError: KS301, KS303. ArrayTypeError: KS302.
    """
    require_masses(model)
    array, xp = configuration(model, q, check_finite)
    vector = checked_gravity(gravity)
    if vector.dtype == object and xp.name == "numpy":
        _, xp = as_array(vector)
        array = xp.constant(array, vector)
    return array, vector, xp


def require_masses(model: RobotModel) -> None:
    """Raises ArrayTypeError (KS302) for what is no robot, MissingMassError (KS320) for one without masses."""
    require_model(model)
    if not model.has_masses:
        raise missing_masses(model)


def missing_masses(model: RobotModel, hint: str = "") -> MissingMassError:
    """The error for a static question to an arm whose masses are unknown."""
    hint = hint or "its description gives none; a result of zero would be wrong, not light"
    return MissingMassError("KS320", f"robot {model.name!r} has no masses", hint)


def checked_gravity(gravity: Sequence[float]) -> Any:
    """Gravity as an array (3) of numbers or of symbols.

    Raises:
        ConfigurationError: KS303, when it is not three finite numbers.
    """
    hint = "m/s², in base axes: (0, 0, -9.81), or ks.gravity_in_base('wall')"
    try:
        vector, xp = as_array(gravity, "gravity")
    except (ArrayTypeError, ValueError):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 numbers", hint) from None
    if tuple(vector.shape) != (3,) or (xp.name == "numpy" and not np.all(np.isfinite(vector))):
        raise ConfigurationError("KS303", f"gravity {gravity!r} is not 3 finite numbers", hint)
    return vector


def _compiled(model: RobotModel, gravity: Any) -> Chain | None:
    """The chain that an earlier question about this gravity left behind, all its checks passed."""
    chains = getattr(model, "__dict__", {}).get("_gravity_chains")
    if not chains or type(gravity) is not tuple:
        return None
    try:
        return chains.get(gravity)
    except TypeError:  # entries that cannot be looked up, such as arrays
        return None


def _gravity_chain(model: RobotModel, gravity: tuple[float, ...]) -> Chain:
    chains: dict[tuple[float, ...], Chain] = model.__dict__.setdefault("_gravity_chains", {})
    if (chain := chains.get(gravity)) is None:
        if len(chains) >= 16:
            chains.clear()
        chain = chains[gravity] = Chain(
            *chain_arguments(model, model.link(BASE), gravity=(gravity[0], gravity[1], gravity[2]))
        )
    return chain


def gravity_in_base(mounting: Any = "floor", magnitude: float = -STANDARD_GRAVITY[2]) -> Array:
    """Gravity in base axes for a base that is mounted on a floor, a ceiling, a wall, or at any angle.

    Args:
        mounting: how the base stands in a world whose z axis points up:
            "floor": base z up;
            "ceiling": R_world_base = Rx(180°), base z down;
            "wall": R_world_base = Ry(90°), base z horizontal (away from the wall), base x down;
            (roll, pitch, yaw) [rad]: R_world_base = Rz(yaw) Ry(pitch) Rx(roll), as in URDF;
            (3, 3): the rotation matrix R_world_base itself, whose columns are the base axes.
        magnitude: of gravity [m/s²].

    Returns:
        (3) [m/s²], for every `gravity=`.

    Raises:
        UnknownNameError: KS322, a word that names no mounting.
        ConfigurationError: KS303, neither three angles nor a rotation matrix, or a magnitude that is none.

    Warns:
        KinestaticsWarning: KS321, angles of more than a turn: degrees?

    Law: g_base = R_world_baseᵀ (0, 0, -g).

    Example:
        >>> import kinestatics as ks
        >>> ks.gravity_in_base("wall")
        array([9.81, 0.  , 0.  ])
    """
    try:
        size = float(magnitude)
    except (TypeError, ValueError):
        size = np.nan
    if not 0 <= size < np.inf:
        message = f"the magnitude of gravity is {magnitude!r}"
        raise ConfigurationError("KS303", message, "m/s², zero or more; its direction comes from the mounting")
    return -size * _mounted(mounting)[2] + 0.0


def _mounted(mounting: Any) -> Array:
    """R_world_base, (3, 3)."""
    if isinstance(mounting, str):
        if mounting not in MOUNTINGS:
            raise UnknownNameError("KS322", f"mounting {mounting!r} is not known", nearest(mounting, MOUNTINGS))
        return np.array(MOUNTINGS[mounting])
    try:
        array = np.asarray(mounting, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(0, np.nan)
    if array.shape == (3,) and np.all(np.isfinite(array)):
        if np.abs(array).max() > _TURN:
            message = f"KS321: mounting {mounting!r} turns by more than a turn: degrees? Angles are radians"
            warnings.warn(message, KinestaticsWarning, stacklevel=3)
        return rpy_to_rotation(*array.tolist())
    if array.shape == (3, 3) and np.all(np.isfinite(array)):
        if np.abs(array).max() <= 1.0 + _ROTATION:
            across = float(np.abs(transpose(array) @ array - np.eye(3)).max())
            if max(across, abs(float(np.linalg.det(array)) - 1.0)) <= _ROTATION:
                return array
        hint = "R_world_base: its columns are the base axes, at right angles, right-handed"
        raise ConfigurationError("KS303", f"mounting {array.tolist()} is no rotation matrix", hint)
    hint = f"say {', '.join(map(repr, MOUNTINGS))}, (roll, pitch, yaw) in radians, or a rotation matrix R_world_base"
    raise ConfigurationError("KS303", f"mounting {mounting!r} is none", hint)
