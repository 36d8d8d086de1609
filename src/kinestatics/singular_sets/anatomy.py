"""`anatomy_of`: which joints of a chain are its shoulder, its elbow and its wrist, judged by its axes at random postures.

Places: the columns that move the link, in the order of the path, so that a robot's other joints do not count.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS
from ..tasks import characteristic_length, prismatic_columns
from .axis_geometry import GENERAL, Axes, Structure, axes_along, random_postures
from .task_map import TaskMap

BALL = 3  # axes of a ball joint
LOST = 1e-8  # a singular value of a posture on a component, in shares of the largest
_KEPT = 16
_EVERY_ROW = (*LINEAR_ROWS, *ANGULAR_ROWS)


class Blocks(NamedTuple):
    """A posture: twists (6, m) of the places, the task's rows J of them, and of these the blocks of arm and wrist."""

    axes: Axes
    twists: Array
    J: Array
    A: Array
    S: Array | None


class Anatomy(NamedTuple):
    """Arm and wrist of a chain, and its parts.

    Attributes:
        of: all six rows as a map without units; rows, rank: of the task; places: columns on the path.
        alone: which joint of the path moves each place; None where several do.
        wrist: the last places, as many as the task has angular freedoms; arm: those before it. parted: whether it parts so.
        spread: (a, freedoms) orthonormal basis of what the angular rows do.
        structure: the axes at random postures, one for each place.
        groups: runs of places that turn about axes which are always parallel, and how many freedoms they have in J and S.
        shoulder, elbow: three places each, the middle one that which bends them; empty where the chain has no such part.
        redundant: whether the chain is shoulder, elbow and wrist with one joint to spare.
        ball: the shoulder, or the first three places of the arm that turn, where their axes always meet in one point.
        center: the wrist's axes, all or the first two, that always meet in one point; empty where they do not.
        upright: whether the first two axes of the arm are never parallel.
    """

    of: TaskMap
    rows: tuple[int, ...]
    rank: int
    places: tuple[int, ...]
    alone: tuple[int | None, ...]
    arm: tuple[int, ...]
    wrist: tuple[int, ...]
    parted: bool
    spread: Array
    structure: Structure
    groups: tuple[tuple[int, ...], ...] = ()
    freedoms: tuple[tuple[int, int], ...] = ()
    shoulder: tuple[int, ...] = ()
    elbow: tuple[int, ...] = ()
    redundant: bool = False
    ball: tuple[int, ...] = ()
    center: tuple[int, ...] = ()
    upright: bool = False

    @property
    def linear(self) -> list[int]:
        """The linear rows of the task."""
        return [r for r in self.rows if r not in ANGULAR_ROWS]

    def at(self, postures: Array) -> list[Blocks]:
        """Postures (k, n) taken apart."""
        twists = self.of.jacobian(postures / self.of.travel)[..., list(self.places)]
        axes = _by_place(axes_along(self.of.model, postures, self.of.at, self.of.length), self.alone)
        return [self._blocks(axes[k], twists[k]) for k in range(len(postures))]

    def _blocks(self, axes: Axes, twists: Array) -> Blocks:
        arm, wrist = list(self.arm), list(self.wrist)
        moving = twists[self.linear]
        turning = self.spread.T @ twists[[r for r in self.rows if r in ANGULAR_ROWS]]
        A = turning[:, wrist] if self.parted else np.zeros((0, 0))
        S = None
        if self.parted and not wrist:
            S = moving[:, arm]
        elif self.parted and np.linalg.svd(A, compute_uv=False)[-1] > LOST:
            S = moving[:, arm] - moving[:, wrist] @ np.linalg.solve(A, turning[:, arm])
        return Blocks(axes, twists, twists[list(self.rows)], A, S)


def _by_place(along: list[Axes], alone: tuple[int | None, ...]) -> list[Axes]:
    """Axes of the places: not a number where several joints share a column."""
    index = [-1 if joint is None else joint for joint in alone]
    shared = np.array([joint is None for joint in alone], dtype=bool)[:, None]
    return [
        Axes(np.where(shared, np.nan, axes.u[index]), np.where(shared, np.nan, axes.p[index]), axes.tip, axes.size)
        for axes in along
    ]


@lru_cache(maxsize=_KEPT)
def anatomy_of(model: RobotModel, at: str, rows: tuple[int, ...], rank: int) -> Anatomy | None:
    """The anatomy of the chain to a link for the rows of a task; None where no joint moves the link.

    Law: the wrist are the last joints that give the task its angular freedoms, exactly as many as these. A shoulder are the
    first three joints that turn, where their axes always meet in one point, or where with one more joint and a wrist of
    three they are all there is; the elbow is the next one, with a neighbour on either side.

    Example:
        >>> import kinestatics as ks
        >>> found = anatomy_of(ks.load("iiwa_14"), "tip", (0, 1, 2, 3, 4, 5), 6)
        >>> found.shoulder, found.elbow, found.wrist
        ((0, 1, 2), (2, 3, 4), (4, 5, 6))
    """
    path = model.path(model.link_joints[model.link(at)])
    places = tuple(dict.fromkeys(model.columns[joint] for joint in path))
    if not places:
        return None
    movers = {c: [k for k, joint in enumerate(path) if model.columns[joint] == c] for c in places}
    alone = tuple(movers[c][0] if len(movers[c]) == 1 else None for c in places)
    size = _reach(model, at)
    travel = np.where(prismatic_columns(model), size, 1.0)
    of = TaskMap(model, _EVERY_ROW, at, size, np.eye(len(_EVERY_ROW)), travel)
    postures = random_postures(model, size)
    structure = Structure(tuple(_by_place(axes_along(model, postures, at, size), alone)))
    angular = of.jacobian(postures / travel)[:, [r for r in rows if r in ANGULAR_ROWS]][..., list(places)]
    arm, wrist, parted, spread = _parted(angular, len(places))
    plain = Anatomy(of, rows, rank, places, alone, arm, wrist, parted, spread, structure)
    return _with_parts(plain, postures)


