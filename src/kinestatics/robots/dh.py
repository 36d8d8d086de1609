"""Denavit-Hartenberg tables, standard and modified. Floor 4.

Standard (Denavit, Hartenberg 1955; Spong): link i is reached by Rz(θ) Tz(d) Tx(a) Rx(α), and joint i turns about the z
axis *before* the row. Modified (Craig 1986): Rx(α) Tx(a) Rz(θ) Tz(d), and joint i turns about the row's own z axis.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import KinestaticsWarning, RobotDefinitionError
from ..model import RobotModel
from ..namespaces import Array
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
        masses: of link 1 to n [kg]; centers_of_mass: in the frames of the rows [m]; inertias: (3, 3) about them [kg m²].
        base: (4, 4) pose of the first frame seen from the base link; tool: (4, 4) pose of the tip seen from link n [m].

    Returns:
        A model with links base, link1 ... linkn (the frames of the rows), and tool if one is given.

    Raises:
        RobotDefinitionError: KS200-KS203, KS205, with the row.

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
    letters = types.upper() if types is not None else "R" * len(rows)
    for letter in letters:
        if letter not in "RP":
            raise RobotDefinitionError("KS202", f"joint type {letter!r} is not known; expected R or P")
    names = list(joint_names) if joint_names is not None else [f"joint{i + 1}" for i in range(len(rows))]
    per_row = {"types": letters, "joint_names": names, "limits": limits, "masses": masses}
    _check_lengths(len(rows), per_row | {"centers_of_mass": centers_of_mass, "inertias": inertias})
    exact = any(_is_symbol(x) for row in rows for x in row)
    links, joints = [LinkDescription("base")], []
    for i, row in enumerate(rows):
        placement, screw = dh_joint(row, letters[i], convention, where=f"row {i + 1}", exact=exact)
        if i == 0 and base is not None:
            placement = np.asarray(base) @ placement
        lower, upper = limits[i] if limits is not None else (-np.inf, np.inf)
        kind = "prismatic" if letters[i] == "P" else ("continuous" if limits is None else "revolute")
        joints.append(JointDescription(names[i], kind, links[-1].name, f"link{i + 1}", placement, screw, lower, upper))
        links.append(_link(i, masses, centers_of_mass, inertias))
    if tool is not None:
        joints.append(JointDescription("tool_joint", "fixed", links[-1].name, "tool", np.asarray(tool)))
        links.append(LinkDescription("tool"))
    source = f"{convention} Denavit-Hartenberg table of {len(rows)} rows"
    return assemble(RobotDescription(name, tuple(links), tuple(joints), source, tip=links[-1].name))


def _link(i: int, masses: Any, centers: Any, inertias: Any) -> LinkDescription:
    return LinkDescription(
        f"link{i + 1}",
        mass=masses[i] if masses is not None else 0.0,
        center_of_mass=np.asarray(centers[i]) if centers is not None else np.zeros(3),
        inertia=np.asarray(inertias[i]) if inertias is not None else np.zeros((3, 3)),
    )


def _check_lengths(n: int, arguments: Mapping[str, Sequence[Any] | None]) -> None:
    for word, value in arguments.items():
        if value is not None and len(value) != n:
            raise RobotDefinitionError("KS205", f"{word} has {len(value)} entries for {n} rows", "give one a row")


def dh_joint(row: Sequence[Any], letter: str, convention: str, where: str, exact: bool = False) -> tuple[Array, Array]:
    """Placement (4, 4) of the frame of a row at zero, and the unit screw (6) of its joint in that frame.

    A standard row's joint turns about the axis *before* the row; seen from the row's own frame that is the screw
    v = (0, a cos α, -a sin α), ω = (0, sin α, cos α).
    """
    if len(row) != 4:
        raise RobotDefinitionError("KS200", f"{where}: expected 4 numbers: a alpha d theta; found {len(row)}")
    for word, entry in zip(("a", "alpha", "d", "theta"), row, strict=True):
        _check_entry(word, entry, where)
    a, alpha, d, theta = row
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
    sympy = sys.modules.get("sympy")
    return sympy is not None and isinstance(value, sympy.Basic)


def _check_entry(word: str, entry: Any, where: str) -> None:
    if isinstance(entry, str | bytes):
        hint = "give the offset of theta as a number; the joint's own angle is added to it"
        raise RobotDefinitionError("KS203", f"{where}: {word} is text, not a number", hint)
    if _is_symbol(entry):
        return
    try:
        finite = math.isfinite(entry)
    except TypeError:
        raise RobotDefinitionError("KS203", f"{where}: {word} is {type(entry).__name__}, not a number") from None
    if not finite:
        raise RobotDefinitionError("KS203", f"{where}: {word} is {entry}", "give a finite number")
    if word in ("alpha", "theta") and abs(entry) > 2 * math.pi + 1e-9:
        warnings.warn(f"KS204: {where}: {word} = {entry:g}: degrees? Angles are radians", KinestaticsWarning, stacklevel=4)


def _cos_sin(angle: Any, exact: bool) -> tuple[Any, Any]:
    """Cosine and sine; exactly 0 and ±1 at the double nearest to a right angle."""
    if _is_symbol(angle):
        import sympy

        return sympy.cos(angle), sympy.sin(angle)
    quarters = round(angle / (math.pi / 2))
    if abs(angle - quarters * (math.pi / 2)) < 1e-15 * max(1.0, abs(angle)):
        cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
        return (_exact(cosine), _exact(sine)) if exact else (float(cosine), float(sine))
    if exact:
        import sympy

        return sympy.cos(sympy.Float(angle)), sympy.sin(sympy.Float(angle))
    return math.cos(angle), math.sin(angle)


def _exact(value: Any) -> Any:
    """A float that is a whole number as an integer; SymPy then keeps expressions free of 1.0 factors."""
    import sympy

    if isinstance(value, float):
        return sympy.Integer(int(value)) if value.is_integer() else sympy.Float(value)
    return sympy.sympify(value)
