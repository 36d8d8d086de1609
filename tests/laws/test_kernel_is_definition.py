"""The kernels repeat the definition: each quantity, instruction set, frame, batch size, mimic, tree, gravity direction."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from kinestatics import definition, kernels
from kinestatics.definition import Target
from kinestatics.inverse_velocity.limits import approach_rate
from kinestatics.namespaces import as_array
from strategies import Features, assert_close, features

SETS = kernels.instruction_sets()
ROUNDING = 5e-14  # a dozen fused operations on numbers of the size of the result; helical joints add lengths


def both(f, axes_of_target, origin_at_base, rows=(0, 1, 2, 3, 4, 5), gravity=(0.0, 0.0, -9.81)):
    """The chain and the target that ask the same question."""
    model = f.model()
    tip, base = model.link("tip"), model.link("base")
    offset = tuple(np.random.default_rng(f.seed).normal(size=3))
    chain = kernels.Chain(
        *kernels.chain_arguments(
            model,
            tip,
            axes_of_target=axes_of_target,
            origin_at_base=origin_at_base,
            offset=offset,
            rows=rows,
            gravity=gravity,
        )
    )
    zero = (0.0, 0.0, 0.0)
    target = Target(
        tip, tip if axes_of_target else base, base if origin_at_base else tip, zero if origin_at_base else offset
    )
    return model, chain, target, Target(tip, tip, tip, offset)


@pytest.mark.parametrize("name", SETS)
@given(f=features(max_joints=9), body=st.booleans(), spatial=st.booleans(), count=st.integers(0, 21))
def test_kinematics(name, f, body, spatial, count):
    """Pose, Jacobian, rate, Hessian and Jᵀw."""
    model, chain, target, place = both(f, body, spatial)
    rng = np.random.default_rng(f.seed)
    q, xp = as_array(f.configurations(count))
    qd, wrench = rng.normal(size=q.shape), rng.normal(size=(count, 6))
    J, H = definition.jacobian(model, q, target, xp), definition.hessian(model, q, target, xp)
    R, p = definition.pose(model, q, place, xp)
    with kernels.use(name):
        assert_close(chain.jacobian(q), J, ROUNDING)
        assert_close(chain.hessian(q), H, ROUNDING)
        assert_close(chain.jacobian_rate(q, qd), definition.rotate_last(H, qd) if model.n else J, ROUNDING)
        assert_close(chain.joint_torques(q, wrench), np.einsum("irk,ir->ik", J, wrench), ROUNDING)
        T = chain.pose(q)
        assert_close(T[:, :3, :3], np.broadcast_to(R, (count, 3, 3)), ROUNDING)
        assert_close(T[:, :3, 3], np.broadcast_to(p, (count, 3)), ROUNDING)
        assert np.all(T[:, 3] == [0, 0, 0, 1])
        for i in range(count):
            assert np.array_equal(chain.jacobian(q[i]), chain.jacobian(q)[i])  # one call and a batch: the same bits


@pytest.mark.parametrize("name", SETS)
@given(f=features(max_joints=9), count=st.integers(0, 21))
def test_gravity(name, f, count):
    """Gravity torques of trees, for any direction."""
    gravity = tuple(np.random.default_rng(f.seed).normal(size=3) * 9.81) if f.seed % 2 else (0.0, 0.0, -9.81)
    model, chain, _, _ = both(f, False, False, gravity=gravity)
    q, xp = as_array(f.configurations(count))
    with kernels.use(name):
        assert_close(chain.gravity_torques(q), definition.gravity_torques(model, q, gravity, xp), ROUNDING)


@pytest.mark.parametrize("name", SETS)
@given(f=features(max_joints=9), count=st.integers(1, 21), rows=st.sets(st.integers(0, 5), min_size=1))
def test_singular_values_and_what_follows(name, f, count, rows):
    """Singular values, their product, and damped rates, against LAPACK."""
    picked = tuple(sorted(rows))
    model, chain, target, _ = both(f, False, False, rows=picked)
    if model.n == 0:
        return
    q, xp = as_array(f.configurations(count))
    J = definition.jacobian(model, q, target, xp)[:, list(picked)]
    twist = np.random.default_rng(f.seed).normal(size=(count, 6))
    sigma = np.linalg.svd(J, compute_uv=False)
    size = max(1.0, sigma.max())
    damping = 0.1 * size
    normal = np.einsum("irk,irl->ikl", J, J) + damping**2 * np.eye(model.n)
    rates = np.linalg.solve(normal, np.einsum("irk,ir->ik", J, twist[:, list(picked)])[..., None])[..., 0]
    with kernels.use(name):
        assert np.abs(chain.singular_values(q) - sigma).max() <= 2e-14 * size
        assert np.abs(chain.manipulability(q) - sigma.prod(-1)).max() <= 1e-13 * size ** sigma.shape[-1]
        assert_close(chain.damped_rates(q, twist, damping), rates, 1e-11)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("joints", [1, 2, 3, 6, 7, 32, 100])
@settings(max_examples=2)
@given(seed=st.integers(0, 10**6))
def test_any_number_of_joints(name, joints, seed):
    """1 to 100 joints, in chains and trees."""
    f = Features(seed=seed, joints=joints, tree=bool(seed % 2))
    model, chain, target, _ = both(f, False, False)
    q, xp = as_array(f.configurations(11))
    with kernels.use(name):
        assert_close(chain.jacobian(q), definition.jacobian(model, q, target, xp), 1e-12)
        assert_close(chain.gravity_torques(q), definition.gravity_torques(model, q, (0, 0, -9.81), xp), 1e-12)


@pytest.mark.parametrize("name", SETS)
def test_large_outputs_at_every_alignment(name):
    """Above the size at which results bypass the caches: right at every offset of a cache line, nothing written beside."""
    f = Features(seed=5, joints=7, kinds=("revolute",))
    model, chain, target, _ = both(f, False, False)
    count = 2503
    q, xp = as_array(f.configurations(count))
    expected = definition.jacobian(model, q, target, xp)
    size = expected.size
    with kernels.use(name):
        for shift in range(9):
            memory = np.full(size + 32, 7.25)
            out = memory[shift : shift + size].reshape(expected.shape)
            chain.jacobian(q, out=out)
            assert_close(out, expected, ROUNDING)
            assert np.all(memory[:shift] == 7.25)
            assert np.all(memory[shift + size :] == 7.25)


@pytest.mark.parametrize("name", SETS)
def test_threads_give_the_same_bits(name):
    """However a batch is split, each configuration meets the same instructions."""
    f = Features(seed=11, joints=7)
    _, chain, _, _ = both(f, False, False)
    q = f.configurations(5003)
    with kernels.use(name):
        for method in (chain.jacobian, chain.pose, chain.gravity_torques, chain.singular_values, chain.hessian):
            one = method(q)
            for threads in (2, 3, 5):
                assert np.array_equal(method(q, threads=threads), one)


@pytest.mark.parametrize("name", SETS)
@given(f=features(max_joints=9), body=st.booleans(), braking=st.booleans())
def test_program_of_a_period(name, f, body, braking):
    """JᵀJ + λ², -Jᵀξ on the rows that count, and the bounds of RateLimits, whose words are in inverse_velocity/limits.py."""
    model, chain, target, _ = both(f, body, origin_at_base=False)
    rng, n, dt = np.random.default_rng(f.seed), model.n, 0.01
    q, xp = as_array(f.configurations(1)[0])
    weights, twist = rng.choice([0.0, 0.3, 1.0], 6), np.where(rng.random(6) < 0.2, np.nan, rng.normal(size=6))
    lower, upper = q - rng.uniform(-0.01, 0.5, n), q + rng.uniform(-0.01, 0.5, n)
    fastest, a, previous = rng.uniform(0.1, 3, n), rng.uniform(1, 9, n), rng.normal(size=n)
    settings = np.concatenate([weights, [0.04, dt], lower, upper, fastest, a if braking else np.full(n, np.inf)])
    program = np.zeros(6 + 10 * n + n * n)
    parts = np.split(program, np.cumsum([6 * n, 6, n, n * n, n, n]))
    parts[2][:] = previous
    with kernels.use(name):
        assert chain.bounded_program(q, twist, settings, program)
    factor = np.where(np.isnan(twist), 0.0, weights)
    J, goal = factor[:, None] * definition.jacobian(model, q, target, xp), factor * np.nan_to_num(twist)
    for found, expected in zip(parts, (J, goal, previous, J.T @ J + 0.04 * np.eye(n), -J.T @ goal), strict=False):
        assert_close(found, expected.ravel(), ROUNDING)
    for found, distance, sign in ((parts[5], upper - q, 1.0), (parts[6], q - lower, -1.0)):
        bound = sign * np.minimum(approach_rate(distance, dt, a if braking else None), fastest)
        expected = np.clip(bound, previous - a * dt, previous + a * dt) if braking else bound
        assert_close(found, expected, 1e-12)
