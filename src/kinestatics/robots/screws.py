"""Product of exponentials: an arm from joint screws and a home pose. Floor 4. Source: MLS section 3.2."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import RobotDefinitionError
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR, LINEAR, split_pose, swap_order
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

    Example:
        >>> screw_axis((0, 0, 1), point=(1, 0, 0))
        array([ 0., -1.,  0.,  0.,  0.,  1.])
    """
    w = np.asarray(direction, dtype=float)
    length = np.linalg.norm(w)
    if w.shape != (3,) or not np.isfinite(length) or length == 0:
        raise RobotDefinitionError("KS211", f"direction {direction} is not a non-zero vector of 3 numbers")
    w = w / length
    if np.isinf(pitch):
        return np.concatenate([w, np.zeros(3)])
    return np.concatenate([np.cross(point, w) + pitch * w, w])


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
        RobotDefinitionError: KS205, KS210-KS214.

    Example:
        >>> import kinestatics as ks
        >>> axes = [ks.screw_axis((0, 0, 1)), ks.screw_axis((0, 0, 1), point=(1, 0, 0))]
        >>> ks.from_screws(axes, order="linear-angular").n
        2
    """
    if frame not in ("spatial", "body"):
        raise RobotDefinitionError("KS214", f"frame {frame!r} is not known", "say frame='spatial' or frame='body'")
    screws = _ordered(np.asarray(axes, dtype=float).reshape(-1, 6) if len(axes) else np.zeros((0, 6)), order)
    M = _checked_home(np.eye(4) if home is None else np.asarray(home, dtype=float))
    names = list(joint_names) if joint_names is not None else [f"joint{i + 1}" for i in range(len(screws))]
    for word, given in (("joint_names", names), ("limits", limits)):
        if given is not None and len(given) != len(screws):
            raise RobotDefinitionError("KS205", f"{word} has {len(given)} entries for {len(screws)} screws", "give one each")
    links, joints = [LinkDescription("base")], []
    for i, screw in enumerate(screws):
        kind = "prismatic" if not np.any(screw[ANGULAR]) else "helical" if _pitch(screw) else "continuous"
        lower, upper = limits[i] if limits is not None else (-np.inf, np.inf)
        placement = M if frame == "body" and i == 0 else np.eye(4)
        joints.append(JointDescription(names[i], kind, links[-1].name, f"link{i + 1}", placement, screw, lower, upper))
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
        if not np.all(np.isfinite(screw)):
            raise RobotDefinitionError("KS146", f"screw {i + 1} is not finite")
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


def _checked_home(M: Array) -> Array:
    if M.shape != (4, 4):
        raise RobotDefinitionError("KS212", f"home pose has shape {M.shape}; expected (4, 4)")
    R, _ = split_pose(M)
    residual = max(np.abs(R.T @ R - np.eye(3)).max(), abs(np.linalg.det(R) - 1), np.abs(M[3] - [0, 0, 0, 1]).max())
    if not residual <= 1e-9:
        raise RobotDefinitionError("KS212", f"home pose is not a rotation and a translation: residual {residual:.3g}")
    return M
