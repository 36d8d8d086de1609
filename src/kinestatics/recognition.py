"""`which_convention`: in which library's convention a foreign Jacobian is written. Floor 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .conventions import CONVENTIONS, FLAT_COLUMNS, TWO_ARRAYS
from .errors import ConfigurationError
from .frames import TIP
from .kinematics import jacobian
from .model import RobotModel


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
        Recognition; with no match it names the nearest convention and how far it is off.

    Raises:
        ConfigurationError: KS303 for an array that is none of these shapes.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> J = ks.jacobian(arm, [0.3, 0.5]).to_array(convention="modern_robotics.body")
        >>> print(ks.which_convention(J, arm, [0.3, 0.5]))
        angular-linear rows, axes of tip, at the origin of tip: as in modern_robotics.body, manipulapy.body
    """
    foreign = np.asarray(array, dtype=float)
    shapes = {(6, model.n), (6 * model.n,), (2, 3, model.n)}
    if foreign.shape not in shapes:
        raise ConfigurationError(
            "KS303", f"the array has shape {foreign.shape}; expected (6, {model.n})", "columns are joints"
        )
    J = jacobian(model, q, at=at)
    if J.array.ndim != 2:
        raise ConfigurationError("KS303", "which_convention takes one configuration, not a batch", "pass one q")
    scale = max(float(np.abs(foreign).max(initial=0.0)), 1e-300)
    residuals: dict[str, float] = {}
    for name, convention in CONVENTIONS.items():
        candidate = J.to_array(convention=name)
        if candidate.shape == foreign.shape and (convention.layout in (FLAT_COLUMNS, TWO_ARRAYS)) == (foreign.ndim != 2):
            residuals[name] = float(np.abs(candidate - foreign).max(initial=0.0)) / scale
    best = min(residuals, key=lambda name: residuals[name])
    matches = tuple(name for name, residual in residuals.items() if residual <= tolerance)
    return _judge(matches, best, residuals[best], tolerance, -foreign, residuals, J)


def _judge(
    matches: tuple[str, ...], best: str, residual: float, tolerance: float, negated: Any, residuals: dict[str, float], J: Any
) -> Recognition:
    kinds = {(CONVENTIONS[m].order, CONVENTIONS[m].axes, CONVENTIONS[m].origin) for m in matches}
    if len(kinds) == 1:
        order, axes, origin = next(iter(kinds))
        message = f"{order} rows, axes of {axes}, at the origin of {origin}: as in {', '.join(matches)}"
        return Recognition(matches, order, axes, origin, residual, best, tolerance, message)
    if kinds:
        message = (
            f"several conventions agree at this configuration ({', '.join(matches)}); try a general one, no joint at zero"
        )
        return Recognition(matches, "", "", "", residual, best, tolerance, message)
    scale = max(float(np.abs(negated).max(initial=0.0)), 1e-300)
    for name in residuals:
        if np.abs(J.to_array(convention=name) - negated).max(initial=0.0) <= tolerance * scale:
            message = f"no convention fits, but its negative is {name}: all joints turn the other way round"
            return Recognition((), "", "", "", residual, best, tolerance, message)
    message = (
        f"no convention fits; the nearest is {best}, off by {residual:.2g} of the largest entry: another tip, another zero "
        "or order of the joints, or other link lengths"
    )
    return Recognition((), "", "", "", residual, best, tolerance, message)
