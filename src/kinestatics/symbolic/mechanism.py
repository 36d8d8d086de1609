"""A tree of joints as exact polynomials: poses and Jacobians of any of its links, seen from any body. Floor 7."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from ..errors import ConfigurationError
from ..frames import Frame
from ..model import RobotModel
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, ROW_NAMES
from .exact import cosine_sine, free_symbols, joint_symbols
from .joints import AXIS, Joint, LengthNames, axis_frame, axis_of, carried, carried_pose, motion, whole_ratio
from .poses import Pose, Vector, compose, crossed, identity, inverse, read_pose, transposed, turned
from .ring import Matrix, Polynomial, TrigonometricRing, atoms_of, expanded
from .values import exact_value, objects

WHOLE_TASKS = ((*LINEAR_ROWS, *ANGULAR_ROWS), LINEAR_ROWS, ANGULAR_ROWS)
"""Tasks whose determinant is the same in all axes."""


@dataclass(frozen=True, eq=False)
class Mechanism:
    """The joints that carry some links of a robot, each with a frame whose z lies along its axis where that is exact.

    Attributes:
        model: exact; ring: of the polynomials.
        parents: joint → the joint before, -1 for the base; joints: joint → it, placed in the frame of its parent.
        links: link → (joint that carries it, its frame seen from the joint's).
        values: what the symbols that `named` put in place of numbers stand for [m].
    """

    model: RobotModel
    ring: TrigonometricRing
    parents: Mapping[int, int]
    joints: Mapping[int, Joint]
    links: Mapping[int, tuple[int, Pose]]
    values: Mapping[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        model: RobotModel,
        links: Iterable[int],
        entries: Iterable[Any] = (),
        symbols: Iterable[Any] = (),
        *,
        from_base: bool = True,
    ) -> Mechanism:
        """The joints between the base and some links of an exact model.

        Args:
            links: indices of the links.
            entries: expressions whose angles, lengths and roots the ring must hold besides.
            symbols: that it must hold as parameters.
            from_base: whether the frames of the first joints, too, are moved along their axes, to where they are nearest to
                the base; else they stay where the model puts them.

        Raises:
            ConfigurationError: KS391 for a screw joint, a mimic joint whose ratio is no whole number, or a coordinate that
                turns one joint and slides another. ArrayTypeError: KS390.
        """
        described = _Description.of(model, links)
        ring = described.ring(entries, symbols)
        parents = {i: model.parents[i] for i in described.screws}
        joints, placed_links = described.placed(ring)
        return cls(model, ring, parents, joints, placed_links)._slid(from_base)

    def _slid(self, from_base: bool) -> Mechanism:
        """The same with frames moved along their axes to where they are nearest to the axis before, as in a table of
        Denavit and Hartenberg; done where axes are at right angles or parallel."""
        ring = self.ring
        along = {-1: ring.zero}  # from where a frame lies now to where it lay
        joints = {}
        for i, joint in self.joints.items():
            R, p = joint.placed
            p = [*p[:AXIS], p[AXIS] + along[self.parents[i]]]
            along[i], z = ring.zero, [row[AXIS] for row in R]
            plain = joint.direction[:AXIS] == [ring.zero] * 2 and all(x in (ring.zero, ring.one, -ring.one) for x in z)
            if plain and (from_base or self.parents[i] >= 0):
                along[i] = ring.total(a * b for a, b in zip(p, z, strict=True))
                p = [ring.reduced(x - along[i] * a) for x, a in zip(p, z, strict=True)]
            joints[i] = joint._replace(placed=Pose(R, p))
        links = {link: (i, Pose(T.R, [*T.p[:AXIS], T.p[AXIS] + along[i]])) for link, (i, T) in self.links.items()}
        return replace(self, joints=joints, links=links)

    def named(self) -> Mechanism:
        """The same with symbols for lengths that are numbers: d along the axis of the joint before, a (and b) across."""
        old = self.ring
        names = LengthNames({str(x) for x in (*old.parameters, *old.joints, *free_symbols(self.model))})
        of_joints = {i: names.of(self.joints.get(self.parents[i]), joint.placed) for i, joint in self.joints.items()}
        of_links = {link: names.of(self.joints.get(i), T) for link, (i, T) in self.links.items()}
        values = names.values
        ring = replace(old, parameters=(*old.parameters, *sorted(values, key=str)))
        joints = {}
        for i, joint in self.joints.items():
            placed = carried_pose(old, joint.placed, ring, of_joints[i])
            joints[i] = joint._replace(placed=placed, direction=[carried(old, x, ring) for x in joint.direction])
        links = {link: (i, carried_pose(old, T, ring, of_links[link])) for link, (i, T) in self.links.items()}
        return Mechanism(self.model, ring, self.parents, joints, links, values)

    @cached_property
    def steps(self) -> dict[int, Pose]:
        """joint → its frame, moved, seen from the moved frame of the joint before."""
        return {i: compose(self.ring, joint.placed, motion(self.ring, joint)) for i, joint in self.joints.items()}

    @cached_property
    def _seen(self) -> dict[int, dict[int, Pose]]:
        return {}

    def seen_from(self, body: int) -> dict[int, Pose]:
        """The moved frames of all joints, and the base (-1), seen from the moved frame of one of them."""
        if body in self._seen:
            return self._seen[body]
        ring = self.ring
        found = {body: identity(ring)}
        here, k = found[body], body
        while k >= 0:
            here = compose(ring, here, inverse(ring, self.steps[k]))
            k = self.parents[k]
            found[k] = here
        for i, step in self.steps.items():
            if i not in found:
                found[i] = compose(ring, found[self.parents[i]], step)
        self._seen[body] = found
        return found

    def point(self, link: int, offset: Sequence[Any], body: int) -> Vector:
        """A point of a link, given in the link's axes, seen from a body."""
        joint, T = self.links[link]
        ring = self.ring
        local = [ring.read(exact_value(x)) for x in offset]
        return compose(ring, compose(ring, self.seen_from(body)[joint], T), Pose(T.R, local)).p

    def pose(self, link: int, offset: Sequence[Any] = (0, 0, 0), body: int = -1) -> Pose:
        """A link's axes, at a point of it, seen from a body."""
        joint, T = self.links[link]
        placed = compose(self.ring, self.seen_from(body)[joint], T)
        return Pose(placed.R, self.point(link, offset, body))

    def path(self, link: int) -> list[int]:
        """The joints that carry a link, base first."""
        found, i = [], self.links[link][0]
        while i >= 0:
            found.append(i)
            i = self.parents[i]
        return found[::-1]

    def jacobian(
        self, link: int, body: int, origin: Vector | None = None, axes: Matrix | None = None
    ) -> list[list[Polynomial]]:
        """(6, n) the Jacobian of a link, linear rows first.

        Args:
            body: joint whose moved frame the columns are found in, -1 for the base.
            origin: (3) where the velocity is taken, seen from the body; default its origin.
            axes: (3, 3) rotation of the axes of the rows, seen from the body; default the body's.
        """
        ring, seen = self.ring, self.seen_from(body)
        point = [ring.zero] * 3 if origin is None else origin
        columns = [[ring.zero] * len(ROW_NAMES) for _ in range(self.model.n)]
        for i in self.path(link):
            joint, (R, p) = self.joints[i], seen[i]
            z = turned(ring, R, joint.direction)
            arm = [ring.reduced(a - b) for a, b in zip(point, p, strict=True)]
            halves = (z, [ring.zero] * 3) if joint.slides else (crossed(ring, z, arm), z)
            six = [x for half in halves for x in (half if axes is None else turned(ring, transposed(axes), half))]
            factor, own = ring.number(joint.multiplier), columns[joint.column]
            columns[joint.column] = [ring.reduced(a + factor * b) for a, b in zip(own, six, strict=True)]
        return [[column[r] for column in columns] for r in range(len(ROW_NAMES))]

    def jacobian_in(self, link: int, frame: Frame, offset: Sequence[Any]) -> list[list[Polynomial]]:
        """(6, n) the Jacobian of a link in axes of one link, at a point of another."""
        axes, origin = self.model.link(frame.axes), self.model.link(frame.origin)
        body, T = self.links[axes]
        return self.jacobian(link, body, self.point(origin, offset, body), T.R)

    def middle(self, link: int) -> int:
        """The joint in the middle of those that carry a link; -1 where there is none."""
        path = self.path(link)
        return path[(len(path) - 1) // 2] if path else -1

    def slope(self, p: Polynomial, column: int) -> Polynomial:
        """∂p/∂q of a joint."""
        ring = self.ring
        if column in ring.slides:
            return p.derivative(ring.slides[column])
        angle = ring.angle_of(column)
        by_sine = p.derivative(angle.sine) * ring.generator(angle.cosine)
        return ring.reduced(by_sine - p.derivative(angle.cosine) * ring.generator(angle.sine))


@dataclass(frozen=True, eq=False)
class _Description:
    """What a model says of the joints that carry some links, as SymPy expressions without sums of angles."""

    model: RobotModel
    screws: Mapping[int, list[Any]]
    frames: Mapping[int, list[list[Any]]]
    placements: Mapping[int, list[list[Any]]]
    places: Mapping[int, list[list[Any]]]
    offsets: Mapping[int, Any]

    @classmethod
    def of(cls, model: RobotModel, links: Iterable[int]) -> _Description:
        """The joints between the base and some links."""
        wanted = sorted(set(links))
        used = sorted({i for link in wanted for i in model.path(model.link_joints[link])})
        screws = {i: expanded(model.screws[i]) for i in used}
        frames = {i: axis_frame(screws[i], model.moving_names[i]) for i in used}
        placements = {i: expanded(model.placements[i]) for i in used}
        places = {link: expanded(model.link_placements[link]) for link in wanted}
        offsets = dict(zip(used, expanded(objects(model.offsets[i] for i in used)), strict=True))
        return cls(model, screws, frames, placements, places, offsets)

    def ring(self, entries: Iterable[Any], symbols: Iterable[Any]) -> TrigonometricRing:
        """The ring that holds them, further expressions, and further symbols as parameters."""

        poses = (*self.placements.values(), *self.places.values(), *self.frames.values())
        found = [x for T in poses for row in T for x in row]
        found += [x if axis_of(self.screws[i])[1] else cosine_sine(x)[0] for i, x in self.offsets.items()]
        found += expanded(objects(entries))
        constants, parameters, roots = atoms_of(found)
        extra = tuple(x for x in symbols if x not in parameters)
        return TrigonometricRing(tuple(joint_symbols(self.model)), self._turns(), constants, (*parameters, *extra), roots)

    def _turns(self) -> tuple[bool, ...]:
        """(n) whether a joint turns.

        Raises:
            ConfigurationError: KS391 where one coordinate turns some joints and slides others.
        """
        model, found = self.model, dict[int, bool]()
        for i, screw in self.screws.items():
            slides = axis_of(screw)[1]
            if found.setdefault(model.columns[i], not slides) == slides:
                message = f"joint {model.joint_names[model.columns[i]]!r} turns one joint and slides another"
                raise ConfigurationError("KS391", message, "closed forms need one kind of joint for each coordinate")
        return tuple(found.get(j, True) for j in range(model.n))

    def placed(self, ring: TrigonometricRing) -> tuple[dict[int, Joint], dict[int, tuple[int, Pose]]]:
        """The joints, and the links with the joints that carry them, as polynomials."""
        model, own, joints = self.model, dict[int, Pose](), dict[int, Joint]()

        def behind(i: int, T: Any) -> Pose:
            seen = read_pose(ring, T)
            return compose(ring, inverse(ring, own[i]), seen) if i >= 0 else seen

        for i, screw in self.screws.items():
            own[i] = read_pose(ring, self.frames[i])
            placed = compose(ring, behind(model.parents[i], self.placements[i]), own[i])
            direction, slides = axis_of(screw)
            seen = turned(ring, transposed(own[i].R), [ring.read(x) for x in direction])
            ratio = whole_ratio(model.multipliers[i], slides, model, i)
            joints[i] = Joint(placed, seen, slides, model.columns[i], ratio, self.offsets[i])
        carriers = {link: model.link_joints[link] for link in self.places}
        return joints, {link: (i, behind(i, self.places[link])) for link, i in carriers.items()}
