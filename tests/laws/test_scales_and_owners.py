"""Answers that scale with the robot, follow the array's type, and belong to whoever asked: faults that once were."""

import copy
import pickle

import numpy as np
import pytest

import kinestatics as ks

Q = np.array([0.3, -1.0, 1.5, -0.5, 1.2, 0.4])


def slider_and_two_turns(size):
    """A vertical slider and two parallel axes, `size` metres apart: rows vx, vy, vz, wz of rank 3."""
    axes = [
        ks.screw_axis((0, 0, 1), pitch=np.inf),
        ks.screw_axis((0, 0, 1)),
        ks.screw_axis((0, 0, 1), point=(size, 0, 0)),
    ]
    home = [[1, 0, 0, 2 * size], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    return ks.from_screws(axes, home, order="linear-angular")


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-6, 1e-9, 1e6, 1e9])
def test_a_sliding_joint_does_not_set_the_size_of_a_robot(size):
    """Rank, measures and capacities of a small or large arm are those of the same arm in other units."""
    arm = slider_and_two_turns(size)
    assert ks.find_task(arm).rank == 3
    w = ks.manipulability(ks.jacobian(arm, [0, 0, 0.3])) / size**2
    assert w == pytest.approx(np.sin(0.3), rel=1e-9)
    push = ks.force_capacity(arm, [0, 0, 1e-8], (1, 0, 0), gravity=None, effort_limits=(1, size, size))
    assert push.value == pytest.approx(1e8, rel=1e-6)


def test_whole_numbers_of_jax_are_numbers():
    """Integer arrays of JAX become floats before anything is cast to their type; complex ones are refused."""
    jnp = pytest.importorskip("jax.numpy")
    arm, q = ks.load("ur5e"), [0, 1, 1, 0, 1, 0]
    np.testing.assert_allclose(ks.gravity_torques(arm, jnp.array(q)), ks.gravity_torques(arm, q), atol=1e-4)
    load = ks.Wrench.on_robot(force=jnp.array([0, 0, -50]), torque=(0.5, 0, 0.25))
    np.testing.assert_allclose(load.torque, [0.5, 0, 0.25])
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        ks.jacobian(arm, jnp.array(q) * 1j)


def test_a_relative_jacobian_is_measured_in_its_own_rows():
    """Task, rank and units are those of the relative motion, not of the link's motion from the base."""
    planar = ks.load("planar_2r")
    assert ks.manipulability(ks.relative_jacobian(planar, [0.1, 0.5], relative_to="link1")) == pytest.approx(1.0)
    arm = ks.load("ur5e")
    R = ks.relative_jacobian(arm, Q, relative_to="forearm_link")
    sigma = np.linalg.svd(R.array, compute_uv=False)[:3]
    assert ks.manipulability(R, length=1.0) == pytest.approx(np.prod(sigma))
    assert ks.condition_number(R, length=1.0) == pytest.approx(sigma[0] / sigma[2])


def test_ranks_follow_the_precision_of_the_array():
    """A straight elbow in single precision is singular, as in double."""
    arm = ks.load("ur5e")
    for kind in (np.float32, np.float64):
        J = ks.jacobian(arm, np.array([0.3, -1.0, 0.0, -0.5, 0.7, 0.1], dtype=kind))
        assert len(ks.free_wrenches(J)) == len(ks.lost_twists(J)) == 1
        assert ks.tip_stiffness(J, [1e4] * 6).rank == 5


@pytest.mark.parametrize("hold", ["orientation", "nothing"])
def test_a_batch_of_directions_is_each_of_them(hold):
    """Directions that need other rows do not hold these rows for one another."""
    arm, q = ks.load("ur5e"), [0, -1, 1.5, -0.5, 1.2, 0]
    directions = np.array([[1.0, 0, 0], [0, 1.0, 0], [1.0, 0, 1.0]])
    together = ks.speed_capacity(arm, q, directions, task=["vx"], hold=hold)
    alone = [ks.speed_capacity(arm, q, d, task=["vx"], hold=hold).value for d in directions]
    np.testing.assert_allclose(together.value, alone, rtol=1e-12)
    twists = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1.0]])
    together = ks.speed_capacity(arm, q, twists, task="position")
    alone = [ks.speed_capacity(arm, q, d, task="position").value for d in twists]
    np.testing.assert_allclose(together.value, alone, rtol=1e-12)


