"""`analyze`: ranks, lost directions and their words, torques, limits, tasks and units, on every bundled arm.

Singular postures are constructed from geometry; ranks, screws and torques are computed again here by other means.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

import kinestatics as ks
from kinestatics.spatial import LINEAR_ROWS
from kinestatics.tasks import prismatic_columns
from strategies import features

NAMES = ks.catalogue_names()
HALF = np.pi / 2
PUMA_ELBOW = np.arctan2(0.4318, -0.0203) - np.pi  # upper arm and forearm of the PUMA 560 in line
SINGULAR = {  # postures that geometry says are singular
    "planar_2r": ([0.4, 0.0], [0.4, np.pi]),
    "planar_3r": ([0.4, 0.0, 0.0], [0.4, 0.0, 0.7], [0.4, np.pi, 0.0]),
    "scara": ([0.4, 0.0, 0.1, 0.2],),
    "rrp_note_000": ([0.4, HALF, 0.8], [0.4, 0.3, 0.0], [0.4, HALF, 0.0]),
    "rrp_note_001": ([0.4, 0.0, 2.0], [0.4, -HALF, 0.0]),
    "elbow_rrr": ([0.4, 0.3, 0.0], [0.4, HALF, 0.0]),
    "puma_560": ([0.1, 0.4, -1.0, 0.3, 0.0, 0.2], [0.1, 0.4, PUMA_ELBOW, 0.3, 0.5, 0.2]),
    "ur5e": ([0.3, -0.8, 1.1, -0.9, 0.0, 0.4], [0.3, -0.8, 0.0, -0.9, 0.7, 0.4], [0.3, -0.8, 0.0, -0.9, 0.0, 0.4]),
    "stanford_arm": ([0.3, 0.5, 0.6, 0.3, 0.0, 0.2],),
    "kr5": ([0.3, -0.5, 0.6, 0.3, 0.0, 0.2],),
    "irb_140": ([0.3, -0.5, 0.6, 0.3, 0.0, 0.2],),
}


def postures(name):
    """Zero, home, four seeded random postures within the limits, and the singular ones by construction."""
    arm = ks.load(name)
    return arm, [np.zeros(arm.n), arm.home, *arm.random_configurations(4, seed=11), *map(np.array, SINGULAR.get(name, ()))]


def weights(analysis):
    """What makes a twist's rows comparable: the characteristic length on angular rows where the task mixes the two."""
    length = analysis.characteristic_length if "angular rows" in analysis.scaled else 1.0
    return np.r_[1, 1, 1, length, length, length]


def twist_of(screw):
    """(v, ω) at the frame's origin: v = p × ω + h ω."""
    if screw.point is None:
        return np.r_[screw.direction, np.zeros(3)]
    return np.r_[np.cross(screw.point, screw.direction) + screw.pitch * screw.direction, screw.direction]


def wrench_of(screw):
    """(f, τ) at the frame's origin: τ = p × f + h f."""
    if screw.point is None:
        return np.r_[np.zeros(3), screw.direction]
    return np.r_[screw.direction, np.cross(screw.point, screw.direction) + screw.pitch * screw.direction]


def rank_again(analysis):
    """The rank by another routine, on rows scaled in another way."""
    rows = weights(analysis)[:, None] * np.asarray(analysis.jacobian)
    rows = rows[list(analysis.task.rows)]
    return np.linalg.matrix_rank(rows, tol=1e-10 * np.linalg.norm(rows, 2)) if rows.any() else 0


def scaled_model(arm, factor):
    """The same arm in another unit of length."""
    prismatic = np.array([kind == "prismatic" for kind in arm.kinds])
    placements, links, screws = np.array(arm.placements), np.array(arm.link_placements), np.array(arm.screws)
    placements[:, :3, 3] *= factor
    links[:, :3, 3] *= factor
    screws[~prismatic, :3] *= factor
    lengths = np.where(prismatic_columns(arm), factor, 1.0)
    limits = {"lower": arm.lower * lengths, "upper": arm.upper * lengths, "home": arm.home * lengths}
    return replace(arm, placements=placements, link_placements=links, screws=screws, **limits), lengths


# ---- rank, lost directions, free wrenches --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_rank_and_lost_directions_fill_the_rows(name):
    """Rank, lost twists and free wrenches: they add up to the rows in play, and the rank is what another routine finds."""
    arm, configurations = postures(name)
    for q in configurations:
        a = ks.analyze(arm, q)
        assert a.rank == rank_again(a)
        assert a.rank <= a.task.rank <= min(len(a.task.rows), arm.n)
        assert a.rank + len(a.lost_twists) == len(a.task.rows)
        assert len(a.free_wrenches) == len(a.lost_twists)
        assert a.is_singular == (a.rank < a.task.rank) == np.isinf(a.condition)


@pytest.mark.parametrize("name", NAMES)
def test_free_wrenches_need_no_torque(name):
    """Every wrench held for free, rebuilt from its axis, point and pitch, gives Jᵀ w = 0 to 1e-12 relative."""
    arm, configurations = postures(name)
    for q in configurations:
        a = ks.analyze(arm, q)
        J = np.asarray(a.jacobian)
        wrenches = [wrench_of(screw) for screw in a.free_wrenches]
        for w in wrenches:
            assert np.abs(J.T @ w).max() <= 1e-12 * np.abs(np.abs(J).T @ np.abs(w)).max(initial=1.0)
            assert not np.delete(w, list(a.task.rows)).any()
        assert np.linalg.matrix_rank(np.array(wrenches).reshape(-1, 6), tol=1e-9) == len(wrenches)


