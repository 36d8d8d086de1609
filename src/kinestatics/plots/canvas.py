"""Where a picture is drawn: flat axes for arms that move in a plane, axes of space for the others, at true scale.

Both take points in base axes (k, 3) [m]; flat axes project them onto the arm's plane.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..namespaces import Array
from ..palette import EDGE, TEXT
from ..quantities import format_number
from .layout import draw_key, place_of, settle
from .style import LABEL_SIZE, SMALL_SIZE, TICK_SIZE, round_down
from .words import place_names

BACK, BODY, ARM, SIGN, TOP = 0.0, 10.0, 20.0, 30.0, 40.0
"""Layers, the lower behind the higher; within one, what is farther away is drawn first."""
WORDS: dict[str, Any] = {"color": TEXT, "ha": "center", "va": "center"}
_MARGIN = 0.07  # of the largest extent, on every side
_THIN = 0.3  # of it: the least extent of a picture, which may show a line


def halo() -> list[Any]:
    """A thin white rim, so that words are read on lines."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=1.4, foreground="white")]


class Canvas(ABC):
    """Axes, and how points of space (k, 3) are drawn in them."""

    dimensions, numbers = 0, 3.0
    """How many axes there are, and into how many steps the longest is divided at least."""

    def __init__(self, ax: Any) -> None:
        self.ax, self.place = ax, place_of(ax)
        self.held: list[Array] = []
        self.names: list[tuple[Any, Array]] = []
        self.letters: list[tuple[Any, Array]] = []
        self.avoided: list[Array] = []  # lines (k, 3) on which no words should lie

    @abstractmethod
    def lines(self, lines: Sequence[Array], layer: float, **style: Any) -> None:
        """Lines through points, (k, 3) each."""

    @abstractmethod
    def solid(self, points: Array, layer: float, faces: Sequence[Sequence[int]] = (), **style: Any) -> None:
        """The outline of a convex body, and in space its near faces: indices of points, in order around them."""

    @abstractmethod
    def faces(self, faces: Sequence[Array], layer: float, **style: Any) -> None:
        """Flat faces, (k, 3) each; in the plane, their common outline."""

    @abstractmethod
    def arrow(self, start: Array, end: Array, layer: float, width: float, head: float, color: str) -> None:
        """An arrow, its shaft and head of fixed size on paper [points]; of no width: a head alone."""

    @abstractmethod
    def cross(self, point: Array, color: str) -> None:
        """A cross of fixed size on paper: not this."""

    @abstractmethod
    def text(self, point: Array, words: str, offset: tuple[float, float], size: float = SMALL_SIZE, **style: Any) -> Any:
        """Words beside a point, displaced on paper [points]."""

    @abstractmethod
    def fit(self, points: Array) -> None:
        """Sets the limits so that everything drawn so far and these points are seen, and names the axes."""

    def hold(self, points: Array) -> None:
        """Makes room for points (k, 3)."""
        self.held.append(np.asarray(points, dtype=float).reshape(-1, 3))

    def key(self, label: str, **style: Any) -> None:
        """One entry of the key: a line in this style."""
        self.ax.plot(*([[]] * self.dimensions), label=label, **style)

    def name(self, point: Array, words: str) -> None:
        """Words that are put beside a point where there is room, once the picture has its place."""
        self.names.append((self.text(point, words, (0.0, 0.0)), point))

    def letter(self, point: Array, word: str) -> None:
        """A letter at a point, or where there is room near it."""
        self.letters.append((self.text(point, word, (0.0, 0.0)), point))

    @abstractmethod
    def paper(self, points: Array) -> Array:
        """(..., 3) → (..., 2): where points are seen, in what `ax.transData` takes."""

    @abstractmethod
    def move(self, text: Any, by: Array) -> None:
        """Moves words on paper [points]."""

    @abstractmethod
    def leader(self, point: Array, move: Array, **style: Any) -> None:
        """A line from a point to words beside it."""

    def place_words(self) -> None:
        """Names and letters to where there is room for them, with leader lines where that is not near."""
        if not (self.names or self.letters):
            return
        joints, ends = (np.array([point for _, point in some]).reshape(-1, 3) for some in (self.names, self.letters))
        pairs = [np.stack([line[:-1], line[1:]], axis=1) for line in self.avoided]
        segments = np.concatenate(pairs) if pairs else np.zeros((0, 2, 3))
        named, lettered = place_names(
            self.ax,
            self.place,
            [text for text, _ in self.names],
            self.paper(joints),
            [text for text, _ in self.letters],
            self.paper(ends),
            self.paper(segments),
        )
        for k, by, line in named:
            self.move(self.names[k][0], by)
            if line is not None:
                self.leader(self.names[k][1], line, color=EDGE, linewidth=0.5)
        for (text, _), by in zip(self.letters, lettered, strict=True):
            self.move(text, by)

    def extent(self, points: Array) -> tuple[Array, Array, float]:
        """Corners of everything held by these axes, now and before, with a margin; and a step for their numbers."""
        if self.place.held is not None:
            points = np.concatenate([self.place.held, points])
        self.place.held = np.array([points.min(axis=0), points.max(axis=0)])
        lower, upper = self.place.held
        largest = float((upper - lower).max()) or 1.0
        thin = np.maximum(_THIN * largest - (upper - lower), 0.0) / 2
        margin = thin + _MARGIN * largest
        return lower - margin, upper + margin, round_down(largest / self.numbers)

    def finish(self) -> Any:
        """Sets limits, true scale, labels and key; returns the axes."""
        self.fit(np.concatenate(self.held) if self.held else np.zeros((1, 3)))
        draw_key(self.ax)
        return self.ax


