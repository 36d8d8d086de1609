"""Who holds a load: the motors, the structure, or nobody."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._kernels import ALL_ROWS
from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace
from ..quantities import TIED, Jacobian, Wrench, check_batches, format_number, in_one_library, numeric, plain, table, wrapped
from ..spatial import WRENCH_NAMES, size_weights
from ..tasks import Task, model_of, task_of
from .capacity import EffortLimits, checked_effort_limits
from .subspaces import RANK_TOLERANCE, SAFE, check_length, jacobian_array, mask_of, rounding, spectrum
from .torques import joint_torques


@dataclass(frozen=True, eq=False)
class LoadSplit:
    """A wrench at a link as the sum of three, at right angles in the size |(f, τ / length)|. `print` it, or `to_dict()`.

    Attributes:
        load: (..., 6) what was asked about, in the frame of the Jacobian, like its parts:
        active: what the motors hold; of a push, what they make. It alone needs joint torques.
        structure: what no joint feels. Of a load, held for free. Of a push, nothing the motors can make: it is only there
            as the answer to what the surroundings push with.
        impossible: what would move joints that cannot be driven; zero if there are none. While it is not zero, the load as a
            whole is not held.
        joint_torques: (..., n) for `active` (the other two need none) [N m or N].
        utilisation: (..., n) |torque| / limit, zero where the limit is infinite (unknown) and at joints without a motor.
        effort_limits: (n) [N m or N]; zero for a joint that cannot be driven, infinite where unknown.
        joint_names: (n); kinds: (n) of the joints; link: at which the load acts.
        task: the components in which the parts are at right angles; what is outside them, no joint feels.
        length: [m]; tolerance: the share of the largest singular value, and of the load, that counts as zero.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> print(ks.split_load(J, ks.Wrench.on_robot(force=(-30, -10, 0)), effort_limits=(40, 40)))
        load on the robot at tip: fx -30, fy -10, axes of base, at the origin of tip
          held by the motors:     fy -10
          held by the structure:  fx -30 (no joint feels it)
                  torque  limit  share
          joint1  20 N m     40    50%  most used
          joint2  10 N m     40    25%
    """

    load: Wrench
    active: Wrench
    structure: Wrench
    impossible: Wrench
    joint_torques: Array
    utilisation: Array
    effort_limits: Array
    joint_names: tuple[str, ...]
    kinds: tuple[str, ...]
    link: str
    task: Task
    length: float
    tolerance: float

    @property
    def passive(self) -> tuple[str, ...]:
        """Names of the joints that cannot be driven: their effort limit is zero."""
        return tuple(name for name, limit in zip(self.joint_names, self.effort_limits, strict=True) if limit == 0)

    @property
    def limiting_joint(self) -> Any:
        """(...) the joint whose motor is used most; None (in a batch "") where none with a known limit is used."""
        shares = numeric(self.utilisation)
        if not self.joint_names:
            return None if shares.ndim == 1 else np.full(shares.shape[:-1], "")
        names = np.where(shares.max(-1) > 0, np.array(self.joint_names)[shares.argmax(-1)], "")
        return names if names.ndim else (str(names) or None)

    @property
    def holds(self) -> Any:
        """(...) whether the whole load is held: nothing impossible, and no motor beyond its limit."""
        weights = size_weights(self.length)
        missing, whole = (np.linalg.norm(numeric(w.array) / weights, axis=-1) for w in (self.impossible, self.load))
        held = (missing <= self.tolerance * whole) & (numeric(self.utilisation).max(-1, initial=0.0) <= 1)
        return held if held.ndim else bool(held)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; unknown limits are None."""
        parts = {"load": self.load, "active": self.active, "structure": self.structure, "impossible": self.impossible}
        return {
            **{name: wrench.to_dict() for name, wrench in parts.items()},
            "link": self.link,
            "joints": list(self.joint_names),
            "joint_torques": plain(self.joint_torques),
            "effort_limits": plain(self.effort_limits),
            "utilisation": plain(self.utilisation),
            "limiting_joint": plain(self.limiting_joint),
            "passive": list(self.passive),
            "holds": plain(self.holds),
            "components": [WRENCH_NAMES[row] for row in self.task.rows],
            "reason": self.task.reason,
            "length": self.length,
            "tolerance": self.tolerance,
        }

    def __str__(self) -> str:
        return "\n".join([self.words, *(self._table() if self.load.array.ndim == 1 else [])])

    @property
    def words(self) -> str:
        """Who holds what, without the table of torques."""
        push = self.load.acts_on == "environment"
        head = f"{'push of the robot on its surroundings' if push else 'load on the robot'} at {self.link}: "
        if self.active.array.ndim > 1:
            shape, held = tuple(self.active.array.shape[:-1]), int(np.sum(self.holds))
            return wrapped(head, f"batch of shape {shape}, {held} held; {self.load.frame}", hang=2 - len(head))
        size = np.abs(numeric(self.load.array)).max()
        verb = "made" if push else "held"
        lines = [wrapped(head, f"{_words(self.load, size)}, {self.load.frame}", hang=2 - len(head))]
        lines.append(wrapped(f"  {verb} by the motors:     ", _words(self.active, size)))
        free = "no motor can make it, only resist it" if push else "no joint feels it"
        lines.append(wrapped("  held by the structure:  ", f"{_words(self.structure, size)} ({free})"))
        if self.passive:
            reason = f"it would move {', '.join(self.passive)}, without motor"
            lines.append(wrapped(f"  not to be {verb}:         ", f"{_words(self.impossible, size)} ({reason})"))
        return "\n".join(lines)

    def _table(self) -> list[str]:
        if not self.joint_names:
            return []
        units = ["N" if kind == "prismatic" else "N m" for kind in self.kinds]
        torques, shares = numeric(self.joint_torques), numeric(self.utilisation)
        size = np.abs(torques).max()
        torques = np.where(np.abs(torques) < 1e-9 * size, 0.0, torques)
        rows = [["", "torque", "limit", "share"]]
        for name, torque, limit, share, unit in zip(
            self.joint_names, torques, self.effort_limits, shares, units, strict=True
        ):
            cells = [f"{format_number(torque)} {unit}", format_number(limit), f"{100 * share * (torque != 0):.3g}%"]
            rows.append([name, *cells] if 0 < limit < np.inf else [name, cells[0], "unknown" if limit else "no motor", ""])
        most = self.limiting_joint
        marked = [f"{line}  most used" if name == most else line for (name, *_), line in _lines(rows)]
        return [f"  {line}" for line in marked]