@pytest.mark.parametrize("name", NAMES)
def test_lost_twists_are_at_right_angles_to_all_motion(name):
    """Every lost twist, rebuilt from its words' numbers, is orthogonal to every column in the weighted metric."""
    arm, configurations = postures(name)
    for q in configurations:
        a = ks.analyze(arm, q)
        scale = weights(a)[:, None]
        columns = scale * np.asarray(a.jacobian)
        twists = [scale[:, 0] * twist_of(screw) for screw in a.lost_twists]
        for twist in twists:
            size = np.linalg.norm(twist) * max(1.0, np.abs(columns).max())
            assert np.abs(columns.T @ twist).max() <= 1e-12 * size
            assert not np.delete(twist, list(a.task.rows)).any()
        assert np.linalg.matrix_rank(np.array(twists).reshape(-1, 6), tol=1e-9) == len(twists)


@pytest.mark.parametrize(("name", "q"), [(name, q) for name in SINGULAR for q in SINGULAR[name]])
def test_singular_postures_are_singular_and_their_neighbours_are_not(name, q):
    """The rank drops at the posture geometry names, and is back a hundredth of a radian beside it."""
    arm = ks.load(name)
    assert ks.analyze(arm, q).is_singular
    beside = np.array(q) + 0.01 * np.random.default_rng(5).uniform(0.5, 1.0, arm.n)
    assert not ks.analyze(arm, beside).is_singular


@given(features())
def test_random_mechanisms(drawn):
    """Chains and trees with every kind of joint, mimic joints and another base: the same laws, and strict JSON.

    To 1e-9 here: a singular value just below the rank tolerance of 1e-10 counts as zero and leaves that much.
    """
    arm = drawn.model()
    for q in drawn.configurations(2):
        a = ks.analyze(arm, q)
        J, scale = np.asarray(a.jacobian), weights(a)
        assert a.rank <= a.task.rank
        assert a.rank + len(a.lost_twists) == len(a.task.rows)
        for twist, wrench in zip(map(twist_of, a.lost_twists), map(wrench_of, a.free_wrenches), strict=True):
            sizes = np.abs(J).T @ np.abs(wrench), np.abs(J).T @ np.abs(scale**2 * twist)
            assert np.all(np.abs(J.T @ wrench) <= 1e-9 * np.maximum(sizes[0], 1.0))
            assert np.all(np.abs(J.T @ (scale**2 * twist)) <= 1e-9 * np.maximum(sizes[1], 1.0))
        strict(json.dumps(a.to_dict(), allow_nan=False))
        assert str(a)


NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
TRIPLE = rf"\(({NUMBER}), ({NUMBER}), ({NUMBER})\)"


def screw_again(six, line, moment):
    """Axis, point and pitch of a screw by least squares: moment = point × line + pitch · line, the point of least norm."""
    size = np.linalg.norm(six[line])
    if size == 0:
        return six[moment] / np.linalg.norm(six[moment]), None, np.inf
    d, m = six[line] / size, six[moment] / size
    cross = np.array([[0, d[2], -d[1]], [-d[2], 0, d[0]], [d[1], -d[0], 0]])  # p × d as a matrix on p
    solution = np.linalg.lstsq(np.c_[cross, d], m, rcond=1e-12)[0]
    return d, solution[:3], solution[3]


def assert_words_match(screw, axes, origin):
    """The text of a screw says its direction, point and pitch, to the digits it prints."""
    named = re.search(rf"(?:along|about) ([xyz]) of {axes}", screw.text)
    if named:
        assert np.allclose(np.abs(screw.direction), np.eye(3)["xyz".index(named[1])], atol=1e-6)
    else:
        found = re.search(rf"(?:along|about) {TRIPLE} in axes of {axes}", screw.text)
        np.testing.assert_allclose([float(x) for x in found.groups()], screw.direction, atol=6e-5)
    at = re.search(rf"through the origin of {origin}(?: \+ {TRIPLE} m in axes of {axes})?", screw.text)
    assert (at is None) == (screw.point is None)
    if at is not None:
        np.testing.assert_allclose([float(x or 0) for x in at.groups()], screw.point, atol=6e-5, rtol=1e-2)
    pitch = re.search(rf"pitch ({NUMBER}) m/rad|with ({NUMBER}) N m of moment", screw.text)
    assert (pitch is not None) == (screw.kind in ("screw", "wrench"))
    if pitch is not None:
        np.testing.assert_allclose(float(pitch[1] or pitch[2]), screw.pitch, atol=6e-5)


