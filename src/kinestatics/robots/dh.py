"""Denavit-Hartenberg tables, standard and modified. Floor 4.

Standard (Denavit, Hartenberg 1955; Spong): link i is reached by Rz(θ) Tz(d) Tx(a) Rx(α), and joint i turns about the z
axis *before* the row. Modified (Craig 1986): Rx(α) Tx(a) Rz(θ) Tz(d), and joint i turns about the row's own z axis.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Sequence
from numbers import Rational
from typing import Any

import numpy as np

from ..errors import KinestaticsWarning, RobotDefinitionError
from ..model import RobotModel
from ..namespaces import Array
from .arguments import checked_array, checked_joints, checked_list, checked_number, checked_pose, is_list, is_real_symbol
from .assemble import assemble
from .description import JointDescription, LinkDescription, RobotDescription

CONVENTIONS = ("standard", "modified")


def from_dh(
    rows: Sequence[Sequence[Any]],
    *,
    convention: str,
    types: str | None = None,
    name: str = "arm",
    joint_names: Sequence[str] | None = None,
    limits: Sequence[tuple[float, float]] | None = None,
    masses: Sequence[Any] | None = None,
    centers_of_mass: Sequence[Sequence[Any]] | None = None,
    inertias: Sequence[Array] | None = None,
    base: Array | None = None,
    tool: Array | None = None,
) -> RobotModel:
    """An arm from a Denavit-Hartenberg table.

    Args:
        rows: n rows (a [m], alpha [rad], d [m], theta [rad]); the entry the joint moves (theta, or d for a prismatic
            joint) is its offset. Entries may be SymPy expressions.
        convention: "standard" or "modified" (Craig); there is no default, since tables of both kinds look alike.
        types: one letter a row, "R" revolute or "P" prismatic; default all revolute.
        name: name of the arm.
        joint_names: default joint1, joint2, ...
        limits: (lower, upper) of each joint [rad or m].
        masses: of link 1 to n [kg]; centers_of_mass: in the frames of the rows [m], by default their origins (the far ends
            of standard rows), with a warning; inertias: (3, 3) about them [kg m²].
        base: (4, 4) pose of the first frame seen from the base link; tool: (4, 4) pose of the tip seen from link n [m].

    Returns:
        A model with links base, link1 ... linkn (the frames of the rows), and tool if one is given.

    Raises:
        RobotDefinitionError: KS200-KS203 with the row; KS131, KS152, KS160, KS205-KS208, KS212 with the argument.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.from_dh([(1, 0, 0, 0), (0.8, 0, 0, 0)], convention="standard")
        >>> ks.pose(arm, [0, 0]).translation
        array([1.8, 0. , 0. ])
    """
    if convention not in CONVENTIONS:
        raise RobotDefinitionError(
            "KS201", f"convention {convention!r} is not known", "say convention='standard' or convention='modified'"
        )
    table = []
    for i, row in enumerate(checked_list(rows, None, "rows", "joint")):
        table.append(_row(row, f"row {i + 1}"))
    n = len(table)
    letters = _letters(types, n)
    names, bounds = checked_joints(joint_names, limits, n, "row")
    bodies = _bodies(n, masses, centers_of_mass, inertias)
    exact = any(_is_symbol(x) for row in table for x in row)
    mount = checked_pose(base, "base") if base is not None else None
    end = checked_pose(tool, "tool") if tool is not None else None
    if not table and mount is not None:
        end = mount if end is None else mount @ end
    links, joints = [LinkDescription("base")], []
    for i, row in enumerate(table):
        placement, screw = dh_joint(row, letters[i], convention, exact)
        if i == 0 and mount is not None:
            placement = mount @ placement
        kind = "prismatic" if letters[i] == "P" else ("continuous" if limits is None else "revolute")
        joints.append(JointDescription(names[i], kind, links[-1].name, f"link{i + 1}", placement, screw, *bounds[i]))
        links.append(LinkDescription(f"link{i + 1}", *bodies[i]))
    if end is not None:
        joints.append(JointDescription("tool_joint", "fixed", links[-1].name, "tool", end))
        links.append(LinkDescription("tool"))
    source = f"{convention} Denavit-Hartenberg table of {n} rows"
    return assemble(RobotDescription(name, tuple(links), tuple(joints), source, tip=links[-1].name))


def _row(row: Any, where: str) -> list[Any]:
    """The four entries of a row: symbols and fractions as they are, other numbers as floats."""
    if not is_list(row) or len(row) != 4:
        found = f"found {len(row)}" if is_list(row) else f"found {type(row).__name__}"
        raise RobotDefinitionError("KS200", f"{where}: expected 4 numbers: a alpha d theta; {found}")
    entries = []
    for word, entry in zip(("a", "alpha", "d", "theta"), row, strict=True):
        _check_entry(word, entry, where)
        entries.append(entry if _is_symbol(entry) or isinstance(entry, Rational) else float(entry))
    return entries


def _letters(types: Any, n: int) -> list[str]:
    letters = (
        ["R"] * n if types is None else checked_list(list(types) if isinstance(types, str) else types, n, "types", "row")
    )
    for letter in letters:
        if not isinstance(letter, str) or letter not in ("R", "P", "r", "p"):
            raise RobotDefinitionError("KS202", f"joint type {letter!r} is not known; expected R or P")
    return [letter.upper() for letter in letters]


def _bodies(n: int, masses: Any, centers: Any, inertias: Any) -> list[tuple[Any, Array, Array]]:
    """Mass, centre of mass and inertia of each link; zero where not given."""
    given = {"masses": ((), masses), "centers_of_mass": ((3,), centers), "inertias": ((3, 3), inertias)}
    columns: list[list[Any]] = []
    for word, (shape, values) in given.items():
        entries = [np.zeros(shape)] * n if values is None else checked_list(values, n, word, "row")
        columns.append([checked_array(entry, shape, f"{word}[{i}]") for i, entry in enumerate(entries)])
    for i, mass in enumerate(columns[0]):
        if mass.dtype != object and mass < 0:
            raise RobotDefinitionError("KS160", f"masses[{i}] is {mass:g}", "a mass is at least 0")
    if centers is None and any(mass.dtype == object or mass > 0 for mass in columns[0]):
        message = "KS209: masses without centers_of_mass: each is taken at the origin of its row's frame"
        warnings.warn(message, KinestaticsWarning, stacklevel=3)
    exact = any(array.dtype == object for column in columns for array in column)
    sizes = [_exact(mass[()]) if exact else float(mass) for mass in columns[0]]
    return list(zip(sizes, columns[1], columns[2], strict=True))


def dh_joint(row: Sequence[Any], letter: str, convention: str, exact: bool = False) -> tuple[Array, Array]:
    """Placement (4, 4) of the frame of a row at zero, and the unit screw (6) of its joint in that frame.

    A standard row's joint turns about the axis *before* the row; seen from the row's own frame that is the screw
    v = (0, a cos α, -a sin α), ω = (0, sin α, cos α).
    """
    a, alpha, d, theta = row if exact else map(float, row)
    (ca, sa), (ct, st) = _cos_sin(alpha, exact), _cos_sin(theta, exact)
    if exact:
        a, d = _exact(a), _exact(d)
    if convention == "standard":
        placement = [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        screw = [0, sa, ca, 0, 0, 0] if letter == "P" else [0, a * ca, -a * sa, 0, sa, ca]
    else:
        placement = [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]]
        screw = [0, 0, 1, 0, 0, 0] if letter == "P" else [0, 0, 0, 0, 0, 1]
    dtype = object if exact else float
    return np.array(placement, dtype=dtype), np.array(screw, dtype=dtype)


def _is_symbol(value: Any) -> bool:
    basic = getattr(sys.modules.get("sympy"), "Basic", None)  # another thread may be half way through importing it
    return basic is not None and isinstance(value, basic)


def _check_entry(word: str, entry: Any, where: str) -> None:
    if isinstance(entry, str | bytes):
        hint = "give the offset of theta as a number; the joint's own angle is added to it"
        raise RobotDefinitionError("KS203", f"{where}: {word} is text, not a number", hint)
    if _is_symbol(entry):
        if not is_real_symbol(entry):
            raise RobotDefinitionError("KS203", f"{where}: {word} is {entry}", "give a real, finite expression")
        return
    try:
        value = checked_number(entry, word)
    except RobotDefinitionError as error:
        raise RobotDefinitionError("KS203", f"{where}: {error.message}", error.hint) from None
    if word in ("alpha", "theta") and abs(value) > 2 * math.pi + 1e-9:
        warnings.warn(f"KS204: {where}: {word} = {value:g}: degrees? Angles are radians", KinestaticsWarning, stacklevel=4)


def _cos_sin(angle: Any, exact: bool) -> tuple[Any, Any]:
    """Cosine and sine; exactly 0 and ±1 at the double nearest to a right angle."""
    if _is_symbol(angle):
        import sympy

        return sympy.cos(angle), sympy.sin(angle)
    quarters = round(angle / (math.pi / 2))
    if abs(quarters) <= 8 and abs(angle - quarters * (math.pi / 2)) < 1e-15 * max(1.0, abs(angle)):
        cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
        return (_exact(cosine), _exact(sine)) if exact else (float(cosine), float(sine))
    if exact:
        import sympy

        given = sympy.Rational(repr(angle)) if isinstance(angle, float) else _exact(angle)
        return sympy.cos(given), sympy.sin(given)  # of a fraction they stay exact: c² + s² is 1
    return math.cos(angle), math.sin(angle)


def _exact(value: Any) -> Any:
    """A float that is a whole number as an integer; SymPy then keeps expressions free of 1.0 factors."""
    import sympy

    if isinstance(value, float):
        return sympy.Integer(int(value)) if value.is_integer() else sympy.Float(value)
    return sympy.sympify(value)
