"""How near to singular the last motion was: measures against the postures on the way."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..palette import FORCE, VELOCITY
from .session import Session

_SHOWN = 300


class MotionPlot:
    """Two curves over the last postures."""

    def __init__(self, gui: Any, session: Session) -> None:
        from viser import uplot

        self._session = session
        zero = np.zeros(1)
        scales: Any = {"x": {"time": False}, "y": {"range": (0.0, 1.0)}}
        series = (
            uplot.Series(label="posture"),
            uplot.Series(label="least / largest singular value", stroke=VELOCITY, width=2),
            uplot.Series(label="manipulability / its largest here", stroke=FORCE, width=2),
        )
        self.plot = gui.add_uplot((zero, zero, zero), series, scales=scales, aspect=1.5)
        gui.add_button("begin a new motion", hint="forgets the curves").on_click(lambda _event: self._clear())

    def _clear(self) -> None:
        with self._session.lock:
            last = self._session.history[-1]
            self._session.history.clear()
            self._session.history.append(last)
        self.write()

    def write(self) -> None:
        """Curves of the last postures."""
        samples = list(self._session.history)[-_SHOWN:]
        values = np.array([(sample.number, sample.least, sample.manipulability) for sample in samples])
        values[:, 2] /= values[:, 2].max() or 1.0
        self.plot.data = tuple(np.ascontiguousarray(column) for column in values.T)
