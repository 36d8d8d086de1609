"""What the page says in words and tables: markup out of escaped blocks, every number with its unit and frame.

Numbers that a program may want to read stand in full in `data-` attributes beside the rounded ones that people read.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ..analysis import Analysis
from ..quantities import Jacobian, format_number
from ..report.blocks import Html, Part, number, tag, visible, with_minus
from ..singular_sets.distance import Distance
from ..statics import free_wrenches

STYLE = """
<style>
.ks{font:13px/1.45 system-ui,sans-serif;padding:0 .6rem .3rem;font-variant-numeric:tabular-nums}
.ks h4{margin:.5rem 0 .2rem;font-size:12px;font-weight:600}
.ks p{margin:.15rem 0}
.ks .small{font-size:11px;opacity:.78}
.ks .scroll{overflow-x:auto}
.ks table{border-collapse:collapse;width:100%}
.ks th,.ks td{padding:.08rem .2rem;text-align:right;white-space:nowrap}
.ks th:first-child,.ks td.name{text-align:left;max-width:6.2rem;overflow:hidden;text-overflow:ellipsis}
.ks tbody th{width:1%}
.ks thead th{font-weight:500;opacity:.75;border-bottom:1px solid rgba(128,128,128,.4)}
.ks tr.dependent th,.ks tr.dependent td{background:rgba(213,94,0,.16)}
.ks tr.still th,.ks tr.still td{opacity:.45}
.ks .good,.ks .bad{display:inline-block;border-radius:3px;padding:0 .45em;color:#fff;font-weight:600}
.ks .good{background:#0b6e4f}.ks .bad{background:#b3261e}
.ks .track{display:block;position:relative;height:9px;min-width:44px;background:rgba(128,128,128,.18);border-radius:2px}
.ks .track i{position:absolute;top:0;bottom:0;border-radius:2px}
.ks .motion{background:#0072b2}.ks .force{background:#d55e00}.ks .over{background:#b3261e}
.ks .of-motion{color:#0072b2}.ks .of-force{color:#b34d00}
.ks .middle{left:50%;width:1px;background:rgba(128,128,128,.7)}
</style>
"""
"""The one sheet of the page's tables, which stands on the page once; a constant, without any text of a robot."""


def framed(*parts: Part) -> str:
    """Markup for the page's panel."""
    return str(tag("div", *parts, class_="ks"))


def ready() -> str:
    """A sign, seen by programs, that the page has been shown whole."""
    return str(tag("span", data_quantity="ready", hidden=True))


def verdict(a: Analysis, near: Sequence[Distance] | None, words: str) -> str:
    """The line at the top: rank, how far the nearest singularity is, what is lost; and what the page has to say."""
    state = tag("span", "singular" if a.is_singular else "regular", class_="bad" if a.is_singular else "good")
    least = _least(a)
    rows = ", ".join(a.task.row_names) or "no rows"
    meter = tag(
        "p",
        state,
        f" rank {a.rank} of {a.task.rank} in {rows}",
        data_quantity="verdict",
        data_singular=str(a.is_singular).lower(),
        data_rank=a.rank,
        data_least=repr(least),
    )
    lost = [tag("p", tag("b", "lost: ", class_="of-motion"), screw.text) for screw in a.lost_twists] if a.is_singular else []
    free = (
        [tag("p", tag("b", "held for free: ", class_="of-force"), screw.text) for screw in a.free_wrenches]
        if a.is_singular
        else []
    )
    status = tag("p", words, class_="small", role="status") if words else None
    return framed(meter, _nearest_line(near), lost[:2], free[:2], status)


def _least(a: Analysis) -> float:
    """The smallest singular value that counts, over the largest."""
    sigma = a.singular_values
    return float(sigma[a.task.rank - 1] / sigma[0]) if a.task.rank and sigma[0] > 0 else 0.0


def _nearest_line(near: Sequence[Distance] | None) -> Html:
    if near is None:
        return tag("p", "nearest singularity: looking …", class_="small", data_quantity="nearest", data_name="")
    reached = [distance for distance in near if np.isfinite(distance.value)]
    if not reached:
        return tag("p", "no singularity is known", class_="small", data_quantity="nearest", data_name="")
    first = reached[0]
    return tag(
        "p", f"nearest: {first}", data_quantity="nearest", data_name=first.component.label, data_distance=repr(first.value)
    )


def singular_values(a: Analysis) -> str:
    """Bars of the singular values; those that count as zero say so."""
    largest = float(a.singular_values.max(initial=0.0)) or 1.0
    rows = []
    for k, value in enumerate(a.singular_values):
        counts = k < a.rank
        bar = tag("span", tag("i", class_="motion", style=f"left:0;width:{100 * value / largest:.2f}%"), class_="track")
        shown = number(float(value)) if counts else tag("span", "0")
        rows.append(
            tag(
                "tr",
                tag("th", f"σ{k + 1}"),
                tag("td", bar),
                tag("td", shown, data_quantity=f"sigma{k + 1}", data_value=repr(float(value))),
            )
        )
    scaled = f"{' and '.join(a.scaled)} times {format_number(round(a.characteristic_length, 4))} m; " if a.scaled else ""
    condition = format_number(a.condition) if np.isfinite(a.condition) else "infinite"
    note = f"{scaled}condition {condition}; manipulability {format_number(a.manipulability)} {a.manipulability_unit}"
    return framed(tag("h4", "singular values"), tag("table", tag("tbody", rows)), tag("p", note, class_="small"))


def jacobian(J: Jacobian, a: Analysis) -> str:
    """The Jacobian as a table; rows that depend on others here are coloured, rows that are always zero are pale.

    Rows depend on each other where a wrench is held for free: Jᵀ w = 0 is a sum of rows that vanishes.
    """
    free = free_wrenches(J, a.characteristic_length)
    array = J.array
    still = ~np.any(np.abs(array) > 1e-12 * (np.abs(array).max(initial=0.0) or 1.0), axis=1)
    involved = np.abs(free[:, ~still]).max(axis=0, initial=0.0) > 1e-9
    dependent = np.zeros(len(array), dtype=bool)
    dependent[~still] = involved
    largest = float(np.abs(array).max(initial=0.0))
    head = tag("tr", tag("th", "", scope="col"), [tag("th", str(k + 1), scope="col") for k in range(array.shape[1])])
    rows = []
    for name, row, pale, tied in zip(J.rows, array, still, dependent, strict=True):
        cells = [_value_cell(x, largest) for x in row.tolist()]
        kind = "still" if pale else "dependent" if tied else None
        rows.append(tag("tr", tag("th", name, scope="row"), cells, class_=kind, data_row=name))
    where = f"axes of {J.frame.axes}, at the origin of {J.frame.origin}; rows v [m/s], w [rad/s] per unit joint rate"
    names = "joints: " + ", ".join(f"{k + 1} {name}" for k, name in enumerate(J.joint_names))
    says = "coloured rows depend on each other: no joint motion tells them apart" if dependent.any() else None
    table = tag("table", tag("thead", head), tag("tbody", rows))
    return framed(
        tag("p", where, class_="small"),
        tag("div", table, class_="scroll"),
        tag("p", says, class_="small") if says else None,
        tag("p", names, class_="small"),
    )


def torques(a: Analysis) -> str:
    """What holds the arm still: gravity, load, both, and a bar against each joint's effort limit."""
    gravity, load, both = a.gravity_torques, a.joint_torques, a.holding_torques
    if both is None:
        return framed(tag("p", "no masses are known, and no load is set: no torques to show", data_quantity="torques"))
    limits = a.effort_limits
    known = limits[np.isfinite(limits)]
    full = float(max(np.abs(both).max(initial=0.0), known.max(initial=0.0))) or 1.0
    rows = []
    for k, (name, kind) in enumerate(zip(a.joints, a.kinds, strict=True)):
        limit, total = float(limits[k]), float(both[k])
        range_of = limit if np.isfinite(limit) and limit > 0 else full
        cells = [
            tag("td", "–") if part is None else _value_cell(float(part[k]), full, data_quantity=what, data_joint=name)
            for what, part in (("gravity", gravity), ("load", load), ("holding", both))
        ]
        unit = "N" if kind == "prismatic" else "N m"
        named = tag("td", f"{k + 1} {name}", class_="name", title=f"{name} [{unit}]")
        limit_cell = tag("td", f"{limit:.4g}" if np.isfinite(limit) else "–")
        rows.append(tag("tr", named, cells, limit_cell, tag("td", _bar(total / range_of, limit))))
    words = ("joint", "gravity", "load", "both", "limit", "")
    head = tag("tr", [tag("th", word, scope="col") for word in words])
    table = tag("table", tag("thead", head), tag("tbody", rows))
    sign = "what the motors supply to hold still, N m for turning and N for sliding joints"
    missing = None if gravity is not None else tag("p", "no masses are known: without the arm's own weight", class_="small")
    return framed(tag("p", sign, class_="small"), tag("div", table, class_="scroll"), missing)


def _value_cell(value: float, beside: float, **names: str) -> Html:
    """A cell with a number; written out, for a page makes hundreds of them a second. `names`: attributes."""
    marks = "".join(f' {key.replace("_", "-")}="{escape(visible(name))}"' for key, name in names.items())
    shown = format_number(value, beside)
    rounded = f"{value:.3f}" if len(shown) > 6 and abs(value) < 1e3 else shown
    return Html(f'<td data-value="{value!r}"{marks}>{with_minus(rounded)}</td>')


def _bar(share: float, limit: float) -> Html:
    """A bar from the middle, to the right for a positive torque; red beyond the limit."""
    over = np.isfinite(limit) and abs(share) > 1
    width = 50 * min(abs(share), 1.0)
    left = 50.0 if share >= 0 else 50.0 - width
    inner = tag("i", class_="over" if over else "force", style=f"left:{left:.2f}%;width:{width:.2f}%")
    return tag("span", inner, tag("i", class_="middle"), class_="track", aria_hidden="true")


def nearest(near: Sequence[Distance] | None, problem: str) -> str:
    """Every known singularity, the nearest first, with the proved bound."""
    if problem:
        return framed(tag("p", problem))
    if near is None:
        return framed(tag("p", "looking for the arm's singularities …"))
    if not near:
        return framed(tag("p", "no singularity was found for this task"))
    rows = []
    for distance in near:
        value = format_number(distance.value) if np.isfinite(distance.value) else "–"
        degrees = f"{format_number(round(float(np.degrees(distance.value)), 2))}°" if np.isfinite(distance.value) else "–"
        far = distance.nearest is None
        rows.append(
            tag(
                "tr",
                tag("td", distance.component.label, class_="name", title=str(distance), data_quantity="singularity"),
                tag("td", value, data_value=repr(distance.value)),
                tag("td", degrees),
                tag("td", format_number(distance.at_least) if np.isfinite(distance.at_least) else "–"),
                class_="still" if far else None,
            )
        )
    head = tag("tr", [tag("th", word, scope="col") for word in ("singularity", "rad", "deg", "at least")])
    words = (
        "to the nearest posture inside the joint limits, √Σ(q − nearest)² [rad, m for sliding joints]; “at least” is proved"
    )
    pale = (
        tag("p", "pale: none was found inside the joint limits; without a bound too, there is none, proved", class_="small")
        if any("still" in row for row in rows)
        else None
    )
    return framed(tag("table", tag("thead", head), tag("tbody", rows)), tag("p", words, class_="small"), pale)


def card(text: str) -> str:
    """The card of a posture, as it prints."""
    return framed(tag("pre", text, style="white-space:pre-wrap;font-size:11px;margin:.2rem 0"))
