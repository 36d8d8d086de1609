"""The exact Jacobian of a chain of joints, in the frame of a middle link, where its entries are shortest. Floor 7.

The determinant of a task that knows no direction (all six rows, position, orientation) is the same in every frame; the frame
of a middle link makes it a hundred times cheaper, since columns near to it depend on few joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..frames import TIP
from ..model import RobotModel
from ..spatial import LINEAR_ROWS
from .exact import exact
from .joints import Joint
from .mechanism import WHOLE_TASKS, Mechanism
from .poses import Pose, determinant
from .ring import Matrix, TrigonometricRing

_ORIGIN = (0, 0, 0)


@dataclass(frozen=True, eq=False)
class ExactChain:
    """The joints between the base and a link, exactly: one path of a mechanism.

    Attributes:
        mechanism: of these joints alone; link: index of the link.
    """

    mechanism: Mechanism
    link: int

    @classmethod
    def of(cls, model: RobotModel, at: str = TIP) -> ExactChain:
        """The chain from the base to a link.

        Raises:
            ConfigurationError: KS391 for a screw joint, a mimic joint whose ratio is no whole number, or a coordinate that
                turns one joint and slides another. ArrayTypeError: KS390.
        """
        model = model if model.is_symbolic else exact(model)
        link = model.link(at)
        return cls(Mechanism.of(model, [link], from_base=False), link)

    def named(self) -> ExactChain:
        """The same chain with symbols for its lengths, as `Mechanism.named`."""
        return ExactChain(self.mechanism.named(), self.link)

    @property
    def ring(self) -> TrigonometricRing:
        """The ring of the polynomials."""
        return self.mechanism.ring

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Base first."""
        return tuple(self.mechanism.joints[i] for i in self.mechanism.path(self.link))

    @property
    def end(self) -> Pose:
        """The link's frame seen from the last joint's."""
        return self.mechanism.links[self.link][1]

    @property
    def columns(self) -> int:
        """Number of columns of the Jacobian."""
        return self.mechanism.model.n

    @property
    def lengths(self) -> Mapping[Any, Any]:
        """What the symbols that `named` put in place of numbers stand for [m]."""
        return self.mechanism.values

    def task_rows(self, rows: tuple[int, ...]) -> Matrix:
        """Rows of the Jacobian at the link's origin: in axes of a middle link where that leaves minors alone, else base."""
        mechanism, link = self.mechanism, self.link
        path = mechanism.path(link)
        if rows not in WHOLE_TASKS or not path:
            J = mechanism.jacobian(link, -1, mechanism.point(link, _ORIGIN, -1))
            return [J[r] for r in rows]
        middle = path[len(path) // 2]
        placed, before = mechanism.joints[middle].placed, mechanism.parents[middle]
        point = mechanism.point(link, _ORIGIN, before) if rows == LINEAR_ROWS else placed.p
        J = mechanism.jacobian(link, before, point, placed.R)
        return [J[r] for r in rows]


__all__ = ["ExactChain", "determinant"]
