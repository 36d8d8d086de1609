"""Pictures: what is drawn is where it should be, at true scale, inside the paper, and leaves nothing behind."""

import io
import re
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from matplotlib import pyplot as plt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from mpl_toolkits.mplot3d import proj3d

import kinestatics as ks
from kinestatics import palette, plots
from kinestatics.bodies import ellipsoid_body, polytope_body
from kinestatics.plots import style
from kinestatics.plots.artists import (
    FlatArrow,
    FlatLeader,
    SpaceArrow,
    SpaceFaces,
    SpaceLeader,
    SpaceLines,
    SpaceSolid,
)
from kinestatics.plots.boxes import Surroundings, Wanted, boxes_about, lengths_inside, spread
from kinestatics.plots.outlines import arrow_outline, hull
from kinestatics.plots.words import merged, places
from kinestatics.skeleton import plane_of, skeleton
from strategies import features

mpl.use("Agg")

NAMED = (
    "elbow_rrr", "gen3", "iiwa_14", "irb_140", "panda", "planar_2r", "planar_3r", "puma_560", "scara", "stanford_arm",
    "ur3e", "ur5e",
)  # fmt: skip
BENT, STRAIGHT = [0.4, 0.9], [0.4, 0.0]
Q = {"ur5e": [0.3, -1.2, 1.4, 0.2, 0.5, 0.1], "panda": None, "scara": None}
BLUE, ORANGE = mpl.colors.to_rgba(palette.VELOCITY), mpl.colors.to_rgba(palette.FORCE)


@pytest.fixture(autouse=True)
def nothing_stays():
    """No picture changes settings of matplotlib or leaves a figure to pyplot."""
    before = dict(mpl.rcParams)
    yield
    assert plt.get_fignums() == []
    assert dict(mpl.rcParams) == before


def lines_of(ax, color):
    """(k, 2 or 3) points of every line of a colour, but for those that are drawn for the key."""
    if ax.name == "3d":
        found = [a for a in ax.collections if isinstance(a, SpaceLines) and np.allclose(a.get_colors()[0], color)]
        return [line for artist in found for line in artist.points]
    found = [line for line in ax.lines if mpl.colors.to_rgba(line.get_color()) == color and line.get_linestyle() == "-"]
    return [line.get_xydata() for line in found if len(line.get_xydata()) > 1]


def solid_of(ax, color):
    """(k, 2 or 3) points that span the coloured body."""
    if ax.name == "3d":
        return [
            a.points
            for a in ax.collections
            if isinstance(a, SpaceSolid) and np.allclose(a.get_facecolor()[0][:3], color[:3])
        ]
    return [patch.get_xy() for patch in ax.patches if np.allclose(patch.get_facecolor()[:3], color[:3])]


