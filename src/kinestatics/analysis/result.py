"""What an analysis holds: every number a surface may show, and the same as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dexterity import Ellipsoid
from ..namespaces import Array
from ..quantities import Jacobian, Pose, Wrench
from ..screws_in_words import Screw
from ..statics import Capacity, JointReactions, LoadSplit, split_load
from ..surfaces import surface
from ..tasks import Task
from .near import NEAR_SINGULARITY

if TYPE_CHECKING:
    from ..singular_sets import SingularSet
    from ..singular_sets.card import Card
    from ..singular_sets.distance import Distance


@dataclass(frozen=True)
class Margin:
    """How far a joint is from its nearest position limit.

    Attributes:
        joint: name; limit: "lower" or "upper"; distance: [rad or m], negative outside; near: within 5 % of the range,
        or outside it; locked: the limits leave it a single position.
    """

    joint: str
    limit: str
    distance: float
    near: bool
    locked: bool = False


@dataclass(frozen=True, eq=False)
class AppliedLoad:
    """A wrench that was asked about, and who holds it.

    Attributes:
        link: where it acts; wrench: with its frame named; joint_torques: (n) what holds it [N m or N].
        jacobian: of the link, in the frame of the wrench; characteristic_length: of the link [m].
        split: the parts that motors and structure hold, divided up when they are asked for.
    """

    link: str
    wrench: Wrench
    joint_torques: Array
    jacobian: Jacobian
    characteristic_length: float

    @cached_property
    def split(self) -> LoadSplit:
        """The parts that motors and structure hold."""
        return split_load(self.jacobian, self.wrench, length=self.characteristic_length)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text."""
        torques = self.joint_torques.tolist()
        return {
            "link": self.link,
            "wrench": self.wrench.to_dict(),
            "joint_torques": torques,
            "split": self.split.to_dict(),
        }


