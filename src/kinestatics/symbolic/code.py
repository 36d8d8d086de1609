"""`generate_code`: closed forms as functions in NumPy, JAX, C, C++, MATLAB and Octave. Floor 7.

Sines and cosines of every sum of angles are computed once, and so is whatever else occurs twice. Names come from the
model's symbols and are made identifiers of the language; text from models enters comments only, stripped of all marks.
"""

from __future__ import annotations

import itertools
import keyword
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .. import definition
from ..errors import ArrayTypeError, ConfigurationError, KinestaticsError, UnknownNameError, nearest
from ..kinematics import Locator, acceleration, jacobian, pose
from ..namespaces import Array, as_array
from ..quantities import Jacobian
from .closed_form import ClosedForm, in_numbers
from .exact import free_symbols, sympy_module

_CLOSE = 1e-12
_SEED = 20261128
_DRAWS = 2
_LONGEST = 48  # characters of an identifier; MATLAB knows 63
_PRODUCTS = 3
"""Up to this power, a name is multiplied with itself in C and C++."""

_FUNCTIONS = (
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "log",
    "Abs",
    "sqrt",
    "sign",
)
_MATLAB_WORDS = (
    "break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endfor endfunction endif "
    "endparfor endswitch endwhile enumeration events for function global if methods otherwise parfor persistent "
    "properties return spmd switch try until unwind_protect unwind_protect_cleanup while pi i j I J e E eps Inf NaN "
    "NA inf nan zeros ans beta gamma result ones size abs"
)
_C_WORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "bool true false asm typeof constexpr nullptr alignas alignof static_assert thread_local I E complex imaginary "
    "errno NULL INFINITY NAN HUGE_VAL j0 j1 jn y0 y1 yn fabs pow main result linux unix"
)
_CPP_WORDS = (
    "catch class const_cast decltype delete dynamic_cast explicit export false friend mutable namespace new noexcept "
    "operator private protected public reinterpret_cast static_cast template this throw true try typeid typename "
    "using virtual wchar_t and or not xor bitand bitor compl and_eq or_eq xor_eq not_eq std array char8_t char16_t "
    "char32_t concept requires co_await co_return co_yield consteval constinit beta"
)


@dataclass(frozen=True)
class Language:
    """How a language writes things.

    Attributes:
        name: for people; reserved: words that name nothing else.
        functions: SymPy's name → the language's; power: of a base and an exponent, both text.
        squares: whether a small power of a name is written as a product.
        assign: how a number is given a name.
    """

    name: str
    reserved: frozenset[str]
    functions: Mapping[str, str]
    power: str
    squares: bool
    assign: str


def _named(prefix: str, **others: str) -> dict[str, str]:
    return {name: others.get(name, prefix + name) for name in _FUNCTIONS}


_INVERSE = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}
_LANGUAGES = {
    word: Language(
        title,
        frozenset([*keyword.kwlist, "np", "jnp", "result", "shape", "print", "self"]),
        _named(f"{prefix}.", Abs=f"{prefix}.abs", **{k: f"{prefix}.{v}" for k, v in _INVERSE.items()}),
        "{}**{}",
        False,
        "{} = {}",
    )
    for word, title, prefix in (("numpy", "NumPy", "np"), ("jax", "JAX", "jnp"))
} | {
    "c": Language(
        "C",
        frozenset([*_C_WORDS.split(), *_FUNCTIONS]),
        _named("", Abs="fabs", sign=""),
        "pow({}, {})",
        True,
        "const double {} = {};",
    ),
    "cpp": Language(
        "C++",
        frozenset([*_C_WORDS.split(), *_CPP_WORDS.split(), *_FUNCTIONS]),
        _named("std::", Abs="std::abs", sign=""),
        "std::pow({}, {})",
        True,
        "const double {} = {};",
    ),
}
for _word, _title in (("matlab", "MATLAB"), ("octave", "Octave")):
    _reserved = frozenset([*_MATLAB_WORDS.split(), *_FUNCTIONS])
    _LANGUAGES[_word] = Language(_title, _reserved, _named("", Abs="abs"), "{}^{}", False, "{} = {};")
LANGUAGES = tuple(_LANGUAGES)


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


@dataclass(frozen=True)
class Steps:
    """Assignments, and the results in terms of what they name."""

    assignments: tuple[tuple[Any, Any], ...]
    results: tuple[Any, ...]


