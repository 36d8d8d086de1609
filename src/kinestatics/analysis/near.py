"""How far the singularities of the arm are from a posture, by name; a note where they cannot be found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import KinestaticsError
from ..model import RobotModel
from ..namespaces import Array
from ..tasks import Task

if TYPE_CHECKING:
    from ..singular_sets.distance import Distance

_BUDGET = 5.0


def nearest_singularities(model: RobotModel, q: Array, task: Task, at: str, notes: list[str]) -> tuple[Distance, ...] | None:
    """Distances of a posture from the components of the singular set, the nearest first; None, and a note, without one."""
    try:
        from ..singular_sets import singularities

        if not task.rank:
            return ()
        found = singularities(model, task.row_names, at=at, budget=_BUDGET)
    except KinestaticsError as error:
        notes.append(f"singularities were not looked for: {error.message}" + (f" ({error.hint})" if error.hint else ""))
        return None
    if not found.complete:
        notes.append("time ran out: there may be nearer singularities (`ks.singularities` with a larger budget)")
    if found.residual > 1e-9:
        notes.append(f"singularities are those of the nominal robot, whose Jacobian differs by {found.residual:.1e}")
    return found.distance(q)
