"""Limits of the joints' speeds or efforts, as the robot has them or as they are given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, UnknownNameError, nearest
from ..model import RobotModel
from ..namespaces import Array

Limits = Sequence[float] | Sequence[Sequence[float]] | Mapping[str, Any] | Array | None
"""(n) sizes, the same both ways; a pair (lower, upper) of (n); or {joint: size} or {joint: (lower, upper)} for some."""


class JointLimits(NamedTuple):
    """(n) lower and upper limits, infinite where there is none; which of them were given; "velocity" or "effort"."""

    lower: Array
    upper: Array
    given: Array
    what: str

    def require(self, model: RobotModel, joints: Array) -> None:
        """Raises ConfigurationError (KS366) where one of these joints (n) has no limit."""
        unknown = joints & ~(np.isfinite(self.lower) & np.isfinite(self.upper))
        if np.any(unknown):
            names = ", ".join(repr(name) for name, missing in zip(model.joint_names, unknown, strict=True) if missing)
            raise ConfigurationError(
                "KS366", f"the {self.what} limits of these joints are unknown: {names}", _hint(self.what)
            )

    def of_carrying(self, model: RobotModel, J: Array) -> tuple[Array, Array]:
        """(n) lower and upper limits of the joints that move the link of a Jacobian (..., 6, n); zeros for the others.

        Raises:
            ConfigurationError: KS366 where one of them is unknown.
        """
        carrying = np.any(J != 0, axis=tuple(range(J.ndim - 1)))
        self.require(model, carrying)
        return np.where(carrying, self.lower, 0.0), np.where(carrying, self.upper, 0.0)


def _hint(what: str) -> str:
    units = "rad/s, m/s for a sliding joint" if what == "velocity" else "N m, N for a sliding joint"
    return f"{what}_limits=(...) one for each joint, or {{'joint': limit}} [{units}]"


def joint_limits(model: RobotModel, given: Limits, what: str) -> JointLimits:
    """The limits given, or the robot's own.

    Raises:
        ConfigurationError: KS303. UnknownNameError: KS313.
    """
    own = model.velocity_limits if what == "velocity" else model.effort_limits
    if given is None:
        return JointLimits(-own, np.array(own), np.zeros(model.n, dtype=bool), what)
    if isinstance(given, Mapping):
        lower, upper = named_limits(model, given, own, what)
        mask = np.isin(model.joint_names, list(given))
    else:
        mask = np.ones(model.n, dtype=bool)
        array = _numbers(given)
        lower, upper = (-array, array) if array.ndim == 1 else array if array.shape[:1] == (2,) else (array, array)
    if lower.shape != (model.n,) or not np.all(lower <= upper):  # NaN is refused too
        message = f"{what} limits {given!r} are not {model.n} numbers of zero or more, nor {model.n} lower and upper ones"
        raise ConfigurationError("KS303", message, _hint(what))
    return JointLimits(np.array(lower), np.array(upper), mask, what)


def _numbers(values: Any) -> Array:
    """An array of floats; NaN where there are none."""
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        return np.full(1, np.nan)


def named_limits(model: RobotModel, given: Mapping[str, Any], own: Array, what: str) -> tuple[Array, Array]:
    """(n) lower and upper limits from {joint: size} or {joint: (lower, upper)}; -own and own (n) for joints not named.

    Raises:
        UnknownNameError: KS313. ConfigurationError: KS303 where a value is not one or two numbers.
    """
    lower, upper = -own, np.array(own)
    for name, value in given.items():
        if name not in model.joint_names:
            hint = nearest(str(name), model.joint_names)
            raise UnknownNameError("KS313", f"robot {model.name!r} has no joint {name!r}", hint)
        pair = _numbers(value).reshape(-1)
        if pair.size not in (1, 2):
            raise ConfigurationError(
                "KS303", f"the {what} limit of joint {name!r} is {value!r}", "a number, or (lower, upper)"
            )
        i = model.joint_names.index(name)
        lower[i], upper[i] = (-pair[0], pair[0]) if pair.size == 1 else pair
    return lower, upper
