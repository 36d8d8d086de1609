"""What other libraries call the Jacobian, asked of the libraries themselves: Pinocchio, Modern Robotics and MuJoCo.

Each computes the Jacobian of real arms from its own reading of the file; `to_array(convention=...)` must be its array.
"""

import importlib.metadata
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import kinestatics as ks

pin = pytest.importorskip("pinocchio", reason="the judges are part of the dev extra")

ARMS = {  # file of example-robot-data, tip, and the number of joints on the way to it
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand_tcp", 7),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "tool0", 6),
    "kinova": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", 6),
}
TOLERANCE = 1e-12


@cache
def path_of(name):
    files = importlib.metadata.files("example-robot-data") or []
    return next(Path(file.locate()).resolve() for file in files if str(file).endswith(ARMS[name][0]))


@cache
def arm_of(name):
    return ks.load(path_of(name), tip=ARMS[name][1])


@cache
def judge_of(name):
    """Pinocchio's model, for each joint of ours its index there, and the index of the tip's frame."""
    judge = pin.buildModelFromUrdf(str(path_of(name)))
    return judge, [judge.getJointId(joint) for joint in arm_of(name).joint_names], judge.getFrameId(ARMS[name][1])


def postures(name):
    """Three seeded configurations of the arm, every joint away from zero."""
    return np.random.default_rng(13).uniform(0.2, 1.4, (3, ARMS[name][2])) * [(-1.0) ** k for k in range(ARMS[name][2])]


def pinocchio_configuration(name, q):
    judge, joints, _ = judge_of(name)
    configuration = pin.neutral(judge)
    for index, value in zip(joints, q, strict=True):
        joint = judge.joints[index]
        configuration[joint.idx_q : joint.idx_q + joint.nq] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
    return configuration


def assert_same(found, expected):
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() <= TOLERANCE * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", ARMS)
def test_the_arm_is_the_one_that_is_meant(name):
    """Six or seven joints to the tip, all general: the kinds of convention differ from one another by far."""
    arm = arm_of(name)
    assert arm.n == ARMS[name][2]
    J = ks.jacobian(arm, postures(name)[0])
    arrays = [
        J.to_array(convention=c) for c in ("pinocchio.WORLD", "pinocchio.LOCAL", "pinocchio.LOCAL_WORLD_ALIGNED", "drake")
    ]
    arrays += [J.to_array(convention=c) for c in ("modern_robotics.space", "modern_robotics.body")]
    for i, one in enumerate(arrays):
        assert all(np.abs(one - other).max() > 0.1 for other in arrays[:i])


@pytest.mark.parametrize("reference", ["WORLD", "LOCAL", "LOCAL_WORLD_ALIGNED"])
@pytest.mark.parametrize("name", ARMS)
def test_pinocchio(name, reference):
    """computeFrameJacobian in each of Pinocchio's three reference frames; and it is recognised as that one."""
    arm, (judge, joints, tip) = arm_of(name), judge_of(name)
    for q in postures(name):
        data = judge.createData()
        full = pin.computeFrameJacobian(judge, data, pinocchio_configuration(name, q), tip, getattr(pin, reference))
        expected = full[:, [judge.joints[index].idx_v for index in joints]]
        assert_same(ks.jacobian(arm, q).to_array(convention=f"pinocchio.{reference}"), expected)
        assert f"pinocchio.{reference}" in ks.which_convention(expected, arm, q).matches


@pytest.mark.parametrize("name", ARMS)
def test_modern_robotics(name):
    """JacobianSpace and JacobianBody, of screws taken from Pinocchio's model at zero."""
    modern = pytest.importorskip("modern_robotics", reason="the judges are part of the dev extra")
    arm, (judge, joints, tip) = arm_of(name), judge_of(name)
    data = judge.createData()
    zero = pinocchio_configuration(name, np.zeros(arm.n))
    at_zero = pin.computeFrameJacobian(judge, data, zero, tip, pin.WORLD)
    pin.updateFramePlacements(judge, data)
    screws = np.roll(at_zero[:, [judge.joints[index].idx_v for index in joints]], 3, axis=0)  # there (ω, v)
    body_screws = modern.Adjoint(modern.TransInv(data.oMf[tip].homogeneous)) @ screws
    for q in postures(name):
        J = ks.jacobian(arm, q)
        space, body = modern.JacobianSpace(screws, q), modern.JacobianBody(body_screws, q)
        assert_same(J.to_array(convention="modern_robotics.space"), space)
        assert_same(J.to_array(convention="modern_robotics.body"), body)
        assert "modern_robotics.space" in ks.which_convention(space, arm, q).matches
        assert "modern_robotics.body" in ks.which_convention(body, arm, q).matches


def mujoco_model(mujoco, name):
    """MuJoCo's own reading of the file, without meshes, and with its fixed links kept."""
    root = ElementTree.parse(path_of(name)).getroot()
    for link in root.iter("link"):
        for element in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(element)
    extension = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(
        extension, "compiler", fusestatic="false", balanceinertia="true", boundmass="1e-3", boundinertia="1e-6"
    )
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


@pytest.mark.parametrize("name", ARMS)
def test_mujoco(name):
    """mj_jac at the tip: jacp and jacr stacked; and they are recognised."""
    mujoco = pytest.importorskip("mujoco", reason="the judges are part of the dev extra")
    arm, model = arm_of(name), mujoco_model(mujoco, name)
    data = mujoco.MjData(model)
    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint) for joint in arm.joint_names]
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, ARMS[name][1])
    assert min(*joints, body) >= 0
    for q in postures(name):
        data.qpos[model.jnt_qposadr[joints]] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        jacp, jacr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacp, jacr, data.xpos[body], body)
        expected = np.stack([jacp, jacr])[:, :, model.jnt_dofadr[joints]]
        found = ks.jacobian(arm, q).to_array(convention="mujoco")
        assert_same(found, expected)
        assert ks.which_convention(expected, arm, q).matches == ("mujoco",)
