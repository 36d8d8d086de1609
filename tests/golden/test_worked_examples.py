"""Every worked example of the lecture notes, through the public functions.

Most are computed at symbols and compared with the recomputed answer in worked_examples.json at three sets of random numbers.
Identities are held as laws on random arms; an answer that is a set, a basis or a word has a test of its own. Where the notes
err (docs/errata.md; `errata` in the same file), the right answer is the one that counts.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, strategies as st

import kinestatics as ks
from strategies import assert_close, features, random_pose, random_screw

DATA = json.loads((Path(__file__).parent / "worked_examples.json").read_text(encoding="utf-8"))
EXAMPLES = {example["id"]: example for example in DATA["examples"]}

a1, a2, l1, l2, L, L1, L2, d1, d3, q3 = sp.symbols("a1 a2 l1 l2 L L1 L2 d1 d3 q3")
t1, t2, u1, u2, w1, w2 = sp.symbols("theta1 theta2 thetadot1 thetadot2 thetaddot1 thetaddot2")
fx, fy, m1, m2, m, g = sp.symbols("F_x F_y m1 m2 m g")
half_pi = sp.pi / 2


def planar(first, second, **masses):
    return ks.from_dh([(first, 0, 0, 0), (second, 0, 0, 0)], convention="standard", **masses)


def spherical():
    """Note 000: rotation about z, rotation about y, extension along x of the second link."""
    return ks.from_dh([(0, -half_pi, d1, 0), (0, half_pi, 0, half_pi), (0, 0, 0, 0)], convention="standard", types="RRP")


def rrp():
    """Note 001: standard DH (a, alpha, d) = (0, -pi/2, 3), (0, -pi/2, 0), (0, 0, q3)."""
    return ks.from_dh([(0, -half_pi, 3, 0), (0, -half_pi, 0, 0), (0, 0, 0, 0)], convention="standard", types="RRP")


def J_of(arm, q, **where):
    return ks.jacobian(arm, np.array(q, dtype=object), **where)


def exact(*values):
    return np.array([sp.sympify(value) for value in values], dtype=object)


def three_joint(lengths):
    """Note 003, at theta = 0: three screws and the home pose, at numbers (from_screws takes no symbols)."""
    first, second = lengths
    axes = [ks.screw_axis((0, 0, 1)), ks.screw_axis((0, -1, 0), (first, 0, 0)), ks.screw_axis((1, 0, 0), (0, 0, -second))]
    return ks.from_screws(axes, [[0, 0, 1, first], [0, 1, 0, 0], [-1, 0, 0, -second], [0, 0, 0, 1]], order="linear-angular")


def torque(J, wrench):
    return ks.joint_torques(J, wrench)


def push(x, y, z=0):
    return ks.Wrench.on_environment(force=exact(x, y, z), torque=exact(0, 0, 0))


def masses_2r():
    halves = [(-a1 / 2, 0, 0), (-a2 / 2, 0, 0)]
    return planar(a1, a2, masses=exact(m1, m2), centers_of_mass=[np.array(h, dtype=object) for h in halves])


def by_gravity(q):
    """Note 000's torque produced BY gravity: the negative of what holds the arm."""
    return -ks.gravity_torques(masses_2r(), exact(*q), gravity=exact(0, -g, 0))


def accelerated():
    A = ks.acceleration(planar(l1, l2), exact(t1, t2), exact(u1, u2), exact(w1, w2))
    return A.linear[:2]


def speeds(x, y):
    """Note 004: the joint rates of two links of 1 m near the stretched posture for a tip velocity in the plane."""
    free = float("nan")
    J = ks.jacobian(planar(1.0, 1.0), [0, 0.01])
    return ks.joint_rates(J, ks.Twist.of(linear=(x, y, free), angular=(free, free, free))).array


def squared(J):
    """J_v J_vᵀ, the matrix of the velocity ellipsoid."""
    return J.linear @ J.linear.T


