"""Gravity torques are the gradient of potential energy, link by link, for every mechanism and direction."""

import numpy as np
from hypothesis import given

import kinestatics as ks
from strategies import assert_close, features

STEP = 1e-5


def potential(model, q, gravity):
    """-Σ m g · p_com, from the poses of the links alone."""
    energy = np.zeros(q.shape[:-1])
    for i, mass in enumerate(model.masses):
        T = ks.pose(model, q, at=model.link_name(i), point=tuple(model.centers_of_mass[i])).array
        energy = energy - mass * T[..., :3, 3] @ np.asarray(gravity)
    return energy


@given(features(max_joints=6))
def test_gravity_torque_is_the_gradient_of_potential_energy(f):
    """τ_hold = ∂U/∂q, for any direction of gravity."""
    model = f.model()
    if model.n == 0 or not model.has_masses:
        return
    gravity = np.random.default_rng(f.seed).normal(size=3) * 9.81
    q = f.configurations(2)
    torques = ks.gravity_torques(model, q, gravity=gravity)
    for k in range(model.n):
        step = np.zeros(model.n)
        step[k] = STEP
        slope = (potential(model, q + step, gravity) - potential(model, q - step, gravity)) / (2 * STEP)
        assert np.abs(torques[..., k] - slope).max() <= 1e-7 * max(1.0, np.abs(potential(model, q, gravity)).max())


@given(features(max_joints=6))
def test_links_add_up(f):
    """The torques of the links add up to those of the arm; a centre of mass moves as its Jacobian says."""
    model = f.model()
    if not model.has_masses:
        return
    q = f.configurations(2)
    by_link = ks.gravity_torques(model, q, by_link=True)
    assert_close(by_link.sum(-2), ks.gravity_torques(model, q), 1e-12)
    assert by_link.shape == (2, len(model.link_names), model.n)


@given(features(max_joints=5))
def test_energy_kept_by_com_jacobians(f):
    """-Σ m gᵀ J_com is the same torque again."""
    model = f.model()
    if not model.has_masses:
        return
    q, g = f.configurations(), np.array([0.0, 0.0, -9.81])
    masses = dict(zip(model.link_names, model.masses, strict=True))
    total = sum((-masses[name] * g @ J for name, J in ks.com_jacobians(model, q).items()), np.zeros(model.n))
    assert_close(total, ks.gravity_torques(model, q), 1e-12)
