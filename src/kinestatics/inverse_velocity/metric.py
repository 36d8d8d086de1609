"""Joint weights W: what makes metres of a prismatic joint and radians of a revolute one comparable, q̇ᵀ W q̇."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace, as_array
from ..spatial import rotate


@dataclass(frozen=True, eq=False)
class Metric:
    """q̇ᵀ W q̇ = |y|² with y = R q̇ and W = Rᵀ R.

    Attributes:
        root: R (n, n), or None for W = 1.
        inverse_root: R⁻¹ (n, n), or None.
    """

    root: Array | None = None
    inverse_root: Array | None = None

    @classmethod
    def of(cls, weights: Any, n: int) -> Metric:
        """From weights (n), or a matrix (n, n) such as the mass matrix; None is W = 1.

        Raises:
            ConfigurationError: KS303 for a shape, KS352 where W is not symmetric and positive.
        """
        if weights is None:
            return cls()
        W, xp = as_array(weights, "weights")
        if xp.name != "numpy":
            raise ArrayTypeError("KS302", f"weights are an array of {xp.name}", "NumPy numbers, or a list")
        if W.shape not in ((n,), (n, n)):
            hint = f"({n},), one for each joint, or a symmetric matrix ({n}, {n})"
            raise ConfigurationError("KS303", f"weights have shape {W.shape}; expected {hint}", "prismatic joints: 1/m²")
        W = np.diag(W) if W.ndim == 1 else W
        wrong = ConfigurationError("KS352", "the joint weights are not positive", "q̇ᵀWq̇ > 0 for every motion; W symmetric")
        if not np.all(np.isfinite(W)) or np.abs(W - W.T).max(initial=0.0) > 1e-12 * np.abs(W).max(initial=0.0):
            raise wrong
        try:
            root = np.linalg.cholesky(W).T
        except np.linalg.LinAlgError:
            raise wrong from None
        return cls(root, np.linalg.inv(root))

    def in_units(self, matrix: Array, xp: Namespace) -> Array:
        """J R⁻¹: the Jacobian for y."""
        return matrix if self.inverse_root is None else matrix @ xp.constant(self.inverse_root, matrix)

    def enter(self, rates: Array, xp: Namespace) -> Array:
        """R q̇."""
        return rates if self.root is None else rotate(xp.constant(self.root, rates), rates)

    def leave(self, y: Array, xp: Namespace) -> Array:
        """R⁻¹ y."""
        return y if self.inverse_root is None else rotate(xp.constant(self.inverse_root, y), y)
