"""Polynomials in cosines and sines as tables of terms, and the sums of angles that make them shorter. Floor 7."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import Any

from .ring import Exponents

Part = tuple[Any, ...]
"""Of one group of angles: (c, s), the powers of cosine and sine; or, of several angles, (frequencies, 0 cos | 1 sin)."""
Key = tuple[tuple[Part, ...], Exponents]
Table = dict[Key, Fraction]
Sums = dict[Key, dict[tuple[int, ...], tuple[Fraction, Fraction]]]
"""Σ (a + b i) e^(i f·x) of one group, for each key without it."""


def _trivial(part: Part) -> bool:
    return not any(part[0]) if isinstance(part[0], tuple) else part == (0, 0)


def size_of(table: Table) -> int:
    """About the number of operations."""
    return sum(
        1 + (abs(value) != 1) + sum(not _trivial(part) for part in parts) + sum(others)
        for (parts, others), value in table.items()
    )


def _squared(table: Table, g: int) -> bool:
    """Whether an angle of its own occurs in more than the first power."""
    return any(not isinstance(parts[g][0], tuple) and sum(parts[g]) > 1 for parts, _ in table)


def with_sines(table: Table, g: int) -> Table:
    """The table with 1 - s² for the squares of one cosine."""
    if not _squared(table, g):
        return table
    found: Table = {}
    for (parts, others), value in table.items():
        c, s = parts[g]
        for k in range(c // 2 + 1):
            part = (c % 2, s + 2 * k)
            key = ((*parts[:g], part, *parts[g + 1 :]), others)
            found[key] = found.get(key, Fraction(0)) + value * math.comb(c // 2, k) * (-1) ** k
    return {key: value for key, value in found.items() if value}


def with_multiples(table: Table, g: int) -> Table:
    """The table with multiples of one angle for powers of its cosine: a constant one comes from a common part of several."""
    if not _squared(table, g):
        return table
    sums: Sums = {}
    for (parts, others), value in table.items():
        group = sums.setdefault(((*parts[:g], *parts[g + 1 :]), others), {})
        for f, (a, b) in _wave(parts[g]):
            real, imaginary = group.get(f, (Fraction(0), Fraction(0)))
            group[f] = real + value * a, imaginary + value * b
    return {((*key[0][:g], key[0][-1], *key[0][g:-1]), key[1]): value for key, value in _real(sums).items()}


def _partner(part: Part) -> Part | None:
    """The same wave a quarter of a turn on."""
    if isinstance(part[0], tuple):
        return None if _trivial(part) else (part[0], 1 - part[1])
    return part[::-1] if sum(part) == 1 else None


def worth(table: Table, x: int, y: int) -> bool:
    """Whether cosines and sines of two groups come in the pairs that make one cosine of a sum."""
    both = pairs = 0
    for (parts, others), value in table.items():
        a, b = _partner(parts[x]), _partner(parts[y])
        if a is None or b is None:
            continue
        both += 1
        other = list(parts)
        other[x], other[y] = a, b
        pairs += abs(table.get((tuple(other), others), 0)) == abs(value)
    return 2 * pairs >= both > 0


def merged(table: Table, x: int, y: int) -> Table:
    """The table with two groups as one, last, in waves."""
    sums: Sums = {}
    for (parts, others), value in table.items():
        rest = tuple(part for k, part in enumerate(parts) if k not in (x, y))
        group = sums.setdefault((rest, others), {})
        for f, (a, b) in _wave(parts[x]):
            for g, (c, d) in _wave(parts[y]):
                real, imaginary = group.get(f + g, (Fraction(0), Fraction(0)))
                group[f + g] = real + value * (a * c - b * d), imaginary + value * (a * d + b * c)
    return _real(sums)


def _real(sums: Sums) -> Table:
    """From coefficients of e^(i f·x) to those of cosines and sines, as a last part of the key."""
    found: Table = {}
    for (rest, others), group in sums.items():
        for f, (real, imaginary) in group.items():
            lead = next((k for k in f if k), 0)
            if lead < 0:
                continue
            for kind, size in ((0, 2 * real if lead else real), (1, -2 * imaginary if lead else Fraction(0))):
                if size:
                    found[(*rest, (f, kind)), others] = size
    return found


@lru_cache(maxsize=4096)
def _wave(part: Part) -> tuple[tuple[tuple[int, ...], tuple[Fraction, Fraction]], ...]:
    """A part as Σ (a + b i) e^(i f·x)."""
    half, none = Fraction(1, 2), Fraction(0)
    if isinstance(part[0], tuple):
        f, kind = part
        if not any(f):
            return ((f, (Fraction(1), none)),)
        pair = ((none, -half), (none, half)) if kind else ((half, none), (half, none))
        return ((f, pair[0]), (tuple(-k for k in f), pair[1]))
    waves = {0: (Fraction(1), none)}
    cosine, sine = ((1, (half, none)), (-1, (half, none))), ((1, (none, -half)), (-1, (none, half)))
    for factor in [cosine] * part[0] + [sine] * part[1]:
        product: dict[int, tuple[Fraction, Fraction]] = {}
        for k, (a, b) in waves.items():
            for f, (c, d) in factor:
                real, imaginary = product.get(k + f, (none, none))
                product[k + f] = real + a * c - b * d, imaginary + a * d + b * c
        waves = product
    return tuple(((k,), pair) for k, pair in waves.items())
