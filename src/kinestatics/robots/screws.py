"""Product of exponentials: an arm from joint screws and a home pose. Floor 4. Source: MLS section 3.2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import RobotDefinitionError
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR, LINEAR, swap_order
from .arguments import checked_array, checked_joints, checked_list, checked_number, checked_pose, unit_direction
from .assemble import assemble
from .description import JointDescription, LinkDescription, RobotDescription

ORDERS = ("linear-angular", "angular-linear")
_UNIT_TOLERANCE = 1e-9


def screw_axis(direction: Sequence[float], point: Sequence[float] = (0, 0, 0), pitch: float = 0.0) -> Array:
    """Unit screw (v, ω) of an axis, linear part first.

    Law: ω is the unit direction, v = -ω × point + pitch ω; an infinite pitch is a pure translation (0 rotation).

    Args:
        direction: (3) any length but zero.
        point: (3) any point of the axis [m].
        pitch: advance per radian [m/rad]; math.inf for a prismatic joint.

    Returns:
        (6) unit screw.

    Raises:
        RobotDefinitionError: KS206-KS208, KS211.

    Example:
        >>> screw_axis((0, 0, 1), point=(1, 0, 0))
        array([ 0., -1.,  0.,  0.,  0.,  1.])
    """
    w, length = unit_direction(_numeric(direction, (3,), "direction"))
    if length == 0:
        raise RobotDefinitionError("KS211", f"direction {direction} is not a non-zero vector of 3 numbers")
    advance = checked_number(pitch, "pitch", infinite=True)
    if np.isinf(advance):
        return np.concatenate([w, np.zeros(3)])
    return np.concatenate([np.cross(_numeric(point, (3,), "point"), w) + advance * w, w])


def _numeric(value: Any, shape: tuple[int, ...], what: str) -> Array:
    array = checked_array(value, shape, what)
    if array.dtype == object:
        raise RobotDefinitionError("KS207", f"{what} holds symbols; screws take numbers", "use from_dh for symbolic lengths")
    return array


def from_screws(
    axes: Sequence[Sequence[float]],
    home: Array | None = None,
    *,
    order: str | None = None,
    frame: str = "spatial",
    name: str = "arm",
    joint_names: Sequence[str] | None = None,
    limits: Sequence[tuple[float, float]] | None = None,
) -> RobotModel:
    """An arm from unit screws at the zero configuration (product of exponentials). Revolute, prismatic and helical.

    Law: T(q) = exp(S1 q1) ... exp(Sn qn) M for spatial screws, M exp(B1 q1) ... exp(Bn qn) for body screws.

    Args:
        axes: n unit screws of 6 numbers: |ω| = 1, or ω = 0 and |v| = 1.
        home: (4, 4) pose M of the tip at zero [m]; default identity.
        order: "linear-angular" (v, ω) or "angular-linear" (ω, v); may be left out only when one order alone fits.
        frame: "spatial" (screws seen from the base) or "body" (seen from the tip at zero).
        name, joint_names, limits: as in `from_dh`.

    Raises:
        RobotDefinitionError: KS131, KS152, KS205-KS208, KS210-KS214.

    Example:
        >>> import kinestatics as ks
        >>> axes = [ks.screw_axis((0, 0, 1)), ks.screw_axis((0, 0, 1), point=(1, 0, 0))]
        >>> ks.from_screws(axes, order="linear-angular").n
        2
    """
    if frame not in ("spatial", "body"):
        raise RobotDefinitionError("KS214", f"frame {frame!r} is not known", "say frame='spatial' or frame='body'")
    rows = checked_list(axes, None, "axes", "joint")
    screws = _ordered(_numeric(rows, (-1, 6), "axes") if rows else np.zeros((0, 6)), order)
    M = np.eye(4) if home is None else _numeric(checked_pose(home, "home pose"), (4, 4), "home pose")
    names, bounds = checked_joints(joint_names, limits, len(screws), "screw")
    links, joints = [LinkDescription("base")], []
    for i, screw in enumerate(screws):
        turning = "helical" if _pitch(screw) else "continuous" if limits is None else "revolute"
        kind = turning if np.any(screw[ANGULAR]) else "prismatic"
        placement = M if frame == "body" and i == 0 else np.eye(4)
        joints.append(JointDescription(names[i], kind, links[-1].name, f"link{i + 1}", placement, screw, *bounds[i]))
        links.append(LinkDescription(f"link{i + 1}"))
    last = M if frame == "spatial" or not joints else np.eye(4)
    joints.append(JointDescription("tip_joint", "fixed", links[-1].name, "tool", last))
    links.append(LinkDescription("tool"))
    source = f"product of exponentials of {len(screws)} {frame} screws"
    return assemble(RobotDescription(name, tuple(links), tuple(joints), source, tip="tool"))


def _pitch(screw: Array) -> bool:
    return bool(abs(screw[LINEAR] @ screw[ANGULAR]) > _UNIT_TOLERANCE)


def _is_unit(screw: Array) -> bool:
    w, v = np.linalg.norm(screw[ANGULAR]), np.linalg.norm(screw[LINEAR])
    return bool(abs(w - 1) < _UNIT_TOLERANCE or (w == 0 and abs(v - 1) < _UNIT_TOLERANCE))


def _ordered(screws: Array, order: str | None) -> Array:
    """The screws with the linear part first, checked to be unit screws."""
    swapped = swap_order(screws)
    if order is None:
        linear_first, angular_first = (all(_is_unit(s) for s in candidate) for candidate in (screws, swapped))
        if angular_first and len(screws):
            seen = "either order fits" if linear_first else "they fit angular first only"
            raise RobotDefinitionError(
                "KS213", f"linear first or angular first? {seen}", "say order='linear-angular' or order='angular-linear'"
            )
    elif order not in ORDERS:
        raise RobotDefinitionError(
            "KS213", f"order {order!r} is not known", "say order='linear-angular' or 'angular-linear'"
        )
    elif order == "angular-linear":
        screws = swapped
    for i, screw in enumerate(screws):
        if not np.any(screw):
            raise RobotDefinitionError("KS211", f"screw {i + 1} is zero")
        if not _is_unit(screw):
            length = np.linalg.norm(screw[ANGULAR])
            raise RobotDefinitionError(
                "KS210",
                f"screw {i + 1}: rotation part has length {length:g}; expected 0 (with |v| = 1) or 1",
                "divide by it",
            )
    return screws
