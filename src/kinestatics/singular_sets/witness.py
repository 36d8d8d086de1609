"""Singular postures inside a piece of a domain: what a certificate shows where it cannot prove that there are none."""

from __future__ import annotations

import numpy as np

from ..namespaces import Array
from .enclosure import Domain
from .exclusion import Part

_ON, _EXACT = 1e-13, 1e-16  # of the amplitudes: what counts as zero, and what no step improves
_STEPS, _HALVINGS = 60, 60
_PATIENCE = 6  # steps that may halve nothing; where an equation has a double root, each step quarters it
_RANDOM = 6
_DAMPING = 1e-13


def witness(part: Part, domain: Domain, low: Array, high: Array) -> Array | None:
    """A posture of one component in a domain, to rounding, looked for from a piece of it; None where none was found.

    Damped Gauss-Newton steps in the parameters, those at an end that push outwards held, from the piece's middle, corners
    and points between; and where one condition has both signs there, halving of the way between.
    """
    with np.errstate(all="ignore"):  # in boxes of so many turns that squares overflow nothing is found
        return _witness(part, domain, low, high)


def _witness(part: Part, domain: Domain, low: Array, high: Array) -> Array | None:
    """The search itself."""
    conditions, table = part.conditions, part.table
    scales = table.scales
    s = _starts(low, high)
    k = s.shape[1]
    if len(np.unique(part.owners)) == 1 and len(conditions) == 1 and k:
        s = np.concatenate([_between(part, domain, s), s])
    least, found, stalled = np.inf, s[0], 0
    for _ in range(_STEPS):
        values, slopes = table.evaluated(domain.at(s))
        f, G = _nearest(values / scales, slopes @ domain.directions.T / scales[:, None], conditions)
        rest = np.nan_to_num(np.abs(f).max(-1), nan=np.inf)
        best = int(rest.argmin())
        stalled = 0 if rest[best] < 0.5 * least else stalled + 1
        if rest[best] < least:
            least, found = float(rest[best]), s[best]
        if not k or least <= _EXACT or stalled >= (1 if least <= _ON else _PATIENCE):
            break
        s = _stepped(s, f, G)
    return domain.at(found) if least <= _ON else None


def _starts(low: Array, high: Array) -> Array:
    """(starts, k) the middle, a few corners, and points between."""
    rng, k = np.random.default_rng(11), len(low)
    if not k:
        return np.zeros((1, 0))
    weights = np.concatenate([np.zeros((1, k)), rng.choice([-1.0, 1.0], (6, k)), rng.uniform(-1.0, 1.0, (_RANDOM, k))])
    return np.clip((low + high) / 2.0 + 0.5 * (high - low) * weights, low, high)


def _nearest(values: Array, slopes: Array, conditions: Array) -> tuple[Array, Array]:
    """(s, c) each condition's factor that is nearest to zero, and (s, c, k) its slope."""
    least = np.abs(values[:, conditions]).argmin(-1)
    factor = np.take_along_axis(np.broadcast_to(conditions, (len(values), *conditions.shape)), least[..., None], -1)[..., 0]
    here = np.arange(len(values))[:, None]
    return values[here, factor], slopes[here, factor]


def _stepped(s: Array, f: Array, G: Array) -> Array:
    """One step, with parameters at an end held where it leads outwards."""
    step = _damped(f, G)
    for _ in range(2):
        outwards = ((s <= -1.0) & (step > 0)) | ((s >= 1.0) & (step < 0))
        if not outwards.any():
            break
        step = _damped(f, np.where(outwards[:, None], 0.0, G))
    return np.clip(s - np.nan_to_num(step), -1.0, 1.0)


def _damped(f: Array, G: Array) -> Array:
    """Gᵀ (G Gᵀ + damping)⁻¹ f, each equation measured by its slope."""
    size = np.maximum(np.linalg.norm(G, axis=-1), 1e-150)
    G, f = G / size[..., None], f / size
    square = G @ np.swapaxes(G, -1, -2) + _DAMPING * np.eye(f.shape[-1])
    return (np.swapaxes(G, -1, -2) @ np.linalg.solve(square, f[..., None]))[..., 0]


def _between(part: Part, domain: Domain, s: Array) -> Array:
    """Points where a factor changes sign on the way between two starts, by halving."""
    found = []
    slopes = part.table.evaluated(domain.at(s[:1]))[1]
    downhill = np.sign(slopes[0] @ domain.directions.T)  # (f, k) corners where a factor without bends is least and greatest
    for f in np.unique(part.conditions):
        ends = np.concatenate([s, np.stack([downhill[f], -downhill[f]])])
        values = part.table.evaluated(domain.at(ends))[0][:, f]
        a, b = ends[values.argmin()], ends[values.argmax()]
        if values.min() > 0 or values.max() < 0:
            continue
        for _ in range(_HALVINGS):
            middle = (a + b) / 2.0
            negative = part.table.evaluated(domain.at(middle[None]))[0][0, f] < 0
            a, b = (middle, b) if negative else (a, middle)
        found += [a, b]
    return np.array(found).reshape(-1, s.shape[1])
