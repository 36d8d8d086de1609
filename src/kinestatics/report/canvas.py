"""Pictures of an arm as SVG: the canvas of `plots`, drawn without a drawing library, light and ready for a page.

The same arms, ellipsoids and signs are drawn on it as on paper. What it writes is small, the same on every run, and in
classes, so that a style sheet can turn it for a dark page; colours and widths stand in it too, so that it needs none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..model import RobotModel
from ..namespaces import Array
from ..palette import EDGE, FACE, FORCE, FRAME, GRAVITY, GRID, GROUND, LINK, TEXT, VELOCITY
from ..plots.canvas import TOP, Canvas, Flat
from ..plots.layout import Place
from ..plots.outlines import arrow_outline, hull
from ..plots.style import VIEW, round_down
from ..skeleton import plane_of
from .blocks import Html, tag

WIDTH = 300.0
"""Of a picture, in units of its own: points, when it is printed 106 mm wide."""
_RIM, _FOOT = 12.0, 26.0  # white around the arm, and the height of the line below it
_HEIGHTS = (130.0, 290.0)  # of the arm's part
_BAR = 0.3  # of the width: the longest scale
_TRIAD = 13.0  # length of the base's axes
_LETTER = 8.5  # size of letters
_NAMES = {
    VELOCITY: "motion",
    FORCE: "force",
    LINK: "link",
    EDGE: "edge",
    FACE: "face",
    GROUND: "ground",
    TEXT: "ink",
    FRAME: "ink",
    GRID: "grid",
    GRAVITY: "weight",
    "white": "paper",
}
Draw = Callable[[Callable[[Array], Array]], Html]


class Entry(NamedTuple):
    """An entry of the key: words, and the line that they explain; no colour where they stand alone."""

    words: str
    color: str = ""
    dashed: bool = False


def _outline(points: Array, style: dict[str, Any], closed: bool = False) -> Draw:
    """A path through points that are seen (k, 2) [m], in a style."""

    def draw(at: Callable[[Array], Array]) -> Html:
        return tag("path", d=_path(at(points), closed), **style)

    return draw


class Svg(Canvas):
    """A canvas that collects what is drawn on it, and writes it as one element.

    Attributes:
        entries: of the key, for the caption.
    """

    def __init__(self) -> None:
        self.place = Place()
        self.held: list[Array] = []
        self.avoided: list[Array] = []
        self.entries: list[Entry] = []
        self._items: list[tuple[float, float, Draw]] = []

    def see(self, points: Array) -> Array:
        """(..., 3) in base axes → (..., 2) to the right and up [m]."""
        raise NotImplementedError

    def nearness(self, points: Array) -> float:
        """How near to the reader points are."""
        del points
        return 0.0

    def _add(self, layer: float, near: float, draw: Draw) -> None:
        self._items.append((layer, near, draw))

    def lines(self, lines: Sequence[Array], layer: float, **style: Any) -> None:
        """Lines through points, (k, 3) each."""
        paint = _stroke(style)
        for line in lines:
            self._add(layer, self.nearness(line), _outline(self.see(np.asarray(line)), {"fill": "none", **paint}))

    def solid(self, points: Array, layer: float, faces: Sequence[Sequence[int]] = (), **style: Any) -> None:
        """The outline of a convex body, and its near faces."""
        points = np.asarray(points)
        self.hold(points)
        seen, middle = self.see(points), self.nearness(points)
        near = [] if isinstance(self, Flat) else [f for f in map(list, faces) if self.nearness(points[f]) > middle]
        outlines = [hull(seen), *(seen[face] for face in near)]
        self._shapes([shape for shape in outlines if len(shape) > 2], layer, middle, style)

    def faces(self, faces: Sequence[Array], layer: float, **style: Any) -> None:
        """Flat faces, the far ones first; in the plane, their common outline."""
        if isinstance(self, Flat):
            self.solid(np.concatenate(list(faces)), layer, **style)
            return
        ordered = sorted(faces, key=self.nearness)
        self._shapes([self.see(face) for face in ordered], layer, self.nearness(np.concatenate(ordered)), style)

    def _shapes(self, shapes: Sequence[Array], layer: float, near: float, style: dict[str, Any]) -> None:
        paint = {**_fill(style), **_stroke(style)}
        paint["class_"] = " ".join(sorted({*_fill(style)["class_"].split(), *_stroke(style)["class_"].split()})) or None
        for shape in shapes:
            self._add(layer, near, _outline(shape, paint, closed=True))

    def arrow(self, start: Array, end: Array, layer: float, width: float, head: float, color: str) -> None:
        """An arrow with a shaft and a head of fixed size."""
        ends = np.array([start, end])
        seen, paint = self.see(ends), _fill({"facecolor": color})

        def draw(at: Callable[[Array], Array]) -> Html:
            first, last = at(seen)
            return tag("path", d=_path(arrow_outline(first, last, width, head), True), **paint)

        self._add(layer, self.nearness(ends), draw)

    def cross(self, point: Array, color: str) -> None:
        """A cross of fixed size: not this."""
        seen, paint = self.see(np.asarray(point)[None]), _stroke({"color": color, "linewidth": 1.5})

        def draw(at: Callable[[Array], Array]) -> Html:
            x, y = at(seen)[0]
            return tag("path", d=f"M{x - 3:.1f} {y - 3:.1f}l6 6m0-6l-6 6", fill="none", **paint)

        self._add(TOP + 1, 0.0, draw)

    def text(self, point: Array, words: str, offset: tuple[float, float], size: float = _LETTER, **style: Any) -> Any:
        """Words beside a point."""
        del style
        seen = self.see(np.asarray(point)[None])

        def draw(at: Callable[[Array], Array]) -> Html:
            x, y = at(seen)[0]
            return _words(words, x + offset[0], y - offset[1], size)

        self._add(TOP + 2, 0.0, draw)

    def letter(self, point: Array, word: str) -> None:
        """A letter at a point."""
        self.text(point, word, (0.0, 0.0))

    def name(self, point: Array, words: str) -> None:
        """Words above a point."""
        self.text(point, words, (0.0, 9.0))

    def key(self, label: str, **style: Any) -> None:
        """An entry of the key, which goes into the caption."""
        line = style.get("linestyle", "-")
        self.entries.append(Entry(label.replace("\n", " "), "" if line == "none" else style.get("color", ""), _dashed(line)))

    def fit(self, points: Array) -> None:
        """Nothing: the picture is fitted when it is written."""

    def paper(self, points: Array) -> Array:
        """As `see`."""
        return self.see(points)

    def move(self, text: Any, by: Array) -> None:
        """Nothing: words stay where they were put."""

    def leader(self, point: Array, move: Array, **style: Any) -> None:
        """Nothing: words stay at their points."""

    def axes(self) -> list[tuple[str, Array]]:
        """The base's axes that are seen, with their letters: (2) unit lengths on paper."""
        seen = self.see(np.eye(3))
        return [(letter, along) for letter, along in zip("xyz", seen, strict=True) if float(np.hypot(*along)) > 0.15]

    def finish(self, description: str = "") -> Html:
        """The picture; `description` is what those hear who do not see it."""
        held = self.see(np.concatenate(self.held))
        lower, upper = held.min(axis=0), held.max(axis=0)
        extent = np.maximum(upper - lower, 1e-3 * max(float((upper - lower).max()), 1e-6))
        lowest, highest = _HEIGHTS
        scale = min((WIDTH - 2 * _RIM) / extent[0], (highest - 2 * _RIM) / extent[1])
        height = max(scale * float(extent[1]) + 2 * _RIM, lowest)
        middle, center = (lower + upper) / 2, np.array([WIDTH, height]) / 2

        def at(points: Array) -> Array:
            return center + scale * (points - middle) * (1.0, -1.0)

        order = sorted(range(len(self._items)), key=lambda k: (*self._items[k][:2], k))
        drawn = [self._items[k][2](at) for k in order]
        foot = [*_scale_bar(scale, height), *self._triad(height)]
        box = f"0 0 {WIDTH:g} {height + _FOOT:.4g}"
        return tag("svg", drawn, foot, viewBox=box, role="img", aria_label=description, class_="picture")

    def _triad(self, height: float) -> list[Html]:
        """The directions of the base's axes, in the lower left corner."""
        origin = np.array([_RIM + 8.0, height + _FOOT - 11.0])
        parts = []
        for letter, along in self.axes():
            end = origin + _TRIAD * along * (1.0, -1.0)
            paint = _fill({"facecolor": FRAME})
            parts.append(tag("path", d=_path(arrow_outline(origin, end, 0.7, 4.0), True), **paint))
            x, y = origin + (_TRIAD + 5.5) * along * (1.0, -1.0)
            parts.append(_words(letter, x, y, _LETTER))
        return parts


