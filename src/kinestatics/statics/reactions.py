"""Free bodies: the wrench that every joint passes on, from the tips to the ground, and whether it all balances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import definition
from .._kernels import STANDARD_GRAVITY
from ..definition import JointPoses
from ..errors import UnknownNameError, nearest
from ..model import RobotModel
from ..namespaces import Array, Namespace
from ..spatial import ANGULAR, LINEAR, change_wrench_frame, cross, rotate, split_pose
from .loads import Load, Loads, load_place, statics_arguments
from .reactions_result import JointReactions

AXES = ("joint", "base")
_ELSEWHERE = (0.6, -0.48, 0.64)
"""A unit vector on which nothing lies by design: the balance is audited about a point in this direction."""


class _Action(NamedTuple):
    """A wrench on a body: six components in axes R (None: base axes) at the point p, seen from the base."""

    body: int  # 0 is the base and all that is fixed to it, i + 1 what moving joint i carries
    six: Array
    R: Array | None
    p: Array


def joint_reactions(
    model: RobotModel,
    q: Any,
    loads: Loads = None,
    *,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    axes: str = "joint",
    check_finite: bool = True,
) -> JointReactions:
    """What every joint carries while the arm is held still: six components, by free-body balance.

    Cut the arm at a joint: the wrench through the cut holds all that lies behind it. Found from the tips to the base,
    body by body, without a Jacobian; its component along the joint's screw is what the motor supplies, and the other
    five are what the bearing must bear.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        loads: as in `holding_torques`: a Wrench at the tip, {link: Wrench or list of them}, or [(link, Wrench), ...].
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.
        axes: "joint": each wrench in the axes of its joint; "base": in base axes. At the origin of the joint's frame.

    Returns:
        JointReactions, for every moving joint, followers of a mimic joint included.

    Raises:
        MissingMassError: KS320. ArrayTypeError: KS302. ConfigurationError: KS301, KS303.
        UnknownNameError: KS310, KS311; KS328 for axes of another name.

    Law: w_joint + Σ loads on the body + m g = Σ w of the joints behind it, for each body. Source: note 004, "statics".

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> r = ks.joint_reactions(arm, [0.0, 0.0], ks.Wrench.on_robot(force=(0, -10, 0)), gravity=None)
        >>> r.torques, r.base[:3], r.bending
        (array([20., 10.]), array([ 0., 10.,  0.]), array([0., 0.]))
    """
    if axes not in AXES:
        raise UnknownNameError("KS328", f"axes={axes!r} is not known", nearest(str(axes), AXES))
    applied, array, down, xp = statics_arguments(model, q, loads, gravity, check_finite)
    folding, heavy = xp.constant(model.folding, array), model.masses != 0
    own = definition.in_library(model, array, xp)
    poses = definition.joint_poses(own, array, xp)
    actions = [_of_load(own, poses, array, load, xp) for load in applied]
    if down is not None:
        pull = xp.constant(np.asarray(down), array)
        actions += [_of_weight(own, poses, array, int(link), pull, xp) for link in np.flatnonzero(heavy)]
    through, base = _balanced(own, actions, xp)
    batch = np.broadcast_shapes(tuple(array.shape[:-1]), *(tuple(a.six.shape[:-1]) for a in actions))
    written = [change_wrench_frame(w, R, p, xp) for w, R, p in zip(through, poses.R, poses.p, strict=True)]
    wrenches = _stacked(written, batch, array, xp)
    base = xp.broadcast(base, (*batch, 6))
    bearing = _bearing(own, wrenches, xp)
    imbalance, sizes = _audit(own, actions, poses, wrenches, base, _far_point(model, array, xp), xp)
    if axes == "base" and model.parents:
        R = xp.stack([xp.broadcast(R, (*batch, 3, 3)) for R in poses.R], -3)
        wrenches = xp.concat([rotate(R, wrenches[..., LINEAR]), rotate(R, wrenches[..., ANGULAR])], -1)
    residual, relative = _residuals(imbalance, sizes, xp)
    return JointReactions(
        robot=model.name,
        joints=model.moving_names,
        kinds=model.kinds,
        axes=axes,
        wrenches=wrenches,
        base=base,
        torques=(bearing["drive"][..., None, :] @ folding)[..., 0, :],
        **bearing,
        imbalance=imbalance,
        residual=residual,
        relative_residual=relative,
    )


def _of_load(model: RobotModel, poses: JointPoses, q: Array, load: Load, xp: Namespace) -> _Action:
    R, p = load_place(model, poses, q, load, xp)
    six = load.wrench.array
    six = xp.constant(six, q) if isinstance(six, np.ndarray) else six
    return _Action(model.link_joints[load.link] + 1, load.on_robot * six, R, p)


def _of_weight(model: RobotModel, poses: JointPoses, q: Array, link: int, pull: Array, xp: Namespace) -> _Action:
    _, center = definition.link_pose(model, poses, link, q, xp, model.centers_of_mass[link, ...])
    force = model.masses[link] * pull
    return _Action(model.link_joints[link] + 1, xp.concat([force, 0 * force], -1), None, center)


def _about(action: _Action, point: Array | None, xp: Namespace) -> Array:
    """The six components of an action in base axes, its moment about the base origin or about another point."""
    f, m = action.six[..., LINEAR], action.six[..., ANGULAR]
    if action.R is not None:
        f, m = rotate(action.R, f), rotate(action.R, m)
    lever = action.p if point is None else action.p - point
    moment = m + cross(lever, f, xp)
    return xp.concat([xp.broadcast(f, tuple(moment.shape)), moment], -1)


def _balanced(model: RobotModel, actions: Sequence[_Action], xp: Namespace) -> tuple[list[Array], Array]:
    """What each joint exerts on the body behind it, and the ground on the base: base axes, base origin."""
    needed: list[Array] = [xp.constant(np.zeros(6), model.placements) for _ in range(len(model.parents) + 1)]
    for action in actions:
        needed[action.body] = needed[action.body] - _about(action, None, xp)
    for i in range(len(model.parents) - 1, -1, -1):
        before = model.parents[i] + 1
        needed[before] = needed[before] + needed[i + 1]
    return needed[1:], needed[0]


def _stacked(rows: list[Array], batch: tuple[int, ...], q: Array, xp: Namespace) -> Array:
    if not rows:
        return xp.constant(np.zeros((*batch, 0, 6)), q)
    return xp.stack([xp.broadcast(row, (*batch, 6)) for row in rows], -2)


def _bearing(model: RobotModel, wrenches: Array, xp: Namespace) -> dict[str, Array]:
    """Each wrench taken apart along the joint's axis, the moment about the point of that axis nearest to the frame."""
    v, w = model.screws[..., LINEAR], model.screws[..., ANGULAR]
    slides = np.array([kind == "prismatic" for kind in model.kinds], dtype=bool)[:, None]
    axis = w + xp.constant(slides.astype(float), w) * v
    f, m = wrenches[..., LINEAR], wrenches[..., ANGULAR]
    m = m - cross(cross(w, v, xp), f, xp)
    axial, torsion = (f * axis).sum(-1), (m * axis).sum(-1)
    return {
        "radial": _length(f - axial[..., None] * axis, xp),
        "axial": axial,
        "bending": _length(m - torsion[..., None] * axis, xp),
        "torsion": torsion,
        "drive": (wrenches * model.screws).sum(-1),
    }


