"""`derivation`: how a closed form comes about, step by step, as LaTeX to be read. Floor 7.

Frame i lies on the axis of joint i, so that z_i and p_i are its axis and a point of it (books that place frame i at the far
end of link i call them z_{i-1} and p_{i-1}).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from ..model import RobotModel
from .chain import Pose, compose, determinant
from .closed_form import (
    ClosedForm,
    Writer,
    _unmoved,
    closed_form,
    exact_value,
    jacobian_rows,
    potential_energy,
    same_everywhere,
    task_matrix,
    velocity_rows,
)
from .halfangle import HalfAngleRing
from .latex import Printer, matrix, symbol, words
from .printing import rational
from .ring import Matrix, Polynomial

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
        >>> text = derivation("determinant", ks.load("planar_2r"), lengths="symbols")
        >>> print(text.splitlines()[-2])
        \\det J = a_{1}^{2} s_{2}
    """
    return derivation_of(closed_form(quantity, model, **options), short=short)


def derivation_of(form: ClosedForm, *, short: bool = True) -> str:
    """The steps of a closed form."""
    story = _Story(form, short)
    _CHAPTERS[form.quantity](story)
    return story.text()


class _Story:
    """Paragraphs and equations about one closed form."""

    def __init__(self, form: ClosedForm, short: bool) -> None:
        self.form, self.question, self.mechanism = form, form.question, form.question.mechanism
        self.ring = self.mechanism.ring
        self.writer = Writer(self.ring)
        symbols = [*self.ring.joints, *self.ring.parameters]
        self.printer = Printer(symbols, short, self.ring.joints)
        self.link = self.question.model.link(form.link)
        self.path = self.mechanism.path(self.link)
        self.lines: list[str] = []

    def text(self) -> str:
        """All of it, after what short names mean."""
        values = [f"{symbol(str(x))} = {self.printer(v)}" for x, v in self.mechanism.values.items()]
        head = [
            f"Closed form: {self.form.quantity.replace('_', ' ')} of {words(self.form.link)} of {words(self.form.robot)}."
        ]
        if self.printer.used:
            waves = Printer([], False)
            short = [f"{name} = {waves(x)}" for name, x in sorted(self.printer.used.items())]
            head.append(f"In short, ${'$, $'.join(short)}$.")
        if values:
            head.append(f"Lengths in metres: ${'$, $'.join(values)}$.")
        return "\n".join([*head, *self.lines, ""])

    def say(self, text: str) -> None:
        """A paragraph."""
        self.lines += ["", text]

    def show(self, *equations: str) -> None:
        """Displayed equations."""
        for equation in equations:
            self.lines += ["\\[", equation, "\\]"]

    def write(self, p: Polynomial) -> str:
        """A polynomial."""
        return self.printer(self.writer(p))

    def matrix(self, M: Matrix) -> str:
        """A matrix of polynomials."""
        return matrix([[self.write(p) for p in row] for row in M])

    def column(self, v: Sequence[Polynomial]) -> str:
        """A column of polynomials."""
        return self.matrix([[p] for p in v])

    def pose(self, T: Pose) -> str:
        """(4, 4)."""
        rows = [[*map(self.write, row), self.write(x)] for row, x in zip(T.R, T.p, strict=True)]
        return matrix([*rows, ["0", "0", "0", "1"]])

    def result(self, left: str) -> None:
        """The closed form itself."""
        self.say("The result:")
        expression = self.form.expression
        body = (
            matrix([[self.printer(x) for x in row] for row in expression.tolist()]) if hasattr(expression, "shape") else None
        )
        self.show(f"{left} = {body if body is not None else self.printer(expression)}")

    # chapters that several quantities share

    def transforms(self, joints: Sequence[int]) -> None:
        """From joint to joint, and the product."""
        mechanism, numbers = self.mechanism, self.numbers(joints)
        self.say("Frame $i$ lies on the axis of joint $i$; seen from the frame before:")
        for i in joints:
            name = words(self.question.model.moving_names[i])
            self.show(
                f"T_{{{numbers.get(mechanism.parents[i], 0)},{numbers[i]}}} = {self.pose(mechanism.steps[i])} \\quad {name}"
            )

    def product(self) -> None:
        """The end, and the product of the transforms."""
        mechanism, numbers = self.mechanism, self.numbers(self.path)
        last = len(self.path)
        self.say(f"The frame of {words(self.form.link)} seen from frame ${last}$:")
        end = mechanism.links[self.link][1]
        point = self.question.point if self.form.quantity == "pose" else (0, 0, 0)
        local = [self.ring.read(exact_value(x)) for x in point]
        self.show(f"T_{{{last},e}} = {self.pose(compose(self.ring, end, Pose(_unmoved(self.ring).R, local)))}")
        self.say("Their products:")
        seen = mechanism.seen_from(-1)
        for i in self.path[1:]:
            k = numbers[i]
            self.show(f"T_{{0,{k}}} = T_{{0,{k - 1}}} T_{{{k - 1},{k}}} = {self.pose(seen[i])}")
        product = f"T_{{0,{last}}} T_{{{last},e}}" if last else "T_{0,e}"
        self.show(f"T_{{0,e}} = {product} = {self.pose(mechanism.pose(self.link, point))}")

    def axes(self) -> None:
        """Axis and point of every joint, and the point in question."""
        seen, numbers = self.mechanism.seen_from(-1), self.numbers(self.path)
        self.say("The axis $z_i$ of joint $i$ and a point $p_i$ of it, in axes of the base:")
        for i in self.path:
            R, p = seen[i]
            z = [self.ring.total(a * b for a, b in zip(row, self.mechanism.joints[i].direction, strict=True)) for row in R]
            self.show(f"z_{{{numbers[i]}}} = {self.column(z)}, \\quad p_{{{numbers[i]}}} = {self.column(p)}")
        self.say("The point whose velocity is asked for:")
        self.show(f"p = {self.column(self.point())}")

    def point(self) -> list[Polynomial]:
        """The origin of the frame, seen from the base."""
        question = self.question
        assert question.frame is not None
        return self.mechanism.point(question.model.link(question.frame.origin), question.offset, -1)

    def columns(self) -> None:
        """z × (p - p_i) and z, or z and 0; several joints of one coordinate are added."""
        mechanism, numbers = self.mechanism, self.numbers(self.path)
        J = mechanism.jacobian(self.link, -1, self.point())
        self.say(
            "A joint that turns moves the point with $z_i \\times (p - p_i)$ and the body with $z_i$; "
            "one that slides moves the point with $z_i$:"
        )
        for column in range(self.question.model.n):
            own = [i for i in self.path if mechanism.joints[i].column == column]
            terms = []
            for i in own:
                joint, k = mechanism.joints[i], numbers[i]
                part = f"z_{{{k}}} \\\\ 0" if joint.slides else f"z_{{{k}}} \\times (p - p_{{{k}}}) \\\\ z_{{{k}}}"
                ratio = "" if joint.multiplier == 1 else f"{self.printer(joint.multiplier)} "
                terms.append(f"{ratio}\\begin{{bmatrix}} {part} \\end{{bmatrix}}")
            left = " + ".join(terms) or "0"
            self.show(f"J_{{{column + 1}}} = {left} = {self.column([row[column] for row in J])}")

    def frame(self) -> None:
        """The change to other axes, and the rows."""
        question = self.question
        assert question.frame is not None
        if question.model.link(question.frame.axes) != question.model.link("base"):
            R = self.mechanism.pose(question.model.link(question.frame.axes)).R
            self.say(
                f"In axes of {words(question.frame.axes)}, whose rotation is $R$, both halves are multiplied with $R^T$:"
            )
            self.show(f"R = {self.matrix(R)}")

    def jacobian(self) -> None:
        """All steps to the Jacobian."""
        self.transforms(self.path)
        self.product()
        self.axes()
        self.columns()
        self.frame()

    def numbers(self, joints: Sequence[int]) -> dict[int, int]:
        """joint → its number, from 1."""
        return {i: k + 1 for k, i in enumerate(joints)}


def _pose(story: _Story) -> None:
    story.transforms(story.path)
    story.product()
    story.result("T")


def _jacobian(story: _Story) -> None:
    story.jacobian()
    story.result("J")


def _velocity(story: _Story) -> None:
    story.jacobian()
    story.say("The Jacobian, and its product with the joint rates:")
    story.show(f"J = {story.matrix(jacobian_rows(story.question))}")
    story.result(r"V = J \dot{q}")


def _acceleration(story: _Story) -> None:
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


def _torques(story: _Story) -> None:
    story.jacobian()
    wrench = matrix([[story.printer(x)] for x in story.question.wrench])
    story.say("By virtual work the torques that hold a wrench $w$ on the environment are $J^T w$:")
    story.show(f"J = {story.matrix(jacobian_rows(story.question))}, \\quad w = {wrench}")
    story.result(r"\tau = J^T w")


def _gravity(story: _Story) -> None:
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


def _determinant(story: _Story) -> None:
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


def _matrix_of_task(story: _Story) -> Matrix:
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


def _expanded(story: _Story, p: Polynomial, numbers: str) -> None:
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
