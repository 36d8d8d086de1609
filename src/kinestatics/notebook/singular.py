"""A singular set: its determinant, its components by name with their conditions, and a posture on each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..namespaces import Array
from ..quantities import format_number
from ..report.blocks import Html, Part, bullets, escaped, paragraph, table, tag, with_minus
from ..singular_sets import SingularSet
from ..singular_sets.components import Component
from ..singular_sets.equations import Equation
from ..symbolic.writer import rounded_text
from .frame import formula, head
from .quantities import legend
from .robot import thumbnail

_MOST_PICTURES = 3
_MOST_COMPONENTS = 12
_READABLE = 260  # characters of LaTeX in a cell
_ROUNDING = 1e-9  # of a residual
_WITHIN = {True: "inside", False: "outside", None: "not seen inside"}


def singular_set_body(found: SingularSet) -> Html:
    """A singular set."""
    rows = ", ".join(found.task.row_names)
    title = head(f"Singularities of {found.model.name}", f"rank of {rows} below {found.task.rank}")
    notes = bullets(_notes(found), kind="facts")
    return escaped([title, _determinant(found), _table(found), legend(found.lengths), _pictures(found), notes])


def _determinant(found: SingularSet) -> Html | None:
    if found.constant is None:
        return None
    from ..symbolic.latex import to_latex

    if any(equation.long for equation, _ in found.factors):
        return paragraph("det J is too long to show; it is ", tag("code", ".determinant"), kind="soft")
    return formula(rf"\det J = {to_latex(found.determinant)}", lambda: f"det J = {rounded_text(found.determinant)}", True)


def _table(found: SingularSet) -> Html:
    if not found.components:
        sure = "never singular" if found.never else "no real component was found; that there is none is not proved"
        return paragraph(sure)
    rows = [
        [component.name, _conditions(component), _rank(component), _WITHIN[component.within_limits], component.verified]
        for component in found.components[:_MOST_COMPONENTS]
    ]
    columns = ["Name", "Where", "Rank there", "Joint limits", "Samples"]
    return table("Components: where all conditions of one hold, rank is lost", columns, rows)


def _conditions(component: Component) -> Html:
    """Its equations, one below the other."""
    more = f"and {len(component.others)} products of factors that were not split" if component.others else None
    lines = [_equation(equation, "and " if k else "") for k, equation in enumerate(component.equations)]
    return escaped([tag("div", line) for line in (*lines, more) if line])


def _equation(equation: Equation, before: str) -> list[Part]:
    """An equation, with the values of its joint where it is of one alone; a long one is folded."""
    from ..symbolic.latex import to_latex

    latex = "" if equation.long else to_latex(equation.expression)
    if not latex or len(latex) > _READABLE:
        words = f"{before}a condition on {', '.join(equation.joints)}"
        return [tag("details", tag("summary", words), tag("code", equation.text()))]
    return [before, formula(f"{latex} = 0", lambda: f"{equation.shown} = 0"), tag("span", _values(equation), class_="soft")]


def _values(equation: Equation) -> str:
    """At which values of its one joint it holds."""
    if not equation.solutions:
        return "" if equation.solutions is None else " (no solution was found)"
    k = equation.columns[0]
    turns = equation.space.half.ring.turns[k]
    shown = (f"{format_number(np.degrees(x))}°" if turns else f"{format_number(x)} m" for x in equation.solutions)
    return with_minus(f"  at {', '.join(shown)}")


def _rank(component: Component) -> str:
    taken = f"takes {component.codimension}" if component.codimension else "codimension not found"
    return f"{component.rank}, {taken}"


def _pictures(found: SingularSet) -> Html | None:
    """The arm at a posture on each of the first components."""
    made: list[Html | None] = []
    for component in found.components[:_MOST_PICTURES]:
        if (q := _posture_on(component, found.model.home)) is not None:
            caption = f"{component.label}: a posture on it"
            made.append(thumbnail(found.model, q, found.link, caption, numbers=False))
    drawn = [picture for picture in made if picture]
    return tag("div", drawn, class_="pictures") if drawn else None


def _posture_on(component: Component, home: Array) -> Array | None:
    """A posture on a component: where steps from home arrive, else one of its samples."""
    q, arrived = component.projected(home[None])
    if arrived[0]:
        return q[0]
    return component.points[0] if len(component.points) else None


def _notes(found: SingularSet) -> Iterator[Part]:
    if len(found.components) > _MOST_COMPONENTS:
        yield f"{len(found.components) - _MOST_COMPONENTS} more components are not shown: print it"
    for equation, _ in found.factors:
        if equation.real is False:
            yield f"void: {equation.shown} = 0 has no real zeros"
        elif equation.real is None:
            yield f"not decided: whether {equation.shown} = 0 has real zeros"
    if not found.complete:
        message = f"time ran out before all {len(found.candidates)} candidates were split and looked at"
        yield f"not complete: {message}; there may be more than stands above (budget=)"
    if not found.lengths and any(equation.long for equation, _ in found.factors):
        yield "of a calibrated robot, singularities(arm, tolerance=0.01) finds the nominal form"
    if found.residual > _ROUNDING:
        yield f"nominal: the robot's own Jacobian differs by up to {format_number(found.residual)} of its reach"
