"""`move_tip`: the place is met, limits are kept all along, steps are small, singular postures are left, reasons are true."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import kinestatics as ks
from kinestatics.inverse_velocity.box import least_in_box
from kinestatics.inverse_velocity.tip_map import rotation_vector
from strategies import features, random_rotation

ARMS = (
    "panda",
    "iiwa_14",
    "gen3",
    "ur5e",
    "puma_560",
    "stanford_arm",
    "scara",
    "planar_2r",
    "planar_3r",
    "rrp_note_000",
    "al5d",
)
PLANAR = ks.load("planar_2r")


def shifted(model, q, shift):
    """The pose at q, displaced in base axes."""
    T = ks.pose(model, q).array.copy()
    T[:3, 3] += shift
    return T


def turned(axis, angle):
    w = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


def check_path(model, found, start, step, margin=0.0):
    """What holds for every motion, whether the place was reached or not."""
    assert np.array_equal(found.path[0], start)
    assert np.array_equal(found.path[-1], found.q)
    assert np.abs(np.diff(found.path, axis=0)).max(initial=0.0) <= step * (1 + 1e-12)
    lower, upper = np.minimum(model.lower + margin, start), np.maximum(model.upper - margin, start)
    assert np.all(found.path >= lower)
    assert np.all(found.path <= upper)
    assert found.reached == (found.reason == "reached")


# Laws


@settings(max_examples=60)
@given(features(), st.floats(0.0, 0.4), st.integers(0, 2**31 - 1))
def test_laws_for_random_mechanisms(drawn, spread, seed):
    """A place near by, made by the arm itself inside random limits: path laws always; where reached, the rows are there."""
    model = drawn.model()
    rng = np.random.default_rng(seed)
    q = rng.normal(size=model.n)
    model = replace(model, lower=q - rng.uniform(0, 0.5, model.n), upper=q + rng.uniform(0, 0.5, model.n))
    assume(model.n and ks.find_task(model).rows)
    goal = np.clip(q + spread * rng.normal(size=model.n), model.lower, model.upper)
    target = ks.pose(model, goal)
    found = ks.move_tip(model, q, target, task=ks.find_task(model).rows)
    check_path(model, found, q, 0.05)
    here = ks.pose(model, found.q)
    rows = ks.find_task(model).rows
    six = np.r_[target.translation - here.translation, rotation_vector(target.rotation @ here.rotation.T)][list(rows)]
    linear = np.array([row < 3 for row in rows])
    assert found.distance == pytest.approx(np.linalg.norm(six[linear]), rel=1e-9, abs=1e-14)
    assert found.angle == pytest.approx(np.linalg.norm(six[~linear]), rel=1e-9, abs=1e-14)
    if found.reached:
        assert np.abs(six).max() <= 1e-6
    again = ks.move_tip(model, q, target, task=rows)
    assert np.array_equal(again.path, found.path)
    assert again.reason == found.reason


@pytest.mark.parametrize("name", ARMS)
def test_a_small_drag_of_the_catalogue(name):
    """Moves of 1 to 5 cm: met to 1e-9 where they are met, which is nearly always; the rest says what is in the way."""
    model, rng = ks.load(name), np.random.default_rng(5)
    reached = 0
    postures = model.random_configurations(60, seed=7)
    for q in postures:
        direction = rng.normal(size=3) * ([1, 1, 0] if name.startswith("planar") else [1, 1, 1])
        target = shifted(model, q, direction / np.linalg.norm(direction) * rng.uniform(0.01, 0.05))
        found = ks.move_tip(model, q, target)
        check_path(model, found, q, 0.05)
        reached += found.reached
        if found.reached:
            here = ks.pose(model, found.q).array
            assert np.abs(here[:3, 3] - target[:3, 3]).max() < 2e-9
            if len(found.task) == 6:
                assert np.abs(here - target).max() < 2e-9
        else:
            assert found.distance + found.angle > 1e-6
            assert found.reason.startswith(("joint", "out of reach", "singular", "not there"))
    assert reached >= 0.7 * len(postures)


@pytest.mark.parametrize("name", ARMS)
def test_its_own_pose_leaves_it_where_it_is(name):
    """The path is the posture itself, bit by bit."""
    model = ks.load(name)
    for q in model.random_configurations(20, seed=1):
        found = ks.move_tip(model, q, ks.pose(model, q))
        assert found.reached
        assert np.array_equal(found.path, [q])


def test_a_position_leaves_the_orientation_free():
    """Rows in play: three; two for an arm in a plane, whose third coordinate is not looked at."""
    arm = ks.load("ur5e")
    q = np.array([0.2, -1.2, 1.4, -0.7, 0.9, 0.3])
    goal = ks.pose(arm, q).translation + np.array([0.0, 0.1, -0.05])
    found = ks.move_tip(arm, q, goal)
    assert found.task == ("vx", "vy", "vz")
    np.testing.assert_allclose(ks.pose(arm, found.q).translation, goal, atol=1e-9)
    assert found.angle == 0.0
    flat = ks.move_tip(PLANAR, [0.0, 0.5], [1.0, 1.0, 7.0])
    assert flat.task == ("vx", "vy")
    np.testing.assert_allclose(flat.q, [0.0, np.pi / 2], atol=1e-9)
    assert ks.move_tip(ks.load("al5d"), np.full(4, 0.4), ks.pose(ks.load("al5d"), np.full(4, 0.5))).task == (
        "vx",
        "vy",
        "vz",
    )


def test_margin_and_step_are_kept():
    """With a margin no joint comes nearer to its limit; with a small step the path is longer and ends in the same place."""
    arm = ks.load("panda")
    target = shifted(arm, arm.home, [0.3, 0.0, -0.3])
    found = ks.move_tip(arm, arm.home, target, margin=0.3, step=0.02)
    check_path(arm, found, arm.home, 0.02, margin=0.3)
    assert found.reached
    assert len(found.path) > 15


# Singular postures and limits


def test_a_stretched_elbow_bends():
    """Pulled inwards along the lost direction no rate helps; the curvature does, always to the same side."""
    for angle in (0.0, 0.3, -2.0):
        q = np.array([angle, 0.0])
        goal = 1.9 * np.array([np.cos(angle), np.sin(angle), 0.0])
        found = ks.move_tip(PLANAR, q, goal)
        assert found.reached
        assert found.singularity < 1e-12
        assert abs(abs(found.q[1]) - np.arccos(1.9**2 / 2 - 1)) < 1e-8
        np.testing.assert_allclose(ks.pose(PLANAR, found.q).translation, goal, atol=1e-9)
        assert np.array_equal(found.q, ks.move_tip(PLANAR, q, goal).q)


def test_beyond_the_reach_it_ends_stretched_towards_the_target():
    """The nearest point of the disk, and how far it is from there."""
    goal = np.array([1.5, 2.0, 0.0])
    found = ks.move_tip(PLANAR, [0.1, 0.8], goal)
    assert not found.reached
    assert found.distance == pytest.approx(0.5, abs=1e-5)
    assert found.reason == "out of reach from here: 0.5 m away"
    np.testing.assert_allclose(ks.pose(PLANAR, found.q).translation, goal * 2.0 / 2.5, atol=1e-2)


def test_a_limit_in_the_way_is_named():
    """A joint that is stopped is named with its side; it stands at its limit, and nothing is beyond."""
    arm = replace(PLANAR, lower=np.array([-np.pi, -np.pi]), upper=np.array([np.pi, 0.7]))
    found = ks.move_tip(arm, [0.0, 0.5], [0.5, 0.2, 0.0])
    assert found.at_limit == {"joint2": "upper"}
    assert found.q[1] == 0.7
    assert found.reason.startswith("joint 'joint2' is at its upper limit: ")
    assert "at its upper limit" in str(found)


def test_a_joint_outside_may_come_in_only():
    """A start beyond a limit is allowed: that joint never goes further out."""
    arm = replace(PLANAR, lower=np.array([-np.pi, 0.2]), upper=np.array([np.pi, 1.0]))
    out, back = (ks.move_tip(arm, [0.0, 1.2], ks.pose(PLANAR, [0.1, bend])) for bend in (1.6, 0.6))
    assert out.path[:, 1].max() == 1.2
    assert not out.reached
    assert back.reached
    assert np.all(np.diff(back.path[:, 1]) <= 0.0)


@pytest.mark.parametrize(
    ("name", "q"),
    [("ur5e", [0.3, -1.2, 1.3, -0.9, 0.0, 0.4]), ("puma_560", [0.3, -0.6, 0.4, 0.2, 0.0, -0.3])],
    ids=["ur5e", "puma_560"],
)
@pytest.mark.parametrize("direction", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.3, -0.7, 0.5]], ids=["x", "y", "z", "oblique"])
def test_through_the_wrist_singularity(name, q, direction):
    """A straight line of the tip in pieces of 1 cm through a singular wrist: bounded steps, each piece on target."""
    arm, unit = ks.load(name), np.asarray(direction) / np.linalg.norm(direction)
    middle = ks.pose(arm, q).array
    here = np.array(q)
    for shift in np.linspace(-0.05, 0.05, 11):
        target = middle.copy()
        target[:3, 3] += shift * unit
        found = ks.move_tip(arm, here, target)
        check_path(arm, found, here, 0.05)
        assert found.reached, (shift, found.reason)
        np.testing.assert_allclose(ks.pose(arm, found.q).array, target, atol=2e-9)
        here = found.q


def test_the_smallest_singular_value_on_the_way():
    """The least over the path of what the Jacobians say, angles counted with the characteristic length."""
    arm = ks.load("ur5e")
    q = np.array([0.2, -1.2, 1.4, -0.7, 0.9, 0.3])
    found = ks.move_tip(arm, q, shifted(arm, q, [0.1, 0.0, 0.1]))
    J = ks.jacobian(arm, found.path).array * np.r_[np.ones(3), np.full(3, ks.characteristic_length(arm))][:, None]
    sigma = np.linalg.svd(J, compute_uv=False)
    assert found.singularity == pytest.approx((sigma[:, -1] / sigma[:, 0]).min(), rel=1e-9)


# The box, the rotation vector


@given(st.integers(0, 2**31 - 1), st.integers(1, 8))
def test_the_box_is_the_optimum(seed, n):
    """Karush, Kuhn and Tucker: inside, and the slope is zero or pushes outwards; some bounds are 0, some are open."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(int(rng.integers(1, 9)), n))
    G, g = A.T @ A + 10.0 ** rng.uniform(-8, 0) * np.eye(n), A.T @ rng.normal(size=len(A))
    lower, upper = (-rng.uniform(0, 1, n), rng.uniform(0, 1, n)) * np.where(rng.random((2, n)) < 0.2, 0.0, 1.0)
    upper[rng.random(n) < 0.2] = np.inf
    x = least_in_box(G, g, lower, upper)
    assert np.all((x >= lower) & (x <= upper))
    slope, least = g - G @ x, 1e-9 * (np.abs(g).max() + np.abs(G).max() * np.abs(x).max())
    assert np.all(np.abs(slope[(x > lower) & (x < upper)]) <= least)
    assert np.all(slope[(x == upper) & (x > lower)] >= -least)
    assert np.all(slope[(x == lower) & (x < upper)] <= least)