def crossed(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def space():
    """Axes of space that are not laid out, which takes most of the time."""
    return Figure().add_subplot(projection="3d")


def key_of(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


# the arm


@settings(max_examples=25)
@given(features(max_joints=6))
def test_links_are_rigid_and_joints_lie_on_their_axes(f):
    """Between any two postures the lines of a link keep their lengths; a joint does not move the point it is drawn at."""
    model = f.model()
    rng = np.random.default_rng(f.seed)
    q = rng.normal(size=(2, model.n))
    a, b = (skeleton(model, x, "base") for x in q)
    assert len(a.joints) == len(model.parents)
    for i, parent in enumerate(model.parents):
        lengths = [np.linalg.norm(s.joints[i].point - (s.joints[parent].end if parent >= 0 else 0)) for s in (a, b)]
        assert abs(lengths[0] - lengths[1]) <= 1e-9 * max(1.0, *lengths)
        for bones, x in ((a, q[0]), (b, q[1])):
            joint = bones.joints[i]
            moved = model.multipliers[i] * x[model.columns[i]] + model.offsets[i]
            slid = (joint.end - joint.point) @ joint.direction
            pitch = model.screws[i, :3] @ model.screws[i, 3:] if model.kinds[i] != "prismatic" else 1.0
            assert abs(slid - pitch * moved) <= 1e-9 * max(1.0, abs(slid))
    alone = [i for i, column in enumerate(model.columns) if model.columns.count(column) == 1 and model.multipliers[i]]
    for i in alone:
        turned = np.array(q[0])
        turned[model.columns[i]] += 0.7
        after = skeleton(model, turned, "base").joints[i]
        np.testing.assert_allclose(after.point, a.joints[i].point, atol=1e-9 * a.size)
        np.testing.assert_allclose(after.direction, a.joints[i].direction, atol=1e-9)


@settings(max_examples=25)
@given(features(max_joints=6, mimic=False))
def test_the_tip_and_every_branch_is_where_pose_says(f):
    """The frame of the tip, and the farthest link behind every last joint, hang on the lines drawn."""
    model = f.model()
    q = f.configurations()
    bones = skeleton(model, q)
    T = ks.pose(model, q).array
    np.testing.assert_allclose(bones.tip[0], T[:3, :3], atol=1e-12)
    np.testing.assert_allclose(bones.tip[1], T[:3, 3], atol=1e-12 * bones.size)
    leaves = [i for i in range(len(model.parents)) if i not in model.parents]
    ends = bones.points
    for i in leaves:
        origins = [ks.pose(model, q, at=model.link_name(k)).translation for k, j in enumerate(model.link_joints) if j == i]
        nearest = [np.linalg.norm(ends - origin, axis=1).min() for origin in origins]
        assert not origins or min(nearest) <= 1e-8 * bones.size


def stays_in_a_plane(model):
    """Brute force: whether points of all moving links only ever move at right angles to one direction, and not on a line."""
    rng = np.random.default_rng(7)
    columns = []
    for link, joint in enumerate(model.link_joints):
        for point in rng.normal(size=(3, 3)) if joint >= 0 else ():
            q = rng.normal(size=(4, model.n))
            J = ks.jacobian(model, q, at=model.link_name(link), point=tuple(point)).linear
            columns.append(np.moveaxis(J, 1, 0).reshape(3, -1))
    if not columns:
        return False
    sigma = np.linalg.svd(np.concatenate(columns, axis=1), compute_uv=False)
    return int((sigma > 1e-6 * max(sigma[0], 1e-300)).sum()) == 2


@settings(max_examples=60)
@given(features(max_joints=3, right_angles=True, mimic=False, kinds=("revolute", "prismatic", "helical")))
def test_planar_arms_are_found(f):
    """An arm is drawn in a plane where, and only where, all its points move in one."""
    model = f.model()
    plane = plane_of(model)
    if any(0 < abs(x) < 1e-4 for x in model.placements[..., :3, :3].flat):
        return  # right angles missed by less than the eye sees; either picture is right
    assert (plane is not None) == stays_in_a_plane(model)
    if plane is not None:
        np.testing.assert_allclose(plane @ plane.T, np.eye(2), atol=1e-12)


def test_planes_are_those_of_the_base_where_they_can_be():
    """xy, xz, yz as they are; any other with a level and a rising axis, named in full."""
    for normal, names in (((0, 0, 1), "xy"), ((0, 1, 0), "xz"), ((0, -1, 0), "xz"), ((1, 0, 0), "yz")):
        arm = ks.from_screws([ks.screw_axis(normal)], order="linear-angular")
        assert "".join("xyz"[int(np.argmax(row))] for row in plane_of(arm)) == names
        assert np.all((plane_of(arm) == 0) | (plane_of(arm) == 1))
    tilted = ks.from_screws([ks.screw_axis(np.array([1.0, 1.0, 0]) / np.sqrt(2))], order="linear-angular")
    ax = plots.arm(tilted, [0.3])
    assert ax.get_xlabel() == "along (-0.707, 0.707, 0) of the base [m]" or ax.get_xlabel().startswith(
        "along (0.707, -0.707"
    )
    assert ax.get_ylabel() == "z [m]"


@pytest.mark.parametrize("name", ["planar_2r", "planar_3r", "scara", "ur5e", "panda", "stanford_arm", "rrp_note_000"])
def test_an_arm_is_drawn_whole_at_true_scale_inside_the_paper(name):
    """The right kind of axes; a metre is as long along each; numbers, names and key lie on the paper."""
    model = ks.load(name)
    ax = plots.arm(model, Q.get(name), labels="numbers")
    figure = ax.figure
    figure.canvas.draw()
    assert figure.get_figwidth() == style.COLUMN
    planar = name.startswith("planar")
    assert (ax.name == "3d") != planar
    if planar:
        scale = ax.transData.transform([[0, 0], [1, 0], [0, 1]])
        along = np.linalg.norm(scale[1:] - scale[0], axis=1)
        assert abs(along[0] / along[1] - 1) < 1e-9
    else:
        spans = np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1)
        np.testing.assert_allclose(ax._box_aspect / spans, (ax._box_aspect / spans)[0], rtol=1e-9)
        drawn = [a for a in ax.collections if isinstance(a, SpaceSolid)]
        assert len(drawn) == len(model.parents)
        for artist in ax.collections:  # what is projected is what is seen, without a clip at the axes' rim
            assert not artist.get_clip_on()
    paper = figure.bbox.padded(1.0)
    for axis in ax._axis_map.values():
        box = axis.get_tightbbox()
        assert paper.x0 <= box.x0 <= box.x1 <= paper.x1
        assert paper.y0 <= box.y0 <= box.y1 <= paper.y1


def words_on_paper(ax, monkeypatch):
    """(text, x0, y0, x1, y1) of all words of axes, taken down by matplotlib's own renderer while it draws them."""
    drawn, draw = [], Text.draw

    def noted(self, renderer):
        if self in ax.texts and self.get_text():
            drawn.append((self.get_text(), *self.get_window_extent(renderer).extents))
        draw(self, renderer)

    with monkeypatch.context() as patch:
        patch.setattr(Text, "draw", noted)
        FigureCanvasAgg(ax.figure).draw()
    return drawn


def links_on_paper(ax):
    """(k, 2) points in pixels along the links and rods."""
    steps = np.linspace(0.0, 1.0, 200)[:, None]
    if ax.name == "3d":
        lines = [line for color in (palette.LINK, palette.EDGE) for line in lines_of(ax, mpl.colors.to_rgba(color))]
        lines = [np.stack(proj3d.proj_transform(*line.T, ax.M)[:2], -1) for line in lines]
    else:
        lines = [line.get_xydata() for line in ax.lines if line.get_color() == palette.LINK]
    return ax.transData.transform(np.concatenate([a + steps * (b - a) for a, b in lines]))


POSTURES = ("home", 1, 2)


@pytest.mark.parametrize("name", NAMED)
def test_names_cover_neither_each_other_nor_the_arm(name, monkeypatch):
    """No two words share any paper, none lies on a link, all lie inside the figure: at home in a new figure of a column's
    width, at two random postures in axes of one's own, as wide."""
    model = ks.load(name)
    for posture in POSTURES:
        q = None if posture == "home" else np.random.default_rng(posture).uniform(-2.5, 2.5, model.n)
        kind = None if plane_of(model) is not None else "3d"
        own = None if q is None else Figure((3.35, 3.35)).add_subplot(projection=kind)
        ax = plots.arm(model, q, labels=True, ax=own)
        words = words_on_paper(ax, monkeypatch)
        boxes = np.array([box for _, *box in words])
        width, height = ax.figure.bbox.size
        assert boxes[:, :2].min() >= 0
        assert boxes[:, 2].max() <= width
        assert boxes[:, 3].max() <= height
        for k, a in enumerate(boxes):
            for b in boxes[:k]:
                assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] or b[1] >= a[3], (name, posture, words)
        points, names = links_on_paper(ax), [box for word, *box in words if word not in "xyz"]
        for x0, y0, x1, y1 in names:
            under = np.all((points > (x0, y0)) & (points < (x1, y1)), axis=1)
            assert not np.any(under), (name, posture)
        text = " ".join(word for word, *_ in words)
        assert 1 <= len(names) <= model.n
        assert all(joint in text for joint in model.joint_names if not joint[-1].isdigit())


def test_joints_at_one_place_have_one_name():
    """The wrist of the Stanford arm is a point; joints that are apart keep their names; what does not count is listed."""
    ax = plots.arm(ks.load("stanford_arm"), labels=True, frames=False)
    assert [text.get_text() for text in ax.texts] == ["joint1", "joint2, 3", "joint4\N{EN DASH}6"]
    ax = plots.arm(ks.load("ur5e"), labels=True, frames=False)
    assert ax.texts[0].get_text() == "shoulder_pan_joint,\nshoulder_lift_joint"
    assert merged(["4", "5", "6", "8"]) == "4\N{EN DASH}6, 8"
    assert merged(["a1", "b2"]) == "a1, b2"
    assert merged(["one"]) == "one"
    assert merged(["7", "7"]) == "7"
    assert merged(["$q_1$", "$q_2$"]) == "$q_1$, $q_2$"
    assert places(np.array([[0.0, 0.0], [9.0, 0.0], [0.5, 0.5]]), 1.0) == [[0, 2], [1]]


@pytest.mark.parametrize("dpi", [72, 300])
def test_leader_lines_join_names_to_joints(dpi, monkeypatch):
    """Names pushed out by others have a thin line from the joint to their rim, at any resolution."""
    arm = ks.from_dh([(1.0, 0, 0, 0), *[(0.04, 0, 0, 0)] * 5], convention="standard")
    q = [0.3, *[0.9] * 5]
    ax = plots.arm(arm, q, labels=[f"a_joint_with_a_long_name_{k}" for k in "abcdef"], frames=False)
    ax.figure.set_dpi(dpi)
    leaders = [a for a in ax.collections if isinstance(a, FlatLeader)]
    assert leaders
    words = words_on_paper(ax, monkeypatch)
    joints = np.array([joint.point[:2] for joint in skeleton(arm, np.array(q)).joints])
    for leader in leaders:
        assert np.linalg.norm(joints - leader.point, axis=1).min() < 1e-12
        start, end = leader.get_segments()[0]
        np.testing.assert_allclose(start, ax.transData.transform(leader.point), atol=1e-9)
        away = [max(x0 - end[0], end[0] - x1, y0 - end[1], end[1] - y1) for _, x0, y0, x1, y1 in words]
        assert min(abs(distance) for distance in away) < 1.5 * dpi / 72
    space_leaders = [a for a in plots.arm(ks.load("ur5e"), labels=True).collections if isinstance(a, SpaceLeader)]
    points = [joint.point for joint in skeleton(ks.load("ur5e"), ks.load("ur5e").home).joints]
    assert all(min(np.linalg.norm(leader.point - p) for p in points) < 1e-12 for leader in space_leaders)