@pytest.mark.parametrize("name", NAMES)
def test_words_match_numbers(name):
    """Text, axis, point and pitch of a screw agree, and where one direction is lost it is the null space of Jᵀ."""
    arm, configurations = postures(name)
    for q in configurations:
        a = ks.analyze(arm, q)
        frame = a.jacobian.frame
        for screw in a.lost_twists + a.free_wrenches:
            assert_words_match(screw, frame.axes, frame.origin)
        if len(a.free_wrenches) != 1:
            continue
        rows = list(a.task.rows)
        scaled = weights(a)[:, None] * np.asarray(a.jacobian)
        null = np.zeros(6)
        null[rows] = np.linalg.eigh(scaled[rows] @ scaled[rows].T)[1][:, 0]  # another routine than the package's
        null[np.abs(null) < 1e-7] = 0.0
        for screw, six, line, moment in (
            (a.lost_twists[0], null / weights(a), slice(3, 6), slice(0, 3)),
            (a.free_wrenches[0], null * weights(a), slice(0, 3), slice(3, 6)),
        ):
            direction, point, pitch = screw_again(six, line, moment)
            np.testing.assert_allclose(np.abs(direction @ screw.direction), 1.0, atol=1e-6)
            assert (point is None) == (screw.point is None)
            if point is not None:
                np.testing.assert_allclose(screw.point, point, atol=1e-5)
                np.testing.assert_allclose(screw.pitch, pitch, atol=1e-5)


# ---- known cases ---------------------------------------------------------------------------------------------------------


def texts(screws):
    return [screw.text for screw in screws]


def test_stretched_planar_arm():
    """A stretched planar 2R arm loses the velocity along itself, and holds a force along itself for free."""
    a = ks.analyze(ks.load("planar_2r"), [0.0, 0.0])
    assert texts(a.lost_twists) == ["no velocity along x of base"]
    assert texts(a.free_wrenches) == ["force along x of base, through the origin of tip"]
    assert (a.rank, a.task.rank, a.manipulability_unit) == (1, 2, "m^2")
    tilted = ks.analyze(ks.load("planar_2r"), [0.6, 0.0]).lost_twists[0]
    np.testing.assert_allclose(tilted.direction, [np.cos(0.6), np.sin(0.6), 0], atol=1e-12)


def test_stretched_scara():
    """A stretched SCARA loses the velocity along itself; vertical travel and turning stay."""
    a = ks.analyze(ks.load("scara"), [0.0, 0.0, 0.1, 0.3])
    assert (a.rank, a.task.rank) == (3, 4)
    assert texts(a.lost_twists) == ["no velocity along x of base"]


def test_spherical_arm_pointing_up():
    """An RRP arm with its tip on the first axis loses the velocity across itself; drawn in to nothing it loses two."""
    up = ks.analyze(ks.load("rrp_note_000"), [0.0, HALF, 0.8])
    assert (up.rank, texts(up.lost_twists)) == (2, ["no velocity along y of base"])
    drawn_in = ks.analyze(ks.load("rrp_note_000"), [0.0, 0.0, 0.0])
    assert (drawn_in.rank, texts(drawn_in.lost_twists)) == (
        1,
        ["no velocity along y of base", "no velocity along z of base"],
    )


def test_puma_wrist():
    """With axes 4 and 6 in line, the free wrench is a couple across axes 4 and 5, and the force joints 1 to 3 ask for."""
    arm, q = ks.load("puma_560"), [0.1, 0.4, -1.0, 0.3, 0.0, 0.2]
    a = ks.analyze(arm, q)
    assert a.rank == 5
    J = np.asarray(a.jacobian)
    np.testing.assert_allclose(np.abs(J[3:, 3] @ J[3:, 5]), 1.0, atol=1e-12)  # axes 4 and 6 line up
    couple = np.cross(J[3:, 3], J[3:, 4])
    centre = np.asarray(ks.jacobian(arm, q, at="link4"))[:, :3]  # the wrist centre and joints 1 to 3
    force = np.linalg.solve(centre[:3].T, -centre[3:].T @ couple)
    lever = ks.pose(arm, q, at="link4").translation - ks.pose(arm, q).translation
    expected = np.r_[force, couple + np.cross(lever, force)]
    found = wrench_of(a.free_wrenches[0])
    np.testing.assert_allclose(found, expected * (found @ expected) / (expected @ expected), atol=1e-10)


def ur_shoulder(arm, q):
    """q with joint 2 moved until the crossing of axes 5 and 6 lies on the plane through axis 1 that holds axis 2."""

    def off(q2):
        turned = np.array([q[0], q2, *q[2:]])
        J = np.asarray(ks.jacobian(arm, turned, at="wrist_3_link", frame=ks.Frame("base", "wrist_3_link")))
        axis2, centre = J[3:, 1], ks.pose(arm, turned, at="wrist_2_link").translation
        return float(np.cross(axis2, [0, 0, 1]) @ centre)

    low, high = -3.0, 0.0
    assert off(low) * off(high) < 0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if off(low) * off(middle) > 0 else (low, middle)
    return np.array([q[0], 0.5 * (low + high), *q[2:]])


@pytest.mark.parametrize("name", ["ur3e", "ur5e", "ur10e"])
def test_universal_robots_elbow_wrist_and_shoulder(name):
    """The three singularities of a UR arm have rank 5 each; so have elbow and wrist together.

    There axes 2, 3, 4 and 6 are parallel, and parallel axes that are not coplanar have three freedoms.
    """
    arm, q = ks.load(name), np.array([0.3, -0.8, 1.1, -0.9, 0.7, 0.4])
    assert ks.analyze(arm, q).rank == 6
    elbow, wrist, both = q.copy(), q.copy(), q.copy()
    elbow[2] = wrist[4] = both[2] = both[4] = 0.0
    assert [ks.analyze(arm, x).rank for x in (elbow, wrist, ur_shoulder(arm, q), both)] == [5, 5, 5, 5]


