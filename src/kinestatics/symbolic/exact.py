"""`exact`: a robot of fractions and right angles, so that zero is zero; and symbols for its joints. Floor 7."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import ConfigurationError, missing_extra
from ..kinematics import require_model
from ..model import RobotModel
from ..namespaces import Array
from ..spatial import ANGULAR, LINEAR, rotation_to_rpy, split_pose
from ..tasks import characteristic_length

_PARTS = 12
"""Angles are taken for whole multiples of 180/12 = 15 degrees, or of whole degrees, where they are that close."""
_DIGITS = 1e-12
_OF_REACH = 0.1
_DENOMINATOR = 10**8
"""Of a parameter of a rotation of fractions: the rotation is then within 1e-15 of the one given."""
KEPT, FRACTIONS = "kept", "fractions"
MOST_KEPT = 3
"""Angles of a robot of numbers that determinants keep: with more, rotations of fractions keep polynomials small."""
LETTERS = ("q", "theta", "joint")


def sympy_module() -> Any:
    """The module sympy.

    Raises:
        MissingExtraError: KS400.
    """
    try:
        import sympy
    except ImportError:
        raise missing_extra("sympy", "symbolic", "closed forms") from None
    return sympy


def joint_symbols(model: RobotModel) -> tuple[Any, ...]:
    """(n) real SymPy symbols for the joints: q1, q2, ...; theta1, ... where a length of the model is called q1.

    Example:
        >>> import kinestatics as ks
        >>> ks.joint_symbols(ks.load("planar_2r"))
        (q1, q2)
    """
    sympy = sympy_module()
    require_model(model)
    taken = {str(symbol) for symbol in free_symbols(model)}
    for letter in LETTERS:
        names = [f"{letter}{k + 1}" for k in range(model.n)]
        if not taken & set(names):
            return tuple(sympy.Symbol(name, real=True) for name in names)
    hint = f"rename the lengths called {', '.join(sorted(taken))}"
    raise ConfigurationError("KS392", f"no letter of {', '.join(LETTERS)} is free for the joints", hint)


def free_symbols(model: RobotModel) -> set[Any]:
    """Symbols of lengths, angles and masses of a model."""
    found: set[Any] = set()
    for name in ("placements", "screws", "link_placements", "offsets", "multipliers", "masses", "centers_of_mass"):
        array = getattr(model, name)
        if array.dtype == object:
            for entry in array.flat:
                found |= getattr(entry, "free_symbols", set())
    return found


def exact(model: RobotModel, tolerance: float = 1e-5, *, angles: str = KEPT) -> RobotModel:
    """The robot with its decimals as fractions and its right angles exact, for closed forms.

    A file writes 90 degrees as 1.5708 and 0.425 m as a sum of floats; kinematics does not mind, algebra does: only where
    such numbers are exact do terms cancel.

    Args:
        model: a robot of numbers; one of symbols is returned as it is.
        tolerance: angles [rad] this close to a multiple of 15 degrees are taken for it (of a whole degree: a thousandth of
            this), lengths below a tenth of it in reaches of the arm for zero. A calibrated robot has its nominal form at
            about 0.01; how far that is from the numbers, `ks.singularities` says (`residual`).
        angles: what becomes of those that are no such multiples. "kept": formulas hold their cosines and sines, as of any
            constant angle. "fractions": rotations become rotations of fractions, within 1e-14 of those given. A calibrated
            arm has a determinant of a few hundred terms then, where its many constant angles would make it millions.

    Returns:
        RobotModel of SymPy numbers. Its links, joints, limits and order are the same.

    Raises:
        ConfigurationError: KS353, where the tolerance is no positive number below 0.1; KS303 for other `angles`.
        MissingExtraError: KS400.

    Law: pose(exact(arm), q) = pose(arm, q) within the tolerance; exactly orthonormal rotations.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.exact(ks.load("planar_2r"))
        >>> ks.jacobian(arm, ks.joint_symbols(arm)).array[0, 1]
        -sin(q1)*cos(q2) - sin(q2)*cos(q1)
    """
    require_model(model)
    sympy_module()
    if model.is_symbolic:
        return model
    if not 0 < tolerance < 0.1:
        raise ConfigurationError("KS353", f"tolerance is {tolerance!r}", "a small positive number, in rad and relative")
    if angles not in (KEPT, FRACTIONS):
        raise ConfigurationError("KS303", f"angles is {angles!r}", f"{KEPT!r} or {FRACTIONS!r}")
    size = characteristic_length(model) if model.tip is not None else 1.0
    reader = (_Fractions if angles == FRACTIONS else _Reader)(tolerance, size)
    pairs = zip(model.offsets, model.screws, strict=True)
    offsets = [reader.angle(x) if np.any(screw[ANGULAR]) else reader.length(x) for x, screw in pairs]
    arrays = {
        "placements": reader.poses(model.placements),
        "link_placements": reader.poses(model.link_placements),
        "screws": reader.screws(model.screws),
        "offsets": _array(offsets, (-1,)),
        "multipliers": _array([fraction(x) for x in model.multipliers], (-1,)),
        "masses": _array([fraction(x) for x in model.masses], (-1,)),
        "centers_of_mass": _array([[reader.length(x) for x in row] for row in model.centers_of_mass], (-1, 3)),
        "inertias": _array([[[fraction(x) for x in row] for row in matrix] for matrix in model.inertias], (-1, 3, 3)),
    }
    if model.masses.dtype == object:
        for name in ("masses", "centers_of_mass", "inertias"):
            arrays.pop(name)
    return replace(model, **arrays)


def fraction(value: Any) -> Any:
    """The decimal with the fewest digits that is this float, as a SymPy number."""
    import sympy

    x = float(value)
    for digits in range(16):
        shorter = round(x, digits)
        if abs(shorter - x) <= _DIGITS * max(abs(x), 1e-3):
            ratio = Fraction(repr(shorter))
            return sympy.Rational(ratio.numerator, ratio.denominator)
    ratio = Fraction(repr(x))
    return sympy.Rational(ratio.numerator, ratio.denominator)


class _Reader:
    """Numbers within a tolerance."""

    def __init__(self, tolerance: float, reach: float) -> None:
        self.tolerance, self.reach = tolerance, reach

    def length(self, value: Any) -> Any:
        import sympy

        return sympy.Integer(0) if abs(value) <= _OF_REACH * self.tolerance * self.reach else fraction(value)

    def angle(self, value: Any) -> Any:
        """A multiple of pi where it is one, else a fraction of a radian."""
        import sympy

        for parts in (_PARTS, 180):
            whole = round(float(value) * parts / math.pi)
            if abs(value - whole * math.pi / parts) <= self.tolerance * (1.0 if parts == _PARTS else 1e-3):
                return sympy.pi * sympy.Rational(whole, parts)
        return fraction(value)

    def rotation(self, R: Array) -> list[list[Any]]:
        """An exact rotation: right angles, or three angles about fixed axes."""
        import sympy

        whole: Array = np.round(R)
        if np.abs(R - whole).max() <= self.tolerance:
            return [[sympy.Integer(int(x)) for x in row] for row in whole]
        roll, pitch, yaw = (self.angle(x) for x in rotation_to_rpy(R))
        matrices = (_turn(2, yaw), _turn(1, pitch), _turn(0, roll))
        return (matrices[0] * matrices[1] * matrices[2]).tolist()

    def direction(self, w: Array) -> list[Any]:
        """An exact unit vector: along an axis, or by its angles about z and from z."""
        import sympy

        whole: Array = np.round(w)
        if np.abs(w - whole).max() <= self.tolerance:
            return [sympy.Integer(int(x)) for x in whole]
        around, down = self.angle(math.atan2(w[1], w[0])), self.angle(math.atan2(math.hypot(w[0], w[1]), w[2]))
        s, c = cosine_sine(down)[::-1]
        c0, s0 = cosine_sine(around)
        return [s * c0, s * s0, c]

    def poses(self, T: Array) -> Array:
        """Exact poses (m, 4, 4)."""
        found = []
        for each in list(T):
            R, p = split_pose(each)
            rows = [[*row, self.length(x)] for row, x in zip(self.rotation(R), p, strict=True)]
            found.append([*rows, [*map(fraction, (0, 0, 0, 1))]])
        return _array(found, (-1, 4, 4))

    def screws(self, screws: Array) -> Array:
        """Exact unit screws (m, 6)."""
        import sympy

        found = []
        for screw in list(screws):
            v, w = screw[LINEAR], screw[ANGULAR]
            if not np.any(w):
                found.append([*self.direction(v), *[sympy.Integer(0)] * 3])
                continue
            axis = sympy.Matrix(self.direction(w))
            point = sympy.Matrix([self.length(x) for x in np.cross(w, v)])
            pitch = self.length(v @ w)
            found.append([*(point.cross(axis) + pitch * axis), *axis])
        return _array(found, (-1, 6))


class _Fractions(_Reader):
    """Numbers within a tolerance; rotations that are general become those of fractions."""

    def angle(self, value: Any) -> Any:
        import sympy

        angle = super().angle(value)
        if angle == 0 or angle.has(sympy.pi):
            return angle
        return 2 * sympy.atan(_near(math.tan(math.remainder(float(value), 2 * math.pi) / 2)))

    def rotation(self, R: Array) -> list[list[Any]]:
        import sympy

        whole: Array = np.round(R)
        if np.abs(R - whole).max() <= self.tolerance:
            return [[sympy.Integer(int(x)) for x in row] for row in whole]
        quaternion = np.linalg.eigh(_quaternion_form(R))[1][:, -1]
        largest = quaternion[np.abs(quaternion).argmax()]
        small = np.abs(quaternion / largest) <= self.tolerance / 2
        w, x, y, z = (sympy.Integer(0) if s else _near(c / largest) for s, c in zip(small, quaternion, strict=True))
        square = w * w + x * x + y * y + z * z
        rows = [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
        return [[x / square for x in row] for row in rows]

    def direction(self, w: Array) -> list[Any]:
        """By its stereographic picture, seen from the pole that is farthest."""
        import sympy

        k = int(np.abs(w).argmax())
        sign = 1 if w[k] > 0 else -1
        flat = [
            sympy.Integer(0) if i == k or abs(x) <= self.tolerance else _near(sign * x / (1.0 + abs(w[k])))
            for i, x in enumerate(w)
        ]
        square = sum(x * x for x in flat)
        return [sign * (1 - square if i == k else 2 * x) / (1 + square) for i, x in enumerate(flat)]


def _near(value: float) -> Any:
    """A fraction within 1e-16 of a number, or of its size."""
    import sympy

    ratio = Fraction(value).limit_denominator(_DENOMINATOR)
    return sympy.Rational(ratio.numerator, ratio.denominator)


def _quaternion_form(R: Array) -> Array:
    """(4, 4) the symmetric form that is greatest for the quaternion (w, x, y, z) of a rotation."""
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    form = np.empty((4, 4))
    form[0, 0], form[0, 1:], form[1:, 0] = np.trace(R), v, v
    form[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    return form


def cosine_sine(angle: Any) -> tuple[Any, Any]:
    """Cosine and sine; nested roots, such as those of 36 degrees, stay as they are written."""
    import sympy

    half = angle / 2
    if isinstance(half, sympy.atan) and half.args[0].is_Rational:
        t = half.args[0]
        return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    cosine, sine = sympy.cos(angle), sympy.sin(angle)
    plain = all(x.is_rational or all(p.base.is_Integer for p in x.atoms(sympy.Pow)) for x in (cosine, sine))
    if plain and not cosine.has(sympy.cos, sympy.sin):
        return cosine, sine
    return sympy.cos(angle, evaluate=False), sympy.sin(angle, evaluate=False)


def _turn(axis: int, angle: Any) -> Any:
    import sympy

    c, s = cosine_sine(angle)
    R = sympy.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def _array(values: list[Any], shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=object)
    return array.reshape((0, *shape[1:])) if not values else array.reshape(shape)
