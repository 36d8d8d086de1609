"""`workspace_section`: the cross-section of an arm's workspace, with what its outline is made of."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array
from ..palette import FORCE, TEXT, VELOCITY
from ..singular_sets.workspace import Outline, WorkspaceSection
from .axes import is_axes, new_axes
from .layout import draw_key, place_of, settle
from .style import LABEL_SIZE, TICK_SIZE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 3.2  # of the picture, its key aside [in]
_REACHED, _CROSSABLE, _AXIS = "#eef3f7", "#3f7d3f", "#9a9a9a"
_OUTLINES = {"barrier": (VELOCITY, "singular: a barrier"), "limit": (FORCE, "at a joint limit")}
_IMAGES = {"barrier": (VELOCITY, "singular, inside: a barrier"), "crossable": (_CROSSABLE, "singular, inside: crossable")}
_ON_OUTLINE = 2e-3  # in reaches: images nearer than this to an outline are that outline


def workspace_section(section: WorkspaceSection, *, images: bool = True, ax: Any = None) -> Axes:
    """The cross-section of a workspace: what is reached, its outline, and inside of it the image of the singular set.

    The outline is blue where a singular posture is the end of what the arm can reach, and vermilion where a joint limit is.
    Inside, dots are places of singular postures: blue ones a barrier for that branch of the arm, which another branch
    passes; green ones crossable.

    Args:
        section: from `SingularSet.workspace_section`.
        images: whether to draw the dots.
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        MissingExtraError: KS400; ArrayTypeError: KS302.

    Example:
        >>> import kinestatics as ks
        >>> found = ks.singularities(ks.load("elbow_rrr"), "position")
        >>> ax = ks.plots.workspace_section(found.workspace_section(cells=24, image=60))
        >>> ax.get_xlabel(), [text.get_text() for text in ax.get_legend().get_texts()]
        ('distance from axis 1 [m]', ['singular: a barrier'])
    """
    if not isinstance(section, WorkspaceSection):
        message = f"expected a section of a workspace, not {type(section).__name__}"
        raise ArrayTypeError("KS302", message, "found.workspace_section() of ks.singularities(arm, 'position')")
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    _fill(axes, section)
    for outline in section.outlines:
        _draw(axes, outline)
    if images:
        _dots(axes, section)
    around = section.axes[0] == "radius"
    if around:
        axes.axvline(0.0, color=_AXIS, linewidth=0.7, linestyle=(0, (6, 2, 1, 2)), zorder=1)
    names = ("distance from axis 1 [m]", "along axis 1 [m]") if around else ("x [m]", "y [m]")
    _dress(axes, section, names)
    return axes


def _fill(axes: Any, section: WorkspaceSection) -> None:
    """What is reached, voids left out."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    paths = [Path(np.vstack([o.points, o.points[:1]]), closed=True) for o in section.outlines]
    if paths:
        axes.add_patch(PathPatch(Path.make_compound_path(*paths), facecolor=_REACHED, edgecolor="none", zorder=1))


def _draw(axes: Any, outline: Outline) -> None:
    """An outline in runs of one kind; a piece between two kinds belongs to the one that is not the axis."""
    points = np.vstack([outline.points, outline.points[:1]])
    pieces = [_between(a, b) for a, b in itertools.pairwise([*outline.kinds, outline.kinds[0]])]
    for kind, (color, _) in _OUTLINES.items():
        chosen = np.array([piece == kind for piece in pieces], dtype=bool)
        runs = np.flatnonzero(np.diff(np.r_[False, chosen, False]))
        for begin, end in zip(runs[::2], runs[1::2], strict=True):
            axes.plot(*points[begin : end + 1].T, color=color, linewidth=1.3, zorder=4, solid_capstyle="round")


def _between(a: str, b: str) -> str:
    """The kind of a piece between points of two kinds."""
    if "axis" in (a, b):
        return "axis" if a == b else a if b == "axis" else b
    return "limit" if "limit" in (a, b) else "barrier"


def _dots(axes: Any, section: WorkspaceSection) -> None:
    """Images of the singular set, those on the outline left out."""
    for kind, (color, word) in _IMAGES.items():
        places = [np.zeros((0, 2))]
        for image in section.images:
            chosen = np.array([k == kind for k in image.kinds], dtype=bool)
            places.append(_inside(image.points[chosen], section))
        found = np.concatenate(places)
        if len(found):
            axes.plot(*found.T, ".", color=color, markersize=1.6, markeredgewidth=0, zorder=3, rasterized=True)
            axes.plot([], [], ".", color=color, markersize=5, label=word)


def _inside(places: Array, section: WorkspaceSection) -> Array:
    """Places not on an outline."""
    if not len(places) or not section.outlines:
        return places
    lengths = np.linalg.norm(places[:, None] - section.points, axis=-1)
    return places[lengths.min(1) > _ON_OUTLINE * section.reach + _spacing(section)[lengths.argmin(1)] / 2]


def _spacing(section: WorkspaceSection) -> Array:
    """(k) the longer of the pieces at each point of the outlines."""
    found = []
    for outline in section.outlines:
        length = np.linalg.norm(np.roll(outline.points, -1, axis=0) - outline.points, axis=-1)
        found.append(np.maximum(length, np.roll(length, 1)))
    return np.concatenate(found)


def _dress(axes: Any, section: WorkspaceSection, names: tuple[str, str]) -> None:
    axes.set_xlabel(names[0], fontsize=LABEL_SIZE, color=TEXT)
    axes.set_ylabel(names[1], fontsize=LABEL_SIZE, color=TEXT)
    axes.tick_params(labelsize=TICK_SIZE, colors=TEXT)
    axes.grid(True, color="0.9", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.04)
    for kind, (color, word) in _OUTLINES.items():
        if kind in section.kinds:
            axes.plot([], [], color=color, label=word)
    draw_key(axes)
    settle(axes, place_of(axes), _HEIGHT)
