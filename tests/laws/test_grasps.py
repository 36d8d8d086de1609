"""Laws of grasps, on random contacts: sums, duality, frames; closure and least forces proven by their own certificates."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

import kinestatics as ks
from kinestatics.grasps.cones import Cones
from kinestatics.spatial import quaternion_to_rotation
from strategies import assert_close

OBJECT = ks.Frame.body("object")
KINDS = ("frictionless", "friction", "soft")


@dataclass(frozen=True)
class Grasp:
    """Contacts around a lump of some size and place; `planar` ones have positions and normals in the x-y plane."""

    seed: int
    count: int
    planar: bool = False
    kinds: tuple = KINDS

    @property
    def rows(self):
        return "planar" if self.planar else "full"

    @property
    def size(self):
        return 10.0 ** np.random.default_rng(self.seed).uniform(-2, 1)

    def contacts(self):
        rng = np.random.default_rng(self.seed + 1)
        flat = np.array([1.0, 1.0, 0.0 if self.planar else 1.0])
        listed = []
        for _ in range(self.count):
            out = rng.normal(size=3) * flat
            out /= np.linalg.norm(out)
            normal, place = -out + 0.3 * rng.normal(size=3) * flat, self.size * out
            kind, friction = str(rng.choice(self.kinds)), rng.uniform(0.05, 1.0)
            if kind == "frictionless":
                listed.append(ks.Contact.frictionless(place, normal))
            elif kind == "friction":
                listed.append(ks.Contact.with_friction(place, normal, friction))
            else:
                listed.append(ks.Contact.soft(place, normal, friction, self.size * rng.uniform(0.02, 0.3)))
        return listed

    def load(self):
        rng = np.random.default_rng(self.seed + 2)
        return ks.Wrench.on_robot(rng.normal(size=3), self.size * rng.normal(size=3), OBJECT)


@st.composite
def grasps(draw, least=1, most=7, **fixed):
    """Hypothesis strategy of Grasp; keyword arguments pin some of its features."""
    drawn = {"seed": draw(st.integers(0, 2**31 - 4)), "count": draw(st.integers(least, most)), "planar": draw(st.booleans())}
    return Grasp(**(drawn | fixed))


def blocks(contacts, stacked):
    """(n, 4) fx, fy, fz, mz, written out here once more."""
    found, start = np.zeros((len(contacts), 4)), 0
    for k, contact in enumerate(contacts):
        where = {"frictionless": [2], "friction": [0, 1, 2], "soft": [0, 1, 2, 3]}[contact.kind]
        found[k, where] = stacked[start : start + len(where)]
        start += len(where)
    assert start == len(stacked)
    return found


def slack(contact, force, length):
    """How far within its cone a force is, moments divided by a length: the least of all its conditions."""
    fx, fy, fz, mz = force
    conditions = [fz, contact.friction * fz - np.hypot(fx, fy), (contact.torsion * fz - abs(mz)) / length]
    return min(conditions[: KINDS.index(contact.kind) + 1])


def most_power(contact, twist):
    """The most power a force with fz = 1 has on the object's twist: its velocity at the contact, written out here."""
    v, w = twist[:3], twist[3:]
    at = contact.rotation.T @ (v + np.cross(w, contact.position))
    return at[2] + contact.friction * np.hypot(at[0], at[1]) + contact.torsion * abs(w @ contact.normal)


def moved(contact, R, p, scale=1.0):
    """The contact of an object that is turned by R, shifted by p, and blown up."""
    place = scale * (R @ contact.position) + p
    return ks.Contact(place, R @ contact.rotation, contact.kind, contact.friction, scale * contact.torsion)


def turn(grasp, rng):
    """A rotation of the object, about z where the grasp is planar."""
    x, y, z, w = rng.normal(size=4)
    return quaternion_to_rotation(w, 0, 0, z) if grasp.planar else quaternion_to_rotation(w, x, y, z)


def scaled_six(wrench, length):
    """(f, τ / length)."""
    return np.asarray(wrench) / np.repeat([1.0, length], 3)


@given(grasps())
def test_internal_forces_cancel(grasp):
    """Every internal force gives no wrench, and there are as many as the rank of G leaves."""
    contacts = grasp.contacts()
    inner = ks.internal_forces(contacts, length=grasp.size)
    G = ks.grasp_matrix(contacts)
    sizes = np.repeat([1.0, 1 / grasp.size], 3)[:, None]
    assert len(inner) == G.shape[1] - np.linalg.matrix_rank(sizes * G, tol=1e-9)
    for forces in inner:
        assert np.abs(scaled_six(ks.contact_wrench(contacts, forces), grasp.size)).max() < 1e-9
    assert_close(inner @ inner.T, np.eye(len(inner)), 1e-12)


