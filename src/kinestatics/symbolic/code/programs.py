"""What is to be written: entries as functions of arguments, with a header. Floor 7."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...errors import ArrayTypeError, ConfigurationError
from ...kinematics import Locator
from ...namespaces import Array
from ...quantities import Jacobian
from ..closed_form import ClosedForm


class Argument(NamedTuple):
    """An argument of the function: a vector of symbols, or one of its own.

    Attributes:
        name: wished for; symbols: its entries; vector: whether it is an array.
        text: what it is; default: a number, or None.
    """

    name: str
    symbols: tuple[Any, ...]
    vector: bool
    text: str
    default: float | None = None


@dataclass(frozen=True)
class Program:
    """What is to be written: entries in row-major order as functions of the arguments.

    Attributes:
        shape: of the result, () for one number.
        title, returns: lines for the header.
        form: the closed form it comes from, or None.
    """

    entries: tuple[Any, ...]
    shape: tuple[int, ...]
    arguments: tuple[Argument, ...]
    title: str
    returns: str
    form: ClosedForm | None = None


def program_of(x: Any, arguments: Mapping[str, Any] | None) -> Program:
    """What is to be written of a closed form, an expression, or an array or quantity of expressions.

    Raises:
        ConfigurationError: KS395, arguments that leave a symbol out. ArrayTypeError: KS302, nothing to write.
    """
    if isinstance(x, ClosedForm):
        return _program_of_form(x, arguments)
    array, title, returns, known = _array_of(x)
    entries = tuple(array.flat)
    found = set().union(*(entry.free_symbols for entry in entries))
    if arguments is None:
        arguments = {"q": known} if known and found & set(known) else {}
        rest = sorted(found - set(known), key=natural_order)
    else:
        rest = []
    given = [_argument(name, value) for name, value in arguments.items()]
    _require_all(found, [*(s for a in given for s in a.symbols), *rest])
    given += [Argument(str(symbol), (symbol,), False, "") for symbol in rest]
    return Program(entries, tuple(array.shape), tuple(given), title, returns)


def natural_order(symbol: Any) -> list[Any]:
    """A key to sort by: q2 before q10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", str(symbol))]


def _argument(name: Any, value: Any) -> Argument:
    import sympy

    several = isinstance(value, list | tuple | np.ndarray)
    symbols = tuple(value) if several else (value,)
    if not isinstance(name, str) or not all(isinstance(x, sympy.Symbol) for x in symbols):
        raise ConfigurationError(
            "KS395", f"argument {name!r} stands for {value!r}", "arguments={'q': [q1, q2], 'a': a}, of symbols"
        )
    return Argument(name, symbols, several, "")


def _require_all(found: set[Any], given: Sequence[Any]) -> None:
    if left := sorted(map(str, found - set(given))):
        raise ConfigurationError("KS395", f"no argument holds {', '.join(left)}", "arguments= must name every symbol")
    if len(set(given)) < len(given):
        twice = sorted({str(x) for x in given if list(given).count(x) > 1})
        raise ConfigurationError("KS395", f"two arguments hold {', '.join(twice)}", "name every symbol once")


def _array_of(x: Any) -> tuple[Array, str, str, tuple[Any, ...]]:
    """Expressions as an object array, two lines for the header, and the joints' symbols of a Jacobian."""
    import sympy

    title, returns, known = _told_by(x)
    if hasattr(x, "array") and not isinstance(x, np.ndarray):
        x = x.array
    if isinstance(x, sympy.MatrixBase):
        x = np.array(x.tolist(), dtype=object).reshape(x.shape)
    if isinstance(x, int | float):
        x = sympy.sympify(x)
    try:
        raw = np.array(x, dtype=object) if isinstance(x, sympy.Basic) else np.asarray(x)
        entries = [sympy.sympify(entry, strict=True) for entry in raw.flat]
    except (ValueError, TypeError, sympy.SympifyError):
        entries = [None]
        raw = np.zeros(0)
    if not all(isinstance(entry, sympy.Expr) for entry in entries):
        hint = "ks.closed_form(...), a SymPy expression or matrix, or ks.jacobian(arm, symbols)"
        raise ArrayTypeError("KS302", f"a {type(x).__name__} is no expression to generate code for", hint)
    array = np.empty(raw.shape, dtype=object)
    array.reshape(-1)[:] = entries
    return array, title, returns, known


def _told_by(x: Any) -> tuple[str, str, tuple[Any, ...]]:
    """What a quantity says of itself: two lines for the header, and the joints' symbols of a Jacobian."""
    import sympy

    if not (hasattr(x, "frame") and hasattr(x, "array")):
        return "an expression", "", ()
    if not isinstance(x, Jacobian):
        return f"{type(x).__name__}, {x.frame}", "", ()
    returns = f"rows {', '.join(x.rows)} [m/s, rad/s], columns {', '.join(x.joint_names)}"
    locate = x._locate
    q = np.asarray(locate.q) if isinstance(locate, Locator) else np.zeros(0)
    plain = q.ndim == 1 and all(isinstance(s, sympy.Symbol) for s in q) and len(set(q)) == len(q)
    return f"Jacobian of {x.link}, {x.frame}", returns, tuple(q) if plain else ()


_UNITS = {
    "rates": ("qd", "joint rates [rad/s or m/s]"),
    "accelerations": ("qdd", "joint accelerations [rad/s^2 or m/s^2]"),
    "wrench": ("wrench", "wrench on the environment, force [N], then moment [N m]"),
}
_RETURNS = {
    "pose": "homogeneous matrix, translation [m]",
    "jacobian": "[m/s and rad/s per unit joint rate]",
    "velocity": "[m/s, rad/s]",
    "acceleration": "[m/s^2, rad/s^2]",
    "gravity_torques": "[N m, or N where a joint slides]",
    "joint_torques": "[N m, or N where a joint slides]",
}


def _program_of_form(form: ClosedForm, arguments: Mapping[str, Any] | None) -> Program:
    expression, symbols = form.expression, form.symbols
    joints = symbols["joints"]
    if arguments is not None:
        given = [_argument(name, value) for name, value in arguments.items()]
    else:
        given = [Argument("q", joints, True, f"joints {', '.join(map(str, joints))} [rad or m]")]
        for kind, (name, text) in _UNITS.items():
            if kind in symbols:
                given.append(Argument(name, symbols[kind], True, text))
        for symbol in symbols.get("parameters", ()):
            value = form.values.get(symbol)
            given.append(Argument(str(symbol), (symbol,), False, "", None if value is None else float(value)))
    _require_all(expression.free_symbols, [x for a in given for x in a.symbols])
    matrix = hasattr(expression, "shape")
    entries = tuple(expression.flat()) if matrix else (expression,)
    shape = () if not matrix else expression.shape if form.column_names else (expression.rows,)
    words = form.quantity.replace("_", " ")
    title = f"{words} of {form.link} of {form.robot}" + (f", {form.where}" if form.where else "")
    parts = [_RETURNS.get(form.quantity, "")]
    if form.row_names:
        parts.append(f"rows {', '.join(form.row_names)}")
    if form.column_names:
        parts.append(f"columns {', '.join(form.column_names)}")
    return Program(entries, tuple(shape), tuple(given), title, "; ".join(filter(None, parts)), form)
