"""Where the arm is singular: its singularities by name, how far they are from here, and the card of this posture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..analysis import Analysis
from ..quantities import format_number
from .blocks import Column, Html, Part, bullets, definitions, escaped, number, paragraph, section, table, tag, with_minus
from .page import Report
from .words import joint_unit

if TYPE_CHECKING:
    from ..singular_sets.card import Card
    from ..singular_sets.components import Component
    from ..singular_sets.distance import Distance
    from ..singular_sets.equations import Equation

_READABLE = 260  # characters of LaTeX in one line


def singular_section(report: Report) -> Html:
    """The table of singularities, then this posture's card."""
    a = report.analysis
    title = "Singularities"
    if a.singular_set is None or a.near is None or a.card is None:
        why = next((note for note in a.notes if note.startswith("singularities")), None)
        words = f"{why[:1].upper()}{why[1:]}." if why else "Not looked for: ask with ks.analyze(arm, q, singularities=True)."
        return section(title, paragraph(words), id="singularities")
    rows = ", ".join(a.task.row_names)
    lead = f"Postures where the rank of {rows} is less than {a.task.rank}. Distances are in joint space, √Σ(Δq)²."
    if not a.near:
        sure = a.singular_set.never
        text = (
            "The arm is never singular in these rows."
            if sure
            else "No singularity was found; that there is none is not proved."
        )
        return section(title, paragraph(text), _card(a, a.card), id="singularities", lead=lead)
    return section(title, _table(report), _card(a, a.card), id="singularities", lead=lead)


def _table(report: Report) -> Html:
    a = report.analysis
    turning = "prismatic" not in a.kinds
    rows = [
        [_name(d), *_distance(d, turning), _rank(d), _within(d), list(_conditions(report, d.component))]
        for d in a.near or ()
    ]
    unit = "rad" if turning else "rad, m"
    columns: list[Column | str] = [
        "Name",
        Column("Distance", unit),
        Column("Proved at least", unit),
        "Rank there",
        "Joint limits",
        "Condition",
    ]
    return table("Singularities, the nearest first", columns, rows)


def _name(distance: Distance) -> str:
    return distance.component.label


def _conditions(report: Report, component: Component) -> Iterator[Part]:
    """Its equations, each as mathematics, with the joint values that solve it."""
    for k, equation in enumerate(component.equations):
        yield tag("div", "and " if k else None, _equation(report, equation), class_="condition")
    if component.others:
        yield tag("div", f"and {len(component.others)} products of factors that were not split")


def _equation(report: Report, equation: Equation) -> list[Part]:
    from ..symbolic.latex import to_latex

    latex = "" if equation.long else to_latex(equation.expression)
    if not latex or len(latex) > _READABLE:
        return [tag("code", with_minus(equation.text()))]
    parts: list[Part] = [report.mathematics(f"{latex} = 0", False)]
    if equation.solutions:
        kind = report.model.joint_kinds[equation.columns[0]]
        joint = report.mathematics(f"q_{{{equation.columns[0] + 1}}}", False)
        sizes = (x if kind == "prismatic" else np.degrees(x) for x in equation.solutions)
        unit = " m" if kind == "prismatic" else "°"
        values = with_minus(", ".join(f"{format_number(round(float(x), 4))}{unit}" for x in sizes))
        parts += [" ", tag("span", "at ", joint, f" = {values}", class_="solutions")]
    return parts


def _distance(distance: Distance, turning: bool) -> list[Part]:
    if not np.isfinite(distance.value):
        return ["no posture was found", ""]
    degrees = f" ({format_number(round(float(np.degrees(distance.value)), 2))}°)" if turning else None
    return [[number(distance.value), degrees], number(distance.at_least)]


def _rank(distance: Distance) -> Part:
    component = distance.component
    taken = f", takes {component.codimension} of the freedoms" if component.codimension else ""
    return f"{component.rank}{taken}" if component.rank is not None else "not found"


def _within(distance: Distance) -> str:
    return {True: "inside", False: "outside", None: "not seen inside"}[distance.component.within_limits]


def _card(a: Analysis, card: Card) -> Html:
    """What is to be known about this posture."""
    state = f"singular: {' and '.join(card.on) or 'on no component that was found'}" if card.is_singular else "not singular"
    pairs: list[tuple[Part, Part]] = [("State", f"{state}; rank {card.rank}, elsewhere {card.task.rank}")]
    if card.lost and card.is_singular:
        pairs.append(("Lost", bullets(with_minus(screw.text) for screw in card.lost)))
        pairs.append(("Held for free", bullets(with_minus(screw.text) for screw in card.free)))
    if card.axes:
        pairs.append(("Axes", bullets(relation.text for relation in card.axes)))
    if card.is_singular and len(card.decomposition.null_motion):
        pairs.append(("Null motion", bullets(with_minus(_motion(a, row)) for row in card.decomposition.null_motion)))
    if card.second_order is not None:
        pairs.append(("Class", [tag("strong", card.second_order.kind), f": {card.second_order.text}"]))
    pairs += [("Speed", with_minus(card.speed_words)), ("Force", card.force_words)]
    nearest = [distance for distance in card.near[:1] if distance.nearest is not None and not card.is_singular]
    pairs += [(f"Nearest ({d.component.label})", with_minus(f"q = ({_values(a, d.nearest)})")) for d in nearest]
    if not card.complete:
        pairs.append(("Complete", "no: time ran out, there may be other singularities"))
    inner = [tag("h3", "This posture", id="card"), definitions(pairs, kind="card")]
    return tag("section", escaped(inner), aria_labelledby="card")


def _motion(a: Analysis, row: object) -> str:
    """A joint motion, its largest entry 1."""
    rates = np.asarray(row, dtype=float)
    scale = rates / np.abs(rates).max()
    pairs = zip(a.joints, a.kinds, scale, strict=True)
    return ", ".join(
        f"{name} {format_number(round(float(x), 6))} {joint_unit(kind)}/s" for name, kind, x in pairs if abs(x) > 1e-7
    )


def _values(a: Analysis, q: object) -> str:
    """A posture."""
    values = np.asarray(q, dtype=float)
    return ", ".join(f"{format_number(x)} {joint_unit(kind)}" for x, kind in zip(values, a.kinds, strict=True))
