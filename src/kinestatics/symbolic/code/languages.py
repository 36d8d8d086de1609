"""How NumPy, JAX, C, C++, MATLAB and Octave write things. Floor 7."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from dataclasses import dataclass

FUNCTIONS = (
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
    return {name: others.get(name, prefix + name) for name in FUNCTIONS}


_INVERSE = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}
LANGUAGE_OF: dict[str, Language] = {
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
        frozenset([*_C_WORDS.split(), *FUNCTIONS]),
        _named("", Abs="fabs", sign=""),
        "pow({}, {})",
        True,
        "const double {} = {};",
    ),
    "cpp": Language(
        "C++",
        frozenset([*_C_WORDS.split(), *_CPP_WORDS.split(), *FUNCTIONS]),
        _named("std::", Abs="std::abs", sign=""),
        "std::pow({}, {})",
        True,
        "const double {} = {};",
    ),
}
for _word, _title in (("matlab", "MATLAB"), ("octave", "Octave")):
    _reserved = frozenset([*_MATLAB_WORDS.split(), *FUNCTIONS])
    LANGUAGE_OF[_word] = Language(_title, _reserved, _named("", Abs="abs"), "{}^{}", False, "{} = {};")
LANGUAGES = tuple(LANGUAGE_OF)
