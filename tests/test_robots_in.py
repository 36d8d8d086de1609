"""What a user expects of loading a robot: any link as base or tip, held joints, followers, odd files, odd paths, tables."""

import contextlib
import gc
import json
import math
import os
import re
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks
from kinestatics.robots.assemble import assemble
from kinestatics.robots.urdf import parse_urdf
from kinestatics.spatial import rotation_to_rpy

GRIPPER = """<robot name="gripper">
  <link name="base"/><link name="arm"/><link name="palm"/><link name="left"/><link name="right"/><link name="pad"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 0 1" rpy="0.3 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="bend" type="revolute"><parent link="arm"/><child link="palm"/><origin xyz="1 0 0" rpy="0 0.2 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="lead" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>{follow}</joint>
  <joint name="chase" type="revolute"><parent link="right"/><child link="pad"/><origin xyz="0 0 0.1"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/>{chase}</joint>
</robot>"""
FOLLOW = '<mimic joint="lead" multiplier="-2" offset="0.25"/>'
CHASE = '<mimic joint="follow" multiplier="3" offset="-0.5"/>'
Q = {"turn": 0.7, "bend": -0.4, "lead": 0.3}


def gripper(tmp_path, follow=FOLLOW, chase=CHASE, **options):
    """The gripper, with its mimic elements exchanged."""
    path = tmp_path / "gripper.urdf"
    path.write_text(GRIPPER.format(follow=follow, chase=chase), encoding="utf-8")
    return ks.load(path, **options)


def values(model, known):
    """The configuration of a model from values by joint name."""
    return np.array([known[name] for name in model.joint_names])


# ---- any link as base or tip --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", ["base", "arm", "palm", "left", "right", "pad"])
@pytest.mark.parametrize("tip", ["base", "arm", "palm", "left", "right", "pad"])
def test_any_link_may_be_base_or_tip(tmp_path, base, tip):
    """T_base_tip of a re-rooted model is what the whole tree says: (T_root_base)⁻¹ T_root_tip."""
    tree = gripper(tmp_path, whole_tree=True)
    there = gripper(
        tmp_path, base=base, tip=tip, joints={"lead": Q["lead"]} if {base, tip} <= {"base", "arm", "palm"} else None
    )
    q = values(tree, Q)
    T_root_base, T_root_tip = ks.pose(tree, q, at=f"link:{base}").array, ks.pose(tree, q, at=f"link:{tip}").array
    found = ks.pose(there, values(there, Q)).array
    np.testing.assert_allclose(found, np.linalg.inv(T_root_base) @ T_root_tip, atol=1e-14)


@pytest.mark.parametrize(("base", "tip"), [("pad", "left"), ("left", "right"), ("palm", "base"), ("right", "arm")])
def test_jacobian_between_any_two_links(tmp_path, base, tip):
    """The re-rooted Jacobian is the relative Jacobian of the whole tree, whose base stands elsewhere."""
    tree, there = gripper(tmp_path, whole_tree=True), gripper(tmp_path, base=base, tip=tip)
    whole = ks.relative_jacobian(tree, values(tree, Q), at=f"link:{tip}", relative_to=f"link:{base}")
    own = ks.jacobian(there, values(there, Q))
    for name in tree.joint_names:
        column = whole.array[:, tree.joint_names.index(name)]
        if name in there.joint_names:
            np.testing.assert_allclose(own.array[:, there.joint_names.index(name)], column, atol=1e-14)
        else:
            np.testing.assert_allclose(column, 0, atol=1e-14)


# ---- masses that must not be lost ---------------------------------------------------------------------------------------

WEIGHED = """<robot name="weighed"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0.5 0 0"/><mass value="1"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.5 0 0"/><mass value="1"/></inertial></link>
  <link name="tool"><inertial><origin xyz="0.5 0 0"/><mass value="1"/></inertial></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="j2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="weld" type="fixed"><parent link="lower"/><child link="tool"/><origin xyz="1 0 0"/></joint></robot>"""


@pytest.mark.parametrize("tip", ["tool", "lower"])
def test_a_tool_on_a_fixed_joint_keeps_its_mass(tmp_path, tip):
    """2R with a tool of 1 kg welded on at (0.3, 0.5): -37.10 and -13.67 N m hold it, whether the tip is before or behind it.

    About y, a positive turn lowers the arm, so that what holds it is negative: -g (c1/2 + (c1 + c12/2) + (c1 + 3 c12/2)).
    """
    path = tmp_path / "weighed.urdf"
    path.write_text(WEIGHED, encoding="utf-8")
    arm = ks.load(path, tip=tip)
    found = ks.gravity_torques(arm, [0.3, 0.5])
    c1, c12 = math.cos(0.3), math.cos(0.8)
    np.testing.assert_allclose(found, [-9.81 * (2.5 * c1 + 2 * c12), -9.81 * 2 * c12], rtol=1e-14)
    np.testing.assert_allclose(found, [-37.10, -13.67], atol=5e-3)


