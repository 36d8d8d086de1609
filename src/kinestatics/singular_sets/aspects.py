"""Aspects: the regions of joint space that singular postures separate, counted from the critical points of the determinant.

Every region of det > 0 holds a greatest value, every region of det < 0 a least one. Two of these lie in one region where a
pass joins them, a critical point from which |det| rises in one direction only: walking up both ways ends at the two
(Milnor, "Morse Theory", section 3); or where any way leads from one to the other on which det J does not vanish. The
critical points are found by Newton steps from many postures, so that the count is measured and not proved; that there are
no fewer than the signs show is certain.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..symbolic.functions import WaveFunction

_NEWTON, _CLIMB = 80, 400
_FLAT, _SAME, _PUSH = 1e-10, 1e-4, 1e-3
_STONES, _NEIGHBOURS, _POINTS = 5, 14, 24
_ZERO = 1e-6  # critical values this small beside the largest lie on the singular set itself


@dataclass(frozen=True, eq=False)
class Aspects:
    """The regions of joint space between singular postures, all joints turning freely.

    Attributes:
        count: how many were found.
        representatives: (count, n) one posture of each, where |det J| is greatest.
        signs: (count) of the determinant.
        extrema, passes: how many critical points of each kind were found.
        proved: False: found from `starts` postures; the number of signs is a proved lower bound.
        starts: postures from which critical points were looked for; seconds: what it took.
    """

    count: int
    representatives: Array
    signs: Array
    extrema: int
    passes: int
    starts: int
    seconds: float
    proved: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "count": self.count,
            "representatives": self.representatives.tolist(),
            "signs": self.signs.tolist(),
            "extrema": self.extrema,
            "passes": self.passes,
            "starts": self.starts,
            "proved": self.proved,
        }

    def __str__(self) -> str:
        return (
            f"{self.count} aspects (measured: {self.extrema} extrema and {self.passes} passes from {self.starts} postures)"
        )


def count_aspects(f: WaveFunction, n: int, starts: int, seed: int) -> Aspects:
    """The aspects of a determinant in angles.

    Args:
        f: the determinant; n: joints of the robot.
        starts: postures from which critical points are looked for.
        seed: of these postures.
    """
    began = time.monotonic()
    joints = list(f.joints)
    if not joints:
        return Aspects(1, np.zeros((1, n)), np.sign(f.value(np.zeros((1, n)))).astype(int), 0, 0, 0, 0.0)
    own = _Restricted(f, joints, n)
    rng = np.random.default_rng(seed)
    points = rng.uniform(-np.pi, np.pi, (starts, len(joints)))
    critical = _distinct(_critical(own, points))
    values, curved = own.value(critical), np.linalg.eigvalsh(own.hessian(critical))
    kept = np.abs(values) > _ZERO * np.abs(values).max()
    critical, values, curved = critical[kept], values[kept], curved[kept]
    rising = (curved * np.sign(values)[:, None] > 0).sum(1)
    climbers = np.concatenate([critical[rising == 0], points])  # a walk up finds what Newton's steps passed by
    tops, passes = _distinct(_critical(own, _climbed(own, climbers))), critical[rising == 1]
    tops = tops[_is_top(own, tops)]
    groups = list(range(len(tops)))
    for point in passes:
        ends = _ends_of(own, point, tops)
        if len(ends) == 2:
            a, b = (_root(groups, k) for k in ends)
            groups[max(a, b)] = min(a, b)
    _join_by_stones(own, tops, groups, starts, seed)
    roots = sorted({_root(groups, k) for k in range(len(tops))})
    found = np.zeros((len(roots), n))
    for place, root in enumerate(roots):
        members = [k for k in range(len(tops)) if _root(groups, k) == root]
        found[place, joints] = tops[max(members, key=lambda k: abs(float(own.value(tops[k][None])[0])))]
    signs = np.sign(f.value(found)).astype(int)
    return Aspects(len(roots), found, signs, len(tops), len(passes), starts, time.monotonic() - began)


class _Restricted:
    """A function of the joints it depends on."""

    def __init__(self, f: WaveFunction, joints: list[int], n: int) -> None:
        self.f, self.joints, self.n = f, joints, n

    def _whole(self, x: Array) -> Array:
        q = np.zeros((*x.shape[:-1], self.n))
        q[..., self.joints] = x
        return q

    def value(self, x: Array) -> Array:
        return self.f.value(self._whole(x))

    def gradient(self, x: Array) -> Array:
        return self.f.gradient(self._whole(x))[..., self.joints]

    def slope_bound(self) -> Array:
        size = np.hypot(self.f.cosines, self.f.sines)
        return (size @ np.abs(self.f.frequencies))[self.joints]

    def hessian(self, x: Array) -> Array:
        return self.f.hessian(self._whole(x))[..., self.joints, :][..., self.joints]


def _is_top(own: _Restricted, x: Array) -> Array:
    """(k) whether |f| is greatest at a critical point, and not zero."""
    values, curved = own.value(x), np.linalg.eigvalsh(own.hessian(x))
    high = np.abs(values) > _ZERO * np.abs(values).max(initial=0.0)
    return np.asarray(np.all(curved * np.sign(values)[:, None] < 0, axis=-1) & high)


def _critical(own: _Restricted, x: Array) -> Array:
    """Points with ∇f = 0: damped Newton steps, kept where they arrive."""
    scale = own.f.scale
    for _ in range(_NEWTON):
        g, H = own.gradient(x), own.hessian(x)
        U, sigma, Vt = np.linalg.svd(H)
        inverse = sigma / (sigma**2 + (1e-9 * scale) ** 2)
        step = -np.einsum("kji,kj->ki", Vt, inverse * np.einsum("kji,kj->ki", U, g))
        size = np.linalg.norm(step, axis=-1, keepdims=True)
        x = x + step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-30))
    return x[np.linalg.norm(own.gradient(x), axis=-1) <= _FLAT * scale]


def _climbed(own: _Restricted, x: Array) -> Array:
    """Postures moved up |f| to where it is greatest nearby."""
    step = np.full(len(x), 0.1)
    sign = np.sign(own.value(x))
    for _ in range(_CLIMB):
        g = own.gradient(x) * sign[:, None]
        size = np.linalg.norm(g, axis=-1)
        if len(x) == 0 or size.max() <= _FLAT * own.f.scale:
            break
        trial = x + step[:, None] * g / np.maximum(size, 1e-30)[:, None]
        better = own.value(trial) * sign > own.value(x) * sign
        x = np.where(better[:, None], trial, x)
        step = np.where(better, np.minimum(1.3 * step, 0.2), 0.4 * step)
    return x


def _ends_of(own: _Restricted, point: Array, tops: Array) -> list[int]:
    """The extrema reached by walking up both ways from a pass."""
    sign = float(np.sign(own.value(point[None])[0]))
    values, vectors = np.linalg.eigh(own.hessian(point[None])[0] * sign)
    direction = vectors[:, int(values.argmax())]
    ends = _critical(own, _climbed(own, np.stack([point + _PUSH * direction, point - _PUSH * direction])))
    found = []
    for end in ends:
        apart = _apart(end, tops)
        if len(apart) and apart.min() < 0.05:
            found.append(int(apart.argmin()))
    return found


def _join_by_stones(own: _Restricted, tops: Array, groups: list[int], starts: int, seed: int) -> None:
    """Joins extrema between which a way of straight pieces leads, from stone to stone, on none of which f vanishes.

    That it does not on a piece follows from the values at a few points of it and a bound on the slope along it.
    """
    stones = np.random.default_rng(seed + 1).uniform(-np.pi, np.pi, (_STONES * starts, tops.shape[1]))
    x = np.concatenate([tops, stones])
    sign, parents = np.sign(own.value(x)), list(range(len(x)))
    for k in range(len(tops)):
        parents[k] = groups[k]
    slope = own.slope_bound()
    for a in range(len(x)):
        difference = np.mod(x - x[a] + np.pi, 2 * np.pi) - np.pi
        near = np.argsort(np.linalg.norm(difference, axis=1))[1 : _NEIGHBOURS + 1]
        near = near[(sign[near] == sign[a]) & np.array([_root(parents, int(b)) != _root(parents, a) for b in near])]
        if not len(near):
            continue
        ways = difference[near]
        shares = (np.arange(_POINTS) + 0.5) / _POINTS
        least = np.abs(own.value(x[a] + shares[:, None, None] * ways)).min(0)
        for b in near[least > 0.5 / _POINTS * (np.abs(ways) @ slope)]:
            one, other = _root(parents, a), _root(parents, int(b))
            parents[max(one, other)] = min(one, other)
    for k in range(len(tops)):
        groups[k] = _root(parents, k)


def _apart(x: Array, others: Array) -> Array:
    """Distances on the torus."""
    difference = np.mod(others - x + np.pi, 2 * np.pi) - np.pi
    return np.linalg.norm(difference, axis=-1)


def _distinct(x: Array) -> Array:
    """The points, each once."""
    kept: list[Array] = []
    for point in x:
        if not kept or _apart(point, np.array(kept)).min() > _SAME:
            kept.append(point)
    return np.array(kept).reshape(len(kept), x.shape[-1])


def _root(groups: list[int], k: int) -> int:
    while groups[k] != k:
        k = groups[k]
    return k
