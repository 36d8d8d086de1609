"""Exact trigonometric polynomials: cosines and sines of the joints, lengths and constant angles, by python-flint. Floor 7.

Every angle is a pair c, s of generators with s² = 1 - c², every square root of a prime one with its square known. Sums and
products are brought to the form that has no s² and no root squared: there it is canonical, so that zero is seen as zero.
Generators have no names: a length may be called c1, s2, q3, I or E.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import ArrayTypeError, missing_extra
from ..namespaces import Array

Polynomial = Any
"""An fmpq_mpoly of python-flint."""
Exponents = tuple[int, ...]
_MOST_TIMES = 24


def flint() -> Any:
    """The module flint.

    Raises:
        MissingExtraError: KS400.
    """
    try:
        import flint
    except ImportError:
        raise missing_extra("python-flint", "symbolic", "exact polynomials") from None
    return flint


@dataclass(frozen=True)
class Angle:
    """An angle of the ring: a joint's, or a constant one.

    Attributes:
        expression: SymPy; the joint's symbol, or what the constant is.
        cosine, sine: places of its generators.
    """

    expression: Any
    cosine: int
    sine: int


@dataclass(frozen=True, eq=False)
class TrigonometricRing:
    """Q[c, s, q, lengths, roots] with c² + s² = 1 for every angle.

    Attributes:
        joints: (n) SymPy symbols of the joints.
        turns: (n) whether a joint is an angle; others are generators as they are.
        constants: SymPy expressions of constant angles; parameters: of symbols; roots: primes whose square roots occur.
    """

    joints: tuple[Any, ...]
    turns: tuple[bool, ...]
    constants: tuple[Any, ...] = ()
    parameters: tuple[Any, ...] = ()
    roots: tuple[int, ...] = ()
    context: Any = field(init=False)
    angles: tuple[Angle, ...] = field(init=False)
    slides: dict[int, int] = field(init=False)
    _generators: tuple[Polynomial, ...] = field(init=False, repr=False)
    _first_parameter: int = field(init=False, repr=False)
    _read: dict[Any, Polynomial] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        angles, slides, place = [], {}, 0
        for j, (symbol, turns) in enumerate(zip(self.joints, self.turns, strict=True)):
            if turns:
                angles.append(Angle(symbol, place, place + 1))
            else:
                slides[j] = place
            place += 1 + turns
        for expression in self.constants:
            angles.append(Angle(expression, place, place + 1))
            place += 2
        size = place + len(self.parameters) + len(self.roots)
        module = flint()
        names = tuple(f"g{i}" for i in range(max(size, 1)))
        object.__setattr__(self, "context", module.fmpq_mpoly_ctx.get(names, module.Ordering.lex))
        object.__setattr__(self, "angles", tuple(angles))
        object.__setattr__(self, "slides", slides)
        object.__setattr__(self, "_generators", tuple(self.context.gens()))
        object.__setattr__(self, "_first_parameter", place)
        object.__setattr__(self, "_read", {})

    @property
    def zero(self) -> Polynomial:
        """0."""
        return self.context.constant(0)

    @property
    def one(self) -> Polynomial:
        """1."""
        return self.context.constant(1)

    def number(self, value: Any) -> Polynomial:
        """A rational number."""
        return self.context.constant(flint().fmpq(int(value.numerator), int(value.denominator)))

    def generator(self, place: int) -> Polynomial:
        """The generator at a place."""
        return self._generators[place]

    def angle_of(self, joint: int) -> Angle:
        """The angle of a turning joint."""
        return self.angles[sum(self.turns[:joint])]

    def parameter_place(self, k: int) -> int:
        """The place of a length's generator."""
        return self._first_parameter + k

    def multiple(self, angle: Angle, times: int) -> tuple[Polynomial, Polynomial]:
        """Cosine and sine of a whole multiple of an angle."""
        c, s = self.generator(angle.cosine), self.generator(angle.sine)
        if times < 0:
            s = -s
        cosine, sine = self.one, self.zero
        for _ in range(abs(times)):
            cosine, sine = self.reduced(c * cosine - s * sine), self.reduced(s * cosine + c * sine)
        return cosine, sine

    def reduced(self, p: Polynomial) -> Polynomial:
        """The canonical form."""
        degrees = p.degrees()
        for angle in self.angles:
            if degrees[angle.sine] > 1:
                c = self.generator(angle.cosine)
                p = self._lowered(p, angle.sine, 2, self.one - c * c)
                degrees = p.degrees()
        for k, prime in enumerate(self.roots):
            place = self.parameter_place(len(self.parameters) + k)
            if degrees[place] > 1:
                p = self._lowered(p, place, 2, self.context.constant(prime))
        return p

    def _lowered(self, p: Polynomial, place: int, power: int, by: Polynomial) -> Polynomial:
        """p with generator^power replaced by a polynomial."""
        groups: dict[int, dict[Exponents, Any]] = {}
        for exponents, coefficient in p.to_dict().items():
            times, rest = divmod(exponents[place], power)
            left = (*exponents[:place], rest, *exponents[place + 1 :])
            groups.setdefault(times, {})[left] = coefficient
        total = self.zero
        for times, terms in groups.items():
            total += self.context.from_dict(terms) * by**times
        return total

    def total(self, parts: Iterable[Polynomial]) -> Polynomial:
        """The sum in canonical form."""
        return self.reduced(sum(parts, self.zero))

    def read(self, expression: Any) -> Polynomial:
        """A SymPy expression of parameters and constant angles, or a whole number of Python.

        Raises:
            ArrayTypeError: KS390, where it is no polynomial of them.
        """
        known = self._read
        if (found := known.get(expression)) is None:
            found = known[expression] = self.reduced(self._translated(expression))
        return found

    def _translated(self, expression: Any) -> Polynomial:
        import sympy

        if isinstance(expression, int):
            return self.context.constant(expression)
        if expression.is_Rational:
            return self.context.constant(flint().fmpq(int(expression.p), int(expression.q)))
        if expression in self.parameters:
            return self.generator(self.parameter_place(self.parameters.index(expression)))
        if isinstance(expression, sympy.cos | sympy.sin):
            number, rest = parts_of(expression.args[0])
            for angle in self.angles[sum(self.turns) :]:
                ratio, same = parts_of(angle.expression)
                if same == rest and (number / ratio).is_Integer and abs(number / ratio) <= _MOST_TIMES:
                    return self.multiple(angle, int(number / ratio))[isinstance(expression, sympy.sin)]
        if expression.is_Add:
            return sum((self.read(x) for x in expression.args), self.zero)
        if expression.is_Mul:
            product = self.one
            for x in expression.args:
                product *= self.read(x)
            return product
        if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
            return self.read(expression.base) ** int(expression.exp)
        if expression.is_Pow and expression.base.is_Integer and 2 * expression.exp in (1, -1):
            root = self._root(int(expression.base))
            return root if expression.exp > 0 else root / int(expression.base)
        raise not_polynomial(expression)

    def _root(self, number: int) -> Polynomial:
        """The square root of a whole number."""
        import sympy

        root = self.one
        for prime, times in sympy.factorint(number).items():
            place = self.parameter_place(len(self.parameters) + self.roots.index(int(prime)))
            root *= self.generator(place) ** times
        return root


