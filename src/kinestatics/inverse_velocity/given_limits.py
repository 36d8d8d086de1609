"""Limits of joint rates in every form they may be given in, as RateLimits that go with a Jacobian."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, as_array
from ..quantities import Jacobian, check_batches
from ..statics.limits import named_limits
from ..tasks import model_of
from .limits import RateLimits
from .problem import Problem

_FORMS = "RateLimits.of(arm, q, dt=...), n sizes for both ways, a pair (lower, upper), or {'joint': size or (lower, upper)}"


def read_limits(limits: Any, problem: Problem, batch: tuple[int, ...], J: Any) -> RateLimits:
    """RateLimits as they are, or from sizes, a pair or names; those of a robot go with its own Jacobian.

    Raises:
        ArrayTypeError: KS302. ConfigurationError: KS301, KS303; KS354 where nothing is left between two bounds.
        UnknownNameError: KS313.
    """
    if problem.xp.name != "numpy":
        raise ArrayTypeError("KS302", f"limits are kept on NumPy, not on {problem.xp.name}", "convert the Jacobian first")
    if not isinstance(limits, RateLimits):
        limits = _read(limits, J, problem.n)
    if limits.lower.shape[-1] != problem.n:
        hint = "one for each joint"
        raise ConfigurationError("KS303", f"the limits are for {limits.lower.shape[-1]} joints, not {problem.n}", hint)
    if isinstance(J, Jacobian) and limits.of_robot and limits.joint_names != J.joint_names:
        message = f"the limits are for joints {', '.join(limits.joint_names)}, the Jacobian for {', '.join(J.joint_names)}"
        raise ConfigurationError("KS303", message, "RateLimits.of the robot of the Jacobian")
    check_batches("the problem", batch, "the limits", limits.lower.shape[:-1])
    return limits


def _read(given: Any, J: Any, n: int) -> RateLimits:
    if isinstance(given, Mapping):
        if not isinstance(J, Jacobian):
            hint = "pass the Jacobian itself, or n sizes, or a pair (lower, upper)"
            raise ArrayTypeError("KS302", "limits by name were given with a bare array, whose joints have no names", hint)
        lower, upper = named_limits(model_of(J), given, np.full(n, np.inf), "velocity")
        return _ordered(lower, upper, J.joint_names, [given.get(name) for name in J.joint_names])
    if _is_pair(given):
        return RateLimits(*given)
    sizes, xp = as_array(given, "limits")
    if sizes.ndim != 1 or xp.name != "numpy":
        found = f"a {type(given).__name__}" + (f" of shape {tuple(sizes.shape)}" if sizes.ndim else "")
        raise ArrayTypeError("KS302", f"limits are {found}", _FORMS)
    named = isinstance(J, Jacobian) and sizes.size == n
    names = J.joint_names if named else tuple(f"q{k + 1}" for k in range(sizes.size))
    return _ordered(-sizes, sizes, names, sizes)


def _is_pair(given: Any) -> bool:
    """Whether two bounds are given, each of several numbers; two numbers are the sizes of two joints."""
    listed = isinstance(given, tuple | list) or (isinstance(given, np.ndarray) and given.ndim > 1)
    return listed and len(given) == 2 and np.ndim(given[0]) > 0


def _ordered(lower: Array, upper: Array, names: tuple[str, ...], given: Any) -> RateLimits:
    """RateLimits; an error (KS354) in the words of what was given where a lower bound is above an upper one."""
    for k in np.flatnonzero(lower > upper)[:1]:
        hint = "a size, zero or more, for both ways, or a lower and a higher bound"
        raise ConfigurationError("KS354", f"the limit of joint {names[k]!r} is {given[k]}", hint)
    return RateLimits(lower, upper, names)
