"""Statics of real robot files, judged by two independent engines: Pinocchio and MuJoCo.

Every file as it is: tools on fixed joints, side branches, mimic joints. The base is tilted, a payload is held, loads act
on links in frames of their own; compared are gravity torques, mass matrices, and the six components in every joint.
"""

from xml.dom import expatbuilder

import mujoco
import numpy as np
import pytest

import kinestatics as ks

pin = pytest.importorskip("pinocchio", reason="the judge is part of the dev extra")

from peers.test_mjcf_models import GYMNASIUM, MENAGERIE  # noqa: E402
from peers.test_real_robots import FILES, REFUSED, followers  # noqa: E402

GRAVITY = 1e-9  # N m, the largest difference in any joint of any robot
WRENCH = 1e-10  # of the largest component
TILTED = (0.3, -0.5, 0.2)
MASS, CENTER, INERTIA = 2.5, (0.03, -0.02, 0.11), np.diag([0.02, 0.03, 0.04]) + 0.002
REFUSED_BY_MUJOCO = {  # for inertias that no rigid body has
    "allegro_left_hand.urdf",
    "allegro_right_hand.urdf",
    "anymal-kinova.urdf",
    "anymal.urdf",
    "b1-z1.urdf",
    "b1.urdf",
    "go1.urdf",
    "hyq_no_sensors.urdf",
    "pr2.urdf",
    "romeo_laas_small.urdf",
    "romeo_small.urdf",
    "schunk_egk40.urdf",
    "schunk_egk40_magneto.urdf",
    "tiago.urdf",
    "tiago_dual.urdf",
    "tiago_no_hand.urdf",
}

mujoco.set_mju_user_warning(lambda _: None)  # the judge would write its warnings to a file in the working folder


ARMS = {path: ks.load(path, whole_tree=True) for path in FILES if path.name not in REFUSED}
MOVING = [path for path, arm in ARMS.items() if arm.n]


def test_there_are_enough_files():
    """Both engines judge more than 30 robots, among them trees, followers and tools that hang on fixed joints."""
    assert len(MOVING) >= 60
    assert sum(path.name not in REFUSED_BY_MUJOCO for path in MOVING) >= 45
    arms = [ARMS[path] for path in MOVING]
    assert sum(len(arm.moving_names) > arm.n for arm in arms) >= 8
    assert sum(len(set(arm.parents)) < len(arm.parents) for arm in arms) >= 30
    assert sum(len(set(arm.link_joints)) < len(arm.link_joints) for arm in arms) >= 50


def question(path):
    """A robot with a payload on its last link, a tilted gravity, a configuration."""
    arm = ARMS[path]
    link = arm.link_names[max(range(len(arm.link_names)), key=lambda i: arm.link_joints[i])]
    holder = arm.link_name(arm.link_names.index(link))
    loaded = arm.with_payload(MASS, CENTER, INERTIA, at=holder)
    q = np.random.default_rng(11).uniform(-1.5, 1.5, arm.n)
    return loaded, link, ks.gravity_in_base(TILTED), q


def in_pinocchio(path, arm, link, q):
    """The judge's model with the same payload, its configuration, and its joints in terms of ours, (nv, n)."""
    judge = pin.buildModelFromUrdf(str(path))  # followers move freely there; they are tied here
    frame = judge.frames[judge.getFrameId(link, pin.FrameType.BODY)]
    payload = pin.Inertia(MASS, np.array(CENTER), INERTIA)
    judge.inertias[frame.parentJoint] = judge.inertias[frame.parentJoint] + frame.placement.act(payload)
    values, tied = dict(zip(arm.joint_names, q, strict=True)), followers(path)
    configuration, fold = np.zeros(judge.nq), np.zeros((judge.nv, arm.n))
    for name in arm.moving_names:
        leader, multiplier, offset = tied.get(name, (name, 1.0, 0.0))
        joint, value = judge.joints[judge.getJointId(name)], multiplier * values[leader] + offset
        place = slice(joint.idx_q, joint.idx_q + joint.nq)
        configuration[place] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
        fold[joint.idx_v, arm.joint_names.index(leader)] = multiplier
    return judge, configuration, fold


