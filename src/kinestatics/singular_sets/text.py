"""A singular set as text, and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..quantities import format_number, wrapped
from ..symbolic.writer import rounded_text
from .components import Component

if TYPE_CHECKING:
    from .singular_set import SingularSet

_ROUNDING = 1e-9  # of a residual
_READABLE = 2000  # characters of a determinant


def data_of(found: SingularSet) -> dict[str, Any]:
    """Plain data for JSON."""
    return {
        "robot": found.model.name,
        "link": found.link,
        "rows": list(found.task.row_names),
        "rank": found.task.rank,
        "determinant": None if found.determinant is None else str(found.determinant),
        "factors": [
            {"expression": str(e.expression), "joints": list(e.joints), "multiplicity": m, "real": e.real}
            for e, m in found.factors
        ],
        "components": [component.to_dict() for component in found.components],
        "complete": found.complete,
        "lengths": {str(symbol): float(value) for symbol, value in found.lengths.items()},
        "residual": found.residual,
    }


def text_of(found: SingularSet) -> str:
    """As it prints."""
    lines = [f"singularities of {found.model.name!r}: {', '.join(found.task.row_names)} (rank {found.task.rank})"]
    if found.constant is not None:
        short = not any(equation.long for equation, _ in found.factors)
        lines += (
            wrapped("det J = ", rounded_text(found.determinant)).splitlines()
            if short and len(str(found.determinant)) < _READABLE
            else ["det J: too long to print; it is .determinant, and .fourier in numbers"]
        )
    if not found.components:
        lines.append("never singular" if found.never else "no real component was found; that there is none is not proved")
    for component in found.components:
        lines += _lines_of(component)
    for equation, _ in found.factors:
        if equation.real is False:
            lines.append(f"  void: {equation.shown} = 0 has no real zeros")
        elif equation.real is None:
            lines.append(f"  not decided: whether {equation.shown} = 0 has real zeros")
    if not found.complete:
        message = f"time ran out before all {len(found.candidates)} candidates were split and looked at"
        lines += wrapped("  not complete: ", f"{message}; there may be more than stands above (budget=)").splitlines()
    if not found.lengths and any(equation.long for equation, _ in found.factors):
        lines.append("  of a calibrated robot, singularities(arm, tolerance=0.01) finds the nominal form")
    if found.lengths:
        named = ", ".join(f"{symbol} = {float(value):g}" for symbol, value in found.lengths.items())
        lines += wrapped("  with ", f"{named} m").splitlines()
    if found.residual > _ROUNDING:
        lines.append(f"  nominal: the robot's own Jacobian differs by up to {format_number(found.residual)} of its reach")
    return "\n".join(lines)


def _lines_of(component: Component) -> list[str]:
    taken = f"takes {component.codimension}" if component.codimension else "codimension not found"
    limits = {True: "", False: "; outside the joint limits", None: "; not seen inside the joint limits"}
    tail = f"{component.verified}{limits[component.within_limits]}"
    head = wrapped("  ", f"{component.name}: {component.text()}", 4).splitlines()
    return head + wrapped("      ", f"rank {component.rank}, {taken}; {tail}").splitlines()
