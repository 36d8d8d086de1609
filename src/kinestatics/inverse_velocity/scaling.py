"""Slowing down until the limits are kept: the same direction, the greatest share of the speed.

q̇ = s p + t b, with p what makes the task, b what moves nothing of it, and 0 <= s, t <= 1: the greatest s first, so that
the task is as fast as the limits let it be, then the greatest t. b may also help: p alone need not fit. With
J b = 0 the twist is s J p for every t.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..namespaces import Array

_SLACK = 1e-12  # relative; what rounding may put a bound off


class Scaled(NamedTuple):
    """Rates inside their bounds.

    Attributes:
        rates: (..., n).
        scale: (...) s, 0 where no share fits.
        fits: (...) whether some share of p and b lies inside the bounds; where not, the rates are p + b cut off joint by
            joint, in another direction.
    """

    rates: Array
    scale: Array
    fits: Array


def scaled_into(task: Array, null: Array | None, lower: Array, upper: Array) -> Scaled:
    """s task + t null inside the bounds, all (..., n)."""
    b = np.zeros_like(task) if null is None else null
    task, b, lower, upper = np.broadcast_arrays(task, b, lower, upper)
    whole = task + b
    inside = np.all((whole >= lower) & (whole <= upper), axis=-1)
    rates, scale, fits = np.array(whole), np.ones(inside.shape), np.ones(inside.shape, dtype=bool)
    for where in np.argwhere(~inside):
        k = tuple(where)
        shares = _shares(task[k], b[k], lower[k], upper[k])
        if shares is None:
            rates[k], scale[k], fits[k] = np.clip(whole[k], lower[k], upper[k]), 0.0, False
        else:
            scale[k] = shares[0]
            rates[k] = np.clip(shares[0] * task[k] + shares[1] * b[k], lower[k], upper[k])
    return Scaled(rates, scale, fits)


def _shares(p: Array, b: Array, lower: Array, upper: Array) -> tuple[float, float] | None:
    """The greatest s, then the greatest t, with lower <= s p + t b <= upper and 0 <= s, t <= 1; None where none fit."""
    of_s = np.concatenate([p, -p, [1.0, -1.0, 0.0, 0.0]])
    of_t = np.concatenate([b, -b, [0.0, 0.0, 1.0, -1.0]])
    most = np.concatenate([upper, -lower, [1.0, 0.0, 1.0, 0.0]])
    bounded = np.isfinite(most)
    of_s, of_t, most = of_s[bounded], of_t[bounded], most[bounded]
    size = np.maximum(np.maximum(np.abs(of_s), np.abs(of_t)), np.abs(most))
    of_s, of_t, most = (x / np.where(size > 0, size, 1.0) for x in (of_s, of_t, most))
    up, down, level = of_t > 0, of_t < 0, of_t == 0
    # t is eliminated: each of its upper bounds must lie above each of its lower bounds (Fourier, Motzkin)
    k_s = np.concatenate([of_s[level], (np.outer(of_s[up], -of_t[down]) + np.outer(of_t[up], of_s[down])).ravel()])
    rest = np.concatenate([most[level], (np.outer(most[up], -of_t[down]) + np.outer(of_t[up], most[down])).ravel()])
    s = _greatest(k_s, rest)
    if s is None:
        return None
    t = _greatest(of_t, most - s * of_s)
    return None if t is None else (s, t)


def _greatest(slope: Array, most: Array) -> float | None:
    """The greatest x in [0, 1] with slope · x <= most; None where there is none, rounding aside."""
    rising, falling = slope > _SLACK, slope < -_SLACK
    if np.any(most[~rising & ~falling] < -_SLACK):
        return None
    highest = float(np.min(most[rising] / slope[rising], initial=1.0))
    lowest = float(np.max(most[falling] / slope[falling], initial=0.0))
    if highest < lowest - _SLACK * max(1.0, abs(lowest)):
        return None
    return min(1.0, max(highest, lowest, 0.0))
