"""A robot: its joints with their limits, and a picture of it at home."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import KinestaticsError
from ..frames import TIP
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import format_number
from ..report.blocks import Column, Html, Part, bullets, escaped, number, table, tag
from ..report.pictures import arm_picture
from ..report.words import counted, effort_unit, joint_value, rate_unit
from .frame import beside, head

_MOST_ROWS = 32
_LARGEST_PICTURE = 24_000  # characters


def robot_body(model: RobotModel) -> Html:
    """A robot."""
    about = f"{counted(model.n, 'joint')} from {model.base} to {model.tip or '(no tip)'}"
    picture = thumbnail(model, model.home, model.tip or TIP, "at home")
    facts = bullets(_facts(model), kind="facts")
    return escaped([head(model.name, about), beside(picture, _joints(model), facts)])


def thumbnail(model: RobotModel, q: Array, at: str, caption: Part, numbers: bool = True) -> Html | None:
    """The arm at a posture, small; None where it cannot be drawn: an arm of symbols, or one of many joints."""
    if model.is_symbolic or not np.all(np.isfinite(q)):
        return None
    try:
        return pictured(arm_picture(model, q, at, names=numbers).svg, caption)
    except KinestaticsError:
        return None


def pictured(svg: Html, caption: Part) -> Html | None:
    """A picture over its caption; None where it is too large for a notebook that is kept."""
    if len(svg) > _LARGEST_PICTURE:
        return None
    return tag("figure", svg, tag("figcaption", caption))


def _joints(model: RobotModel) -> Html:
    rows = []
    for k, (name, kind) in enumerate(zip(model.joint_names[:_MOST_ROWS], model.joint_kinds, strict=False)):
        speed, effort = float(model.velocity_limits[k]), float(model.effort_limits[k])
        rows.append(
            [
                [tag("span", str(k + 1), class_="index"), "\u00a0", name],
                kind,
                joint_value(float(model.lower[k]), kind),
                joint_value(float(model.upper[k]), kind),
                number(speed if np.isfinite(speed) else None, rate_unit(kind)),
                number(effort if np.isfinite(effort) else None, effort_unit(kind)),
            ]
        )
    columns: list[Column | str] = ["Joint", "Kind", *map(Column, ("Lower", "Upper", "Speed", "Effort"))]
    return table("Joints, in the order of q, and their limits", columns, rows)


def _facts(model: RobotModel) -> Iterator[Part]:
    """What is to be known beside the joints."""
    if model.n > _MOST_ROWS:
        yield f"{model.n - _MOST_ROWS} more joints are not shown: print it"
    for name, value in model.frozen.items():
        yield f"{name} held at {value:g}"
    if model.has_masses and not model.has_symbolic_masses:
        yield ["mass ", number(float(model.masses.sum()), "kg"), f" in {counted(int((model.masses > 0).sum()), 'link')}"]
    elif not model.has_masses:
        yield "no masses are known"
    for name in model.payloads:
        yield f"carries {name}, {format_number(model.masses[model.link_names.index(name)])} kg"
    if model.findings:
        words = bullets(f"{found.code}: {found.message}" for found in model.findings[:_MOST_ROWS])
        yield tag("details", tag("summary", counted(len(model.findings), "finding"), " of its file"), words)
