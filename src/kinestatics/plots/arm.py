"""`arm`: an arm at a posture, drawn as textbooks do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UnknownNameError
from ..frames import TIP
from ..model import RobotModel
from ..namespaces import Array
from ..palette import EDGE, FACE, FRAME, GROUND, LINK
from ..skeleton import DrawnJoint, Skeleton, one_configuration, skeleton
from .axes import canvas_for
from .canvas import ARM, BACK, SIGN, Canvas, Flat

if TYPE_CHECKING:
    from matplotlib.axes import Axes

JOINT, WIDE, FRAME_LENGTH = 0.027, 0.085, 0.13
"""Radius and length of a joint's sign, and length of a frame's axes, as a share of the arm's size."""


def arm(
    model: RobotModel,
    q: Any = None,
    *,
    ax: Any = None,
    at: str = TIP,
    frames: bool | str = "tip",
    labels: bool | str | Sequence[str] = False,
    view: tuple[float, float] | None = None,
) -> Axes:
    """An arm at a posture: links, joints by their kind, the ground and the frame of the tip, at true scale.

    Arms whose joints all move in one plane are drawn in it, as circles (turning) and squares (sliding); others in space,
    as cylinders about the axis of turning and boxes along the direction of sliding. Trees are drawn with all branches.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        ax: axes to draw into, or a figure to add them to; default a new figure of one column's width (85 mm).
        at: link whose frame is drawn.
        frames: "tip" for the frame of `at`; True for those of base and joints too; False for none.
        labels: True or "names" for the joints' names; "numbers" for 1 to n, their columns; or texts, one for each column.
            Joints at one place of the picture share a label ("joint4-6"); labels keep off each other and off the arm, with
            a thin line to the joint where they are far from it.
        view: elevation and azimuth of space axes [deg].

    Returns:
        The axes, in metres of the base frame. A new figure is not pyplot's: `ax.figure.savefig("arm.pdf")`, or draw into
        one of pyplot's with `ax=plt.figure()`.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS303, KS301 for q, KS380 for flat axes and an arm of space;
        ArrayTypeError: KS302; UnknownNameError: KS310 for a link, KS381 for frames or labels.

    Law: every point drawn is where `pose` says it is; one metre is as long along every axis.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics import plots
        >>> ax = plots.arm(ks.load("planar_2r"), [0.4, 0.9])
        >>> ax.get_xlabel()
        'x [m]'
    """
    bones = skeleton(model, one_configuration(model, q), at)
    words = _labels(model, bones, labels)
    check_frames(frames)
    canvas = canvas_for(model, ax, view)
    draw_arm(canvas, bones, frames, words)
    return canvas.finish()


def check_frames(frames: Any) -> None:
    """Raises UnknownNameError (KS381) unless it is a word for which frames to draw."""
    if frames is not True and frames is not False and frames != "tip":
        raise UnknownNameError("KS381", f"frames={frames!r} is not known", "say 'tip', True for all, or False")


def draw_arm(canvas: Canvas, bones: Skeleton, frames: bool | str = "tip", labels: Sequence[str] = ()) -> None:
    """The arm on a canvas: ground, links, joints, frames, labels."""
    canvas.hold(bones.points)
    if isinstance(canvas, Flat):
        _flat_ground(canvas, bones.size)
    else:
        _space_ground(canvas, bones.size)
    canvas.lines(bones.links, ARM, color=LINK, linewidth=2.6, solid_capstyle="round")
    canvas.avoided += [*bones.links, *bones.rods]
    canvas.lines(bones.rods, ARM, color=EDGE, linewidth=1.3, solid_capstyle="round")
    for joint in bones.joints:
        _draw_joint(canvas, joint, bones.size)
    if frames is True:
        for R, p in ((np.eye(3), np.zeros(3)), *bones.frames):
            _draw_frame(canvas, R, p, 0.6 * FRAME_LENGTH * bones.size, named=False)
    if frames and bones.tip is not None:
        _draw_frame(canvas, *bones.tip, FRAME_LENGTH * bones.size, named=True)
    for joint, word in zip(bones.joints, labels, strict=False):
        canvas.name(joint.point, word)


def _labels(model: RobotModel, bones: Skeleton, labels: Any) -> tuple[str, ...]:
    """One word for every moving joint drawn."""
    if labels is False:
        return ()
    if labels is True or labels == "names":
        return tuple(joint.name for joint in bones.joints)
    columns = tuple(str(k + 1) for k in range(model.n)) if labels == "numbers" else labels
    if isinstance(columns, str) or len(columns) != model.n:
        hint = f"say True, 'names', 'numbers' or False, or give {model.n} texts"
        raise UnknownNameError("KS381", f"labels={labels!r} is not known", hint)
    return tuple(str(columns[joint.column]) for joint in bones.joints)