def turned():
    """Note 002: the frame c of the data file, seen from b."""
    inputs = EXAMPLES["002.wrench_transform"]["inputs"]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = inputs["R_bc"], inputs["p_bc"]
    return T, inputs["F_b (f,tau)"]


def transformed():
    T_b_c, w = turned()
    return ks.Wrench.on_environment(w[:3], w[3:], frame=ks.Frame("b", "b")).change_frame(ks.Frame("c", "c"), T_b_c).array


def warm_up():
    """Note 002: the twist (-1, 0, 0, 0, 0, 1); of the wrench only F·V = 0 survived: any with f_x = τ_z."""
    V = EXAMPLES["002.power"]["inputs"]["V"]
    wrench = ks.Wrench.on_environment(exact(m1, fy, m2), exact(fx, m, m1))
    return ks.power(wrench, ks.Twist.of(exact(*V[:3]), exact(*V[3:])))


rrp_at = [0, -half_pi, 2]
down = ks.Wrench.on_robot(force=(0, 0, -100))
COMPUTED = {
    "000.planar.Jv": lambda: J_of(planar(a1, a2), [t1, t2]).linear[:2],
    "000.planar.det": lambda: sp.Matrix(J_of(planar(a1, a2), [t1, t2]).linear[:2]).det(),
    "000.planar.rank": lambda: ks.find_task(planar(0.7, 0.4), "position").rank,
    "000.planar.mu": lambda: ks.manipulability(J_of(planar(a1, a2), [t1, t2]).linear[:2]),
    "000.planar.Jv_0_90": lambda: J_of(planar(a1, a2), exact(0, half_pi)).linear,
    "000.planar.vel_0_90": lambda: (J_of(planar(a1, a2), exact(0, half_pi)) @ exact(u1, u2)).linear,
    "000.planar.Jv_0_0": lambda: J_of(planar(a1, a2), exact(0, 0)).linear,
    "000.planar.vel_0_0": lambda: (J_of(planar(a1, a2), exact(0, 0)) @ exact(u1, u2)).linear,
    "000.planar.statics": lambda: torque(J_of(planar(a1, a2), [t1, t2]), push(fx, fy)),
    "000.planar.tau_0_90": lambda: torque(J_of(planar(a1, a2), exact(0, half_pi)), push(fx, fy)),
    "000.planar.tau_0_0": lambda: torque(J_of(planar(a1, a2), exact(0, 0)), push(fx, fy)),
    "000.spherical.fk": lambda: ks.pose(spherical(), exact(t1, t2, d3)).translation,
    "000.spherical.Jv": lambda: J_of(spherical(), [t1, t2, d3]).linear,
    "000.spherical.Jw": lambda: J_of(spherical(), [t1, t2, d3]).angular,
    "000.spherical.det": lambda: sp.Matrix(J_of(spherical(), [t1, t2, d3]).linear).det(),
    "000.spherical.Jv_num": lambda: J_of(spherical(), exact(sp.pi / 4, 0, 1)).linear,
    "000.spherical.tau": lambda: torque(J_of(spherical(), exact(sp.pi / 4, 0, 1)), push(0, 2, 2)),
    "000.spherical.ellipsoid": lambda: squared(J_of(spherical(), exact(0, 0, d3))),
    "000.gravity.J1": lambda: ks.com_jacobians(masses_2r(), exact(t1, t2))["link1"],
    "000.gravity.J2": lambda: ks.com_jacobians(masses_2r(), exact(t1, t2))["link2"],
    "000.gravity.tau": lambda: by_gravity([t1, t2]),
    "000.gravity.tau_0_90": lambda: by_gravity([0, half_pi]),
    "000.gravity.tau_0_0": lambda: by_gravity([0, 0]),
    "000.gravity.comp": lambda: -by_gravity([t1, t2]),
    "001.T1": lambda: ks.pose(rrp(), exact(t1, t2, q3), at="link1").array,
    "001.T2": lambda: ks.pose(rrp(), exact(t1, t2, q3), at="link2").array,
    "001.T3": lambda: ks.pose(rrp(), exact(t1, t2, q3), at="link3").array,
    "001.Jw": lambda: J_of(rrp(), [t1, t2, q3]).angular,
    "001.Jv": lambda: J_of(rrp(), [t1, t2, q3]).linear,
    "001.detJv": lambda: sp.Matrix(J_of(rrp(), [t1, t2, q3]).linear).det(),
    "001.omega": lambda: (J_of(rrp(), exact(0, -half_pi, 5)) @ exact(2, 1, 0)).angular,
    "001.v": lambda: (J_of(rrp(), exact(*rrp_at)) @ exact(2, -1, 0)).linear,
    "001.Jv_num": lambda: J_of(rrp(), exact(*rrp_at)).linear,
    "001.tau_hold": lambda: torque(J_of(rrp(), exact(*rrp_at)), down),
    "001.tau_JTF": lambda: -torque(J_of(rrp(), exact(*rrp_at)), down),
    "002.power": warm_up,
    "002.wrench_transform": transformed,
    "003.Js": lambda: ks.jacobian(three_joint((0.7, 0.4)), np.zeros(3), frame=ks.Frame.spatial()).array,
    "003.Jb": lambda: ks.jacobian(three_joint((0.7, 0.4)), np.zeros(3), frame=ks.Frame.body()).array,
    "003.Jb_second": lambda: ks.jacobian(three_joint((0.7, 0.4)), np.zeros(3), frame=ks.Frame.body()).array,
    "004.PA": lambda: ks.pose(planar(l1, l2), exact(t1, t2), at="link1").translation[:2],
    "004.PB": lambda: ks.pose(planar(l1, l2), exact(t1, t2)).translation[:2],
    "004.vA": lambda: (J_of(planar(l1, l2), [t1, t2], at="link1") @ exact(u1, u2)).linear[:2],
    "004.vB": lambda: (J_of(planar(l1, l2), [t1, t2]) @ exact(u1, u2)).linear[:2],
    "004.J": lambda: J_of(planar(l1, l2), [t1, t2]).linear[:2],
    "004.JA": lambda: J_of(planar(l1, l2), [t1, t2], at="link1").linear[:2],
    "004.accel_recipe": accelerated,
    "004.J_t2_0": lambda: J_of(planar(l1, l2), exact(t1, 0)).linear[:2],
    "004.v_sing": lambda: (J_of(planar(l1, l2), exact(t1, 0)) @ exact(u1, u2)).linear[:2],
    "004.near_J": lambda: ks.jacobian(planar(1.0, 1.0), [0, 0.01]).array[:2],
    "004.near_det": lambda: np.linalg.det(ks.jacobian(planar(1.0, 1.0), [0, 0.01]).array[:2]),
    "004.near_inv": lambda: np.linalg.inv(ks.jacobian(planar(1.0, 1.0), [0, 0.01]).array[:2]),
    "004.near_rad": lambda: speeds(1, 0),
    "004.near_tan": lambda: speeds(0, 1),
    "004.statics": lambda: torque(J_of(planar(l1, l2), [t1, t2]), push(fx, fy)),
    "004.fbd": lambda: torque(J_of(planar(l1, l2), [t1, t2]), push(fx, fy)),
    "004.leg_JT": lambda: J_of(planar(L, L), exact(t1, sp.pi - 2 * t1)).linear[:2].T,
    "004.leg_tau": lambda: torque(J_of(planar(L, L), exact(t1, sp.pi - 2 * t1)), push(0, m * g)),
    "004.leg_straight": lambda: abs(torque(J_of(planar(L, L), exact(half_pi, 0)), push(0, m * g))[1]),
}
LAWS: set[str] = set()
"""Examples that are held by a test of their own below, by the decorator `answers`."""