@dataclass(frozen=True)
class Ability:
    """How fast and how strong the arm is along one direction, with the limits of its joints.

    Attributes:
        direction: a word, "+x" to "-z" of base.
        speed: the greatest speed in this direction alone [m/s], all other rows of `speed_rows` at rest; None where velocity
            limits are unknown. speed_joints: whose limits stop it.
        push: the greatest force in this direction on the surroundings [N], the arm's weight taken off; infinite where the
            structure makes it; None where effort limits or masses are unknown. push_joints: whose limit stops it.
    """

    direction: str
    speed: float | None
    speed_joints: tuple[str, ...]
    push: float | None
    push_joints: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Analysis:
    """What an arm can do at one configuration. `print` it, or take `to_dict()`.

    Attributes:
        robot, base, tip: names; joints: names of the columns; kinds: of the joints.
        configuration: (n) [rad or m].
        pose: of the tip.
        jacobian: with its frame.
        task: the rows in play and the rank they can have.
        rank: here; singular when it is less than task.rank.
        singular_values: (k) of the rows in play. Where the task mixes metres and radians, angular rows are multiplied by
            the characteristic length; where the arm mixes prismatic and turning joints, prismatic columns are (a metre
            of travel then counts as the angle that moves the arm's reach by a metre). No unit of length changes the
            condition.
        condition: σ_max / σ_min over the task's rank, infinite when singular.
        characteristic_length: [m]; scaled: what it multiplied, "angular rows", "prismatic columns", both or nothing.
        manipulability: product of the singular values of the bare rows in play (note 000); unit: of that product.
        tolerance: singular values below this fraction of the largest count as zero.
        lost_twists, free_wrenches: within the rows in play, in words and numbers.
        isotropy: geometric over arithmetic mean of the squared singular values, 1 where all directions are alike.
        velocity_ellipsoid, force_ellipsoid: of the rows in play of one unit, linear before angular; None where none moves.
        abilities: along ± each axis of base that a linear row in play has; speed_rows: the rows that a speed keeps at rest.
        payloads: mass of each link that `with_payload` added [kg]; payload_capacity: the greatest mass at the tip beside
            them [kg], or None where efforts or masses are unknown.
        gravity: (3) in base axes [m/s²]; gravity_torques: (n) what holds the arm [N m or N], or None without masses.
        gravity_by_link: the same for each link with a mass; potential_energy: [J], zero at the base origin.
        loads: what was asked about; wrench: of the only one, or None; joint_torques: (n) what holds them all, or None.
        holding_torques: (n) what holds arm and loads, or None when neither is known.
        reactions: what each joint's bearing carries then, or None.
        effort_limits: (n) [N m or N], infinite where unknown.
        margins: one for each joint with limits.
        near: distances from the singularities, the nearest first, or None where they were not asked for or not found.
        singular_set: the singularities themselves, and card: what they say of this posture; None likewise.
        notes: sentences about missing data.
    """

    robot: str
    base: str
    tip: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    configuration: Array
    pose: Pose
    jacobian: Jacobian
    task: Task
    rank: int
    singular_values: Array
    condition: float
    characteristic_length: float
    scaled: tuple[str, ...]
    manipulability: float
    manipulability_unit: str
    tolerance: float
    lost_twists: tuple[Screw, ...]
    free_wrenches: tuple[Screw, ...]
    isotropy: float
    velocity_ellipsoid: Ellipsoid | None
    force_ellipsoid: Ellipsoid | None
    abilities: tuple[Ability, ...]
    speed_rows: tuple[str, ...]
    payloads: dict[str, float]
    payload_capacity: Capacity | None
    gravity: Array
    gravity_torques: Array | None
    gravity_by_link: dict[str, Array] | None
    potential_energy: float | None
    loads: tuple[AppliedLoad, ...]
    joint_torques: Array | None
    holding_torques: Array | None
    reactions: JointReactions | None
    effort_limits: Array
    margins: tuple[Margin, ...]
    near: tuple[Distance, ...] | None
    singular_set: SingularSet | None
    card: Card | None
    notes: tuple[str, ...]

    @property
    def is_singular(self) -> bool:
        """Whether the rank is less than the arm can have in these rows."""
        return self.rank < self.task.rank

    @property
    def wrench(self) -> Wrench | None:
        """The wrench that was asked about, where it was one."""
        return self.loads[0].wrench if len(self.loads) == 1 else None

    @property
    def effort_shares(self) -> Array | None:
        """(n) what holding the arm takes of each joint's effort limit: 1 is all of it, NaN where the limit is unknown."""
        if self.holding_torques is None:
            return None
        used, limits = np.abs(self.holding_torques), self.effort_limits
        shares = np.divide(used, limits, out=np.where(used > 0, np.inf, 0.0), where=limits > 0)
        return np.where(np.isfinite(limits), shares, np.nan)

    @property
    def close_singularities(self) -> tuple[Distance, ...]:
        """Those of `near` that are closer than `NEAR_SINGULARITY`, while the posture is not singular itself."""
        if self.near is None or self.is_singular:
            return ()
        return tuple(distance for distance in self.near if distance.value <= NEAR_SINGULARITY)

    def to_html(self, **options: Any) -> str:
        """A report as one page that needs neither network nor script, to be sent and printed; see `report.html`.

        Args:
            options: interactive, scene, command, seed, as in `kinestatics.report.html`.

        Returns:
            HTML, to be written with encoding="utf-8".

        Raises:
            MissingExtraError: KS400 without the extra `report`.

        Example:
            >>> import kinestatics as ks
            >>> ks.analyze(ks.load("planar_2r"), [0.0, 0.5]).to_html()[:15]
            '<!DOCTYPE html>'
        """
        page: str = surface("report").html(self, **options)
        return page

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; unknown and infinite values are None."""
        return {**self._motion_dict(), **self._statics_dict()}

    def _motion_dict(self) -> dict[str, Any]:
        J = self.jacobian
        return {
            "robot": self.robot,
            "base": self.base,
            "tip": self.tip,
            "joints": list(self.joints),
            "configuration": self.configuration.tolist(),
            "pose": np.asarray(self.pose).tolist(),
            "jacobian": {
                "array": np.asarray(J).tolist(),
                "axes": J.frame.axes,
                "origin": J.frame.origin,
                "rows": list(J.rows),
            },
            "task": {
                "name": self.task.name,
                "rows": list(self.task.row_names),
                "rank": self.task.rank,
                "reason": self.task.reason,
            },
            "rank": self.rank,
            "singular": self.is_singular,
            "singular_values": self.singular_values.tolist(),
            "condition": _finite(self.condition),
            "characteristic_length": self.characteristic_length,
            "scaled": list(self.scaled),
            "tolerance": self.tolerance,
            "manipulability": self.manipulability,
            "manipulability_unit": self.manipulability_unit,
            "lost_twists": [screw.to_dict() for screw in self.lost_twists],
            "free_wrenches": [screw.to_dict() for screw in self.free_wrenches],
            "isotropy": self.isotropy,
            "velocity_ellipsoid": _optional(self.velocity_ellipsoid),
            "force_ellipsoid": _optional(self.force_ellipsoid),
            "abilities": [_ability_dict(ability) for ability in self.abilities],
            "speed_rows": list(self.speed_rows),
            "limits": [asdict(margin) for margin in self.margins],
            "near_singularities": None if self.near is None else [distance.to_dict() for distance in self.near],
        }

    def _statics_dict(self) -> dict[str, Any]:
        by_link = self.gravity_by_link
        return {
            "gravity": self.gravity.tolist(),
            "gravity_torques": _listed(self.gravity_torques),
            "gravity_by_link": None if by_link is None else {name: torques.tolist() for name, torques in by_link.items()},
            "potential_energy": self.potential_energy,
            "wrench": None if self.wrench is None else self.wrench.to_dict(),
            "loads": [load.to_dict() for load in self.loads],
            "joint_torques": _listed(self.joint_torques),
            "holding_torques": _listed(self.holding_torques),
            "effort_limits": [_finite(x) for x in self.effort_limits],
            "payloads": dict(self.payloads),
            "payload_capacity": _optional(self.payload_capacity),
            "reactions": _optional(self.reactions),
            "notes": list(self.notes),
        }

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        from .text import paragraphs

        return "\n\n".join(paragraphs(self))

    def __repr__(self) -> str:
        return str(self)


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _listed(array: Array | None) -> Any:
    return None if array is None else array.tolist()


def _optional(result: Any) -> dict[str, Any] | None:
    return None if result is None else result.to_dict()


def _ability_dict(ability: Ability) -> dict[str, Any]:
    """As a dictionary; an unlimited push is null, with a word that tells it from an unknown one."""
    unlimited = ability.push is not None and not np.isfinite(ability.push)
    names = {"speed_joints": list(ability.speed_joints), "push_joints": list(ability.push_joints)}
    return asdict(ability) | names | {"push": None if unlimited else ability.push, "push_unlimited": unlimited}
