"""Which wrenches act on which links: the one way to say it, and the torques that hold them together with the weight."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import definition
from .._kernels import STANDARD_GRAVITY
from ..definition import JointPoses
from ..errors import ArrayTypeError
from ..frames import TIP, Frame
from ..kinematics import configuration, jacobian, named_frame, require_model
from ..model import RobotModel
from ..namespaces import Array, Namespace
from ..quantities import Wrench, check_batches, in_one_library
from .gravity import checked_gravity, gravity_torques, missing_masses
from .torques import joint_torques, require_finite

Loads = Wrench | Mapping[str, Wrench | Sequence[Wrench]] | Sequence[Wrench] | Sequence[tuple[str, Wrench]] | None
"""A wrench or several at the tip, {link: wrench or wrenches}, [(link, wrench), ...], or none.

A wrench of the default frame is in base axes, at the origin of the link it acts on (displaced by the frame's offset);
every other frame of the robot is taken as it says. `Wrench.on_robot` is a load, `Wrench.on_environment` a push.
"""
_LARGEST = 1e150  # numbers from here on cannot be squared
_HINT = "Wrench.on_robot(force=...) for a load at the tip, {'link': wrench or list of them}, or [('link', wrench), ...]"


class Load(NamedTuple):
    """A wrench and the link it acts on, or through which the robot exerts it.

    Attributes:
        link: index; wrench: in a frame with link names.
    """

    link: int
    wrench: Wrench

    @property
    def on_robot(self) -> int:
        """1 for a load on the robot, -1 for a push, whose reaction acts on the robot."""
        return 1 if self.wrench.acts_on == "robot" else -1


def holding_torques(
    model: RobotModel,
    q: Any,
    loads: Loads = None,
    *,
    gravity: Sequence[float] | None = STANDARD_GRAVITY,
    check_finite: bool = True,
) -> Array:
    """What the motors must supply to hold still: the arm's own weight, and every load and push.

    Args:
        model: the robot.
        q: (..., n) [rad or m].
        loads: a Wrench at the tip, {link: Wrench or list of them}, or [(link, Wrench), ...]. A wrench of the default
            frame is in base axes at the origin of its link; `Wrench.on_robot` and `Wrench.on_environment` say who acts.
        gravity: (3) in base axes [m/s²]; None leaves the weight of the arm out.

    Returns:
        (..., n) [N m, or N for a prismatic joint].

    Raises:
        MissingMassError: KS320, no masses are known, and gravity is not None.
        ArrayTypeError: KS302, loads of another form. UnknownNameError: KS310, KS311.
        ConfigurationError: KS301 a wrench is not finite, KS303 batches do not fit.

    Law: virtual work, τ · δq = δU - Σ w · V δt over the loads on the robot. Source: note 000; MLS section 3.4.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> ks.holding_torques(arm, [0.0, 0.0], ks.Wrench.on_robot(force=(0, -10, 0)), gravity=None)
        array([20., 10.])
    """
    applied, array, _, xp = statics_arguments(model, q, loads, gravity, check_finite)
    total = xp.constant(np.zeros(tuple(array.shape)), array)
    if gravity is not None:
        total = gravity_torques(model, array, gravity=gravity, check_finite=False)
    for load in applied:
        J = jacobian(model, array, at=model.link_name(load.link), frame=load.wrench.frame, check_finite=False)
        total = total + joint_torques(J, load.wrench)
    return total


def statics_arguments(
    model: RobotModel, q: Any, loads: Loads, gravity: Any, check_finite: bool
) -> tuple[tuple[Load, ...], Array, Array | None, Namespace]:
    """The loads, q and gravity (None: left out) of a question about the whole arm, checked, and their common library."""
    require_model(model)
    if gravity is not None and not model.has_masses:
        raise missing_masses(model, "its description gives none; gravity=None leaves the weight of the arm out")
    applied = applied_loads(model, loads)
    array, _ = configuration(model, q, check_finite)
    down = None if gravity is None else checked_gravity(gravity)
    together = {"q": array} if down is None else {"q": array, "gravity": down}
    together |= {f"load {k + 1}": load.wrench.array for k, load in enumerate(applied)}
    (array, *_), xp = in_one_library(together)
    batch: tuple[int, ...] = tuple(array.shape[:-1])
    for load in applied:
        own_batch = tuple(load.wrench.array.shape[:-1])
        check_batches("q and the loads before", batch, f"the load on {model.link_names[load.link]!r}", own_batch)
        batch = np.broadcast_shapes(batch, own_batch)
    return applied, array, down, xp


def applied_loads(model: RobotModel, loads: Loads) -> tuple[Load, ...]:
    """Every load of a question, with its link and with its frame named.

    Raises:
        ArrayTypeError: KS302. UnknownNameError: KS310, KS311. ConfigurationError: KS301.
    """
    return tuple(_load(model, name, wrench) for name, wrench in _pairs(loads))


def _pairs(loads: Any) -> Iterator[tuple[Any, Any]]:
    if loads is None:
        return
    if isinstance(loads, Wrench):
        yield TIP, loads
    elif isinstance(loads, Mapping):
        for name, wrenches in loads.items():
            several = wrenches if isinstance(wrenches, list | tuple) else [wrenches]
            yield from ((name, wrench) for wrench in several)
    else:
        for pair in _listed(loads):
            if isinstance(pair, Wrench):
                yield TIP, pair
                continue
            if not (isinstance(pair, list | tuple) and len(pair) == 2):
                raise ArrayTypeError("KS302", f"loads hold a {type(pair).__name__}; expected (link, wrench)", _HINT)
            yield pair[0], pair[1]


def _listed(value: Any) -> Sequence[Any]:
    if not isinstance(value, list | tuple):
        raise ArrayTypeError("KS302", f"loads are given as {type(value).__name__}", _HINT)
    return value


def _load(model: RobotModel, name: Any, wrench: Any) -> Load:
    if not isinstance(wrench, Wrench):
        hint = "Wrench.on_robot(force=...) for a load, Wrench.on_environment(...) for a push"
        raise ArrayTypeError("KS302", f"the load on {name!r} is a {type(wrench).__name__}; expected a Wrench", hint)
    link = model.link(name)
    require_finite(wrench.array, f"the load on {name!r}", _LARGEST)
    default = Frame()
    frame = wrench.frame
    if isinstance(frame, Frame) and (frame.axes, frame.origin) == (default.axes, default.origin):
        frame = Frame(default.axes, model.link_name(link), frame.offset)
    return Load(link, Wrench(wrench.array, named_frame(model, frame), wrench.acts_on))


def load_place(model: RobotModel, poses: JointPoses, q: Array, load: Load, xp: Namespace) -> tuple[Array, Array]:
    """Axes (..., 3, 3) and point (..., 3) of a load's frame, in base axes; the model's arrays are those of the library."""
    frame = load.wrench.frame
    R, _ = definition.link_pose(model, poses, model.link(frame.axes), q, xp)
    offset = xp.constant(np.asarray(frame.offset), q)
    _, p = definition.link_pose(model, poses, model.link(frame.origin), q, xp, offset)
    return R, p
