"""The MJCF reader: bad files by code and place, what is missing as findings, MuJoCo kept in a bounded child."""

import dataclasses
import json
import os
import re
import subprocess
import sys
import time

import numpy as np
import pytest

import kinestatics as ks
from corpus import codes, malformed
from kinestatics.robots import mjcf, mjcf_source

CORPUS = {name: text for name, text in malformed().items() if name.endswith(".xml")}
CODES = codes() | {"eq_missing.xml": "KS170"}
FINDINGS = {"KS111": ("mesh_abs_nonmesh.xml", "mesh_up.xml"), "KS161": ("no_mass.xml",)}
BALL = '<geom size="0.1"/>'
HINGE = f'<body name="b"><joint name="j" axis="0 1 0"/>{BALL}</body>'


def world(text, rest="", attributes='angle="radian"'):
    return f"<mujoco><compiler {attributes}/>{rest}<worldbody>{text}</worldbody></mujoco>"


@pytest.fixture
def load(tmp_path):
    """Writes a model into a folder of its own and loads it."""
    folder = tmp_path / "model"
    folder.mkdir()
    path = folder / "robot.xml"

    def write_and_load(text, **arguments):
        path.write_text(text, encoding="utf-8")
        return ks.load(path, **{"whole_tree": True} | arguments)

    write_and_load.folder = folder
    return write_and_load


def found_codes(arm):
    return [finding.code for finding in arm.findings]


@pytest.mark.parametrize("name", CORPUS)
def test_bad_file_has_its_code_and_place(tmp_path, name):
    """Every malformed model gives its documented code with its place, soon, and never another exception."""
    path = tmp_path / name
    path.write_text(CORPUS[name], encoding="utf-8")
    expected = CODES[name]
    began = time.monotonic()
    if expected and name not in FINDINGS.get(expected, ()):
        with pytest.raises(ks.RobotFileError, match=rf"{re.escape(name)}:1:\d+: error {expected}: "):
            ks.load(path, whole_tree=True)
    else:
        arm = ks.load(path, whole_tree=True)
        assert found_codes(arm) == ([expected] if expected else [])
        assert all(re.search(rf"{re.escape(name)}:1:\d+: ", str(finding)) for finding in arm.findings)
        assert np.all(np.isfinite(arm.placements))
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (world('<body><joint name="j"/><joint name="j"/><geom size="0.1"/></body>'), "KS131"),
        (world('<body><joint axis="1 0"/><geom size="0.1"/></body>'), "KS144"),
        (world('<body><joint axis="1 0 0 0"/><geom size="0.1"/></body>'), "KS144"),
        (world('<body><joint axis="0x1 0 0"/><geom size="0.1"/></body>'), "KS145"),
        (world('<body pos="1e60 0 0"><joint/><geom size="0.1"/></body>'), "KS148"),
        (world('<body><joint/><inertial mass="1" diaginertia="1 1 1"/></body>'), "KS125"),
        (world('<body><joint/><inertial pos="0 0 0" mass="-1" diaginertia="1 1 1"/></body>'), "KS160"),
        (world('<body><joint/><geom size="0.1" mass="-1"/></body>'), "KS160"),
        (world(HINGE, '<actuator><plugin plugin="x" joint="j"/></actuator>'), "KS112"),
        (world('<body><joint class="nope"/></body>'), "KS191"),
        (world('<body><joint type="screw"/></body>'), "KS191"),
        ("<!DOCTYPE mujoco><mujoco/>", "KS110"),
        ('<mujoco><include file="gone.xml"/></mujoco>', "KS190"),
        ("<mujoco><include/></mujoco>", "KS125"),
        (world('<composite type="cable" count="100 100 100"/>'), "KS108"),
        (world(HINGE, '<asset><model name="m" file="/etc/passwd"/></asset>'), "KS111"),
        (world(HINGE, '<asset><model name="m" file="gone.xml"/></asset>'), "KS190"),
        (world(HINGE, '<equality><joint joint1="j" joint2="k"/></equality>'), "KS170"),
    ],
)
def test_other_mistakes_have_codes(load, text, code):
    """Mistakes that the corpus does not hold have a code and a place too."""
    with pytest.raises(ks.RobotFileError, match=rf"robot\.xml:1:\d+: error {code}: "):
        load(text)


