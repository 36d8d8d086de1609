"""Real robot files from PyPI packages, judged by an independent engine: Pinocchio for URDF.

Every link of every URDF of example-robot-data: pose, Jacobian and, for the whole tree, gravity torques, mimic joints folded.
"""

import importlib.metadata
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks

pin = pytest.importorskip("pinocchio", reason="the judge is part of the dev extra")

FILES = sorted(
    Path(file.locate()).resolve()
    for package in ("example-robot-data", "airo-models")
    for file in importlib.metadata.files(package) or []
    if str(file).endswith(".urdf")
)
REFUSED = {  # what is wrong with the file itself
    "alex_psyonic_hands.urdf": "KS170",  # a mimic joint names a joint that is not there
    "ur3.urdf": "KS121",  # xacro that was never expanded: no links
}
PINOCCHIO_REFUSES_MIMIC = {"romeo.urdf", "romeo_small.urdf", "talos_full_v2.urdf", "talos_full_v2_box.urdf"}
TOLERANCE = 1e-12


def test_there_are_enough_files():
    """At least 60 real robots are compared."""
    assert len(FILES) >= 62


def pinocchio_model(path):
    try:
        return pin.buildModelFromUrdf(str(path), mimic=True)
    except (ValueError, RuntimeError) as failure:
        if "mimic" not in str(failure):
            pytest.skip(f"Pinocchio cannot read this file: {failure}")
    return None


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_link_agrees_with_pinocchio(path):
    """Pose and Jacobian of every link, and gravity torques, to 1e-12 of the largest entry."""
    if path.name in REFUSED:
        with pytest.raises(ks.RobotFileError, match=REFUSED[path.name]):
            ks.load(path, whole_tree=True)
        return
    arm = ks.load(path, whole_tree=True)
    judge = pinocchio_model(path)
    if judge is None:
        assert any(name in path.name for name in PINOCCHIO_REFUSES_MIMIC) or "v2" in path.name
        return
    if arm.n == 0:
        return
    data = judge.createData()
    for q in np.random.default_rng(7).uniform(-1.5, 1.5, (3, arm.n)):
        compare(arm, judge, data, q)


def compare(arm, judge, data, q):
    configuration, columns = np.zeros(judge.nq), []
    for name, value in zip(arm.joint_names, q, strict=True):
        joint = judge.joints[judge.getJointId(name)]
        place = slice(joint.idx_q, joint.idx_q + joint.nq)
        configuration[place] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
        columns.append(joint.idx_v)
    pin.forwardKinematics(judge, data, configuration)
    pin.updateFramePlacements(judge, data)
    pin.computeJointJacobians(judge, data, configuration)
    for index, link in enumerate(arm.link_names):
        frame = judge.getFrameId(link, pin.FrameType.BODY)
        if frame >= len(judge.frames):
            continue
        expected = pin.getFrameJacobian(judge, data, frame, pin.LOCAL_WORLD_ALIGNED).reshape(6, -1)[:, columns]
        scale = max(1.0, np.abs(expected).max())
        assert np.abs(ks.jacobian(arm, q, at=arm.link_name(index)).array - expected).max() <= TOLERANCE * scale
        assert (
            np.abs(ks.pose(arm, q, at=arm.link_name(index)).array - data.oMf[frame].homogeneous).max() <= TOLERANCE * scale
        )
    if arm.has_masses:
        expected = pin.computeGeneralizedGravity(judge, data, configuration)[columns]
        scale = max(1.0, np.abs(expected).max())
        assert np.abs(ks.gravity_torques(arm, q) - expected).max() <= TOLERANCE * scale
