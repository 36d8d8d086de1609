"""Walls, passages and standstills; axes that line up; names; boundaries. Golden values and mistakes.

Lengths and postures: Spong, Hutchinson, Vidyasagar (planar, elbow, SCARA, Stanford arms), Corke's tables (PUMA 560),
Universal Robots (UR5), KUKA (KR 5), ABB (IRB 140); the determinants whose factors are used here are
checked in test_singularities.
"""

import json

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.errors import ArrayTypeError, ConfigurationError, UnknownNameError
from kinestatics.singular_sets.axes import axis_relations
from kinestatics.singular_sets.names import name_of
from kinestatics.singular_sets.reach import on_boundary
from kinestatics.singular_sets.second_order import second_order
from kinestatics.singular_sets.task_map import polished, rotation_vectors, task_map
from singular_robots import ROBOTS, numeric

PI = np.pi
Q3_FOLDED, SHOULDER = np.arctan2(-0.4318, 0.0203) + PI, -0.18310094581072303


def dh(*rows, types=None, convention="standard", **options):
    """An arm from rows (a, alpha in degrees, d, offset in degrees)."""
    table = [(a, np.deg2rad(alpha), d, np.deg2rad(theta)) for a, alpha, d, theta in rows]
    return ks.from_dh(table, convention=convention, types=types, **options)


def planar(*lengths):
    return dh(*((a, 0, 0, 0) for a in lengths))


def turning(point, axis):
    return np.r_[np.cross(point, axis), axis]


def rotated_home(z):
    T = np.eye(4)
    T[2, 3] = z
    return T