def test_messages_of_mujoco_are_placed_in_the_included_file(load):
    """A mistake that MuJoCo finds is shown in the file, line and column where it was written."""
    (load.folder / "part.xml").write_text("<x>\n\n  <worldbody>\n    <body><joint axis='0 0 0'/></body>\n  </worldbody></x>")
    with pytest.raises(ks.RobotFileError, match=r"part\.xml:4:11: error KS142: MuJoCo: axis too small"):
        load('<mujoco><include file="part.xml"/></mujoco>')


@pytest.mark.parametrize(
    ("content", "code"),
    [
        ("plain text", "KS190"),
        ('<mujoco><include file="part.xml"/></mujoco>', "KS190"),
        ('<mujoco><include file="robot.xml"/></mujoco>', "KS190"),
        ('<mujoco><include file="../secret.xml"/></mujoco>', "KS111"),
        ('<!DOCTYPE x [<!ENTITY e "e">]><x/>', "KS110"),
        ("<x>" + "<body>" * 250 + "</body>" * 250 + "</x>", "KS103"),
    ],
)
def test_included_files_are_read_as_strictly(load, content, code):
    """What is not MJCF, includes itself, leaves the folder, or nests too deep once it stands in its place, is refused."""
    (load.folder.parent / "secret.xml").write_text("<mujoco/>", encoding="utf-8")
    (load.folder / "part.xml").write_text(content, encoding="utf-8")
    nested = "<worldbody><body><body><body><body><body>{}</body></body></body></body></body></worldbody>"
    with pytest.raises(ks.RobotFileError, match=f"error {code}"):
        load("<mujoco>" + nested.format('<include file="part.xml"/>') + "</mujoco>")


def test_link_out_of_the_folder_is_not_included(load):
    """A symbolic link is followed before it is judged; a root that the user names is allowed."""
    shared = load.folder.parent / "shared"
    shared.mkdir()
    (shared / "part.xml").write_text(f"<x><worldbody>{HINGE}</worldbody></x>", encoding="utf-8")
    (load.folder / "part.xml").symlink_to(shared / "part.xml")
    text = '<mujoco><include file="part.xml"/></mujoco>'
    with pytest.raises(ks.RobotFileError, match="KS111"):
        load(text)
    assert load(text, package_roots=[shared]).joint_names == ("j",)


def test_attached_models_that_attach_one_another_are_refused(load):
    """Models that attach each other without end stop at the limit on files."""
    text = world(HINGE, '<asset><model name="m" file="robot.xml"/></asset>')
    with pytest.raises(ks.RobotFileError, match=r"KS108.*100 files"):
        load(text)


def test_limit_on_processor_time(load, monkeypatch):
    """A model that MuJoCo cannot finish in time is an error with the limit and a remedy."""
    monkeypatch.setattr(mjcf_source, "MAX_GENERATED", 10**9)
    monkeypatch.setattr(mjcf, "LIMITS", dataclasses.replace(mjcf.LIMITS, processor=2))
    began = time.monotonic()
    with pytest.raises(ks.RobotFileError, match=re.compile(r"KS108.*2 s of processor time.*hint: make", re.DOTALL)):
        load(CORPUS["replicate_bomb.xml"])
    assert time.monotonic() - began < 15.0


