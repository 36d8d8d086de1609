"""`which_convention`: in which library's convention a foreign Jacobian is written. Floor 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .conventions import ANGULAR_FIRST, CONVENTIONS, FLAT_COLUMNS, MATRIX, TWO_ARRAYS
from .errors import ArrayTypeError, ConfigurationError
from .frames import TIP
from .kinematics import jacobian
from .model import RobotModel
from .namespaces import Array, as_array
from .quantities import Jacobian
from .spatial import ANGULAR, LINEAR


@dataclass(frozen=True)
class Recognition:
    """What a foreign array was found to be.

    Attributes:
        matches: names of the conventions that reproduce it; several libraries share one.
        order, axes, origin: the convention in this package's words; empty when nothing fits or several differ.
        residual: largest difference to the best convention, relative to the largest entry.
        best: the best convention's name, match or not.
        tolerance: residual up to which a convention counts as a match.
        message: the finding in a sentence.
    """

    matches: tuple[str, ...]
    order: str
    axes: str
    origin: str
    residual: float
    best: str
    tolerance: float
    message: str

    def __str__(self) -> str:
        return self.message


def which_convention(array: Any, model: RobotModel, q: Any, *, at: str = TIP, tolerance: float = 1e-6) -> Recognition:
    """Tells in which convention another program wrote the Jacobian of this robot at q.

    Args:
        array: 6 x n, or flat 6 n, or (2, 3, n) as MuJoCo's jacp and jacr stacked; columns in the order of the model.
        model, q: the robot and one configuration (n) [rad or m]; take a general one, with no joint at zero.
        at: the link it describes.
        tolerance: relative difference that still counts as equal (1e-6: six printed digits).

    Returns:
        Recognition; with no match it says what would make one, such as another link, another order or direction of the
        joints, millimetres or degrees, and names the nearest convention and how far it is off.

    Raises:
        ConfigurationError: KS303 for an array that is none of these shapes, KS301 for one that is not finite.
        ArrayTypeError: KS302 for symbols and other things that are no numbers.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> J = ks.jacobian(arm, [0.3, 0.5]).to_array(convention="modern_robotics.body")
        >>> print(ks.which_convention(J, arm, [0.3, 0.5]))
        angular-linear rows, axes of tip, at the origin of tip: as in modern_robotics.body, manipulapy.body
    """
    foreign = _foreign(array, model)
    J = jacobian(model, q, at=at)
    if J.array.ndim != 2 or not isinstance(J.array, np.ndarray) or J.array.dtype == object:
        raise ConfigurationError("KS303", "which_convention takes one numeric configuration", "pass one q, as numbers")
    residuals = _residuals(J, foreign)
    best = min(residuals, key=lambda name: residuals[name])
    matches = tuple(name for name, residual in residuals.items() if residual <= tolerance)
    kinds = {(CONVENTIONS[m].order, CONVENTIONS[m].axes, CONVENTIONS[m].origin) for m in matches}
    order, axes, origin = next(iter(kinds)) if len(kinds) == 1 else ("", "", "")
    if order:
        message = f"{order} rows, axes of {axes}, at the origin of {origin}: as in {', '.join(matches)}"
    elif matches:
        message = (
            f"several conventions agree at this configuration ({', '.join(matches)}); try a general one, no joint at zero"
        )
    else:
        message = _explain(model, q, J, foreign, tolerance) or (
            f"no convention fits; the nearest is {best}, off by {residuals[best]:.2g} of the largest entry: another tip, "
            "another zero of the joints, or other link lengths"
        )
    return Recognition(matches, order, axes, origin, residuals[best], best, tolerance, message)


def _foreign(array: Any, model: RobotModel) -> Array:
    """The array as float64, its shape and values checked."""
    values, xp = as_array(array, "the array")
    if xp.name == "sympy":
        raise ArrayTypeError("KS302", "the array holds symbols", "evaluate it at numbers first")
    foreign = np.array(values, dtype=np.float64)
    if foreign.shape not in {(6, model.n), (6 * model.n,), (2, 3, model.n)}:
        hint = "transpose it: rows are the six of a twist" if foreign.shape == (model.n, 6) else "columns are joints"
        raise ConfigurationError("KS303", f"the array has shape {foreign.shape}; expected (6, {model.n})", hint)
    if not np.all(np.isfinite(foreign)):
        raise ConfigurationError("KS301", "the array holds NaN or infinite entries", "a Jacobian is finite everywhere")
    return foreign


def _difference(candidate: Array, foreign: Array) -> float:
    """The largest difference of the entries, relative to the largest entry."""
    scale = max(float(np.abs(candidate).max(initial=0.0)), float(np.abs(foreign).max(initial=0.0)))
    return float(np.abs(candidate - foreign).max(initial=0.0)) / scale if scale > 0 else 0.0


def _residuals(J: Jacobian, foreign: Array) -> dict[str, float]:
    """How far each convention of this layout is off."""
    found = ((name, J.to_array(convention=name)) for name, c in CONVENTIONS.items() if _NDIM[c.layout] == foreign.ndim)
    return {name: _difference(candidate, foreign) for name, candidate in found}


_NDIM = {MATRIX: 2, FLAT_COLUMNS: 1, TWO_ARRAYS: 3}


def _explain(model: RobotModel, q: Any, J: Jacobian, foreign: Array, tolerance: float) -> str:
    """What would make it fit: another link, order, direction or unit of the joints, or unit of length; empty if nothing."""
    for index in range(len(model.link_names)):
        other = model.link_name(index)
        for name, residual in _residuals(jacobian(model, q, at=other), foreign).items():
            if residual <= tolerance and np.any(foreign):
                return f"no convention fits at {J.link!r}, but {name} does at link {other!r}"
    given = _as_matrix(foreign)
    for convention in CONVENTIONS.values():
        if _NDIM[convention.layout] != foreign.ndim:
            continue
        candidate = _as_matrix(J.to_array(convention=convention.name))
        linear = ANGULAR if convention.order == ANGULAR_FIRST else LINEAR
        for joints, lengths, words in _UNITS:
            scaled = candidate * joints
            scaled[linear] *= lengths
            order = _signed_order(scaled, given, tolerance)
            if order is not None:
                changes = [*_order_words(order, J.joint_names), *([words] if words else [])]
                return f"no convention fits as it stands, but {convention.name} does with {' and '.join(changes)}"
    return ""


_UNITS = (
    (1.0, 1.0, ""),
    (1.0, 1000.0, "lengths in millimetres"),
    (np.pi / 180, 1.0, "joint rates in degrees"),
    (np.pi / 180, 1000.0, "lengths in millimetres and joint rates in degrees"),
)


def _as_matrix(array: Array) -> Array:
    """6 x n, whatever the layout; a copy."""
    if array.ndim == 1:
        return array.reshape(-1, 6).T.copy()
    return array.reshape(6, -1).copy()


def _signed_order(candidate: Array, given: Array, tolerance: float) -> list[tuple[int, int]] | None:
    """For each column given, which column of the candidate it is and with which sign; None when they do not pair up."""
    if float(np.abs(candidate).max(initial=0.0)) == 0.0:
        return None
    free, order = list(range(candidate.shape[1])), []
    allowed = tolerance * float(np.abs(given).max())
    for k, column in enumerate(given.T):
        tries = [(j, sign) for sign in (1, -1) for j in sorted(free, key=lambda j: j != k)]
        fits = (t for t in tries if float(np.abs(t[1] * candidate[:, t[0]] - column).max()) <= allowed)
        if (found := next(fits, None)) is None:
            return None
        free.remove(found[0])
        order.append(found)
    return order


def _order_words(order: list[tuple[int, int]], names: tuple[str, ...]) -> list[str]:
    words = []
    if any(j != k for k, (j, _) in enumerate(order)):
        words.append(f"its columns in the order {', '.join(names[j] for j, _ in order)}")
    turned = [names[j] for j, sign in order if sign < 0]
    if len(turned) == len(order) > 1:
        words.append("the opposite sign: all joints turn the other way round")
    elif turned:
        words.append(f"the opposite sign of {', '.join(turned)}")
    return words