class Flat(Canvas):
    """Axes of two dimensions; plane (2, 3) holds the directions to the right and up, in base axes."""

    dimensions = 2
    proportion = 1.0

    def __init__(self, ax: Any, plane: Array) -> None:
        super().__init__(ax)
        self.plane = plane
        self.normal = np.cross(plane[0], plane[1])

    def project(self, points: Array) -> Array:
        """(..., 3) → (..., 2)."""
        return np.asarray(points, dtype=float) @ self.plane.T

    def lines(self, lines: Sequence[Array], layer: float, **style: Any) -> None:
        """Lines through points (k, 3)."""
        for line in lines:
            x, y = self.project(line).T
            self.ax.plot(x, y, zorder=3 + layer, **style)

    def solid(self, points: Array, layer: float, faces: Sequence[Sequence[int]] = (), **style: Any) -> None:
        """The outline of a convex body."""
        from matplotlib.patches import Polygon

        from .outlines import hull

        del faces
        corners = hull(self.project(points))
        if len(corners) > 2 and not _is_line(corners):
            self.ax.add_patch(Polygon(corners, closed=True, zorder=3 + layer, **style))

    def faces(self, faces: Sequence[Array], layer: float, **style: Any) -> None:
        """Flat faces: in the plane, their common outline."""
        self.solid(np.concatenate(list(faces)), layer, **style)

    def arrow(self, start: Array, end: Array, layer: float, width: float, head: float, color: str) -> None:
        """An arrow; one that points at the reader is a circle with a dot, one that points away a circle with a cross."""
        from .artists import FlatArrow

        a, b = self.project(start), self.project(end)
        along = np.asarray(end, dtype=float) - start
        if np.hypot(*(b - a)) < 1e-3 * np.linalg.norm(along):
            self.towards(start, bool(along @ self.normal > 0), layer, color)
            return
        arrow = FlatArrow(a, b, width, head, facecolor=color, edgecolor="none", zorder=3 + layer)
        self.ax.add_collection(arrow, autolim=False)

    def towards(self, point: Array, nearer: bool, layer: float, color: str) -> None:
        """The sign for a direction at right angles to the paper."""
        x, y = self.project(point)
        self.ax.plot([x], [y], "o", ms=6, mfc="white", mec=color, mew=0.9, zorder=3 + layer)
        self.ax.plot([x], [y], "." if nearer else "x", ms=3.2, mfc=color, mec=color, mew=0.9, zorder=3.1 + layer)

    def cross(self, point: Array, color: str) -> None:
        """A cross of fixed size on paper: not this."""
        x, y = self.project(point)
        self.ax.plot([x], [y], "x", ms=6.5, mec=color, mew=1.4, zorder=3 + TOP)

    def disc(self, point: Array, layer: float, size: float, **style: Any) -> None:
        """A circle of a size on paper [points]."""
        x, y = self.project(point)
        self.ax.plot([x], [y], "o", ms=size, zorder=3 + layer, **style)

    def text(self, point: Array, words: str, offset: tuple[float, float], size: float = SMALL_SIZE, **style: Any) -> Any:
        """Words beside a point, displaced on paper [points]."""
        options = WORDS | {"path_effects": halo()} | style
        return self.ax.annotate(
            words, self.project(point), offset, textcoords="offset points", fontsize=size, zorder=60, **options
        )

    def fit(self, points: Array) -> None:
        """Limits around everything, one scale for both axes."""
        lower, upper, step = self.extent(self.project(points))
        self.ax.update_datalim([lower, upper])
        self.ax.margins(0.0)
        self.ax.set_aspect("equal", adjustable="datalim" if self.place.own else "box")
        self.ax.autoscale_view()
        self.proportion = float((upper - lower)[1] / (upper - lower)[0])
        for name, direction in zip(("x", "y"), self.plane, strict=True):
            getattr(self.ax, f"set_{name}label")(_axis_words(direction), fontsize=LABEL_SIZE, color=TEXT)
        if self.place.own:
            self._dress(step)

    def _dress(self, step: float) -> None:
        """Two thin axes with few numbers, at the same step on each."""
        from matplotlib.ticker import MultipleLocator

        self.ax.tick_params(labelsize=TICK_SIZE, colors=TEXT, width=0.6, length=2.5)
        for axis in (self.ax.xaxis, self.ax.yaxis):
            axis.set_major_locator(MultipleLocator(step))
        for side, spine in self.ax.spines.items():
            spine.set_visible(side in ("left", "bottom"))
            spine.set(linewidth=0.6, edgecolor=TEXT)

    def finish(self) -> Any:
        """As for all; and the picture fills the place it has."""
        super().finish()
        if self.place.own:
            settle(self.ax, self.place, float(np.clip(0.6 + 2.75 * self.proportion, 1.5, 3.4)))
        self.ax.apply_aspect()
        self.place_words()
        return self.ax

    def paper(self, points: Array) -> Array:
        """As `project`."""
        return self.project(points)

    def move(self, text: Any, by: Array) -> None:
        """Moves words on paper [points]."""
        text.set_position((float(by[0]), float(by[1])))

    def leader(self, point: Array, move: Array, **style: Any) -> None:
        """A line from a point to words beside it."""
        from .artists import FlatLeader

        self.ax.add_collection(FlatLeader(self.project(point), move, zorder=3 + TOP, **style), autolim=False)


def _is_line(corners: Array) -> bool:
    """Whether a polygon has no width that could be seen."""
    sigma = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    return bool(sigma[1] <= 1e-9 * sigma[0])


def _axis_words(direction: Array) -> str:
    for name, unit in zip("xyz", np.eye(3), strict=True):
        if np.allclose(direction, unit, rtol=0.0, atol=1e-9):
            return f"{name} [m]"
    return f"along ({', '.join(format_number(round(float(x), 3)) for x in direction)}) of the base [m]"
