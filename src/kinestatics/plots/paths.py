"""`measure_along`: how well an arm moves along a path of configurations, and where it is worst."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..dexterity import condition_number, inverse_condition, isotropy, manipulability, smallest_singular_value
from ..dexterity.measures import ratio_of
from ..dexterity.rows import RowsInPlay, TaskName, manipulability_unit, rows_in_play, singular
from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError
from ..frames import TIP
from ..kinematics import configuration, jacobian, require_model
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..palette import FORCE, TEXT, VELOCITY
from ..quantities import Jacobian
from ..spatial import LINEAR_ROWS
from .axes import is_axes, new_axes
from .layout import draw_key, place_of, settle
from .style import LABEL_SIZE, TICK_SIZE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 2.0  # of the picture, its key aside [in]
_STYLES = ("-", (0, (4.0, 1.6)), (0, (1.2, 1.2)), (0, (5.0, 1.4, 1.2, 1.4)))  # of one curve after the other
_CURVE, _LOST, _CROSSED = "kinestatics-curve", "rank drops here", "rank drops between two configurations"


@dataclass(frozen=True)
class _Measure:
    """A measure by its name: what computes it, its words, and which end of it is the worst."""

    compute: Callable[..., Array]
    words: str
    worst: Callable[[Array], Any] = np.argmin

    @property
    def is_ratio(self) -> bool:
        return self.compute not in (manipulability, smallest_singular_value)


MEASURES: Final = {
    "manipulability": _Measure(manipulability, "manipulability $w$"),
    "smallest_singular_value": _Measure(smallest_singular_value, "smallest singular value\n" r"$\sigma_\mathrm{min}$"),
    "sigma_min": _Measure(smallest_singular_value, "smallest singular value\n" r"$\sigma_\mathrm{min}$"),
    "inverse_condition": _Measure(inverse_condition, "inverse condition\n" r"$\sigma_\mathrm{min}/\sigma_\mathrm{max}$"),
    "condition_number": _Measure(
        condition_number, "condition number\n" r"$\sigma_\mathrm{max}/\sigma_\mathrm{min}$", np.argmax
    ),
    "isotropy": _Measure(isotropy, r"isotropy $\Delta$"),
}
"""What `measure_along` draws, by name."""


def measure_along(
    model: RobotModel,
    path: Any,
    measure: str = "manipulability",
    *,
    task: TaskName = "auto",
    at: str = TIP,
    length: float | None = None,
    times: Any = None,
    label: str | None = None,
    ax: Any = None,
) -> Axes:
    """A measure along a path of configurations: its curve, its worst place, and the places where the rank drops.

    A dot marks the least value (of the condition number the greatest), the first of equal ones; the key says it and where
    it is. A cross on the lower rim marks a configuration of the path at which the rank is lower than at almost every
    posture. Where the Jacobian in its rows is square, a ring there marks a place between two configurations at which its
    determinant changes sign: on any way from the one to the other the rank drops.

    Args:
        model: the robot.
        path: (m, n) configurations, one after the other [rad or m].
        measure: "manipulability", "smallest_singular_value" (or "sigma_min"), "inverse_condition", "condition_number" (on
            a logarithmic axis), "isotropy": the functions of these names.
        task, length: rows in play and characteristic length [m], as in `kinestatics.manipulability`.
        at: link whose Jacobian is measured.
        times: (m) increasing times [s] for the horizontal axis; default the number of the configuration, from 0.
        label: the name of this curve in the key; default the rows in play.
        ax: axes, or a figure to add them to; default a new figure of one column's width. Further curves on the same axes
            are dashed.

    Returns:
        The axes. The unit of the measure stands on the vertical axis, where it has one.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS384 for a path of another shape, KS385 for times, KS301 where q is
        not finite, KS360 where the rows mix metres and radians and the measure needs a length; UnknownNameError: KS386 for
        a measure, KS310 for a link, KS318 for a task; ArrayTypeError: KS302.

    Law: the curve is measure(J(q_k)) at every k. Between two configurations with det J of different signs there is one with
    det J = 0 (J is continuous). Source: Yoshikawa, IJRR 4(2), 1985, for the use of w along a motion.

    Example:
        >>> import numpy as np, kinestatics as ks
        >>> path = np.linspace([0.0, 2.0], [0.0, 0.5], 31)
        >>> ax = ks.plots.measure_along(ks.load("planar_2r"), path)
        >>> ax.get_ylabel()
        'manipulability $w$ [m$^{2}$]'
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['rows vx, vy', 'least: 0.4794 m$^{2}$ at configuration 30']
    """
    found, values = _known(measure), checked_path(model, path)
    x = np.arange(len(values), dtype=float) if times is None else checked_times(times, len(values))
    J = jacobian(model, values, at=at)
    heights = np.asarray(found.compute(J, task=task, length=length), dtype=float)
    rows = rows_in_play(J, task, length, needs_length=False)
    unit = "" if found.is_ratio else _in_mathtext(_unit(rows, model, J, found.compute is manipulability))
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    _draw_curve(axes, x, heights, label or f"rows {', '.join(rows.task.row_names) if rows.task else ''}")
    _draw_worst(axes, x, heights, found, unit, times is not None)
    _draw_drops(axes, x, rows)
    _dress(axes, found, unit, "configuration" if times is None else "time [s]")
    return axes


def _known(measure: Any) -> _Measure:
    if not isinstance(measure, str) or measure not in MEASURES:
        raise UnknownNameError("KS386", f"measure={measure!r} is not known", f"one of {', '.join(MEASURES)}")
    return MEASURES[measure]


def checked_path(model: RobotModel, path: Any) -> Array:
    """(m, n) the path in NumPy, checked."""
    require_model(model)
    if model.is_symbolic:
        raise ArrayTypeError("KS302", f"robot {model.name!r} has symbolic lengths", "put numbers in place of the symbols")
    array, xp = as_array(path, "the path")
    if xp.name != "numpy":
        hint = "np.asarray(path) first"
        raise ArrayTypeError("KS302", f"pictures are drawn with NumPy; the path is an array of {xp.name}", hint)
    if array.ndim != 2 or array.shape[1] != model.n or not len(array):
        message = f"the path has shape {tuple(array.shape)}; expected (m, {model.n})"
        hint = f"one row for each configuration, one column for each joint of {model.name!r}: {', '.join(model.joint_names)}"
        raise ConfigurationError("KS384", message, hint)
    return np.array(configuration(model, array, what="the path")[0], dtype=np.float64)


def checked_times(times: Any, m: int) -> Array:
    """(m) increasing times.

    Raises:
        ConfigurationError: KS385.
    """
    try:
        x = np.asarray(times, dtype=float)
    except (TypeError, ValueError):
        x = np.zeros(0)
    if x.shape != (m,) or not np.all(np.isfinite(x)) or np.any(np.diff(x) <= 0):
        message = f"the times have shape {x.shape}" if x.shape != (m,) else "the times are not finite and increasing"
        raise ConfigurationError("KS385", message, f"({m},) increasing times in seconds, one for each configuration")
    return x


def _unit(rows: RowsInPlay, model: RobotModel, J: Jacobian, is_product: bool) -> str:
    """Unit of the product of the singular values, or of one of them; "1" for none."""
    if rows.task is None or not rows.rank:
        return "1"
    if rows.scaled:
        return f"m^{rows.rank}" if is_product and rows.rank > 1 else "m"
    if is_product:
        return manipulability_unit(rows.task, model, J.link)
    return _unit_of_one(rows, model)


def _unit_of_one(rows: RowsInPlay, model: RobotModel) -> str:
    """Unit of a singular value of rows as they are: one of linear rows over one of the joints that move them."""
    if rows.task is None or not any(row in LINEAR_ROWS for row in rows.task.rows):
        return "1"
    kinds = {kind == "prismatic" for kind, moves in zip(model.joint_kinds, _moving(rows), strict=True) if moves}
    return "mixed units" if len(kinds) == 2 else "1" if kinds == {True} else "m"


def _moving(rows: RowsInPlay) -> Array:
    """(n) whether a joint moves the rows anywhere on the path."""
    return np.asarray(np.any(rows.array != 0, axis=(0, 1)))


def _in_mathtext(unit: str) -> str:
    base, _, power = unit.partition("^")
    return "" if unit == "1" else f"{base}$^{{{power}}}$" if power else unit


def _draw_curve(axes: Any, x: Array, heights: Array, label: str) -> None:
    before = sum(line.get_gid() == _CURVE for line in axes.lines)
    style: dict[str, Any] = {"color": VELOCITY, "linewidth": 1.2, "linestyle": _STYLES[before % len(_STYLES)]}
    marker = "." if len(x) == 1 else ""
    axes.plot(x, np.where(np.isfinite(heights), heights, np.nan), marker=marker, label=label, gid=_CURVE, zorder=3, **style)


def _draw_worst(axes: Any, x: Array, heights: Array, found: _Measure, unit: str, timed: bool) -> None:
    """A dot at the worst of the values; where that is infinite, the key alone says it."""
    k = int(found.worst(heights))
    where = f"t = {x[k]:.4g} s" if timed else f"configuration {k}"
    word = "least" if found.worst is np.argmin else "greatest"
    size = f"{heights[k]:.4g}" if np.isfinite(heights[k]) else "infinite"
    shown = f"{word}: {size}{' ' + unit if unit and unit != 'mixed units' else ''} at {where}"
    height = heights[k] if np.isfinite(heights[k]) else np.nan
    axes.plot(x[[k]], [height], "o", ms=4.5, mfc="white", mec=VELOCITY, mew=1.1, zorder=5, label=shown, clip_on=False)


def _draw_drops(axes: Any, x: Array, rows: RowsInPlay) -> None:
    """Crosses at configurations of lower rank, rings between those whose determinants have different signs."""
    if not rows.rank:
        return
    lost = ratio_of(singular(rows.array, rows.xp), rows.rank, rows.tolerance) == 0
    lower = axes.get_xaxis_transform()
    style: dict[str, Any] = {"linestyle": "none", "transform": lower, "clip_on": False, "mec": FORCE, "zorder": 6}
    if np.any(lost):
        axes.plot(x[lost], np.zeros(lost.sum()), "x", ms=5.0, mew=1.3, label=_LOST, **style)
    r, n = rows.array.shape[-2:]
    if not r == n == rows.rank:
        return
    signs, logarithms = np.linalg.slogdet(rows.array)
    changes = (signs[:-1] * signs[1:] < 0) & ~lost[:-1] & ~lost[1:]
    if np.any(changes):
        share = 1.0 / (1.0 + np.exp(np.clip(np.diff(logarithms)[changes], -50.0, 50.0)))  # as if det were straight
        places = x[:-1][changes] + share * np.diff(x)[changes]
        axes.plot(places, np.zeros(len(places)), "o", ms=4.5, mfc="none", mew=1.2, label=_CROSSED, **style)


def _dress(axes: Any, found: _Measure, unit: str, below: str) -> None:
    """Names and numbers of the axes, the key, the place; a value of zero is in the picture."""
    axes.margins(x=0.02)
    if found.worst is np.argmax:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0, auto=True)  # for a further curve the upper end is found again
    axes.set_xlabel(below, fontsize=LABEL_SIZE, color=TEXT)
    axes.set_ylabel(f"{found.words} [{unit}]" if unit else found.words, fontsize=LABEL_SIZE, color=TEXT)
    axes.tick_params(which="both", labelsize=TICK_SIZE, colors=TEXT, width=0.6, length=2.5)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set(linewidth=0.6, edgecolor=TEXT)
    draw_key(axes)
    settle(axes, place_of(axes), _HEIGHT)