X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
SLIDES = [np.r_[axis, ORIGIN] for axis in (X, Y, Z)]
WRIST_ZYZ = [turning(ORIGIN, Z), turning(ORIGIN, Y), turning(ORIGIN, Z)]
ARMS = {
    "planar_2r": planar(0.5, 0.4),
    "planar_3r": planar(0.5, 0.4, 0.2),
    "planar_3r_hole": planar(1.0, 0.4, 0.2),
    "elbow": dh((0, 90, 0.4, 0), (0.5, 0, 0, 0), (0.35, 0, 0, 0)),
    "scara": dh((0.325, 0, 0.387, 0), (0.275, 180, 0, 0), (0, 0, 0, 0), (0, 0, 0.1, 0), types="RRPR"),
    "rrp": dh((0, -90, 3, 0), (0, -90, 0, 0), (0, 0, 0, 0), types="RRP"),
    "stanford": dh(
        (0, -90, 0.412, 0), (0, 90, 0.154, 0), (0, 0, 0, -90), (0, -90, 0, 0), (0, 90, 0, 0), (0, 0, 0.26, 0), types="RRPRRR"
    ),
    "puma": dh(
        (0, 90, 0.67183, 0),
        (0.4318, 0, 0, 0),
        (0.0203, -90, 0.15005, 0),
        (0, 90, 0.4318, 0),
        (0, -90, 0, 0),
        (0, 0, 0.05625, 0),
    ),
    "ur5": dh(
        (0, 90, 0.089159, 0),
        (-0.425, 0, 0, 0),
        (-0.39225, 0, 0, 0),
        (0, 90, 0.10915, 0),
        (0, -90, 0.09465, 0),
        (0, 0, 0.0823, 0),
    ),
    "kr5": dh((0.18, -90, 0.4, 0), (0.6, 0, 0, 0), (0.12, 90, 0, 0), (0, -90, -0.62, 0), (0, 90, 0, 0), (0, 180, -0.115, 0)),
    "irb140": dh((0.07, -90, 0.352, 0), (0.36, 0, 0, 0), (0, -90, 0, 0), (0, 90, 0.38, 0), (0, -90, 0, 0), (0, 0, 0.065, 0)),
    "anthropomorphic": dh((0, 90, 0, 0), (0.5, 0, 0, 0), (0, 90, 0, 90), (0, -90, 0.45, 0), (0, 90, 0, 0), (0, 0, 0.1, 0)),
    "zyz": ks.from_screws(WRIST_ZYZ, order="linear-angular"),
    "gantry": ks.from_screws([*SLIDES, *WRIST_ZYZ], rotated_home(0.1), order="linear-angular"),
    "cylindrical": ks.from_screws([turning(ORIGIN, Z), SLIDES[2], SLIDES[0]], order="linear-angular"),
    "iiwa": ks.load("iiwa_14"),
    "cuspidal": ks.from_dh(
        [(0, 0, 0, 0), (1, -PI / 2, 1, 0), (2, PI / 2, 0, 0)],
        convention="modified",
        tool=np.array([[1.0, 0, 0, 1.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    ),
}
ELBOW_SHOULDER = [0.3, 1.1, np.arccos(-0.5 * np.cos(1.1) / 0.35) - 1.1]
UR5_SHOULDER = [0.3, -1.45, -0.25, -1.4487181665409483, 0.6, 0.2]
PUMA_ELBOW = Q3_FOLDED - PI


def judged(name, q, task="auto", **options):
    arm = ARMS[name]
    return second_order(arm, q, ks.find_task(arm, task), **options)


# What second order says


@pytest.mark.parametrize(
    ("name", "q", "task", "kind", "rank"),
    [
        ("planar_2r", [0.4, 0], "auto", "barrier", 1),
        ("planar_2r", [0.4, PI], "auto", "barrier", 1),
        ("planar_3r", [0.3, 0, 0.7], "auto", "barrier", 2),
        ("elbow", [0.3, 0.5, 0], "auto", "barrier", 2),
        ("elbow", ELBOW_SHOULDER, "auto", "self-motion", 2),
        ("scara", [0.3, 0, 0.1, 0.2], "auto", "barrier", 3),
        ("scara", [0.3, 0, 0.1, 0.2], "full", "barrier", 3),
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2], "full", "barrier", 5),
        ("puma", [0.3, 0.4, Q3_FOLDED, 0.5, 0.6, 0.2], "full", "barrier", 5),
        ("puma", [0.3, 0.9, SHOULDER, 0.5, 0.6, 0.2], "full", "barrier", 5),
        ("puma", [0.3, 0.4, 0.5, 0.5, 0, 0.2], "full", "self-motion", 5),
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0, 0.2], "full", "self-motion", 5),  # two factors vanish, one rank is lost
        ("ur5", [0.3, -0.9, 0, 0.5, 0.6, 0.2], "full", "barrier", 5),
        ("ur5", UR5_SHOULDER, "full", "barrier", 5),
        ("ur5", [0.3, -0.9, 0.7, 0.5, 0, 0.2], "full", "self-motion", 5),
        ("stanford", [0.3, 0, 0.5, 0.4, 0.6, 0.2], "full", "barrier", 5),
        ("stanford", [0.3, 0.7, 0, 0.4, 0.6, 0.2], "full", "self-motion", 5),
        ("stanford", [0.3, 0.7, 0.5, 0.4, 0, 0.2], "full", "self-motion", 5),
        ("rrp", [0.3, 0.7, 0], "auto", "self-motion", 1),
        ("rrp", [0.3, 0, 0.5], "auto", "self-motion", 2),
        ("cylindrical", [0.3, 0.2, 0], "auto", "self-motion", 2),
        ("zyz", [0.4, 0, 0.5], "auto", "self-motion", 2),
        ("gantry", [0.1, 0.2, 0.3, 0.4, 0, 0.5], "full", "self-motion", 5),
        ("anthropomorphic", [0.3, PI / 2, 0, 0.5, 0.6, 0.2], "full", "barrier", 4),
        ("anthropomorphic", [0.3, PI / 2, 0, 0.5, 0, 0.2], "full", "self-motion", 4),
        ("iiwa", [0.3, 0.5, 0.2, 0, 0.4, 0.7, 0.1], "full", "barrier", 5),
        ("iiwa", [0.3, 0, PI / 2, 0.9, 0.4, 0.6, 0.1], "full", "crossable", 5),
        ("iiwa", [0.3, 0.5, 0.2, 0.9, 0.4, 0.7, 0.1], "full", "regular", 6),
    ],
)
def test_known_postures(name, q, task, kind, rank):
    found = judged(name, q, task)
    assert (found.kind, found.rank, found.decided) == (kind, rank, True)
    assert found.corank == ks.find_task(ARMS[name], task).rank - rank
    assert found.text
    assert all(len(line) <= 80 for line in str(found).splitlines())
    json.dumps(found.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("planar_3r", {(0, 0): "barrier", (0, 1): "crossable", (1, 0): "crossable", (1, 1): "crossable"}),
        ("planar_3r_hole", {(0, 0): "barrier", (0, 1): "crossable", (1, 0): "barrier", (1, 1): "crossable"}),
    ],
)
def test_planar_arm_has_a_wall_inside_only_with_a_hole(name, kinds):
    """(.5, .4, .2) can touch its own base; (1, .4, .2) keeps 0.4 m away from it."""
    for (second, third), kind in kinds.items():
        assert judged(name, [0.3, PI * second, PI * third], "position").kind == kind


