"""Contacts: where fingers touch an object, and which forces they can transmit there. MLS section 5.2."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any, Final, Self

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError, UnknownNameError, nearest
from ..frames import Frame
from ..namespaces import Array, Namespace, as_array
from ..quantities import format_number, plain
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, WRENCH_NAMES, change_wrench_frame, cross, rotate, transpose

OBJECT: Final = Frame.body("object")
"""Axes and origin of the grasped object, whatever they are: those in which its contacts are given."""

COMPONENTS: Final = {
    "frictionless": (LINEAR_ROWS[2],),
    "friction": LINEAR_ROWS,
    "soft": (*LINEAR_ROWS, ANGULAR_ROWS[2]),
}
"""Which components of a wrench in contact axes a contact transmits, by its kind."""

_ORTHONORMAL = 1e-6  # how far RᵀR may be from the identity
_POLE = 1e-30  # squared share of a unit normal off the z axis, below which it counts as the z axis


@dataclass(frozen=True, eq=False)
class Contact:
    """A point where a finger touches an object: its place, its inward normal, and what it transmits.

    Made by `Contact.frictionless`, `Contact.with_friction` or `Contact.soft`; or directly, with a rotation, where the
    tangent axes matter. Forces at a contact are those that the finger exerts on the object, in the contact's axes:
    x, y tangent, z the inward normal. Lengths, normals and friction may be SymPy expressions.

    Attributes:
        position: (..., 3) in the object's frame [m].
        rotation: (..., 3, 3) R_object_contact; its third column is the inward normal.
        kind: "frictionless" (fz >= 0), "friction" (√(fx² + fy²) <= μ fz) or "soft" (that, and |τz| <= γ fz).
        friction: μ, Coulomb's coefficient; 0 for a frictionless contact.
        torsion: γ, the largest moment about the normal for a unit of normal force [m]; 0 unless soft.

    Raises:
        UnknownNameError: KS370, for another kind.
        ConfigurationError: KS371 for a contact that cannot be, KS303 for a wrong shape, KS301 for NaN and infinity.

    Source: MLS section 5.2, table 5.2.

    Example:
        >>> print(Contact.with_friction((0.02, 0, 0), (-1, 0, 0), friction=0.5))
        contact with friction 0.5 at (0.02, 0, 0) m, inward normal (-1, 0, 0)
    """

    position: Any
    rotation: Any
    kind: str = "frictionless"
    friction: Any = 0.0
    torsion: Any = 0.0

    def __post_init__(self) -> None:
        if self.kind not in COMPONENTS:
            raise UnknownNameError("KS370", f"contact kind {self.kind!r} is not known", nearest(str(self.kind), COMPONENTS))
        object.__setattr__(self, "position", _points(self.position, "position"))
        object.__setattr__(self, "rotation", _rotation(self.rotation))
        object.__setattr__(self, "friction", _coefficient(self.friction, "friction"))
        object.__setattr__(self, "torsion", _coefficient(self.torsion, "torsion"))
        for name, kinds in (("friction", ("friction", "soft")), ("torsion", ("soft",))):
            if self.kind not in kinds and getattr(self, name) != 0:
                hint = 'kind="friction" has friction; kind="soft" has friction and torsion'
                raise ConfigurationError("KS371", f"a contact of kind {self.kind!r} has no {name}", hint)

    @classmethod
    def frictionless(cls, position: Any, normal: Any) -> Self:
        """A contact that only pushes along its inward normal.

        Args:
            position: (..., 3) in the object's frame [m].
            normal: (..., 3) pointing into the object, of any length but 0.
        """
        return cls(position, contact_axes(normal), "frictionless")

    @classmethod
    def with_friction(cls, position: Any, normal: Any, friction: Any) -> Self:
        """A hard point contact with Coulomb friction.

        Args:
            position: (..., 3) in the object's frame [m].
            normal: (..., 3) pointing into the object, of any length but 0.
            friction: μ.
        """
        return cls(position, contact_axes(normal), "friction", friction)

    @classmethod
    def soft(cls, position: Any, normal: Any, friction: Any, torsion: Any) -> Self:
        """A soft finger: friction, and a moment about the normal.

        Args:
            position: (..., 3) in the object's frame [m].
            normal: (..., 3) pointing into the object, of any length but 0.
            friction: μ.
            torsion: γ, with |τz| <= γ fz [m].
        """
        return cls(position, contact_axes(normal), "soft", friction, torsion)

    @property
    def normal(self) -> Array:
        """(..., 3) unit vector into the object."""
        return self.rotation[..., :, 2]

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the forces it transmits, in contact axes: fz; fx, fy, fz; or fx, fy, fz, mz."""
        return tuple(WRENCH_NAMES[row] for row in COMPONENTS[self.kind])

    @property
    def wrench_basis(self) -> Array:
        """B, (6, m): the wrench in contact axes is B times the forces transmitted (MLS table 5.2)."""
        return np.eye(6)[:, list(COMPONENTS[self.kind])]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text; symbols as text."""
        return {
            "kind": self.kind,
            "position": plain(self.position),
            "rotation": plain(self.rotation),
            "friction": plain(self.friction),
            "torsion": plain(self.torsion),
        }

    def __str__(self) -> str:
        names = {
            "frictionless": "frictionless contact",
            "friction": f"contact with friction {format_number(self.friction)}",
            "soft": f"soft contact with friction {format_number(self.friction)}, torsion {format_number(self.torsion)} m",
        }
        if self.position.ndim > 1 or self.rotation.ndim > 2:
            return f"{names[self.kind]}, batch of shape {batch_shape(self)}"
        position, normal = (", ".join(format_number(x) for x in _listed(v)) for v in (self.position, self.normal))
        return f"{names[self.kind]} at ({position}) m, inward normal ({normal})"


def _listed(array: Array) -> Any:
    return array.detach().tolist() if hasattr(array, "detach") else array.tolist()


def _points(value: Any, what: str) -> Array:
    array, xp = as_array(value, what)
    if array.ndim < 1 or array.shape[-1] != 3:
        raise ConfigurationError("KS303", f"{what} has shape {tuple(array.shape)}; expected (..., 3)", "x, y, z")
    if xp.name != "numpy":
        return array
    if not np.all(np.isfinite(array)):
        raise ConfigurationError("KS301", f"{what} {array.tolist()} is not finite", "pass finite numbers")
    return array.copy()


def _rotation(value: Any) -> Array:
    array, xp = as_array(value, "rotation")
    if array.ndim < 2 or array.shape[-2:] != (3, 3):
        hint = "R_object_contact, with the inward normal as its third column"
        raise ConfigurationError("KS303", f"rotation has shape {tuple(array.shape)}; expected (..., 3, 3)", hint)
    if xp.name != "numpy":
        return array
    if not np.all(np.isfinite(array)):
        raise ConfigurationError("KS301", f"rotation {array.tolist()} is not finite", "pass finite numbers")
    if np.abs(transpose(array) @ array - np.eye(3)).max(initial=0.0) > _ORTHONORMAL or np.any(np.linalg.det(array) < 0):
        hint = "orthonormal and right-handed columns; Contact.with_friction(position, normal, μ) finds tangent axes itself"
        raise ConfigurationError("KS371", "the rotation of a contact is no rotation", hint)
    return array.copy()


def _coefficient(value: Any, what: str) -> Any:
    if isinstance(value, str | bytes) or np.ndim(value):
        raise ConfigurationError("KS371", f"{what} is {value!r}; expected one number", f"{what} of one contact")
    if not isinstance(value, Real | np.ndarray):
        return value  # a symbol, or a number of another library
    number = float(value)
    if not 0 <= number < np.inf:
        raise ConfigurationError("KS371", f"{what} is {value}", "a finite number, 0 or more")
    return number


def contact_axes(normal: Any) -> Array:
    """Contact axes for an inward normal: R_object_contact, (..., 3, 3), the same for the same normal.

    z is the normal, x = z_object × normal (level, to the left of the normal), y = normal × x (up); where the normal is
    the object's z axis, x is the object's x axis. In the plane x, y of the object, x is thus the tangent in the plane.
    """
    z, xp = as_array(normal, "normal")
    z = _points(z, "normal")
    if xp.name == "sympy":
        return _symbolic_axes(z, xp)
    z, x = _numeric_axes(z, xp)
    return xp.stack([x, cross(z, x, xp), z], -1)


def _numeric_axes(normal: Array, xp: Namespace) -> tuple[Array, Array]:
    """The unit normal and the first tangent axis, without a branch on values (for jit and batches)."""
    if xp.name == "numpy":
        largest = np.abs(normal).max(axis=-1, initial=0.0, keepdims=True)
        if np.any(largest == 0):
            raise ConfigurationError("KS371", "the normal of a contact is zero", "the direction into the object")
        normal = normal / largest  # squares neither vanish nor overflow
    z = normal / (normal * normal).sum(-1)[..., None] ** 0.5
    level = z[..., 0] ** 2 + z[..., 1] ** 2
    one = 0 * level + 1
    pole = (level < _POLE) * one
    size = (level * (one - pole) + pole) ** 0.5
    x = xp.stack([(pole - z[..., 1] * (one - pole)) / size, z[..., 0] * (one - pole) / size, 0 * level], -1)
    return z, x


def _symbolic_axes(normal: Array, xp: Namespace) -> Array:
    """`contact_axes` at symbols; the normal is taken off the z axis unless it is on it for all values."""
    import sympy

    def unit(vectors: Array) -> Array:
        sizes = [sympy.sqrt(sympy.simplify(sum(x**2 for x in v))) for v in vectors.reshape(-1, 3)]
        if any(size == 0 for size in sizes):
            raise ConfigurationError("KS371", "the normal of a contact is zero", "the direction into the object")
        return vectors / np.array(sizes, dtype=object).reshape((*vectors.shape[:-1], 1))

    z = unit(np.vectorize(sympy.sympify, otypes=[object])(normal))
    level = np.stack([-z[..., 1], z[..., 0], 0 * z[..., 0]], -1)
    for row in level.reshape(-1, 3):  # rows are views
        if sympy.simplify(row[0] ** 2 + row[1] ** 2) == 0:
            row[0] = sympy.Integer(1)
    x = unit(level)
    return np.vectorize(sympy.simplify, otypes=[object])(xp.stack([x, cross(z, x, xp), z], -1))


def checked_contacts(contacts: Any) -> tuple[Contact, ...]:
    """The contacts of a grasp, one or more.

    Raises:
        ArrayTypeError: KS302.
        ConfigurationError: KS372, when there are none.
    """
    hint = "[ks.Contact.with_friction(position, normal, friction), ...]"
    if isinstance(contacts, Contact) or not isinstance(contacts, Iterable):
        raise ArrayTypeError("KS302", f"contacts is a {type(contacts).__name__}; expected a list of Contact", hint)
    listed = tuple(contacts)
    for k, contact in enumerate(listed):
        if not isinstance(contact, Contact):
            raise ArrayTypeError("KS302", f"contacts[{k}] is a {type(contact).__name__}; expected a Contact", hint)
    if not listed:
        raise ConfigurationError("KS372", "a grasp has at least one contact; there are none", hint)
    return listed


def stacked_forces(contacts: Iterable[Contact], forces: Array) -> Array:
    """(Σm): the components that each contact transmits, out of (n, 4) fx, fy, fz, mz."""
    soft = COMPONENTS["soft"]
    parts = [f[[soft.index(c) for c in COMPONENTS[contact.kind]]] for f, contact in zip(forces, contacts, strict=True)]
    return np.concatenate(parts)


def batch_shape(contact: Contact) -> tuple[int, ...]:
    """Batch axes of a contact.

    Raises:
        ConfigurationError: KS303, when position and rotation disagree.
    """
    position, rotation = tuple(contact.position.shape[:-1]), tuple(contact.rotation.shape[:-2])
    try:
        return np.broadcast_shapes(position, rotation)
    except ValueError:
        message = f"positions of a contact have batch axes {position}, its rotations {rotation}"
        raise ConfigurationError("KS303", message, "give both the same, or one of them none") from None


def object_wrenches(contact: Contact, components: tuple[int, ...], like: Array, xp: Namespace) -> Array:
    """Wrenches of unit forces along components of contact axes, in the object's frame, (..., len(components), 6)."""
    R, p, units = contact.rotation, contact.position, np.eye(6)[list(components)]
    R, p = (xp.constant(a, like) if isinstance(a, np.ndarray) and a.dtype != object else a for a in (R, p))
    shape = batch_shape(contact)
    R_contact_object = xp.broadcast(transpose(R), (*shape, 3, 3))
    p_contact_object = xp.broadcast(-rotate(R_contact_object, p), (*shape, 3))
    pose = R_contact_object[..., None, :, :], p_contact_object[..., None, :]
    return change_wrench_frame(xp.constant(units, like), *pose, xp)
