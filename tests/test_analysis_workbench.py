"""What `analyze` says of speeds, forces, loads and reactions: the numbers of the functions, and words that go with them."""

import json
from dataclasses import replace

import numpy as np
import pytest

import kinestatics as ks

NAMES = ks.catalogue_names()


def loads_of(arm):
    """A load at the tip, one with a moment at a middle link, and a push."""
    middle = arm.link_names[len(arm.link_names) // 2]
    return [
        ("tip", ks.Wrench.on_robot(force=(1, -2, -30))),
        (middle, ks.Wrench.on_robot(force=(0, 5, 0), torque=(0.3, 0, 1))),
        ("tip", ks.Wrench.on_environment(force=(4, 0, 1))),
    ]


@pytest.mark.parametrize("name", NAMES)
def test_three_routes_agree_within_one_analysis(name):
    """Motors, free bodies and the loads' own torques: holding = gravity + loads = reactions."""
    arm = ks.load(name)
    for q in arm.random_configurations(3, seed=6):
        a = ks.analyze(arm, q, loads_of(arm))
        own = np.zeros(arm.n) if a.gravity_torques is None else a.gravity_torques
        size = np.abs(a.holding_torques).max() + 1.0
        np.testing.assert_allclose(a.holding_torques, own + a.joint_torques, atol=1e-12 * size)
        np.testing.assert_allclose(a.reactions.torques, a.holding_torques, atol=1e-11 * size)
        np.testing.assert_allclose(sum(load.joint_torques for load in a.loads), a.joint_torques, atol=1e-12 * size)
        if a.gravity_by_link is not None:
            np.testing.assert_allclose(sum(a.gravity_by_link.values()), a.gravity_torques, atol=1e-12 * size)
            assert a.potential_energy == pytest.approx(float(ks.potential_energy(arm, q)))
        for load in a.loads:
            parts = (load.split.active, load.split.structure, load.split.impossible)
            np.testing.assert_allclose(sum(part.array for part in parts), load.wrench.array, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_ellipsoids_are_those_of_the_rows_in_play(name):
    """Radii are singular values of the linear rows in play, of the angular ones where none is linear; force is the dual."""
    arm = ks.load(name)
    for q in (arm.home, *arm.random_configurations(3, seed=7)):
        a = ks.analyze(arm, q)
        linear = [row for row in a.task.rows if row < 3] or list(a.task.rows)
        sigma = np.linalg.svd(a.jacobian.array[linear], compute_uv=False)
        radii = a.velocity_ellipsoid.radii
        np.testing.assert_allclose(radii[: len(sigma)], sigma, atol=1e-9)
        held = radii == 0
        assert np.all(np.isinf(a.force_ellipsoid.radii[held]))
        np.testing.assert_allclose(radii[~held] * a.force_ellipsoid.radii[~held], 1.0, atol=1e-12)
        np.testing.assert_array_equal(a.velocity_ellipsoid.axes, a.force_ellipsoid.axes)


@pytest.mark.parametrize("name", NAMES)
def test_abilities_are_those_of_the_functions(name):
    """Greatest speeds and pushes along the axes of base are those of speed_capacity and force_capacity, or unknown."""
    arm = ks.load(name)
    q = arm.random_configurations(1, seed=8)[0]
    a = ks.analyze(arm, q)
    for able in a.abilities:
        direction = {"+": 1.0, "-": -1.0}[able.direction[0]] * np.eye(3)["xyz".index(able.direction[1])]
        if able.speed is not None:
            found = ks.speed_capacity(arm, q, direction)
            assert (able.speed, able.speed_joints) == (pytest.approx(found.value), tuple(found.limiting_joints))
        if able.push is not None:
            found = ks.force_capacity(arm, q, direction)
            assert (able.push, able.push_joints) == (pytest.approx(found.value), (found.limiting_joint,))
    known = [np.all(np.isfinite(limits)) for limits in (arm.velocity_limits, arm.effort_limits)]
    assert all((able.speed is not None) == known[0] for able in a.abilities)
    assert all((able.push is not None) == (known[1] and arm.has_masses) for able in a.abilities)
    assert any("velocity limits are unknown" in note for note in a.notes) != known[0]
    assert (a.payload_capacity is not None) == (bool(known[1]) and arm.has_masses)
    if a.payload_capacity is not None:
        assert a.payload_capacity.value == ks.payload_capacity(arm, q).value


def test_a_payload_is_in_gravity_and_capacity():
    """What the arm carries already is taken off what it can carry."""
    arm = ks.load("ur5e")
    q = arm.random_configurations(1, seed=9)[0]
    bare, loaded = ks.analyze(arm, q), ks.analyze(arm.with_payload(3.0), q)
    weight = ks.joint_torques(bare.jacobian, ks.Wrench.on_robot(force=(0, 0, -3 * 9.81)))
    np.testing.assert_allclose(loaded.gravity_torques, bare.gravity_torques + weight, atol=1e-12)
    assert loaded.payload_capacity.value == pytest.approx(bare.payload_capacity.value - 3.0)
    assert "payload" in loaded.gravity_by_link


def test_the_straight_leg_is_said_to_push_without_limit():
    """Lecture 004: along the leg the structure holds; the push is unlimited in print, and null with a word in JSON."""
    leg = ks.from_dh(
        [(0.43, 0, 0, 0), (0.43, 0, 0, 0)],
        convention="standard",
        masses=[8.0, 4.0],
        centers_of_mass=[(-0.2, 0, 0)] * 2,
    )
    leg = replace(leg, effort_limits=np.full(2, 250.0))
    a = ks.analyze(leg, [np.pi / 2, 0.0], gravity=(0, -9.81, 0))
    up = next(able for able in a.abilities if able.direction == "+y")
    assert np.isinf(up.push)
    assert "unlimited" in str(a)
    stored = next(able for able in a.to_dict()["abilities"] if able["direction"] == "+y")
    assert (stored["push"], stored["push_unlimited"]) == (None, True)
    json.dumps(a.to_dict(), allow_nan=False)


def test_who_holds_each_load_is_said():
    """A stretched arm: the axial part is the structure's, the rest the motors'; each load has its paragraph."""
    text = str(ks.analyze(ks.load("planar_2r"), [0.0, 0.0], loads_of(ks.load("planar_2r"))))
    assert text.count("held by the structure:") + text.count("made by the motors:") >= 3
    assert "fx 1, fz -30 (no joint feels it)" in text


def test_an_arm_without_joints_is_analyzed():
    """Nothing moves, nothing is asked of motors; no crash."""
    arm = ks.load("planar_2r", tip="link1", joints={"joint1": 0.2})
    a = ks.analyze(arm, [])
    assert (a.abilities, a.velocity_ellipsoid, a.payload_capacity) == ((), None, None)
    assert "0 joints" in str(a)
    json.dumps(a.to_dict(), allow_nan=False)