def generate_code(
    x: Any,
    language: str = "numpy",
    name: str | None = None,
    check: bool = True,
    *,
    arguments: Mapping[str, Any] | None = None,
) -> str:
    """An expression as a function in another language.

    Args:
        x: ClosedForm, SymPy expression or matrix, array of expressions, or a quantity at symbols such as a Jacobian.
        language: "numpy", "jax", "c", "cpp", "matlab" or "octave".
        name: of the function; default the quantity's, else "evaluate".
        check: whether the steps are compared, at random numbers, with the expression and, for a ClosedForm, with the numeric
            definition.
        arguments: argument → symbol, or list of symbols that come as one array, in order. Default: for closed forms q, qd,
            qdd, wrench and then every parameter; for other expressions every symbol, by name.

    Returns:
        The source. In NumPy and JAX a function of arrays with batch axes first that returns (..., rows, columns); in C a
        function that fills an array row by row; in C++ one that returns it as std::array; in MATLAB and Octave a matrix. Its
        header says shapes, units, rows, frame, and which names were changed because the language takes them.

    Raises:
        UnknownNameError: KS395, no such language. ConfigurationError: KS395, a name that is no identifier, arguments that
            leave a symbol out. ArrayTypeError: KS395, no code for a function; KS302, nothing to write.
        KinestaticsError: KS396, the check failed. MissingExtraError: KS400.

    Law: the function at numbers is the expression at these numbers, to rounding.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics.symbolic.closed_form import closed_form
        >>> form = closed_form("determinant", ks.load("planar_2r"), lengths="symbols")
        >>> print(generate_code(form, "c").partition("#include")[2])
         <math.h>
        <BLANKLINE>
        double determinant(const double *q, double a1)
        {
            const double s2 = sin(q[1]);
            return s2*(a1*a1);
        }
        <BLANKLINE>
    """
    sympy_module()
    if not isinstance(language, str) or language.lower() not in _LANGUAGES:
        raise UnknownNameError(
            "KS395", f"no code in {language!r}", nearest(str(language), LANGUAGES) or ", ".join(LANGUAGES)
        )
    spoken = _LANGUAGES[language.lower()]
    function = _function_name(name if name is not None else _wished_name(x), spoken)
    program = _program(x, arguments)
    names = Names(spoken, function)
    steps = _steps(program, names)
    if check:
        _check(program, steps)
    return _WRITERS[language.lower()](program, steps, names, spoken)


def _wished_name(x: Any) -> str:
    if isinstance(x, ClosedForm):
        return x.quantity
    return "jacobian" if isinstance(x, Jacobian) else "evaluate"


def _function_name(name: Any, language: Language) -> str:
    if isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and len(name) <= _LONGEST:
        if name not in language.reserved and "__" not in name:
            return name
        message = f"{name!r} is a word of {language.name}"
    else:
        message = f"{name!r} is no name for a function"
    raise ConfigurationError("KS395", message, "letters, digits and underscores, a letter first: name='arm_jacobian'")


# What is to be written


def _program(x: Any, arguments: Mapping[str, Any] | None) -> Program:
    if isinstance(x, ClosedForm):
        return _program_of_form(x, arguments)
    array, title, returns, known = _array_of(x)
    entries = tuple(array.flat)
    found = set().union(*(entry.free_symbols for entry in entries))
    if arguments is None:
        arguments = {"q": known} if known and found & set(known) else {}
        rest = sorted(found - set(known), key=_natural)
    else:
        rest = []
    given = [_argument(name, value) for name, value in arguments.items()]
    _require_all(found, [*(s for a in given for s in a.symbols), *rest])
    given += [Argument(str(symbol), (symbol,), False, "") for symbol in rest]
    return Program(entries, tuple(array.shape), tuple(given), title, returns)


def _natural(symbol: Any) -> list[Any]:
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

    title, returns, known = "an expression", "", ()
    if hasattr(x, "frame") and hasattr(x, "array"):
        title = f"{type(x).__name__}, {x.frame}"
        if isinstance(x, Jacobian):
            title = f"Jacobian of {x.link}, {x.frame}"
            returns = f"rows {', '.join(x.rows)} [m/s, rad/s], columns {', '.join(x.joint_names)}"
            locate = x._locate
            q = np.asarray(locate.q) if isinstance(locate, Locator) else np.zeros(0)
            if q.ndim == 1 and all(isinstance(s, sympy.Symbol) for s in q) and len(set(q)) == len(q):
                known = tuple(q)
        x = x.array
    elif hasattr(x, "array") and not isinstance(x, np.ndarray):
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


