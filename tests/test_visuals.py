"""What robots look like: shapes read from their files, placed in their links, and what is missing said once."""

import dataclasses
import os
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from audit import opened
from kinestatics.robots.shapes import SIZES
from kinestatics.robots.visuals import MAX_SHAPES, visuals

REAL = sorted(Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data/robots/**/*.urdf"))
UNREADABLE = {"alex_psyonic_hands.urdf": "KS170", "ur3.urdf": "KS121"}  # one mimics a joint that is not there, one is empty
ARM = """<robot name="r">
  <material name="blue"><color rgba="0 0 1 0.5"/></material>
  <link name="base"/>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><origin xyz="0 0 1"/></joint>
  <link name="arm">{}</link>
  <joint name="f" type="fixed"><parent link="arm"/><child link="flange"/><origin xyz="1 0 0"/></joint>
  <link name="flange"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
</robot>"""
SPHERE = '<visual><geometry><sphere radius="0.1"/></geometry></visual>'


def shape(geometry, rest=""):
    return f"<visual>{rest}<geometry>{geometry}</geometry></visual>"


@pytest.fixture
def look(tmp_path):
    """Writes a robot whose link "arm" looks like that, and reads its shapes."""
    folder = tmp_path / "model"
    folder.mkdir()

    def write_and_look(text, **arguments):
        path = folder / "robot.urdf"
        path.write_text(text if text.startswith("<robot") else ARM.format(text), encoding="utf-8")
        return visuals(ks.load(path), **arguments)

    write_and_look.folder = folder
    return write_and_look


@pytest.mark.parametrize(
    ("geometry", "kind", "size"),
    [
        ('<box size="1 2 3"/>', "box", (1.0, 2.0, 3.0)),
        ('<cylinder radius="0.1" length="0.5"/>', "cylinder", (0.1, 0.5)),
        ('<sphere radius="0.2"/>', "sphere", (0.2,)),
        ('<capsule radius="0.1" length="0.5"/>', "capsule", (0.1, 0.5)),
    ],
)
def test_simple_shapes(look, geometry, kind, size):
    """Kind, size and place are those of the file."""
    found = look(shape(geometry, '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'))
    first = found.shapes[0]
    assert (first.link, first.kind, first.size, first.file) == ("arm", kind, size, None)
    assert len(first.size) == SIZES[kind]
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(first.T_link_visual, expected, atol=1e-15)
    assert not found.findings


def test_shapes_on_fixed_links_move_with_their_carrier(look):
    """A fixed link is a link of the model: its shape stands where pose says."""
    look(SPHERE)
    arm = ks.load(look.folder / "robot.urdf", tip="flange")
    flange = visuals(arm).shapes[1]
    T = np.asarray(ks.pose(arm, [np.pi / 2], at=flange.link)) @ flange.T_link_visual
    np.testing.assert_allclose(T[:3, 3], [0, 1, 1], atol=1e-15)


def test_colors_by_name_and_inline(look):
    """A robot's material counts before a visual's own of that name; one in a visual is shared; textures give none."""
    own = '<material name="red"><color rgba="1 0 0 1"/></material>'
    override = '<material name="blue"><color rgba="0 1 0 1"/></material>'
    plain = [own, '<material name="red"/>', override, '<material name=""><color rgba="2 -1 0.5 1"/></material>', ""]
    plain.append('<material name="picture"><texture filename="../../x.png"/></material>')
    found = look("".join(shape('<sphere radius="1"/>', text) for text in plain))
    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.5)
    assert [s.color for s in found.shapes[:-1]] == [red, red, blue, (1.0, 0.0, 0.5, 1.0), None, None]


def test_mesh_is_found_and_scaled(look):
    """Relative paths, file:// and package:// lead to the file; its scale may be negative."""
    (look.folder / "a b.stl").write_bytes(b"")
    names = ["a b.stl", "file://a b.stl", "package://model/a%20b.stl", f"file://{look.folder}/a b.stl"]
    found = look("".join(shape(f'<mesh filename="{name}" scale="1 -2 3"/>') for name in names))
    assert [s.file for s in found.shapes[:-1]] == [Path(os.path.realpath(look.folder / "a b.stl"))] * 4
    assert found.shapes[0].scale == (1.0, -2.0, 3.0)
    assert not found.findings