def test_redundant_arm():
    """Seven joints: rank 6 in general; the upright Panda loses one direction, the upright iiwa three."""
    panda, iiwa = ks.load("panda"), ks.load("iiwa_14")
    assert ks.analyze(panda).rank == ks.analyze(iiwa).rank == 6
    assert ks.analyze(panda, np.zeros(7)).rank == 5
    upright = ks.analyze(iiwa, np.zeros(7))
    assert (upright.rank, upright.task.rank, len(upright.lost_twists)) == (3, 6, 3)


@pytest.mark.parametrize("name", [name for name in NAMES if ks.load(name).n < 6])
def test_arms_with_few_joints_are_not_always_singular(name):
    """Fewer than six joints is no singularity: at general postures the rank is all the arm can have."""
    arm = ks.load(name)
    for q in arm.random_configurations(20, seed=2):
        a = ks.analyze(arm, q)
        assert not a.is_singular
        assert np.isfinite(a.condition)
        assert a.manipulability > 0
        assert "not singular" in str(a)


# ---- tasks ---------------------------------------------------------------------------------------------------------------

ALL, POSITION = ("vx", "vy", "vz", "wx", "wy", "wz"), ("vx", "vy", "vz")
TASKS = {
    "planar_2r": (("vx", "vy"), 2),
    "planar_3r": (("vx", "vy", "wz"), 3),
    "scara": (("vx", "vy", "vz", "wz"), 4),
    "rrp_note_000": (POSITION, 3),
    "rrp_note_001": (POSITION, 3),
    "elbow_rrr": (POSITION, 3),
    "al5d": (ALL, 4),
    "three_joint_note_003": (ALL, 3),  # its position alone has rank 2
}


@pytest.mark.parametrize("name", NAMES)
def test_rows_of_every_arm(name):
    """The rows that "auto" finds, and the rank the arm can have in them."""
    rows, rank = TASKS.get(name, (ALL, 6))
    task = ks.find_task(ks.load(name))
    assert (task.row_names, task.rank) == (rows, rank)


def test_rows_of_a_five_joint_arm_and_of_a_wrist():
    """Five joints in space keep all six rows with rank 5; a wrist whose tip is its centre has the rows of orientation."""
    five = ks.from_dh(
        [(0, HALF, 0.1, 0), (0.3, 0, 0, 0), (0.2, 0, 0, 0), (0, HALF, 0, 0), (0, 0, 0.1, 0)], convention="standard"
    )
    assert (ks.find_task(five).row_names, ks.find_task(five).rank) == (ALL, 5)
    wrist = ks.from_dh([(0, -HALF, 0, 0), (0, HALF, 0, 0), (0, 0, 0, 0)], convention="standard")
    assert ks.find_task(wrist).row_names == ("wx", "wy", "wz")


def test_a_wrist_far_from_its_base_moves_no_point():
    """Rounding of positions is not motion: a wrist on a turned base metres away has the rows of orientation."""
    far = np.eye(4)
    far[:3, :3] = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]
    far[:3, 3] = 7.3, -11.1, 13.7
    back = np.eye(4)
    back[2, 3] = -0.1  # from the flange back to the centre, which rounding misses by 1e-17
    rows = [(0, -HALF, 0, 0), (0, HALF, 0, 0), (0, 0, 0.1, 0)]
    wrist = ks.from_dh(rows, convention="standard", base=far, tool=back)
    assert 0 < np.abs(ks.jacobian(wrist, [0.3, 0.7, -0.4]).linear).max() < 1e-14
    a = ks.analyze(wrist, [0.3, 0.7, -0.4])
    assert a.task.row_names == ("wx", "wy", "wz")
    assert (a.rank, a.manipulability_unit) == (3, "1")
    np.testing.assert_allclose(a.manipulability, np.sin(0.7), atol=1e-12)
    assert ks.analyze(wrist, [0.3, 0.7, -0.4], task="position").rank == 0


def test_orientation_rows_are_not_scaled():
    """A task without metres has bare singular values, and says nothing of a characteristic length."""
    a = ks.analyze(ks.load("ur5e"), task="orientation")
    expected = np.linalg.svd(np.asarray(a.jacobian)[3:], compute_uv=False)
    np.testing.assert_allclose(a.singular_values, expected, atol=1e-14)
    assert a.scaled == ()
    assert "characteristic" not in str(a)


def test_rows_can_be_given_in_any_usual_way():
    """Names, numbers, NumPy numbers, one text with commas, in any order and more than once: the same rows."""
    arm = ks.load("ur5e")
    for rows in (["vx", "wz"], ("wz", "vx", "vx"), [0, 5], np.array([5, 0]), "vx,wz", " wz , vx", iter(["vx", "wz"])):
        assert ks.find_task(arm, rows).row_names == ("vx", "wz")
    assert ks.find_task(arm, "vz").row_names == ("vz",)


@pytest.mark.parametrize(
    "task", ["bogus", "vx,bogus", ["vx", "bogus"], [6], [-1], [True], [0.0], 3, None, "", [None], [["vx"]]]
)
def test_unknown_rows_are_refused(task):
    """Anything else is KS318 with the rows there are."""
    with pytest.raises(ks.UnknownNameError, match="KS318"):
        ks.analyze(ks.load("ur5e"), task=task)


