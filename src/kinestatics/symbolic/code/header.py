"""What generated code says of itself: shapes, units, rows, frame, changed names. Floor 7.

Text from models enters comments only, stripped of all marks.
"""

from __future__ import annotations

import re

from .identifiers import Names
from .languages import Language
from .programs import Program


def _harmless(text: str) -> str:
    """Text of a model for a comment: letters, digits and a few marks that end no comment in any language."""
    return re.sub(r"[^A-Za-z0-9 _.,:;()\[\]+=<>^/-]", "_", text.replace("²", "^2")).replace("//", "/")


def header_lines(program: Program, names: Names, language: Language, batch: str) -> list[str]:
    """What the function computes, of what, and which names were changed."""
    lines = [
        _harmless(program.title[:1].upper() + program.title[1:]) + ".",
        "",
        f"{language.name} code of kinestatics; SI units, radians.",
    ]
    if program.arguments:
        lines += ["", "Arguments:"]
    for argument in program.arguments:
        name = names.known[argument] if argument.vector else names.known[argument.symbols[0]]
        shape = f"({batch}{len(argument.symbols)}) " if argument.vector else ""
        text = argument.text or (f"array of {', '.join(map(str, argument.symbols))}" if argument.vector else "number")
        default = "" if argument.default is None else f"; {argument.default!r} in this robot"
        lines.append(_harmless(f"    {name}: {shape}{text}{default}"))
    shape = (
        "x".join(map(str, program.shape)) if language.name not in ("NumPy", "JAX") else ", ".join(map(str, program.shape))
    )
    lines += [
        "",
        "Result:",
        _harmless(f"    ({batch}{shape}) {program.returns}" if program.shape else f"    one number {program.returns}"),
    ]
    if names.changed:
        told = [f"{_harmless(old)} is called {new}" for old, new in names.changed]
        lines += ["", "Names changed:", *(f"    {line}" for line in told)]
    return [line.rstrip() for line in lines]
