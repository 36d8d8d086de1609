"""The grasp matrix: the wrench on an object is G times the forces at its contacts. MLS section 5.2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ArrayTypeError, ConfigurationError
from ..namespaces import Array, Namespace, as_array
from ..quantities import Wrench, check_batches
from ..spatial import ANGULAR_ROWS, LINEAR_ROWS, rotate, transpose
from ..statics import decompose
from ..statics.subspaces import check_length
from .contacts import COMPONENTS, OBJECT, Contact, batch_shape, checked_contacts, object_wrenches

ROWS = {"full": (*LINEAR_ROWS, *ANGULAR_ROWS), "planar": (*LINEAR_ROWS[:2], ANGULAR_ROWS[2])}
"""Rows of an object's wrench that the contacts have to balance, by name."""


def checked_rows(rows: Any) -> tuple[int, ...]:
    """Rows of a wrench: "full", "planar", or different numbers out of 0..5.

    Raises:
        ConfigurationError: KS373.
    """
    chosen = ROWS.get(rows) if isinstance(rows, str) else None
    if chosen is None and isinstance(rows, Sequence | np.ndarray) and not isinstance(rows, str):
        listed = [int(row) for row in rows if isinstance(row, int | np.integer)]
        if listed and len(listed) == len(rows) == len(set(listed)) and set(listed) <= set(ROWS["full"]):
            chosen = tuple(listed)
    if chosen is None:
        hint = '"full", "planar" (fx, fy, mz), or numbers of rows out of 0..5'
        raise ConfigurationError("KS373", f"rows {rows!r} are no rows of a wrench", hint)
    return chosen


def grasp_matrix(contacts: Sequence[Contact]) -> Array:
    """The grasp matrix G: the wrench on the object is G times the forces at its contacts.

    Args:
        contacts: the contacts, in the object's frame; with batch axes, and of any array library (SymPy included).

    Returns:
        (..., 6, Σm), linear rows first, in the object's axes at its origin. Columns: contact after contact, each with the
        forces it transmits, `contact.components`.

    Raises:
        ArrayTypeError: KS302 for what is no contact, and for contacts of several array libraries.
        ConfigurationError: KS372 for no contacts, KS303 for batch axes that do not go together.

    Law: f = R f_c, τ = R τ_c + p × R f_c, summed over the contacts; Gᵀ maps the object's twist to the velocities of its
    contact points along the same components. Source: MLS section 5.2; note 002 (wrenches add in one frame).

    Example:
        >>> finger = Contact.with_friction((1, 0, 0), (-1, 0, 0), friction=0.5)
        >>> G = grasp_matrix([finger, Contact.frictionless((0, 1, 0), (0, -1, 0))])
        >>> G[:, 3]
        array([ 0., -1.,  0.,  0.,  0.,  0.])
    """
    listed = checked_contacts(contacts)
    like, xp = _library(listed)
    shape: tuple[int, ...] = ()
    for k, contact in enumerate(listed):
        check_batches("the contacts before it", shape, f"contacts[{k}]", batch_shape(contact))
        shape = np.broadcast_shapes(shape, batch_shape(contact))
    blocks = []
    for contact in listed:
        components = COMPONENTS[contact.kind]
        wrenches = object_wrenches(contact, components, like, xp)
        blocks.append(xp.broadcast(wrenches, (*shape, len(components), 6)))
    return transpose(xp.concat(blocks, -2))


def _library(contacts: Sequence[Contact]) -> tuple[Array, Namespace]:
    """The one library, besides plain numbers, that the contacts speak, and an array of it."""
    found = [as_array(a) for contact in contacts for a in (contact.position, contact.rotation)]
    others = [(array, xp) for array, xp in found if xp.name != "numpy"]
    if len({xp.name for _, xp in others}) > 1:
        names = " and ".join(sorted({xp.name for _, xp in others}))
        raise ArrayTypeError("KS302", f"the contacts hold arrays of {names}", "use one array library in a grasp")
    return others[0] if others else found[0]


