"""`to_latex`: expressions, matrices and quantities as LaTeX mathematics, c_{23} for cos(q2 + q3). Floor 7."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array
from ..quantities import JacobianMatrix, Pose, SixVector, format_number, largest, numeric
from ..spatial import ANGULAR, LINEAR, ROW_NAMES, WRENCH_NAMES
from .closed_form import ClosedForm
from .exact import sympy_module

_LETTERS = (
    "alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
GREEK = frozenset(_LETTERS.split())
_JOINT = re.compile(r"(q|theta|joint)(\d+)_*")
_RATE = re.compile(r"(q|theta|joint)(dd?)(\d+)_*")
_SIX = re.compile(r"([vwfm])([xyz])_*")
_PIECES = re.compile(r"([A-Za-z]+?)(?:_?(\d+)|_([A-Za-z0-9]+))?(_*)")
_SPECIAL = {"\\": r"\backslash ", "^": r"\wedge ", "~": r"\sim "}
_ESCAPED = set("{}$&#%_")
_TEN = 10


def to_latex(x: Any, *, short: bool = True, legend: bool = False, steps: bool = False) -> str:
    """An expression, a matrix or a quantity as LaTeX, to be put between dollar signs or in an equation.

    Args:
        x: ClosedForm, SymPy expression or matrix, array of expressions or numbers, number, or a quantity such as a Jacobian,
            a Pose or a Wrench; rows and columns of a Jacobian, and rows of a six-vector, are labelled.
        short: c_{23} for cos(q2 + q3), s_{1} for sin(q1), where x has no symbol that looks like it.
        legend: what the short ones stand for, and the numbers of a ClosedForm's lengths, in further lines.
        steps: of a ClosedForm, its derivation from the transforms of the links on: text with displayed equations. See
            `kinestatics.symbolic.derivation`.

    Returns:
        LaTeX of mathematics mode (amsmath for matrices and legends); with steps=True, of text mode.

    Raises:
        ArrayTypeError: KS302, no mathematics; KS394, steps of what is no ClosedForm. MissingExtraError: KS400.

    Example:
        >>> import sympy
        >>> q1, q2, a2 = sympy.symbols("q1 q2 a2")
        >>> print(to_latex(a2 * sympy.cos(q1 + q2)))
        a_{2} c_{12}
        >>> print(to_latex(a2 * sympy.cos(q1 + q2), short=False))
        a_{2} \\cos\\left(q_{1} + q_{2}\\right)
    """
    sympy_module()
    if steps:
        if not isinstance(x, ClosedForm):
            hint = "to_latex(ks.closed_form('jacobian', arm), steps=True)"
            raise ArrayTypeError("KS394", f"a {type(x).__name__} has no derivation", hint)
        from .derivation import derivation_of

        return derivation_of(x, short=short)
    entries = _expressions(x)
    printer = Printer(entries, short, _joints_of(x))
    text = _written(x, printer)
    lines = _legend(printer, x) if legend else []
    if not lines:
        return text
    return "\\begin{gathered}\n" + " \\\\\n".join([text, *lines]) + "\n\\end{gathered}"


def _joints_of(x: Any) -> Sequence[Any]:
    return x.symbols["joints"] if isinstance(x, ClosedForm) else ()


def _expressions(x: Any) -> list[Any]:
    """The SymPy expressions in x."""
    import sympy

    if isinstance(x, ClosedForm):
        return _expressions(x.expression)
    if isinstance(x, sympy.MatrixBase):
        return list(x.flat())
    if isinstance(x, sympy.Expr):
        return [x]
    array = np.asarray(numeric(getattr(x, "array", x)))
    return [entry for entry in array.flat if isinstance(entry, sympy.Expr)] if array.dtype == object else []


def _written(x: Any, printer: Printer) -> str:
    import sympy

    if isinstance(x, ClosedForm):
        return _written(x.expression, printer)
    if isinstance(x, sympy.MatrixBase):
        return matrix([[printer(entry) for entry in row] for row in x.tolist()])
    if isinstance(x, sympy.Expr):
        return printer(x)
    if isinstance(x, JacobianMatrix | SixVector | Pose) and np.ndim(numeric(x.array)) > (
        1 if isinstance(x, SixVector) else 2
    ):
        raise ArrayTypeError(
            "KS302", f"LaTeX of a batch of {type(x).__name__}s", "write one of them: x = ks.jacobian(arm, q[0])"
        )
    if isinstance(x, JacobianMatrix):
        return labelled(_cells(numeric(x.array), printer), ROW_NAMES, x.joint_names)
    if isinstance(x, SixVector):
        names = WRENCH_NAMES if type(x).__name__ == "Wrench" else ROW_NAMES
        return labelled(_cells(numeric(x.array)[:, None], printer), names, ())
    array = np.asarray(numeric(getattr(x, "array", x)))
    if array.dtype.kind not in "biufO" or array.ndim > 2 or any(not _is_mathematics(entry) for entry in array.flat):
        hint = "a ClosedForm, SymPy expression, number, quantity, or an array of one or two axes"
        raise ArrayTypeError("KS302", f"no LaTeX for a {type(x).__name__}", hint)
    if array.ndim == 0:
        return _cells(array.reshape(1, 1), printer)[0][0]
    return matrix(_cells(array if array.ndim == 2 else array[:, None], printer))


def _is_mathematics(entry: Any) -> bool:
    import sympy

    return isinstance(entry, sympy.Expr | int | float | np.number | np.bool_)


def _cells(array: Array, printer: Printer) -> list[list[str]]:
    """Entries as text; numbers to four decimals, rounding beside larger ones of their half as 0."""
    import sympy

    sizes = np.full(len(array), largest(array))
    if len(array) == len(ROW_NAMES):
        for half in (LINEAR, ANGULAR):
            sizes[half] = largest(array[half])
    return [
        [printer(x) if isinstance(x, sympy.Expr) else decimal(format_number(x, size)) for x in row]
        for row, size in zip(array, sizes, strict=True)
    ]


def decimal(text: str) -> str:
    """A number as people write it: 1.2e-05 with a power of ten."""
    if "nan" in text or "inf" in text:
        return text.replace("nan", r"\mathrm{NaN}").replace("inf", r"\infty")
    number, _, power = text.partition("e")
    return rf"{number} \cdot 10^{{{int(power)}}}" if power else number


def matrix(cells: Sequence[Sequence[str]]) -> str:
    """A matrix in brackets."""
    body = " \\\\\n".join(" & ".join(row) for row in cells)
    return f"\\begin{{bmatrix}}\n{body}\n\\end{{bmatrix}}"


def labelled(cells: Sequence[Sequence[str]], rows: Sequence[str], columns: Sequence[str]) -> str:
    """A matrix with names of its rows, and of its columns where there are some."""
    lines = [" & ".join([symbol(name), *row]) for name, row in zip(rows, cells, strict=True)]
    head = [" & ".join(["", *(words(name) for name in columns)]) + r" \\ \hline"] if columns else []
    body = "\n".join([*head, " \\\\\n".join(lines)])
    return f"\\begin{{array}}{{r|{'r' * max(len(cells[0]), 1)}}}\n{body}\n\\end{{array}}"


def words(text: str) -> str:
    """Any text, upright, with its marks made harmless."""
    safe = "".join(f"\\{c}" if c in _ESCAPED else " " if c in "\\^~\n\r" else c for c in text)
    return rf"\text{{{safe}}}"


@lru_cache(maxsize=4096)
def symbol(name: str) -> str:
    """The name of a symbol: a_{2} for a2, \\theta_{1} for theta1, \\dot{q}_{1} for qd1, v_{x} for vx."""
    if found := _RATE.fullmatch(name):
        dots = {"d": r"\dot", "dd": r"\ddot"}[found[2]]
        return f"{dots}{{{_letter(found[1])}}}_{{{found[3]}}}{_primes(name)}"
    if name.startswith("d") and _SIX.fullmatch(name.removeprefix("d")):
        kind, axis = name[1], name[2]
        return rf"\dot{{{_SIX_LETTERS[kind]}}}_{{{axis}}}{_primes(name)}"
    if found := _SIX.fullmatch(name):
        return f"{_SIX_LETTERS[found[1]]}_{{{found[2]}}}{_primes(name)}"
    if found := _PIECES.fullmatch(name):
        below = found[2] or found[3]
        shown = below if not below or below.isdigit() or len(below) == 1 else rf"\mathrm{{{below}}}"
        index = f"_{{{shown}}}" if below else ""
        return f"{_letter(found[1])}{index}{_primes(name)}"
    return _harmless(name)


_SIX_LETTERS = {"v": "v", "w": r"\omega", "f": "f", "m": "m"}


def _letter(letters: str) -> str:
    if letters in GREEK:
        return f"\\{letters}"
    return letters if len(letters) == 1 else rf"\mathrm{{{letters}}}"


def _primes(name: str) -> str:
    return "'" * (len(name) - len(name.rstrip("_")))


def _harmless(name: str) -> str:
    safe = "".join(f"\\{c}" if c in _ESCAPED else _SPECIAL.get(c, c) for c in name if c.isprintable())
    return rf"\mathrm{{{safe or '?'}}}"


_SUM, _TERM, _POWER = range(3)


class Printer:
    """SymPy expressions as LaTeX.

    Attributes:
        used: short names → the angles they stand for, filled while printing.
    """

    def __init__(self, expressions: Iterable[Any], short: bool, joints: Sequence[Any] = ()) -> None:
        found = set().union(*(x.free_symbols for x in expressions))
        self.joints = {x for x in found if x in joints or _JOINT.fullmatch(str(x))}
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
        binds = _SUM if x.is_negative else _POWER
        if not x.is_Rational:
            plain = x.is_Float and x.is_finite
            return (decimal(format_number(x)) if plain else str(_sympy_latex(x))), binds
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
        if size.is_Rational and size.q != 1 and _is_plain(size) is None:
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


def _sympy_latex(x: Any) -> str:
    import sympy

    return str(sympy.latex(x))


def _is_plain(x: Any) -> str | None:
    """A fraction that is a short decimal, as one; thirds and eighths stay fractions."""
    rest = int(x.q)
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest != 1 or x.q <= 8:
        return None
    return f"{float(x):.12g}" if "e" not in f"{float(x):.12g}" else decimal(f"{float(x):.12g}")


def fraction_text(p: int, q: int) -> str:
    """A positive fraction: 0.425 for 17/40, \\frac{1}{3}."""
    import sympy

    plain = _is_plain(sympy.Rational(p, q))
    return plain if plain is not None else rf"\frac{{{p}}}{{{q}}}"


def _legend(printer: Printer, x: Any) -> list[str]:
    """What short names and symbols stand for."""
    plain = Printer(list(printer.used.values()), False)
    items = [f"{name} = {plain(wave)}" for name, wave in sorted(printer.used.items())]
    if isinstance(x, ClosedForm):
        items += [f"{symbol(str(s))} = {plain(v)}" for s, v in x.values.items()]
    return [r",\quad ".join(items[k : k + 4]) for k in range(0, len(items), 4)]


__all__ = ["to_latex"]
