"""Identifiers of a language: for functions as asked for, for symbols like the names they have. Floor 7."""

from __future__ import annotations

import re
from typing import Any

from ...errors import ConfigurationError
from .languages import Language

_LONGEST = 48  # characters of an identifier; MATLAB knows 63


def function_name(name: Any, language: Language) -> str:
    """The name of a function as asked for.

    Raises:
        ConfigurationError: KS395, where it is none in the language.
    """
    if isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and len(name) <= _LONGEST:
        if name not in language.reserved and "__" not in name:
            return name
        message = f"{name!r} is a word of {language.name}"
    else:
        message = f"{name!r} is no name for a function"
    raise ConfigurationError("KS395", message, "letters, digits and underscores, a letter first: name='arm_jacobian'")


class Names:
    """Identifiers of a language for symbols, each once."""

    def __init__(self, language: Language, function: str) -> None:
        self.language, self.function = language, function
        self.taken = {function}
        self.known: dict[Any, str] = {}
        self.changed: list[tuple[str, str]] = []

    def new(self, wished: str) -> str:
        """An identifier like the one wished for that is not taken."""
        plain = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", wished))[:_LONGEST]
        if not re.match(r"[A-Za-z]", plain):
            plain = f"x{plain}"
        found, tries = plain, 0
        while found in self.taken or found in self.language.reserved:
            tries += 1
            found = plain.rstrip("_") + ("_" if tries == 1 else f"_{tries}")
        self.taken.add(found)
        return found

    def of(self, symbol: Any, wished: str | None = None) -> str:
        """The identifier of a symbol."""
        if symbol not in self.known:
            name = str(symbol) if wished is None else wished
            self.known[symbol] = self.new(name)
            if wished is None and self.known[symbol] != name:
                self.changed.append((name, self.known[symbol]))
        return self.known[symbol]