def test_eigenvalues():
    """Published with the planar arm: outer wall (0.2472, 0.1105) m, hole (0.1187, 0.4813) m, up to the sign of w."""
    outer = judged("planar_3r", [0.3, 0, 0], "position")
    hole = judged("planar_3r_hole", [0.3, PI, 0], "position")
    assert np.allclose(outer.scale * outer.eigenvalues, [0.1105, 0.2472], atol=5e-5)
    assert np.allclose(hole.scale * hole.eigenvalues, [0.1187, 0.4813], atol=5e-5)
    towards = np.array([np.cos(0.3), np.sin(0.3)])
    assert np.allclose(outer.directions[0, :2], -towards)  # what is reached is inside, and outside of the hole
    assert np.allclose(hole.directions[0, :2], towards)


def test_nearly_flat_wall_is_a_wall():
    """PUMA's folded elbow: a2 = 0.4318 against hypot(a3, d4) = 0.43228; 5.1e-7 beside 0.122, with metres for radians."""
    extended = judged("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2], "full", length=1.0)
    folded = judged("puma", [0.3, 0.4, Q3_FOLDED, 0.5, 0.6, 0.2], "full", length=1.0)
    assert extended.eigenvalues == pytest.approx([0.1219], abs=5e-5)
    assert folded.eigenvalues == pytest.approx([5.1e-7], rel=0.02)
    assert folded.kind == "barrier"
    assert folded.error < 1e-3 * folded.eigenvalues[0]


def test_exactly_flat_fold_is_no_wall():
    """With equal lengths the 2R arm folds onto its own base and turns about it."""
    arm = planar(0.5, 0.5)
    found = second_order(arm, [0.4, PI], ks.find_task(arm))
    assert (found.kind, found.self_motion, found.turns) == ("self-motion", 1, True)
    assert abs(found.eigenvalues[0]) <= found.error < 1e-6


def test_what_turns_with_the_self_motion():
    """The wrist's lost direction turns with joints 4 and 6; with the elbow stretched the wall stays where it is."""
    wrist = judged("puma", [0.3, 0.4, 0.5, 0.5, 0, 0.2], "full")
    both = judged("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0, 0.2], "full")
    assert wrist.turns is True
    assert both.turns is False
    assert judged("iiwa", [0.3, 0.5, 0.2, 0, 0.4, 0.7, 0.1], "full").self_motion == 1
    assert judged("rrp", [0.3, 0.7, 0]).self_motion == 2


def test_cusp_is_degenerate():
    """At a cusp of the orthogonal 3R arm the curvature vanishes too: third order decides (Wenger's arm, 4 cusps)."""
    from scipy.optimize import fsolve

    arm = ARMS["cuspidal"]
    of = task_map(arm, ks.find_task(arm, "position"))

    def equations(x):
        y = np.r_[0.2, x]
        J, H = of.jacobian(y), of.hessian(y)
        minors = np.linalg.det(J) * np.linalg.inv(J)
        a, w = minors[:, 0], minors[0]
        return [np.linalg.det(J), np.einsum("k,kjl,j,l->", w, H, a, a)]

    found = fsolve(equations, [-2.264, 1.16], xtol=1e-14)
    assert np.allclose(found, [-2.264, 1.16], atol=0.02)
    at_cusp = second_order(arm, np.r_[0.2, found], ks.find_task(arm, "position"), tolerance=1e-8)
    assert (at_cusp.kind, at_cusp.self_motion) == ("degenerate", 0)
    beside, _ = polished(arm, np.r_[0.2, found[0] + 0.05, found[1]], ks.find_task(arm, "position"))
    assert second_order(arm, beside, ks.find_task(arm, "position")).kind == "barrier"


def test_undecided_is_said():
    """An upright iiwa loses three directions at once; one form has one sign, and others decide where it vanishes."""
    found = judged("iiwa", [0.0] * 7, "full")
    assert (found.kind, found.corank, found.decided) == ("degenerate", 3, False)
    assert "higher order" in found.text


def test_fewer_freedoms_than_rows():
    """Five joints, six rows: one direction is lost everywhere, and the stretched elbow is still a wall."""
    arm = dh((0, 90, 0.1, 0), (0.3, 0, 0, 0), (0.3, 0, 0, 0), (0, 90, 0, 90), (0, 0, 0.1, 0))
    task = ks.find_task(arm, "full")
    found = second_order(arm, [0.3, 0.4, 0, 0.7, 0.2], task)
    assert (task.rank, found.kind, found.corank, len(found.directions)) == (5, "barrier", 1, 2)
    assert "at any posture" in found.text
    assert second_order(arm, [0.3, 0.4, 0.5, 0.7, 0.2], task).kind == "regular"
    assert on_boundary(arm, [0.3, 0.4, 0, 0.7, 0.2], task, "tip", found).verdict == "boundary"


def test_wrenches_go_with_the_directions():
    """Free wrenches of elbows: the PUMA's a force on the line from shoulder to wrist, the UR5's a screw of -0.0852 m."""
    for name, q, pitch in (
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2], 0.0),
        ("ur5", [0.3, -0.9, 0, 0.5, 0.6, 0.2], -0.085195372),
    ):
        found = judged(name, q, "full")
        force, moment = found.wrenches[0, :3], found.wrenches[0, 3:]
        J = ks.jacobian(ARMS[name], q).array
        assert np.abs(J.T @ found.wrenches[0]).max() < 1e-14
        assert force @ moment / (force @ force) == pytest.approx(pitch, abs=1e-9)


