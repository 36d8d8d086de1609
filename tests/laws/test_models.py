"""Re-rooting, holding joints, mimic, flipping axes, moving the base: what must not change, does not."""

import numpy as np
from hypothesis import given

import kinestatics as ks
from kinestatics.robots.assemble import assemble
from kinestatics.robots.description import LinkDescription, RobotDescription
from kinestatics.spatial import quaternion_to_rotation
from strategies import Features, assert_close, features

ROUNDING = 1e-12


def by_name(model, q, other):
    """The configuration q of `model` in the order of `other`."""
    values = dict(zip(model.joint_names, q, strict=True))
    return np.array([values[name] for name in other.joint_names])


@given(features(tree=False, other_base=False))
def test_seen_from_the_tip_everything_is_inverted(f):
    """T_tip_base = T_base_tip⁻¹, and the base's twist seen from the tip is minus the tip's, in one frame."""
    there = f.model()
    back = assemble(f.description(), f"l{f.joints}", "l0")
    q = f.configurations()
    r = by_name(there, q, back)
    assert_close(ks.pose(there, q).array @ ks.pose(back, r).array, np.eye(4), ROUNDING)
    tip_from_base = ks.jacobian(there, q, frame=ks.Frame.body()).array  # tip axes at the tip
    base_from_tip = ks.jacobian(back, r, frame=ks.Frame.spatial()).array  # tip axes at the tip
    order = [back.joint_names.index(name) for name in there.joint_names]
    assert_close(base_from_tip[:, order], -tip_from_base, ROUNDING)


@given(features(max_joints=6, mimic=False))
def test_a_held_joint_is_a_missing_column(f):
    """Holding a joint leaves the other columns and the pose as they were, and its branch keeps its weight."""
    model = f.model()
    if model.n == 0:
        return
    q = f.configurations()
    name = model.joint_names[f.seed % model.n]
    held = f.model(joints={name: float(q[model.joint_names.index(name)])})
    rest = [i for i, other in enumerate(model.joint_names) if other != name]
    r = by_name(model, q, held)
    assert held.joint_names == tuple(model.joint_names[i] for i in rest)
    assert_close(ks.pose(held, r).array, ks.pose(model, q).array, ROUNDING)
    assert_close(ks.jacobian(held, r).array, ks.jacobian(model, q).array[:, rest], ROUNDING)
    if model.has_masses:
        assert_close(ks.gravity_torques(held, r), ks.gravity_torques(model, q)[rest], ROUNDING)


@given(features(mimic=True))
def test_mimic_columns_are_the_sum_over_followers(f):
    """J_folded = J_free S, with S the multipliers down every chain of followers."""
    folded = f.model()
    links = f.description()
    free_joints = tuple(j.__class__(**{**j.__dict__, "mimic": None}) for j in links.joints)
    free = assemble(RobotDescription("free", links.links, free_joints), folded.base, f"l{f.joints}", whole_tree=True)
    q = f.configurations()
    values = {}
    for name, column, multiplier, offset in zip(
        folded.moving_names, folded.columns, folded.multipliers, folded.offsets, strict=True
    ):
        values[name] = multiplier * q[column] + offset
    held = {j.name: folded.frozen.get(j.name) for j in links.joints if j.kind != "fixed"}
    for joint in links.joints:  # followers of joints that are held, and joints off the path
        if joint.kind != "fixed" and joint.name not in values:
            mimic = joint.mimic
            values[joint.name] = (
                mimic.multiplier * values[mimic.joint] + mimic.offset if mimic is not None else held[joint.name] or 0.0
            )
    r = np.array([values[name] for name in free.joint_names])
    S = np.zeros((free.n, folded.n))
    for name, column, multiplier in zip(folded.moving_names, folded.columns, folded.multipliers, strict=True):
        S[free.joint_names.index(name), column] = multiplier
    assert_close(ks.pose(folded, q).array, ks.pose(free, r).array, ROUNDING)
    assert_close(ks.jacobian(folded, q).array, ks.jacobian(free, r).array @ S, ROUNDING)


