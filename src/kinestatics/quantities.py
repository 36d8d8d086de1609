"""Pose, Twist, Wrench, Acceleration, Jacobian: an array and the frame it is written in. Floor 3. No physics.

Every six-vector knows its axes and its point; a mismatch is an error that names both frames and the remedy. The array
may be of any library and have leading batch axes.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from typing import Any, NoReturn, Self

import numpy as np

from .conventions import ANGULAR_FIRST, FLAT_COLUMNS, LINEAR_FIRST, ORDERS, TWO_ARRAYS, find_convention
from .errors import ArrayTypeError, ConfigurationError, FrameMismatchError, UnknownNameError
from .frames import Frame
from .namespaces import Array, Namespace, as_array
from .spatial import (
    ANGULAR,
    LINEAR,
    ROW_NAMES,
    WRENCH_NAMES,
    change_twist_frame,
    rotate,
    rotation_to_rpy,
    split_pose,
    transpose,
)

Locate = Callable[[Frame], tuple[Frame, Array, Array, Namespace]]
"""Frame → the frame with link names, its rotation and origin in base axes, and the array library."""

WIDTH = 80
"""Columns of text that printed results keep to, where the names of links and joints allow it."""
TIED = "\u00a0"
"""A space at which no line is broken; printed as an ordinary one."""

_set = object.__setattr__


class _Frozen:
    """Attributes are set once, in __init__."""

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} is immutable; make a new one instead of setting {name!r}")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} is immutable")

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for cls in type(self).__mro__ for name in getattr(cls, "__slots__", ())}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            _set(self, name, value)


def _check_order(order: str) -> None:
    if order not in ORDERS:
        raise UnknownNameError("KS316", f"order {order!r} is not known", f"say order={LINEAR_FIRST!r} or {ANGULAR_FIRST!r}")


def _reordered(array: Array, order: str, axis: int) -> Array:
    """The array with its six rows in `order`; linear first as it is."""
    _check_order(order)
    if order == LINEAR_FIRST:
        return array
    if isinstance(array, np.ndarray):
        return np.roll(array, 3, axis=axis)
    index: list[Any] = [slice(None)] * array.ndim
    index[axis] = [3, 4, 5, 0, 1, 2]
    return array[tuple(index)]


def _numeric(array: Array) -> Array:
    detached = array.detach() if hasattr(array, "detach") else array
    return np.asarray(detached)


def format_number(x: Any) -> str:
    """Four decimals at most, no minus before a rounded zero; symbols as they are."""
    try:
        value = float(x)
    except (TypeError, ValueError):
        return str(x)
    if value != 0 and (abs(value) < 5e-5 or abs(value) >= 1e6):
        return "0" if abs(value) < 1e-12 else f"{value:.3g}"
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _table(rows: list[list[str]]) -> str:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0])] + [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def wrapped(label: str, text: str, hang: int = 0) -> str:
    """The text behind a label, its further lines indented; names are never broken, nor lines at a tied space."""
    indent = " " * (len(label) + hang)
    filled = textwrap.fill(
        text, WIDTH, initial_indent=label, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return filled.replace(TIED, " ")


def check_batches(first: str, a: Any, second: str, b: Any) -> None:
    """Raises ConfigurationError (KS303) unless two batch shapes go together."""
    try:
        np.broadcast_shapes(tuple(a), tuple(b))
    except ValueError:
        raise ConfigurationError(
            "KS303", f"{first} has batch axes {tuple(a)}, {second} {tuple(b)}", "give both the same, or one of them none"
        ) from None


class Pose(_Frozen):
    """Axes and origin of a link, seen from another: T_base_link, (..., 4, 4) [m].

    Attributes:
        array: (..., 4, 4) homogeneous matrix.
        link: whose frame; seen_from: in whose axes, from whose origin.

    Example:
        >>> import kinestatics as ks
        >>> ks.pose(ks.load("planar_2r"), [0, 0]).translation
        array([2., 0., 0.])
    """

    __slots__ = ("array", "link", "seen_from")
    array: Array
    link: str
    seen_from: str

    def __init__(self, array: Array, link: str, seen_from: str) -> None:
        _set(self, "array", array)
        _set(self, "link", link)
        _set(self, "seen_from", seen_from)

    @property
    def rotation(self) -> Array:
        """(..., 3, 3); its columns are the axes of the link."""
        return split_pose(self.array)[0]

    @property
    def translation(self) -> Array:
        """(..., 3) [m]."""
        return split_pose(self.array)[1]

    @property
    def rpy(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw [rad] of one pose: R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
        if self.array.ndim != 2:
            raise ConfigurationError("KS303", f"rpy of a batch of shape {tuple(self.array.shape)}", "loop over the poses")
        return rotation_to_rpy(_numeric(self.rotation))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(_numeric(self.array), dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<Pose of {self.link} seen from {self.seen_from}, shape {tuple(self.array.shape)}>"

    def __str__(self) -> str:
        if self.array.ndim > 2:
            return repr(self)
        rows = [[""] + [format_number(x) for x in row] for row in _numeric(self.array)[:-1]]
        return f"pose of {self.link} seen from {self.seen_from} [m]\n" + _table(rows)


class _SixVector(_Frozen):
    __slots__ = ("array", "frame")
    array: Array
    frame: Frame
    _names = ROW_NAMES
    _units = ("", "")

    def __init__(self, array: Array, frame: Frame) -> None:
        values, _ = as_array(array, type(self).__name__.lower())
        if values.ndim < 1 or values.shape[-1] != 6:
            raise ConfigurationError("KS303", f"a {type(self).__name__} has shape {tuple(values.shape)}; expected (..., 6)")
        _set(self, "array", values)
        _set(self, "frame", frame)

    def to_array(self, order: str = LINEAR_FIRST) -> Array:
        """The bare array (..., 6), in the row order asked for."""
        return _reordered(self.array, order, -1)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(_numeric(self.array), dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.array.tolist()}, {self.frame}>"

    def __str__(self) -> str:
        if self.array.ndim > 1:
            return f"{type(self).__name__} {tuple(self.array.shape)}, {self.frame}"
        values = ", ".join(f"{name} {format_number(x)}" for name, x in zip(self._names, _numeric(self.array), strict=True))
        return f"{type(self).__name__} ({values}) [{self._units[0]}, {self._units[1]}], {self.frame}"


def _three(value: Any, what: str) -> tuple[Array, Namespace]:
    array, xp = as_array(value, what)
    if array.ndim < 1 or array.shape[-1] != 3:
        raise ConfigurationError("KS303", f"{what} has shape {tuple(array.shape)}; expected (3,) or (..., 3)", "x, y, z")
    return array, xp


def _six(first: Any, second: Any, names: tuple[str, str]) -> Array:
    """The two halves of a six-vector as one array, in the library of the half that is not plain numbers."""
    (a, of_a), (b, of_b) = _three(first, names[0]), _three(second, names[1])
    xp = of_b if of_a.name == "numpy" else of_a
    if of_a.name != xp.name:
        a = xp.constant(a, b)
    if of_b.name != xp.name:
        b = xp.constant(b, a)
    try:
        shape = np.broadcast_shapes(tuple(a.shape), tuple(b.shape))
    except ValueError:
        raise ConfigurationError(
            "KS303", f"{names[0]} has shape {tuple(a.shape)}, {names[1]} {tuple(b.shape)}", "give both the same batch axes"
        ) from None
    return xp.concat([xp.broadcast(a, shape), xp.broadcast(b, shape)], -1)


class Twist(_SixVector):
    """Velocity of a rigid body: (v, ω) [m/s, rad/s], v being the velocity of its point at the frame's origin.

    Example:
        >>> Twist.of(linear=(1, 0, 0)).angular
        array([0., 0., 0.])
    """

    __slots__ = ()
    _units = ("m/s", "rad/s")

    @classmethod
    def of(cls, linear: Any = (0.0, 0.0, 0.0), angular: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """From its two parts, (..., 3) each."""
        return cls(_six(linear, angular, ("linear", "angular")), frame or Frame())

    @classmethod
    def from_array(cls, array: Any, *, order: str, frame: Frame | None = None) -> Self:
        """From six numbers in a stated order, "linear-angular" or "angular-linear"."""
        return cls(_reordered(as_array(array)[0], order, -1), frame or Frame())

    @property
    def linear(self) -> Array:
        """(..., 3) velocity of the body's point at the frame's origin [m/s]."""
        return self.array[..., LINEAR]

    @property
    def angular(self) -> Array:
        """(..., 3) angular velocity [rad/s]."""
        return self.array[..., ANGULAR]


class Acceleration(Twist):
    """d/dt of a twist's components (v̇, ω̇) [m/s², rad/s²]; in base axes at a link, the classical acceleration."""

    __slots__ = ()
    _units = ("m/s²", "rad/s²")


