"""Names, numbers and words as LaTeX: a_{2} for a2, \\dot{q}_{1} for qd1. Floor 7."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

_LETTERS = (
    "alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
GREEK = frozenset(_LETTERS.split())
JOINT = re.compile(r"(q|theta|joint)(\d+)_*")
_RATE = re.compile(r"(q|theta|joint)(dd?)(\d+)_*")
_SIX = re.compile(r"([vwfm])([xyz])_*")
_PIECES = re.compile(r"([A-Za-z]+?)(?:_?(\d+)|_([A-Za-z0-9]+))?(_*)")
_SPECIAL = {"\\": r"\backslash ", "^": r"\wedge ", "~": r"\sim "}
_ESCAPED = set("{}$&#%_")


def decimal(text: str) -> str:
    """A number as people write it: 1.2e-05 with a power of ten."""
    if "nan" in text or "inf" in text:
        return text.replace("nan", r"\mathrm{NaN}").replace("inf", r"\infty")
    number, _, power = text.partition("e")
    return rf"{number} \cdot 10^{{{int(power)}}}" if power else number


def words(text: str) -> str:
    """Any text, upright, with its marks made harmless."""
    safe = "".join(f"\\{c}" if c in _ESCAPED else " " if c in "\\^~\n\r" else c for c in text)
    return rf"\text{{{safe}}}"


@lru_cache(maxsize=4096)
def symbol(name: str) -> str:
    """The name of a symbol: a_{2} for a2, \\theta_{1} for theta1, \\dot{q}_{1} for qd1, v_{x} for vx."""
    if found := _RATE.fullmatch(name):
        dots = {"d": r"\dot", "dd": r"\ddot"}[found[2]]
        return f"{dots}{{{_letter(found[1])}}}_{{{found[3]}}}{_primes(name)}"
    if name.startswith("d") and _SIX.fullmatch(name.removeprefix("d")):
        kind, axis = name[1], name[2]
        return rf"\dot{{{_SIX_LETTERS[kind]}}}_{{{axis}}}{_primes(name)}"
    if found := _SIX.fullmatch(name):
        return f"{_SIX_LETTERS[found[1]]}_{{{found[2]}}}{_primes(name)}"
    if found := _PIECES.fullmatch(name):
        below = found[2] or found[3]
        shown = below if not below or below.isdigit() or len(below) == 1 else rf"\mathrm{{{below}}}"
        index = f"_{{{shown}}}" if below else ""
        return f"{_letter(found[1])}{index}{_primes(name)}"
    return _harmless(name)


_SIX_LETTERS = {"v": "v", "w": r"\omega", "f": "f", "m": "m"}


def _letter(letters: str) -> str:
    if letters in GREEK:
        return f"\\{letters}"
    return letters if len(letters) == 1 else rf"\mathrm{{{letters}}}"


def _primes(name: str) -> str:
    return "'" * (len(name) - len(name.rstrip("_")))


def _harmless(name: str) -> str:
    safe = "".join(f"\\{c}" if c in _ESCAPED else _SPECIAL.get(c, c) for c in name if c.isprintable())
    return rf"\mathrm{{{safe or '?'}}}"


def short_decimal(x: Any) -> str | None:
    """A fraction that is a short decimal, as one; thirds and eighths stay fractions."""
    rest = int(x.q)
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest != 1 or x.q <= 8:
        return None
    return f"{float(x):.12g}" if "e" not in f"{float(x):.12g}" else decimal(f"{float(x):.12g}")


def fraction_text(p: int, q: int) -> str:
    """A positive fraction: 0.425 for 17/40, \\frac{1}{3}."""
    import sympy

    plain = short_decimal(sympy.Rational(p, q))
    return plain if plain is not None else rf"\frac{{{p}}}{{{q}}}"
