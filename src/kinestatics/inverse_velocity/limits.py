"""RateLimits: how fast each joint may move now, from its velocity, position and acceleration limits.

One law for everything here, per joint, with the distance D to a position limit [rad or m], the period dt and the greatest
acceleration a:

    towards a limit   q̇ <= D / dt                 so that one period ends before it, or
                      q̇ <= √(2 a D) - a dt / 2    with a known: so that braking with a ends before it (0 where negative)
    velocity          |q̇| <= v_max
    acceleration      |q̇ - q̇_previous| <= a dt

The second bound keeps itself: whoever obeys it now can obey it in the next period by slowing down by a dt. With
x = q̇/(a dt) and y = D/(a dt²) it says (x + 1/2)² <= 2y; one period later x' = x - 1 and y' = y - x, and (x' + 1/2)² <= 2y'
is the same statement. It is never above D/dt, since y - √(2y) + 1/2 is a square. A joint closer than a dt²/8 stands.

Where limits contradict one another the weaker gives way, and `gives_way` says so: acceleration holds before velocity (a
drive cannot do more), velocity before position.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError, nearest
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..quantities import format_number, named_table, plain
from .problem import checked_positive

_ROUNDING = 1e-7  # of rates: one digit of q is worth that much in √(2 a D) close to a limit
SOURCES = ("no limit", "velocity", "position", "acceleration")
"""What a bound comes from; RateLimits.lower_from and upper_from count these."""


def approach_rate(distance: Array, dt: float | None, acceleration: Array | None) -> Array:
    """The greatest rate towards a position limit `distance` away; 0 at the limit and beyond."""
    ahead = np.maximum(distance, 0.0)
    if dt is None:
        return np.where(ahead > 0.0, np.inf, 0.0)
    if acceleration is None:
        return ahead / dt
    return np.maximum(np.sqrt(2.0 * acceleration * ahead) - 0.5 * dt * acceleration, 0.0)


@dataclass(frozen=True, eq=False)
class RateLimits:
    """Bounds of the joint rates: lower <= q̇ <= upper. `RateLimits.of` makes them for a robot.

    Attributes:
        lower, upper: (..., n) [rad/s or m/s], infinite where there is none.
        joint_names: (n), for people to read.
        lower_from, upper_from: (..., n) which of "no limit", "velocity", "position", "acceleration" a bound comes from,
            counted from 0.
        outside: (..., n) joints beyond a position limit: they may not go further out.
        gives_way: (..., n) joints of which a weaker limit cannot be kept in this period.

    Raises:
        ConfigurationError: KS303 shapes, KS301 NaN, KS354 where a lower bound is above an upper one.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.RateLimits([-1.0, -2.0], [1.0, 0.5]))
        joint rates [rad/s or m/s]
            lower  upper
        q1     -1      1
        q2     -2    0.5
    """

    lower: Array
    upper: Array
    joint_names: tuple[str, ...] = ()
    lower_from: Array = None
    upper_from: Array = None
    outside: Array = None
    gives_way: Array = None

    def __post_init__(self) -> None:
        lower, upper = _bound(self.lower, "lower"), _bound(self.upper, "upper")
        if lower.shape != upper.shape:
            raise ConfigurationError("KS303", f"lower has shape {lower.shape}, upper {upper.shape}", "one bound a joint")
        names = self.joint_names or tuple(f"q{k + 1}" for k in range(lower.shape[-1]))
        if np.any(lower > upper):
            where = tuple(int(i) for i in np.argwhere(lower > upper)[0])
            message = f"the bounds of joint {names[where[-1]]!r} exclude each other: {lower[where]:g} > {upper[where]:g}"
            raise ConfigurationError("KS354", message, "RateLimits.of(model, q) finds which limit gives way")
        nothing = np.zeros(lower.shape, dtype=int)
        values: dict[str, Any] = {"lower": lower, "upper": upper}
        for name, bound in (("lower_from", lower), ("upper_from", upper)):
            values[name] = _own(getattr(self, name), np.where(np.isfinite(bound), 1, nothing))
        for name in ("outside", "gives_way"):
            values[name] = _own(getattr(self, name), nothing.astype(bool))
        for name, value in values.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "joint_names", names)

    @classmethod
    def of(
        cls,
        model: RobotModel,
        q: Any,
        *,
        dt: float | None = None,
        previous: Any = None,
        acceleration: Any = None,
        margin: Any = 0.0,
        recovery: float = 0.0,
    ) -> RateLimits:
        """The bounds of a robot at a configuration: velocity, position over the next period, acceleration.

        Args:
            model: the robot; its lower, upper and velocity_limits, infinite where unknown.
            q: (..., n) [rad or m].
            dt: period [s] for which the rates will be held. Without it position limits are felt only where they are
                reached: a joint at or beyond one does not go further.
            previous: (..., n) rates of the period before [rad/s or m/s]; needed to limit the acceleration.
            acceleration: (n) or a number: the greatest |q̈| [rad/s² or m/s²]; without it any change of rate is allowed.
                Without `previous` it only makes joints slow down in time before a position limit.
            margin: (n) or a number: distance kept from the position limits [rad or m].
            recovery: a joint beyond a position limit must move back at `recovery` times its distance from it [1/s];
                0: it must not go further.

        Raises:
            ConfigurationError: KS301, KS303 for q or previous; KS353, KS354 for the others.
            ArrayTypeError: KS302, for other libraries and symbols.

        Law: the head of this module: braking distance v²/2a in sampled time. Source: derived and proved there.

        Example:
            >>> import kinestatics as ks
            >>> limits = ks.RateLimits.of(ks.load("panda"), [0, 0, 0, -0.08, 0, 1, 0], dt=0.01)
            >>> limits.why(3, "upper")
            'position'
        """
        array = _numbers(model, q, "q")
        period = None if dt is None else checked_positive(dt, "dt", "the period in seconds")
        most = None if acceleration is None else per_joint(model, acceleration, "acceleration", positive=True)
        if period is None and (most is not None or previous is not None):
            hint = "dt=, the period in seconds for which the rates are held"
            raise ConfigurationError("KS354", "limits of the acceleration need the period", hint)
        if most is None and previous is not None:
            hint = "acceleration=, in rad/s² or m/s²"
            raise ConfigurationError("KS354", "previous= was given without acceleration=", hint)
        position = _position_bounds(array, position_range(model, margin), period, most, recovery)
        fastest = np.broadcast_to(model.velocity_limits, array.shape)
        bounds = [np.clip(bound, -fastest, fastest) for bound in position[:2]]
        sources = [np.where(a == b, 2, 1) for a, b in zip(bounds, position, strict=False)]
        if previous is not None and most is not None and period is not None:
            held, step = _numbers(model, previous, "previous"), most * period
            slowed = [np.clip(bound, held - step, held + step) for bound in bounds]
            sources = [np.where(a == b, s, 3) for a, b, s in zip(slowed, bounds, sources, strict=True)]
            bounds = slowed
        lower, upper = np.broadcast_arrays(*bounds)
        slack = _ROUNDING * (1.0 + np.where(np.isfinite(upper - lower), np.abs(upper) + np.abs(lower), 0.0))
        weaker = np.maximum(position[0], -fastest), np.minimum(position[1], fastest)
        gives_way = (lower < weaker[0] - slack) | (upper > weaker[1] + slack)
        sources = [np.where(np.isfinite(b), s, 0) for b, s in zip((lower, upper), sources, strict=True)]
        outside = np.broadcast_to(position[2], lower.shape)
        return cls(lower, upper, model.joint_names, sources[0], sources[1], outside, gives_way)

    @property
    def of_robot(self) -> bool:
        """Whether the joints have names of their own, and not q1, q2, ..."""
        return self.joint_names != tuple(f"q{k + 1}" for k in range(self.lower.shape[-1]))

    def why(self, joint: int | str, side: str) -> str:
        """Where the "lower" or "upper" bound of a joint comes from: "velocity", "position", "acceleration", "no limit".

        Args:
            joint: its name, or its place from 0; side: "lower" or "upper".
        """
        if isinstance(joint, str):
            if joint not in self.joint_names:
                raise UnknownNameError("KS313", f"there is no joint {joint!r}", nearest(joint, self.joint_names))
            joint = self.joint_names.index(joint)
        if side not in ("lower", "upper") or not 0 <= joint < len(self.joint_names):
            message = f"there is no {side!r} bound of joint {joint}"
            raise ConfigurationError("KS303", message, f"'lower' or 'upper'; joints 0 to {len(self.joint_names) - 1}")
        source = self.lower_from if side == "lower" else self.upper_from
        if source.ndim != 1:
            raise ConfigurationError("KS303", f"a batch of bounds of shape {source.shape}", "SOURCES by upper_from[i]")
        return SOURCES[int(source[joint])]

    def contains(self, rates: Any, slack: float = 0.0) -> Array:
        """(...) whether rates (..., n) are inside, but for `slack` [rad/s or m/s]."""
        array = np.asarray(rates)
        if array.shape[-1:] != self.lower.shape[-1:]:
            n = self.lower.shape[-1]
            raise ConfigurationError("KS303", f"rates have shape {array.shape}; expected (..., {n})", "one for each joint")
        return np.all((array >= self.lower - slack) & (array <= self.upper + slack), axis=-1)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; an infinite bound is None."""
        bounds = {name: plain(getattr(self, name)) for name in ("lower", "upper")}
        sources = {name: np.array(SOURCES)[getattr(self, name)].tolist() for name in ("lower_from", "upper_from")}
        flags = {name: getattr(self, name).tolist() for name in ("outside", "gives_way")}
        return {"joint_names": list(self.joint_names), **bounds, **sources, **flags}

    def __str__(self) -> str:
        if self.lower.ndim > 1:
            return f"RateLimits of shape {self.lower.shape}"
        told = bool(np.any(self.lower_from > 1) or np.any(self.upper_from > 1))
        rows = [["", "lower", "upper"] + (["from"] if told else [])]
        for k, name in enumerate(self.joint_names):
            row = [name, format_number(self.lower[k]), format_number(self.upper[k])]
            if told:
                pair = {self.why(k, "lower"), self.why(k, "upper")}
                row.append(" and ".join(sorted(pair)) + (", gives way" if self.gives_way[k] else ""))
            rows.append(row)
        return "joint rates [rad/s or m/s]\n" + named_table(rows, "joints")