@settings(max_examples=8)
@given(st.integers(0, 10**6), st.integers(1, 7))
def test_words_find_room(seed, count):
    """Words of many sizes around points that may be one and the same: apart, in the room, the same every time."""
    rng = np.random.default_rng(seed)
    room = np.array([[0.0, 0.0], [260.0, 240.0]])
    wanted = [Wanted(np.array([rng.uniform(10, 80), 9.0]), rng.uniform(90, 110, 2)) for _ in range(count)]
    around = Surroundings(np.array([[[80.0, 120.0], [120.0, 140.0]]]), rng.uniform(0, 240, (6, 2, 2)), room, 1.0)
    middles = spread(wanted, around)
    np.testing.assert_array_equal(middles, spread(wanted, around))
    boxes = np.array([boxes_about(m, w.size) for m, w in zip(middles, wanted, strict=True)])
    assert boxes.min() >= 0
    assert np.all(boxes[:, 1] <= room[1])
    everything = [*boxes, around.boxes[0]]
    for k, a in enumerate(everything):
        for b in everything[:k]:
            assert np.any((a[0] >= b[1]) | (b[0] >= a[1]))


@given(st.integers(0, 10**6))
def test_lengths_inside_a_box(seed):
    """Against many points along each segment, counted."""
    rng = np.random.default_rng(seed)
    box = np.sort(rng.uniform(0, 10, (1, 2, 2)), axis=1)
    segments = rng.uniform(0, 10, (5, 2, 2))
    segments[0, 1, 0] = segments[0, 0, 0]  # upright
    steps = (np.arange(4000) + 0.5)[:, None, None] / 4000
    points = segments[:, 0] + steps * (segments[:, 1] - segments[:, 0])
    counted = np.all((points > box[0, 0]) & (points < box[0, 1]), axis=2).mean(0)
    expected = counted * np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    np.testing.assert_allclose(lengths_inside(box, segments)[0], expected, atol=0.01)


def test_frames_and_labels():
    """As many arrows as axes; texts of one's own; words that are not known are refused."""
    arm = ks.load("ur5e")
    counts = {
        frames: sum(isinstance(a, SpaceArrow) for a in plots.arm(arm, frames=frames, ax=space()).collections)
        for frames in (False, "tip", True)
    }
    assert counts == {False: 0, "tip": 3, True: 3 * 8}
    tip = [a for a in plots.arm(arm, ax=space()).collections if isinstance(a, SpaceArrow)]
    T = ks.pose(arm, arm.home)
    for k, arrow in enumerate(tip):
        np.testing.assert_allclose(arrow.points[0], T.translation, atol=1e-12)
        along = arrow.points[1] - arrow.points[0]
        np.testing.assert_allclose(along / np.linalg.norm(along), T.rotation[:, k], atol=1e-12)
    ax = plots.arm(ks.load("planar_2r"), BENT, labels=["$q_1$", "$q_2$"], frames=False)
    assert [text.get_text() for text in ax.texts] == ["$q_1$", "$q_2$"]
    for wrong in ({"labels": "some"}, {"labels": ["a"]}, {"frames": "all"}, {"frames": 1}):
        with pytest.raises(ks.UnknownNameError) as caught:
            plots.arm(ks.load("planar_2r"), BENT, **wrong)
        assert caught.value.code == "KS381"


TREE = """<robot name="fork"><link name="base"/><link name="body"/><link name="left"/><link name="right"/><link name="far"/>
<joint name="waist" type="continuous"><parent link="base"/><child link="body"/><axis xyz="0 0 1"/></joint>
<joint name="l" type="continuous"><parent link="body"/><child link="left"/><origin xyz="0.5 0.3 0"/>
<axis xyz="0 0 1"/></joint>
<joint name="r" type="prismatic"><parent link="body"/><child link="right"/><origin xyz="0.5 -0.3 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="1" effort="5" velocity="1"/></joint>
<joint name="end" type="fixed"><parent link="left"/><child link="far"/><origin xyz="0.4 0 0"/></joint></robot>"""


def test_a_tree_is_drawn_with_all_branches(tmp_path):
    """A robot without a tip too; the ends of both arms are on lines; the slide has moved along its rod."""
    path = tmp_path / "fork.urdf"
    path.write_text(TREE, encoding="utf-8")
    tree = ks.load(path, whole_tree=True)
    q = [0.3, -0.4, 0.2]
    ax = plots.arm(tree, q, labels=True)
    assert ax.name != "3d"
    drawn = np.concatenate([line.get_xydata() for line in ax.lines if len(line.get_xydata())])
    for link in ("left", "right", "far"):
        p = ks.pose(tree, q, at=link).translation[:2]
        assert np.linalg.norm(drawn - p, axis=1).min() < 1e-12
    rods = [line.get_xydata() for line in ax.lines if line.get_color() == palette.EDGE and len(line.get_xydata()) == 2]
    assert any(abs(np.linalg.norm(rod[1] - rod[0]) - 0.2) < 1e-12 for rod in rods)
    if tree.tip is None:
        with pytest.raises(ks.UnknownNameError) as caught:
            plots.velocity_ellipsoid(tree, q)
        assert caught.value.code == "KS311"
    ax = plots.velocity_ellipsoid(tree, q, at="far")
    assert key_of(ax)[0].startswith("velocity ellipsoid")


@settings(max_examples=5)
@given(features(max_joints=5))
def test_any_mechanism_can_be_drawn(f):
    """Chains and trees of every joint, without joints too, each with everything that can be drawn at its tip."""
    model, q, ax = f.model(), f.configurations(), space()
    plots.arm(model, q, ax=ax, frames=True, labels="numbers")
    for draw in (plots.velocity_ellipsoid, plots.force_ellipsoid, plots.lost_and_free):
        draw(model, q, ax=ax, with_arm=False)
    plots.torque_bars(model, q, ks.Wrench.on_robot(force=(1, 2, 3)), ax=Figure().add_subplot())
    assert len(key_of(ax)) >= 3
    assert all(
        np.all(np.isfinite(artist.points)) for artist in ax.collections if isinstance(artist, SpaceSolid | SpaceArrow)
    )
    ax.figure.draw_without_rendering()


# ellipsoids and polytopes


