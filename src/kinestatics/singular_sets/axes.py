"""`axis_relations`: which joint axes line up, are parallel or meet at a posture, though not at every one.

Law: what holds among the axes at random postures too is the arm's structure, and no news: only what holds at this posture
alone is a relation. Two axes u, u' through p, p' meet where (p' - p) · (u × u') = 0 and u × u' is not.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..frames import TIP
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..tasks import characteristic_length
from .axis_geometry import GENERAL, TOLERANCE, Axes, Structure, axes_at, common_point, plane_of, structure_of
from .axis_words import AxisRelation, groups, listed

__all__ = ["AxisRelation", "axis_relations"]
_BALL = 3  # axes of a ball joint


def axis_relations(model: RobotModel, q: Any, at: str = TIP, tolerance: float = TOLERANCE) -> tuple[AxisRelation, ...]:
    """The joint axes that line up, are parallel, meet, or have a point of the arm in their plane, at this posture alone.

    Args:
        model: the robot; q: (n) one posture, NumPy or a list [rad or m]; at: the link whose chain is looked at.
        tolerance: angles [rad] and lengths in reaches of the arm below which a relation holds.

    Returns:
        Relations, the closest first: axes that line up, parallel axes in one plane, parallel ones, axes that meet, the tip
        on axes, a point of the arm in the plane of two axes that follow each other (through the first and parallel to the
        second where they do not meet), and the next axis behind a ball joint at the base crossed by the line from there to a
        point of the arm. Points of the arm are those in which axes always meet, and the tip. What holds at random postures
        too, and what follows from another relation that is told, is left out.

    Raises:
        ConfigurationError: KS303, KS301; UnknownNameError: KS310.

    Law: see the head of this module.

    Example:
        >>> import kinestatics as ks
        >>> for relation in axis_relations(ks.load("planar_2r"), [0.4, 0.0]):
        ...     print(relation)
        the tip is in the plane of the axes of joint1 and joint2
    """
    require_model(model)
    array, xp = configuration(model, q)
    if xp.name != "numpy" or array.ndim != 1:
        raise ConfigurationError("KS303", "axis_relations takes one posture, as numbers", "loop over a batch")
    if not 0 <= tolerance < 1:
        raise ConfigurationError("KS303", f"tolerance is {tolerance}", "a small angle, such as 1e-7")
    size = characteristic_length(model, at)
    names = [model.moving_names[i] for i in model.path(model.link_joints[model.link(at)])]
    finder = _Finder(axes_at(model, np.array(array, dtype=float), at, size), structure_of(model, at, size), names, tolerance)
    return (*finder.lined_up(), *finder.parallel(), *finder.meeting(), *finder.points())


class _Finder(NamedTuple):
    """Looks for relations at one posture."""

    axes: Axes
    structure: Structure
    names: list[str]
    tolerance: float

    def _made(
        self, kind: str, joints: Sequence[int], words: str, point: Array | None, direction: Array | None, through: Any = ()
    ) -> AxisRelation:
        named, meeting = tuple(self.names[i] for i in joints), tuple(self.names[i] for i in through)
        return AxisRelation(kind, named, meeting, point, direction, self.tolerance, words)

    def _collinear(self, axes: Axes, i: int, j: int, tolerance: float) -> bool:
        return axes.parallel(i, j) <= tolerance and axes.off(axes.p[j], i) <= tolerance

    def lined_up(self) -> list[AxisRelation]:
        """Axes on one line."""
        found = []
        for group in groups(self.axes.turning, lambda i, j: self._collinear(self.axes, i, j, self.tolerance)):
            if not self._always_lined_up(group):
                words = f"the axes of {listed(self.names, group)} line up"
                found.append(self._made("collinear", group, words, self.axes.p[group[0]], self.axes.u[group[0]]))
        return found

    def _always_lined_up(self, group: Sequence[int]) -> bool:
        return self.structure.always(lambda axes: all(self._collinear(axes, group[0], j, GENERAL) for j in group))

    def parallel(self) -> list[AxisRelation]:
        """Parallel axes and slides, and parallel axes in one plane."""
        found, everyone = [], range(len(self.names))
        for group in groups(everyone, lambda i, j: self.axes.parallel(i, j) <= self.tolerance):
            flat = self._coplanar(group)
            if flat is not None:
                found.append(flat)
            if self._parallel_as_ever(group) or (flat is not None and len(flat.joints) == len(group)):
                continue
            words = f"the axes of {listed(self.names, group)} are parallel"
            found.append(self._made("parallel", group, words, None, self.axes.u[group[0]]))
        return sorted(found, key=lambda relation: relation.kind != "coplanar")

    def _parallel_as_ever(self, group: Sequence[int]) -> bool:
        """Whether axes are parallel at every posture, or are so once those that line up here are counted once."""
        reached, rest = [group[0]], list(group[1:])
        while rest:
            new = next((j for j in rest if any(self._tied(i, j) for i in reached)), None)
            if new is None:
                return False
            rest.remove(new)
            reached.append(new)
        return True

    def _tied(self, i: int, j: int) -> bool:
        """Whether two axes are always parallel, or line up here."""
        return self.structure.parallel(i, j) or (self._both_turn(i, j) and self._collinear(self.axes, i, j, self.tolerance))

    def _both_turn(self, i: int, j: int) -> bool:
        return {i, j} <= set(self.axes.turning)

    def _coplanar(self, group: Sequence[int]) -> AxisRelation | None:
        """Three or more parallel axes in one plane, not all on one line."""
        turning = [i for i in group if i in self.axes.turning]
        if len(turning) < 3:
            return None
        if (normal := plane_of(self.axes, turning, self.tolerance)) is None:
            return None
        if self.structure.always(lambda axes: plane_of(axes, turning, GENERAL) is not None):
            return None
        words = f"the axes of {listed(self.names, turning)} are parallel and in one plane"
        return self._made("coplanar", turning, words, self.axes.p[turning[0]], normal)

    def meeting(self) -> list[AxisRelation]:
        """Axes that meet in one point, and the tip on an axis."""
        found: list[AxisRelation] = []
        seen: set[tuple[int, ...]] = set()
        for i, j in itertools.combinations(self.axes.turning, 2):
            point = self.axes.meeting(i, j, self.tolerance)
            if point is None:
                continue
            group = tuple(k for k in self.axes.turning if self.axes.off(point, k) <= self.tolerance)
            if group in seen:
                continue
            seen.add(group)
            if self._meet_as_ever(group):
                continue
            words = f"the axes of {listed(self.names, group)} meet in one point"
            found.append(self._made("meet", group, words, point, None))
        carrying = [k for k in self.axes.turning if self._tip_comes_to(k, found)]
        if carrying:
            words = f"the tip is on the {'axis' if len(carrying) == 1 else 'axes'} of {listed(self.names, carrying)}"
            direction = self.axes.u[carrying[0]] if len(carrying) == 1 else None
            found.append(self._made("on-axis", carrying, words, self.axes.tip, direction))
        return sorted(found, key=lambda relation: (relation.kind != "meet", -len(relation.joints)))

    def _tip_comes_to(self, k: int, met: Sequence[AxisRelation]) -> bool:
        """Whether the tip is on an axis, which no relation found before says."""
        if self.axes.off(self.axes.tip, k) > self.tolerance:
            return False
        if any(self._carries_tip(j) for j in self.axes.turning if self._collinear(self.axes, k, j, self.tolerance)):
            return False
        here = [m for m in met if m.point is not None and self.names[k] in m.joints]
        return not any(np.linalg.norm(m.point - self.axes.tip) <= self.tolerance * self.axes.size for m in here)

    def _carries_tip(self, k: int) -> bool:
        """Whether the tip is always on an axis."""
        return self.structure.always(lambda axes: axes.off(axes.tip, k) <= GENERAL)

    def _meet_as_ever(self, group: Sequence[int]) -> bool:
        """Whether axes meet at every posture, or do so once those that line up here are counted once."""
        if self.structure.point(group):
            return True
        lines = [g for g in groups(group, lambda i, j: self._collinear(self.axes, i, j, self.tolerance)) if len(g) > 1]
        doubled = {k for g in lines for k in g}
        alone = [k for k in group if k not in doubled]
        choices = itertools.product(*[(*g,) for g in lines]) if lines else iter([()])
        return bool(lines) and any(self.structure.point(sorted((*alone, *choice))) for choice in choices)

    def points(self) -> list[AxisRelation]:
        """Points of the arm in the plane of two axes that follow each other."""
        found: list[AxisRelation] = []
        turning = self.axes.turning
        for i, j in itertools.pairwise(turning):
            for joints in self._arm_points(j):
                if self._in_plane(self.axes, i, j, joints, self.tolerance) and not self._known(i, j, joints):
                    relation = self._point_in_plane(i, j, joints)
                    if not any(self._same_plane(relation, other) for other in found):
                        found.append(relation)
        return [*found, *self.straight()]

    def _known(self, i: int, j: int, joints: Sequence[int]) -> bool:
        """Whether a point is in a plane at every posture, or because of a relation that is reported itself."""
        if self.structure.always(lambda axes: self._in_plane(axes, i, j, joints, GENERAL)):
            return True
        place = self._place(self.axes, joints, self.tolerance)
        through = [k for k in self.axes.turning if place is not None and self.axes.off(place, k) <= self.tolerance]
        if i in through or j in through:
            return True
        if any(self._meets_twice(k, i, j) for k in through):  # an axis through the point lies in the plane
            return True
        for k in through:  # an axis through the point that is parallel to one of the two: then it lies in their plane
            beside = [o for o in (i, j) if self.axes.parallel(k, o) <= self.tolerance]
            if len(beside) == 2 or any(not self.structure.parallel(k, o) for o in beside):
                return True
        return False

    def _same_plane(self, one: AxisRelation, other: AxisRelation) -> bool:
        """Whether two relations put the same point in the same plane."""
        if one.through != other.through or one.direction is None or other.direction is None:
            return False
        return float(np.linalg.norm(np.cross(one.direction, other.direction))) <= self.tolerance

    def _meets_twice(self, k: int, i: int, j: int) -> bool:
        """Whether an axis meets two others in different points."""
        one, other = (self.axes.meeting(k, o, self.tolerance) for o in (i, j))
        return one is not None and other is not None and bool(np.linalg.norm(one - other) > self.tolerance * self.axes.size)

    def straight(self) -> list[AxisRelation]:
        """The point of a ball joint, the axis behind it, and a point behind that on one line."""
        turning = self.axes.turning
        ball, rest = turning[:_BALL], turning[_BALL + 1 :]
        if len(turning) < 6 or not self.structure.point(ball):
            return []
        found = []
        for joints in self._arm_points(turning[_BALL]):
            if not joints or not set(joints) <= set(rest):
                continue
            line = self._crossing(self.axes, ball, turning[_BALL], joints, self.tolerance)
            if line is None or self._one_axis(ball, joints):
                continue
            if all(self._crossing(a, ball, turning[_BALL], joints, GENERAL) for a in self.structure.samples):
                continue
            ends = f"the axes of {listed(self.names, ball)} and those of {listed(self.names, joints)} meet"
            words = f"the line through the points where {ends} crosses the axis of {self.names[turning[_BALL]]}"
            found.append(self._made("straight", (turning[_BALL],), words, line[0], line[1], (*ball, *joints)))
        return found

    def _one_axis(self, ball: Sequence[int], joints: Sequence[int]) -> bool:
        """Whether the line through two points is that of axes that line up, or turns about one axis alone."""
        return any(self._collinear(self.axes, i, j, self.tolerance) for i in ball for j in joints)

    def _crossing(
        self, axes: Axes, ball: Sequence[int], k: int, joints: Sequence[int], tolerance: float
    ) -> tuple[Array, Array] | None:
        """Where the line through two points crosses an axis that neither is on, and the line's direction."""
        start, end = self._place(axes, ball, tolerance), self._place(axes, joints, tolerance)
        if start is None or end is None or min(axes.off(start, k), axes.off(end, k)) <= tolerance:
            return None
        reach = end - start
        size = float(np.linalg.norm(reach))
        if size <= tolerance * axes.size:
            return None
        line = Axes(np.stack([reach / size, axes.u[k]]), np.stack([start, axes.p[k]]), axes.tip, axes.size)
        point = line.meeting(0, 1, tolerance)
        return None if point is None else (point, line.u[0])

    def _arm_points(self, after: int) -> list[tuple[int, ...]]:
        """Where axes behind a joint always meet, each point once; () for the tip."""
        found: list[tuple[int, ...]] = []
        rest = [k for k in self.axes.turning if k > after]
        for i, j in itertools.combinations(rest, 2):
            if any({i, j} <= set(known) for known in found) or not self.structure.point((i, j)):
                continue
            found.append(tuple(k for k in rest if k in (i, j) or self.structure.point((i, j, k))))
        return found if any(self._tip_at(group) for group in found) else [*found, ()]

    def _tip_at(self, joints: Sequence[int]) -> bool:
        """Whether the tip always is where axes meet."""
        return self.structure.always(lambda axes: self._at(axes, joints, axes.tip))

    @staticmethod
    def _at(axes: Axes, joints: Sequence[int], place: Array) -> bool:
        point = common_point(axes, joints, GENERAL)
        return point is not None and float(np.linalg.norm(point - place)) <= GENERAL * axes.size

    def _place(self, axes: Axes, joints: Sequence[int], tolerance: float) -> Array | None:
        if not joints:
            return axes.tip
        point = common_point(axes, joints, tolerance)
        return point if point is not None else common_point(axes, joints[:2], 1e-12)

    def _in_plane(self, axes: Axes, i: int, j: int, joints: Sequence[int], tolerance: float) -> bool:
        plane, place = axes.plane(i, j, tolerance), self._place(axes, joints, tolerance)
        if plane is None or place is None:
            return False
        return abs(float((place - plane[0]) @ plane[1])) <= tolerance * axes.size

    def _point_in_plane(self, i: int, j: int, joints: Sequence[int]) -> AxisRelation:
        plane = self.axes.plane(i, j, self.tolerance)
        place = self._place(self.axes, joints, self.tolerance)
        what = f"the point where the axes of {listed(self.names, joints)} meet" if joints else "the tip"
        flat = self.axes.parallel(i, j) <= self.tolerance or self.axes.meeting(i, j, self.tolerance) is not None
        where = f"the plane of the axes of {self.names[i]} and {self.names[j]}"
        if not flat:
            where = f"the plane through the axis of {self.names[i]} that is parallel to the axis of {self.names[j]}"
        normal = plane[1] if plane is not None else None
        return self._made("in-plane", (i, j), f"{what} is in {where}", place, normal, joints)