def _lines(rows: list[list[str]]) -> list[tuple[list[str], str]]:
    return list(zip(rows, table(rows).split("\n"), strict=True))


def _clean(x: Any, size: Any) -> str:
    return format_number(0.0 if abs(x) < 1e-9 * size else x)


def _words(wrench: Wrench, size: Any) -> str:
    """The components that are not zero beside `size`."""
    values = [(name, _clean(x, size)) for name, x in zip(WRENCH_NAMES, numeric(wrench.array), strict=True)]
    return ", ".join(f"{name}{TIED}{text}" for name, text in values if text != "0") or "nothing"


def split_load(
    J: Jacobian,
    load: Wrench,
    *,
    effort_limits: EffortLimits = None,
    task: str | Sequence[str] | Sequence[int] = "auto",
    length: float = 1.0,
    tolerance: float = RANK_TOLERANCE,
) -> LoadSplit:
    """Which part of a load the motors hold, which the structure, and which nobody can.

    Args:
        J: Jacobian (..., 6, n) of the link the load acts at; NumPy, JAX or PyTorch.
        load: (..., 6) in the frame of J, on the robot or on the environment.
        effort_limits: (n) or {joint: limit} [N m or N] instead of the robot's own; 0 for a joint that cannot be driven.
        task: the components that are divided up, as in `find_task`; what no joint feels in any posture is left to the
            structure. "auto" takes force alone for an arm whose position accounts for all its freedoms (a planar 2R arm),
            if the load has no moment that a joint feels; else all components that joints feel.
        length: [m], the size of a wrench is |(f, τ / length)|; "at right angles" is meant in it, and with another length
            the parts differ wherever force and moment are bound together.
        tolerance: singular values below this fraction of the largest count as zero.

    Returns:
        LoadSplit: load = active + structure + impossible, three Wrenches on the same body as the load.

    Raises:
        FrameMismatchError: KS330. ArrayTypeError: KS302, symbols too. UnknownNameError: KS318, KS313.
        ConfigurationError: KS301; KS303, also for a load outside the task that joints feel.

    Law: let W = diag(1, 1, 1, length, length, length), S = W J (rows of the task) and x = W⁻¹ w, so that Jᵀ w = Sᵀ x. Of x,
    `impossible` is the part in the range of the columns of joints without a motor, `structure` the part in null(Sᵀ), and
    `active` the rest: it is in the range of S, and joints without a motor do not feel it. The three are at right angles.
    Source: note 000, "The robot can resist arbitrary externally applied forces/torques in Null(Jᵀ) without moving".

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
        >>> split = ks.split_load(J, ks.Wrench.on_robot(force=(-30, -10, 0)))
        >>> split.joint_torques.round(9), split.structure.force[0].round(9)
        (array([20., 10.]), np.float64(-30.0))
    """
    jacobian_array(J, "split_load")
    if not isinstance(load, Wrench):
        hint = "Wrench.on_robot(force=...) for a load, Wrench.on_environment(...) for a push"
        raise ArrayTypeError("KS302", f"load is a {type(load).__name__}; expected a Wrench", hint)
    J.require_frame(load.frame, "load")
    check_length(length)
    (matrix, six), xp = in_one_library({"the Jacobian": J.array, "the load": load.array})
    if xp.name == "sympy":
        raise ArrayTypeError("KS302", "who holds a load depends on ranks, and ranks on numbers", "put numbers in first")
    if xp.name == "numpy" and not np.all(np.isfinite(six)):
        raise ConfigurationError("KS301", "the load holds numbers that are not finite", "give finite numbers")
    check_batches("the Jacobian", matrix.shape[:-2], "the load", six.shape[:-1])
    limits, found = checked_effort_limits(model_of(J), effort_limits), _task(J, six, task)
    divided = _divide(matrix, six, xp, found, limits == 0, length, tolerance)
    active, structure, impossible = (Wrench(part, J.frame, load.acts_on) for part in divided)
    torques = joint_torques(J, active)
    known = np.isfinite(limits) & (limits > 0)
    return LoadSplit(
        load=Wrench(six, J.frame, load.acts_on),
        active=active,
        structure=structure,
        impossible=impossible,
        joint_torques=torques,
        utilisation=abs(torques) * xp.constant(np.where(known, 1 / np.where(known, limits, 1.0), 0.0), matrix),
        effort_limits=limits,
        joint_names=J.joint_names,
        kinds=model_of(J).joint_kinds,
        link=J.link,
        task=found,
        length=length,
        tolerance=max(tolerance, SAFE * rounding(matrix)),
    )


