"""Artists of space: lines, solids and arrows that know their depth, whatever axes they are put into. Imports matplotlib.

Each is projected when it is drawn, so that a picture may be turned. A solid is drawn as the outline of its points: one
polygon where a surface of facets would take hundreds, and no seams between them in a vector file.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.transforms import IdentityTransform
from mpl_toolkits.mplot3d import proj3d  # type: ignore[import-untyped]

from ..namespaces import Array
from .outlines import arrow_outline, hull


def projected(ax: Any, points: Array) -> Array:
    """(k, 3) points of space as (k, 3): where they are seen, and how deep."""
    x, y, z = proj3d.proj_transform(*np.asarray(points).T, ax.M)
    return np.array([x, y, z]).T


def _arrow_on_paper(arrow: Any, ends: Array) -> Array:
    """The outline of an arrow between two points of its axes (2, 2), in pixels."""
    start, end = arrow.axes.transData.transform(ends)
    pixels = arrow.axes.figure.dpi / 72
    return arrow_outline(start, end, arrow.width * pixels, arrow.head * pixels)


class SpaceLines(LineCollection):
    """Lines through points of space; `points` (list of (k, 3)) stays as given."""

    def __init__(self, points: Sequence[Array], layer: float, **style: Any) -> None:
        self.points, self.layer = [np.asarray(line) for line in points], layer
        super().__init__([line[:, [0, 1]] for line in self.points], **style)

    def do_3d_projection(self) -> float:
        """Projects the lines; returns their depth, near ones smaller."""
        seen = [projected(self.axes, line) for line in self.points]
        self.set_segments([line[:, [0, 1]] for line in seen])
        return float(np.mean([line[:, 2].mean() for line in seen])) - self.layer


class SpaceSolid(PolyCollection):
    """The outline of a convex body, and those of its flat faces that are seen from here.

    `points` (k, 3) span the body; `faces` are lists of their indices, drawn where they lie nearer than its middle.
    """

    def __init__(self, points: Array, layer: float, faces: Sequence[Sequence[int]] = (), **style: Any) -> None:
        self.points, self.faces, self.layer = np.asarray(points), [list(face) for face in faces], layer
        super().__init__([hull(self.points[:, [0, 1]])], **style)

    def do_3d_projection(self) -> float:
        """Projects the body; returns its depth, near ones smaller."""
        seen = projected(self.axes, self.points)
        depth = float(seen[:, 2].mean())
        near = [face for face in self.faces if seen[face, 2].mean() < depth]
        self.set_verts([hull(seen[:, [0, 1]]), *(seen[face][:, [0, 1]] for face in near)])
        return depth - self.layer


class SpaceFaces(PolyCollection):
    """Flat faces of space, the far ones drawn first; for bodies one sees through. `faces` is a list of (k, 3)."""

    def __init__(self, faces: Sequence[Array], layer: float, **style: Any) -> None:
        self.points, self.layer = [np.asarray(face) for face in faces], layer
        super().__init__([face[:, [0, 1]] for face in self.points], **style)

    def do_3d_projection(self) -> float:
        """Projects the faces; returns their depth, near ones smaller."""
        seen = sorted((projected(self.axes, face) for face in self.points), key=lambda face: -float(face[:, 2].mean()))
        self.set_verts([face[:, [0, 1]] for face in seen])
        return float(np.mean([face[:, 2].mean() for face in seen])) - self.layer


class SpaceArrow(PolyCollection):
    """An arrow from a point of space to another, with a shaft and a head of fixed size on paper [points]."""

    def __init__(self, start: Array, end: Array, layer: float, width: float, head: float, **style: Any) -> None:
        self.points, self.layer = np.array([start, end]), layer
        self.width, self.head = width, head
        super().__init__([np.zeros((3, 2))], transform=IdentityTransform(), **style)

    def do_3d_projection(self) -> float:
        """Projects the two ends and draws the arrow between them; returns its depth."""
        seen = projected(self.axes, self.points)
        self.set_verts([_arrow_on_paper(self, seen[:, [0, 1]])])
        return float(seen[:, 2].mean()) - self.layer


def _leader_on_paper(leader: Any, place: Array) -> Array:
    """From a place (2) of the axes of a leader line to its end, in pixels."""
    start = leader.axes.transData.transform(place)
    return np.array([start, start + leader.move * leader.axes.figure.dpi / 72])


class SpaceLeader(LineCollection):
    """A line from a point of space to words beside it, `move` (2) [points] on paper."""

    def __init__(self, point: Array, move: Array, layer: float, **style: Any) -> None:
        self.point, self.move, self.layer = np.asarray(point), np.asarray(move), layer
        super().__init__([np.zeros((2, 2))], transform=IdentityTransform(), **style)

    def do_3d_projection(self) -> float:
        """Projects the point and draws the line from it; returns its depth."""
        seen = projected(self.axes, self.point[None])[0]
        self.set_segments([_leader_on_paper(self, seen[[0, 1]])])
        return float(seen[2]) - self.layer


class FlatLeader(LineCollection):
    """The same in the plane: `point` (2) in data coordinates."""

    def __init__(self, point: Array, move: Array, **style: Any) -> None:
        self.point, self.move = np.asarray(point), np.asarray(move)
        super().__init__([np.zeros((2, 2))], transform=IdentityTransform(), **style)

    def draw(self, renderer: Any) -> None:
        """Draws the line from where its point lies on paper now."""
        self.set_segments([_leader_on_paper(self, self.point)])
        super().draw(renderer)


class FlatArrow(PolyCollection):
    """The same in the plane: `points` (2, 2) in data coordinates."""

    def __init__(self, start: Array, end: Array, width: float, head: float, **style: Any) -> None:
        self.points = np.array([start, end])
        self.width, self.head = width, head
        super().__init__([np.zeros((3, 2))], transform=IdentityTransform(), **style)

    def draw(self, renderer: Any) -> None:
        """Draws the arrow between its ends as they lie on paper now."""
        self.set_verts([_arrow_on_paper(self, self.points)])
        super().draw(renderer)