def test_a_side_branch_keeps_its_mass_where_it_is_held(tmp_path):
    """A chain that ends before a side branch carries it: holding a joint elsewhere moves its weight."""
    path = tmp_path / "weighed.urdf"
    path.write_text(WEIGHED, encoding="utf-8")
    for bend in (0.0, 1.2, -2.0):
        arm = ks.load(path, tip="upper", joints={"j2": bend})
        expected = -9.81 * (2.5 * math.cos(0.3) + 2 * math.cos(0.3 + bend))
        np.testing.assert_allclose(ks.gravity_torques(arm, [0.3]), [expected], rtol=1e-14)


# ---- joints that follow -------------------------------------------------------------------------------------------------


def follower_values(model, q):
    """Value of each moving joint."""
    return {
        name: m * q[c] + o
        for name, c, m, o in zip(model.moving_names, model.columns, model.multipliers, model.offsets, strict=True)
    }


def test_a_chain_of_followers_is_multiplied_out(tmp_path):
    """follow = -2 lead + 0.25; chase = 3 follow - 0.5: one column, the sum of both, on the way to the pad."""
    arm = gripper(tmp_path, tip="pad")
    assert arm.joint_names == ("turn", "bend", "lead")
    q = values(arm, Q)
    moved = follower_values(arm, q)
    assert moved["follow"] == pytest.approx(-2 * 0.3 + 0.25)
    assert moved["chase"] == pytest.approx(3 * (-2 * 0.3 + 0.25) - 0.5)
    step = 1e-6 * np.eye(3)[2]
    J = ks.jacobian(arm, q)
    fast = (ks.pose(arm, q + step).translation - ks.pose(arm, q - step).translation) / 2e-6
    np.testing.assert_allclose(J.linear[:, 2], fast, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(J.angular[:, 2]), 6, rtol=1e-14)  # chase turns by -6 rad for 1 m of lead


def test_a_follower_with_multiplier_zero_stands_still(tmp_path):
    """multiplier 0 is a joint that keeps its offset: a column of zeros, and no division by it."""
    arm = gripper(tmp_path, follow='<mimic joint="lead" multiplier="0" offset="0.125"/>', chase="", tip="right")
    q = values(arm, Q)
    assert arm.joint_names == ("turn", "bend", "lead")
    np.testing.assert_array_equal(ks.jacobian(arm, q).array[:, 2], np.zeros(6))
    T = ks.pose(arm, q, at="palm").array
    np.testing.assert_allclose(ks.pose(arm, q).array, T @ pose_of(p=(0.2, 0.125, 0)), atol=1e-15)


def pose_of(R=None, p=(0, 0, 0)):
    """(4, 4) from its parts."""
    T = np.eye(4)
    T[:3, :3] = np.eye(3) if R is None else R
    T[:3, 3] = p
    return T


def test_a_follower_of_a_held_joint_is_held_with_it(tmp_path):
    """Holding the leader holds the whole chain of followers where it puts them."""
    arm = gripper(tmp_path, tip="pad", joints={"lead": 0.3})
    assert arm.joint_names == ("turn", "bend")
    assert arm.frozen == {"lead": 0.3}
    free = gripper(tmp_path, tip="pad")
    np.testing.assert_allclose(ks.pose(arm, [0.7, -0.4]).array, ks.pose(free, [0.7, -0.4, 0.3]).array, atol=1e-15)


def test_a_follower_may_be_held_alone(tmp_path):
    """Holding a follower takes it from its leader: it stays where it was put, and the leader still moves."""
    arm = gripper(tmp_path, tip="right", joints={"follow": -0.75}, chase="")
    assert arm.joint_names == ("turn", "bend")
    T = ks.pose(arm, [0.1, 0.2], at="palm").array
    np.testing.assert_allclose(ks.pose(arm, [0.1, 0.2]).array, T @ pose_of(p=(0.2, -0.75, 0)), atol=1e-15)
    tree = gripper(tmp_path, joints={"follow": -0.75}, chase="", whole_tree=True)
    assert tree.joint_names == ("turn", "bend", "lead", "chase")


def test_a_held_follower_leads_its_own_followers(tmp_path):
    """In a chain lead, follow, chase with follow held, chase stands at 3 follow - 0.5, and the leader moves neither."""
    arm = gripper(tmp_path, tip="pad", joints={"follow": -0.75})
    assert arm.joint_names == ("turn", "bend")
    assert arm.frozen == {"follow": -0.75, "lead": 0.0}
    bend = 3 * -0.75 - 0.5
    R = np.array([[1, 0, 0], [0, math.cos(bend), -math.sin(bend)], [0, math.sin(bend), math.cos(bend)]])
    T = ks.pose(arm, [0.1, 0.2], at="palm").array
    np.testing.assert_allclose(ks.pose(arm, [0.1, 0.2]).array, T @ pose_of(R, (0.2, -0.75, 0.1)), atol=1e-15)


def test_a_follower_of_a_fixed_joint_stays_at_its_offset(tmp_path):
    """A fixed joint leads nowhere: its value is zero, so that the follower keeps its offset."""
    path = tmp_path / "fixed.urdf"
    text = GRIPPER.format(follow=FOLLOW, chase="").replace('name="lead" type="prismatic"', 'name="lead" type="fixed"')
    path.write_text(text, encoding="utf-8")
    arm = ks.load(path, tip="right")
    assert arm.joint_names == ("turn", "bend")
    np.testing.assert_allclose(
        ks.pose(arm, [0, 0]).array, ks.pose(arm, [0, 0], at="palm").array @ pose_of(p=(0.2, 0.25, 0)), atol=1e-15
    )


