"""Pose, Twist, Wrench, Jacobian and their kin: what they hold, print, convert and refuse."""

import copy
import pickle

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.quantities import format_number

ARM, Q = ks.load("ur5e"), np.array([0.3, -0.8, 1.1, -0.9, 0.7, 0.4])
QD = np.array([0.1, -0.2, 0.3, -0.4, 0.5, -0.6])


def everything():
    """One of each quantity."""
    return [
        ks.pose(ARM, Q),
        ks.jacobian(ARM, Q),
        ks.hessian(ARM, Q),
        ks.jacobian_rate(ARM, Q, QD),
        ks.acceleration(ARM, Q, QD, QD),
        ks.jacobian(ARM, Q) @ QD,
        ks.Wrench.on_robot(force=(1, 2, 3), torque=(4, 5, 6), frame=ks.Frame.body()),
    ]


ALL = pytest.mark.parametrize("quantity", everything(), ids=lambda quantity: type(quantity).__name__)


@ALL
def test_quantities_cannot_be_changed(quantity):
    """No attribute can be set or deleted, old or new."""
    for name in ("array", "frame", "anything"):
        with pytest.raises(AttributeError, match="immutable"):
            setattr(quantity, name, 0)
    with pytest.raises(AttributeError, match="immutable"):
        del quantity.array


@ALL
@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_are_the_same(quantity, again):
    """A copy has the same array, names and print."""
    other = again(quantity)
    assert type(other) is type(quantity)
    assert np.array_equal(np.asarray(other), np.asarray(quantity))
    assert (str(other), repr(other)) == (str(quantity), repr(quantity))


@ALL
def test_numpy_takes_a_quantity_for_its_array(quantity):
    """np.asarray gives the bare numbers, in the type asked for, and a copy of its own."""
    array = np.asarray(quantity)
    assert np.array_equal(array, quantity.array)
    assert np.asarray(quantity, dtype=np.float32).dtype == np.float32
    kept = quantity.array.copy()
    np.array(quantity)[...] = 9.0
    assert np.array_equal(quantity.array, kept)


def test_a_pose_has_its_parts():
    """Rotation, translation and angles of the matrix; whose pose, and seen from where."""
    T = ks.pose(ARM, Q)
    assert (T.link, T.seen_from) == ("tool0", "base")
    assert np.array_equal(T.rotation, T.array[:3, :3])
    assert np.array_equal(T.translation, T.array[:3, 3])
    np.testing.assert_allclose(T.rotation @ T.rotation.T, np.eye(3), atol=1e-15)
    assert str(T).startswith("pose of tool0 seen from base [m]\n")
    printed = [[float(x) for x in line.split()] for line in str(T).splitlines()[1:]]
    np.testing.assert_allclose(printed, T.array[:3], atol=5.01e-5)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_angles_at_the_pole(pitch):
    """With the tool straight up or down, roll and yaw are not unique; the angles given still build the rotation."""
    for yaw in (-2.0, 0.0, 0.7):
        c, s, sign = np.cos(yaw), np.sin(yaw), np.sign(pitch)
        T = np.eye(4)
        T[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[0, 0, sign], [0, 1, 0], [-sign, 0, 0]])
        roll, found, turned = ks.Pose(T, "tip", "base").rpy
        assert found == pytest.approx(pitch)
        assert sign * np.sin(turned - sign * roll - yaw) == pytest.approx(0.0, abs=1e-12)
        assert np.cos(turned - sign * roll - yaw) == pytest.approx(1.0)


