"""The Evaluator says what the functions say, in every frame and at every point, and drops no sign, frame or rank."""

import itertools
import re
import threading

import numpy as np
import pytest

import kinestatics as ks

ARM = ks.load("panda")
Q = ARM.random_configurations(7, seed=5)
POINT = (0.1, -0.2, 0.3)


@pytest.mark.parametrize("axes", ["base", "tip"])
@pytest.mark.parametrize("frame_offset", [(0.0, 0.0, 0.0), (0.05, 0.1, -0.2)], ids=["at the tip", "offset"])
@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), POINT], ids=["no point", "point"])
def test_points_and_offsets_are_those_of_the_functions(axes, frame_offset, point):
    """frame= with an offset, point= and both together give what ks.jacobian gives, and the frame says so."""
    frame = ks.Frame(axes, "tip", frame_offset)
    ev = ks.Evaluator(ARM, frame=frame, point=point)
    J = ks.jacobian(ARM, Q, frame=frame, point=point if any(point) else None)
    assert ev.frame == J.frame
    np.testing.assert_array_equal(ev.jacobian(Q), J.array)
    rate = ks.jacobian_rate(ARM, Q, Q, frame=frame, point=point if any(point) else None)
    np.testing.assert_array_equal(ev.jacobian_rate(Q, Q), rate.array)


def test_an_offset_at_the_base_is_refused():
    """A point off the base origin is none of the four frames: an error, and not numbers without it."""
    with pytest.raises(ks.FrameMismatchError, match="KS331"):
        ks.Evaluator(ARM, frame=ks.Frame("base", "base", POINT))


@pytest.mark.parametrize("point", [(0, 0), (0, 0, 0, 0), (np.nan, 0, 0), "abc", None, 1.0], ids=str)
def test_points_are_three_finite_numbers(point):
    """Anything else is KS303."""
    with pytest.raises(ks.ConfigurationError, match="KS303: point"):
        ks.Evaluator(ARM, point=point)


def test_wrenches_and_twists_are_not_stripped_of_sign_and_frame():
    """A Wrench or Twist where bare arrays are taken is an error: its sign and frame would be lost."""
    ev = ks.Evaluator(ARM)
    typed = (ks.Wrench.on_robot(force=(0, 0, -50)), ks.Twist.of((0, 0, 0.1)), ks.pose(ARM, Q[0]), ks.jacobian(ARM, Q[0]))
    for call, value in itertools.product((ev.joint_torques, lambda q, w: ev.damped_rates(q, w, 0.1)), typed):
        with pytest.raises(ks.ArrayTypeError, match=re.compile("KS302.*bare arrays", re.DOTALL)):
            call(Q[0], value)


def test_no_masses_is_an_error_here_too():
    """Gravity of an arm without masses is KS320 and not zeros; with masses it is the function's."""
    arm = ks.load("scara")
    with pytest.raises(ks.MissingMassError, match="KS320"):
        ks.Evaluator(arm).gravity_torques(arm.home)
    heavy = ks.load("planar_2r")
    np.testing.assert_array_equal(ks.Evaluator(heavy).gravity_torques(heavy.home), ks.gravity_torques(heavy, heavy.home))


@pytest.mark.parametrize("name", ks.kernels.instruction_sets())
def test_manipulability_counts_the_freedoms_the_arm_has(name):
    """A planar arm with a tilted base has three freedoms in six moving rows: the product of three singular values, not 0."""
    c, s = np.cos(0.7), np.sin(0.7)
    tilt = np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]) @ np.array(
        [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]]
    )
    arm = ks.from_dh([(0.5, 0, 0, 0)] * 4, convention="standard", base=tilt)
    ev = ks.Evaluator(arm)
    assert (len(ev.task.rows), ev.task.rank) == (6, 3)
    q = arm.random_configurations(50, seed=1)
    expected = np.prod(np.linalg.svd(ks.jacobian(arm, q).array, compute_uv=False)[:, :3], axis=-1)
    with ks.kernels.use(name):
        np.testing.assert_allclose(ev.manipulability(q), expected, rtol=1e-12)
        np.testing.assert_array_equal(ev.manipulability(q), [ev.manipulability(x) for x in q])
    assert ks.analyze(arm, q[0]).manipulability == pytest.approx(expected[0])


@pytest.mark.parametrize("name", ks.kernels.instruction_sets())
@pytest.mark.parametrize("size", [1e-290, 1e-160, 1e-82, 1e-30, 1.0, 1e30, 1e49])
def test_singular_values_at_every_scale(name, size):
    """The ratios of the singular values do not depend on the unit of length."""
    arm, unit = (ks.from_dh([(x, 0, 0, 0)] * 2, convention="standard") for x in (size, 1.0))
    q = arm.random_configurations(9, seed=2)
    with ks.kernels.use(name):
        found = ks.Evaluator(arm, task=["vx", "vy"]).singular_values(q) / size
        np.testing.assert_allclose(found, ks.Evaluator(unit, task=["vx", "vy"]).singular_values(q), rtol=1e-13)


@pytest.mark.parametrize("name", ks.kernels.instruction_sets())
def test_rows_that_vanish_give_no_infinity(name):
    """Towards an exact singularity through denormal squares: w goes to 0, and σ1 stays what it is."""
    ev = ks.Evaluator(ks.load("planar_2r"))
    for tiny in (1e-140, 1e-146, 1e-150, 1e-155, 1e-161, 5e-324):
        with ks.kernels.use(name):
            assert ev.manipulability([tiny, 0.0]) <= 1e-139
            np.testing.assert_allclose(ev.singular_values([tiny, 0.0]), [np.sqrt(5), 0.0], rtol=1e-14, atol=1e-15)


def test_a_chain_is_made_once():
    """A second __init__ would free the program under a running call: it is refused."""
    ev = ks.Evaluator(ARM)
    arguments = ks.kernels.chain_arguments(ARM, ARM.link("tip"))
    with pytest.raises(TypeError, match="made once"):
        ks.kernels.Chain.__init__(ev, *arguments)
    np.testing.assert_array_equal(ev.jacobian(Q), ks.jacobian(ARM, Q).array)


def test_many_joints_and_threads():
    """1000 joints in four Python threads at once: the same bits."""
    arm = ks.from_dh([(0.01, 0.3, 0.002, 0.1)] * 1000, convention="standard")
    q, ev, results = arm.random_configurations(3, seed=0), ks.Evaluator(arm), []
    threads = [threading.Thread(target=lambda: results.append(ev.jacobian(q))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    assert all(np.array_equal(result, results[0]) for result in results)


def test_more_threads_than_sense():
    """A million threads are not started, and change nothing."""
    q, ev = np.tile(Q, (2000, 1)), ks.Evaluator(ARM)
    np.testing.assert_array_equal(ev.manipulability(q, threads=1_000_000), ev.manipulability(q))


def test_every_method_says_what_it_does():
    """Docstrings of the compiled methods reach help()."""
    for name in ("jacobian", "pose", "jacobian_rate", "hessian", "gravity_torques", "joint_torques"):
        assert "(..., " in getattr(ks.Evaluator, name).__doc__
