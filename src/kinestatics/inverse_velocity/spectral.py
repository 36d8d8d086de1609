"""Rates through the singular values of J: pseudoinverse, damped and filtered inverses, and motion of the null space.

With J = U diag(σ) Vᵀ every one of these laws is q̇ = V diag(g(σ)) Uᵀ ξ and differs in the gain g only. Singular values
are taken of J itself and not of J Jᵀ, whose condition is the square.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..namespaces import Array, Namespace
from ..spatial import rotate, transpose
from .problem import select

Gain = Callable[[Array], Array]
"""Singular values (..., k), descending → what each direction of ξ is multiplied by."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """J = U diag(σ) Vᵀ, and which σ count.

    Attributes:
        U: (..., r, k), Vt: (..., k, n); sigma: (..., k) descending.
        counted: (..., k) whether a singular value is above the tolerance.
    """

    U: Array
    sigma: Array
    Vt: Array
    counted: Array
    xp: Namespace

    def rates(self, target: Array, gain: Array) -> Array:
        """V diag(gain) Uᵀ target."""
        return rotate(transpose(self.Vt), gain * rotate(transpose(self.U), target))

    def reachable_part(self, target: Array) -> Array:
        """The part of ξ in the range of J: what its columns can make."""
        along = select(self.xp, self.counted, rotate(transpose(self.U), target), 0.0)
        return rotate(self.U, along)

    def without_task(self, b: Array) -> Array:
        """(I - J⁺J) b: the part of a joint motion that does not move the rows."""
        along = select(self.xp, self.counted, rotate(self.Vt, b), 0.0)
        return b - rotate(transpose(self.Vt), along)


def spectrum(matrix: Array, xp: Namespace, tolerance: float) -> Spectrum:
    """The singular value decomposition of (..., r, n); σ counts above `tolerance` times the largest."""
    U, sigma, Vt = xp.linalg.svd(matrix, full_matrices=False)
    return Spectrum(U, sigma, Vt, sigma > tolerance * sigma[..., :1], xp)


def inverse_gain(found: Spectrum) -> Array:
    """1/σ where σ counts, else 0: the pseudoinverse."""
    if found.xp.name == "numpy" and found.counted.all():
        return 1.0 / found.sigma
    safe = select(found.xp, found.counted, found.sigma, 1.0)
    return select(found.xp, found.counted, 1.0 / safe, 0.0)


def damped_gain(found: Spectrum, damping: Any) -> Array:
    """σ / (σ² + λ²), and the pseudoinverse's gain where λ is 0; λ may differ from direction to direction.

    Nakamura, Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986; Wampler, IEEE Trans. SMC 16(1), 1986. Divided through by the
    larger of σ and λ, so that neither square overflows or vanishes.
    """
    damping = damping + 0.0 * found.sigma
    largest = select(found.xp, damping > found.sigma, damping, found.sigma)
    positive = (damping > 0.0) & (largest > 0.0)
    safe = select(found.xp, positive, largest, 1.0)
    s, d = found.sigma / safe, select(found.xp, positive, damping, 1.0) / safe
    return select(found.xp, positive, s / (s * s + d * d) / safe, inverse_gain(found))


def adaptive_damping(found: Spectrum, region: float, most: Any) -> Array:
    """(..., k) the damping of each direction: λ² = (1 - (σ/ε)²) λ_max² below ε = region · σ_max, else 0.

    Nakamura, Hanafusa 1986 and Chiaverini, IEEE Trans. Robotics Automation 13(3), 1997 take it by the smallest σ for all;
    here each direction has its own, so that no other is slowed and rows that can never move damp nothing. With
    λ_max >= ε/√2 the gain grows with σ up to 1/ε and falls from there: no twist asks for more than |ξ|/ε.
    """
    edge = region * found.sigma[..., :1]
    safe = select(found.xp, edge > 0.0, edge, 1.0)
    share = found.sigma / safe
    left = select(found.xp, share < 1.0, 1.0 - share * share, 0.0)
    largest = edge * 0.5**0.5 if most is None else most
    return largest * left**0.5