def test_package_roots_of_load_are_kept(tmp_path):
    """What load was told about packages, the viewer needs no second time; and it may be told more."""
    for name in ("one", "two"):
        (tmp_path / "packages" / name).mkdir(parents=True)
        (tmp_path / "packages" / name / "a.stl").write_bytes(b"")
    path = tmp_path / "model" / "robot.urdf"
    path.parent.mkdir()
    path.write_text(ARM.format(shape('<mesh filename="package://one/a.stl"/>')), encoding="utf-8")
    assert len(visuals(ks.load(path, package_roots=[tmp_path / "packages"])).shapes) == 2
    assert len(visuals(ks.load(path)).shapes) == 1
    assert len(visuals(ks.load(path), package_roots=[tmp_path / "packages"]).shapes) == 2


def test_missing_and_outside_meshes_are_one_finding_each(look):
    """They are told once, with the paths that were searched; the rest is drawn, and nothing outside is touched."""
    (look.folder.parent / "secret.stl").write_bytes(b"")
    (look.folder / "link.stl").symlink_to(look.folder.parent / "secret.stl")
    missing = [f"missing{i}.stl" for i in range(3)]
    outside = ["../secret.stl", "link.stl", "/etc/passwd", "file:///etc/passwd", "package://model/../secret.stl"]
    body = "".join(shape(f'<mesh filename="{name}"/>') for name in [*missing, *outside]) + SPHERE
    look(body)
    arm = ks.load(look.folder / "robot.urdf")
    with opened() as paths:
        found = visuals(arm)
    assert [s.kind for s in found.shapes] == ["sphere", "sphere"]
    assert sorted(finding.code for finding in found.findings) == ["KS111", "KS180"]
    told = {finding.code: finding.message for finding in found.findings}
    assert "missing0.stl" in told["KS180"]
    assert str(look.folder / "missing0.stl") in told["KS180"]
    assert told["KS180"].endswith("and 2 more files")
    assert told["KS111"].endswith("and 4 more files")
    assert set(paths) == {os.path.realpath(look.folder / "robot.urdf")}


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("<visual/>", "KS125"),
        ("<visual><geometry/></visual>", "KS125"),
        (shape("<torus/>"), "KS124"),
        (shape('<box size="1 2"/>'), "KS144"),
        (shape('<box size="1 2 x"/>'), "KS145"),
        (shape('<box size="1 2 0"/>'), "KS164"),
        (shape('<sphere radius="-1"/>'), "KS164"),
        (shape('<sphere radius="nan"/>'), "KS146"),
        (shape('<sphere radius="1e30"/>'), "KS148"),
        (shape('<sphere radius="1"/>', '<origin xyz="1e30 0 0"/>'), "KS148"),
        (shape('<sphere radius="1"/>', '<origin xyz="1 2"/>'), "KS144"),
        (shape("<sphere/>"), "KS125"),
        (shape("<mesh/>"), "KS125"),
        (shape('<mesh filename="http://example.com/a.stl"/>'), "KS180"),
        (shape('<mesh filename="a.stl" scale="0 1 1"/>'), "KS164"),
        (shape('<sphere radius="1"/>', '<material name="m"><color rgba="1 1 1"/></material>'), "KS144"),
    ],
)
def test_a_bad_shape_is_a_finding_and_the_rest_is_drawn(look, body, code):
    """Each with its code and place; the robot and the other shapes are there."""
    (look.folder / "a.stl").write_bytes(b"")
    found = look(body + SPHERE)
    assert [finding.code for finding in found.findings] == [code]
    assert found.findings[0].place.line == 5
    assert [s.link for s in found.shapes][-2:] == ["arm", "flange"]


def test_too_many_shapes(look):
    """A page would not bear them all."""
    found = look(SPHERE * (MAX_SHAPES + 5))
    assert len(found.shapes) == MAX_SHAPES
    assert [finding.code for finding in found.findings] == ["KS108"]


