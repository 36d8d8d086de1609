"""What holds the arm still: torques against their limits, who holds each load, and what the bearings carry."""

from __future__ import annotations

import numpy as np

from ..analysis import Analysis
from ..analysis.near import NEAR_EFFORT
from ..analysis.result import AppliedLoad
from ..namespaces import Array
from ..quantities import Wrench, format_number, largest
from ..spatial import WRENCH_NAMES
from .blocks import Column, Html, bar, escaped, number, paragraph, section, table, tag, with_minus
from .page import Report
from .words import effort_unit, percent

_UNITS = dict(zip(WRENCH_NAMES, ("N", "N", "N", "N m", "N m", "N m"), strict=True))


def statics_section(report: Report) -> Html:
    """Torques of weight and loads against the limits of the motors."""
    a = report.analysis
    pull = ", ".join(format_number(x) for x in a.gravity)
    lead = with_minus(f"Torques that the motors supply to hold the arm still; gravity ({pull}) m/s² in axes of {a.base}.")
    parts = [_torques(a), *map(_load, a.loads), _energy(a), _capacity(a)]
    if not any(parts):
        parts = [paragraph("Neither masses nor loads are known: there are no torques to show.")]
    return section("Statics", escaped(part for part in parts if part), id="statics", lead=lead)


def _parts(a: Analysis) -> list[tuple[str, Array]]:
    """The columns of the table of torques."""
    word = "Loads" if a.wrench is None else {"robot": "Load", "environment": "Push"}[a.wrench.acts_on]
    parts = [("Weight", a.gravity_torques), (word, a.joint_torques)]
    known = [(name, values) for name, values in parts if values is not None]
    if len(known) == 2 and a.holding_torques is not None:
        known.append(("Both", a.holding_torques))
    return known


def _torques(a: Analysis) -> Html | None:
    parts, shares = _parts(a), a.effort_shares
    if not parts or shares is None or not a.joints:
        return None
    rows = []
    for k, (name, kind) in enumerate(zip(a.joints, a.kinds, strict=True)):
        unit, limit = effort_unit(kind), float(a.effort_limits[k])
        values = [number(float(x[k]), unit, largest(x)) for _, x in parts]
        known = np.isfinite(limit)
        rows.append([name, *values, number(limit if known else None, unit if known else ""), _share(float(shares[k]))])
    columns: list[Column | str] = ["Joint", *(Column(name) for name, _ in parts), Column("Limit"), "Share of the limit"]
    what = parts[-1][0].lower()
    return table(
        f"Holding torques, and the share of the effort limit that {what} take{'s' * (what not in ('loads', 'both'))}",
        columns,
        rows,
    )


def _share(share: float) -> Html:
    """A bar and its number; the colour says what the word says too."""
    if np.isnan(share):
        return tag("span", "limit unknown", class_="word")
    kind = "bad" if share > 1 else "warning" if share > NEAR_EFFORT else "force"
    word = {"bad": " over the limit", "warning": " near the limit"}.get(kind, "")
    return tag("span", bar(share, kind), " ", percent(share), word, class_="share")


def _load(load: AppliedLoad) -> Html:
    """Who holds a load."""
    push = load.wrench.acts_on == "environment"
    what = "Push of the robot on its surroundings" if push else "Load on the robot"
    split, size = load.split, largest(load.wrench.array)
    rows = [
        _wrench_row("as given", split.load, size),
        _wrench_row("made by the motors" if push else "held by the motors", split.active, size),
        _wrench_row("held by the structure", split.structure, size),
    ]
    if split.passive:
        rows.append(_wrench_row("held by nobody", split.impossible, size))
    columns: list[Column | str] = ["Part", *(Column(name, unit) for name, unit in _UNITS.items())]
    return table(f"{what} at {load.link}: {load.wrench.frame}", columns, rows)


def _wrench_row(name: str, wrench: Wrench, size: float) -> list[str | Html]:
    array = np.asarray(wrench.array, dtype=float)
    return [name, *(number(float(x) if abs(x) >= 1e-9 * size else 0.0) for x in array)]


def _energy(a: Analysis) -> Html | None:
    if a.potential_energy is None:
        return None
    return paragraph("Potential energy ", number(a.potential_energy, "J"), f", zero at the origin of {a.base}.")


def _capacity(a: Analysis) -> Html | None:
    if a.payload_capacity is None:
        return None
    more = " more" if a.payloads else ""
    return paragraph(f"Greatest mass held at {a.tip}{more}, no other load: {a.payload_capacity.verdict}.")


def reactions_section(report: Report) -> Html | None:
    """What the bearings of the joints and the ground carry."""
    a = report.analysis
    found = a.reactions
    if found is None or not found.joints:
        return None
    names = ("radial", "axial", "bending", "torsion", "drive")
    columns = [getattr(found, name) for name in names]
    rows = []
    for k, (joint, kind) in enumerate(zip(found.joints, found.kinds, strict=True)):
        values = [number(float(column[k]), beside=largest(column)) for column in columns[:-1]]
        rows.append([joint, *values, number(float(found.drive[k]), effort_unit(kind), largest(found.drive))])
    titles = [Column(name.capitalize(), unit) for name, unit in zip(names[:-1], ("N", "N", "N m", "N m"), strict=True)]
    bearings = table(
        "What a bearing carries, about its axis, and what the motor supplies", ["Joint", *titles, Column("Drive")], rows
    )
    ground = [number(float(x), beside=largest(found.base)) for x in found.base]
    base = table(
        f"What the ground exerts on the whole arm: axes of {a.base}, at its origin",
        ["Body", *(Column(name, unit) for name, unit in _UNITS.items())],
        [["ground", *ground]],
    )
    lead = "Forces across and along each joint's axis, and moments about it, with the arm held still."
    return section("Reactions", bearings, base, id="reactions", lead=lead)
