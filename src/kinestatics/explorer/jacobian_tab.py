"""The Jacobian as a live table, in a chosen frame."""

from __future__ import annotations

from typing import Any

from ..frames import Frame
from .session import Session
from .tables import jacobian

FRAMES = {
    "axes of base, at the tip (geometric)": None,
    "axes of the tip, at the tip (body)": Frame.body(),
    "axes of base, at its origin (spatial)": Frame.spatial(),
}


class JacobianTab:
    """J of the tip."""

    def __init__(self, gui: Any, session: Session) -> None:
        self._session = session
        self.frame = gui.add_dropdown("frame", tuple(FRAMES), hint="the same motion, written in other axes at another point")
        self.table = gui.add_html("")
        self.frame.on_update(lambda _event: self.write())

    def write(self) -> None:
        """The table to the posture."""
        a = self._session.analysis
        frame = FRAMES[self.frame.value]
        J = a.jacobian if frame is None else a.jacobian.change_frame(frame)
        self.table.content = jacobian(J, a)
