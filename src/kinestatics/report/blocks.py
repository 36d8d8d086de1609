"""Building blocks of a page: every text is escaped by construction, for only blocks make markup. Imports no library."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from ..quantities import format_number

_VOID = frozenset({"meta", "br", "hr", "img", "link", "col"})
_LONG_WORD = re.compile(r"\S{121,}")  # names of files may be hostile
_HEAD, _TAIL = 70, 20
_KEPT = "\n\u00a0\u2009\u2060"  # of what Python does not call printable; a line feed is white space in a page
_POWERS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_MINUS = re.compile(r"(?<![\w.])-(?=\d)")


class Html(str):
    """Markup that goes into a page as it stands. Only the blocks of this module make it, out of escaped text."""

    __slots__ = ()

    def __html__(self) -> str:
        """Itself: the word by which template engines know markup."""
        return str(self)


Part = str | float | int | None | Iterable[Any]
"""What a block may hold: text, which is escaped, markup, numbers, nothing, or several of them."""


def visible(text: str) -> str:
    """Text of which every character can be seen: controls, also those that turn the direction of reading, as escapes.

    A word of more than 120 characters, which only a hostile file holds, keeps its beginning and its end.

    Example:
        >>> visible("a\\u202eb\\x00"), len(visible("x" * 10000))
        ('a\\\\u202eb\\\\x00', 91)
    """
    if len(text) <= 120 and text.isprintable():
        return text
    shown = "".join(c if c.isprintable() or c in _KEPT else c.encode("unicode_escape").decode() for c in text)
    return _LONG_WORD.sub(lambda word: f"{word[0][:_HEAD]}…{word[0][-_TAIL:]}", shown)


def escaped(part: Part) -> Html:
    """A part of a page as markup: markup as it is, all else escaped; several after each other.

    Example:
        >>> escaped(["<b>", 2, None, Html("<i>x</i>")])
        '&lt;b&gt;2<i>x</i>'
    """
    if part is None:
        return Html("")
    if isinstance(part, Html):
        return part
    if isinstance(part, str):
        return Html(html.escape(visible(part)))
    if isinstance(part, Iterable):
        return Html("".join(map(escaped, part)))
    return Html(html.escape(str(part)))


def tag(name: str, /, *parts: Part, **attributes: Any) -> Html:
    """An element. Attributes: `class_` for class, `aria_label` for aria-label; None and False are left out, True is bare.

    Example:
        >>> tag("a", "to <base>", href="#base", class_=None)
        '<a href="#base">to &lt;base&gt;</a>'
    """
    written = "".join(_attribute(key, value) for key, value in attributes.items())
    if name in _VOID:
        return Html(f"<{name}{written}>")
    return Html(f"<{name}{written}>{escaped(parts)}</{name}>")


def _attribute(key: str, value: Any) -> str:
    if value is None or value is False:
        return ""
    name = key.rstrip("_").replace("_", "-")
    if value is True:
        return f" {name}"
    return f' {name}="{value if isinstance(value, Html) else html.escape(visible(str(value)))}"'


def number(value: float | None, unit: str = "", beside: float = 0.0) -> Html:
    """A number and its unit, with a true minus; "unknown" for nothing, "unlimited" for infinity.

    `beside` is the largest of the numbers it stands among: what is rounding compared with it is 0.

    Example:
        >>> number(-0.5, "rad"), number(float("inf"))
        ('<span class="number">−0.5\\xa0rad</span>', '<span class="word">unlimited</span>')
    """
    if value is None or math.isnan(value):
        return tag("span", "unknown", class_="word")
    if math.isinf(value):
        return tag("span", "unlimited", class_="word")
    shown = raised(unit)
    return tag("span", with_minus(format_number(value, beside)), f"\u00a0{shown}" if shown else None, class_="number")


def raised(unit: str) -> str:
    """A unit with its powers raised.

    Example:
        >>> raised("m^3")
        'm³'
    """
    return re.sub(r"\^(\d)", lambda power: _POWERS[int(power[1])], unit)


def with_minus(text: str) -> str:
    """Text with a true minus before its numbers.

    Example:
        >>> with_minus("from -1.5 to 2e-05, wrist-3")
        'from −1.5 to 2e-05, wrist-3'
    """
    return _MINUS.sub("\N{MINUS SIGN}", text)


def section(title: Part, *parts: Part, id: str, level: int = 2, lead: Part = None) -> Html:
    """A part of the page under a heading, which labels it; `lead` is a sentence below the heading."""
    head = [tag(f"h{level}", title, id=f"{id}-title"), tag("p", lead, class_="lead") if lead else None]
    return tag("section", head, parts, id=id, aria_labelledby=f"{id}-title")


def paragraph(*parts: Part, kind: str | None = None) -> Html:
    """A paragraph."""
    return tag("p", *parts, class_=kind)


def bullets(items: Iterable[Part], kind: str | None = None) -> Html:
    """A list; nothing where there are no items."""
    rows = [tag("li", item) for item in items]
    return tag("ul", rows, class_=kind) if rows else Html("")


def definitions(pairs: Iterable[tuple[Part, Part]], kind: str | None = None) -> Html:
    """Terms and what they are, in rows."""
    rows = [tag("div", tag("dt", term), tag("dd", meaning)) for term, meaning in pairs]
    return tag("dl", rows, class_=kind)


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        title: what it holds; unit: shown beside it; numeric: whether it holds numbers, which stand flush right.
    """

    title: Part
    unit: str = ""
    numeric: bool = True


