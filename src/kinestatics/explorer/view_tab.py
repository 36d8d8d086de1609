"""What is seen in the scene, and at which scale."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..scene.arm_scene import SHAPES, View


class ViewTab:
    """Choices of what is shown; `view` is what they say."""

    def __init__(
        self, gui: Any, has_solids: bool, view: View, changed: Callable[[], None], fit: Callable[[str, str], float]
    ) -> None:
        self._has_solids = has_solids
        self.velocity = gui.add_dropdown(
            "velocity at the tip", SHAPES, initial_value=view.velocity, hint="of unit joint rates"
        )
        self.velocity_scale = gui.add_number(
            "scale [m per m/s]", view.velocity_scale, min=1e-4, max=1e3, step=1e-4, hint="metres of the scene per m/s"
        )
        self.force = gui.add_dropdown("force at the tip", SHAPES, initial_value=view.force, hint="of unit joint torques")
        self.force_scale = gui.add_number(
            "scale [m per N]", view.force_scale, min=1e-6, max=1e3, step=1e-6, hint="metres of the scene per newton"
        )
        self.solids = gui.add_checkbox("meshes", view.solids, visible=has_solids)
        self.axes = gui.add_checkbox("joint axes", view.axes)
        self.lost = gui.add_checkbox("lost motions", view.lost)
        self.free = gui.add_checkbox("wrenches held for free", view.free)
        self.load = gui.add_checkbox("load", view.load)
        self.velocity.on_update(self._chosen("velocity", self.velocity_scale, changed, fit))
        self.force.on_update(self._chosen("force", self.force_scale, changed, fit))
        for handle in (self.velocity_scale, self.force_scale, self.solids, self.axes, self.lost, self.free, self.load):
            handle.on_update(lambda _event: changed())

    @staticmethod
    def _chosen(kind: str, scale: Any, changed: Callable[[], None], fit: Callable[[str, str], float]) -> Any:
        """What a choice of shape does: a polytope has the limits of the joints, an ellipsoid has not, and is far smaller."""

        def chosen(event: Any) -> None:
            if event.target.value != "none":
                scale.value = fit(kind, event.target.value)
            changed()

        return chosen

    @property
    def view(self) -> View:
        """What is shown now."""
        return View(
            velocity=self.velocity.value,
            force=self.force.value,
            velocity_scale=self.velocity_scale.value,
            force_scale=self.force_scale.value,
            solids=self.solids.value,
            axes=self.axes.value,
            lost=self.lost.value,
            free=self.free.value,
            load=self.load.value,
        )
