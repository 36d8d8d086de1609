"""What an analysis refuses to compute with."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array

LARGEST = 1e150
"""Numbers from here on cannot be squared: an analysis refuses them."""


def finite_array(values: Any, what: str) -> Array:
    """The values, unless they ran out of what a float holds: prismatic joints and loads can be given as 1e300."""
    array = np.asarray(values, dtype=np.float64)
    if np.abs(array).max(initial=0.0) < LARGEST:
        return array
    raise ConfigurationError("KS301", f"{what} holds numbers of {LARGEST:g} or more", "check the units: metres, radians, N")
