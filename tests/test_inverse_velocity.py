"""Joint rates: numbers of the notes, singular postures, limits over time, words, mistakes, other array libraries."""

import copy
import json
import pickle
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks
from golden.test_truth_cases import BUILD, CASES, jacobian_in_convention

PLANAR = ks.load("planar_2r")
PANDA = ks.load("panda")
J7 = ks.jacobian(PANDA, PANDA.home)
FREE = (np.nan, np.nan, np.nan)
TWIST = ks.Twist.of((0.1, 0, 0))


# Numbers of the notes and of the collected cases


def test_near_a_singularity_note_004():
    """Note 004: links of 1 m, θ2 = 0.01: a radial 1 m/s asks for (99.9967, -199.998), a tangential one for (1, -1)."""
    J = ks.jacobian(PLANAR, [0.0, 0.01])
    rows = [0, 1]
    np.testing.assert_allclose(J.array[rows], [[-0.01, -0.01], [2.0, 1.0]], atol=5e-5)
    radial, tangential = (ks.joint_rates(J.array[rows], v).array for v in ([1.0, 0.0], [0.0, 1.0]))
    np.testing.assert_allclose(radial, [99.9967, -199.998], rtol=5e-6)
    np.testing.assert_allclose(tangential, [1.0, -1.0], atol=5e-6)
    exact = ks.joint_rates(J, ks.Twist.of((1, 0, 0), FREE))
    np.testing.assert_allclose(exact.array, radial, rtol=1e-12)
    assert exact.reachable


def test_at_the_singularity_note_004():
    """Note 004: at θ2 = 0 only tangential velocities are possible, and the reason says which is lost."""
    J = ks.jacobian(PLANAR, [0.3, 0.0])
    radial = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    lost = ks.joint_rates(J, ks.Twist.of(radial, FREE))
    assert (lost.rank, lost.rank_augmented) == (1, 2)
    assert np.abs(lost.array).max() < 1e-12
    assert lost.reason.startswith("not reachable: rank J = 1 < rank [J | ξ] = 2: no velocity along (0.9553, 0.2955, 0)")
    tangential = ks.joint_rates(J, ks.Twist.of(np.array([-np.sin(0.3), np.cos(0.3), 0.0]), FREE))
    assert tangential.reason == "reachable: rank J = rank [J | ξ] = 1"
    np.testing.assert_allclose(tangential.array, [0.4, 0.2], atol=1e-12)


def test_collected_case_of_least_norm():
    """The hand calculation of the collected cases, through joint_rates."""
    [case] = [case for case in CASES if "minimum-norm" in case["quantity"]]
    J = jacobian_in_convention(BUILD[case["robot"]["type"]](case["robot"]), case["q"], case)
    for method in ("pseudoinverse", "qr"):
        found = ks.joint_rates(J[:2], case["inputs"]["v"], method)
        np.testing.assert_allclose(found.array, case["expected"], atol=case["tolerance"]["atol"])


def test_rank_of_the_notes():
    """Note 000: the velocity Jacobian of a planar arm has rank 2, also in three rows, and 1 where it is straight."""
    for q, rank in (([0.2, 0.7], 2), ([0.2, 0.0], 1), ([0.2, np.pi], 1)):
        found = ks.joint_rates(ks.jacobian(PLANAR, q).linear, [0.1, 0.2, 0.3])
        assert (found.rank, found.rank_augmented) == (rank, rank + 1)
    spherical = ks.load("rrp_note_000")
    for q, rank in (([0.1, 0.2, 1.0], 3), ([0.1, 0.2, 0.0], 1), ([0.1, np.pi / 2, 1.0], 2)):
        assert ks.joint_rates(ks.jacobian(spherical, q).linear, [0.0, 0.0, 0.0]).rank == rank


# Through singular postures


@pytest.mark.parametrize(
    ("method", "options"), [("damped", {"damping": 0.05}), ("adaptive", {})], ids=["damped", "adaptive"]
)
def test_a_straight_arm_is_passed_without_a_jump(method, options):
    """From 0.3 rad through 0 to -0.3 rad with a radial twist: bounded rates, no jump; the pseudoinverse has both."""
    angles = np.linspace(0.3, -0.3, 6001)
    J = ks.jacobian(PLANAR, np.stack([np.zeros_like(angles), angles], -1)).array[:, :2]
    found = ks.joint_rates(J, [0.1, 0.05], method, **options).array
    most = 0.12 / (2 * 0.05) if method == "damped" else 0.12 / (0.02 * 2.2)
    assert np.abs(found).max() < most
    assert np.abs(np.diff(found, axis=0)).max() < 0.02
    plain = ks.joint_rates(J, [0.1, 0.05]).array
    assert np.abs(plain).max() > 100
    far = np.abs(angles) > 0.2
    if method == "adaptive":
        np.testing.assert_allclose(found[far], plain[far], atol=1e-10)


@pytest.mark.parametrize("name", [name for name in ks.catalogue_names() if ks.load(name).n])
def test_every_arm_in_every_posture_it_is_named_for(name):
    """At zero, at home and stretched: nothing blows up, ranks and reasons are there, reachable twists are made."""
    arm = ks.load(name)
    for q in (np.zeros(arm.n), arm.home, *arm.random_configurations(2, seed=3)):
        J = ks.jacobian(arm, q)
        twist = J @ np.linspace(-1.0, 1.0, arm.n)
        found = ks.joint_rates(J, twist)
        assert found.reachable
        np.testing.assert_allclose(np.asarray(found.achieved), twist.array, atol=1e-9)
        assert np.all(np.isfinite(ks.joint_rates(J, ks.Twist.of((1, 2, 3), (4, 5, 6)), "adaptive").array))
        assert json.loads(json.dumps(found.to_dict()))["rank"] == found.rank


def test_free_orientation_of_a_wrist_with_the_tip_on_its_axes():
    """Entries of 1e-17 m are no lever arms: with orientation free, no velocity is reachable and no rate is large."""
    tip, tilt = (
        np.array([0.1, 0.2, 0.3]),
        [(0.0, 0.0, 1.0), (0.0, np.sin(0.3), np.cos(0.3)), (np.sin(0.5), 0.0, np.cos(0.5))],
    )
    home = np.eye(4)
    home[:3, 3] = tip
    wrist = ks.from_screws([ks.screw_axis(axis, point=tip) for axis in tilt], home, order="linear-angular")
    J = ks.jacobian(wrist, [0.3, 0.4, 0.5])
    assert 0 < np.abs(J.linear).max() < 1e-15
    found = ks.joint_rates(J, ks.Twist.of((0, 0, 1), FREE))
    assert (found.rank, bool(found.reachable)) == (0, False)
    assert np.all(found.array == 0.0)