def position_range(model: RobotModel, margin: Any) -> tuple[Array, Array]:
    """(n) lower and upper position limits, `margin` inside the model's [rad or m].

    Raises:
        ConfigurationError: KS353 for a margin that is negative, KS354 where it leaves nothing.
    """
    inside = per_joint(model, margin, "margin", positive=False)
    lower, upper = model.lower + inside, model.upper - inside
    if np.any(lower > upper):
        k = int(np.argmax(lower > upper))
        message = f"a margin of {inside[k]:g} leaves joint {model.joint_names[k]!r} no room between its limits"
        raise ConfigurationError("KS354", message, f"they are {model.lower[k]:g} and {model.upper[k]:g}")
    return lower, upper


def per_joint(model: RobotModel, value: Any, name: str, positive: bool) -> Array:
    """(n) finite numbers above zero (or not below it), from one number or n.

    Raises:
        ConfigurationError: KS353.
    """
    try:
        array = np.broadcast_to(np.asarray(value, dtype=np.float64), (model.n,))
    except (TypeError, ValueError):
        array = np.full(model.n, np.nan)
    good = np.isfinite(array) & ((array > 0) if positive else (array >= 0))
    if not np.all(good):
        kind = "positive" if positive else "not negative"
        hint = f"a finite number, {kind}, or one for each of {model.n} joints"
        raise ConfigurationError("KS353", f"{name} is {value!r}", hint)
    return array