def _length(vector: Array, xp: Namespace) -> Array:
    squares = (vector * vector).sum(-1)
    if xp.name != "sympy":
        return squares**0.5
    import sympy

    return np.vectorize(sympy.sqrt, otypes=[object])(squares) if squares.size else squares


def _far_point(model: RobotModel, q: Array, xp: Namespace) -> Array:
    """A point off the base origin, as far as the robot is large, or at (3, -2, 5) m where lengths are symbols."""
    if xp.name == "sympy":
        return xp.constant(np.array([3.0, -2.0, 5.0]), q)
    lengths = (split_pose(model.placements)[1], split_pose(model.link_placements)[1])
    size = sum(float(np.abs(length).max(initial=0.0)) for length in lengths)
    return xp.constant((size or 1.0) * np.array(_ELSEWHERE), q)


def _audit(
    model: RobotModel,
    actions: Sequence[_Action],
    poses: JointPoses,
    wrenches: Array,
    base: Array,
    point: Array,
    xp: Namespace,
) -> tuple[Array, Array | None]:
    """Sums of all that acts on the whole arm and on each body about another point, (..., m + 2, 6), and sums of sizes.

    The wrenches are those of the result, in joint axes: what is audited is what is returned. Symbols have no size.
    """
    ground = _about(_Action(0, base, None, 0 * point), point, xp)
    rows: list[list[Array]] = [[ground], [ground], *([] for _ in model.parents)]
    for action in actions:
        six = _about(action, point, xp)
        rows[0].append(six)
        rows[action.body + 1].append(six)
    for i, parent in enumerate(model.parents):
        six = _about(_Action(i + 1, wrenches[..., i, :], poses.R[i], poses.p[i]), point, xp)
        rows[i + 2].append(six)
        rows[parent + 2].append(-six)
    shape = tuple(base.shape)
    sums = xp.stack([xp.broadcast(sum(row[1:], row[0]), shape) for row in rows], -2)
    if xp.name == "sympy":
        return sums, None
    return sums, xp.stack([xp.broadcast(sum((abs(six) for six in row[1:]), abs(row[0])), shape) for row in rows], -2)


def _residuals(imbalance: Array, sizes: Array | None, xp: Namespace) -> tuple[Array | None, Array | None]:
    """The largest imbalance, and the same as a share of the forces or moments at play; None for symbols."""
    if sizes is None:
        return None, None
    largest = [_largest(abs(imbalance[..., part]), xp) for part in (LINEAR, ANGULAR)]
    scales = [_largest(sizes[..., part], xp) for part in (LINEAR, ANGULAR)]
    shares = [a / (scale + (scale == 0)) for a, scale in zip(largest, scales, strict=True)]
    return _largest(xp.stack(largest, -1)[..., None], xp), _largest(xp.stack(shares, -1)[..., None], xp)


def _largest(array: Array, xp: Namespace) -> Array:
    """The largest entry over the last two axes."""
    return array.amax((-2, -1)) if xp.name == "torch" else array.max((-2, -1))