def test_a_jacobian_has_its_parts():
    """Linear and angular halves, names, rows and shape; printed as a table with its frame."""
    J = ks.jacobian(ARM, Q)
    assert np.array_equal(np.r_[J.linear, J.angular], J.array)
    assert (J.shape, J.rows, J.link) == ((6, 6), ("vx", "vy", "vz", "wx", "wy", "wz"), "tool0")
    assert J.joint_names == ARM.joint_names
    lines = str(J).splitlines()
    assert lines[0] == "Jacobian of tool0: axes of base, at the origin of tool0"
    assert lines[2].split() == ["1", "2", "3", "4", "5", "6"]  # six such names are wider than a page: they follow below
    printed = [[float(x) for x in line.split()[1:]] for line in lines[3:9]]
    np.testing.assert_allclose(printed, J.array, atol=5.01e-5)
    assert [line.split()[0] for line in lines[3:9]] == list(J.rows)
    listed = " ".join(lines[9:]).removeprefix("joints:").split(",")
    assert [entry.split() for entry in listed] == [[str(k + 1), name] for k, name in enumerate(ARM.joint_names)]
    assert max(len(line) for line in lines) <= 80


def test_a_narrow_jacobian_shows_its_joints_above_the_columns():
    """Where the names fit, they stand above their columns."""
    arm = ks.load("planar_2r")
    assert str(ks.jacobian(arm, [0.3, 0.5])).splitlines()[2].split() == list(arm.joint_names)


def test_batches_print_their_shape():
    """A batch is not printed number by number."""
    batch = np.stack([Q, Q, Q])
    assert "batch of shape (3, 6, 6)" in str(ks.jacobian(ARM, batch))
    assert "(3, 4, 4)" in str(ks.pose(ARM, batch))
    assert "(3, 6)" in str(ks.jacobian(ARM, batch) @ QD)


def test_a_jacobian_times_rates_is_a_twist():
    """J @ q̇ is the twist in the frame of J; a batch of rates gives a batch; wrong lengths are refused."""
    J = ks.jacobian(ARM, Q, frame=ks.Frame.body())
    V = J @ QD
    assert V.frame == J.frame
    np.testing.assert_allclose(np.r_[V.linear, V.angular], J.array @ QD, atol=1e-15)
    many = J.twist(np.stack([QD, 2 * QD]))
    np.testing.assert_allclose(many.array[1], 2 * V.array, atol=1e-15)
    for rates in (QD[:5], np.zeros((6, 5)), 1.0):
        with pytest.raises(ks.ConfigurationError, match="KS303"):
            J @ rates


def test_change_of_frame_keeps_link_and_joints():
    """Frames are named by links afterwards, `base` and `tip` looked up; an unknown link is refused by name."""
    J = ks.jacobian(ARM, Q)
    moved = J.change_frame(ks.Frame.body("forearm_link"))
    assert (moved.frame.axes, moved.frame.origin) == ("forearm_link", "forearm_link")
    assert (moved.link, moved.joint_names) == (J.link, J.joint_names)
    assert J.same_frame(ks.Frame("base", "tip"))
    assert J.same_frame(ks.Frame("base", "tool0"))
    assert not J.same_frame(ks.Frame.body())
    with pytest.raises(ks.UnknownNameError, match=r"KS310.*\n.*'forearm_link'"):
        J.change_frame(ks.Frame.body("forarm_link"))


def test_frames_are_not_mixed():
    """A wrench in another frame is an error that names both frames and a remedy that works."""
    J, wrench = ks.jacobian(ARM, Q), ks.Wrench.on_robot(force=(0, 0, -9.81), frame=ks.Frame.body())
    with pytest.raises(ks.FrameMismatchError) as refused:
        ks.joint_torques(J, wrench)
    message = str(refused.value)
    assert refused.value.code == "KS330"
    assert "axes of base, at the origin of tool0" in message
    assert "axes of tip, at the origin of tip" in message
    assert "J.change_frame(Frame(axes='tip', origin='tip'))" in message
    assert np.all(np.isfinite(ks.joint_torques(J.change_frame(ks.Frame(axes="tip", origin="tip")), wrench)))


