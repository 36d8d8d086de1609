"""Numbers, tables and paragraphs as people read them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

WIDTH = 80
"""Columns of text that printed results keep to, where the names of links and joints allow it."""
TIED = "\u00a0"
"""A space at which no line is broken; printed as an ordinary one."""


_NOISE = 1e-12
"""Beside a number, one this much smaller is rounding, and is printed as 0."""


def format_number(x: Any, beside: Any = 0.0) -> str:
    """Four decimals at most, no minus before a rounded zero; symbols as they are.

    `beside` is the largest of the numbers it stands among: what is rounding compared with it is 0.
    """
    try:
        value = float(x)
    except (TypeError, ValueError):
        return str(x)
    if abs(value) < _NOISE * abs(beside):
        return "0"
    if value != 0 and (abs(value) < 5e-5 or abs(value) >= 1e6):
        return "0" if abs(value) < 1e-12 else f"{value:.3g}"
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def largest(array: Any) -> float:
    """The largest finite size in an array of numbers; 0 for symbols."""
    numbers = np.asarray(array)
    if numbers.dtype == object or not numbers.size:
        return 0.0
    sizes = np.abs(numbers)
    return float(sizes[np.isfinite(sizes)].max(initial=0.0))


def table(rows: list[list[str]]) -> str:
    """Cells in columns; the first column is flush left, the others right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0])] + [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def named_table(rows: list[list[str]], what: str) -> str:
    """A table whose first cells are names, or nothing; where it would be too wide, numbers, and the names below.

    `what` is the word before the names, such as "joints".
    """
    text = table(rows)
    if all(len(line) <= WIDTH for line in text.splitlines()):
        return text
    names = [row[0].strip() for row in rows if row[0].strip()]
    places = iter(range(1, len(names) + 1))
    short = [[row[0].replace(name, str(next(places))) if (name := row[0].strip()) else "", *row[1:]] for row in rows]
    return f"{table(short)}\n{numbered(what, names)}"


def numbered(what: str, names: Sequence[str]) -> str:
    """The names behind their numbers, as in "joints: 1 shoulder, 2 elbow"."""
    return wrapped(f"{what}: ", ", ".join(f"{k + 1}{TIED}{name}" for k, name in enumerate(names)))


def wrapped(label: str, text: str, hang: int = 0) -> str:
    """The text behind a label, its further lines indented; names are never broken, nor lines at a tied space.

    What is tied and longer than a line is broken all the same.
    """
    indent = " " * (len(label) + hang)
    room = WIDTH - max(len(label), len(indent))
    words = [word if len(word) <= room else word.replace(TIED, " ") for word in text.split(" ")]
    fitted = " ".join(words)
    filled = textwrap.fill(
        fitted, WIDTH, initial_indent=label, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return filled.replace(TIED, " ")
