"""Closed forms as polynomials: rows of Jacobians, velocities, accelerations, energies, torques. Floor 7."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..frames import Frame
from ..spatial import LINEAR_ROWS, ROW_NAMES
from .mechanism import WHOLE_TASKS
from .poses import Pose, Vector, compose, turned
from .questions import Question
from .ring import Matrix, Polynomial, TrigonometricRing, expanded
from .values import center_of, exact_value, objects


def jacobian_rows(question: Question) -> list[list[Polynomial]]:
    """(rows, n) the Jacobian in the frame of the question, as polynomials."""
    assert question.frame is not None
    model = question.model
    J = question.mechanism.jacobian_in(model.link(question.link), question.frame, question.offset)
    return [J[r] for r in question.rows]


def _combination(ring: TrigonometricRing, M: Matrix, values: Sequence[Polynomial]) -> list[Polynomial]:
    return [ring.total(a * b for a, b in zip(row, values, strict=True)) for row in M]


def velocity_rows(question: Question) -> list[Polynomial]:
    """J q̇."""
    ring = question.mechanism.ring
    return _combination(ring, jacobian_rows(question), [ring.read(x) for x in question.qd])


def acceleration_rows(question: Question) -> list[Polynomial]:
    """jacobian(v, q̇) q̈ + jacobian(v, q) q̇ with v = J q̇."""
    mechanism, ring = question.mechanism, question.mechanism.ring
    J, rates = jacobian_rows(question), [ring.read(x) for x in question.qd]
    first = _combination(ring, J, [ring.read(x) for x in question.qdd])
    found = []
    for row, part in zip(J, first, strict=True):
        v = ring.total(a * b for a, b in zip(row, rates, strict=True))
        moving = (mechanism.slope(v, j) * rate for j, rate in enumerate(rates))
        found.append(ring.total([part, *moving]))
    return found


def torque_rows(question: Question) -> list[Polynomial]:
    """Jᵀ w."""
    ring = question.mechanism.ring
    columns = list(zip(*jacobian_rows(question), strict=True))
    return _combination(ring, columns, [ring.read(x) for x in question.wrench])


def potential_energy(question: Question) -> Polynomial:
    """-Σ m gᵀ p of the centres of mass of the links that move."""
    mechanism, model = question.mechanism, question.model
    ring = mechanism.ring
    down = [ring.read(x) for x in question.gravity]
    moments: dict[int, Vector] = {}
    masses: dict[int, Polynomial] = {}
    for link, (joint, T) in mechanism.links.items():
        mass = exact_value(model.masses[link])
        if joint < 0 or mass == 0:
            continue
        m = ring.read(expanded(objects([mass]))[0])
        center = [ring.read(x) for x in expanded(objects(center_of(model, link)))]
        place = compose(ring, T, Pose(T.R, center)).p
        before = moments.get(joint, [ring.zero] * 3)
        moments[joint] = [ring.reduced(a + m * b) for a, b in zip(before, place, strict=True)]
        masses[joint] = masses.get(joint, ring.zero) + m
    seen, parts = mechanism.seen_from(-1), []
    for joint, moment in moments.items():
        R, p = seen[joint]
        for g, a, b in zip(down, turned(ring, R, moment), p, strict=True):
            parts.append(-g * (a + masses[joint] * b))
    return ring.total(parts)


def same_everywhere(question: Question) -> bool:
    """Whether determinants of the rows are the same in all axes; of fewer columns than rows they are not."""
    return question.rows in WHOLE_TASKS and question.model.n >= len(question.rows)


def task_matrix(question: Question) -> tuple[Matrix, str]:
    """The rows in play, in the frame of a middle joint where their determinants are the same in all; and where, in words."""
    model, mechanism = question.model, question.mechanism
    assert question.frame is not None
    link = model.link(question.link)
    if not same_everywhere(question):
        return jacobian_rows(
            question
        ), f"rows {', '.join(row_names(question))}, {frame_in_words(question.frame, question.offset)}"
    body = mechanism.middle(link)
    origin = None
    if question.rows == LINEAR_ROWS:
        origin = mechanism.point(model.link(question.frame.origin), question.offset, body)
    J = mechanism.jacobian(link, body, origin)
    name = model.moving_names[body] if body >= 0 else model.base
    at = "" if origin is None else f" at {frame_in_words(question.frame, question.offset).partition(', at ')[2]}"
    alike = "the same in every frame" if origin is None else "the same in all axes"
    of_joint = f"{'that' if origin is None else 'those'} of joint {name}" if body >= 0 else name
    return [J[r] for r in question.rows], f"rows {', '.join(row_names(question))}{at}, {alike}, found in {of_joint}"


def row_names(question: Question, names: Sequence[str] = ROW_NAMES) -> list[str]:
    """Names of the rows in play."""
    return [names[r] for r in question.rows]


def frame_in_words(frame: Frame, offset: Sequence[Any]) -> str:
    """Axes and origin, the offset exact."""
    text = str(frame._replace(offset=(0.0, 0.0, 0.0)))
    return f"{text} + ({', '.join(map(str, offset))})" if any(x != 0 for x in offset) else text
