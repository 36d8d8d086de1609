"""Expressions as text of a language. Floor 7."""

from __future__ import annotations

import re
from typing import Any

from .arithmetic import evaluated, no_code
from .identifiers import Names
from .languages import Language

_PRODUCTS = 3
"""Up to this power, a name is multiplied with itself in C and C++."""
_SUM, _TERM, _FACTOR, _POWER = range(4)


class Text:
    """Expressions in a language."""

    def __init__(self, names: Names, language: Language, index: str) -> None:
        self.names, self.language, self.index = names, language, index

    def name(self, symbol: Any) -> str:
        """The identifier of a symbol, or the entry of the array that holds it."""
        word = self.names.known[symbol]
        found = re.fullmatch(r"(\w+)\{(\d+)\}", word)
        return word if found is None else self.index.format(found[1], int(found[2]), int(found[2]) + 1)

    def __call__(self, x: Any, within: int = _SUM) -> str:
        """The text, in brackets where what stands around it binds tighter."""
        text, binds = self._written(x)
        return text if binds >= within else f"({text})"

    def _written(self, x: Any) -> tuple[str, int]:
        if x in self.names.known:
            return self.name(x), _POWER
        if not x.free_symbols:
            return _number(x)
        if x.is_Add:
            return self._sum(x), _SUM
        if x.is_Mul:
            return self._product(x), _TERM
        if x.is_Pow:
            return self._power(x.base, x.exp)
        function = self.language.functions.get(type(x).__name__)
        if not function:
            raise no_code(x)
        return f"{function}({', '.join(map(self, x.args))})", _POWER

    def _sum(self, x: Any) -> str:
        text = ""
        for term in x.as_ordered_terms() if len(x.args) < 200 else x.args:
            part = self(term, _TERM)
            text += part if not text else f" - {part[1:]}" if part.startswith("-") else f" + {part}"
        return text

    def _product(self, x: Any) -> str:
        number, rest = x.as_coeff_Mul()
        above: list[str] = []
        below: list[str] = []
        for factor in _factors_of(rest):
            inverted = factor.is_Pow and factor.exp.is_number and factor.exp.is_negative
            (below if inverted else above).append(self(1 / factor if inverted else factor, _FACTOR))
        value = evaluated(number, {})
        sign, size = ("-" if value < 0 else ""), abs(value)
        if size != 1 or not above:
            above.insert(0, repr(size))
        text = sign + "*".join(above)
        if below:
            text += f"/{below[0]}" if len(below) == 1 and "*" not in below[0] else f"/({'*'.join(below)})"
        return text

    def _power(self, base: Any, exponent: Any) -> tuple[str, int]:
        language = self.language
        if exponent.is_number and exponent.is_negative:
            below, _ = self._power(base, -exponent)
            simple = re.fullmatch(r"[\w.\[\]()]+", below) is not None
            return f"1.0/{below}" if simple else f"1.0/({below})", _TERM
        if exponent == 1:
            return self(base, _FACTOR), _FACTOR
        if 2 * exponent == 1:
            return f"{language.functions['sqrt']}({self(base)})", _POWER
        if language.squares and exponent.is_Integer and exponent <= _PRODUCTS and base in self.names.known:
            return "*".join([self(base)] * int(exponent)), _TERM
        written = str(int(exponent)) if exponent.is_Integer else self(exponent, _POWER)
        inside = _SUM if language.power.startswith(("pow", "std")) else _POWER
        return language.power.format(self(base, inside), written), _POWER if inside == _SUM else _FACTOR


def _factors_of(x: Any) -> tuple[Any, ...]:
    """The factors of a product in SymPy's printing order."""
    return tuple(x.as_ordered_factors()) if x.is_Mul else (x,)


def _number(x: Any) -> tuple[str, int]:
    value = evaluated(x, {})
    text = repr(float(value))
    return text, _POWER if value >= 0 else _SUM
