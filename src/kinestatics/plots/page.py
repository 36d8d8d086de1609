"""`analysis`: one page for one analysis, small pictures side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis import Analysis
from ..errors import ArrayTypeError
from ..model import RobotModel
from ..palette import EDGE, FORCE, GRAVITY, LINK, TEXT, VELOCITY
from ..quantities import format_number
from ..tasks import model_of
from .axes import Cell, new_axes
from .ellipsoids import force_ellipsoid, velocity_ellipsoid
from .layout import place_of, settle
from .screws import draw_screws
from .shapes import begin
from .style import LABEL_SIZE, PAGE, SMALL_SIZE, TICK_SIZE, new_figure, require_matplotlib
from .torques import WITHOUT_WEIGHT, analysis_parts, draw_bars

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TITLE, _PICTURES, _ROW = 0.28, 3.0, 0.19  # heights of the title, of the pictures and of a joint's row [in]


def analysis(a: Analysis, *, figure: Any = None) -> Figure:
    """One page for an analysis: what the arm can do at this posture, what it has lost, and what holds it.

    Six small pictures: velocity ellipsoid, force ellipsoid, lost motions and free wrenches; joint torques with their limits,
    singular values, and the joints between their position limits.

    Args:
        a: from `kinestatics.analyze`.
        figure: an empty matplotlib figure to draw into; default a new one of a page's width (178 mm).

    Returns:
        The figure: `figure.savefig("page.pdf")`.

    Raises:
        MissingExtraError: KS400; ArrayTypeError: KS302 for what is no analysis.

    Example:
        >>> import kinestatics as ks
        >>> page = ks.plots.analysis(ks.analyze(ks.load("planar_2r"), [0.4, 0.9]))
        >>> len(page.axes)
        6
    """
    if not isinstance(a, Analysis):
        raise ArrayTypeError("KS302", f"expected an Analysis, not a {type(a).__name__}", "a = ks.analyze(arm, q)")
    require_matplotlib()
    model = model_of(a.jacobian)
    lower = 0.85 + _ROW * max(len(a.joints), len(a.singular_values))
    height = _TITLE + _PICTURES + lower
    figure = new_figure(PAGE, height) if figure is None else figure
    tops = [Cell(figure, (k / 3, lower / height, 1 / 3, _PICTURES / height)) for k in range(3)]
    velocity_ellipsoid(model, a.configuration, ax=tops[0], at=a.tip)
    force_ellipsoid(model, a.configuration, ax=tops[1], at=a.tip)
    canvas, bones, _ = begin(model, a.configuration, tops[2], a.tip, True, False, None)
    draw_screws(canvas, bones, a)
    canvas.finish()
    share = lower / height
    _torques(Cell(figure, (0.0, 0.0, 0.42, share)), model, a)
    _singular_values(Cell(figure, (0.42, 0.0, 0.25, share)), a)
    _ranges(Cell(figure, (0.67, 0.0, 0.33, share)), model, a)
    values = ", ".join(format_number(round(float(x), 3)) for x in a.configuration)
    words = f"{a.robot}, q = ({values}): rank {a.rank} of {a.task.rank} in {', '.join(a.task.row_names) or 'no rows'}"
    figure.text(0.01, 1 - 0.06 / height, words, va="top", fontsize=LABEL_SIZE, color=TEXT, fontweight="bold")
    return figure


def _torques(cell: Cell, model: RobotModel, a: Analysis) -> None:
    axes = new_axes(cell, 0.0)
    parts = analysis_parts(a)
    if parts:
        note = "" if a.gravity_torques is not None else WITHOUT_WEIGHT
        draw_bars(axes, model, parts, note)
        return
    axes.set_axis_off()
    axes.text(0.5, 0.5, "no masses are known:\nno torques to show", ha="center", va="center", fontsize=TICK_SIZE, color=TEXT)


def _rows(axes: Any, names: list[str], title: str) -> None:
    """A row for each name, the first on top; no frame."""
    axes.set_yticks(range(len(names)), names, fontsize=TICK_SIZE, color=TEXT)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    axes.set_title(title, loc="left", fontsize=TICK_SIZE, color=TEXT)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=TICK_SIZE, colors=TEXT, width=0.6, length=2.5)
    for side, spine in axes.spines.items():
        spine.set_visible(side == "bottom")
        spine.set(linewidth=0.6, edgecolor=TEXT)


def _singular_values(cell: Cell, a: Analysis) -> None:
    """Bars; those that count as zero say so."""
    axes = new_axes(cell, 0.0)
    shown = np.where(np.arange(len(a.singular_values)) < a.rank, a.singular_values, 0.0)
    notes = [f"condition {a.condition:.3g}" if np.isfinite(a.condition) else "condition infinite"]
    if a.scaled:
        notes += [" and\n".join(a.scaled), f"times {format_number(round(a.characteristic_length, 3))} m"]
    _rows(axes, [rf"$\sigma_{{{k + 1}}}$" for k in range(len(shown))], "singular values")
    axes.barh(range(len(shown)), shown, height=0.62, color=VELOCITY)
    axes.set_xlim(0.0, 1.05 * float(shown.max(initial=0.0)) or 1.0)
    axes.locator_params(axis="x", nbins=4)
    for k, value in enumerate(shown):
        words, color = (f"{value:.3g}", TEXT) if value else ("0", FORCE)
        where = ("axes fraction", "data")
        axes.annotate(words, (1.03, k), xycoords=where, va="center", fontsize=SMALL_SIZE, color=color)
    axes.set_xlabel("\n".join(notes), fontsize=TICK_SIZE, color=TEXT)
    settle(axes, place_of(axes))


def _ranges(cell: Cell, model: RobotModel, a: Analysis) -> None:
    """Where each joint is between its limits; near ones in another colour."""
    axes = new_axes(cell, 0.0)
    near = {margin.joint for margin in a.margins if margin.near}
    _rows(axes, list(a.joints), "joint ranges")
    for k, (name, x, lower, upper) in enumerate(zip(a.joints, a.configuration, model.lower, model.upper, strict=True)):
        bounded = bool(np.isfinite(lower) and np.isfinite(upper) and upper > lower)
        axes.plot([0, 1], [k, k], color=GRAVITY, linewidth=2.4 if bounded else 0.8, linestyle="-" if bounded else ":")
        if bounded:
            share = float(np.clip((x - lower) / (upper - lower), -0.05, 1.05))
            axes.plot([share], [k], "o", ms=4.5, mfc=FORCE if name in near else LINK, mec=EDGE, mew=0.6)
        else:
            axes.annotate(
                "no limits", (0.5, k), ha="center", va="center", fontsize=SMALL_SIZE, color=TEXT, backgroundcolor="w"
            )
    axes.set_xlim(-0.07, 1.07)
    axes.set_xticks([0, 1], ["lower", "upper"])
    settle(axes, place_of(axes))
