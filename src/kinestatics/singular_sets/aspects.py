"""Aspects: the regions of joint space that singular postures separate, on the torus or within the joint limits.

Factors of the determinant that share no joint separate each on their own: regions of a product are products of regions.
Of one joint they are the intervals between its zeros. Of several, regions are joined from postures: each is walked up |f|
to where it is greatest nearby, limits included (stratified Morse theory: Goresky and MacPherson, 1988; Milnor, "Morse
Theory", section 3); two of these lie in one region where a pass joins them, a critical posture of the box or of one of its
faces from which |f| rises both ways, or a way of straight pieces from posture to posture. Every step and piece is taken
only where a bound of derivatives says that f keeps its sign on it: what is joined is one region, up to the rounding of
floats. That none was missed, and that none was left in two, is measured.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..model import RobotModel
from ..namespaces import Array
from ..progress import Job
from ..symbolic.functions import WaveFunction
from .equations import Equation, Space
from .landscape import Landscape
from .regions import Map, Regions

_RIM = 1e-4  # [rad or m] at a limit that is left out: a zero that is written at a limit is at it


@dataclass(frozen=True, eq=False)
class Aspects:
    """The regions of joint space between singular postures.

    Attributes:
        count: how many were found.
        representatives: (count, n) one posture of each, where |det J| is great.
        signs: (count) of the determinant.
        limits: whether they are the regions within the joint limits; else all joints turn freely.
        extrema, passes: how many postures were found at which |f| is greatest nearby, and from which it rises both ways;
            over the factors of several joints.
        proved: whether the count is proved: where each factor is of one joint. Else it was found from `starts` postures:
            that postures counted together lie in one region is proved, that none was missed and none is left in two is not.
        settled: whether a last round of postures changed nothing; False where the time was up before.
        starts: postures in a round; seconds: what it took.
    """

    count: int
    representatives: Array
    signs: Array
    extrema: int
    passes: int
    starts: int
    seconds: float
    limits: bool = False
    proved: bool = False
    settled: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "count": self.count,
            "representatives": self.representatives.tolist(),
            "signs": self.signs.tolist(),
            "limits": self.limits,
            "extrema": self.extrema,
            "passes": self.passes,
            "starts": self.starts,
            "proved": self.proved,
            "settled": self.settled,
        }

    def __str__(self) -> str:
        what = f"{self.count} aspect{'' if self.count == 1 else 's'}{' within the joint limits' if self.limits else ''}"
        if self.proved:
            return f"{what} (proved: between zeros of single joints)"
        how = f"measured: {self.extrema} extrema and {self.passes} passes from {self.starts} postures"
        return f"{what} ({how}{'' if self.settled else '; the time was up'})"


class Box(NamedTuple):
    """(n) joints between limits, or infinite: on a circle; home: (n) where those that matter to no factor stay."""

    lower: Array
    upper: Array
    home: Array


def box_of(model: RobotModel, turns: Sequence[bool], joints: Sequence[int], limits: bool) -> Box:
    """The box within the limits, joints that turn without them on a circle; or the torus.

    Args:
        turns: which joints turn; joints: those that matter, which must turn or be limited.

    Raises:
        ConfigurationError: KS398 for one of these that slides without limits.
    """
    finite = np.isfinite(model.lower) & np.isfinite(model.upper) & limits
    for j in joints:
        if not turns[j] and not finite[j]:
            hint = "limits=True counts within the limits of joints that slide" if not limits else "give the joint limits"
            raise ConfigurationError("KS398", f"joint {model.joint_names[j]!r} slides, without an end", hint)
    lower, upper = np.where(finite, model.lower, -np.inf), np.where(finite, model.upper, np.inf)
    return Box(lower, upper, np.clip(model.home, lower, upper))


def count_aspects(
    factors: Sequence[tuple[Equation, int]],
    determinant: WaveFunction,
    space: Space,
    box: Box,
    starts: int,
    seed: int,
    job: Job,
) -> Aspects:
    """The aspects of a determinant by its factors.

    Args:
        factors: with multiplicities; determinant: their product.
        space: what they are written in; box: where.
        starts: postures in a round; seed: of these postures.
        job: the time it may take.
    """
    began = time.monotonic()
    n = space.model.n
    found = [_regions(group, space, box, starts, seed, job) for group in _groups(factors)]
    postures = []
    for chosen in itertools.product(*(group.postures for group in found)):
        q = box.home.copy()
        for group, x in zip(found, chosen, strict=True):
            q[list(group.joints)] = x
        postures.append(q)
    representatives = np.array(postures).reshape(len(postures), n)
    signs = np.sign(determinant.value(representatives)).astype(int)
    extrema, passes = (sum(getattr(group, what) for group in found) for what in ("extrema", "passes"))
    proved, settled = (all(getattr(group, what) for group in found) for what in ("proved", "settled"))
    limits = bool(np.any(np.isfinite(box.lower)))
    seconds = time.monotonic() - began
    return Aspects(len(signs), representatives, signs, extrema, passes, starts, seconds, limits, proved, settled)


def _groups(factors: Sequence[tuple[Equation, int]]) -> list[list[tuple[Equation, int]]]:
    """Factors that share joints, directly or by others; those proved to have no zeros are left out."""
    groups: list[list[tuple[Equation, int]]] = []
    for factor in factors:
        if factor[0].real is False or not factor[0].columns:
            continue
        joints = set(factor[0].columns)
        touched = [group for group in groups if any(joints & set(equation.columns) for equation, _ in group)]
        groups = [group for group in groups if group not in touched]
        groups.append([factor, *itertools.chain.from_iterable(touched)])
    return sorted(groups, key=lambda group: min(equation.columns for equation, _ in group))


def _regions(group: list[tuple[Equation, int]], space: Space, box: Box, starts: int, seed: int, job: Job) -> Regions:
    joints = tuple(sorted({j for equation, _ in group for j in equation.columns}))
    columns = list(joints)
    rim = np.minimum(_RIM, (box.upper[columns] - box.lower[columns]) / 4)
    lower, upper = box.lower[columns] + rim, box.upper[columns] - rim
    if len(joints) == 1:
        zeros = sorted({x for equation, _ in group for x in equation.solutions or ()})
        postures = _between(zeros, float(lower[0]), float(upper[0]), space.half.ring.turns[joints[0]])
        proved = all(equation.real is not None for equation, _ in group)
        return Regions(joints, postures[:, None], 0, 0, proved, True)
    product = None
    for equation, times in group:
        for part in equation.parts:
            power = part**times
            product = power if product is None else product * power
    land = Landscape(WaveFunction.of(space.half, product, space.values), joints, lower, upper)
    return Map(land, starts, seed, job).regions()


def _between(zeros: list[float], lower: float, upper: float, turns: bool) -> Array:
    """Middles of the intervals between the zeros of one joint, on a circle where limits are infinite."""
    if turns and np.isfinite(lower):
        first, last = np.floor((lower - np.pi) / (2 * np.pi)), np.ceil((upper + np.pi) / (2 * np.pi))
        zeros = sorted(x + 2 * np.pi * k for x in zeros for k in np.arange(first, last + 1))
    if np.isfinite(lower):
        ends = np.array([lower, *(x for x in zeros if lower < x < upper), upper])
        return (ends[:-1] + ends[1:]) / 2
    if not zeros:
        return np.zeros(1)
    ends = np.array([*zeros, zeros[0] + 2 * np.pi])
    return np.pi - np.mod(np.pi - (ends[:-1] + ends[1:]) / 2, 2 * np.pi)