@pytest.mark.parametrize(
    ("follow", "code"),
    [
        ('<mimic joint="led"/>', r"KS170.*did you mean 'lead'"),
        ('<mimic joint="chase"/>', r"KS171.*mimics follow -> chase -> follow"),
        ('<mimic joint="lead" multiplier="1e40" offset="1e40"/>', "KS172"),
        ('<mimic joint="lead" multiplier="nan"/>', "KS146"),
        ("<mimic/>", "KS125.*'joint'"),
    ],
)
def test_followers_that_lead_nowhere_are_refused(tmp_path, follow, code):
    """A leader that does not exist, that follows in turn, or a motion too large to compute with."""
    with pytest.raises(ks.RobotFileError, match=re.compile(code, re.DOTALL)):
        gripper(tmp_path, follow=follow, chase='<mimic joint="follow" multiplier="1e20"/>')


LINK = '<link name="l{i}"/>'
JOINT = '<joint name="j{i}" type="{kind}"><parent link="l{parent}"/><child link="l{i}"/>{mimic}</joint>'


def many(parents, kind="continuous", mimic=lambda _: ""):
    """A robot whose link i hangs on link parents[i - 1]; the joints stand in the file from the last to the first."""
    links = "".join(LINK.format(i=i) for i in range(len(parents) + 1))
    joints = [JOINT.format(i=i, kind=kind, parent=p, mimic=mimic(i)) for i, p in enumerate(parents, start=1)]
    return f'<robot name="r">{links}{"".join(reversed(joints))}</robot>'.encode()


def follows_next(i):
    """Each joint follows the one before it."""
    return f'<mimic joint="j{i - 1}"/>' if i > 1 else ""


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (many(range(15_000)), "KS106: 15000 joints that move"),
        (many(range(15_000), kind="fixed"), "KS106: 15000 joints in a row"),
        (many([15_000, *range(1, 15_000)]), "KS135: loop: l"),
        (many([0] * 15_000, mimic=lambda i: f'<mimic joint="j{i % 15_000 + 1}"/>'), "KS171|KS106"),
        (
            many([0] * 4000, mimic=lambda i: f'<mimic joint="j{i % 4000 + 1}"/>'),
            "KS171: joint 'j4000' mimics j4000 -> j1 -> ",
        ),
    ],
    ids=["chain", "fixed chain", "loop", "many followers in a circle", "followers in a circle"],
)
def test_robots_too_large_are_refused_at_once(data, code):
    """Long chains, loops and rows of followers, in the order that costs most: refused within two seconds, in few words."""
    gc.freeze()  # what other tests left behind is not gone through while this one is timed
    try:
        began = time.process_time()
        with pytest.raises(ks.RobotFileError, match=code) as caught:
            parse_urdf(data, "large.urdf")
        taken = time.process_time() - began
    finally:
        gc.unfreeze()
    assert taken < 2.0
    assert len(caught.value.message) < 500


def test_a_long_row_of_followers_is_one_column():
    """4,000 joints that each follow the one before: one joint leads them all."""
    arm = assemble(parse_urdf(many([0] * 4000, mimic=follows_next), "row.urdf"), tip="l4000")
    assert arm.joint_names == ("j1",)
    np.testing.assert_allclose(ks.jacobian(arm, [0.3]).angular[:, 0], [1, 0, 0])


# ---- tips and names -----------------------------------------------------------------------------------------------------


def test_several_ends_and_no_tip_are_all_named(tmp_path):
    """KS314 names every end that can move, and both ways out."""
    with pytest.raises(ks.RobotDefinitionError) as caught:
        gripper(tmp_path)
    assert caught.value.code == "KS314"
    assert "left, pad" in caught.value.message
    assert "tip=" in caught.value.hint
    assert "whole_tree=True" in caught.value.hint


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"tip": "Pad"}, "KS310.*'pad'"),
        ({"base": "plam", "tip": "pad"}, "KS310.*'palm'"),
        ({"tip": "pad", "joints": {"leed": 0.1}}, "KS313.*'lead'"),
        ({"tip": ""}, "KS310.*known: 'base'"),
    ],
)
def test_unknown_names_are_answered_with_the_nearest(tmp_path, options, code):
    """Links and joints by their nearest names; where nothing is near, all of them."""
    with pytest.raises(ks.UnknownNameError, match=re.compile(code, re.DOTALL)):
        gripper(tmp_path, **options)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300, "0.1", None, [0.1]])
def test_a_joint_is_held_at_a_finite_number(tmp_path, value):
    """KS301 for anything else, naming the joint."""
    with pytest.raises(ks.RobotDefinitionError, match=r"KS301: joint 'lead'"):
        gripper(tmp_path, tip="pad", joints={"lead": value})


