"""`name_of`: wrist, elbow or shoulder: what people call a part of the singular set, judged by its geometry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ConfigurationError, UnknownNameError, nearest
from ..frames import TIP
from ..kinematics import configuration, require_model
from ..model import RobotModel
from ..namespaces import Array
from ..tasks import Task, find_task
from .anatomy import BALL, LOST, Anatomy, Blocks, anatomy_of, flat, rank_of
from .axis_geometry import GENERAL, TOLERANCE, Axes, common_point

_NAMES = ("shoulder", "elbow", "wrist")
_NEAR = 1e-3  # a wrist so nearly singular that what the arm does for it is not told from samples
_SMALL_ARM = 3  # joints of an arm without one to spare


def name_of(model: RobotModel, samples: Any, joints: Sequence[str | int], at: str = TIP, task: Task | None = None) -> str:
    """What robot people call a component of the singular set, judged by its geometry: never by a table of robots.

    Args:
        model: the robot.
        samples: (s, n) postures on the component, general ones [rad or m].
        joints: the joints in the component's equations, by name or column.
        at, task: as the component was found; default task: "auto".

    Returns:
        "wrist", "elbow", "shoulder", two of them in the order from the base ("shoulder and wrist") where both hold at every
        sample, or "other" where none does. Samples of a lower rank than the others are not counted.

    Law: only joints that move the link count. The last joints that turn it, as many as the task has angular freedoms, are
    the wrist, with angular rows A; the joints before it are the arm, and move the tip by S when the wrist holds its attitude
    (Schur's complement of A in J).
    - wrist: A loses rank, and the equations are of wrist joints alone;
    - elbow: joints that follow each other, with axes that are always parallel, lose a freedom in J or in S, and the second
      of them is in the equations: their axes, and the wrist's centre, are in one plane, the arm is stretched or folded; or,
      where a ball joint carries the elbow, the lost direction points from the ball to the wrist's centre;
    - shoulder: the wrist's centre is on the axis of an arm joint, which does not move it; or the lost direction is that of
      the second axis, into which the first joint alone can move (the centre is in the plane through axis 1 parallel to axis
      2); or the first three axes meet in one point, are in one plane, and the equations are of these joints alone.
    In a chain of shoulder, elbow and wrist with a joint to spare (3 + 1 + 3 axes) a part names the component too where it
    wastes a freedom: its three axes (the elbow with a neighbour on either side) are parallel to one plane, and its middle
    joint is in the equations. In any other chain that a ball joint carries, the three axes of shoulder or elbow have to be
    dependent as lines: two of them line up.

    Example:
        >>> import kinestatics as ks
        >>> name_of(ks.load("planar_2r"), [[0.3, 0.0], [1.0, 0.0]], ["joint2"])
        'elbow'
        >>> name_of(ks.load("iiwa_14"), [[0.3, 0.0, 0.5, 0.9, 0.4, 0.0, 0.1]], ["joint_a2", "joint_a6"])
        'shoulder and wrist'
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
    anatomy = anatomy_of(model, at, tuple(found.rows), found.rank)
    if anatomy is None:
        return "other"
    held = frozenset(anatomy.places.index(column) for column in columns if column in anatomy.places)
    return _joined(_words(anatomy, anatomy.at(postures), held))


def _joined(words: frozenset[str]) -> str:
    named = [name for name in _NAMES if name in words]
    return f"{', '.join(named[:-1])} and {named[-1]}" if len(named) > 1 else "".join(named) or "other"


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


def _words(anatomy: Anatomy, blocks: list[Blocks], held: frozenset[int]) -> frozenset[str]:
    """The names that hold at all postures, those that are singular beyond their neighbours left out."""
    sigma = np.linalg.svd(np.stack([b.J for b in blocks]), compute_uv=False)
    ranks = (sigma > LOST * sigma[:, :1]).sum(-1)
    if ranks.max() >= anatomy.rank:
        return frozenset()
    general = [b for b, rank in zip(blocks, ranks, strict=True) if rank == ranks.max()]
    if any(b.S is None for b in general) or not anatomy.wrist:
        kept = general
    else:  # S is known as well as A can be inverted
        sure = [b for b in general if np.linalg.svd(b.A, compute_uv=False)[-1] > _NEAR]
        kept = sure or general
    return frozenset.intersection(*(_words_at(anatomy, b, held) for b in kept))


def _words_at(anatomy: Anatomy, b: Blocks, held: frozenset[int]) -> frozenset[str]:
    found = {name for name in ("shoulder", "elbow") if _wasted(anatomy, b, held, name)}
    if anatomy.parted and b.S is None:
        if held <= set(anatomy.wrist) or (anatomy.shoulder and anatomy.wrist[1] in held):
            found.add("wrist")
        return frozenset(found)
    if _stretched(anatomy, b, held):
        found.add("elbow")
    if b.S is not None and len(b.S) and b.S.shape[1] and _arm_loses(anatomy, b.S) and _shoulder(anatomy, b, held):
        found.add("shoulder")
    return frozenset(found)


def _arm_loses(anatomy: Anatomy, S: Array) -> bool:
    return rank_of(S, LOST * max(1.0, float(np.abs(S).max()))) < anatomy.rank - len(anatomy.wrist)


def _wasted(anatomy: Anatomy, b: Blocks, held: frozenset[int], name: str) -> bool:
    """Whether a part loses a freedom by itself, through its middle joint."""
    part = anatomy.shoulder if name == "shoulder" else anatomy.elbow
    if not part or part[1] not in held:
        return False
    if anatomy.redundant:
        return flat(b.axes, part, TOLERANCE)
    sigma = np.linalg.svd(b.twists[:, list(part)], compute_uv=False)
    return bool(sigma[-1] <= LOST * sigma[0])


def _lost(S: Array) -> Array | None:
    """The one linear direction that is lost; None where there are more, or none."""
    U, s, _ = np.linalg.svd(S)
    s = np.r_[s, np.zeros(len(U) - len(s))]
    lost = s <= LOST * max(1.0, s[0])
    return np.asarray(U[:, -1]) if lost.sum() == 1 else None


def _center(anatomy: Anatomy, axes: Axes) -> Array | None:
    """The wrist's centre: where its axes, or the first two, always meet; the tip where there is no wrist."""
    if len(anatomy.wrist) < 2:
        return axes.tip
    return common_point(axes, anatomy.center, TOLERANCE) if anatomy.center else None


def _stretched(anatomy: Anatomy, b: Blocks, held: frozenset[int]) -> bool:
    """Parallel axes and the centre in one plane, or a ball, the elbow and the centre on one line."""
    for group, (in_task, of_arm) in zip(anatomy.groups, anatomy.freedoms, strict=True):
        if group[1] not in held:
            continue
        if rank_of(b.J[:, list(group)], LOST) < in_task:
            return True
        inside = [anatomy.arm.index(k) for k in group if k in anatomy.arm]
        if b.S is not None and len(inside) > 1 and 0 < rank_of(b.S[:, inside], LOST) < of_arm:
            return True
    return _on_one_line(anatomy, b, held)


def _on_one_line(anatomy: Anatomy, b: Blocks, held: frozenset[int]) -> bool:
    """Whether the lost direction points from the ball that carries the elbow to the wrist's centre."""
    ball, bends = anatomy.ball, [k for k in anatomy.arm if k in b.axes.turning]
    if not ball or len(bends) == BALL or held & set(ball) or b.S is None or len(b.S) != BALL:
        return False
    lost, center = _lost(b.S), _center(anatomy, b.axes)
    start = b.axes.meeting(ball[0], ball[1], TOLERANCE)
    start = start if start is not None else b.axes.meeting(ball[1], ball[2], TOLERANCE)
    if lost is None or center is None or start is None:
        return False
    reach = center - start
    size = float(np.linalg.norm(reach))
    return size > GENERAL * b.axes.size and float(np.linalg.norm(np.cross(lost, reach))) <= TOLERANCE * size


def _shoulder(anatomy: Anatomy, b: Blocks, held: frozenset[int]) -> bool:
    S, turning = b.S, [i for i in anatomy.arm if i in b.axes.turning]
    if S is None or len(S) != BALL or not turning:
        return False
    if anatomy.ball == (0, 1, 2) and held <= set(anatomy.ball):
        return flat(b.axes, anatomy.ball, TOLERANCE)
    small = len(anatomy.arm) <= _SMALL_ARM
    idle = [i for i in turning if np.linalg.norm(S[:, i]) <= LOST]
    others = [i for i in range(S.shape[1]) if i not in idle]
    if idle and small and rank_of(S[:, others]) == len(others):
        return True
    lost = _lost(S)
    if lost is None or not anatomy.upright or turning[0] != 0:
        return False
    along = float(np.linalg.norm(np.cross(lost, b.axes.u[turning[1]])))
    behind = S[:, 1:] / max(float(np.abs(S[:, 1:]).max()), LOST)
    return along <= TOLERANCE and rank_of(behind) == BALL - 1
