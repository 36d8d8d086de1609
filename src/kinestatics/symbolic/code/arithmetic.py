"""Expressions in numbers, without SymPy's arithmetic. Floor 7."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ...errors import ArrayTypeError
from .languages import FUNCTIONS

_NUMERIC: dict[str, Callable[..., float]] = {name: getattr(math, name) for name in FUNCTIONS if hasattr(math, name)}
_NUMERIC |= {"Abs": math.fabs, "sign": lambda x: math.copysign(1.0, x) if x else 0.0}


def evaluated(x: Any, values: Mapping[Any, float], known: dict[Any, float] | None = None) -> float:
    """An expression in numbers, without SymPy's arithmetic.

    Raises:
        ArrayTypeError: KS395, where it holds something that is not known.
    """
    known = {} if known is None else known
    if x in known:
        return known[x]
    if x in values:
        found = values[x]
    elif x.is_Rational:
        found = int(x.p) / int(x.q)
    elif x.is_number and not x.args:
        found = float(x)
    elif x.is_Add:
        found = math.fsum(evaluated(a, values, known) for a in x.args)
    elif x.is_Mul:
        found = math.prod(evaluated(a, values, known) for a in x.args)
    elif x.is_Pow:
        found = evaluated(x.base, values, known) ** evaluated(x.exp, values, known)
    elif type(x).__name__ in _NUMERIC:
        found = _NUMERIC[type(x).__name__](*(evaluated(a, values, known) for a in x.args))
    else:
        raise no_code(x)
    known[x] = found
    return found


def no_code(x: Any) -> ArrayTypeError:
    """KS395."""
    kind = type(x).__name__
    hint = f"sums, products, powers and {', '.join(FUNCTIONS)}; put symbols in place of anything else"
    return ArrayTypeError("KS395", f"no code for {str(x)[:80]!r} ({kind})", hint)
