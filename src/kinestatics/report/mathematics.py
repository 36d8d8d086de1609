"""LaTeX as a page shows it: MathML for browsers, drawings for PDF; and the font that lets brackets grow.

The LaTeX is ours (`kinestatics.to_latex`), but names of joints in it are not: what the converter makes is taken apart, and
only elements and attributes of mathematics come through.
"""

from __future__ import annotations

import base64
import re
import warnings
from collections.abc import Callable, Sequence
from functools import cache
from importlib import resources
from importlib.util import find_spec
from xml.etree.ElementTree import Element

from ..errors import missing_extra
from .blocks import Html, scrolling, tag

FONT = "mathematics.woff2"
"""A subset of STIX Two Math, cut by scripts/subset_math_font to what is written here."""
_ELEMENTS = re.compile(
    "mrow|mi|mo|mn|mtext|msup|msub|msubsup|mover|munder|munderover|mfrac|msqrt|mroot|mtable|mtr|mtd|mspace|mstyle"
)
_ATTRIBUTES = re.compile("mathvariant|stretchy|fence|form|width|columnalign|columnlines|rowlines")
_CHARACTER = re.compile(r"&#x([0-9A-F]{5});")  # the converter's own way to write a character
_MATHML = "http://www.w3.org/1998/Math/MathML"
_UPRIGHT = re.compile(r"\\(text|mathrm)\{((?:[^\\{}]|\\.)*)\}")  # names and words, as `to_latex` writes them
_PLACE, _PLACED = "\\text{\ue000%d\ue000}", re.compile("\ue000(\\d+)\ue000")
_WRITTEN = {r"\backslash ": "\\", r"\wedge ": "^", r"\sim ": "~"}


def mathml(latex: str, display: bool = False) -> Html:
    """LaTeX of mathematics as MathML; where it cannot be converted, the LaTeX itself.

    Args:
        latex: of mathematics mode, as `kinestatics.to_latex` writes it.
        display: whether it stands in a line of its own.

    Raises:
        MissingExtraError: KS400 without latex2mathml.

    Example:
        >>> mathml(r"\\tau = J^{\\mathsf T}")
        '<math><mrow><mi>τ</mi><mo>=</mo><msup><mi>J</mi><mi mathvariant="normal">𝖳</mi></msup></mrow></math>'
    """
    upright: list[tuple[str, str]] = []

    def kept(found: re.Match[str]) -> str:
        upright.append((found[1], _as_text(found[2])))
        return _PLACE % (len(upright) - 1)

    root = _converted(_UPRIGHT.sub(kept, latex))
    if root is None:
        return tag("code", latex)
    return tag("math", _repaired(root, upright), display="block" if display else None)


def formula(latex: str, label: str, write: Callable[[str, bool], Html] = mathml) -> Html:
    """A formula in a line of its own, which scrolls in its own box where it is wide; `write` makes its markup."""
    return scrolling(write(latex, True), label)


def drawing(latex: str, display: bool = False) -> Html:
    """The same as `mathml`, as a picture with the LaTeX for its words: for PDF, whose maker knows no MathML.

    Raises:
        MissingExtraError: KS400 without ziamath.
    """
    if find_spec("ziamath") is None:
        raise missing_extra("ziamath", "report", "mathematics in a PDF")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of how it reads its own font
        import ziamath

    written = mathml(latex, display)
    if not written.startswith("<math"):
        return written
    standalone = written.replace("<math", f'<math xmlns="{_MATHML}"', 1)
    svg = ziamath.zmath.Math(standalone, size=_POINTS).svg()
    data = base64.b64encode(svg.encode()).decode()
    found = re.search(r'width="([\d.]+)" height="([\d.]+)" viewBox="\S+ (-?[\d.]+) ', svg)
    if found is None:
        return written
    width, height, top = (float(size) / _POINTS for size in found.groups())
    style = f"width:{width:.3f}em;height:{height:.3f}em;vertical-align:{-(height + top):.3f}em"
    image = tag("img", src=Html(f"data:image/svg+xml;base64,{data}"), alt=latex, style=style, class_="mathematics")
    return tag("div", image, class_="display") if display else image


_POINTS = 16.0


@cache
def font_face() -> str:
    """The style sheet that brings the font along: a page with mathematics holds it once."""
    data = resources.files(__package__).joinpath("fonts", FONT).read_bytes()
    source = f"url(data:font/woff2;base64,{base64.b64encode(data).decode()})format('woff2')"
    return f"@font-face{{font-family:'Kinestatics Mathematics';src:{source}}}\n"


def _converted(latex: str) -> Element | None:
    """The converter's tree, as one row; None where it knows no way."""
    if find_spec("latex2mathml") is None:
        raise missing_extra("latex2mathml", "report", "mathematics in a report")
    from latex2mathml.converter import convert_to_element

    try:
        root: Element = convert_to_element(latex)
    except Exception:  # its errors share no base class, and names of files may hold anything
        return None
    root.tag = "mrow"
    return root if all(_ELEMENTS.fullmatch(element.tag) for element in root.iter()) else None


def _as_text(latex: str) -> str:
    """A name or word without the marks that make it harmless in LaTeX."""
    for mark, letter in _WRITTEN.items():
        latex = latex.replace(mark, letter)
    return re.sub(r"\\([{}$&#%_])", r"\1", latex)


def _repaired(element: Element, upright: Sequence[tuple[str, str]]) -> Html:
    """An element as MathML Core has it: no rows that hold nothing together, names whole, letters without serifs."""
    children = [_repaired(child, upright) for child in element]
    if element.tag == "mrow":
        return children[0] if len(children) == 1 else tag("mrow", children)
    if placed := _PLACED.fullmatch(element.text or ""):
        kind, name = upright[int(placed[1])]
        return tag("mi" if kind == "mathrm" else "mtext", name, mathvariant="normal" if len(name) == 1 else None)
    attributes = {key: value for key, value in element.attrib.items() if _ATTRIBUTES.fullmatch(key)}
    text = _CHARACTER.sub(lambda found: chr(int(found[1], 16)), element.text or "")
    if attributes.pop("mathvariant", None) == "sans-serif":
        text, attributes["mathvariant"] = "".join(map(_without_serifs, text)), "normal"
    return tag(element.tag, text, children, **attributes)


def _without_serifs(letter: str) -> str:
    """𝖳 for T."""
    if "A" <= letter <= "Z":
        return chr(0x1D5A0 + ord(letter) - ord("A"))
    if "a" <= letter <= "z":
        return chr(0x1D5BA + ord(letter) - ord("a"))
    return letter
