"""The colours of every picture, page and scene: a colour-blind reader can tell them apart. Floor 1."""

from __future__ import annotations

from typing import Final

VELOCITY: Final = "#0072B2"
"""Blue of Okabe and Ito: everything that moves."""
FORCE: Final = "#D55E00"
"""Vermilion of Okabe and Ito: everything that pushes."""
LINK, EDGE, FACE, GROUND, TEXT, FRAME = "#8c8c8c", "#4d4d4d", "#f2f2f2", "#9a9a9a", "#262626", "#333333"
GRID, GRAVITY = "#e3e3e3", "#bdbdbd"


def rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of "#rrggbb".

    Example:
        >>> rgb(VELOCITY)
        (0, 114, 178)
    """
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
