"""What the reader should know first: what is wrong, what is near, what is missing, and what to do about it.

The judgements are those of the analysis; here they are only put into words and in order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..analysis import Analysis
from ..analysis.near import NEAR_EFFORT
from ..quantities import format_number
from ..tasks import model_of
from .blocks import Html, badge, paragraph, tag, with_minus
from .words import effort_unit, joint_unit, kinds_of, listed, margin_words, percent

SEVERITIES = ("problem", "warning", "note")
"""The gravest first: the arm cannot do it; it is close to not; something is not known."""


class Remark(NamedTuple):
    """One finding.

    Attributes:
        severity: one of SEVERITIES; title: a sentence; remedy: what to do about it; empty where there is nothing to do.
    """

    severity: str
    title: str
    remedy: str = ""


def remarks_of(a: Analysis) -> list[Remark]:
    """All findings, the gravest first."""
    found = [*_singular(a), *_limits(a), *_efforts(a), *_loads(a), *_missing(a)]
    return sorted(found, key=lambda remark: SEVERITIES.index(remark.severity))


def list_of(remarks: list[Remark]) -> Html:
    """The findings as a list; a sentence where there are none."""
    if not remarks:
        return paragraph(badge("No findings", "good"), " nothing is near a limit, and nothing is missing.")
    kinds = {"problem": "bad", "warning": "warning", "note": "note"}
    items = [
        tag(
            "li",
            badge(remark.severity.capitalize(), kinds[remark.severity]),
            tag("div", tag("strong", remark.title), tag("p", remark.remedy) if remark.remedy else None),
            class_=remark.severity,
        )
        for remark in remarks
    ]
    return tag("ul", items, class_="findings", role="list")


def _singular(a: Analysis) -> Iterator[Remark]:
    if a.is_singular:
        names = "" if a.card is None or not a.card.on else f" ({listed(a.card.on)})"
        lost = with_minus("; ".join(screw.text for screw in a.lost_twists))
        yield Remark(
            "problem",
            f"Singular{names}: rank {a.rank} of {a.task.rank}. Lost here: {lost}.",
            "Motion that is lost here needs another posture. Close to this one joint speeds grow without bound: bound them, "
            "ks.joint_rates(J, twist, 'adaptive').",
        )
    for distance in a.close_singularities:
        unit = "rad" if "prismatic" not in a.kinds else "rad, m"
        yield Remark(
            "warning",
            f"Near a singularity ({distance.component.label}): {format_number(distance.value)} {unit} away in joint space.",
            "Joint speeds are large here for some motions. Pass it at a distance, or bound them: "
            "ks.joint_rates(J, twist, 'adaptive').",
        )


def _limits(a: Analysis) -> Iterator[Remark]:
    kinds = kinds_of(a)
    for margin in a.margins:
        if not margin.near or margin.locked:
            continue
        words = f"{margin.joint} is {margin_words(margin, kinds[margin.joint])}."
        if margin.distance < 0:
            remedy = f"The arm cannot be there: check the posture and its unit ({joint_unit(kinds[margin.joint])})."
            yield Remark("problem", words, remedy)
        else:
            yield Remark("warning", words, "Motion towards this limit ends soon: choose a posture with more room.")


def _efforts(a: Analysis) -> Iterator[Remark]:
    shares, torques = a.effort_shares, a.holding_torques
    if shares is None or torques is None:
        return
    for k in np.flatnonzero(shares > NEAR_EFFORT):
        unit = effort_unit(a.kinds[k])
        needs = f"{a.joints[k]} needs {format_number(abs(torques[k]))} {unit} to hold still, {percent(float(shares[k]))} "
        words = f"{needs}of its limit of {format_number(a.effort_limits[k])} {unit}."
        if shares[k] > 1:
            yield Remark("problem", words, "The motor cannot hold it: less load, nearer to the base, or another posture.")
        else:
            yield Remark("warning", words, "Little is left to accelerate with: less load, or another posture.")


def _loads(a: Analysis) -> Iterator[Remark]:
    for load in a.loads:
        if load.split.passive and np.any(load.split.impossible.array):
            names = listed(load.split.passive)
            yield Remark(
                "problem", f"The load at {load.link} would move {names}, which no motor drives.", "Block that joint."
            )


_REMEDIES = (
    ("velocity limits are unknown", 'Give them in the robot\'s file: <limit velocity="..."> of each joint.'),
    ("effort limits are unknown", 'Give them in the robot\'s file: <limit effort="..."> of each joint.'),
    ("no masses are known", "Give them in the robot's file: <inertial> of each link."),
    ("singularities are those of the nominal robot", "For a calibrated robot this is as it should be."),
)


def _missing(a: Analysis) -> Iterator[Remark]:
    """What the analysis could not know, and what the reader of the robot's file found."""
    for note in a.notes:
        remedy = next((remedy for words, remedy in _REMEDIES if words in note), "")
        yield Remark("note", f"{note[:1].upper()}{note[1:]}.", remedy)
    if not a.margins and a.joints:
        yield Remark(
            "note", "No position limits are known.", 'Give them in the robot\'s file: <limit lower="..." upper="...">.'
        )
    for finding in model_of(a.jacobian).findings:
        where = f" ({finding.place})" if finding.place else ""
        yield Remark("note", f"{finding.code}: {finding.message}{where}", "See `kinestatics check` of the robot's file.")