def test_robots_without_a_file_have_no_shapes():
    """Catalogue, rows and screws."""
    assert not visuals(ks.load("puma_560")).shapes
    assert not visuals(ks.from_dh([(0, 1, 0, 0)], convention="standard")).shapes


def test_a_file_that_is_gone_is_a_finding(look):
    """The model stays; there is nothing to draw."""
    look(SPHERE)
    arm = ks.load(look.folder / "robot.urdf")
    (look.folder / "robot.urdf").unlink()
    found = visuals(arm)
    assert not found.shapes
    assert [finding.code for finding in found.findings] == ["KS109"]


def test_only_links_of_the_model(look):
    """A model that starts behind a joint it cannot move has the shapes of its own links."""
    text = ARM.format(SPHERE).replace('type="continuous"', 'type="floating"').replace("<axis", "<ignored")
    path = look.folder / "floating.urdf"
    path.write_text(text, encoding="utf-8")
    arm = ks.load(path, base="flange")
    assert {s.link for s in visuals(arm).shapes} == {"flange"}


def test_payload_and_home_keep_the_file(look):
    """Copies of a model remember where they came from."""
    look(SPHERE)
    arm = ks.load(look.folder / "robot.urdf")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ks.KinestaticsWarning)
        heavier = arm.with_payload(1.0)
    assert len(visuals(heavier.with_home([1.0])).shapes) == 2


def test_shapes_are_frozen(look):
    """Nothing in them can be changed in place."""
    first = look(SPHERE).shapes[0]
    with pytest.raises(ValueError, match="read-only"):
        first.T_link_visual[0, 0] = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        first.kind = "box"


def test_xacro_is_expanded_as_load_was_allowed_to(look):
    """The model remembers that its file is trusted."""
    pytest.importorskip("xacro")
    text = ARM.format(shape('<sphere radius="${0.1 + 0.2}"/>')).replace("<robot ", '<robot xmlns:xacro="x" ')
    path = look.folder / "robot.xacro"
    path.write_text(text, encoding="utf-8")
    found = visuals(ks.load(path, allow_xacro=True))
    assert [s.size for s in found.shapes] == [(pytest.approx(0.3),), (0.1,)]


@pytest.mark.skipif(not REAL, reason="example-robot-data is not installed")
def test_real_robots():
    """Every shape is on a link of its model, every mesh is there, and nothing but the robot's file is opened."""
    meshes = 0
    for path in REAL:
        if path.name in UNREADABLE:
            with pytest.raises(ks.RobotFileError, match=UNREADABLE[path.name]):
                ks.load(path, whole_tree=True)
            continue
        arm = ks.load(path, whole_tree=True)
        with opened() as paths:
            found = visuals(arm)
        assert set(paths) == {os.path.realpath(path)}
        assert {s.link for s in found.shapes} <= set(arm.link_names)
        files = [s.file for s in found.shapes if s.kind == "mesh"]
        assert all(file.is_file() and "example-robot-data" in file.parts for file in files)
        meshes += len(files)
        expected = {"romeo_laas_small.urdf": ["KS111"], "talos_full_v2.urdf": ["KS180"], "talos_full_v2_box.urdf": ["KS180"]}
        assert [finding.code for finding in found.findings] == expected.get(path.name, [])
    assert (len(REAL), meshes) == (69, 1237)