def test_intermediate_links_are_other_jacobians():
    """The elbow's twist needs the joints before it, and only these."""
    J = ks.jacobian(PANDA, PANDA.home, at="panda_link4")
    twist = J @ np.r_[0.1, 0.2, 0.3, 0.4, 9.0, 9.0, 9.0]
    found = ks.joint_rates(J, twist)
    assert found.reachable
    np.testing.assert_allclose(found.array[4:], 0.0, atol=1e-12)


# Results


def test_closest_is_closest_in_the_size_of_the_twist():
    """No reachable twist is nearer in |(v, length · ω)|; another length, another answer."""
    rng = np.random.default_rng(1)
    J = ks.jacobian(ks.load("elbow_rrr"), [0.2, 0.5, 0.9])
    twist = ks.Twist(rng.normal(size=6), J.frame)
    answers = []
    for length in (0.2, 5.0):
        found = ks.joint_rates(J, twist, length=length)
        sizes = np.r_[np.ones(3), np.full(3, length)]
        best = np.linalg.norm(sizes * (twist.array - found.closest.array))
        for _ in range(200):
            other = J @ (found.array + rng.normal(size=3) * 0.1)
            assert np.linalg.norm(sizes * (twist.array - other.array)) >= best
        answers.append(found.array)
    assert np.abs(answers[0] - answers[1]).max() > 1e-3


def test_achieved_residual_and_closest_of_a_slowed_arm():
    """With limits and damping the three differ: the closest twist knows neither."""
    twist = ks.Twist.of((1.0, 2.0, 0.0), (0.0, np.nan, 0.0))
    found = ks.joint_rates(J7, twist, "damped", damping=0.1, limits=ks.RateLimits.of(PANDA, PANDA.home))
    assert found.scale < 1
    np.testing.assert_allclose(found.achieved.array, J7.array @ found.array, atol=1e-13)
    expected = np.where(np.isnan(twist.array), 0.0, twist.array - found.achieved.array)
    np.testing.assert_allclose(found.residual.array, expected, atol=1e-13)
    asked = ~np.isnan(twist.array)
    np.testing.assert_allclose(found.closest.array[asked], twist.array[asked], atol=1e-12)
    assert found.achieved.frame == found.closest.frame == J7.frame


def test_nothing_is_computed_before_it_is_asked_for():
    """The rates cost one decomposition: ranks, reasons and bases are found when they are looked at, and kept."""
    found = ks.joint_rates(J7, ks.Twist.of((0.1, 0, 0)))
    lazy = {"rank", "reachable", "rank_augmented", "reason", "achieved", "closest", "residual", "null_motion", "condition"}
    assert not lazy & set(vars(found))
    assert found.null_motion is found.null_motion
    assert found.condition == pytest.approx(np.linalg.cond(J7.array))


def test_printed_rates():
    """What a person sees: names, units, the rank test, what is missing, which limit slows the arm down."""
    limits = ks.RateLimits.of(PANDA, PANDA.home, dt=0.01)
    text = str(ks.joint_rates(J7, ks.Twist.of((1, 2, 0)), limits=limits))
    assert "panda_joint3   2.175  rad/s" in text
    assert "reachable: rank J = rank [J | ξ] = 6" in text
    assert re.search(r"limits: slowed to 0\.6429 of the speed by\s+panda_joint3: velocity limit 2\.175 rad/s", text)
    assert all(len(line) <= 80 for line in text.splitlines())
    scara = ks.load("scara")
    J = ks.jacobian(scara, [0.1, 0.4, 0.1, 0.2])
    lines = str(ks.joint_rates(J, ks.Twist.of((0, 0, 0.1), (0.5, 0, 0)))).splitlines()
    assert any(line.endswith("m/s") for line in lines)
    assert "no rotation about x of" in " ".join(lines)
    assert "residual:" in str(ks.joint_rates(J7.array, [1, 2, 0, 0, 0, 0], "damped", damping=0.1))
    assert "no limit is met" in str(ks.joint_rates(J7, ks.Twist.of((0.1, 0, 0)), "qp", limits=limits))
    moving = ks.RateLimits(np.full(7, 0.5), np.full(7, 1.0))
    assert "in another direction" in str(ks.joint_rates(J7, ks.Twist.of((0.1, 0, 0)), limits=moving)).replace(
        "\n        ", " "
    )
    batch = ks.joint_rates(J7, np.zeros((3, 6)))
    assert str(batch) == "<JointRates by pseudoinverse, shape (3, 7)>\nreachable: 3 of 3 twists"


@pytest.mark.parametrize("shape", [(0, 6, 7), (6, 0), (0, 4), (0, 0)], ids=str)
def test_empty_batches_rows_and_joints(shape):
    """Nothing in, nothing out."""
    J = np.zeros(shape)
    for method in ("pseudoinverse", "qr", "adaptive", "qp"):
        found = ks.joint_rates(J, np.zeros((*shape[:-2], shape[-2])), method)
        assert found.array.shape == (*shape[:-2], shape[-1])
        assert np.all(found.array == 0.0)
        assert found.rank.shape == found.condition.shape == shape[:-2]
    assert ks.prioritized_rates([(J, np.zeros((*shape[:-2], shape[-2])))]).array.shape == (*shape[:-2], shape[-1])


def test_results_and_arguments_are_left_alone():
    """Arguments are not changed; results are frozen."""
    J, v, b = J7.array.copy(), np.array([1.0, np.nan, 0, 0, 0, 0]), np.ones(7)
    before = J.copy(), v.copy(), b.copy()
    found = ks.joint_rates(J, v, secondary=b, limits=(-b, b))
    for array, kept in zip((J, v, b), before, strict=True):
        np.testing.assert_array_equal(array, kept)
    with pytest.raises(AttributeError):
        found.array = 0
    with pytest.raises(ValueError, match="read-only"):
        found.limits.lower[0] = 0.0


def test_results_can_be_kept():
    """Pickled and copied, with what was already asked for."""
    limits = ks.RateLimits.of(PANDA, PANDA.home)
    found = ks.joint_rates(J7, ks.Twist.of((1, np.nan, 0)), limits=limits)
    tasks = ks.prioritized_rates([(J7, TWIST)])
    reason = found.reason
    for copied in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert (copied.reason, copied.limiting) == (reason, found.limiting)
        np.testing.assert_array_equal(copied.closest.array, found.closest.array)
    assert str(pickle.loads(pickle.dumps(tasks))) == str(tasks)


# The rows of a task, and limits in every form


