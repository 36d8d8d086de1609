"""Twists and wrenches between frames: adjoint, change of frame, power, sums, screws. Floor 6.

`quantities` knows one frame at a time; here both are looked up on a robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar, cast

import numpy as np

from .errors import ArrayTypeError, ConfigurationError, FrameMismatchError
from .frames import Frame
from .kinematics import Locator, configuration, require_model
from .model import RobotModel
from .namespaces import Array, as_array
from .quantities import (
    Acceleration,
    Hessian,
    Jacobian,
    JacobianRate,
    Pose,
    SixVector,
    Twist,
    Wrench,
    check_batches,
    checked_poses,
    gains_terms,
    in_one_library,
    numeric,
    require_one_frame,
    require_one_side,
    rewritten,
    seen_from,
)
from .screws_in_words import PURE, Screw, describe_screw
from .spatial import adjoint_matrix, bracket_matrix as _bracket_matrix, split_pose

Quantity = TypeVar("Quantity", Twist, Wrench, Jacobian)


def adjoint(T: Any) -> Array:
    """The matrix that takes a twist from one frame to another.

    Args:
        T: (..., 4, 4) T_a_b, the pose of frame b seen from frame a [m], or a Pose; NumPy, JAX, PyTorch or SymPy.

    Returns:
        Ad(T_a_b), (..., 6, 6), rows and columns linear first. V_a = Ad(T_a_b) V_b, and F_b = Ad(T_a_b)ᵀ F_a.

    Raises:
        ConfigurationError: KS303 wrong shape, KS335 no rotation and translation.

    Law: Ad(T_a_b) Ad(T_b_c) = Ad(T_a_c); T exp([V]) T⁻¹ = exp([Ad(T) V]). Source: MLS eq. 2.58.

    Example:
        >>> adjoint([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) @ [0, 0, 0, 0, 0, 1]
        array([ 0., -2.,  0.,  0.,  0.,  1.])
    """
    matrix, xp = checked_poses(T.array if isinstance(T, Pose) else T, "T")
    return adjoint_matrix(*split_pose(matrix), xp)


def bracket_matrix(twist: Any) -> Array:
    """The matrix ad of a twist: ad_V W is the rate of change of W carried along by a body that moves with V.

    Args:
        twist: Twist, or bare (..., 6), linear first; NumPy, JAX, PyTorch or SymPy.

    Returns:
        (..., 6, 6): bracket_matrix(V) @ W = [V, W], the Lie bracket of twists.

    Law: d/dt Ad(exp([V] t)) = ad_V Ad(exp([V] t)). Source: MLS section 2.3, page 68, with the sign of ad.

    Example:
        >>> bracket_matrix([0, 0, 0, 0, 0, 1]) @ [1, 0, 0, 0, 0, 0]
        array([0., 1., 0., 0., 0., 0.])
    """
    if isinstance(twist, SixVector) and type(twist) is not Twist:
        raise ArrayTypeError("KS302", f"bracket_matrix takes a Twist, not a {type(twist).__name__}", "Twist or (..., 6)")
    array, xp = as_array(twist.array if isinstance(twist, Twist) else twist, "the twist")
    if array.ndim < 1 or array.shape[-1] != 6:
        raise ConfigurationError("KS303", f"the twist has shape {tuple(array.shape)}; expected (..., 6)", "linear first")
    return _bracket_matrix(array, xp)


def change_frame(model: RobotModel, q: Any, quantity: Quantity, frame: Frame) -> Quantity:
    """A twist, wrench or Jacobian in other axes, at another point of a robot.

    Args:
        model: the robot on which both frames are found; "base", "tip" and every link may be used.
        q: (..., n) its configuration [rad or m], with the batch axes of the quantity.
        quantity: Twist, Wrench or Jacobian (a Jacobian knows its own robot and configuration).
        frame: where to write it.

    Returns:
        The same quantity in `frame`, whose links are named.

    Raises:
        ArrayTypeError: KS302 for anything else; KS334 for an Acceleration, JacobianRate or Hessian, which gain terms.
        UnknownNameError: KS310 for a link that does not exist.

    Law: V_b = Ad(T_ab)⁻¹ V_a, F_b = Ad(T_ab)ᵀ F_a. Source: MLS eq. 2.58 and section 2.5; note 002.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> ks.change_frame(arm, [0, 0], ks.Wrench.on_robot(force=(0, -10, 0)), ks.Frame.spatial()).torque
        array([  0.,   0., -20.])
    """
    require_model(model)
    if isinstance(quantity, Acceleration):
        raise gains_terms("an acceleration", "acceleration(arm, q, qd, qdd")
    if isinstance(quantity, JacobianRate | Hessian):
        kind = isinstance(quantity, Hessian)
        raise gains_terms("a Hessian" if kind else "a rate", "hessian(arm, q" if kind else "jacobian_rate(arm, q, qd")
    if isinstance(quantity, Jacobian):
        own = cast(Locator, quantity._locate).model
        if own is not model:
            message = f"the Jacobian is one of {own.name!r}, not of this model of {model.name!r}"
            raise ConfigurationError("KS333", message, "J.change_frame(frame) knows its own robot and configuration")
        return quantity.change_frame(frame)
    if not isinstance(quantity, Twist | Wrench):
        raise ArrayTypeError(
            "KS302", f"no frame of a {type(quantity).__name__} to change", "give a Twist, Wrench or Jacobian"
        )
    named, R, p, _ = seen_from(Locator(model, configuration(model, q)[0]), quantity.frame, frame)
    return cast(Quantity, rewritten(quantity, named, R, p))


def power(wrench: Wrench, twist: Twist) -> Array:
    """The power that a wrench delivers to a body that moves.

    Args:
        wrench: (..., 6) in the frame of the twist.
        twist: (..., 6) velocity of the body the wrench acts on.

    Returns:
        (...) [W]: f · v + τ · ω. Of a `Wrench.on_environment` at a link that moves with this twist it is what the
        robot gives away, of a `Wrench.on_robot` what the robot takes in.

    Raises:
        FrameMismatchError: KS330, with the remedy.
        ArrayTypeError: KS302 unless it is a Wrench and a Twist (an Acceleration is none).

    Law: the same number in every frame; joint_torques(J, w) · q̇ = power(w, J q̇) for a w on the environment.
    Source: MLS section 2.5; note 002, warm-up.

    Example:
        >>> float(power(Wrench.on_environment(force=(0, 3, 0)), Twist.of(linear=(1, 2, 0))))
        6.0
    """
    if not isinstance(wrench, Wrench) or type(twist) is not Twist:
        found = f"{type(wrench).__name__} and {type(twist).__name__}"
        raise ArrayTypeError("KS302", f"power takes a Wrench and a Twist, not {found}", "ks.power(wrench, J @ qd)")
    require_one_frame(wrench, twist)
    (w, V), _ = in_one_library({"the wrench": wrench.array, "the twist": twist.array})
    check_batches("the wrench", w.shape[:-1], "the twist", V.shape[:-1])
    return (w * V).sum(-1)


def net_wrench(
    wrenches: Sequence[Wrench], frame: Frame | None = None, *, model: RobotModel | None = None, q: Any = None
) -> Wrench:
    """The sum of several wrenches: what all of them do together.

    Args:
        wrenches: one or more, all on the robot or all on the environment; their batch axes go together.
        frame: where to write the sum; default the frame of the first.
        model, q: the robot and its configuration, (..., n), where the frames are found; not needed if all are one.

    Returns:
        Wrench.

    Raises:
        FrameMismatchError: KS333, several frames and no robot.
        ConfigurationError: KS332, some act on the robot and some on the environment; KS303, none given.

    Law: forces add up, and so do moments about one point. Source: note 002, "Can add wrenches"; MLS section 2.5.

    Example:
        >>> push = Wrench.on_environment(force=(0, 0, 1))
        >>> net_wrench([push, push.reaction().reaction()]).force
        array([0., 0., 2.])
    """
    if isinstance(wrenches, Wrench) or not all(isinstance(wrench, Wrench) for wrench in wrenches):
        raise ArrayTypeError("KS302", "net_wrench takes a list of Wrenches", "net_wrench([first, second, ...])")
    several = list(wrenches)
    if not several:
        raise ConfigurationError("KS303", "net_wrench of no wrench: on whom, and in which frame?", "give one or more")
    for other in several[1:]:
        require_one_side(several[0], other)
    target = several[0].frame if frame is None else frame
    if model is not None:
        several = [change_frame(model, q, wrench, target) for wrench in several]
    elif others := [wrench.frame for wrench in several if wrench.frame != target]:
        hint = "net_wrench(wrenches, frame, model=arm, q=q) finds the frames; or rewrite each: wrench.change_frame(frame, T)"
        raise FrameMismatchError("KS333", f"a wrench in {others[0]} is to be added in {target}, and no robot is given", hint)
    total = several[0]
    for other in several[1:]:
        total = total + other
    return total


def screw(six: Twist | Wrench, *, length: float = 1.0, tolerance: float = PURE) -> Screw:
    """The axis, pitch and magnitude of a twist or wrench: every motion is a screw motion, every load a force along a line.

    Args:
        six: Twist or Wrench, (..., 6); numbers of any library (computed with NumPy).
        length: [m] that makes turning and shifting comparable; the size of the mechanism.
        tolerance: a turning (or force) whose share of the whole is smaller counts as none, a pitch below this share of
            `length` as zero. Without it, rounding would send axes to infinity.

    Returns:
        Screw: direction, the point of the axis nearest to the frame's origin, pitch, magnitude, kind; of a single one also
        in words, of a batch arrays. Zeros have kind "rest" or "none", no point, and NaN for a pitch.

    Raises:
        ArrayTypeError: KS302 for symbols and anything but a Twist or Wrench. ConfigurationError: KS301 not finite.

    Law: v = point × ω + pitch ω for a twist, τ = point × f + pitch f for a wrench (theorems of Chasles and Poinsot).
    Source: Ball, "A Treatise on the Theory of Screws" (1900); MLS sections 2.3 and 2.5.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.screw(ks.Twist.of(linear=(0, 2, 0), angular=(0, 0, 2))))
        rotation about z of base, through the origin of tip + (-1, 0, 0) m in axes of
          base, 2 rad/s
    """
    if not isinstance(six, Wrench) and type(six) is not Twist:
        raise ArrayTypeError("KS302", f"screw takes a Twist or a Wrench, not a {type(six).__name__}", "J @ qd is a Twist")
    of = type(six).__name__.lower()
    if not (0 < length < np.inf and 0 <= tolerance < 1):
        raise ConfigurationError("KS303", f"length {length}, tolerance {tolerance}", "metres, positive; a share below 1")
    if as_array(six.array)[1].name == "sympy":
        raise ArrayTypeError("KS302", f"the {of} holds symbols, and its kind depends on numbers", "put numbers in first")
    array = np.asarray(numeric(six.array), dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ConfigurationError("KS301", f"the {of} holds numbers that are not finite", "give finite numbers")
    return describe_screw(array, of, six.frame, length, tolerance)
