"""`load` and `torque_bars`: what acts on an arm, and what its motors must supply to hold it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..analysis import Analysis
from ..frames import TIP
from ..kinematics import pose
from ..model import RobotModel
from ..namespaces import Array
from ..palette import EDGE, FORCE, GRAVITY, TEXT
from ..skeleton import Skeleton, one_configuration, skeleton
from ..spatial import ANGULAR, LINEAR
from ..statics import Load, Loads, applied_loads, gravity_torques, holding_torques, missing_masses
from .arm import draw_arm
from .axes import Cell, canvas_for, is_axes, new_axes
from .canvas import TOP, Canvas
from .layout import draw_key, place_of, settle
from .signs import turning_arrow
from .style import COLUMN, LABEL_SIZE, SMALL_SIZE, TICK_SIZE, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WITHOUT_WEIGHT = "without the arm's weight:\nno masses are known"
_ARROW, _MOMENT = 0.30, 0.10
"""Length of the largest force and radius of a moment, as a share of the arm's size."""
_ARM_HEIGHT, _ROW = 3.0, 0.2  # of the picture of the arm; of a joint's bar and the room around it [in]
_ROUNDING = 1e-12  # of the largest torque: nothing


def load(
    model: RobotModel,
    q: Any,
    loads: Loads,
    *,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    ax: Any = None,
    bars: Any = None,
    at: str = TIP,
    view: tuple[float, float] | None = None,
) -> Axes:
    """An arm, the loads on it, and below them the joint torques that hold it.

    A load on the robot (`Wrench.on_robot`) is an arrow that ends at its point; what the robot exerts on its surroundings
    (`Wrench.on_environment`) an arrow that leaves from it; a moment is a circular arrow by the right hand. The longest
    arrow is the largest force, the others are to its scale.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; None for the robot's home.
        loads: a Wrench at the tip, {link: Wrench or list of them}, or [(link, Wrench), ...].
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.
        ax: axes for the arm, or a figure for both; default a new figure.
        bars: axes for the bars; without them, and with axes for the arm, the bars are left out.
        at, view: as in `arm`.

    Returns:
        The axes of the arm; those of the bars are the last of `ax.figure.axes`.

    Raises:
        As in `arm`; ArrayTypeError: KS302 for loads of another form. A robot without masses is drawn without the part of
        gravity, and the picture says so.

    Law: τ = τ_gravity - Jᵀ w for a load w on the robot, + Jᵀ w for what it exerts.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.load(ks.load("planar_2r"), [0.0, 0.0], ks.Wrench.on_robot(force=(0, -10, 0)), gravity=None)
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['load on the robot: 10 N']
    """
    values = one_configuration(model, q)
    applied = applied_loads(model, loads)
    bones = skeleton(model, values, at)
    place = ax
    if not is_axes(ax):
        place, below = _two_rows(model, ax)
        bars = below if bars is None else bars
    canvas = canvas_for(model, place, view)
    draw_arm(canvas, bones, frames=False)
    draw_loads(canvas, model, values, bones, applied)
    if bars is not None:
        torque_bars(model, values, loads, gravity=gravity, ax=bars)
    return canvas.finish()


def _two_rows(model: RobotModel, figure: Any) -> tuple[Cell, Cell]:
    """Places for the arm and, below it, for the bars."""
    upper, lower = _ARM_HEIGHT, _bars_height(model)
    share = lower / (upper + lower)
    figure = new_figure(COLUMN, upper + lower) if figure is None else figure
    return Cell(figure, (0.0, share, 1.0, 1.0 - share)), Cell(figure, (0.0, 0.0, 1.0, share))


def draw_loads(canvas: Canvas, model: RobotModel, q: Array, bones: Skeleton, loads: Sequence[Load]) -> None:
    """Every load as an arrow at its point and a circular arrow."""
    largest = max((float(np.linalg.norm(load.wrench.array[LINEAR])) for load in loads), default=0.0)
    for load in loads:
        frame = load.wrench.frame
        R = pose(model, q, at=frame.axes).rotation
        point = pose(model, q, at=frame.origin, point=frame.offset).translation
        force, moment = R @ load.wrench.array[LINEAR], R @ load.wrench.array[ANGULAR]
        size, turn = float(np.linalg.norm(force)), float(np.linalg.norm(moment))
        if size:
            arrow = _ARROW * bones.size * force / largest
            start, end = (point - arrow, point) if load.on_robot > 0 else (point, point + arrow)
            canvas.hold(np.array([start, end]))
            canvas.arrow(start, end, TOP, width=1.6, head=7.0, color=FORCE)
        if turn:
            turning_arrow(canvas, point, moment / turn, _MOMENT * bones.size, FORCE)
        parts = [f"{x:.4g} {unit}" for x, unit in ((size, "N"), (turn, "N m")) if x]
        who = "load on the robot" if load.on_robot > 0 else "push on the surroundings"
        where = "" if len(loads) == 1 else f" at {model.link_name(load.link)}"
        canvas.key(f"{who}{where}: {', '.join(parts) or '0'}", color=FORCE, linewidth=1.6)