def across(direction: Array) -> tuple[Array, Array]:
    """Two unit vectors at right angles to a direction and to each other."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(direction, helper)
    first = first / np.linalg.norm(first)
    return first, np.cross(direction, first)


def _draw_joint(canvas: Canvas, joint: DrawnJoint, size: float) -> None:
    style: dict[str, Any] = {"facecolor": FACE, "edgecolor": EDGE, "linewidth": 0.8}
    first, second = across(joint.direction)
    radius, half = JOINT * size, 0.5 * WIDE * size
    extents = half * joint.direction, 1.2 * radius * first, 1.2 * radius * second
    canvas.avoided += [np.array([joint.point - extent, joint.point + extent]) for extent in extents]
    if not isinstance(canvas, Flat):
        canvas.avoided += _edges(joint.point, extents)
    if isinstance(canvas, Flat) and joint.kind != "prismatic":
        canvas.disc(joint.point, ARM + 1, 6.5, markerfacecolor=FACE, markeredgecolor=EDGE, markeredgewidth=0.9)
        return
    if joint.kind == "prismatic":
        signs = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
        corners = [joint.point + half * a * joint.direction + 1.15 * radius * (b * first + c * second) for a, b, c in signs]
        faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
        canvas.solid(np.array(corners), ARM + 1, faces, **style)
        return
    turns = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    ring = radius * (np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * second)
    ends = [joint.point + side * half * joint.direction + ring for side in (-1, 1)]
    canvas.solid(np.concatenate(ends), ARM + 1, (range(32), range(32, 64)), **style)


def _edges(middle: Array, extents: tuple[Array, ...]) -> list[Array]:
    """(2, 3) the twelve edges of a box about a point, given half of its extents."""
    edges = []
    for k in range(3):
        others = [extents[j] for j in range(3) if j != k]
        corners = [middle + a * others[0] + b * others[1] for a in (-1, 1) for b in (-1, 1)]
        edges += [np.array([corner - extents[k], corner + extents[k]]) for corner in corners]
    return edges


def _draw_frame(canvas: Canvas, R: Array, p: Array, length: float, named: bool) -> None:
    """The axes of a frame: arrows for x, y, z; where one points at the reader of a flat picture, a ring."""
    for k, name in enumerate("xyz"):
        end = p + length * R[:, k]
        canvas.arrow(p, end, SIGN, width=0.9, head=4.5, color=FRAME)
        canvas.hold(end)
        canvas.avoided.append(np.array([p, end]))
        if named and not (isinstance(canvas, Flat) and abs(float(R[:, k] @ canvas.normal)) > 0.99):
            canvas.letter(p + 1.22 * length * R[:, k], name)


def _flat_ground(canvas: Flat, size: float) -> None:
    """A bracket on hatched ground below the base's origin."""
    right, up = canvas.plane
    foot, wide = -0.07 * size * up, 0.055 * size
    canvas.lines([np.array([foot - wide * right, np.zeros(3), foot + wide * right])], BACK, color=EDGE, linewidth=0.9)
    ground = np.array([foot - 1.7 * wide * right, foot + 1.7 * wide * right])
    strokes = [
        np.array([foot + x * wide * right, foot + (x - 0.45) * wide * right - 0.5 * wide * up])
        for x in np.linspace(-1.25, 1.7, 7)
    ]
    canvas.lines([ground], BACK, color=EDGE, linewidth=0.9)
    canvas.lines(strokes, BACK, color=GROUND, linewidth=0.6)
    canvas.avoided += [*strokes, ground, np.array([foot - wide * right, np.zeros(3), foot + wide * right])]
    canvas.hold(np.array([*ground, *(stroke[1] for stroke in strokes)]))


def _space_ground(canvas: Canvas, size: float) -> None:
    """A hatched square in the base's xy plane, at its origin."""
    half = 0.11 * size
    square = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float)
    canvas.lines([square], BACK, color=GROUND, linewidth=0.7)
    strokes = []
    for c in np.linspace(-1.5, 1.5, 7):
        low, high = max(-1.0, c - 1.0), min(1.0, c + 1.0)
        strokes.append(half * np.array([[low, c - low, 0], [high, c - high, 0]]))
    canvas.lines(strokes, BACK, color=GROUND, linewidth=0.5)
    canvas.avoided += [*strokes, square]
    canvas.hold(square)