def test_a_planar_arm_reaches_what_its_task_asks():
    """Six components ask a 2R arm not to turn as well, and say what to do; its own task is the notes' two-row answer."""
    J, twist = ks.jacobian(PLANAR, [0.4, 0.9]), [0.3, -0.2, 0, 0, 0, 0]
    asked = ks.joint_rates(J, twist)
    assert not asked.reachable
    assert "hint: task='auto' asks only for what this arm can do, vx, vy;" in str(asked)
    found = ks.joint_rates(J, twist, task="auto")
    assert found.reachable
    assert found.task == ("vx", "vy")
    np.testing.assert_allclose(found.array, np.linalg.solve(J.array[:2], twist[:2]), rtol=1e-12)
    np.testing.assert_allclose(found.achieved.linear[:2], twist[:2], atol=1e-14)
    assert np.all(found.residual.angular == 0.0)
    assert "task: vx, vy; the rest is free" in str(found)
    assert (found.to_dict()["task"], asked.to_dict()["task"]) == (["vx", "vy"], None)
    assert pickle.loads(pickle.dumps(found)).task == found.task
    assert "task='auto'" not in str(ks.joint_rates(ks.jacobian(PANDA, np.zeros(7)), [1, 2, 3, 4, 5, 6]))  # helps no more


def test_tasks_of_bare_arrays():
    """Six rows have names; any number of rows has numbers; what is outside the task may be anything at all."""
    J, twist = J7.array, np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    expected = ks.joint_rates(J7.linear, twist[:3]).array
    for task in ("position", "vx,vy,vz", ["vz", "vx", "vy"], range(3), np.arange(3)):
        np.testing.assert_allclose(ks.joint_rates(J, twist, task=task).array, expected, atol=1e-14)
        np.testing.assert_allclose(ks.joint_rates(J7, twist, task=task).array, expected, atol=1e-14)
    np.testing.assert_array_equal(ks.joint_rates(J, twist, task="full").array, ks.joint_rates(J, twist).array)
    eight = np.concatenate([J, J7.linear[:2]])
    found = ks.joint_rates(eight, [*twist[:3], np.inf, np.nan, 9, -np.inf, 0], task=[0, 1, 2])
    np.testing.assert_allclose(found.array, expected, atol=1e-14)
    assert found.task == ("row 1", "row 2", "row 3")
    assert "task: row 1, row 2, row 3; the rest is free" in str(found)


@pytest.mark.filterwarnings("ignore:.*torch.jit.script. is deprecated:DeprecationWarning")
def test_tasks_in_other_libraries():
    """Under jit, in PyTorch with gradients and at symbols: the rates with NaN outside the task."""
    jax = pytest.importorskip("jax", reason="a judge of the dev extra")
    torch = pytest.importorskip("torch", reason="a judge of the dev extra")
    jax.config.update("jax_enable_x64", True)
    rng = np.random.default_rng(11)
    J, v = rng.normal(size=(4, 6, 7)), rng.normal(size=(4, 6))
    expected = ks.joint_rates(J, np.where(np.isin(np.arange(6), [0, 2, 4]), v, np.nan)).array
    rates = jax.jit(lambda J, v: ks.joint_rates(J, v, task="vx,vz,wy").array)
    np.testing.assert_allclose(rates(J, v), expected, atol=1e-12)
    twist = torch.tensor(v, requires_grad=True)
    found = ks.joint_rates(torch.tensor(J), twist, task=[0, 2, 4]).array
    np.testing.assert_allclose(found.detach().numpy(), expected, atol=1e-12)
    found.sum().backward()
    assert np.all(np.isfinite(twist.grad.numpy()))
    assert np.all(twist.grad.numpy()[:, [1, 3, 5]] == 0.0)
    assert np.all(twist.grad.numpy()[:, [0, 2, 4]] != 0.0)
    l1, l2 = sp.symbols("l1 l2", positive=True)
    t1, t2, vx, vy = sp.symbols("theta1 theta2 v_x v_y")
    symbolic = ks.jacobian(ks.from_dh([(l1, 0, 0, 0), (l2, 0, 0, 0)], convention="standard"), [t1, t2])
    free = ks.joint_rates(symbolic, [vx, vy, *[sp.nan] * 4]).array
    chosen = ks.joint_rates(symbolic, [vx, vy, 0, 0, 0, 0], task="auto")
    assert [a == b for a, b in zip(chosen.array, free, strict=True)] == [True, True]
    assert "task: vx, vy" in str(chosen)


def test_limits_in_every_form():
    """Sizes, pairs and names say the same bounds; joints that are not named have none; a bare array has no names."""
    n, names = 7, PANDA.joint_names
    sizes = np.linspace(0.05, 0.2, n)
    pair = (-sizes, sizes)
    bounds = ks.RateLimits(*pair)
    for method, options in (("pseudoinverse", {}), ("qp", {}), ("qp", {"keep_direction": True})):
        expected = ks.joint_rates(J7, TWIST, method, limits=bounds, **options)
        assert expected.limiting
        for form in (sizes, sizes.tolist(), tuple(sizes), pair, list(pair), np.array(pair)):
            np.testing.assert_array_equal(ks.joint_rates(J7, TWIST, method, limits=form, **options).array, expected.array)
            bare = ks.joint_rates(J7.array, TWIST.array, method, limits=form, **options)
            np.testing.assert_array_equal(bare.array, expected.array)
        named = ks.joint_rates(J7, TWIST, method, limits=dict(zip(names, sizes, strict=True)), **options)
        np.testing.assert_array_equal(named.array, expected.array)
        assert named.limits.joint_names == names
        assert named.limiting == expected.limiting
    lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    lower[1], upper[1], lower[3], upper[3] = -0.1, 0.1, -0.02, 0.3
    some = {names[1]: 0.1, names[3]: (-0.02, 0.3)}
    found = ks.joint_rates(J7, TWIST, "qp", limits=some)
    np.testing.assert_array_equal(found.array, ks.joint_rates(J7, TWIST, "qp", limits=(lower, upper)).array)
    np.testing.assert_array_equal([found.limits.lower, found.limits.upper], [lower, upper])
    assert np.all(ks.joint_rates(J7, TWIST, limits={}).array == ks.joint_rates(J7, TWIST).array)
    assert np.all(ks.joint_rates(J7, TWIST, limits=dict.fromkeys(names, 0.0)).array == 0.0)
    first = ks.prioritized_rates([(J7, TWIST)], limits=sizes)
    np.testing.assert_array_equal(first.array, ks.prioritized_rates([(J7, TWIST)], limits=pair).array)
    mixed = [(J7.linear, TWIST.array[:3]), (J7, TWIST)]  # the second task knows the names
    found = ks.prioritized_rates(mixed, limits=some).array
    np.testing.assert_array_equal(found, ks.prioritized_rates(mixed, limits=(lower, upper)).array)


