"""Scenes: what is drawn is where the floors below say it is. No browser here: handles of viser hold what was sent."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import kinestatics as ks
from kinestatics.scene.placing import between, quaternions, turned_to
from kinestatics.skeleton import rigid_lines, skeleton
from kinestatics.spatial import quaternion_to_rotation
from strategies import features

viser = pytest.importorskip("viser", reason="the extra view is not installed")

from kinestatics.scene.arm_scene import ArmScene, View, fitting_view  # noqa: E402
from kinestatics.scene.export import scene_html  # noqa: E402
from kinestatics.scene.guard import guarded_server  # noqa: E402
from kinestatics.scene.robot import RobotBody  # noqa: E402
from kinestatics.scene.signs import arrow_strokes, free_strokes, lost_strokes  # noqa: E402

SIGMA = 5e-7  # what single precision, in which viser sends, leaves of a length of a metre


@pytest.fixture(scope="module", name="server")
def server_fixture():
    with guarded_server() as guarded:
        yield guarded.server


def placed(body, model):
    """(R, p) of every frame in base axes: those of viser hang on each other as the joints do."""
    found = []
    for handle, parent in zip(body._frames, model.parents, strict=True):
        R, p = quaternion_to_rotation(*map(float, handle.wxyz)), np.array(handle.position)
        found.append((R, p) if parent < 0 else (found[parent][0] @ R, found[parent][1] + found[parent][0] @ p))
    return found


def unit(values):
    vector = np.array(values)
    return vector / np.linalg.norm(vector)


directions = st.tuples(*[st.floats(-1, 1) for _ in range(3)]).filter(lambda v: np.linalg.norm(v) > 1e-3).map(unit)


@given(st.tuples(*[st.floats(-1, 1) for _ in range(4)]).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_quaternions_give_their_rotation_back(values):
    """R(q(R)) = R, for half turns too; the real part is not negative."""
    R = quaternion_to_rotation(*unit(values))
    q = quaternions(R)
    assert q[0] >= 0
    np.testing.assert_allclose(quaternion_to_rotation(*q), R, atol=1e-14)
    np.testing.assert_allclose(quaternions(np.stack([R, np.eye(3)])), [q, [1, 0, 0, 0]], atol=1e-15)


@given(directions)
def test_turned_to_takes_z_to_a_direction(direction):
    """A rotation, whose last column is the direction."""
    R = turned_to(direction)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0
    np.testing.assert_array_equal(R[:, 2], direction)


def test_between_reaches_from_point_to_point():
    """The axis of the cylinder, from z = -1/2 to 1/2, scaled, turned and moved, runs from one point to the other."""
    start, end = np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.4, -0.1])
    wxyz, position, scale = between(start, end, 0.02)
    R = quaternion_to_rotation(*wxyz)
    np.testing.assert_allclose(position - R @ [0, 0, scale[2] / 2], start, atol=1e-12)
    np.testing.assert_allclose(position + R @ [0, 0, scale[2] / 2], end, atol=1e-12)
    assert scale[:2] == (0.02, 0.02)


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_rigid_lines_are_those_of_every_posture(name):
    """The lines of the links, moved with their joints, are the lines of the skeleton at a random posture."""
    arm = ks.load(name)
    q = arm.random_configurations(1, 3)[0]
    bones = skeleton(arm, q)
    moved = []
    for carrier, line in rigid_lines(arm):
        R, p = bones.frames[carrier] if carrier >= 0 else (np.eye(3), np.zeros(3))
        moved.append(line @ R.T + p)
    expected = {tuple(np.round(line, 6).ravel() + 0.0) for line in bones.links}
    assert expected <= {tuple(np.round(line, 6).ravel() + 0.0) for line in moved}


@pytest.mark.parametrize("name", ["ur5e", "scara", "stanford_arm", "planar_3r", "rrp_note_000"])
def test_frames_and_rods_follow_the_posture(server, name):
    """Every joint's frame is where the definition has it; what a sliding joint has pushed out ends there."""
    arm = ks.load(name)
    server.scene.reset()
    scene = ArmScene(server, arm)
    q = arm.random_configurations(1, 5)[0]
    a = ks.analyze(arm, q, brief=True)
    scene.update(a, View())
    bones = skeleton(arm, q)
    for (R_drawn, p_drawn), (R, p) in zip(placed(scene.body, arm), bones.frames, strict=True):
        np.testing.assert_allclose(p_drawn, p, atol=2 * SIGMA)
        np.testing.assert_allclose(R_drawn, R, atol=1e-6)
    np.testing.assert_allclose(np.array(scene._tip.position), np.array(a.pose.translation), atol=SIGMA)
    for i, rod in scene.body._rods.items():
        R, p = bones.frames[arm.parents[i]] if arm.parents[i] >= 0 else (np.eye(3), np.zeros(3))
        middle, along = np.array(rod.position), quaternion_to_rotation(*map(float, rod.wxyz))[:, 2] * rod.scale[2]
        np.testing.assert_allclose(p + R @ (middle + along / 2), bones.frames[i][1], atol=1e-6)


def test_ellipsoid_has_the_radii_of_the_analysis(server):
    """Half-axes of the drawn ball are the radii, times the scale, along the axes of the ellipsoid, at the tip."""
    arm = ks.load("ur5e")
    server.scene.reset()
    scene = ArmScene(server, arm)
    a = ks.analyze(arm, [0.3, -1.2, 1.3, -0.6, 1.0, 0.2], brief=True)
    scene.update(a, View(velocity_scale=0.25))
    ball = scene._velocity._ball
    assert ball.visible
    place = scene._velocity._place
    drawn = quaternion_to_rotation(*map(float, place.wxyz)) * np.array(ball.scale)
    wanted = 0.25 * a.velocity_ellipsoid.axes * a.velocity_ellipsoid.radii
    np.testing.assert_allclose(drawn @ drawn.T, wanted @ wanted.T, atol=1e-6)
    np.testing.assert_allclose(np.array(place.position), np.array(a.pose.translation), atol=SIGMA)


