"""Jacobian, JacobianRate, Hessian: six rows with a frame, a link and the names of the joints."""

from __future__ import annotations

from typing import Any, NoReturn, Protocol

import numpy as np

from ..conventions import FLAT_COLUMNS, LINEAR_FIRST, TWO_ARRAYS, find_convention
from ..errors import ArrayTypeError, ConfigurationError, FrameMismatchError
from ..frames import Frame
from ..namespaces import Array, Namespace, as_array
from ..spatial import ANGULAR, LINEAR, ROW_NAMES, change_twist_frame, rotate, transpose
from ..surfaces import surface
from .arrays import check_batches, numeric, reordered
from .frozen import Frozen, set_once
from .printing import WIDTH, format_number, largest, numbered, table, wrapped
from .six_vectors import Twist


class Locate(Protocol):
    """Where frames are: a frame → the same with link names, its rotation and origin in base axes, and the array library."""

    def __call__(self, frame: Frame) -> tuple[Frame, Array, Array, Namespace]: ...

    def named(self, frame: Frame) -> Frame:
        """The frame with link names."""
        ...


def seen_from(locate: Locate, old: Frame, new: Frame) -> tuple[Frame, Array, Array, Namespace]:
    """A frame with link names, its rotation and origin seen from another frame, and the array library."""
    _, R_old, p_old, xp = locate(old)
    named, R_new, p_new, _ = locate(new)
    Rt = transpose(R_old)
    return named, Rt @ R_new, rotate(Rt, p_new - p_old), xp


class JacobianMatrix(Frozen):
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
        set_once(self, "array", array)
        set_once(self, "frame", frame)
        set_once(self, "link", link)
        set_once(self, "joint_names", joint_names)
        set_once(self, "_locate", locate)

    def to_array(self, order: str = LINEAR_FIRST) -> Array:
        """The bare array in the row order asked for, "linear-angular" or "angular-linear"."""
        return reordered(self.array, order, self._row_axis)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return tuple(self.array.shape)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(numeric(self.array), dtype=dtype, copy=copy)

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
        named, R, p, xp = seen_from(self._locate, self.frame, frame)
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
            return reordered(written.array, order, -2)
        c = find_convention(convention)
        words = {"base": "base", "tip": self.link}
        written = self.change_frame(Frame(words[c.axes], words[c.origin]))
        array = reordered(written.array, c.order, -2)
        if c.layout == TWO_ARRAYS:
            return np.stack([numeric(array)[..., LINEAR, :], numeric(array)[..., ANGULAR, :]])
        if c.layout == FLAT_COLUMNS:
            flat = transpose(numeric(array))
            return flat.reshape(*flat.shape[:-2], -1)
        return array

    @property
    def T(self) -> NoReturn:
        """Not here: a bare transpose would drop frame and sign."""
        hint = "ks.joint_torques(J, wrench) is Jᵀ w with its sign; np.asarray(J).T the bare transpose"
        raise AttributeError(f"a Jacobian has no .T; {hint}")

    def same_frame(self, frame: Frame) -> bool:
        """Whether `frame` names the frame this Jacobian is written in ("base" and "tip" are looked up)."""
        return frame == self.frame or self._locate.named(frame) == self.frame

    def require_frame(self, frame: Frame, what: str) -> None:
        """Raises FrameMismatchError (KS330), naming both frames and the remedy, unless `frame` is this one's."""
        if not self.same_frame(frame):
            raise FrameMismatchError(
                "KS330",
                f"the Jacobian ({self.frame}) and the {what} ({frame}) are written in different frames",
                f"say where it is written: frame=J.frame; or rewrite the Jacobian: J.change_frame({frame!r})",
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
        if isinstance(qd, Frozen):
            raise ArrayTypeError("KS302", f"joint rates are given as a {type(qd).__name__}", "pass n rates, one a joint")
        rates, xp = as_array(qd, "qd")
        if rates.shape[-1:] != (len(self.joint_names),):
            raise ConfigurationError("KS303", f"qd has shape {tuple(rates.shape)}; expected (..., {len(self.joint_names)})")
        if xp.name == "numpy" and not isinstance(self.array, np.ndarray):
            rates = self._locate(self.frame)[3].constant(rates, self.array)
        check_batches("the Jacobian", self.shape[:-2], "qd", tuple(rates.shape[:-1]))
        return Twist(rotate(self.array, rates), self.frame)

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        """A labelled table of one Jacobian; the shape of a batch."""
        where = wrapped(f"Jacobian of {self.link}: ", str(self.frame), hang=2 - len(f"Jacobian of {self.link}: "))
        head = f"{where}\nrows: linear [m/s], angular [rad/s], per unit joint rate"
        if self.array.ndim > 2:
            return f"{head}\nbatch of shape {self.shape}"
        array = numeric(self.array)
        most = {name: largest(array[part]) for part in (LINEAR, ANGULAR) for name in self.rows[part]}
        rows = [[name, *(format_number(x, most[name]) for x in row)] for name, row in zip(self.rows, array, strict=True)]
        named = table([["", *self.joint_names], *rows])
        if not self.joint_names or len(named.partition("\n")[0]) <= WIDTH:
            return f"{head}\n{named}"
        numbers = [str(k + 1) for k in range(len(self.joint_names))]  # the names would make the table too wide
        return f"{head}\n{table([['', *numbers], *rows])}\n{numbered('joints', self.joint_names)}"


class JacobianRate(JacobianMatrix):
    """J̇, the derivative in time of the matrix that `jacobian` returns, (..., 6, n). It is no Jacobian: under a change of
    frame it gains terms, so ask for it in the frame you need."""

    __slots__ = ()


class Hessian(JacobianMatrix):
    """H[..., r, j, k] = ∂J[r, j]/∂q_k of the matrix that `jacobian` returns, (..., 6, n, n)."""

    __slots__ = ()
    _row_axis = -3
