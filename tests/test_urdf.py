"""The URDF reader: bad files by code and place, messages to the letter, good files right."""

import json
import os
import re
import time
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from corpus import codes, malformed
from kinestatics.robots.assemble import assemble
from kinestatics.robots.urdf import parse_urdf

CORPUS = {name: text for name, text in malformed().items() if name.endswith(".urdf")}
CODES = codes()
FINDINGS = {"KS122", "KS123", "KS143", "KS150", "KS151", "KS161", "KS162", "KS163", "KS180"}
MESSAGES = Path(__file__).parent / "golden" / "messages.json"


def outcome(name):
    """The message of the error, or of the findings, or "loads"."""
    try:
        description = parse_urdf(CORPUS[name].encode(), name)
    except ks.RobotFileError as error:
        return str(error)
    model = assemble(description, whole_tree=True)
    assert np.all(np.isfinite(model.placements))
    return "\n".join(str(finding) for finding in description.findings) or "loads"


@pytest.mark.parametrize("name", CORPUS)
def test_bad_file_has_its_code_and_place(name):
    """Every malformed file gives its documented code, as an error or as a finding, and never another exception."""
    began = time.process_time()
    found = outcome(name)
    assert time.process_time() - began < 2.0
    expected = CODES.get(name, "")
    if not expected:
        assert found == "loads"
        return
    word = "warning" if expected in FINDINGS else "error"
    assert re.search(rf"(^|: ){word} {expected}: ", found)
    assert found.startswith(name)


def test_messages_are_as_they_were():
    """Messages, to the letter. After a deliberate change: KINESTATICS_UPDATE=1 rewrites the file."""
    found = {name: outcome(name)[:400] for name in CORPUS}
    if os.environ.get("KINESTATICS_UPDATE"):
        MESSAGES.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert found == json.loads(MESSAGES.read_text(encoding="utf-8"))


TREE = """<robot name="tree">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="2"/></inertial></link>
  <link name="left"><inertial><mass value="1"/></inertial></link>
  <link name="right"><inertial><mass value="1"/></inertial></link>
  <link name="tool"><inertial><mass value="0.5"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="left"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0.1" upper="1" effort="10" velocity="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="arm"/><child link="right"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/><mimic joint="slide" multiplier="-2" offset="0.25"/></joint>
  <joint name="weld" type="fixed"><parent link="right"/><child link="tool"/><origin xyz="0 0.3 0"/></joint>
</robot>"""


@pytest.fixture
def tree(tmp_path):
    path = tmp_path / "tree.urdf"
    path.write_text(TREE, encoding="utf-8")
    return path


def test_several_leaves_are_listed(tree):
    """Without a tip, the possible ones are named."""
    with pytest.raises(ks.RobotDefinitionError, match=r"KS314.*left, tool"):
        ks.load(tree)


def test_chain_holds_its_side_branches_and_keeps_their_mass(tree):
    """Joints off the path stand at their home or at the limit nearest to zero; what hangs on them is carried."""
    arm = ks.load(tree, tip="arm")
    assert arm.joint_names == ("turn",)
    assert arm.frozen == {"slide": 0.1}
    follower = -2 * 0.1 + 0.25
    torque = 9.81 * (2 * 0.5 + 1 * 1 + 1 * 1 + 0.5 * 1)  # all at x = 0.5 or 1 when level
    np.testing.assert_allclose(ks.gravity_torques(arm, [0.0]), [-torque], atol=1e-12)
    np.testing.assert_allclose(ks.pose(arm, [0.0], at="tool").translation, [1, 0.3, follower], atol=1e-15)


def test_mimic_joint_moves_with_its_master(tree):
    """The follower's motion is folded into the master's column, also where only the follower is on the path."""
    arm = ks.load(tree, tip="tool")
    assert arm.joint_names == ("turn", "slide")
    np.testing.assert_allclose(ks.jacobian(arm, [0.0, 0.0]).linear[:, 1], [0, 0, -2])
    np.testing.assert_allclose(ks.pose(arm, [0.0, 0.5]).translation, [1, 0.3, -0.75])


