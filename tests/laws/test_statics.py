"""Laws of the arm at rest: three routes to the same torques, energy, free bodies, payloads, capacities, elastic joints."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import kinestatics as ks
from kinestatics.spatial import ANGULAR, LINEAR, rpy_to_rotation
from strategies import Features, assert_close, features, scale_of

torch = pytest.importorskip("torch", reason="a judge of the dev extra")

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*torch.jit.script. is deprecated:DeprecationWarning"
)  # raised inside PyTorch

FRAMES = (None, ks.Frame.spatial(), ks.Frame.body(), ks.Frame("l0", "l1", (0.3, -0.1, 0.2)))
ROUNDING = 1e-12
REAL = ("ur3e", "ur5e", "ur10e", "puma_560", "planar_2r", "planar_3r")


def gravity_of(seed):
    return np.random.default_rng(seed).normal(size=3) * 9.81


def loads_on(model, seed, shape=()):
    """Loads and pushes on links drawn at random, in frames of every kind."""
    rng = np.random.default_rng(seed)
    loads = []
    for k in range(int(rng.integers(1, 4))):
        link = model.link_name(int(rng.integers(len(model.link_names))))
        frame = FRAMES[int(rng.integers(len(FRAMES)))]
        if frame is not None and {frame.axes, frame.origin} - {"base", "tip", *model.link_names}:
            frame = None
        make = ks.Wrench.on_environment if k % 2 else ks.Wrench.on_robot
        loads.append((link, make(rng.normal(size=(*shape, 3)) * 20, rng.normal(size=(*shape, 3)) * 5, frame)))
    return loads


def heavy(f):
    """The mechanism with a payload that has an inertia, on one of its links."""
    model, rng = f.model(), np.random.default_rng(f.seed + 5)
    half = rng.normal(size=(3, 3))
    moments = np.trace(half @ half.T) * np.eye(3) - half @ half.T  # of a cloud of points: every triangle holds
    at = model.link_name(int(rng.integers(len(model.link_names))))
    with pytest.warns(ks.KinestaticsWarning, match="KS325") if not model.has_masses else nothing():
        return model.with_payload(float(rng.uniform(0.5, 3.0)), rng.normal(size=3), moments, at=at)


class nothing:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None


@given(features(max_joints=6))
def test_gravity_is_the_gradient_of_the_potential(f):
    """τ = ∂U/∂q for every joint type, any gravity and a payload; the links add up; U = -M g · p of the whole."""
    model, g = heavy(f), gravity_of(f.seed)
    q = f.configurations(2)
    energy = ks.potential_energy(model, q, gravity=g)
    assert_close(ks.potential_energy(model, q, gravity=g, by_link=True).sum(-1), energy, ROUNDING)
    point, mass = ks.center_of_mass(model, q)
    assert_close(-mass * point @ g, energy, ROUNDING)
    torques, step = ks.gravity_torques(model, q, gravity=g), 1e-5
    for k in range(model.n):
        ahead, behind = q.copy(), q.copy()
        ahead[:, k] += step
        behind[:, k] -= step
        slope = (ks.potential_energy(model, ahead, gravity=g) - ks.potential_energy(model, behind, gravity=g)) / (2 * step)
        assert np.abs(torques[:, k] - slope).max() <= 1e-7 * max(1.0, np.abs(energy).max())


@given(features(max_joints=6))
def test_kinetic_energy(f):
    """½ q̇ᵀ M q̇ is the sum of ½ m v² and ½ ω I ω of the links, whose twists come from their own Jacobians."""
    model, q = heavy(f), f.configurations(2)
    rates = np.random.default_rng(f.seed).normal(size=q.shape)
    energy = np.zeros(2)
    for i, mass in enumerate(model.masses):
        name, center = model.link_name(i), tuple(model.centers_of_mass[i])
        twist = ks.jacobian(model, q, at=name, point=center, frame=ks.Frame(name, name, center)) @ rates
        turning = np.einsum("bi,ij,bj->b", twist.angular, model.inertias[i], twist.angular)
        energy += 0.5 * mass * (twist.linear**2).sum(-1) + 0.5 * turning
    M = ks.mass_matrix(model, q)
    assert_close(0.5 * np.einsum("bi,bij,bj->b", rates, M, rates), energy, ROUNDING)
    assert_close(M, M.swapaxes(-1, -2), 1e-14)


@given(features(max_joints=6), st.booleans())
def test_free_bodies_give_the_torques(f, batched):
    """Free-body balance from the tips to the base = Jᵀf and gravity by Jacobians of the centres of mass, every tree."""
    model, g = heavy(f), gravity_of(f.seed)
    q = f.configurations(2)
    loads = loads_on(model, f.seed, (2,) if batched else ())
    r = ks.joint_reactions(model, q, loads, gravity=g)
    expected = ks.holding_torques(model, q, loads, gravity=g)
    size = scale_of(r.wrenches)
    assert np.abs(r.torques - expected).max(initial=0.0) <= ROUNDING * max(size, scale_of(expected))
    assert r.wrenches.shape == (2, len(model.moving_names), 6)
    assert np.all(r.relative_residual <= 1e-13)
    assert np.all(r.residual <= 1e-11 * max(size, scale_of(r.base)))
    weightless = ks.joint_reactions(model, q, loads, gravity=None)
    assert_close(weightless.torques + ks.gravity_torques(model, q, gravity=g), r.torques, 1e-10)


@given(features(max_joints=5))
def test_the_ground_carries_everything(f):
    """The ground's force is the weight and all loads; its moment that of the weight at the common centre of mass."""
    model, g = heavy(f), gravity_of(f.seed)
    q = f.configurations()
    r = ks.joint_reactions(model, q, gravity=g)
    point, mass = ks.center_of_mass(model, q)
    assert_close(r.base[LINEAR], -mass * g, ROUNDING)
    assert_close(r.base[ANGULAR], -np.cross(point, mass * g), ROUNDING)
    force = np.array([1.0, -2.0, 3.0])
    pulled = ks.joint_reactions(model, q, {"tip": ks.Wrench.on_robot(force)}, gravity=g)
    assert_close(pulled.base[LINEAR], r.base[LINEAR] - force, ROUNDING)
    place = ks.pose(model, q).translation
    assert_close(pulled.base[ANGULAR], r.base[ANGULAR] - np.cross(place, force), ROUNDING)