def test_polished():
    arm, task = ARMS["ur5"], ks.find_task(ARMS["ur5"], "full")
    q, left = polished(arm, [0.3, -0.9, 0.01, 0.5, 0.6, 0.2], task)
    assert left < 1e-15
    assert abs(q[2]) < 1e-14
    assert np.allclose(q, [0.3, -0.9, 0, 0.5, 0.6, 0.2], atol=1e-4)
    found = second_order(arm, [0.3, -0.9, 1e-7, 0.5, 0.6, 0.2], task, tolerance=1e-6)
    assert found.kind == "barrier"
    assert found.moved == pytest.approx(1e-7, rel=1e-3)
    assert found.eigenvalues == pytest.approx(judged("ur5", [0.3, -0.9, 0, 0.5, 0.6, 0.2], "full").eigenvalues, abs=1e-7)


def test_no_joints():
    arm = ks.from_dh([], convention="standard")
    found = second_order(arm, [], ks.find_task(arm, "full"))
    assert (found.kind, found.rank) == ("regular", 0)


def test_rotation_vectors():
    rng = np.random.default_rng(0)
    for angle in (0.0, 1e-9, 0.3, 2.0, PI - 1e-3, PI - 1e-7, PI):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        K = np.cross(np.eye(3), axis)
        R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
        found = rotation_vectors(R)
        expected = angle * axis
        assert min(np.abs(found - expected).max(), np.abs(found + expected).max() if angle == PI else 1) < 1e-7


