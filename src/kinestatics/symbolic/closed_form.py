"""`closed_form`: kinematic and static quantities of a robot as short expressions, exact and without simplification. Floor 7.

A question holds the joints and links in it as exact polynomials; the quantities are sums, products and derivatives of these,
which are printed as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ..frames import TIP, Frame
from ..kinematics import require_model
from ..model import RobotModel
from ..quantities import Wrench, wrapped
from ..surfaces import surface
from .answers import ANSWERS, Answer
from .exact import FRACTIONS, MOST_KEPT, exact, sympy_module
from .questions import QUANTITIES, Question, asked, check_options, require_masses
from .writer import rounded_text


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A quantity of a robot as an expression in its joints, lengths, rates.

    Attributes:
        quantity: "pose", "jacobian", ...; robot, link: names.
        expression: SymPy; a matrix, or for a determinant one expression.
        frame: axes and origin of the rows; None where they do not matter.
        where: the same in words.
        symbols: "joints" (n), and where they occur "rates", "accelerations", "wrench", "parameters" (lengths, masses).
        values: numbers that symbols stand for, where lengths="symbols" put them in.
        row_names, column_names: of the matrix; () where it has none.
        factors: of a determinant, with multiplicities; the first is what does not depend on the joints.
        operations: of the expression, nothing shared; `generate_code` shares what occurs twice.
        question: what was asked.

    Example:
        >>> import kinestatics as ks
        >>> form = ks.closed_form("determinant", ks.load("planar_2r"), lengths="symbols")
        >>> form.expression, form.values
        (a1**2*sin(q2), {a1: 1})
    """

    quantity: str
    robot: str
    link: str
    expression: Any
    frame: Frame | None
    where: str
    symbols: Mapping[str, tuple[Any, ...]]
    values: Mapping[Any, Any]
    row_names: tuple[str, ...]
    column_names: tuple[str, ...]
    factors: tuple[tuple[Any, int], ...]
    operations: int
    question: Question = field(repr=False)

    @property
    def entries(self) -> list[tuple[str, Any]]:
        """(label, expression) of every entry that is not zero; the label is empty for a single expression."""
        if not hasattr(self.expression, "shape"):
            return [("", self.expression)]
        rows, columns = self.row_names or ("",) * self.expression.rows, self.column_names or ("",) * self.expression.cols
        return [
            (", ".join(filter(None, (row, column))), self.expression[i, j])
            for i, row in enumerate(rows)
            for j, column in enumerate(columns)
            if self.expression[i, j] != 0
        ]

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        """Every entry that is not zero on a line of its own; numbers to 6 digits."""
        words = self.quantity.replace("_", " ")
        where = f", {self.where}" if self.where else ""
        lines = [wrapped("", f"{words} of {self.link} of {self.robot}{where} ({self.operations} operations)", hang=2)]
        entries = self.entries
        for label, expression in entries:
            lines.append(wrapped(f"  {label + ' = ' if label else ''}", rounded_text(expression), hang=2))
        if not entries:
            lines.append("  0")
        elif hasattr(self.expression, "shape") and len(entries) < len(self.expression):
            lines.append("  all other entries are 0")
        if self.values:
            lines.append(wrapped("with ", ", ".join(f"{x} = {float(v):.6g}" for x, v in self.values.items())))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; expressions as text that SymPy reads."""
        matrix = hasattr(self.expression, "shape")
        found = [[str(x) for x in row] for row in self.expression.tolist()] if matrix else str(self.expression)
        return {
            "quantity": self.quantity,
            "robot": self.robot,
            "link": self.link,
            "expression": found,
            "rows": list(self.row_names),
            "columns": list(self.column_names),
            "frame": None if self.frame is None else self.frame.to_dict(),
            "where": self.where,
            "symbols": {kind: [str(x) for x in several] for kind, several in self.symbols.items()},
            "values": {str(x): float(v) for x, v in self.values.items()},
            "factors": [{"expression": str(x), "multiplicity": times} for x, times in self.factors],
            "operations": self.operations,
        }


def closed_form(
    quantity: str,
    model: RobotModel,
    *,
    at: str = TIP,
    point: Sequence[Any] | None = None,
    frame: Frame | str = "auto",
    task: str | Sequence[str] | Sequence[int] | None = None,
    qd: Sequence[Any] | None = None,
    qdd: Sequence[Any] | None = None,
    wrench: Wrench | Sequence[Any] | None = None,
    gravity: Sequence[Any] | None = None,
    lengths: str = "numbers",
) -> ClosedForm:
    """A quantity of a robot as a short exact expression in its joints, and in whatever symbols its description holds.

    Args:
        quantity: "pose" (4, 4) of a link; "jacobian" (6, n) of a link; "velocity" (6) J q̇; "acceleration" (6) J q̈ + J̇ q̇;
            "gravity_torques" (n) that hold the arm's weight; "joint_torques" (n) Jᵀ w; "determinant" of the rows of a task;
            "minors", all the largest ones of a task whose Jacobian is not square.
        model: a robot of numbers (taken by `ks.exact`; of one with more than three general angles, such as a calibrated
            one, with rotations of fractions, and numbers of 17 digits) or of symbols.
        at: link, default the tip.
        point: (3) of that link, in its axes [m]; numbers or symbols.
        frame: axes and origin of the rows, as in `ks.jacobian`. "auto": a Jacobian in the frame that makes it shortest, of
            base, link and the links between; a determinant that is the same in every frame in that of a middle joint; all
            else in the geometric frame, Frame("base", at).
        task: rows, as in `ks.find_task`; default all six, for determinants and minors "auto".
        qd, qdd: (n) rates and accelerations, numbers or polynomials of symbols; default symbols qd1, qdd1, ...
        wrench: (6) at the frame's origin in its axes, on the environment, numbers or symbols, default fx ... mz; or a
            Wrench, whose side decides the sign and whose frame must be that of the rows.
        gravity: (3) in base axes, numbers or symbols [m/s²]; default (0, 0, -9.81).
        lengths: "numbers" as they are, or "symbols" a2, d4, ... in their place, with `values` that say what they are.

    Returns:
        ClosedForm.

    Raises:
        UnknownNameError: KS393, no such quantity; KS310, no such link; KS318, no such row.
        ConfigurationError: KS391, screw joints and broken ratios; KS393, an option that the quantity does not take; KS394, a
            determinant of a Jacobian that is not square; KS303, wrong shapes.
        ArrayTypeError: KS390, lengths or angles that are no polynomials.
        MissingMassError: KS320. FrameMismatchError: KS330. MissingExtraError: KS400.

    Law: the expression at numbers is what `ks.pose`, `ks.jacobian`, `ks.acceleration`, `ks.gravity_torques`,
    `ks.joint_torques` give. Source: note 004 for a = jacobian(v, q̇) q̈ + jacobian(v, q) q̇; note 000 for gravity and Jᵀ w.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.closed_form("determinant", ks.load("planar_2r"), lengths="symbols"))
        determinant of tip of planar_2r, rows vx, vy, axes of base, at the origin of tip
          (3 operations)
          a1**2*sin(q2)
        with a1 = 1
    """
    require_model(model)
    sympy_module()
    given = {"point": point, "task": task, "qd": qd, "qdd": qdd, "wrench": wrench, "gravity": gravity}
    given["frame"] = None if isinstance(frame, str) and frame == "auto" else frame
    check_options(quantity, given, lengths)
    if quantity == "gravity_torques":
        require_masses(model)
    question = asked(quantity, exact(model), model, at, given)
    if len(question.mechanism.ring.constants) > MOST_KEPT and not model.is_symbolic:
        question = asked(quantity, exact(model, angles=FRACTIONS), model, at, given)
    if lengths == "symbols":
        question = replace(question, mechanism=question.mechanism.named())
    return _form_of(ANSWERS[quantity](question))


def _form_of(answer: Answer) -> ClosedForm:
    import sympy

    question, expression = answer.question, answer.expression
    symbols = _symbols(question, expression.free_symbols)
    return ClosedForm(
        question.quantity,
        question.model.name,
        question.link,
        expression,
        answer.frame,
        answer.where,
        symbols,
        {x: v for x, v in question.mechanism.values.items() if x in expression.free_symbols},
        tuple(answer.rows),
        tuple(answer.columns),
        answer.factors,
        int(sympy.count_ops(expression)),
        question,
    )


def _symbols(question: Question, found: set[Any]) -> dict[str, tuple[Any, ...]]:
    """The symbols of an expression by kind: all joints, and what else occurs."""
    symbols = {"joints": tuple(question.mechanism.ring.joints)}
    used = [("rates", question.qd), ("accelerations", question.qdd), ("wrench", question.wrench)]
    for kind, several in used:
        if found & set(several) and len({x for x in several if x.is_Symbol}) == len(several):
            symbols[kind] = tuple(several)
    known = {x for several in symbols.values() for x in several}
    if rest := tuple(sorted(found - known, key=str)):
        symbols["parameters"] = rest
    return symbols


__all__ = ["QUANTITIES", "ClosedForm", "closed_form"]
