"""Statics of the whole arm: payloads, mountings, loads in every form, reactions, capacities, elastic joints, mistakes."""

import json
import pickle
import re
import warnings

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks
from kinestatics.statics import reactions
from strategies import Features, assert_close

jax = pytest.importorskip("jax", reason="a judge of the dev extra")
torch = pytest.importorskip("torch", reason="a judge of the dev extra")
jax.config.update("jax_enable_x64", True)

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*torch.jit.script. is deprecated:DeprecationWarning"
)  # raised inside PyTorch

ARM = ks.load("ur5e")
Q = np.array([0.3, -1.0, 1.2, 0.4, 0.5, 0.6])
LEG = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
WEIGHT = 75 * 9.81
BARE = ks.load("panda")  # no masses are published
SLIDE = ks.from_dh(
    [(0, 0, 0, 0), (0.5, 0, 0, 0)], convention="standard", types="PR", masses=[1, 1], centers_of_mass=[(0, 0, 0)] * 2
)
LOAD = ks.Wrench.on_robot(force=(0, 0, -50), torque=(1, 2, 3))


def standing(degrees):
    """The leg of note 004 with the hip above the ankle, its knee bent by an angle."""
    bend = np.radians(degrees)
    return [np.pi / 2 - bend / 2, bend]


@pytest.mark.parametrize(("bend", "knee"), [(0, 0.0), (10, 27.6), (30, 81.9), (60, 158.2), (90, 223.7)])
def test_standing_leg(bend, knee):
    """Two links of 0.43 m carry 75 kg at the hip: torque of the knee m g L cos θ1, and none in the ankle (note 004)."""
    q = standing(bend)
    torques = ks.holding_torques(LEG, q, ks.Wrench.on_environment(force=(0, WEIGHT, 0)), gravity=None)
    assert torques[1] == pytest.approx(-WEIGHT * 0.43 * np.cos(q[0]), abs=1e-10)
    assert abs(torques[1]) == pytest.approx(knee, abs=0.05)
    assert abs(torques[0]) < 1e-10
    carried = ks.joint_reactions(LEG, q, ks.Wrench.on_robot(force=(0, -WEIGHT, 0)), gravity=None)
    assert_close(carried.torques, torques, 1e-13)
    assert_close(carried.base, [0, WEIGHT, 0, 0, 0, 0], 1e-12)


@pytest.mark.parametrize(("bend", "force"), [(90, 822), (60, 1163), (30, 2246), (10, 6671)])
def test_what_a_knee_can_push(bend, force):
    """A knee of 250 N m: 822 N at 90 degrees, 6.7 kN at 10."""
    push = ks.force_capacity(LEG, standing(bend), (0, 1, 0), gravity=None, effort_limits=(1000, 250))
    assert round(push.value) == force
    assert push.limiting_joint == "joint2"
    assert push.torques[1] == pytest.approx(-250)


def test_straight_leg_is_held_by_its_structure():
    """With the knee straight no joint feels the push: unlimited, and said so; a payload likewise."""
    push = ks.force_capacity(LEG, standing(0), (0, 1, 0), gravity=None, effort_limits=(1000, 250))
    assert push.value == np.inf
    assert push.held_by_structure
    assert push.limiting_joint is None
    assert "unlimited: held by the structure" in str(push)
    hanging = ks.payload_capacity(SLIDE, [0.0, 0.3], gravity=(9.81, 0, 0), effort_limits=(10, 10))
    assert hanging.limiting_joint == "joint2"
    upright = ks.payload_capacity(SLIDE, [0.0, 0.0], gravity=(9.81, 0, 0), effort_limits=(10, 10))
    assert upright.value == np.inf
    assert json.loads(json.dumps(upright.to_dict()))["value"] is None


def test_payload_is_a_link_like_any_other():
    """Gravity, kernels, Jacobians of centres, Evaluator and pickling carry it; nothing of the old model leaks."""
    ks.gravity_torques(ARM, Q)  # fills the caches
    ks.find_task(ARM)
    loaded = ARM.with_payload(5.0, (0, 0, 0.1), np.eye(3) * 0.01)
    assert set(loaded.__dict__) == set(ARM.__dict__) - {key for key in ARM.__dict__ if key not in loaded.__dict__}
    assert not {"_gravity_chains", "_plans", "_samples"} & set(loaded.__dict__)
    expected = ks.gravity_torques(ARM, Q) + ks.joint_torques(
        ks.jacobian(ARM, Q, point=(0, 0, 0.1)),
        ks.Wrench.on_robot(force=(0, 0, -5 * 9.81), frame=ks.jacobian(ARM, Q, point=(0, 0, 0.1)).frame),
    )
    assert_close(ks.gravity_torques(loaded, Q), expected, 1e-13)
    assert_close(ks.Evaluator(loaded).gravity_torques(Q), expected, 1e-13)
    assert_close(ks.gravity_torques(pickle.loads(pickle.dumps(loaded)), Q), expected, 1e-13)
    assert_close(ks.gravity_torques(loaded, torch.tensor(Q)).numpy(), expected, 1e-13)
    assert_close(ks.gravity_torques(loaded, Q, by_link=True)[-1], expected - ks.gravity_torques(ARM, Q), 1e-12)
    assert loaded.tip == ARM.tip
    assert "payload" in ks.com_jacobians(loaded, Q)
    assert_close(ks.pose(loaded, Q, at="payload").array, ks.pose(ARM, Q).array, 1e-15)
    assert ks.center_of_mass(loaded, Q).mass == pytest.approx(ARM.masses.sum() + 5)
    assert len(ARM.link_names) == len(loaded.link_names) - 1  # the old one is as it was
    both = loaded.with_payload(1.0, at="forearm_link", name="camera")
    assert both.link_names[-2:] == ("payload", "camera")


