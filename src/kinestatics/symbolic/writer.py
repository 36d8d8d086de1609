"""Short SymPy expressions for exact polynomials, without simplification. Floor 7.

Polynomials are canonical, so that nothing is left to be simplified: cosines of sums of angles stand where that is shorter,
and what several terms have in common is taken out.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import Any

from .printing import generator_values
from .ring import Matrix, Polynomial, TrigonometricRing
from .wave_tables import Key, Table, merged, size_of, with_multiples, with_sines, worth

_LOOKED_AT = 5
_BITS = 200  # of a denominator that no product of decimals has
Term = tuple[Fraction, dict[int, int]]
"""A coefficient, and the powers of factors by their number."""


class Writer:
    """Polynomials as SymPy expressions: cosines of sums of angles where that is shorter, common factors taken out."""

    def __init__(self, ring: TrigonometricRing) -> None:
        self.ring = ring
        self.values = generator_values(ring)
        self.trigonometric = {place for angle in ring.angles for place in (angle.cosine, angle.sine)}
        self.plain = [k for k in range(len(self.values)) if k not in self.trigonometric]

    def matrix(self, M: Matrix) -> Any:
        """A SymPy matrix."""
        import sympy

        return sympy.ImmutableDenseMatrix([[self(p) for p in row] for row in M])

    def __call__(self, p: Polynomial) -> Any:
        """One expression."""
        angles, table = self._table(p)
        groups: list[tuple[int, ...]] = [(a,) for a in angles]
        for g in range(len(groups)):
            table = min(table, with_sines(table, g), with_multiples(table, g), key=size_of)
        size, tried = size_of(table), set[tuple[Any, ...]]()
        while pair := next((p for p in itertools.combinations(groups, 2) if p not in tried), None):
            tried.add(pair)
            x, y = map(groups.index, pair)
            if worth(table, x, y) and (cost := size_of(joined := merged(table, x, y))) < size:
                groups, table, size = [*(g for g in groups if g not in pair), pair[0] + pair[1]], joined, cost
        atoms: dict[Any, int] = {}
        terms = [self._term(groups, key, value, atoms) for key, value in table.items()]
        return _nested(terms, list(atoms))

    def _table(self, p: Polynomial) -> tuple[list[int], Table]:
        terms = {tuple(map(int, e)): _readable(Fraction(int(c.p), int(c.q))) for e, c in p.to_dict().items()}
        pairs = [(angle.cosine, angle.sine) for angle in self.ring.angles]
        present = [a for a, (c, s) in enumerate(pairs) if any(e[c] or e[s] for e in terms)]
        table = {}
        for e, coefficient in terms.items():
            parts = tuple((e[pairs[a][0]], e[pairs[a][1]]) for a in present)
            table[parts, tuple(e[k] for k in self.plain if k < len(e))] = coefficient
        return present, table

    def _term(self, groups: list[tuple[int, ...]], key: Key, value: Fraction, atoms: dict[Any, int]) -> Term:
        import sympy

        factors: dict[int, int] = {}
        for group, part in zip(groups, key[0], strict=True):
            angles = [self.ring.angles[a].expression for a in group]
            if not isinstance(part[0], tuple):
                wave = [(sympy.cos(angles[0]), part[0]), (sympy.sin(angles[0]), part[1])]
            else:
                phase = sympy.Add(*[f * x for f, x in zip(part[0], angles, strict=True)])
                wave = [(_wave_of(phase, part[1]), 1)] if phase != 0 else []
            for x, power in wave:
                if power:
                    _raise(factors, atoms.setdefault(x, len(atoms)), power)
        for place, power in zip(self.plain, key[1], strict=False):
            if power:
                x = self.values[place]
                _raise(factors, atoms.setdefault(x, len(atoms)), power)
        return value, factors


def _wave_of(phase: Any, kind: int) -> Any:
    """The cosine (0) or sine (1) of a phase; of a constant one as it is written, where its roots would be a sum."""
    import sympy

    function = sympy.sin if kind else sympy.cos
    wave = function(phase)
    return function(phase, evaluate=False) if wave.is_Add else wave


def _raise(factors: dict[int, int], atom: int, power: int) -> None:
    factors[atom] = factors.get(atom, 0) + power


def _nested(terms: list[Term], atoms: list[Any]) -> Any:
    """A sum of products with common factors taken out, those first that save most."""
    import sympy

    if not terms:
        return sympy.Integer(0)
    common, size = _common(terms), content([value for value, _ in terms])
    rest = [(value / size, _without(factors, common)) for value, factors in terms]
    shared = [sympy.Rational(size.numerator, size.denominator), *(atoms[x] ** e for x, e in common.items())]
    if len(rest) == 1:
        return sympy.Mul(*shared)
    if (square := _square(rest, atoms)) is not None:
        return sympy.Mul(*shared, square)
    parts = []
    while (best := _best(rest)) is not None:
        parts.append(_nested([term for term in rest if best in term[1]], atoms))
        rest = [term for term in rest if best not in term[1]]
    parts += [_nested([term], atoms) for term in rest]
    return sympy.Mul(*shared, sympy.Add(*parts))


def _square(terms: list[Term], atoms: list[Any]) -> Any:
    """sin² for 1 - cos² and cos² for 1 - sin²; None for other sums."""
    import sympy

    if len(terms) != 2 or terms[0][0] != -terms[1][0]:
        return None
    (value, one), (_, other) = sorted(terms, key=lambda term: len(term[1]))
    if one or len(other) != 1 or [*other.values()] != [2]:
        return None
    wave = atoms[next(iter(other))]
    partner = {sympy.cos: sympy.sin, sympy.sin: sympy.cos}.get(type(wave))
    return (
        None
        if partner is None
        else sympy.Mul(sympy.Rational(value.numerator, value.denominator), partner(wave.args[0]) ** 2)
    )


def _best(terms: list[Term]) -> int | None:
    """The factor that saves most when it is taken out of all terms that hold it, with all that these have in common."""
    counts: dict[int, int] = {}
    for _, factors in terms:
        for x in factors:
            counts[x] = counts.get(x, 0) + 1
    often = sorted((x for x, count in counts.items() if count > 1), key=lambda x: (-counts[x], x))[:_LOOKED_AT]
    if not often:
        return None
    return max(often, key=lambda x: (counts[x] - 1) * sum(_common([t for t in terms if x in t[1]]).values()))


def _common(terms: list[Term]) -> dict[int, int]:
    common = dict(terms[0][1])
    for _, factors in terms:
        for x in [x for x, e in common.items() if factors.get(x, 0) < e]:
            if x in factors:
                common[x] = factors[x]
            else:
                del common[x]
        if not common:
            break
    return common


def _without(factors: dict[int, int], common: dict[int, int]) -> dict[int, int]:
    return {x: e - common.get(x, 0) for x, e in factors.items() if e > common.get(x, 0)}


def _readable(x: Fraction) -> Fraction:
    """A number with at most 17 digits where it has so many that they come from rotations of fractions."""
    return Fraction(f"{float(x):.17g}") if x.denominator.bit_length() > _BITS else x


def content(values: list[Fraction]) -> Fraction:
    """What numbers have in common, with the sign that most of them have."""
    sign = -1 if sum(value < 0 for value in values) * 2 > len(values) else 1
    top = math.gcd(*(value.numerator for value in values))
    return Fraction(sign * top, math.lcm(*(value.denominator for value in values)))


def rounded_text(expression: Any) -> str:
    """An expression as text, fractions as decimals of 6 digits where their denominators are long."""
    import sympy

    if not hasattr(expression, "atoms"):
        return str(expression)
    constant = {x: sympy.Symbol(str(x)) for x in expression.atoms(sympy.cos, sympy.sin) if not x.free_symbols}
    plain = expression.xreplace(constant)
    long = {x: sympy.Float(f"{float(x):.6g}") for x in plain.atoms(sympy.Rational) if x.q > 12 or abs(x.p) > 1e6}
    return str(sympy.sstr(plain.xreplace(long), full_prec=False))
