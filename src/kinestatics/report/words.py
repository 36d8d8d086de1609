"""Units and words that several sections share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis import Analysis, Margin
from ..quantities import format_number
from .blocks import with_minus

_LEAST_SHARE = 5e-5  # below, a share of a limit is none


def joint_unit(kind: str) -> str:
    """Of a joint's position."""
    return "m" if kind == "prismatic" else "rad"


def rate_unit(kind: str) -> str:
    """Of a joint's speed."""
    return f"{joint_unit(kind)}/s"


def effort_unit(kind: str) -> str:
    """Of what drives a joint."""
    return "N" if kind == "prismatic" else "N m"


def joint_value(x: float, kind: str) -> str:
    """A position with its unit, and in degrees where the joint turns."""
    if not np.isfinite(x):
        return "none"
    degrees = "" if kind == "prismatic" else f" ({format_number(round(float(np.degrees(x)), 2))}°)"
    return with_minus(f"{format_number(x)}\u00a0{joint_unit(kind)}{degrees}")


def margin_words(margin: Margin, kind: str) -> str:
    """How far a joint is from its nearest limit."""
    amount = joint_value(abs(margin.distance), kind)
    if margin.distance < 0:
        return f"outside its {margin.limit} limit by {amount}"
    if margin.locked:
        return "locked: its limits leave it one position"
    return f"{amount} from its {margin.limit} limit" if margin.distance > 0 else f"at its {margin.limit} limit"


def kinds_of(a: Analysis) -> dict[str, str]:
    """Joint names and their kinds."""
    return dict(zip(a.joints, a.kinds, strict=True))


def listed(words: Sequence[str]) -> str:
    """Words in a sentence: "a, b and c"."""
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)


def percent(share: float) -> str:
    """A share of a limit."""
    if np.isinf(share):
        return "over any"
    return f"{100 * share if share >= _LEAST_SHARE else 0:.3g}\u00a0%"


def counted(n: int, word: str) -> str:
    """ "1 joint", "2 joints"."""
    return f"{n} {word}{'s' * (n != 1)}"
