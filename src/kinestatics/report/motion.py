"""What the arm can move: the Jacobian in numbers and in closed form, its singular values, directions, speeds and pushes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..analysis import Analysis
from ..errors import KinestaticsError
from ..model import RobotModel
from ..quantities import format_number, largest
from ..spatial import ANGULAR, LINEAR, ROW_NAMES, split_pose
from ..symbolic.latex import labelled
from ..symbolic.latex_names import decimal, symbol
from .blocks import (
    Column,
    Html,
    Part,
    bar,
    bullets,
    definitions,
    escaped,
    number,
    paragraph,
    section,
    table,
    tag,
    with_minus,
)
from .mathematics import formula
from .page import Report

_SHORT_NAME = 12  # characters of a joint's name that fit above a column
_MOST_JOINTS, _MOST_OPERATIONS = 7, 260  # of a closed form that is read on a page
_MOST_ANGLES, _RIGHT = 3, 1e-9  # general angles of it; and how far a right one may be off


def jacobian_section(report: Report) -> Html:
    """The matrix with its rows and joints named, and the formulas behind it."""
    a = report.analysis
    lead = f"In {a.jacobian.frame}; columns are joints. {_units(a)}"
    title = "Jacobian"
    if not a.joints:
        return section(title, paragraph("The arm has no joints."), id="jacobian")
    latex = rf"J = {_numbers(a)}"
    shown = formula(latex, "Jacobian", report.mathematics)
    names = None if _are_short(a.joints) else bullets((f"{k + 1} {name}" for k, name in enumerate(a.joints)), kind="legend")
    return section(title, shown, names, _closed_forms(report), id="jacobian", lead=lead)


def _units(a: Analysis) -> str:
    """Of its entries."""
    turning = "m/s for each rad/s in linear rows, rad/s for each rad/s in angular rows"
    sliding = "m/s for each m/s in linear rows, none in angular rows"
    slides = [kind == "prismatic" for kind in a.kinds]
    if not any(slides):
        return f"Units: {turning}."
    return f"Units: {sliding}." if all(slides) else f"Units: turning joints {turning}; sliding joints {sliding}."


def _are_short(names: tuple[str, ...]) -> bool:
    return all(len(name) <= _SHORT_NAME for name in names)


def _numbers(a: Analysis) -> str:
    """The matrix as LaTeX."""
    J = a.jacobian.array
    cells = []
    for half in (LINEAR, ANGULAR):
        size = largest(J[half])
        cells += [[decimal(format_number(x, size)) for x in row] for row in J[half]]
    heads = a.joints if _are_short(a.joints) else tuple(str(k + 1) for k in range(len(a.joints)))
    return labelled(cells, ROW_NAMES, heads)


def _closed_forms(report: Report) -> Html:
    """Jacobian and determinant as formulas, or why they are left out."""
    return tag(
        "section", tag("h3", "In closed form", id="closed-forms"), list(_formulas(report)), aria_labelledby="closed-forms"
    )


def _formulas(report: Report) -> Iterator[Html]:
    a, model = report.analysis, report.model
    if model.n > _MOST_JOINTS:
        yield paragraph(
            f"Left out: with {model.n} joints the formulas are too long to read. `kinestatics export` writes them."
        )
        return
    if _general_angles(model) > _MOST_ANGLES:
        yield paragraph(
            "Left out: the arm has many general angles, as a calibrated one has. `kinestatics export` writes them."
        )
        return
    try:
        from ..symbolic.closed_form import closed_form
        from ..symbolic.latex import to_latex

        form = closed_form("jacobian", model, at=a.tip, lengths="symbols")
    except KinestaticsError as error:
        yield paragraph(f"Left out: {error.message}." + (f" {error.hint}" if error.hint else ""))
        return
    if form.operations > _MOST_OPERATIONS:
        yield paragraph(f"Left out: it takes {form.operations} operations to write. `kinestatics export` writes it.")
        return
    values = dict(form.values)
    yield paragraph(f"The Jacobian in {form.where}, where it is shortest:")
    yield formula(rf"J = {to_latex(form)}", "Jacobian in closed form", report.mathematics)
    found = a.singular_set
    if found is not None and found.determinant is not None and not any(equation.long for equation, _ in found.factors):
        yield paragraph(f"Its determinant, rows {', '.join(found.task.row_names)}, the same in all axes:")
        yield formula(rf"\det J = {to_latex(found.determinant)}", "Determinant", report.mathematics)
        values |= found.lengths
    yield _legend(report, values)


def _general_angles(model: RobotModel) -> int:
    """Joints whose frames are turned by other than right angles: what makes formulas long."""
    turned = np.abs(split_pose(np.asarray(model.placements, dtype=float))[0])
    return int(np.any((turned > _RIGHT) & (turned < 1.0 - _RIGHT), axis=(-2, -1)).sum())


def _legend(report: Report, values: dict[object, object]) -> Html:
    """What the letters stand for."""
    write = report.mathematics
    items: list[Part] = [[write("q_k", False), " the joints in order, ", write("s_{12} = \\sin(q_1 + q_2)", False), ", "]]
    items = [[*items, write("c_{12} = \\cos(q_1 + q_2)", False)]]
    named = sorted(values.items(), key=lambda pair: str(pair[0]))
    items += [write(rf"{symbol(str(name))} = {format_number(float(value))}\,\mathrm{{m}}", False) for name, value in named]  # type: ignore[arg-type]
    return bullets(items, kind="legend")


def motion_section(report: Report) -> Html:
    """Rank, singular values, what is lost, ellipsoids, and what the limits allow."""
    a = report.analysis
    length = f"{' and '.join(a.scaled)} times {format_number(a.characteristic_length)} m" if a.scaled else "nothing scaled"
    lead = f"Rows {', '.join(a.task.row_names) or '(none)'}; {length}."
    parts = [_measures(a), _singular_values(a), _directions(a), _ellipsoids(a), _abilities(a)]
    return section("Motion and force", escaped(part for part in parts if part), id="motion", lead=lead)


def _measures(a: Analysis) -> Html:
    unit = {"1": "", "mixed units": "(mixed units)"}.get(a.manipulability_unit, a.manipulability_unit)
    pairs = [
        ("Rank", f"{a.rank} of {a.task.rank}: {'singular' if a.is_singular else 'not singular'}"),
        ("Condition", number(a.condition) if np.isfinite(a.condition) else "infinite"),
        ("Isotropy", number(0.0 if a.is_singular else a.isotropy)),
        ("Manipulability", number(0.0 if a.is_singular else a.manipulability, unit)),
    ]
    return definitions(pairs, kind="measures")


def _singular_values(a: Analysis) -> Html | None:
    if not len(a.singular_values):
        return None
    greatest = float(a.singular_values[0]) or 1.0
    linear = any(row[0] == "v" for row in a.task.row_names)
    joints = "m/s" if all(kind == "prismatic" for kind in a.kinds) and not a.scaled else "rad/s"
    unit = f"{'m/s' if linear else 'rad/s'} per {joints}"
    rows = []
    for k, value in enumerate(a.singular_values):
        counts = k < a.rank
        shown = number(float(value)) if counts else ["0 ", tag("span", "counts as zero", class_="near")]
        rows.append([["σ", tag("sub", str(k + 1))], shown, bar(float(value) / greatest if counts else 0.0, "motion")])
    columns: list[Column | str] = ["σ", Column("Value", unit), "Share of the largest"]
    return table("Singular values of the rows in play", columns, rows)


def _directions(a: Analysis) -> Html:
    """What is lost and what is held for free, in words."""
    if not a.lost_twists:
        return paragraph("No direction of the task is lost, and every wrench in it is felt by some joint.")
    always = len(a.task.rows) - a.task.rank
    head = "Lost here" if a.is_singular else "Without motion, as in every posture"
    if a.is_singular and always > 0:
        head += f" (of them {always} in every posture)"
    lost = [tag("h4", head), bullets((with_minus(screw.text) for screw in a.lost_twists), kind="motion")]
    free = [
        tag("h4", "Held for free: no joint torque"),
        bullets((with_minus(screw.text) for screw in a.free_wrenches), kind="force"),
    ]
    inner = [tag("h3", "Directions", id="directions"), tag("div", tag("div", lost), tag("div", free), class_="columns")]
    return tag("section", inner, aria_labelledby="directions")


def _ellipsoids(a: Analysis) -> Html | None:
    """Both as one table: they share their axes."""
    velocity, force = a.velocity_ellipsoid, a.force_ellipsoid
    if velocity is None or force is None:
        return None
    rows = []
    for k, (speed, strength, axis) in enumerate(zip(velocity.radii, force.radii, velocity.axes.T, strict=True)):
        rows.append(
            [str(k + 1), number(float(speed)), number(float(strength)), *(number(float(x), beside=1.0) for x in axis)]
        )
    columns: list[Column | str] = [
        "Half-axis",
        Column("Speed", velocity.unit),
        Column("Force", force.unit),
        *(Column(row) for row in velocity.rows),
    ]
    caption = f"Ellipsoids at joint speeds and joint torques of size 1: half-axes and their directions in axes of {a.base}"
    return table(caption, columns, rows)


def _abilities(a: Analysis) -> Html | None:
    """What the limits of the joints allow along each axis."""
    if not a.abilities:
        return None
    rows = [
        [
            able.direction.replace("-", "\N{MINUS SIGN}"),
            number(able.speed),
            ", ".join(able.speed_joints),
            number(able.push),
            ", ".join(able.push_joints),
        ]
        for able in a.abilities
    ]
    rest = [row for row in a.speed_rows if not row.startswith("v")]
    still = f"; the speed is that of pure translation, {', '.join(rest)} at rest" if rest else ""
    caption = f"With the limits of the joints, along axes of {a.base}, other loads left out{still}"
    columns: list[Column | str] = ["Direction", Column("Speed", "m/s"), "ends at", Column("Push", "N"), "ends at"]
    return table(caption, columns, rows)