def test_limit_on_wall_time(load, monkeypatch):
    """A child that gives no answer in time is ended."""
    monkeypatch.setattr(mjcf_source, "MAX_GENERATED", 10**9)
    monkeypatch.setattr(mjcf, "LIMITS", dataclasses.replace(mjcf.LIMITS, wall=1.0))
    began = time.monotonic()
    with pytest.raises(ks.RobotFileError, match=r"KS108.*1 s of wall time"):
        load(CORPUS["replicate_bomb.xml"])
    assert time.monotonic() - began < 4.0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds the address space of a process")
def test_limit_on_memory(load, monkeypatch):
    """A model that needs more memory than the child may have is an error with the limit."""
    monkeypatch.setattr(mjcf_source, "MAX_GENERATED", 10**9)
    monkeypatch.setattr(mjcf, "LIMITS", dataclasses.replace(mjcf.LIMITS, memory=620 << 20))
    names = "".join(f'<body name="{"n" * 4000}{i}"><joint/>{BALL}</body>' for i in range(400))
    with pytest.raises(ks.RobotFileError, match="KS108"):
        load(world(f'<replicate count="10" offset="1 0 0">{names}</replicate>'))


def test_missing_mesh_stops_nothing(load):
    """With an <inertial>, a mesh that is missing, broken or outside is a finding; kinematics and masses are there."""
    (load.folder / "broken.stl").write_bytes(b"solid nonsense")
    meshes = "".join(
        f'<mesh name="m{i}" file="{file}"/>'
        for i, file in enumerate(("gone.stl", "broken.stl", "../out.obj", "/etc/hostname"))
    )
    geoms = "".join(f'<geom type="mesh" mesh="m{i}" material="paint"/>' for i in range(4))
    inertial = '<inertial pos="0.5 0 0" mass="2" diaginertia="1 1 1"/>'
    assets = f'<asset>{meshes}<texture name="t" type="2d" file="gone.png"/><material name="paint" texture="t"/></asset>'
    arm = load(world(f'<body name="b"><joint name="j" axis="0 1 0"/>{inertial}{geoms}</body>', assets))
    assert sorted(found_codes(arm)) == ["KS111", "KS111", "KS180", "KS180"]
    np.testing.assert_allclose(ks.gravity_torques(arm, [0.0]), [-2 * 9.81 * 0.5])


@pytest.mark.parametrize("file", ["gone.stl", "broken.stl"])
def test_unknown_mass_makes_gravity_an_error(load, file):
    """Where a missing or broken mesh would give a mass, kinematics loads, says so, and gravity is no silent wrong number."""
    (load.folder / "broken.stl").write_bytes(b"solid nonsense")
    asset = f'<asset><mesh name="m" file="{file}"/></asset>'
    arm = load(world(f'<body name="b" pos="0 0 1"><joint axis="0 1 0"/>{BALL}<geom type="mesh" mesh="m"/></body>', asset))
    assert found_codes(arm)[-2:] == ["KS165", "KS165"]
    assert "link 'b': mass is unknown" in str(arm.findings[-2])
    np.testing.assert_allclose(ks.pose(arm, [0.0], at="b").translation, [0, 0, 1])
    with pytest.raises(ks.MissingMassError):
        ks.gravity_torques(arm, [0.0])


def test_unknown_mass_of_what_stands_still_does_not_count(load):
    """A stand without its mesh does not take the weight of the arm away, unless the stand is made to move."""
    text = world(
        f'<body name="stand"><geom type="mesh" mesh="m"/>{HINGE}</body>', '<asset><mesh name="m" file="gone.stl"/></asset>'
    )
    assert load(text).has_masses
    assert not load(text, base="b").has_masses


