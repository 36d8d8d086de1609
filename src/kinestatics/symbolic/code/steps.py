"""From expressions to assignments: every sine and cosine once, then common subexpressions. Floor 7."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field
from typing import Any

from .identifiers import Names
from .programs import Program, natural_order


@dataclass(frozen=True)
class Steps:
    """Assignments, and the results in terms of what they name."""

    assignments: tuple[tuple[Any, Any], ...]
    results: tuple[Any, ...]


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
    for term in sorted(sympy.Add.make_args(angle), key=natural_order):
        number, rest = term.as_coeff_Mul()
        tail = re.search(r"\d+$", str(rest))
        if not rest.is_Symbol or tail is None or abs(number) != 1:
            return ""
        text += ("m" if number < 0 else "_" if text and len(tail[0]) > 1 else "") + tail[0]
    return text


def steps_of(program: Program, names: Names) -> Steps:
    """Sines and cosines first, then what else occurs twice."""
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