def test_two_numbers_are_sizes_of_two_joints():
    """Of an arm with two joints, two numbers are sizes and two lists a pair."""
    J = ks.jacobian(PLANAR, [0.4, 0.9])
    found = ks.joint_rates(J, [1, 1, 0, 0, 0, 0], task="auto", limits=[0.5, 0.25])
    np.testing.assert_array_equal([found.limits.lower, found.limits.upper], [[-0.5, -0.25], [0.5, 0.25]])
    found = ks.joint_rates(J, [1, 1, 0, 0, 0, 0], task="auto", limits=[[-0.5, -1], [0.25, 1]])
    np.testing.assert_array_equal([found.limits.lower, found.limits.upper], [[-0.5, -1], [0.25, 1]])
    many = ks.joint_rates(J, np.ones((3, 6)), task="position", limits=([[-1, -1]] * 3, [[1, 1]] * 3))
    assert many.array.shape == (3, 2)
    assert np.all(np.abs(many.array) <= 1)


# Limits of one period


def test_bounds_of_a_period():
    """Velocity, position and acceleration, each where it is the narrowest, against numbers worked out by hand."""
    arm = PLANAR_LIMITED
    limits = ks.RateLimits.of(arm, [0.0, 0.99], dt=0.01)
    np.testing.assert_allclose(limits.upper, [2.0, 1.0])
    np.testing.assert_allclose(limits.lower, [-2.0, -3.0])
    assert [limits.why(k, "upper") for k in (0, 1)] == ["velocity", "position"]
    braking = ks.RateLimits.of(arm, [0.0, 0.5], dt=0.01, acceleration=[1.0, 4.0])
    np.testing.assert_allclose(braking.upper, [np.sqrt(2.0) - 0.005, 2.0 - 0.02])
    windowed = ks.RateLimits.of(arm, [0.0, 0.5], dt=0.01, acceleration=[1.0, 4.0], previous=[0.5, -1.0])
    np.testing.assert_allclose(windowed.upper, [0.51, -0.96])
    np.testing.assert_allclose(windowed.lower, [0.49, -1.04])
    assert {windowed.why(k, side) for k in (0, 1) for side in ("lower", "upper")} == {"acceleration"}
    assert "acceleration" in str(windowed)
    inside = ks.RateLimits.of(arm, [0.0, 0.0], dt=1.0, margin=[0.5, 0.0])
    np.testing.assert_allclose(inside.upper, [0.5, 1.0])
    reached = ks.RateLimits.of(arm, [[1.0, 0.0], [0.0, -1.0]])
    np.testing.assert_allclose(reached.upper, [[0.0, 3.0], [2.0, 3.0]])
    np.testing.assert_allclose(reached.lower, [[-2.0, -3.0], [-2.0, 0.0]])


def test_joints_beyond_a_limit_go_no_further_and_may_be_brought_back():
    """Outside: 0 outwards; with recovery a rate inwards; accelerations hold before positions, and the flag says so."""
    arm = PLANAR_LIMITED
    limits = ks.RateLimits.of(arm, [1.2, 0.0], dt=0.01)
    assert (limits.upper[0], limits.outside.tolist(), limits.gives_way.any()) == (0.0, [True, False], False)
    back = ks.RateLimits.of(arm, [1.2, -1.5], dt=0.01, recovery=2.0)
    np.testing.assert_allclose([back.upper[0], back.lower[1]], [-0.4, 1.0])
    assert ks.RateLimits.of(arm, [5.0, 0.0], dt=0.01, recovery=2.0).upper[0] == -2.0
    fast = ks.RateLimits.of(arm, [0.999, 0.0], dt=0.01, acceleration=1.0, previous=[1.5, 0.0])
    np.testing.assert_allclose([fast.lower[0], fast.upper[0]], [1.49, 1.49])
    assert fast.gives_way.tolist() == [True, False]
    faster = ks.RateLimits.of(arm, [0.0, 0.0], dt=0.01, acceleration=1.0, previous=[2.5, 0.0])
    np.testing.assert_allclose([faster.lower[0], faster.upper[0]], [2.49, 2.49])  # acceleration before velocity
    assert faster.gives_way.tolist() == [True, False]
    assert "gives way" in str(faster)
    assert json.loads(json.dumps(faster.to_dict()))["gives_way"] == [True, False]


def limited_planar():
    """A 2R arm with limits of both joints: ±1 rad, 2 and 3 rad/s."""
    import dataclasses

    velocities, ends = np.array([2.0, 3.0]), np.array([1.0, 1.0])
    return dataclasses.replace(PLANAR, lower=-ends, upper=ends, velocity_limits=velocities)


PLANAR_LIMITED = limited_planar()


@pytest.mark.parametrize("method", ["pseudoinverse", "qp", "direction", "solver"])
def test_five_seconds_against_the_limits(method):
    """A loop that always asks for more: position, velocity and acceleration limits hold at every one of 500 periods."""
    dt, a = 0.01, np.array([4.0, 4.0, 6.0, 6.0, 8.0, 8.0, 8.0])
    q, rates, jumps = PANDA.home.copy(), np.zeros(7), 0
    solver = ks.RateSolver(PANDA, dt=dt, acceleration=a)
    met = {"position": 0, "velocity": 0, "acceleration": 0}
    for k in range(500):
        turn = 2 * np.pi * k * dt / 2.5
        twist = np.r_[3 * np.cos(turn), 3 * np.sin(turn), 1.0 if k < 250 else -1.0, 0, 2 * np.sin(turn), 0]
        before, limits = rates, ks.RateLimits.of(PANDA, q, dt=dt, previous=rates, acceleration=a)
        assert not limits.gives_way.any()
        if method == "solver":
            rates = solver.step(q, twist)
        else:
            name, options = ("qp", {"keep_direction": True}) if method == "direction" else (method, {})
            found = ks.joint_rates(ks.jacobian(PANDA, q), twist, name, limits=limits, **options)
            rates = found.array
            jumps += not found.keeps_direction
            for j in np.flatnonzero(found.at_limit):
                met[limits.why(int(j), "upper" if rates[j] > 0 else "lower")] += 1
        q = q + dt * rates
        assert np.all(np.abs(rates) <= PANDA.velocity_limits)
        assert np.all(np.abs(rates - before) <= a * dt * (1 + 1e-9))
        assert np.all((q >= PANDA.lower - 1e-14) & (q <= PANDA.upper + 1e-14))
    assert np.min(np.minimum(q - PANDA.lower, PANDA.upper - q)) < 0.3
    if method == "qp":
        assert min(met.values()) > 20


@pytest.mark.parametrize("dt", [0.003, 0.02, 0.3])
def test_braking_keeps_itself_possible(dt):
    """Full speed at a position limit: every period can be followed by one that obeys, and the joint comes to rest at it."""
    arm, a = PLANAR_LIMITED, 1.5
    q, rates = np.array([-0.9, 0.0]), np.zeros(2)
    for _ in range(int(6 / dt)):
        limits = ks.RateLimits.of(arm, q, dt=dt, previous=rates, acceleration=a)
        assert not limits.gives_way.any()
        rates = limits.upper.copy()
        q = q + dt * rates
        assert np.all(q <= arm.upper + 1e-13)
    assert np.all(arm.upper - q <= a * dt**2 / 8 + 1e-9)
    np.testing.assert_allclose(rates, 0.0, atol=1e-6)


