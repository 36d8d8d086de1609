"""`singular_curves`, `aspect_regions`, `singular_image`: singular postures in a plane of joints and in the workspace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..kinematics import pose
from ..namespaces import Array
from ..palette import FORCE, TEXT, VELOCITY
from ..singular_sets import SingularSet
from .axes import is_axes, new_axes
from .layout import draw_key, place_of, settle
from .style import LABEL_SIZE, TICK_SIZE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POSITIVE, _NEGATIVE, _CELLS = "#dcebf5", "#fbe6d8", 241
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
    require_set(found)
    curves = found.trace(joints, q, step)
    columns = [found.model.joint_names.index(j) if isinstance(j, str) else int(j) for j in joints]
    turns = [found.space.half.ring.turns[c] for c in columns]
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    shown: dict[str, str] = {}
    for curve in curves:
        points = curve.points[:, columns]
        points = np.vstack([points, points[:1]]) if curve.closed else points
        color = color_of(shown, curve.component.label)
        draw_line(axes, _in_degrees(points, turns), color, [360.0 * t for t in turns])
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
    dress(axes, (labels[0], labels[1]), shown, equal=all(turns))
    return axes


def aspect_regions(
    found: SingularSet,
    joints: Sequence[str | int],
    q: Any = None,
    *,
    limits: bool = False,
    step: float = 0.02,
    ax: Any = None,
) -> Axes:
    """The regions between singular curves in the plane of two joints, the others held, by the sign of det J.

    Where the determinant depends on these two joints and on factors of others alone, they are the aspects of the arm; where
    it depends on more, an aspect may show as several regions. Angles are in degrees.

    Args:
        found: from `kinestatics.singularities`, with a determinant.
        joints: names or columns of two joints: across and up.
        q: (n) where the others are held; a dot marks it. Default: where |det J| is great, unmarked.
        limits: whether to show the two joints between their limits, where they have some; else one turn.
        step: between points of the curves [rad or m].
        ax: axes, or a figure to add them to; default a new figure of one column's width.

    Returns:
        The axes.

    Raises:
        MissingExtraError: KS400; ConfigurationError: KS303, KS398 where there is no determinant; UnknownNameError: KS313;
        ArrayTypeError: KS302.

    Example:
        >>> import kinestatics as ks
        >>> ax = ks.plots.aspect_regions(ks.singularities(ks.load("puma_560")), ["joint2", "joint3"])
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['det J > 0', 'det J < 0', 'shoulder', 'elbow']
    """
    require_set(found)
    held = _regular(found) if q is None else np.asarray(q, dtype=float)
    curves = found.trace(joints, held, step)
    columns = [found.model.joint_names.index(j) if isinstance(j, str) else int(j) for j in joints]
    turns = [found.space.half.ring.turns[c] for c in columns]
    axes = ax if is_axes(ax) else new_axes(ax, _HEIGHT)
    sides = [_side(found, c, turn, limits) for c, turn in zip(columns, turns, strict=True)]
    shown: dict[str, str] = {}
    _tint(axes, found, held, columns, sides, turns)
    for curve in curves:
        points = curve.points[:, columns]
        points = np.vstack([points, points[:1]]) if curve.closed else points
        _draw_turns(axes, _in_degrees(points, turns), color_of(shown, curve.component.label), turns, sides)
    if q is not None:
        axes.plot(*(held[columns] * np.where(turns, 180 / np.pi, 1.0))[:, None], "o", color=TEXT, markersize=4, zorder=4)
    labels = [f"{found.model.joint_names[c]} [{'°' if t else 'm'}]" for c, t in zip(columns, turns, strict=True)]
    for axis, limit, side, turn in zip((axes.xaxis, axes.yaxis), (axes.set_xlim, axes.set_ylim), sides, turns, strict=True):
        limit(*side)
        if turn:
            axis.set_ticks([a for a in range(-720, 721, 90 if np.ptp(side) <= 400 else 180) if side[0] <= a <= side[1]])
    dress(axes, (labels[0], labels[1]), shown, equal=all(turns))
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
    require_set(found)
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
        draw_line(axes, places, color_of(shown, curve.component.label), [0.0, 0.0])
    if around:
        for cusp in found.cusps(step):
            axes.plot(cusp.radius, cusp.height, "o", color=TEXT, markersize=3, zorder=4)
    names = ("distance from axis 1 [m]", "along axis 1 [m]") if around else ("x [m]", "y [m]")
    dress(axes, names, shown, equal=True)
    return axes


def require_set(found: Any) -> None:
    if not isinstance(found, SingularSet):
        message = f"expected a singular set, not {type(found).__name__}"
        raise ArrayTypeError("KS302", message, "found = ks.singularities(arm)")


def _regular(found: SingularSet) -> Array:
    """A posture at which |det J| is great, for what is held."""
    q = found.space.random(200, seed=5)
    return np.asarray(q[int(np.abs(found.fourier.value(q)).argmax())])


def _side(found: SingularSet, column: int, turns: bool, limits: bool) -> tuple[float, float]:
    """From where to where a joint is shown [deg or m]."""
    lower, upper = float(found.model.lower[column]), float(found.model.upper[column])
    bounded = np.isfinite(lower) and np.isfinite(upper)
    if turns:
        return (float(np.degrees(lower)), float(np.degrees(upper))) if bounded and limits else (-180.0, 180.0)
    return (lower, upper) if bounded else (-1.0, 1.0)


def _tint(
    axes: Any, found: SingularSet, held: Array, columns: list[int], sides: list[tuple[float, float]], turns: list[bool]
) -> None:
    """The plane coloured by the sign of the determinant."""
    across, up = (np.linspace(*side, _CELLS) for side in sides)
    q = np.broadcast_to(held, (_CELLS, _CELLS, len(held))).copy()
    for column, values, turn in zip(columns, np.meshgrid(across, up), turns, strict=True):
        q[..., column] = np.radians(values) if turn else values
    values = found.fourier.value(q)
    size = 2 * float(np.abs(values).max()) + 1e-300
    axes.contourf(across, up, values, levels=[-size, 0.0, size], colors=[_NEGATIVE, _POSITIVE], zorder=0)
    for color, word in ((_POSITIVE, "det J > 0"), (_NEGATIVE, "det J < 0")):
        if np.any(values > 0 if color == _POSITIVE else values < 0):
            axes.plot([], [], "s", color=color, markersize=6, label=word)


def _draw_turns(axes: Any, points: Array, color: str, turns: Sequence[bool], sides: Sequence[tuple[float, float]]) -> None:
    """A line, again at every whole turn that is shown."""
    around = [360.0 * t for t in turns]
    shifts = []
    for turn, (low, high) in zip(turns, sides, strict=True):
        count = range(int(np.floor((low - 180) / 360)), int(np.ceil((high + 180) / 360)) + 1) if turn else range(1)
        shifts.append([360.0 * k for k in count if not turn or (360 * k + 180 > low and 360 * k - 180 < high)])
    for right in shifts[0]:
        for high in shifts[1]:
            draw_line(axes, points + np.array([right, high]), color, around)


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


def color_of(shown: dict[str, str], label: str) -> str:
    return shown.setdefault(label, _COLORS[len(shown) % len(_COLORS)])


def draw_line(axes: Any, points: Array, color: str, around: Sequence[float]) -> None:
    """A line, broken where it goes around the torus."""
    breaks = np.zeros(len(points) - 1, dtype=bool)
    for k, turn in enumerate(around):
        if turn:
            breaks |= np.abs(np.diff(points[:, k])) > turn / 2
    for piece in np.split(points, np.flatnonzero(breaks) + 1):
        axes.plot(*piece.T, color=color, linewidth=1.2, zorder=3)


def dress(axes: Any, names: tuple[str, str], shown: dict[str, str], equal: bool) -> None:
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
