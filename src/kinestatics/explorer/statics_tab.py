"""A wrench at the tip, a payload, the mount; and bars of the torques that hold them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..errors import KinestaticsError
from .session import LOAD, PUSH, Session
from .tables import torques

_MOUNTS = ("floor", "wall", "ceiling")


class StaticsTab:
    """What the arm carries and what carrying it takes."""

    def __init__(self, gui: Any, session: Session, attempt: Callable[[Callable[[], None]], None]) -> None:
        self._session = session
        s = session.situation
        self._shown = s.asked
        self.acts = gui.add_dropdown("wrench is", (LOAD, PUSH), initial_value=s.acts)
        self.force = gui.add_vector3("force [N]", s.force, step=0.1, hint="at the origin of the tip, along the axes of base")
        self.torque = gui.add_vector3("torque [N m]", s.torque, step=0.01, hint="axes of base")
        self.mass = gui.add_number("payload [kg]", s.mass, min=0.0, step=0.1, hint="a point mass that the tip holds")
        self.center = gui.add_vector3("its centre [m]", s.center, step=0.001, hint="in axes of the tip, from its origin")
        mounts = _MOUNTS if s.mount in _MOUNTS else ("as given", *_MOUNTS)
        self._given = s.mount
        self.mount = gui.add_dropdown(
            "base stands on", mounts, initial_value=mounts[0] if s.mount not in mounts else s.mount
        )
        for handle in (self.acts, self.force, self.torque, self.mass, self.center, self.mount):
            handle.on_update(lambda event: attempt(self._asked) if event.client_id is not None else None)
        self.table = gui.add_html("")

    def _asked(self) -> None:
        """The situation to the inputs; these may be farther already when the page is refreshed, and are left alone."""
        with self._session.lock:
            mount = self.mount.value
            what: dict[str, Any] = {
                "force": tuple(self.force.value),
                "torque": tuple(self.torque.value),
                "acts": self.acts.value,
                "mass": self.mass.value,
                "center": tuple(self.center.value),
                "mount": self._given if mount == "as given" else mount,
            }
            self._shown = replace(self._session.situation, **what).asked
            try:
                self._session.change(**what)
            except (KinestaticsError, ArithmeticError):
                self._show()  # what was refused does not stay in the boxes
                raise

    def refresh(self) -> None:
        """Inputs to the situation."""
        if self._session.situation.asked != self._shown:
            self._show()

    def _show(self) -> None:
        s = self._session.situation
        self._shown = s.asked
        self.force.value, self.torque.value, self.acts.value = s.force, s.torque, s.acts
        self.mass.value, self.center.value = s.mass, s.center
        self.mount.value = s.mount if s.mount in _MOUNTS else "as given"

    def write(self) -> None:
        """Bars of the torques."""
        self.table.content = torques(self._session.analysis)
