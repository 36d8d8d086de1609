"""A strict XML reader for robot files over the standard library's expat: positions, limits, no entities. Floor 4.

Nothing here knows links or joints. What the usual libraries swallow (a document type, a bomb, a number with a comma) is an
error with its place.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from xml.parsers import expat

import numpy as np

from ..errors import Place, RobotFileError
from ..namespaces import Array
from .checks import LARGEST

MAX_BYTES = 64 << 20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 64
MAX_ATTRIBUTE = 4096
_LONG = (  # beginnings of the names of attributes that hold arrays
    *("vertex", "vertid", "face", "point", "texcoord", "normal", "node", "element", "body", "weight"),
    *("qpos", "qvel", "data", "elevation"),
)
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)", re.IGNORECASE | re.ASCII)


class Element:
    """One XML element; light, since a file may hold two hundred thousand of them.

    Attributes:
        tag: its name; attributes: by name; place: file, line and column of its start; children: in order.
    """

    __slots__ = ("_children", "_where", "attributes", "tag")

    def __init__(
        self, tag: str, attributes: Mapping[str, str], place: tuple[str, int, int], children: list[Element] | None = None
    ) -> None:
        self.tag = tag
        self.attributes = attributes
        self._where = (
            place[0],
            place[1],
            place[2],
        )  # a plain tuple, no empty lists: less for the garbage collector
        self._children = children

    @property
    def place(self) -> Place:
        """Where it starts."""
        return Place(*self._where)

    @property
    def children(self) -> list[Element]:
        """The elements directly inside, in order."""
        if self._children is None:
            self._children = []
        return self._children

    def all(self, tag: str) -> Iterator[Element]:
        """The children of that name."""
        return (child for child in self._children or () if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        """The first child of that name, or None."""
        return next(self.all(tag), None)

    def walk(self) -> Iterator[Element]:
        """This element and everything below it, in the order of the file; without recursion."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element._children or ()))

    def __repr__(self) -> str:
        return f"<Element {self.tag!r} at {self.place}>"


def read_file(path: Path, max_bytes: int = MAX_BYTES) -> bytes:
    """The bytes of a file that is not too large.

    Raises:
        RobotFileError: KS101 too large, KS109 cannot be read.
    """
    try:
        size = path.stat().st_size
        data = path.read_bytes() if size <= max_bytes else b""
    except OSError as failure:
        raise RobotFileError("KS109", f"cannot be read: {failure.strerror}", "", Place(str(path))) from None
    if size > max_bytes:
        hint = "pass max_bytes=..."
        raise RobotFileError("KS101", f"file is {size} bytes; the limit is {max_bytes}", hint, Place(str(path)))
    return data


def check_bytes(data: bytes, file: str, max_bytes: int = MAX_BYTES) -> None:
    """Size and encoding, before expat guesses at either.

    Raises:
        RobotFileError: KS100 empty, KS101 too large, KS105 not UTF-8.
    """
    if not data.strip():
        raise RobotFileError("KS100", "the file is empty", place=Place(file))
    if len(data) > max_bytes:
        raise RobotFileError(
            "KS101", f"file is {len(data)} bytes; the limit is {max_bytes}", "pass max_bytes=...", Place(file)
        )
    head = data[:512]
    if b"\x00" in head and b"<" in head:
        raise RobotFileError("KS105", "the file is not UTF-8 (it looks like UTF-16)", "save the file as UTF-8", Place(file))
    declared = re.match(rb"\s*<\?xml[^>]*encoding=[\"']([A-Za-z0-9._-]+)", head)
    if declared and declared[1].lower() not in (b"utf-8", b"utf8", b"us-ascii", b"ascii", b"iso-8859-1", b"latin1"):
        raise RobotFileError(
            "KS105", f"encoding {declared[1].decode()!r} is not supported", "save the file as UTF-8", Place(file, 1, 1)
        )


def parse_xml(data: bytes, file: str, *, max_bytes: int = MAX_BYTES, max_depth: int = MAX_DEPTH) -> Element:
    """The root element of one XML document.

    Args:
        data: the bytes of the file; file: its name, for messages.
        max_bytes, max_depth: limits on size and nesting.

    Raises:
        RobotFileError: KS100-KS105, KS110, with file, line and column.
    """
    check_bytes(data, file, max_bytes)
    builder = _Builder(file, max_depth)
    try:
        builder.parse(data)
    except expat.ExpatError as failure:
        reason = expat.ErrorString(failure.code)
        cut = reason in ("unclosed token", "no element found")
        hint = (
            "the file seems cut off"
            if cut
            else "is this an XML file?"
            if failure.lineno == 1 and builder.root is None
            else ""
        )
        place = Place(file, failure.lineno, failure.offset + 1)
        code = "KS105" if reason == "not well-formed (invalid token)" and not _is_utf8(data) else "KS100"
        text = "the file is not UTF-8" if code == "KS105" else f"not well-formed XML: {reason}"
        raise RobotFileError(code, text, "save the file as UTF-8" if code == "KS105" else hint, place) from None
    except (UnicodeDecodeError, ValueError) as failure:
        if isinstance(failure, RobotFileError):
            raise
        raise RobotFileError("KS105", f"cannot be decoded: {failure}", "save the file as UTF-8", Place(file)) from None
    if builder.root is None:
        raise RobotFileError("KS100", "not well-formed XML: no element found", "", Place(file))
    return builder.root