def test_a_continuous_joint_has_one_column_and_no_wrap(tmp_path):
    """One entry of q, no limits, the same pose after a full turn, and the value itself is never changed."""
    arm = gripper(tmp_path, tip="arm")
    assert arm.joint_names == ("turn",)
    assert (arm.lower[0], arm.upper[0]) == (-np.inf, np.inf)
    turns = np.array([[0.7 + 2 * math.pi * k] for k in range(-3, 4)])
    poses = ks.pose(arm, turns).array
    np.testing.assert_allclose(poses, np.broadcast_to(poses[3], poses.shape), atol=1e-14)
    assert ks.analyze(arm, [7.0]).configuration[0] == 7.0


def test_hold_in_a_shell_is_joints_in_python(tmp_path):
    """--hold name=value gives the same Jacobian as joints={name: value}; a wrong one is exit code 2 and one message."""
    arm = gripper(tmp_path, tip="pad", joints={"lead": 0.3})
    command = [
        sys.executable,
        "-m",
        "kinestatics",
        "jacobian",
        str(tmp_path / "gripper.urdf"),
        "--tip",
        "pad",
        "--at",
        "0.7,-0.4",
    ]
    done = subprocess.run([*command, "--hold", "lead=0.3", "--json"], capture_output=True, text=True, check=True)
    np.testing.assert_array_equal(json.loads(done.stdout)["array"], ks.jacobian(arm, [0.7, -0.4]).array)
    for wrong, code in (("lead", "KS341"), ("lead=x", "KS340"), ("leed=0.3", "KS313")):
        failed = subprocess.run([*command, "--hold", wrong], capture_output=True, text=True, check=False)
        assert (failed.returncode, failed.stdout) == (2, "")
        assert failed.stderr.count("error KS") == 1
        assert code in failed.stderr


# ---- files and paths ----------------------------------------------------------------------------------------------------


def plain(tmp_path, data, name="arm.urdf"):
    """A file of those bytes, loaded."""
    path = tmp_path / name
    path.write_bytes(data)
    return ks.load(path, tip="tool")


BYTES = WEIGHED.encode()


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbf" + BYTES,
        BYTES.replace(b"\n", b"\r\n"),
        b'<?xml version="1.0"?>\n<!-- <link name="x"/> -->\n' + BYTES.replace(b"</robot>", b"<!-- end --></robot>\n\n"),
        b'<?xml version="1.0" encoding="utf-8" standalone="yes"?>' + BYTES,
        b'<?xml version="1.0" encoding="iso-8859-1"?>' + BYTES.replace(b'"weighed"', b'"w\xe4ge"'),
        BYTES.replace(b"<link name=", b"<link  \t\n name = ").replace(b'"0.5 0 0"', b'" .5\t0.0\n-0 "'),
    ],
    ids=["byte order mark", "CRLF", "comments", "declaration", "Latin-1 declared", "white space"],
)
def test_the_same_robot_however_it_is_written(tmp_path, data):
    """Byte order marks, line ends, comments, declared encodings and white space change nothing."""
    arm, as_it_is = plain(tmp_path, data), plain(tmp_path, BYTES, "plain.urdf")
    np.testing.assert_array_equal(ks.pose(arm, [0.3, 0.5]).array, ks.pose(as_it_is, [0.3, 0.5]).array)
    np.testing.assert_array_equal(ks.gravity_torques(arm, [0.3, 0.5]), ks.gravity_torques(as_it_is, [0.3, 0.5]))


def test_latin_1_bytes_without_a_declaration_are_refused(tmp_path):
    """KS105 with the place of the first byte that is not UTF-8, and what to do."""
    with pytest.raises(ks.RobotFileError) as caught:
        plain(tmp_path, BYTES.replace(b'"weighed"', b'"w\xe4ge"'))
    assert caught.value.code == "KS105"
    assert (caught.value.place.line, caught.value.hint) == (1, "save the file as UTF-8")


class Somewhere(os.PathLike):
    """A path that is neither text nor pathlib's."""

    def __init__(self, path):
        self.path = path

    def __fspath__(self):
        return str(self.path)


@pytest.mark.parametrize("kind", [str, Path, Somewhere])
@pytest.mark.parametrize("name", ["arm.urdf", "ARM.URDF", "arm", "arm.xml", "arm with spaces é.urdf"])
def test_paths_of_every_kind(tmp_path, kind, name):
    """Text, Path or PathLike; any case of the suffix, or none; .xml where the root is <robot>."""
    path = tmp_path / name
    path.write_bytes(BYTES)
    assert ks.load(kind(path), tip="tool").n == 2


def test_a_file_in_the_working_folder_by_its_bare_name(tmp_path, monkeypatch):
    """A bare file name is looked up in the working folder."""
    (tmp_path / "arm.urdf").write_bytes(BYTES)
    monkeypatch.chdir(tmp_path)
    assert ks.load("arm.urdf", tip="tool").n == 2


@pytest.mark.parametrize("name", ["", " ", ".", "..", "/", "a\x00b", "no such arm"])
def test_what_names_nothing_is_an_unknown_name(name):
    """KS312 for text that is neither a file nor in the catalogue, whatever the text."""
    with pytest.raises(ks.UnknownNameError, match="KS312"):
        ks.load(name)


def test_a_folder_is_no_robot_file(tmp_path):
    """KS109 for a folder called like a file, KS312 for another."""
    (tmp_path / "robot.urdf").mkdir()
    with pytest.raises(ks.RobotFileError, match="KS109"):
        ks.load(tmp_path / "robot.urdf")
    with pytest.raises(ks.UnknownNameError, match="KS312"):
        ks.load(tmp_path)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="whoever may read everything cannot be refused")