@pytest.mark.parametrize("name", ["planar_2r", "planar_3r", "ur5e", "panda"])
def test_ellipsoids_are_those_of_the_jacobian(name):
    """Every point drawn, less the tip and divided by the scale, is on |J⁺v| = 1 and |Jᵀf| = 1: right radii, right axes."""
    model = ks.load(name)
    q = Q.get(name, [0.4, 0.9, -0.7][: model.n])
    rows = 2 if name.startswith("planar") else 3
    J = ks.jacobian(model, model.home if q is None else q)
    tip = ks.pose(model, model.home if q is None else q).translation[:rows]
    J = J.array[:rows]
    moving = plots.velocity_ellipsoid(model, q, scale=0.05, ax=None if rows == 2 else space())
    holding = plots.force_ellipsoid(model, q, scale=0.02, ax=None if rows == 2 else space())
    inverse = np.linalg.inv(J @ J.T)
    curves = [line for line in lines_of(moving, BLUE) if len(line) > 2]
    assert len(curves) == (1 if rows == 2 else 3)
    v = np.concatenate([*curves, *solid_of(moving, BLUE)])
    v = (v - tip) / 0.05
    np.testing.assert_allclose(np.einsum("ij,jk,ik->i", v, inverse, v), 1.0, atol=1e-9)
    f = np.concatenate([line for line in lines_of(holding, ORANGE) if len(line) > 2] + solid_of(holding, ORANGE))
    f = (f - tip) / 0.02
    np.testing.assert_allclose(np.linalg.norm(f @ J, axis=1), 1.0, atol=1e-9)
    assert (v @ f.T).max() <= 1 + 1e-9  # each in the polar of the other: a force of one holds against a motion of the other
    assert (v @ f.T).max() >= 0.99
    assert key_of(moving)[0].endswith("(scale: 1 m = 20 m/s)")
    assert key_of(holding)[0].endswith("(scale: 1 m = 50 N)")


def test_the_axes_of_an_ellipsoid_are_drawn_through_the_tip():
    """In the plane the half-axes are the singular values along the left singular vectors."""
    model = ks.load("planar_2r")
    U, sigma, _ = np.linalg.svd(ks.jacobian(model, BENT).array[:2])
    tip = ks.pose(model, BENT).translation[:2]
    ax = plots.velocity_ellipsoid(model, BENT, scale=0.1)
    spokes = [line for line in lines_of(ax, BLUE) if len(line) == 2]
    assert len(spokes) == 2
    for k, spoke in enumerate(spokes):
        np.testing.assert_allclose(spoke.mean(axis=0), tip, atol=1e-12)
        half = (spoke[1] - spoke[0]) / 0.2
        np.testing.assert_allclose(np.abs(half @ U), np.diag(sigma)[k], atol=1e-12)
    scaled = plots.velocity_ellipsoid(model, BENT, scale=0.1, joint_scale=(2.0, 2.0))
    wide = [line for line in lines_of(scaled, BLUE) if len(line) == 2]
    np.testing.assert_allclose(np.ptp(wide[0], axis=0), 2 * np.ptp(spokes[0], axis=0), atol=1e-12)
    assert "scaled joints" in key_of(scaled)[0]


def test_an_unbounded_ellipse_goes_on():
    """A straight arm: the velocities are a segment, the forces a strip along the arm, dashed and headed at all four ends."""
    model = ks.load("planar_2r")
    J, tip = ks.jacobian(model, STRAIGHT).array[:2], ks.pose(model, STRAIGHT).translation[:2]
    along = np.array([np.cos(0.4), np.sin(0.4)])
    ax = plots.velocity_ellipsoid(model, STRAIGHT, scale=0.1)
    assert solid_of(ax, BLUE) == []
    for line in lines_of(ax, BLUE):
        np.testing.assert_allclose((line - tip) @ along, 0, atol=1e-12)
    reach = max(np.linalg.norm(line - tip, axis=1).max() for line in lines_of(ax, BLUE))
    assert abs(reach / 0.1 - np.sqrt(5)) < 1e-9
    ax = plots.force_ellipsoid(model, STRAIGHT, scale=0.5)
    edges = lines_of(ax, ORANGE)
    assert len(edges) == 2
    for line in edges:
        np.testing.assert_allclose(np.linalg.norm((line - tip) / 0.5 @ J, axis=1), 1.0, atol=1e-9)
        assert abs(crossed(line[1] - line[0], along)) < 1e-12
    heads = [a for a in ax.collections if isinstance(a, FlatArrow) and a.width == 0]
    assert len(heads) == 4
    for head in heads:
        assert abs(crossed(head.points[1] - head.points[0], along)) < 1e-12
        assert np.linalg.norm(head.points[1] - tip) > np.linalg.norm(head.points[0] - tip)
    assert "dashed: without end" in key_of(ax)[0]


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(0, 3), st.integers(0, 3))
def test_bodies_of_ellipsoids(seed, k, flats, endless):
    """Whatever is flat or unbounded: lines lie on the surface, points in the set, and what goes on stays in it for ever."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(k, k)))[0]
    radii = rng.uniform(0.5, 2.0, k)
    radii[:flats] = 0.0
    radii[max(k - endless, 0) :] = np.inf
    body = ellipsoid_body(axes, radii, 1.7)
    inverse = np.where(radii > 0, 1 / np.where(radii > 0, radii, 1), 0.0)

    def norms(points):
        along = points @ axes
        assert np.abs(along[:, radii == 0]).max(initial=0.0) < 1e-9
        return np.linalg.norm(along * inverse, axis=1)

    assert norms(body.points).max() <= 1 + 1e-9
    for line in body.lines:
        assert norms(line).max() <= 1 + 1e-9
    for start, end in body.fading:
        assert norms(np.array([start, start + 1e3 * (end - start)])).max() <= 1 + 1e-9
    assert len(body.fading) >= 2 * np.isinf(radii).sum()
    finite = radii[np.isfinite(radii) & (radii > 0)]
    if len(finite) == k:
        extent = np.abs(body.points @ axes).max(axis=0)
        np.testing.assert_allclose(extent, radii, rtol=5e-3)


def test_polytopes_are_those_of_the_limits():
    """Corners drawn, less the tip and divided by the scale, are the corners computed; a force has a joint at its limit."""
    model = ks.load("ur5e")
    q = np.array(Q["ur5e"])
    tip = ks.pose(model, q).translation
    ax = plots.velocity_polytope(model, q, scale=0.02, ax=space())
    expected = ks.velocity_polytope(model, q, task="position")
    (faces,) = [a for a in ax.collections if isinstance(a, SpaceFaces)]
    assert len(faces.points) == len(expected.faces)
    found = (np.concatenate(faces.points) - tip) / 0.02
    gaps = np.linalg.norm(found[:, None] - expected.vertices[None], axis=2)
    assert gaps.min(axis=1).max() < 1e-9
    assert gaps.min(axis=0).max() < 1e-9
    for v in found:  # a corner needs joints at their limits and cannot be reached with less
        assert expected.contains(v)
        assert not expected.contains(1.01 * v)
    ax = plots.force_polytope(model, q, scale=1e-3, ax=space())
    (faces,) = [a for a in ax.collections if isinstance(a, SpaceFaces)]
    f = (np.concatenate(faces.points) - tip) / 1e-3
    tau = f @ ks.jacobian(model, q).linear + ks.gravity_torques(model, q)
    share = np.abs(tau) / model.effort_limits
    np.testing.assert_allclose(share.max(axis=1), 1.0, atol=1e-9)


def test_polytopes_without_end_and_without_points():
    """A straight arm's strip along the arm; an arm that cannot hold itself has no force at all, and the key says so."""
    model = ks.load("planar_2r")
    J, tip = ks.jacobian(model, STRAIGHT).array[:2], ks.pose(model, STRAIGHT).translation[:2]
    ax = plots.force_polytope(model, STRAIGHT, effort_limits=(8, 2), gravity=None, scale=0.1)
    edges = lines_of(ax, ORANGE)
    assert edges
    for line in edges:
        tau = np.abs((line - tip) / 0.1 @ J)
        np.testing.assert_allclose((tau / np.array([8, 2])).max(axis=1), 1.0, atol=1e-9)
    assert len([a for a in ax.collections if isinstance(a, FlatArrow) and a.width == 0]) == 4
    ax = plots.force_polytope(model, STRAIGHT, effort_limits=(0.01, 0.01), gravity=(0, -9.81, 0))
    assert key_of(ax) == ["force polytope of the joint limits:\nempty, the arm cannot hold its own weight"]
    ax = plots.velocity_polytope(model, STRAIGHT, velocity_limits=(1, 1), scale=0.1)
    (segment,) = lines_of(ax, BLUE)
    assert abs(np.linalg.norm(segment[1] - segment[0]) / 0.1 - 6.0) < 1e-9


