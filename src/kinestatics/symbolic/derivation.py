"""`derivation`: how a closed form comes about, step by step, as LaTeX to be read. Floor 7.

Frame i lies on the axis of joint i, so that z_i and p_i are its axis and a point of it (books that place frame i at the far
end of link i call them z_{i-1} and p_{i-1}).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from ..model import RobotModel
from .closed_form import ClosedForm, closed_form
from .halfangle import HalfAngleRing
from .latex import matrix
from .latex_names import words
from .poses import determinant
from .printing import rational
from .ring import Matrix, Polynomial
from .rows import jacobian_rows, potential_energy, same_everywhere, task_matrix, velocity_rows
from .story import Story

_SHOWN = 40
"""Sums of more terms are not written out: their number is said."""


def derivation(quantity: str, model: RobotModel, *, short: bool = True, **options: Any) -> str:
    """A closed form with the steps that lead to it.

    Args:
        quantity, model, options: as in `closed_form`.
        short: c_{23} for cos(q2 + q3).

    Returns:
        LaTeX of text mode, paragraphs and displayed equations (amsmath): the transforms from joint to joint, their
        products, the axes and points, the columns of the Jacobian, what is made of them; for a determinant the Jacobian in a
        middle frame, its expansion, and its factors in half angles.

    Raises:
        As `closed_form`.

    Source: note 001, "Kinematics using the Jacobian"; note 004; Spong, "Robot Modeling and Control" (2006), chapter 4.

    Example:
        >>> import kinestatics as ks
        >>> text = ks.derivation("determinant", ks.load("planar_2r"), lengths="symbols")
        >>> print(text.splitlines()[-2])
        \\det J = a_{1}^{2} s_{2}
    """
    return derivation_of(closed_form(quantity, model, **options), short=short)


def derivation_of(form: ClosedForm, *, short: bool = True) -> str:
    """The steps of a closed form."""
    story = Story(form, short)
    _CHAPTERS[form.quantity](story)
    return story.text()


def _pose(story: Story) -> None:
    story.transforms(story.path)
    story.product()
    story.result("T")


def _jacobian(story: Story) -> None:
    story.jacobian()
    story.result("J")


def _velocity(story: Story) -> None:
    story.jacobian()
    story.say("The Jacobian, and its product with the joint rates:")
    story.show(f"J = {story.matrix(jacobian_rows(story.question))}")
    story.result(r"V = J \dot{q}")


def _acceleration(story: Story) -> None:
    mechanism, question = story.mechanism, story.question
    story.jacobian()
    v = velocity_rows(question)
    story.say("The velocity $v = J \\dot{q}$:")
    story.show(f"v = {story.column(v)}")
    story.say("Its derivatives by the rates, which are $J$ again, and by the joints:")
    slopes = [[mechanism.slope(p, j) for j in range(question.model.n)] for p in v]
    story.show(rf"\frac{{\partial v}}{{\partial \dot{{q}}}} = J = {story.matrix(jacobian_rows(question))}")
    story.show(rf"\frac{{\partial v}}{{\partial q}} = {story.matrix(slopes)}")
    story.result(r"a = \frac{\partial v}{\partial \dot{q}} \ddot{q} + \frac{\partial v}{\partial q} \dot{q}")


def _torques(story: Story) -> None:
    story.jacobian()
    wrench = matrix([[story.printer(x)] for x in story.question.wrench])
    story.say("By virtual work the torques that hold a wrench $w$ on the environment are $J^T w$:")
    story.show(f"J = {story.matrix(jacobian_rows(story.question))}, \\quad w = {wrench}")
    story.result(r"\tau = J^T w")


def _gravity(story: Story) -> None:
    mechanism, question = story.mechanism, story.question
    story.transforms([*mechanism.joints])
    story.say("The centres of mass, seen from the base, and the masses in kg:")
    for link, (joint, _) in mechanism.links.items():
        mass = question.model.masses[link]
        if joint >= 0 and mass != 0:
            name = words(question.model.link_names[link])
            center = mechanism.point(link, question.model.centers_of_mass[link], -1)
            story.show(f"p = {story.column(center)}, \\quad m = {story.printer(mass)} \\quad {name}")
    g = matrix([[story.printer(x)] for x in question.gravity])
    story.say("The potential energy, in J:")
    story.show(rf"U = - \sum m \, g^T p = {story.write(potential_energy(question))}, \quad g = {g}")
    story.say("Its slopes are the torques that hold the arm.")
    story.result(r"\tau = \frac{\partial U}{\partial q}")


def _determinant(story: Story) -> None:
    M, ring = _matrix_of_task(story), story.ring
    rows, columns = len(M), story.question.model.n
    size = min(rows, columns)
    for kept in itertools.combinations(range(max(rows, columns)), size):
        part = [[row[j] for j in kept] for row in M] if columns >= rows else [M[r] for r in kept]
        p = determinant(ring, part)
        numbers = "" if rows == columns else f"_{{{','.join(str(k + 1) for k in kept)}}}"
        _expanded(story, p, numbers)
    if story.form.quantity == "determinant":
        story.result(r"\det J")
    else:
        story.result("m")


def _matrix_of_task(story: Story) -> Matrix:
    """The frame, and the Jacobian in it."""
    M, where = task_matrix(story.question)
    story.transforms(story.path)
    story.product()
    if same_everywhere(story.question):
        story.say(
            "The determinant of these rows is the same in all axes, since a change of axes has determinant 1. "
            "In axes of a joint in the middle the columns next to it depend on few joints:"
        )
    else:
        story.axes()
        story.columns()
        story.frame()
        story.say("The rows in play:")
    story.say(words(where) + ".")
    story.show(f"J = {story.matrix(M)}")
    return M


def _expanded(story: Story, p: Polynomial, numbers: str) -> None:
    """The determinant as a sum, and its factors in half angles."""
    half, terms = HalfAngleRing(story.ring), len(p.to_dict())
    story.say("Expanded along its emptiest rows and columns:")
    shown = story.write(p) if terms <= _SHOWN else rf"\text{{({terms} terms)}}"
    story.show(rf"\det J{numbers} = {shown}")
    if p == 0:
        return
    factors = half.factored(half.lifted(p))[1]
    if not factors:
        return
    t, u = r"t_i = \sin\tfrac{q_i}{2}", r"u_i = \cos\tfrac{q_i}{2}"
    rules = r"$\cos q_i = u_i^2 - t_i^2$, $\sin q_i = 2 t_i u_i$, $1 = t_i^2 + u_i^2$"
    story.say(f"With ${t}$ and ${u}$, so that {rules}, the factors are:")
    names = _half_symbols(half)
    for F, times in factors:
        raised = f"^{{{times}}}" if times > 1 else ""
        size = len(F.to_dict())
        text = story.printer(_half_sum(F, names)) if size <= _SHOWN else rf"\text{{a sum of {size} terms}}"
        story.show(rf"\left({text}\right){raised}")


def _half_symbols(half: HalfAngleRing) -> list[Any]:
    """SymPy symbols for the generators of half angles: t3, u3; and what else there is."""
    import sympy

    ring, names = half.ring, list[Any]()
    turning = [j + 1 for j, turns in enumerate(ring.turns) if turns]
    for k in range(len(ring.angles)):
        tail = str(turning[k]) if k < len(turning) else f"_c{k - len(turning) + 1}"
        names += [sympy.Symbol(f"t{tail}"), sympy.Symbol(f"u{tail}")]
    others = [*(ring.joints[j] for j in ring.slides), *ring.parameters, *map(sympy.sqrt, ring.roots)]
    return [*names, *others]


def _half_sum(F: Polynomial, names: Sequence[Any]) -> Any:
    import sympy

    terms = []
    for exponents, coefficient in F.to_dict().items():
        powers = [x ** int(e) for x, e in zip(names, exponents, strict=False) if e]
        terms.append(sympy.Mul(rational(coefficient), *powers))
    return sympy.Add(*terms)


_CHAPTERS = {
    "pose": _pose,
    "jacobian": _jacobian,
    "velocity": _velocity,
    "acceleration": _acceleration,
    "gravity_torques": _gravity,
    "joint_torques": _torques,
    "determinant": _determinant,
    "minors": _determinant,
}

__all__ = ["derivation", "derivation_of"]
