"""The gizmo on the tip: dragged, and followed by resolved rate inside the position limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..inverse_velocity import move_tip
from ..namespaces import Array, as_array
from ..scene.placing import quaternions
from ..spatial import pose_matrix, quaternion_to_rotation
from .session import Session
from .worker import LatestWorker

_SCALE = 0.28  # of the arm's size
_STEPS, _LAST_STEPS = 40, 200  # of one pull: while it is dragged, the next pull goes on from there; and when it is let go


class Tool:
    """A handle on the tip that can be pulled and turned; a planar arm's stays in its plane.

    Attributes:
        motion: the last `TipMotion`, or None.
    """

    def __init__(self, server: Any, session: Session, size: float, plane: Array | None, told: Callable[[str], None]) -> None:
        self._server, self._session = server, session
        self.motion: Any = None
        rows = session.analysis.task.row_names
        self._turns = any(row.startswith("w") for row in rows) and plane is None
        moving = tuple(bool(plane is None or np.any(plane[:, k])) for k in range(3))
        self.handle = server.scene.add_transform_controls(
            "/tool",
            scale=_SCALE * size,
            line_width=3.5,
            active_axes=moving,
            disable_sliders=plane is not None,
            disable_rotations=not self._turns,
            depth_test=False,
        )
        self._held = False
        self.worker = LatestWorker("kinestatics tool", lambda error: told(f"{type(error).__name__}: {error}"))
        self.handle.on_update(self._pulled)

    def refresh(self) -> None:
        """Back onto the tip, unless somebody holds it."""
        if not self._held:
            pose = self._session.analysis.pose
            self.handle.wxyz, self.handle.position = quaternions(pose.rotation), pose.translation

    async def _pulled(self, event: Any) -> None:
        """Events of a drag arrive in order only where they are awaited; what takes time is left to the worker."""
        if event.phase == "start":
            self._session.mark()
        self._held = event.phase != "end"
        self.worker.ask(self._follow, quiet=0.0)

    def _follow(self) -> None:
        """The arm to where the handle is now; the handle back to the tip, once it has been let go."""
        with self._session.lock:
            most = _STEPS if self._held else _LAST_STEPS
            self.motion = move_tip(self._session.model, self._session.situation.q, self._target(), most_steps=most)
            self._session.change(undo=False, q=self.motion.q)

    def _target(self) -> Array:
        """(4, 4) where the handle is, in base axes."""
        R = quaternion_to_rotation(*map(float, self.handle.wxyz)) if self._turns else self._session.analysis.pose.rotation
        array, xp = as_array(R)
        return pose_matrix(array, np.array(self.handle.position, dtype=np.float64), xp)
