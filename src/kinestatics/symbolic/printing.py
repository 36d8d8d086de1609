"""From exact polynomials to short SymPy expressions, without SymPy's simplification. Floor 7.

The shorter of two canonical forms: a sum of waves, a2 cos(q2) + a3 cos(q2 + q3), is short where axes are parallel, products
of cosines and sines elsewhere.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from .halfangle import HalfAngleRing, Waves
from .ring import Polynomial, TrigonometricRing


def rational(value: Any) -> Any:
    """A SymPy number."""
    import sympy

    if isinstance(value, Fraction):
        return sympy.Rational(value.numerator, value.denominator)
    return sympy.Rational(int(value.p), int(value.q))


def to_sympy(ring: TrigonometricRing, p: Polynomial) -> Any:
    """A polynomial in whole angles, as a sum of products."""
    import sympy

    values = generator_values(ring)
    terms = []
    for exponents, coefficient in p.to_dict().items():
        factors = [value ** int(e) for value, e in zip(values, exponents, strict=False) if e]
        terms.append(sympy.Mul(rational(coefficient), *factors))
    return sympy.Add(*terms)


def waves_to_sympy(ring: TrigonometricRing, waves: Waves) -> Any:
    """A sum of waves."""
    import sympy

    angles = [angle.expression for angle in ring.angles]
    others = _others(ring)
    terms = []
    for k, group in waves.items():
        phase = sympy.Add(*[sympy.Rational(f, 2) * x for f, x in zip(k, angles, strict=True) if f])
        sums = []
        for part in (0, 1):
            parts = [
                sympy.Mul(rational(pair[part]), *[x**e for x, e in zip(others, exponents, strict=False) if e])
                for exponents, pair in group.items()
                if pair[part]
            ]
            sums.append(sympy.Add(*parts))
        terms.append(sums[0] * sympy.cos(phase) + sums[1] * sympy.sin(phase))
    return sympy.Add(*terms)


def shortest(half: HalfAngleRing, F: Polynomial) -> Any:
    """The shorter form of a polynomial in half angles; common factors are taken out of short ones."""
    import sympy

    whole = half.full_angles(F)
    products = half.in_whole_angles(F) if whole is None else [((0,) * len(half.ring.angles), whole)]
    size = sum(1 + sum(map(bool, e)) for _, p in products for e in p.to_dict())
    if sum(len(p.to_dict()) for _, p in products) > _MANY:  # its waves would be more
        return _sum_of(half, products)
    waves = half.waves(F)
    of_waves = sum(
        sum(map(bool, k)) + sum((1 + sum(map(bool, e))) * sum(map(bool, pair)) for e, pair in group.items())
        for k, group in waves.items()
    )
    form = waves_to_sympy(half.ring, waves) if of_waves <= size else _sum_of(half, products)
    if len(form.args) > _FEW:
        return form
    return min((form, sympy.factor_terms(form)), key=lambda x: (sympy.count_ops(x), str(x)))


def _sum_of(half: HalfAngleRing, products: list[tuple[tuple[int, ...], Polynomial]]) -> Any:
    """Σ of sines and cosines of half angles, each times a polynomial in whole angles."""
    import sympy

    angles = [angle.expression for angle in half.ring.angles]
    terms = []
    for halves, p in products:
        factors = [(sympy.sin if kind == 1 else sympy.cos)(x / 2) for kind, x in zip(halves, angles, strict=True) if kind]
        terms.append(sympy.Mul(*factors, to_sympy(half.ring, p)))
    return sympy.Add(*terms)


def shortest_in_whole_angles(half: HalfAngleRing, p: Polynomial) -> Any:
    """The shorter of the two forms of a polynomial in whole angles."""
    return shortest(half, half.lifted(p)) if p != 0 else to_sympy(half.ring, p)


_FEW, _MANY = 12, 60


def generator_values(ring: TrigonometricRing) -> list[Any]:
    """What every generator of a ring stands for, in the order of the generators."""
    import sympy

    size = ring.parameter_place(0) + len(ring.parameters) + len(ring.roots)
    values: list[Any] = [None] * size
    for angle in ring.angles:
        values[angle.cosine], values[angle.sine] = sympy.cos(angle.expression), sympy.sin(angle.expression)
    for joint, place in ring.slides.items():
        values[place] = ring.joints[joint]
    for k, value in enumerate([*ring.parameters, *map(sympy.sqrt, ring.roots)]):
        values[ring.parameter_place(k)] = value
    return values


def _others(ring: TrigonometricRing) -> list[Any]:
    import sympy

    return [*(ring.joints[j] for j in ring.slides), *ring.parameters, *map(sympy.sqrt, ring.roots)]