def answers(*names):
    """Marks a test as the one that holds these worked examples."""

    def register(test):
        LAWS.update(names)
        return test

    return register


def evaluate(value, numbers):
    flat = [sp.sympify(x).subs(numbers).evalf(30) for x in np.ravel(np.array(value, dtype=object))]
    return np.array([float(x) for x in flat]).reshape(np.shape(value))


def parsed(expected):
    """Expressions of the data file; a trailing unit such as "N m" is dropped."""
    names = {str(s): s for s in (a1, a2, l1, l2, L, L1, L2, d1, d3, q3, t1, t2, u1, u2, w1, w2, fx, fy, m1, m2, m, g)}
    if isinstance(expected, list):
        return [parsed(x) for x in expected]
    text = str(expected).removesuffix(" N m").removesuffix(" N")
    return sp.sympify(text, locals=names)


@pytest.mark.parametrize("name", COMPUTED)
def test_worked_example_of_the_notes(name):
    """The public functions give the answer of the notes, at symbols where the notes have symbols."""
    expected = parsed(EXAMPLES[name]["expected"])
    computed = COMPUTED[name]()
    rng = np.random.default_rng(4)
    for _ in range(3):
        numbers = {
            s: sp.Rational(int(rng.integers(1, 999)), 500) for s in (a1, a2, l1, l2, L, d1, d3, q3, t1, t2, u1, u2, w1, w2)
        }
        numbers |= {s: sp.Rational(int(rng.integers(1, 999)), 50) for s in (fx, fy, m1, m2, m, g)}
        numbers |= {L1: sp.Rational(7, 10), L2: sp.Rational(2, 5)}
        found, right = evaluate(computed, numbers), evaluate(expected, numbers)
        assert found.shape == right.shape
        np.testing.assert_allclose(found, right, rtol=1e-12, atol=1e-12)