# The stepping class


@pytest.mark.parametrize("acceleration", [None, 3.0])
@pytest.mark.parametrize("name", ["panda", "ur5e", "scara", "planar_3r", "rrp_note_000"])
def test_solver_is_the_program_with_the_bounds_of_the_period(name, acceleration):
    """step(q, twist) against joint_rates and RateLimits, with free components, jumps of q and postures at the limits."""
    arm, rng = ks.load(name), np.random.default_rng(2)
    if not np.all(np.isfinite(arm.velocity_limits)):
        from dataclasses import replace

        arm = replace(arm, velocity_limits=np.full(arm.n, 1.5))
    solver = ks.RateSolver(arm, dt=0.01, acceleration=acceleration, damping=0.05)
    rows, previous = list(solver.task.rows), np.zeros(arm.n)
    for drawn in np.repeat(arm.random_configurations(40, seed=5), 2, axis=0):
        q = np.where(rng.random(arm.n) < 0.2, np.clip(arm.upper, -9, 9), drawn)
        twist = np.where(rng.random(6) < 0.2, np.nan, rng.normal(size=6))
        found = solver.step(q, twist)
        options = {"acceleration": acceleration, "previous": previous} if acceleration else {}
        limits = ks.RateLimits.of(arm, q, dt=0.01, **options)
        asked = ks.joint_rates(ks.jacobian(arm, q).array[rows], twist[rows], "qp", limits=limits, damping=0.05)
        np.testing.assert_allclose(found, asked.array, atol=2e-6)
        for mine, other in zip(solver.bounds, (limits.lower, limits.upper), strict=True):
            np.testing.assert_allclose(mine, np.clip(other, -1e30, 1e30), atol=1e-6)
        assert limits.contains(found, 1e-9)  # a window that is one value is met to the 1e-9 that the solver stays inside
        previous = solver.previous if acceleration else previous
        if acceleration:
            np.testing.assert_array_equal(previous, found)


def test_solver_returns_arrays_of_its_own():
    """What a step returns is not changed by the next; q and the twist are not changed at all."""
    solver = ks.RateSolver(PANDA, dt=0.01, acceleration=5.0)
    q, twist = PANDA.home.copy(), np.array([0.1, 0.2, 0.0, 0.0, 0.0, 0.3])
    first = solver.step(q, twist)
    kept = first.copy()
    first *= 1.0
    solver.step(q, -twist)
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(q, PANDA.home)
    solver.reset()
    np.testing.assert_allclose(solver.step(list(q), list(twist)), kept, atol=1e-12)
    solver.reset(np.full(7, 0.5))
    assert np.all(solver.step(q, twist) >= 0.5 - 0.05 - 1e-12)


def test_solver_in_body_axes_and_at_other_points():
    """The frame of the twist is the solver's; a Twist says its own and is checked."""
    frame, q = ks.Frame.body(), PANDA.home
    solver = ks.RateSolver(PANDA, dt=0.01, frame=frame, damping=1e-3)
    J = ks.jacobian(PANDA, q, frame=frame)
    twist = ks.Twist.of((0.1, 0.2, 0.3), (0.1, 0.0, 0.2), frame=frame)
    found = solver.step(q, twist)
    np.testing.assert_allclose((J @ found).array, twist.array, atol=1e-4)
    with pytest.raises(ks.FrameMismatchError, match="KS330"):
        solver.step(q, ks.Twist.of((0.1, 0, 0)))
    point = (0.1, 0.0, 0.2)
    there = ks.RateSolver(PANDA, dt=0.01, at="panda_link4", point=point, task="position", damping=1e-3)
    rates = there.step(q, [0.1, 0.05, 0.02, 0, 0, 0])
    np.testing.assert_allclose(
        (ks.jacobian(PANDA, q, at="panda_link4", point=point) @ rates).linear, [0.1, 0.05, 0.02], atol=1e-3
    )
    offset = ks.RateSolver(PANDA, dt=0.01, frame=ks.Frame("base", "tip", point), task="position", damping=1e-3)
    rates = offset.step(q, [0.1, 0.05, 0.02, 0, 0, 0])
    np.testing.assert_allclose((ks.jacobian(PANDA, q, point=point) @ rates).linear, [0.1, 0.05, 0.02], atol=1e-3)
    sized = ks.RateSolver(PANDA, dt=0.01, length=0.3, damping=0.1, task=["vx", "vz", "wy"])
    rates = sized.step(q, [0.1, 9.0, 0.02, 9.0, 0.3, 9.0])
    rows, weights = [0, 2, 4], np.array([1.0, 1.0, 0.3])
    expected = ks.joint_rates(weights[:, None] * J7.array[rows], weights * [0.1, 0.02, 0.3], "damped", damping=0.1)
    np.testing.assert_allclose(rates, expected.array, atol=1e-9)


def test_solver_goes_on_where_daqp_gives_up(monkeypatch):
    """A flag other than "optimal" sends the step by the slower route, with the same answer, and the loop goes on."""
    solver = ks.RateSolver(PANDA, dt=0.01)
    q, twist = PANDA.home, np.array([2.0, 1.0, 0.0, 0.0, 0.0, 0.3])
    expected = solver.step(q, twist)
    monkeypatch.setattr(solver, "_solve", lambda: (np.zeros(7), 0.0, -2, {}))
    np.testing.assert_allclose(solver.step(q, twist), expected, atol=1e-7)
    np.testing.assert_allclose(solver.step(q, twist), expected, atol=1e-7)


def test_solver_sees_the_limits_again_after_an_excursion():
    """From the middle to a position limit and back at once: bounds are those of where the arm is, not of where it was."""
    solver = ks.RateSolver(PLANAR_LIMITED, dt=0.01)
    for q in ([0.0, 0.0], [0.995, 0.0], [0.0, 0.0], [0.01, 0.0], [0.0, -0.999], [0.0, 0.0]):
        solver.step(q, np.array([5.0, 5.0, 0, 0, 0, 0]))
        limits = ks.RateLimits.of(PLANAR_LIMITED, q, dt=0.01)
        for mine, other in zip(solver.bounds, (limits.lower, limits.upper), strict=True):
            np.testing.assert_allclose(mine, other, atol=1e-6)


