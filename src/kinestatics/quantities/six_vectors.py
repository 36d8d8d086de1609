"""Twist, Acceleration, Wrench: six numbers, the frame they are written in and, for a wrench, who acts on whom.

Two of one kind in one frame add up, and scale; what does not go together is an error that says why. With a bare array a
six-vector is an array too, as in np.asarray.
"""

from __future__ import annotations

import numbers
from typing import Any, Final, NoReturn, Self

import numpy as np

from ..conventions import LINEAR_FIRST
from ..errors import ArrayTypeError, ConfigurationError, FrameMismatchError, UnknownNameError
from ..frames import BASE, TIP, Frame
from ..namespaces import Array, as_array
from ..spatial import (
    ANGULAR,
    LINEAR,
    ROW_NAMES,
    WRENCH_NAMES,
    change_twist_frame,
    change_wrench_frame,
    split_pose,
)
from ..surfaces import surface
from .arrays import check_batches, checked_poses, in_one_library, numeric, owned, plain, reordered, six_of_halves
from .frozen import Frozen, set_once
from .poses import Pose
from .printing import TIED, WIDTH, format_number, wrapped

ONE_FRAME: Final = (
    "rewrite one: ks.change_frame(arm, q, it, frame) looks both frames up, 'base' and 'tip' too; "
    "it.change_frame(frame, T) does without a robot; frame=J.frame says the one of a Jacobian and of what it gives"
)
"""The remedy where two six-vectors are written in different frames."""