def test_no_rows_at_all():
    """An empty task is refused; an arm without joints has rank 0, nothing lost, and prints."""
    with pytest.raises(ks.UnknownNameError, match="KS318"):
        ks.analyze(ks.load("ur5e"), task=[])
    still = ks.analyze(ks.load("ur5e", base="base", tip="base"))
    assert (still.rank, still.joints, still.manipulability) == (0, (), 0.0)
    assert str(still)
    json.dumps(still.to_dict(), allow_nan=False)


# ---- units ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [1000.0, 1e-3, 39.37])
@pytest.mark.parametrize("name", NAMES)
def test_another_unit_of_length_changes_no_finding(name, factor):
    """Millimetres for metres: same rows, rank and condition; lost twists, point and pitch in the new unit."""
    arm, configurations = postures(name)
    other, lengths = scaled_model(arm, factor)
    resize = np.r_[factor, factor, factor, 1, 1, 1]
    for q in configurations:
        a, b = ks.analyze(arm, q), ks.analyze(other, q * lengths)
        assert (a.task.row_names, a.task.rank, a.rank) == (b.task.row_names, b.task.rank, b.rank)
        np.testing.assert_allclose(b.condition, a.condition, rtol=1e-9)
        np.testing.assert_allclose(b.characteristic_length, factor * a.characteristic_length, rtol=1e-12)
        lost = [np.array([twist_of(s) for s in x.lost_twists]).reshape(-1, 6) for x in (a, b)]
        together = np.r_[lost[0] * resize, lost[1]] * weights(b) / np.linalg.norm(weights(b))
        if len(together):
            together /= np.linalg.norm(together, axis=1, keepdims=True)
        assert np.linalg.matrix_rank(together, tol=1e-7) == len(a.lost_twists)
        for mine, theirs in zip(a.lost_twists, b.lost_twists, strict=True):
            assert len(a.lost_twists) > 1 or mine.kind == theirs.kind


@pytest.mark.parametrize("name", NAMES)
def test_unit_of_the_manipulability(name):
    """It grows with the power of length that is printed behind it; where it has no such power, "mixed units" is printed."""
    arm = ks.load(name)
    other, lengths = scaled_model(arm, 1000.0)
    for q in arm.random_configurations(3, seed=4):
        a, b = ks.analyze(arm, q), ks.analyze(other, q * lengths)
        power = np.log(b.manipulability / a.manipulability) / np.log(1000.0)
        if a.manipulability_unit == "mixed units":
            assert abs(power - round(power)) > 1e-6
        else:
            assert a.manipulability_unit == {0: "1", 1: "m"}.get(round(power), f"m^{round(power)}")
            np.testing.assert_allclose(power, round(power), atol=1e-9)


def test_where_the_characteristic_length_comes_in():
    """It multiplies angular rows where the task has both kinds, prismatic columns where the arm has both, and is said to."""
    expected = {
        "ur5e": ("angular rows",),
        "planar_2r": (),
        "scara": ("angular rows", "prismatic columns"),
        "rrp_note_000": ("prismatic columns",),
    }
    for name, scaled in expected.items():
        a = ks.analyze(ks.load(name))
        assert a.scaled == scaled
        length = a.characteristic_length
        J = np.array(a.jacobian)
        J[3:] *= length if "angular rows" in scaled else 1.0
        if "prismatic columns" in scaled:
            J[:, 2] *= length
        np.testing.assert_allclose(a.singular_values, np.linalg.svd(J[list(a.task.rows)], compute_uv=False), atol=1e-14)
        said = " ".join(str(a).split())
        assert f"({' and '.join(scaled)} times the characteristic length" in said or not scaled


def test_characteristic_length():
    """The reach of the chain: links, a pitch, travel at home; without reach the largest length there is, or 1 m."""
    assert ks.characteristic_length(ks.from_dh([(0.3, 0, 0, 0), (0.4, 0, 0, 0)], convention="standard")) == pytest.approx(
        0.7
    )
    helical = ks.from_screws([ks.screw_axis((0, 0, 1), pitch=0.02)])
    assert ks.characteristic_length(helical) == pytest.approx(0.02)
    wrist = ks.from_dh([(0, -HALF, 0, 0), (0, HALF, 0, 0), (0, 0, 0, 0)], convention="standard")
    assert ks.characteristic_length(wrist) == 1.0
    raised = ks.from_dh([(0, -HALF, 3.0, 0), (0, -HALF, 0, 0), (0, 0, 0, 0)], convention="standard", types="RRP")
    assert ks.characteristic_length(raised.with_home([0.0, 0.0, 2.0])) == pytest.approx(2.0)
    assert ks.characteristic_length(raised) == pytest.approx(3.0)
    tiny = ks.from_dh([(1e-30, 0, 0, 0), (1e-30, 0, 0, 0)], convention="standard")
    assert ks.characteristic_length(tiny) == pytest.approx(2e-30)