@pytest.mark.parametrize("lie", ["nothing met", "everything met", "no answer", "all wrong"])
def test_what_the_solver_says_is_checked(lie, monkeypatch):
    """A wrong set of bounds, or none, from DAQP is found out by the conditions of the optimum, and put right."""
    from kinestatics.inverse_velocity import quadratic

    rng = np.random.default_rng(4)
    for _ in range(30):
        n = int(rng.integers(2, 8))
        J, v = rng.normal(size=(int(rng.integers(1, 7)), n)), rng.normal(size=n)[0] * 3
        lower, upper = -rng.uniform(0.1, 1.0, n), rng.uniform(0.1, 1.0, n)
        asked = (J, np.full(len(J), v), "qp")
        expected = ks.joint_rates(*asked, limits=(lower, upper), damping=0.1).array
        with monkeypatch.context() as patch:
            guess = {"nothing met": 0.0 * upper, "everything met": upper, "no answer": upper, "all wrong": lower}[lie]
            patch.setattr(quadratic, "_daqp", lambda _, g=guess: (g, -2 if lie == "no answer" else 1))
            found = ks.joint_rates(*asked, limits=(lower, upper), damping=0.1).array
        np.testing.assert_allclose(found, expected, atol=1e-12)


class Forgetful:
    """A workspace that loses the bounds without a word, as those of DAQP 0.8.7 to 0.9.1 do when told of H alone."""

    def __init__(self):
        self.settings = {}

    def setup(self, H, f, *_):
        self.H, self.f = H, f

    def update(self, *_):
        return 0

    def solve(self):
        return np.linalg.solve(self.H, -self.f), 0.0, 1, {}


def test_solver_does_not_trust_a_workspace_that_loses_the_bounds(monkeypatch):
    """The ways to call DAQP are tried on problems with known answers: the one that is wrong is not taken."""
    daqp = pytest.importorskip("daqp")
    from kinestatics.inverse_velocity import workspace

    q, twist = PANDA.home, np.array([9.0, 9.0, 0.0, 0.0, 0.0, 3.0])
    expected = ks.RateSolver(PANDA, dt=0.01).step(q, twist)
    monkeypatch.setattr(workspace, "solver", lambda: SimpleNamespace(Model=Forgetful, solve=daqp.solve))
    found = ks.RateSolver(PANDA, dt=0.01).step(q, twist)
    np.testing.assert_allclose(found, expected, atol=1e-8)
    monkeypatch.setattr(workspace, "solver", lambda: SimpleNamespace(solve=daqp.solve))  # older: no workspace at all
    np.testing.assert_allclose(ks.RateSolver(PANDA, dt=0.01).step(q, twist), expected, atol=1e-8)
    wrong = SimpleNamespace(Model=Forgetful, solve=lambda H, f, *_, **__: (np.linalg.solve(H, -f), 0.0, 1, {}))
    monkeypatch.setattr(workspace, "solver", lambda: wrong)
    with pytest.raises(ks.ConfigurationError, match="KS356"):
        ks.RateSolver(PANDA, dt=0.01)


# Other array libraries


def test_symbols_are_solved_exactly():
    """Square, wide and tall at symbols: J⁻¹ξ, Jᵀ(JJᵀ)⁻¹ξ, (JᵀJ)⁻¹Jᵀξ, also with free rows and a secondary motion."""
    l1, l2 = sp.symbols("l1 l2", positive=True)
    t1, t2, t3, vx, vy, b = sp.symbols("theta1 theta2 theta3 v_x v_y b")
    arm = ks.from_dh([(l1, 0, 0, 0), (l2, 0, 0, 0)], convention="standard")
    J = ks.jacobian(arm, [t1, t2])
    square = ks.joint_rates(J.array[:2], [vx, vy])
    first = (vx * sp.cos(t1 + t2) + vy * sp.sin(t1 + t2)) / (l1 * sp.sin(t2))  # by hand
    assert sp.simplify(square.array[0] - first) == 0
    free = ks.joint_rates(J, [vx, vy, sp.nan, sp.nan, sp.nan, sp.nan])
    assert [a == b for a, b in zip(free.array, square.array, strict=True)] == [True, True]
    tall = ks.joint_rates(J, [vx, vy, 0, 0, 0, 0])  # three equations for two rates
    numbers = {l1: 1.1, l2: 0.7, t1: 0.3, t2: 0.5, vx: 0.2, vy: -0.1}
    achieved = [float(x.subs(numbers)) for x in free.achieved.array]
    np.testing.assert_allclose(achieved[:2], [0.2, -0.1], atol=1e-12)
    full = np.array(sp.Matrix(J.array[[0, 1, 5]]).subs(numbers), dtype=float)
    closed = np.linalg.inv(full.T @ full) @ full.T @ [0.2, -0.1, 0.0]
    np.testing.assert_allclose([float(x.subs(numbers)) for x in tall.array], closed, atol=1e-12)
    arm3 = ks.from_dh([(1, 0, 0, 0)] * 3, convention="standard")
    wide = ks.jacobian(arm3, [t1, t2, t3]).array[:2]
    moved = ks.joint_rates(wide, [vx, vy], secondary=[b, 0, 0])
    numbers = {t1: 0.3, t2: 0.5, t3: 0.9, vx: 0.2, vy: -0.1, b: 0.7}
    judge = ks.joint_rates(np.array(sp.Matrix(wide).subs(numbers), dtype=float), [0.2, -0.1], secondary=[0.7, 0, 0])
    np.testing.assert_allclose([float(x.subs(numbers)) for x in moved.array], judge.array, atol=1e-12)
    assert "joint rates by pseudoinverse" in str(square)
    for attribute in ("rank", "reachable", "closest", "condition"):
        with pytest.raises(ks.ArrayTypeError, match="KS302"):
            getattr(square, attribute)
    with pytest.raises(ks.ConfigurationError, match=r"KS355.*rank 1"):
        ks.joint_rates(np.array([[t1, t2], [2 * t1, 2 * t2]]), [vx, vy])


@pytest.mark.parametrize(
    ("method", "options"),
    [("pseudoinverse", {}), ("damped", {"damping": 0.1}), ("adaptive", {}), ("weighted", {"weights": np.arange(1.0, 8)})],
)
@pytest.mark.filterwarnings("ignore:.*torch.jit.script. is deprecated:DeprecationWarning")
def test_jax_and_torch_give_the_same_numbers(method, options):
    """JAX under jit and vmap, PyTorch: NumPy's numbers, with free components, rank loss and a secondary motion."""
    jax = pytest.importorskip("jax", reason="a judge of the dev extra")
    torch = pytest.importorskip("torch", reason="a judge of the dev extra")
    jax.config.update("jax_enable_x64", True)
    rng = np.random.default_rng(3)
    J, v, b = rng.normal(size=(4, 6, 7)), rng.normal(size=(4, 6)), rng.normal(size=7)
    J[1, 3], v[2, 1:4], v[3] = J[1, 2], np.nan, np.nan
    expected = ks.joint_rates(J, v, method, secondary=b, **options)
    rates = jax.jit(lambda J, v: ks.joint_rates(J, v, method, secondary=b, **options).array)
    np.testing.assert_allclose(rates(J, v), expected.array, atol=1e-11)
    np.testing.assert_allclose(jax.vmap(rates)(jax.numpy.asarray(J), jax.numpy.asarray(v)), expected.array, atol=1e-11)
    found = ks.joint_rates(torch.tensor(J), v, method, secondary=b, **options)
    assert isinstance(found.array, torch.Tensor)
    np.testing.assert_allclose(found.array.numpy(), expected.array, atol=1e-11)
    np.testing.assert_array_equal(found.rank, expected.rank)
    np.testing.assert_array_equal(found.reachable, expected.reachable)
    np.testing.assert_allclose(np.asarray(found.residual), expected.residual, atol=1e-11)
    np.testing.assert_allclose(
        found.member(b), ks.joint_rates(J, v, method, **options).array * 0 + expected.member(b), atol=1e-10
    )


