"""Every exception of kinestatics. Floor 0: imports nothing of the package.

    KinestaticsError
    ├── RobotFileError (ValueError)        a robot file is wrong: code, file:line:column, remedy
    ├── RobotDefinitionError (ValueError)  DH rows, screws or a model built in Python are wrong
    ├── UnknownNameError (LookupError)     a robot, link or joint of that name does not exist
    ├── ConfigurationError (ValueError)    q, or an array that goes with it, has a wrong value or shape
    ├── ArrayTypeError (TypeError)         an array of a kind that cannot be computed with
    ├── FrameMismatchError (ValueError)    two quantities of different frames were combined
    ├── MissingMassError (ValueError)      a static quantity was asked of an arm whose masses are unknown
    └── MissingExtraError (ImportError)    an optional package is needed: says which command installs it

    KinestaticsWarning (UserWarning)       the answer is right but probably not what was meant

Every exception carries a stable `code` ("KS142"). A message says what is wrong, where, and what to do about it.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import NamedTuple


class Place(NamedTuple):
    """A position in a file, counted from 1; line 0 means the file as a whole."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file


class KinestaticsError(Exception):
    """Base of all exceptions of this package.

    Attributes:
        code: stable identifier such as "KS142".
        message: what is wrong.
        hint: what to do about it; empty when the message says it all.
        place: where in a file, or None.
    """

    def __init__(self, code: str, message: str, hint: str = "", place: Place | None = None) -> None:
        self.code, self.message, self.hint, self.place = code, message, hint, place
        super().__init__(code, message, hint, place)  # all arguments, so that pickling rebuilds the exception

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        remedy = f"\n  hint: {self.hint}" if self.hint else ""
        return f"{where}error {self.code}: {self.message}{remedy}"


class RobotFileError(KinestaticsError, ValueError):
    """A robot file cannot be read as a robot."""


class RobotDefinitionError(KinestaticsError, ValueError):
    """DH rows, screws or a model built in Python do not describe a robot."""


class UnknownNameError(KinestaticsError, LookupError):
    """No robot, link, joint or convention of that name."""


class ConfigurationError(KinestaticsError, ValueError):
    """q, or an array that goes with it, has a wrong value or shape."""


class ArrayTypeError(KinestaticsError, TypeError):
    """An array of a kind that cannot be computed with (complex, masked, text, ...)."""


class FrameMismatchError(KinestaticsError, ValueError):
    """Two quantities are expressed in different frames."""


class MissingMassError(KinestaticsError, ValueError):
    """A static quantity was asked of an arm whose masses are unknown."""


class MissingExtraError(KinestaticsError, ImportError):
    """An optional package is needed."""


class KinestaticsWarning(UserWarning):
    """The answer is right but probably not what was meant."""


class Finding(NamedTuple):
    """Something in a robot file that does not stop it from loading: a warning with a code and a place."""

    code: str
    message: str
    place: Place | None = None

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        return f"{where}warning {self.code}: {self.message}"


_COMPARED, _READABLE = 2000, 80  # names, characters


def nearest(name: str, names: Iterable[str]) -> str:
    """'did you mean ...' for the closest of `names`, else the list of them; for use as a hint."""
    known = list(names)
    comparable = [k for k in known[:_COMPARED] if len(k) <= _READABLE]  # the comparison takes time; files may be hostile
    close = difflib.get_close_matches(name[:_READABLE], comparable, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(repr(c) for c in close) + "?"
    shown = ", ".join(repr(k[:_READABLE]) for k in known[:12])
    return f"known: {shown}" + (f" and {len(known) - 12} more" if len(known) > 12 else "") if known else ""


def missing_extra(package: str, extra: str, purpose: str) -> MissingExtraError:
    """The error for an optional package that is not installed."""
    return MissingExtraError(
        "KS400", f"{purpose} needs the package {package!r}, which is not installed", f"pip install 'kinestatics[{extra}]'"
    )
