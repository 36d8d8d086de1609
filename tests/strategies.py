"""Random mechanisms of every joint type: chains and trees, fixed joints between, mimic followers, any base, right angles.

Hypothesis draws the features and a seed; the numbers come from the seed, so that a failing example is one short line.
"""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from kinestatics import from_dh
from kinestatics.robots.assemble import assemble
from kinestatics.robots.description import JointDescription, LinkDescription, Mimic, RobotDescription
from kinestatics.spatial import quaternion_to_rotation

QUARTER_X = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
QUARTER_Z = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
KINDS = ("revolute", "continuous", "prismatic", "helical")


def random_rotation(rng, right_angles):
    if right_angles:
        return np.linalg.matrix_power(QUARTER_Z, int(rng.integers(4))) @ np.linalg.matrix_power(
            QUARTER_X, int(rng.integers(4))
        )
    return quaternion_to_rotation(*rng.normal(size=4))


def random_pose(rng, right_angles=False):
    """A pose whose rotation is general, a right angle, or a right angle missed by as little as rounding."""
    T = np.eye(4)
    T[:3, :3] = random_rotation(rng, right_angles)
    if right_angles and rng.random() < 0.3:
        tilt = 10.0 ** rng.uniform(-17, -5)
        T[:3, :3] = T[:3, :3] @ quaternion_to_rotation(1.0, *(tilt * rng.normal(size=3)))
    T[:3, 3] = np.where(rng.random(3) < (0.5 if right_angles else 0.0), 0.0, rng.normal(size=3))
    return T


def random_screw(rng, kind, right_angles):
    axis = np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0]) if right_angles else rng.normal(size=3)
    axis = axis / np.linalg.norm(axis)
    point = rng.normal(size=3) if rng.random() < 0.4 else np.zeros(3)
    if kind == "prismatic":
        return np.r_[axis, np.zeros(3)]
    pitch = rng.normal() if kind == "helical" else 0.0
    return np.r_[np.cross(point, axis) + pitch * axis, axis]


@dataclass(frozen=True)
class Features:
    """What to build; `seed` fixes the numbers."""

    seed: int = 0
    joints: int = 6
    tree: bool = False
    mimic: bool = False
    right_angles: bool = False
    other_base: bool = False
    kinds: tuple = KINDS

    def description(self):
        rng = np.random.default_rng(self.seed)
        links, joints = [LinkDescription("l0", 1.0, rng.normal(size=3))], []
        for i in range(self.joints):
            fixed = rng.random() < 0.1
            kind = "fixed" if fixed else str(rng.choice(self.kinds))
            parent = links[rng.integers(len(links))].name if self.tree else links[-1].name
            screw = np.zeros(6) if fixed else random_screw(rng, kind, self.right_angles)
            leaders = [j for j in joints if j.kind != "fixed"]
            mimic = None
            if self.mimic and leaders and not fixed and rng.random() < 0.4:
                multiplier = rng.choice([0.0, -1.0, 1.0, rng.normal()])
                mimic = Mimic(leaders[rng.integers(len(leaders))].name, float(multiplier), float(rng.normal()))
            pose = random_pose(rng, self.right_angles)
            joints.append(JointDescription(f"j{i}", kind, parent, f"l{i + 1}", pose, screw, mimic=mimic))
            links.append(LinkDescription(f"l{i + 1}", float(rng.uniform(0, 3)) * (rng.random() < 0.8), rng.normal(size=3)))
        return RobotDescription("random", tuple(links), tuple(joints))

    def model(self, **options):
        base = f"l{self.seed % (self.joints + 1)}" if self.other_base else "l0"
        return assemble(self.description(), base, f"l{self.joints}", whole_tree=self.tree, **options)

    def configurations(self, *shape):
        return np.random.default_rng(self.seed + 1).normal(size=(*shape, self.model().n)) * 1.7

    def without(self, **changes):
        return replace(self, **changes)


@st.composite
def features(draw, max_joints=7, **fixed):
    """Hypothesis strategy of Features; keyword arguments pin some of them."""
    drawn = {
        "seed": draw(st.integers(0, 2**31 - 1)),
        "joints": draw(st.integers(0, max_joints)),
        "tree": draw(st.booleans()),
        "mimic": draw(st.booleans()),
        "right_angles": draw(st.booleans()),
        "other_base": draw(st.booleans()),
    }
    return Features(**(drawn | fixed))


def scale_of(array):
    """The size against which rounding is judged: the largest entry, at least 1."""
    return max(1.0, float(np.abs(array).max(initial=0.0)))


def assert_close(found, expected, tolerance):
    """Equal to `tolerance` times the largest entry; shapes too."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max(initial=0.0) <= tolerance * scale_of(expected)


RIGHT_ANGLES = (0.0, np.pi / 2, -np.pi / 2, np.pi)


def tables(n, kinds="RRRP", twists=RIGHT_ANGLES):
    """Arms of a standard table with n rows, lengths of two decimals of which many are zero; twists at right angles."""
    length = st.sampled_from([0.0, 0.0, 0.1, -0.25, 0.3, 0.42])
    row = st.tuples(length, st.sampled_from(twists), length, st.sampled_from((0.0, np.pi / 2)))
    return st.builds(
        lambda rows, types: from_dh(rows, convention="standard", types="".join(types)),
        st.lists(row, min_size=n, max_size=n),
        st.lists(st.sampled_from(kinds), min_size=n, max_size=n),
    )