# ---- another base, another tip -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["ur5e", "panda", "scara", "stanford_arm", "planar_3r"])
def test_turned_round(name):
    """Base and tip exchanged: the same rank, and the same wrenches held for free, written at the other end."""
    arm, configurations = postures(name)
    back = ks.load(name, base=arm.tip, tip=arm.base)
    assert back.joint_names == arm.joint_names[::-1] or set(back.joint_names) == set(arm.joint_names)
    order = [arm.joint_names.index(joint) for joint in back.joint_names]
    for q in configurations:
        a, b = ks.analyze(arm, q, task="full"), ks.analyze(back, q[order], task="full")
        assert (a.rank, a.task.rank) == (b.rank, b.task.rank)
        T = np.asarray(a.pose)
        np.testing.assert_allclose(np.asarray(b.pose), np.linalg.inv(T), atol=1e-12)
        J = np.asarray(a.jacobian)
        for screw in b.free_wrenches:  # axes of the tip, at the origin of the base
            six = wrench_of(screw)
            force, moment = T[:3, :3] @ six[:3], T[:3, :3] @ six[3:]
            moved = np.r_[force, moment + np.cross(-T[:3, 3], force)]
            assert np.abs(J.T @ moved).max() <= 1e-12 * max(1.0, np.abs(moved).max())


def test_a_link_in_between():
    """`at` asks about that link: its pose, its Jacobian, zeros for the joints behind it."""
    arm = ks.load("ur5e")
    a = ks.analyze(arm, at="forearm_link")
    assert a.tip == "forearm_link"
    assert not np.asarray(a.jacobian)[:, 3:].any()
    assert a.task.rank == 3


# ---- torques -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_a_push_needs_the_torques_of_virtual_work(name):
    """τ · δq = f · δp + m · δφ for a push, by differences of poses; a load needs the opposite torques."""
    arm = ks.load(name)
    q, step = arm.home, 1e-6
    force, torque = np.array([3.0, -5.0, 7.0]), np.array([0.4, 0.2, -0.6])
    expected = []
    for k in range(arm.n):
        ahead, behind = (np.asarray(ks.pose(arm, q + s * step * np.eye(arm.n)[k])) for s in (1, -1))
        turn = (ahead[:3, :3] - behind[:3, :3]) @ np.asarray(ks.pose(arm, q))[:3, :3].T / (2 * step)
        moved = (ahead[:3, 3] - behind[:3, 3]) / (2 * step)
        expected.append(force @ moved + torque @ [turn[2, 1], turn[0, 2], turn[1, 0]])
    push = ks.analyze(arm, q, ks.Wrench.on_environment(force, torque))
    load = ks.analyze(arm, q, ks.Wrench.on_robot(force, torque))
    np.testing.assert_allclose(push.joint_torques, expected, atol=1e-7)
    np.testing.assert_array_equal(load.joint_torques, -push.joint_torques)


def test_a_wrench_in_any_frame():
    """The same force written in base axes at the tip, in tool axes, at the base and at an offset: the same torques."""
    arm, q = ks.load("ur5e"), np.array([0.3, -0.8, 1.1, -0.9, 0.7, 0.4])
    force, torque = np.array([10.0, -4.0, 6.0]), np.array([1.0, 2.0, -0.5])
    T = np.asarray(ks.pose(arm, q))
    R, p = T[:3, :3], T[:3, 3]
    lever = R @ [0, 0, 0.1]
    given = {
        ks.Frame(): (force, torque),
        ks.Frame.body(): (R.T @ force, R.T @ torque),
        ks.Frame.spatial(): (force, torque + np.cross(p, force)),
        ks.Frame("base", "tip", (0, 0, 0.1)): (force, torque - np.cross(lever, force)),
    }
    results = [ks.analyze(arm, q, ks.Wrench.on_robot(*parts, frame=frame)) for frame, parts in given.items()]
    for a in results:
        np.testing.assert_allclose(a.joint_torques, results[0].joint_torques, atol=1e-12)
    assert results[3].to_dict()["wrench"]["offset"] == [0.0, 0.0, 0.1]
    assert str(results[1].wrench.frame) == "axes of tool0, at the origin of tool0"


def table_of(text):
    """The torque table of a printed analysis: {joint: numbers}."""
    lines = text.split("torques that hold the arm still")[1].splitlines()[2:]
    rows = (line.split() for line in lines[: lines.index("")] if not line.startswith("potential"))
    return {row[0]: [float(x) for x in row[1:] if re.fullmatch(NUMBER, x)] for row in rows}


def test_gravity_turns_with_the_base():
    """Another direction of gravity is passed on: an arm on a wall."""
    arm = ks.load("ur5e")
    a = ks.analyze(arm, gravity=[9.81, 0, 0])
    np.testing.assert_array_equal(a.gravity_torques, ks.gravity_torques(arm, arm.home, gravity=(9.81, 0, 0)))
    assert np.abs(a.gravity_torques - ks.analyze(arm).gravity_torques).max() > 1.0


def test_gravity_and_load_and_both():
    """Printed gravity plus printed load is printed both, and the column's numbers are those of the result."""
    a = ks.analyze(ks.load("ur5e"), wrench=ks.Wrench.on_robot(force=(0, 0, -30)))
    for k, (joint, numbers) in enumerate(table_of(str(a)).items()):
        assert joint == a.joints[k]
        expected = [a.gravity_torques[k], a.joint_torques[k], a.gravity_torques[k] + a.joint_torques[k], a.effort_limits[k]]
        np.testing.assert_allclose(numbers, expected, atol=6e-5)
    np.testing.assert_allclose(a.gravity_torques, ks.gravity_torques(ks.load("ur5e"), a.configuration), atol=0)


