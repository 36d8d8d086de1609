"""The page: the scene, the line that says what is the case, and tabs. It renders a session, and asks it for changes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

from ..errors import KinestaticsError
from ..scene.arm_scene import ArmScene, fitting_scale, fitting_view
from ..scene.solids import Solid
from .files_tab import FilesTab
from .jacobian_tab import JacobianTab
from .joints_tab import JointsTab
from .motion_plot import MotionPlot
from .session import Session
from .singular_tab import SingularTab
from .statics_tab import StaticsTab
from .tables import STYLE, ready, verdict
from .tool import Tool
from .view_tab import ViewTab
from .words import shown_name
from .worker import LatestWorker


class Page:
    """A page on a server of viser; everyone who opens it sees, and moves, the same arm.

    Attributes:
        session: what it is about; scene: the arm; tool: the gizmo; motion: the plot.
        joints, statics, singular, jacobian, view, files: the tabs.
    """

    def __init__(self, server: Any, session: Session, solids: Sequence[Solid], seed: int = 0) -> None:
        self.server, self.session = server, session
        self._words, self._drawing = "", threading.RLock()
        gui = server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large", brand_color=(0, 114, 178))
        gui.main_panel.dock_right()
        gui.set_panel_label(shown_name(session.model.name))
        self.scene = ArmScene(server, session.model, solids)
        gui.add_html(STYLE)
        self.verdict = gui.add_html("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Joints"):
            self.joints = JointsTab(gui, session, seed)
            self.motion = MotionPlot(gui, session)
        with tabs.add_tab("Statics"):
            self.statics = StaticsTab(gui, session, self.attempt)
        with tabs.add_tab("Singular"):
            self.singular = SingularTab(gui, session, self.attempt, self.tell)
            self.singular.changed = self._say
        with tabs.add_tab("Jacobian"):
            self.jacobian = JacobianTab(gui, session)
        with tabs.add_tab("View"):
            view = fitting_view(session.analysis, self.scene.size)
            self.view = ViewTab(gui, self.scene.body.has_solids, view, self.draw, self._fit)
        with tabs.add_tab("Files"):
            self.files = FilesTab(gui, session, self.attempt, self.tell, self.scene_html, self.report_html)
        self.tool = Tool(server, session, self.scene.size, self.scene.plane, self.tell)
        self.writer = LatestWorker("kinestatics words", lambda error: self.tell(f"{type(error).__name__}: {error}"))
        session.listen(self.refresh)
        self.refresh()
        gui.add_html(ready())  # the last message: a client that shows it has shown all the others

    def attempt(self, action: Callable[[], None]) -> None:
        """Does what a reader asked for; what goes wrong is said on the page, and nothing is changed."""
        try:
            action()
        except (KinestaticsError, ArithmeticError, ValueError) as error:
            self.tell(str(error))

    def tell(self, words: str) -> None:
        """Says something in the line at the top."""
        self._words = words
        self._say()

    def refresh(self) -> None:
        """The arm, its signs and the verdict at once, in one batch; the tables when the writer comes to them."""
        with self._drawing, self.server.atomic():
            self._words = ""
            self.joints.refresh()
            self.statics.refresh()
            self.singular.refresh()
            self.tool.refresh()
            self._say()
            self.draw()
        self.writer.ask(self._write, quiet=0.0)

    def _write(self) -> None:
        """The tables and the plot; of postures that follow each other fast, those of the last."""
        with self.server.atomic():
            self.joints.write()
            self.statics.write()
            self.jacobian.write()
            self.motion.write()

    def draw(self) -> None:
        """The scene, as the choices of the view say."""
        view = self.view.view
        velocity, force, notes = self.session.polytopes(view.velocity == "polytope", view.force == "polytope")
        with self._drawing:
            self.scene.update(self.session.analysis, view, (velocity, force))
        if notes:
            self.tell("; ".join(notes))

    def _fit(self, kind: str, shape: str) -> float:
        """The scale at which a body of the present posture is well seen."""
        a, polytope = self.session.analysis, shape == "polytope"
        velocity, force, _ = self.session.polytopes(polytope and kind == "velocity", polytope and kind == "force")
        ellipsoid = a.velocity_ellipsoid if kind == "velocity" else a.force_ellipsoid
        return fitting_scale((velocity or force) if polytope else ellipsoid, self.scene.size)

    def close(self) -> None:
        """Ends what runs beside the page."""
        for worker in (self.singular.worker, self.tool.worker, self.writer):
            worker.stop()

    def scene_html(self) -> str:
        """The scene as it is seen, in one file that needs no server."""
        return self.server.get_scene_serializer().as_html()

    def report_html(self) -> str:
        """A report of the present situation."""
        return self.session.whole_analysis().to_html()

    def _say(self) -> None:
        with self._drawing:
            self.verdict.content = verdict(self.session.analysis, self.singular.near, self._words)
