"""Where the singularities of the arm are, how far from a posture, and what it is itself; a note where they are not found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import KinestaticsError
from ..model import RobotModel
from ..namespaces import Array
from ..tasks import Task

if TYPE_CHECKING:
    from ..singular_sets import SingularSet
    from ..singular_sets.card import Card

_BUDGET = 5.0
NEAR_SINGULARITY = 0.1
"""A posture closer to a singular one than this, in joint space [rad, and m where joints slide], is near it."""
NEAR_EFFORT = 0.9
"""A joint that needs more than this share of its effort limit is near it."""


def singular_here(
    model: RobotModel, q: Array, task: Task, at: str, notes: list[str]
) -> tuple[SingularSet | None, Card | None]:
    """The singular set, and the card of a posture, whose `near` are the distances; None, and a note, where there is none."""
    try:
        from ..singular_sets import singularities

        if not task.rank:
            return None, None
        found = singularities(model, task.row_names, at=at, budget=_BUDGET)
        card = found.at(q)
    except KinestaticsError as error:
        notes.append(f"singularities were not looked for: {error.message}" + (f" ({error.hint})" if error.hint else ""))
        return None, None
    if not found.complete:
        notes.append("time ran out: there may be nearer singularities (`ks.singularities` with a larger budget)")
    if found.residual > 1e-9:
        notes.append(f"singularities are those of the nominal robot, whose Jacobian differs by {found.residual:.1e}")
    return found, card