BAD_PAYLOADS = {
    "no mass": ({"mass": 0.0}, "mass is 0"),
    "a negative mass": ({"mass": -1}, "mass is -1"),
    "an infinite mass": ({"mass": np.inf}, "finite"),
    "a mass that is no number": ({"mass": "5"}, "a number"),
    "two masses": ({"mass": [1, 2]}, "a number"),
    "a symbol in a robot of numbers": ({"mass": sp.Symbol("m")}, "symbols only where"),
    "a centre of two": ({"mass": 1, "center": (1, 2)}, "center"),
    "a centre nowhere": ({"mass": 1, "center": (1, 2, np.nan)}, "finite"),
    "an inertia of three": ({"mass": 1, "inertia": (1, 2, 3)}, "inertia"),
    "an inertia that is not symmetric": ({"mass": 1, "inertia": np.triu(np.ones((3, 3)))}, "symmetric"),
    "a negative inertia": ({"mass": 1, "inertia": -np.eye(3)}, "semidefinite"),
    "an inertia of no body": ({"mass": 1, "inertia": np.diag([1, 1, 3])}, "triangle"),
    "a name that is taken": ({"mass": 1, "name": "forearm_link"}, "forearm_link.*payload2"),
    "a reserved name": ({"mass": 1, "name": "tip"}, "cannot be the name"),
    "no name": ({"mass": 1, "name": ""}, "cannot be the name"),
}


@pytest.mark.parametrize("mistake", BAD_PAYLOADS, ids=lambda name: name.replace(" ", "_"))
def test_bad_payloads_are_named(mistake):
    """KS324, with what is wrong."""
    arguments, pattern = BAD_PAYLOADS[mistake]
    with pytest.raises(ks.RobotDefinitionError, match=re.compile(f"KS324.*payload: .*{pattern}", re.DOTALL)):
        ARM.with_payload(**arguments)


def test_payload_on_an_arm_without_masses_is_doubted():
    """Gravity is then that of the payload alone: a warning, and a finding that stays with the model."""
    with pytest.warns(ks.KinestaticsWarning, match=r"KS325.*panda.*payload.*alone"):
        loaded = BARE.with_payload(3.0)
    assert [finding.code for finding in loaded.findings][-1:] == ["KS325"]
    expected = ks.holding_torques(BARE, BARE.home, ks.Wrench.on_robot((0, 0, -3 * 9.81)), gravity=None)
    assert_close(ks.gravity_torques(loaded, BARE.home), expected, 1e-13)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        loaded.with_payload(1.0, name="second")


def test_mountings():
    """Exact for the words; mistakes are named, degrees are doubted."""
    np.testing.assert_array_equal(ks.gravity_in_base(), (0, 0, -9.81))
    np.testing.assert_array_equal(ks.gravity_in_base("ceiling"), (0, 0, 9.81))
    np.testing.assert_array_equal(ks.gravity_in_base("wall"), (9.81, 0, 0))
    np.testing.assert_array_equal(ks.gravity_in_base("wall", 0), (0, 0, 0))
    hanging = ks.gravity_torques(ARM, Q, gravity=ks.gravity_in_base("ceiling"))
    np.testing.assert_allclose(hanging, -ks.gravity_torques(ARM, Q), atol=1e-13)
    with pytest.raises(ks.UnknownNameError, match=r"KS322.*\n.*'ceiling'"):
        ks.gravity_in_base("celing")
    for wrong in (np.eye(3) * 2, np.diag([1, 1, -1]), np.full((3, 3), 1e300), (1, 2), None, (0, np.nan, 0), b"abc"):
        with pytest.raises(ks.ConfigurationError, match="KS303"):
            ks.gravity_in_base(wrong)
    for wrong in (-1, np.inf, "g"):
        with pytest.raises(ks.ConfigurationError, match=r"KS303.*magnitude"):
            ks.gravity_in_base("floor", wrong)
    with pytest.warns(ks.KinestaticsWarning, match="KS321.*degrees"):
        ks.gravity_in_base((0, 90, 0))


