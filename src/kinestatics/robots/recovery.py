"""Every fault of a URDF file, not just the first: what is faulty is struck out, and the rest is read again. Floor 4.

A faulty <axis> or <limit> is struck out alone, so that its joint is still read. A whole <link> or <joint> is struck out when
it is at fault itself; that the rest then no longer hangs together is a consequence, and the search ends there.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ..errors import Finding, Place, RobotFileError
from .description import RobotDescription
from .urdf import parse_urdf

MOST, MOST_BYTES = 30, 2 << 20
"""Faults looked for in one file, and bytes read again on the way: a large file with many faults is not worth the wait."""
_TAG = re.compile(rb"<[^>\"']*(?:\"[^\"]*\"[^>\"']*|'[^']*'[^>\"']*)*>")
_CULPRITS = {"KS152": "limit", "KS153": "limit", "KS155": "limit", "KS170": "mimic", "KS171": "mimic", "KS172": "mimic"}
"""What is struck out in an element of which this is said."""
_CONSEQUENCES = ("KS121", "KS136", "KS170")
"""What may be said only because a link or joint was struck out."""
_OF_FILES = "KS120"  # codes below are of the file as a whole: it may be an attack, and nothing of it is looked at again
_TREE = 2  # depth of <link> and <joint>


@dataclass(frozen=True)
class Faults:
    """What is wrong in a URDF file.

    Attributes:
        errors: in the order in which they were met.
        findings: warnings about what is not at fault; none where the rest cannot be read.
        description: the rest of the robot, or None.
        complete: whether the whole file was looked at.
    """

    errors: tuple[RobotFileError, ...]
    findings: tuple[Finding, ...] = ()
    description: RobotDescription | None = None
    complete: bool = True


@dataclass(frozen=True)
class _Element:
    """Where an element lies among the bytes, and how deep; `top` is the link or joint that it is part of."""

    tag: str
    begin: int
    end: int
    depth: int
    top: tuple[int, int]


def find_faults(data: bytes, file: str, *, package_roots: Sequence[Path] = (), base: str | None = None) -> Faults:
    """All faults in the bytes of a URDF file; `file` names it in messages and is where relative paths start."""
    errors: list[RobotFileError] = []
    struck: set[tuple[int, int]] = set()
    broken = False
    most = min(MOST, 1 + MOST_BYTES // max(len(data), 1))
    while len(errors) < most:
        try:
            found = parse_urdf(data, file, package_roots=package_roots, base=base)
        except RobotFileError as error:
            if broken and error.code in _CONSEQUENCES:
                break
            errors.append(error)
            element = _culprit(data, error)
            if element is None or element.depth < _TREE:
                break
            broken = broken or element.depth == _TREE
            struck.add(element.top)
            data = _without(data, element)
        else:
            elements = _elements(data) if struck else {}
            sound = [note for note in found.findings if not _within(note.place, elements, struck)]
            return Faults(tuple(errors), tuple(sound), found)
    return Faults(tuple(errors), complete=False)


def _culprit(data: bytes, error: RobotFileError) -> _Element | None:
    """The element to be struck out, so that the rest can be read."""
    if error.place is None or error.code < _OF_FILES:
        return None
    elements = _elements(data)
    element = elements.get(_key(error.place))
    if element is None or error.code not in _CULPRITS:
        return element
    inside = (part for part in elements.values() if element.begin < part.begin < element.end)
    return next((part for part in inside if part.tag == _CULPRITS[error.code]), element)


def _key(place: Place) -> tuple[int, int]:
    return place.line, place.column


def _within(place: Place | None, elements: dict[tuple[int, int], _Element], tops: set[tuple[int, int]]) -> bool:
    """Whether a place lies in one of these links and joints, so that what is said of it may be a consequence."""
    element = elements.get(_key(place)) if place is not None else None
    return element is not None and element.top in tops


@dataclass
class _Positions:
    """Collects where elements begin and end."""

    data: bytes
    found: dict[tuple[int, int], _Element] = field(default_factory=dict)
    open: list[tuple[tuple[int, int], int]] = field(default_factory=list)

    def collect(self) -> None:
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler, self.parser.EndElementHandler = self.start, self.end
        self.parser.Parse(self.data, True)

    def start(self, *_: object) -> None:
        key = (self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)
        self.open.append((key, self.parser.CurrentByteIndex))

    def end(self, tag: str) -> None:
        depth, top = len(self.open), self.open[min(1, len(self.open) - 1)][0]
        key, begin = self.open.pop()
        last = _TAG.match(self.data, begin)
        if last is None or not last[0].endswith(b"/>"):
            last = _TAG.match(self.data, self.parser.CurrentByteIndex)  # the closing tag
        self.found[key] = _Element(tag, begin, last.end() if last else begin, depth, top)


def _elements(data: bytes) -> dict[tuple[int, int], _Element]:
    """Every element by the line and column of its start."""
    positions = _Positions(data)
    try:
        positions.collect()
    except expat.ExpatError:
        return {}
    return positions.found


def _without(data: bytes, element: _Element) -> bytes:
    """The file with spaces in the place of an element; all else keeps its line and column."""
    cut = data[element.begin : element.end]
    text = cut.decode("utf-8", errors="surrogateescape")
    return data[: element.begin] + "".join(c if c == "\n" else " " for c in text).encode() + data[element.end :]
