"""pycapacity, another library of polytopes, as a judge: the same corners, on its own examples and on real arms.

Where the two differ the reason is shown. Its forces are made from torques that it has rounded to 7 decimals, and no more
is asked of them; its velocities agree to the last digits. At a singularity it returns forces that break their limits.
"""

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.dexterity.shapes import image_of_box, let_through

capacity = pytest.importorskip("pycapacity.robot", reason="the judge is part of the dev extra")
examples = pytest.importorskip("pycapacity.examples")

TOLERANCE = 1e-9
ROUNDED = 0.5e-7  # its torques are, to 7 decimals


def distance(ours, theirs):
    """Hausdorff distance of two sets of points (v, k)."""
    gaps = np.linalg.norm(ours[:, None] - theirs, axis=-1)
    return max(gaps.min(0).max(), gaps.min(1).max())


def same_velocities(ours, theirs):
    return distance(ours, theirs) <= TOLERANCE * np.abs(ours).max()


def same_forces(ours, theirs, J):
    """Equal but for what rounded torques do to a force: at most |pinv(Jᵀ)| times their error."""
    rounding = ROUNDED * np.sqrt(J.shape[1]) * np.linalg.norm(np.linalg.pinv(J), 2)
    return distance(ours, theirs) <= TOLERANCE * np.abs(ours).max() + rounding


def points(polytope):
    return np.asarray(polytope.vertices).T


def bare(J):
    k, n = J.shape
    return {"kind": "", "unit": "", "rows": tuple(map(str, range(k))), "joints": tuple(map(str, range(n)))}


def velocities(J, limits):
    return image_of_box(J, -limits, limits, np.ones(len(J)), **bare(J))


def forces(J, lower, upper):
    return let_through(J.T, lower, upper, np.ones(len(J)), **bare(J))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("rows", "joints"), [(3, 6), (3, 7), (2, 4), (2, 2), (3, 10)])
def test_its_randomised_robot(seed, rows, joints):
    """Its example "randomised robot": uniform random Jacobians, unit limits."""
    J, one = np.random.default_rng(seed).random((rows, joints)), np.ones(joints)
    assert same_velocities(velocities(J, one).vertices, points(capacity.velocity_polytope(J, one, -one)))
    assert same_forces(forces(J, -one, one).vertices, points(capacity.force_polytope(J, one, -one)), J)


@pytest.mark.parametrize("seed", range(5))
def test_its_four_link_robot(seed):
    """Its example "four link robot", planar, with a bias torque as well."""
    rng = np.random.default_rng(seed)
    J, one = examples.FourLinkRobot().jacobian(rng.random(4) * np.pi / 3 * 2 - 1), np.ones(4)
    bias = rng.uniform(-0.3, 0.3, 4)
    assert same_velocities(velocities(J, one).vertices, points(capacity.velocity_polytope(J, one, -one)))
    theirs = points(capacity.force_polytope(J, one, -one, bias))
    assert same_forces(forces(J, -one - bias, one - bias).vertices, theirs, J)


def test_the_jacobian_of_its_four_link_robot_is_none():
    """Its entry of the third joint has 0.7 where its own forward kinematics give 0.3: not used as a robot here."""
    robot, q, step = examples.FourLinkRobot(), np.array([0.1, 0.3, -0.4, 0.5]), 1e-6
    move = [(robot.forward_kinematics(q + e) - robot.forward_kinematics(q - e)) / (2 * step) for e in step * np.eye(4)]
    wrong = np.abs(robot.jacobian(q) - np.array(move).T) > 1e-6
    assert np.argwhere(wrong).tolist() == [[0, 2]]


@pytest.mark.parametrize("name", ["ur5e", "panda", "iiwa_14"])
@pytest.mark.parametrize("rows", [slice(0, 3), slice(3, 6), slice(0, 2)], ids=["position", "orientation", "plane"])
def test_real_arms(name, rows):
    """The limits of the makers, forces with the weight of the arm where it is known."""
    arm = ks.load(name)
    task = ("vx", "vy", "vz", "wx", "wy", "wz")[rows]
    for q in arm.random_configurations(4, 5):
        J, fast, strong = np.asarray(ks.jacobian(arm, q))[rows], arm.velocity_limits, arm.effort_limits
        ours = ks.velocity_polytope(arm, q, task=task)
        assert same_velocities(ours.vertices, points(capacity.velocity_polytope(J, fast, -fast)))
        gravity = (0, 0, -9.80665) if arm.has_masses else None
        held = np.zeros(arm.n) if gravity is None else ks.gravity_torques(arm, q, gravity=gravity)
        pushes = ks.force_polytope(arm, q, task=task, gravity=gravity)
        assert same_forces(pushes.vertices, points(capacity.force_polytope(J, strong, -strong, held)), J)


def test_at_a_singularity_it_breaks_the_limits_it_was_given():
    """A straight leg: |0.86 fx| <= 250 N m, and fy is free. It returns four points, two of which need 300 N m."""
    leg = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
    q, limits = [np.pi / 2, 0], np.array([250.0, 250.0])
    J = np.asarray(ks.jacobian(leg, q))[:2]
    theirs = points(capacity.force_polytope(J, limits, -limits))
    assert len(theirs) == 4
    assert np.abs(theirs @ J).max() > 1.19 * limits[0]
    ours = ks.force_polytope(leg, q, gravity=None, effort_limits=limits)
    assert not ours.is_bounded
    assert np.abs(ours.corners @ J).max() <= limits[0] * (1 + 1e-12)
    with pytest.raises(AttributeError):  # and of velocities, which are a segment there, it makes nothing
        capacity.velocity_polytope(J, np.ones(2), -np.ones(2))
    assert ks.velocity_polytope(leg, q, velocity_limits=(1, 1)).is_flat
