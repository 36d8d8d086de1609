"""Whole functions in every language: signature, header, steps, result. Floor 7."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterable, Sequence

from .header import header_lines
from .identifiers import Names
from .languages import Language
from .programs import Program
from .steps import Steps
from .text import Text


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
    header = header_lines(program, names, language, "..., ")
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
    header = header_lines(program, names, language, "")
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
    lines += [f"% {line}".rstrip() for line in header_lines(program, names, language, "")]
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


WRITERS: dict[str, Callable[[Program, Steps, Names, Language], str]] = {
    "numpy": _numpy_source,
    "jax": _jax_source,
    "c": _c_source,
    "cpp": _cpp_source,
    "matlab": _matlab_source,
    "octave": _matlab_source,
}