@given(grasps())
def test_grasp_matrix_sums_forces_and_moments(grasp):
    """G x = Σ (R f, R m + p × R f), contact by contact."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    x = rng.normal(size=ks.grasp_matrix(contacts).shape[1])
    total = np.zeros(6)
    for contact, (fx, fy, fz, mz) in zip(contacts, blocks(contacts, x), strict=True):
        f = contact.rotation @ [fx, fy, fz]
        total += np.r_[f, contact.rotation @ [0, 0, mz] + np.cross(contact.position, f)]
    found = ks.contact_wrench(contacts, x)
    assert_close(found.array, total, 1e-12)
    assert (found.acts_on, found.frame) == ("environment", OBJECT)


@given(grasps())
def test_transpose_gives_velocities_of_the_contacts(grasp):
    """Gᵀ V are the velocities of the object's points at the contacts, along what each transmits: power is kept."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    V = rng.normal(size=6)
    found = blocks(contacts, ks.grasp_matrix(contacts).T @ V)
    for contact, velocity in zip(contacts, found, strict=True):
        step, turn = 1e-6, quaternion_to_rotation(1.0, *(0.5e-6 * V[3:]))
        there = turn @ contact.position + step * V[:3]
        rate = contact.rotation.T @ (there - contact.position) / step
        expected = np.r_[rate, contact.normal @ V[3:]] * (velocity != 0)
        assert np.abs(velocity - expected).max() < 1e-4 * max(1.0, grasp.size)


@given(grasps())
def test_net_wrench_changes_frame_with_the_object(grasp):
    """Turned and shifted with the object, the same contact forces give the same wrench, rewritten."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    R, p = quaternion_to_rotation(*rng.normal(size=4)), rng.normal(size=3)
    x = rng.normal(size=ks.grasp_matrix(contacts).shape[1])
    before = ks.contact_wrench(contacts, x)
    after = ks.contact_wrench([moved(c, R, p) for c in contacts], x)
    assert_close(after.force, R @ before.force, 1e-12)
    assert_close(after.torque, R @ before.torque + np.cross(p, R @ before.force), 1e-12)


@given(grasps(least=2))
def test_closure_is_proven_either_way(grasp):
    """Closed: an internal force strictly within all cones, and full rank. Open: a motion no contact force resists."""
    contacts, rows = grasp.contacts(), [0, 1, 5] if grasp.planar else list(range(6))
    found = ks.force_closure(contacts, rows=grasp.rows, length=grasp.size, accuracy=None)
    if found.closed:
        forces = blocks(contacts, found.squeeze)
        assert min(slack(*pair, grasp.size) for pair in zip(contacts, forces, strict=True)) > 0
        assert forces[:, 2].max() == pytest.approx(1.0)
        net = scaled_six(ks.contact_wrench(contacts, found.squeeze), grasp.size)[rows]
        assert np.abs(net).max() < 1e-9
        sizes = np.repeat([1.0, 1 / grasp.size], 3)[rows, None]
        assert np.linalg.matrix_rank(sizes * ks.grasp_matrix(contacts)[rows], tol=1e-9) == len(rows)
        assert found.unresisted is found.escape is None
    else:
        escape = np.asarray(found.escape)
        assert np.linalg.norm(np.repeat([1.0, grasp.size], 3) * escape) == pytest.approx(1.0)
        assert max(most_power(contact, -escape) for contact in contacts) < 1e-8
        assert np.linalg.norm(scaled_six(found.unresisted, grasp.size)) == pytest.approx(1.0)
        assert found.unresisted.array @ escape == pytest.approx(1.0)
        assert not np.delete(escape, rows).any()
        held = ks.grasp_equilibrium(contacts, found.unresisted, rows=grasp.rows)
        assert not held.feasible
        assert held.held == 0


@given(grasps(least=3, most=6))
def test_closure_does_not_depend_on_axes_units_or_length(grasp):
    """Turned, shifted and blown up, a grasp closes as before."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    R = turn(grasp, rng)
    shift, scale = grasp.size * rng.normal(size=3), 10.0 ** rng.uniform(-2, 2)
    others = [moved(c, R, shift, scale) for c in contacts]
    options = {"rows": grasp.rows, "accuracy": None}
    assert ks.force_closure(contacts, **options).closed == ks.force_closure(others, length=0.01, **options).closed