def test_held_joints_keep_the_value_given(tree):
    """joints={name: value} holds a joint there, and its followers with it."""
    arm = ks.load(tree, tip="tool", joints={"slide": 0.5})
    assert arm.joint_names == ("turn",)
    np.testing.assert_allclose(ks.pose(arm, [0.0]).translation, [1, 0.3, -0.75])


def test_any_link_may_be_the_base(tree):
    """Seen from the tool, the base moves the other way."""
    there, back = ks.load(tree, tip="tool"), ks.load(tree, base="tool", tip="base")
    q = {"turn": 0.3, "slide": 0.4}
    forward = ks.pose(there, [q[name] for name in there.joint_names]).array
    backward = ks.pose(back, [q[name] for name in back.joint_names]).array
    np.testing.assert_allclose(forward @ backward, np.eye(4), atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"tip": "tol"}, "KS310.*did you mean 'tool'"),
        ({"base": "bas", "tip": "arm"}, "KS310.*did you mean 'base'"),
        ({"tip": "arm", "joints": {"slid": 0.1}}, "KS313.*did you mean 'slide'"),
    ],
)
def test_unknown_names_are_matched_to_the_nearest(tree, arguments, code):
    """A misspelt name is answered with the nearest one."""
    with pytest.raises(ks.UnknownNameError, match=re.compile(code, re.DOTALL)):
        ks.load(tree, **arguments)


def test_missing_file_names_its_neighbour(tree):
    """A misspelt file is answered with the nearest one in the folder."""
    with pytest.raises(ks.RobotFileError, match=re.compile(r"KS109.*tree\.urdf", re.DOTALL)):
        ks.load(tree.with_name("tre.urdf"))


def test_unknown_catalogue_name():
    """A misspelt catalogue name is answered with the nearest one."""
    with pytest.raises(ks.UnknownNameError, match=re.compile(r"KS312.*ur5e", re.DOTALL)):
        ks.load("ur5ee")


def test_joint_of_several_freedoms_is_read_from_behind(tmp_path):
    """A floating joint is refused by name; the robot behind it loads when the base is named."""
    path = tmp_path / "floating.urdf"
    extra = (
        '<link name="world"/><joint name="free" type="floating"><parent link="world"/><child link="base"/></joint></robot>'
    )
    path.write_text(TREE.replace("</robot>", extra), encoding="utf-8")
    with pytest.raises(ks.RobotFileError, match=r"KS140.*'free'"):
        ks.load(path, tip="tool")
    assert ks.load(path, base="base", tip="tool").n == 2


def test_mesh_paths_stay_inside_the_model_folder(tmp_path):
    """A mesh outside the folder, through .. or a link, is a finding; no file but the model is opened."""
    (tmp_path / "secret.stl").write_text("solid", encoding="utf-8")
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "link.stl").symlink_to(tmp_path / "secret.stl")
    visuals = "".join(
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in ("../secret.stl", "link.stl", "/etc/hostname", "http://127.0.0.1/x.stl", "file:///etc/hostname")
    )
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="r"><link name="a">{visuals}</link></robot>', encoding="utf-8")
    findings = [finding.code for finding in ks.load(path).findings]
    assert findings == ["KS111", "KS111", "KS111", "KS180", "KS111"]


def test_base_and_tip_are_words_even_where_links_are_called_so(tmp_path):
    """A link called "base" that is not the base (as in Universal Robots' files) does not turn the default frame."""
    path = tmp_path / "collision.urdf"
    turned = (
        '<link name="root"/><joint name="w" type="fixed"><parent link="root"/><child link="base"/>'
        '<origin rpy="0 0 3.141592653589793"/></joint></robot>'
    )
    path.write_text(TREE.replace("</robot>", turned), encoding="utf-8")
    arm = ks.load(path, tip="arm")
    J = ks.jacobian(arm, [0.0])
    assert J.frame.axes == "root"
    np.testing.assert_allclose(J.angular[:, 0], [0, -1, 0], atol=1e-15)
    other = ks.jacobian(arm, [0.0], frame=ks.Frame("link:base", "tip"))
    assert other.frame.axes == "link:base"
    np.testing.assert_allclose(other.angular[:, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(J.change_frame(other.frame).array, other.array, atol=1e-15)