@pytest.mark.parametrize("path", MOVING, ids=lambda path: path.name)
def test_pinocchio_agrees(path):
    """Gravity to 1e-9 N m, the mass matrix, and data.f of a resting arm under loads: the wrench in every joint."""
    arm, link, gravity, q = question(path)
    judge, configuration, fold = in_pinocchio(path, arm, link, q)
    judge.gravity.linear = gravity
    data = judge.createData()
    expected = pin.computeGeneralizedGravity(judge, data, configuration) @ fold
    assert np.abs(ks.gravity_torques(arm, q, gravity=gravity) - expected).max() <= GRAVITY
    upper = np.triu(pin.crba(judge, data, configuration))
    mass = fold.T @ (upper + upper.T - np.diag(np.diag(upper))) @ fold
    assert np.abs(ks.mass_matrix(arm, q) - mass).max() <= WRENCH * max(1.0, np.abs(mass).max())

    loads, outside = some_loads(arm, judge, data, configuration)
    still = np.zeros(judge.nv)
    torques = pin.rnea(judge, data, configuration, still, still, outside) @ fold
    reactions = ks.joint_reactions(arm, q, loads, gravity=gravity)
    scale = max(1.0, np.abs(reactions.wrenches).max())
    for name in arm.moving_names:
        expected = data.f[judge.getJointId(name)].vector
        assert np.abs(reactions.wrench(name) - expected).max() <= WRENCH * scale
    assert np.abs(reactions.torques - torques).max() <= WRENCH * scale
    assert np.abs(ks.holding_torques(arm, q, loads, gravity=gravity) - torques).max() <= WRENCH * scale
    assert reactions.relative_residual <= 1e-13


def some_loads(arm, judge, data, configuration):
    """Random loads and pushes on three links, half of them in frames of other links; and the same as the judge's fext."""
    rng = np.random.default_rng(12)
    pin.forwardKinematics(judge, data, configuration)
    pin.updateFramePlacements(judge, data)
    known = [name for name in arm.link_names if judge.existFrame(name, pin.FrameType.BODY)]
    loads, outside = [], [pin.Force.Zero() for _ in range(judge.njoints)]
    for k, name in enumerate(rng.choice(known, 3)):
        body = judge.frames[judge.getFrameId(name, pin.FrameType.BODY)]
        other = str(rng.choice(known)) if k % 2 else name
        place = data.oMf[judge.getFrameId(other, pin.FrameType.BODY)]
        force, torque, offset = rng.normal(size=3) * 30, rng.normal(size=3) * 5, rng.normal(size=3) * 0.2
        word = f"link:{other}" if other in ("base", "tip") else other
        axes = word if k == 1 else "base"
        R = place.rotation if k == 1 else np.eye(3)
        frame = ks.Frame(axes, word, tuple(offset.tolist())) if k else None  # the first: the default frame
        at = place.translation + place.rotation @ offset if k else place.translation
        push = k == 2
        make = ks.Wrench.on_environment if push else ks.Wrench.on_robot
        loads.append((f"link:{name}" if name in ("base", "tip") else str(name), make(force, torque, frame)))
        world = pin.SE3(R, at).act(pin.Force(force, torque))
        outside[body.parentJoint] += data.oMi[body.parentJoint].actInv(-world if push else world)
    return loads, outside


def urdf_for_mujoco(path):
    """The file without shapes, which statics does not need, and with MuJoCo told to keep links on fixed joints."""
    document = expatbuilder.parse(str(path), namespaces=False)
    for tag in ("visual", "collision", "transmission", "gazebo", "sensor", "material", "mujoco"):
        for element in list(document.getElementsByTagName(tag)):
            element.parentNode.removeChild(element)
    settings, compiler = document.createElement("mujoco"), document.createElement("compiler")
    for word, value in {"fusestatic": "false", "boundmass": "1e-14", "boundinertia": "1e-14"}.items():
        compiler.setAttribute(word, value)
    settings.appendChild(compiler)
    document.documentElement.insertBefore(settings, document.documentElement.firstChild)
    return document.documentElement.toxml()


