"""Reports: one analysis as one page to be sent, printed and kept. Floor 11.

    html        the page: needs neither network nor script; interactive=True adds figures to turn, scene=True the arm in 3-D
    pdf         the same on paper

    page        the document: its sections in order, its style, and what it may load
    overview    the verdict, the findings, the pictures         findings     what is wrong, near or missing, with a remedy
    robot       conventions, joints, links, pose                motion       Jacobian, closed forms, singular values, limits
    statics     torques against limits, loads, reactions        singular     singularities by name, the card of the posture
    provenance  file, hash, versions, command                   interactive  figures of plotly, and the scene
    blocks      markup, escaped by construction                 mathematics  LaTeX as MathML or as a drawing, and its font
    pictures    the arm with what it can do                     canvas       SVG from what `plots` draws
    printing    the page as PDF                             words        units and sentences that sections share

Nothing is computed here: every number is the analysis's, or asked of the floors below.
"""

from __future__ import annotations

from importlib.util import find_spec

from ..analysis import Analysis
from ..errors import ArrayTypeError, missing_extra
from .page import page_of, report_of

__all__ = ["html", "pdf"]


def html(
    analysis: Analysis, *, interactive: bool = False, scene: bool = False, command: str = "", seed: int | None = None
) -> str:
    """An analysis as one page: self-contained, it loads nothing, and the same input makes the same bytes.

    Args:
        analysis: from `kinestatics.analyze`; with singularities=True it has a table of them, and of this posture a card.
        interactive: adds figures that can be turned, by plotly: 5 MB and script.
        scene: adds the arm in three dimensions, as it stands: some MB and script, in a frame of its own.
        command: what was typed, for the last section.
        seed: of a random posture, for the last section.

    Returns:
        HTML, to be written with encoding="utf-8".

    Raises:
        ArrayTypeError: KS302 for what is no Analysis. MissingExtraError: KS400 without the extra `report`.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics import report
        >>> page = report.html(ks.analyze(ks.load("planar_2r"), [0.0, 0.5]))
        >>> "<script" in page, len(page) < 500_000
        (False, True)
    """
    made = report_of(_checked(analysis), command, seed)
    if not (interactive or scene):
        return str(page_of(made))
    from .interactive import extra_section, policy

    return str(page_of(made, policy(scene), extra_section(made, interactive, scene)))


def pdf(analysis: Analysis, *, command: str = "", seed: int | None = None) -> bytes:
    """An analysis on paper: the page of `html`, as PDF.

    Args:
        analysis, command, seed: as in `html`.

    Returns:
        The bytes of the file.

    Raises:
        As `html`.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics import report
        >>> report.pdf(ks.analyze(ks.load("planar_2r"), [0.0, 0.5]))[:5]
        b'%PDF-'
    """
    made = report_of(_checked(analysis), command, seed, for_print=True)
    if find_spec("weasyprint") is None:
        raise missing_extra("weasyprint", "report", "a report as PDF")
    from .printing import printed

    return printed(page_of(made))


def _checked(analysis: Analysis) -> Analysis:
    if not isinstance(analysis, Analysis):
        raise ArrayTypeError("KS302", f"expected an Analysis, not a {type(analysis).__name__}", "a = ks.analyze(arm, q)")
    return analysis
