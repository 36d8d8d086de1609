"""The document: the sections of a report in order, its style, and what it may load."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import NamedTuple

from ..analysis import Analysis
from ..model import RobotModel
from ..tasks import model_of
from . import mathematics
from .blocks import Html, document, escaped, tag

STATIC = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; base-uri 'none'; form-action 'none'"
"""What a static page may do: show what is in it. It can run and fetch nothing, even if a text should escape its escaping."""


class Report(NamedTuple):
    """What the sections are made of.

    Attributes:
        analysis: the numbers; model: the robot they are of.
        mathematics: how LaTeX is written: `mathml`, or `drawing` for PDF.
        command, seed: what was asked, for the last section.
    """

    analysis: Analysis
    model: RobotModel
    mathematics: Callable[[str, bool], Html] = mathematics.mathml
    command: str = ""
    seed: int | None = None


def report_of(a: Analysis, command: str, seed: int | None, for_print: bool = False) -> Report:
    """What the sections of an analysis are made of."""
    write = mathematics.drawing if for_print else mathematics.mathml
    return Report(a, model_of(a.jacobian), write, command, seed)


@cache
def style_sheet() -> str:
    """The look of a page."""
    return resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")


def page_of(report: Report, policy: str = STATIC, extra: Html | None = None) -> Html:
    """The whole page; `extra` are sections that a static page does not have, after the pictures."""
    from .motion import jacobian_section, motion_section
    from .overview import contents, header, pictures_section, summary_section
    from .provenance import provenance_section
    from .robot import conventions_section, robot_section
    from .singular import singular_section
    from .statics import reactions_section, statics_section

    made = [
        summary_section(report),
        conventions_section(report),
        pictures_section(report),
        extra,
        robot_section(report),
        jacobian_section(report),
        motion_section(report),
        statics_section(report),
        reactions_section(report),
        singular_section(report),
        provenance_section(report),
    ]
    sections = [section for section in made if section]
    body = [header(report), contents(sections), tag("main", escaped(sections), id="main")]
    a = report.analysis
    face = [] if report.mathematics is mathematics.drawing else [mathematics.font_face()]
    return document(f"{a.robot}: what can this arm do, here?", [*face, style_sheet()], policy, body)
