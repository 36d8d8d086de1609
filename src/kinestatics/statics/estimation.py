"""The wrench that explains measured motor torques, and how much of it the torques can tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace
from ..quantities import Frozen, Jacobian, Wrench, check_batches, in_one_library
from ..spatial import rotate, size_weights, transpose
from ..tasks import Task, find_task, model_of, relative_to, task_of, without_rounding
from . import symbols
from .estimate_result import WrenchEstimate
from .subspaces import RANK_TOLERANCE, SAFE, Spectrum, check_length, decompose, jacobian_array, rounding, spectrum


class _Measured(NamedTuple):
    """What was asked, in one library; J is (..., 6, n), torques (..., n) those of the contact, with the sign of Jᵀ w."""

    J: Array
    torques: Array
    scale: Array
    covariance: Array | None
    xp: Namespace


def wrench_from_torques(
    J: Jacobian,
    tau: Any,
    *,
    task: str | Sequence[str] | Sequence[int] = "auto",
    gravity_torques: Any = None,
    covariance: Any = None,
    acts_on: str = "environment",
    length: float = 1.0,
    tolerance: float = RANK_TOLERANCE,
) -> WrenchEstimate:
    """The wrench at a link that explains measured motor torques, as far as the torques can tell.

    Args:
        J: Jacobian (..., 6, n) of the link where the contact is; NumPy, JAX, PyTorch, or one of SymPy expressions.
        tau: (..., n) torques the motors supply while nothing moves [N m or N].
        task: the components of the wrench that are looked for, as in `find_task`; all others are taken to be zero. "auto"
            leaves out those that no torque can tell in any posture; where position accounts for all freedoms (a planar 2R
            arm, an RRP arm), it looks for a force without a moment, as at the contact of a point. "full" looks for all six.
        gravity_torques: (..., n) the part of tau that holds the arm's own weight, from `gravity_torques`; taken off.
        covariance: (n, n) or (..., n, n) of the measured torques, symmetric and positive definite. With it, joints that are
            measured well count for more (weighted least squares), and the estimate has a covariance.
        acts_on: "environment" for the push of the robot, "robot" for the load on it; the two are each other's reaction.
        length: [m], the size of a wrench is |(f, τ / length)|: of all that explain the torques, the smallest is chosen.
        tolerance: singular values below this fraction of the largest count as zero, and so do residuals below this fraction
            of the torques.

    Returns:
        WrenchEstimate. Where tau = joint_torques(J, w) of a w within the task, its wrench is w if `unique`, else
        `observable` · w.

    Raises:
        ArrayTypeError: KS302. ConfigurationError: KS303 shapes, length, or a covariance that is none; KS301 not finite;
        KS336, symbols whose rank is neither that of the rows nor that of the joints. UnknownNameError: KS317, KS318.

    Law: τ = Jᵀ w for what the robot exerts, -Jᵀ w for a load; w minimises |τ - Jᵀ w| in the torques' own units, or with a
    covariance C the sum (τ - Jᵀ w)ᵀ C⁻¹ (τ - Jᵀ w) (Gauss and Markov: no linear unbiased estimate has less variance).
    Source: note 004, "This is the relation between the joint torques and end point force"; Lawson, Hanson, "Solving Least
    Squares Problems" (1974), chapters 7 and 12 for the smallest solution and its covariance.

    Example:
        >>> import kinestatics as ks
        >>> J = ks.jacobian(ks.load("planar_2r"), [0.3, 0.8])
        >>> tau = ks.joint_torques(J, ks.Wrench.on_environment(force=(2, -5, 0)))
        >>> ks.wrench_from_torques(J, tau).wrench.force.round(9)
        array([ 2., -5.,  0.])
    """
    measured = _measured(J, tau, gravity_torques, covariance, acts_on)
    check_length(length)
    if not 0 <= tolerance < 1:
        raise ConfigurationError("KS303", f"tolerance is {tolerance}", "a share below 1, such as 1e-10")
    found = _task(J, task)
    solve = _symbolic if measured.xp.name == "sympy" else _numeric
    return solve(J, measured, found, acts_on, length, tolerance)


def _measured(J: Any, tau: Any, gravity: Any, covariance: Any, acts_on: str) -> _Measured:
    """Checks all arrays and brings them into one library."""
    jacobian_array(J, "wrench_from_torques")
    Wrench(np.zeros(6), J.frame, acts_on)  # refuses a side that is none
    arrays = {"the Jacobian": J.array, "tau": tau, "gravity_torques": gravity, "covariance": covariance}
    if tau is None:
        raise ArrayTypeError("KS302", "tau is None", "the torques that were measured, one for each joint")
    given = {name: value for name, value in arrays.items() if value is not None}
    for name, value in list(given.items())[1:]:
        if isinstance(value, Frozen):
            raise ArrayTypeError("KS302", f"{name} is a {type(value).__name__}; expected numbers, one for each joint")
    listed, xp = in_one_library(given)
    library = dict(zip(given, listed, strict=True))
    n, batch = len(J.joint_names), tuple[int, ...]()
    for name, array in library.items():
        expected = {"the Jacobian": (6, n), "covariance": (n, n)}.get(name, (n,))
        if tuple(array.shape[-len(expected) :]) != expected:
            wanted = f"(..., {', '.join(map(str, expected))})"
            raise ConfigurationError("KS303", f"{name} has shape {tuple(array.shape)}; expected {wanted}", _joints(J))
        if xp.name == "numpy" and not np.all(np.isfinite(array)):
            raise ConfigurationError("KS301", f"{name} holds numbers that are not finite", "give finite numbers")
        own = tuple(array.shape[: array.ndim - len(expected)])
        check_batches("what comes before it", batch, name, own)
        batch = np.broadcast_shapes(batch, own)
    torques, held = library["tau"], library.get("gravity_torques")
    scale = abs(torques) if held is None else abs(torques) + abs(held)
    contact = torques if held is None else torques - held
    signed = contact if acts_on == "environment" else 0 - contact
    return _Measured(library["the Jacobian"], signed, scale, library.get("covariance"), xp)


def _joints(J: Jacobian) -> str:
    return f"one entry for each joint: {', '.join(J.joint_names)}; batch axes first"


def _task(J: Jacobian, task: Any) -> Task:
    model = model_of(J)
    if not model.is_symbolic:
        return task_of(J, task)
    return find_task(symbols.with_numbers(model), task, J.link, J.frame, relative_to=relative_to(J))


def _numeric(J: Jacobian, m: _Measured, task: Task, acts_on: str, length: float, tolerance: float) -> WrenchEstimate:
    """Least squares through the singular values of the rows in play; nothing here depends on a decision about numbers."""
    xp = m.xp
    cleaned = without_rounding(model_of(J), m.J) if xp.name == "numpy" and not model_of(J).is_symbolic else m.J
    found = spectrum(cleaned, xp, length, tolerance, task.rows)
    within = found.V * found.kept[..., None, :]
    explained = rotate(within, rotate(transpose(within), m.torques))
    if m.covariance is None:
        coordinates, spread, residual = rotate(transpose(within), m.torques), None, m.torques - explained
    else:
        coordinates, spread, residual = _weighted(found, within, m)
    back = found.weights[:, None] * found.U * found.inverse_values[..., None, :]
    six, missed = rotate(back, coordinates), m.torques - explained
    share = max(tolerance, SAFE * rounding(m.J))
    largest = (m.scale**2).sum(-1) ** 0.5
    rank, sign = found.kept.sum(-1), 1 if acts_on == "environment" else -1
    fits = (missed**2).sum(-1) ** 0.5 <= share * largest
    one = xp.name == "numpy" and not rank.ndim
    return WrenchEstimate(
        wrench=Wrench(six, J.frame, acts_on),
        link=J.link,
        joint_names=J.joint_names,
        task=task,
        rank=int(rank) if one else rank,
        explained=fits if np.ndim(fits) or xp.name != "numpy" else bool(fits),
        unique=bool(rank == len(task.rows)) if one else rank == len(task.rows),
        residual=sign * residual,
        observable=found.weights[:, None] * found.projector() / found.weights,
        unobservable=_basis(J, m, cleaned, task, length, found.tolerance),
        covariance=None if spread is None else back @ spread @ transpose(back),
        length=length,
        tolerance=found.tolerance,
    )


def _weighted(found: Spectrum, within: Array, m: _Measured) -> tuple[Array, Array, Array]:
    """Coordinates along the singular vectors, their covariance, and the residual, for torques of a covariance C = L Lᵀ.

    L⁻¹ τ has unit covariance, and L⁻¹ V spans what a wrench can explain of it; as many singular values as there are
    vectors kept are not zero.
    """
    L = _factor(m.covariance, m.xp)
    white = m.xp.linalg.solve(L, m.torques[..., None])
    U, values, Vt = m.xp.linalg.svd(m.xp.linalg.solve(L, within), full_matrices=False)
    order = m.xp.constant(np.arange(found.kept.shape[-1], dtype=float), m.torques)
    counted = order < found.kept.sum(-1)[..., None]
    inverse = counted / (counted * values + ~counted)
    along = transpose(U * counted[..., None, :]) @ white
    V = transpose(Vt) * inverse[..., None, :]
    left = white - U @ along
    return (V @ along)[..., 0], V @ transpose(V), (L @ left)[..., 0]


def _factor(covariance: Array, xp: Namespace) -> Array:
    """L with C = L Lᵀ."""
    if xp.name == "numpy":
        lopsided = np.abs(covariance - transpose(covariance)).max(initial=0.0)
        if lopsided > 1e-9 * np.abs(covariance).max(initial=0.0):
            raise ConfigurationError("KS303", "the covariance is not symmetric", "C[i, j] = C[j, i]")
        try:
            return np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            hint = "every joint is measured with some error; np.diag(standard_deviations**2)"
            raise ConfigurationError("KS303", "the covariance is not positive definite", hint) from None
    return xp.linalg.cholesky(covariance)


def _basis(J: Jacobian, m: _Measured, cleaned: Array, task: Task, length: float, tolerance: float) -> Array | None:
    """The wrenches of the task that no torque tells, for one Jacobian of NumPy."""
    if m.xp.name != "numpy" or J.array.ndim > 2:
        return None
    return decompose(cleaned, task.rows, length, tolerance).free_wrenches


def _symbolic(J: Jacobian, m: _Measured, task: Task, acts_on: str, length: float, tolerance: float) -> WrenchEstimate:
    """The same by normal equations, for expressions that have full rank at almost all values."""
    import sympy

    if m.J.ndim > 2 or m.torques.ndim > 1 or (m.covariance is not None and m.covariance.ndim > 2):
        raise ConfigurationError("KS303", "symbols are taken one at a time", "loop over the batch")
    rows = list(task.rows)
    W = sympy.diag(*symbols.exact(size_weights(length))[rows])
    A, b = sympy.Matrix(m.J[rows].T), sympy.Matrix(m.torques)
    n, k = A.shape
    rank = len(symbols.pivots(m.J[rows].T).rows)
    C = None if m.covariance is None else sympy.Matrix(m.covariance)
    if rank == k:
        weighted = A.T if C is None or n == k else A.T * symbols.inverse(C)
        G = symbols.inverse(A) if n == k else symbols.inverse(weighted * A) * weighted
    elif rank == n:
        scaled = A * W
        G = W * scaled.T * symbols.inverse((scaled * scaled.T).applyfunc(symbols.shorter))
    else:
        message = f"rank {rank} of {k} rows and {n} joints: least squares of symbols needs one of the two in full"
        raise ConfigurationError("KS336", message, "choose fewer rows with task=..., or put numbers in")
    G = G.applyfunc(symbols.shorter)
    left = symbols.exact(np.zeros(n)) if rank == n else symbols.simplified(b - A * G * b)[:, 0]

    def spread(block: Any) -> Array:
        """A matrix (k, k) of the rows in play as one of all six."""
        whole = symbols.exact(np.zeros((6, 6)))
        whole[np.ix_(rows, rows)] = symbols.simplified(block)
        return whole

    six = symbols.exact(np.zeros(6))
    six[rows] = symbols.simplified(G * b)[:, 0]
    free = symbols.null_space(m.J[rows].T)
    unobservable = symbols.exact(np.zeros((len(free), 6)))
    unobservable[:, rows] = free
    return WrenchEstimate(
        wrench=Wrench(six, J.frame, acts_on),
        link=J.link,
        joint_names=J.joint_names,
        task=task,
        rank=rank,
        explained=all(x == 0 for x in left),
        unique=rank == k,
        residual=left if acts_on == "environment" else -left,
        observable=spread(sympy.eye(k) if rank == k else G * A),
        unobservable=unobservable,
        covariance=None if C is None else spread(G * C * G.T),
        length=length,
        tolerance=tolerance,
    )