@given(features(max_joints=5))
def test_what_a_bearing_bears(f):
    """Axial, radial, bending, torsion and drive put the wrench together again; base axes are the same vectors turned."""
    model, q = heavy(f), f.configurations()
    loads = loads_on(model, f.seed)
    r = ks.joint_reactions(model, q, loads)
    turned = ks.joint_reactions(model, q, loads, axes="base")
    assert_close(turned.base, r.base, ROUNDING)
    for i, name in enumerate(r.joints):
        size = max(1.0, np.abs(r.wrenches[i]).max())
        force, moment = r.wrench(name)[LINEAR], r.wrench(name)[ANGULAR]
        v, w = model.screws[i][LINEAR], model.screws[i][ANGULAR]
        slides = not np.any(w)
        moment = moment - np.cross(np.cross(w, v), force)
        pitch = v @ w
        assert np.hypot(r.radial[i], r.axial[i]) == pytest.approx(np.linalg.norm(force), rel=1e-12, abs=1e-12)
        assert np.hypot(r.bending[i], r.torsion[i]) == pytest.approx(np.linalg.norm(moment), rel=1e-12, abs=1e-12 * size)
        expected = r.axial[i] if slides else r.torsion[i] + pitch * r.axial[i]
        assert abs(r.drive[i] - expected) <= 1e-12 * size * (1 + np.abs(v).max())
        assert np.linalg.norm(turned.wrenches[i][LINEAR]) == pytest.approx(np.linalg.norm(force), rel=1e-12, abs=1e-12)


def virtual_work(model, q, loads, gravity):
    """The gradient of the potential less the work of the loads, derivatives by PyTorch: no Jacobian of ours takes part."""
    x = torch.tensor(q)
    torques = torch.func.grad(lambda y: ks.potential_energy(model, y, gravity=gravity))(x).numpy()
    for link, wrench in loads:
        default = (wrench.frame.axes, wrench.frame.origin) == ("base", "tip")
        axes, origin = ("base", link) if default else (wrench.frame.axes, wrench.frame.origin)
        R = ks.pose(model, q, at=axes).rotation
        force, moment = R @ wrench.force, R @ wrench.torque
        place = ks.pose(model, q, at=origin, point=wrench.frame.offset).translation
        own = ks.pose(model, q, at=link)
        point = tuple((own.rotation.T @ (place - own.translation)).tolist())  # the link's point that is there now
        moved = torch.func.jacfwd(lambda y, at=link, p=point: ks.pose(model, y, at=at, point=p).array)(x).numpy()
        turning = np.einsum("abk,cb->ack", moved[:3, :3], own.rotation)
        w = np.stack([turning[2, 1], turning[0, 2], turning[1, 0]])
        work = force @ moved[:3, 3] + moment @ w
        torques -= work if wrench.acts_on == "robot" else -work
    return torques


