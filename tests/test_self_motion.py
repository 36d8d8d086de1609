"""`self_motion`: the tip stands still along a curve of postures, or it is said that it does so for an instant only."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import kinestatics as ks
from kinestatics.statics import decompose
from kinestatics.tasks import without_rounding
from strategies import features

PANDA, UR, PUMA = (ks.load(name) for name in ("panda", "ur5e", "puma_560"))
WRIST = np.array([0.3, -1.2, 1.1, -0.7, 0.0, 0.4])
STRAIGHT = np.array([0.3, 0.0])


def rows_of(found):
    return [("vx", "vy", "vz", "wx", "wy", "wz").index(row) for row in found.task]


def check_curve(model, found, q, step, tolerance=1e-9):
    """The tip at rest, tangents in the null space, even spacing, limits, and s = 0 at the posture asked about."""
    rows = rows_of(found)
    J = ks.jacobian(model, found.q).array[:, rows]
    size = max(1.0, np.abs(J).max(initial=0.0))
    assert np.abs(np.einsum("krn,kn->kr", J, found.tangent)).max() <= 1e-7 * size
    np.testing.assert_allclose(np.linalg.norm(found.tangent, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(np.diff(found.q, axis=0), axis=1), step, rtol=1e-7)
    np.testing.assert_allclose(np.diff(found.s), step, rtol=1e-9)
    zero = int(np.argmin(np.abs(found.s)))
    assert found.s[zero] == 0.0
    assert np.array_equal(found.q[zero], q)
    assert found.held.max() <= tolerance * max(1.0, found.length)
    assert np.all(found.q >= np.minimum(model.lower, q))
    assert np.all(found.q <= np.maximum(model.upper, q))
    assert np.all(np.sum(found.tangent[1:] * found.tangent[:-1], axis=1) > 0.5)


def check_still(model, found):
    """Forward kinematics as the judge: one pose for all postures."""
    T = ks.pose(model, found.q).array
    assert np.abs(T - T[0]).max() < 1e-9


# Redundant arms


@pytest.mark.parametrize(
    ("name", "q"),
    [
        ("panda", None),
        ("panda", [0.3, 0.4, -0.5, -1.8, 0.6, 1.9, 0.2]),
        ("iiwa_14", [0.1, 0.5, 0.2, -1.0, 0.3, 0.7, 0.1]),
        ("gen3", [0.1, 0.5, 0.2, -1.0, 0.3, 0.7, 0.1]),
    ],
)
def test_the_swivel_of_a_redundant_arm(name, q):
    """The elbow turns about the line from shoulder to wrist; with a spherical wrist and shoulder, joint 4 stands still."""
    model = ks.load(name)
    q = model.home if q is None else np.array(q)
    found = ks.self_motion(model, q, length=0.5)
    assert found.finite
    assert found.directions == 1
    assert len(found.s) == 101
    check_curve(model, found, q, 0.01)
    check_still(model, found)
    if name == "iiwa_14":
        assert np.ptp(found.q[:, 3]) < 1e-12
        elbow = ks.pose(model, found.q, at=model.link_names[4]).translation
        assert np.ptp(elbow, axis=0).max() > 0.01


def test_it_comes_back():
    """From its own end the same motion leads back through the posture it began at."""
    found = ks.self_motion(PANDA, PANDA.home, length=0.3)
    for end in (0, -1):
        back = ks.self_motion(PANDA, found.q[end], length=0.6)
        gaps = np.linalg.norm(back.q[:, None] - found.q[None], axis=-1).min(axis=0)
        assert gaps.max() < 1e-5  # between two postures of a chain 0.01 apart; the chains have the same posts
    again = ks.self_motion(PANDA, PANDA.home, length=0.3)
    assert np.array_equal(again.q, found.q)


def test_the_path_has_the_tangent_it_says():
    """Central differences of the postures, to second order in the step."""
    found = ks.self_motion(PANDA, PANDA.home, length=0.3)
    slopes = (found.q[2:] - found.q[:-2]) / 0.02
    assert np.abs(slopes - found.tangent[1:-1]).max() < 1e-3


def test_limits_end_it_and_are_named():
    found = ks.self_motion(PANDA, PANDA.home, length=8.0, step=0.05)
    check_curve(PANDA, found, PANDA.home, 0.05)
    assert found.s[-1] < 8.0
    assert "meets its" in found.reason
    named = [name for name in PANDA.joint_names if repr(name) in found.reason]
    assert named
    for name in named:
        k = PANDA.joint_names.index(name)
        room = np.minimum(found.q[[0, -1], k] - PANDA.lower[k], PANDA.upper[k] - found.q[[0, -1], k])
        assert room.min() < 0.05


def test_fewer_rows_leave_more_freedom():
    """A 6R arm that holds its position only: three null directions, each followed."""
    q = np.array([0.2, -1.2, 1.4, -0.7, 0.9, 0.3])
    for direction in range(3):
        found = ks.self_motion(UR, q, task="position", direction=direction, length=0.3)
        assert found.directions == 3
        assert found.finite
        check_curve(UR, found, q, 0.01)
        J = ks.jacobian(UR, q)
        null = decompose(without_rounding(UR, J.array), range(3), ks.characteristic_length(UR)).null_motion[direction]
        assert abs(abs(found.tangent[30] @ null) - 1.0) < 1e-3


# Singular postures


@pytest.mark.parametrize(
    ("model", "q"), [(UR, WRIST), (PUMA, np.array([0.3, -0.2, 0.1, 0.4, 0.0, 0.2]))], ids=["ur5e", "puma"]
)
def test_a_singular_wrist_turns_against_itself(model, q):
    """Axes 4 and 6 in line: a true self-motion, on which the wrist stays singular."""
    found = ks.self_motion(model, q)
    assert found.finite
    assert len(found.s) == 201
    check_curve(model, found, q, 0.01)
    check_still(model, found)
    assert np.abs(found.q[:, 4]).max() < 1e-12
    if model is PUMA:
        expected = np.zeros(6)
        expected[[3, 5]] = np.array([1, -1]) / np.sqrt(2)
        assert np.abs(found.tangent - expected).max() < 1e-9


@pytest.mark.parametrize(
    ("model", "q", "task"),
    [
        (ks.load("planar_2r"), STRAIGHT, "auto"),
        (UR, np.array([0.3, -1.2, 0.0, -0.7, 0.5, 0.4]), "auto"),
        (ks.load("planar_3r"), np.array([0.3, 0.0, 0.0]), "position"),
    ],
    ids=["2r", "ur5e", "3r"],
)
def test_a_stretched_elbow_is_for_an_instant_only(model, q, task):
    """The tip leaves with the square of s, and the motion says so; the null direction is shown all the same."""
    found = ks.self_motion(model, q, task=task)
    assert not found.finite
    assert found.reason.startswith("instantaneous only: the tip leaves its place to second order")
    assert found.s[0] == -found.s[-1]
    assert 0.1 <= found.s[-1] <= 0.2 + 1e-12
    zero = int(np.argmin(np.abs(found.s)))
    assert found.held[zero] == 0.0
    np.testing.assert_allclose(found.held[zero + 10] / found.held[zero + 5], 4.0, rtol=0.05)
    np.testing.assert_allclose(found.q, q + found.s[:, None] * found.tangent[zero], atol=1e-14)
    J = ks.jacobian(model, q).array[rows_of(found)]
    assert np.abs(J @ found.tangent[zero]).max() < 1e-12


def test_a_folded_arm_turns_with_its_tip_on_the_axis():
    """Equal links folded back: the tip is on axis 1 and stays there while joint 1 turns."""
    found = ks.self_motion(ks.load("planar_2r"), [0.3, np.pi])
    assert found.finite
    np.testing.assert_allclose(found.tangent, np.tile([1.0, 0.0], (201, 1)), atol=1e-9)


@pytest.mark.parametrize("direction", [0, 1])
def test_where_two_curves_cross_one_is_followed(direction):
    """Two null directions at a singular posture of a redundant arm: the nearest curve, straight through the crossing."""
    arm, q = ks.load("planar_3r"), np.array([0.3, np.pi, 0.0])
    found = ks.self_motion(arm, q, task="position", direction=direction)
    assert (found.finite, found.directions) == (True, 2)
    check_curve(arm, found, q, 0.01)
    zero = int(np.argmin(np.abs(found.s)))
    assert (found.q[zero + 1] - q) @ (q - found.q[zero - 1]) > 0.99e-4


@settings(max_examples=25)
@given(features(max_joints=8), st.integers(0, 2**31 - 1))
def test_laws_for_random_mechanisms(drawn, seed):
    """Random postures with null motion, random limits."""
    model, rng = drawn.model(), np.random.default_rng(seed)
    q = rng.normal(size=model.n)
    task = ks.find_task(model)
    assume(task.rows and model.n)
    model = replace(model, lower=q - rng.uniform(0, 1, model.n), upper=q + rng.uniform(0, 1, model.n))
    J = without_rounding(model, ks.jacobian(model, q).array)
    null = decompose(J, task.rows, ks.characteristic_length(model)).null_motion
    if not len(null):
        with pytest.raises(ks.ConfigurationError) as caught:
            ks.self_motion(model, q)
        assert caught.value.code == "KS379"
        return
    direction = int(rng.integers(len(null)))
    found = ks.self_motion(model, q, direction=direction, length=0.2)
    assert found.directions == len(null)
    if found.finite:
        check_curve(model, found, q, 0.01)


# Words and mistakes


def test_the_result_as_text_and_plain_data():
    found = ks.self_motion(PUMA, [0.3, -0.2, 0.1, 0.4, 0.0, 0.2], length=0.1)
    text = str(found)
    assert text.startswith("self-motion: s = -0.1 to 0.1 [rad or m], 21 postures")
    assert "at s = 0: joint4 0.7071, joint6 -0.7071" in text
    assert max(map(len, text.splitlines())) <= 80
    data = json.loads(json.dumps(found.to_dict()))
    assert data["finite"] is True
    assert data["q"] == found.q.tolist()
    assert pickle.loads(pickle.dumps(found)).reason == found.reason
    with pytest.raises(ValueError, match="read-only"):
        found.q[0, 0] = 1.0


@pytest.mark.parametrize(
    ("arguments", "error", "code"),
    [
        ({"q": [0.3, 0.4]}, ks.ConfigurationError, "KS379"),
        ({"direction": 1}, ks.ConfigurationError, "KS379"),
        ({"direction": -1}, ks.ConfigurationError, "KS379"),
        ({"direction": 0.5}, ks.ConfigurationError, "KS379"),
        ({"length": 0.0}, ks.ConfigurationError, "KS353"),
        ({"step": np.nan}, ks.ConfigurationError, "KS353"),
        ({"task": "sideways"}, ks.UnknownNameError, "KS318"),
        ({"q": [0.3]}, ks.ConfigurationError, "KS303"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_mistakes(arguments, error, code):
    arguments = {"q": STRAIGHT} | arguments
    with pytest.raises(error) as caught:
        ks.self_motion(ks.load("planar_2r"), arguments.pop("q"), **arguments)
    assert caught.value.code == code


def test_no_null_motion_says_what_would_have_one():
    with pytest.raises(ks.ConfigurationError, match="this posture has no null motion: every joint motion moves vx, vy"):
        ks.self_motion(ks.load("planar_2r"), [0.3, 0.4])
