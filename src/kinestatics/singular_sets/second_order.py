"""`second_order`: what the curvature of the motion says at a singular posture: a wall, a passage, or a standstill.

Law: let J be the Jacobian of the task's rows, H its derivative, N a basis of ker J and w in null(Jᵀ). Along q(t) with
q̇ = N a the lost component of the acceleration is Q_w(a) = w · H[N a, N a] whatever q̈ is: the intrinsic second
differential ker J → coker J. With Lyapunov and Schmidt's reduction the reachable points are (x, g(x, y)), y in ker J, with
g(0, y) = ½ Q(y) + higher order, and therefore
- Q_w definite for one w: g(0, y) lies on one side of w: a *barrier*; the tip is on the boundary of what this branch reaches;
- a zero a of all Q_w at which a ↦ Q(a, ·) is onto: g covers both sides (second-order openness): *crossable*;
- directions in which all Q_w vanish (the radical) are divided out where they integrate to a *self-motion*, postures that
  hold the tip still and stay singular with the same corank (Morse and Bott's condition): a form that is definite on the
  quotient is then a barrier too, and a form that is zero altogether is a self-motion and nothing more;
- anything else is *degenerate*: higher order decides (a cusp of a 3R arm), or nothing was decided, and the text says which.
Sources: Haug, Luh, Adkins, Wang, "Numerical algorithms for mapping boundaries of manipulator workspaces" (1996), for the
definite form; Bohigas, Manubens, Ros, "A complete method for workspace boundary determination on general structure
manipulators" (2012), for barriers that can be crossed. That of the openness of quadratic maps is in `pencils`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..frames import TIP
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import format_number, largest, plain, wrapped
from ..screws_in_words import PURE, describe_free_wrench
from ..spatial import ANGULAR, LINEAR, size_weights
from ..statics import RANK_TOLERANCE
from ..tasks import Task
from .pencils import most_definite, passes, radical_of
from .task_map import EPS, Singular, StandsStill, TaskMap, nearest_singular, one_posture, taken_apart, task_map

_SAFE = 16  # times the rounding of a sum

KINDS = ("regular", "barrier", "crossable", "self-motion", "degenerate")


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """What the curvature of the motion says at one posture.

    Attributes:
        kind: "regular", "barrier", "crossable", "self-motion" or "degenerate".
        decided: False where "degenerate" means that neither a wall nor a passage could be shown at second order.
        rank, corank: of the task's rows; the corank counts from the rank at almost every posture.
        eigenvalues: (m) of the form of the direction that shows most: the barrier's, else the one that is the least
            indefinite; without units: of lengths in reaches of the arm, joints in radians or reaches.
        scale: the reach [m]: scale · eigenvalue is in m per rad², for directions of the size |(v, scale · ω)| = 1.
        error: what of an eigenvalue rounding and a posture that is not exactly singular can account for.
        forms: (c, m, m) the form of each direction in `directions`, on the basis `null_motion`.
        directions: (c, 6) lost twists (v, ω), base axes at the link's origin; of a barrier the first is the wall's, and
            points to the side that is reached.
        null_motion: (m, n) joint motions that do not move the rows to first order.
        self_motion: dimension of the set of postures, all as singular, among which the tip stands still.
        turns: whether the lost directions turn along that set; None where there is none.
        q: (n) the posture that was judged; moved: how far it is from the one given [rad or m], to be singular to rounding.
        tolerance: singular values below this fraction of the largest count as zero.
        text: the same in words.
    """

    kind: str
    decided: bool
    rank: int
    corank: int
    eigenvalues: Array
    scale: float
    error: float
    forms: Array
    directions: Array
    null_motion: Array
    self_motion: int
    turns: bool | None
    q: Array
    moved: float
    tolerance: float
    text: str

    @property
    def wrenches(self) -> Array:
        """(c, 6) the wrenches (f, τ) held for free with the lost directions, in the same frame and order."""
        return self.directions * size_weights(self.scale) ** 2

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "kind": self.kind,
            "decided": self.decided,
            "rank": self.rank,
            "corank": self.corank,
            "eigenvalues": plain(self.eigenvalues),
            "scale": plain(self.scale),
            "error": plain(self.error),
            "forms": plain(self.forms),
            "directions": plain(self.directions),
            "null_motion": plain(self.null_motion),
            "self_motion": self.self_motion,
            "turns": self.turns,
            "q": plain(self.q),
            "moved": plain(self.moved),
            "tolerance": self.tolerance,
            "text": self.text,
        }

    def __str__(self) -> str:
        lines = [wrapped(f"{self.kind}: ", self.text)]
        if self.eigenvalues.size:
            beside = largest(self.eigenvalues)
            numbers = ", ".join(format_number(x, beside) for x in self.eigenvalues)
            words = f"{numbers} (in reaches of {format_number(self.scale)} m; known to {self.error:.1g})"
            lines.append(wrapped("  eigenvalues: ", words))
        return "\n".join(lines)


def second_order(
    model: RobotModel,
    q: Any,
    task: Task,
    at: str = TIP,
    tolerance: float = RANK_TOLERANCE,
    *,
    length: float | None = None,
) -> SecondOrder:
    """Whether a singular posture is a wall, can be passed, or lets the arm move while its tip stands still.

    Args:
        model: the robot; q: (n) one posture, NumPy or a list [rad or m]; it is polished first (see `moved`).
        task: the rows that count, from `find_task`; at: the link.
        tolerance: singular values below this fraction of the largest count as zero, in units of the reach.
        length: [m] by which angles are compared with lengths; default the arm's characteristic length. It scales the
            eigenvalues and does not change the kind.

    Returns:
        SecondOrder. A barrier is one of this branch of the arm: another branch may well pass (`on_boundary`). Joint limits
        are not looked at. Where the rows have more freedoms than the arm, w ranges over all of null(Jᵀ).

    Raises:
        ArrayTypeError: KS302; ConfigurationError: KS303 for a batch or wrong shape, KS301; UnknownNameError: KS310.

    Law: Q_w(a) = w · H[a, a], w in null(Jᵀ), a in ker J: see the head of this module. Whether some w of unit length has a
    definite form is a convex question: λ_min(Q_w) is concave in w, its greatest value the distance of 0 from the convex hull
    of {Q(a)}. An eigenvalue counts as zero only where it is smaller than `error`, never because it is small beside others.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> print(second_order(arm, [0.0, 0.0], ks.find_task(arm)))
        barrier: force along x of base, through the origin of tip, is held for free;
                 bending the arm moves tip to one side of it only, along -x of base; a
                 wall for this branch of the arm
          eigenvalues: 0.2 (in reaches of 2 m; known to 7e-14)
    """
    of = task_map(model, task, at, length)
    if not 0 <= tolerance < 1:
        raise ConfigurationError("KS303", f"tolerance is {tolerance}", "a small share, such as 1e-10")
    given = one_posture(model, q)
    found = taken_apart(of, given / of.travel, None, tolerance)
    if found.rank >= task.rank:
        return _regular(of, found, given, tolerance)
    y, _ = nearest_singular(of, found.y, found.rank)
    found = taken_apart(of, y, found.rank, tolerance)
    corank = task.rank - found.rank
    moved = float(np.linalg.norm((y - given / of.travel) * of.travel))
    H = of.hessian(y)
    error = _error(found, H)
    forms = np.einsum("ki,kjl,ja,lb->iab", found.W, H, found.N, found.N)
    forms = (forms + forms.swapaxes(-1, -2)) / 2
    radical, rest = radical_of(forms, error)
    still = StandsStill.along(of, found, radical)
    verdict = _judged(forms, rest, error, radical.shape[1], still)
    W, forms, eigenvalues = _in_order(found.W, forms, verdict)
    six = of.six(W.T)
    directions = six / size_weights(of.length)
    self_motion = radical.shape[1] if still.all_of_it else 0
    turns = still.turns if still.all_of_it and self_motion else None
    text = _words(of, verdict, six * size_weights(of.length), self_motion, turns, len(forms) - corank)
    judged = (verdict.kind, verdict.decided, found.rank, corank, eigenvalues, of.length, error)
    basis = (forms, directions, (found.N * of.travel[:, None]).T)
    return SecondOrder(*judged, *basis, self_motion, turns, y * of.travel, moved, tolerance, text)


def _regular(of: TaskMap, found: Singular, q: Array, tolerance: float) -> SecondOrder:
    n = of.model.n
    none, text = np.zeros((0, 6)), f"all {found.rank} freedoms of the task are there"
    null_motion = (found.N * of.travel[:, None]).T
    forms = np.zeros((0, n - found.rank, n - found.rank))
    sizes = (of.length, 0.0, forms, none, null_motion)
    return SecondOrder("regular", True, found.rank, 0, np.zeros(0), *sizes, 0, None, q, 0.0, tolerance, text)


def _error(found: Singular, H: Array) -> float:
    """What of the forms is due to rounding of H, W and N, and to the distance δ from the exactly singular posture.

    The part B = Wᵀ J N that should vanish changes by T δ = W · H[N, δ]; where T has no slope, by |H| δ² / 2 instead.
    """
    size = float(np.linalg.norm(H))
    n, gap = H.shape[-1], found.sigma[found.rank - 1] if found.rank else found.sigma.max(initial=0.0)
    top = found.sigma.max(initial=0.0)
    rounding = n * EPS * size * (1.0 + (top / gap if gap > 0 else 0.0))
    if not size > 0:
        return _SAFE * n * EPS
    T = np.einsum("ki,kjl,ja->ial", found.W, H, found.N).reshape(-1, n)
    B = (found.W.T @ found.J @ found.N).ravel()
    U, slopes, _ = np.linalg.svd(T, full_matrices=True)
    slopes = np.r_[slopes, np.zeros(len(B) - len(slopes))] if len(B) > len(slopes) else slopes[: len(B)]
    left = np.abs(U.T @ B) + 2 * EPS * top
    flat = np.sqrt(2 * left / size)
    steps = np.minimum(flat, left / np.maximum(slopes, EPS * size))
    return _SAFE * (rounding + size * float(np.linalg.norm(steps)))


class _Verdict(NamedTuple):
    """The kind; whether decided; the unit combination (c) of the forms that shows most, or None; a remark."""

    kind: str
    decided: bool
    combination: Array | None
    remark: str


def _judged(forms: Array, rest: Array, error: float, radical: int, still: StandsStill) -> _Verdict:
    """The kind of a pencil of forms (c, m, m), `rest` the part of its space where they do not vanish."""
    if not rest.shape[1]:
        if still.all_of_it:
            return _Verdict("self-motion", True, None, "")
        part = "; along some of the null motion the tip stands still, along the rest it does not" if still.part else ""
        return _Verdict("degenerate", True, None, f"the curvature vanishes, and higher order decides{part}")
    on_rest = rest.T @ forms @ rest
    combination, lower, upper = most_definite(on_rest, error)
    if lower > error:
        if radical == 0 or still.all_of_it:
            return _Verdict("barrier", True, combination, "")
        remark = "the curvature has one sign, and vanishes for a null motion for which higher order decides"
        return _Verdict("degenerate", True, combination, remark)
    if passes(on_rest, error):
        return _Verdict("crossable", True, combination, "")
    if lower > -error:
        remark = "its form has one sign, but vanishes for null motions that others do not vanish for: higher order decides"
        return _Verdict("degenerate", False, combination, remark)
    if upper > error:
        return _Verdict("degenerate", False, combination, "it is not decided whether any direction is a wall")
    return _Verdict(
        "degenerate", False, combination, "no direction is a wall to second order; a passage was not found either"
    )


def _in_order(W: Array, forms: Array, verdict: _Verdict) -> tuple[Array, Array, Array]:
    """W (k, c) and forms with the combination that shows most first, and its eigenvalues."""
    if verdict.combination is not None:
        completed = np.linalg.svd(verdict.combination[None])[2]
        turn = np.vstack([verdict.combination, completed[1:]])
        W, forms = W @ turn.T, np.einsum("ij,jab->iab", turn, forms)
    if verdict.kind != "barrier" and W[int(np.argmax(np.abs(W[:, 0]) > 0.5 * np.abs(W[:, 0]).max())), 0] < 0:
        W, forms = -W, -forms  # a sign that does not depend on the rounding of the decomposition
    return W, forms, np.linalg.eigvalsh(forms[0]) + 0.0  # no minus before a zero


def _words(of: TaskMap, verdict: _Verdict, wrenches: Array, self_motion: int, turns: bool | None, structural: int) -> str:
    """The verdict for people."""
    axes, link = of.model.base, of.model.link_name(of.model.link(of.at))
    lost = len(wrenches) - structural
    parts = [f"{lost} direction{'s are' if lost > 1 else ' is'} lost"]
    if verdict.combination is not None or len(wrenches) == 1:
        parts = [f"{describe_free_wrench(wrenches[0], axes, link, of.length).text}, is held for free"]
    if verdict.kind == "barrier":
        parts.append(f"bending the arm moves {link} to one side of it only, {_side(wrenches[0], axes)}")
        parts.append("a wall for this branch of the arm")
    elif verdict.kind == "crossable":
        parts.append(f"bending the arm moves {link} to either side of it: no wall, the arm can pass")
    elif verdict.kind == "self-motion":
        many = "" if self_motion == 1 else f" ({self_motion} freedoms)"
        turning = "turns with it" if turns else "stays the same"
        parts.append(f"the arm can move on{many} while {link} stands still, as singular as before")
        parts.append(f"what is lost {turning}")
    else:
        parts.append(verdict.remark)
    if verdict.kind == "barrier" and self_motion:
        parts.append(f"at it the arm can move on while {link} stands still")
    if structural > 0:
        parts.append(f"besides, {structural} of the rows' freedoms are beyond this arm at any posture")
    return "; ".join(parts)


def _side(wrench: Array, axes: str) -> str:
    """The reached side of a wall: along an axis or a direction, or in the sense of a couple."""
    force = wrench[LINEAR]
    size = np.linalg.norm(force)
    if size < PURE * np.linalg.norm(wrench):
        moment = wrench[ANGULAR]
        return f"turning about ({', '.join(format_number(x) for x in moment / np.linalg.norm(moment))}) in axes of {axes}"
    unit = force / size
    for k, name in enumerate("xyz"):
        if abs(abs(unit[k]) - 1) < PURE:
            return f"along {'-' if unit[k] < 0 else '+'}{name} of {axes}"
    return f"along ({', '.join(format_number(x) for x in unit)}) in axes of {axes}"
