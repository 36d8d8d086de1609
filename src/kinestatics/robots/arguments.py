"""Arguments of models built in Python: are they numbers, of the right shape, one for each joint? Floor 4."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, RobotDefinitionError
from ..namespaces import Array, as_array
from ..spatial import split_pose, transpose
from .checks import LARGEST, unlimited


def checked_array(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """`value` as a float64 array of that shape, or as an object array where it holds SymPy expressions; -1 fits any length.

    Raises:
        RobotDefinitionError: KS206 wrong shape, KS207 no number, KS208 not finite or too large.
        ArrayTypeError: KS302, for arrays that are no real numbers.
    """
    wanted = f"({', '.join('n' if size < 0 else str(size) for size in shape)})"
    try:
        array, xp = as_array(np.asarray(value), what)
    except ArrayTypeError:
        raise
    except (ValueError, TypeError, OverflowError):
        raise RobotDefinitionError(
            "KS206", f"{what} is not an array of shape {wanted}", "are all rows of one length?"
        ) from None
    if array.ndim != len(shape) or any(size not in (-1, found) for size, found in zip(shape, array.shape, strict=True)):
        raise RobotDefinitionError("KS206", f"{what} has shape {array.shape}; expected {wanted}")
    if xp.name == "sympy" and any(hasattr(x, "free_symbols") for x in array.flat):
        if not all(is_real_symbol(x) if hasattr(x, "free_symbols") else np.isfinite(x) for x in array.flat):
            raise RobotDefinitionError("KS208", f"{what} holds an expression that is not real and finite")
        return array
    return np.array([checked_number(x, what) for x in array.flat], dtype=np.float64).reshape(array.shape)


def is_real_symbol(value: Any) -> bool:
    """Whether a SymPy object is an expression that may be a real number: no nan, infinity, complex number, set or tuple."""
    return bool(
        hasattr(value, "as_numer_denom") and value.is_real is not False and value.is_finite is not False
    ) and not any(atom.is_finite is not True for atom in value.atoms() if atom.is_number)


def is_list(value: Any) -> bool:
    """Whether a value has a length and an order and is no text."""
    return isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes) and getattr(value, "ndim", 1) > 0


def checked_number(value: Any, what: str, infinite: bool = False) -> float:
    """A real number as float, finite unless `infinite` is allowed.

    Raises:
        RobotDefinitionError: KS207 no number, KS208 not finite or too large.
    """
    if isinstance(value, str | bytes) or getattr(value, "shape", ()) != ():
        raise RobotDefinitionError("KS207", f"{what} is {type(value).__name__}, not a number")
    try:
        number = float(value)
    except OverflowError:
        number = np.inf
    except (TypeError, ValueError):
        raise RobotDefinitionError("KS207", f"{what} is {type(value).__name__}, not a number") from None
    if np.isnan(number) or (abs(number) > LARGEST and not infinite):
        raise RobotDefinitionError("KS208", f"{what} is {number:g}", f"give a finite number, at most {LARGEST:g}")
    return number


def unit_direction(vector: Array) -> tuple[Array, float]:
    """The unit vector along a vector of 3 finite numbers, however small or large, and its length; zero stays zero."""
    length = math.hypot(*vector)
    if length in (0.0, 1.0):
        return vector, length
    scaled = vector if 1e-100 < length < 1e100 else vector / np.abs(vector).max()
    return scaled / math.hypot(*scaled), length


def checked_pose(value: Any, what: str) -> Array:
    """A (4, 4) rotation and translation; symbolic ones are taken as they are.

    Raises:
        RobotDefinitionError: KS212.
    """
    try:
        T = checked_array(value, (4, 4), what)
    except RobotDefinitionError as error:
        raise RobotDefinitionError("KS212", error.message, error.hint) from None
    if T.dtype == object:
        return T
    R, _ = split_pose(T)
    residual = max(np.abs(transpose(R) @ R - np.eye(3)).max(), abs(np.linalg.det(R) - 1), np.abs(T[3] - [0, 0, 0, 1]).max())
    if not residual <= 1e-9:
        raise RobotDefinitionError("KS212", f"{what} is not a rotation and a translation: residual {residual:.3g}")
    return T


def checked_list(value: Any, n: int | None, what: str, of: str) -> list[Any]:
    """One entry for each of n rows or screws; any number of them where n is None.

    Raises:
        RobotDefinitionError: KS205.
    """
    if not is_list(value):
        raise RobotDefinitionError("KS205", f"{what} is {type(value).__name__}, not a list", f"give one entry for each {of}")
    if n is not None and len(value) != n:
        raise RobotDefinitionError("KS205", f"{what} has {len(value)} entries for {n} {of}s", f"give one for each {of}")
    return list(value)


def checked_joints(joint_names: Any, limits: Any, n: int, of: str) -> tuple[list[str], list[tuple[float, float]]]:
    """Names, by default joint1, joint2, ..., and limits, by default none, of n joints.

    Raises:
        RobotDefinitionError: KS131 a name twice, KS152 limits reversed, KS155 no position within, KS205, KS207, KS208.
    """
    names = [f"joint{i + 1}" for i in range(n)] if joint_names is None else checked_list(joint_names, n, "joint_names", of)
    for i, name in enumerate(names):
        if not isinstance(name, str):
            raise RobotDefinitionError("KS207", f"joint_names[{i}] is {type(name).__name__}, not a name")
        if name in names[:i]:
            raise RobotDefinitionError("KS131", f"joint {name!r} is named twice", "rename one of them")
    if limits is None:
        return names, [(-np.inf, np.inf)] * n
    bounds = []
    for name, pair in zip(names, checked_list(limits, n, "limits", of), strict=True):
        what = f"limits of {name!r}"
        lower, upper = (checked_number(x, what, infinite=True) for x in checked_list(pair, 2, what, "end"))
        if lower > upper:
            raise RobotDefinitionError("KS152", f"{what}: lower {lower:g} is above upper {upper:g}", "exchange them")
        if lower > LARGEST or upper < -LARGEST:
            raise RobotDefinitionError("KS155", f"{what}: [{lower:g}, {upper:g}] holds no position", "exchange their signs")
        bounds.append(unlimited(lower, upper))
    return names, bounds
