"""What a page with script adds: figures that can be turned and asked, and the arm as a scene of three dimensions."""

from __future__ import annotations

import html
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np

from ..analysis import Analysis
from ..bodies import Body, ellipsoid_body
from ..dexterity import manipulability
from ..dexterity.rows import manipulability_unit
from ..errors import MissingExtraError, missing_extra
from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..palette import EDGE, FORCE, LINK, VELOCITY
from ..plots.shapes import clip_length, metres_per_unit
from ..plots.style import VIEW
from ..quantities import format_number
from ..skeleton import Skeleton, skeleton
from .blocks import Html, raised, section, tag, visible
from .page import STATIC, Report
from .words import joint_unit, joint_value

_STEPS = 121  # of a joint's range
_TURN = np.pi  # either way, of a joint without limits


def policy(scene: bool) -> str:
    """What these pages may do: run what is in them. They still fetch nothing; a scene's WebAssembly calls for eval."""
    more = " 'unsafe-eval' blob:; worker-src blob: data:; connect-src data: blob:" if scene else ""
    return f"{STATIC}; script-src 'unsafe-inline'{more}".replace("img-src data:", "img-src data: blob:")


def extra_section(report: Report, figures: bool, scene: bool) -> Html:
    """The figures and the scene that were asked for."""
    parts: list[Html] = []
    if scene:
        parts.append(_scene(report))
    if figures:
        parts += _figures(report)
    return section("To turn and to try", parts, id="interactive", lead="This part runs script, and works without a network.")


def _scene(report: Report) -> Html:
    """The scene in a frame of its own, that can reach neither this page nor anything else."""
    try:
        from ..scene.export import scene_html
    except MissingExtraError:
        raise
    except ImportError as error:
        raise missing_extra(str(error.name or "viser"), "view", "a scene in a report") from None
    a = report.analysis
    inner = Html(html.escape(scene_html(report.model, a.configuration, a)))
    title = f"{a.robot} in three dimensions"
    return tag("iframe", srcdoc=inner, sandbox="allow-scripts", title=title, class_="scene", loading="lazy")


def _figures(report: Report) -> list[Html]:
    if find_spec("plotly") is None:
        raise missing_extra("plotly", "report", "an interactive report")
    found: list[Html] = []
    for k, (name, words, made) in enumerate(_made(report)):
        text = made.to_html(full_html=False, include_plotlyjs=not k, div_id=f"figure-{name}", config=_CONFIGURATION)
        head = tag("h3", words, id=f"{name}-title")
        found.append(tag("section", head, tag("div", Html(text), class_="turning"), aria_labelledby=f"{name}-title"))
    return found


_CONFIGURATION = {"displayModeBar": False, "responsive": True, "scrollZoom": False}
_LAYOUT: dict[str, Any] = {
    "template": "plotly_white",
    "margin": {"l": 56, "r": 16, "t": 24, "b": 48},
    "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#262626"},
    "legend": {"orientation": "h", "y": -0.25},
    "colorway": [VELOCITY, FORCE, "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#4d4d4d"],
}


def _made(report: Report) -> Iterator[tuple[str, str, Any]]:
    """Every figure with its name and title."""
    yield "arm", "The arm and its ellipsoids, to be turned", _arm_figure(report)
    if report.analysis.task.rank and report.model.n:
        yield "measure", "Manipulability while one joint moves and the others stay", _measure_figure(report)


def _safe(text: str) -> str:
    """Text of a file for plotly, which takes some marks of HTML for its own."""
    return html.escape(visible(text))


def _arm_figure(report: Report) -> Any:
    import plotly.graph_objects as go

    a, model = report.analysis, report.model
    bones = skeleton(model, a.configuration, a.tip, required=True)
    figure = go.Figure()
    figure.add_trace(_line([*bones.links, *bones.rods], LINK, "arm", 8))
    figure.add_trace(_joints(a, bones))
    for found, color in ((a.velocity_ellipsoid, VELOCITY), (a.force_ellipsoid, FORCE)):
        if found is not None and all(row[0] in "vf" for row in found.rows):
            finite = found.radii[np.isfinite(found.radii)]
            metres = metres_per_unit(None, float(finite.max(initial=0.0)), bones, len(finite) == len(found.radii))
            body = ellipsoid_body(found.axes, found.radii, clip_length(bones, metres))
            name = f"{found.kind} ellipsoid (1 m = {format_number(1 / metres)} {'m/s' if color == VELOCITY else 'N'})"
            lift = np.eye(3)[["xyz".index(row[-1]) for row in found.rows]]
            for trace in _body(bones, body, lift, metres, color, name):
                figure.add_trace(trace)
    names = {f"{axis}axis": {"title": {"text": f"{axis} [m]"}} for axis in "xyz"}
    figure.update_layout(
        **_LAYOUT, height=560, scene={"aspectmode": "data", "dragmode": "orbit", "camera": {"eye": _eye()}, **names}
    )
    return figure


