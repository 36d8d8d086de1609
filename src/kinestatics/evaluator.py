"""Evaluator: the hot path. One target, one frame, bare NumPy arrays in and out, straight into the kernels. Floor 8."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._kernels import STANDARD_GRAVITY, Chain, chain_arguments
from .errors import ArrayTypeError, FrameMismatchError
from .frames import BASE, TIP, Frame
from .kinematics import checked_point, named_frame, require_model
from .model import RobotModel
from .namespaces import Array
from .statics import checked_gravity, missing_masses
from .tasks import find_task


class Evaluator(Chain):
    """Computes one arm's quantities for one configuration or a batch, as bare float64 arrays.

    All methods take q (..., n) and return (..., shape); `out=` takes the result's array, `threads=` splits large batches.
    NaN in q gives NaN out. Everything is computed in C++ with the widest vectors the processor has; the GIL is released
    for batches of 64 and more. The bits do not depend on batch size, threads or memory layout.

    Methods:
        pose(q) → (..., 4, 4); jacobian(q) → (..., 6, n); jacobian_rate(q, qd) → (..., 6, n); hessian(q) → (..., 6, n, n);
        gravity_torques(q) → (..., n), what holds the arm [N m, N]; joint_torques(q, wrench) → (..., n), Jᵀ w;
        manipulability(q) → (...), the product of the singular values of the rows in play that the arm can have (task.rank);
        singular_values(q) → (..., k), k = min(rows, n), descending;
        damped_rates(q, twist, damping) → (..., n), Jᵀ(J Jᵀ + damping² I)⁻¹ twist over the rows in play; the normal equations
        lose what lies below 1e-8 σ1, so keep the damping above 1e-7 σ1 near singularities.

    Args:
        model: the robot.
        tip: link that is the target, default the model's tip.
        point: (3) point of that link, in its axes [m].
        frame: Frame(axes, origin) with base or tip for each; default Frame("base", "tip").
        task: rows in play, as in `find_task`.
        gravity: (3) in base axes [m/s²].

    Raises:
        FrameMismatchError: KS331, a frame other than these four.
        ArrayTypeError: KS302, a model with symbolic lengths; a Twist or Wrench in place of a bare array.
        MissingMassError: KS320, by gravity_torques where no masses are known.

    Laws: those of `jacobian`, `hessian`, ...; tests/laws holds the kernels to the definition.

    Example:
        >>> import kinestatics as ks
        >>> ev = ks.Evaluator(ks.load("planar_2r"))
        >>> ev.jacobian([[0.0, 0.0], [0.0, 1.5]]).shape
        (2, 6, 2)
    """

    def __init__(
        self,
        model: RobotModel,
        tip: str = TIP,
        *,
        point: Sequence[float] = (0.0, 0.0, 0.0),
        frame: Frame | None = None,
        task: str | Sequence[str] | Sequence[int] = "auto",
        gravity: Sequence[float] = STANDARD_GRAVITY,
    ) -> None:
        require_model(model)
        if model.is_symbolic:
            raise ArrayTypeError(
                "KS302", f"robot {model.name!r} has symbolic lengths", "use kinestatics.jacobian(arm, symbols)"
            )
        link, base, at_point = model.link(tip), model.link(BASE), checked_point(point)
        self.model = model
        written = frame or Frame(BASE, tip)
        if any(at_point) and model.link(written.origin) == link:
            written = written._replace(offset=at_point)
        self.frame = named_frame(model, written)
        axes, origin = model.link(self.frame.axes), model.link(self.frame.origin)
        if axes not in (base, link) or origin not in (base, link) or (origin != link and any(self.frame.offset)):
            raise FrameMismatchError(
                "KS331",
                f"an Evaluator writes in axes of base or tip at the origin of base or tip, not in {self.frame}",
                "use kinestatics.jacobian(arm, q, frame=...), which knows every link",
            )
        self.task = find_task(model, task, at=tip, frame=frame)
        self._has_masses = model.has_masses
        down = tuple(float(g) for g in checked_gravity(gravity))
        self._arguments = (model, tip, at_point, frame, task, down)
        super().__init__(
            *chain_arguments(
                model,
                link,
                axes_of_target=axes == link != base,
                origin_at_base=origin == base != link,
                offset=self.frame.offset if origin == link else at_point,
                rows=self.task.rows,
                rank=self.task.rank,
                gravity=(down[0], down[1], down[2]),
            )
        )

    def gravity_torques(self, q: Any, out: Any = None, threads: int | None = None) -> Array:
        """What holds the arm against gravity, q (..., n) → (..., n) [N m, N]; KS320 when no masses are known."""
        if not self._has_masses:
            raise missing_masses(self.model)
        if self.model.has_symbolic_masses:
            hint = "use kinestatics.gravity_torques(arm, q)"
            raise ArrayTypeError("KS302", f"the masses of robot {self.model.name!r} are symbols", hint)
        return super().gravity_torques(q, out, threads)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, self._arguments

    def __copy__(self) -> Evaluator:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Evaluator:
        return self

    def __repr__(self) -> str:
        return f"<Evaluator of {self.model.name!r}, {self.frame}, rows {', '.join(self.task.row_names)}>"


def _rebuild(model: RobotModel, tip: str, point: Any, frame: Frame | None, task: Any, gravity: Any) -> Evaluator:
    return Evaluator(model, tip, point=point, frame=frame, task=task, gravity=gravity)
