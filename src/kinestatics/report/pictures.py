"""The pictures of an analysis: the arm with its ellipsoids, polytopes, lost motions and loads, as SVG with captions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ..analysis import Analysis
from ..bodies import Body, ellipsoid_body, polytope_body
from ..dexterity import Ellipsoid, Polytope, force_polytope, velocity_polytope
from ..errors import KinestaticsError
from ..model import RobotModel
from ..namespaces import Array
from ..palette import FORCE, VELOCITY
from ..plots.arm import draw_arm
from ..plots.screws import draw_screws
from ..plots.shapes import clip_length, draw_body, metres_per_unit
from ..plots.torques import draw_loads
from ..quantities import format_number
from ..skeleton import Skeleton, skeleton
from ..spatial import LINEAR_ROWS
from ..statics import applied_loads
from ..tasks import model_of
from .blocks import Html, bullets, escaped, figure, tag
from .canvas import Entry, Svg, canvas_of

_AXES = np.eye(3)


class Picture(NamedTuple):
    """A picture of an arm.

    Attributes:
        title: what it is; svg: the picture itself, with its description inside; entries: of its key.
    """

    title: str
    svg: Html
    entries: tuple[Entry, ...]

    def figure(self) -> Html:
        """The picture with its title and key."""
        caption = [tag("strong", self.title), bullets(map(_entry, self.entries), kind="key")]
        return figure(self.svg, caption, kind="picture-card")


def _entry(entry: Entry) -> Html:
    """Words of a key behind a line in their colour."""
    kind = {VELOCITY: "motion", FORCE: "force"}.get(entry.color, "")
    line = tag("i", None, class_=f"line {kind}{' dashed' * entry.dashed}", aria_hidden="true") if kind else None
    return escaped([line, entry.words])


def arm_picture(model: RobotModel, q: Array, at: str, names: bool = False) -> Picture:
    """The arm alone, its joints numbered where `names` asks for it."""
    bones = skeleton(model, q, at)
    canvas = canvas_of(model)
    labels = tuple(str(joint.column + 1) for joint in bones.joints) if names else ()
    draw_arm(canvas, bones, "tip" if bones.tip is not None else False, labels)
    return _finished(canvas, "The arm", f"{_of(model)} at this posture", [])


def pictures_of(a: Analysis) -> Iterator[Picture]:
    """Those that this analysis has something to show in, the ellipsoids first."""
    model = model_of(a.jacobian)
    bones = skeleton(model, a.configuration, a.tip, required=True)
    for found in (a.velocity_ellipsoid, a.force_ellipsoid):
        if found is not None and _is_linear(found.rows):
            yield _of_ellipsoid(model, bones, found)
    if a.lost_twists or a.free_wrenches:
        yield _of_screws(model, bones, a)
    for polytope in _polytopes(model, a):
        yield _of_polytope(model, bones, polytope)
    if a.loads:
        yield _of_loads(model, bones, a)


def _is_linear(rows: tuple[str, ...]) -> bool:
    """Whether the coordinates are along axes of space: velocities or forces, which a picture of space can show."""
    return all(row[0] in "vf" for row in rows)


def _begun(model: RobotModel, bones: Skeleton) -> Svg:
    canvas = canvas_of(model)
    draw_arm(canvas, bones)
    return canvas


def _of(model: RobotModel) -> str:
    return f"{model.name}: links, joints and the frame of the tip"


def _finished(canvas: Svg, title: str, description: str, entries: list[Entry]) -> Picture:
    return Picture(title, canvas.finish(description), tuple(entries))


def _of_ellipsoid(model: RobotModel, bones: Skeleton, found: Ellipsoid) -> Picture:
    finite = found.radii[np.isfinite(found.radii)]
    metres = metres_per_unit(None, float(finite.max(initial=0.0)), bones, len(finite) == len(found.radii))
    body = ellipsoid_body(found.axes, found.radii, clip_length(bones, metres))
    radii = ", ".join("without end" if np.isinf(r) else f"{format_number(r)} {found.unit}" for r in found.radii)
    bound = "joint speeds" if found.kind == "velocity" else "joint torques"
    what = f"What {bound} of size 1 amount to at {found.link}; half-axes {radii}"
    return _of_body(model, bones, body, found.rows, metres, found.kind, f"{found.kind.capitalize()} ellipsoid", what)


def _of_polytope(model: RobotModel, bones: Skeleton, found: Polytope) -> Picture:
    title = f"{found.kind.capitalize()} polytope"
    if found.is_empty:
        words = "Empty: the arm cannot hold its own weight within its effort limits"
        canvas = _begun(model, bones)
        return _finished(canvas, title, f"{_of(model)}. {words}", [Entry(words, FORCE)])
    corners = np.zeros((0, 3)) if found.corners is None else found.corners
    largest = float(np.linalg.norm(corners, axis=-1).max(initial=0.0))
    metres = metres_per_unit(None, largest, bones, found.is_bounded)
    body = polytope_body(found, clip_length(bones, metres))
    if found.kind == "velocity":
        what = "All velocities of the tip while no joint is faster than its limit"
    else:
        what = (
            "All forces the tip can push with, the arm's weight taken off, while no joint needs more than its effort limit"
        )
    return _of_body(model, bones, body, found.rows, metres, found.kind, title, what)


def _of_body(
    model: RobotModel, bones: Skeleton, body: Body, rows: tuple[str, ...], metres: float, kind: str, title: str, what: str
) -> Picture:
    """A body of velocities or forces at the tip; `metres` of the picture for each unit."""
    canvas, color = _begun(model, bones), VELOCITY if kind == "velocity" else FORCE
    draw_body(canvas, bones, body, _AXES[["xyz".index(row[-1]) for row in rows]], metres, kind, "")
    scale = f"1 m of the picture is {format_number(1.0 / metres)} {'m/s' if kind == 'velocity' else 'N'}"
    entries = [Entry(what, color)]
    if body.fading or np.ptp(body.points, axis=0).any():
        entries.append(Entry(scale + ("; dashed: without end, held by the structure" if body.fading else "")))
    else:
        entries.append(Entry("a point: nothing is possible"))
    words = ". ".join([_of(model), what, *(entry.words for entry in entries[1:])])
    return _finished(canvas, title, words, entries)


def _polytopes(model: RobotModel, a: Analysis) -> Iterator[Polytope]:
    """Of velocity and force, in the linear rows in play, where the limits are known."""
    rows = [row for row in a.task.rows if row in LINEAR_ROWS]
    if not rows:
        return
    with suppress(KinestaticsError):  # a limit is unknown; a note says so
        yield velocity_polytope(model, a.configuration, task=rows, at=a.tip)
    with suppress(KinestaticsError):
        yield force_polytope(model, a.configuration, task=rows, at=a.tip, gravity=tuple(a.gravity))


def _of_screws(model: RobotModel, bones: Skeleton, a: Analysis) -> Picture:
    canvas = _begun(model, bones)
    draw_screws(canvas, bones, a)
    entries = [entry._replace(words=entry.words[:1].upper() + entry.words[1:]) for entry in canvas.entries]
    words = ". ".join([_of(model), *(entry.words for entry in entries)])
    return _finished(canvas, "Lost motions and free wrenches", words, entries)


def _of_loads(model: RobotModel, bones: Skeleton, a: Analysis) -> Picture:
    canvas = canvas_of(model)
    draw_arm(canvas, bones, frames=False)
    loads = applied_loads(model, [(load.link, load.wrench) for load in a.loads])
    draw_loads(canvas, model, a.configuration, bones, loads)
    words = ". ".join([_of(model), *(entry.words for entry in canvas.entries)])
    return _finished(canvas, "Loads", words, canvas.entries)