@pytest.mark.parametrize(
    ("moments", "code"),
    [
        ('diaginertia="1 1 5"', "KS163"),
        ('diaginertia="1 -1 1"', "KS162"),
        ('diaginertia="1 1 0"', "KS162"),
        ('fullinertia="1 1 1 2 0 0"', "KS162"),
        ('fullinertia="1 1 3 0.1 0 0"', "KS163"),
        ('diaginertia="0 0 0"', None),
    ],
)
def test_unsound_inertia_is_a_finding(load, moments, code):
    """An inertia that MuJoCo refuses is kept as the file has it; mass and kinematics are not touched."""
    turned = "" if "full" in moments else 'euler="0 0 1.5707963267948966"'
    arm = load(world(f'<body><joint axis="0 1 0"/><inertial pos="1 0 0" mass="2" {turned} {moments}/></body>'))
    assert found_codes(arm) == ([code] if code else [])
    numbers = [float(word) for word in moments.split('"')[1].split()]
    expected = np.diag([numbers[1], numbers[0], numbers[2]])
    if "full" in moments:
        expected = np.diag(numbers[:3])
        expected[0, 1] = expected[1, 0] = numbers[3]
    np.testing.assert_allclose(arm.inertias[1], expected, atol=1e-15)
    np.testing.assert_allclose(ks.gravity_torques(arm, [0.0]), [-2 * 9.81])


def test_names_are_stable_and_free(load):
    """Unnamed bodies and joints are numbered, links between joints named after the next, sites give way to bodies."""
    arm = load(
        world(
            f'<body name="a"><joint/><joint name="k"/><joint/>{BALL}<site name="a"/><site name="end"/>'
            f'<body><joint name="a_joint"/>{BALL}<body>{BALL}</body></body></body>'
        )
    )
    assert arm.joint_names == ("a_joint2", "k", "a_joint3", "a_joint")
    assert arm.link_names == ("world", "a", "body2", "body3", "a_before_k", "a_before_a_joint3", "a_site", "end")
    assert found_codes(arm) == ["KS126"]


@pytest.mark.parametrize(
    ("sites", "tip"), [("", "b"), ('<site name="end"/>', "end"), ('<site name="end"/><site name="imu"/>', "b")]
)
def test_default_tip(load, sites, tip):
    """Sites along the arm are no ends; the last body is the tip, or the only site on it."""
    arm = load(world(f'<body name="a"><joint/>{BALL}<site name="along"/><body name="b"><joint/>{BALL}{sites}</body></body>'))
    assert arm.tip == tip
    assert load(world(HINGE.replace("</body>", '<site name="s" pos="1 0 0"/></body>')), base="s", tip="world").n == 1


def test_effort_limits(load):
    """Motors give ctrlrange times gain and gear, servos their forcerange, a joint its actuatorfrcrange; the least counts."""
    names = ("motor", "two", "servo", "joint", "both", "free", "skew", "oneway")
    bodies = "".join(
        f'<body><joint name="{name}"'
        + (' actuatorfrcrange="-4 4"' if name in ("joint", "both") else "")
        + f"/>{BALL}</body>"
        for name in names
    )
    actuators = """<actuator><motor joint="motor" ctrlrange="-2 2" gear="-3"/>
        <motor joint="two" ctrlrange="-1 1"/><general joint="two" ctrlrange="-1 1" gainprm="5"/>
        <position joint="servo" kp="9" forcerange="-7 7" gear="2" ctrlrange="-1 1"/>
        <motor joint="both" ctrlrange="-100 100"/><position joint="free" kp="9" ctrlrange="-1 1"/>
        <motor joint="skew" ctrlrange="-1 3"/><motor joint="oneway" ctrlrange="0 3"/></actuator>"""
    arm = load(world(bodies, actuators))
    np.testing.assert_array_equal(arm.effort_limits, [6, 6, 14, 4, 4, np.inf, 1, np.inf])
    assert found_codes(arm) == ["KS156", "KS156"]


def test_home_is_the_keyframe_of_that_name(load):
    """The keyframe "home" is home; one of the wrong size is a finding."""
    key = '<keyframe><key name="zero" qpos="0"/><key name="home" qpos="{}" ctrl="1 2 3"/></keyframe>'
    np.testing.assert_array_equal(load(world(HINGE, key.format("0.4"))).home, [0.4])
    arm = load(world(HINGE, key.format("0.4 0.5")))
    assert (arm.home[0], found_codes(arm)) == (0.0, ["KS157"])


