"""`name_of`: wrist, elbow or shoulder: what people call a part of the singular set, judged by its geometry."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, UnknownNameError, nearest
from ..frames import TIP
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR_ROWS
from ..tasks import Task, find_task
from .axis_geometry import GENERAL, TOLERANCE, Axes, Structure, axes_at, common_point, structure_of
from .task_map import TaskMap, task_map

_SAMPLES = 6
_BALL = 3  # axes of a ball joint
_LOST = 1e-8  # a singular value of a posture on a component, in shares of the largest


def name_of(model: RobotModel, samples: Any, joints: Sequence[str | int], at: str = TIP, task: Task | None = None) -> str:
    """What robot people call a component of the singular set, judged by its geometry: never by a table of robots.

    Args:
        model: the robot.
        samples: (s, n) postures on the component, general ones [rad or m].
        joints: the joints in the component's equations, by name or column.
        at, task: as the component was found; default task: "auto".

    Returns:
        "wrist", "elbow", "shoulder", or "other" where none of these holds at every sample, or more than one does.

    Law: the last joints that turn the tip, as many as the task has angular freedoms, are the wrist, with angular rows A; the
    joints before it are the arm, and move the tip by S when the wrist holds its attitude (Schur's complement of A in J).
    - wrist: A loses rank, and the equations are of wrist joints alone;
    - elbow: two arm joints that follow each other, with axes that are always parallel, move the tip along one line, and the
      equations hold the second: the arm is stretched or folded; or, where a spherical shoulder carries the elbow, the lost
      direction points from the wrist's centre to the shoulder's;
    - shoulder: the wrist's centre is on the axis of an arm joint, which does not move it; or the lost direction is that of
      the second axis, into which the first joint alone can move (the centre is in the plane through axis 1 parallel to axis
      2); or the first three axes meet in one point, are in one plane, and the equations are of these joints alone.

    Example:
        >>> import kinestatics as ks
        >>> name_of(ks.load("planar_2r"), [[0.3, 0.0], [1.0, 0.0]], ["joint2"])
        'elbow'
    """
    require_model(model)
    array, xp = configuration(model, samples)
    if xp.name != "numpy":
        raise ConfigurationError("KS303", "name_of takes postures as numbers", "NumPy or lists")
    postures = np.array(array, dtype=float).reshape(-1, model.n)
    found = task if task is not None else find_task(model, "auto", at)
    columns = frozenset(_column(model, joint) for joint in joints)
    if not len(postures) or not columns or not 0 < found.rank <= len(found.rows):
        return "other"
    anatomy = _anatomy(model, at, found)
    if anatomy is None:
        return "other"
    names = {_name_at(anatomy, q, columns) for q in postures}
    return names.pop() if len(names) == 1 else "other"


def _column(model: RobotModel, joint: str | int) -> int:
    if isinstance(joint, str):
        if joint not in model.joint_names:
            raise UnknownNameError(
                "KS313", f"robot {model.name!r} has no joint {joint!r}", nearest(joint, model.joint_names)
            )
        return model.joint_names.index(joint)
    if not 0 <= joint < model.n:
        raise ConfigurationError("KS303", f"joint {joint} is none of the {model.n} columns", "0 to n - 1, or a name")
    return int(joint)


class _Anatomy(NamedTuple):
    """Which columns are the arm and which the wrist; the map of the rows with the linear ones first."""

    of: TaskMap
    at: str
    rank: int
    arm: list[int]
    wrist: list[int]
    structure: Structure
    linear: list[int]
    angular: list[int]
    spread: Array

    def blocks(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Linear and angular rows of arm and wrist: J_la, J_lw, J_aa, A; angular rows on an orthonormal basis."""
        J = TaskMap.jacobian(self.of, q / self.of.travel)
        turning = self.spread.T @ J[self.angular] if self.angular else np.zeros((0, J.shape[1]))
        moving = J[self.linear]
        return moving[:, self.arm], moving[:, self.wrist], turning[:, self.arm], turning[:, self.wrist]


def _anatomy(model: RobotModel, at: str, task: Task) -> _Anatomy | None:
    """None where the joints of the chain are not the columns, or no last joints account for the angular freedoms."""
    path = model.path(model.link_joints[model.link(at)])
    if [model.columns[i] for i in path] != list(range(model.n)):
        return None
    plain_map = task_map(model, task, at)
    of = TaskMap(model, task.rows, at, plain_map.length, np.eye(len(task.rows)), plain_map.travel)
    linear = [k for k, r in enumerate(task.rows) if r not in ANGULAR_ROWS]
    angular = [k for k, r in enumerate(task.rows) if r in ANGULAR_ROWS]
    rng = np.random.default_rng(20260208)
    J = of.jacobian(rng.uniform(-np.pi, np.pi, (_SAMPLES, model.n)))
    U, sigma, _ = np.linalg.svd(np.moveaxis(J[:, angular], 0, 1).reshape(len(angular), _SAMPLES * model.n))
    freedoms = int((sigma > GENERAL).sum())
    spread = U[:, :freedoms]
    turning = spread.T @ J[:, angular]
    for count in range(model.n + 1):
        wrist = list(range(model.n - count, model.n))
        if count >= freedoms and _rank(turning[..., wrist]) == freedoms:
            if count != freedoms:
                return None
            arm = list(range(model.n - count))
            structure = structure_of(model, at, of.length)
            return _Anatomy(of, at, task.rank, arm, wrist, structure, linear, angular, spread)
    return None


def _rank(matrices: Array) -> int:
    if not matrices.shape[-1] or not matrices.shape[-2]:
        return 0
    sigma = np.linalg.svd(matrices, compute_uv=False)
    return int((sigma > GENERAL).sum(-1).min())


def _name_at(anatomy: _Anatomy, q: Array, columns: frozenset[int]) -> str:
    J_la, J_lw, J_aa, A = anatomy.blocks(q)
    whole = np.vstack([np.hstack([J_la, J_lw]), np.hstack([J_aa, A])])
    sigma = np.linalg.svd(whole, compute_uv=False)
    if (sigma > _LOST * sigma[0]).sum() >= anatomy.rank:
        return "other"
    if len(anatomy.wrist) and np.linalg.svd(A, compute_uv=False)[-1] <= _LOST:
        return "wrist" if columns <= set(anatomy.wrist) else "other"
    if not anatomy.arm or not anatomy.linear:
        return "other"
    S = J_la - J_lw @ np.linalg.solve(A, J_aa) if len(anatomy.wrist) else J_la
    axes = axes_at(anatomy.of.model, q, anatomy.at, anatomy.of.length)
    s = np.linalg.svd(S, compute_uv=False)
    drop = anatomy.rank - len(anatomy.wrist)
    if drop < 1 or (s > _LOST * max(1.0, s[0])).sum() >= drop:
        return "other"
    names = {name for name, holds in (("elbow", _elbow), ("shoulder", _shoulder)) if holds(anatomy, axes, S, columns)}
    return names.pop() if len(names) == 1 else "other"


def _lost(S: Array) -> Array | None:
    """The one linear direction that is lost; None where there are more, or none."""
    U, s, _ = np.linalg.svd(S)
    s = np.r_[s, np.zeros(len(U) - len(s))]
    lost = s <= _LOST * max(1.0, s[0])
    return np.asarray(U[:, -1]) if lost.sum() == 1 else None


def _center(anatomy: _Anatomy, axes: Axes) -> Array | None:
    """The wrist's centre: where all axes of the wrist always meet; the tip where there is no wrist."""
    if len(anatomy.wrist) < 2:
        return axes.tip
    return common_point(axes, anatomy.wrist, TOLERANCE) if anatomy.structure.point(anatomy.wrist) else None


def _elbow(anatomy: _Anatomy, axes: Axes, S: Array, columns: frozenset[int]) -> bool:
    turning = [i for i in anatomy.arm if i in axes.turning]
    flat = all(anatomy.structure.parallel(turning[0], j) for j in turning)
    least = anatomy.rank - len(anatomy.wrist)
    if flat or len(anatomy.arm) <= least:
        for i, j in itertools.pairwise(turning):
            if j not in columns or not anatomy.structure.parallel(i, j):
                continue
            pair = np.linalg.svd(S[:, [i, j]], compute_uv=False)
            if pair[-1] <= _LOST * max(1.0, pair[0]) and pair[0] > GENERAL:
                return True
    return _stretched(anatomy, axes, S, columns, turning)


def _stretched(anatomy: _Anatomy, axes: Axes, S: Array, columns: frozenset[int], turning: list[int]) -> bool:
    """A spherical shoulder, and a lost direction from it to the wrist's centre: one joint in between is the elbow."""
    if len(turning) < 4 or len(S) != 3 or not anatomy.structure.point(turning[:_BALL]):
        return False
    shoulder, center, lost = common_point(axes, turning[:_BALL], TOLERANCE), _center(anatomy, axes), _lost(S)
    if shoulder is None:
        shoulder = axes.meeting(turning[0], turning[1], 1e-12)
    if shoulder is None or center is None or lost is None or not columns <= set(turning[_BALL:]):
        return False
    reach = center - shoulder
    size = float(np.linalg.norm(reach))
    return size > GENERAL * axes.size and float(np.linalg.norm(np.cross(lost, reach))) <= TOLERANCE * size


def _shoulder(anatomy: _Anatomy, axes: Axes, S: Array, columns: frozenset[int]) -> bool:
    turning = [i for i in anatomy.arm if i in axes.turning]
    if len(S) != 3 or not turning:
        return False
    planar = len(turning) > 1 and anatomy.structure.parallel(turning[0], turning[1])
    if (
        len(turning) > 2
        and turning[:_BALL] == [0, 1, 2]
        and columns <= {0, 1, 2}
        and anatomy.structure.point(turning[:_BALL])
    ):
        return bool(abs(np.linalg.det(axes.u[:_BALL])) <= TOLERANCE)
    idle = [i for i in turning if np.linalg.norm(S[:, i]) <= _LOST]
    others = [i for i in anatomy.arm if i not in idle]
    if idle and len(anatomy.arm) <= 3 and _independent(S[:, others]):
        return True
    lost = _lost(S)
    if lost is None or planar or len(turning) < 2 or len(anatomy.arm) > 3 or turning[0] != 0:
        return False
    along = float(np.linalg.norm(np.cross(lost, axes.u[turning[1]])))
    return along <= TOLERANCE and _independent(S[:, 1:])


def _independent(columns: Array) -> bool:
    sigma = np.linalg.svd(columns, compute_uv=False)
    return columns.shape[1] == 0 or bool(sigma[-1] > GENERAL)
