"""An analysis: the verdict, a picture, the joints, the Jacobian, what is lost, and what to look at."""

from __future__ import annotations

import numpy as np

from ..analysis import Analysis, Margin
from ..quantities import format_number, largest
from ..report.blocks import Column, Html, Part, bullets, escaped, number, paragraph, table, tag, with_minus
from ..report.findings import list_of, remarks_of
from ..report.overview import tiles_of
from ..report.pictures import pictures_of
from ..report.words import counted, effort_unit, joint_value, kinds_of, margin_words, percent
from ..tasks import model_of
from .frame import beside, head
from .quantities import JACOBIAN_UNITS, jacobian_table
from .robot import pictured, thumbnail

_MOST_JOINTS = 16


def analysis_body(a: Analysis) -> Html | None:
    """An analysis; None for an arm of more joints than anyone reads in a cell."""
    if len(a.joints) > _MOST_JOINTS:
        return None
    held = [f"carries {name} {format_number(mass)} kg" for name, mass in a.payloads.items()]
    about = "; ".join([f"{counted(len(a.joints), 'joint')}, from {a.base} to {a.tip}", *held])
    remarks = remarks_of(a)
    grave = [remark for remark in remarks if remark.severity != "note"]
    notes = [remark for remark in remarks if remark.severity == "note"]
    parts = [
        head(a.robot, about),
        tag("ul", [tile.html() for tile in tiles_of(a)], class_="tiles"),
        list_of(grave) if grave else None,
        beside(_picture(a), _joints(a), _free(a)),
        _jacobian(a),
        tag("details", tag("summary", counted(len(notes), "note")), list_of(notes)) if notes else None,
        paragraph("All of it: ", tag("code", "print(a)"), "; a page to send: ", tag("code", "a.to_html()"), kind="soft"),
    ]
    return escaped(parts)


def _picture(a: Analysis) -> Html | None:
    """What is lost where the arm is singular, else its ellipsoid of velocity, else the arm alone."""
    wanted = ("Lost",) if a.is_singular else ("Velocity", "Force")
    for picture in pictures_of(a):
        if picture.title.startswith(wanted):
            return pictured(
                picture.svg, [picture.title, *(f". {entry.words}" for entry in picture.entries if not entry.color)]
            )
        if "polytope" in picture.title or picture.title == "Loads":
            break  # these take long, and come last
    return thumbnail(model_of(a.jacobian), a.configuration, a.tip, "at this posture")


def _joints(a: Analysis) -> Html | None:
    """Where each joint is, how far it can go, and what it takes to hold still."""
    if not a.joints:
        return None
    margins = {margin.joint: margin for margin in a.margins}
    columns: list[Column | str] = ["Joint", Column("Position"), "Room"]
    rows: list[list[Part]] = []
    for k, (name, kind) in enumerate(kinds_of(a).items()):
        position = joint_value(float(a.configuration[k]), kind)
        rows.append([[tag("span", str(k + 1), class_="index"), "\u00a0", name], position, _room(margins.get(name), kind)])
    torques, shares = a.holding_torques, a.effort_shares
    if torques is not None:
        columns.append(Column("Holding"))
        for row, x, kind in zip(rows, torques, a.kinds, strict=True):
            row.append(number(float(x), effort_unit(kind), largest(torques)))
    if shares is not None and not np.all(np.isnan(shares)):
        columns.append(Column("of the limit"))
        for row, share in zip(rows, shares, strict=True):
            row.append(_share(float(share)))
    held = "; holding: what keeps the arm and its loads still" if torques is not None else ""
    return table(f"Joints: position and room to the nearest limit{held}", columns, rows)


def _room(margin: Margin | None, kind: str) -> Part:
    if margin is None:
        return "no limits"
    return tag("span", margin_words(margin, kind), class_="near" if margin.near else None)


def _share(share: float) -> Html:
    if np.isnan(share):
        return tag("span", "unknown", class_="soft")
    return tag("span", percent(share), class_="bad" if share > 1 else None)


def _free(a: Analysis) -> Html | None:
    """What is held for free where the arm is singular, in words; what is lost is said above."""
    if not a.is_singular:
        return None
    free = bullets((with_minus(screw.text) for screw in a.free_wrenches), kind="force")
    return escaped([paragraph("Held for free, without joint torques:"), free])


def _jacobian(a: Analysis) -> Html | None:
    if not a.joints:
        return None
    counted_values = [f"{x:.4g}" if k < a.rank else "0" for k, x in enumerate(a.singular_values)]
    scaled = f" ({' and '.join(a.scaled)} times {format_number(a.characteristic_length)} m)" if a.scaled else ""
    words = (
        f"Singular values of rows {', '.join(a.task.row_names) or '(none)'}{scaled}: {', '.join(counted_values) or '(none)'}"
    )
    return escaped(
        [head("Jacobian", str(a.jacobian.frame), JACOBIAN_UNITS), jacobian_table(a.jacobian), paragraph(words, kind="soft")]
    )