def test_expressions_of_exact_arms_hold_no_floats():
    """At symbols, whole numbers stay integers: no factor 1.0 in any entry."""
    for entry in np.ravel(J_of(rrp(), [t1, t2, q3]).array):
        assert not sp.sympify(entry).atoms(sp.Float)


def test_first_body_jacobian_of_note_003_is_the_right_one():
    """J_body = Ad(g⁻¹) J_spatial (erratum of note 003: the second printed matrix is wrong)."""
    arm = three_joint((0.7, 0.4))
    J = ks.jacobian(arm, np.zeros(3), frame=ks.Frame.spatial()).change_frame(ks.Frame.body())
    expected = evaluate(parsed(EXAMPLES["003.Jb"]["expected"]), {L1: 0.7, L2: 0.4})
    np.testing.assert_allclose(J.array, expected, atol=1e-15)


# ---- sets, bases and words -----------------------------------------------------------------------------------------------


def members(equation, wholes=range(-2, 3)):
    """The substitutions of an equation such as "theta2 = pi/2 + k*pi", for some whole k."""
    name, _, value = (part.strip() for part in equation.partition("="))
    k = sp.Symbol("k")
    return [{sp.Symbol(name): sp.sympify(value, locals={"k": k}).subs(k, whole)} for whole in wholes]


def factors(determinant):
    """The factors that depend on anything: where all of them are non-zero, so is the determinant."""
    return {factor for factor, _ in sp.factor_list(sp.trigsimp(sp.expand_trig(determinant)))[1]}


def general_postures(n, count=20):
    return np.random.default_rng(7).uniform(0.1, 1.4, (count, n)) * np.random.default_rng(8).choice([-1, 1], (count, n))