def test_results_do_not_change_with_the_callers_arrays():
    """q, twists and wrenches are the caller's to change."""
    arm = ks.load("ur5e")
    given = [Q.copy(), memoryview(Q.copy())]
    torch = pytest.importorskip("torch")
    given.append(torch.tensor(Q.copy()))
    for q in given:
        J = ks.jacobian(arm, q)
        before = np.array(J.change_frame(ks.Frame.body()))
        for k in range(6):
            q[k] += 1.0
        np.testing.assert_array_equal(np.array(J.change_frame(ks.Frame.body())), before)
    numbers = np.zeros(6)
    twist, wrench = ks.Twist.from_array(numbers, order="linear-angular"), ks.Wrench(numbers, ks.Frame(), "robot")
    split = ks.split_load(ks.jacobian(arm, Q), ks.Wrench.on_robot(force=(0, 0, -10), frame=ks.Frame("base", "tool0")))
    numbers[0] = 9.0
    assert twist.array[0] == wrench.array[0] == 0.0
    assert not np.shares_memory(split.load.array, split.active.array)


def test_an_unfelt_mass_matrix_is_no_measure():
    """The bundled UR5e has no inertia about its last axis: its mass matrix is singular, and Asada's measure says so."""
    arm = ks.load("ur5e")
    with pytest.raises(ks.ConfigurationError, match="KS303"):
        ks.asada(ks.jacobian(arm, Q), ks.mass_matrix(arm, Q), task="position")


def test_who_holds_a_load_has_a_derivative():
    """No NaN out of the singular vectors of zeros."""
    jax = pytest.importorskip("jax")
    arm, load = ks.load("ur5e"), ks.Wrench.on_robot(force=(1.0, 2, -50.0))

    def effort(q):
        return (ks.split_load(ks.jacobian(arm, q), load, task="full").joint_torques ** 2).sum()

    found = jax.grad(effort)(jax.numpy.array(Q))
    assert np.all(np.isfinite(found))


def test_results_pickle_and_copy():
    """What inverse velocity returns is plain data, its array library found again by name."""
    rates = ks.joint_rates(ks.jacobian(ks.load("ur5e"), Q), [0.1, 0, 0, 0, 0, 0])
    for again in (pickle.loads(pickle.dumps(rates)), copy.deepcopy(rates)):
        np.testing.assert_array_equal(again.array, rates.array)
        assert (again.rank, again.reason) == (rates.rank, rates.reason)


def test_six_vectors_are_not_taken_for_bare_numbers():
    """Where axes and sides would be lost, a Wrench or Twist is refused with the remedy."""
    arm = ks.load("ur5e")
    wrench, twist = ks.Wrench.on_robot(force=(0, 0, -1)), ks.Twist.of(linear=(1, 0, 0))
    polytope = ks.velocity_polytope(arm, Q)
    for call in (
        lambda: ks.force_capacity(arm, Q, wrench),
        lambda: ks.speed_capacity(arm, Q, twist),
        lambda: polytope.contains(twist),
        lambda: ks.Wrench.on_robot(force=(1, 0, 0), frame="tip"),
        lambda: ks.wrench_from_torques(ks.jacobian(arm, Q), None),
        lambda: ks.manipulability(arm),
    ):
        with pytest.raises(ks.ArrayTypeError, match="KS302"):
            call()


def test_speeds_where_q_is_not_finite_are_nan():
    """check_finite=False lets NaN through, and it stays NaN."""
    arm = ks.load("ur5e")
    found = ks.speed_capacity(arm, np.array([np.full(6, np.nan), Q]), (0, 0, 1), check_finite=False)
    assert np.isnan(found.value).tolist() == [True, False]
    assert not np.any(found.limiting[0])


def test_a_frame_may_be_given_with_a_list():
    """An offset of a list names the same frame as one of a tuple."""
    arm = ks.load("ur5e")
    listed = ks.jacobian(arm, Q, frame=ks.Frame("base", "tool0", [0, 0, 1]))
    np.testing.assert_array_equal(listed, ks.jacobian(arm, Q, frame=ks.Frame("base", "tool0", (0.0, 0.0, 1.0))))


def test_a_jacobian_of_another_robot_is_refused():
    """change_frame(arm, q, J, frame) is about that arm."""
    one, other = ks.load("ur5e"), ks.load("irb_140")
    with pytest.raises(ks.ConfigurationError, match="KS333"):
        ks.change_frame(one, Q, ks.jacobian(other, Q), ks.Frame.body())


def test_the_bare_transpose_is_explained():
    """J.T would lose frame and sign; the error says what is meant."""
    with pytest.raises(AttributeError, match="joint_torques"):
        _ = ks.jacobian(ks.load("ur5e"), Q).T
