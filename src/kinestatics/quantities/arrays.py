"""Rows, batches and halves of six-vectors, on bare arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..conventions import ANGULAR_FIRST, LINEAR_FIRST, ORDERS
from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError
from ..namespaces import Array, Namespace, as_array
from ..spatial import pose_residual

_RIGID, _RIGID_SINGLE = 1e-9, 1e-5  # how far a matrix of double, of single precision may miss being a rotation


def check_order(order: str) -> None:
    """Raises UnknownNameError (KS316) unless the order of rows is one of the two."""
    if order not in ORDERS:
        raise UnknownNameError("KS316", f"order {order!r} is not known", f"say order={LINEAR_FIRST!r} or {ANGULAR_FIRST!r}")


def reordered(array: Array, order: str, axis: int) -> Array:
    """The array with its six rows in `order`; linear first as it is."""
    check_order(order)
    if order == LINEAR_FIRST:
        return array
    if isinstance(array, np.ndarray):
        return np.roll(array, 3, axis=axis)
    index: list[Any] = [slice(None)] * array.ndim
    index[axis] = [3, 4, 5, 0, 1, 2]
    return array[tuple(index)]


def numeric(array: Array) -> Array:
    """The array as one of NumPy, without gradients."""
    detached = array.detach() if hasattr(array, "detach") else array
    return np.asarray(detached)


def plain(value: Any) -> Any:
    """Nested lists of numbers for JSON; what is not finite is None, a symbol its text."""
    if isinstance(value, list | tuple):
        return [plain(x) for x in value]
    if isinstance(value, str | bool | int) or value is None:
        return value
    if getattr(value, "ndim", 0) or hasattr(value, "tolist"):
        return plain(numeric(value).tolist())
    try:
        number = float(value)
    except (TypeError, ValueError):
        return str(value)
    return number if np.isfinite(number) else None


def in_one_library(arrays: Mapping[str, Any]) -> tuple[list[Array], Namespace]:
    """Arrays as arrays of one library: NumPy ones go with any other. The names are for errors.

    Raises:
        ArrayTypeError: KS302, when two libraries other than NumPy meet.
    """
    found = [as_array(value, name) for name, value in arrays.items()]
    names = list(arrays)
    foreign = [k for k, (_, xp) in enumerate(found) if xp.name != "numpy"]
    if not foreign:
        return [array for array, _ in found], found[0][1]
    like, xp = found[foreign[0]]
    for k in foreign:
        if found[k][1].name != xp.name:
            message = f"{names[foreign[0]]} is an array of {xp.name}, {names[k]} of {found[k][1].name}"
            raise ArrayTypeError("KS302", message, "pass both of one library")
    return [array if own.name == xp.name else xp.constant(array, like) for array, own in found], xp


def checked_poses(value: Any, what: str) -> tuple[Array, Namespace]:
    """Poses (..., 4, 4); those of NumPy are looked at.

    Raises:
        ConfigurationError: KS303 wrong shape, KS301 not finite, KS335 no rotation and translation.
    """
    T, xp = as_array(value, what)
    if T.ndim < 2 or tuple(T.shape[-2:]) != (4, 4):
        raise ConfigurationError("KS303", f"{what} has shape {tuple(T.shape)}; expected (..., 4, 4)", "a homogeneous matrix")
    if xp.name != "numpy":
        return T, xp
    if not np.all(np.isfinite(T)):
        raise ConfigurationError("KS301", f"{what} holds numbers that are not finite", "give finite numbers")
    if (residual := pose_residual(T)) > (_RIGID if T.dtype == np.float64 else _RIGID_SINGLE):
        message = f"{what} is not a rotation and a translation: residual {residual:.3g}"
        raise ConfigurationError("KS335", message, "rotation with orthonormal columns, determinant 1; last row 0 0 0 1")
    return T, xp


def owned(values: Array, given: Any) -> Array:
    """The values, copied where they share the memory of the array they were given as: it may be changed by its owner."""
    if isinstance(values, np.ndarray):
        return values.copy() if isinstance(given, np.ndarray) and np.may_share_memory(values, given) else values
    return values.clone() if values is given and hasattr(values, "clone") else values


def check_batches(first: str, a: Any, second: str, b: Any) -> None:
    """Raises ConfigurationError (KS303) unless two batch shapes go together."""
    try:
        np.broadcast_shapes(tuple(a), tuple(b))
    except ValueError:
        raise ConfigurationError(
            "KS303", f"{first} has batch axes {tuple(a)}, {second} {tuple(b)}", "give both the same, or one of them none"
        ) from None


def _three(value: Any, what: str) -> None:
    array, _ = as_array(value, what)
    if array.ndim < 1 or array.shape[-1] != 3:
        raise ConfigurationError("KS303", f"{what} has shape {tuple(array.shape)}; expected (3,) or (..., 3)", "x, y, z")


def six_of_halves(first: Any, second: Any, names: tuple[str, str]) -> Array:
    """The two halves of a six-vector as one array, in the library of the half that is not plain numbers."""
    _three(first, names[0])
    _three(second, names[1])
    (a, b), xp = in_one_library({names[0]: first, names[1]: second})
    try:
        shape = np.broadcast_shapes(tuple(a.shape), tuple(b.shape))
    except ValueError:
        raise ConfigurationError(
            "KS303", f"{names[0]} has shape {tuple(a.shape)}, {names[1]} {tuple(b.shape)}", "give both the same batch axes"
        ) from None
    return xp.concat([xp.broadcast(a, shape), xp.broadcast(b, shape)], -1)
