"""JointRates: the rates, and what is to be known about them: reachable or not and why, what is achieved, what is free."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array
from ..quantities import TIED, Jacobian, Twist, format_number, numeric, plain
from ..screws_in_words import describe_lost_twist
from ..spatial import rotate
from ..statics import decompose
from .limits import RateLimits
from .metric import Metric
from .problem import Problem, read_rates
from .spectral import Spectrum, inverse_gain, spectrum
from .text import described, joint_units, row_names

_AT_LIMIT = 1e-9  # relative to 1 + |bound|


@dataclass(frozen=True, eq=False, repr=False)
class JointRates:
    """Joint rates that make a twist, or come closest to it; made by `joint_rates`. `np.asarray` gives the bare rates.

    Ranks, reachability and what follows from them are found when they are asked for, and then kept.

    Attributes:
        array: (..., n) joint rates [rad/s or m/s].
        method: "pseudoinverse", "weighted", "damped", "adaptive", "qr" or "qp".
        jacobian, twist: as given; NaN in the twist, and what lies outside `task`, is a component that is free.
        tolerance: singular values below this fraction of the largest count as zero.
        length: a twist's size is |(v, length · ω)| [m].
        damping: λ; for "adaptive" one for each singular value (..., k); None where nothing is damped.
        limits: the bounds that were kept, or None.
        scale: (...) share of the speed that the limits allow: 1 where they do not bind, 0 where no share fits.
        keeps_direction: (...) whether the twist achieved is a share of the one without limits; "qp" gives that up where
            limits bind, unless keep_direction was asked for.
        by_svd: (...) for "qr", where the SVD took over for want of full rank; None for other methods.
        problem, metric: rows and weights in the form they were solved in.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> print(ks.joint_rates(J, [1, 1, 0, np.nan, np.nan, np.nan]))
        joint rates by pseudoinverse
          joint1  0.4  rad/s
          joint2  0.2  rad/s
        not reachable: rank J = 1 < rank [J | ξ] = 2: no velocity along x of base
        achieved: vx 0, vy 1, vz 0, wx 0, wy 0, wz 0.6
        residual: vx 1, vy 0, vz 0
    """

    array: Array
    method: str
    jacobian: Any
    twist: Any
    tolerance: float
    length: float
    problem: Problem
    metric: Metric
    damping: Any = None
    limits: RateLimits | None = None
    scale: Array = None
    keeps_direction: Array = None
    by_svd: Array = None

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(numeric(self.array), dtype=dtype, copy=copy)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """(n) names of the joints; "q1" ... for a bare array."""
        if isinstance(self.jacobian, Jacobian):
            return self.jacobian.joint_names
        return tuple(f"q{k + 1}" for k in range(self.problem.n))

    @property
    def task(self) -> tuple[str, ...] | None:
        """Names of the rows that the task asks for; "row 1" ... of a bare array; None where it is all of them."""
        rows = self.problem.task
        if rows is None:
            return None
        names = row_names(isinstance(self.jacobian, Jacobian), len(self.problem.sizes))
        return tuple(names[row].replace(TIED, " ") for row in rows)

    @cached_property
    def _spectrum(self) -> Spectrum:
        if self.problem.xp.name == "sympy":
            hint = "put numbers in place of the symbols"
            raise ArrayTypeError("KS302", "symbols have no tolerance to judge a rank with", hint)
        return spectrum(self.problem.matrix, self.problem.xp, self.tolerance)

    @cached_property
    def rank(self) -> Array:
        """(...) rank of the rows of J that count."""
        return np.broadcast_to(np.sum(numeric(self._spectrum.counted), axis=-1), self._batch)

    @cached_property
    def reachable(self) -> Array:
        """(...) whether some joint rates make the twist exactly, limits aside: rank J = rank [J | ξ]."""
        target = numeric(self.problem.target)
        rest = np.linalg.norm(target - numeric(self._spectrum.reachable_part(self.problem.target)), axis=-1)
        return np.broadcast_to(rest <= self.tolerance * np.linalg.norm(target, axis=-1), self._batch)

    @cached_property
    def rank_augmented(self) -> Array:
        """(...) rank of [J | ξ]: one more than that of J where ξ is no combination of its columns."""
        return self.rank + np.where(self.reachable, 0, 1)

    @property
    def _batch(self) -> tuple[int, ...]:
        return tuple(self.array.shape[:-1])

    @cached_property
    def reason(self) -> str:
        """The rank test in a sentence, with the directions that are lost where J has a frame."""
        if self.reachable.ndim:
            return f"reachable: {int(self.reachable.sum())} of {self.reachable.size} twists"
        rank = int(self.rank)
        if self.reachable:
            return f"reachable: rank J = rank [J | ξ] = {rank}"
        lost = self._lost()
        return f"not reachable: rank J = {rank} < rank [J | ξ] = {rank + 1}" + (f": {lost}" if lost else "")

    def _lost(self) -> str:
        """The lost directions that the twist asks for, in words; "" where J has no frame."""
        J, problem = self.jacobian, self.problem
        if not isinstance(J, Jacobian):
            return ""
        rows = [int(r) for r in np.flatnonzero(numeric(problem.asked))]
        matrix, target = numeric(problem.matrix) / problem.sizes[:, None], numeric(problem.target)
        lost = decompose(matrix, rows, self.length, self.tolerance).lost_twists
        asked = [t for t in lost if abs((problem.sizes * t) @ target) > self.tolerance * np.linalg.norm(target)]
        return ", ".join(describe_lost_twist(t, J.frame.axes, J.frame.origin, self.length).text for t in asked)

    @cached_property
    def achieved(self) -> Any:
        """J q̇: a Twist in the frame of J, or a bare array (..., r) where J is one."""
        return self._as_given(rotate(self.problem.plain, self.array))

    @cached_property
    def closest(self) -> Any:
        """The reachable twist closest to the one asked for, in the size |(v, length · ω)|; free rows as they then come."""
        found = self._spectrum
        return self._as_given(rotate(self.problem.plain, found.rates(self.problem.target, inverse_gain(found))))

    @cached_property
    def residual(self) -> Any:
        """The twist asked for minus the one achieved; 0 where a component is free."""
        problem = self.problem
        made = rotate(problem.plain, self.array)
        factors = (np.asarray(numeric(x), dtype=float) for x in (problem.asked, problem.sizes))
        asked, sizes = (problem.xp.constant(x, made) for x in factors)
        return self._as_given(problem.target / sizes - asked * made)

    def _as_given(self, array: Array) -> Any:
        return Twist(array, self.jacobian.frame) if isinstance(self.jacobian, Jacobian) else array

    @cached_property
    def null_motion(self) -> Array:
        """(n - rank, n) orthonormal basis of the joint motions that do not move the rows that count, of one J."""
        matrix = numeric(self.problem.matrix)
        if matrix.ndim != 2:
            hint = "loop over it, or member(b), which takes a batch"
            raise ConfigurationError("KS303", f"null motion of a batch of shape {matrix.shape}", hint)
        rank = int(np.sum(numeric(self._spectrum.counted)))
        return np.linalg.svd(matrix)[2][rank:]

    def member(self, b: Any) -> Array:
        """Other rates with the same twist: q̇ plus the part of the joint motion b that does not move the rows that count.

        Args:
            b: (n) or (..., n) [rad/s or m/s].

        Law: q̇ + (I - J⁺ J) b, with J⁺ of the joint weights in use. Source: note 000. Limits are not looked at.
        """
        problem, metric = self.problem, self.metric
        found = self._spectrum
        if metric.root is not None:
            found = spectrum(metric.in_units(problem.matrix, problem.xp), problem.xp, self.tolerance)
        motion = metric.enter(read_rates(b, "b", problem), problem.xp)
        return self.array + metric.leave(found.without_task(motion), problem.xp)

    @cached_property
    def condition(self) -> Array:
        """(...) σ_max / σ_min of the rows that count and are not zero, infinite at a singularity."""
        matrix, sigma = numeric(self.problem.matrix), numeric(self._spectrum.sigma)
        if not sigma.shape[-1]:
            return np.full(self._batch, np.inf)
        live = np.minimum(np.sum(np.any(matrix != 0.0, axis=-1), axis=-1), sigma.shape[-1])
        least = np.take_along_axis(sigma, np.maximum(live - 1, 0)[..., None], -1)[..., 0]
        good = (least > self.tolerance * sigma[..., 0]) & (live > 0)
        return np.broadcast_to(np.where(good, sigma[..., 0] / np.where(good, least, 1.0), np.inf), self._batch)

    @cached_property
    def at_limit(self) -> Array:
        """(..., n) which joints move as fast as a bound lets them; all False without limits."""
        rates = np.asarray(self)
        if self.limits is None:
            return np.zeros(rates.shape, dtype=bool)
        sizes = (_AT_LIMIT * (1.0 + np.where(np.isinf(b), 0.0, np.abs(b))) for b in (self.limits.lower, self.limits.upper))
        return (rates <= self.limits.lower + next(sizes)) | (rates >= self.limits.upper - next(sizes))

    @property
    def limiting(self) -> tuple[str, ...]:
        """The joints at a limit, of one set of rates: ("joint4: velocity limit 2.175 rad/s", ...)."""
        limits = self.limits
        if limits is None or len(self.array.shape) != 1 or limits.lower.ndim != 1:
            return ()
        units, rates, told = joint_units(self.jacobian, self.problem.n), np.asarray(self), []
        for k in np.flatnonzero(self.at_limit):
            side = "upper" if limits.upper[k] - rates[k] <= rates[k] - limits.lower[k] else "lower"
            bound = format_number(getattr(limits, side)[k])
            told.append(f"{self.joint_names[k]}: {limits.why(int(k), side)} limit {bound} {units[k]}".rstrip())
        return tuple(told)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; what is infinite is None."""
        return {
            "method": self.method,
            "joint_names": list(self.joint_names),
            "task": None if self.task is None else list(self.task),
            "rates": np.asarray(self).tolist(),
            "reachable": self.reachable.tolist(),
            "rank": self.rank.tolist(),
            "rank_augmented": self.rank_augmented.tolist(),
            "reason": self.reason,
            "achieved": np.asarray(self.achieved).tolist(),
            "residual": np.asarray(self.residual).tolist(),
            "condition": plain(self.condition),
            "damping": None if self.damping is None else np.asarray(numeric(self.damping)).tolist(),
            "scale": np.asarray(self.scale).tolist(),
            "keeps_direction": np.asarray(self.keeps_direction).tolist(),
            "limiting": list(self.limiting),
            "tolerance": self.tolerance,
            "length": self.length,
        }

    def __repr__(self) -> str:
        return f"<JointRates by {self.method}, shape {tuple(self.array.shape)}>"

    def __str__(self) -> str:
        return described(self)
