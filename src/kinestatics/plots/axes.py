"""The axes a picture goes into: those given, new ones in a figure given, or new ones in a new figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..errors import ConfigurationError
from ..model import RobotModel
from ..skeleton import plane_of
from .canvas import Canvas, Flat
from .layout import Place, wrong_axes
from .space import Space
from .style import COLUMN, VIEW, new_figure, require_matplotlib


@dataclass(frozen=True)
class Cell:
    """A place in a figure of several pictures: left, bottom, width, height, as shares of it."""

    figure: Any
    rectangle: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)


def canvas_for(model: RobotModel, ax: Any, view: tuple[float, float] | None = None) -> Canvas:
    """The canvas for an arm: `ax` may be axes, a figure to draw into, or None for a new figure.

    Raises:
        MissingExtraError: KS400; ArrayTypeError: KS302 for something else; ConfigurationError: KS380 for flat axes and
        an arm that moves in space.
    """
    plane = plane_of(model)
    if not is_axes(ax):
        axes = new_axes(ax, COLUMN, None if plane is not None else "3d")
        if plane is not None:
            return Flat(axes, plane)
        axes.set_proj_type("ortho")
        elevation, azimuth = VIEW if view is None else _checked_view(view)
        axes.view_init(elev=elevation, azim=azimuth)
        axes.patch.set_visible(False)  # pictures side by side may reach into each other's corners
        return Space(axes)
    if ax.name == "3d":
        return Space(ax)
    if plane is None:
        hint = "leave ax out, pass a figure, or figure.add_subplot(projection='3d')"
        raise ConfigurationError("KS380", f"robot {model.name!r} moves in space, and the axes given are flat", hint)
    return Flat(ax, plane)


def _checked_view(view: Any) -> tuple[float, float]:
    """Elevation and azimuth [deg]; KS383 for anything else."""
    try:
        elevation, azimuth = (float(angle) for angle in view)
    except (TypeError, ValueError):
        raise ConfigurationError("KS383", f"view is {view!r}", "(elevation, azimuth) in degrees") from None
    return elevation, azimuth


def is_axes(ax: Any) -> bool:
    """Whether this is matplotlib axes, and not a figure, a cell or nothing."""
    require_matplotlib()
    from matplotlib.axes import Axes

    return isinstance(ax, Axes)


def new_axes(ax: Any, height: float, projection: str | None = None) -> Any:
    """New axes in a cell, in a figure, or in a new figure of one column's width and a height [in]."""
    from matplotlib.figure import FigureBase

    alone = ax is None
    cell = Cell(new_figure(COLUMN, height)) if alone else ax if isinstance(ax, Cell) else Cell(ax)
    if not isinstance(cell.figure, FigureBase):
        raise wrong_axes(ax)
    axes: Any = cell.figure.add_axes(cell.rectangle, projection=projection)
    axes._kinestatics_place = Place(True, cell.rectangle, alone)
    return axes