def _task(J: Jacobian, six: Array, task: Any) -> Task:
    """The components to divide up: none outside may be felt by a joint."""
    found = task_of(J, task)
    felt = tuple(row for row in ALL_ROWS if task_of(J, (row,)).rank)
    outside = [row for row in felt if row not in found.rows]
    if not outside:
        return found
    try:
        loaded = [WRENCH_NAMES[row] for row in outside if np.any(numeric(six[..., row]))]
    except TypeError:  # traced by JAX: no numbers to look at
        raise ArrayTypeError("KS302", "the components of a traced load are not known", "say task='full'") from None
    if not loaded:
        return found
    if found.name != "auto":
        hint = "task='full', or leave the task to be found"
        message = f"the load has {', '.join(loaded)} outside the task, which joints feel"
        raise ConfigurationError("KS303", message, hint)
    reason = f"the load has {', '.join(loaded)}, so all components that joints feel"
    return Task(felt, task_of(J, felt).rank, "auto", reason)


def _divide(
    matrix: Array, six: Array, xp: Namespace, task: Task, passive: Array, length: float, tolerance: float
) -> tuple[Array, Array, Array]:
    """Active, structure and impossible part of wrenches (..., 6)."""
    rows = xp.constant(mask_of(task.rows), matrix)
    arm = spectrum(matrix, xp, length, tolerance, task.rows)
    scaled = rows * six / arm.weights
    impossible = 0 * scaled
    if np.any(passive):  # of zeros alone, singular vectors have no derivative
        columns = matrix * xp.constant(passive.astype(float), matrix)
        impossible = spectrum(columns, xp, length, tolerance, task.rows, arm.values).reached(scaled)
    active = arm.reached(scaled - impossible)
    structure = scaled - impossible - active
    return arm.weights * active, arm.weights * structure + (1 - rows) * six, arm.weights * impossible
