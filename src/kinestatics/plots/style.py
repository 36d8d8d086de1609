"""How the pictures look: colours that a colour-blind reader can tell apart, greys for the arm, sizes for a column."""

from __future__ import annotations

import math
from importlib.util import find_spec
from typing import Any, Final

from ..errors import missing_extra

COLUMN: Final = 3.35
"""Width of a column of text [in]: 85 mm."""
PAGE: Final = 7.0
"""Width of a page of text [in]: 178 mm."""
LABEL_SIZE, TICK_SIZE, SMALL_SIZE = 8.0, 7.0, 6.5
VIEW: Final = (24.0, -58.0)
"""Elevation and azimuth from which a space arm is seen [deg]."""


def require_matplotlib() -> None:
    """Raises MissingExtraError (KS400) where matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        raise missing_extra("matplotlib", "plot", "drawing a picture")


def new_figure(width: float, height: float) -> Any:
    """A figure of its own [in]: pyplot does not know of it, so that it goes when its last user does."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=150)


def round_number(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return min((step * power for step in (1, 2, 5, 10)), key=lambda step: abs(math.log(step / value)))


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is no larger."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9))


def with_unit(value: float, unit: str) -> str:
    """A number of three digits, and its unit."""
    return f"{float(f'{value:.3g}'):g} {unit}"
