"""Axes of three dimensions, for arms that move in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..namespaces import Array
from ..palette import GRID, TEXT
from .canvas import TOP, WORDS, Canvas, halo
from .layout import fill, measure
from .style import LABEL_SIZE, SMALL_SIZE, TICK_SIZE


class Space(Canvas):
    """Axes of three dimensions."""

    dimensions = 3
    box: Array

    def __init__(self, ax: Any) -> None:
        super().__init__(ax)
        self.numbers = 3.0 if self.place.own else 2.0  # where we lay out the axes, numbers that touch are made fewer
        if not self.place.own and self.place.held is None and ax.has_data():  # somebody's picture stays in sight
            self.place.held = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()]).T

    def lines(self, lines: Sequence[Array], layer: float, **style: Any) -> None:
        """Lines through points (k, 3)."""
        from .artists import SpaceLines

        named = {"color": "colors", "linewidth": "linewidths", "linestyle": "linestyles"}
        options = {named.get(name, name): value for name, value in style.items()}
        caps = {"capstyle": options.pop("solid_capstyle", "butt")}
        for line in lines:
            self._add(SpaceLines([line], layer, **options, **caps))

    def solid(self, points: Array, layer: float, faces: Sequence[Sequence[int]] = (), **style: Any) -> None:
        """The outline of a convex body, and its near faces."""
        from .artists import SpaceSolid

        self._add(SpaceSolid(points, layer, faces, **style))

    def faces(self, faces: Sequence[Array], layer: float, **style: Any) -> None:
        """Flat faces."""
        from .artists import SpaceFaces

        self._add(SpaceFaces(faces, layer, **style))

    def arrow(self, start: Array, end: Array, layer: float, width: float, head: float, color: str) -> None:
        """An arrow."""
        from .artists import SpaceArrow

        self._add(SpaceArrow(start, end, layer, width, head, facecolor=color, edgecolor="none"))

    def cross(self, point: Array, color: str) -> None:
        """A cross of fixed size on paper: not this."""
        x, y, z = point
        self.ax.plot([x], [y], [z], "x", ms=6.5, mec=color, mew=1.4, zorder=1e5)

    def _add(self, artist: Any) -> None:
        artist.set_clip_on(False)
        self.ax.add_collection(artist, autolim=False)

    def text(self, point: Array, words: str, offset: tuple[float, float], size: float = SMALL_SIZE, **style: Any) -> Any:
        """Words beside a point, displaced on paper [points]."""
        options = WORDS | {"path_effects": halo()} | style
        return self.ax.text(*point, words, fontsize=size, zorder=1e6, transform=self._moved(offset), **options)

    def _moved(self, offset: tuple[float, float]) -> Any:
        """Where things are seen, and so many points aside."""
        from matplotlib.transforms import ScaledTranslation

        return self.ax.transData + ScaledTranslation(offset[0] / 72, offset[1] / 72, self.ax.figure.dpi_scale_trans)

    def fit(self, points: Array) -> None:
        """Limits around everything, one scale for the three axes."""
        lower, upper, step = self.extent(points)
        for k, name in enumerate("xyz"):
            getattr(self.ax, f"set_{name}lim")(lower[k], upper[k])
        self.box = upper - lower
        self.ax.set_box_aspect(self.box)
        self._dress(step)

    def _dress(self, step: float) -> None:
        """Thin grey axes with few numbers, at the same step on each."""
        from matplotlib.ticker import MultipleLocator

        self.place.step = step
        for name, axis in zip("xyz", (self.ax.xaxis, self.ax.yaxis, self.ax.zaxis), strict=True):
            axis.set_label_text(f"{name} [m]", fontsize=LABEL_SIZE, color=TEXT)
            axis.set_major_locator(MultipleLocator(step))
            if self.place.own:
                axis.labelpad = -5.0
                axis.set_tick_params(labelsize=TICK_SIZE, pad=0.5 if name == "z" else -2.5, colors=TEXT)
                axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
                axis.pane.set_edgecolor(GRID)
                axis.line.set(color=GRID, linewidth=0.6)
                axis._axinfo["grid"].update(color=GRID, linewidth=0.5)
                axis._axinfo["tick"].update(inward_factor=0.0, outward_factor=0.15, color=GRID)

    def finish(self) -> Any:
        """As for all; and the picture fills the place it has."""
        super().finish()
        if self.place.own:
            fill(self.ax, self.place, self.box)
        if self.names or self.letters:
            measure(self.ax)
            self.place_words()
        return self.ax

    def paper(self, points: Array) -> Array:
        """Where points are seen."""
        from .artists import projected

        flat = projected(self.ax, np.asarray(points, dtype=float).reshape(-1, 3))[:, [0, 1]]
        return flat.reshape(*points.shape[:-1], 2)

    def move(self, text: Any, by: Array) -> None:
        """Moves words on paper [points]."""
        text.set_transform(self._moved((float(by[0]), float(by[1]))))

    def leader(self, point: Array, move: Array, **style: Any) -> None:
        """A line from a point to words beside it."""
        from .artists import SpaceLeader

        named = {"color": "colors", "linewidth": "linewidths"}
        self._add(SpaceLeader(point, move, TOP, **{named.get(name, name): value for name, value in style.items()}))