def test_a_file_without_permission(tmp_path):
    """KS109 with the system's reason."""
    path = tmp_path / "arm.urdf"
    path.write_bytes(BYTES)
    path.chmod(0)
    with pytest.raises(ks.RobotFileError, match=r"KS109.*[Pp]ermission"):
        ks.load(path)


def test_a_file_that_fails_while_read(tmp_path, monkeypatch):
    """KS109 with the system's reason, in the place of the file."""
    path = tmp_path / "arm.urdf"
    path.write_bytes(BYTES)

    def fails(_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(Path, "read_bytes", fails)
    with pytest.raises(ks.RobotFileError, match=r"arm\.urdf: error KS109: cannot be read: Input/output error"):
        ks.load(path)


def test_elements_for_other_programs_are_left_alone(tmp_path):
    """gazebo, transmission, ros2_control, sensor, material: nothing in them is a link or a joint of the robot."""
    other = (
        b'<gazebo reference="upper"><link name="ghost"/><joint name="j9" type="screw"/></gazebo>'
        b'<transmission name="t"><joint name="j1"><hardwareInterface>x</hardwareInterface></joint></transmission>'
        b'<ros2_control name="c" type="system"><joint name="j2"><param name="p">nan</param></joint></ros2_control>'
        b'<sensor name="s"/><material name="m"><color rgba="x"/></material><unknown/>'
    )
    arm = plain(tmp_path, BYTES.replace(b"</robot>", other + b"</robot>"))
    assert arm.link_names == ("base", "upper", "lower", "tool")
    assert arm.moving_names == ("j1", "j2")


WATCHED = """
import sys
from pathlib import Path
import kinestatics as ks
folder = Path(sys.argv[1])
ks.load("planar_2r"), ks.load(folder / "model" / "warm.urdf")
opened = []
sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event in ("open", "os.listdir", "os.scandir") else None)
arm = ks.load(folder / "model" / "arm.urdf", package_roots=[folder / "packages"])
print(*opened, sep="\\n")
print("found", *(finding.code for finding in arm.findings))
"""


def test_nothing_but_the_robot_file_is_opened(tmp_path):
    """Meshes that exist, inside and outside of the folders, by every kind of path: found or reported, and never opened."""
    model, packages, outside = (tmp_path / name for name in ("model", "packages", "outside"))
    for folder in (model, packages / "maker" / "meshes", outside):
        folder.mkdir(parents=True)
        (folder / "part.stl").write_text("solid", encoding="utf-8")
    (model / "door").symlink_to(outside)
    names = {
        "part.stl": "", "package://maker/meshes/part.stl": "", f"file://{model}/part.stl": "",
        "../outside/part.stl": "KS111", "door/part.stl": "KS111", f"{outside}/part.stl": "KS111",
        f"file://{outside}/part.stl": "KS111", "package://maker/../../outside/part.stl": "KS111",
        "package://../outside/part.stl": "KS111", "package://%2e%2e/outside/part.stl": "KS111",
        f"package:///{outside}/part.stl": "KS180", "package:///etc/hostname": "KS180", "package://other/part.stl": "KS180",
        "https://example.org/part.stl": "KS180", "missing.stl": "KS180", "n" * 4000: "KS180", "package://maker/%00": "KS180",
    }  # fmt: skip
    visuals = "".join(f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names)
    (model / "warm.urdf").write_text('<robot name="r"><link name="a"/></robot>', encoding="utf-8")
    (model / "arm.urdf").write_text(f'<robot name="r"><link name="a">{visuals}</link></robot>', encoding="utf-8")
    done = subprocess.run([sys.executable, "-c", WATCHED, str(tmp_path)], capture_output=True, text=True, check=True)
    *opened, found = done.stdout.splitlines()
    assert opened == [str(model / "arm.urdf")]
    assert found.split()[1:] == [code for code in names.values() if code]


def test_a_model_folder_behind_a_link_is_found_by_both_names(tmp_path):
    """A folder reached through a link holds its meshes, whether the file names it by the link or by the folder."""
    folder, link = tmp_path / "folder", tmp_path / "link"
    folder.mkdir()
    link.symlink_to(folder)
    (folder / "part.stl").write_text("solid", encoding="utf-8")
    visuals = "".join(
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in ("part.stl", f"file://{link}/part.stl", f"file://{folder}/part.stl", f"{link}/part.stl")
    )
    (folder / "arm.urdf").write_text(f'<robot name="r"><link name="a">{visuals}</link></robot>', encoding="utf-8")
    assert ks.load(link / "arm.urdf").findings == ()


# ---- tables and screws --------------------------------------------------------------------------------------------------


def test_a_helical_joint_from_screws():
    """A screw of pitch h advances by h for each radian: pose, Jacobian column and kind."""
    pitch = 0.02
    arm = ks.from_screws([ks.screw_axis((0, 0, 2), (0.3, 0, 0), pitch)], order="linear-angular")
    assert arm.kinds == ("helical",)
    angle = 5 * math.pi
    np.testing.assert_allclose(
        ks.pose(arm, [angle]).array, pose_of(np.diag([-1, -1, 1]), (0.6, 0, pitch * angle)), atol=1e-14
    )
    np.testing.assert_allclose(ks.jacobian(arm, [0.0]).array[:, 0], [0, -0.3, pitch, 0, 0, 1], atol=1e-15)


def test_body_screws_and_spatial_screws_are_one_arm():
    """B = Ad(M⁻¹) S: the same pose at every q, whichever are given."""
    axes = [ks.screw_axis((0, 0, 1)), ks.screw_axis((0, 1, 0), (0.4, 0, 0.2)), ks.screw_axis((1, 0, 1), pitch=math.inf)]
    M = pose_of(np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), (0.9, -0.1, 0.3))
    spatial = ks.from_screws(axes, M, order="linear-angular")
    in_body = ks.jacobian(spatial, np.zeros(3), frame=ks.Frame.body()).array.T
    body = ks.from_screws(in_body, M, order="linear-angular", frame="body")
    other_order = ks.from_screws(np.roll(in_body, 3, axis=1), M, order="angular-linear", frame="body")
    for q in np.random.default_rng(1).uniform(-2, 2, (10, 3)):
        np.testing.assert_allclose(ks.pose(body, q).array, ks.pose(spatial, q).array, atol=1e-14)
        np.testing.assert_allclose(ks.pose(other_order, q).array, ks.pose(spatial, q).array, atol=1e-14)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_a_symbolic_table_at_numbers_is_the_numeric_table(convention):
    """Poses and Jacobians of symbolic rows, with numbers put in, are those of the numeric rows; a P row included."""
    a, d, alpha = sp.symbols("a d alpha", real=True)
    q = sp.symbols("q1:4", real=True)
    rows = [(a, sp.pi / 2, 0, 0), (0.25, alpha, d, 0.5), (0, -sp.pi / 2, sp.Rational(1, 3), 0)]
    at = {a: 0.7, d: -0.2, alpha: 0.3}
    numeric = [[float(sp.sympify(x).subs(at)) for x in row] for row in rows]
    exact, plain = (ks.from_dh(r, convention=convention, types="RPR") for r in (rows, numeric))
    values_at = np.array([0.4, 0.9, -1.1])
    at |= dict(zip(q, values_at, strict=True))
    for quantity in (lambda arm, x: ks.pose(arm, x).array, lambda arm, x: ks.jacobian(arm, x).array):
        symbolic = sp.Matrix(quantity(exact, np.array(q, dtype=object)))
        np.testing.assert_allclose(np.array(symbolic.subs(at), dtype=float), quantity(plain, values_at), atol=1e-13)