def test_a_torque_over_its_limit_is_said():
    """A load that the motors cannot hold is marked at the joint, by the sum with gravity; a bearable one is not."""
    arm = ks.load("ur5e")
    assert "over the limit" not in str(ks.analyze(arm))
    text = str(ks.analyze(arm, wrench=ks.Wrench.on_robot(force=(0, 0, -500))))
    marked = [line.split()[0] for line in text.splitlines() if "over the limit" in line]
    a = ks.analyze(arm, wrench=ks.Wrench.on_robot(force=(0, 0, -500)))
    total = np.abs(a.gravity_torques + a.joint_torques)
    assert marked == [name for name, x, most in zip(a.joints, total, a.effort_limits, strict=True) if x > most] != []


def test_prismatic_joints_have_newtons_and_metres():
    """A sliding joint's value is in m and its force in N, beside rad and N m for the others."""
    a = ks.analyze(ks.load("rrp_note_000"), wrench=ks.Wrench.on_robot(force=(1, 2, 3)))
    text = str(a)
    assert "q = (0.4 rad, 0.3 rad, 0.8 m)" in text
    table = text.split("torques that hold the arm still")[1]
    units = [re.search(r"  (N(?: m)?)$", line)[1] for line in table.splitlines() if re.match(r"  joint\d .*N", line)]
    assert units == ["N m", "N m", "N"]
    assert "[N m]" in str(ks.analyze(ks.load("ur5e")))


def test_missing_data_is_said():
    """No masses: gravity is None and a note says so; unknown torque limits are noted where torques are asked for."""
    a = ks.analyze(ks.load("scara"), wrench=ks.Wrench.on_robot(force=(1, 0, 0)))
    assert a.gravity_torques is None
    assert any("no masses" in note for note in a.notes)
    assert any("effort limits are unknown" in note for note in a.notes)
    assert ks.analyze(ks.load("ur5e")).notes == ()


# ---- limits --------------------------------------------------------------------------------------------------------------


def margin(lower, upper, q):
    arm = ks.from_dh([(0.5, 0, 0, 0)], convention="standard", limits=[(lower, upper)])
    a = ks.analyze(arm, [q])
    return (a.margins[0] if a.margins else None), str(a)


@pytest.mark.parametrize(
    ("lower", "upper", "q", "limit", "distance", "near", "words"),
    [
        (-1.0, 1.0, 0.0, "upper", 1.0, False, "no joint is near a position limit"),
        (-1.0, 1.0, 0.91, "upper", 0.09, True, "0.09 rad (5.1566 deg) from its upper limit"),
        (-1.0, 1.0, -0.89, "lower", 0.11, False, "no joint is near a position limit"),
        (-1.0, 1.0, -1.0, "lower", 0.0, True, "at its lower limit"),
        (-1.0, 1.0, 1.2, "upper", -0.2, True, "outside its upper limit by 0.2 rad"),
        (-1.0, 1.0, -1.5, "lower", -0.5, True, "outside its lower limit by 0.5 rad"),
        (-np.inf, 1.0, 0.96, "upper", 0.04, True, "0.04 rad (2.2918 deg) from its upper limit"),
        (-np.inf, 1.0, -9.0, "upper", 10.0, False, "no joint is near a position limit"),
        (-1.0, np.inf, -1.1, "lower", -0.1, True, "outside its lower limit by 0.1 rad"),
        (0.3, 0.3, 0.3, "upper", 0.0, True, "locked: its limits leave it one position"),
        (0.3, 0.3, 0.5, "upper", -0.2, True, "outside its upper limit by 0.2 rad"),
    ],
)
def test_joints_near_their_limits(lower, upper, q, limit, distance, near, words):
    """Distance to the nearest limit, negative outside; one-sided limits, a locked joint and both sides included."""
    found, text = margin(lower, upper, q)
    assert (found.limit, found.near, found.locked) == (limit, near, lower == upper)
    assert found.distance == pytest.approx(distance)
    assert words in text


def test_a_joint_without_limits_has_no_margin():
    """Nothing is said of a limit that is not there."""
    found, text = margin(-np.inf, np.inf, 2.0)
    assert found is None
    assert "no position limits are known" in text


def test_a_sliding_joint_near_its_limit_is_measured_in_metres():
    """The SCARA's quill at its upper stop: metres, no degrees."""
    arm = ks.load("scara")
    q = arm.home.copy()
    q[2] = arm.upper[2] - 0.001
    assert "joint3: 0.001 m from its upper limit" in str(ks.analyze(arm, q))