def test_two_halves_make_a_six_vector():
    """Twists and wrenches are built of halves that may be batches; the missing half is zero."""
    assert ks.Twist.of(linear=(1, 2, 3)).array.tolist() == [1, 2, 3, 0, 0, 0]
    assert ks.Twist.of(angular=(1, 2, 3)).array.tolist() == [0, 0, 0, 1, 2, 3]
    batch = ks.Wrench.on_environment(force=np.ones((4, 3)), torque=(0, 0, 1))
    assert batch.array.shape == (4, 6)
    assert np.array_equal(batch.torque, np.tile([0, 0, 1.0], (4, 1)))
    assert batch.force.shape == (4, 3)


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda: ks.Twist(np.zeros(5), ks.Frame()), "KS303"),
        (lambda: ks.Twist(0.0, ks.Frame()), "KS303"),
        (lambda: ks.Wrench(np.zeros(6), ks.Frame(), "gravity"), "KS317"),
        (lambda: ks.Wrench.on_robot(force=(1, 2)), "KS303"),
        (lambda: ks.Wrench.on_robot(force=5.0), "KS303"),  # not (5, 5, 5)
        (lambda: ks.Wrench.on_environment(force=(1, 2, 3), torque=[1]), "KS303"),
        (lambda: ks.Twist.of(linear=np.ones((2, 3)), angular=np.ones((3, 3))), "KS303"),
        (lambda: ks.Twist.of(linear=(1j, 0, 0)), "KS302"),
        (lambda: ks.Twist.from_array(["a"] * 6, order="linear-angular"), "KS302"),
        (lambda: ks.Twist.from_array(np.zeros(6), order="linear first"), "KS316"),
        (lambda: ks.jacobian(ARM, Q).to_array(convention="Pinocchio"), "KS315"),
        (lambda: ks.jacobian(ARM, Q).to_array(order="ωv"), "KS316"),
    ],
)
def test_what_is_no_quantity_is_refused(make, code):
    """Wrong lengths, words and kinds of numbers are errors with a code."""
    with pytest.raises(ks.KinestaticsError) as refused:
        make()
    assert refused.value.code == code


def test_who_acts_on_whom_is_kept():
    """The two ways to make a wrench differ in `acts_on` alone, and in the sign of the joint torques."""
    J = ks.jacobian(ARM, Q)
    load, push = (make(force=(1, 2, 3), torque=(4, 5, 6)) for make in (ks.Wrench.on_robot, ks.Wrench.on_environment))
    assert (load.acts_on, push.acts_on) == ("robot", "environment")
    assert np.array_equal(load.array, push.array)
    np.testing.assert_array_equal(ks.joint_torques(J, load), -ks.joint_torques(J, push))
    np.testing.assert_allclose(ks.joint_torques(J, push), J.array.T @ push.array, atol=1e-14)


def test_six_vectors_print_their_units():
    """Names, numbers, units and frame in one line."""
    assert str(ks.Twist.of((1, 0, 0), (0, 0, 0.5))) == (
        "Twist (vx 1, vy 0, vz 0, wx 0, wy 0, wz 0.5) [m/s, rad/s], axes of base, at the origin of tip"
    )
    wrench = str(ks.Wrench.on_robot((1, 2, 3)))
    assert wrench.startswith("Wrench (fx 1, fy 2, fz 3, mx 0, my 0, mz 0) [N, N m]")
    assert "m/s²" in str(ks.acceleration(ARM, Q, QD, QD))


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-0.00001, "-1e-05"),
        (-1e-13, "0"),
        (0.30000000000000004, "0.3"),
        (-1.23456, "-1.2346"),
        (0.00005, "0.0001"),
        (999999.0, "999999"),
        (1e6, "1e+06"),
        (float("inf"), "inf"),
        (float("nan"), "nan"),
        ("q1", "q1"),
    ],
)
def test_numbers_are_printed_short(x, text):
    """Four decimals at most, small and large ones by their exponent, no minus before a zero, symbols as they are."""
    assert format_number(x) == text