# Names


class Names:
    """Identifiers of a language for symbols, each once."""

    def __init__(self, language: Language, function: str) -> None:
        self.language, self.function = language, function
        self.taken = {function}
        self.known: dict[Any, str] = {}
        self.changed: list[tuple[str, str]] = []

    def new(self, wished: str) -> str:
        """An identifier like the one wished for that is not taken."""
        plain = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", wished))[:_LONGEST]
        if not re.match(r"[A-Za-z]", plain):
            plain = f"x{plain}"
        found, tries = plain, 0
        while found in self.taken or found in self.language.reserved:
            tries += 1
            found = plain.rstrip("_") + ("_" if tries == 1 else f"_{tries}")
        self.taken.add(found)
        return found

    def of(self, symbol: Any, wished: str | None = None) -> str:
        """The identifier of a symbol."""
        if symbol not in self.known:
            name = str(symbol) if wished is None else wished
            self.known[symbol] = self.new(name)
            if wished is None and self.known[symbol] != name:
                self.changed.append((name, self.known[symbol]))
        return self.known[symbol]


# Steps: every sine and cosine once, then common subexpressions


@dataclass
class _Angles:
    """Sines and cosines, each with a name."""

    names: Names
    assignments: list[tuple[Any, Any]] = field(default_factory=list)
    known: dict[Any, Any] = field(default_factory=dict)

    def replaced(self, x: Any) -> Any:
        """The expression with names for its sines and cosines of what is not a number."""
        import sympy

        if x in self.known:
            return self.known[x]
        if not x.args or not x.free_symbols:
            found = x
        elif isinstance(x, sympy.sin | sympy.cos):
            found = sympy.Dummy()
            argument = self._angle(self.replaced(x.args[0]), x.args[0])
            self.names.of(found, f"{'s' if isinstance(x, sympy.sin) else 'c'}{_digits(x.args[0])}")
            self.assignments.append((found, x.func(argument, evaluate=False)))
        else:
            found = x.func(*[self.replaced(a) for a in x.args])
        self.known[x] = found
        return found

    def _angle(self, argument: Any, original: Any) -> Any:
        """A name for an angle that is a sum; it is often used twice."""
        import sympy

        if argument.is_Symbol:
            return argument
        if ("angle", argument) not in self.known:
            name = sympy.Dummy()
            self.names.of(name, f"angle{_digits(original)}")
            self.assignments.append((name, argument))
            self.known["angle", argument] = name
        return self.known["angle", argument]


def _digits(angle: Any) -> str:
    """23 for q2 + q3, 2m3 for q2 - q3."""
    import sympy

    text = ""
    for term in sorted(sympy.Add.make_args(angle), key=_natural):
        number, rest = term.as_coeff_Mul()
        tail = re.search(r"\d+$", str(rest))
        if not rest.is_Symbol or tail is None or abs(number) != 1:
            return ""
        text += ("m" if number < 0 else "_" if text and len(tail[0]) > 1 else "") + tail[0]
    return text


def _steps(program: Program, names: Names) -> Steps:
    import sympy

    for argument in program.arguments:
        if not argument.vector:
            names.of(argument.symbols[0], None if str(argument.symbols[0]) == argument.name else argument.name)
    vectors: dict[Any, str] = {}
    for argument in program.arguments:
        if argument.vector:
            holder = sympy.Dummy(argument.name)
            word = names.of(holder, argument.name)
            if word != argument.name:
                names.changed.append((argument.name, word))
            vectors |= {symbol: f"{word}{{{k}}}" for k, symbol in enumerate(argument.symbols)}
            names.known[argument] = word
    angles = _Angles(names)
    entries = [angles.replaced(entry) for entry in program.entries]

    shared, results = sympy.cse(entries, symbols=(sympy.Dummy() for _ in itertools.count()), order="none")
    for k, (symbol, _) in enumerate(shared):
        names.of(symbol, f"x{k}")
    names.known |= vectors
    return Steps((*angles.assignments, *shared), tuple(results))


# Numbers: the check


class Numbers(NamedTuple):
    """Numbers for every symbol of a closed form and of its robot."""

    q: Array
    values: Mapping[Any, float]