def _reach(model: RobotModel, at: str) -> float:
    """The greatest distance of the tip from an axis at random postures, slides at zero: the same from any base [m]."""
    along = axes_along(model, random_postures(model, 0.0), at, 1.0)
    far = max((axes.off(axes.tip, k) for axes in along for k in axes.turning), default=0.0)
    usual = characteristic_length(model, at)
    return far if far > GENERAL * usual else usual


def _parted(angular: Array, count: int) -> tuple[tuple[int, ...], tuple[int, ...], bool, Array]:
    """Arm and wrist, whether there are any, and a basis of what the angular rows do, from their rows at postures."""
    U, sigma, _ = np.linalg.svd(np.moveaxis(angular, 0, 1).reshape(angular.shape[1], len(angular) * count))
    freedoms = int((sigma > GENERAL).sum())
    turning = U[:, :freedoms].T @ angular
    arm, wrist = tuple(range(count - freedoms)), tuple(range(max(0, count - freedoms), count))
    parted = freedoms <= count and rank_of(turning[..., list(wrist)]) == freedoms
    return (arm, wrist, True, U[:, :freedoms]) if parted else (tuple(range(count)), (), False, U[:, :freedoms])


def _with_parts(plain: Anatomy, postures: Array) -> Anatomy:
    """The parts of an anatomy. A ball at the base that is not all there is, is a shoulder: no wrist shares its joints."""
    structure, turning = plain.structure, plain.structure.samples[0].turning
    first, last = tuple(turning[:BALL]), tuple(turning[-BALL:])
    is_ball = len(first) == BALL and structure.point(first) and not structure.always(lambda axes: flat(axes, first))
    is_ball = is_ball and len(turning) > BALL and _slides(plain, first[0])
    if is_ball and set(first) & set(plain.wrist):
        plain = plain._replace(arm=tuple(range(len(plain.places))), wrist=(), parted=False)
    bends = [i for i in plain.arm if i in turning]
    redundant = plain.parted and plain.wrist == last and len(turning) == 2 * BALL + 1 and len(bends) == BALL + 1
    redundant = redundant and _slides(plain, first[0]) and not structure.always(lambda axes: flat(axes, first))
    middle = tuple(turning[BALL - 1 : BALL + 2])
    bent = len(middle) == BALL and not structure.always(lambda axes: flat(axes, middle))
    redundant = redundant and bent and plain.rank == len(_EVERY_ROW)
    elbow = middle if bent and (redundant or is_ball) and middle[1] in plain.arm else ()
    shoulder = first if redundant or is_ball else ()
    start = tuple(bends[:BALL])
    found = plain._replace(
        shoulder=shoulder,
        elbow=elbow,
        redundant=redundant,
        groups=_parallel_runs(structure, turning),
        ball=start if len(start) == BALL and structure.point(start) else (),
        center=next((c for c in (plain.wrist, plain.wrist[:2]) if len(c) > 1 and structure.point(c)), ()),
        upright=len(bends) > 1 and not structure.parallel(bends[0], bends[1]),
    )
    samples = found.at(postures)
    return found._replace(freedoms=tuple(_freedoms(found, group, samples) for group in found.groups))


def _slides(plain: Anatomy, first: int) -> bool:
    """Whether all places before one only slide."""
    return all(np.isfinite(plain.structure.samples[0].u[k, 0]) for k in range(first))


def _parallel_runs(structure: Structure, turning: list[int]) -> tuple[tuple[int, ...], ...]:
    """Runs of two or more axes one after the other that are always parallel."""
    runs: list[list[int]] = []
    for k in turning:
        if runs and structure.parallel(runs[-1][-1], k):
            runs[-1].append(k)
        else:
            runs.append([k])
    return tuple(tuple(run) for run in runs if len(run) > 1)


def _freedoms(found: Anatomy, group: tuple[int, ...], samples: list[Blocks]) -> tuple[int, int]:
    """How many freedoms a group has in the task, and its joints of the arm when the wrist holds its attitude."""
    inside = [found.arm.index(k) for k in group if k in found.arm]
    held = [s.S[:, inside] for s in samples if s.S is not None]
    return (
        min(rank_of(s.J[:, list(group)]) for s in samples),
        min((rank_of(S) for S in held), default=0),
    )


def flat(axes: Axes, joints: tuple[int, ...], tolerance: float = GENERAL) -> bool:
    """Whether the axes of three joints are parallel to one plane."""
    return bool(np.linalg.svd(axes.u[list(joints)], compute_uv=False)[-1] <= tolerance)


def rank_of(matrices: Array, tolerance: float = GENERAL) -> int:
    """The least rank of matrices (..., a, b)."""
    if not matrices.shape[-1] or not matrices.shape[-2]:
        return 0
    return int((np.linalg.svd(matrices, compute_uv=False) > tolerance).sum(-1).min())
