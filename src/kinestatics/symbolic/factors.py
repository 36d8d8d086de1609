"""`factored`: trigonometric polynomials as products of short expressions, complete over the rationals. Floor 7."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from .halfangle import HalfAngleRing
from .ring import Polynomial, TrigonometricRing
from .writer import Writer, content

_FACTORED = 600
"""Polynomials of more terms are printed as they are: their half-angle polynomials are too long to factor."""
_LONG = 100  # whole numbers from here on are lengths in disguise


def factored(ring: TrigonometricRing, p: Polynomial) -> list[tuple[Any, int]]:
    """Factors of a polynomial as expressions, complete over the rationals; the first does not depend on the joints."""
    import sympy

    writer = Writer(ring)
    if p == 0:
        return [(sympy.Integer(0), 1)]
    if len(p.to_dict()) > _FACTORED:
        return [(sympy.Integer(1), 1), (writer(p), 1)]
    half = HalfAngleRing(ring)
    constant, parts = half.factored(half.lifted(p))
    whole, odd = dict[str, tuple[Polynomial, int]](), list[Polynomial]()
    for F, times in parts:
        if any(d % 2 for d in half.degrees(F)):
            odd += [F] * times
        else:
            _count(whole, half.full_angles(F), times)
    if any(d % 2 for d in half.degrees(constant)):
        odd, constant = [*odd, constant], half.context.constant(1)
    for F in _paired(half, odd):
        _count(whole, half.full_angles(F), 1)
    scale, found = half.full_angles(constant), []
    for F, times in whole.values():
        size = ring.number(_scale(ring, F))
        expression = writer(F / size.leading_coefficient())
        if _mostly_negative(expression):
            expression, size = -expression, -size
        scale = scale * size**times
        found.append((expression, times))
    found.sort(key=lambda pair: (len(pair[0].free_symbols), str(pair[0])))
    return [(writer(scale), 1), *found]


def _scale(ring: TrigonometricRing, F: Polynomial) -> Fraction:
    """What to divide a factor by, so that its numbers are small and whole, or lengths in metres."""
    values = [Fraction(int(c.p), int(c.q)) for c in F.to_dict().values()]
    size = abs(content(values))
    largest = max(abs(value) for value in values) / size
    first = ring.parameter_place(0)
    given = any(e[k] for e in F.to_dict() for k in range(first, first + len(ring.parameters)))
    return size if given or largest < _LONG else size * 10 ** len(str(int(largest)))


def _mostly_negative(expression: Any) -> bool:
    terms = expression.args if expression.is_Add else (expression,)
    return sum(bool(term.as_coeff_Mul()[0].is_negative) for term in terms) * 2 > len(terms)


def _count(found: dict[str, tuple[Polynomial, int]], F: Polynomial, times: int) -> None:
    key = str(F)
    found[key] = F, times + (found[key][1] if key in found else 0)


def _length(half: HalfAngleRing, F: Polynomial, G: Polynomial) -> tuple[int, bool]:
    """How long a product is in whole angles; of two alike, one with another comes first."""
    whole = half.full_angles(F * G)
    return (0 if whole is None else len(whole.to_dict())), bool(F == G)


def _paired(half: HalfAngleRing, odd: list[Polynomial]) -> list[Polynomial]:
    """Products of factors that are odd in some angle, even in all: two of one kind where there are, the rest together."""
    rest, found, left = list(odd), [], None
    while rest:
        F = rest.pop(0)
        kind = [d % 2 for d in half.degrees(F)]
        partners = [k for k, G in enumerate(rest) if [d % 2 for d in half.degrees(G)] == kind]
        if partners:
            best = min(partners, key=lambda k: _length(half, F, rest[k]))
            found.append(F * rest.pop(best))
        else:
            left = F if left is None else left * F
    return found if left is None else [*found, left]
