"""How the numbers are meant, and the robot they are of."""

from __future__ import annotations

import numpy as np

from ..quantities import format_number
from ..spatial import ROW_NAMES, WRENCH_NAMES
from .blocks import Column, Html, definitions, number, section, table, tag, with_minus
from .mathematics import formula
from .page import Report
from .words import effort_unit, joint_value, kinds_of, margin_words, rate_unit


def conventions_section(report: Report) -> Html:
    """Frame, point, order, sign, units, characteristic length: in a box of its own, before any matrix."""
    a = report.analysis
    frame = a.jacobian.frame
    pairs = [
        ("Units", "metres, radians, kilograms, newtons, newton metres, seconds"),
        ("Axes", f"those of {frame.axes}, unless a number says otherwise"),
        ("Point", f"velocities are of the origin of {frame.origin}; moments are about it"),
        ("Order", f"linear before angular: twist ({', '.join(ROW_NAMES)}), wrench ({', '.join(WRENCH_NAMES)})"),
        (
            "Sign",
            "a load acts on the robot, a push is what the robot exerts. Torques are what the motors supply to hold still: "
            "minus Jᵀ times a load, plus Jᵀ times a push, plus what holds the weight.",
        ),
        ("Rows in play", f"{', '.join(a.task.row_names) or 'none'}: {a.task.reason}"),
        (
            "Characteristic length",
            f"{format_number(a.characteristic_length)} m"
            + (
                f"; {' and '.join(a.scaled)} are multiplied by it before singular values are taken"
                if a.scaled
                else "; not used"
            ),
        ),
        ("Tolerance", f"singular values below {a.tolerance:g} of the largest count as zero"),
    ]
    return section("How to read the numbers", definitions(pairs, kind="conventions"), id="conventions")


def robot_section(report: Report) -> Html:
    """Posture, joints with their limits, links with their masses, and where the tip is."""
    a = report.analysis
    lead = f"From {a.base} to {a.tip}. Pose of {a.tip}: its axes and origin seen from {a.base}, metres."
    pose = _pose(report)
    return section("Robot and posture", _joints(report), pose, _links(report), id="robot", lead=lead)


def _joints(report: Report) -> Html:
    a, model = report.analysis, report.model
    margins, kinds = {margin.joint: margin for margin in a.margins}, kinds_of(a)
    rows = []
    for k, name in enumerate(a.joints):
        kind, margin = kinds[name], margins.get(name)
        room = "no limits" if margin is None else margin_words(margin, kind)
        speed, effort = float(model.velocity_limits[k]), float(model.effort_limits[k])
        rows.append(
            [
                name,
                kind,
                joint_value(float(a.configuration[k]), kind),
                joint_value(float(model.lower[k]), kind),
                joint_value(float(model.upper[k]), kind),
                tag("span", room, class_="near") if margin is not None and margin.near else room,
                number(speed if np.isfinite(speed) else None, rate_unit(kind)),
                number(effort if np.isfinite(effort) else None, effort_unit(kind)),
            ]
        )
    columns: list[Column | str] = [
        "Joint",
        "Kind",
        Column("Position"),
        Column("Lower"),
        Column("Upper"),
        "Room",
        Column("Speed limit"),
        Column("Effort limit"),
    ]
    caption = "Joints, in the order of q: position, limits, and room to the nearest limit"
    return table(caption, columns, rows)


def _pose(report: Report) -> Html:
    a = report.analysis
    T = np.asarray(a.pose)
    cells = [[format_number(x, float(np.abs(T).max())) for x in row] for row in T]
    body = r" \\ ".join(" & ".join(row) for row in cells)
    latex = rf"T_{{\mathrm{{base}},\mathrm{{tip}}}} = \left[\begin{{array}}{{rrrr}} {body} \end{{array}}\right]"
    return formula(latex, "Pose of the tip", report.mathematics)


def _links(report: Report) -> Html | None:
    model = report.model
    if not model.has_masses:
        return None
    rows = []
    for k, name in enumerate(model.link_names):
        if model.masses[k] > 0:
            center = ", ".join(format_number(x) for x in model.centers_of_mass[k])
            held = " (payload)" if name in model.payloads else ""
            rows.append([f"{name}{held}", number(float(model.masses[k]), "kg"), with_minus(f"({center}) m")])
    total = number(float(model.masses.sum()), "kg")
    caption = ["Masses, ", total, " in all; centres of mass in axes of the link, from its origin"]
    return table(caption, ["Link", Column("Mass"), Column("Centre of mass")], rows)