MODEL = """<mujoco>
  <compiler angle="radian" meshdir="meshes"/>
  <default><default class="shown"><geom group="2" material="steel"/></default></default>
  <asset>
    <material name="steel" rgba="0.1 0.2 0.3 1" specular="1"/>
    <mesh name="tetra" file="tetra.stl" scale="2 2 2" refpos="0.1 0.2 0.3" refquat="0.9 0.1 0.2 0.3"/>
    <mesh name="flat" file="tetra.stl" scale="1 2 3" refpos="0.1 0 0"/>
    <mesh name="written" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
    <mesh name="absent" file="absent.stl"/>
    <mesh name="outside" file="../../secret.stl"/>
  </asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="b" pos="0 0 1"><joint name="j1"/><joint name="j2" axis="0 1 0"/>
      <frame pos="0 0 1" euler="0 0.3 0">
        <geom class="shown" name="turned" type="mesh" mesh="tetra" pos="1 0 0" euler="0.1 0.2 0.3"/>
        <geom class="shown" name="stretched" type="mesh" mesh="flat" euler="0.1 0.2 0.3"/>
        <geom name="rod" type="capsule" fromto="0 0 0 0 1 0" size="0.1" rgba="1 0 0 0.5"/>
      </frame>
      <geom name="block" type="box" size="1 2 3"/>
      <geom name="egg" type="ellipsoid" size="1 2 3" class="shown"/>
      <geom name="can" type="cylinder" size="1 2"/>
      <geom name="hidden" type="sphere" size="1" group="3"/>
      <geom type="mesh" mesh="written"/>{}
    </body>
  </worldbody>
</mujoco>"""
TROUBLE = '<geom type="mesh" mesh="absent"/><geom type="mesh" mesh="outside"/>'
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
SIDES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.fixture
def mujoco_arm(tmp_path):
    """A MuJoCo model with a mesh beside it."""
    (tmp_path / "model" / "meshes").mkdir(parents=True)
    (tmp_path / "secret.stl").write_bytes(b"")
    triangles = np.zeros(4, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles["corners"] = CORNERS[SIDES]
    data = bytes(80) + (4).to_bytes(4, "little") + triangles.tobytes()
    (tmp_path / "model" / "meshes" / "tetra.stl").write_bytes(data)
    path = tmp_path / "model" / "robot.xml"

    def write(rest=""):
        path.write_text(MODEL.replace("{}", rest), encoding="utf-8")
        return path

    return write


def test_mujoco_shapes(mujoco_arm):
    """Kinds, sizes and colours of the shown groups; what cannot be drawn is told."""
    pytest.importorskip("mujoco")
    arm = ks.load(mujoco_arm(TROUBLE))
    found = visuals(arm)
    shapes = {s.name: s for s in found.shapes}
    assert set(shapes) == {"block", "egg", "can", "turned", "stretched", "rod"}
    assert {s.link for s in found.shapes} == {"b"}
    steel = pytest.approx((0.1, 0.2, 0.3, 1.0))
    assert (shapes["block"].size, shapes["block"].color) == ((2.0, 4.0, 6.0), (0.5, 0.5, 0.5, 1.0))
    assert (shapes["egg"].kind, shapes["egg"].size, shapes["egg"].color) == ("ellipsoid", (1.0, 2.0, 3.0), steel)
    assert (shapes["can"].kind, shapes["can"].size) == ("cylinder", (1.0, 4.0))
    assert (shapes["rod"].kind, shapes["rod"].color) == ("capsule", (1.0, 0.0, 0.0, 0.5))
    np.testing.assert_allclose(shapes["rod"].size, (0.1, 1.0), atol=1e-12)
    assert sorted(finding.code for finding in found.findings) == ["KS111", "KS124", "KS180"]


@pytest.mark.parametrize("name", ["turned", "stretched"])
def test_mujoco_places_a_mesh_there_too(mujoco_arm, name):
    """MuJoCo, which moves the mesh to its centre, draws the same points."""
    mujoco = pytest.importorskip("mujoco")
    path = mujoco_arm()
    drawn = next(s for s in visuals(ks.load(path)).shapes if s.name == name)
    ours = (CORNERS * drawn.scale) @ drawn.T_link_visual[:3, :3].T + drawn.T_link_visual[:3, 3]
    spec = mujoco.MjSpec.from_file(str(path))
    for mesh in list(spec.meshes):
        if mesh.name in ("absent", "outside"):
            spec.delete(mesh)
    model = spec.compile()
    geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name)
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, model.geom_quat[geom])
    theirs = model.mesh_vert[first : first + count] @ R.reshape(3, 3).T + model.geom_pos[geom]
    for corner in theirs:
        assert np.abs(ours - corner).max(axis=1).min() < 1e-6
    assert np.ptp(theirs, axis=0) == pytest.approx(np.ptp(ours, axis=0), abs=1e-6)