@pytest.mark.parametrize(
    ("equality", "code"),
    [
        ('<joint joint1="k" joint2="j" polycoef="0 1 0.5 0 0"/>', "KS174"),
        ('<joint joint1="k" polycoef="0.5 0 0 0 0"/>', "KS174"),
        ('<joint joint1="k" joint2="j"/><joint joint1="j" joint2="k"/>', "KS174"),
        ('<joint joint1="k" joint2="j"/><joint joint1="k" joint2="j" polycoef="0 2 0 0 0"/>', "KS174"),
        ('<connect body1="b" body2="c" anchor="0 0 0"/>', "KS173"),
        ('<weld body1="b" body2="c"/>', "KS173"),
        ('<weld body1="b" body2="c" active="false"/>', None),
    ],
)
def test_couplings_that_are_not_modelled_are_findings(load, equality, code):
    """What is no straight line from one joint to another, or closes a loop, is said and not guessed."""
    arm = load(world(HINGE + f'<body name="c"><joint name="k"/>{BALL}</body>', f"<equality>{equality}</equality>"))
    assert found_codes(arm) == ([code] if code else [])
    assert arm.n == (1 if equality.count("<joint") == 2 else 2)


def test_deformable_parts_are_left_out_with_a_finding(load):
    """A cable is no chain of links here; the arm loads without it."""
    cable = '<composite type="cable" curve="s" count="5 1 1" size="1"><geom type="capsule" size="0.01"/></composite>'
    assert found_codes(load(world(HINGE + cable))) == ["KS175"]


@pytest.mark.parametrize("joint", ["<freejoint/>", '<joint type="ball"/>', '<joint type="free"/>'])
def test_joint_of_several_freedoms_is_read_from_behind(load, joint):
    """A free or ball joint is refused with the remedy; the arm behind or beside it loads when its base is named."""
    scene = world(f'<body name="box">{joint}{BALL}{HINGE}</body><body name="arm"><joint name="k"/>{BALL}</body>')
    with pytest.raises(ks.RobotFileError, match=re.compile(r"KS140.*'box_joint'.*base='box'", re.DOTALL)):
        load(scene)
    assert load(scene, base="box").joint_names == ("j",)
    assert load(scene, base="arm").n == 0


def test_ordinary_arm_loads_within_a_second(load):
    """Seven bodies with defaults, sites and motors: less than a second, most of it the start of the child."""
    text = f'<body pos="0.1 0 0.2"><joint axis="0 1 0" range="-1 1"/>{BALL}<site pos="0 0 0.1"/>'
    began = time.monotonic()
    assert load(world(text * 7 + "</body>" * 7)).n == 7
    assert time.monotonic() - began < 1.0


def test_missing_package_is_named(load, monkeypatch):
    """Without mujoco the error says which command installs it."""
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ks.MissingExtraError, match=re.compile(r"KS400.*kinestatics\[mjcf\]", re.DOTALL)):
        load(world(HINGE))


def test_same_file_gives_the_same_robot(load):
    """Names and numbers do not change from one load to the next, and the file is not changed."""
    text = world(HINGE + f"<body><joint/>{BALL}</body>")
    first, second = load(text), load(text)
    assert (first.joint_names, first.link_names) == (second.joint_names, second.link_names)
    np.testing.assert_array_equal(first.placements, second.placements)
    assert [path.name for path in load.folder.iterdir()] == ["robot.xml"]


def watch(code):
    """What a fresh process imports of MuJoCo and which files it opens, while it runs `code`."""
    program = f"""
import json, sys
import kinestatics as ks
from kinestatics.robots import bounded, loading, mjcf, urdf
import subprocess, threading
opened = []
def hook(event, arguments):
    if event in ("open", "os.listdir", "socket.connect", "pickle.find_class") and isinstance(arguments[0], str):
        opened.append([event, arguments[0]])
sys.addaudithook(hook)
{code}
print(json.dumps([sorted(name for name in sys.modules if name.startswith("mujoco")), opened]))
"""
    return json.loads(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout)