def test_loads_in_every_form():
    """A wrench at the tip, a mapping, lists and pairs say the same; analyze agrees on the frame that is meant."""
    J = ks.jacobian(ARM, Q)
    expected = ks.joint_torques(J, ks.Wrench(LOAD.array, J.frame, "robot"))
    forms = [LOAD, {"tip": LOAD}, {"tool0": [LOAD]}, [("tip", LOAD)], (["tool0", LOAD],)]
    for form in forms:
        assert_close(ks.holding_torques(ARM, Q, form, gravity=None), expected, 1e-15)
    twice = ks.holding_torques(ARM, Q, {"tip": [LOAD, LOAD]}, gravity=None)
    assert_close(twice, 2 * expected, 1e-15)
    assert_close(ks.holding_torques(ARM, Q, LOAD), expected + ks.gravity_torques(ARM, Q), 1e-13)
    assert_close(ks.analyze(ARM, Q, LOAD).joint_torques, expected, 1e-15)
    np.testing.assert_array_equal(ks.holding_torques(ARM, Q, gravity=None), np.zeros(6))
    np.testing.assert_array_equal(ks.holding_torques(ARM, Q, []), ks.gravity_torques(ARM, Q))


def test_default_frame_is_at_the_link_it_acts_on():
    """Base axes, at the origin of that link and its offset; any other frame is taken as it says."""
    wrench = ks.Wrench.on_robot((1, 2, 3), (4, 5, 6), ks.Frame(offset=(0.1, 0.2, 0.3)))
    J = ks.jacobian(ARM, Q, at="forearm_link", point=(0.1, 0.2, 0.3))
    expected = ks.joint_torques(J, ks.Wrench(wrench.array, J.frame, "robot"))
    assert_close(ks.holding_torques(ARM, Q, {"forearm_link": wrench}, gravity=None), expected, 1e-15)
    elsewhere = ks.Frame("wrist_1_link", "base", (0.0, 0.0, 1.0))
    J = ks.jacobian(ARM, Q, at="forearm_link", frame=elsewhere)
    expected = ks.joint_torques(J, ks.Wrench(wrench.array, J.frame, "environment"))
    push = ks.Wrench.on_environment((1, 2, 3), (4, 5, 6), elsewhere)
    assert_close(ks.holding_torques(ARM, Q, {"forearm_link": push}, gravity=None), expected, 1e-15)
    assert_close(ks.joint_reactions(ARM, Q, {"forearm_link": push}, gravity=None).torques, expected, 1e-13)
    np.testing.assert_array_equal(ks.holding_torques(ARM, Q, {"base": LOAD}, gravity=None), np.zeros(6))


