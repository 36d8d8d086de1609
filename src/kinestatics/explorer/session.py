"""What the page is about: a posture, a load, a payload, a mount; and the analysis of them. Knows nothing of pages."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from ..analysis import Analysis, analyze
from ..dexterity import Polytope, force_polytope, velocity_polytope
from ..errors import KinestaticsError
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Wrench
from ..statics import gravity_in_base

KEPT = 600
"""Postures of the last motion that are kept for its plot."""
PUSH, LOAD = "the robot pushes", "a load on the robot"
_UNDO = 50


@dataclass(frozen=True, eq=False)
class Situation:
    """What is asked about.

    Attributes:
        q: (n) [rad or m].
        force, torque: (3) of the wrench at the tip, axes of base [N, N m]; acts: PUSH or LOAD.
        mass: held at the tip [kg]; center: (3) of it, in axes of the tip [m].
        mount: how the base stands, a word of `gravity_in_base`, or (3) gravity in base axes [m/s²].
    """

    q: Array
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)
    acts: str = LOAD
    mass: float = 0.0
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mount: str | tuple[float, float, float] = "floor"

    @property
    def wrench(self) -> Wrench | None:
        """The wrench at the tip, or None where there is none."""
        if not any((*self.force, *self.torque)):
            return None
        make = Wrench.on_environment if self.acts == PUSH else Wrench.on_robot
        return make(force=self.force, torque=self.torque)

    @property
    def asked(self) -> tuple[Any, ...]:
        """Everything but the posture."""
        return self.force, self.torque, self.acts, self.mass, self.center, self.mount

    @property
    def gravity(self) -> Array:
        """(3) in base axes [m/s²]."""
        return gravity_in_base(self.mount) if isinstance(self.mount, str) else np.array(self.mount)


@dataclass(frozen=True)
class Sample:
    """Of one posture of a motion: which, the smallest singular value over the largest, and manipulability."""

    number: int
    least: float
    manipulability: float


class Session:
    """One robot that several pages may look at. `change` is the only way in; listeners are told after it.

    Attributes:
        model: the robot as it was given; situation: what is asked about; analysis: the answer, brief.
        history: samples of the last motion, the oldest first.
    """

    def __init__(self, model: RobotModel, situation: Situation) -> None:
        self.model, self.situation = model, situation
        self.lock = threading.RLock()
        self.history: deque[Sample] = deque(maxlen=KEPT)
        self._before: deque[Array] = deque(maxlen=_UNDO)
        self._listeners: list[Callable[[], None]] = []
        self._carrying: tuple[Any, RobotModel] = ((0.0, situation.center), model)
        self.analysis = self._analyzed()
        self._remember()

    def listen(self, listener: Callable[[], None]) -> None:
        """Calls a function after every change."""
        self._listeners.append(listener)

    def change(self, *, undo: bool = True, **what: Any) -> None:
        """Replaces parts of the situation, and analyses it anew; nothing is changed where that fails.

        Args:
            undo: whether a step back comes to the posture before; postures on the way of a motion are not kept.
            what: attributes of `Situation`. q is kept inside the position limits.
        """
        with self.lock:
            before, was = self.situation, self.analysis
            if "q" in what:
                what["q"] = self.inside(what["q"])
            self.situation = replace(before, **what)
            try:
                self.analysis = self._analyzed()
            except (KinestaticsError, ArithmeticError):
                self.situation, self.analysis = before, was
                raise
            if "q" in what:
                if undo and not np.array_equal(before.q, self.situation.q):
                    self._before.append(before.q)
                self._remember()
            for listener in self._listeners:
                listener()

    def inside(self, q: Any) -> Array:
        """q (n) with every joint at its limit where it was beyond."""
        return np.clip(np.array(q, dtype=np.float64), self.model.lower, self.model.upper)

    def mark(self) -> None:
        """Makes the present posture one that `back` comes to: before a motion of many postures."""
        with self.lock:
            self._before.append(self.situation.q)

    def back(self) -> bool:
        """One posture back; whether there was one."""
        with self.lock:
            if not self._before:
                return False
            self.change(undo=False, q=self._before.pop())
            return True

    @property
    def carrying(self) -> RobotModel:
        """The robot with its payload."""
        s = self.situation
        key = (s.mass, s.center)
        if self._carrying[0] != key:
            held = self.model
            if s.mass > 0:
                names = (f"payload{k or ''}" for k in count())  # a robot may come with payloads of its own
                name = next(name for name in names if name not in held.link_names)
                held = held.with_payload(s.mass, s.center, name=name)
            self._carrying = (key, held)
        return self._carrying[1]

    def whole_analysis(self, singularities: bool = True) -> Analysis:
        """The same situation with everything an analysis can say: for a report."""
        s = self.situation
        return analyze(self.carrying, s.q, s.wrench, gravity=s.gravity, singularities=singularities)

    def polytopes(self, velocity: bool, force: bool) -> tuple[Polytope | None, Polytope | None, tuple[str, ...]]:
        """The polytopes of the linear rows in play, and why one cannot be had."""
        rows = [row for row in self.analysis.task.row_names if row.startswith("v")]
        s, notes = self.situation, []
        found: list[Polytope | None] = [None, None]
        if velocity and rows:
            try:
                found[0] = velocity_polytope(self.model, s.q, task=rows)
            except KinestaticsError as error:
                notes.append(f"no polytope of velocities: {error.message}")
        if force and rows:
            try:
                found[1] = force_polytope(self.carrying, s.q, task=rows, gravity=s.gravity if self._heavy else None)
            except KinestaticsError as error:
                notes.append(f"no polytope of forces: {error.message}")
        return found[0], found[1], tuple(notes)

    @property
    def _heavy(self) -> bool:
        return self.carrying.has_masses

    def _analyzed(self) -> Analysis:
        s = self.situation
        return analyze(self.carrying, s.q, s.wrench, gravity=s.gravity, brief=True)

    def _remember(self) -> None:
        a = self.analysis
        sigma = a.singular_values
        least = float(sigma[a.task.rank - 1] / sigma[0]) if a.task.rank and sigma[0] > 0 else 0.0
        number = self.history[-1].number + 1 if self.history else 0
        self.history.append(Sample(number, least, a.manipulability if not a.is_singular else 0.0))
