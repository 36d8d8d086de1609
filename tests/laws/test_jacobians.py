"""Pose, Jacobian, Hessian and rate are derivatives of one another, in every frame, for every mechanism."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import kinestatics as ks
from kinestatics import definition
from kinestatics.definition import Target
from kinestatics.namespaces import as_array
from oracle import exact_poses, jacobian
from strategies import Features, assert_close, features

STEP = 1e-5
DIFFERENCE = 2e-9  # central differences at this step: error h² plus rounding 1e-16 / h, times a few


def targets(model, seed):
    """The tip in base axes, in its own, at the base, and in two arbitrary links' axes and origins."""
    rng = np.random.default_rng(seed)
    tip, base = model.link("tip"), model.link("base")
    any_axes, any_origin = rng.integers(len(model.link_names), size=2)
    offset = tuple(rng.normal(size=3))
    return [
        Target(tip, base, tip),
        Target(tip, tip, tip, offset),
        Target(tip, base, base),
        Target(tip, tip, base),
        Target(tip, int(any_axes), int(any_origin), offset),
    ]


def differences(function, q):
    """∂ function / ∂ q_k along a new last axis."""
    columns = []
    for k in range(q.shape[-1]):
        step = np.zeros(q.shape[-1])
        step[k] = STEP
        columns.append((function(q + step) - function(q - step)) / (2 * STEP))
    return np.stack(columns, -1)


@given(features())
def test_jacobian_is_the_derivative_of_the_pose(f):
    """Linear rows are ∂p/∂q; angular rows are the axial vector of ∂R/∂q Rᵀ."""
    model = f.model()
    if model.n == 0:
        return
    q, xp = as_array(f.configurations(3))
    for target in targets(model, f.seed)[:2]:
        in_base = Target(target.link, model.link("base"), target.origin, target.offset)
        place = Target(target.link, target.link, target.origin, target.offset)
        J = definition.jacobian(model, q, in_base, xp)
        R, _ = definition.pose(model, q, place, xp)
        dp = differences(lambda x, place=place: definition.pose(model, x, place, xp)[1], q)
        dR = differences(lambda x, place=place: definition.pose(model, x, place, xp)[0], q)
        W = np.einsum("...ijk,...lj->...ilk", dR, R)
        assert_close(J[..., :3, :], dp, DIFFERENCE)
        assert_close(J[..., 3:, :], np.stack([W[..., 2, 1, :], W[..., 0, 2, :], W[..., 1, 0, :]], -2), DIFFERENCE)


@given(features())
def test_hessian_is_the_derivative_of_the_jacobian_in_every_frame(f):
    """H[r, j, k] = ∂J[r, j]/∂q_k, the motion of the frame included."""
    model = f.model()
    if model.n == 0:
        return
    q, xp = as_array(f.configurations(2))
    for target in targets(model, f.seed):
        expected = differences(lambda x, target=target: definition.jacobian(model, x, target, xp), q)
        assert_close(definition.hessian(model, q, target, xp), expected, 10 * DIFFERENCE)


@given(features())
def test_rate_is_the_derivative_along_the_motion(f):
    """J̇ = d/dt of the matrix returned, and J q̈ + J̇ q̇ is the second derivative of the tip's position."""
    model = f.model()
    q, qd = f.configurations(2), f.without(seed=f.seed + 7).configurations(2)[..., : model.n]
    if model.n == 0 or qd.shape != q.shape:
        return
    rate = ks.jacobian_rate(model, q, qd).array
    expected = (ks.jacobian(model, q + STEP * qd).array - ks.jacobian(model, q - STEP * qd).array) / (2 * STEP)
    assert_close(rate, expected, 100 * DIFFERENCE)
    h = 1e-4
    along = [ks.pose(model, q + s * h * qd).translation for s in (-1, 0, 1)]
    second = (along[0] - 2 * along[1] + along[2]) / h**2
    found = ks.acceleration(model, q, qd, np.zeros(model.n)).linear
    assert np.abs(found - second).max() <= 1e-5 * max(1.0, np.abs(q).max() * np.abs(qd).max() ** 3, np.abs(second).max())


@pytest.mark.parametrize("seed", range(200))
def test_against_fifty_digits(seed):
    """Pose and Jacobian of random chains agree with an oracle of 50 digits to 1e-13 per metre of reach."""
    f = Features(seed=seed, joints=1 + seed % 7, mimic=seed % 3 == 0, right_angles=seed % 2 == 0)
    description, model = f.description(), f.model()
    values = np.random.default_rng(seed).normal(size=model.n) * 3
    by_name = dict(zip(model.joint_names, values, strict=True))
    free = {j.name: by_name.get(j.name, 0.0) for j in description.joints if j.mimic is None and j.kind != "fixed"}
    tip = f"l{f.joints}"
    exact = np.array(exact_poses(description, free)[tip].tolist(), dtype=float)
    assert_close(ks.pose(model, values).array, exact, 1e-13)
    if model.n and seed % 4 == 0:
        assert_close(ks.jacobian(model, values).array, jacobian(description, free, tip, model.joint_names), 1e-13)


@settings(max_examples=15)
@given(features(tree=True, mimic=False), st.sampled_from([(), (4,), (2, 3), (0,)]))
def test_relative_jacobian_is_the_derivative_of_the_relative_pose(f, shape):
    """The twist of one moving link as seen from another."""
    model = f.model()
    if model.n == 0:
        return
    observer = model.link_name(int(np.random.default_rng(f.seed).integers(len(model.link_names))))
    q = f.configurations(*shape)

    def relative(x):
        seen, from_ = ks.pose(model, x), ks.pose(model, x, at=observer)
        return np.einsum("...ji,...j->...i", from_.rotation, seen.translation - from_.translation)

    found = ks.relative_jacobian(model, q, relative_to=observer)
    assert_close(found.linear, differences(relative, q), 10 * DIFFERENCE)
    assert found.frame.axes == observer