def drawn(form: ClosedForm, seed: int = 0) -> Numbers:
    """Pseudo-random numbers for the symbols of a closed form."""
    rng = np.random.default_rng(_SEED + seed)
    asked, joints = form.question, form.symbols["joints"]
    q = rng.uniform(-2.0, 2.0, len(joints))
    found = set(free_symbols(asked.model)) | set(form.expression.free_symbols)
    for several in (asked.qd, asked.qdd, asked.wrench, asked.gravity, asked.point, asked.offset):
        found |= set().union(*(x.free_symbols for x in several))
    others = sorted(found - set(joints), key=str)
    values = {x: float(form.values[x]) if x in form.values else float(rng.uniform(0.3, 1.7)) for x in others}
    return Numbers(q, values | dict(zip(joints, q.tolist(), strict=True)))


def by_definition(form: ClosedForm, numbers: Numbers) -> Array:
    """The quantity of a closed form by the numeric definition, in the shape of its expression."""
    asked, values = form.question, numbers.values
    model = in_numbers(asked.model, values)

    def several(entries: Iterable[Any]) -> Array:
        return np.array([evaluated(x, values) for x in entries])

    if form.quantity == "pose":
        return pose(model, numbers.q, at=form.link, point=several(asked.point).tolist(), check_finite=False).array
    if form.quantity == "gravity_torques":
        array, xp = as_array(numbers.q)
        return definition.gravity_torques(model, array, several(asked.gravity), xp)[:, None]
    assert asked.frame is not None
    frame = asked.frame._replace(offset=tuple(several(asked.offset).tolist()))
    options: dict[str, Any] = {"at": form.link, "frame": frame, "check_finite": False}
    rows = list(asked.rows)
    if form.quantity == "acceleration":
        found = acceleration(model, numbers.q, several(asked.qd), several(asked.qdd), **options)
        return found.array[rows][:, None]
    J = jacobian(model, numbers.q, **options).array[rows]
    if form.quantity == "velocity":
        return (J @ several(asked.qd))[:, None]
    if form.quantity == "joint_torques":
        return (J.T @ several(asked.wrench))[:, None]
    if form.quantity == "determinant":
        return np.array(np.linalg.det(J))
    if form.quantity == "minors":
        wide = J if J.shape[1] >= J.shape[0] else J.T
        kept = itertools.combinations(range(wide.shape[1]), len(wide))
        return np.array([[np.linalg.det(wide[:, columns])] for columns in kept])
    return J


_NUMERIC: dict[str, Callable[..., float]] = {name: getattr(math, name) for name in _FUNCTIONS if hasattr(math, name)}
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
        raise _no_code(x)
    known[x] = found
    return found


def _no_code(x: Any) -> ArrayTypeError:
    kind = type(x).__name__
    hint = f"sums, products, powers and {', '.join(_FUNCTIONS)}; put symbols in place of anything else"
    return ArrayTypeError("KS395", f"no code for {str(x)[:80]!r} ({kind})", hint)


def _check(program: Program, steps: Steps) -> None:
    """Raises KinestaticsError (KS396) unless steps, expression and definition agree at random numbers."""
    for seed in range(_DRAWS):
        expected, values = None, dict[Any, float]()
        if program.form is not None:
            numbers = drawn(program.form, seed)
            values = dict(numbers.values)
            expected = by_definition(program.form, numbers).ravel()
        rng = np.random.default_rng(_SEED + seed)
        symbols = [x for argument in program.arguments for x in argument.symbols]
        values |= {x: float(rng.uniform(0.2, 0.9)) for x in symbols if x not in values}
        try:
            plain = np.array([evaluated(entry, values) for entry in program.entries])
            for symbol, x in steps.assignments:
                values[symbol] = evaluated(x, values)
            found = np.array([evaluated(x, values) for x in steps.results])
        except KinestaticsError:
            raise
        except (ArithmeticError, ValueError, TypeError) as error:
            hint = "check=False leaves the check out"
            raise KinestaticsError("KS396", f"the code could not be checked: at random numbers, {error}", hint) from None
        _compare(found, plain, "the expression")
        if expected is not None:
            _compare(found, expected, "the numeric definition")


def _compare(found: Array, expected: Array, what: str) -> None:
    off = np.abs(found - expected).max(initial=0.0)
    if not off <= _CLOSE * max(1.0, float(np.abs(expected).max(initial=0.0))):
        raise KinestaticsError(
            "KS396", f"the code differs from {what} by {off:.2g}", "this is a fault of kinestatics: please report it"
        )


# Text


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
            raise _no_code(x)
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
        for factor in sorted_factors(rest):
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


