"""Paragraphs and displayed equations about one closed form, and the chapters that several quantities share. Floor 7."""

from __future__ import annotations

from collections.abc import Sequence

from .closed_form import ClosedForm
from .latex import matrix
from .latex_names import symbol, words
from .latex_printer import Printer
from .poses import Pose, compose, identity
from .ring import Matrix, Polynomial
from .writer import Writer


class Story:
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
        local = [self.ring.read(x) for x in point]
        self.show(f"T_{{{last},e}} = {self.pose(compose(self.ring, end, Pose(identity(self.ring).R, local)))}")
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