def _is_utf8(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


class _Builder:
    """Collects elements from expat's events and refuses what is over a limit."""

    def __init__(self, file: str, max_depth: int) -> None:
        self.file, self.max_depth = file, max_depth
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0
        self.parser = expat.ParserCreate()

    def parse(self, data: bytes) -> None:
        """Builds the tree; a file that may hold too many elements is counted first, which costs a tenth of building it."""
        if data.count(b"<") > MAX_ELEMENTS:
            with contextlib.suppress(expat.ExpatError):  # what is wrong there is said below
                self.listen(self.counted).Parse(data, True)
            self.count = 0
        self.listen(self.start, self.end).Parse(data, True)

    def listen(self, start: Callable[..., None], end: Callable[[str], None] | None = None) -> expat.XMLParserType:
        """A parser that knows no document types."""
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler, self.parser.EndElementHandler = start, end
        self.parser.StartDoctypeDeclHandler = self.refuse
        self.parser.EntityDeclHandler = self.refuse
        self.parser.ExternalEntityRefHandler = self.refuse
        return self.parser

    def error(self, code: str, message: str, hint: str = "") -> RobotFileError:
        place = Place(self.file, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)
        return RobotFileError(code, message, hint, place)

    def refuse(self, *_: object) -> int:
        raise self.error("KS110", "DOCTYPE/ENTITY is not allowed in a robot file", "delete the <!DOCTYPE ...> block")

    def counted(self, *_: object) -> None:
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise self.error("KS102", f"more than {MAX_ELEMENTS} elements")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.counted()
        if len(self.open) >= self.max_depth:
            raise self.error("KS103", f"elements nested deeper than {self.max_depth}")
        for name, value in attributes.items():
            if len(value) > MAX_ATTRIBUTE and not name.startswith(_LONG):
                raise self.error("KS104", f"attribute {name!r} is {len(value)} characters; the limit is {MAX_ATTRIBUTE}")
        parser = self.parser
        element = Element(tag, attributes, (self.file, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1))
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _: str) -> None:
        self.open.pop()


def required(element: Element, name: str, what: str) -> str:
    """An attribute that must be there.

    Raises:
        RobotFileError: KS125.
    """
    if (value := element.attributes.get(name)) is None:
        raise RobotFileError("KS125", f"{what}: <{element.tag}> has no attribute {name!r}", "", element.place)
    return value


def read_number(text: str, what: str, place: Place, infinite: bool = False) -> float:
    """One number as robot files write it: decimal point, no separators, finite unless `infinite` is allowed.

    Raises:
        RobotFileError: KS145 not a number, KS146 not finite, KS148 too large to compute with.
    """
    word = text.strip()
    if not _NUMBER.fullmatch(word):
        hint = ""
        if word.count(",") == 1 and re.fullmatch(r"[+-]?\d+,\d+", word):
            hint = "use a decimal point"
        elif "," in word:
            hint = "separate with spaces, not commas"
        elif "${" in word:
            hint = "this looks like xacro: expand it first, or name the file .xacro"
        raise RobotFileError("KS145", f"{what}: {word[:60]!r} is not a number", hint, place)
    value = float(word)
    if math.isnan(value) or (math.isinf(value) and not infinite):
        raise RobotFileError("KS146", f"{what}: {word} is not finite", "give a finite number", place)
    if abs(value) > LARGEST and not infinite:
        raise RobotFileError("KS148", f"{what}: {word[:60]} is larger than {LARGEST:g}", "look for a wrong unit", place)
    return value


def read_vector(text: str, size: int, what: str, place: Place) -> Array:
    """Exactly `size` finite numbers separated by white space, as float64.

    Raises:
        RobotFileError: KS144 wrong count, KS145, KS146, KS148.
    """
    words = text.split()
    values = [read_number(word, what, place) for word in words]
    if len(values) != size:
        hint = "is this a quaternion?" if size == 3 and len(values) == 4 else ""
        raise RobotFileError("KS144", f"{what}: expected {size} numbers, found {len(values)}", hint, place)
    return np.array(values)


def check_name(name: str, what: str) -> str | None:
    """A sentence about control characters or markup in a name, or None."""
    if any(not c.isprintable() or c in "<>&" for c in name):
        return f"{what} name {name!r} holds control characters or markup; it is shown escaped"
    return None


def numbers_in(element: Element, names: Sequence[str]) -> dict[str, list[float]]:
    """The numbers of those attributes that are present, each checked to be finite."""
    found = {}
    for name in names:
        if (text := element.attributes.get(name)) is not None:
            found[name] = [read_number(word, f"<{element.tag} {name}>", element.place) for word in text.split()]
    return found
