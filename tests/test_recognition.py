"""`which_convention`: every convention is recognised, and a near miss is explained."""

import numpy as np
import pytest

import kinestatics as ks

ARMS = ("planar_2r", "scara", "stanford_arm", "ur5e", "panda")
ARM = ks.load("ur5e")
Q = np.array([0.3, -0.7, 0.9, 0.4, -0.5, 0.6])


def general(name):
    """An arm and a posture with no joint at zero."""
    arm = ks.load(name)
    return arm, np.linspace(0.3, 0.9, arm.n) * (-1.0) ** np.arange(arm.n)


def written(convention, arm=ARM, q=Q, at="tip"):
    return np.array(ks.jacobian(arm, q, at=at).to_array(convention=convention))


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("convention", ks.CONVENTIONS)
def test_every_convention_is_recognised(name, convention):
    """Planar, prismatic, six and seven joints: all conventions written alike match, with their order, axes and origin."""
    arm, q = general(name)
    found = ks.which_convention(written(convention, arm, q), arm, q)
    expected = ks.CONVENTIONS[convention]
    assert convention in found.matches
    assert (found.order, found.axes, found.origin) == (expected.order, expected.axes, expected.origin)
    assert found.residual <= 1e-15
    assert convention in str(found)
    same = [c.name for c in ks.CONVENTIONS.values() if c[1:5] == expected[1:5]]
    assert list(found.matches) == same


@pytest.mark.parametrize("convention", ["drake", "mujoco", "dynibo", "mls.body"])
def test_printed_digits_are_enough(convention):
    """Six digits after the point are recognised; three are not, unless the tolerance says so."""
    array = written(convention)
    assert convention in ks.which_convention(array.round(7), ARM, Q).matches
    assert ks.which_convention(array.round(3), ARM, Q).matches == ()
    assert convention in ks.which_convention(array.round(3), ARM, Q, tolerance=1e-3).matches


def test_another_link():
    """The Jacobian of a link in between is recognised when that link is asked for."""
    found = ks.which_convention(written("modern_robotics.space", at="forearm_link"), ARM, Q, at="forearm_link")
    assert "modern_robotics.space" in found.matches


@pytest.mark.parametrize(
    ("arm", "q"),
    [
        (ks.load("planar_2r"), [0.0, 0.0]),
        (ks.from_dh([(0, np.pi / 2, 0, 0), (0, 0, 0, 0)], convention="standard", types="PP"), [0.0, 0.0]),
    ],
)
def test_a_special_posture_is_ambiguous(arm, q):
    """Where several kinds of convention agree, all are named, none is chosen, and a general posture is asked for."""
    found = ks.which_convention(written("drake", arm, q), arm, q)
    assert "drake" in found.matches
    assert len({ks.CONVENTIONS[name][1:4] for name in found.matches}) > 1
    assert (found.order, found.axes, found.origin) == ("", "", "")
    assert "several conventions agree" in found.message


@pytest.mark.parametrize("convention", ["drake", "mujoco", "dynibo", "pinocchio.LOCAL"])
def test_the_opposite_sign(convention):
    """A negated Jacobian matches nothing, and is said to be one."""
    found = ks.which_convention(-written(convention), ARM, Q)
    assert found.matches == ()
    assert "opposite sign: all joints turn the other way round" in found.message


def test_one_joint_turned_round():
    """A joint that turns the other way is named."""
    array = written("drake")
    array[:, 1] *= -1
    message = ks.which_convention(array, ARM, Q).message
    assert "drake" in message
    assert message.endswith("the opposite sign of shoulder_lift_joint")


@pytest.mark.parametrize("convention", ["pinocchio.LOCAL", "mujoco", "dynibo"])
def test_columns_in_another_order(convention):
    """Joints listed from tip to base: the order in which they come is said."""
    array = written(convention)
    turned = array.reshape(6, 6)[::-1].ravel() if array.ndim == 1 else array[..., ::-1]
    found = ks.which_convention(turned, ARM, Q)
    assert found.matches == ()
    assert found.message.endswith(f"its columns in the order {', '.join(ARM.joint_names[::-1])}")


@pytest.mark.parametrize("convention", ["drake", "mls.spatial"])
@pytest.mark.parametrize(("joints", "lengths", "words"), [(1, 1000, "millimetres"), (np.pi / 180, 1, "degrees")])
def test_other_units(convention, joints, lengths, words):
    """Lengths in millimetres and joint rates in degrees are said, and only they."""
    array = written(convention) * joints
    linear = slice(3, 6) if ks.CONVENTIONS[convention].order == "angular-linear" else slice(0, 3)
    array[linear] *= lengths
    message = ks.which_convention(array, ARM, Q).message
    assert words in message
    assert "order" not in message
    assert "sign" not in message


def test_several_changes_at_once():
    """Another order, one joint turned round and millimetres: all three are said."""
    array = written("mls.body")[:, [1, 0, 2, 3, 4, 5]]
    array[:, 0] *= -1
    array[:3] *= 1000
    message = ks.which_convention(array, ARM, Q).message
    assert "its columns in the order shoulder_lift_joint, shoulder_pan_joint, elbow_joint" in message
    assert "the opposite sign of shoulder_lift_joint" in message
    assert "lengths in millimetres" in message


@pytest.mark.parametrize("link", ["wrist_2_link", "forearm_link"])
def test_the_wrong_tip(link):
    """The Jacobian of another link is found there, and that link is named."""
    found = ks.which_convention(written("drake", at=link), ARM, Q)
    assert found.matches == ()
    assert f"at link {link!r}" in found.message


@pytest.mark.parametrize(
    "array", [np.zeros((6, 6)), np.full((6, 6), 0.5), written("drake") + 0.1, written("drake", q=Q + 0.2)]
)
def test_no_convention_fits(array):
    """Anything else names the nearest convention, how far it is off, and what to look for."""
    found = ks.which_convention(array, ARM, Q)
    assert (found.matches, found.order) == ((), "")
    assert np.isfinite(found.residual)
    assert found.residual > found.tolerance
    assert f"the nearest is {found.best}, off by {found.residual:.2g}" in found.message
    assert "another tip, another zero of the joints, or other link lengths" in found.message


@pytest.mark.parametrize(
    ("array", "code", "words"),
    [
        (np.zeros((6, 5)), "KS303", "expected (6, 7)"),
        (np.zeros((7, 6)), "KS303", "transpose"),
        (np.zeros((2, 6, 7)), "KS303", "columns are joints"),
        (np.zeros(41), "KS303", "(6, 7)"),
        (np.full((6, 7), np.nan), "KS301", "NaN"),
        (np.full((6, 7), 1j), "KS302", "complex"),
        ([["a"] * 7] * 6, "KS302", "the array"),
    ],
)
def test_arrays_that_are_no_jacobians(array, code, words):
    """Wrong shapes, NaN and things that are no numbers are refused with a code and a remedy."""
    arm, q = general("panda")
    with pytest.raises(ks.KinestaticsError) as refused:
        ks.which_convention(array, arm, q)
    assert refused.value.code == code
    assert words in str(refused.value)


def test_one_configuration_only():
    """A batch of configurations is refused, not matched by its first."""
    with pytest.raises(ks.ConfigurationError, match="KS303"):
        ks.which_convention(written("drake"), ARM, np.stack([Q, Q]))


def test_the_array_is_left_alone():
    """The array given is not changed."""
    array = -written("drake")
    before = array.copy()
    ks.which_convention(array, ARM, Q)
    assert np.array_equal(array, before)