MISTAKES = {
    "loads of a name": (lambda: ks.holding_torques("ur5e", Q), "KS302.*RobotModel"),
    "reactions of a name": (lambda: ks.joint_reactions("ur5e", Q), "KS302.*RobotModel"),
    "capacity of a name": (lambda: ks.payload_capacity("ur5e", Q), "KS302.*RobotModel"),
    "mass matrix of a name": (lambda: ks.mass_matrix("ur5e", Q), "KS302.*RobotModel"),
    "a bare wrench": (lambda: ks.holding_torques(ARM, Q, [0, 0, -9.81, 0, 0, 0]), r"KS302.*\(link, wrench\)"),
    "wrenches without links": (lambda: ks.holding_torques(ARM, Q, [[LOAD]]), r"KS302.*\(link, wrench\)"),
    "a number on a link": (lambda: ks.holding_torques(ARM, Q, {"tip": 3.0}), "KS302.*load on 'tip'"),
    "a force for a wrench": (lambda: ks.holding_torques(ARM, Q, {"tip": [(0, 0, 1)]}), r"KS302.*Wrench\.on_robot"),
    "a link that is not there": (lambda: ks.holding_torques(ARM, Q, {"forearm": LOAD}), "KS310.*forearm_link"),
    "a frame that is not there": (
        lambda: ks.joint_reactions(ARM, Q, ks.Wrench.on_robot((0, 0, 1), frame=ks.Frame("hand", "tip"))),
        "KS310.*hand",
    ),
    "torques of a force of NaN": (
        lambda: ks.joint_torques(ks.jacobian(ARM, Q), ks.Wrench.on_robot((0, 0, np.nan))),
        r"KS301: the wrench is not finite: fz is nan.*0 where there is no force.*twists",
    ),
    "torques of one moment among many": (
        lambda: ks.joint_torques(ks.jacobian(ARM, Q), ks.Wrench.on_robot(torque=[[0, 0, 1], [0, -np.inf, 0]])),
        r"KS301.*my of wrench \[1\] is -inf",
    ),
    "a push of NaN in single precision": (
        lambda: ks.joint_torques(
            ks.jacobian(ARM, Q), ks.Wrench(np.full(6, np.nan, dtype=np.float32), ks.Frame(), "environment")
        ),
        "KS301.*fx is nan",
    ),
    "a load beyond all numbers": (
        lambda: ks.holding_torques(ARM, Q, ks.Wrench.on_robot((0, 1e200, 0))),
        r"KS301.*load on 'tip'.*fy is 1e\+200.*below 1e\+150",
    ),
    "a load that is not finite": (lambda: ks.holding_torques(ARM, Q, ks.Wrench.on_robot((0, 0, np.nan))), "KS301.*load on"),
    "batches that do not fit": (
        lambda: ks.holding_torques(ARM, np.zeros((2, 6)), ks.Wrench.on_robot(np.zeros((3, 3)))),
        "KS303",
    ),
    "reactions of batches that do not fit": (
        lambda: ks.joint_reactions(ARM, np.zeros((2, 6)), ks.Wrench.on_robot(np.zeros((3, 3)))),
        "KS303",
    ),
    "two libraries": (
        lambda: ks.holding_torques(ARM, jax.numpy.asarray(Q), ks.Wrench.on_robot(torch.tensor([0.0, 0, 1]))),
        "KS302.*jax.*torch",
    ),
    "no masses": (lambda: ks.holding_torques(BARE, BARE.home, LOAD), "KS320.*gravity=None"),
    "reactions without masses": (lambda: ks.joint_reactions(BARE, BARE.home, LOAD), "KS320.*gravity=None"),
    "energy without masses": (lambda: ks.potential_energy(BARE, BARE.home), "KS320"),
    "centre without masses": (lambda: ks.center_of_mass(BARE, BARE.home), "KS320"),
    "inertia without masses": (lambda: ks.mass_matrix(BARE, BARE.home), "KS320"),
    "capacity without masses": (lambda: ks.payload_capacity(BARE, BARE.home), "KS320.*gravity=None"),
    "force without masses": (lambda: ks.force_capacity(BARE, BARE.home, (0, 0, 1)), "KS320.*gravity=None"),
    "axes of another name": (lambda: ks.joint_reactions(ARM, Q, axes="joints"), "KS328.*'joint'"),
    "a joint that is not there": (lambda: ks.joint_reactions(ARM, Q).wrench("elbow"), "KS313.*elbow_joint"),
    "no effort limits": (lambda: ks.force_capacity(LEG, [0.3, 0.4], (0, 1, 0), gravity=None), "KS323.*effort_limits="),
    "too few limits": (lambda: ks.payload_capacity(ARM, Q, effort_limits=(1, 2)), "KS303.*6 numbers"),
    "negative limits": (lambda: ks.payload_capacity(ARM, Q, effort_limits=[-1] * 6), "KS303.*zero or more"),
    "limits that are no numbers": (lambda: ks.payload_capacity(ARM, Q, effort_limits="high"), "KS303"),
    "one limit": (lambda: ks.payload_capacity(ARM, Q, effort_limits=5), "KS303"),
    "a limit of no joint": (lambda: ks.payload_capacity(ARM, Q, effort_limits={"elbow": 5}), "KS313.*elbow_joint"),
    "a direction without length": (lambda: ks.force_capacity(ARM, Q, (0, 0, 0)), "KS303.*no length"),
    "a direction of four": (lambda: ks.force_capacity(ARM, Q, (0, 0, 0, 1)), "KS303.*3 or 6"),
    "a direction nowhere": (lambda: ks.force_capacity(ARM, Q, (0, 0, np.inf)), "KS303.*finite"),
    "directions that do not fit": (lambda: ks.force_capacity(ARM, np.zeros((2, 6)), np.ones((3, 3))), "KS303"),
    "a direction of symbols": (lambda: ks.force_capacity(ARM, Q, (0, 0, sp.Symbol("x"))), "KS302"),
    "capacity at symbols": (lambda: ks.payload_capacity(ARM, sp.symbols("q1:7")), "KS302.*NumPy"),
    "capacity of a tensor": (lambda: ks.payload_capacity(ARM, torch.tensor(Q)), r"KS302.*np\.asarray"),
    "capacity in symbolic gravity": (lambda: ks.payload_capacity(ARM, Q, gravity=(0, 0, sp.Symbol("g"))), "KS302"),
    "too few stiffnesses": (lambda: ks.tip_compliance(ks.jacobian(ARM, Q), (1, 2)), "KS303.*stiffness"),
    "a stiffness of zero": (lambda: ks.tip_compliance(ks.jacobian(ARM, Q), [1, 1, 1, 1, 1, 0]), "KS326.*positive"),
    "no Jacobian": (lambda: ks.tip_compliance(np.zeros((3, 2)), (1, 2)), r"KS303.*\(\.\.\., 6, n\)"),
    "stiffness of a batch": (lambda: ks.tip_stiffness(ks.jacobian(ARM, [Q, Q]), [1] * 6), "KS303.*one numeric"),
    "a preload without Hessian": (
        lambda: ks.tip_compliance(ks.jacobian(ARM, Q), [1] * 6, wrench=LOAD),
        r"KS302.*ks\.hessian",
    ),
    "a Hessian in another frame": (
        lambda: ks.tip_compliance(
            ks.jacobian(ARM, Q), [1] * 6, wrench=LOAD, hessian=ks.hessian(ARM, Q, frame=ks.Frame.body())
        ),
        "KS330.*Hessian",
    ),
    "a preload in another frame": (
        lambda: ks.tip_compliance(
            ks.jacobian(ARM, Q),
            [1] * 6,
            wrench=ks.Wrench.on_robot((0, 0, 1), frame=ks.Frame.body()),
            hessian=ks.hessian(ARM, Q),
        ),
        "KS330",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda name: name.replace(" ", "_"))
def test_a_mistake_is_named(mistake):
    """A code, what is wrong, and the remedy."""
    call, pattern = MISTAKES[mistake]
    with pytest.raises(ks.KinestaticsError, match=re.compile(pattern, re.DOTALL)):
        call()


def test_reactions_are_printed_as_tables():
    """Each joint and the ground, what a bearing bears, how well it balances; in 80 columns; JSON as well."""
    r = ks.joint_reactions(ARM, Q, LOAD)
    text = str(r)
    assert all(name in text for name in (*ARM.joint_names, "ground", "bending", "drive"))
    assert max(len(line) for line in text.splitlines()) <= 80
    stored = json.loads(json.dumps(r.to_dict()))
    assert_close(stored["wrenches"], r.wrenches, 1e-15)
    assert "batch of shape (2,)" in str(ks.joint_reactions(ARM, [Q, Q]))
    with pytest.raises(AttributeError):
        r.base = 0
    still = ks.from_dh([], convention="standard")
    standing_still = ks.joint_reactions(still, np.zeros((3, 0)), LOAD, gravity=None)
    assert standing_still.wrenches.shape == (3, 0, 6)
    assert_close(standing_still.base, [[0, 0, 50, -1, -2, -3]] * 3, 1e-15)
    assert "ground" in str(ks.joint_reactions(still, np.zeros(0), LOAD, gravity=None))


def test_a_wrong_balance_is_found(monkeypatch):
    """The residual is no formality: one newton too many in the ground, or in a joint, shows."""
    right = reactions._balanced

    def tampered(where):
        def balanced(*arguments):
            through, base = right(*arguments)
            if where == "ground":
                return through, base + np.eye(6)[0]
            return [*through[:2], through[2] + np.eye(6)[4], *through[3:]], base

        return balanced

    for where in ("ground", "joint"):
        monkeypatch.setattr(reactions, "_balanced", tampered(where))
        r = ks.joint_reactions(ARM, Q, LOAD)
        assert r.residual >= 0.99
        assert r.relative_residual > 1e-4


def test_weights_of_a_cantilever():
    """Two links of 1 m and 1 kg, held out level across their axes: by hand, 2 kg at 1 m bend the first bearing."""
    r = ks.joint_reactions(ks.load("planar_2r"), [0.0, 0.0], gravity=(0, 0, -10))
    assert_close(r.bending, [20.0, 5.0], 1e-14)
    assert_close(r.axial, [20.0, 10.0], 1e-14)
    assert_close(r.radial, [0.0, 0.0], 1e-14)
    assert_close(r.torques, [0.0, 0.0], 1e-14)
    assert_close(r.base, [0, 0, 20, 0, -20, 0], 1e-14)


def test_a_sliding_joint():
    """A vertical slide carries both links: its drive is a force, its guide bears the arm's moment; the hinge lies level."""
    r = ks.joint_reactions(SLIDE, [0.2, 0.0], {"tip": ks.Wrench.on_robot((0, -3, 0))}, gravity=(0, 0, -10))
    assert_close(r.drive, [20.0, 1.5], 1e-14)
    assert_close(r.axial, [20.0, 10.0], 1e-14)
    assert_close(r.torsion, [1.5, 1.5], 1e-14)
    assert_close(r.radial, [3.0, 3.0], 1e-14)
    assert_close(r.bending, [5.0, 5.0], 1e-14)


def test_mimic_followers_have_reactions_of_their_own():
    """Every moving joint is there; their drives fold into the torque of the joint that leads."""
    model = Features(seed=4, joints=5, tree=True, mimic=True).model()
    assert len(model.moving_names) > model.n
    r = ks.joint_reactions(model, np.full(model.n, 0.3))
    assert r.joints == model.moving_names
    assert_close(model.folding.T @ r.drive, r.torques, 1e-14)
    assert_close(r.torques, ks.holding_torques(model, np.full(model.n, 0.3)), 1e-12)


def test_libraries_agree():
    """JAX under jit and vmap, and PyTorch, give the numbers of NumPy, batches of q against batches of loads included."""
    model = Features(seed=4, joints=3, tree=True, mimic=True).model()
    q = np.random.default_rng(0).normal(size=(3, model.n))
    loads = {"tip": LOAD, "l2": ks.Wrench.on_environment((1, 2, 3), frame=ks.Frame.body())}

    def questions(x):
        return (
            ks.joint_reactions(model, x, loads).wrenches,
            ks.holding_torques(model, x, loads),
            ks.mass_matrix(model, x),
            ks.potential_energy(model, x, by_link=True),
            ks.center_of_mass(model, x, moving=True).point,
            ks.tip_compliance(ks.jacobian(model, x), np.arange(1.0, model.n + 1)),
        )

    expected, on_jax = questions(q), jax.numpy.asarray(q)
    for found in (jax.vmap(jax.jit(questions))(on_jax), questions(torch.tensor(q))):
        for one, other in zip(found, expected, strict=True):
            assert_close(one, other, 1e-13)
    forces = np.random.default_rng(1).normal(size=(3, 3))

    def torques(force):
        return ks.holding_torques(model, q, {"tip": ks.Wrench.on_robot(force)})

    assert_close(jax.jit(torques)(jax.numpy.asarray(forces)), torques(forces), 1e-13)
    found = ks.joint_reactions(model, q[0], {"tip": ks.Wrench.on_robot(torch.tensor(forces))})
    assert_close(found.torques.numpy(), ks.holding_torques(model, q[0], {"tip": ks.Wrench.on_robot(forces)}), 1e-13)
    assert found.residual.shape == (3,)


def test_symbols():
    """The planar arm by hand: reactions in the axes of the links, torques, inertia and compliance as formulas."""
    length, mass, g, F, q1, q2, k1, k2, p = sp.symbols("l m g F q1 q2 k1 k2 p", positive=True)
    rows, centers = [(length, 0, 0, 0)] * 2, [(-length / 2, 0, 0)] * 2
    arm = ks.from_dh(rows, convention="standard", masses=[mass] * 2, centers_of_mass=centers)
    pulled = ks.Wrench.on_robot((0, -F, 0))
    r = ks.joint_reactions(arm, [q1, q2], pulled, gravity=(0, -g, 0))
    knee = length * (F + mass * g / 2) * sp.cos(q1 + q2)
    assert sp.simplify(r.torques[1] - knee) == 0
    assert sp.simplify(r.torques[0] - knee - length * (F + 3 * mass * g / 2) * sp.cos(q1)) == 0
    assert sp.simplify(r.wrench("joint2")[0] - (F + mass * g) * sp.sin(q1 + q2)) == 0
    somewhere = {q1: 0.3, q2: -0.7, length: 1.1, mass: 2, g: 9.81, F: 7}
    assert all(abs(float(x.subs(somewhere))) < 1e-12 for x in r.imbalance.ravel())
    assert all(sp.simplify(x) == 0 for x in r.imbalance[0])
    assert all(
        sp.simplify(a - b) == 0
        for a, b in zip(r.torques, ks.holding_torques(arm, [q1, q2], pulled, gravity=(0, -g, 0)), strict=True)
    )
    assert r.residual is None
    assert "symbols" in str(r)
    assert r.to_dict()["torques"] == [str(x) for x in r.torques]
    M = ks.mass_matrix(arm, [q1, q2])
    assert sp.simplify(M[0, 1] - mass * length**2 * (1 + 2 * sp.cos(q2)) / 4) == 0
    energy = ks.potential_energy(arm, [q1, q2], gravity=(0, -g, 0))
    assert all(
        sp.simplify(sp.diff(energy, q) - t) == 0
        for q, t in zip((q1, q2), ks.gravity_torques(arm, [q1, q2], gravity=(0, -g, 0)), strict=True)
    )
    C = ks.tip_compliance(ks.jacobian(arm, [q1, q2]), [k1, k2])
    assert sp.simplify(C[5, 5] - 1 / k1 - 1 / k2) == 0
    rigid = ks.tip_compliance(ks.jacobian(arm, [q1, q2]), [k1, sp.oo])
    assert sp.simplify(rigid[5, 5] - 1 / k1) == 0
    loaded = arm.with_payload(p, (-length, 0, 0))
    added = ks.gravity_torques(loaded, [q1, q2], gravity=(0, -g, 0)) - ks.gravity_torques(arm, [q1, q2], gravity=(0, -g, 0))
    assert sp.simplify(added[0] - p * g * length * sp.cos(q1)) == 0
    assert sp.simplify(added[1]) == 0
    numbers = ks.gravity_torques(ks.load("planar_2r"), [0.0, 0.0], gravity=(0, -g, 0))
    assert numbers[1] == 0.5 * g


def test_an_arm_that_cannot_hold_itself():
    """0, the joint that fails and by how much; in a batch the others keep their value."""
    heavy = ARM.with_payload(50.0)
    stretched, folded = np.zeros(6), np.array([0, -np.pi / 2, 0, -np.pi / 2, 0, 0])
    one = ks.payload_capacity(heavy, stretched)
    assert (one.value, one.limiting_joint, one.holds_itself) == (0.0, "shoulder_lift_joint", False)
    shares = np.abs(ks.gravity_torques(heavy, stretched)) / ARM.effort_limits
    assert one.margin == pytest.approx(1 - shares.max())
    assert "cannot hold its own weight" in str(one)
    assert "3.07 times its effort limit" in str(one)
    both = ks.force_capacity(heavy, [stretched, folded], (0, 0, 1))
    np.testing.assert_array_equal(both.holds_itself, [False, True])
    assert both.value[0] == 0
    assert both.value[1] > 0
    assert "1 of 2 configurations" in str(both)
    json.dumps(both.to_dict())
    powerless = ks.payload_capacity(ARM, stretched, effort_limits=np.zeros(6))
    assert powerless.value == 0
    assert powerless.margin == -np.inf
    assert powerless.limiting_joint == "shoulder_lift_joint"
    assert "an effort limit of 0" in str(powerless)


def test_limits_that_are_unknown():
    """A joint without limit is taken to hold, and named; where none that feels it has one the value is NaN, or an error."""
    q = standing(60)
    push = ks.force_capacity(LEG, q, (0, 1, 0), gravity=None, effort_limits={"joint2": 250.0})
    assert push.value == pytest.approx(250 / abs(ks.jacobian(LEG, q).linear[1, 1]))
    sideways = ks.force_capacity(LEG, q, (1, 0, 0), gravity=None, effort_limits={"joint2": 250.0})
    assert "unknown, and taken to suffice, for: joint1" in " ".join(sideways.notes)
    postures = [standing(0), [0.0, np.pi / 2], q]  # no joint feels a push along y; the first alone; the second alone
    batch = ks.force_capacity(LEG, postures, (0, 1, 0), gravity=None, effort_limits={"joint2": 250.0})
    np.testing.assert_array_equal(batch.value, [np.inf, np.nan, push.value])
    assert batch.limiting_joint == [None, None, "joint2"]
    np.testing.assert_array_equal(batch.held_by_structure, [True, False, False])
    assert any("NaN" in note for note in batch.notes)
    assert batch.to_dict()["value"][:2] == [None, None]
    with pytest.raises(ks.ConfigurationError, match="KS323"):
        ks.force_capacity(LEG, postures[:2], (0, 1, 0), gravity=None, effort_limits={"joint2": 250.0})


def test_capacity_batches():
    """Directions in batches against one configuration, configurations against one direction, both at once."""
    directions = np.eye(3)
    one = ks.force_capacity(ARM, Q, directions)
    assert_close(one.value, [ks.force_capacity(ARM, Q, d).value for d in directions], 1e-14)
    many = ARM.random_configurations(3, seed=0)
    both = ks.force_capacity(ARM, many, directions)
    assert_close(both.value, [ks.force_capacity(ARM, q, d).value for q, d in zip(many, directions, strict=True)], 1e-14)
    assert both.torques.shape == (3, 6)
    grid = ks.force_capacity(ARM, many[:, None], directions[None])
    assert grid.value.shape == (3, 3)
    assert len(grid.limiting_joint) == 3
    assert isinstance(ks.payload_capacity(ARM, Q).value, float)
    longer = ks.force_capacity(ARM, Q, (0, 0, 1e200)).value
    assert longer == ks.force_capacity(ARM, Q, (0, 0, 1e-200)).value == pytest.approx(one.value[2])
    wrench = ks.force_capacity(ARM, Q, (0, 0, 10, 0, 0, 0))
    assert 10 * wrench.value == pytest.approx(one.value[2])
    assert "times the wrench" in str(wrench)
    still = ks.from_dh([], convention="standard")
    assert ks.force_capacity(still, np.zeros(0), (0, 0, 1), gravity=None).value == np.inf


def test_a_link_that_no_motor_moves_holds_anything():
    """On the base, or where the only axis stands along the load, rounding is not a torque."""
    assert ks.payload_capacity(ARM, Q, at="base").held_by_structure
    up = ks.force_capacity(ARM, Q, (0, 0, 1), at=ARM.link_names[ARM.link_joints.index(0)])
    assert up.value == np.inf


def test_stiffness_in_numbers():
    """A planar arm stretched out: 1/k adds along the lever arms; what no joint moves is rigid; a rigid joint too."""
    J = ks.jacobian(ks.load("planar_2r"), [0.0, 0.0])
    C = ks.tip_compliance(J, (1000.0, 500.0))
    assert C[1, 1] == pytest.approx(4 / 1000 + 1 / 500)
    s = ks.tip_stiffness(J, (1000.0, np.inf))
    assert s.rank == 1
    assert s.rigid.shape == (5, 6)
    assert C.shape == (6, 6)
    assert "rigid directions (infinite stiffness), 5 of 6" in str(s)
    assert max(len(line) for line in str(s).splitlines()) <= 80
    assert json.loads(json.dumps(s.to_dict()))["rank"] == 1
    batch = ks.tip_compliance(ks.jacobian(ARM, [Q, Q]), np.full(6, 1e4))
    assert batch.shape == (2, 6, 6)
    bare = ks.tip_compliance(ks.jacobian(ARM, Q).array, np.full(6, 1e4))
    assert_close(batch[0], bare, 1e-15)
    none = ks.tip_stiffness(J, (np.inf, np.inf))
    assert none.rank == 0
    np.testing.assert_array_equal(none.matrix, np.zeros((6, 6)))


def test_a_column_buckles():
    """A straight leg on an elastic knee holds k / L from above and no more (Euler's rigid column): KS327 names the share."""
    q = [np.pi / 2, 0.0]
    J, H = ks.jacobian(LEG, q), ks.hessian(LEG, q)
    stiffness = (np.inf, 1000.0)  # the knee, with the shank held
    critical = 1000.0 / 0.43
    light = ks.Wrench.on_robot((0, -0.5 * critical, 0), frame=J.frame)
    C = ks.tip_compliance(J, stiffness, wrench=light, hessian=H)
    assert C[0, 0] == pytest.approx(2 * 0.43**2 / 1000)  # half the critical load makes it twice as soft
    heavy = ks.Wrench.on_robot((0, -1.25 * critical, 0), frame=J.frame)
    for ask in (ks.tip_compliance, ks.tip_stiffness):
        with pytest.raises(ks.ConfigurationError, match=r"KS327.*0\.8 of it"):
            ask(J, stiffness, wrench=heavy, hessian=H)
    pulled = ks.Wrench.on_robot((0, critical, 0), frame=J.frame)
    assert ks.tip_compliance(J, stiffness, wrench=pulled, hessian=H)[0, 0] == pytest.approx(0.43**2 / 2000)
    x = torch.tensor(np.array(q))
    on_torch = ks.tip_compliance(ks.jacobian(LEG, x), stiffness, wrench=light, hessian=ks.hessian(LEG, x))
    assert_close(on_torch.numpy(), C, 1e-12)


def test_center_of_mass_of_what_moves():
    """Links that stand still count, unless they are not asked for."""
    arm = ARM.with_payload(100.0, (1, 2, 3), at="base", name="pedestal")
    point, mass = ks.center_of_mass(arm, Q)
    moving, less = ks.center_of_mass(arm, Q, moving=True)
    assert mass - less >= 100.0
    assert_close(mass * point - less * moving, (mass - less) * np.array([1, 2, 3]), 2.0)
    assert ks.center_of_mass(arm, [Q, Q]).point.shape == (2, 3)
    still = LEG
    with pytest.warns(ks.KinestaticsWarning, match="KS325"):
        still = still.with_payload(1.0, at="base")
    with pytest.raises(ks.ConfigurationError, match=r"KS303.*\n.*moving=False"):
        ks.center_of_mass(still, [0, 0], moving=True)
    np.testing.assert_array_equal(ks.mass_matrix(still, [0, 0]), np.zeros((2, 2)))


def test_capacities_of_what_is_not_finite_are_nan():
    """check_finite=False lets NaN through, and it stays NaN: no unlimited payload, no joint named."""
    arm = ks.load("ur5e")
    q = np.array([np.full(6, np.nan), arm.home])
    payload = ks.payload_capacity(arm, q, check_finite=False)
    push = ks.force_capacity(arm, q, (0, 0, 1), check_finite=False)
    for found in (payload, push):
        assert np.isnan(found.value).tolist() == [True, False]
        assert found.limiting_joint[0] is None
        assert found.holds_itself.tolist() == [False, True]
        assert not np.any(found.held_by_structure)
    assert "unknown" in str(ks.payload_capacity(arm, q[0], check_finite=False))


def test_several_wrenches_at_the_tip():
    """A list of wrenches acts at the tip, like one wrench of their sum."""
    assert_close(ks.holding_torques(ARM, Q, [LOAD, LOAD]), ks.holding_torques(ARM, Q, LOAD * 2.0), 1e-12)


def test_a_wrench_without_numbers_is_not_looked_at():
    """Only numbers of NumPy are: under jit there are none yet, symbols are what they are, and nothing is nothing."""
    J = ks.jacobian(ARM, Q)
    torques = jax.jit(lambda f: ks.joint_torques(J, ks.Wrench.on_robot(force=f)))
    assert np.all(np.isnan(torques(jax.numpy.full(3, np.nan))[:3]))
    assert_close(torques(jax.numpy.array([0.0, 0, 1])), ks.joint_torques(J, ks.Wrench.on_robot((0, 0, 1))), 1e-14)
    assert len(ks.joint_torques(J, ks.Wrench.on_robot(force=(0, 0, sp.Symbol("f"))))) == 6
    assert ks.joint_torques(J, ks.Wrench.on_robot(np.zeros((0, 3)))).shape == (0, 6)
    assert np.isnan(ks.Wrench.on_robot((0, 0, np.nan)).force[2])  # made, as an estimate may be, but not held