# Which axes line up or meet


def relations(name, q):
    return [(r.kind, r.joints, r.through) for r in axis_relations(ARMS[name], q)]


def joints(*numbers):
    return tuple(f"joint{i}" for i in numbers)


@pytest.mark.parametrize(
    ("name", "q", "expected"),
    [
        ("planar_2r", [0.4, 0], [("in-plane", joints(1, 2), ())]),
        ("elbow", [0.3, 0.5, 0], [("in-plane", joints(2, 3), ())]),
        ("elbow", ELBOW_SHOULDER, [("on-axis", joints(1), ())]),
        ("scara", [0.3, 0, 0.1, 0.2], [("coplanar", joints(1, 2, 4), ())]),
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2], [("in-plane", joints(2, 3), joints(4, 5, 6))]),
        ("puma", [0.3, 0.9, SHOULDER, 0.5, 0.6, 0.2], [("in-plane", joints(1, 2), joints(4, 5, 6))]),
        ("puma", [0.3, 0.4, 0.5, 0.5, 0, 0.2], [("collinear", joints(4, 6), ())]),
        ("puma", [0.3, 0.4, 0.5, 0.5, 0.6, 0.2], []),
        ("ur5", [0.3, -0.9, 0, 0.5, 0.6, 0.2], [("coplanar", joints(2, 3, 4), ())]),
        ("ur5", [0.3, -0.9, 0.7, 0.5, 0, 0.2], [("parallel", joints(2, 3, 4, 6), ())]),
        ("ur5", UR5_SHOULDER, [("in-plane", joints(1, 2), joints(5, 6))]),
        ("stanford", [0.3, 0, 0.5, 0.4, 0.6, 0.2], [("parallel", joints(1, 3, 4), ())]),
        ("stanford", [0.3, 0.7, 0, 0.4, 0.6, 0.2], [("meet", joints(2, 4, 5, 6), ())]),
        ("zyz", [0.4, 0, 0.5], [("collinear", joints(1, 3), ())]),
        ("iiwa", [0.3, 0.5, 0.2, 0, 0.4, 0.7, 0.1], [("collinear", ("joint_a3", "joint_a5"), ())]),
    ],
)
def test_axis_relations(name, q, expected):
    """Only what is special here: a UR's axes 2, 3, 4 are always parallel, a PUMA's 4, 5, 6 always meet."""
    assert relations(name, q) == expected


def test_wrist_centre_on_axis_one():
    """KR 5: without a lateral offset the wrist's centre comes to lie on axis 1 itself."""
    from scipy.optimize import brentq

    x = brentq(lambda x: 0.18 + 0.6 * np.cos(-1.0) + 0.12 * np.cos(x - 1.0) - 0.62 * np.sin(x - 1.0), 0, 3, xtol=1e-15)
    (found,) = axis_relations(ARMS["kr5"], [0.3, -1.0, x, 0.5, 0.6, 0.2])
    assert (found.kind, found.joints) == ("meet", joints(1, 4, 5, 6))
    assert np.allclose(found.point[:2], 0, atol=1e-12)
    assert str(found) == "the axes of joint1, joint4, joint5 and joint6 meet in one point"
    json.dumps(found.to_dict(), allow_nan=False)


# What people call it


