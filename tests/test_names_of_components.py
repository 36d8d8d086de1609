"""What the parts of the singular set are called: laws of the names, and the names of real arms.

A name is geometry: it may not hang on the base, on signs and zeros of joints, on the size of the arm, on a tool behind a
ball wrist, on other joints of the robot, or on which general points of a component were looked at.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import kinestatics as ks
from kinestatics.robots.assemble import assemble
from kinestatics.robots.catalogue import read_catalogue
from kinestatics.robots.description import JointDescription, LinkDescription, Mimic
from kinestatics.singular_sets.axes import axis_relations
from kinestatics.singular_sets.names import name_of
from singular_robots import ROBOTS, numeric, random_lengths, task_of

PI = np.pi
IDENTITY = np.eye(4)
SEEDS = st.integers(0, 2**31 - 1)

# Arms whose components are named, in the order in which they are found: (robot, task, link)
NAMED = {
    ("iiwa_14", "auto", "tip"): ["elbow", "wrist", "shoulder and wrist", "shoulder"],
    ("panda", "auto", "tip"): ["elbow", "shoulder and elbow", "elbow", "other", "shoulder"],
    ("gen3", "auto", "tip"): ["elbow", "elbow", "elbow", "wrist", "shoulder"],
    ("ur5e", "auto", "tip"): ["shoulder", "elbow", "wrist"],
    ("puma_560", "auto", "tip"): ["shoulder", "elbow", "wrist"],
    ("kr5", "auto", "tip"): ["shoulder", "elbow", "wrist"],
    ("irb_140", "auto", "tip"): ["shoulder", "elbow", "wrist"],
    ("stanford_arm", "auto", "tip"): ["shoulder", "shoulder", "wrist"],
    ("scara", "auto", "tip"): ["elbow"],
    ("al5d", "auto", "tip"): ["elbow"],
    ("al5d", "position", "tip"): ["shoulder", "elbow"],
    ("planar_3r", "position", "tip"): ["elbow"],
    ("puma_560", "position", "tip"): ["elbow", "shoulder"],
    ("iiwa_14", "position", "tip"): ["elbow", "shoulder", "shoulder and elbow"],
    ("iiwa_14", "orientation", "tip"): ["shoulder, elbow and wrist"],
    ("ur5e", "auto", "forearm_link"): ["elbow", "shoulder"],
    ("ur5e", "auto", "wrist_1_link"): ["elbow"],
    ("panda", "auto", "panda_link5"): ["elbow", "other", "shoulder"],
}
LAWS = [key for key in NAMED if key != ("iiwa_14", "orientation", "tip")]


@cache
def singular(name, task, at):
    arm = ks.load(name)
    return arm, ks.singularities(arm, task, at=at)


@pytest.mark.parametrize("key", NAMED, ids="-".join)
def test_names(key):
    _, found = singular(*key)
    assert sorted(c.name for c in found.components) == sorted(NAMED[key])


# Laws


def rewritten(arm, at, q0, base=IDENTITY, signs=1.0, scale=1.0, tool=IDENTITY):
    """The chain to a link as screws: its base moved, joints reversed, zero at q0, lengths scaled, a tool added.

    Returns the model, its columns in the arm, and the function from the arm's postures to the model's.
    """
    chain = sorted({arm.columns[i] for i in arm.path(arm.link_joints[arm.link(at)])})
    T, J = ks.pose(arm, q0, at=at).array, ks.jacobian(arm, q0, at=at).array[:, chain]
    v, w = J[:3].T + np.cross(T[:3, 3], J[3:].T), J[3:].T  # at the base origin
    slides = np.linalg.norm(w, axis=1) < 0.5
    v = np.where(slides[:, None], v, scale * v)
    R, p = base[:3, :3], base[:3, 3]
    w = w @ R.T
    screws = np.hstack([v @ R.T + np.cross(p, w), w]) * (np.ones(arm.n) * signs)[chain, None]
    home = T.copy()
    home[:3, 3] *= scale
    travel = np.where(slides, scale, 1.0)
    model = ks.from_screws(screws, base @ home @ tool, order="linear-angular")
    return model, chain, lambda q: ((q - q0) * signs)[:, chain] * travel


def random_pose(rng, size=1.0):
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Q * np.sign(np.linalg.det(Q)), size * rng.normal(size=3)
    return T


def names(found, chain_model):
    """Names of components by a model of the same chain."""
    model, chain, moved = chain_model
    return [
        name_of(model, moved(c.points[:6]), [chain.index(k) for k in c.columns if k in chain], "tip", c.task)
        for c in found.components
    ]


@pytest.mark.parametrize("key", NAMED, ids="-".join)
@settings(max_examples=2, deadline=None, database=None, derandomize=True)
@given(seed=SEEDS)
def test_names_do_not_hang_on_how_the_arm_is_written(key, seed):
    """Another base, joints reversed, other zeros, another size: the same names, by numbers alone."""
    arm, found = singular(*key)
    rng = np.random.default_rng(seed)
    free = set(found.task.rows) in ({0, 1, 2}, {3, 4, 5}, set(range(6)))  # rows that turn into each other
    base = random_pose(rng) if free else IDENTITY
    signs, scale = rng.choice([-1.0, 1.0], arm.n), float(10.0 ** rng.uniform(-2, 2))
    again = rewritten(arm, key[2], rng.uniform(-2, 2, arm.n), base, signs, scale)
    assert names(found, again) == [c.name for c in found.components]


@pytest.mark.parametrize("name", ["puma_560", "kr5", "irb_140", "stanford_arm", "iiwa_14", "gen3"])
@settings(max_examples=2, deadline=None, database=None, derandomize=True)
@given(seed=SEEDS)
def test_names_do_not_hang_on_the_tool_behind_a_ball_wrist(name, seed):
    arm, found = singular(name, "auto", "tip")
    tool = random_pose(np.random.default_rng(seed), 0.3)
    assert names(found, rewritten(arm, "tip", np.zeros(arm.n), tool=tool)) == [c.name for c in found.components]


@pytest.mark.parametrize("key", NAMED, ids="-".join)
def test_every_general_point_gives_the_name(key):
    """One point is enough, whichever it is."""
    arm, found = singular(*key)
    for c in found.components:
        assert {name_of(arm, q, c.joints, key[2], c.task) for q in c.points[::4]} == {c.name}


@pytest.mark.parametrize(
    ("robot", "expected"),
    [
        ("puma560", ["elbow", "shoulder", "wrist"]),
        ("ur5", ["elbow", "shoulder", "wrist"]),
        ("kuka_kr5", ["elbow", "shoulder", "wrist"]),
        ("iiwa_SRS", ["elbow", "shoulder", "shoulder and wrist", "wrist"]),
        ("panda_FR3", ["elbow", "elbow", "other", "shoulder", "shoulder and elbow"]),
        ("fanuc_crx10ia_l", ["other"]),
        ("orthogonal_3R_cuspidal", ["other"]),
    ],
)
def test_names_do_not_hang_on_lengths(robot, expected):
    """With lengths drawn at random the parts that have points are called the same."""
    lengths = random_lengths(ROBOTS[robot], np.random.default_rng(11))
    found = ks.singularities(numeric(ROBOTS[robot], lengths), task_of(ROBOTS[robot]))
    called = [c.name for c in found.components]
    assert set(called) <= set(expected)
    assert robot == "panda_FR3" or sorted(called) == expected  # its parts may be void


# Joints that do not matter to the link


def with_other_joints(name):
    """The robot on a tree: a gripper of two fingers, one of which follows, a second chain at the base, and a turret."""
    description = read_catalogue(name)
    tip, root = description.links[-1].name, description.links[0].name
    slide, turn = np.array([0.0, 1, 0, 0, 0, 0]), np.array([0.0, 0, 0, 0, 0, 1])
    extra = [
        JointDescription("a_finger", "prismatic", tip, "finger_1", np.eye(4), slide),
        JointDescription("b_finger", "prismatic", tip, "finger_2", np.eye(4), -slide, mimic=Mimic("a_finger", 1.0, 0.0)),
        JointDescription("other_1", "revolute", root, "left_1", np.eye(4), turn),
        JointDescription("other_2", "revolute", "left_1", "left_2", np.eye(4), turn),
    ]
    links = [LinkDescription(j.child) for j in extra]
    grown = replace(description, links=(*description.links, *links), joints=(*extra[2:], *description.joints, *extra[:2]))
    return assemble(grown, None, ks.load(name).tip, whole_tree=True)


@pytest.mark.parametrize("name", ["ur5e", "panda", "iiwa_14", "scara", "planar_3r"])
def test_names_do_not_hang_on_other_joints(name):
    arm, found = singular(name, "auto", "tip")
    tree = with_other_joints(name)
    assert tree.n == arm.n + 3
    rng = np.random.default_rng(4)
    for c in found.components:
        q = rng.uniform(-1, 1, (6, tree.n))
        q[:, [tree.joint_names.index(joint) for joint in arm.joint_names]] = c.points[:6]
        assert name_of(tree, q, [*c.joints, "other_1"], tree.tip, c.task) == c.name


def test_a_column_that_several_joints_share_has_no_axis():
    """Planar arm whose third joint follows the second: sin q2 = 0 is no bent elbow of one joint, and nothing is claimed."""
    description = read_catalogue("planar_3r")
    second, third = description.joints[1].name, description.joints[2]
    joints = tuple(replace(j, mimic=Mimic(second, -1.0, 0.0)) if j is third else j for j in description.joints)
    arm = assemble(replace(description, joints=joints), None, ks.load("planar_3r").tip)
    assert arm.n == 2
    found = ks.singularities(arm, "position")
    assert [c.name for c in found.components] == ["other"]


def test_words_that_do_not_hold_at_every_sample_are_left_out():
    """iiwa: points of the shoulder's part and of the wrist's have no name together; with both conditions they have both."""
    arm, rng = ks.load("iiwa_14"), np.random.default_rng(3)
    q = rng.uniform(-3, 3, (4, 7))
    q[:2, [1, 2]], q[2:, [5, 4]] = (0, PI / 2), (0, PI / 2)
    assert name_of(arm, q, [1, 2, 4, 5]) == "other"
    q = rng.uniform(-3, 3, (4, 7))
    q[:, [1, 5]] = 0
    assert name_of(arm, q, [1, 5]) == "shoulder and wrist"
    assert name_of(arm, q, [0, 6]) == "other"  # not joints that bend anything


# Sentences on axes


def told(name, task, at, index):
    arm, found = singular(name, task, at)
    postures = found.components[index].points[:3]
    return {tuple((r.kind, *(j[-1] for j in r.joints)) for r in axis_relations(arm, q)) for q in postures}


@pytest.mark.parametrize(
    ("name", "names_and_relations"),
    [
        (
            "iiwa_14",
            {
                "elbow": [("collinear", "3", "5")],
                "wrist": [("collinear", "5", "7"), ("meet", "3", "6")],
                "shoulder and wrist": [("collinear", "1", "3"), ("collinear", "5", "7")],
                "shoulder": [("collinear", "1", "3"), ("meet", "2", "5")],
            },
        ),
        (
            "stanford_arm",
            {"wrist": [("collinear", "4", "6")]},  # the slide is parallel to axis 6 only because axis 4 always is
        ),
        ("gen3", {"wrist": [("collinear", "5", "7")], "shoulder": [("parallel", "1", "3"), ("in-plane", "1", "2")]}),
        ("irb_140", {"elbow": [("meet", "2", "4")], "shoulder": [("meet", "1", "4", "5", "6")]}),
    ],
)
def test_each_fact_is_told_once(name, names_and_relations):
    """At the points of a component the same sentences, none of which follows from the others."""
    _, found = singular(name, "auto", "tip")
    for index, component in enumerate(found.components):
        if component.name in names_and_relations:
            assert told(name, "auto", "tip", index) == {tuple(names_and_relations[component.name])}


def test_the_straight_line_of_an_arm_with_offsets():
    """Panda, elbow: shoulder, axis 4 and the point of axes 5 and 6 on one line, though no axes line up."""
    arm, found = singular("panda", "auto", "tip")
    (stretched,) = [c for c in found.components if [j[-1] for j in c.joints] == ["4", "5"]]
    for q in stretched.points[:4]:
        straight = axis_relations(arm, q)[-1]
        assert (straight.kind, straight.joints[0][-1]) == ("straight", "4")
        assert [j[-1] for j in straight.through] == ["1", "2", "3", "5", "6"]
        shoulder, wrist = np.array([0, 0, 0.333]), ks.pose(arm, q, at="panda_link5").translation
        along = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
        assert np.abs(np.cross(along, straight.direction)).max() < 1e-9
        assert np.abs(np.cross(along, straight.point - shoulder)).max() < 1e-9
        axis = ks.jacobian(arm, q, at="panda_link4").array[3:, 3]
        hinge = ks.pose(arm, q, at="panda_link4").translation
        assert np.abs(np.cross(axis, straight.point - hinge)).max() < 1e-9
    assert "crosses the axis of panda_joint4" in str(straight)


def test_the_tip_on_two_axes_is_one_sentence():
    (found,) = axis_relations(ks.load("rrp_note_000"), [0.3, 0.4, 0.0])
    assert (found.kind, found.joints, found.direction) == ("on-axis", ("joint1", "joint2"), None)
    assert str(found) == "the tip is on the axes of joint1 and joint2"
