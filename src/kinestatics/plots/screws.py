"""`lost_and_free`: the motions an arm has lost and the wrenches its structure holds, as lines in the picture."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis import Analysis, analyze
from ..frames import TIP
from ..model import RobotModel
from ..namespaces import Array
from ..palette import FORCE, VELOCITY
from ..screws_in_words import Screw
from ..skeleton import Skeleton, one_configuration
from .arm import across
from .canvas import SIGN, Canvas, Flat
from .shapes import begin
from .signs import double_arrow, turning_arrow
from .style import COLUMN

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_REACH, _RADIUS, _BESIDE = 0.34, 0.09, 0.07
"""Half a line, the radius of a circular arrow, and how far apart two signs stand, as shares of the arm's size."""
_FAR = 1.0  # share of the arm's size; an axis farther from the tip is drawn as what it amounts to at the tip
_IN_WORDS, _LETTERS = 4, 16.5  # entries of the key that are told in words; letters of it on an inch


def lost_and_free(
    model: RobotModel,
    q: Any = None,
    *,
    task: str | Sequence[str] | Sequence[int] = "auto",
    ax: Any = None,
    at: str = TIP,
    with_arm: bool = True,
    frames: bool | str = False,
    view: tuple[float, float] | None = None,
) -> Axes:
    """What a posture has lost, and what it holds without any joint torque.

    Lost motions are dashed, in the colour of velocities, and crossed: an arrow for a translation, an axis with a circular
    arrow for a rotation or screw. Free wrenches are solid, in the colour of forces: the line of a force through its point, a
    circular arrow for a couple. A translation and a couple belong to no point, and are drawn a little beside the tip. An
    axis that passes the tip at more than the arm's reach is drawn as what it amounts to at the tip, a translation and a
    rotation, or a force and a moment; the key says so.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        task: rows in play, as in `kinestatics.analyze`.
        ax, at, frames, view: as in `arm`.
        with_arm: whether the arm is drawn too.

    Returns:
        The axes. The key says the same in words; with many entries, how many of each kind.

    Raises: as in `arm` and `kinestatics.analyze`.

    Law: Jᵀ w = 0 for the free wrenches, which do no work on any motion the arm has left. Source: note 000.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.lost_and_free(ks.load("planar_2r"), [0.0, 0.0])
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['no velocity along x of base', 'held for free: force along x of base, through the\\norigin of tip']
    """
    found = analyze(model, one_configuration(model, q), task=task, at=at)
    canvas, bones, _ = begin(model, q, ax, at, with_arm, frames, view)
    draw_screws(canvas, bones, found)
    return canvas.finish()


def draw_screws(canvas: Canvas, bones: Skeleton, found: Analysis) -> None:
    """Lost twists and free wrenches of an analysis, and their entries in the key."""
    size, tip = bones.size, bones.tip_point
    for screw in found.lost_twists:
        along = _REACH * size * screw.direction
        if screw.point is None:
            _lost_translation(canvas, bones, screw.direction)
        elif _is_far(screw, size):
            _lost_translation(canvas, bones, _unit(_moment(screw)))
            _lost_rotation(canvas, tip, along, size)
        else:
            _lost_rotation(canvas, tip + screw.point, along, size)
    for screw in found.free_wrenches:
        center = tip if screw.point is None or _is_far(screw, size) else tip + screw.point
        if screw.point is not None:
            double_arrow(canvas, center, 1.25 * _REACH * size * screw.direction, FORCE)
        if screw.kind != "force" or _is_far(screw, size):
            about = screw.direction if center is not tip or screw.point is None else _unit(_moment(screw))
            turning_arrow(canvas, center + 0.5 * _REACH * size * about, about, 0.8 * _RADIUS * size, FORCE)
    _key(canvas, found, size)


def _lost_translation(canvas: Canvas, bones: Skeleton, direction: Array) -> None:
    """A dashed, crossed arrow, a little beside the tip."""
    middle = bones.tip_point + _BESIDE * bones.size * _aside(canvas, direction)
    along = _REACH * bones.size * direction
    double_arrow(canvas, middle, along, VELOCITY, dashed=True)
    canvas.cross(middle + 0.5 * along, VELOCITY)


def _lost_rotation(canvas: Canvas, middle: Array, along: Array, size: float) -> None:
    """A dashed axis and a crossed circular arrow about it."""
    ends = np.array([middle - along, middle + along])
    canvas.hold(ends)
    canvas.lines([ends], SIGN, color=VELOCITY, linewidth=0.9, linestyle=(0, (4.0, 1.6)))
    canvas.cross(turning_arrow(canvas, middle, _unit(along), _RADIUS * size, VELOCITY, dashed=True), VELOCITY)


def _is_far(screw: Screw, size: float) -> bool:
    """Whether an axis lies so far from the tip that the arm would be a speck beside it."""
    return screw.point is not None and float(np.linalg.norm(screw.point)) > _FAR * size


def _moment(screw: Screw) -> Array:
    """Of a unit force along the axis about the tip; of a unit rotation, the velocity of the tip [m]."""
    point = np.zeros(3) if screw.point is None else screw.point
    return np.cross(point, screw.direction) + screw.pitch * screw.direction


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _aside(canvas: Canvas, direction: Array) -> Array:
    """A unit vector at right angles to a direction: in the picture's plane, or as far up as it goes."""
    if isinstance(canvas, Flat):
        aside = np.cross(canvas.normal, direction)
    else:
        up = np.array([0.0, 0.0, 1.0])
        aside = up - direction * float(up @ direction)
    length = float(np.linalg.norm(aside))
    return aside / length if length > 0.1 else across(direction)[0]


def _key(canvas: Canvas, found: Analysis, size: float) -> None:
    width = canvas.place.rectangle[2] * canvas.ax.figure.figure.get_figwidth() if canvas.place.own else COLUMN
    letters = max(int(_LETTERS * (width - 0.35)), 20)
    lost: dict[str, Any] = {"color": VELOCITY, "linewidth": 1.3, "linestyle": (0, (2.6, 1.6))}
    free: dict[str, Any] = {"color": FORCE, "linewidth": 1.3}
    if not (found.lost_twists or found.free_wrenches):
        canvas.key(f"nothing is lost: rank {found.rank} of {found.task.rank}", linestyle="none")
    elif len(found.lost_twists) + len(found.free_wrenches) <= _IN_WORDS:
        for screw in found.lost_twists:
            canvas.key(textwrap.fill(screw.text, letters), **lost)
        for screw in found.free_wrenches:
            canvas.key(textwrap.fill(f"held for free: {screw.text}", letters), **free)
    else:
        canvas.key(f"lost: {_counted(found.lost_twists)}", **lost)
        canvas.key(f"held for free: {_counted(found.free_wrenches)}", **free)
    if any(_is_far(screw, size) for screw in (*found.lost_twists, *found.free_wrenches)):
        canvas.key("far axes are drawn as what they amount to at the tip", linestyle="none")


def _counted(screws: Sequence[Screw]) -> str:
    counts = Counter(str(screw.kind) for screw in screws)
    plural = {"wrench": "wrenches"}
    return ", ".join(f"{n} {kind if n == 1 else plural.get(kind, kind + 's')}" for kind, n in counts.items())