def test_edges_without_end_of_a_polytope_in_space():
    """A straight arm of space: four edges of the prism go on both ways, each with two joints at their limits."""
    model = ks.load("elbow_rrr")
    polytope = ks.force_polytope(model, [0.3, 0.5, 0.0], task="position", gravity=None, effort_limits=(10, 10, 10))
    body = polytope_body(polytope, 50.0)
    J = ks.jacobian(model, [0.3, 0.5, 0.0]).linear
    assert len(body.fading) == 2 * len(polytope.corners)
    for start, end in body.fading:
        assert (np.abs(np.abs(start @ J) - 10) < 1e-9).sum() >= 2
        assert np.abs((end - start) @ J).max() < 1e-9
    for line in body.lines:
        assert np.abs(line @ J).max() <= 10 + 1e-9


def test_scales():
    """Round by itself, and such that the picture is read; a scale that is none is refused."""
    ax = plots.velocity_ellipsoid(ks.load("planar_2r"), BENT)
    assert key_of(ax) == ["velocity ellipsoid, $|\\dot q| \\leq 1$ rad/s\n(scale: 1 m = 2 m/s)"]
    size = max(np.linalg.norm(line.max(axis=0) - line.min(axis=0)) for line in lines_of(ax, BLUE))
    assert 0.6 < size < 2.7  # of an arm of 2 m
    for wrong in (0, -1.0, np.inf, np.nan, "big"):
        with pytest.raises(ks.ConfigurationError) as caught:
            plots.velocity_ellipsoid(ks.load("planar_2r"), BENT, scale=wrong)
        assert caught.value.code == "KS382"
    for value in (0.013, 0.9, 4.4, 70.0):
        nice = style.round_number(value)
        assert 0.5 < nice / value < 2
        assert f"{nice:.0e}"[0] in "125"


# lost and free


@pytest.mark.parametrize(
    ("name", "q"), [("planar_2r", STRAIGHT), ("elbow_rrr", [0.3, 0.5, 0.0]), ("iiwa_14", [0, 0.5, 0, 0, 0, 0.6, 0])]
)
def test_free_forces_lie_on_lines_that_no_joint_feels(name, q):
    """The line drawn, taken as a force through its points: Jᵀ w = 0."""
    model = ks.load(name)
    a = ks.analyze(model, q)
    assert [screw.kind for screw in a.free_wrenches] == ["force"]
    ax = plots.lost_and_free(model, q, ax=None if name == "planar_2r" else space())
    tip = ks.pose(model, q).translation
    (line,) = [line for line in lines_of(ax, ORANGE) if len(line) == 2]
    line = np.column_stack([line, np.zeros((2, 3 - line.shape[1]))])
    f = line[1] - line[0]
    w = np.concatenate([f, np.cross(line[0] - tip, f)])
    assert np.abs(ks.jacobian(model, q).array.T @ w).max() < 1e-9 * np.linalg.norm(f)
    heads = [a for a in ax.collections if isinstance(a, FlatArrow | SpaceArrow)]
    assert len(heads) >= 4  # both of a force, both of a translation: either sign


def test_lost_and_free_in_words():
    """Few are told in words, many are counted, none is said too; a line far away is drawn by what it amounts to here."""
    assert key_of(plots.lost_and_free(ks.load("panda"), ax=space())) == ["nothing is lost: rank 6 of 6"]
    many = key_of(plots.lost_and_free(ks.load("three_joint_note_003"), [0.3, 0.6, 0.5], ax=space()))
    assert [line.partition(":")[0] for line in many[:2]] == ["lost", "held for free"]
    model = ks.load("ur5e")
    q = [0.3, -1.2, 1.4, 0, 0, 0]
    a = ks.analyze(model, q)
    assert np.linalg.norm(a.free_wrenches[0].point) > 1.5  # far beyond the arm
    ax = plots.lost_and_free(model, q, ax=space())
    assert key_of(ax)[-1] == "far axes are drawn as what they amount to at the tip"
    tip = ks.pose(model, q).translation
    assert max(np.linalg.norm(line - tip, axis=1).max() for line in lines_of(ax, ORANGE)) < 1.2
    flat = plots.lost_and_free(ks.load("planar_2r"), BENT, task="full")  # couples in the plane, motions out of it
    assert flat.name != "3d"


# loads and torques


def test_bars_are_the_torques():
    """Widths are the parts, diamonds the sums, strokes the limits on the side of the sum; numbers say when one is over."""
    model, w = ks.load("ur5e"), ks.Wrench.on_robot(force=(0, 0, -300))
    q = np.array(Q["ur5e"])
    ax = plots.torque_bars(model, q, w)
    weight, load = (np.array([bar.get_width() for bar in bars]) for bars in ax.containers)
    np.testing.assert_allclose(weight, ks.gravity_torques(model, q), atol=1e-12)
    np.testing.assert_allclose(load, ks.joint_torques(ks.jacobian(model, q), w), atol=1e-12)
    marks = {line.get_label(): line.get_xdata() for line in ax.lines}
    np.testing.assert_allclose(marks["sum"], weight + load, atol=1e-12)
    np.testing.assert_allclose(marks["limit"], np.where(weight + load < 0, -1, 1) * model.effort_limits)
    left = np.array([bar.get_x() for bar in ax.containers[1]])
    np.testing.assert_allclose(left, np.where(weight * load > 0, weight, 0.0), atol=1e-12)
    over = [text.get_fontweight() == "bold" for text in ax.texts]
    assert over == list(np.abs(weight + load) > model.effort_limits)
    assert any(over)
    assert key_of(ax) == ["weight of the arm", "load", "limit", "sum"]
    assert [tick.get_text() for tick in ax.get_yticklabels()] == list(model.joint_names)
    assert ax.get_ylim()[0] > ax.get_ylim()[1]