def component(condition, solved, n, count=6):
    """Postures with condition(q) = 0, joint `solved` solved for."""
    from scipy.optimize import brentq

    rng, found, grid = np.random.default_rng(5), [], np.linspace(-3.1, 3.1, 200)
    while len(found) < count:
        q = rng.uniform(-3, 3, n)

        def value(x, q=q):
            return condition(np.r_[q[:solved], x, q[solved + 1 :]])

        signs = np.array([value(x) for x in grid])
        changes = np.flatnonzero(signs[:-1] * signs[1:] < 0)
        if len(changes):
            k = int(rng.choice(changes))
            found.append(np.r_[q[:solved], brentq(value, grid[k], grid[k + 1], xtol=1e-15), q[solved + 1 :]])
    return np.array(found)


def c(*angles):
    return np.cos(sum(angles))


def s(*angles):
    return np.sin(sum(angles))


@pytest.mark.parametrize(
    ("name", "condition", "solved", "columns", "expected"),
    [
        *(
            (arm, lambda q: s(q[4]), 4, [4], "wrist")
            for arm in ("puma", "ur5", "kr5", "irb140", "anthropomorphic", "stanford")
        ),
        ("gantry", lambda q: s(q[4]), 4, [4], "wrist"),
        ("zyz", lambda q: s(q[1]), 1, [1], "wrist"),
        ("puma", lambda q: 0.0203 * s(q[2]) + 0.4318 * c(q[2]), 2, ["joint3"], "elbow"),
        ("ur5", lambda q: s(q[2]), 2, [2], "elbow"),
        ("kr5", lambda q: 0.12 * s(q[2]) + 0.62 * c(q[2]), 2, [2], "elbow"),
        ("irb140", lambda q: c(q[2]), 2, [2], "elbow"),
        ("anthropomorphic", lambda q: s(q[2]), 2, [2], "elbow"),
        ("elbow", lambda q: s(q[2]), 2, [2], "elbow"),
        ("planar_2r", lambda q: s(q[1]), 1, [1], "elbow"),
        ("planar_3r", lambda q: s(q[1]), 1, [1], "elbow"),
        ("scara", lambda q: s(q[1]), 1, [1], "elbow"),
        ("iiwa", lambda q: s(q[3]), 3, [3], "elbow"),
        ("puma", lambda q: 0.4318 * c(q[1]) + 0.0203 * c(q[1], q[2]) - 0.4318 * s(q[1], q[2]), 2, [1, 2], "shoulder"),
        (
            "ur5",
            lambda q: -0.425 * c(q[1]) - 0.39225 * c(q[1], q[2]) + 0.09465 * s(q[1], q[2], q[3]),
            2,
            [1, 2, 3],
            "shoulder",
        ),
        ("kr5", lambda q: 0.18 + 0.6 * c(q[1]) + 0.12 * c(q[1], q[2]) - 0.62 * s(q[1], q[2]), 2, [1, 2], "shoulder"),
        ("irb140", lambda q: 0.07 + 0.36 * c(q[1]) - 0.38 * s(q[1], q[2]), 2, [1, 2], "shoulder"),
        ("anthropomorphic", lambda q: 0.5 * c(q[1]) + 0.45 * c(q[1], q[2]), 2, [1, 2], "shoulder"),
        ("elbow", lambda q: 0.5 * c(q[1]) + 0.35 * c(q[1], q[2]), 2, [1, 2], "shoulder"),
        ("stanford", lambda q: s(q[1]), 1, [1], "shoulder"),
        ("stanford", lambda q: q[2], 2, [2], "shoulder"),  # the wrist's centre is on axis 2, which does not move it
        ("rrp", lambda q: q[2], 2, [2], "shoulder"),
        ("cuspidal", lambda q: s(q[2]) + c(q[1]) * (2 * s(q[2]) - c(q[2])), 2, [1, 2], "other"),
    ],
)
def test_names(name, condition, solved, columns, expected):
    arm = ARMS[name]
    assert name_of(arm, component(condition, solved, arm.n), columns) == expected


