"""What a terminal can show: width, colour, and text that cannot drive it."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from typing import TextIO

COLOURS = {"error": "31", "warning": "33", "note": "36", "good": "32"}
"""What each kind of word is painted in, beside bold: codes of ANSI terminals."""


def wants_colour(stream: TextIO) -> bool:
    """Whether colour is welcome: on a terminal that is not a dumb one, unless NO_COLOR is set (no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def paint(text: str, kind: str, stream: TextIO | None = None) -> str:
    """The text in bold and the colour of its kind, one of COLOURS, where the stream welcomes it; default stdout."""
    return f"\x1b[1;{COLOURS[kind]}m{text}\x1b[0m" if wants_colour(stream or sys.stdout) else text


def printable(text: str) -> str:
    """Text from robot files without control characters that could drive a terminal."""
    return "".join(c if c == "\n" or c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def line_width(stream: TextIO | None = None) -> int | None:
    """Columns to keep to on a terminal; None into a pipe or a file, where lines are for other programs."""
    return max(shutil.get_terminal_size().columns, 40) if (stream or sys.stdout).isatty() else None


def hanging(text: str, indent: int, width: int | None, first: int | None = None) -> str:
    """One paragraph indented by so many columns, its first line by `first`; on one line where there is no width."""
    lead = " " * (indent if first is None else first)
    if width is None:
        return lead + text
    return textwrap.fill(
        text, width, initial_indent=lead, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False
    )