@given(features(tree=False, mimic=False, other_base=False))
def test_flipping_an_axis_flips_its_column(f):
    """A joint that turns the other way, at the opposite angle, gives the same pose and the opposite column."""
    model = f.model()
    if model.n == 0:
        return
    name = model.joint_names[f.seed % model.n]
    joints = tuple(j.__class__(**{**j.__dict__, "screw": -j.screw}) if j.name == name else j for j in f.description().joints)
    flipped = assemble(RobotDescription("flipped", f.description().links, joints), "l0", f"l{f.joints}")
    signs = np.array([-1.0 if other == name else 1.0 for other in model.joint_names])
    q = f.configurations()
    assert_close(ks.pose(flipped, signs * q).array, ks.pose(model, q).array, ROUNDING)
    assert_close(ks.jacobian(flipped, signs * q).array, ks.jacobian(model, q).array * signs, ROUNDING)


@given(features(tree=False, other_base=False))
def test_moving_the_base_moves_nothing_inside(f):
    """The body Jacobian and the singular values do not depend on where the arm is mounted."""
    rng = np.random.default_rng(f.seed)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = quaternion_to_rotation(*rng.normal(size=4)), rng.normal(size=3)
    description = f.description()
    mount = [
        j.__class__(**{**j.__dict__, "placement": T @ j.placement}) if j.parent == "l0" else j for j in description.joints
    ]
    model = f.model()
    moved = assemble(RobotDescription("moved", description.links, tuple(mount)), "l0", f"l{f.joints}")
    q = f.configurations(3)
    if f.joints == 0:
        return
    body = ks.Frame.body()
    assert_close(ks.jacobian(moved, q, frame=body).array, ks.jacobian(model, q, frame=body).array, ROUNDING)
    assert_close(ks.pose(moved, q).array, T @ ks.pose(model, q).array, ROUNDING)


def test_a_robot_without_joints():
    """No joints: a pose, a 6 x 0 Jacobian, and no crash."""
    model = assemble(RobotDescription("stone", (LinkDescription("l0", 1.0),), ()))
    assert model.n == 0
    assert ks.pose(model, np.zeros(0)).array.tolist() == np.eye(4).tolist()
    assert ks.jacobian(model, np.zeros(0)).array.shape == (6, 0)
    assert ks.jacobian(model, np.zeros((5, 0))).array.shape == (5, 6, 0)
    assert ks.hessian(model, np.zeros(0)).array.shape == (6, 0, 0)
    assert ks.gravity_torques(model, np.zeros(0)).shape == (0,)
    assert ks.analyze(model).rank == 0


def test_nearly_aligned_axes():
    """Two axes tilted by less than rounding: the kernels once lost a millionth of a radian here."""
    rng = np.random.default_rng(0)
    for k in range(60):
        f = Features(seed=int(rng.integers(10**6)), joints=4, right_angles=True, kinds=("revolute",))
        description = f.description()
        tilt = quaternion_to_rotation(1.0, *(10.0 ** -(4 + k / 5) * rng.normal(size=3)))
        joints = []
        for joint in description.joints:
            T = joint.placement.copy()
            T[:3, :3] = tilt @ T[:3, :3]
            joints.append(joint.__class__(**{**joint.__dict__, "placement": T}))
        model = assemble(RobotDescription("tilted", description.links, tuple(joints)), "l0", "l4")
        q = rng.normal(size=model.n)
        R = ks.jacobian(model, q, frame=ks.Frame("base", "tip")).change_frame(ks.Frame.spatial()).array
        assert_close(ks.jacobian(model, q, frame=ks.Frame.spatial()).array, R, 1e-14)
        from kinestatics import definition
        from kinestatics.definition import Target
        from kinestatics.namespaces import as_array

        tip = model.link("tip")
        array, xp = as_array(q)
        exact = definition.jacobian(model, array, Target(tip, model.link("base"), tip), xp)
        assert_close(ks.jacobian(model, q).array, exact, 1e-14)