def test_names_of_redundant_arms():
    """iiwa: {s2 = 0, c3 = 0} and {s6 = 0, c5 = 0} belong to one ball joint each; {s2 = 0, s6 = 0} to both."""
    arm, rng = ARMS["iiwa"], np.random.default_rng(2)
    for fixed, name in (
        ({1: 0, 2: PI / 2}, "shoulder"),
        ({5: 0, 4: PI / 2}, "wrist"),
        ({1: 0, 5: 0}, "shoulder and wrist"),
    ):
        q = rng.uniform(-3, 3, (6, 7))
        q[:, list(fixed)] = list(fixed.values())
        assert name_of(arm, q, list(fixed)) == name


def test_no_name_without_a_singularity():
    """Regular postures, postures of several kinds and no postures have no name."""
    arm = ARMS["puma"]
    wrist, elbow = [0.3, 0.4, 0.5, 0.5, 0, 0.2], [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2]
    assert name_of(arm, [[0.3, 0.4, 0.5, 0.5, 0.6, 0.2]], [4]) == "other"
    assert name_of(arm, [wrist, elbow], [2, 4]) == "other"
    assert name_of(arm, [wrist], [2]) == "other"
    assert name_of(arm, np.zeros((0, 6)), [2]) == "other"


# The boundary of the workspace


def bounded(name, q, task="auto", **options):
    arm = ARMS[name]
    rows = ks.find_task(arm, task)
    return on_boundary(arm, q, rows, "tip", second_order(arm, q, rows), **options)


@pytest.mark.parametrize(
    ("name", "q", "task", "verdict", "proved"),
    [
        ("planar_2r", [0.4, 0], "auto", "boundary", False),
        ("planar_3r", [0.3, 0, 0], "position", "boundary", False),
        ("planar_3r_hole", [0.3, PI, 0], "position", "boundary", False),
        ("planar_3r", [0.3, PI, 0], "position", "inside", True),
        ("elbow", ELBOW_SHOULDER, "auto", "inside", False),
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0.6, 0.2], "full", "boundary", False),
        ("puma", [0.3, 0.4, PUMA_ELBOW, 0.5, 0, 0.2], "full", "boundary", False),
        ("puma", [0.3, 0.4, 0.5, 0.5, 0, 0.2], "full", "inside", True),
        ("ur5", [0.3, -0.9, 0, 0.5, 0.6, 0.2], "full", "inside", True),  # with the wrist the other way the elbow is bent
        ("ur5", UR5_SHOULDER, "full", "boundary", False),
        ("stanford", [0.3, 0.7, 0, 0.4, 0.6, 0.2], "full", "boundary", False),  # |wrist - shoulder| is never below d2
        ("zyz", [0.4, 0, 0.5], "auto", "inside", False),
    ],
)
def test_boundary(name, q, task, verdict, proved):
    arm, found = ARMS[name], bounded(name, q, task, budget_seconds=60)
    assert (found.verdict, found.proved) == (verdict, proved)
    if proved:
        T, there = ks.pose(arm, q), ks.pose(arm, found.posture)
        rows = 3 if task == "position" else 4
        assert np.abs(T.array - there.array)[:rows, 3].max() < 1e-9
        assert task == "position" or np.abs(T.array - there.array).max() < 1e-9
    assert all(len(line) <= 80 for line in str(found).splitlines())
    json.dumps(found.to_dict(), allow_nan=False)


def test_boundary_is_repeatable_and_says_when_time_ran_out():
    q = [0.3, -0.9, 0, 0.5, 0.6, 0.2]
    one, two = (bounded("ur5", q, "full", budget_seconds=60, seed=3) for _ in range(2))
    assert np.array_equal(one.posture, two.posture)
    assert bounded("ur5", q, "full", budget_seconds=1e-9).verdict == "undecided"


