"""docs/conventions.md, executed: its table of Jacobians number by number, its rows by name, and what no other file holds."""

import re
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
ARM, Q = ks.load("planar_2r"), [0.3, 0.5]


def rows_of(heading):
    """The cells of the table under a heading, header and rule left out."""
    section = TEXT.split(heading)[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


JACOBIANS = rows_of("## What other libraries call the Jacobian")
CONVENTIONS = rows_of("# Conventions")


def names_in(cell):
    return re.findall(r"`([^`]+)`", cell)


def numbers_in(cell):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", cell)]


# ---- the table of Jacobians ----------------------------------------------------------------------------------------------


def test_the_table_names_every_convention_once():
    """The names of the table are those of CONVENTIONS, each in one row."""
    assert sorted(name for row in JACOBIANS for name in names_in(row[0])) == sorted(ks.CONVENTIONS)


@pytest.mark.parametrize("row", JACOBIANS, ids=lambda row: names_in(row[0])[0])
def test_the_table_says_what_the_package_does(row):
    """Rows, axes, point and the first column of each row are those of to_array(convention=...)."""
    names, order, axes, point, column = row
    for name in names_in(names):
        convention = ks.CONVENTIONS[name]
        array = ks.jacobian(ARM, Q).to_array(convention=name)
        if "jacp and jacr" in order:
            assert array.shape == (2, 3, 2)
            first = array[:, :, 0].ravel()
        else:
            assert order.startswith("v, ω" if convention.order == "linear-angular" else "ω, v")
            first = array[:6] if "flat" in order else array[:, 0]
        assert (axes, point) == (convention.axes, "base origin" if convention.origin == "base" else "tip")
        expected = numbers_in(column) if column != "as Drake" else numbers_in(JACOBIANS[row_of("drake")][4])
        assert len(expected) == 6
        np.testing.assert_allclose(first, expected, atol=5.01e-4)


def row_of(name):
    return next(i for i, row in enumerate(JACOBIANS) if name in names_in(row[0]))


def test_the_example_of_the_table_is_the_arm():
    """The arm and the posture above the table are those used here: links of 1 m, q = (0.3, 0.5)."""
    assert "links of 1 m, q = (0.3, 0.5)" in TEXT
    lengths = ks.pose(ARM, [0, 0], at="link1").translation, ks.pose(ARM, [0, 0]).translation
    np.testing.assert_allclose(lengths, [(1, 0, 0), (2, 0, 0)])


def test_world_is_the_body_point_at_the_base_origin():
    """The last paragraph: the linear part of "WORLD" is the velocity of the tool's point now at the base origin."""
    arm, q, qd = ks.load("ur5e"), np.linspace(0.3, 0.9, 6), np.linspace(-1, 1, 6)
    twist = ks.jacobian(arm, q).to_array(convention="pinocchio.WORLD") @ qd
    step = 1e-6
    inside = np.linalg.inv(np.asarray(ks.pose(arm, q))) @ [0, 0, 0, 1]  # the base origin as a point of the tool
    moved = [np.asarray(ks.pose(arm, q + s * step * qd)) @ inside for s in (1, -1)]
    np.testing.assert_allclose(twist[:3], ((moved[0] - moved[1]) / (2 * step))[:3], atol=1e-9)


# ---- the table of conventions --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", CONVENTIONS, ids=lambda row: row[0])
def test_every_line_names_tests_that_are_there(row):
    """The last cell of each line names files that exist and hold tests."""
    files = names_in(row[2])
    assert files
    for name in files:
        assert re.search(r"^def test_", (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE), name


def test_six_vectors_are_linear_first():
    """(v, ω) and (f, τ); the other order comes in and goes out by its name alone."""
    six = np.arange(6.0)
    twist = ks.Twist.from_array(six, order="angular-linear")
    assert twist.linear.tolist() == [3, 4, 5]
    assert twist.angular.tolist() == [0, 1, 2]
    assert twist.to_array().tolist() == [3, 4, 5, 0, 1, 2]
    assert twist.to_array(order="angular-linear").tolist() == six.tolist()
    wrench = ks.Wrench.on_robot(force=(1, 2, 3), torque=(4, 5, 6))
    assert wrench.to_array().tolist() == [1, 2, 3, 4, 5, 6]
    J = ks.jacobian(ARM, Q)
    assert np.array_equal(J.to_array(order="angular-linear"), np.r_[J.angular, J.linear])
    assert np.array_equal(ks.hessian(ARM, Q).to_array(order="angular-linear")[:3], ks.hessian(ARM, Q).array[3:])
    for act in (lambda: ks.Twist.from_array(six, order="v,w"), lambda: J.to_array(order="wv")):
        with pytest.raises(ks.UnknownNameError, match="KS316"):
            act()
    with pytest.raises(TypeError, match="order"):
        ks.Twist.from_array(six)


def test_the_default_frame_is_base_axes_at_the_tip():
    """The Jacobian without a frame is that of Frame("base", "tip"), and so are twist and wrench."""
    J = ks.jacobian(ARM, Q)
    assert J.frame == ks.Frame("base", "tip") == ks.Frame()
    assert np.array_equal(J.array, ks.jacobian(ARM, Q, frame=ks.Frame("base", "tip")).array)
    assert ks.Twist.of().frame == ks.Wrench.on_robot().frame == ks.Frame()
    assert ks.Frame.body("tip") == ks.Frame("tip", "tip")
    assert ks.Frame.spatial() == ks.Frame("base", "base")


def test_batch_axes_come_first():
    """q (..., n) gives poses (..., 4, 4), Jacobians (..., 6, n) and Hessians (..., 6, n, n)."""
    q = np.zeros((3, 5, 2))
    assert ks.pose(ARM, q).array.shape == (3, 5, 4, 4)
    assert ks.jacobian(ARM, q).shape == (3, 5, 6, 2)
    assert ks.hessian(ARM, q).shape == (3, 5, 6, 2, 2)
    assert ks.gravity_torques(ARM, q).shape == (3, 5, 2)


def test_joint_torques_hold_still():
    """A level arm: the motors lift a load that pulls down, and turn the other way for a push downwards by the robot."""
    arm = ks.from_dh([(1.0, np.pi / 2, 0, 0)], convention="standard", base=upright())
    J = ks.jacobian(arm, [0.0])
    assert J.linear[2, 0] == pytest.approx(1.0)  # positive turning lifts
    assert ks.joint_torques(J, ks.Wrench.on_robot(force=(0, 0, -10)))[0] == pytest.approx(10.0)
    assert ks.joint_torques(J, ks.Wrench.on_environment(force=(0, 0, -10)))[0] == pytest.approx(-10.0)


def upright():
    """The first axis along -y of the base: turning lifts what points along x."""
    T = np.eye(4)
    T[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    return T


def test_gravity_torques_hold_the_arm():
    """Default gravity is 9.81 m/s² along -z of the base; the torque is what lifts, the gradient of potential energy."""
    arm = ks.from_dh([(1.0, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(-0.5, 0, 0)], base=upright())
    assert ks.gravity_torques(arm, [0.0])[0] == pytest.approx(2.0 * 9.81 * 0.5)
    assert ks.gravity_torques(arm, [0.0], gravity=(0, 0, 9.81))[0] == pytest.approx(-2.0 * 9.81 * 0.5)


def test_continuous_joints_do_not_wrap():
    """A continuous joint has one column; three turns more are the same pose, and the configuration stays as given."""
    arm = ks.from_dh([(1.0, 0, 0, 0)], convention="standard")
    assert arm.kinds == ("continuous",)
    assert ks.jacobian(arm, [0.2]).shape == (6, 1)
    turned = 0.2 + 6 * np.pi
    np.testing.assert_allclose(ks.pose(arm, [turned]).array, ks.pose(arm, [0.2]).array, atol=1e-14)
    assert ks.analyze(arm, [turned]).configuration[0] == turned


def test_roll_pitch_yaw_is_that_of_urdf():
    """R = Rz(yaw) Ry(pitch) Rx(roll): a pose built so gives its angles back."""
    roll, pitch, yaw = 0.3, -0.4, 1.2

    def about(axis, angle):
        w = np.zeros((3, 3))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        w[axis, axis] = 1.0
        w[i, i] = w[j, j] = np.cos(angle)
        w[j, i], w[i, j] = np.sin(angle), -np.sin(angle)
        return w

    T = np.eye(4)
    T[:3, :3] = about(2, yaw) @ about(1, pitch) @ about(0, roll)
    np.testing.assert_allclose(ks.Pose(T, "tip", "base").rpy, (roll, pitch, yaw), atol=1e-15)


def test_dh_rows_and_screws_ask_for_what_is_not_plain():
    """The DH convention has no default; the order of screws must be said where either fits."""
    with pytest.raises(TypeError, match="convention"):
        ks.from_dh([(1, 0, 0, 0)])
    with pytest.raises(ks.RobotDefinitionError, match="KS201"):
        ks.from_dh([(1, 0, 0, 0)], convention="DH")
    either = [[1.0, 0, 0, 0, 1.0, 0]]  # a unit vector in both halves
    with pytest.raises(ks.RobotDefinitionError):
        ks.from_screws(either)
    linear, angular = (ks.from_screws(either, order=order) for order in ("linear-angular", "angular-linear"))
    assert ks.jacobian(linear, [0.0], frame=ks.Frame.spatial()).linear[0, 0] == 1.0
    assert ks.jacobian(angular, [0.0], frame=ks.Frame.spatial()).angular[0, 0] == 1.0


def test_dh_rows_are_a_alpha_d_theta():
    """Standard: Rz(θ) Tz(d) Tx(a) Rx(α); modified: Rx(α) Tx(a) Rz(θ) Tz(d)."""
    a, alpha, d, theta = 0.3, 0.5, 0.2, 0.7

    def turn(axis, angle):
        T = np.eye(4)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        T[i, i] = T[j, j] = np.cos(angle)
        T[j, i], T[i, j] = np.sin(angle), -np.sin(angle)
        return T

    def shift(x, z):
        T = np.eye(4)
        T[0, 3], T[2, 3] = x, z
        return T

    standard = turn(2, theta) @ shift(a, d) @ turn(0, alpha)
    modified = turn(0, alpha) @ shift(a, 0) @ turn(2, theta) @ shift(0, d)
    for convention, expected in (("standard", standard), ("modified", modified)):
        arm = ks.from_dh([(a, alpha, d, 0.0)], convention=convention)
        np.testing.assert_allclose(ks.pose(arm, [theta]).array, expected, atol=1e-15)


def test_the_rank_tolerance_is_in_the_result():
    """Singular values below 1e-10 of the largest count as zero, on either side of the line, and the result says so."""
    arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard")
    assert ks.analyze(arm, [0.0, 0.0]).tolerance == 1e-10
    sigma = ks.analyze(arm, [0.0, 1e-9]).singular_values
    assert 1e-10 < sigma[1] / sigma[0] < 1e-9
    assert ks.analyze(arm, [0.0, 1e-9]).rank == 2
    assert ks.analyze(arm, [0.0, 1e-11]).rank == 1
