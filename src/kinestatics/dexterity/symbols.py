"""The measures of matrices of SymPy expressions: closed forms, where they are short enough to be read."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array

_ROUNDING = 1e-14


def each(array: Array, function: Callable[[Array], Any]) -> Any:
    """The function of every matrix of a batch (..., r, n)."""
    if array.ndim == 2:
        return function(array)
    batch = array.shape[:-2]
    values = [np.asarray(function(array[index]), dtype=object) for index in np.ndindex(*batch)]
    return np.array(values, dtype=object).reshape(*batch, *(values[0].shape if values else ()))


def volume(array: Array, rank: int) -> Any:
    """The product of the first `rank` singular values, all others being zero."""
    import sympy

    minors = _minors(array, rank) if rank else []
    if len(minors) == 1:
        return sympy.Abs(minors[0])
    return sympy.sqrt(sum((minor**2 for minor in minors), sympy.Integer(0)))


def isotropy(array: Array, rank: int) -> Any:
    """Geometric over arithmetic mean of the first `rank` squared singular values."""
    import sympy

    if not rank:
        return sympy.Integer(0)
    power = sympy.Rational(1, rank)
    return rank * _invariant(array, rank) ** power / _invariant(array, 1)


def singular_values(array: Array) -> Array:
    """One or two singular values, descending."""
    k = min(array.shape)
    if k > 2:
        raise _too_many(k)
    return np.array(_squares_to_roots(array, k), dtype=object)


def smallest(array: Array, rank: int) -> Any:
    """The last singular value that counts."""
    import sympy

    if rank > 2:
        raise _too_many(rank)
    return _squares_to_roots(array, rank)[rank - 1] if rank else sympy.Integer(0)


def condition(array: Array, rank: int) -> Any:
    """σ1/σ_rank for a rank of one or two."""
    import sympy

    if rank == 0:
        return sympy.oo
    if rank > 2:
        raise _too_many(rank)
    if rank == 1:
        return sympy.Integer(1)
    t, d, root = _trace_and_volume(array)
    return sympy.oo if d == 0 else (t + root) / (2 * sympy.sqrt(d))


def inverse_condition(array: Array, rank: int) -> Any:
    """σ_rank/σ1 for a rank of one or two."""
    import sympy

    if rank != 2:
        return sympy.Integer(0) if rank == 0 else 1 / condition(array, rank)
    t, d, root = _trace_and_volume(array)
    return 2 * sympy.sqrt(d) / (t + root)


def _squares_to_roots(array: Array, rank: int) -> list[Any]:
    import sympy

    if rank < 2:
        return [sympy.sqrt(_invariant(array, 1))] * rank
    t, _, root = _trace_and_volume(array)
    return [sympy.sqrt((t + root) / 2), sympy.sqrt((t - root) / 2)]


def _trace_and_volume(array: Array) -> tuple[Any, Any, Any]:
    """σ1² + σ2², σ1² σ2², and σ1² - σ2²."""
    import sympy

    t, d = _invariant(array, 1), _invariant(array, 2)
    return t, d, sympy.sqrt(sympy.factor(sympy.simplify(t**2 - 4 * d)))


def _invariant(array: Array, rank: int) -> Any:
    """The sum of all products of `rank` different squared singular values (Cauchy and Binet)."""
    import sympy

    total = sum((minor**2 for minor in _minors(array, rank)), sympy.Integer(0))
    return sympy.factor(sympy.simplify(total)) if rank == 1 else total


def _minors(array: Array, rank: int) -> list[Any]:
    """All minors of a size that are not zero."""
    import sympy

    matrix, found = _exact(sympy.Matrix(array)), []
    for rows in combinations(range(matrix.rows), rank):
        for columns in combinations(range(matrix.cols), rank):
            minor = sympy.factor(sympy.simplify(matrix.extract(list(rows), list(columns)).det()))
            if minor != 0:
                found.append(minor)
    return found


def _exact(matrix: Any) -> Any:
    """The matrix with fractions for floats, read to 15 digits, and 0 for rounding such as cos(π/2) = 6e-17.

    Simplification cannot cancel floats, and leaves hundreds of terms that are nothing but rounding.
    """
    import sympy

    floats = matrix.atoms(sympy.Float)
    floor = _ROUNDING * max((abs(x) for x in floats), default=0)
    return matrix.xreplace({x: sympy.Rational(f"{float(x):.15g}") if abs(x) > floor else sympy.Integer(0) for x in floats})


def _too_many(count: int) -> ArrayTypeError:
    message = f"{count} singular values of symbols have no closed form that can be read"
    return ArrayTypeError("KS302", message, "manipulability and isotropy have one; or put numbers in place of the symbols")
