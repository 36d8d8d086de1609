"""Where on the paper axes go: inside a rectangle, with their numbers and names, below their key. Measured, not guessed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array
from ..palette import TEXT
from .style import TICK_SIZE, round_number

TALLEST = 3.3
"""Of a figure of one column [in], its key aside."""
_PAD = 0.05  # white at the rim of a place [in]
_ROUNDS, _CLEAR = 9, 1.0  # of moving names and measuring again, at most; white around a name [points]
_GAP = 3.0  # by which the name of an axis is moved off its numbers, until it clears them [points]


@dataclass
class Place:
    """What is known of axes that have been drawn in.

    Attributes:
        own: whether they were made here, and may be moved and dressed.
        rectangle: left, bottom, width, height that they may fill, as shares of the figure.
        alone: whether the figure was made for them, and may be cut to their height.
        held: (2, k) corners of what has been drawn in them [m], or None.
        step: from number to number of axes of space [m].
    """

    own: bool = False
    rectangle: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)
    alone: bool = False
    held: Array | None = None
    step: float = 1.0


def place_of(ax: Any) -> Place:
    """The place of axes; it stays with them."""
    if not hasattr(ax, "_kinestatics_place"):
        ax._kinestatics_place = Place()
    return ax._kinestatics_place


def wrong_axes(ax: Any) -> ArrayTypeError:
    """The error for what nothing can be drawn into."""
    hint = "pass matplotlib axes, a figure to draw into, or nothing"
    return ArrayTypeError("KS302", f"ax is a {type(ax).__name__}; expected matplotlib axes", hint)


def draw_key(ax: Any, **options: Any) -> Any:
    """The key above axes, of all that is labelled in them, bars first; None where there is nothing."""
    from matplotlib.container import Container

    handles, labels = ax.get_legend_handles_labels()
    if not labels:
        return None
    order = sorted(range(len(labels)), key=lambda k: not isinstance(handles[k], Container))
    handles, labels = [handles[k] for k in order], [labels[k] for k in order]
    style = {"frameon": False, "fontsize": TICK_SIZE, "labelcolor": TEXT, "handlelength": 1.4, "labelspacing": 0.25}
    rims = {"borderaxespad": 0.0, "borderpad": 0.1}
    return ax.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.02), **style, **rims, **options)


def _rectangle(ax: Any, place: Place) -> Any:
    """The place on paper [pixels], without a rim."""
    from matplotlib.transforms import Bbox

    whole = Bbox.from_bounds(*place.rectangle).transformed(ax.figure.transSubfigure)
    return whole.padded(-_PAD * ax.figure.dpi)


def _move(ax: Any, x: float, y: float, width: float, height: float) -> None:
    """Axes to a rectangle on paper [pixels]."""
    from matplotlib.transforms import Bbox

    ax.set_position(Bbox.from_bounds(x, y, width, height).transformed(ax.figure.transSubfigure.inverted()))


def _key_height(ax: Any) -> float:
    """Room for the key above axes [pixels]."""
    key = ax.get_legend()
    return 0.0 if key is None else float(key.get_window_extent().height) + _PAD * ax.figure.dpi


def _move_key(ax: Any, room: Any) -> None:
    """The key to the upper left corner of the place."""
    if (key := ax.get_legend()) is not None:
        key.set_loc("upper left")
        paper = ax.figure.transSubfigure
        key.set_bbox_to_anchor(paper.inverted().transform((room.x0, room.y1)), paper)


def settle(ax: Any, place: Place, height: float | None = None) -> None:
    """Flat axes, their numbers and names into their place; `height` [in] of the axes' own part of a figure made for them."""
    from matplotlib.transforms import Bbox

    if not place.own:
        return
    figure = ax.figure.figure  # of a subfigure, the whole; get_figure(root=True) is newer than the oldest matplotlib we take
    if place.alone and height is not None:
        figure.set_figheight(height + _key_height(ax) / ax.figure.dpi)
    room = _rectangle(ax, place)
    _move_key(ax, room)
    inner = Bbox.from_extents(room.x0, room.y0, room.x1, room.y1 - _key_height(ax))
    edges = np.array(inner.extents)
    for _ in range(2):
        _move(ax, edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1])
        seen = ax.get_tightbbox(bbox_extra_artists=ax.texts)
        edges = edges + np.array(inner.extents) - np.array(seen.extents)
    _move(ax, edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1])


