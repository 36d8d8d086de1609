"""The expressions of closed forms, one answer for each quantity. Floor 7."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ..errors import ConfigurationError
from ..frames import Frame
from ..spatial import LINEAR_ROWS
from .factors import factored
from .mechanism import WHOLE_TASKS
from .poses import determinant
from .questions import Question, between
from .ring import Polynomial
from .rows import (
    acceleration_rows,
    frame_in_words,
    jacobian_rows,
    potential_energy,
    row_names,
    same_everywhere,
    task_matrix,
    torque_rows,
    velocity_rows,
)
from .writer import Writer, rounded_text


class Answer(NamedTuple):
    """A quantity as an expression, and how it is to be read.

    Attributes:
        question: with the frame that was chosen; expression: SymPy; where: the frame in words.
        rows, columns: names of them; frame: of the rows, None where it does not matter; factors: of a determinant.
    """

    question: Question
    expression: Any
    where: str
    rows: Sequence[str]
    columns: Sequence[str]
    frame: Frame | None
    factors: tuple[tuple[Any, int], ...] = ()


def _pose(question: Question) -> Answer:
    import sympy

    mechanism = question.mechanism
    writer = Writer(mechanism.ring)
    R, p = mechanism.pose(question.model.link(question.link), question.point)
    rows = [[*map(writer, row), writer(x)] for row, x in zip(R, p, strict=True)]
    T = sympy.ImmutableDenseMatrix([*rows, [0, 0, 0, 1]])
    at = f" at ({', '.join(map(str, question.point))})" if any(x != 0 for x in question.point) else ""
    columns = ("x axis", "y axis", "z axis", "origin")
    return Answer(question, T, f"seen from {question.model.base}{at}", "xyz1", columns, None)


def _jacobian(question: Question) -> Answer:
    mechanism = question.mechanism
    assert question.frame is not None
    writer = Writer(mechanism.ring)
    columns = [str(x) for x in mechanism.ring.joints]
    best = None
    for frame, offset in _candidates(question):
        asked = replace(question, frame=frame, offset=offset)
        J = jacobian_rows(asked)
        size = sum(sum(1 + sum(map(bool, e)) for e in p.to_dict()) for row in J for p in row)
        if best is None or size < best[0]:
            best = size, asked, J
    assert best is not None
    _, asked, J = best
    assert asked.frame is not None
    where = frame_in_words(asked.frame, asked.offset)
    return Answer(asked, writer.matrix(J), where, row_names(asked), columns, asked.frame)


def _candidates(question: Question) -> list[tuple[Frame, tuple[Any, ...]]]:
    """The frames among which the shortest is sought, the geometric one first; one alone where it was asked for."""
    import sympy

    assert question.frame is not None
    found, model = [(question.frame, question.offset)], question.model
    path = between(model, model.link(question.link))
    if not question.automatic or not path or question.rows not in WHOLE_TASKS:
        return found
    name, zero = question.link, (sympy.Integer(0),) * 3
    found.append((question.frame._replace(axes=name), question.offset))
    if question.rows != LINEAR_ROWS:
        for i in path[:-1]:
            found.append((Frame.body(model.link_name(i)), zero))
    else:
        found += [(question.frame._replace(axes=model.link_name(i)), question.offset) for i in path[:-1]]
    return found


def _velocity(question: Question) -> Answer:
    return _column(question, velocity_rows(question), row_names(question))


def _column(question: Question, entries: Sequence[Polynomial], rows: Sequence[str]) -> Answer:
    assert question.frame is not None
    writer = Writer(question.mechanism.ring)
    where = frame_in_words(question.frame, question.offset)
    return Answer(question, writer.matrix([[p] for p in entries]), where, rows, (), question.frame)


def _acceleration(question: Question) -> Answer:
    return _column(question, acceleration_rows(question), [f"d{name}" for name in row_names(question)])


def _gravity(question: Question) -> Answer:
    mechanism = question.mechanism
    energy, writer = potential_energy(question), Writer(mechanism.ring)
    torques = [[mechanism.slope(energy, j)] for j in range(question.model.n)]
    names = [f"tau{j + 1}" for j in range(question.model.n)]
    where = f"gravity ({', '.join(map(rounded_text, question.gravity))}) m/s² in axes of {question.model.base}"
    return Answer(question, writer.matrix(torques), where, names, (), None)


def _torques(question: Question) -> Answer:
    return _column(question, torque_rows(question), [f"tau{j + 1}" for j in range(question.model.n)])


def _determinant(question: Question) -> Answer:
    import sympy

    rows, n = len(question.rows), question.model.n
    if rows != n:
        message = f"the Jacobian of {question.link} has {rows} rows ({', '.join(row_names(question))}) and {n} columns"
        raise ConfigurationError(
            "KS394", f"{message}: it has no determinant", "closed_form('minors', ...), or task= with as many rows"
        )
    M, where = task_matrix(question)
    factors = factored(question.mechanism.ring, determinant(question.mechanism.ring, M))
    expression = sympy.Mul(*(x**times for x, times in factors))
    return Answer(question, expression, where, (), (), _frame_if_it_matters(question), tuple(factors))


def _frame_if_it_matters(question: Question) -> Frame | None:
    return None if same_everywhere(question) else question.frame


def _minors(question: Question) -> Answer:
    import sympy

    ring = question.mechanism.ring
    M, where = task_matrix(question)
    rows, n = len(M), question.model.n
    size = min(rows, n)
    names, found = [], []
    for kept in itertools.combinations(range(max(rows, n)), size):
        part = [[row[j] for j in kept] for row in M] if n >= rows else [M[r] for r in kept]
        left = [k for k in range(max(rows, n)) if k not in kept]
        labels = [str(x) for x in ring.joints] if n >= rows else row_names(question)
        names.append(f"without {', '.join(labels[k] for k in left)}" if left else "all")
        found.append(sympy.Mul(*(x**times for x, times in factored(ring, determinant(ring, part)))))
    return Answer(question, sympy.ImmutableDenseMatrix([found]).T, where, names, (), _frame_if_it_matters(question))


ANSWERS: dict[str, Callable[[Question], Answer]] = {
    "pose": _pose,
    "jacobian": _jacobian,
    "velocity": _velocity,
    "acceleration": _acceleration,
    "gravity_torques": _gravity,
    "joint_torques": _torques,
    "determinant": _determinant,
    "minors": _minors,
}
