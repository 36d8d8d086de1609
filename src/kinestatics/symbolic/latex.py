"""`to_latex`: expressions, matrices and quantities as LaTeX mathematics. Floor 7."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ArrayTypeError
from ..namespaces import Array
from ..quantities import JacobianMatrix, Pose, SixVector, format_number, largest, numeric
from ..spatial import ANGULAR, LINEAR, ROW_NAMES, WRENCH_NAMES
from .closed_form import ClosedForm
from .exact import sympy_module
from .latex_names import decimal, symbol, words
from .latex_printer import Printer


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
        >>> import kinestatics as ks, sympy
        >>> q1, q2, a2 = sympy.symbols("q1 q2 a2")
        >>> print(ks.to_latex(a2 * sympy.cos(q1 + q2)))
        a_{2} c_{12}
        >>> print(ks.to_latex(a2 * sympy.cos(q1 + q2), short=False))
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


def _legend(printer: Printer, x: Any) -> list[str]:
    """What short names and symbols stand for."""
    plain = Printer(list(printer.used.values()), False)
    items = [f"{name} = {plain(wave)}" for name, wave in sorted(printer.used.items())]
    if isinstance(x, ClosedForm):
        items += [f"{symbol(str(s))} = {plain(v)}" for s, v in x.values.items()]
    return [r",\quad ".join(items[k : k + 4]) for k in range(0, len(items), 4)]


__all__ = ["to_latex"]