class FlatSvg(Svg, Flat):
    """For arms that move in a plane; `plane` (2, 3) holds the directions to the right and up."""

    def __init__(self, plane: Array) -> None:
        super().__init__()
        self.plane, self.normal = plane, np.cross(plane[0], plane[1])

    def see(self, points: Array) -> Array:
        """As `project`."""
        return self.project(points)

    def arrow(self, start: Array, end: Array, layer: float, width: float, head: float, color: str) -> None:
        """An arrow; one that points at the reader is a ring with a dot, one that points away a ring with a cross."""
        along = np.asarray(end, dtype=float) - start
        if float(np.hypot(*self.project(along))) < 1e-3 * float(np.linalg.norm(along)):
            self.towards(start, bool(along @ self.normal > 0), layer, color)
            return
        super().arrow(start, end, layer, width, head, color)

    def towards(self, point: Array, nearer: bool, layer: float, color: str) -> None:
        """The sign for a direction at right angles to the paper."""
        self.disc(point, layer, 6.0, markerfacecolor="white", markeredgecolor=color, markeredgewidth=0.9)
        if nearer:
            self.disc(point, layer + 0.1, 2.0, markerfacecolor=color, markeredgecolor=color, markeredgewidth=0.0)
            return
        seen, paint = self.project(np.asarray(point))[None], _stroke({"color": color, "linewidth": 0.9})

        def draw(at: Callable[[Array], Array]) -> Html:
            x, y = at(seen)[0]
            return tag("path", d=f"M{x - 2:.1f} {y - 2:.1f}l4 4m0-4l-4 4", fill="none", **paint)

        self._add(layer + 0.1, 0.0, draw)

    def disc(self, point: Array, layer: float, size: float, **style: Any) -> None:
        """A circle of a fixed size."""
        seen = self.project(np.asarray(point))[None]
        style = {"facecolor": style["markerfacecolor"], "edgecolor": style["markeredgecolor"]} | {
            "linewidth": style["markeredgewidth"]
        }
        paint = {**_fill(style), **_stroke(style)}
        paint["class_"] = f"{_fill(style)['class_']} {_stroke(style)['class_']}"

        def draw(at: Callable[[Array], Array]) -> Html:
            x, y = at(seen)[0]
            return tag("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=f"{size / 2:g}", **paint)

        self._add(layer, 0.0, draw)


class SpaceSvg(Svg):
    """For arms that move in space, seen in parallel from an elevation and an azimuth [deg]."""

    def __init__(self, view: tuple[float, float] = VIEW) -> None:
        super().__init__()
        elevation, azimuth = np.radians(view)
        self.toward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        self._paper = np.stack([right, np.cross(self.toward, right)])

    def see(self, points: Array) -> Array:
        """(..., 3) → (..., 2)."""
        return np.asarray(points, dtype=float) @ self._paper.T

    def nearness(self, points: Array) -> float:
        """Of their middle."""
        return float((np.asarray(points, dtype=float) @ self.toward).mean())


def canvas_of(model: RobotModel) -> Svg:
    """The canvas that an arm is drawn on: of its plane, or of space."""
    plane = plane_of(model)
    return SpaceSvg() if plane is None else FlatSvg(plane)


def _scale_bar(scale: float, height: float) -> list[Html]:
    """A stroke of a round length, and what it stands for, in the lower right corner."""
    metres = round_down(_BAR * WIDTH / scale)
    length, y = metres * scale, height + _FOOT - 8.0
    x = WIDTH - _RIM - length
    stroke = _stroke({"color": TEXT, "linewidth": 1.0})
    words = f"{metres:g} m" if 1e-3 <= metres < 1e4 else f"{metres:.0e} m"
    bar = tag("path", d=f"M{x:.1f} {y - 3:.1f}v6m0-3h{length:.1f}m0-3v6", fill="none", **stroke)
    return [bar, _words(words, x + length / 2, y - 8.0, _LETTER)]


def _path(points: Array, closed: bool = False) -> str:
    """The data of a path through points (k, 2)."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("Z" if closed else "")


def _words(words: str, x: float, y: float, size: float) -> Html:
    place = {"x": f"{x:.1f}", "y": f"{y + 0.35 * size:.1f}", "font_size": f"{size:g}", "text_anchor": "middle"}
    return tag("text", words, **place, fill=TEXT, class_="fill-ink halo")


def _dashed(style: Any) -> bool:
    return isinstance(style, tuple)


def _stroke(style: dict[str, Any]) -> dict[str, Any]:
    """Attributes of a line in the words of `plots`: color or edgecolor, linewidth, linestyle."""
    color, width = style.get("color", style.get("edgecolor", "none")), float(style.get("linewidth", 1.0))
    if color == "none" or not width:
        return {"class_": ""}
    found: dict[str, Any] = {"stroke": color, "stroke_width": f"{width:g}", "class_": f"stroke-{_NAMES.get(color, 'ink')}"}
    line = style.get("linestyle", "-")
    if _dashed(line):
        found["stroke_dasharray"] = " ".join(f"{width * part:.3g}" for part in line[1])
    if style.get("solid_capstyle") == "round":
        found["stroke_linecap"] = "round"
    return {**found, "stroke_linejoin": "round"}


def _fill(style: dict[str, Any]) -> dict[str, Any]:
    """Attributes of an area in the words of `plots`: facecolor, alpha."""
    color = style.get("facecolor", "none")
    if color == "none":
        return {"fill": "none", "class_": ""}
    return {"fill": color, "fill_opacity": style.get("alpha"), "class_": f"fill-{_NAMES.get(color, 'ink')}"}
