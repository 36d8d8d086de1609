"""Jacobians, poses, six-vectors and closed forms, with rows, frames and units named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from ..quantities import Jacobian, Pose, SixVector, Wrench, format_number, largest, numeric
from ..report.blocks import Column, Html, Part, bullets, escaped, number, table, tag, with_minus
from ..spatial import ANGULAR, LINEAR, ROW_NAMES, WRENCH_NAMES
from ..symbolic.closed_form import ClosedForm
from ..symbolic.writer import rounded_text
from .frame import LONGEST_FORMULA, formula, head

_SHORT_NAME, _MANY = 12, 9  # characters of a joint's name, and columns, that stand above a matrix
_MOST_COLUMNS = 40
JACOBIAN_UNITS = "linear rows [m/s], angular rows [rad/s], per unit joint rate"
_MOST_OPERATIONS = 260  # of a closed form that is read on a page


def jacobian_body(J: Jacobian) -> Html | None:
    """A Jacobian; None for a batch, and for what is too wide or too long to be read."""
    if J.array.ndim > 2 or len(J.joint_names) > _MOST_COLUMNS:
        return None
    shown = jacobian_table(J)
    return escaped([head(f"Jacobian of {J.link}", str(J.frame), JACOBIAN_UNITS), shown]) if shown else None


def jacobian_table(J: Jacobian) -> Html | None:
    """The entries of a Jacobian, numbers or mathematics."""
    array, names = numeric(J.array), J.joint_names
    if array.dtype == object:
        cells = _expressions(array.tolist())
    else:
        halves = [(array[half], largest(array[half])) for half in (LINEAR, ANGULAR)]
        cells = [[_entry(x, size) for x in row] for rows, size in halves for row in rows]
    if cells is None:
        return None
    short = len(names) <= _MANY and all(len(name) <= _SHORT_NAME for name in names)
    heads = names if short else [str(k + 1) for k in range(len(names))]
    numbered = None if short else bullets((f"{k + 1} {name}" for k, name in enumerate(names)), kind="facts")
    return escaped([_matrix("Jacobian", ROW_NAMES, heads, cells, "halves"), numbered])


def _matrix(caption: str, rows: Sequence[str], columns: Sequence[str], cells: Sequence[Sequence[Part]], kind: str) -> Html:
    """A matrix with its rows and columns named; the line above says what it is of."""
    named = [[_row(name), *row] for name, row in zip(rows, cells, strict=True)]
    return table(caption, [Column("", numeric=False), *map(Column, columns)], named, kind=f"matrix {kind}")


def _row(name: str) -> Html:
    """A row's name as mathematics writes it: a letter with an index."""
    return tag("var", name[:1].replace("w", "ω"), tag("sub", name[1:]) if name[1:] else None)


def _entry(x: float, beside: float) -> Html:
    """A number of a matrix; zeros stand back."""
    text = format_number(x, beside)
    return tag("span", with_minus(text), class_="zero" if text == "0" else "number")


def _expressions(rows: Sequence[Sequence[Any]]) -> list[list[Html]] | None:
    """Expressions as mathematics; None where they are too long to be read."""
    from ..symbolic.latex import to_latex

    written = [[(to_latex(x), x) for x in row] for row in rows]
    if sum(len(latex) for row in written for latex, _ in row) > LONGEST_FORMULA:
        return None
    return [[_expression(latex, x) for latex, x in row] for row in written]


def _expression(latex: str, x: Any) -> Html:
    return tag("span", "0", class_="zero") if latex == "0" else formula(latex, partial(str, x))


def pose_body(T: Pose) -> Html | None:
    """A pose: the axes of the link and its origin, as columns."""
    array = numeric(T.array)
    if array.ndim > 2 or array.dtype == object:
        return None
    rows = [[tag("var", axis), *(_entry(x, 1.0) for x in row)] for axis, row in zip("xyz", array[:-1], strict=True)]
    columns = [Column("", numeric=False), *(Column(f"{axis} axis") for axis in "xyz"), Column("origin", "m")]
    shown = table(f"Axes and origin of {T.link}", columns, rows, kind="matrix last")
    return escaped([head(f"Pose of {T.link}", f"seen from {T.seen_from}"), shown])


def six_vector_body(six: SixVector) -> Html | None:
    """A twist, an acceleration or a wrench, as a row."""
    array = numeric(six.array)
    if array.ndim > 1 or array.dtype == object:
        return None
    acts = f"acts on the {six.acts_on}" if isinstance(six, Wrench) else ""
    names: Sequence[str] = WRENCH_NAMES if isinstance(six, Wrench) else ROW_NAMES
    units = [unit for unit in six._units for _ in range(3)]
    cells = [number(float(x), unit, largest(array)) for x, unit in zip(array, units, strict=True)]
    kind = type(six).__name__
    columns = [Column("", numeric=False), *(Column(_row(name)) for name in names)]
    shown = table(kind, columns, [[kind.lower(), *cells]], kind="matrix")
    return escaped([head(kind, acts, str(six.frame)), shown])


def closed_form_body(form: ClosedForm) -> Html | None:
    """A closed form as mathematics; None where it is too long to be read as such."""
    if form.operations > _MOST_OPERATIONS:
        return None
    shown = _closed(form)
    words = form.quantity.replace("_", " ")
    title = head(f"{words[:1].upper()}{words[1:]} of {form.link}", f"of {form.robot}", form.where)
    return escaped([title, shown, legend(form.values)]) if shown else None


def _closed(form: ClosedForm) -> Html | None:
    """A matrix as a table, one expression in a line of its own."""
    from ..symbolic.latex import to_latex

    if not hasattr(form.expression, "shape"):
        return formula(to_latex(form), lambda: rounded_text(form.expression), True)
    cells = _expressions(form.expression.tolist())
    if cells is None or len(cells[0]) > _MOST_COLUMNS:
        return None
    rows, columns = form.row_names or ("",) * len(cells), form.column_names or ("",) * len(cells[0])
    heads = columns if all(len(name) <= _SHORT_NAME for name in columns) else [str(k + 1) for k in range(len(columns))]
    return _matrix(form.quantity.replace("_", " "), rows, heads, cells, "named" if form.row_names else "bare")


def legend(lengths: Mapping[Any, Any]) -> Html:
    """What the letters of a formula stand for."""
    from ..symbolic.latex_names import symbol

    items = [(rf"{x}_{{12}} = \{name}(q_1 + q_2)", f"{x}12 = {name}(q1 + q2)") for x, name in (("s", "sin"), ("c", "cos"))]
    for letter, value in lengths.items():
        metres = format_number(float(value))
        items.append((rf"{symbol(str(letter))} = {metres}\,\mathrm{{m}}", f"{letter} = {metres} m"))
    return bullets((formula(latex, partial(str, text)) for latex, text in items), kind="facts")
