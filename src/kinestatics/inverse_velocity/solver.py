"""RateSolver: one bounded quadratic program a period, for control loops; bare arrays, nothing allocated but the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .._kernels import Chain, _core, chain_arguments
from ..errors import ArrayTypeError, ConfigurationError, FrameMismatchError
from ..frames import BASE, TIP, Frame
from ..kinematics import checked_point, named_frame, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Acceleration, SixVector, Twist
from ..spatial import ANGULAR_ROWS
from ..tasks import find_task
from .limits import per_joint, position_range
from .problem import checked_positive
from .quadratic import Bounded, solve
from .workspace import Arrays, open_workspace

_INSIDE = 1e-9
"""Bounds are kept this much inside the limits, relative or in rad, so that the solver's own tolerance exceeds none."""
_TRIALS = 32
_NO_LIMIT = 1e30
_LEAST_DAMPING = 2e-5  # of the largest singular value: DAQP takes squares below 1e-11 for zero
_largest = _core.largest


class RateSolver:
    """Joint rates for a twist inside velocity, position and acceleration limits, one period after the other.

    It is the program of `joint_rates(..., "qp")` with the bounds of `RateLimits.of`, on the rows in play. Rates are held
    for `dt`; with accelerations known, those of the period before are remembered (`previous`; `reset()` starts at rest).
    One solver serves one loop: it is not for several threads at once.

    Args:
        model: the robot.
        at: link that is moved; point: (3) of it, in its axes [m].
        frame: of the twists: Frame("base", at), the default, or Frame.body(at).
        task: rows in play, as in `find_task`; the others are free.
        dt: period [s].
        acceleration: (n) or a number: the greatest |q̈| [rad/s² or m/s²]; None: any change of rate is allowed.
        margin: (n) or a number: distance kept from the position limits [rad or m].
        damping: λ of |J q̇ - ξ|² + λ² |q̇|² [the unit of the rows]. The program is in the squares of J, which leave no
            digits for less than 2e-5 of the largest singular value; "qp" of joint_rates takes less.
        length: a twist's size is |(v, length · ω)| [m].

    Methods:
        step(q, twist) → (n), for q (n) and a twist (6), NaN where a component is free.
        reset(previous=None): the rates the next step starts from.

    Raises:
        ConfigurationError: KS301, KS303 by step; KS353, KS354. FrameMismatchError: KS331. ArrayTypeError: KS302.
        MissingExtraError: KS400.

    Law: min |J q̇ - ξ|² + λ² |q̇|² subject to the bounds of RateLimits.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("panda")
        >>> solver = ks.RateSolver(arm, dt=0.001)
        >>> q = arm.home
        >>> rates = solver.step(q, [0.1, 0, 0, 0, 0, 0])
        >>> round(float((ks.jacobian(arm, q) @ rates).linear[0]), 4)
        0.1
    """

    _tell: Callable[[], Any]
    _solve: Callable[[], Any]

    def __init__(
        self,
        model: RobotModel,
        *,
        at: str = TIP,
        point: Sequence[float] = (0.0, 0.0, 0.0),
        frame: Frame | None = None,
        task: str | Sequence[str] | Sequence[int] = "auto",
        dt: float,
        acceleration: Any = None,
        margin: Any = 0.0,
        damping: float = 1e-3,
        length: float = 1.0,
    ) -> None:
        require_model(model)
        self.model, self.dt = model, checked_positive(dt, "dt", "the period in seconds")
        self.damping = checked_positive(damping, "damping", "in the unit of the rows")
        self._chain, self.frame = _chain(model, at, checked_point(point), frame)
        self._write = self._chain.bounded_program
        self.task = find_task(model, task, at=at, frame=frame)
        self._read_settings(checked_positive(length, "length", "the characteristic length in metres"), margin, acceleration)
        self._share_arrays()
        self._check_damping()
        self._open()
        self.reset()

    def step(self, q: Any, twist: Any) -> Array:
        """The rates for the coming period: q (n) [rad or m], twist (6) [m/s, rad/s] → (n) [rad/s or m/s]."""
        if not self._write(q, twist, self._settings, self._program):
            self._write(self._read_q(q), self._read_twist(twist), self._settings, self._program)
        self._tell()
        rates, _, flag, _ = self._solve()
        if flag != 1 or not _largest(rates) <= self._greatest:  # type: ignore[operator]
            rates = self._again()
        elif not self._exact:
            rates = np.clip(rates, self._lower, self._upper)
        self._previous[:] = rates
        return rates

    def reset(self, previous: Any = None) -> None:
        """Says at which rates (n) the arm moves before the next step, default none."""
        rates = np.zeros(self.model.n) if previous is None else np.asarray(previous, dtype=np.float64)
        if rates.shape != (self.model.n,) or not np.all(np.isfinite(rates)):
            raise ConfigurationError("KS303", f"previous is {previous!r}", f"{self.model.n} finite rates")
        self._previous[:] = rates

    @property
    def previous(self) -> Array:
        """(n) the rates of the period before [rad/s or m/s]."""
        return self._previous.copy()

    @property
    def bounds(self) -> tuple[Array, Array]:
        """(n), (n) lower and upper bounds of the last step [rad/s or m/s]."""
        return self._lower.copy(), self._upper.copy()

    def _read_settings(self, length: float, margin: Any, acceleration: Any) -> None:
        """What stays from step to step, as the kernel reads it: row weights, λ², dt, then four numbers of each joint."""
        model = self.model
        self._weights = np.zeros(6)
        for row in self.task.rows:
            self._weights[row] = length if row in ANGULAR_ROWS else 1.0
        lower, upper = position_range(model, np.asarray(margin, dtype=float) + _INSIDE)
        fastest = np.minimum(model.velocity_limits * (1.0 - _INSIDE), _NO_LIMIT)
        most = np.full(model.n, np.inf)
        if acceleration is not None:
            most = per_joint(model, acceleration, "acceleration", positive=True) * (1.0 - _INSIDE)
        self._settings = np.concatenate([self._weights, [self.damping**2, self.dt], lower, upper, fastest, most])
        self._greatest = float(model.velocity_limits.max(initial=0.0)) * (1.0 + 1e-6)

    def _share_arrays(self) -> None:
        """The one array the kernel writes, and the names of its parts; DAQP reads H, f and the bounds where they lie."""
        n = self.model.n
        sizes = [6 * n, 6, n, n * n, n, n, n]
        self._program = np.zeros(sum(sizes))
        parts = np.split(self._program, np.cumsum(sizes)[:-1])
        self._J, self._target, self._previous, H, f, self._upper, self._lower = parts
        self._J = self._J.reshape(6, n)
        self._arrays = Arrays(H.reshape(n, n), f, self._upper, self._lower)

    def _check_damping(self) -> None:
        """Raises ConfigurationError (KS353) where λ² would be rounding beside J J in some posture."""
        if not self.model.n:
            return
        samples = self._weighted(self.model.random_configurations(64, seed=1))
        least = _LEAST_DAMPING * float(np.linalg.norm(samples, 2, axis=(-2, -1)).max())
        if self.damping < least:
            hint = f"at least {least:.1g} for this arm; joint_rates(..., 'qp', damping=) takes less"
            raise ConfigurationError("KS353", f"damping is {self.damping!r}, too small for a program in squares", hint)

    def _weighted(self, q: Array) -> Array:
        return self._weights[:, None] * self._chain.jacobian(q)

    def _trials(self) -> list[Bounded]:
        """Problems like those to come: this arm, every other time short of rank, with bounds that are met and others."""
        n, rng = self.model.n, np.random.default_rng(1)
        found = []
        for k, drawn in enumerate(self.model.random_configurations(_TRIALS, seed=2)):
            J = self._weighted(drawn)
            if k % 2:
                U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
                J = (U[:, : k % 4] * sigma[: k % 4]) @ Vt[: k % 4]
            reach = rng.uniform(0.1, 1.0, n)
            twist = J @ (reach * rng.normal(size=n)) * rng.choice([0.3, 3.0])
            found.append(Bounded(J, twist, np.zeros(n), np.eye(n), -reach, reach, self.damping))
        return found

    def _open(self) -> None:
        """A workspace of DAQP on the arrays of this solver."""
        workspace = open_workspace(self._arrays, self._trials())
        self._tell, self._solve, self._exact, self._way = workspace.tell, workspace.solve, workspace.exact, workspace.way

    def _again(self) -> Array:
        """The same program by the slower route, where DAQP has given up or was handed numbers out of scale."""
        J, n = self._J, self.model.n
        if not (np.all(np.isfinite(self._program))):
            raise ConfigurationError("KS356", "the program of this step is not finite", "q or the twist is far out of scale")
        lower, upper = self._lower.copy(), np.maximum(self._upper, self._lower)
        program = Bounded(J, self._target, np.zeros(n), np.eye(n), lower, upper, self.damping)
        found = solve(program, np.clip(np.zeros(n), lower, upper))
        if self._way is not None and (fresh := self._way(self._arrays)) is not None:
            self._tell, self._solve = fresh.tell, fresh.solve
        return np.clip(found, lower, upper)

    def _read_twist(self, twist: Any) -> Array:
        if isinstance(twist, SixVector) and (not isinstance(twist, Twist) or isinstance(twist, Acceleration)):
            message = f"step takes a twist, not {'an' if isinstance(twist, Acceleration) else 'a'} {type(twist).__name__}"
            raise ArrayTypeError("KS302", message, "ks.Twist.of(linear=..., angular=...), or 6 numbers")
        if isinstance(twist, SixVector):
            written = named_frame(self.model, twist.frame)
            if written != self.frame:
                message = f"the solver ({self.frame}) and the twist ({written}) are written in different frames"
                raise FrameMismatchError("KS330", message, f"RateSolver(..., frame={written!r}), or rewrite the twist")
            twist = twist.array
        array = np.array(twist, dtype=np.float64)
        hint = "6 finite numbers, linear first; NaN where a component is free"
        if array.shape != (6,):
            raise ConfigurationError("KS303", f"the twist has shape {array.shape}", hint)
        if np.isinf(array).any():
            raise ConfigurationError("KS301", f"the twist is {array}", hint)
        return array

    def _read_q(self, q: Any) -> Array:
        array = np.array(q, dtype=np.float64)
        if array.shape != (self.model.n,):
            raise ConfigurationError("KS303", f"q has shape {array.shape}; expected ({self.model.n},)", "one configuration")
        if not np.all(np.isfinite(array)):
            raise ConfigurationError("KS301", f"q is {array}", "pass finite numbers")
        return array

    def __repr__(self) -> str:
        return f"<RateSolver of {self.model.name!r}, {self.frame}, rows {', '.join(self.task.row_names)}, dt {self.dt:g} s>"


def _chain(model: RobotModel, at: str, point: tuple[float, float, float], frame: Frame | None) -> tuple[Chain, Frame]:
    """The compiled Jacobian of a link's point, in base axes or in the link's own.

    Raises:
        FrameMismatchError: KS331. ArrayTypeError: KS302, for a model with symbolic lengths.
    """
    if model.is_symbolic:
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths", "put numbers in place of the symbols")
    link, base = model.link(at), model.link(BASE)
    wanted = frame or Frame(BASE, at)
    named = named_frame(model, wanted._replace(offset=point) if any(point) else wanted)
    axes, origin = model.link(named.axes), model.link(named.origin)
    if axes not in (base, link) or origin != link:
        hint = "twists at the link itself; other frames: the Jacobian's change_frame and joint_rates"
        message = f"a RateSolver writes in axes of base or of {at!r}, at its point, not in {named}"
        raise FrameMismatchError("KS331", message, hint)
    return Chain(*chain_arguments(model, link, axes_of_target=axes == link != base, offset=named.offset)), named
