"""`singular_distances`: how far an arm stays from each way of losing rank, along a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..namespaces import Array
from ..palette import TEXT
from ..singular_sets import SingularSet
from .axes import is_axes, new_axes
from .layout import draw_key, place_of, settle
from .paths import checked_path, checked_times
from .singular import color_of, require_set
from .style import LABEL_SIZE, TICK_SIZE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 2.0  # of the picture, its key aside [in]
_STYLES = ("-", (0, (4.0, 1.6)), (0, (1.2, 1.2)), (0, (5.0, 1.4, 1.2, 1.4)))
_COLORS = 5


def singular_distances(found: SingularSet, path: Any, *, times: Any = None, bounds: bool = True, ax: Any = None) -> Axes:
    """The distance in joint space from each component of the singular set, along a path of configurations.

    A line for each component, in degrees where all joints turn; at zero the arm is singular. A band below a line, where
    there is one, reaches down to the bound that no singular posture of that component is within: the line is the shortest
    distance that was found, the band's lower rim is proved.

    Args:
        found: from `kinestatics.singularities`.
        path: (m, n) configurations, one after the other [rad or m]. Each takes about a tenth of a second for a component
            of several joints.
        times: (m) increasing times [s] for the horizontal axis; default the number of the configuration, from 0.
        bounds: whether to draw the bands.
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS384 for a path of another shape, KS301 where it is not finite, KS385
        for times; ArrayTypeError: KS302.

    Law: the distance is min |q - x| over the component, so that it changes along the path by no more than the path is long.

    Example:
        >>> import numpy as np, kinestatics as ks
        >>> path = np.linspace([0.0, 0.5, -1.0, 0.3, 0.6, 0.0], [0.0, 0.2, -0.4, 0.3, -0.2, 0.0], 5)
        >>> ax = ks.plots.singular_distances(ks.singularities(ks.load("puma_560")), path)
        >>> ax.get_ylabel(), [text.get_text() for text in ax.get_legend().get_texts()]
        ('distance [°]', ['shoulder', 'elbow', 'wrist'])
    """
    require_set(found)
    q = checked_path(found.model, path)
    x = np.arange(len(q), dtype=float) if times is None else checked_times(times, len(q))
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    turning = all(found.space.half.ring.turns)
    value, at_least = _distances(found, q)
    if turning:
        value, at_least = np.degrees(value), np.degrees(at_least)
    shown: dict[str, str] = {}
    for k, label in enumerate(_labels(found)):
        color, style = color_of(shown, label), _STYLES[k // _COLORS % len(_STYLES)]
        marker = "." if len(x) == 1 else ""
        axes.plot(x, value[:, k], color=color, linestyle=style, linewidth=1.2, marker=marker, label=label, zorder=3)
        if bounds:
            axes.fill_between(x, at_least[:, k], value[:, k], color=color, alpha=0.13, linewidth=0, zorder=2)
    _dress(axes, "configuration" if times is None else "time [s]", "°" if turning else "rad, m")
    return axes


def _labels(found: SingularSet) -> list[str]:
    """Names of the components, numbered where they are the same."""
    labels = [component.label for component in found.components]
    places = [labels[: k + 1].count(label) for k, label in enumerate(labels)]
    return [f"{label} {k}" if labels.count(label) > 1 else label for label, k in zip(labels, places, strict=True)]


def _distances(found: SingularSet, q: Array) -> tuple[Array, Array]:
    """(m, c) distances of the components in their order, infinite ones NaN, and bounds from below."""
    value, at_least = np.zeros((2, len(q), len(found.components)))
    for row, posture in enumerate(q):
        by_component = {id(d.component): d for d in found.distance(posture)}
        for k, component in enumerate(found.components):
            distance = by_component[id(component)]
            value[row, k] = distance.value if np.isfinite(distance.value) else np.nan
            at_least[row, k] = distance.at_least
    return value, at_least


def _dress(axes: Any, below: str, unit: str) -> None:
    axes.margins(x=0.02)
    axes.set_ylim(bottom=0.0, auto=True)
    axes.set_xlabel(below, fontsize=LABEL_SIZE, color=TEXT)
    axes.set_ylabel(f"distance [{unit}]", fontsize=LABEL_SIZE, color=TEXT)
    axes.tick_params(which="both", labelsize=TICK_SIZE, colors=TEXT, width=0.6, length=2.5)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set(linewidth=0.6, edgecolor=TEXT)
    draw_key(axes)
    settle(axes, place_of(axes), _HEIGHT)