class Wrench(_SixVector):
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
        _set(self, "acts_on", acts_on)

    @classmethod
    def on_environment(cls, force: Any = (0.0, 0.0, 0.0), torque: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """What the robot exerts on its surroundings, (..., 3) each [N, N m]."""
        return cls(_six(force, torque, ("force", "torque")), frame or Frame(), "environment")

    @classmethod
    def on_robot(cls, force: Any = (0.0, 0.0, 0.0), torque: Any = (0.0, 0.0, 0.0), frame: Frame | None = None) -> Self:
        """What a load exerts on the robot, (..., 3) each [N, N m]."""
        return cls(_six(force, torque, ("force", "torque")), frame or Frame(), "robot")

    @property
    def force(self) -> Array:
        """(..., 3) [N]."""
        return self.array[..., LINEAR]

    @property
    def torque(self) -> Array:
        """(..., 3) moment about the frame's origin [N m]."""
        return self.array[..., ANGULAR]


class JacobianMatrix(_Frozen):
    """What Jacobian, JacobianRate and Hessian share: an array with six rows, its frame, link and joint names.

    Attributes:
        array: (..., 6, n) or, for a Hessian, (..., 6, n, n); linear rows first.
        frame: axes and origin it is written in, with link names.
        link: the body whose motion it describes.
        joint_names: (n) names of the columns.
        rows: (6) names of the rows.
    """

    __slots__ = ("_locate", "array", "frame", "joint_names", "link")
    array: Array
    frame: Frame
    link: str
    joint_names: tuple[str, ...]
    _locate: Locate
    rows = ROW_NAMES
    _row_axis = -2

    def __init__(self, array: Array, frame: Frame, link: str, joint_names: tuple[str, ...], locate: Locate) -> None:
        _set(self, "array", array)
        _set(self, "frame", frame)
        _set(self, "link", link)
        _set(self, "joint_names", joint_names)
        _set(self, "_locate", locate)

    def to_array(self, order: str = LINEAR_FIRST) -> Array:
        """The bare array in the row order asked for, "linear-angular" or "angular-linear"."""
        return _reordered(self.array, order, self._row_axis)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return tuple(self.array.shape)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(_numeric(self.array), dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.link}, shape {self.shape}, {self.frame}>"


class Jacobian(JacobianMatrix):
    """J with J q̇ = the twist of a link: an array that knows its frame, point, rows and joint names.

    `np.asarray(J)` is the bare array; `J.linear`, `J.angular` its halves; `print(J)` a labelled table; `J @ qd` a Twist.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> J.linear
        array([[0., 0.],
               [2., 1.],
               [0., 0.]])
        >>> J.change_frame(ks.Frame.spatial()).linear
        array([[ 0.,  0.],
               [ 0., -1.],
               [ 0.,  0.]])
    """

    __slots__ = ()

    @property
    def linear(self) -> Array:
        """(..., 3, n) rows of the velocity of the point at the frame's origin [m/s per unit joint rate]."""
        return self.array[..., LINEAR, :]

    @property
    def angular(self) -> Array:
        """(..., 3, n) rows of the angular velocity [rad/s per unit joint rate]."""
        return self.array[..., ANGULAR, :]

    def change_frame(self, frame: Frame) -> Jacobian:
        """The same Jacobian in other axes, at another point (MLS eq. 3.60 and its relatives).

        Args:
            frame: where to write it; "base", "tip" and every link of the model may be used.
        """
        _, R_old, p_old, xp = self._locate(self.frame)
        named, R_new, p_new, _ = self._locate(frame)
        Rt = transpose(R_old)
        R, p = Rt @ R_new, rotate(Rt, p_new - p_old)
        columns = change_twist_frame(transpose(self.array), R[..., None, :, :], p[..., None, :], xp)
        return Jacobian(transpose(columns), named, self.link, self.joint_names, self._locate)

    def to_array(self, order: str = LINEAR_FIRST, frame: Frame | None = None, convention: str | None = None) -> Array:
        """The bare array as another library or book writes it.

        Args:
            order: "linear-angular" or "angular-linear".
            frame: axes and point, default its own.
            convention: instead of both, a name such as "pinocchio.WORLD", "modern_robotics.body", "drake", "mujoco"
                (`kinestatics.CONVENTIONS` lists all). "base" and "tip" then mean the base and the link described.

        Returns:
            (..., 6, n); "mujoco" gives (2, ..., 3, n), jacp and jacr; "dynibo" (..., 6 n), column after column.

        Example:
            >>> import kinestatics as ks
            >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
            >>> J.to_array(convention="modern_robotics.space")[2]
            array([1., 1.])
        """
        if convention is not None and (frame is not None or order != LINEAR_FIRST):
            message = f"convention {convention!r} already says order and frame"
            raise ConfigurationError("KS319", message, "leave out order= and frame=, or the convention")
        if convention is None:
            written = self if frame is None else self.change_frame(frame)
            return _reordered(written.array, order, -2)
        c = find_convention(convention)
        words = {"base": "base", "tip": self.link}
        written = self.change_frame(Frame(words[c.axes], words[c.origin]))
        array = _reordered(written.array, c.order, -2)
        if c.layout == TWO_ARRAYS:
            return np.stack([_numeric(array)[..., LINEAR, :], _numeric(array)[..., ANGULAR, :]])
        if c.layout == FLAT_COLUMNS:
            flat = transpose(_numeric(array))
            return flat.reshape(*flat.shape[:-2], -1)
        return array

    def same_frame(self, frame: Frame) -> bool:
        """Whether `frame` names the frame this Jacobian is written in ("base" and "tip" are looked up)."""
        return frame == self.frame or self._locate(frame)[0] == self.frame

    def require_frame(self, frame: Frame, what: str) -> None:
        """Raises FrameMismatchError (KS330), naming both frames and the remedy, unless `frame` is this one's."""
        if not self.same_frame(frame):
            raise FrameMismatchError(
                "KS330",
                f"the Jacobian ({self.frame}) and the {what} ({frame}) are written in different frames",
                f"rewrite the Jacobian first: J.change_frame({frame!r})",
            )

    def __matmul__(self, qd: Any) -> Twist:
        """The twist of the link at joint rates qd: (n), or (..., n) with the batch axes of J [rad/s or m/s].

        It is no matrix product: for that, and for one J with many rates, take np.asarray(J) or `twist`.
        """
        if np.ndim(qd) not in (1, self.array.ndim - 1):
            expected, found = (*self.shape[:-2], self.shape[-1]), tuple(np.shape(qd))
            hint = "J.twist(rates) takes a batch of rates; np.asarray(J) @ B is the matrix product"
            raise ConfigurationError("KS303", f"J @ takes joint rates of shape {expected}, got {found}", hint)
        return self.twist(qd)

    def twist(self, qd: Any) -> Twist:
        """The twist of the link at joint rates qd, (..., n) [rad/s or m/s]; one J goes with any batch of rates.

        Example:
            >>> import kinestatics as ks
            >>> ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]).twist([[1, 0], [0, 1]]).linear
            array([[0., 2., 0.],
                   [0., 1., 0.]])
        """
        if isinstance(qd, _Frozen):
            raise ArrayTypeError("KS302", f"joint rates are given as a {type(qd).__name__}", "pass n rates, one a joint")
        rates, xp = as_array(qd, "qd")
        if rates.shape[-1:] != (len(self.joint_names),):
            raise ConfigurationError("KS303", f"qd has shape {tuple(rates.shape)}; expected (..., {len(self.joint_names)})")
        if xp.name == "numpy" and not isinstance(self.array, np.ndarray):
            rates = self._locate(self.frame)[3].constant(rates, self.array)
        check_batches("the Jacobian", self.shape[:-2], "qd", tuple(rates.shape[:-1]))
        return Twist(rotate(self.array, rates), self.frame)

    def __str__(self) -> str:
        """A labelled table of one Jacobian; the shape of a batch."""
        head = f"Jacobian of {self.link}: {self.frame}\nrows: linear [m/s], angular [rad/s], per unit joint rate"
        if self.array.ndim > 2:
            return f"{head}\nbatch of shape {self.shape}"
        rows = [[name, *(format_number(x) for x in row)] for name, row in zip(self.rows, _numeric(self.array), strict=True)]
        named = _table([["", *self.joint_names], *rows])
        if not self.joint_names or len(named.partition("\n")[0]) <= WIDTH:
            return f"{head}\n{named}"
        numbers = [str(k + 1) for k in range(len(self.joint_names))]  # the names would make the table too wide
        names = ", ".join(f"{k}{TIED}{name}" for k, name in zip(numbers, self.joint_names, strict=True))
        return f"{head}\n{_table([['', *numbers], *rows])}\n{wrapped('joints: ', names)}"


class JacobianRate(JacobianMatrix):
    """J̇, the derivative in time of the matrix that `jacobian` returns, (..., 6, n). It is no Jacobian: under a change of
    frame it gains terms, so ask for it in the frame you need."""

    __slots__ = ()


class Hessian(JacobianMatrix):
    """H[..., r, j, k] = ∂J[r, j]/∂q_k of the matrix that `jacobian` returns, (..., 6, n, n)."""

    __slots__ = ()
    _row_axis = -3