def test_limits_count():
    """Where limits keep the wrist from flipping the UR5's stretched elbow is a wall; without limits it is not."""
    bounds = [(-0.5, 0.8), (-1.5, -0.2), (-0.3, 0.3), (-0.5, 1.0), (0.2, 1.0), (-0.5, 0.5)]
    rows = [(0, 90, 0.089159, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0), (0, 90, 0.10915, 0), (0, -90, 0.09465, 0)]
    arm = dh(*rows, (0, 0, 0.0823, 0), limits=bounds)
    task, q = ks.find_task(arm, "full"), [0.3, -0.9, 0, 0.5, 0.6, 0.2]
    second = second_order(arm, q, task)
    assert on_boundary(arm, q, task, "tip", second, 60).verdict == "boundary"
    assert on_boundary(arm, q, task, "tip", second, 60, limits=False).verdict == "inside"
    at_limit = [0.3, -0.9, 0.3, 0.5, 0.6, 0.2]
    assert on_boundary(arm, at_limit, task, "tip", second_order(arm, at_limit, task)).verdict == "undecided"


# Mistakes


def test_mistakes():
    arm = ARMS["planar_2r"]
    task, q = ks.find_task(arm), [0.3, 0.0]
    second = second_order(arm, q, task)
    with pytest.raises(ArrayTypeError, match="KS302"):
        second_order(arm, q, "position")
    with pytest.raises(ArrayTypeError, match="KS302"):
        second_order("arm", q, task)
    with pytest.raises(ConfigurationError, match="KS303"):
        second_order(arm, [q, q], task)
    with pytest.raises(ConfigurationError, match="KS303"):
        second_order(arm, [0.3], task)
    with pytest.raises(ConfigurationError, match="KS301"):
        second_order(arm, [0.3, np.nan], task)
    with pytest.raises(ConfigurationError, match="KS303"):
        second_order(arm, q, task, tolerance=2.0)
    with pytest.raises(ConfigurationError, match="KS303"):
        second_order(arm, q, task, length=0.0)
    with pytest.raises(UnknownNameError, match="KS310"):
        second_order(arm, q, task, at="nowhere")
    with pytest.raises(ConfigurationError, match="KS303"):
        polished(arm, q, task, corank=3)
    with pytest.raises(ConfigurationError, match="KS303"):
        axis_relations(arm, [q, q])
    with pytest.raises(ConfigurationError, match="KS303"):
        axis_relations(arm, q, tolerance=-1.0)
    with pytest.raises(UnknownNameError, match="KS313"):
        name_of(arm, [q], ["elbow"])
    with pytest.raises(ConfigurationError, match="KS303"):
        name_of(arm, [q], [2])
    with pytest.raises(ArrayTypeError, match="KS302"):
        on_boundary(arm, q, task, "tip", "barrier")
    with pytest.raises(ConfigurationError, match="KS303"):
        on_boundary(arm, q, task, "tip", second, budget_seconds=0.0)
    with pytest.raises(ConfigurationError, match="KS303"):
        on_boundary(arm, [q, q], task, "tip", second)


def test_symbols_are_refused():
    import sympy

    a = sympy.Symbol("a")
    symbolic = ks.from_dh([(a, 0, 0, 0), (1, 0, 0, 0)], convention="standard")
    with pytest.raises(ArrayTypeError, match="KS302"):
        second_order(symbolic, [0, 0], ks.find_task(ARMS["planar_2r"]))


@pytest.mark.parametrize(
    ("name", "q"),
    [
        (
            "tm5_700",
            [-0.1316245757259975, -2.1379234521572865, 1.473891711134418, -2.427370288182206, 0, 0.10518166948605545],
        ),
        (
            "stanford_SHV",
            [-2.6034430650208034, -1.6536683579594254, 0, 0.5162392978075951, -2.550164951680153, -0.4201758265523301],
        ),
    ],
)
def test_self_motion_near_another_singularity(name, q):
    """The tip stands still along a curve that a step of 0.05 rad leaves: shorter ones follow it."""
    arm = numeric(ROBOTS[name])
    found = second_order(arm, q, ks.find_task(arm))
    assert (found.kind, found.self_motion) == ("self-motion", 1)