def test_bars_without_masses():
    """A load alone is shown, and what is missing is said; nothing at all is an error."""
    arm = ks.load("scara")
    ax = plots.torque_bars(arm, None, ks.Wrench.on_environment(force=(0, 0, -20)))
    assert "no masses are known" in ax.get_xlabel()
    assert [tick.get_text() for tick in ax.get_yticklabels()][2] == "joint3 [N]"
    with pytest.raises(ks.MissingMassError) as caught:
        plots.torque_bars(arm)
    assert caught.value.code == "KS320"


def test_loads_are_arrows_at_their_points():
    """A load ends at its point, a push begins there; axes and point are those of the wrench's frame."""
    model = ks.load("planar_2r")
    q = np.array(BENT)
    tip = ks.pose(model, q).translation[:2]
    for wrench, at_head in (
        (ks.Wrench.on_robot(force=(3, -4, 0)), True),
        (ks.Wrench.on_environment(force=(3, -4, 0)), False),
    ):
        ax = plots.load(model, q, wrench)
        (arrow,) = [a for a in ax.collections if isinstance(a, FlatArrow)]
        np.testing.assert_allclose(arrow.points[int(at_head)], tip, atol=1e-12)
        along = arrow.points[1] - arrow.points[0]
        np.testing.assert_allclose(along / np.linalg.norm(along), [0.6, -0.8], atol=1e-12)
        assert len(ax.figure.axes) == 2
    frame = ks.Frame("link1", "link1", (0.5, 0.1, 0.0))
    ax = plots.load(
        model, q, {"link1": [ks.Wrench.on_robot(force=(0, 2, 0), frame=frame), ks.Wrench.on_robot(force=(0, 1, 0))]}
    )
    first, second = [a for a in ax.collections if isinstance(a, FlatArrow)]
    T = ks.pose(model, q, at="link1", point=(0.5, 0.1, 0.0))
    np.testing.assert_allclose(first.points[1], T.translation[:2], atol=1e-12)
    lengths = [np.linalg.norm(a.points[1] - a.points[0]) for a in (first, second)]
    assert abs(lengths[0] - 2 * lengths[1]) < 1e-12
    along = first.points[1] - first.points[0]
    np.testing.assert_allclose(along / lengths[0], T.rotation[:2, 1], atol=1e-12)
    assert key_of(ax) == ["load on the robot at link1: 2 N", "load on the robot at link1: 1 N"]
    torque = plots.load(model, q, ks.Wrench.on_robot(torque=(0, 0, -2)))
    (arc,) = [line for line in lines_of(torque, ORANGE) if len(line) > 5]
    turned = crossed(arc[:-1] - tip, arc[1:] - tip)
    assert np.all(turned < 0)  # by the right hand about -z: clockwise


def test_one_page():
    """Six pictures; a figure of one's own is used; what is no analysis is refused."""
    figure = plt.figure(figsize=(7, 5))
    model = ks.load("planar_2r")
    a = ks.analyze(model, STRAIGHT, ks.Wrench.on_robot(force=(0, -10, 0)))
    page = plots.analysis(a, figure=figure)
    plt.close(figure)
    assert page is figure
    assert len(page.axes) == 6
    values = [bar.get_width() for bar in page.axes[4].patches]
    np.testing.assert_allclose(values, a.singular_values, atol=1e-9)
    assert page.axes[4].texts[1].get_text() == "0"
    assert "rank 1 of 2" in page.texts[0].get_text()
    with pytest.raises(ks.ArrayTypeError) as caught:
        plots.analysis(model)
    assert caught.value.code == "KS302"


def test_a_page_of_an_arm_in_space_without_masses():
    """Panda: no bars but a sentence; joints by their share of the range."""
    model = ks.load("panda")
    a = ks.analyze(model, model.home)
    page = plots.analysis(a)
    assert [ax.name for ax in page.axes[:3]] == ["3d"] * 3
    dots = [line.get_xdata()[0] for line in page.axes[5].lines if line.get_marker() == "o"]
    np.testing.assert_allclose(dots, (model.home - model.lower) / (model.upper - model.lower))
    assert isinstance(page, Figure)


# along a path


def curves_of(ax):
    return [line for line in ax.lines if line.get_gid() == "kinestatics-curve"]


def marked(ax, word):
    """The marks of one entry of the key, (k, 2)."""
    (line,) = [line for line in ax.lines if str(line.get_label()).startswith(word)]
    return line.get_xydata()


@pytest.mark.parametrize(
    ("measure", "compute"),
    [
        ("manipulability", ks.manipulability),
        ("sigma_min", ks.smallest_singular_value),
        ("smallest_singular_value", ks.smallest_singular_value),
        ("inverse_condition", ks.inverse_condition),
        ("condition_number", ks.condition_number),
        ("isotropy", ks.isotropy),
    ],
)
@pytest.mark.parametrize(("name", "task"), [("planar_3r", "auto"), ("ur5e", "position"), ("scara", "position")])
def test_a_measure_along_a_path_is_the_measure(measure, compute, name, task):
    """Every point drawn is what the measure says of one posture alone; the worst is marked, once, with its place."""
    model = ks.load(name)
    path = model.home + np.random.default_rng(5).normal(size=(23, model.n)).cumsum(axis=0) * 0.2
    times = np.cumsum(np.linspace(0.1, 0.5, 23))
    length = ks.characteristic_length(model)
    options = {"task": task, "length": length}
    ax = plots.measure_along(model, path, measure, times=times, **options)
    x, y = curves_of(ax)[0].get_xydata().T
    np.testing.assert_array_equal(x, times)
    np.testing.assert_allclose(y, [float(compute(ks.jacobian(model, q), **options)) for q in path], rtol=1e-9)
    worst = "greatest" if measure == "condition_number" else "least"
    (mark,) = marked(ax, worst)
    assert mark[1] == (y.max() if worst == "greatest" else y.min())
    assert mark[0] == x[list(y).index(mark[1])]
    assert ax.get_xlabel() == "time [s]"
    assert "s" in key_of(ax)[1].split(" at t = ")[1]


