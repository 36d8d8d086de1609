"""A polytope as a person would want to read it: its shape, how far it reaches, and what ends it there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..quantities import TIED, format_number, wrapped

if TYPE_CHECKING:
    from .polytope import Polytope


def in_words(p: Polytope) -> str:
    """What it is, its shape, and how far it reaches along the axes."""
    whose = " of " * bool(p.robot) + p.robot + " at " * bool(p.link) + p.link
    lines = [wrapped("", f"{p.kind} polytope{whose}: {', '.join(p.rows)} [{p.unit}]")]
    lines += [str(p.frame)] if p.frame is not None else []
    if not p.is_empty:
        lines += [_shape(p), *(_reaches(p) if p.contains(np.zeros(len(p.rows))) else _ranges(p))]
    return "\n".join(lines + [wrapped("note: ", note) for note in p.notes])


def _shape(p: Polytope) -> str:
    parts = [_counted(len(p.offsets), "facet")]
    parts += [] if p.corners is None else [_counted(len(p.corners), "corner")]
    if not p.is_bounded:
        parts.append("unbounded")
    elif p.is_flat:
        parts.append("flat")
    elif p.corners is not None:
        k = len(p.rows)
        unit = f"({p.unit})" if "/" in p.unit or " " in p.unit else p.unit
        unit = "" if "," in p.unit or not p.unit else f" {p.unit}" if k == 1 else f" {unit}^{k}"
        parts.append(f"{('length', 'area', 'volume')[k - 1]} {format_number(p.volume)}{unit}")
    return ", ".join(parts)


def _reaches(p: Polytope) -> list[str]:
    """How far it reaches from the origin along each axis, and what ends it there."""
    lines = ["from the origin as far as"]
    for axis, name in zip(np.eye(len(p.rows)), p.rows, strict=True):
        for sign in (1.0, -1.0):
            label = f"  {'+' if sign > 0 else '-'}{name} {_number(p.extent(sign * axis))}"
            words = _joined(p.limiting_facet(sign * axis))
            lines.append(wrapped(f"{label}: ", words) if words else label)
    return lines


def _ranges(p: Polytope) -> list[str]:
    """The least and the greatest of each coordinate, for a set that does not have the origin in it."""
    lines = ["coordinates of its points"]
    for axis, name in zip(np.eye(len(p.rows)), p.rows, strict=True):
        low, high = -p.support(-axis), p.support(axis)
        lines.append(f"  {name} from {_number(low)} to {_number(high)}")
    return lines


def _number(value: float) -> str:
    return format_number(value) if np.isfinite(value) else "without end"


def _counted(count: int, word: str) -> str:
    return f"{count} {word}{'s' * (count != 1)}"


def _joined(words: Sequence[str]) -> str:
    """Words with commas between, no line broken within one."""
    return ", ".join(
        word.replace(" at its ", f"{TIED}at{TIED}its{TIED}").replace(" limit", f"{TIED}limit") for word in words
    )
