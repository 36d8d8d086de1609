"""What `wrench_from_torques` returns: a wrench, what is not known of it, and the same in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..namespaces import Array
from ..quantities import TIED, Wrench, format_number, numeric, plain, wrapped
from ..screws_in_words import Screw, describe_free_wrench
from ..spatial import WRENCH_NAMES
from ..tasks import Task

_WORDS = {"robot": "load on the robot", "environment": "push of the robot on its surroundings"}


@dataclass(frozen=True, eq=False)
class WrenchEstimate:
    """The wrench at a link that explains measured motor torques. `print` it, or take `to_dict()`.

    Attributes:
        wrench: (..., 6) in the frame of the Jacobian: of all wrenches within the task that come nearest to the torques,
            the smallest one. Components outside the task are zero.
        link: at which it acts; joint_names: (n) of the torques.
        task: the components looked for. Its `row_names` are those of the twist; `looked_for` and `left_out` name the
            components of the wrench.
        rank: (...) how many components the torques tell.
        explained: (...) whether a wrench at this link within the task explains all torques (residual below tolerance).
        unique: (...) whether it is the only one within the task.
        residual: (..., n) torques that no wrench at this link explains [N m or N]: the measured ones without those of
            gravity and of the estimate.
        observable: (..., 6, 6) projector onto the wrenches that the torques tell: applied to the true wrench (if it is
            within the task and there is no noise), it gives the estimate.
        unobservable: (k, 6) basis of the wrenches within the task that make no torque, for one Jacobian of numbers or
            symbols; None for a batch and for JAX and PyTorch.
        covariance: (..., 6, 6) of the estimate, without the part that is not observable (there it is zero, and the truth
            unknown); None if none was given for the torques.
        length: [m], the size of a wrench is |(f, τ / length)|; tolerance: the share that counts as zero.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.wrench_from_torques(ks.jacobian(ks.load("planar_2r"), [0.0, 0.0]), [20.0, 10.0]))
        wrench at tip: push of the robot on its surroundings
        (fx 0, fy 10, fz 0, mx 0, my 0, mz 0) [N, N m], axes of base, at the origin of
          tip
        verdict: exact, not unique: a wrench explains all torques, others as well
        looked for: fx, fy; taken to be zero: fz, mx, my, mz
        not told by the torques:
          force along x of base, through the origin of tip
    """

    wrench: Wrench
    link: str
    joint_names: tuple[str, ...]
    task: Task
    rank: Any
    explained: Any
    unique: Any
    residual: Array
    observable: Array
    unobservable: Array | None
    covariance: Array | None
    length: float
    tolerance: float

    @property
    def looked_for(self) -> tuple[str, ...]:
        """Components of the wrench that were looked for, such as "fx"."""
        return tuple(WRENCH_NAMES[row] for row in self.task.rows)

    @property
    def left_out(self) -> tuple[str, ...]:
        """Components that were taken to be zero."""
        return tuple(name for row, name in enumerate(WRENCH_NAMES) if row not in self.task.rows)

    @property
    def verdict(self) -> Any:
        """(...) "exact" where a wrench at this link explains all torques, "least squares" where none does."""
        words = np.where(numeric(self.explained), "exact", "least squares")
        return words if words.ndim else str(words)

    @property
    def standard_deviations(self) -> Array | None:
        """(..., 6) of the components [N, N m], or None; of symbols by `covariance`."""
        if self.covariance is None or numeric(self.covariance).dtype == object:
            return None
        return np.sqrt(np.maximum(np.diagonal(numeric(self.covariance), axis1=-2, axis2=-1), 0.0))

    @property
    def directions(self) -> tuple[Screw, ...]:
        """The wrenches that are not told by the torques, in words; empty for a batch and for symbols."""
        if self.unobservable is None or self.unobservable.dtype == object:
            return ()
        frame = self.wrench.frame
        return tuple(describe_free_wrench(w, frame.axes, frame.origin, self.length) for w in self.unobservable)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON."""
        return {
            "wrench": self.wrench.to_dict(),
            "link": self.link,
            "joints": list(self.joint_names),
            "looked_for": list(self.looked_for),
            "left_out": list(self.left_out),
            "reason": self.task.reason,
            "verdict": plain(self.verdict),
            "unique": plain(self.unique),
            "rank": plain(self.rank),
            "residual": plain(self.residual),
            "observable": plain(self.observable),
            "unobservable": plain(self.unobservable),
            "directions": [screw.to_dict() for screw in self.directions],
            "covariance": plain(self.covariance),
            "length": self.length,
            "tolerance": self.tolerance,
        }

    def __str__(self) -> str:
        head = f"wrench at {self.link}: {_WORDS[self.wrench.acts_on]}"
        left = f"; taken to be zero: {', '.join(self.left_out)}" if self.left_out else ""
        rows = wrapped("looked for: ", f"{', '.join(self.looked_for) or 'nothing'}{left}")
        if self.residual.ndim > 1 or self.wrench.array.ndim > 1:
            exact, unique = (int(np.sum(numeric(x))) for x in (self.explained, self.unique))
            shape = tuple(self.wrench.array.shape[:-1])
            return (
                f"{head}\nbatch of shape {shape}: {exact} exact; {unique} of {np.size(self.unique)} postures unique\n{rows}"
            )
        return "\n".join([head, self._numbers(), wrapped("verdict: ", self._verdict_words()), rows, *self._blind()])

    def _numbers(self) -> str:
        values, spread = numeric(self.wrench.array), self.standard_deviations
        if values.dtype == object:
            lines = [wrapped(f"  {name} = ", str(x)) for name, x in zip(WRENCH_NAMES, values, strict=True) if x != 0]
            return "\n".join([*lines, wrapped("", f"[N,{TIED}N{TIED}m], {self.wrench.frame}")])
        size = np.abs(values).max(initial=0.0)
        cells = []
        for k, (name, x) in enumerate(zip(WRENCH_NAMES, values, strict=True)):
            text = format_number(0.0 if size and abs(x) < 1e-9 * size else x)
            error = f"{TIED}±{TIED}{format_number(spread[k])}" if spread is not None and k in self.task.rows else ""
            cells.append(f"{name}{TIED}{text}{error}")
        return wrapped("", f"({', '.join(cells)}) [N,{TIED}N{TIED}m], {self.wrench.frame}", hang=2)

    def _verdict_words(self) -> str:
        if self.explained:
            return "exact" if self.unique else "exact, not unique: a wrench explains all torques, others as well"
        named = zip(self.joint_names, numeric(self.residual), strict=True)
        left = ", ".join(f"{name} {format_number(x)}" for name, x in named)
        more = "" if self.unique else "; others come as near"
        return f"least squares: no wrench within the task explains all torques{more}; left over: {left}"

    def _blind(self) -> list[str]:
        if self.unobservable is None or not len(self.unobservable):
            return []
        symbols = [
            ", ".join(f"{name} {x}" for name, x in zip(WRENCH_NAMES, w, strict=True) if x != 0) for w in self.unobservable
        ]
        told = [screw.text for screw in self.directions] or symbols
        return ["not told by the torques:", *(wrapped("  ", text, hang=4) for text in told)]