def contact_wrench(contacts: Sequence[Contact], forces: Any) -> Wrench:
    """The net wrench of contact forces on the object.

    Args:
        contacts: the contacts.
        forces: (..., Σm) in contact axes, contact after contact, `contact.components` each [N, N m].

    Returns:
        Wrench on the environment (the object is part of it), in the frame `Frame.body("object")`.

    Raises:
        ConfigurationError: KS303 for a wrong shape.

    Law: w = G x. Source: MLS section 5.2.

    Example:
        >>> pinch = [Contact.with_friction((x, 0, 0), (-x, 0, 0), 0.5) for x in (0.1, -0.1)]
        >>> contact_wrench(pinch, [0, 1, 3, 0, 1, 3]).force
        array([0., 0., 2.])
    """
    listed = checked_contacts(contacts)
    G, x = grasp_matrix(listed), as_array(forces, "forces")[0]
    size = G.shape[-1]
    if x.ndim < 1 or x.shape[-1] != size:
        hint = "; ".join(f"contacts[{k}]: {', '.join(contact.components)}" for k, contact in enumerate(listed))
        raise ConfigurationError("KS303", f"forces have shape {tuple(x.shape)}; expected (..., {size})", hint)
    (G, of_G), (x, of_x) = as_array(G), as_array(x)
    if of_x.name == "numpy" != of_G.name:
        x = of_G.constant(x, G)
    elif of_G.name == "numpy" != of_x.name:
        G = of_x.constant(G, x)
    check_batches("the contacts", G.shape[:-2], "the forces", x.shape[:-1])
    return Wrench(rotate(G, x), OBJECT, "environment")


def numeric_grasp(contacts: Any) -> tuple[Contact, ...]:
    """The contacts of one grasp, in numbers.

    Raises:
        ArrayTypeError: KS302 for symbols and other libraries.
        ConfigurationError: KS303 for a batch of grasps.
    """
    listed = checked_contacts(contacts)
    for k, contact in enumerate(listed):
        values = contact.position, contact.rotation, contact.friction, contact.torsion
        if not all(isinstance(v, float) or (isinstance(v, np.ndarray) and v.dtype != object) for v in values):
            raise ArrayTypeError(
                "KS302", f"contacts[{k}] is not given in NumPy numbers", "put numbers for the symbols first"
            )
        if batch_shape(contact):
            message = f"contacts[{k}] has batch axes {batch_shape(contact)}; expected one grasp"
            raise ConfigurationError("KS303", message, "loop over the batch")
    return listed


def internal_forces(contacts: Sequence[Contact], *, rows: Any = "full", length: float = 1.0) -> Array:
    """A basis of the contact forces that cancel on the object: null(G).

    A squeeze is internal: it makes room for friction and moves nothing. Cones are not looked at: an internal force that
    lies within all of them is found by `force_closure`.

    Args:
        contacts: one grasp, in numbers.
        rows: rows of the wrench that must vanish: "full", "planar" (fx, fy, mz), or numbers.
        length: characteristic length for the rank decision [m].

    Returns:
        (k, Σm), orthonormal rows, in contact axes.

    Raises:
        ArrayTypeError: KS302 for what is no contact, or symbols.
        ConfigurationError: KS372 no contacts, KS373 rows, KS303 batches or length.

    Law: G x = 0. Source: MLS section 5.3.

    Example:
        >>> pinch = [Contact.frictionless((x, 0, 0), (-x, 0, 0)) for x in (0.1, -0.1)]
        >>> abs(internal_forces(pinch).round(6))
        array([[0.707107, 0.707107]])
    """
    G = grasp_matrix(numeric_grasp(contacts))
    check_length(length)
    # sizes of wrenches are |(f, τ / length)|, those of twists, which `decompose` expects, |(v, length · ω)|
    return decompose(G, checked_rows(rows), 1.0 / length).null_motion
