"""The worked examples of the lecture notes that are poses, Jacobians, velocities, accelerations or torques.

Each is computed at symbols through the public functions and compared with the recomputed answer in worked_examples.json at
three sets of random numbers. Where the notes err (errata in the same file), the right answer is the one that counts.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks

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


rrp_at = [0, -half_pi, 2]
down = ks.Wrench.on_robot(force=(0, 0, -100))
COMPUTED = {
    "000.planar.Jv": lambda: J_of(planar(a1, a2), [t1, t2]).linear[:2],
    "000.planar.det": lambda: sp.Matrix(J_of(planar(a1, a2), [t1, t2]).linear[:2]).det(),
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
    "004.statics": lambda: torque(J_of(planar(l1, l2), [t1, t2]), push(fx, fy)),
    "004.fbd": lambda: torque(J_of(planar(l1, l2), [t1, t2]), push(fx, fy)),
    "004.leg_JT": lambda: J_of(planar(L, L), exact(t1, sp.pi - 2 * t1)).linear[:2].T,
    "004.leg_tau": lambda: torque(J_of(planar(L, L), exact(t1, sp.pi - 2 * t1)), push(0, m * g)),
}


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


def test_every_pose_jacobian_velocity_and_acceleration_is_covered():
    """The kinematic examples are all computed above; the rest belongs to inverse problems, measures and singular sets."""
    elsewhere = {
        "000.planar.sing", "000.planar.rank", "000.planar.mu", "000.planar.null_JT",
        "000.spherical.sing", "000.spherical.tau", "000.spherical.ellipsoid", "000.pinv",
        "002.power", "002.wrench_transform", "002.spatial_jacobian_formula", "002.body_jacobian_formula",
        "003.Jbar", "003.AdgInv", "004.boundary", "004.near_rad",
        "004.near_tan", "004.sing_J", "004.leg_straight",
    }  # fmt: skip
    assert set(EXAMPLES) - set(COMPUTED) == elsewhere