def _position_bounds(
    q: Array, span: tuple[Array, Array], dt: float | None, acceleration: Array | None, recovery: float
) -> tuple[Array, Array, Array]:
    """Rates that stay inside the position limits, and whether a joint is beyond one of them."""
    if not 0 <= recovery < np.inf:
        raise ConfigurationError("KS353", f"recovery is {recovery!r}", "0, or a rate in 1/s")
    above, below = span[1] - q, q - span[0]
    upper, lower = (approach_rate(D, dt, acceleration) + recovery * np.minimum(D, 0.0) for D in (above, below))
    lower = -lower
    lower, upper = np.where(above < 0, np.minimum(lower, upper), lower), np.where(below < 0, np.maximum(lower, upper), upper)
    return lower, upper, (above < 0) | (below < 0)


def _numbers(model: RobotModel, value: Any, what: str) -> Array:
    require_model(model)
    if model.is_symbolic:
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths", "put numbers in place of the symbols")
    array, xp = configuration(model, value, what=what)
    if xp.name != "numpy":
        raise ArrayTypeError("KS302", f"{what} is an array of {xp.name}; limits are NumPy arrays", "pass np.asarray(...)")
    return array


def _bound(value: Any, name: str) -> Array:
    array, xp = as_array(value, name)
    if xp.name != "numpy" or array.ndim < 1:
        raise ArrayTypeError("KS302", f"{name} is no array of numbers (..., n)", "one bound for each joint, NumPy or a list")
    if np.isnan(array).any():
        raise ConfigurationError("KS301", f"{name} holds NaN", "an infinite number where there is no limit")
    return np.array(array, dtype=np.float64)


def _own(value: Array, default: Array) -> Array:
    return np.array(default if value is None else value)
