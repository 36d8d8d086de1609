"""The solids of a robot's links, from the visual shapes of its file; what cannot be had is told."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import KinestaticsError, KinestaticsWarning
from ..model import RobotModel
from ..namespaces import Array
from ..palette import LINK, rgb
from ..robots.visuals import Visual, visuals
from ..spatial import split_pose
from .simple_shapes import triangles_of

_TOLD = 3
"""Shapes that cannot be drawn are told one by one up to this many."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles of one colour.

    Attributes:
        link: that carries them; vertices: (k, 3) in its axes [m]; faces: (m, 3) rows of vertices.
        color: red, green, blue, 0 to 255; opacity: 1 for what cannot be seen through.
    """

    link: str
    vertices: Array
    faces: Array
    color: tuple[int, int, int]
    opacity: float = 1.0


def solids_of(model: RobotModel, package_roots: Sequence[Path | str] = ()) -> list[Solid]:
    """Every visual shape of a robot as triangles in the axes of its link; none where its file has none.

    Warns:
        KinestaticsWarning: what is missing or cannot be read. The rest is drawn.
    """
    seen = visuals(model, package_roots)
    problems = [str(finding) for finding in seen.findings]
    found: list[Solid] = []
    for visual in seen.shapes:
        try:
            found += _solids(visual)
        except KinestaticsError as error:
            problems.append(str(error))
    for problem in problems[:_TOLD]:
        warnings.warn(problem, KinestaticsWarning, stacklevel=3)
    if len(problems) > _TOLD:
        more = f"{len(problems) - _TOLD} more shapes of robot {model.name!r} cannot be drawn"
        warnings.warn(more, KinestaticsWarning, stacklevel=3)
    return found


def _solids(visual: Visual) -> list[Solid]:
    """One for each colour of a shape. A mesh's own colours go before that of the robot's file, as in RViz."""
    R, p = split_pose(visual.T_link_visual)
    found = []
    for color, mesh in triangles_of(visual).by_color():
        own = None if color is None else tuple(part / 255 for part in color)
        red, green, blue, opacity = own or visual.color or (*(part / 255 for part in rgb(LINK)), 1.0)
        vertices = np.asarray(mesh.vertices, dtype=np.float64) @ R.T + p
        shade = (round(255 * red), round(255 * green), round(255 * blue))
        found.append(Solid(visual.link, vertices, mesh.faces, shade, float(opacity)))
    return found