@given(
    st.integers(0, 2**31 - 1), st.sampled_from([0.0, 1e-9, 1e-3, 1.0, 2.0, np.pi - 1e-3, np.pi - 1e-6, np.pi - 1e-9, np.pi])
)
def test_rotation_vectors_turn_back_into_rotations(seed, angle):
    """Axis times angle, and the rotation about it again."""
    rng = np.random.default_rng(seed)
    R = turned(rng.normal(size=3), angle)
    w = rotation_vector(R)
    assert np.linalg.norm(w) == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(turned(w, np.linalg.norm(w)) if angle else np.eye(3), R, atol=1e-9)


def test_a_target_behind_the_arm_is_turned_to():
    """Half a turn of a wrist, and a random orientation far away: many steps, still met."""
    arm = ks.load("iiwa_14")
    q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.9, 0.1])
    target = ks.pose(arm, q).array.copy()
    target[:3, :3] = target[:3, :3] @ turned([0, 0, 1], 2.9)
    assert ks.move_tip(arm, q, target).reached
    target[:3, :3] = random_rotation(np.random.default_rng(3), right_angles=True)
    found = ks.move_tip(arm, q, target)
    check_path(arm, found, q, 0.05)


# Words and mistakes


def test_the_result_as_text_and_plain_data():
    found = ks.move_tip(PLANAR, [0.0, 0.5], [1.0, 1.0, 0.0])
    lines = str(found).splitlines()
    assert lines[0].startswith("motion of the tip: reached, after ")
    assert max(map(len, lines)) <= 80
    data = json.loads(json.dumps(found.to_dict()))
    assert data["path"] == found.path.tolist()
    assert data["reason"] == "reached"
    assert pickle.loads(pickle.dumps(found)).reason == "reached"
    with pytest.raises(ValueError, match="read-only"):
        found.q[0] = 1.0