def test_single_precision_is_judged_by_its_own_rounding():
    """float32: the tolerance in the result is coarser, and the rank is right."""
    J = (np.outer([1, 2, 3], [1, 1, 2, 1]) / 3).astype(np.float32)
    found = ks.joint_rates(J, np.array([1, 2, 3], dtype=np.float32))
    assert found.array.dtype == np.float32
    assert (found.rank, bool(found.reachable)) == (1, True)
    assert found.tolerance > 1e-6
    np.testing.assert_allclose(found.achieved, [1, 2, 3], rtol=1e-5)


# Mistakes

MISTAKES = {
    "an unknown method": (lambda: ks.joint_rates(J7, TWIST, "pinv"), "KS350"),
    "a method nearly right": (lambda: ks.joint_rates(J7, TWIST, "dampd"), "KS350.*'damped'"),
    "damping without a number": (lambda: ks.joint_rates(J7, TWIST, "damped"), "KS351.*needs damping"),
    "damping of the pseudoinverse": (lambda: ks.joint_rates(J7, TWIST, damping=0.1), "KS351.*takes no damping"),
    "negative damping": (lambda: ks.joint_rates(J7, TWIST, "damped", damping=-0.1), "KS353: damping"),
    "no region": (lambda: ks.joint_rates(J7, TWIST, "adaptive", region=0.0), "KS353: region"),
    "a region elsewhere": (lambda: ks.joint_rates(J7, TWIST, "damped", damping=1, region=0.1), "KS351.*region"),
    "no weights": (lambda: ks.joint_rates(J7, TWIST, "weighted"), "KS351.*weights"),
    "weights of another arm": (lambda: ks.joint_rates(J7, TWIST, "weighted", weights=[1, 2]), r"KS303.*\(2,\)"),
    "a weight of zero": (lambda: ks.joint_rates(J7, TWIST, "weighted", weights=[1, 1, 1, 1, 1, 1, 0]), "KS352"),
    "weights askew": (lambda: ks.joint_rates(J7, TWIST, "weighted", weights=np.triu(np.ones((7, 7)))), "KS352"),
    "direction without a program": (lambda: ks.joint_rates(J7, TWIST, keep_direction=True), "KS351.*keep_direction"),
    "direction without limits": (lambda: ks.joint_rates(J7, TWIST, "qp", keep_direction=True), "KS351.*limits"),
    "another frame": (lambda: ks.joint_rates(J7.change_frame(ks.Frame.body()), TWIST), "KS330"),
    "a Twist with a bare array": (lambda: ks.joint_rates(J7.array, TWIST), "KS302.*frame"),
    "a wrench for a twist": (lambda: ks.joint_rates(J7, ks.Wrench.on_robot(force=(1, 0, 0))), "KS302.*Wrench"),
    "a Hessian for a Jacobian": (lambda: ks.joint_rates(ks.hessian(PANDA, PANDA.home), TWIST), "KS302.*Hessian"),
    "five components": (lambda: ks.joint_rates(J7, np.zeros(5)), r"KS303.*\(5,\).*6 rows"),
    "batches that do not fit": (lambda: ks.joint_rates(np.ones((3, 6, 7)), np.ones((2, 6))), "KS303"),
    "an infinite twist": (lambda: ks.joint_rates(J7, [np.inf, 0, 0, 0, 0, 0]), r"KS301.*\[0\]"),
    "a Jacobian that is not finite": (lambda: ks.joint_rates(np.full((6, 7), np.nan), np.zeros(6)), "KS301"),
    "no length": (lambda: ks.joint_rates(J7, TWIST, length=0), "KS353: length"),
    "no tolerance": (lambda: ks.joint_rates(J7, TWIST, tolerance=0), "KS353: tolerance"),
    "a motion of other joints": (lambda: ks.joint_rates(J7, TWIST, secondary=[1, 2]), "KS303: secondary"),
    "a motion that is not finite": (lambda: ks.joint_rates(J7, TWIST, secondary=[np.nan] * 7), "KS301: secondary"),
    "limits as one number": (lambda: ks.joint_rates(J7, TWIST, limits=2.0), "KS302: limits"),
    "limits as a word": (lambda: ks.joint_rates(J7, TWIST, limits="fast"), "KS302: limits"),
    "limits of a column for each joint": (lambda: ks.joint_rates(J7, TWIST, limits=[(-1, 1)] * 7), r"KS302.*\(7, 2\).*pair"),
    "sizes of other joints": (lambda: ks.joint_rates(J7, TWIST, limits=[1.0, 2.0]), "KS303.*2 joints"),
    "a size below zero": (lambda: ks.joint_rates(J7, TWIST, limits=[1.0] * 6 + [-2]), "KS354.*panda_joint7.*-2.*both ways"),
    "a size of NaN": (lambda: ks.joint_rates(J7, TWIST, limits=[np.nan] * 7), "KS301"),
    "a named size below zero": (lambda: ks.joint_rates(J7, TWIST, limits={"panda_joint2": -1}), "KS354.*panda_joint2"),
    "named bounds the wrong way": (lambda: ks.joint_rates(J7, TWIST, limits={"panda_joint2": (2, 1)}), r"KS354.*\(2, 1\)"),
    "three named bounds": (lambda: ks.joint_rates(J7, TWIST, limits={"panda_joint2": (1, 2, 3)}), "KS303.*panda_joint2"),
    "a joint without a name": (lambda: ks.joint_rates(J7, TWIST, limits={"joint2": 1}), "KS313.*panda_joint2"),
    "names with a bare array": (lambda: ks.joint_rates(J7.array, np.zeros(6), limits={"q1": 1}), "KS302.*pass the Jacobian"),
    "no such task": (lambda: ks.joint_rates(J7, TWIST, task="pose"), "KS318.*'position'"),
    "no such row": (lambda: ks.joint_rates(J7, TWIST, task=["vx", "vw"]), "KS318.*vw"),
    "a seventh row": (lambda: ks.joint_rates(J7, TWIST, task=[6]), "KS318.*0 to 5"),
    "no rows": (lambda: ks.joint_rates(J7, TWIST, task=[]), "KS318"),
    "a task that is a number": (lambda: ks.joint_rates(J7, TWIST, task=3), "KS318"),
    "auto of a bare array": (lambda: ks.joint_rates(J7.array, np.zeros(6), task="auto"), "KS351.*pass the Jacobian itself"),
    "a row of three by name": (lambda: ks.joint_rates(J7.linear, np.zeros(3), task="vx"), r"KS351.*3 rows.*\[0, 1\]"),
    "rows of three by name": (lambda: ks.joint_rates(J7.linear, np.zeros(3), task=["vx"]), "KS318.*0 to 2"),
    "rows that are true": (lambda: ks.joint_rates(J7.linear, np.zeros(3), task=[True, 0]), "KS318"),
    "a fourth row of three": (lambda: ks.joint_rates(J7.linear, np.zeros(3), task=[3]), "KS318.*0 to 2"),
    "limits of other joints": (lambda: ks.joint_rates(J7, TWIST, limits=([-1.0], [1.0])), "KS303.*1 joints"),
    "limits the wrong way": (lambda: ks.joint_rates(J7, TWIST, limits=([1.0] * 7, [-1.0] * 7)), "KS354"),
    "limits that are NaN": (lambda: ks.RateLimits([np.nan], [1.0]), "KS301"),
    "limits of two shapes": (lambda: ks.RateLimits([0.0, 0.0], [1.0]), "KS303"),
    "null motion of a batch": (lambda: ks.joint_rates(np.ones((2, 6, 7)), np.ones(6)).null_motion, "KS303"),
    "acceleration without a period": (lambda: ks.RateLimits.of(PANDA, PANDA.home, acceleration=1.0), "KS354.*period"),
    "rates before without acceleration": (lambda: ks.RateLimits.of(PANDA, PANDA.home, dt=1, previous=PANDA.home), "KS354"),
    "no period": (lambda: ks.RateLimits.of(PANDA, PANDA.home, dt=0.0), "KS353: dt"),
    "a margin wider than the range": (lambda: ks.RateLimits.of(PANDA, PANDA.home, margin=9.0), "KS354.*room"),
    "a negative margin": (lambda: ks.RateLimits.of(PANDA, PANDA.home, margin=-0.1), "KS353: margin"),
    "accelerations of other joints": (lambda: ks.RateLimits.of(PANDA, PANDA.home, dt=1, acceleration=[1, 2]), "KS353"),
    "limits of a name": (lambda: ks.RateLimits.of("panda", PANDA.home), "KS302.*RobotModel"),
    "no tasks": (lambda: ks.prioritized_rates([]), "KS303.*no tasks"),
    "tasks that are no pairs": (lambda: ks.prioritized_rates([J7]), "KS302.*pairs"),
    "tasks of two robots": (lambda: ks.prioritized_rates([(J7, TWIST), (np.ones((1, 2)), [1.0])]), "KS303.*2 joints"),
    "damped tasks with limits": (
        lambda: ks.prioritized_rates([(J7, TWIST)], damping=0.1, limits=([-1] * 7, [1] * 7)),
        "KS351",
    ),
    "a step with an infinite twist": (lambda: ks.RateSolver(PANDA, dt=1).step(PANDA.home, np.full(6, np.inf)), "KS301"),
    "a step with a q of NaN": (lambda: ks.RateSolver(PANDA, dt=1).step(np.full(7, np.nan), np.zeros(6)), "KS301"),
    "a step with two numbers": (lambda: ks.RateSolver(PANDA, dt=1).step(PANDA.home, [1.0, 2.0]), "KS303"),
    "a step with one number": (lambda: ks.RateSolver(PANDA, dt=1).step(PANDA.home, 1.0), "KS303"),
    "a step from six joints": (lambda: ks.RateSolver(PANDA, dt=1).step([0.0] * 6, np.zeros(6)), "KS303"),
    "a solver without a period": (lambda: ks.RateSolver(PANDA, dt=-1), "KS353: dt"),
    "a solver with too little damping": (lambda: ks.RateSolver(PANDA, dt=1, damping=1e-6), "KS353.*at least"),
    "a solver in spatial axes": (lambda: ks.RateSolver(PANDA, dt=1, frame=ks.Frame.spatial()), "KS331"),
    "a reset to nothing": (lambda: ks.RateSolver(PANDA, dt=1).reset([1.0]), "KS303"),
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda name: name.replace(" ", "_"))
def test_mistakes_are_named(mistake):
    """Each is an error of ours with its code and what to do."""
    call, pattern = MISTAKES[mistake]
    with pytest.raises(ks.KinestaticsError, match=re.compile(pattern, re.DOTALL)):
        call()


