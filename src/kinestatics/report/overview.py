"""The top of the page: which arm, the verdict in a few tiles, the findings, where to find what, and the pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..analysis import Analysis
from ..analysis.near import NEAR_EFFORT
from ..quantities import format_number
from .blocks import Html, Part, badge, escaped, number, section, tag
from .findings import list_of, remarks_of
from .page import Report
from .pictures import pictures_of
from .words import counted, kinds_of, margin_words, percent


def header(report: Report) -> Html:
    """The name of the arm, and what this is."""
    a = report.analysis
    about = f"{counted(len(a.joints), 'joint')}, from {a.base} to {a.tip}"
    held = [f"carries {name} {format_number(mass)} kg" for name, mass in a.payloads.items()]
    return tag(
        "header", tag("p", "kinestatics report", class_="eyebrow"), tag("h1", a.robot), tag("p", "; ".join([about, *held]))
    )


def contents(sections: Sequence[Html]) -> Html:
    """Links to the sections."""
    found = [re.match(r'<section id="([a-z-]+)"[^>]*><h2[^>]*>(.*?)</h2>', made) for made in sections]
    links = [tag("li", tag("a", Html(match[2]), href=f"#{match[1]}")) for match in found if match]
    return tag("nav", tag("ul", links, role="list"), aria_label="Contents", class_="contents")


def summary_section(report: Report) -> Html:
    """The verdict, then the findings."""
    a = report.analysis
    tiles = tag("ul", [tile.html() for tile in tiles_of(a)], class_="tiles", role="list")
    findings = tag(
        "section", tag("h3", "Findings", id="findings-title"), list_of(remarks_of(a)), aria_labelledby="findings-title"
    )
    return section("What can this arm do, here?", tiles, findings, id="summary")


class _Tile(NamedTuple):
    """One answer: the question, a badge, the number, and what it means."""

    question: str
    verdict: Html
    answer: Part
    note: Part

    def html(self) -> Html:
        """As an item of the list."""
        head = tag("p", self.question, " ", self.verdict, class_="question")
        return tag("li", head, tag("p", self.answer, class_="answer"), tag("p", self.note, class_="note"))


def tiles_of(a: Analysis) -> Iterator[_Tile]:
    yield _mobility(a)
    if a.near:
        yield _nearest(a)
    yield _room(a)
    yield _effort(a)
    if a.payload_capacity is not None:
        yield _payload(a)


def _mobility(a: Analysis) -> _Tile:
    rows = f"rows in play: {', '.join(a.task.row_names) or 'none'}"
    if a.is_singular:
        names = "" if a.card is None or not a.card.on else f"{', '.join(a.card.on)}; "
        return _Tile("Motion", badge("singular", "bad"), f"rank {a.rank} of {a.task.rank}", names + rows)
    note = f"{rows}; condition {format_number(a.condition)}" if np.isfinite(a.condition) else rows
    verdict = badge("near singular", "warning") if a.close_singularities else badge("full rank", "good")
    return _Tile("Motion", verdict, f"rank {a.rank} of {a.task.rank}", note)


def _nearest(a: Analysis) -> _Tile:
    assert a.near
    first = a.near[0]
    kind = "bad" if a.is_singular and first.value < 1e-6 else "warning" if a.close_singularities else "good"
    turning = "prismatic" not in a.kinds
    answer = number(first.value, "rad" if turning else "rad, m") if np.isfinite(first.value) else "none found"
    degrees = (
        f" ({format_number(round(float(np.degrees(first.value)), 2))}°)" if turning and np.isfinite(first.value) else ""
    )
    word = {"bad": "here", "warning": "near", "good": "far"}[kind]
    return _Tile("Nearest singularity", badge(word, kind), answer, f"{first.component.label}{degrees}, in joint space")


def _room(a: Analysis) -> _Tile:
    question, kinds = "Joint limits", kinds_of(a)
    free = [margin for margin in a.margins if not margin.locked]
    if not free:
        return _Tile(question, badge("unknown", "note"), "no limits", "no joint has known position limits")
    first = min(free, key=lambda margin: (not margin.near, margin.distance))
    outside = any(margin.distance < 0 for margin in free)
    near = [margin for margin in free if margin.near]
    kind = "bad" if outside else "warning" if near else "good"
    word = {"bad": "outside", "warning": "near", "good": "inside"}[kind]
    answer = f"{len(near)} near or passed" if near else "none near"
    return _Tile(question, badge(word, kind), answer, f"{first.joint}: {margin_words(first, kinds[first.joint])}")


def _effort(a: Analysis) -> _Tile:
    question, shares = "Torques to hold still", a.effort_shares
    if shares is None or a.holding_torques is None:
        return _Tile(question, badge("unknown", "note"), "no masses", "neither masses nor loads are known")
    what = "arm" if a.gravity_torques is not None else "loads alone, no masses are known"
    what = "arm and loads" if a.gravity_torques is not None and a.loads else what
    if not np.any(np.isfinite(shares)) and not np.any(np.isinf(shares)):
        k = int(np.abs(a.holding_torques).argmax()) if a.joints else 0
        if not a.joints:
            return _Tile(question, badge("none", "good"), "0", what)
        unit = "N" if a.kinds[k] == "prismatic" else "N m"
        most = number(abs(float(a.holding_torques[k])), unit)
        return _Tile(question, badge("limits unknown", "note"), most, f"most at {a.joints[k]}; {what}")
    k = int(np.nanargmax(shares))
    kind = "bad" if shares[k] > 1 else "warning" if shares[k] > NEAR_EFFORT else "good"
    word = {"bad": "over the limit", "warning": "near the limit", "good": "within limits"}[kind]
    return _Tile(question, badge(word, kind), percent(float(shares[k])), f"of the limit of {a.joints[k]}; {what}")


def _payload(a: Analysis) -> _Tile:
    found = a.payload_capacity
    assert found is not None
    question = "Further payload" if a.payloads else "Greatest payload"
    if not found.holds_itself:
        return _Tile(question, badge("none", "bad"), number(0.0, "kg"), found.verdict)
    value = float(found.value)
    if found.held_by_structure or not np.isfinite(value):
        return _Tile(question, badge("structure", "good"), "unlimited", "no joint feels it here")
    return _Tile(
        question, badge("estimate", ""), number(value, "kg"), f"at {a.tip}, no other load; ends at {found.limiting_joint}"
    )


def pictures_section(report: Report) -> Html:
    """The arm and what it can do, side by side."""
    cards = [picture.figure() for picture in pictures_of(report.analysis)]
    a = report.analysis
    lead = (
        f"Axes of {a.base}; velocities and forces begin at the origin of {a.tip}. Blue is what moves, vermilion what pushes."
    )
    return section("Pictures", tag("div", escaped(cards), class_="pictures"), id="pictures", lead=lead)
