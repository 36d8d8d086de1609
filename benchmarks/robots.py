"""The robots that are measured, as our model and as Pinocchio's: UR10, Panda (fingers held) and Talos (32 joints)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import kinestatics as ks

FILES = {
    "ur10": ("ur10_robot.urdf", "tool0", ()),
    "panda": ("panda.urdf", "panda_hand_tcp", ("panda_finger_joint1", "panda_finger_joint2")),
    "talos": ("talos_reduced.urdf", "gripper_right_base_link", ()),
}


@dataclass(frozen=True)
class Subject:
    """A robot to measure: our model and Evaluator, Pinocchio's model and data, and the tool's frame there.

    `order` lists, for each of Pinocchio's joints, the column it has with us.
    """

    name: str
    path: Path
    tip: str
    arm: ks.RobotModel
    evaluator: ks.Evaluator
    model: Any
    data: Any
    tool: int
    order: tuple[int, ...]

    def configurations(self, count: int, seed: int = 0) -> Any:
        """(count, n), within ±3: the size of angles that occur."""
        return np.random.default_rng(seed).uniform(-3, 3, (count, self.arm.n))


@cache
def subject(name: str) -> Subject:
    """The robot of that name, from the package example-robot-data."""
    file, tip, held = FILES[name]
    listed = metadata.files("example-robot-data") or []
    path = Path(next(f for f in listed if f.name == file).locate()).resolve()
    model = pin.buildModelFromUrdf(str(path))
    model = pin.buildReducedModel(model, [model.getJointId(joint) for joint in held], pin.neutral(model))
    whole = len(model.joints) > 10
    arm = ks.load(path, tip=tip, joints=dict.fromkeys(held, 0.0), whole_tree=whole)
    order = tuple(arm.joint_names.index(model.names[i]) for i in range(1, model.njoints))
    return Subject(name, path, tip, arm, ks.Evaluator(arm), model, model.createData(), model.getFrameId(tip), order)