def not_polynomial(expression: Any) -> ArrayTypeError:
    """KS390."""
    hint = "lengths and angles may be numbers, symbols, and sums and products of them and of cosines and sines"
    return ArrayTypeError("KS390", f"{expression} is no polynomial of lengths and of cosines and sines of angles", hint)


def parts_of(angle: Any) -> tuple[Any, Any]:
    """A constant angle as a rational number times a thing: (4/9, pi), (-1, alpha), (1/2, 1)."""
    number, rest = angle.as_coeff_Mul()
    if not number.is_Rational:
        raise not_polynomial(angle)
    return number, rest


def bases_of(angles: Iterable[Any]) -> tuple[Any, ...]:
    """Constant angles of which all given ones are whole multiples: pi/36 for 55 and 110 degrees.

    Multiples beyond a few dozen would be polynomials of that degree: such angles stand for themselves, and what relates
    them is not known to the ring.
    """
    import sympy

    numbers: dict[Any, set[Any]] = {}
    for angle in angles:
        number, rest = parts_of(angle)
        numbers.setdefault(rest, set()).add(abs(number))
    found = []
    for rest, values in numbers.items():
        common = sympy.ilcm(1, *(x.q for x in values))
        if max(values) * common <= _MOST_TIMES:
            found.append(rest / common)
        else:
            found += [x * rest for x in values]
    return tuple(sorted(found, key=str))


def atoms_of(entries: Iterable[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...], tuple[int, ...]]:
    """Constant angles, parameters and primes under roots that occur in SymPy expressions, in a fixed order."""
    import sympy

    angles: set[Any] = set()
    symbols: set[Any] = set()
    primes: set[int] = set()

    def visit(x: Any) -> None:
        if isinstance(x, sympy.cos | sympy.sin):
            angles.add(x.args[0])
            return
        if x.is_Symbol:
            symbols.add(x)
        elif x.is_Pow and 2 * x.exp in (1, -1) and x.base.is_Integer and x.base > 0:
            primes.update(int(prime) for prime in sympy.factorint(x.base))
        for argument in x.args:
            visit(argument)

    for entry in entries:
        visit(entry)
    return bases_of(angles), tuple(sorted(symbols, key=str)), tuple(sorted(primes))


def expanded(array: Array) -> list[list[Any]] | list[Any]:
    """Entries of a matrix or vector of SymPy expressions, sums of angles taken apart."""
    import sympy

    def one(x: Any) -> Any:
        x = sympy.sympify(x)
        if x.has(sympy.Float):
            x = sympy.nsimplify(x, rational=True)
        return sympy.expand_trig(x) if any(a.args[0].is_Add for a in x.atoms(sympy.cos, sympy.sin)) else x

    return [expanded(row) for row in array] if array.ndim > 1 else [one(x) for x in array]


Matrix = Sequence[Sequence[Polynomial]]
