"""The arm itself: its own solids where they are known, else links and joints; each moves with what carries it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import definition
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..palette import EDGE, LINK, TEXT, rgb
from ..skeleton import rigid_lines
from ..spatial import ANGULAR, LINEAR, split_pose
from .placing import between, quaternions
from .simple_shapes import box, cylinder
from .solids import Solid

_THICK, _JOINT, _AXIS = 0.018, 0.034, 0.11
"""Radius of a link, radius of a joint and half its axis, as shares of the arm's size."""


class RobotBody:
    """An arm in a scene; `place` moves it.

    Attributes:
        has_solids: whether there are solids of its own (meshes), and not only links and joints.
    """

    def __init__(self, scene: Any, model: RobotModel, size: float, solids: Sequence[Solid] = ()) -> None:
        self._scene, self._model, self._size = scene, model, size
        self._paths: dict[int, str] = {-1: "/robot"}
        for i, parent in enumerate(model.parents):
            self._paths[i] = f"{self._paths[parent]}/{i}"
        self._frames = [scene.add_frame(self._paths[i], show_axes=False) for i in range(len(model.parents))]
        self._R, self._p = np.zeros((len(model.parents), 3, 3)), np.zeros((len(model.parents), 3))
        self._solids = [self._solid(k, solid) for k, solid in enumerate(solids)]
        self._bones = [*self._links(), *self._joints()]
        self._covered = {model.link_joints[model.link(solid.link)] for solid in solids}
        self._axes = self._joint_axes()
        self._rods = {i: self._rod(i) for i in self._sliding()}
        self.has_solids = bool(self._solids)
        self.show(solids=True, bones=True, axes=True)

    def show(self, *, solids: bool, bones: bool, axes: bool) -> None:
        """What of the arm is seen. What has solids needs no bones; parts whose meshes are missing are drawn by theirs."""
        for group, visible in ((self._solids, solids), (self._axes, axes)):
            for handle in group:
                handle.visible = visible
        for carrier, handle in self._bones:
            handle.visible = bones and not (solids and carrier in self._covered)
        for carrier, handle in self._rods.items():
            handle.visible = bones and not (solids and carrier in self._covered)

    def place(self, q: Array) -> None:
        """Moves the arm to q (n). Frames hang on each other as the joints do: what did not move by itself is not sent."""
        array, xp = as_array(q)
        if not self._frames:
            return
        R, p = definition.joint_steps(self._model, array, xp)
        moved = [i for i in range(len(R)) if not (np.array_equal(R[i], self._R[i]) and np.array_equal(p[i], self._p[i]))]
        for i, wxyz in zip(moved, quaternions(R[moved]), strict=True):
            self._frames[i].wxyz, self._frames[i].position = wxyz, p[i]
            if i in self._rods:
                self._place_rod(i, R[i], p[i], q)
        self._R, self._p = R, p

    def _place_rod(self, i: int, R: Array, p: Array, q: Array) -> None:
        """What a sliding joint has pushed out: from where it began to where it is, in the frame of the joint before."""
        pushed = self._model.multipliers[i] * q[self._model.columns[i]] + self._model.offsets[i]
        rod, start = self._rods[i], p - pushed * R @ self._model.screws[i, LINEAR]
        rod.wxyz, rod.position, rod.scale = between(start, p, 0.7 * self._thick)

    @property
    def _thick(self) -> float:
        return _THICK * self._size

    def _node(self, joint: int, name: str) -> str:
        """The path of a part that a joint carries; -1 is the base."""
        return f"{self._paths[joint]}/{name}"

    def _solid(self, k: int, solid: Solid) -> Any:
        """A solid of a link, placed in the frame of the joint that carries it."""
        index = self._model.link(solid.link)
        R, p = split_pose(self._model.link_placements[index])
        node = self._node(self._model.link_joints[index], f"solid{k}")
        opacity = None if solid.opacity >= 1 else solid.opacity
        look: dict[str, Any] = {"color": solid.color, "opacity": opacity, "side": "double", "cast_shadow": False}
        look["flat_shading"] = True  # corners are shared by faces that meet at an edge
        return self._scene.add_mesh_simple(node, solid.vertices @ R.T + p, solid.faces, **look)

    def _links(self) -> list[tuple[int, Any]]:
        """The links as rods with round ends, each with the joint that carries it."""
        made, rod = [], cylinder(1.0, 1.0)
        look: dict[str, Any] = {"color": rgb(LINK), "cast_shadow": False}
        for k, (carrier, line) in enumerate(rigid_lines(self._model)):
            wxyz, position, scale = between(line[0], line[1], self._thick)
            node, placed = self._node(carrier, f"link{k}"), {"wxyz": wxyz, "position": position, "scale": scale}
            made.append((carrier, self._scene.add_mesh_simple(node, rod.vertices, rod.faces, **placed, **look)))
            for e, end in enumerate(line):
                ball = self._scene.add_icosphere(f"{node}end{e}", self._thick, subdivisions=2, position=end, **look)
                made.append((carrier, ball))
        return made

    def _joints(self) -> list[tuple[int, Any]]:
        """A drum about the axis of a joint that turns, a block along that of one that slides."""
        made = []
        for i, (foot, direction, turns) in enumerate(self._axis_lines()):
            half, radius = 1.5 * _JOINT * self._size, _JOINT * self._size
            wxyz, position, scale = between(foot - half * direction, foot + half * direction, radius)
            solid = cylinder(1.0, 1.0) if turns else box(2.0, 2.0, 1.0)
            options: dict[str, Any] = {"color": rgb(EDGE), "cast_shadow": False, "flat_shading": not turns}
            options |= {"wxyz": wxyz, "position": position, "scale": scale}
            made.append((i, self._scene.add_mesh_simple(self._node(i, "drum"), solid.vertices, solid.faces, **options)))
        return made

    def _joint_axes(self) -> list[Any]:
        """A line along the axis of every joint, and its number."""
        made = []
        for i, (foot, direction, _) in enumerate(self._axis_lines()):
            reach = _AXIS * self._size * direction
            line = np.array([[foot - reach, foot + reach]], dtype=np.float32)
            made.append(
                self._scene.add_line_segments(
                    self._node(i, "axis"), line, rgb(TEXT), thickness=2.0, thickness_units="screen"
                )
            )
            number = str(self._model.columns[i] + 1)
            made.append(self._scene.add_label(self._node(i, "number"), number, position=foot + 1.15 * reach))
        return made

    def _axis_lines(self) -> list[tuple[Array, Array, bool]]:
        """Of every moving joint, in its own frame: a point of its axis, the axis' direction, whether it turns."""
        found = []
        for screw in self._model.screws:
            turns = bool(np.any(screw[ANGULAR]))
            direction = screw[ANGULAR] if turns else screw[LINEAR]
            foot = np.cross(screw[ANGULAR], screw[LINEAR]) if turns else np.zeros(3)
            found.append((foot, direction, turns))
        return found

    def _sliding(self) -> list[int]:
        return [i for i, (_, _, turns) in enumerate(self._axis_lines()) if not turns]

    def _rod(self, i: int) -> Any:
        """What a sliding joint has pushed out."""
        rod = cylinder(1.0, 1.0)
        return self._scene.add_mesh_simple(
            self._node(self._model.parents[i], f"rod{i}"), rod.vertices, rod.faces, color=rgb(EDGE), cast_shadow=False
        )