@answers("000.planar.sing")
def test_planar_arm_of_note_000_is_singular_where_the_note_says_and_nowhere_else():
    """θ2 = kπ, or a link of no length: there the determinant and the rank fall, and at other postures they do not."""
    expected = EXAMPLES["000.planar.sing"]["expected"]
    determinant = COMPUTED["000.planar.det"]()
    folded = members(f"theta2 = {expected['theta2']}")
    for member in folded + [one for equation in expected["or"] for one in members(equation)]:
        assert sp.simplify(determinant.subs(member)) == 0
    assert factors(determinant) == {a1, a2, sp.sin(t2)}
    for member in folded:
        here = ks.analyze(planar(0.7, 0.4), [0.3, float(member[t2])])
        assert (here.rank, here.is_singular) == (1, True)
    for first, second in ((0.0, 0.4), (0.7, 0.0)):
        assert ks.analyze(planar(first, second), [0.3, 0.5], task="position").rank == 1
    for q in general_postures(2):
        here = ks.analyze(planar(0.7, 0.4), q)
        assert (here.rank, here.is_singular) == (2, False)


@answers("000.spherical.sing")
def test_spherical_arm_of_note_000_is_singular_where_the_note_says_and_nowhere_else():
    """d3 = 0 or θ2 = π/2 + kπ."""
    arm, determinant = ks.load("rrp_note_000"), COMPUTED["000.spherical.det"]()
    for equation in EXAMPLES["000.spherical.sing"]["expected"]:
        for member in members(equation):
            assert sp.simplify(determinant.subs(member)) == 0
            q = [float(member.get(s, other)) for s, other in ((t1, 0.3), (t2, 0.5), (d3, 0.8))]
            assert ks.analyze(arm, q).is_singular
    assert factors(determinant) == {d3, sp.cos(t2)}
    for q in general_postures(3):
        assert ks.analyze(arm, q).rank == 3


@answers("004.boundary")
def test_arm_of_note_004_is_singular_on_the_two_boundaries_of_its_workspace():
    """θ2 = 0 is the outer and θ2 = π the inner circle: no posture reaches further out or in; none between is singular."""
    arm, determinant = planar(0.7, 0.4), sp.Matrix(COMPUTED["004.J"]()).det()
    general = general_postures(2)
    reach = np.linalg.norm(ks.pose(arm, general).translation, axis=-1)
    side = {"outer": (1, np.max), "inner": (-1, np.min)}
    for equation, word in EXAMPLES["004.boundary"]["expected"].items():
        (member,) = members(equation, [0])
        assert sp.simplify(determinant.subs(member)) == 0
        q = np.array([0.3, float(member[t2])])
        assert ks.analyze(arm, q).is_singular
        sign, extreme = side[word]
        assert sign * np.linalg.norm(ks.pose(arm, q).translation) > sign * extreme(reach)
    assert not any(ks.analyze(arm, q).is_singular for q in general)


@answers("004.sing_J")
def test_stretched_arm_of_note_004():
    """Two links of 1 m, stretched: the Jacobian of the note, and a determinant that is zero and not merely small."""
    expected = EXAMPLES["004.sing_J"]["expected"]
    J = sp.Matrix(J_of(planar(1, 1), exact(0, 0)).linear[:2])
    assert sp.Matrix(expected["J"]) == J
    assert J.det() == expected["det"] == 0


@answers("000.planar.null_JT")
def test_stretched_arm_of_note_000_holds_forces_along_and_across_its_plane_for_free():
    """null(J_vᵀ) at (0, 0) is spanned by x and z, for any lengths; in the plane, x is also the direction that is lost."""
    expected = EXAMPLES["000.planar.null_JT"]["expected"]
    free = np.array(ks.free_wrenches(J_of(planar(a1, a2), exact(0, 0))))
    assert len(free) == 4
    forces = sp.Matrix([row[:3] for row in free if all(sp.sympify(entry) == 0 for entry in row[3:])])
    basis = sp.Matrix(exact(*expected["null_JT"][0], *expected["null_JT"][1])).reshape(2, 3)
    assert forces.rank() == basis.rank() == basis.col_join(forces).rank() == 2
    here = ks.analyze(planar(0.7, 0.4), [0.0, 0.0])
    (lost,), (held,) = here.lost_twists, here.free_wrenches
    np.testing.assert_allclose(np.abs(lost.direction)[:2], np.array(expected["lost_velocity_in_plane"], float), atol=1e-12)
    np.testing.assert_allclose(np.abs(held.direction)[:2], np.array(expected["in_plane"], float), atol=1e-12)