class SixVector(Frozen):
    """What Twist, Acceleration and Wrench share.

    Attributes:
        array: (..., 6), linear first.
        frame: whose axes, at whose origin.
    """

    __slots__ = ("array", "frame")
    __array_priority__ = -1.0  # above NumPy's scalars, so that np.float64(2) * wrench is a wrench; below its arrays
    array: Array
    frame: Frame
    _names = ROW_NAMES
    _units = ("", "")

    def __init__(self, array: Array, frame: Frame) -> None:
        values, _ = as_array(array, type(self).__name__.lower())
        if values.ndim < 1 or values.shape[-1] != 6:
            raise ConfigurationError("KS303", f"a {type(self).__name__} has shape {tuple(values.shape)}; expected (..., 6)")
        if not isinstance(frame, Frame):
            hint = "ks.Frame.body('tip'), ks.Frame.spatial(), or ks.Frame(axes, origin)"
            raise ArrayTypeError("KS302", f"the frame of a {type(self).__name__} is a {type(frame).__name__}", hint)
        set_once(self, "array", owned(values, array))
        set_once(self, "frame", frame)

    def with_array(self, array: Array, frame: Frame | None = None) -> Self:
        """The same kind of quantity with other numbers, (..., 6), and where given in another frame."""
        return type(self)(array, self.frame if frame is None else frame)

    def to_array(self, order: str = LINEAR_FIRST) -> Array:
        """The bare array (..., 6), in the row order asked for."""
        return reordered(self.array, order, -1)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists and text, for JSON."""
        return {"linear": plain(self.array[..., LINEAR]), "angular": plain(self.array[..., ANGULAR]), **self.frame.to_dict()}

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(numeric(self.array), dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.array.tolist()}, {self.frame}>"

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        name, where = f"{type(self).__name__} ", str(self.frame)
        if self.array.ndim > 1:
            return wrapped("", f"{name}{tuple(self.array.shape)}, {where}", hang=len(name))
        cells = [f"{row}{TIED}{format_number(x)}" for row, x in zip(self._names, numeric(self.array), strict=True)]
        text = f"({', '.join(cells)}) [{self._units[0]}, {self._units[1]}],"
        line = f"{name}{text} {where}".replace(TIED, " ")
        return line if len(line) <= WIDTH else f"{wrapped(name, text)}\n{wrapped(' ' * len(name), where)}"

    def __neg__(self) -> Self:
        return self.with_array(-self.array)

    def __add__(self, other: Any) -> Self:
        if isinstance(other, SixVector):
            a, b = _alike(self, other)
            return self.with_array(a + b)
        return self if isinstance(other, int) and other == 0 else NotImplemented  # sum() begins with 0

    __radd__ = __add__

    def __sub__(self, other: Any) -> Self:
        if not isinstance(other, SixVector):
            return NotImplemented
        a, b = _alike(self, other)
        return self.with_array(a - b)

    def __mul__(self, factor: Any) -> Self:
        if not _is_scalar(factor):
            return NotImplemented
        if isinstance(factor, int | float):
            return self.with_array(factor * self.array)
        (a, array), _ = in_one_library({"the factor": factor, type(self).__name__: self.array})
        return self.with_array(a * array)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Any) -> Self:
        if not _is_scalar(divisor):
            return NotImplemented
        if isinstance(divisor, numbers.Number | np.generic | np.ndarray) and divisor == 0:
            raise ConfigurationError("KS303", f"a {type(self).__name__} is divided by 0", "divide by a number other than 0")
        if isinstance(divisor, int | float):
            return self.with_array(self.array / divisor)
        (array, a), _ = in_one_library({type(self).__name__: self.array, "the divisor": divisor})
        return self.with_array(array / a)


def _is_scalar(value: Any) -> bool:
    """One number or symbol, of any library; not a quantity, a list or an array."""
    return not isinstance(value, Frozen | list | tuple) and np.ndim(value) == 0


def require_one_frame(first: SixVector, second: SixVector) -> None:
    """Raises FrameMismatchError (KS330), naming both frames and the remedy, unless both are written in one frame."""
    if first.frame != second.frame:
        a, b = type(first).__name__.lower(), type(second).__name__.lower()
        message = f"one {a} is written in {first.frame}, the other in {second.frame}"
        if a != b:
            message = f"the {a} ({first.frame}) and the {b} ({second.frame}) are written in different frames"
        raise FrameMismatchError("KS330", message, ONE_FRAME)


def require_one_side(first: Wrench, second: Wrench) -> None:
    """Raises ConfigurationError (KS332) where one wrench acts on the robot and the other on the environment."""
    if first.acts_on != second.acts_on:
        message = f"one wrench acts on the {first.acts_on}, the other on the {second.acts_on}"
        raise ConfigurationError("KS332", message, "take one of them from the other side: wrench.reaction()")


def _alike(first: SixVector, second: SixVector) -> tuple[Array, Array]:
    """The arrays of two quantities of one kind, in one frame and of one library."""
    a, b = type(first).__name__, type(second).__name__
    if type(first) is not type(second):
        raise ArrayTypeError("KS302", f"{a} and {b} do not add up", "combine two of one kind; ks.power multiplies two kinds")
    require_one_frame(first, second)
    if isinstance(first, Wrench) and isinstance(second, Wrench):
        require_one_side(first, second)
    (x, y), _ = in_one_library({f"the first {a.lower()}": first.array, f"the second {a.lower()}": second.array})
    check_batches(f"the first {a.lower()}", x.shape[:-1], "the second", y.shape[:-1])
    return x, y


def gains_terms(what: str, call: str) -> ArrayTypeError:
    """The error (KS334) for a derivative in time that was to be rewritten in a frame which may move."""
    return ArrayTypeError("KS334", f"{what} gains terms in a frame that moves", f"ask for it there: ks.{call}, frame=...)")


def rewritten(quantity: SixVector, frame: Frame, R: Array, p: Array) -> SixVector:
    """A twist or wrench in another frame, whose pose seen from the present one is (R, p).

    Raises:
        ArrayTypeError: KS334 for an acceleration.
    """
    if isinstance(quantity, Acceleration):
        raise gains_terms("an acceleration", "acceleration(arm, q, qd, qdd")
    change = change_wrench_frame if isinstance(quantity, Wrench) else change_twist_frame
    (six, rotation, point), xp = in_one_library(
        {type(quantity).__name__: quantity.array, "the rotation": R, "the origin": p}
    )
    check_batches(f"the {type(quantity).__name__.lower()}", six.shape[:-1], "the pose", point.shape[:-1])
    return quantity.with_array(change(six, rotation, point, xp), frame)


def _placed(quantity: Twist | Wrench, frame: Frame, T: Any) -> Any:
    """`change_frame` of both kinds: T is looked at, and a Pose must belong to the two frames."""
    if not isinstance(frame, Frame):
        raise ArrayTypeError("KS302", f"frame is a {type(frame).__name__}; expected a Frame", "ks.Frame(axes, origin)")
    if isinstance(T, Pose):
        _check_pose(quantity.frame, T.seen_from, any(quantity.frame.offset))
        _check_pose(frame, T.link, False)
        T = T.array
    matrix, _ = checked_poses(T, "T")
    return rewritten(quantity, frame, *split_pose(matrix))


def _check_pose(frame: Frame, link: str, displaced: bool) -> None:
    """A Pose tells where one link is; a frame of two links, of another link, or beside it, is not meant by it."""
    words = (link, BASE, TIP)
    if frame.axes == frame.origin and frame.axes in words and not displaced:
        return
    raise FrameMismatchError(
        "KS330",
        f"the Pose has to do with axes and origin of {link}; the frame is {frame}",
        "pass the matrix (4, 4) of the new frame seen from the present one, or ks.change_frame(arm, q, it, frame)",
    )


class Twist(SixVector):
    """Velocity of a rigid body: (v, ω) [m/s, rad/s], v being the velocity of its point at the frame's origin.

    Example:
        >>> Twist.of(linear=(1, 0, 0)).angular
        array([0., 0., 0.])
        >>> print(Twist.of(linear=(1, 0, 0)) + 2 * Twist.of(angular=(0, 0, 1)))
        Twist (vx 1, vy 0, vz 0, wx 0, wy 0, wz 2) [m/s, rad/s],
              axes of base, at the origin of tip
    """

    __slots__ = ()
    _units = ("m/s", "rad/s")

    @classmethod
    def of(cls, linear: Any = (0.0, 0.0, 0.0), angular: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """From its two parts, (..., 3) each."""
        return cls(six_of_halves(linear, angular, ("linear", "angular")), frame or Frame())

    @classmethod
    def from_array(cls, array: Any, *, order: str, frame: Frame | None = None) -> Self:
        """From six numbers in a stated order, "linear-angular" or "angular-linear"."""
        return cls(reordered(as_array(array)[0], order, -1), frame or Frame())

    @property
    def linear(self) -> Array:
        """(..., 3) velocity of the body's point at the frame's origin [m/s]."""
        return self.array[..., LINEAR]

    @property
    def angular(self) -> Array:
        """(..., 3) angular velocity [rad/s]."""
        return self.array[..., ANGULAR]

    def change_frame(self, frame: Frame, T: Any) -> Self:
        """The same motion in other axes, at another point, without a robot.

        Args:
            frame: the name of the new frame; nothing is looked up (`ks.change_frame` does that).
            T: (..., 4, 4) pose of the new frame seen from the present one [m], or a Pose.

        Raises:
            ConfigurationError: KS335, T is no rotation and translation.
            FrameMismatchError: KS330, a Pose of other links than the two frames'.

        Law: V_b = Ad(T_ab)⁻¹ V_a. Source: MLS eq. 2.58.

        Example:
            >>> turning = Twist.of(angular=(0, 0, 1), frame=Frame.body("a"))
            >>> turning.change_frame(Frame.body("b"), [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).linear
            array([0., 2., 0.])
        """
        return _placed(self, frame, T)


class Acceleration(Twist):
    """d/dt of a twist's components (v̇, ω̇) [m/s², rad/s²]; in base axes at a link, the classical acceleration."""

    __slots__ = ()
    _units = ("m/s²", "rad/s²")

    def change_frame(self, frame: Frame, T: Any) -> NoReturn:  # noqa: ARG002
        """Refused (KS334): in a frame that moves an acceleration gains terms; ask `acceleration(..., frame=)` for it."""
        raise gains_terms("an acceleration", "acceleration(arm, q, qd, qdd")


class Wrench(SixVector):
    """Force and moment (f, τ) [N, N m], τ about the frame's origin, and who acts on whom.

    Made by `Wrench.on_environment` (the robot pushes on its surroundings) or `Wrench.on_robot` (a load acts on the
    robot): the sign of joint torques depends on it, and nothing else does.

    Example:
        >>> Wrench.on_environment(force=(0, 2, 2)).force
        array([0., 2., 2.])
    """

    __slots__ = ("acts_on",)
    acts_on: str
    _names = WRENCH_NAMES
    _units = ("N", "N m")

    def __init__(self, array: Array, frame: Frame, acts_on: str) -> None:
        super().__init__(array, frame)
        if acts_on not in ("robot", "environment"):
            raise UnknownNameError(
                "KS317", f"acts_on={acts_on!r} is not known", "use Wrench.on_robot or Wrench.on_environment"
            )
        set_once(self, "acts_on", acts_on)

    @classmethod
    def on_environment(cls, force: Any = (0.0, 0.0, 0.0), torque: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """What the robot exerts on its surroundings, (..., 3) each [N, N m]."""
        return cls(six_of_halves(force, torque, ("force", "torque")), frame or Frame(), "environment")

    @classmethod
    def on_robot(cls, force: Any = (0.0, 0.0, 0.0), torque: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """What a load exerts on the robot, (..., 3) each [N, N m]."""
        return cls(six_of_halves(force, torque, ("force", "torque")), frame or Frame(), "robot")

    def with_array(self, array: Array, frame: Frame | None = None) -> Self:
        """The same kind of wrench with other numbers, (..., 6), and where given in another frame."""
        return type(self)(array, self.frame if frame is None else frame, self.acts_on)

    @property
    def force(self) -> Array:
        """(..., 3) [N]."""
        return self.array[..., LINEAR]

    @property
    def torque(self) -> Array:
        """(..., 3) moment about the frame's origin [N m]."""
        return self.array[..., ANGULAR]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists and text, for JSON."""
        return {"force": plain(self.force), "torque": plain(self.torque), "acts_on": self.acts_on, **self.frame.to_dict()}

    def reaction(self) -> Self:
        """The same contact seen from the other side: opposite numbers, acting on the other body (Newton's third law).

        Example:
            >>> load = Wrench.on_environment(force=(0, 0, 5)).reaction()
            >>> load.force, load.acts_on
            (array([ 0.,  0., -5.]), 'robot')
        """
        other = "environment" if self.acts_on == "robot" else "robot"
        return type(self)(0 - self.array, self.frame, other)  # 0 - x has no minus before a zero

    def change_frame(self, frame: Frame, T: Any) -> Self:
        """The same force and moment in other axes, the moment about another point, without a robot.

        Args:
            frame: the name of the new frame; nothing is looked up (`ks.change_frame` does that).
            T: (..., 4, 4) pose of the new frame seen from the present one [m], or a Pose.

        Raises:
            ConfigurationError: KS335, T is no rotation and translation.
            FrameMismatchError: KS330, a Pose of other links than the two frames'.

        Law: F_c = Ad(T_bc)ᵀ F_b, so that power is the same. Source: note 002, "Wrenches (cont'd)"; MLS section 2.5.

        Example:
            >>> push = Wrench.on_environment(force=(1, 0, 0), torque=(0, 0, 1), frame=Frame.body("b"))
            >>> push.change_frame(Frame.body("c"), [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]).array
            array([ 0., -1.,  0., -3.,  0.,  3.])
        """
        return _placed(self, frame, T)
