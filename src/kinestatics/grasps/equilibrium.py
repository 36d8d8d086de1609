"""Contact forces that hold a load on an object, with as little normal force as friction allows. MLS section 5.3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, FrameMismatchError, UnknownNameError
from ..namespaces import Array, as_array
from ..quantities import Wrench, format_number, wrapped
from ..spatial import ANGULAR, LINEAR, WRENCH_NAMES, change_wrench_frame, rotate
from .cones import Cones, checked_edges
from .contacts import OBJECT, Contact, stacked_forces
from .grasp_map import checked_rows, numeric_grasp
from .search import ForceSearch, least_forces

_SLIPPING = 1 - 1e-6  # a contact that uses this share of its friction is about to slip


@dataclass(frozen=True, eq=False)
class GraspEquilibrium:
    """Contact forces for a load on an object. `print` it, or take `to_dict()`.

    Attributes:
        feasible: whether the contacts hold the load.
        reason: a sentence: what holds, or why not, and which contacts are about to slip.
        forces: (n, 4) fx, fy, fz, mz of each finger on the object, in its contact's axes [N, N m]. Where the load cannot be
            held, the forces for the share of it that can, `held`; where no share can, those that come nearest to it.
        normal: (n) normal forces fz [N].
        friction_used: (n) √(fx² + fy²) / (μ fz), never above 1; 0 without force or friction.
        torsion_used: (n) |mz| / (γ fz), in the same way.
        held: the largest share of the load that can be held, 1 at most.
        missing: what the contacts would have to exert on the object besides `forces`; zero when feasible.
        wanted: what they were to exert in all: minus the load.
        rows: rows of the wrench that are balanced, 0..5.
        minimized: "largest" or "total" normal force.
        limit: (n) largest normal forces allowed [N], infinite where there is no limit.
        contacts: the grasp.

    Example:
        >>> pinch = [Contact.with_friction((x, 0, 0), (-x, 0, 0), 0.5) for x in (0.04, -0.04)]
        >>> print(grasp_equilibrium(pinch, Wrench.on_robot(force=(0, 0, -9.81), frame=OBJECT), safety=2))
        the contacts hold the load
                            normal [N]  tangential [N]   friction used    torsion used
        contacts[0]              19.62           4.905           50.0%            0.0%
        contacts[1]              19.62           4.905           50.0%            0.0%
    """

    feasible: bool
    reason: str
    forces: Array
    normal: Array
    friction_used: Array
    torsion_used: Array
    held: float
    missing: Wrench
    wanted: Wrench
    rows: tuple[int, ...]
    minimized: str
    limit: Array
    contacts: tuple[Contact, ...]

    @property
    def stacked(self) -> Array:
        """(Σm) the same forces, without the components that a contact does not transmit: what `contact_wrench` takes."""
        return stacked_forces(self.contacts, self.forces)

    @property
    def wrenches(self) -> tuple[Wrench, ...]:
        """What each finger exerts on the object: in the object's axes, at the contact."""
        result = []
        for contact, (fx, fy, fz, mz) in zip(self.contacts, self.forces, strict=True):
            force, torque = rotate(contact.rotation, np.array([fx, fy, fz])), mz * contact.normal
            x, y, z = (float(value) for value in contact.position)
            result.append(Wrench.on_environment(force, torque, OBJECT._replace(offset=(x, y, z))))
        return tuple(result)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, for JSON; infinite limits are None."""
        return {
            "feasible": self.feasible,
            "reason": self.reason,
            "forces": self.forces.tolist(),
            "normal": self.normal.tolist(),
            "friction_used": self.friction_used.tolist(),
            "torsion_used": self.torsion_used.tolist(),
            "held": self.held,
            "missing": np.asarray(self.missing).tolist(),
            "wanted": np.asarray(self.wanted).tolist(),
            "rows": [WRENCH_NAMES[row] for row in self.rows],
            "minimized": self.minimized,
            "limit": [float(x) if np.isfinite(x) else None for x in self.limit],
            "contacts": [contact.to_dict() for contact in self.contacts],
        }

    def __str__(self) -> str:
        heads = ("", "normal [N]", "tangential [N]", "friction used", "torsion used")
        slips = np.hypot(self.forces[:, 0], self.forces[:, 1])
        lines = ["".join([f"{heads[0]:14s}", *(f"{head:>16s}" for head in heads[1:])])]
        for k, (normal, slip) in enumerate(zip(self.normal, slips, strict=True)):
            cells = (
                format_number(normal),
                format_number(slip),
                f"{self.friction_used[k]:.1%}",
                f"{self.torsion_used[k]:.1%}",
            )
            lines.append("".join([f"{f'contacts[{k}]':14s}", *(f"{cell:>16s}" for cell in cells)]))
        return "\n".join([wrapped("", self.reason), *lines])


def grasp_equilibrium(
    contacts: Sequence[Contact],
    load: Wrench,
    *,
    minimize: str = "largest",
    safety: float = 1.0,
    limit: Any = None,
    rows: Any = "full",
    edges: int = 8,
) -> GraspEquilibrium:
    """Contact forces that hold a load on the object, within the friction cones. Needs SciPy (extra "grasp").

    The cones are round, and the forces lie within them. Signs are those of `joint_torques`: for a load, `Wrench.on_robot`,
    the contacts exert its negative; for what the hand is to exert on the object, `Wrench.on_environment`, that itself.

    Args:
        contacts: one grasp, in numbers.
        load: (6) in the object's axes at its origin, or at a point of it: `Frame("object", "object", center_of_mass)`.
        minimize: "largest", the largest normal force, then their sum; or "total", their sum. Where several sets of forces
            are as good, one of them is returned.
        safety: friction and torsion are divided by it in the search, 1 or more; the result shows shares of the true ones.
        limit: largest normal force, one number or (n) [N]; None for no limit.
        rows: rows of the wrench to balance: "full", "planar" (fx, fy, mz; something else holds the others), or numbers.
        edges: of each cone to begin with; more are added where they matter.

    Raises:
        MissingExtraError: KS400, without SciPy.
        ArrayTypeError: KS302 for what is no contact or no wrench, or symbols.
        FrameMismatchError: KS330 for a load that is not written in the object's frame.
        UnknownNameError: KS377 for another `minimize`.
        ConfigurationError: KS372 no contacts, KS373 rows, KS374 edges, KS376 safety or limit, KS303 batches, KS301 not
            finite, KS375 no answer.

    Law: G x = -load, √(fx² + fy²) <= μ fz, |mz| <= γ fz at every contact. Source: MLS section 5.3; for the least force,
    Buss, Hashimoto, Moore, "Dextrous hand grasping force optimization", IEEE T-RA 12(3), 1996.

    Example:
        >>> import kinestatics as ks
        >>> pinch = [ks.Contact.with_friction((x, 0, 0), (-x, 0, 0), 0.5) for x in (0.04, -0.04)]
        >>> weight = ks.Wrench.on_robot(force=(0, 0, -9.81), frame=ks.Frame.body("object"))
        >>> ks.grasp_equilibrium(pinch, weight).normal
        array([9.81, 9.81])
    """
    listed, chosen = numeric_grasp(contacts), checked_rows(rows)
    wanted, limits = _wanted(load), _limits(limit, len(listed))
    if minimize not in ("largest", "total"):
        raise UnknownNameError("KS377", f"minimize={minimize!r} is not known", '"largest" or "total" normal force')
    if not 1 <= safety < np.inf:
        raise ConfigurationError("KS376", f"safety is {safety}", "1 or more: 1.5 uses two thirds of the friction")
    cones = Cones.of(listed, float(safety))
    search = ForceSearch(cones, chosen, cones.edges(checked_edges(edges)))
    forces, held = least_forces(search, wanted, limits, minimize)
    return _result(forces, held, wanted, limits, minimize, chosen, Cones.of(listed))


def _wanted(load: Wrench) -> Array:
    """(6): what the contacts are to exert on the object, at its origin."""
    if not isinstance(load, Wrench):
        hint = 'ks.Wrench.on_robot(force=(0, 0, -9.81), frame=ks.Frame.body("object"))'
        raise ArrayTypeError("KS302", f"the load is a {type(load).__name__}; expected a Wrench", hint)
    frame = load.frame
    if (frame.axes, frame.origin) != (OBJECT.axes, OBJECT.origin):
        hint = 'frame=ks.Frame.body("object"), or ks.Frame("object", "object", point), in the axes the contacts are given in'
        raise FrameMismatchError("KS330", f"the load ({frame}) is not written in the frame of the object", hint)
    array, xp = as_array(load.array, "the load")
    if xp.name != "numpy" or array.shape != (6,):
        raise ConfigurationError(
            "KS303", f"the load has shape {tuple(array.shape)}; expected 6 numbers", "loop over a batch"
        )
    if not np.all(np.isfinite(array)):
        raise ConfigurationError("KS301", f"the load {array.tolist()} is not finite", "pass finite numbers")
    at_origin = change_wrench_frame(array, np.eye(3), -np.array(frame.offset), xp)
    return at_origin if load.acts_on == "environment" else 0.0 - at_origin


def _limits(limit: Any, n: int) -> Array:
    try:
        limits = np.full(n, np.inf) if limit is None else np.asarray(limit, dtype=float)
    except (TypeError, ValueError):
        limits = np.zeros(0)
    if limits.shape not in ((), (n,)) or not np.all(limits > 0):
        raise ConfigurationError("KS376", f"limit is {limit!r}; expected one positive force, or {n}", "newtons")
    return np.broadcast_to(limits, (n,)).copy()


def _result(
    forces: Array, held: float, wanted: Array, limits: Array, minimize: str, rows: tuple[int, ...], cones: Cones
) -> GraspEquilibrium:
    feasible = held == 1.0
    exerted = np.einsum("kic,kc->i", cones.maps, forces)
    missing = np.zeros(6)
    if not feasible:
        missing[list(rows)] = (wanted - exerted)[list(rows)]
    normal = np.maximum(forces[:, 2], 0.0)
    used = [
        np.minimum(np.divide(part, most, out=np.zeros(len(part)), where=most > 0), 1.0)
        for part, most in (
            (np.hypot(forces[:, 0], forces[:, 1]), cones.friction * normal),
            (np.abs(forces[:, 3]), cones.torsion * normal),
        )
    ]
    reason = _reason(feasible, held, missing, normal, limits, np.maximum(*used))
    lacking, asked = (Wrench.on_environment(w[LINEAR], w[ANGULAR], OBJECT) for w in (missing, wanted))
    shared = (held, lacking, asked, rows, minimize, limits, cones.contacts)
    return GraspEquilibrium(feasible, reason, forces, normal, used[0], used[1], *shared)


def _reason(feasible: bool, held: float, missing: Array, normal: Array, limits: Array, used: Array) -> str:
    """What holds the load, or what stands against it, in a sentence."""

    def named(which: Array) -> str:
        return ", ".join(f"contacts[{k}]" for k in np.flatnonzero(which))

    slipping = named(used >= _SLIPPING)
    slip = f"; about to slip: {slipping}" if slipping else ""
    if feasible:
        return f"the contacts hold the load{slip}"
    if held > 0:
        at_limit = named(normal >= limits * _SLIPPING)
        return f"the contacts hold {held:.4g} of the load: at the limit of normal force: {at_limit}{slip}"
    lacking = ", ".join(
        f"{name} {format_number(x)}" for name, x in zip(WRENCH_NAMES, missing, strict=True) if format_number(x) != "0"
    )
    return f"no forces of these contacts hold the load, however large: the nearest lack {lacking} [N, N m]{slip}"
