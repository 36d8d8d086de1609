"""Public kinematics: pose, Jacobians, rates, accelerations of any link and point in any frame. Floor 5.

Checks arguments, finds links and frames, and asks the kernels (NumPy) or the definition (JAX, PyTorch, SymPy, and
frames that the kernels do not write). Results are quantities that know their frame.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from . import definition
from ._kernels import Chain, _core, chain_arguments
from .definition import Target
from .errors import ArrayTypeError, ConfigurationError, KinestaticsWarning
from .frames import BASE, TIP, Frame
from .model import RobotModel
from .namespaces import Array, Namespace, as_array
from .quantities import Acceleration, Hessian, Jacobian, JacobianRate, Pose
from .spatial import pose_matrix, rotate

LARGE = 1e6
"""Above this |q| one unit in the last place is more than 1e-10 rad; a warning says so."""
_TWO_TURNS = 4 * np.pi
_CACHED_PLANS = 128


class _Plan(NamedTuple):
    """What a question (at, point, frame, relative_to) comes to on one model."""

    target: Target
    frame: Frame
    link: str
    chain: Chain | None


class Locator:
    """Where frames are, for one model at one configuration (or batch of them)."""

    __slots__ = ("model", "q", "relative_to")

    def __init__(self, model: RobotModel, q: Array, relative_to: str | None = None) -> None:
        self.model, self.q, self.relative_to = model, q, relative_to

    def named(self, frame: Frame) -> Frame:
        """The frame with link names."""
        return named_frame(self.model, frame)

    def __call__(self, frame: Frame) -> tuple[Frame, Array, Array, Namespace]:
        """The frame with link names, its rotation and origin in base axes, and the array library."""
        q, xp = as_array(self.q)
        named = named_frame(self.model, frame)
        axes, origin = self.model.link(named.axes), self.model.link(named.origin)
        R, p = definition.pose(self.model, q, Target(origin, axes, origin, named.offset), xp)
        return named, R, p, xp


def require_model(model: Any) -> None:
    """Raises ArrayTypeError (KS302) unless the first argument is a robot."""
    if not isinstance(model, RobotModel):
        hint = 'arm = ks.load("ur5e") or ks.load("robot.urdf"); then ks.jacobian(arm, q)'
        raise ArrayTypeError("KS302", f"the first argument is a {type(model).__name__}; expected a RobotModel", hint)


def checked_point(point: Any) -> tuple[float, float, float]:
    """Three finite numbers.

    Raises:
        ConfigurationError: KS303.
    """
    try:
        x, y, z = (float(value) for value in point)
    except (TypeError, ValueError):
        x = y = z = np.nan
    if not np.all(np.isfinite((x, y, z))):
        raise ConfigurationError("KS303", f"point {point!r} is not 3 finite numbers", "metres, in the axes of the link")
    return x, y, z


def named_frame(model: RobotModel, frame: Frame) -> Frame:
    """The frame with "base" and "tip" replaced by link names."""
    if not isinstance(frame, Frame):
        hint = "ks.Frame.body(), ks.Frame.spatial(), or ks.Frame(axes, origin)"
        raise ArrayTypeError("KS302", f"frame is a {type(frame).__name__}; expected a Frame", hint)
    axes, origin = model.link_name(model.link(frame.axes)), model.link_name(model.link(frame.origin))
    return Frame(axes, origin, checked_point(frame.offset))


def _plan(model: RobotModel, at: str, point: Any, frame: Frame | None, relative_to: str | None = None) -> _Plan:
    if not isinstance(model, RobotModel):
        require_model(model)
    if type(frame) is Frame and type(frame.offset) is not tuple:
        frame = frame._replace(offset=checked_point(frame.offset))
    key = (at, point if point is None else checked_point(point), frame, relative_to)
    plans: dict[Any, _Plan] = model.__dict__.get("_plans") or model.__dict__.setdefault("_plans", {})
    if (plan := plans.get(key)) is None:
        plan = _make_plan(model, at, key[1], frame, relative_to)
        if len(plans) >= _CACHED_PLANS:
            plans.clear()
        plans[key] = plan
    return plan


def _make_plan(model: RobotModel, at: str, point: Any, frame: Frame | None, relative_to: str | None) -> _Plan:
    link = model.link(at)
    offset = (0.0, 0.0, 0.0) if point is None else checked_point(point)
    if frame is None:
        frame = Frame(BASE if relative_to is None else relative_to, at, offset)
    elif point is not None and model.link(frame.origin) == link:
        frame = frame._replace(offset=offset)
    named = named_frame(model, frame)
    reference = model.link(relative_to) if relative_to is not None else None
    target = Target(link, model.link(named.axes), model.link(named.origin), named.offset, reference)
    return _Plan(target, named, model.link_name(link), _chain(model, target))


def _chain(model: RobotModel, target: Target) -> Chain | None:
    """The compiled chain, where the kernels write this frame: axes and origin of the base link or of the target."""
    base = model.link(BASE)
    if model.is_symbolic or target.relative_to is not None or target.axes not in (base, target.link):
        return None
    origin_at_base = target.origin == base and not any(target.offset) and target.link != base
    if not origin_at_base and target.origin != target.link:
        return None
    return Chain(
        *chain_arguments(
            model,
            target.link,
            axes_of_target=target.axes == target.link and target.link != base,
            origin_at_base=origin_at_base,
            offset=(0.0, 0.0, 0.0) if origin_at_base else target.offset,
        )
    )


def configuration(model: RobotModel, q: Any, check_finite: bool = True, what: str = "q") -> tuple[Array, Namespace]:
    """q as an array of its library, with its shape and values checked.

    Raises:
        ArrayTypeError: KS302.
        ConfigurationError: KS303 wrong shape, KS301 not finite.
    """
    array, xp = (q, _NUMPY) if type(q) is np.ndarray and q.dtype is _FLOAT64 else as_array(q, what)
    if model.is_symbolic and xp.name != "sympy":
        array, xp = _symbolic(array, xp, model)
    if array.ndim < 1 or array.shape[-1] != model.n:
        raise ConfigurationError(
            "KS303",
            f"{what} has shape {tuple(array.shape)}; expected ({model.n},) or (..., {model.n})",
            f"one entry for each joint of {model.name!r}: {', '.join(model.joint_names)}; batch axes first",
        )
    if check_finite and xp is _NUMPY:
        _check_values(model, array, what)
    return array, xp


_NUMPY = as_array(np.zeros(0))[1]
_FLOAT64 = np.dtype(np.float64)  # one object in NumPy: compared by identity, which is quick


def _symbolic(array: Array, xp: Namespace, model: RobotModel) -> tuple[Array, Namespace]:
    """Numbers as exact-looking symbols, for a model whose lengths are symbols."""
    if xp.name != "numpy":
        raise ArrayTypeError(
            "KS302", f"robot {model.name!r} has symbolic lengths; {xp.name} arrays cannot hold them", "pass symbols"
        )
    import sympy

    values = np.vectorize(lambda x: sympy.Integer(int(x)) if x == int(x) else sympy.Float(x), otypes=[object])
    return as_array(values(array) if array.size else array.astype(object))


def _check_values(model: RobotModel, q: Array, what: str) -> None:
    most = _core.largest(q)
    if most is None:
        most = float(np.abs(q).max(initial=0.0))
    if most <= _TWO_TURNS:
        return
    if np.isfinite(most):
        if what == "q" and (message := _doubt(model, q, most)):
            warnings.warn(message, KinestaticsWarning, stacklevel=4)
        return
    where = np.argwhere(~np.isfinite(q))[0]
    index = ", ".join(str(i) for i in where)
    raise ConfigurationError(
        "KS301",
        f"{what}[{index}] (joint {model.joint_names[where[-1]]!r}) is {q[tuple(where)]}",
        "pass finite numbers; check_finite=False lets them through and gives NaN",
    )


def _doubt(model: RobotModel, q: Array, most: float) -> str:
    """What a large but finite q was probably not meant to be; empty where it may well be meant."""
    if most > LARGE:
        return f"KS308: |q| reaches {most:.3g}; angles this large are only known to {np.spacing(most):.1g} rad"
    angles = np.array([k != "prismatic" for k in model.joint_kinds], dtype=bool)
    limited = angles & (np.abs(model.lower) <= _TWO_TURNS) & (np.abs(model.upper) <= _TWO_TURNS)
    far = limited & np.any(np.abs(q.reshape(-1, model.n)) > _TWO_TURNS, axis=0)
    if not np.any(far):
        return ""
    joint = model.joint_names[int(np.argmax(far))]
    return f"KS321: |q| reaches {most:.3g}, far outside the limits of joint {joint!r}: degrees? Angles are radians"


def _own(q: Array) -> Array:
    """A copy that the caller cannot change: results must not change with his array."""
    return np.array(q) if isinstance(q, np.ndarray) else q.clone() if hasattr(q, "clone") else q


def pose(
    model: RobotModel, q: Any, *, at: str = TIP, point: Sequence[float] | None = None, check_finite: bool = True
) -> Pose:
    """Where a link is: its axes and origin seen from the base.

    Args:
        model: the robot.
        q: (..., n) [rad or m]; NumPy, JAX, PyTorch, SymPy or a list.
        at: link, default the tip.
        point: (3) displacement of the origin in the link's axes [m].
        check_finite: refuse NaN and infinite entries of a NumPy q.

    Returns:
        Pose with array (..., 4, 4).

    Raises:
        UnknownNameError, ConfigurationError, ArrayTypeError.

    Law: T_base_link(q) = T_base_parent(q) · placement · exp(q [screw]). Source: MLS section 3.2.

    Example:
        >>> import kinestatics as ks
        >>> ks.pose(ks.load("planar_2r"), [0, 0]).translation
        array([2., 0., 0.])
    """
    plan = _plan(model, at, point, Frame.body(at))
    array, xp = configuration(model, q, check_finite)
    if xp is _NUMPY and plan.chain is not None:
        return Pose(plan.chain.pose(array), plan.link, model.base)
    R, p = definition.pose(model, array, plan.target, xp)
    return Pose(pose_matrix(R, p, xp), plan.link, model.base)


def jacobian(
    model: RobotModel,
    q: Any,
    *,
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    check_finite: bool = True,
) -> Jacobian:
    """The Jacobian of a link: J q̇ is its twist.

    Args:
        model: the robot.
        q: (..., n) [rad or m]; NumPy, JAX, PyTorch, SymPy or a list.
        at: link whose motion is described, default the tip.
        point: (3) point of that link, in its axes [m]; default its origin.
        frame: axes and point; default Frame("base", at): the geometric Jacobian of textbooks.
        check_finite: refuse NaN and infinite entries of a NumPy q.

    Returns:
        Jacobian with array (..., 6, n), linear rows first [m/s and rad/s per unit joint rate].

    Raises:
        UnknownNameError, ConfigurationError, ArrayTypeError.

    Law: J[:, k] = (v, ω) with v = ∂p/∂q_k and [ω]× = ∂R/∂q_k Rᵀ. Source: MLS section 3.4; note 001.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0, 0])
        >>> print(J)
        Jacobian of tip: axes of base, at the origin of tip
        rows: linear [m/s], angular [rad/s], per unit joint rate
            joint1  joint2
        vx       0       0
        vy       2       1
        vz       0       0
        wx       0       0
        wy       0       0
        wz       1       1
    """
    plan = _plan(model, at, point, frame)
    array, xp = configuration(model, q, check_finite)
    if xp is _NUMPY and plan.chain is not None:
        result = plan.chain.jacobian(array)
    else:
        result = definition.jacobian(model, array, plan.target, xp)
    return Jacobian(result, plan.frame, plan.link, model.joint_names, Locator(model, _own(array)))


def relative_jacobian(
    model: RobotModel,
    q: Any,
    *,
    at: str = TIP,
    relative_to: str,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    check_finite: bool = True,
) -> Jacobian:
    """The Jacobian of one moving link as seen from another: J q̇ is the twist of `at` relative to `relative_to`.

    Args:
        relative_to: the link that is taken to stand still. The others: as in `jacobian`.
        frame: default Frame(relative_to, at): axes of the observer, velocity of the origin of `at`.

    Returns:
        Jacobian with array (..., 6, n).

    Law: J = J_at - J_relative_to in one frame; the derivative of T_relative_to_at.

    Example:
        >>> import kinestatics as ks
        >>> ks.relative_jacobian(ks.load("planar_2r"), [0, 0], relative_to="link1").linear
        array([[0., 0.],
               [0., 1.],
               [0., 0.]])
    """
    plan = _plan(model, at, point, frame, relative_to)
    array, xp = configuration(model, q, check_finite)
    result = definition.jacobian(model, array, plan.target, xp)
    return Jacobian(result, plan.frame, plan.link, model.joint_names, Locator(model, _own(array), relative_to))


def hessian(
    model: RobotModel,
    q: Any,
    *,
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    check_finite: bool = True,
) -> Hessian:
    """The derivative of the Jacobian by the joints: H[..., r, j, k] = ∂J[r, j]/∂q_k.

    Args, Raises: as in `jacobian`. If the frame moves, its motion is part of the derivative.

    Returns:
        Hessian with array (..., 6, n, n).

    Law: columns of the spatial Jacobian obey ∂S_j/∂q_k = [S_k, S_j] where joint k carries joint j, else 0.
    Source: MLS section 2.3.

    Example:
        >>> import kinestatics as ks
        >>> ks.hessian(ks.load("planar_2r"), [0, 0]).array[0]
        array([[-2., -1.],
               [-1., -1.]])
    """
    plan = _plan(model, at, point, frame)
    array, xp = configuration(model, q, check_finite)
    if xp is _NUMPY and plan.chain is not None:
        result = plan.chain.hessian(array)
    else:
        result = definition.hessian(model, array, plan.target, xp)
    return Hessian(result, plan.frame, plan.link, model.joint_names, Locator(model, _own(array)))


def jacobian_rate(
    model: RobotModel,
    q: Any,
    qd: Any,
    *,
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    check_finite: bool = True,
) -> JacobianRate:
    """J̇: the derivative in time of the matrix that `jacobian` returns (the classical one, not the spatial one).

    Args:
        qd: (..., n) joint rates [rad/s or m/s], with the batch axes of q. The others: as in `jacobian`.

    Returns:
        JacobianRate with array (..., 6, n).

    Law: J̇ = Σ_k ∂J/∂q_k q̇_k, so that the acceleration is J q̈ + J̇ q̇. Source: note 004, "accelerations".

    Example:
        >>> import kinestatics as ks
        >>> ks.jacobian_rate(ks.load("planar_2r"), [0, 0], [1, 0]).array[0]
        array([-2., -1.])
    """
    plan = _plan(model, at, point, frame)
    array, xp = configuration(model, q, check_finite)
    rates = _rates(model, qd, "qd", array, xp, check_finite)
    if xp is _NUMPY and plan.chain is not None:
        result = plan.chain.jacobian_rate(array, rates)
    else:
        result = definition.jacobian_rate(model, array, rates, plan.target, xp)
    return JacobianRate(result, plan.frame, plan.link, model.joint_names, Locator(model, _own(array)))


def _rates(model: RobotModel, rates: Any, what: str, q: Array, xp: Namespace, check_finite: bool) -> Array:
    """Joint rates or accelerations in the library of q, with its batch axes."""
    array, own = configuration(model, rates, check_finite, what)
    if own.name != xp.name:
        if own is not _NUMPY:
            raise ArrayTypeError("KS302", f"q is an array of {xp.name}, {what} of {own.name}", "pass both of one library")
        array = xp.constant(array, q)
    if array.ndim > 1 and tuple(array.shape) != tuple(q.shape):
        raise ConfigurationError(
            "KS303", f"{what} has shape {tuple(array.shape)}; expected {tuple(q.shape)} or ({model.n},)", "like q"
        )
    return array


def acceleration(
    model: RobotModel,
    q: Any,
    qd: Any,
    qdd: Any,
    *,
    at: str = TIP,
    point: Sequence[float] | None = None,
    frame: Frame | None = None,
    check_finite: bool = True,
) -> Acceleration:
    """d/dt of the twist of a link: J q̈ + J̇ q̇.

    In the default frame (base axes, at the link) it is the classical acceleration of the point and of the body.

    Args:
        qd, qdd: (..., n) joint rates and accelerations [rad/s, rad/s² or m/s, m/s²]. The others: as in `jacobian`.

    Returns:
        Acceleration with array (..., 6): (v̇, ω̇) [m/s², rad/s²].

    Law: d²p/dt² for the linear part. Source: note 004, "accelerations".

    Example:
        >>> import kinestatics as ks
        >>> ks.acceleration(ks.load("planar_2r"), [0, 0], [1, 0], [0, 0]).linear
        array([-2.,  0.,  0.])
    """
    options: dict[str, Any] = {"at": at, "point": point, "frame": frame, "check_finite": check_finite}
    J = jacobian(model, q, **options)
    rate = jacobian_rate(model, q, qd, **options)
    array, xp = configuration(model, q, check_finite=False)
    first = _rates(model, qd, "qd", array, xp, check_finite)
    second = _rates(model, qdd, "qdd", array, xp, check_finite)
    return Acceleration(rotate(J.array, second) + rotate(rate.array, first), J.frame)


def com_jacobians(model: RobotModel, q: Any, *, check_finite: bool = True) -> dict[str, Array]:
    """The Jacobian of every centre of mass: velocity of the point where a link's mass is thought to be.

    Args:
        model: the robot.
        q: (..., n) [rad or m].

    Returns:
        For each link that has mass, (..., 3, n) in base axes [m/s per unit joint rate].

    Law: v_com = J_com q̇. Source: note 000, "gravity compensation".

    Example:
        >>> import kinestatics as ks
        >>> ks.com_jacobians(ks.load("planar_2r"), [0, 0])["link1"]
        array([[0. , 0. ],
               [0.5, 0. ],
               [0. , 0. ]])
    """
    array, xp = configuration(model, q, check_finite)
    stacked = definition.com_jacobians(model, array, xp)
    massive = [i for i in range(len(model.link_names)) if model.masses.dtype == object or model.masses[i] > 0]
    return {model.link_names[i]: stacked[..., i, :, :] for i in massive}
