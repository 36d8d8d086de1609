"""`pencils`: the algebra of several quadratic forms at once: the combinations w · Q of Q(a) = (Q₁(a), …, Q_c(a)).

Law: two questions decide what the map a ↦ Q(a) covers near zero.
- Is some combination definite? λ_min(w · Q) is concave in w; its greatest value over unit w, where it is positive, is the
  distance of 0 from the convex hull of {Q(a) : |a| = 1}.
- Is there a zero a of Q at which a ↦ Q(a, ·) is onto? Then Q, and every map with that second differential, covers a
  neighbourhood of zero. Both at once cannot be: a definite w · Q has no zero.
Forms are (c, m, m), symmetric; `error` is what of them rounding accounts for, and what is smaller counts as zero.
Source: Agrachev and Sachkov, "Control theory from the geometric viewpoint" (2004), chapter 20, for the openness of quadratic
maps.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from ..namespaces import Array

_ROUNDS, _CLOSE = 120, 1e-12
_STARTS = 32


def radical_of(forms: Array, error: float) -> tuple[Array, Array]:
    """Orthonormal bases, as columns, of the null motions in which all forms vanish, and of what is at right angles."""
    m = forms.shape[-1]
    _, sigma, Vt = np.linalg.svd(forms.reshape(-1, m), full_matrices=True)
    kept = int((sigma > error).sum())
    return Vt[kept:].T, Vt[:kept].T


def most_definite(forms: Array, error: float) -> tuple[Array, float, float]:
    """The unit w with the greatest λ_min(w · Q), that value, and a bound above it.

    Args:
        forms: (c, m, m) symmetric; error: a bound below it ends the search, for no combination is definite then.

    Returns:
        w (c), λ_min(w · Q) and the bound: the form is definite where the second is above `error`.

    Law: the bound is the distance of 0 from the hull of {Q(a)}: every point of the hull bounds from above, every w from
    below, and the two meet.

    Example:
        >>> import numpy as np
        >>> w, lower, upper = most_definite(np.array([np.diag([1.0, -1.0]), np.eye(2)]), 1e-12)
        >>> w.round(9), round(lower, 9), round(upper, 9)
        (array([0., 1.]), 1.0, 1.0)
    """
    c = len(forms)
    points = np.array([_value(forms, a) for a in np.linalg.eigh(forms[0])[1].T[:1]])
    best = (np.eye(c)[0], -np.inf)
    upper = np.inf
    for _ in range(_ROUNDS):
        nearest, points = _least_norm(points)
        upper = float(np.linalg.norm(nearest))
        if upper <= error:
            break
        w = nearest / upper
        values, vectors = np.linalg.eigh(np.einsum("i,iab->ab", w, forms))
        if values[0] > best[1]:
            best = (w, float(values[0]))
        if upper - values[0] <= _CLOSE * max(1.0, upper):
            break
        points = np.vstack([points, _value(forms, vectors[:, 0])])
    return best[0], best[1], upper


def _value(forms: Array, a: Array) -> Array:
    return np.asarray(np.einsum("iab,a,b->i", forms, a, a))


def _least_norm(points: Array) -> tuple[Array, Array]:
    """The point of least norm of the hull of a few points (s, c), and those of them that hold it."""
    best, holders = points[0], points[:1]
    for chosen in _subsets(len(points), points.shape[1] + 1):
        part = points[list(chosen)]
        s = len(part)
        system = np.block([[part @ part.T, np.ones((s, 1))], [np.ones((1, s)), np.zeros((1, 1))]])
        shares = np.linalg.lstsq(system, np.r_[np.zeros(s), 1.0], rcond=None)[0][:s]
        if shares.min() < 0 or abs(shares.sum() - 1) > 1e-9:
            continue
        point = shares @ part
        if point @ point < best @ best:
            best, holders = point, part
    return best, holders


def _subsets(count: int, most: int) -> Iterator[tuple[int, ...]]:
    for size in range(1, min(count, most) + 1):
        yield from itertools.combinations(range(count), size)


def passes(forms: Array, error: float) -> bool:
    """Whether both sides of every direction are reached: a regular common zero of the forms, or a loop around zero.

    Args:
        forms: (c, m, m) symmetric; error: what of them counts as zero.

    Returns:
        True where it was shown. False is a proof for one form and for two forms in two variables; for others it says that
        Newton's steps from 32 starts found no regular zero.

    Law: one form passes where it has eigenvalues of both signs; for more a zero a, |a| = 1, with a ↦ Q(a, ·) onto.

    Example:
        >>> import numpy as np
        >>> passes(np.diag([1.0, -1.0])[None], 1e-12), passes(np.eye(2)[None], 1e-12)
        (True, False)
    """
    c, m = len(forms), forms.shape[-1]
    if c == 1:
        values = np.linalg.eigvalsh(forms[0])
        return bool(values[0] < -error and values[-1] > error)
    if c == 2 and m == 2:
        return _loops_around_zero(forms, error)
    size = float(np.linalg.norm(forms))
    rng = np.random.default_rng(20260206)
    for a in rng.normal(size=(_STARTS if m > c else 0, m)):
        a = a / np.linalg.norm(a)  # noqa: PLW2901
        for _ in range(30):
            slopes = np.vstack([2 * forms @ a, 2 * a])
            values = np.r_[_value(forms, a), a @ a - 1]
            a = a - np.linalg.lstsq(slopes, values, rcond=1e-12)[0]  # noqa: PLW2901
        onto = np.linalg.svd(2 * forms @ a, compute_uv=False)
        if np.abs(_value(forms, a)).max() <= error and abs(a @ a - 1) < 1e-6 and onto[-1] > max(error, 1e-6 * size):
            return True
    return False


def _loops_around_zero(forms: Array, error: float) -> bool:
    """Two forms in two variables: (cos t, sin t) is carried to the ellipse A₀ + A₁ cos 2t + A₂ sin 2t. Does 0 lie inside?"""
    center = (forms[:, 0, 0] + forms[:, 1, 1]) / 2
    axes = np.stack([(forms[:, 0, 0] - forms[:, 1, 1]) / 2, forms[:, 0, 1]], -1)
    sigma = np.linalg.svd(axes, compute_uv=False)
    if sigma[-1] <= error:
        return False
    return bool(np.linalg.norm(np.linalg.solve(axes, center)) < 1 - error / sigma[-1])
