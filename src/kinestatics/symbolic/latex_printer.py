"""`Printer`: SymPy expressions as LaTeX, c_{23} for cos(q2 + q3). Floor 7."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from ..quantities import format_number
from .latex_names import JOINT, decimal, fraction_text, short_decimal, symbol

_TEN = 10
_SUM, _TERM, _POWER = range(3)


class Printer:
    """SymPy expressions as LaTeX.

    Attributes:
        used: short names → the angles they stand for, filled while printing.
    """

    def __init__(self, expressions: Iterable[Any], short: bool, joints: Sequence[Any] = ()) -> None:
        found = set().union(*(x.free_symbols for x in expressions))
        self.joints = {x for x in found if x in joints or JOINT.fullmatch(str(x))}
        self.avoided = {symbol(str(x)) for x in found - self.joints}
        self.short = short
        self.used: dict[str, Any] = {}

    def __call__(self, x: Any, within: int = _SUM) -> str:
        """The text, in brackets where what stands around it binds tighter."""
        text, binds = self._written(x)
        return text if binds >= within else rf"\left({text}\right)"

    def _written(self, x: Any) -> tuple[str, int]:
        import sympy

        if x.is_Symbol:
            return symbol(str(x)), _POWER
        if x.is_Number:
            return self._number(x)
        if x.is_Add:
            return self._sum(x), _SUM
        if x.is_Mul:
            return self._product(x), _TERM
        if x.is_Pow:
            return self._power(x.base, x.exp)
        if isinstance(x, sympy.sin | sympy.cos):
            return self._wave(x), _POWER
        if x.is_Function and len(x.args) == 1:
            return self._function(x), _POWER
        return str(sympy.latex(x)), _POWER if x.is_Atom else _SUM

    def _number(self, x: Any) -> tuple[str, int]:
        import sympy

        binds = _SUM if x.is_negative else _POWER
        if not x.is_Rational:
            plain = x.is_Float and x.is_finite
            return (decimal(format_number(x)) if plain else str(sympy.latex(x))), binds
        if x.q == 1:
            return str(x.p), binds
        return f"{'-' if x.p < 0 else ''}{fraction_text(abs(int(x.p)), int(x.q))}", binds

    def _sum(self, x: Any) -> str:
        text = ""
        for term in x.as_ordered_terms() if len(x.args) < 100 else x.args:
            part = self(term, _TERM) if not term.is_Number else self(term)
            text += part if not text else f" - {part[1:]}" if part.startswith("-") else f" + {part}"
        return text

    def _product(self, x: Any) -> str:
        import sympy

        number, rest = x.as_coeff_Mul()
        above, below = [], []
        for factor in rest.as_ordered_factors() if rest.is_Mul else [rest]:
            if factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                below.append(1 / factor)
            elif factor != 1:
                above.append(factor)
        sign = "-" if number.is_negative else ""
        size = abs(number)
        shown = [] if size == 1 else [self(size)]
        if size.is_Rational and size.q != 1 and short_decimal(size) is None:
            shown = [str(size.p)] if size.p != 1 else []
            below.insert(0, sympy.Integer(size.q))
        alone = not shown and len(above) == 1
        parts = [*shown, *(self(factor, _SUM if alone and below else _TERM + (factor.is_Add)) for factor in above)]
        text = " ".join(parts) or "1"
        if below:
            bottom = " ".join(self(factor, _SUM if len(below) == 1 else _TERM + factor.is_Add) for factor in below)
            text = rf"\frac{{{text}}}{{{bottom}}}"
        return sign + text

    def _power(self, base: Any, exponent: Any) -> tuple[str, int]:
        import sympy

        if exponent.is_number and exponent.is_negative:
            return rf"\frac{{1}}{{{self(base**-exponent)}}}", _POWER
        if 2 * exponent == 1:
            return rf"\sqrt{{{self(base)}}}", _POWER
        if isinstance(base, sympy.sin | sympy.cos):
            return self._wave(base, self(exponent)), _POWER
        simple = base.is_Symbol or (base.is_Integer and base.is_nonnegative)
        inside = self(base) if simple else rf"\left({self(base)}\right)"
        return f"{inside}^{{{self(exponent)}}}", _POWER

    def _wave(self, x: Any, power: str = "") -> str:
        """A sine or cosine, short where its angle is a sum of joints."""
        import sympy

        raised = f"^{{{power}}}" if power else ""
        letter, full = ("s", r"\sin") if isinstance(x, sympy.sin) else ("c", r"\cos")
        index = self._index(x.args[0]) if self.short else ""
        name = f"{letter}_{{{index}}}"
        if index and name not in self.avoided:
            self.used[name] = x
            return name + raised
        return rf"{full}{raised}\left({self(x.args[0])}\right)"

    def _index(self, angle: Any) -> str:
        """23 for q2 + q3, 2-3 for q2 - q3; commas where a joint has two digits."""
        import sympy

        found = []
        for term in sympy.Add.make_args(angle):
            number, joint = term.as_coeff_Mul()
            if joint not in self.joints or number not in (1, -1):
                return ""
            digits = re.search(r"(\d+)_*$", str(joint))
            if digits is None:
                return ""
            found.append((int(digits[1]), int(number)))
        found.sort()
        comma = "," if any(k >= _TEN for k, _ in found) else ""
        text = ""
        for k, sign in found:
            text += ("-" if sign < 0 else comma if text else "") + str(k)
        return text

    def _function(self, x: Any) -> str:
        names = {"Abs": None, "exp": r"\exp", "log": r"\log", "tan": r"\tan", "asin": r"\arcsin", "acos": r"\arccos"}
        name = type(x).__name__
        inside = self(x.args[0])
        if name == "Abs":
            return rf"\left|{inside}\right|"
        return rf"{names.get(name) or symbol(name)}\left({inside}\right)"