def _eye() -> dict[str, float]:
    """From where the arm is seen at first: as in the pictures."""
    elevation, azimuth = np.radians(VIEW)
    x, y, z = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    return {"x": round(2 * float(x), 4), "y": round(2 * float(y), 4), "z": round(2 * float(z), 4)}


def _line(lines: list[Array], color: str, name: str, width: int, **options: Any) -> Any:
    """Lines through points of space as one trace, with gaps between them."""
    import plotly.graph_objects as go

    gap = np.full((1, 3), np.nan)
    points = np.concatenate([part for line in lines for part in (np.asarray(line), gap)]) if lines else gap
    x, y, z = (column.tolist() for column in np.where(np.isnan(points), None, points).T)  # type: ignore[call-overload]
    style = {"color": color, "width": width}
    return go.Scatter3d(x=x, y=y, z=z, mode="lines", name=name, line=style, hoverinfo="skip", **options)


def _joints(a: Analysis, bones: Skeleton) -> Any:
    """A mark on every joint, which tells its name and where it stands."""
    import plotly.graph_objects as go

    points = np.array([joint.point for joint in bones.joints]).reshape(-1, 3)
    texts = [
        f"{_safe(joint.name)}<br>{joint.kind}, {joint_value(float(a.configuration[joint.column]), a.kinds[joint.column])}"
        for joint in bones.joints
    ]
    x, y, z = points.T.tolist()
    marks = {"size": 6, "color": "#ffffff", "line": {"color": EDGE, "width": 2}}
    return go.Scatter3d(x=x, y=y, z=z, mode="markers", name="joints", text=texts, hoverinfo="text", marker=marks)


def _body(bones: Skeleton, body: Body, lift: Array, metres: float, color: str, name: str) -> Iterator[Any]:
    """A body at the tip: its lines, and in space its surface; both go with one entry of the key."""
    import plotly.graph_objects as go

    lines = [bones.tip_point + metres * line @ lift for line in (*body.lines, *body.fading)]
    yield _line(lines, color, name, 3, legendgroup=name)
    points = bones.tip_point + metres * body.points @ lift
    if len(lift) == 3 and np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-9) == 3:
        x, y, z = points.T.tolist()
        surface = {"alphahull": 0, "color": color, "opacity": 0.18, "legendgroup": name, "hoverinfo": "skip"}
        yield go.Mesh3d(x=x, y=y, z=z, name=name, showlegend=False, **surface)


def _measure_figure(report: Report) -> Any:
    """A line for each joint over its range; asked of the workbench in one batch."""
    import plotly.graph_objects as go

    a, model = report.analysis, report.model
    figure = go.Figure()
    for k, (name, kind) in enumerate(zip(a.joints, a.kinds, strict=True)):
        values = _range(model, a, k)
        q = np.repeat(a.configuration[None], len(values), axis=0)
        q[:, k] = values
        measured = manipulability(jacobian(model, q, at=a.tip), task=a.task.rows)
        x = values if kind == "prismatic" else np.degrees(values)
        unit = joint_unit(kind) if kind == "prismatic" else "°"
        shown = f"{_safe(name)} [{unit}]"
        figure.add_trace(go.Scatter(x=np.round(x, 6).tolist(), y=np.asarray(measured).tolist(), mode="lines", name=shown))
    unit = manipulability_unit(a.task, model, a.tip)
    axis = "manipulability" + (f" [{raised(unit)}]" if unit != "1" else "")
    figure.update_layout(
        **_LAYOUT, height=420, xaxis={"title": {"text": "position of the joint"}}, yaxis={"title": {"text": axis}}
    )
    return figure


def _range(model: RobotModel, a: Analysis, k: int) -> Array:
    """Positions of one joint, within its limits or half a turn, or a metre, either way."""
    here = float(a.configuration[k])
    reach = _TURN if a.kinds[k] != "prismatic" else 1.0
    lower, upper = float(model.lower[k]), float(model.upper[k])
    bounded = np.isfinite(lower) and np.isfinite(upper) and upper > lower
    return np.linspace(lower, upper, _STEPS) if bounded else np.linspace(here - reach, here + reach, _STEPS)
