"""`axis_relations`: which joint axes line up, are parallel or meet at a posture, though not at every one.

Law: what holds among the axes at random postures too is the arm's structure, and no news: only what holds at this posture
alone is a relation. Two axes u, u' through p, p' meet where (p' - p) · (u × u') = 0 and u × u' is not.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..frames import TIP
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import plain
from ..tasks import characteristic_length
from .axis_geometry import GENERAL, TOLERANCE, Axes, Structure, axes_at, common_point, structure_of


@dataclass(frozen=True, eq=False)
class AxisRelation:
    """What holds among the axes of joints at one posture and not at every one.

    Attributes:
        kind: "collinear", "parallel", "coplanar" (parallel axes in one plane), "meet" (axes through one point),
            "in-plane" (a point in the plane of two axes), "on-axis" (the tip on an axis).
        joints: names of the joints whose axes they are, from the base on; for "in-plane" the two of the plane.
        through: for "in-plane", the joints whose axes always meet in the point; empty for the tip.
        point: (3) where they meet, the point in the plane or on the axis; base axes, base origin [m]; None where there is
            none.
        direction: (3) unit vector along the axes, or at right angles to the plane; None for axes that meet.
        tolerance: angles [rad] and lengths in reaches of the arm below which the relation holds.
        text: the same in words.
    """

    kind: str
    joints: tuple[str, ...]
    through: tuple[str, ...]
    point: Array | None
    direction: Array | None
    tolerance: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "kind": self.kind,
            "joints": list(self.joints),
            "through": list(self.through),
            "point": plain(self.point),
            "direction": plain(self.direction),
            "tolerance": self.tolerance,
            "text": self.text,
        }

    def __str__(self) -> str:
        return self.text


def _groups(count: Sequence[int], related: Callable[[int, int], bool]) -> list[tuple[int, ...]]:
    """Joints gathered into classes of two or more by a relation that carries over."""
    found: list[list[int]] = []
    for i in count:
        home = next((group for group in found if related(group[0], i)), None)
        if home is None:
            found.append([i])
        else:
            home.append(i)
    return [tuple(group) for group in found if len(group) > 1]


def axis_relations(model: RobotModel, q: Any, at: str = TIP, tolerance: float = TOLERANCE) -> tuple[AxisRelation, ...]:
    """The joint axes that line up, are parallel, meet, or have a point of the arm in their plane, at this posture alone.

    Args:
        model: the robot; q: (n) one posture, NumPy or a list [rad or m]; at: the link whose chain is looked at.
        tolerance: angles [rad] and lengths in reaches of the arm below which a relation holds.

    Returns:
        Relations, the closest first: axes that line up, parallel axes in one plane, parallel ones, axes that meet, the tip
        on an axis, a point of the arm in the plane of two axes that follow each other (through the first and parallel to
        the second where they do not meet). Points of the arm are those in which axes always meet, and the tip. What holds
        at random postures too is left out.

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
        for group in _groups(self.axes.turning, lambda i, j: self._collinear(self.axes, i, j, self.tolerance)):
            if not self._always_lined_up(group):
                words = f"the axes of {_list(self.names, group)} line up"
                found.append(self._made("collinear", group, words, self.axes.p[group[0]], self.axes.u[group[0]]))
        return found

    def _always_lined_up(self, group: Sequence[int]) -> bool:
        return self.structure.always(lambda axes: all(self._collinear(axes, group[0], j, GENERAL) for j in group))

    def parallel(self) -> list[AxisRelation]:
        """Parallel axes and slides, and parallel axes in one plane."""
        found, everyone = [], range(len(self.names))
        for group in _groups(everyone, lambda i, j: self.axes.parallel(i, j) <= self.tolerance):
            flat = self._coplanar(group)
            if flat is not None:
                found.append(flat)
            new = [(i, j) for i, j in itertools.combinations(group, 2) if not self.structure.parallel(i, j)]
            if all(self._both_turn(i, j) and self._collinear(self.axes, i, j, self.tolerance) for i, j in new):
                continue
            words = f"the axes of {_list(self.names, group)} are parallel"
            found.append(self._made("parallel", group, words, None, self.axes.u[group[0]]))
        return sorted(found, key=lambda relation: relation.kind != "coplanar")

    def _both_turn(self, i: int, j: int) -> bool:
        return {i, j} <= set(self.axes.turning)

    def _coplanar(self, group: Sequence[int]) -> AxisRelation | None:
        """Three or more parallel axes in one plane, not all on one line."""
        turning = [i for i in group if i in self.axes.turning]
        if len(turning) < 3:
            return None
        if (normal := self._flat(self.axes, turning, self.tolerance)) is None:
            return None
        if self.structure.always(lambda axes: self._flat(axes, turning, GENERAL) is not None):
            return None
        words = f"the axes of {_list(self.names, turning)} are parallel and in one plane"
        return self._made("coplanar", turning, words, self.axes.p[turning[0]], normal)

    @staticmethod
    def _flat(axes: Axes, joints: Sequence[int], tolerance: float) -> Array | None:
        """The normal of the plane of parallel axes on at least three different lines."""
        first = joints[0]
        if any(axes.parallel(first, j) > tolerance for j in joints):
            return None
        distinct = [first]
        for j in joints[1:]:
            if all(axes.off(axes.p[j], i) > tolerance for i in distinct):
                distinct.append(j)
        if len(distinct) < 3:
            return None
        across = np.cross(axes.u[first], axes.p[distinct[1:]] - axes.p[first]) / axes.size
        _, sigma, Vt = np.linalg.svd(across)
        return np.asarray(Vt[0]) if sigma[1] <= tolerance * max(1.0, sigma[0]) else None

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
            words = f"the axes of {_list(self.names, group)} meet in one point"
            found.append(self._made("meet", group, words, point, None))
        for k in self.axes.turning:
            if self.axes.off(self.axes.tip, k) <= self.tolerance and not any(
                self._carries_tip(j) for j in self.axes.turning if self._collinear(self.axes, k, j, self.tolerance)
            ):
                words = f"the tip is on the axis of {self.names[k]}"
                found.append(self._made("on-axis", (k,), words, self.axes.tip, self.axes.u[k]))
        return sorted(found, key=lambda relation: (relation.kind != "meet", -len(relation.joints)))

    def _carries_tip(self, k: int) -> bool:
        """Whether the tip is always on an axis."""
        return self.structure.always(lambda axes: axes.off(axes.tip, k) <= GENERAL)

    def _meet_as_ever(self, group: Sequence[int]) -> bool:
        """Whether axes meet at every posture, or do so once those that line up here are counted once."""
        if self.structure.point(group):
            return True
        lines = [g for g in _groups(group, lambda i, j: self._collinear(self.axes, i, j, self.tolerance)) if len(g) > 1]
        doubled = {k for g in lines for k in g}
        alone = [k for k in group if k not in doubled]
        choices = itertools.product(*[(*g,) for g in lines]) if lines else iter([()])
        return bool(lines) and any(self.structure.point(sorted((*alone, *choice))) for choice in choices)

    def points(self) -> list[AxisRelation]:
        """Points of the arm in the plane of two axes that follow each other."""
        found = []
        turning = self.axes.turning
        for i, j in itertools.pairwise(turning):
            for joints in self._arm_points(j):
                if self._in_plane(self.axes, i, j, joints, self.tolerance) and not self._known(i, j, joints):
                    found.append(self._point_in_plane(i, j, joints))
        return found

    def _known(self, i: int, j: int, joints: Sequence[int]) -> bool:
        """Whether a point is in a plane at every posture, or because of a relation that is reported itself."""
        if self.structure.always(lambda axes: self._in_plane(axes, i, j, joints, GENERAL)):
            return True
        place = self._place(self.axes, joints, self.tolerance)
        through = [k for k in self.axes.turning if place is not None and self.axes.off(place, k) <= self.tolerance]
        if i in through or j in through:
            return True
        for k in through:  # an axis through the point that is parallel to one of the two: then it lies in their plane
            beside = [o for o in (i, j) if self.axes.parallel(k, o) <= self.tolerance]
            if len(beside) == 2 or any(not self.structure.parallel(k, o) for o in beside):
                return True
        return False

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
        what = f"the point where the axes of {_list(self.names, joints)} meet" if joints else "the tip"
        flat = self.axes.parallel(i, j) <= self.tolerance or self.axes.meeting(i, j, self.tolerance) is not None
        where = f"the plane of the axes of {self.names[i]} and {self.names[j]}"
        if not flat:
            where = f"the plane through the axis of {self.names[i]} that is parallel to the axis of {self.names[j]}"
        normal = plane[1] if plane is not None else None
        return self._made("in-plane", (i, j), f"{what} is in {where}", place, normal, joints)


def _list(names: Sequence[str], joints: Sequence[int]) -> str:
    words = [names[i] for i in joints]
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)