def test_flat_and_unbounded_bodies(server):
    """At a stretched elbow the velocity ellipsoid is a thin line, the force ellipsoid lines without end; signs appear."""
    arm = ks.load("planar_2r")
    server.scene.reset()
    scene = ArmScene(server, arm)
    singular, regular = (ks.analyze(arm, [0.4, bend], brief=True) for bend in (0.0, 1.0))
    scene.update(singular, View(force="ellipsoid", velocity_scale=1.0))
    radii = sorted(scene._velocity._ball.scale)
    assert radii[0] == radii[1] < 0.01 < radii[2]
    assert not scene._force._ball.visible
    assert scene._force._edges.visible
    assert scene._lost._arrows.visible
    assert scene._free._arrows.visible
    scene.update(regular, View(force="ellipsoid"))
    assert scene._force._ball.visible
    assert not scene._lost._arrows.visible
    assert not scene._free._arrows.visible


def test_polytope_is_drawn_with_its_own_corners(server):
    """The vertices of the mesh are the corners, scaled, at the tip; triangles cover each face."""
    arm = ks.load("ur5e")
    server.scene.reset()
    scene = ArmScene(server, arm)
    q = [0.3, -1.2, 1.3, -0.6, 1.0, 0.2]
    a, polytope = ks.analyze(arm, q, brief=True), ks.velocity_polytope(arm, q, task="position")
    scene.update(a, View(velocity="polytope", velocity_scale=0.1), (polytope, None))
    mesh, tip = scene._velocity._mesh, np.array(a.pose.translation)
    drawn = {tuple(np.round((vertex - tip) / 0.1, 3) + 0.0) for vertex in np.array(mesh.vertices, dtype=float)}
    assert drawn == {tuple(np.round(corner, 3) + 0.0) for corner in polytope.corners}
    assert len(mesh.faces) == sum(len(face) - 2 for face in polytope.faces)


def test_load_arrow_points_as_the_force_does(server):
    """The arrow starts at the tip and is the force at scale, from whichever frame it was given in."""
    arm = ks.load("ur5e")
    server.scene.reset()
    scene = ArmScene(server, arm)
    q = [0.3, -1.2, 1.3, -0.6, 1.0, 0.2]
    R = np.array(ks.pose(arm, q).rotation)
    for wrench in (
        ks.Wrench.on_robot(force=(0, 0, -50)),
        ks.Wrench.on_robot(force=R.T @ [0, 0, -50], frame=ks.Frame.body()),
    ):
        a = ks.analyze(arm, q, wrench, brief=True)
        scene.update(a, View())
        ((start, end),) = np.array(scene._load._arrows.points, dtype=float)
        np.testing.assert_allclose(start, np.array(a.pose.translation), atol=SIGMA)
        np.testing.assert_allclose(end - start, scene.metres_per_newton * np.array([0, 0, -50]), atol=1e-6)


def test_screws_are_drawn_along_their_axes():
    """Lost and free signs of a wrist's singularity lie on the lines that the analysis names."""
    arm = ks.load("puma_560")
    a = ks.analyze(arm, [0.1, 0.4, -1.0, 0.3, 0.0, 0.2], brief=True)
    tip = np.array(a.pose.translation)
    for strokes, screws in (
        (lost_strokes(a.lost_twists, tip, 1.0), a.lost_twists),
        (free_strokes(a.free_wrenches, tip, 1.0), a.free_wrenches),
    ):
        assert strokes is not None
        (screw,) = screws
        arrows = strokes.arrows[:, 1] - strokes.arrows[:, 0]
        assert np.all(np.isfinite(strokes.lines))
        if screw.kind in ("translation", "force"):
            np.testing.assert_allclose(np.abs(arrows @ screw.direction), np.linalg.norm(arrows, axis=1), rtol=1e-9)
    assert lost_strokes((), tip, 1.0) is None
    assert arrow_strokes(tip, np.zeros(3), np.zeros(3), 1.0, 1.0) is None


def test_view_that_fits_is_round_and_seen():
    """Scales have one digit, and make the largest radius about a third of the arm."""
    a = ks.analyze(ks.load("ur5e"), None, brief=True)
    view = fitting_view(a, 1.0)
    for scale, ellipsoid in ((view.velocity_scale, a.velocity_ellipsoid), (view.force_scale, a.force_ellipsoid)):
        assert float(f"{scale:.1g}") == scale
        assert 0.15 < scale * ellipsoid.radii.max() < 0.6


def test_exported_scene_is_one_document():
    """Whole, small, with nothing to fetch."""
    text = scene_html(ks.load("planar_2r"), [0.3, 0.0])
    assert text.startswith("<!doctype html>")
    assert len(text) < 2_000_000


@settings(max_examples=15, deadline=None)
@given(features())
def test_any_mechanism_can_be_drawn(server, mechanism):
    """Random chains and trees with mimic, helical and sliding joints: frames are where the definition has them."""
    model, q = mechanism.model(), mechanism.configurations()
    server.scene.reset()
    body = RobotBody(server.scene, model, 1.0)
    body.place(q)
    for (_, drawn), (_, p) in zip(placed(body, model), skeleton(model, q).frames, strict=True):
        np.testing.assert_allclose(drawn, p, atol=1e-5 * max(1.0, float(np.abs(p).max())))
