"""An arm, what it can do and what it has lost, in one scene: made once, then moved from analysis to analysis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis import Analysis
from ..dexterity import Ellipsoid, Polytope
from ..frames import Frame
from ..kinematics import pose
from ..model import RobotModel
from ..namespaces import Array
from ..palette import FORCE, VELOCITY
from ..six_vectors import change_frame
from ..skeleton import plane_of, skeleton
from ..spatial import ANGULAR, LINEAR
from .placing import quaternions
from .robot import RobotBody
from .signs import ConvexBody, Strokes, StrokeSign, arrow_strokes, free_strokes, lost_strokes, together
from .solids import Solid

_BODY, _ARROW = 0.3, 0.35
"""Of the arm's size: half the length of a typical body, and the length of a load's arrow."""
_SKY = 3.0  # brightness of the light from above and around
_FAR_AWAY = 1.25  # arm's sizes from which it is looked at
SHAPES = ("none", "ellipsoid", "polytope")


@dataclass(frozen=True)
class View:
    """What is shown.

    Attributes:
        velocity, force: which body of each, one of SHAPES.
        velocity_scale: metres of the scene per m/s; force_scale: metres per N of the bodies of force.
        solids, bones, axes, lost, free, load: whether the robot's own shape, its links and joints, the joint axes, the lost
        motions, the free wrenches and the loads are seen.

    Example:
        >>> import kinestatics as ks
        >>> seen = ks.View(velocity="none", force="ellipsoid", force_scale=0.1)
        >>> ks.show(ks.load("planar_2r"), [0.3, 1.0], view=seen).html.startswith("<!doctype html>")
        True
    """

    velocity: str = "ellipsoid"
    force: str = "none"
    velocity_scale: float = 0.25
    force_scale: float = 0.05
    solids: bool = True
    bones: bool = True
    axes: bool = True
    lost: bool = True
    free: bool = True
    load: bool = True


def fitting_view(a: Analysis, size: float) -> View:
    """What a page begins with: rounded scales at which the bodies of this posture are well seen on an arm of a size [m]."""
    return View(velocity_scale=fitting_scale(a.velocity_ellipsoid, size), force_scale=fitting_scale(a.force_ellipsoid, size))


def fitting_scale(body: Ellipsoid | Polytope | None, size: float) -> float:
    """Metres of the scene per unit, to one digit, at which a body is a third of an arm of this size [m]; 1 for nothing."""
    reach = 0.0
    if isinstance(body, Polytope) and body.corners is not None:
        reach = float(np.linalg.norm(body.corners, axis=-1).max(initial=0.0))
    elif isinstance(body, Ellipsoid):
        reach = float(body.radii[np.isfinite(body.radii)].max(initial=0.0))
    return float(f"{_BODY * size / reach:.1g}") if reach > 0 else 1.0


class ArmScene:
    """An arm in a scene of viser.

    Attributes:
        size: length by which signs are scaled [m]; plane: (2, 3) of a planar arm, right and up, else None.
        metres_per_newton: scale of the arrows of loads.
    """

    def __init__(self, server: Any, model: RobotModel, solids: Sequence[Solid] = ()) -> None:
        self._server, self._model, scene = server, model, server.scene
        bones = skeleton(model, model.home)
        self.size, self.plane = bones.size, plane_of(model)
        self.metres_per_newton = _ARROW * self.size / 100.0
        scene.world_axes.visible = False
        scene.configure_default_lights(cast_shadow=False)
        scene.configure_environment_map(None)  # mirrored surroundings take seconds to prepare without a graphics card
        scene.add_light_hemisphere("/light", intensity=_SKY)
        scene.add_frame(
            "/base", axes_length=0.12 * self.size, axes_radius=0.004 * self.size, origin_radius=0.006 * self.size
        )
        self.body = RobotBody(scene, model, self.size, solids)
        self._tip = scene.add_frame(
            "/tip_axes", axes_length=0.1 * self.size, axes_radius=0.004 * self.size, origin_radius=0.006 * self.size
        )
        self._velocity = ConvexBody(scene, "velocity", VELOCITY, self.size)
        self._force = ConvexBody(scene, "force", FORCE, self.size)
        self._lost = StrokeSign(scene, "lost", VELOCITY, self.size)
        self._free = StrokeSign(scene, "free", FORCE, self.size)
        self._load = StrokeSign(scene, "load", "#a50f15", self.size)
        self._ground_and_camera(bones.points)

    def update(self, a: Analysis, view: View, polytopes: tuple[Polytope | None, Polytope | None] = (None, None)) -> None:
        """Shows what `view` says of an analysis; polytopes of velocity and force, where they are given."""
        R, p = a.pose.rotation, a.pose.translation
        with self._server.atomic():
            self.body.place(a.configuration)
            self.body.show(solids=view.solids, bones=view.bones, axes=view.axes)
            self._tip.wxyz, self._tip.position = quaternions(R), p
            _show(self._velocity, view.velocity, a.velocity_ellipsoid, polytopes[0], p, view.velocity_scale)
            _show(self._force, view.force, a.force_ellipsoid, polytopes[1], p, view.force_scale)
            self._lost.show(lost_strokes(_new(a.lost_twists, a), p, self.size) if view.lost else None)
            self._free.show(free_strokes(_new(a.free_wrenches, a), p, self.size) if view.free else None)
            self._load.show(self._loads(a) if view.load else None)

    def _loads(self, a: Analysis) -> Strokes | None:
        """The loads of an analysis, each in axes of base, at the link where it acts."""
        found = []
        for load in a.loads:
            frame = Frame(self._model.base, load.link)
            given = load.wrench
            wrench = (given if given.frame == frame else change_frame(self._model, a.configuration, given, frame)).array
            place = pose(self._model, a.configuration, at=load.link).translation
            found.append(arrow_strokes(place, wrench[LINEAR], wrench[ANGULAR], self.metres_per_newton, self.size))
        return together(found)

    def _ground_and_camera(self, points: Array) -> None:
        """Where one looks from: a planar arm at right angles to its plane, another from in front and above."""
        scene, camera = self._server.scene, self._server.initial_camera
        middle = points.mean(axis=0)
        if self.plane is None:
            scene.set_up_direction("+z")
            away, up = np.array([0.75, -0.95, 0.5]), np.array([0.0, 0.0, 1.0])
            turn = np.eye(3)
        else:
            normal = np.cross(self.plane[0], self.plane[1])
            scene.set_up_direction(tuple(self.plane[1].tolist()))
            away, up = normal, self.plane[1]
            turn = np.stack([self.plane[0], self.plane[1], normal], -1)
        cell = 10.0 ** math.floor(math.log10(self.size / 2))
        width = 4 * self.size
        scene.add_grid(
            "/grid",
            width=width,
            height=width,
            cell_size=cell,
            section_size=5 * cell,
            plane="xy",
            wxyz=quaternions(turn),
            shadow_opacity=0.0,
        )
        camera.look_at = middle
        camera.position = middle + _FAR_AWAY * self.size * away / np.linalg.norm(away)
        camera.up = up


def _new(screws: Sequence[Any], a: Analysis) -> Sequence[Any]:
    """Directions lost here and not in every posture; a planar arm would else be full of signs that never change."""
    return screws if a.is_singular else ()


def _show(
    body: ConvexBody, shape: str, ellipsoid: Ellipsoid | None, polytope: Polytope | None, tip: Array, metres: float
) -> None:
    if shape == "ellipsoid" and ellipsoid is not None and ellipsoid.unit in ("m/s", "N"):
        body.ellipsoid(ellipsoid, tip, metres)
    elif shape == "polytope" and polytope is not None:
        body.polytope(polytope, tip, metres)
    else:
        body.hide()
