"""Sliders for the joints, buttons that change the whole posture, and bars of the singular values."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..namespaces import Array
from .session import Session
from .tables import singular_values
from .words import shown_name

STEP = 1e-3
"""Step of a slider [rad or m]; the posture itself is not rounded to it."""
_TURN = np.pi  # where a joint without limits is cut [rad]


class JointsTab:
    """A slider for each joint, in the order of q."""

    def __init__(self, gui: Any, session: Session, seed: int = 0) -> None:
        self._session, self._rng = session, np.random.default_rng(seed)
        self._source: int | None = None
        model, q = session.model, session.situation.q
        self._ranges = slider_ranges(model.lower, model.upper, q)
        self.sliders = []
        for k, (name, kind) in enumerate(zip(model.joint_names, model.joint_kinds, strict=True)):
            low, high = self._ranges[k]
            unit = "m" if kind == "prismatic" else "rad"
            slider = gui.add_slider(
                f"{k + 1} {shown_name(name, 22)} [{unit}]",
                min=low,
                max=high,
                step=STEP,
                initial_value=_on_step(q[k], low, high),
                hint=f"{shown_name(name)}, {kind}, from {low:g} to {high:g} {unit}",
            )
            slider.on_update(self._moved(k))
            self.sliders.append(slider)
        self._buttons(gui)
        self.values = gui.add_html("")

    def _buttons(self, gui: Any) -> None:
        chosen = gui.add_button_group("posture", ("home", "zero", "random", "back"), hint="goes to a posture; back undoes")
        chosen.on_click(lambda event: self._go(event.target.value))

    def _go(self, word: str) -> None:
        session = self._session
        if word == "back":
            session.back()
            return
        lower, upper = np.array(self._ranges).T
        if word == "random":
            session.change(q=self._rng.uniform(lower, upper))
        else:
            session.change(q=session.model.home if word == "home" else np.zeros(session.model.n))

    def _moved(self, k: int) -> Any:
        """What a slider does: it sets its own joint, and leaves the others as exact as they are."""

        def moved(event: Any) -> None:
            if event.client_id is None:  # set by us, to follow the posture
                return
            with self._session.lock:
                q = self._session.situation.q.copy()
                if _on_step(q[k], *self._ranges[k]) == event.target.value:
                    return
                q[k] = event.target.value
                self._source = k
                try:
                    self._session.change(q=q)
                finally:
                    self._source = None

        return moved

    def refresh(self) -> None:
        """Sliders to the posture, but for the one that a reader moves: it may be farther already than what is shown here."""
        for k, (slider, x) in enumerate(zip(self.sliders, self._session.situation.q, strict=True)):
            if k != self._source:
                slider.value = _on_step(x, *self._ranges[k])

    def write(self) -> None:
        """Bars of the singular values."""
        self.values.content = singular_values(self._session.analysis)


def slider_ranges(lower: Array, upper: Array, q: Array) -> list[tuple[float, float]]:
    """Where sliders begin and end: at the limits; a joint without them is cut at half a turn, or where q needs more."""
    found = []
    for low, high, x in zip(lower, upper, q, strict=True):
        first = float(low) if np.isfinite(low) else min(-_TURN, float(x))
        last = float(high) if np.isfinite(high) else max(_TURN, float(x))
        found.append((first, last if last > first else first + STEP))
    return found


def _on_step(x: float, low: float, high: float) -> float:
    """A value that the slider can show: on its step, inside its range."""
    return float(np.clip(round(round(float(x) / STEP) * STEP, 6), low, high))