def sorted_factors(x: Any) -> tuple[Any, ...]:
    """The factors of a product in SymPy's printing order."""
    return tuple(x.as_ordered_factors()) if x.is_Mul else (x,)


def _number(x: Any) -> tuple[str, int]:
    value = evaluated(x, {})
    text = repr(float(value))
    return text, _POWER if value >= 0 else _SUM


def _safe(text: str) -> str:
    """Text of a model for a comment: letters, digits and a few marks that end no comment in any language."""
    return re.sub(r"[^A-Za-z0-9 _.,:;()\[\]+=<>^/-]", "_", text.replace("²", "^2")).replace("//", "/")


def _header(program: Program, names: Names, language: Language, batch: str) -> list[str]:
    """What the function computes, of what, and which names were changed."""
    lines = [
        _safe(program.title[:1].upper() + program.title[1:]) + ".",
        "",
        f"{language.name} code of kinestatics; SI units, radians.",
    ]
    if program.arguments:
        lines += ["", "Arguments:"]
    for argument in program.arguments:
        name = names.known[argument] if argument.vector else names.known[argument.symbols[0]]
        shape = f"({batch}{len(argument.symbols)}) " if argument.vector else ""
        text = argument.text or (f"array of {', '.join(map(str, argument.symbols))}" if argument.vector else "number")
        default = "" if argument.default is None else f"; {argument.default!r} in this robot"
        lines.append(_safe(f"    {name}: {shape}{text}{default}"))
    shape = (
        "x".join(map(str, program.shape)) if language.name not in ("NumPy", "JAX") else ", ".join(map(str, program.shape))
    )
    lines += [
        "",
        "Result:",
        _safe(f"    ({batch}{shape}) {program.returns}" if program.shape else f"    one number {program.returns}"),
    ]
    if names.changed:
        told = [f"{_safe(old)} is called {new}" for old, new in names.changed]
        lines += ["", "Names changed:", *(f"    {line}" for line in told)]
    return [line.rstrip() for line in lines]


def _body(steps: Steps, text: Text) -> list[str]:
    return [text.language.assign.format(text(symbol), text(x)) for symbol, x in steps.assignments]


def _words(program: Program, names: Names) -> list[str]:
    return [names.known[a] if a.vector else names.known[a.symbols[0]] for a in program.arguments]


def _python(program: Program, steps: Steps, names: Names, language: Language, module: str) -> tuple[list[str], Text]:
    """Import, signature, header and body."""
    text = Text(names, language, "{0}[..., {1}]")
    words = _words(program, names)
    signature: list[str] = []
    defaults = True
    for word, argument in reversed(list(zip(words, program.arguments, strict=True))):
        defaults = defaults and argument.default is not None
        signature.insert(0, f"{word}={argument.default!r}" if defaults else word)
    long = {"np": "numpy", "jnp": "jax.numpy"}[module]
    lines = [f"import {long} as {module}", "", "", f"def {names.function}({', '.join(signature)}):"]
    header = _header(program, names, language, "..., ")
    lines += [f'    """{header[0]}', *(f"    {line}".rstrip() for line in header[1:]), '    """']
    for word, argument in zip(words, program.arguments, strict=True):
        if argument.vector:
            lines.append(f"    {word} = {module}.asarray({word}{', dtype=float' if module == 'np' else ''})")
    shapes = [
        f"{w}.shape[:-1]" if a.vector else f"{module}.shape({w})" for w, a in zip(words, program.arguments, strict=True)
    ]
    lines.append(f"    shape = {module}.broadcast_shapes({', '.join(shapes)})" if shapes else "    shape = ()")
    return [*lines, *(f"    {line}" for line in _body(steps, text))], text


def _places(shape: tuple[int, ...]) -> Iterable[tuple[int, ...]]:
    return itertools.product(*map(range, shape))


def _numpy_source(program: Program, steps: Steps, names: Names, language: Language) -> str:
    lines, text = _python(program, steps, names, language, "np")
    shape = ", ".join(map(str, program.shape)) + "," * (len(program.shape) == 1)
    lines.append(f"    result = np.zeros(shape + ({shape}))")
    for place, x in zip(_places(program.shape), steps.results, strict=True):
        if x != 0:
            lines.append(f"    result[{', '.join(['...', *map(str, place)])}] = {text(x)}")
    return "\n".join([*lines, "    return result[()]", ""])


