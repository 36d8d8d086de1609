"""What people do wrong: each is an error of ours with a code that names the place and the remedy, or a warning."""

import re

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks

ARM = ks.load("ur5e")
Q = ARM.home
J = ks.jacobian(ARM, Q)
BATCH = ks.jacobian(ARM, np.stack([Q] * 4))
PUSH = ks.Wrench.on_environment(force=(0, 0, 1))
SYMBOLIC = ks.from_dh([(sp.Symbol("l"), 0, 0, 0)], convention="standard")

MISTAKES = {
    "no robot, a name": (lambda: ks.jacobian("ur5e", Q), "KS302.*RobotModel"),
    "robot and q exchanged": (lambda: ks.pose(Q, ARM), "KS302.*RobotModel"),
    "analyze a name": (lambda: ks.analyze("ur5e"), "KS302.*RobotModel"),
    "Evaluator of a name": (lambda: ks.Evaluator("ur5e"), "KS302.*RobotModel"),
    "gravity of a name": (lambda: ks.gravity_torques("ur5e", Q), "KS302.*RobotModel"),
    "load nothing": (lambda: ks.load(None), "KS312"),
    "load a very long name": (lambda: ks.load("a" * 5000), "KS312"),
    "a frame as text": (lambda: ks.jacobian(ARM, Q, frame="body"), r"KS302.*Frame\.body"),
    "change to a frame as text": (lambda: J.change_frame("body"), r"KS302.*Frame\.body"),
    "Evaluator with a frame as text": (lambda: ks.Evaluator(ARM, frame="body"), r"KS302.*Frame\.body"),
    "a link by number": (lambda: ks.jacobian(ARM, Q, at=3), "KS310"),
    "a link that is None": (lambda: ks.pose(ARM, Q, at=None), "KS310"),
    "a point too deep": (lambda: ks.jacobian(ARM, Q, point=[[1, 2, 3]]), "KS303: point"),
    "a point as text": (lambda: ks.pose(ARM, Q, point="abc"), "KS303: point"),
    "a bare wrench": (lambda: ks.joint_torques(J, [0, 0, 1, 0, 0, 0]), r"KS302.*Wrench\.on_robot"),
    "a bare Jacobian": (lambda: ks.joint_torques(J.array, PUSH), r"KS302.*ks\.jacobian"),
    "a twist for a wrench": (lambda: ks.joint_torques(J, ks.Twist.of((0, 0, 1))), "KS302"),
    "a tuple for a wrench": (lambda: ks.analyze(ARM, Q, (0, 0, -50)), r"KS302.*Wrench\.on_robot"),
    "batches that do not fit": (
        lambda: ks.joint_torques(BATCH, ks.Wrench.on_robot(force=np.zeros((3, 3)))),
        r"KS303.*\(4,\).*\(3,\)",
    ),
    "rates that do not fit": (lambda: BATCH @ np.zeros((3, 6)), r"KS303.*\(4,\).*\(3,\)"),
    "a matrix product": (lambda: J @ np.linalg.pinv(J), r"KS303.*np\.asarray"),
    "a twist for rates": (lambda: J @ ks.Twist.of((0, 0, 1)), "KS302.*Twist"),
    "free wrenches of a batch": (lambda: ks.free_wrenches(BATCH), "KS303"),
    "lost twists of a batch": (lambda: ks.lost_twists(BATCH), "KS303"),
    "no length": (lambda: ks.free_wrenches(J, 0.0), "KS303.*length"),
    "a negative length": (lambda: ks.lost_twists(J, -1.0), "KS303.*length"),
    "a length that is no number": (lambda: ks.lost_twists(J, np.nan), "KS303.*length"),
    "rpy of a batch": (lambda: ks.pose(ARM, np.stack([Q, Q])).rpy, "KS303"),
    "no rows": (lambda: ks.analyze(ARM, Q, task=[]), "KS318"),
    "convention and frame": (
        lambda: J.to_array(convention="pinocchio.WORLD", frame=ks.Frame.body()),
        "KS319.*already",
    ),
    "reach of symbols": (lambda: ks.characteristic_length(SYMBOLIC), "KS302.*symbolic"),
    "task of symbols": (lambda: ks.find_task(SYMBOLIC), "KS302.*symbolic"),
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda name: name.replace(" ", "_"))
def test_a_mistake_is_named(mistake):
    """A code, what is wrong, and the remedy; never an exception of NumPy's or Python's own."""
    call, pattern = MISTAKES[mistake]
    with pytest.raises(ks.KinestaticsError, match=re.compile(pattern, re.DOTALL)):
        call()


@pytest.mark.parametrize("ask", [ks.jacobian, ks.pose, ks.analyze], ids=["jacobian", "pose", "analyze"])
def test_degrees_are_doubted(ask):
    """-90 for a joint limited to two turns is a warning that asks for degrees; large but possible angles are not."""
    with pytest.warns(ks.KinestaticsWarning, match="KS321.*degrees"):
        ask(ARM, [0, -90, 90, -90, -90, 0])
    ask(ARM, [0, -6.2, 6.2, 4 * np.pi, 0, 0])
    ks.pose(ks.from_dh([(1, 0, 0, 0)], convention="standard"), [90.0])  # a joint without limits may turn that far


def test_tensors_for_analyze_name_their_library():
    """analyze computes with NumPy, and says what to do with a tensor; other functions take whole numbers of PyTorch too."""
    torch = pytest.importorskip("torch")
    with pytest.raises(ks.ArrayTypeError, match=re.compile("KS302.*torch.*np.asarray|KS302.*np.asarray.*torch", re.DOTALL)):
        ks.analyze(ARM, torch.tensor(Q))
    whole = torch.tensor([0, -1, 1, -1, -1, 0])
    assert ks.jacobian(ARM, whole).array.dtype == torch.float64
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        ks.jacobian(ARM, whole.to(torch.complex128))


def test_limits_that_mean_none_are_no_range_to_draw_from():
    """A file's ±1e16 is no limit: random configurations stay within a turn."""
    arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", limits=[(-1e16, 1e16)])
    assert np.all(np.abs(arm.random_configurations(100, seed=0)) <= np.pi)


def test_masses_without_centres_are_doubted():
    """Masses whose centres nobody gave are put at the frames' origins, with a warning."""
    with pytest.warns(ks.KinestaticsWarning, match="KS209"):
        arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0])
    np.testing.assert_allclose(ks.gravity_torques(arm, [0.0], gravity=(0, -9.81, 0)), [2 * 9.81])
