"""Numbers and symbols that callers give, exactly. Floor 7."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..model import RobotModel
from ..namespaces import Array, as_array
from .exact import fraction, free_symbols

_SEED = 20261127


def objects(entries: Iterable[Any]) -> Array:
    """A vector of objects, whatever they are."""
    values = list(entries)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def exact_value(x: Any) -> Any:
    """A number as a fraction; an expression as it is."""
    import sympy

    if isinstance(x, sympy.Basic):
        return x
    return fraction(x)


def exact_values(what: str, values: Any, size: int) -> tuple[Any, ...]:
    """(size) exact values; () where none are given.

    Raises:
        ConfigurationError: KS303.
    """
    if values is None:
        return ()
    try:
        array, xp = as_array(values, what)
    except (ArrayTypeError, ValueError):
        array, xp = np.zeros(0), None
    if xp is None or tuple(array.shape) != (size,) or (xp.name != "sympy" and not np.all(np.isfinite(np.asarray(array)))):
        raise ConfigurationError(
            "KS303", f"{what} {values!r} is not {size} finite numbers or symbols", "a list, one after another"
        )
    return tuple(exact_value(x) for x in array)


def fresh(names: Sequence[str], taken: set[str]) -> tuple[Any, ...]:
    """Real symbols of these names, with underscores behind those that are taken."""
    import sympy

    tail = ""
    while taken & {name + tail for name in names}:
        tail += "_"
    taken |= {name + tail for name in names}
    return tuple(sympy.Symbol(name + tail, real=True) for name in names)


def center_of(model: RobotModel, link: int) -> tuple[Any, ...]:
    """(3) exact centre of mass of a link, in its axes."""
    return tuple(exact_value(x) for x in model.centers_of_mass[link])


def in_numbers(model: RobotModel, values: Mapping[Any, float] | None = None) -> RobotModel:
    """The model with numbers for its symbols; without values, pseudo-random ones."""
    symbols = sorted(free_symbols(model), key=str)
    if values is None:
        drawn = np.random.default_rng(_SEED).uniform(0.3, 1.7, len(symbols))
        values = dict(zip(symbols, drawn.tolist(), strict=True))

    def number(x: Any) -> float:
        return float(x.xreplace(values)) if getattr(x, "free_symbols", None) else float(x)

    def numbers(array: Array) -> Array:
        if array.dtype != object:
            return array
        return np.array([number(x) for x in array.flat], dtype=np.float64).reshape(array.shape)

    return replace(model.map(numbers))