def test_a_missing_solver_names_the_extra(monkeypatch):
    """Without daqp everything but the programs works, and these say which command installs it."""
    monkeypatch.setitem(sys.modules, "daqp", None)
    limits = ks.RateLimits.of(PANDA, PANDA.home)
    assert ks.joint_rates(J7, TWIST, limits=limits).scale == 1.0
    calls = (
        lambda: ks.joint_rates(J7, TWIST, "qp"),
        lambda: ks.joint_rates(J7, TWIST, "qp", limits=limits, keep_direction=True),
        lambda: ks.prioritized_rates([(J7, TWIST)], limits=limits),
        lambda: ks.RateSolver(PANDA, dt=0.01),
    )
    for call in calls:
        with pytest.raises(ks.MissingExtraError, match=re.compile(r"KS400.*kinestatics\[qp\]", re.DOTALL)):
            call()


def test_what_belongs_to_another_robot_or_is_no_twist_is_refused():
    """Limits and tasks of another robot, a Wrench for a Twist, joints and sides that do not exist: refused with a code."""
    one, other = ks.load("ur5e"), ks.load("irb_140")
    q = one.random_configurations(1, seed=3)[0]
    J, K = ks.jacobian(one, q), ks.jacobian(other, other.home)
    limits, twist = ks.RateLimits.of(one, q), [0.1, 0, 0, 0, 0, 0]
    assert limits.why("elbow_joint", "lower") == limits.why(2, "lower") == "velocity"
    for call, code in (
        (lambda: ks.joint_rates(K, twist, limits=limits), "KS303"),
        (lambda: ks.prioritized_rates([(J, twist), (K, twist)]), "KS303"),
        (lambda: ks.RateSolver(one, dt=0.01).step(q, ks.Wrench.on_robot(force=(0, 0, -10))), "KS302"),
        (lambda: limits.why("elbow", "lower"), "KS313"),
        (lambda: limits.why(9, "upper"), "KS303"),
        (lambda: limits.why(0, "up"), "KS303"),
        (lambda: limits.contains([1.0, 2.0]), "KS303"),
    ):
        with pytest.raises(ks.KinestaticsError, match=code):
            call()
    assert np.all(np.isfinite(ks.joint_rates(J, twist, limits=limits).array))