@pytest.mark.parametrize(
    ("name", "measure", "options", "unit"),
    [
        ("planar_2r", "manipulability", {}, " [m$^{2}$]"),
        ("ur5e", "manipulability", {}, " [m$^{3}$]"),
        ("ur5e", "manipulability", {"task": "orientation"}, ""),
        ("ur5e", "manipulability", {"length": 0.5}, " [m$^{6}$]"),
        ("ur5e", "sigma_min", {"task": "position"}, " [m]"),
        ("ur5e", "sigma_min", {"task": "orientation"}, ""),
        ("ur5e", "sigma_min", {"length": 0.5}, " [m]"),
        ("scara", "sigma_min", {"task": ("vz",)}, ""),
        ("scara", "sigma_min", {"task": "position"}, " [mixed units]"),
        ("scara", "sigma_min", {"task": ("vx", "vy")}, " [m]"),
        ("scara", "manipulability", {"task": "position", "length": 0.5}, " [m$^{3}$]"),
        ("ur5e", "isotropy", {"length": 0.5}, ""),
    ],
)
def test_units_of_measures(name, measure, options, unit):
    """The unit on the axis is the power by which the measure grows when the metre is made half as long."""
    model = ks.load(name)
    q = model.home + np.linspace(0.1, 0.4, model.n)
    ax = plots.measure_along(model, [q, q + 0.1], measure, **options)
    words = ax.get_ylabel()
    assert words.endswith(unit) if unit else "[" not in words
    if unit == " [mixed units]":
        return
    power = 0 if not unit else int((re.search(r"\d", unit) or ["1"])[0])
    J = ks.jacobian(model, q)
    task = ks.find_task(model, options.get("task", "auto"))
    rows = np.array(task.rows)
    length, prismatic = options.get("length"), np.array([kind == "prismatic" for kind in model.joint_kinds])
    found = []
    for metre in (1.0, 2.0):  # the number that stands for one metre
        array = J.array[rows].copy()
        array[rows < 3] *= metre
        array[:, prismatic] /= metre
        if length:
            array[rows >= 3] *= length * metre
            if not np.all(prismatic):
                array[:, prismatic] *= length * metre
        sigma = np.linalg.svd(array, compute_uv=False)[: task.rank]
        found.append({"manipulability": np.prod(sigma), "sigma_min": sigma[-1], "isotropy": 1.0}[measure])
    assert found[1] / found[0] == pytest.approx(2.0**power, rel=1e-9)


def test_where_the_rank_drops_is_marked():
    """At a configuration a cross; between two with determinants of different signs a ring, where the arm is straight."""
    model = ks.load("planar_2r")
    path = np.linspace([0.2, 1.0], [0.5, -1.0], 21)  # straight at the eleventh
    ax = plots.measure_along(model, path)
    np.testing.assert_allclose(marked(ax, "rank drops here"), [[10.0, 0.0]])
    assert key_of(ax) == ["rows vx, vy", "least: 0 m$^{2}$ at configuration 10", "rank drops here"]
    path = np.linspace([0.2, 1.0], [0.5, -0.7], 40)
    ax = plots.measure_along(model, path, times=np.linspace(0.0, 1.7, 40))
    ((x, _),) = marked(ax, "rank drops between")
    assert abs(x - 1.0) < 1e-3
    ax = plots.measure_along(model, path, "condition_number")
    assert ax.get_yscale() == "log"
    assert len(marked(ax, "rank drops between")) == 1
    never = plots.measure_along(model, np.linspace([0.2, 0.5], [0.5, 1.5], 9))
    redundant = plots.measure_along(ks.load("planar_3r"), np.linspace([0, 0.5, 0.5], [0, -0.4, -0.6], 9), task="position")
    for axes in (never, redundant):
        assert not [words for words in key_of(axes) if words.startswith("rank")]
    infinite = plots.measure_along(model, [BENT, STRAIGHT], "condition_number")
    assert key_of(infinite)[1] == "greatest: infinite at configuration 1"
    infinite.figure.draw_without_rendering()


def test_curves_share_axes_and_lie_on_the_paper():
    """A second curve is dashed, the axes grow with it; one configuration is a dot; nothing leaves the figure."""
    model = ks.load("planar_2r")
    path = np.linspace([0.0, 0.2], [0.0, 0.4], 9)
    ax = plots.measure_along(model, path, "inverse_condition", label="low")
    plots.measure_along(model, path + np.array([0.0, 1.0]), "inverse_condition", label="high", ax=ax)
    first, second = curves_of(ax)
    assert (first.get_linestyle(), second.get_linestyle()) == ("-", "--")
    assert ax.get_ylim()[0] == 0
    assert ax.get_ylim()[1] > second.get_ydata().max() > first.get_ydata().max()
    assert [word for word in key_of(ax) if word in ("low", "high")] == ["low", "high"]
    ax = plots.measure_along(ks.load("scara"), np.zeros((1, 4)) + 0.3, "sigma_min", task="position")
    assert curves_of(ax)[0].get_marker() == "."
    ax.figure.canvas.draw()
    box, paper = ax.get_tightbbox(), ax.figure.bbox.padded(1.0)
    assert paper.x0 <= box.x0 <= box.x1 <= paper.x1
    assert paper.y0 <= box.y0 <= box.y1 <= paper.y1
    assert ax.get_legend().get_window_extent().y0 >= ax.bbox.y1


# axes, files, errors


def test_axes_of_ones_own():
    """Axes and figures given are drawn into; a second picture on the same axes makes room for both, and adds to the key."""
    model = ks.load("planar_2r")
    figure = plt.figure()
    flat, space = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2, projection="3d")
    assert plots.arm(model, BENT, ax=flat) is flat
    assert flat.get_aspect() == 1.0
    assert plots.arm(model, BENT, ax=space) is space
    before = space.get_xlim()
    assert before[1] < 2.6
    space.plot([5.0], [0.0], [0.0], "o")
    plots.velocity_ellipsoid(model, BENT, ax=flat)
    plots.force_ellipsoid(model, BENT, ax=flat, with_arm=False)
    assert len(key_of(flat)) == 2
    assert len(figure.axes) == 2
    part = plots.arm(model, BENT, ax=figure.subfigures(1, 1))
    assert len(figure.axes) == 2 or part in figure.axes
    plt.close(figure)
    ours = plots.arm(ks.load("ur5e"))
    small = ours.get_xlim()
    plots.velocity_ellipsoid(ks.load("ur5e"), ax=ours, with_arm=False, scale=2.0)
    assert np.ptp(ours.get_xlim()) > np.ptp(small)
    assert len(key_of(ours)) == 1


def test_a_picture_is_the_same_every_time():
    """Same call, same bytes; a vector file holds no bitmap."""
    written = []
    for _ in range(2):
        file = io.StringIO()
        with mpl.rc_context({"svg.hashsalt": "kinestatics"}):
            ax = plots.velocity_ellipsoid(ks.load("ur5e"), Q["ur5e"])
            ax.figure.savefig(file, format="svg", metadata={"Date": None})
        written.append(file.getvalue())
    assert written[0] == written[1]
    assert "<image" not in written[0]
    assert len(written[0]) < 300_000


def test_arrows_end_where_they_should_in_a_vector_file():
    """Arrows have a fixed size on paper: their outline is found when they are drawn, at the file's own resolution."""
    model, file = ks.load("planar_2r"), io.StringIO()
    ax = plots.load(model, BENT, ks.Wrench.on_robot(force=(0, -5, 0)))
    ax.figure.savefig(file, format="svg")
    text = file.getvalue().partition('id="FlatArrow_1"')[2].partition("z")[0]
    corners = np.array(re.findall(r"[ML] ([\d.]+) ([\d.]+)", text), dtype=float)
    ax.figure.set_dpi(72)  # a vector file counts in points, from the top
    x, y = ax.transData.transform(ks.pose(model, BENT).translation[:2])
    point = corners[corners[:, 1].argmax()]
    np.testing.assert_allclose(point, (x, 72 * ax.figure.get_figheight() - y), atol=1e-5)
    assert np.ptp(corners[:2, 0]) == 0  # straight down