def test_users_process_imports_no_mujoco_and_opens_nothing_outside(tmp_path):
    """Over the whole corpus MuJoCo stays in the child; nothing outside the model's folder is opened, and no connection."""
    for name, text in CORPUS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    imported, opened = watch(f"""
for name in {sorted(CORPUS)!r}:
    try:
        ks.load({str(tmp_path)!r} + "/" + name, whole_tree=True)
    except ks.RobotFileError:
        pass
""")
    assert imported == []
    libraries = (sys.prefix, sys.base_prefix, os.path.dirname(ks.__file__))
    assert {event for event, path in opened if not path.startswith(libraries)} <= {"open"}  # imports list their own folders
    allowed = (str(tmp_path), "/dev/null")
    outside = [path for _, path in opened if not path.startswith(allowed) and not path.startswith(libraries)]
    assert not outside
    assert len([path for _, path in opened if path.startswith(str(tmp_path))]) >= len(CORPUS)


def test_child_opens_nothing_that_a_model_names(tmp_path):
    """The text handed to MuJoCo holds no path: not of an include, a mesh, a texture or a height field."""
    (tmp_path / "part.stl").write_bytes(b"")
    path = tmp_path / "robot.xml"
    assets = (
        '<asset><mesh file="part.stl"/><mesh name="n" file="/etc/passwd"/><texture type="2d" name="t" file="/etc/passwd"/>'
        '<hfield name="h" file="/etc/passwd" size="1 1 1 1"/><skin file="/etc/passwd"/></asset>'
    )
    path.write_text(world(HINGE + '<geom type="hfield" hfield="h"/>', assets, 'meshdir="/etc"'), encoding="utf-8")
    source = mjcf_source.read_source(path, ())
    assert "passwd" not in source.text
    assert "/etc" not in source.text
    assert set(source.meshes.values()) == {None}
    assert ks.load(path).n == 1


@pytest.mark.parametrize("name", ["replicate_bomb.xml", "include_abs.xml", "plugin_unknown.xml", "zero_axis.xml"])
def test_hostile_file_in_a_shell(tmp_path, name):
    """Exit code 2 and one message, never a traceback."""
    path = tmp_path / name
    path.write_text(CORPUS[name], encoding="utf-8")
    command = [sys.executable, "-m", "kinestatics", "analyze", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f"error {CODES[name]}: " in done.stderr
    assert "Traceback" not in done.stderr + done.stdout


def test_home_is_where_mujoco_starts(tmp_path):
    """Without a keyframe "home" joints start, and are held, at their reference; what is left out is a finding."""
    path = tmp_path / "m.xml"
    path.write_text(
        """<mujoco><compiler angle="radian"/><option gravity="0 0 -1.62"/><worldbody><body name="a" gravcomp="1">
        <joint name="j" axis="0 1 0" ref="0.5" stiffness="3"/><geom type="sphere" size="0.1" mass="1" pos="1 0 0"/>
        <body name="b"><joint name="s" type="slide" axis="1 0 0" ref="0.2"/><geom type="sphere" size="0.1" mass="1"/></body>
        <body name="c" pos="0 0 1"><joint name="side" axis="0 1 0" ref="0.7"/><geom type="sphere" size="0.1" mass="2"/>
        </body></body></worldbody></mujoco>""",
        encoding="utf-8",
    )
    arm = ks.load(path, tip="b")
    assert dict(zip(arm.joint_names, arm.home, strict=True)) == {"j": 0.5, "s": 0.2}
    assert arm.frozen == {"side": 0.7}
    assert [finding.code for finding in arm.findings] == ["KS176", "KS177", "KS178"]
    assert "gravity=(0, 0, -1.62)" in arm.findings[0].message