@given(grasps(least=3, most=4))
def test_margin_does_not_depend_on_axes_or_units(grasp):
    """Turned about the origin, or blown up together with the length, the bounds still enclose the margin."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    found = ks.force_closure(contacts, rows=grasp.rows, length=grasp.size)
    assert 0 <= found.margin <= found.margin_at_most
    R = turn(grasp, rng)
    for other, scale in ((R, 1.0), (np.eye(3), 8.0)):
        contacts_too = [moved(c, other, np.zeros(3), scale) for c in contacts]
        again = ks.force_closure(contacts_too, rows=grasp.rows, length=scale * grasp.size)
        assert again.margin <= found.margin_at_most + 1e-9
        assert found.margin <= again.margin_at_most + 1e-9


@given(grasps(least=2, kinds=("friction", "soft")), st.floats(1.05, 3.0))
def test_more_friction_never_harms(grasp, factor):
    """A grasp that closes still does, with no smaller margin, when all friction grows."""
    contacts = grasp.contacts()
    more = [ks.Contact(c.position, c.rotation, c.kind, factor * c.friction, factor * c.torsion) for c in contacts]
    options = {"rows": grasp.rows, "length": grasp.size, "accuracy": 0.2}
    before, after = ks.force_closure(contacts, **options), ks.force_closure(more, **options)
    assert after.closed >= before.closed
    assert after.margin_at_most >= before.margin - 1e-9


@given(grasps(), st.sampled_from(["largest", "total"]))
def test_equilibrium_is_proven_either_way(grasp, minimize):
    """Held: forces within the cones balance the load. Not held: what is missing has power that no contact force has."""
    contacts, load, rows = grasp.contacts(), grasp.load(), [0, 1, 5] if grasp.planar else list(range(6))
    found = ks.grasp_equilibrium(contacts, load, rows=grasp.rows, minimize=minimize)
    net = scaled_six(ks.contact_wrench(contacts, found.stacked), grasp.size)
    missing, wanted = scaled_six(found.missing, grasp.size), scaled_six(found.wanted, grasp.size)
    assert np.abs((net + missing - wanted)[rows]).max() < 1e-8 * np.linalg.norm(wanted)
    largest = max(1e-12, found.normal.max())
    for contact, force in zip(contacts, found.forces, strict=True):
        assert slack(contact, force, grasp.size) >= -1e-12 * largest
    assert_close(blocks(contacts, found.stacked), found.forces, 0)
    np.testing.assert_array_equal(wanted, -scaled_six(load, grasp.size))
    if found.feasible:
        assert found.held == 1
        assert not missing.any()
    else:
        assert found.held == 0
        assert np.linalg.norm(missing) > 0


@given(grasps(least=3, kinds=("friction", "soft")))
def test_what_is_missing_separates(grasp):
    """Where a load cannot be held there is a motion on which it has power against every force of the contacts."""
    contacts, rows = grasp.contacts(), [0, 1, 5] if grasp.planar else list(range(6))
    found = ks.grasp_equilibrium(contacts, grasp.load(), rows=grasp.rows)
    if found.feasible:
        return
    scales = np.repeat([1.0, 1 / Cones.of(contacts).size], 3)  # the nearest wrench is nearest in these
    motion = scales**2 * np.asarray(found.missing)
    motion /= np.linalg.norm(motion / scales)
    assert max(most_power(contact, motion) for contact in contacts) < 1e-7
    assert np.asarray(found.wanted)[rows] @ motion[rows] > 0


@given(grasps(least=2), st.floats(0.1, 50.0))
def test_least_force_grows_with_the_load(grasp, factor):
    """Twice the load takes twice the force; a limit below it holds the share that it is."""
    contacts, load = grasp.contacts(), grasp.load()
    once = ks.grasp_equilibrium(contacts, load, rows=grasp.rows)
    bigger = ks.Wrench.on_robot(factor * load.force, factor * load.torque, OBJECT)
    again = ks.grasp_equilibrium(contacts, bigger, rows=grasp.rows)
    assert once.feasible == again.feasible
    if not once.feasible:
        return
    assert again.normal.max() == pytest.approx(factor * once.normal.max(), rel=1e-6)
    share = ks.grasp_equilibrium(contacts, load, rows=grasp.rows, limit=0.25 * once.normal.max())
    assert not share.feasible
    assert share.held == pytest.approx(0.25, rel=1e-6)
    assert share.normal.max() <= 0.25 * once.normal.max() * (1 + 1e-8)
    enough = ks.grasp_equilibrium(contacts, load, rows=grasp.rows, limit=1.001 * once.normal.max(), minimize="total")
    assert enough.feasible
    assert enough.normal.max() <= 1.001 * once.normal.max() * (1 + 1e-8)
    assert enough.normal.sum() <= once.normal.sum() * (1 + 1e-6)


@given(grasps(least=3, most=6, kinds=("friction", "soft")))
def test_margin_is_the_worst_load_per_newton(grasp):
    """Every load of the margin's size is held with normal forces of 1 N in all; the sum of least forces is convex."""
    contacts, rng = grasp.contacts(), np.random.default_rng(grasp.seed)
    closure = ks.force_closure(contacts, rows=grasp.rows, length=grasp.size, accuracy=0.2)
    if not closure.margin > 1e-6:
        return
    totals, loads = [], []
    for _ in range(2):
        direction = rng.normal(size=6)
        if grasp.planar:
            direction[2:5] = 0
        direction /= np.linalg.norm(direction)
        loads.append(ks.Wrench.on_robot(direction[:3], grasp.size * direction[3:], OBJECT))
        found = ks.grasp_equilibrium(contacts, loads[-1], rows=grasp.rows, minimize="total")
        assert found.feasible
        totals.append(found.normal.sum())
        assert closure.margin * totals[-1] <= 1 + 1e-6
    both = ks.Wrench.on_robot(loads[0].force + loads[1].force, loads[0].torque + loads[1].torque, OBJECT)
    together = ks.grasp_equilibrium(contacts, both, rows=grasp.rows, minimize="total").normal.sum()
    assert together <= sum(totals) * (1 + 1e-6)