@pytest.mark.parametrize("extension", [0.5, 1.0, 2.0])
def test_velocity_ellipsoid_of_the_spherical_arm_of_note_000(extension):
    """Half-axes 1 along x and d3 along y and z: the matrix of the note from the axes and radii of the public function."""
    expected = evaluate(parsed(EXAMPLES["000.spherical.ellipsoid"]["expected"]), {d3: extension})
    shape = ks.velocity_ellipsoid(ks.jacobian(ks.load("rrp_note_000"), [0, 0, extension]).linear)
    np.testing.assert_allclose(shape.axes @ np.diag(shape.radii**2) @ shape.axes.T, expected, atol=1e-12)


# ---- identities, on random arms ------------------------------------------------------------------------------------------


def exponential(screw, angle):
    """exp(θ ξ^) by its power series, for MLS's formulas below: no code of the package."""
    v, (x, y, z) = screw[:3], screw[3:]
    hat = angle * np.vstack([np.column_stack([[[0, -z, y], [z, 0, -x], [-y, x, 0]], v]), np.zeros(4)])
    total = term = np.eye(4)
    for k in range(1, 60):
        term = term @ hat / k
        total = total + term
    return total


@st.composite
def screw_arms(draw):
    """Screws, home pose, the arm made of them, a configuration, and the exponential of each joint."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31 - 1)))
    n = draw(st.integers(1, 6))
    screws = np.array([random_screw(rng, str(rng.choice(["revolute", "prismatic", "helical"])), False) for _ in range(n)])
    home, q = random_pose(rng), rng.uniform(-2, 2, n)
    arm = ks.from_screws(screws, home, order="linear-angular")
    return arm, screws, home, q, [exponential(screw, angle) for screw, angle in zip(screws, q, strict=True)]


def product(matrices):
    total = np.eye(4)
    for matrix in matrices:
        total = total @ matrix
    return total


def differences(arm, q, body):
    """(∂g/∂θ_i g⁻¹) or (g⁻¹ ∂g/∂θ_i) as six-vectors, by central differences of the pose: the definitions of note 002."""
    inverse, columns, step = np.linalg.inv(ks.pose(arm, q).array), [], 1e-6
    for e in step * np.eye(len(q)):
        slope = (ks.pose(arm, q + e).array - ks.pose(arm, q - e).array) / (2 * step)
        V = inverse @ slope if body else slope @ inverse
        columns.append([*V[:3, 3], V[2, 1], V[0, 2], V[1, 0]])
    return np.array(columns).T


@answers("002.spatial_jacobian_formula")
@given(screw_arms())
def test_spatial_jacobian_of_note_002(case):
    """Column i is Ad(e¹ … eⁱ⁻¹) ξ_i, is what differences of the pose say, and the last angle is in no column."""
    arm, screws, home, q, e = case
    assert_close(ks.pose(arm, q).array, product(e) @ home, 1e-12)
    J = ks.jacobian(arm, q, frame=ks.Frame.spatial()).array
    formula = np.array([ks.adjoint(product(e[:i])) @ screws[i] for i in range(len(q))]).T
    assert_close(J, formula, 1e-12)
    assert_close(J, differences(arm, q, body=False), 1e-6)
    assert_close(ks.jacobian(arm, [*q[:-1], q[-1] + 0.7], frame=ks.Frame.spatial()).array, J, 1e-13)


@answers("002.body_jacobian_formula")
@given(screw_arms())
def test_body_jacobian_of_note_002_with_its_formula_put_right(case):
    """Column i is Ad⁻¹(eⁱ … eⁿ g(0)) ξ_i (erratum E002-1: the note prints Ad⁻¹(e¹ … eⁱ⁻¹))."""
    arm, screws, home, q, e = case
    J = ks.jacobian(arm, q, frame=ks.Frame.body()).array
    formula = np.array([ks.adjoint(np.linalg.inv(product(e[i:]) @ home)) @ screws[i] for i in range(len(q))]).T
    assert_close(J, formula, 1e-12)
    assert_close(J, differences(arm, q, body=True), 1e-6)


@answers("003.AdgInv")
@given(features(max_joints=6))
def test_body_jacobian_of_note_003_is_the_adjoint_of_the_spatial_one(f):
    """J_body = Ad(g⁻¹) J_spatial, and column by column ξ† = Ad(g⁻¹) ξ' (erratum E003-4), at a batch of postures."""
    model, q = f.model(), f.configurations(3)
    spatial = ks.jacobian(model, q, frame=ks.Frame.spatial()).array
    inverse = np.linalg.inv(ks.pose(model, q).array)
    assert_close(ks.jacobian(model, q, frame=ks.Frame.body()).array, ks.adjoint(inverse) @ spatial, 1e-12)