def as_urdf(model):
    """The URDF text of a chain, written from the numbers of its model: each joint placed where its own axis is z."""
    parts, before = ['<robot name="written"><link name="l0"/>'], np.eye(4)
    for i, (kind, placement, screw) in enumerate(zip(model.kinds, model.placements, model.screws, strict=True)):
        v, w = screw[:3], screw[3:]
        axis, point = (v, np.zeros(3)) if kind == "prismatic" else (w, np.cross(w, v))
        at = before @ placement @ pose_of(p=point)
        parts.append(
            f'<link name="l{i + 1}"/><joint name="{model.moving_names[i]}" type="{kind}"><parent link="l{i}"/>'
            f'<child link="l{i + 1}"/>{origin(at)}<axis xyz="{numbers(axis)}"/>'
            f'<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )
        before = pose_of(p=-point)
    tip = before @ model.link_placements[model.link("tip")]
    parts.append(
        f'<link name="end"/><joint name="e" type="fixed"><parent link="l{model.n}"/><child link="end"/>{origin(tip)}</joint>'
    )
    return "".join([*parts, "</robot>"])


def numbers(values):
    """Numbers that are read back to the same bits."""
    return " ".join(repr(float(x)) for x in values)


def origin(T):
    """An <origin> element."""
    return f'<origin xyz="{numbers(T[:3, 3])}" rpy="{numbers(rotation_to_rpy(T[:3, :3]))}"/>'


@pytest.mark.parametrize("seed", range(12))
def test_table_screws_and_file_are_one_arm(tmp_path, seed):
    """DH = product of exponentials = URDF: three ways in, one pose and one Jacobian at every configuration."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 7
    rows = rng.uniform(-1, 1, (n, 4)) * [1, 3, 1, 3]
    types = "".join(rng.choice(["R", "R", "P"], n))
    table = ks.from_dh(rows, convention=("standard", "modified")[seed % 2], types=types)
    zero = np.zeros(n)
    axes = ks.jacobian(table, zero, frame=ks.Frame.spatial()).array.T
    screws = ks.from_screws(axes, ks.pose(table, zero).array, order="linear-angular")
    path = tmp_path / "written.urdf"
    path.write_text(as_urdf(table), encoding="utf-8")
    file = ks.load(path, tip="end")
    for q in rng.uniform(-3, 3, (5, n)):
        for other in (screws, file):
            np.testing.assert_allclose(ks.pose(other, q).array, ks.pose(table, q).array, atol=1e-13)
            np.testing.assert_allclose(ks.jacobian(other, q).array, ks.jacobian(table, q).array, atol=1e-13)


def test_a_table_without_rows_keeps_its_base_and_tool():
    """No joints, and still T_base_tool = base · tool."""
    base, tool = pose_of(np.diag([-1.0, -1.0, 1.0]), (1, 2, 3)), pose_of(p=(0.5, 0, 0))
    for given, expected in (
        ({"base": base, "tool": tool}, base @ tool),
        ({"base": base}, base),
        ({"tool": tool}, tool),
        ({}, np.eye(4)),
    ):
        arm = ks.from_dh([], convention="standard", **given)
        np.testing.assert_array_equal(ks.pose(arm, np.zeros(0)).array, expected)


def test_fractions_and_symbols_stay_exact():
    """A fraction among symbols is not rounded; a symbolic centre of mass makes the torques symbolic too."""
    a, q = sp.symbols("a q", real=True)
    arm = ks.from_dh([(Fraction(1, 3), 0, a, 0)], convention="standard")
    assert ks.pose(arm, [q]).translation[0] == sp.cos(q) / 3
    arm = ks.from_dh([(1, 0, 0, 0)], convention="standard", masses=[2.0], centers_of_mass=[(-a / 2, 0, 0)])
    found = ks.gravity_torques(arm, [q], gravity=(0, -10, 0))[0]
    assert sp.simplify(found - 20 * (1 - a / 2) * sp.cos(q)) == 0


ROWS = [(1.0, 0, 0, 0), (1.0, 0, 0, 0)]
AXES = [ks.screw_axis((0, 0, 1)), ks.screw_axis((0, 0, 1), (1, 0, 0))]


@pytest.mark.parametrize(
    ("rows", "options", "code"),
    [
        (ROWS, {"convention": "craig"}, "KS201"),
        (ROWS, {"types": "RX"}, "KS202.*'X'"),
        (ROWS, {"types": "R"}, "KS205.*types has 1 entries for 2 rows"),
        ([(1, 0, 0)], {}, "KS200.*row 1.*found 3"),
        ([1.0], {}, "KS200.*row 1.*found float"),
        (None, {}, "KS205.*rows is NoneType"),
        ([("1", 0, 0, 0)], {}, "KS203.*row 1: a is text"),
        ([(1, 0, 0, 1j)], {}, "KS203.*theta is complex"),
        ([(1, 0, math.nan, 0)], {}, "KS203.*row 1: d is nan"),
        ([(10**400, 0, 0, 0)], {}, "KS203.*a is inf"),
        ([(sp.oo, 0, 0, 0)], {}, "KS203.*a is oo"),
        ([(sp.I, 0, 0, 0)], {}, "KS203.*a is I"),
        (ROWS, {"joint_names": ["a", "a"]}, "KS131.*'a' is named twice"),
        (ROWS, {"joint_names": ["a", 1]}, "KS207.*joint_names"),
        (ROWS, {"limits": [(0, 1), (1, 0)]}, "KS152.*'joint2'"),
        (ROWS, {"limits": [(0, 1), (0, math.nan)]}, "KS208.*'joint2'"),
        (ROWS, {"limits": [(0, 1), (math.inf, math.inf)]}, "KS155.*'joint2'"),
        (ROWS, {"limits": [(0, 1), 1]}, "KS205.*'joint2'"),
        (ROWS, {"masses": [1, -1]}, r"KS160.*masses\[1\]"),
        (ROWS, {"masses": [1, math.nan]}, r"KS208.*masses\[1\]"),
        (ROWS, {"centers_of_mass": [(0, 0, 0), (0, 0)]}, r"KS206.*centers_of_mass\[1\] has shape \(2,\); expected \(3\)"),
        (ROWS, {"inertias": [np.eye(3), np.eye(2)]}, r"KS206.*inertias\[1\]"),
        (ROWS, {"base": 2 * np.eye(4)}, "KS212.*base"),
        (ROWS, {"tool": np.eye(3)}, r"KS212.*tool has shape \(3, 3\)"),
    ],
)
def test_bad_tables_say_what_is_wrong(rows, options, code):
    """Every argument of from_dh is checked: code, row or argument, and value."""
    with pytest.raises(ks.RobotDefinitionError, match=code):
        ks.from_dh(rows, **{"convention": "standard"} | options)


@pytest.mark.parametrize(
    ("axes", "options", "code"),
    [
        (AXES, {"order": "linear"}, "KS213"),
        (AXES[:1], {"order": None}, "KS213.*either order fits"),
        ([[0, 0, 1, 0, -2, 0]], {"order": None}, "KS213.*angular first only"),
        (AXES, {"frame": "tool"}, "KS214"),
        (AXES, {"home": np.eye(3)}, r"KS212.*\(3, 3\)"),
        (AXES, {"home": np.diag([1, 1, -1, 1])}, "KS212.*not a rotation"),
        (AXES, {"limits": [(0, 1)]}, "KS205.*limits has 1 entries for 2 screws"),
        (AXES, {"joint_names": ["x", "x"]}, "KS131"),
        ([2 * AXES[0]], {}, "KS210.*screw 1.*length 2"),
        ([np.zeros(6)], {}, "KS211.*screw 1 is zero"),
        ([[0, 0, 0, 0, 0, math.nan]], {}, "KS208.*nan"),
        (np.zeros((2, 3)), {}, r"KS206.*axes has shape \(2, 3\); expected \(n, 6\)"),
        (np.eye(12)[:1], {}, r"KS206.*\(1, 12\)"),
        ([[0, 0, 1], [0, 0, 0, 0, 0, 1]], {}, "KS206.*one length"),
        (3.0, {}, "KS205.*axes is float"),
        ([[sp.Symbol("a"), 0, 0, 0, 0, 1]], {}, "KS207.*symbols"),
    ],
)
def test_bad_screws_say_what_is_wrong(axes, options, code):
    """Every argument of from_screws is checked: code, screw or argument, and value."""
    with pytest.raises(ks.RobotDefinitionError, match=re.compile(code, re.DOTALL)):
        ks.from_screws(axes, **{"order": "linear-angular"} | options)


def test_screws_in_a_plain_order_need_no_word():
    """Where linear first alone fits, the order may be left out."""
    axes = [ks.screw_axis((0, 0, 1), (2, 0, 0)), ks.screw_axis((0, 0, 1), (1, 1, 0))]
    q = [0.3, -0.4]
    np.testing.assert_array_equal(
        ks.pose(ks.from_screws(axes), q).array, ks.pose(ks.from_screws(axes, order="linear-angular"), q).array
    )


@pytest.mark.parametrize("length", [5e-324, 3e-162, 1e-8, 1.0, 1e9, 1e49])
def test_an_axis_of_any_length_is_a_direction(length):
    """Axes in files and screws are normalised without losing digits, however short or long they are written."""
    text = WEIGHED.replace('<axis xyz="0 1 0"/>', f'<axis xyz="{length!r} {length!r} 0"/>', 1)
    robot = parse_urdf(text.encode(), "axis.urdf")
    expected = np.array([1, 1, 0]) / math.sqrt(2)
    np.testing.assert_allclose(robot.joints[0].screw[3:], expected, rtol=1e-15)
    np.testing.assert_allclose(ks.screw_axis((length, length, 0))[3:], expected, rtol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ('xyz="1 0 0"', 'xyz="1e60 0 0"', "KS148.*larger than 1e"),
        ('lower="-3"', 'lower="inf"', "KS152"),
        ('lower="-3" upper="3"', 'lower="inf" upper="inf"', "KS155"),
        ('upper="3"', 'upper="٣"', "KS145"),
        ('upper="3"', 'upper="1_0"', "KS145"),
    ],
)
def test_numbers_no_robot_has_are_refused(tmp_path, old, new, code):
    """Lengths that overflow, limits without a position between them, digits of other scripts: code and place."""
    with pytest.raises(ks.RobotFileError, match=rf"arm\.urdf:\d+:\d+: error {code}"):
        plain(tmp_path, WEIGHED.replace(old, new, 1).encode())


def test_the_largest_double_as_a_limit_means_none(tmp_path):
    """Exporters write "no limit" as ±1.8e308: such a joint is unlimited, and random configurations stay within a turn."""
    text = WEIGHED.replace('lower="-3" upper="3"', f'lower="-{sys.float_info.max!r}" upper="{sys.float_info.max!r}"', 1)
    arm = plain(tmp_path, text.encode())
    assert (arm.lower[0], arm.upper[0]) == (-np.inf, np.inf)
    assert np.all(np.abs(arm.random_configurations(100, seed=0)) <= math.pi)


@pytest.mark.parametrize("turns", [0.25, 3.1, 1e4 + 0.3, 1e9 + 0.1])
def test_large_angles_in_a_table_are_not_rounded_to_right_angles(turns):
    """Only what is a right angle to the last bit is made exact; the cosine of any other angle is its own."""
    angle = turns * math.pi / 2
    with pytest.warns(ks.KinestaticsWarning, match="KS204") if turns > 4 else contextlib.nullcontext():
        arm = ks.from_dh([(1.0, 0.0, 0.0, angle)], convention="standard")
    np.testing.assert_allclose(ks.pose(arm, [0.0]).translation, [math.cos(angle), math.sin(angle), 0], atol=1e-15)


def test_lengths_of_numbers_go_with_masses_of_symbols():
    """Kinematics at numbers; gravity torques are expressions; an Evaluator refuses to leave the masses out."""
    sympy = pytest.importorskip("sympy")
    m = sympy.Symbol("m")
    for masses, centers in (([m, m], [(-0.5, 0, 0)] * 2), ([2.0, 3.0], [(-m, 0, 0)] * 2)):
        arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard", masses=masses, centers_of_mass=centers)
        np.testing.assert_allclose(ks.pose(arm, [0.0, 0.0]).translation, [2, 0, 0])
        torques = ks.gravity_torques(arm, [0.0, 0.0], gravity=(0, -10, 0))
        assert all(sympy.sympify(t).has(m) for t in torques)
        evaluator = ks.Evaluator(arm)
        assert evaluator.jacobian([0.0, 0.0])[1].tolist() == [2.0, 1.0]
        with pytest.raises(ks.ArrayTypeError, match="KS302"):
            evaluator.gravity_torques([0.0, 0.0])