@pytest.mark.parametrize("name", REAL)
def test_three_routes_on_real_arms(name):
    """Free-body balance, Jᵀf with Jacobians of the centres of mass, and virtual work agree to 1e-10 N m."""
    arm = ks.load(name).with_payload(2.0, (0.01, 0.02, 0.1), np.diag([0.01, 0.02, 0.02]))
    g = ks.gravity_in_base((0.4, -0.3, 0.1))
    middle = arm.link_names[len(arm.link_names) // 2]
    for seed, q in enumerate(arm.random_configurations(3, seed=5)):
        rng = np.random.default_rng(seed)
        loads = [
            ("tip", ks.Wrench.on_robot(rng.normal(size=3) * 30, rng.normal(size=3) * 5)),
            (middle, ks.Wrench.on_robot(rng.normal(size=3) * 30, rng.normal(size=3), ks.Frame.body(middle))),
            (middle, ks.Wrench.on_environment(rng.normal(size=3), frame=ks.Frame("tip", "base", (0.1, 0.2, 0.3)))),
        ]
        r = ks.joint_reactions(arm, q, loads, gravity=g)
        second = ks.holding_torques(arm, q, loads, gravity=g)
        assert np.abs(r.torques - second).max() <= 1e-10
        assert np.abs(second - virtual_work(arm, q, loads, g)).max() <= 1e-10
        assert 0 < r.residual <= 1e-11


@pytest.mark.parametrize(
    "f", [Features(seed=3), Features(seed=4, joints=5, tree=True, mimic=True), Features(seed=6, joints=5, other_base=True)]
)
def test_three_routes_on_every_joint_type(f):
    """The same on helical and prismatic joints, trees and mimic followers."""
    model, q, g = heavy(f), f.configurations(), gravity_of(f.seed)
    loads = loads_on(model, f.seed)
    second = ks.holding_torques(model, q, loads, gravity=g)
    size = scale_of(second)
    assert np.abs(ks.joint_reactions(model, q, loads, gravity=g).torques - second).max() <= 1e-12 * size
    assert np.abs(second - virtual_work(model, q, loads, g)).max() <= 1e-12 * size


@given(features(max_joints=5))
def test_a_payload_is_its_weight(f):
    """Gravity with a payload = gravity without it and the weight as a load at its centre; a batch of payloads adds up."""
    model = f.model()
    if not model.has_masses:
        return
    q, g, rng = f.configurations(2), gravity_of(f.seed), np.random.default_rng(f.seed)
    link = model.link_name(int(rng.integers(len(model.link_names))))
    center = tuple(rng.normal(size=3).tolist())
    loaded = model.with_payload(2.0, center, at=link)
    weight = {link: ks.Wrench.on_robot(2.0 * g, frame=ks.Frame("base", link, center))}
    expected = ks.holding_torques(model, q, weight, gravity=g)
    size = max(scale_of(expected), scale_of(ks.gravity_torques(model, q, gravity=g, by_link=True)))
    assert np.abs(ks.gravity_torques(loaded, q, gravity=g) - expected).max(initial=0.0) <= ROUNDING * size
    assert_close(ks.com_jacobians(loaded, q)["payload"], ks.jacobian(model, q, at=link, point=center).linear, ROUNDING)
    twice = loaded.with_payload(1.5, center, at=link, name="more")
    once = model.with_payload(3.5, center, at=link)
    assert_close(ks.gravity_torques(twice, q, gravity=g), ks.gravity_torques(once, q, gravity=g), ROUNDING)


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_mounting_turns_gravity_and_nothing_else(angles):
    """Gravity in base axes is the world's turned back: U is m g times the height in the world; a matrix says the same."""
    R, arm = rpy_to_rotation(*angles), ks.load("ur5e")
    g = ks.gravity_in_base(angles)
    assert_close(R @ g, [0, 0, -9.81], 1e-14)
    np.testing.assert_array_equal(ks.gravity_in_base(R), g)
    q = arm.random_configurations(1, seed=1)[0]
    point, mass = ks.center_of_mass(arm, q)
    height = (R @ point)[2]
    assert_close(ks.potential_energy(arm, q, gravity=g), mass * 9.81 * height, ROUNDING)


@pytest.mark.parametrize(
    ("word", "R"), [("floor", (0, 0, 0)), ("ceiling", (np.pi, 0, 0)), ("wall", (0, np.pi / 2, 0))], ids=str
)
def test_mountings_by_name(word, R):
    """The words are roll, pitch and yaw as documented, but exact."""
    g = ks.gravity_in_base(word, 1.62)
    np.testing.assert_allclose(g, ks.gravity_in_base(R, 1.62), atol=1e-15)
    assert np.count_nonzero(g) == 1
    assert not np.any(np.signbit(g[g == 0]))


def still_held(arm, q, mass, point, limits):
    """Whether the motors hold a mass, asked of a robot that carries it."""
    loaded = arm if mass == 0 else arm.with_payload(mass, point)
    return np.all(np.abs(ks.holding_torques(loaded, q)) <= limits)


def bisected(holds, most):
    """The largest value in [0, most] up to which `holds` is true, by halving."""
    low, high = 0.0, most
    for _ in range(55):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


@pytest.mark.parametrize("name", ["ur3e", "ur5e", "ur10e"])
def test_payload_by_halving(name):
    """The capacity is where a bisection ends that asks a loaded robot for its torques; the named joint is at its limit."""
    arm, point = ks.load(name), (0.02, -0.03, 0.1)
    q = arm.random_configurations(3, seed=2)
    capacity = ks.payload_capacity(arm, q, point=point)
    for k in range(len(q)):
        most = bisected(lambda m, k=k: still_held(arm, q[k], m, point, arm.effort_limits), 1e4)
        assert capacity.value[k] == pytest.approx(most, rel=1e-9)
        loaded = ks.holding_torques(arm.with_payload(capacity.value[k], point), q[k])
        assert np.abs(loaded - capacity.torques[k]).max() <= 1e-9
        joint = arm.joint_names.index(capacity.limiting_joint[k])
        assert abs(loaded[joint]) == pytest.approx(arm.effort_limits[joint], rel=1e-9)


@pytest.mark.parametrize("size", [3, 6])
def test_force_by_halving(size):
    """The same for forces and wrenches along any direction, on every link, with the weight taken off."""
    arm, rng = ks.load("ur10e"), np.random.default_rng(3)
    for k, q in enumerate(arm.random_configurations(5, seed=3)):
        at = arm.link_names[-1 - k]
        direction = rng.normal(size=size) * 3
        unit = direction / np.linalg.norm(direction) if size == 3 else direction
        six = np.r_[unit, np.zeros(6 - size)]

        def holds(x, q=q, at=at, six=six):
            push = ks.Wrench.on_environment(x * six[LINEAR], x * six[ANGULAR])
            return np.all(np.abs(ks.holding_torques(arm, q, {at: push})) <= arm.effort_limits)

        capacity = ks.force_capacity(arm, q, direction, at=at)
        most = bisected(holds, 1e5)
        assert capacity.value == pytest.approx(most, rel=1e-9) or (capacity.held_by_structure and most > 9e4)
        assert not holds(min(capacity.value, 1e9) * (1 + 1e-9) + 1e-9) or capacity.held_by_structure


def test_duality_of_capacity_and_speed():
    """A joint that limits the force along a line is one that turns when the tip moves along it: J row times torque."""
    leg = ks.from_dh([(0.43, 0, 0, 0), (0.43, 0, 0, 0)], convention="standard")
    for bend in (0.2, 0.7, 1.5):
        q = [np.pi / 2 - bend / 2, bend]
        push = ks.force_capacity(leg, q, (0, 1, 0), gravity=None, effort_limits=(250, 250))
        rise = ks.jacobian(leg, q).linear[1]
        assert push.value == pytest.approx(250 / abs(rise[1]), rel=1e-12)


@given(features(max_joints=7), st.sampled_from(FRAMES[:3]))
def test_compliance_is_the_energy_of_the_springs(f, frame):
    """wᵀ C w is twice the energy that the torques Jᵀw put into the springs; stiffness inverts it where it can."""
    model = f.model()
    q, rng = f.configurations(), np.random.default_rng(f.seed)
    J = ks.jacobian(model, q, frame=frame)
    stiffness = np.where(rng.random(model.n) < 0.2, np.inf, 10.0 ** rng.uniform(2, 4, model.n))
    w = rng.normal(size=6)
    torques = ks.joint_torques(J, ks.Wrench(w, J.frame, "environment"))
    energy = (torques**2 / stiffness).sum()
    C = ks.tip_compliance(J, stiffness)
    assert_close(w @ C @ w, energy, ROUNDING)
    s = ks.tip_stiffness(J, stiffness)
    assert s.rank + len(s.rigid) == 6
    condition = np.linalg.norm(s.matrix) * np.linalg.norm(C)
    assert np.abs(C @ s.matrix @ C - C).max() <= 1e-13 * condition * max(1e-300, np.abs(C).max())
    assert_close(s.compliance, C, 1e-14)
    assert np.abs(s.rigid @ (J.array * np.isfinite(stiffness))).max(initial=0.0) <= 1e-8 * scale_of(J.array)
    assert np.abs(s.held @ C).max(initial=0.0) <= 1e-8 * np.abs(C).max(initial=0.0)


def settled(arm, start, stiffness, first, second, frame):
    """Where the elastic arm comes to rest when the wrench changes from first to second: Newton's method on equilibrium."""
    rest = ks.jacobian(arm, start, frame=frame).array.T @ first  # torque of the springs at the start
    q = start.copy()
    for _ in range(30):
        J = ks.jacobian(arm, q, frame=frame).array
        out = stiffness * (q - start) - (J.T @ second - rest)
        bend = np.einsum("r,rjk->jk", second, ks.hessian(arm, q, frame=frame).array)
        q = q - np.linalg.solve(np.diag(stiffness) - bend, out)
    assert np.abs(out).max() < 1e-9
    return q


@pytest.mark.parametrize("frame", [ks.Frame(), ks.Frame.body()], ids=["wrench fixed in space", "wrench follows the tip"])
@pytest.mark.parametrize("name", ["ur5e", "iiwa_14", "planar_3r", "stanford_arm"])
def test_preloaded_compliance_is_the_derivative_of_equilibrium(name, frame):
    """The tip's displacement when the load on an elastic arm changes a little, found by solving for equilibrium anew."""
    arm, rng = ks.load(name), np.random.default_rng(8)
    q = arm.random_configurations(1, seed=4)[0]
    stiffness = rng.uniform(300, 3000, arm.n)
    preload = np.r_[rng.normal(size=3) * 60, rng.normal(size=3) * 10]
    J, H = ks.jacobian(arm, q, frame=frame), ks.hessian(arm, q, frame=frame)
    C = ks.tip_compliance(J, stiffness, wrench=ks.Wrench(preload, J.frame, "robot"), hessian=H)
    pushed = ks.tip_compliance(J, stiffness, wrench=ks.Wrench(-preload, J.frame, "environment"), hessian=H)
    assert_close(pushed, C, 1e-15)
    step, columns = 1e-3, []
    R = ks.pose(arm, q, at=J.frame.axes).rotation
    for k in range(6):
        ends = [settled(arm, q, stiffness, preload, preload + s * step * np.eye(6)[k], frame) for s in (1, -1)]
        there, back = (ks.pose(arm, end) for end in ends)
        turn = there.rotation @ back.rotation.T
        angles = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        columns.append(np.r_[R.T @ (there.translation - back.translation), R.T @ angles] / (2 * step))
    found = np.array(columns).T
    assert np.abs(found - C).max() <= 1e-6 * np.abs(C).max()
    plain = ks.tip_compliance(J, stiffness)
    assert np.abs(C - plain).max() > 1e-3 * np.abs(plain).max()  # the preload is felt
    s = ks.tip_stiffness(J, stiffness, wrench=ks.Wrench(preload, J.frame, "robot"), hessian=H)
    assert np.abs(C @ s.matrix @ C - C).max() <= 1e-8 * np.abs(C).max()


def test_conservative_congruence():
    """K_q = Jᵀ K_x J + K_G (Chen and Kao 2000) for an arm without singularity, as printed there."""
    arm = ks.load("ur5e")
    q = arm.random_configurations(1, seed=6)[0]
    J, H, K = ks.jacobian(arm, q), ks.hessian(arm, q), np.linspace(1000, 2000, 6)
    w = np.array([30.0, -20.0, 10.0, 0.0, 0.0, 0.0])
    Kx = ks.tip_stiffness(J, K, wrench=ks.Wrench.on_robot(w[LINEAR], frame=J.frame), hessian=H).matrix
    KG = np.einsum("r,rjk->jk", w, H.array)
    assert_close(J.array.T @ Kx @ J.array + KG, np.diag(K), 1e-9)
