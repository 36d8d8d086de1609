"""Polytopes by hand, known solids, real arms, and what is said when there is nothing to say."""

import json
import pickle

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.dexterity import halfspaces, zonotopes
from kinestatics.dexterity.shapes import image_of_box, let_through
from kinestatics.dexterity.surfaces import closes
from strategies import assert_close

QUARTER = np.pi / 2
GOLDEN = (1 + np.sqrt(5)) / 2
LEG = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
UR5E_Q = [0, -1, 1.5, -0.5, 1.2, 0]


def named(rows, joints, kind="velocity"):
    return {"kind": kind, "unit": "m/s", "rows": ("vx", "vy", "vz")[:rows], "joints": tuple(f"j{i}" for i in range(joints))}


def same_points(found, expected, tolerance=1e-12):
    """The same set of points, in any order."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    gaps = np.linalg.norm(found[:, None] - expected, axis=-1)
    return found.shape == expected.shape and max(gaps.min(0).max(), gaps.min(1).max()) <= tolerance


def unit_vectors(count, seed):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


# --- by hand -------------------------------------------------------------------------------------------------------


def test_planar_arm_with_a_bent_elbow():
    """J = [[-1, -1], [1, 0]] at (0, 90°): the parallelogram of ±J_1 ± J_2, area 4 |det J| = 4."""
    p = ks.velocity_polytope(ks.load("planar_2r"), [0, QUARTER], velocity_limits=(1, 1))
    assert same_points(p.vertices, [(-2, 1), (2, -1), (0, 1), (0, -1)])
    assert_close(p.volume, 4.0, 1e-12)
    assert (p.rows, p.unit, p.dimension, p.kind) == (("vx", "vy"), "m/s", 2, "velocity")
    corners = p.vertices[list(p.faces[0])]
    sides = np.roll(corners, -1, axis=0) - corners
    assert np.all([np.linalg.det([a, b]) > 0 for a, b in zip(sides, np.roll(sides, -1, axis=0), strict=True)])  # to the left
    assert_close(p.support([1, 0]), 2.0, 1e-12)
    assert_close(p.extent([1, 0]), 1.0, 1e-12)
    assert p.limiting_facet([1, -0.1]) == ("joint2 at its lower limit",)
    assert p.limiting_facet([0.1, -1]) == ("joint1 at its lower limit",)


def test_limits_that_are_not_even():
    """Joints that turn one way only span {a J_1 + b J_2 : 0 <= a <= 1, 0 <= b <= 2}."""
    p = ks.velocity_polytope(ks.load("planar_2r"), [0, QUARTER], velocity_limits=([0, 0], [1, 2]))
    assert same_points(p.vertices, [(0, 0), (-1, 1), (-2, 0), (-3, 1)])
    assert_close(p.center, [-1.5, 0.5], 1e-12)
    named_ones = ks.velocity_polytope(
        ks.load("planar_2r"), [0, QUARTER], velocity_limits={"joint1": (0, 1), "joint2": (0.0, 2.0)}
    )
    assert same_points(named_ones.vertices, p.vertices)
    slow = ks.velocity_polytope(ks.load("ur5e"), UR5E_Q, velocity_limits={"elbow_joint": 0.5})
    assert slow.volume < ks.velocity_polytope(ks.load("ur5e"), UR5E_Q).volume


def test_a_lost_direction_makes_a_segment():
    """A stretched arm moves its tip across only: ±3 m/s along y, 0 along x, and both said."""
    p = ks.velocity_polytope(ks.load("planar_2r"), [0, 0], velocity_limits=(1, 1))
    assert p.is_flat
    assert p.is_bounded
    assert same_points(p.vertices, [(0, 3), (0, -3)])
    assert (p.dimension, p.volume, p.extent([1, 0]), p.faces) == (1, 0.0, 0.0, ((0, 1),))
    assert p.limiting_facet([1, 0]) == ("within the limits no joint moves that way",)
    assert p.limiting_facet([0, 1]) == ("joint1 at its upper limit", "joint2 at its upper limit")
    assert "flat: within the limits no joint moves it along (1, 0)" in p.notes
    assert list(p.contains([(0, 2.9), (0, 3.1), (0.1, 0)])) == [True, False, False]


def test_a_flat_polygon_in_space():
    """All three rows of a planar arm: the hexagon in its plane, one polygon, two opposite facets that no joint makes."""
    p = ks.velocity_polytope(ks.load("planar_3r"), [0.1, 0.7, 0.9], task="position", velocity_limits=(1, 1, 1))
    plane = ks.velocity_polytope(ks.load("planar_3r"), [0.1, 0.7, 0.9], velocity_limits=(1, 1, 1))
    assert plane.rows == ("vx", "vy")  # vx, vy, wz mix units: the linear ones
    assert len(p.faces) == 1
    assert len(p.faces[0]) == len(p.vertices) == len(plane.vertices) == 6
    assert p.limiting.count(("within the limits no joint moves that way",)) == 2
    assert p.volume == 0.0
    assert_close(p.support([[1, 2, 0], [0, 0, 1]]), [plane.support([1, 2]), 0.0], 1e-12)


def test_a_point():
    """Joints that may not move leave one point, and so does a link that they turn about its own origin."""
    p = ks.velocity_polytope(ks.load("ur5e"), UR5E_Q, velocity_limits=np.zeros(6))
    assert (p.dimension, len(p.vertices), p.faces, p.volume) == (0, 1, ((0,),), 0.0)
    assert p.contains([0, 0, 0])
    assert not p.contains([1e-3, 0, 0])
    assert p.extent([1, 0, 0]) == p.support([1, 0, 0]) == 0.0


# --- known solids --------------------------------------------------------------------------------------------------

AXES = np.eye(3)
DIAGONALS = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)], dtype=float)
EDGES = np.array([(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)], dtype=float)
ICOSAHEDRON = np.array([(0, 1, GOLDEN), (0, 1, -GOLDEN), (1, GOLDEN, 0), (1, -GOLDEN, 0), (GOLDEN, 0, 1), (-GOLDEN, 0, 1)])
DODECAHEDRON = np.vstack(
    [DIAGONALS, [(0, 1 / GOLDEN, s * GOLDEN) for s in (1, -1)]]
    + [[(1 / GOLDEN, s * GOLDEN, 0), (s * GOLDEN, 0, 1 / GOLDEN)] for s in (1, -1)]
)
HALVES = np.vstack(
    [AXES, *([np.roll((s * 1.0, t * GOLDEN, 1 / GOLDEN), k) for k in range(3)] for s in (1, -1) for t in (1, -1))]
)


@pytest.mark.parametrize(
    ("generators", "corners", "polygons"),
    [
        (AXES, 8, {4: 6}),  # cube
        (np.vstack([AXES, (1, 1, 0)]), 12, {4: 6, 6: 2}),  # hexagonal prism: three generators in one plane
        (DIAGONALS, 14, {4: 12}),  # rhombic dodecahedron
        (
            np.vstack([DIAGONALS, DIAGONALS[::-1], -2 * DIAGONALS[:2], np.zeros((2, 3))]),
            14,
            {4: 12},
        ),  # parallel and zero ones
        (EDGES, 24, {4: 6, 6: 8}),  # truncated octahedron, the permutohedron of four
        (ICOSAHEDRON, 32, {4: 30}),  # rhombic triacontahedron
        (np.vstack([AXES, EDGES]), 48, {4: 12, 6: 8, 8: 6}),  # truncated cuboctahedron
        (HALVES, 120, {4: 30, 6: 20, 10: 12}),  # truncated icosidodecahedron
    ],
    ids=["cube", "prism", "rhombic-12", "parallel", "permutohedron", "rhombic-30", "cuboctahedron", "icosidodecahedron"],
)
@pytest.mark.parametrize("stretch", [1.0, 1e-6])
def test_zonohedra(generators, corners, polygons, stretch):
    """Known zonohedra: corners and polygons, whatever the size, and one coordinate a million times as small.

    Source: Coxeter, "Regular polytopes", section 2.8; the four last are those of the root systems A3, H3 (axes), B3, H3.
    """
    J = generators.T * np.array([[1.0], [stretch], [1e3]])
    p = image_of_box(J, -np.ones(len(generators)), np.ones(len(generators)), np.ones(3), **named(3, len(generators)))
    assert len(p.vertices) == corners
    sizes = [len(face) for face in p.faces]
    assert {size: sizes.count(size) for size in sizes} == polygons
    assert closes(p.faces, corners)


@pytest.mark.parametrize(
    ("normals", "limits", "corners", "polygons"),
    [
        (AXES, 1.0, 8, {4: 6}),  # cube
        (DIAGONALS, 1.0, 6, {3: 8}),  # octahedron
        (ICOSAHEDRON, 1.0, 20, {5: 12}),  # dodecahedron
        (DODECAHEDRON, 1.0, 12, {3: 20}),  # icosahedron: five planes in every corner
        (np.vstack([AXES, DIAGONALS]), np.r_[1, 1, 1, 2, 2, 2, 2], 12, {3: 8, 4: 6}),  # cuboctahedron
        (np.vstack([AXES, DIAGONALS, 3 * AXES[:2]]), np.r_[1, 1, 1, 5, 5, 5, 5, 3, 3], 8, {4: 6}),  # idle and twice
        (EDGES, 1.0, 14, {4: 12}),  # rhombic dodecahedron
    ],
    ids=["cube", "octahedron", "dodecahedron", "icosahedron", "cuboctahedron", "idle", "rhombic-12"],
)
@pytest.mark.parametrize("stretch", [1.0, 1e-6])
def test_solids_between_planes(normals, limits, corners, polygons, stretch):
    """Known solids as {x : |A x| <= b}: idle limits drop out, coincident ones make one facet."""
    A, limits = normals * np.array([1.0, stretch, 1e3]), limits * np.ones(len(normals))
    p = let_through(A, -limits, limits, np.ones(3), **named(3, len(A), "force"))
    assert len(p.vertices) == corners
    sizes = [len(face) for face in p.faces]
    assert {size: sizes.count(size) for size in sizes} == polygons
    assert closes(p.faces, corners)
    assert all(len(words) in (1, 2) for words in p.limiting)


def test_nearly_coplanar_generators_leave_no_gaps(monkeypatch):
    """Where no tolerance closes the surface, exact fractions do: right angles missed by 1e-17 to 1e-3."""
    taken = []
    exact = zonotopes.exact_planes
    monkeypatch.setattr(zonotopes, "exact_planes", lambda d: taken.append(1) or exact(d))
    rng = np.random.default_rng(3)
    for _ in range(60):
        G = rng.integers(-1, 2, (7, 3)) + 10.0 ** rng.uniform(-17, -3) * rng.normal(size=(7, 3)) * (rng.random((7, 3)) < 0.4)
        p = image_of_box(G.T, -np.ones(7), np.ones(7), np.ones(3), **named(3, 7))
        if p.is_flat:
            continue
        assert closes(p.faces, len(p.corners))
        assert np.all(p.contains(rng.uniform(-1, 1, (50, 7)) @ G))
        triples = [(a, b, c) for c in range(7) for b in range(c) for a in range(b)]
        assert_close(p.volume, 8 * sum(abs(np.linalg.det(G[list(t)])) for t in triples), 1e-9)
    assert taken


def test_planes_that_nearly_meet_in_a_point_leave_no_gaps(monkeypatch):
    """The same for sets of half-spaces."""
    taken = []
    exact = halfspaces.exact_corners
    monkeypatch.setattr(halfspaces, "exact_corners", lambda A, b: taken.append(1) or exact(A, b))
    rng = np.random.default_rng(5)
    for _ in range(150):
        A = rng.integers(-1, 2, (9, 3)) + 10.0 ** rng.uniform(-12, -6) * rng.normal(size=(9, 3)) * (rng.random((9, 3)) < 0.4)
        p = let_through(A, -np.ones(9), np.ones(9), np.ones(3), **named(3, 9, "force"))
        if p.is_bounded and not p.is_flat:
            assert closes(p.faces, len(p.corners))
            assert np.abs(p.corners @ A.T).max() <= 1 + 1e-9
    assert taken


# --- forces --------------------------------------------------------------------------------------------------------


def test_bent_leg():
    """Note 004, standing with bent legs: 250 N m in each joint push with 822 N through a knee at 90°; joint 2 stops it."""
    p = ks.force_polytope(LEG, [0.7854, QUARTER], gravity=None, effort_limits=(250, 250))
    assert round(p.extent([0, 1])) == 822
    assert p.limiting_facet([0, 1]) == ("joint2 at its lower limit",)
    assert (p.rows, p.unit, p.is_bounded, len(p.vertices)) == (("fx", "fy"), "N", True, 4)
    torques = p.vertices @ np.asarray(ks.jacobian(LEG, [0.7854, QUARTER]))[:2]
    assert_close(np.abs(torques), np.full((4, 2), 250.0), 1e-9)


def test_straight_leg_stands_for_free():
    """A straight leg carries any weight: a strip without end along y, |fx| <= 250 / 0.86, and nothing crashes."""
    p = ks.force_polytope(LEG, [QUARTER, 0], gravity=None, effort_limits=(250, 250))
    assert not p.is_bounded
    assert not p.is_flat
    assert p.vertices is None
    assert_close(np.abs(p.free), [[0.0, 1.0]], 1e-12)
    assert same_points(p.corners, [(250 / 0.86, 0), (-250 / 0.86, 0)], 1e-9)
    assert p.extent([0, 1]) == p.support([0.1, 1]) == p.volume == np.inf
    assert_close(p.extent([1, 0]), 250 / 0.86, 1e-12)
    assert p.limiting_facet([0, -1]) == ()
    assert p.limiting_facet([1, 0]) == ("joint1 at its lower limit",)
    assert list(p.contains([(0, 1e9), (290, -1e9), (291, 0)])) == [True, True, False]
    assert p.to_dict()["vertices"] is None
    assert "without end along (0, 1)" in str(p)


def test_an_edge_without_end():
    """A cable pulls and never pushes: limits on one side leave rays, and corners where they start."""
    p = ks.force_polytope(LEG, [0.7854, QUARTER], gravity=None, effort_limits=([-np.inf, -np.inf], [250, 250]))
    assert not p.is_bounded
    assert len(p.corners) == 1
    assert len(p.rays) == 2
    assert p.free.shape == (0, 2)
    J = np.asarray(ks.jacobian(LEG, [0.7854, QUARTER]))[:2]
    assert_close(p.corners[0] @ J, [250.0, 250.0], 1e-9)
    assert np.all(p.rays @ J <= 1e-12)
    assert np.all(p.contains(p.corners + 1e3 * np.array([[1, 2], [0, 5.0]]) @ p.rays))


def test_a_joint_that_cannot_hold_its_own_weight():
    """Pushing with link 1 does not help joint 2: there is no force at all, and joint 2 is named."""
    arm = ks.load("planar_2r")
    down = (0, -9.81, 0)
    held = ks.gravity_torques(arm, [0, 0], gravity=down)
    p = ks.force_polytope(arm, [0, 0], at="link1", point=(1, 0, 0), gravity=down, effort_limits=(100, 0.5 * held[1]))
    assert p.is_empty
    assert not p.is_flat
    assert (p.dimension, p.volume, p.center, len(p.vertices)) == (-1, 0.0, None, 0)
    assert p.extent([0, 1]) == p.support([0, 1]) == -np.inf
    assert not p.contains([0, 0])
    assert p.limiting_facet([0, 1]) == ()
    assert "joint 'joint2'" in p.notes[-1]
    assert p.to_dict()["empty"] is True


def test_an_arm_that_must_lean_on_something():
    """Too weak for its weight alone, but not when its tip rests on a table: zero is outside, a push is inside."""
    arm = ks.load("planar_2r")
    down = (0, -9.81, 0)
    held = ks.gravity_torques(arm, [0.3, 0.4], gravity=down)
    p = ks.force_polytope(arm, [0.3, 0.4], gravity=down, effort_limits=0.8 * held)
    assert not p.is_empty
    assert not p.contains([0, 0])
    assert p.contains(p.center)
    assert p.center[1] < 0  # it presses the table down
    assert any("zero is not in it" in note for note in p.notes)
    near, far = -p.extent(-p.center), p.extent(p.center)
    assert 0 < near < np.linalg.norm(p.center) < far
    assert p.extent(-p.center) < 0
    assert p.extent([p.center[1], -p.center[0]]) == -np.inf or not p.contains([0, 0])


def test_the_weight_shifts_the_forces():
    """With gravity the polytope of even limits is not even, and its extent is `force_capacity` in all directions."""
    arm = ks.load("ur5e")
    p = ks.force_polytope(arm, UR5E_Q)
    rng = np.random.default_rng(0)
    for d in rng.normal(size=(30, 3)):
        assert_close(p.extent(d), ks.force_capacity(arm, UR5E_Q, d).value, 1e-10)
    without = ks.force_polytope(arm, UR5E_Q, gravity=None)
    assert same_points(without.vertices, -without.vertices, 1e-6)
    assert p.support([0, 0, 1]) != pytest.approx(p.support([0, 0, -1]))
    assert without.notes == ("the weight of the arm is left out",)
    six = ks.force_polytope(arm, UR5E_Q, task="full")
    assert (six.vertices, six.faces, six.unit) == (None, (), "N, N m")
    assert_close(six.extent([1, 2, 3, 0, 0, 0]), p.extent([1, 2, 3]), 1e-10)  # no moment
    assert six.support([0, 0, 1, 0, 0, 0]) > p.support([0, 0, 1])  # moments help


@pytest.mark.parametrize("name", ["ur5e", "panda", "iiwa_14"])
@pytest.mark.parametrize("task", ["position", "orientation", "full"])
def test_real_arms_with_the_limits_of_their_makers(name, task):
    """Catalogue limits: closed surfaces, corners within all limits, every facet made by a joint."""
    arm = ks.load(name)
    for q in arm.random_configurations(3, 7):
        J = np.asarray(ks.jacobian(arm, q))[list(ks.find_task(arm, task).rows)]
        v = ks.velocity_polytope(arm, q, task=task)
        f = ks.force_polytope(arm, q, task=task, gravity=None)
        assert v.is_bounded
        assert f.is_bounded
        assert all(words != ("within the limits no joint moves that way",) for words in (*v.limiting, *f.limiting))
        if task == "full":
            assert len(v.offsets) == {"ur5e": 12, "panda": 42, "iiwa_14": 32}[name]  # at most 2 C(n, 5)
            continue
        assert closes(v.faces, len(v.vertices))
        assert closes(f.faces, len(f.vertices))
        assert np.all(np.abs(f.vertices @ J) <= arm.effort_limits * (1 + 1e-9))
        assert np.all((np.abs(np.abs(f.vertices @ J) - arm.effort_limits) <= 1e-9 * arm.effort_limits).sum(axis=1) >= 3)


def test_support_of_six_rows_near_a_singularity():
    """Six rows and six joints: h(d) = Σ t_i |J⁻¹ d|_i in closed form, up to a wrist 1e-9 rad from straight."""
    arm = ks.load("ur5e")
    for bend in (1e-1, 1e-3, 1e-5, 1e-7, 1e-9):
        q = [0.3, -1, 1.5, -0.5, bend, 0.2]
        p = ks.force_polytope(arm, q, task="full", gravity=None)
        J = np.asarray(ks.jacobian(arm, q))
        for d in (np.eye(6)[2], np.array([1.0, 2, 3, -1, 0.5, 0.1])):
            wanted = np.abs(np.linalg.solve(J, d)) @ arm.effort_limits
            assert abs(p.support(d) / wanted - 1) <= 1e-14 / bend + 1e-12
    at_it = ks.force_polytope(arm, [0.3, -1, 1.5, -0.5, 0, 0.2], task="full", gravity=None)
    assert not at_it.is_bounded
    assert at_it.support(d) == np.inf
    assert at_it.support(at_it.normals[0]) <= at_it.offsets[0] * (1 + 1e-9)  # at right angles to what is free


def test_a_redundant_arm_has_no_choice_of_torques():
    """At rest all seven torques are those of the force: each of the seven can be the one that stops it."""
    arm = ks.load("panda")
    q = arm.home + 0.3
    p = ks.force_polytope(arm, q, gravity=None)
    J = np.asarray(ks.jacobian(arm, q))[:3]
    for d in unit_vectors(20, 1):
        shares = np.abs(J.T @ d) / arm.effort_limits
        assert_close(p.extent(d), 1 / shares.max(), 1e-10)
        assert p.limiting_facet(d)[0].startswith(arm.joint_names[int(shares.argmax())])


# --- speeds --------------------------------------------------------------------------------------------------------


def test_speed_of_a_planar_arm_by_hand():
    """At (0, 90°) along x: q̇ = (0, -1), so 1 m/s at 1 rad/s, joint 2 at its lower limit."""
    s = ks.speed_capacity(ks.load("planar_2r"), [0, QUARTER], (2, 0, 0), velocity_limits=(1, 1))
    assert_close(s.value, 1.0, 1e-12)
    assert_close(s.rates, [0.0, -1.0], 1e-12)
    assert s.limiting_joints == ["joint2"]
    assert list(s.limiting) == [0, -1]
    assert (s.unit, s.held, s.is_lost) == ("m/s", (), False)
    out = ks.speed_capacity(ks.load("planar_2r"), [0, QUARTER], (0, 0, 1), velocity_limits=(1, 1))
    assert (out.value, out.is_lost, out.limiting_joints) == (0.0, True, [])


def test_speed_with_and_without_the_orientation():
    """Free to turn an arm is never slower; held, its rates turn the tool by nothing."""
    arm = ks.load("ur5e")
    held, free = (ks.speed_capacity(arm, UR5E_Q, (1, 1, 0), hold=hold) for hold in ("orientation", "nothing"))
    assert 0 < held.value < free.value
    J = ks.jacobian(arm, UR5E_Q)
    assert_close(J.twist(held.rates).array, [*(held.value * held.direction), 0, 0, 0], 1e-9)
    assert_close(J.twist(free.rates).linear, free.value * free.direction, 1e-9)
    assert (held.held, free.held) == (("wx", "wy", "wz"), ())
    assert_close(free.value, ks.velocity_polytope(arm, UR5E_Q).extent([1, 1, 0]), 1e-10)
    assert np.abs(held.rates).max() == pytest.approx(np.pi)


def test_spare_joints_help():
    """The greatest speed of a seven-joint arm beats that of the smallest rates, and meets the polytope of six rows."""
    arm = ks.load("panda")
    q = arm.home + 0.2
    J = np.asarray(ks.jacobian(arm, q))
    gained = 0
    for d in unit_vectors(10, 0):
        s = ks.speed_capacity(arm, q, d)
        smallest = np.linalg.pinv(J) @ np.r_[d, 0, 0, 0]
        plain = 1 / np.abs(smallest / arm.velocity_limits).max()
        gained += s.value > plain * 1.01
        assert s.value >= plain * (1 - 1e-12)
        assert_close(s.value, ks.velocity_polytope(arm, q, task="full").extent(np.r_[d, 0, 0, 0]), 1e-9)
    assert gained >= 5


def test_speed_of_a_twist_and_in_other_axes():
    """Six numbers are a twist, had so many times; three in the axes of the tool go where the tool points."""
    arm = ks.load("ur5e")
    twist = np.array([0.1, 0, 0.2, 0, 0.3, -0.1])
    s = ks.speed_capacity(arm, UR5E_Q, twist)
    assert s.unit == "times the twist"
    assert_close(ks.jacobian(arm, UR5E_Q).twist(s.rates).array, s.value * twist, 1e-9)
    R = ks.pose(arm, UR5E_Q).rotation
    tool = ks.speed_capacity(arm, UR5E_Q, (0, 0, 1), frame=ks.Frame.body())
    assert_close(tool.value, ks.speed_capacity(arm, UR5E_Q, R[:, 2]).value, 1e-9)
    fewer = ks.speed_capacity(arm, UR5E_Q, (1, 0, 0), task=["vx"])
    assert fewer.rows == ("vx",)
    assert_close(fewer.value, ks.velocity_polytope(arm, UR5E_Q, task="vx").extent([1]), 1e-10)


def test_speeds_of_a_batch():
    """Batches of q, of directions and of both; each entry is what it is alone."""
    arm = ks.load("ur5e")
    q, d = arm.random_configurations(4, 3), np.random.default_rng(0).normal(size=(4, 3))
    s = ks.speed_capacity(arm, q, d)
    assert s.value.shape == s.is_lost.shape == (4,)
    assert s.rates.shape == s.limiting.shape == (4, 6)
    for i in range(4):
        one = ks.speed_capacity(arm, q[i], d[i])
        assert_close(s.value[i], one.value, 1e-12)
        assert s.limiting_joints[i] == one.limiting_joints
    rose = ks.speed_capacity(arm, q[0], np.stack([d, -d]))
    assert rose.value.shape == (2, 4)
    assert_close(rose.value[0], rose.value[1], 1e-10)  # even limits
    assert "batch of shape (2, 4)" in str(rose)
    assert ks.speed_capacity(arm, np.zeros((0, 6)), (1, 0, 0)).rates.shape == (0, 6)
    json.dumps(rose.to_dict())


def test_joints_that_go_one_way_only():
    """A lower limit of zero: the other way there is no speed, and the joint is named."""
    s = ks.speed_capacity(ks.load("planar_2r"), [0, QUARTER], (1, 0, 0), velocity_limits=([0, 0], [1, 1]))
    assert s.value == 0.0
    assert not s.is_lost
    assert s.limiting_joints == ["joint2"]


# --- arguments, words, data ----------------------------------------------------------------------------------------


def test_what_is_refused():
    """Every mistake has its code."""
    arm, ur5e = ks.load("planar_2r"), ks.load("ur5e")
    cases = [
        ("KS366", lambda: ks.velocity_polytope(arm, [0, 1])),
        ("KS366", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits=(1, np.inf))),
        ("KS366", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits={"joint1": 1})),
        ("KS366", lambda: ks.force_polytope(arm, [0, 1])),
        ("KS366", lambda: ks.force_polytope(arm, [0, 1], effort_limits={"joint1": 5})),
        ("KS366", lambda: ks.speed_capacity(arm, [0, 1], (1, 0, 0))),
        ("KS367", lambda: ks.speed_capacity(ur5e, UR5E_Q, (0, 0, 0))),
        ("KS367", lambda: ks.velocity_polytope(ur5e, UR5E_Q).extent([0, 0, 0])),
        ("KS368", lambda: ks.velocity_polytope(ur5e, UR5E_Q, at="base")),
        ("KS303", lambda: ks.velocity_polytope(ur5e, UR5E_Q, task="full").volume),
        ("KS320", lambda: ks.force_polytope(ks.load("panda"), np.zeros(7))),
        ("KS318", lambda: ks.velocity_polytope(ur5e, UR5E_Q, task="sideways")),
        ("KS313", lambda: ks.velocity_polytope(ur5e, UR5E_Q, velocity_limits={"elbow": 1})),
        ("KS310", lambda: ks.velocity_polytope(ur5e, UR5E_Q, at="hand")),
        ("KS303", lambda: ks.velocity_polytope(ur5e, np.zeros((2, 6)))),
        ("KS303", lambda: ks.velocity_polytope(ur5e, UR5E_Q, velocity_limits=(1, 1))),
        ("KS303", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits=(-1, 1))),
        ("KS303", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits=(np.nan, 1))),
        ("KS303", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits="fast")),
        ("KS303", lambda: ks.velocity_polytope(arm, [0, 1], velocity_limits={"joint1": (1, 2, 3)})),
        ("KS303", lambda: ks.velocity_polytope(ur5e, UR5E_Q).contains([1, 2])),
        ("KS303", lambda: ks.velocity_polytope(ur5e, UR5E_Q).limiting_facet(np.eye(3))),
        ("KS303", lambda: ks.speed_capacity(ur5e, UR5E_Q, (1, 0))),
        ("KS303", lambda: ks.speed_capacity(ur5e, UR5E_Q, (1, 0, 0), hold="breath")),
        ("KS303", lambda: ks.speed_capacity(ur5e, UR5E_Q, (1, 0, 0), velocity_limits=(np.ones(6), 2 * np.ones(6)))),
        ("KS303", lambda: ks.speed_capacity(ur5e, np.zeros((2, 6)), np.ones((3, 3)))),
        ("KS301", lambda: ks.velocity_polytope(ur5e, [np.nan] * 6)),
        ("KS301", lambda: ks.velocity_polytope(ur5e, UR5E_Q).support([np.inf, 0, 0])),
        ("KS301", lambda: ks.speed_capacity(ur5e, UR5E_Q, (np.nan, 0, 0))),
        ("KS302", lambda: ks.velocity_polytope("ur5e", UR5E_Q)),
    ]
    for code, call in cases:
        with pytest.raises(ks.KinestaticsError) as caught:
            call()
        assert caught.value.code == code, caught.value
        assert caught.value.hint or code in ("KS310", "KS318")


def test_symbols_and_other_libraries():
    """Symbols are refused, tensors are taken for their numbers."""
    sympy = pytest.importorskip("sympy")
    arm = ks.load("ur5e")
    x = sympy.Symbol("x")
    for call in (
        lambda: ks.velocity_polytope(arm, [x, 0, 0, 0, 0, 0]),
        lambda: ks.speed_capacity(arm, UR5E_Q, (x, 0, 0)),
        lambda: ks.velocity_polytope(arm, UR5E_Q).extent([x, 0, 0]),
    ):
        with pytest.raises(ks.ArrayTypeError) as caught:
            call()
        assert caught.value.code == "KS302"
    torch = pytest.importorskip("torch")
    q = torch.tensor(UR5E_Q, dtype=torch.float64, requires_grad=True)
    assert same_points(ks.velocity_polytope(arm, q).vertices, ks.velocity_polytope(arm, UR5E_Q).vertices)
    assert same_points(ks.force_polytope(arm, q).vertices, ks.force_polytope(arm, UR5E_Q).vertices)
    assert ks.speed_capacity(arm, q, torch.tensor([1.0, 0, 0])).value == ks.speed_capacity(arm, UR5E_Q, (1, 0, 0)).value


def test_joints_beyond_the_link_do_not_count():
    """The forearm needs no limits of the wrist, and a joint that sets no effort limit may be said to."""
    arm = ks.load("ur5e")
    p = ks.velocity_polytope(arm, UR5E_Q, at="forearm_link", velocity_limits={f"wrist_{i}_joint": np.inf for i in (1, 2, 3)})
    assert {word for words in p.limiting for word in words} <= {
        f"{name} at its {side} limit" for name in arm.joint_names[:3] for side in ("upper", "lower")
    } | {"within the limits no joint moves that way"}
    leg = ks.force_polytope(LEG, [0.7854, QUARTER], gravity=None, effort_limits=(np.inf, 250))
    assert not leg.is_bounded
    assert len(leg.free) == 1


def test_the_origin_of_the_frame_is_where_the_moment_is_zero():
    """A point of the tool, and other axes: the frame says where the force acts."""
    arm = ks.load("ur5e")
    p = ks.force_polytope(arm, UR5E_Q, point=(0, 0, 0.2), gravity=None)
    J = np.asarray(ks.jacobian(arm, UR5E_Q, point=(0, 0, 0.2)))[:3]
    assert_close(p.extent([0, 0, 1]), 1 / (np.abs(J[2]) / arm.effort_limits).max(), 1e-10)
    assert p.frame.offset == (0.0, 0.0, 0.2)


def test_mixed_rows_are_told_by_their_units():
    """Three rows of two units have corners too; the unit says both."""
    p = ks.velocity_polytope(ks.load("planar_3r"), [0.1, 0.7, 0.9], task="vx,vy,wz", velocity_limits=(1, 1, 1))
    assert (p.unit, len(p.vertices), len(p.faces)) == ("m/s, rad/s", 8, 6)
    assert p.rows == ("vx", "vy", "wz")


def test_words_and_data():
    """Printed lines keep to 80 columns, dictionaries go through JSON, results go through pickle and cannot be set."""
    arm = ks.load("ur5e")
    results = [
        ks.velocity_polytope(arm, UR5E_Q),
        ks.velocity_polytope(arm, np.zeros(6), task="orientation"),
        ks.force_polytope(arm, UR5E_Q, task="full"),
        ks.force_polytope(arm, np.zeros(6), effort_limits={"elbow_joint": 1}),
        ks.force_polytope(LEG, [QUARTER, 0], gravity=None, effort_limits=(250, 250)),
        ks.speed_capacity(arm, UR5E_Q, (1, 0, 0)),
        ks.speed_capacity(arm, np.zeros(6), (1, 0, 0)),
        ks.velocity_polytope(ks.load("planar_2r"), [0, 0], task="vy", velocity_limits=(1, 1)),
    ]
    for result in results:
        assert max(len(line) for line in str(result).splitlines()) <= 80
        assert repr(result).startswith(f"<{type(result).__name__}")
        json.dumps(result.to_dict())
        assert str(pickle.loads(pickle.dumps(result))) == str(result)
        with pytest.raises(AttributeError):
            result.frame = None
    assert "length 6 m/s" in str(results[-1])
    assert "(m/s)^3" in str(results[0])


def test_inputs_stay_as_they_are():
    """Neither q nor limits nor directions change."""
    arm = ks.load("ur5e")
    q, limits, d = np.array(UR5E_Q, dtype=float), arm.velocity_limits.copy(), np.array([0.0, 2.0, 0.0])
    p = ks.velocity_polytope(arm, q, velocity_limits=limits)
    p.extent(d)
    ks.speed_capacity(arm, q, d, velocity_limits=limits)
    ks.force_polytope(arm, q, effort_limits=(-limits, limits), gravity=None)
    assert np.array_equal(q, UR5E_Q)
    assert np.array_equal(limits, arm.velocity_limits)
    assert np.array_equal(d, [0, 2, 0])
