"""Signs at the tip: ellipsoids, polytopes, arrows, lost motions, free wrenches. Each is made once, and then changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bodies import Body, ellipsoid_body, polytope_body
from ..dexterity import Ellipsoid, Polytope
from ..namespaces import Array
from ..palette import rgb
from ..screws_in_words import Screw
from .placing import quaternions, turned_to

_OPAQUE, _LINE = 0.28, 1.5
_THIN = 3e-3  # of the arm's size: as thick as a flat body is drawn
_CUT = 0.45  # of the arm's size: where a direction without end is cut
_REACH, _RADIUS, _BESIDE, _FAR = 0.3, 0.09, 0.05, 1.0
"""Half a line, the radius of a turning arrow and how far a translation stands beside the tip, as shares of the arm's size;
an axis farther from the tip than this is drawn as what it amounts to at the tip."""
_TURN = np.linspace(0.0, 1.6 * np.pi, 25)


class ConvexBody:
    """An ellipsoid or a polytope at the tip, in the colour of its kind."""

    def __init__(self, scene: Any, name: str, color: str, size: float) -> None:
        self._size = size
        self._place = scene.add_frame(f"/{name}/ellipsoid", show_axes=False)
        self._ball = scene.add_icosphere(
            f"/{name}/ellipsoid/ball",
            1.0,
            rgb(color),
            subdivisions=4,
            opacity=_OPAQUE,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._circles = scene.add_line_segments(
            f"/{name}/ellipsoid/circles", _unit_circles(), rgb(color), thickness=_LINE, thickness_units="screen"
        )
        self._mesh = scene.add_mesh_simple(
            f"/{name}/polytope",
            np.zeros((3, 3)),
            np.array([[0, 1, 2]]),
            color=rgb(color),
            opacity=_OPAQUE,
            side="double",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._edges = scene.add_line_segments(
            f"/{name}/edges", np.zeros((1, 2, 3)), rgb(color), thickness=_LINE, thickness_units="screen"
        )
        self.hide()

    def hide(self) -> None:
        """Shows nothing."""
        for handle in (self._ball, self._circles, self._mesh, self._edges):
            handle.visible = False

    def ellipsoid(self, ellipsoid: Ellipsoid, tip: Array, metres: float) -> None:
        """Shows an ellipsoid of linear rows, `metres` per unit; where it is unbounded, its lines, cut."""
        bounded = bool(np.all(np.isfinite(ellipsoid.radii)))
        self._ball.visible = self._circles.visible = bounded
        self._mesh.visible, self._edges.visible = False, not bounded
        lift = _lift(ellipsoid.rows)
        if not bounded:
            self._lines(ellipsoid_body(ellipsoid.axes, ellipsoid.radii, _CUT * self._size / metres), lift, tip, metres)
            return
        axes = _completed(lift.T @ ellipsoid.axes)
        radii = np.concatenate([metres * ellipsoid.radii, np.zeros(3 - len(ellipsoid.radii))])
        scale, wxyz = tuple(np.maximum(radii, _THIN * self._size).tolist()), quaternions(axes)
        self._place.wxyz, self._place.position = wxyz, tip
        self._ball.scale = self._circles.scale = scale

    def polytope(self, polytope: Polytope, tip: Array, metres: float) -> None:
        """Shows a polytope of linear rows, `metres` per unit; where it is unbounded, its edges, cut."""
        self.hide()
        if polytope.is_empty:
            return
        lift = _lift(polytope.rows)
        body = polytope_body(polytope, _CUT * self._size / metres)
        if body.faces:
            self._mesh.vertices = tip + metres * np.concatenate(body.faces) @ lift
            self._mesh.faces = _fans([len(face) for face in body.faces])
            self._mesh.visible = True
        self._lines(body, lift, tip, metres)

    def _lines(self, body: Body, lift: Array, tip: Array, metres: float) -> None:
        """The lines and edges of a body; what goes on without end is dashed."""
        curves = [*body.lines, *body.faces]
        pieces = [np.stack([curve[:-1], curve[1:]], 1) for curve in curves]
        pieces += [_dashes(line) for line in body.fading]
        self._edges.visible = bool(pieces)
        if pieces:
            self._edges.points = (tip + metres * np.concatenate(pieces) @ lift).astype(np.float32)


def _lift(rows: Sequence[str]) -> Array:
    """(k, 3) the axes of base along which linear rows such as "vx" or "fz" are."""
    return np.eye(3)[["xyz".index(row[-1]) for row in rows]]


def _completed(axes: Array) -> Array:
    """(3, 3) right-handed axes that begin with these columns (3, k)."""
    k = axes.shape[1]
    if k < 3:
        u, _, _ = np.linalg.svd(axes, full_matrices=True)
        axes = np.concatenate([axes, u[:, k:]], axis=1)
    return axes * [1.0, 1.0, np.sign(np.linalg.det(axes))]


def _unit_circles(count: int = 72) -> Array:
    """(k, 2, 3) the circles of a unit sphere in its three planes."""
    turns = 2 * np.pi * np.arange(count + 1) / count
    plane = np.stack([np.cos(turns), np.sin(turns), 0 * turns], -1)
    circles = [np.roll(plane, k, axis=-1) for k in range(3)]
    return np.concatenate([np.stack([circle[:-1], circle[1:]], 1) for circle in circles])


def _fans(counts: Sequence[int]) -> Array:
    """Triangles of closed polygons whose corners, the first again at the end, follow each other."""
    found, start = [], 0
    for count in counts:
        found += [(start, start + k, start + k + 1) for k in range(1, count - 2)]
        start += count
    return np.array(found, dtype=np.uint32).reshape(-1, 3)


def _dashes(line: Array, count: int = 5) -> Array:
    """(count, 2, 3) a line with gaps."""
    start, along = line[0], line[1] - line[0]
    at = np.arange(count) / count
    return np.stack([start + np.outer(at, along), start + np.outer(at + 0.5 / count, along)], 1)


@dataclass(frozen=True, eq=False)
class Strokes:
    """What a sign is drawn with: lines (k, 2, 3) and arrows (m, 2, 3) [m], in base axes."""

    lines: Array
    arrows: Array


class StrokeSign:
    """Lines and arrows of one colour, in a scene."""

    def __init__(self, scene: Any, name: str, color: str, size: float) -> None:
        zero = np.zeros((1, 2, 3))
        thick = {"shaft_radius": 0.006 * size, "head_radius": 0.016 * size, "head_length": 0.045 * size}
        self._arrows = scene.add_arrows(f"/{name}/arrows", zero, rgb(color), **thick)
        self._lines = scene.add_line_segments(f"/{name}/lines", zero, rgb(color), thickness=3.0, thickness_units="screen")
        self.show(None)

    def show(self, strokes: Strokes | None) -> None:
        """Shows strokes, or nothing."""
        self._arrows.visible = strokes is not None and len(strokes.arrows) > 0
        self._lines.visible = strokes is not None and len(strokes.lines) > 0
        if strokes is not None and len(strokes.arrows):
            self._arrows.points = strokes.arrows.astype(np.float32)
        if strokes is not None and len(strokes.lines):
            self._lines.points = strokes.lines.astype(np.float32)


def lost_strokes(screws: Sequence[Screw], tip: Array, size: float) -> Strokes | None:
    """Lost motions: dashed axes with a turning arrow for a rotation, a double arrow beside the tip for a translation."""
    lines, arrows = [], []
    for screw in screws:
        turns = screw.point is not None
        if not turns or _is_far(screw, size):
            direction = _unit(_at_tip(screw)) if turns else screw.direction
            aside = turned_to(direction)[:, 0] * _BESIDE * size
            arrows += _double(tip + aside, _REACH * size * direction)
        if turns:
            center = tip if _is_far(screw, size) else tip + screw.point
            along = _REACH * size * screw.direction
            lines.append(_dashes(np.array([center - along, center + along]), 9))
            arc, head = _turning(center + 0.6 * along, screw.direction, _RADIUS * size)
            lines.append(arc)
            arrows.append(head)
    return _strokes(lines, arrows)


def free_strokes(screws: Sequence[Screw], tip: Array, size: float) -> Strokes | None:
    """Free wrenches: the line of a force with an arrow at both ends, a turning arrow for a couple."""
    lines, arrows = [], []
    for screw in screws:
        has_force = screw.point is not None
        center = tip + screw.point if screw.point is not None and not _is_far(screw, size) else tip
        if has_force:
            arrows += _double(center, 1.2 * _REACH * size * screw.direction)
        if screw.kind != "force" or _is_far(screw, size):
            about = _unit(_at_tip(screw)) if has_force and _is_far(screw, size) else screw.direction
            arc, head = _turning(center + 0.5 * _REACH * size * about, about, 0.8 * _RADIUS * size)
            lines.append(arc)
            arrows.append(head)
    return _strokes(lines, arrows)


def arrow_strokes(tip: Array, force: Array, torque: Array, metres: float, size: float) -> Strokes | None:
    """A wrench at a point: its force as an arrow from there, its torque as a turning arrow about its axis."""
    lines: list[Array] = []
    arrows: list[Array] = []
    if np.any(force):
        arrows.append(np.array([tip, tip + metres * force]))
    if np.any(torque):
        about = _unit(torque)
        arc, head = _turning(tip + 0.12 * size * about, about, 1.2 * _RADIUS * size)
        lines.append(arc)
        arrows.append(head)
    return _strokes(lines, arrows)


def together(several: Sequence[Strokes | None]) -> Strokes | None:
    """Signs of one colour as one."""
    seen = [strokes for strokes in several if strokes is not None]
    return _strokes([strokes.lines for strokes in seen], [arrow for strokes in seen for arrow in strokes.arrows])


def _strokes(lines: list[Array], arrows: list[Array]) -> Strokes | None:
    if not lines and not arrows:
        return None
    return Strokes(np.concatenate([np.zeros((0, 2, 3)), *lines]), np.array(arrows).reshape(-1, 2, 3))


def _double(center: Array, along: Array) -> list[Array]:
    return [np.array([center, center + along]), np.array([center, center - along])]


def _turning(center: Array, about: Array, radius: float) -> tuple[Array, Array]:
    """An arc (k, 2, 3) about an axis, and the arrow (2, 3) at its end."""
    frame = turned_to(about)
    circle = center + radius * (np.outer(np.cos(_TURN), frame[:, 0]) + np.outer(np.sin(_TURN), frame[:, 1]))
    onward = radius * (np.cos(_TURN[-1]) * frame[:, 1] - np.sin(_TURN[-1]) * frame[:, 0])
    return np.stack([circle[:-1], circle[1:]], 1), np.array([circle[-1], circle[-1] + 0.55 * onward])


def _is_far(screw: Screw, size: float) -> bool:
    """Whether an axis lies so far from the tip that the arm would be a speck beside it."""
    return screw.point is not None and float(np.linalg.norm(screw.point)) > _FAR * size


def _at_tip(screw: Screw) -> Array:
    """Of a unit force along the axis, the moment about the tip; of a unit rotation, the velocity of the tip [m]."""
    point = np.zeros(3) if screw.point is None else screw.point
    return np.cross(point, screw.direction) + screw.pitch * screw.direction


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
