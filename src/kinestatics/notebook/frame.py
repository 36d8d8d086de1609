"""A result as a piece of a page: its display, and its printed text for pages that take style away.

GitHub, nbviewer and untrusted notebooks strip style, drawings and mathematics, but keep text and the attribute `style`.
So the display is hidden by that attribute and the text is not; the style sheet, where it is let through, turns both around.
No script, no identifiers (a page holds many displays), nothing that is fetched.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import resources
from importlib.util import find_spec
from typing import Any

from ..analysis import Analysis
from ..model import RobotModel
from ..quantities import Jacobian, Pose, SixVector
from ..report.blocks import Html, Part, escaped, tag
from ..report.mathematics import mathml
from ..singular_sets import SingularSet
from ..symbolic.closed_form import ClosedForm

_OFF = "tex2jax_ignore mathjax_ignore"  # a dollar in a joint's name begins no formula
LONGEST_FORMULA = 4000  # characters of LaTeX that are read on a page


def html(result: Any) -> str:
    """A result as a piece of a page, for `_repr_html_`; its printed text where there is no display of it.

    Args:
        result: RobotModel, Jacobian, Pose, Twist, Wrench, Analysis, SingularSet, ClosedForm; anything that prints.

    Returns:
        HTML of one element, without script: the same input, the same bytes.

    Example:
        >>> import kinestatics as ks
        >>> html(ks.load("planar_2r")).startswith('<div class="kinestatics-output">')
        True
    """
    text = _printed(result)
    try:
        body = _body(result)
    except Exception:  # a display must never stand in the way of the numbers: these are in the text
        body = None
    return framed(body, text)


def framed(body: Part, text: str) -> Html:
    """A display and its printed text, of which one is seen; the text alone where there is no display."""
    if body is None:
        return tag("div", tag("pre", text), class_="kinestatics-output")
    shown = tag("div", body, class_=f"kinestatics {_OFF}", style="display:none")
    return tag("div", _style(), tag("pre", text, class_="kinestatics-text"), shown, class_="kinestatics-output")


def head(name: Part, *about: Part) -> Html:
    """The first line of a display: what it is, and what of."""
    return tag("p", tag("strong", name), [[" ", tag("span", part, class_="soft")] for part in about if part], class_="head")


def beside(picture: Html | None, *parts: Part) -> Html:
    """A picture with what belongs to it at its side, or below it where there is no room."""
    return tag("div", picture, tag("div", parts, class_="main"), class_="row") if picture else escaped(parts)


def formula(latex: str, printed: Callable[[], str], display: bool = False) -> Html:
    """Mathematics, as MathML; as it prints, which is asked for then, where that cannot be had."""
    if len(latex) > LONGEST_FORMULA or find_spec("latex2mathml") is None:
        return tag("code", printed())
    written = mathml(latex, display)
    return tag("div", written, class_="formula") if display else written


def _printed(result: Any) -> str:
    """As it prints; what cannot be printed, such as an array that is being traced, is named."""
    try:
        return str(result)
    except Exception:
        return f"<{type(result).__name__}>"


def _body(result: Any) -> Html | None:
    """The display of a result; None where the printed text says it all."""
    from . import posture, quantities, robot, singular

    makers: dict[type, Callable[[Any], Html | None]] = {
        RobotModel: robot.robot_body,
        Analysis: posture.analysis_body,
        SingularSet: singular.singular_set_body,
        Jacobian: quantities.jacobian_body,
        Pose: quantities.pose_body,
        SixVector: quantities.six_vector_body,
        ClosedForm: quantities.closed_form_body,
    }
    return next((make(result) for kind, make in makers.items() if isinstance(result, kind)), None)


@cache
def _style() -> Html:
    """The look of displays: rules of our own, and each is of something in `.kinestatics`."""
    return tag("style", Html(resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")))