@pytest.mark.parametrize(
    ("call", "code"),
    [
        (lambda: plots.arm(ks.load("ur5e"), ax=Figure().add_subplot()), "KS380"),
        (lambda: plots.arm(ks.load("planar_2r"), BENT, ax="here"), "KS302"),
        (lambda: plots.torque_bars(ks.load("planar_2r"), BENT, ax="here"), "KS302"),
        (lambda: plots.load(ks.load("planar_2r"), BENT, ks.Wrench.on_robot(), ax="here"), "KS302"),
        (lambda: plots.arm(ks.load("planar_2r"), [BENT, BENT]), "KS303"),
        (lambda: plots.arm(ks.load("planar_2r"), [0.1]), "KS303"),
        (lambda: plots.arm(ks.load("planar_2r"), [0.1, np.nan]), "KS301"),
        (lambda: plots.arm("ur5e"), "KS302"),
        (lambda: plots.arm(ks.load("planar_2r"), BENT, at="hand"), "KS310"),
        (lambda: plots.velocity_polytope(ks.load("planar_2r"), BENT), "KS366"),
        (lambda: plots.load(ks.load("planar_2r"), BENT, 3.0), "KS302"),
        (lambda: plots.measure_along(ks.load("planar_2r"), BENT), "KS384"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [[0.1, 0.2, 0.3]]), "KS384"),
        (lambda: plots.measure_along(ks.load("planar_2r"), np.zeros((0, 2))), "KS384"),
        (lambda: plots.measure_along(ks.load("planar_2r"), np.zeros((2, 3, 2))), "KS384"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT, [0.1, np.nan]]), "KS301"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT, BENT], times=[0.0]), "KS385"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT, BENT], times=[1.0, 1.0]), "KS385"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT, BENT], times="now"), "KS385"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT], "speed"), "KS386"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT], task="speed"), "KS318"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT], at="hand"), "KS310"),
        (lambda: plots.measure_along(ks.load("planar_2r"), [BENT], ax="here"), "KS302"),
        (lambda: plots.measure_along(ks.load("ur5e"), [ks.load("ur5e").home], "isotropy"), "KS360"),
        (lambda: plots.measure_along("ur5e", [BENT]), "KS302"),
    ],
)
def test_mistakes_are_named(call, code):
    """Each with its code and a remedy."""
    with pytest.raises(ks.KinestaticsError) as caught:
        call()
    assert caught.value.code == code
    assert caught.value.hint


def test_symbols_are_refused():
    """A robot of symbols has no picture."""
    sympy = pytest.importorskip("sympy")
    a = sympy.symbols("a", positive=True)
    arm = ks.from_dh([(a, 0, 0, 0)], convention="standard")
    with pytest.raises(ks.ArrayTypeError) as caught:
        plots.arm(arm, [0.3])
    assert caught.value.code == "KS302"


def test_without_matplotlib(monkeypatch):
    """The error names the command that installs it."""
    monkeypatch.setattr(style, "find_spec", lambda _: None)
    for call in (lambda: plots.arm(ks.load("ur5e")), lambda: plots.torque_bars(ks.load("ur5e"))):
        with pytest.raises(ks.MissingExtraError) as caught:
            call()
        assert caught.value.code == "KS400"
        assert "kinestatics[plot]" in str(caught.value)


def test_matplotlib_is_imported_when_a_picture_is_drawn():
    """Neither `import kinestatics` nor `kinestatics.plots` needs it; pyplot is never imported."""
    code = (
        "import sys, kinestatics as ks; print('kinestatics.plots' in sys.modules); p = ks.plots;"
        "print('matplotlib' in sys.modules); p.arm(ks.load('planar_2r'), [0.3, 0.4]);"
        "print('matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False", "True", "False"]


# artists


@given(st.lists(st.tuples(st.floats(-10, 10), st.floats(-10, 10)), min_size=1, max_size=40))
def test_hull_holds_its_points(points):
    """Corners are among the points, in order, and no point lies outside."""
    array = np.array(points)
    corners = hull(array)
    assert {tuple(c) for c in corners} <= {tuple(p) for p in array.tolist()}
    if len(corners) > 2:
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            edge = b - a
            sides = edge[0] * (array[:, 1] - a[1]) - edge[1] * (array[:, 0] - a[0])
            assert sides.min() >= -1e-9


def test_arrows_keep_their_heads():
    """The head is as long as asked for, shorter on a short arrow; a head without a shaft stays."""
    outline = arrow_outline(np.zeros(2), np.array([10.0, 0.0]), 1.0, 3.0)
    assert outline[:, 0].max() == 10.0
    assert np.ptp(outline[:, 1]) == pytest.approx(0.72 * 3.0)
    short = arrow_outline(np.zeros(2), np.array([1.0, 0.0]), 1.0, 3.0)
    assert short[:, 0].min() >= 0.0
    head = arrow_outline(np.zeros(2), np.array([1.0, 0.0]), 0.0, 3.0)
    assert head[:, 0].min() == pytest.approx(-2.0)


# Singular sets


def test_singular_curves_are_where_the_determinant_is_zero():
    """Every point drawn is singular; both halves of the elbow and the shoulder are in the key; the posture is marked."""
    found = ks.singularities(ks.load("puma_560"))
    ax = plots.singular_curves(found, ["joint2", "joint3"], [0.1, 0.4, 0.5, 0.0, 0.3, 0.0])
    lines = [line for line in ax.lines if len(line.get_xdata()) > 1]
    assert {text.get_text() for text in ax.get_legend().get_texts()} == {"shoulder", "elbow"}
    for line in lines:
        q = np.zeros((len(line.get_xdata()), 6))
        q[:, 1], q[:, 2], q[:, 4] = np.radians(line.get_xdata()), np.radians(line.get_ydata()), 0.3
        sigma = np.linalg.svd(ks.jacobian(found.model, q, check_finite=False).array, compute_uv=False)
        assert sigma[:, -1].max() < 1e-9
    (mark,) = [line for line in ax.lines if line.get_marker() == "o"]
    np.testing.assert_allclose([mark.get_xdata()[0], mark.get_ydata()[0]], np.degrees([0.4, 0.5]))


def test_the_image_of_an_elbow_arm_is_its_workspace():
    """A planar arm of equal links: the circle of radius 2 and its centre; refused for six joints."""
    ax = plots.singular_image(ks.singularities(ks.load("planar_2r")))
    radii = np.concatenate([np.hypot(*line.get_data()) for line in ax.lines if len(line.get_xdata())])
    assert np.all((np.abs(radii - 2) < 1e-9) | (radii < 1e-9))
    with pytest.raises(ks.ConfigurationError, match="KS398"):
        plots.singular_image(ks.singularities(ks.load("ur5e")))
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        plots.singular_curves(ks.load("ur5e"), [1, 2])
