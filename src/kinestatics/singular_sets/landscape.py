"""`Landscape`: a factor of the determinant over a box of joints; walks up it and ways on which it surely keeps its sign.

Law: along x + s v, |f| >= |f(x)| + s ∇|f| · v - s² b(v)/2, with b(v) a bound of the second derivative along v; where that is
positive up to s = 1, f does not vanish on the way. Bounds of waves are Σ amplitude (k · v)².
"""

from __future__ import annotations

import numpy as np

from ..namespaces import Array
from ..symbolic.functions import WaveFunction

_ROUNDING = 1e-12  # of the scale: values this small may be zero
_CLIMB, _SHORTEST, _LONGEST = 120, 1e-6, 0.5
_LEVEL = 1e-7  # slopes this small beside the scale end a walk
_HALVINGS = 9
_NEWTON, _FLAT, _CAP = 40, 1e-10, 0.3
_RISES = 1e-9


class Landscape:
    """f over the joints it depends on, each on a circle or between limits.

    Attributes:
        f: the function, of these joints alone; joints: their columns in the robot.
        lower, upper: (d) limits, infinite on a circle; round: (d) which are circles.
        scale: |f| does not exceed it.
    """

    def __init__(self, f: WaveFunction, joints: tuple[int, ...], lower: Array, upper: Array) -> None:
        columns = list(joints)
        self.f = WaveFunction(f.frequencies[:, columns], f.powers[:, columns], f.cosines, f.sines)
        self.joints, self.lower, self.upper = joints, lower, upper
        self.round = ~np.isfinite(lower)
        size, powers = np.hypot(f.cosines, f.sines), self.f.powers
        reach = np.where(self.round, 1.0, np.maximum(np.abs(lower), np.abs(upper)))
        eye = np.eye(len(columns), dtype=int)

        def bound(*by: Array) -> Array:
            """(m) the greatest of the monomials differentiated by some joints."""
            left, factor = powers, np.ones(len(powers))
            for one in by:
                factor, left = factor * (left @ one), np.maximum(left - one, 0)
            return size * factor * np.prod(reach**left, axis=-1)

        self._whole = bound()
        self._once = np.stack([bound(one) for one in eye], -1)
        self._twice = np.stack([np.stack([bound(one, other) for other in eye], -1) for one in eye], -1)
        self.scale = float(self._whole.sum())

    def size(self, x: Array, sign: Array) -> Array:
        """(k) f by the sign given."""
        return self.f.value(x) * sign

    def bend(self, v: Array) -> Array:
        """(k) what the second derivative along steps v (k, d) does not exceed in the box."""
        turned = v @ self.f.frequencies.T
        found = turned**2 @ self._whole
        if self.f.slides:
            away = np.abs(v)
            found = found + 2 * (np.abs(turned) * (away @ self._once.T)).sum(-1)
            found = found + np.einsum("ki,mij,kj->k", away, self._twice, away)
        return found

    def sure(self, x: Array) -> Array:
        """(k) whether f is surely not zero."""
        return np.abs(self.f.value(x)) > _ROUNDING * self.scale

    def chart(self, x: Array) -> Array:
        """(k, c) the places where near ones are near around circles too."""
        return np.concatenate([np.cos(x[:, self.round]), np.sin(x[:, self.round]), x[:, ~self.round]], -1)

    def step_to(self, a: Array, b: Array) -> Array:
        """(k, d) the way from a to b, the shorter one around circles."""
        away = b - a
        return np.where(self.round, np.mod(away + np.pi, 2 * np.pi) - np.pi, away)

    def keeps_sign(self, a: Array, v: Array) -> Array:
        """(k) whether f surely keeps its sign all along a + s v, s from 0 to 1; halved where bounds are too coarse."""
        sign = np.sign(self.f.value(a))
        kept, way = np.ones(len(a), dtype=bool), np.arange(len(a))
        middle, bend = np.full(len(a), 0.5), self.bend(v)
        for half in 0.5 ** np.arange(1, _HALVINGS + 1):
            x = a[way] + middle[:, None] * v[way]
            value, slope = self.size(x, sign[way]), np.abs((self.f.gradient(x) * v[way]).sum(-1))
            free = value - slope * half - bend[way] * half**2 / 2 > _ROUNDING * self.scale
            kept[way[value <= 0]] = False
            open_ = ~free & kept[way]
            if not open_.any():
                return kept
            way, middle = np.repeat(way[open_], 2), np.repeat(middle[open_], 2)
            middle = middle + half / 2 * np.tile([-1.0, 1.0], len(way) // 2)
        kept[way] = False
        return kept

    def inwards(self, x: Array, g: Array) -> Array:
        """(k, d) a slope without what leads out of the box."""
        out = ((x >= self.upper) & (g > 0)) | ((x <= self.lower) & (g < 0))
        return np.where(out, 0.0, g)

    def climbed(self, x: Array) -> Array:
        """Places walked up |f| within the box, by steps on each of which f surely keeps its sign.

        Newton's steps with the curvatures made positive: along a narrow ridge they are as long as it allows.
        """
        x = x.copy()
        sign, share, going = np.sign(self.f.value(x)), np.ones(len(x)), np.arange(len(x))
        for _ in range(_CLIMB):
            here, s = x[going], sign[going]
            g = self.inwards(here, self.f.gradient(here) * s[:, None])
            left = (np.linalg.norm(g, axis=-1) > _LEVEL * self.scale) & (share[going] > _SHORTEST)
            if not left.any():
                break
            going, here, s, g = going[left], here[left], s[left], g[left]
            trial = np.clip(here + share[going, None] * self._up(here, s, g), self.lower, self.upper)
            v, value = trial - here, self.size(here, s)
            better = self.size(trial, s) > value
            better[better] = self.keeps_sign(here[better], v[better])
            x[going[better]] = trial[better]
            share[going] = np.where(better, np.minimum(2.0 * share[going], 1.0), 0.3 * share[going])
        return x

    def _up(self, x: Array, sign: Array, g: Array) -> Array:
        """(k, d) steps up a slope g (k, d), none along joints that it does not rise along."""
        held = g == 0
        H = self.f.hessian(x) * sign[:, None, None]
        H = np.where(held[:, :, None] | held[:, None, :], 0.0, H)
        values, vectors = np.linalg.eigh(H)
        along = np.einsum("kij,ki->kj", vectors, g) / np.maximum(np.abs(values), 1e-6 * self.scale)
        step = np.where(held, 0.0, np.einsum("kij,kj->ki", vectors, along))
        size = np.linalg.norm(step, axis=-1, keepdims=True)
        return np.asarray(step * np.minimum(1.0, _LONGEST / np.maximum(size, 1e-30)))

    def critical(self, x: Array, free: Array) -> Array:
        """Places on a face of the box, where the slope along it vanishes: Newton steps in the free joints (d, bool)."""
        x, columns = x.copy(), np.flatnonzero(free)
        for _ in range(_NEWTON):
            g, H = self.f.gradient(x)[:, columns], self.f.hessian(x)[:, columns[:, None], columns]
            values, vectors = np.linalg.eigh(H)
            soft = values / (values**2 + (1e-9 * self.scale) ** 2)
            step = -np.einsum("kij,kj,klj,kl->ki", vectors, soft, vectors, g)
            size = np.linalg.norm(step, axis=-1, keepdims=True)
            x[:, columns] += step * np.minimum(1.0, _CAP / np.maximum(size, 1e-30))
        flat = np.linalg.norm(self.f.gradient(x)[:, columns], axis=-1) <= _FLAT * self.scale
        return x[flat & np.all((x >= self.lower) & (x <= self.upper), axis=-1)]

    def passes(self, x: Array, free: Array) -> tuple[Array, Array]:
        """Of critical places on a face those that |f| rises from along the face only, and (k, d) the way it rises most."""
        sign = np.sign(self.f.value(x))
        slope = self.f.gradient(x) * sign[:, None]
        held = ~free
        outwards = np.all(~held | (self.inwards(x, slope) == 0), axis=-1)
        columns = np.flatnonzero(free)
        values, vectors = np.linalg.eigh(self.f.hessian(x)[:, columns[:, None], columns] * sign[:, None, None])
        kept = outwards & (values[:, -1] > _RISES * self.scale) & self.sure(x)
        ways = np.zeros((int(kept.sum()), x.shape[1]))
        ways[:, columns] = vectors[kept, :, -1]
        return x[kept], ways
