"""Changing the frame: a group action that keeps power, for every mechanism."""

import numpy as np
import pytest
from hypothesis import given

import kinestatics as ks
from kinestatics.spatial import change_wrench_frame
from strategies import assert_close, features

ROUNDING = 1e-13


def some_frames(model, seed):
    rng = np.random.default_rng(seed)
    names = [model.link_name(i) for i in range(len(model.link_names))]
    picked = [names[i] for i in rng.integers(len(names), size=2)]
    return [ks.Frame(), ks.Frame.body(), ks.Frame.spatial(), ks.Frame(*picked, offset=(0.3, -0.2, 0.5))]


@given(features(max_joints=6))
def test_change_of_frame_is_a_group_action(f):
    """A → B → C is A → C, and A → B → A is nothing; asking for the frame is the same as changing to it."""
    model = f.model()
    q = f.configurations(2)
    frames = some_frames(model, f.seed)
    J = ks.jacobian(model, q)
    for first in frames:
        there = J.change_frame(first)
        assert_close(there.change_frame(J.frame).array, J.array, ROUNDING * 100)
        assert_close(there.array, ks.jacobian(model, q, frame=first).array, ROUNDING * 100)
        for second in frames:
            assert_close(there.change_frame(second).array, J.change_frame(second).array, ROUNDING * 100)


@given(features(max_joints=6))
def test_power_is_the_same_in_every_frame(f):
    """τ · q̇ = w · V, whatever frame w and V are written in."""
    model = f.model()
    rng = np.random.default_rng(f.seed)
    q, qd, wrench = f.configurations(), rng.normal(size=model.n), rng.normal(size=6)
    base = ks.jacobian(model, q, frame=ks.Frame.spatial())
    power = wrench @ (base.array @ qd)
    for frame in some_frames(model, f.seed):
        J = base.change_frame(frame)
        _, R, p, xp = J._locate(frame)
        there = ks.Wrench(change_wrench_frame(wrench, R, p, xp), J.frame, "environment")
        assert abs(ks.joint_torques(J, there) @ qd - power) <= ROUNDING * 1000 * max(
            1.0, np.abs(J.array).max(initial=0.0) ** 2
        )
        assert abs(np.asarray(there) @ np.asarray(J @ qd) - power) <= ROUNDING * 1000 * max(
            1.0, np.abs(J.array).max(initial=0.0) ** 2
        )


@given(features(max_joints=6, tree=False))
def test_body_jacobian_is_the_adjoint_of_the_spatial_one(f):
    """J_body = Ad(g⁻¹) J_spatial (MLS eq. 3.60), Ad written out as a 6 x 6 matrix."""
    model = f.model()
    q = f.configurations()
    T = ks.pose(model, q).array
    R, p = T[:3, :3], T[:3, 3]
    hat = np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
    inverse_adjoint = np.block([[R.T, -R.T @ hat], [np.zeros((3, 3)), R.T]])
    spatial = ks.jacobian(model, q, frame=ks.Frame.spatial()).array
    assert_close(ks.jacobian(model, q, frame=ks.Frame.body()).array, inverse_adjoint @ spatial, ROUNDING * 10)


def test_a_wrench_in_another_frame_is_refused_with_the_remedy():
    """Mixing frames is an error that names both and says what to do."""
    arm = ks.load("ur5e")
    J = ks.jacobian(arm, arm.home)
    with pytest.raises(ks.FrameMismatchError, match=r"KS330.*tool0") as caught:
        ks.joint_torques(J, ks.Wrench.on_robot(force=(0, 0, 1), frame=ks.Frame.body()))
    assert "change_frame" in caught.value.hint
