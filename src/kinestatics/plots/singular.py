"""`singular_curves` and `singular_image`: where an arm is singular, in the plane of two joints and in its workspace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..kinematics import pose
from ..namespaces import Array
from ..singular_sets import SingularSet
from .axes import is_axes, new_axes
from .layout import draw_key, place_of, settle
from .style import FORCE, LABEL_SIZE, TEXT, TICK_SIZE, VELOCITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 2.6  # of the picture, its key aside [in]
_COLORS = (VELOCITY, FORCE, "#3f7d3f", "#7a4fa3", "#555555")
_RIGHT_ANGLES = (-180, -90, 0, 90, 180)


def singular_curves(
    found: SingularSet, joints: Sequence[str | int], q: Any = None, *, step: float = 0.02, ax: Any = None
) -> Axes:
    """The singular curves in the plane of two joints, the others held; angles in degrees.

    Args:
        found: from `kinestatics.singularities`.
        joints: names or columns of two joints: across and up.
        q: (n) where the others are held; a dot marks it. Default the home posture, unmarked.
        step: between points [rad or m].
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS303, KS398; UnknownNameError: KS313; ArrayTypeError: KS302.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.singular_curves(ks.singularities(ks.load("puma_560")), ["joint2", "joint3"])
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['shoulder', 'elbow']
    """
    _require_set(found)
    curves = found.trace(joints, q, step)
    columns = [found.model.joint_names.index(j) if isinstance(j, str) else int(j) for j in joints]
    turns = [found.space.half.ring.turns[c] for c in columns]
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    shown: dict[str, str] = {}
    for curve in curves:
        points = curve.points[:, columns]
        points = np.vstack([points, points[:1]]) if curve.closed else points
        color = _color(shown, curve.component.label)
        _draw(axes, _in_degrees(points, turns), color, [360.0 * t for t in turns])
    if q is not None:
        here = _in_degrees(np.asarray(q, dtype=float)[None, columns], turns)
        axes.plot(*here.T, "o", color=TEXT, markersize=4, zorder=4)
    names = [found.model.joint_names[c] for c in columns]
    labels = [f"{name} [{'°' if t else 'm'}]" for name, t in zip(names, turns, strict=True)]
    for axis, t in zip((axes.xaxis, axes.yaxis), turns, strict=True):
        if t:
            axis.set_ticks(_RIGHT_ANGLES)
    for limit, t in zip((axes.set_xlim, axes.set_ylim), turns, strict=True):
        if t:
            limit(-180, 180)
    _dress(axes, (labels[0], labels[1]), shown, equal=all(turns))
    return axes


def singular_image(found: SingularSet, *, step: float = 0.02, ax: Any = None) -> Axes:
    """The tip's places in singular postures: of two joints in the plane of base, of three joints around axis 1.

    The workspace's boundary is part of it; what is inside separates regions with different numbers of solutions of the
    inverse problem. Cusps are marked.

    Args:
        found: from `kinestatics.singularities` of an arm of two or three joints that turn.
        step: between points [rad].
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS398 for other arms; ArrayTypeError: KS302.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.singular_image(ks.singularities(ks.load("elbow_rrr"), "position"))
        >>> ax.get_xlabel()
        'distance from axis 1 [m]'
    """
    _require_set(found)
    n = found.model.n
    if n not in (2, 3) or not all(found.space.half.ring.turns):
        hint = "singular_curves draws the curves of any arm in joint space"
        raise ConfigurationError("KS398", f"the image is drawn for two or three joints that turn, not for {n}", hint)
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    shown: dict[str, str] = {}
    around = n == 3
    for curve in found.trace((n - 2, n - 1), np.zeros(n), step):
        points = np.vstack([curve.points, curve.points[:1]]) if curve.closed else curve.points
        places = _places(found, points, around)
        _draw(axes, places, _color(shown, curve.component.label), [0.0, 0.0])
    if around:
        for cusp in found.cusps(step):
            axes.plot(cusp.radius, cusp.height, "o", color=TEXT, markersize=3, zorder=4)
    names = ("distance from axis 1 [m]", "along axis 1 [m]") if around else ("x [m]", "y [m]")
    _dress(axes, names, shown, equal=True)
    return axes


def _require_set(found: Any) -> None:
    if not isinstance(found, SingularSet):
        message = f"expected a singular set, not {type(found).__name__}"
        raise ArrayTypeError("KS302", message, "found = ks.singularities(arm)")


def _places(found: SingularSet, q: Array, around: bool) -> Array:
    """(k, 2) where the tip is: around axis 1, or in the plane."""
    from ..singular_sets.tracing import first_axis

    p = pose(found.model, q, at=found.link, check_finite=False).translation
    if not around:
        return p[:, :2]
    axis, origin = first_axis(found.model, found.link)
    height = (p - origin) @ axis
    return np.stack([np.linalg.norm(p - origin - height[:, None] * axis, axis=-1), height], axis=-1)


def _in_degrees(points: Array, turns: Sequence[bool]) -> Array:
    """Angles between -180 and 180 degrees."""
    turned = np.degrees(np.pi - np.mod(np.pi - points, 2 * np.pi))
    return np.where(turns, turned, points)


def _color(shown: dict[str, str], label: str) -> str:
    return shown.setdefault(label, _COLORS[len(shown) % len(_COLORS)])


def _draw(axes: Any, points: Array, color: str, around: Sequence[float]) -> None:
    """A line, broken where it goes around the torus."""
    breaks = np.zeros(len(points) - 1, dtype=bool)
    for k, turn in enumerate(around):
        if turn:
            breaks |= np.abs(np.diff(points[:, k])) > turn / 2
    for piece in np.split(points, np.flatnonzero(breaks) + 1):
        axes.plot(*piece.T, color=color, linewidth=1.2, zorder=3)


def _dress(axes: Any, names: tuple[str, str], shown: dict[str, str], equal: bool) -> None:
    """Names, a grid, and the key of components."""
    axes.set_xlabel(names[0], fontsize=LABEL_SIZE, color=TEXT)
    axes.set_ylabel(names[1], fontsize=LABEL_SIZE, color=TEXT)
    axes.tick_params(labelsize=TICK_SIZE, colors=TEXT)
    axes.grid(True, color="0.9", linewidth=0.6, zorder=0)
    if equal:
        axes.set_aspect("equal", adjustable="box")
    for label, color in shown.items():
        axes.plot([], [], color=color, label=label)
    if shown:
        draw_key(axes)
    settle(axes, place_of(axes), _HEIGHT)