def torque_bars(
    model: RobotModel,
    q: Any = None,
    loads: Loads = None,
    *,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    ax: Any = None,
) -> Axes:
    """The joint torques that hold an arm: the part of its weight and the part of the loads, and the limits.

    The parts are stacked, each to the side of its sign; a diamond marks their sum, a thick stroke the effort limit on
    that side. Sum and limit stand beside the bars as numbers, bold where the sum is over.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        loads: as in `load`; None for the weight alone.
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        As in `load`; MissingMassError: KS320 where neither masses nor loads are known.

    Law: as in `load`.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.torque_bars(ks.load("planar_2r"), [0.0, 0.0], ks.Wrench.on_robot(force=(0, -10, 0)))
        >>> [round(float(bar.get_width()), 12) for bar in ax.containers[-1]]
        [20.0, 10.0]
    """
    values = one_configuration(model, q)
    applied = applied_loads(model, loads)
    weighed = gravity is not None and model.has_masses
    if not weighed and not applied:
        raise missing_masses(model)
    parts: list[tuple[str, str, Array]] = []
    if weighed and gravity is not None:
        parts.append(("weight of the arm", GRAVITY, gravity_torques(model, values, gravity=gravity)))
    if applied:
        word = "loads" if len(applied) > 1 else "load" if applied[0].on_robot > 0 else "push"
        parts.append((word, FORCE, holding_torques(model, values, loads, gravity=None)))
    axes = ax if is_axes(ax) else new_axes(ax, _bars_height(model))
    draw_bars(axes, model, parts, "" if weighed or gravity is None else WITHOUT_WEIGHT)
    return axes


def _bars_height(model: RobotModel) -> float:
    return 0.75 + _ROW * model.n


def analysis_parts(a: Analysis) -> list[tuple[str, str, Array]]:
    """What an analysis knows of the torques: the part of the weight and the part of the loads, as `draw_bars` takes them."""
    parts = [("weight of the arm", GRAVITY, a.gravity_torques), ("load", FORCE, a.joint_torques)]
    return [(name, color, values) for name, color, values in parts if values is not None]


def draw_bars(ax: Any, model: RobotModel, parts: Sequence[tuple[str, str, Array]], note: str = "") -> None:
    """Stacked bars of (name, colour, torques (n)), their sums and the limits; a row for each joint, the first on top."""
    rows, total = np.arange(model.n), np.sum([values for *_, values in parts], axis=0)
    ends = {True: np.zeros(model.n), False: np.zeros(model.n)}
    for name, color, values in parts:
        up = values >= 0
        start = np.where(up, ends[True], ends[False])
        ax.barh(rows, values, left=start, height=0.62, color=color, edgecolor="white", linewidth=0.4, label=name, zorder=2)
        ends = {side: np.where(up == side, start + values, end) for side, end in ends.items()}
    total = np.where(np.abs(total) > _ROUNDING * np.abs([values for *_, values in parts]).max(initial=0.0), total, 0.0)
    limits = np.where(total < 0, -model.effort_limits, model.effort_limits)
    known = np.isfinite(limits)
    if np.any(known):
        ax.plot(limits[known], rows[known], "|", ms=9, mew=1.6, color=TEXT, linestyle="none", label="limit", zorder=3)
    if len(parts) > 1:
        ax.plot(total, rows, "D", ms=3.2, mfc="white", mec=TEXT, mew=0.8, linestyle="none", label="sum", zorder=4)
    _number_rows(ax, model, total, float(np.abs([values for *_, values in parts]).max(initial=0.0)))
    _dress_bars(ax, model, note)
    draw_key(ax, ncols=4, columnspacing=1.2, handletextpad=0.5)
    settle(ax, place_of(ax))


def _number_rows(ax: Any, model: RobotModel, total: Array, largest: float) -> None:
    """The sums as numbers in a column, with the limits where they are known; bold where they are over."""
    for row, (value, limit) in enumerate(zip(total, model.effort_limits, strict=True)):
        words = f"{0.0 if abs(value) <= _ROUNDING * largest else value:.3g}"
        over = abs(value) > limit
        ax.annotate(
            f"{words} / {limit:.3g}" if np.isfinite(limit) else words,
            (1.02, row),
            xycoords=("axes fraction", "data"),
            va="center",
            fontsize=SMALL_SIZE,
            color=FORCE if over else TEXT,
            fontweight="bold" if over else "normal",
        )


def _dress_bars(ax: Any, model: RobotModel, note: str) -> None:
    mixed = "prismatic" in model.joint_kinds
    units = ["N" if kind == "prismatic" else "N m" for kind in model.joint_kinds]
    names = [f"{name} [{unit}]" if mixed else name for name, unit in zip(model.joint_names, units, strict=True)]
    ax.axvline(0.0, color=EDGE, linewidth=0.6, zorder=1)
    ax.set_yticks(range(model.n), names, fontsize=TICK_SIZE, color=TEXT)
    ax.set_ylim(max(model.n, 1) - 0.5, -0.5)
    ax.margins(x=0.04)
    what = "holding torque [N m]" if not mixed else "holding torque or force"
    ax.set_xlabel(f"{what}\n{note}" if note else what, fontsize=LABEL_SIZE, color=TEXT)
    ax.tick_params(axis="y", length=0)
    ax.tick_params(axis="x", labelsize=TICK_SIZE, colors=TEXT, width=0.6, length=2.5)
    for side, spine in ax.spines.items():
        spine.set_visible(side == "bottom")
        spine.set(linewidth=0.6, edgecolor=TEXT)