def _jax_source(program: Program, steps: Steps, names: Names, language: Language) -> str:
    lines, text = _python(program, steps, names, language, "jnp")
    if not program.shape:
        return "\n".join([*lines, f"    return jnp.broadcast_to({text(steps.results[0])}, shape)", ""])
    lines += ["    result = [", *(f"        {text(x)}," for x in steps.results), "    ]"]
    lines.append("    result = jnp.stack([jnp.broadcast_to(entry, shape) for entry in result], -1)")
    shape = ", ".join(map(str, program.shape)) + "," * (len(program.shape) == 1)
    return "\n".join([*lines, f"    return result.reshape(shape + ({shape}))", ""])


def _c_source(program: Program, steps: Steps, names: Names, language: Language) -> str:
    text = Text(names, language, "{0}[{1}]")
    words = _words(program, names)
    arguments = [f"{'const double *' if a.vector else 'double '}{w}" for w, a in zip(words, program.arguments, strict=True)]
    size = math.prod(program.shape)
    if program.shape:
        arguments.append(f"double result[{max(size, 1)}]")
    lines = _comment(program, names, language, "row by row")
    kind = "void" if program.shape else "double"
    lines += ["#include <math.h>", "", f"{kind} {names.function}({', '.join(arguments) or 'void'})", "{"]
    body = _body(steps, text)
    values = _filled(program, steps, text, "result[{}] = {};")
    lines += [f"    {line}" for line in [*_unused(words, body + values, "(void){};"), *body, *values]]
    return "\n".join([*lines, "}", ""])


def _cpp_source(program: Program, steps: Steps, names: Names, language: Language) -> str:
    text = Text(names, language, "{0}[{1}]")
    words = _words(program, names)
    arguments = []
    for word, a in zip(words, program.arguments, strict=True):
        kind = f"const std::array<double, {len(a.symbols)}>& " if a.vector else "double "
        arguments.append(f"{kind}{word}")
    kind = f"std::array<double, {math.prod(program.shape)}>" if program.shape else "double"
    lines = _comment(program, names, language, "row by row")
    lines += ["#include <array>", "#include <cmath>", "", f"inline {kind} {names.function}({', '.join(arguments)})", "{"]
    body = _body(steps, text)
    values = _filled(program, steps, text, "result[{}] = {};")
    if program.shape:
        values = [f"{kind} result{{}};", *(v for v in values if not v.endswith("= 0.0;")), "return result;"]
    lines += [f"    {line}" for line in [*_unused(words, body + values, "(void){};"), *body, *values]]
    return "\n".join([*lines, "}", ""])


def _comment(program: Program, names: Names, language: Language, order: str) -> list[str]:
    header = _header(program, names, language, "")
    header = [
        f"{line}, {order}" if k and header[k - 1] == "Result:" and program.shape else line for k, line in enumerate(header)
    ]
    return [f"/* {header[0]}", *(f" * {line}".rstrip() for line in header[1:]), " */"]


def _filled(program: Program, steps: Steps, text: Text, assign: str) -> list[str]:
    if not program.shape:
        return [f"return {text(steps.results[0])};"]
    return [assign.format(k, text(x)) for k, x in enumerate(steps.results)]


def _unused(words: Sequence[str], lines: Sequence[str], template: str) -> list[str]:
    used = set(re.findall(r"[A-Za-z]\w*", "\n".join(lines)))
    return [template.format(word) for word in words if word not in used]


def _matlab_source(program: Program, steps: Steps, names: Names, language: Language) -> str:
    text = Text(names, language, "{0}({2})")
    lines = [f"function result = {names.function}({', '.join(_words(program, names))})"]
    lines += [f"% {line}".rstrip() for line in _header(program, names, language, "")]
    lines += [f"    {line}" for line in _body(steps, text)]
    if not program.shape:
        lines.append(f"    result = {text(steps.results[0])};")
    else:
        sizes = program.shape if len(program.shape) > 1 else (*program.shape, 1)
        lines.append(f"    result = zeros({', '.join(map(str, sizes))});")
        for place, x in zip(_places(program.shape), steps.results, strict=True):
            if x != 0:
                lines.append(f"    result({', '.join(str(k + 1) for k in place)}) = {text(x)};")
    return "\n".join([*lines, "end", ""])


_WRITERS: dict[str, Callable[[Program, Steps, Names, Language], str]] = {
    "numpy": _numpy_source,
    "jax": _jax_source,
    "c": _c_source,
    "cpp": _cpp_source,
    "matlab": _matlab_source,
    "octave": _matlab_source,
}

__all__ = ["LANGUAGES", "generate_code"]