def test_steps_run_out():
    found = ks.move_tip(PLANAR, [0.0, 0.5], [-1.0, 1.0, 0.0], most_steps=3)
    assert len(found.path) == 4
    assert found.reason.startswith("not there after the steps allowed: ")
    assert not found.reached


@pytest.mark.parametrize(
    ("changes", "error", "code"),
    [
        ({"target": [1.0, 2.0]}, ks.ConfigurationError, "KS378"),
        ({"target": [1.0, np.nan, 0.0]}, ks.ConfigurationError, "KS378"),
        ({"target": 2 * np.eye(4)}, ks.ConfigurationError, "KS378"),
        ({"target": "home"}, ks.ArrayTypeError, "KS302"),
        ({"task": "orientation"}, ks.ConfigurationError, "KS378"),
        ({"task": "sideways"}, ks.UnknownNameError, "KS318"),
        ({"at": "hand"}, ks.UnknownNameError, "KS310"),
        ({"q": [[0.0, 0.0]]}, ks.ConfigurationError, "KS303"),
        ({"step": 0.0}, ks.ConfigurationError, "KS353"),
        ({"tolerance": -1.0}, ks.ConfigurationError, "KS353"),
        ({"most_steps": 2.5}, ks.ConfigurationError, "KS353"),
        ({"margin": -1.0}, ks.ConfigurationError, "KS353"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_mistakes(changes, error, code):
    arguments = {"q": [0.0, 0.5], "target": [1.0, 1.0, 0.0]} | changes
    with pytest.raises(error) as caught:
        ks.move_tip(PLANAR, arguments.pop("q"), arguments.pop("target"), **arguments)
    assert caught.value.code == code
