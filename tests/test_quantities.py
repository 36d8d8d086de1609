"""Pose, Twist, Wrench, Jacobian and their kin: what they hold, print, convert and refuse."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.quantities import TIED, format_number, wrapped

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
    """Names, numbers, units and frame, in one line where it is not too long."""
    assert str(ks.Twist.of((1, 0, 0), (0, 0, 0.5))) == (
        "Twist (vx 1, vy 0, vz 0, wx 0, wy 0, wz 0.5) [m/s, rad/s],\n      axes of base, at the origin of tip"
    )
    assert str(ks.Wrench.on_robot(frame=ks.Frame("a", "b"))) == (
        "Wrench (fx 0, fy 0, fz 0, mx 0, my 0, mz 0) [N, N m],\n       axes of a, at the origin of b"
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


def with_long_names(name, letters):
    """A catalogue arm whose links and joints have names of so many letters."""
    arm = ks.load(name)
    links = tuple(f"left_gripper_of_link_{k}_".ljust(letters, "x") for k in range(len(arm.link_names)))
    joints = tuple(f"left_arm_joint_{k}_".ljust(letters, "y") for k in range(arm.n))
    base, tip = (links[arm.link_names.index(word)] for word in (arm.base, arm.tip))
    return replace(arm, link_names=links, joint_names=joints, moving_names=joints, base=base, tip=tip)


def printed(arm, seed):
    """What one arm prints."""
    rng = np.random.default_rng(seed)
    q = arm.random_configurations(1, seed=seed)[0]
    J = ks.jacobian(arm, q)
    size = 10.0 ** rng.integers(-3, 6)
    placed = ks.Frame(arm.link_names[1], arm.link_names[-1], (0.123456, -0.5, 1.25))
    for frame in (J.frame, ks.Frame(arm.link_names[1], arm.link_names[-1]), placed):
        twist, wrench = ks.Twist(size * rng.normal(size=6), frame), ks.Wrench(size * rng.normal(size=6), frame, "robot")
        yield from (twist, wrench, ks.screw(twist), ks.screw(wrench), ks.screw(ks.Twist.of((1, 2, 3), frame=frame)))
        yield from (ks.Twist(np.zeros((2, 6)), frame), ks.Wrench(np.zeros((2, 6)), frame, "environment"))
        yield ks.screw(ks.Wrench(rng.normal(size=(2, 6)), frame, "robot"))
        yield ks.jacobian(arm, q, frame=frame)
    yield from (ks.pose(arm, q), ks.acceleration(arm, q, q, q), J)
    limits = ks.RateLimits.of(arm, q, dt=0.01, acceleration=30.0, previous=0.9 * arm.velocity_limits)
    for bounds in (None, limits, {arm.joint_names[0]: 0.1}, ks.RateLimits(np.full(arm.n, 0.5), np.full(arm.n, 1.0))):
        twist = ks.Twist(rng.normal(size=6), J.frame)
        for options in ({}, {"task": "auto"}, {"method": "adaptive", "damping": 0.01}, {"method": "qp"}):
            yield ks.joint_rates(J, twist, limits=bounds, **options)
    straight = ks.jacobian(arm, np.zeros(arm.n))
    yield ks.joint_rates(straight, rng.normal(size=6))
    yield from (limits, ks.RateLimits.of(arm, q, dt=0.01, acceleration=0.01, previous=0 * q))
    yield ks.prioritized_rates([(J, rng.normal(size=6)), (straight, rng.normal(size=6))])


@pytest.mark.parametrize("letters", [10, 40, 60])
@pytest.mark.parametrize("name", ["ur5e", "panda", "iiwa_14"])
def test_nothing_is_printed_wider_than_eighty_columns(name, letters):
    """However long the names of links and joints: no line that could be broken at a space is longer than 80 columns."""
    arm, kinds, wide = with_long_names(name, letters), set(), 0
    for seed in range(3):
        for thing in printed(arm, seed):
            text = str(thing)
            kinds.add(type(thing).__name__)
            wide += any(len(line) > 70 for line in text.splitlines())
            for line in text.splitlines():
                assert len(line) <= 80, line
                assert line == line.rstrip()
    assert {"Twist", "Wrench", "Acceleration", "Screw", "Pose", "Jacobian", "JointRates", "RateLimits"} <= kinds
    assert wide > 10


def test_a_table_too_wide_for_its_names_has_numbers():
    """Names move below the table, in order, and the numbers of each row stay where they were."""
    limits = ks.RateLimits.of(with_long_names("panda", 72), ks.load("panda").home, dt=0.01, acceleration=10.0)
    short = ks.RateLimits.of(ks.load("panda"), ks.load("panda").home, dt=0.01, acceleration=10.0)
    long_lines, short_lines = (str(x).splitlines() for x in (limits, short))
    assert [line.split()[1:] for line in long_lines[2:9]] == [line.split()[1:] for line in short_lines[2:9]]
    assert [line.split()[0] for line in long_lines[2:9]] == list("1234567")
    legend = " ".join(long_lines[9:]).split()
    assert legend[:3] == ["joints:", "1", limits.joint_names[0] + ","]
    assert legend[-2:] == ["7", limits.joint_names[6]]
    assert short_lines[2].split()[0] == "panda_joint1"


def test_tied_words_are_torn_only_where_they_must():
    """Tied words stay in one line, unless they are longer than a line."""
    text = wrapped("label: ", f"some words {TIED.join(['a' * 30, 'b' * 32])}")
    assert text == f"label: some words\n       {'a' * 30} {'b' * 32}"
    text = wrapped("label: ", TIED.join(["a" * 30] * 3))
    assert text.split() == ["label:", *["a" * 30] * 3]
    assert max(map(len, text.splitlines())) <= 80