def compiled_with_payload(spec, link):
    holder = spec.body(link)
    moments = [*np.diag(INERTIA), INERTIA[0, 1], INERTIA[0, 2], INERTIA[1, 2]]
    holder.add_body(name="test payload", mass=MASS, ipos=CENTER, fullinertia=moments, explicitinertial=True)
    return spec.compile()


def compare_with_mujoco(judge, gravity, configuration, fold):
    judge.opt.gravity = gravity
    data = mujoco.MjData(judge)
    data.qpos[:] = configuration
    mujoco.mj_forward(judge, data)
    return data.qfrc_bias @ fold, fold.T @ full_mass_matrix(judge, data) @ fold - fold.T @ np.diag(judge.dof_armature) @ fold


def full_mass_matrix(judge, data):
    mass = np.zeros((judge.nv, judge.nv))
    mujoco.mj_fullM(judge, data, mass)
    return mass


@pytest.mark.parametrize("path", [path for path in MOVING if path.name not in REFUSED_BY_MUJOCO], ids=lambda path: path.name)
def test_mujoco_agrees(path):
    """The same files, the same payload, the same tilt, through MuJoCo's own reader of URDF."""
    arm, link, gravity, q = question(path)
    judge = compiled_with_payload(mujoco.MjSpec.from_string(urdf_for_mujoco(path)), link)
    values, tied = dict(zip(arm.joint_names, q, strict=True)), followers(path)
    configuration, fold = np.zeros(judge.nq), np.zeros((judge.nv, arm.n))
    for name in arm.moving_names:
        leader, multiplier, offset = tied.get(name, (name, 1.0, 0.0))
        joint = judge.joint(name)
        configuration[joint.qposadr[0]] = multiplier * values[leader] + offset
        fold[joint.dofadr[0], arm.joint_names.index(leader)] = multiplier
    torques, mass = compare_with_mujoco(judge, gravity, configuration, fold)
    assert np.abs(ks.gravity_torques(arm, q, gravity=gravity) - torques).max() <= GRAVITY
    assert np.abs(ks.mass_matrix(arm, q) - mass).max() <= 1e-9 * max(1.0, np.abs(mass).max())


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass' is deprecated:UserWarning")
@pytest.mark.parametrize("path", [*GYMNASIUM, *MENAGERIE], ids=lambda path: path.name)
def test_mujoco_models_agree(path):
    """MuJoCo's own models, whose joints have anchors and references: gravity with a payload on a tilted base, and mass."""
    spec = mujoco.MjSpec.from_file(str(path))
    plain = spec.compile()
    if not plain.njnt or plain.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        return
    link = plain.body(plain.nbody - 1).name or f"body{plain.nbody - 1}"
    arm = ks.load(path, whole_tree=True)
    gravity, q = ks.gravity_in_base(TILTED), np.random.default_rng(13).uniform(-1.0, 1.0, arm.n)
    fold = np.zeros((plain.nv, arm.n))
    fold[np.arange(len(arm.columns)), arm.columns] = arm.multipliers
    configuration = q[list(arm.columns)] * arm.multipliers + arm.offsets
    _, mass = compare_with_mujoco(plain, gravity, configuration, fold)
    assert np.abs(ks.mass_matrix(arm, q) - mass).max() <= 1e-9 * max(1.0, np.abs(mass).max())
    if not plain.body(plain.nbody - 1).name or spec.compiler.settotalmass > 0:  # the latter would scale the payload away
        return
    loaded = arm.with_payload(MASS, CENTER, INERTIA, at=arm.link_name(arm.link_names.index(link)))
    torques, mass = compare_with_mujoco(compiled_with_payload(spec, link), gravity, configuration, fold)
    assert np.abs(ks.gravity_torques(loaded, q, gravity=gravity) - torques).max() <= GRAVITY
    assert np.abs(ks.mass_matrix(loaded, q) - mass).max() <= 1e-9 * max(1.0, np.abs(mass).max())