# ---- bad input -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"q": np.zeros((2, 6))}, "KS303"),
        ({"q": np.zeros(5)}, "KS303"),
        ({"q": 0.0}, "KS303"),
        ({"q": [0, 0, 0, 0, 0, np.nan]}, "KS301"),
        ({"q": ["a"] * 6}, "KS302"),
        ({"wrench": ks.Wrench.on_robot(force=np.ones((4, 3)))}, "KS303"),
        ({"wrench": ks.Wrench.on_robot(force=(np.nan, 0, 0))}, "KS301"),
        ({"wrench": ks.Wrench.on_robot(force=(0, 0, 1e200))}, "KS301"),
        ({"wrench": ks.Wrench.on_robot(force=(0, 0, 1), frame=ks.Frame("nowhere", "tip"))}, "KS310"),
        ({"at": "nowhere"}, "KS310"),
        ({"gravity": (0, -9.81)}, "KS303"),
        ({"gravity": (0, 0, -9.81, 0)}, "KS303"),
        ({"gravity": (0, 0, np.nan)}, "KS303"),
        ({"gravity": "down"}, "KS303"),
        ({"gravity": 9.81}, "KS303"),
    ],
)
def test_bad_input_is_refused_with_a_code(arguments, code):
    """Batches, wrong lengths, NaN, text, unknown links: an error with its code, and no number."""
    with pytest.raises(ks.KinestaticsError, match=code):
        ks.analyze(ks.load("ur5e"), **arguments)


def test_numbers_too_large_to_square_are_refused():
    """A prismatic joint at 1e300 m is an error, not an infinite manipulability."""
    with pytest.warns(ks.KinestaticsWarning, match="KS308"), pytest.raises(ks.ConfigurationError, match="KS301"):
        ks.analyze(ks.load("rrp_note_000"), [0.0, 0.0, 1e300])


def test_inputs_are_left_alone():
    """q is not changed and not kept."""
    arm, q = ks.load("ur5e"), np.full(6, 0.3)
    before = q.copy()
    a = ks.analyze(arm, q)
    assert np.array_equal(q, before)
    q[:] = 9.0
    assert np.array_equal(a.configuration, before)


# ---- JSON and print ------------------------------------------------------------------------------------------------------

KEYS = {
    "near_singularities",
    "robot", "base", "tip", "joints", "configuration", "pose", "jacobian", "task", "rank", "singular", "singular_values",
    "condition", "characteristic_length", "scaled", "tolerance", "manipulability", "manipulability_unit", "lost_twists",
    "free_wrenches", "gravity_torques", "wrench", "joint_torques", "effort_limits", "limits", "notes", "isotropy",
    "velocity_ellipsoid", "force_ellipsoid", "abilities", "speed_rows", "payload_capacity", "gravity", "gravity_by_link",
    "potential_energy", "payloads", "loads", "holding_torques", "reactions",
}  # fmt: skip


def strict(text):
    """JSON without NaN and Infinity."""

    def refuse(token):
        raise AssertionError(f"{token} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("name", NAMES)
def test_json_is_strict_and_holds_the_numbers(name):
    """Every posture's dictionary is strict JSON with the pinned keys, and reads back to the numbers of the result."""
    arm, configurations = postures(name)
    for q in configurations:
        a = ks.analyze(arm, q, ks.Wrench.on_environment(force=(1, 2, 3)))
        d = strict(json.dumps(a.to_dict(), allow_nan=False))
        assert set(d) == KEYS
        assert set(d["jacobian"]) == {"array", "axes", "origin", "rows"}
        assert set(d["task"]) == {"name", "rows", "rank", "reason"}
        np.testing.assert_array_equal(d["configuration"], q)
        np.testing.assert_array_equal(d["pose"], a.pose)
        np.testing.assert_array_equal(d["jacobian"]["array"], a.jacobian)
        np.testing.assert_array_equal(d["singular_values"], a.singular_values)
        np.testing.assert_array_equal(d["joint_torques"], a.joint_torques)
        np.testing.assert_array_equal(a.gravity_torques, d["gravity_torques"])
        assert (d["rank"], d["singular"], d["manipulability"]) == (a.rank, a.is_singular, a.manipulability)
        assert d["condition"] == (None if a.is_singular else a.condition)
        for stored, screw in zip(d["lost_twists"] + d["free_wrenches"], a.lost_twists + a.free_wrenches, strict=True):
            assert set(stored) == {"kind", "direction", "point", "pitch", "text"}
            np.testing.assert_array_equal(stored["direction"], screw.direction)
            assert (stored["point"] is None) == (stored["pitch"] is None) == (screw.point is None)


@pytest.mark.parametrize("name", NAMES)
def test_it_prints_in_80_columns(name):
    """No line is wider than 80 columns, at any posture and with a wrench; the rank and the task are always shown."""
    arm, configurations = postures(name)
    for q in configurations:
        text = str(ks.analyze(arm, q, ks.Wrench.on_robot(force=(100.5, -200.25, 300.125))))
        assert max(len(line) for line in text.splitlines()) <= 80
        assert "task rows " in text
        assert re.search(r"rank +\d of \d: (not )?singular", text)
        assert "nan" not in text.lower().split()


def test_directions_that_no_posture_has_are_not_called_lost_here():
    """A 4-joint arm in space: at a regular posture its two missing directions are those of every posture."""
    arm = ks.load("al5d")
    regular, singular = ks.analyze(arm), ks.analyze(arm, np.zeros(4))
    assert "as in every posture (6 rows, 4 freedoms)" in str(regular)
    assert "lost here (of them 2 in every posture: 6 rows, 4 freedoms)" in str(singular)


def test_position_rows_are_the_linear_ones():
    """The rows of "position" are those the Jacobian calls linear."""
    assert ks.find_task(ks.load("ur5e"), "position").rows == LINEAR_ROWS