@answers("003.Jbar")
@given(features(max_joints=6))
def test_velocity_jacobian_of_note_003_has_the_rank_of_the_spatial_one(f):
    """J̄ = [[I, -p^], [0, I]] J_spatial is the Jacobian of the tip in base axes; an invertible factor keeps the rank."""
    model, q = f.model(), f.configurations()
    spatial, geometric = (ks.jacobian(model, q, frame=frame).array for frame in (ks.Frame.spatial(), ks.Frame()))
    x, y, z = ks.pose(model, q).translation
    factor = np.eye(6)
    factor[:3, 3:] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    assert_close(geometric, factor @ spatial, 1e-12)
    assert np.linalg.det(factor) == pytest.approx(1.0)
    assert rank(geometric) == rank(spatial)


def rank(array):
    return np.linalg.matrix_rank(array, tol=1e-9 * max(1.0, np.abs(array).max(initial=0.0))) if array.size else 0


@answers("000.pinv")
@given(st.integers(0, 2**31 - 1), st.integers(2, 9))
def test_pseudoinverse_of_note_000(seed, n):
    """J⁺ = Jᵀ (J Jᵀ)⁻¹ where J is wide, (Jᵀ J)⁻¹ Jᵀ where it is tall; its columns are the `joint_rates` of unit twists."""
    rng = np.random.default_rng(seed)
    axes = [ks.screw_axis(rng.normal(size=3), rng.normal(size=3)) for _ in range(n)]
    J = ks.jacobian(ks.from_screws(axes, random_pose(rng), order="linear-angular"), rng.uniform(-2, 2, n))
    A = J.array
    assume(np.linalg.cond(A) < 1e3)  # the note's condition: full rank
    plus = np.array([ks.joint_rates(J, ks.Twist(unit, J.frame)).array for unit in np.eye(6)]).T
    scale = np.linalg.cond(A) ** 2 * 1e-14
    if n >= 6:
        assert_close(plus, A.T @ np.linalg.inv(A @ A.T), scale)
        assert_close(A @ plus, np.eye(6), scale)
        b = rng.normal(size=n)
        assert_close(A @ (b - plus @ (A @ b)), np.zeros(6), scale * np.abs(b).max())
    if n <= 6:
        assert_close(plus, np.linalg.inv(A.T @ A) @ A.T, scale)
        assert_close(plus @ A, np.eye(n), scale)
    if n > 6:
        assert np.linalg.matrix_rank(plus @ A, tol=1e-6) == 6 < n


def test_every_worked_example_of_the_notes_is_held_by_a_test():
    """All of them, and each once."""
    assert set(EXAMPLES) == set(COMPUTED) | LAWS
    assert not set(COMPUTED) & LAWS
