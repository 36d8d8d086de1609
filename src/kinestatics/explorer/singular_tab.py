"""Where the arm is singular, how far that is from here, the way there, and the motions that leave the tip where it is."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import KinestaticsError
from ..inverse_velocity import SelfMotion, self_motion
from ..namespaces import Array
from ..quantities import format_number
from ..singular_sets import SingularSet, singularities
from ..singular_sets.distance import Distance
from .session import Session
from .tables import card, nearest
from .words import shown_name
from .worker import LatestWorker

_BUDGET = 20.0  # s for redundant arms
_FRAMES, _PAUSE = 24, 0.025  # of the way to a singular posture, so that one sees what happens [s]
_ALONG, _STEP = 1.2, 0.02  # how far a null motion is followed each way, and how fine [rad or m]
NEAREST = "the nearest"


class SingularTab:
    """Distances by name, the way to a singular posture, null motions.

    Attributes:
        near: distances from the posture of the page, or None while they are being looked for; problem: why there are none.
    """

    def __init__(
        self, gui: Any, session: Session, attempt: Callable[[Callable[[], None]], None], told: Callable[[str], None]
    ) -> None:
        self._session, self._told = session, told
        self.near: tuple[Distance, ...] | None = None
        self.problem = ""
        self._found: SingularSet | None = None
        self._path: SelfMotion | None = None
        self._following = False
        self.changed: Callable[[], None] = lambda: None
        self.worker = LatestWorker("kinestatics singularities", lambda error: told(f"{type(error).__name__}: {error}"))
        self.list = gui.add_html("")
        self.which = gui.add_dropdown("singularity", (NEAREST,), hint="which one the button goes to")
        self.go = gui.add_button("go there", hint="moves the joints straight to the nearest posture of it")
        self.go.on_click(lambda _event: attempt(self._go))
        self.take = gui.add_button("take the null motion of this posture", hint="joint motion that leaves the tip at rest")
        self.take.on_click(lambda _event: attempt(self._take))
        self.direction = gui.add_number("null direction", 1, min=1, max=1, step=1, visible=False)
        self.along = gui.add_slider("along it [rad]", -_ALONG, _ALONG, _STEP, 0.0, disabled=True)
        self.along.on_update(lambda event: attempt(self._follow) if event.client_id is not None else None)
        self.ask_card = gui.add_button("describe this posture", hint="what is lost, what is held, wall or passage")
        self.ask_card.on_click(lambda _event: self.worker.ask(self._describe, quiet=0.0))
        self.card = gui.add_html("")
        self.list.content = nearest(None, "")
        self.worker.ask(self._look, quiet=0.0)

    def refresh(self) -> None:
        """Looks for distances anew once the posture has come to rest; a null motion belongs to the posture it began in."""
        if not self._following and self._path is not None:
            self._path = None
            self.along.disabled, self.along.value, self.direction.visible = True, 0.0, False
        if self.card.content:
            self.card.content = ""
        if self.problem:
            return
        if self.near is not None:  # else the list says already that it is being looked for
            self.near = None
            self.list.content = nearest(None, "")
        self.worker.ask(self._look)

    def _look(self) -> None:
        """Finds the singular set once, and how far the posture is from it."""
        if self._found is None:
            try:
                task = self._session.analysis.task
                self._found = singularities(self._session.model, task.row_names, budget=_BUDGET)
                names = dict.fromkeys(component.label for component in self._found.components)
                self.which.options = (NEAREST, *names)
            except KinestaticsError as error:
                self.problem = f"singularities were not looked for: {error.message}" + (
                    f" ({error.hint})" if error.hint else ""
                )
                self.near = ()
                self._show()
                return
        q = self._session.situation.q
        near = self._found.distance(q, within_limits=True)
        if np.array_equal(q, self._session.situation.q):  # else a newer question is on its way
            self.near = near
            self._show()

    def _show(self) -> None:
        self.list.content = nearest(self.near, self.problem)
        self.changed()

    def _go(self) -> None:
        if self._found is None:
            self._told(self.problem or "the singularities are still being looked for")
            return
        near = self._found.distance(self._session.situation.q, within_limits=True)
        if self.which.value != NEAREST:
            near = tuple(d for d in near if d.component.label == self.which.value)
        target = next((d for d in near if d.nearest is not None), None)
        if target is None:
            self._told("; ".join(map(str, near)) or "no singularity is known")
            return
        self._travel(np.asarray(target.nearest))
        self._told(f"{target.component.label}: it was {format_number(target.value)} away in joint space")

    def _travel(self, target: Array) -> None:
        """To a posture in steps that one can follow; the last is the posture itself."""
        self._session.mark()
        start = self._session.situation.q
        for share in np.linspace(0.0, 1.0, _FRAMES)[1:-1]:
            self._session.change(undo=False, q=start + share * (target - start))
            time.sleep(_PAUSE)
        self._session.change(undo=False, q=target)

    def _take(self) -> None:
        """The null motion of this posture, for the slider."""
        wanted = int(self.direction.value) - 1 if self.direction.visible else 0
        with self._session.lock:
            model, q = self._session.model, self._session.situation.q
            path = self_motion(model, q, direction=wanted, length=_ALONG, step=_STEP)
            self._session.mark()
            self._path = path
            self.direction.max, self.direction.visible = path.directions, path.directions > 1
            self.along.disabled, self.along.value = False, 0.0
            self._told(path.reason)

    def _follow(self) -> None:
        """The posture at the slider. Several events may come at once; the lock keeps each with the path it belongs to."""
        with self._session.lock:
            if self._path is None:
                return
            k = int(np.argmin(np.abs(self._path.s - self.along.value)))
            self._following = True
            try:
                self._session.change(undo=False, q=self._path.q[k])
            finally:
                self._following = False
            self._told(f"the tip is {self._path.held[k]:.2g} m from where it was")

    def _describe(self) -> None:
        if self._found is None:
            self._told(self.problem or "the singularities are still being looked for")
            return
        text = str(self._found.at(self._session.situation.q))
        self.card.content = card("\n".join(shown_name(line, 400) for line in text.splitlines()))
        self._look()  # this question may have taken the place of that one