def fill(ax: Any, place: Place, extent: Array) -> None:
    """Axes of space into their place: matplotlib leaves much white around them. `extent` (3) of their limits."""
    figure = ax.figure.figure
    room, above = _rectangle(ax, place), _key_height(ax)
    width, height = room.width, TALLEST * ax.figure.dpi if place.alone else room.height - above
    side, zoom = max(width, height), 1.0
    for step in range(_ROUNDS):
        if step and not (_thin_numbers(ax, place) or _clear_names(ax)) and step > 2:
            break
        ax.set_box_aspect(extent, zoom=zoom)
        _move(ax, room.x0, room.y0, side, side)
        measure(ax)
        seen = _seen(ax)
        zoom *= min(width / seen.width, height / seen.height)
    if place.alone:
        figure.set_figheight((seen.height + above) / ax.figure.dpi + 2 * _PAD)
        room = _rectangle(ax, place)
    x = room.x0 + (room.width - seen.width) / 2 - (seen.x0 - room.x0)
    y = room.y0 + (room.height - above - seen.height) / 2 - (seen.y0 - room.y0)
    _move(ax, x, y, side, side)
    _move_key(ax, room)


def measure(ax: Any) -> None:
    """Lets matplotlib find out where everything in these axes lies; the others of the figure are left out meanwhile."""
    figure = ax.figure.figure
    others = [other for other in figure.axes if other is not ax and other.get_visible()]
    try:
        for other in others:
            other.set_visible(False)
        figure.draw_without_rendering()
    finally:
        for other in others:
            other.set_visible(True)


def _seen(ax: Any) -> Any:
    """The rectangle on paper [pixels] of what is seen of axes of space: their box, numbers, names and words."""
    from matplotlib.transforms import Bbox

    from .artists import projected

    corners = np.array([(x, y, z) for x in ax.get_xlim() for y in ax.get_ylim() for z in ax.get_zlim()])
    box = ax.transData.transform(projected(ax, corners)[:, [0, 1]])
    boxes = [Bbox([box.min(axis=0), box.max(axis=0)])]
    boxes += [axis.get_tightbbox() for axis in (ax.xaxis, ax.yaxis, ax.zaxis)]
    boxes += [box_of(ax, text) for text in ax.texts]
    return Bbox.union(boxes)


def box_of(ax: Any, text: Any) -> Any:
    """The rectangle on paper [pixels] of words of axes."""
    if not hasattr(text, "get_position_3d"):
        return text.get_window_extent()
    from .artists import projected

    # outside of drawing, matplotlib takes two of their three coordinates for a place on paper
    place = projected(ax, np.array([text.get_position_3d()]))[0, [0, 1]]
    moved = text.get_transform().transform(place) - text.get_transform().transform(text.get_position())
    return text.get_window_extent().translated(*moved)


def fixed_boxes(ax: Any, moving: set[Any]) -> Array:
    """(b, 2, 2) rectangles on paper [pixels] of numbers, names, key and words of axes, but for those that are moved."""
    axes = list(ax._axis_map.values())
    found = _numbers(ax) + [label.get_window_extent() for label in (ax.title, *(axis.label for axis in axes))]
    found += [box_of(ax, text) for text in ax.texts if text not in moving]
    if (key := ax.get_legend()) is not None:
        found.append(key.get_window_extent())
    return np.array([box.get_points() for box in found if box.width > 0]).reshape(-1, 2, 2)


def room_of(ax: Any, place: Place) -> Array:
    """(2, 2) rectangle on paper [pixels] for words: the place of axes made here, else the axes, inside the figure."""
    from matplotlib.transforms import Bbox

    inner = _rectangle(ax, place) if place.own else ax.bbox
    whole = ax.figure.figure.bbox
    room = Bbox.intersection(inner, whole.padded(-_PAD * ax.figure.dpi)) or whole
    return np.asarray(room.get_points())


def _numbers(ax: Any) -> list[Any]:
    """The rectangles on paper [pixels] of the numbers that are seen; of axes of space, as they were last measured."""
    found = []
    for axis in ax._axis_map.values():
        if ax.name != "3d":
            axis.get_ticklabels()  # finds their places; in space it would lose them
        lower, upper = sorted(axis.get_view_interval())
        rim = 1e-9 * (upper - lower)
        ticks = [tick for tick in axis.get_major_ticks() if lower - rim <= tick.get_loc() <= upper + rim]
        found += [tick.label1.get_window_extent() for tick in ticks if tick.label1.get_text()]
    return found


def _thin_numbers(ax: Any, place: Place) -> bool:
    """Makes the numbers of the axes of space fewer where two of them touch; whether they were."""
    from matplotlib.ticker import MultipleLocator

    boxes = [box.padded(_CLEAR * ax.figure.dpi / 72) for box in _numbers(ax)]
    if not any(a.overlaps(b) for a, b in combinations(boxes, 2)):
        return False
    place.step = round_number(2.2 * place.step)  # from 1 to 2 to 5 to 10
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(place.step))
    return True


def _clear_names(ax: Any) -> bool:
    """Moves the names of the axes of space farther out where they lie on their numbers; whether any was moved."""
    numbers, moved = _numbers(ax), False
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        name = axis.label.get_window_extent().padded(_CLEAR * ax.figure.dpi / 72)
        if any(name.overlaps(number) for number in numbers):
            axis.labelpad += _GAP
            moved = True
    return moved
