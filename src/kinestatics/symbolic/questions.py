"""What a closed form answers: the quantity, link, frame and rows, made exact, and the mechanism in polynomials. Floor 7."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .._kernels import STANDARD_GRAVITY
from ..errors import (
    ArrayTypeError,
    ConfigurationError,
    FrameMismatchError,
    MissingMassError,
    UnknownNameError,
    nearest,
)
from ..frames import BASE, Frame
from ..kinematics import named_frame
from ..model import RobotModel
from ..quantities import Wrench
from ..spatial import ROW_NAMES, WRENCH_NAMES
from ..tasks import find_task
from .exact import fraction, free_symbols, joint_symbols
from .mechanism import Mechanism
from .values import center_of, exact_value, exact_values, fresh, in_numbers

OPTIONS = {
    "pose": {"point"},
    "jacobian": {"point", "frame", "task"},
    "velocity": {"point", "frame", "task", "qd"},
    "acceleration": {"point", "frame", "task", "qd", "qdd"},
    "gravity_torques": {"gravity"},
    "joint_torques": {"point", "frame", "wrench"},
    "determinant": {"point", "frame", "task"},
    "minors": {"point", "frame", "task"},
}
QUANTITIES = tuple(OPTIONS)


@dataclass(frozen=True, eq=False)
class Question:
    """What a closed form answers, so that it can be derived step by step and compared with numbers.

    Attributes:
        model: exact; mechanism: its polynomials; link: name of the link; point: (3) of it.
        frame: axes and origin of the rows, None where they do not matter or are those of a middle joint.
        automatic: whether the frame is left to the answer.
        offset: (3) of the frame's origin, exact; rows: the rows in play.
        qd, qdd, wrench, gravity: as given, exact.
    """

    quantity: str
    model: RobotModel
    mechanism: Mechanism
    link: str
    point: tuple[Any, ...]
    frame: Frame | None
    automatic: bool
    offset: tuple[Any, ...]
    rows: tuple[int, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]
    wrench: tuple[Any, ...]
    gravity: tuple[Any, ...]


def check_options(quantity: Any, given: Mapping[str, Any], lengths: Any) -> None:
    """Raises UnknownNameError or ConfigurationError (KS393) unless the quantity exists and takes the options given."""
    if not isinstance(quantity, str) or quantity not in OPTIONS:
        hint = nearest(str(quantity), QUANTITIES) or f"known: {', '.join(QUANTITIES)}"
        raise UnknownNameError("KS393", f"there is no closed form of {quantity!r}", hint)
    for name, value in given.items():
        if value is not None and name not in OPTIONS[quantity]:
            takes = ", ".join(sorted(OPTIONS[quantity]))
            raise ConfigurationError("KS393", f"{quantity!r} takes no {name}=", f"it takes {takes}")
    if lengths not in ("numbers", "symbols"):
        raise ConfigurationError("KS393", f"lengths is {lengths!r}", "say lengths='numbers' or lengths='symbols'")


def require_masses(model: RobotModel) -> None:
    """Raises MissingMassError (KS320) where the robot has none."""
    if not model.has_masses:
        hint = "its description gives none; a result of zero would be wrong, not light"
        raise MissingMassError("KS320", f"robot {model.name!r} has no masses", hint)


def asked(quantity: str, model: RobotModel, numbers: RobotModel, at: str, given: Mapping[str, Any]) -> Question:
    """The question, its arguments exact and its mechanism built."""
    import sympy

    link = model.link(at)
    name = model.link_name(link)
    point = exact_values("point", given["point"], 3) or (sympy.Integer(0),) * 3
    frame, offset = _frame_of(model, name, point, given)
    rows = _rows_of(quantity, numbers, name, frame, given["task"])
    taken = {str(x) for x in free_symbols(model)} | {str(x) for x in joint_symbols(model)}
    taken |= {str(x) for value in (*point, *offset) for x in value.free_symbols}
    letter = str(joint_symbols(model)[0]).rstrip("0123456789") if model.n else "q"
    n = model.n
    qd = exact_values("qd", given["qd"], n) or fresh([f"{letter}d{k + 1}" for k in range(n)], taken)
    qdd = exact_values("qdd", given["qdd"], n) or fresh([f"{letter}dd{k + 1}" for k in range(n)], taken)
    wrench = _wrench_of(model, frame, name, given["wrench"]) or fresh(WRENCH_NAMES, taken)
    gravity = exact_values("gravity", given["gravity"], 3) or tuple(map(fraction, STANDARD_GRAVITY))
    links = [link, *_links_of(quantity, model, link, frame, given["frame"] is None)]
    used = {"velocity": qd, "acceleration": (*qd, *qdd), "joint_torques": wrench}.get(quantity, ())
    entries, symbols = [*point, *offset], [x for x in used if x.is_Symbol]
    entries += [x for x in used if not x.is_Symbol]
    if quantity == "gravity_torques":
        entries += [*gravity, *(x for i in links for x in (exact_value(model.masses[i]), *center_of(model, i)))]
    mechanism = Mechanism.of(model, links, entries, symbols)
    automatic = given["frame"] is None
    return Question(quantity, model, mechanism, name, point, frame, automatic, offset, rows, qd, qdd, wrench, gravity)


def _frame_of(
    model: RobotModel, name: str, point: tuple[Any, ...], given: Mapping[str, Any]
) -> tuple[Frame, tuple[Any, ...]]:
    """The frame asked for, or the geometric one, and the exact offset of its origin; that of the frame is in numbers."""
    frame = given["frame"]
    if frame is None:
        frame, offset = Frame(BASE, name), point
    else:
        if not isinstance(frame, Frame):
            hint = "frame='auto', or ks.Frame.body(), ks.Frame.spatial(), ks.Frame(axes, origin)"
            raise ArrayTypeError("KS302", f"frame is {frame!r}; expected a Frame", hint)
        own = model.link(frame.origin) == model.link(name) and given["point"] is not None
        offset = point if own else tuple(exact_value(x) for x in frame.offset)
    plain = all(x.is_number for x in offset)
    x, y, z = map(float, offset) if plain else (0.0, 0.0, 0.0)
    named = named_frame(model, frame._replace(offset=(x, y, z)))
    return named, offset


def _rows_of(quantity: str, model: RobotModel, name: str, frame: Frame, task: Any) -> tuple[int, ...]:
    if quantity not in ("determinant", "minors") and task is None:
        return tuple(range(len(ROW_NAMES)))
    return find_task(in_numbers(model), "auto" if task is None else task, name, frame).rows


def _wrench_of(model: RobotModel, frame: Frame, name: str, wrench: Any) -> tuple[Any, ...]:
    if not isinstance(wrench, Wrench):
        return exact_values("wrench", wrench, len(WRENCH_NAMES))
    written = wrench.frame if wrench.frame != Frame() else Frame(BASE, name, frame.offset)
    if named_frame(model, written) != frame:
        hint = "closed_form(..., frame=wrench.frame), or the six numbers as they are in this frame"
        raise FrameMismatchError(
            "KS330", f"the rows ({frame}) and the wrench ({wrench.frame}) are written in different frames", hint
        )
    six = exact_values("wrench", wrench.array, len(WRENCH_NAMES))
    return six if wrench.acts_on == "environment" else tuple(-x for x in six)


def _links_of(quantity: str, model: RobotModel, link: int, frame: Frame, automatic: bool) -> list[int]:
    """The other links whose frames or masses are needed."""
    if quantity == "gravity_torques":
        moved = [i for i, joint in enumerate(model.link_joints) if joint >= 0]
        return [i for i in moved if exact_value(model.masses[i]) != 0]
    found = [model.link(frame.axes), model.link(frame.origin)]
    if quantity == "jacobian" and automatic:
        found += between(model, link)
    return found


def between(model: RobotModel, link: int) -> list[int]:
    """One link for each joint that carries a link, base first; the last is the link itself."""
    path = model.path(model.link_joints[link])
    found = [model.link_joints.index(i) if i in model.link_joints else -1 for i in path]
    return [i for i in found[:-1] if i >= 0] + [link] * bool(path)
