"""The same questions to matrices of SymPy expressions: null spaces and least squares at almost all values of the symbols.

Which entries vanish for all values is asked of fixed pseudo-random numbers in place of the symbols; the answer is then
worked out in symbols. A posture or length at which the rank is less must be put in as such.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..model import RobotModel
from ..namespaces import Array

_DRAWS = 3
_ZERO = 1e-9  # of the largest entry: a smaller pivot at random numbers is none at any


class Pivots(NamedTuple):
    """Rows and columns of a square block that is regular at almost all values of the symbols, as large as there is."""

    rows: list[int]
    columns: list[int]


def exact(array: Array) -> Array:
    """Numbers as the fractions their decimals say: 0.1 is one tenth."""
    import sympy

    return np.array([sympy.Rational(str(x)) for x in array.flat], dtype=object).reshape(array.shape)


def shorter(expression: Any) -> Any:
    """A fraction with numerator and denominator in factors, sines and cosines gathered: simplified, in bearable time."""
    import sympy

    parts = sympy.fraction(sympy.factor(sympy.together(expression)))
    above, below = (sympy.factor(sympy.trigsimp(part)) for part in parts)
    return above / below


def simplified(matrix: Any) -> Array:
    """A SymPy matrix as an array of shorter entries."""
    return np.array([shorter(x) for x in matrix], dtype=object).reshape(matrix.shape)


def unknowns(entries: Any) -> list[Any]:
    """Symbols, and functions such as q(t), in the order of their names."""
    import sympy
    from sympy.core.function import AppliedUndef

    found: set[Any] = set()
    for entry in entries:
        functions = sympy.sympify(entry).atoms(AppliedUndef)
        found |= functions | sympy.sympify(entry).subs(dict.fromkeys(functions, 0)).free_symbols
    return sorted(found, key=str)


def _at_random(array: Array, seed: int) -> Array:
    """Numbers in place of the symbols."""
    import sympy

    names = unknowns(array.flat)
    drawn = np.random.default_rng(20261126 + seed).uniform(0.4, 1.6, len(names))
    values = list(zip(names, drawn.tolist(), strict=True))
    values.sort(key=lambda pair: isinstance(pair[0], sympy.Symbol))  # q(t) before t
    try:
        numbers = [float(sympy.sympify(x).subs(values)) for x in array.flat]
    except TypeError as error:
        message = f"an expression has no real value at numbers in place of {', '.join(map(str, names))}: {error}"
        raise ConfigurationError("KS336", message, "expressions of symbols that take real values") from None
    return np.array(numbers, dtype=np.float64).reshape(array.shape)


def pivots(array: Array) -> Pivots:
    """The leftmost columns that are independent at almost all values, and rows that show it."""
    found = [_pivots(_at_random(array, seed)) for seed in range(_DRAWS)]
    return max(found, key=lambda pivot: len(pivot.rows))


def _pivots(matrix: Array) -> Pivots:
    """Gaussian elimination of numbers, column by column with the largest pivot of each."""
    rest, rows, columns = matrix.copy(), list[int](), list[int]()
    smallest = _ZERO * np.abs(matrix).max(initial=0.0)
    for column in range(matrix.shape[1]):
        if len(rows) == matrix.shape[0]:
            break
        candidates = np.abs(rest[:, column])
        candidates[rows] = 0.0
        row = int(np.argmax(candidates))
        if candidates[row] > smallest:
            factors = rest[:, column] / rest[row, column]
            factors[[*rows, row]] = 0.0
            rest = rest - np.outer(factors, rest[row])
            rows.append(row)
            columns.append(column)
    return Pivots(rows, columns)


def null_space(array: Array) -> Array:
    """(m - rank, m) vectors that a matrix (n, m) of expressions sends to zero, at almost all values of the symbols."""
    import sympy

    m = array.shape[1]
    pivot = pivots(array)
    free = [column for column in range(m) if column not in pivot.columns]
    basis = exact(np.zeros((len(free), m)))
    basis[range(len(free)), free] = sympy.Integer(1)
    if pivot.rows and free:
        A = sympy.Matrix(array)
        block = inverse(A.extract(pivot.rows, pivot.columns))
        basis[:, pivot.columns] = simplified((-block * A.extract(pivot.rows, free)).T)
    return basis


def inverse(matrix: Any) -> Any:
    """Of a SymPy matrix that is regular at almost all values; no pivot is asked whether it vanishes."""
    return matrix.adjugate() / shorter(matrix.det())


def with_numbers(model: RobotModel) -> RobotModel:
    """The model with fixed pseudo-random numbers in place of its symbols: what it can do at almost all lengths."""
    import sympy

    entries: list[Any] = []

    def collect(array: Array) -> Array:
        entries.extend(array.flat if array.dtype == object else ())
        return array

    model.map(collect)
    names = unknowns(entries)
    drawn = np.random.default_rng(20261126).uniform(0.4, 1.6, len(names))
    values = dict(zip(names, drawn.tolist(), strict=True))

    def replaced(array: Array) -> Array:
        if array.dtype != object:
            return array
        numbers = [float(sympy.sympify(x).subs(values)) for x in array.flat]
        return np.array(numbers, dtype=np.float64).reshape(array.shape)

    return model.map(replaced)