def table(
    caption: Part, columns: Sequence[Column | str], rows: Iterable[Sequence[Part]], *, kind: str | None = None
) -> Html:
    """A table whose first column names the rows. It scrolls in a box of its own where the window is narrow.

    Args:
        caption: what it shows, with frame and order where they apply.
        columns: a text alone is a column of words.
        rows: a cell for each column.
    """
    made = [column if isinstance(column, Column) else Column(column, numeric=False) for column in columns]
    head = [
        tag("th", c.title, tag("span", f" [{c.unit}]", class_="unit") if c.unit else None, scope="col", class_=_align(c))
        for c in made
    ]
    body = [tag("tr", [_cell(k, part, made[k]) for k, part in enumerate(row)]) for row in rows]
    inner = tag(
        "table", tag("caption", tag("span", caption)), tag("thead", tag("tr", head)), tag("tbody", body), class_=kind
    )
    return scrolling(inner, caption)


def _cell(k: int, part: Part, column: Column) -> Html:
    return tag("td", part, class_=_align(column)) if k else tag("th", part, scope="row", class_=_align(column))


def _align(column: Column) -> str | None:
    return "numeric" if column.numeric else None


def scrolling(inner: Part, label: Part) -> Html:
    """A box that scrolls sideways, within reach of the keyboard."""
    return tag("div", inner, class_="scroll", role="group", aria_label=plain(label), tabindex="0")


def plain(part: Part) -> str:
    """The words of a part, without its markup."""
    return html.unescape(re.sub(r"<[^>]*>", "", escaped(part)))


def badge(word: Part, kind: str = "") -> Html:
    """A word in a coloured frame; kind: "good", "warning", "bad", or nothing."""
    return tag("span", word, class_=f"badge {kind}".rstrip())


def figure(picture: Html, caption: Part, kind: str | None = None) -> Html:
    """A picture and what it shows."""
    return tag("figure", picture, tag("figcaption", caption), class_=kind)


def bar(share: float, kind: str = "") -> Html:
    """A bar of a share of its track, for the eye alone: the number stands beside it."""
    width = min(max(share, 0.0), 1.0)
    inner = tag("i", None, style=f"width:{100 * width:.4g}%")
    return tag("span", inner, class_=f"bar {kind}".rstrip(), aria_hidden="true")


def document(title: str, styles: Iterable[str], policy: str, body: Part, scripts: Part = None) -> Html:
    """A whole page.

    Args:
        title: of the window.
        styles: sheets of our own, written as they are: no text of a robot belongs in them.
        policy: what the page may load and run (Content-Security-Policy).
        body: what it shows; scripts: elements at its end.
    """
    head = [
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("meta", name="referrer", content="no-referrer"),
        tag("title", title),
        [Html(f"<style>\n{sheet}</style>") for sheet in styles],
    ]
    page = tag("html", "\n", tag("head", head), "\n", tag("body", body, scripts), "\n", lang="en")
    return Html(f"<!DOCTYPE html>\n{page}\n")


__all__ = [
    "Column",
    "Html",
    "Part",
    "badge",
    "bar",
    "bullets",
    "definitions",
    "document",
    "escaped",
    "figure",
    "number",
    "paragraph",
    "plain",
    "raised",
    "scrolling",
    "section",
    "table",
    "tag",
    "visible",
    "with_minus",
]
