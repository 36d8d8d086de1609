"""The bits of a kernel's result depend on the configuration alone: not on batch, neighbours, threads or alignment."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from kinestatics import definition, kernels
from kinestatics.definition import Target
from kinestatics.namespaces import as_array
from strategies import Features, assert_close, features

SETS = kernels.instruction_sets()
QUANTITIES = {
    "jacobian": (),
    "pose": (),
    "hessian": (),
    "gravity_torques": (),
    "manipulability": (),
    "singular_values": (),
    "jacobian_rate": ("rate",),
    "joint_torques": ("six",),
    "damped_rates": ("six", 0.3),
}
ROUNDING = 5e-14  # as in test_kernel_is_definition
FRAMES = [(body, spatial) for body in (False, True) for spatial in (False, True)]


def chain_of(model, body=False, spatial=False, **options):
    return kernels.Chain(
        *kernels.chain_arguments(model, model.link("tip"), axes_of_target=body, origin_at_base=spatial, **options)
    )


def second(kind, q, seed=0):
    """The second argument of a quantity: rates like q, or six-vectors."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=q.shape if kind == "rate" else (*q.shape[:-1], 6))


def call(chain, name, q, also, **options):
    """A quantity by name; `also` is its second argument, if it has one."""
    arguments = QUANTITIES[name]
    return getattr(chain, name)(q, *((also, *arguments[1:]) if arguments else ()), **options)


def inputs(name, q, seed=0):
    return second(QUANTITIES[name][0], q, seed) if QUANTITIES[name] else None


def part(also, index):
    return None if also is None else also[index]


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize("name", QUANTITIES)
@given(f=features(max_joints=8), frame=st.sampled_from(FRAMES), count=st.integers(1, 21))
def test_a_batch_is_a_loop(instructions, name, f, frame, count):
    """A batch gives, bit for bit, what one call for each configuration gives, and so does any part of the batch."""
    model = f.model()
    chain, q = chain_of(model, *frame), f.configurations(count)
    also = inputs(name, q)
    with kernels.use(instructions):
        batch = call(chain, name, q, also)
        for i in range(count):
            np.testing.assert_array_equal(call(chain, name, q[i], part(also, i)), batch[i])
        cut = f.seed % count
        np.testing.assert_array_equal(call(chain, name, q[cut:], part(also, slice(cut, None))), batch[cut:])
        shuffled = np.random.default_rng(f.seed).permutation(count)
        np.testing.assert_array_equal(call(chain, name, q[shuffled], part(also, shuffled)), batch[shuffled])


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize("name", QUANTITIES)
def test_a_neighbour_that_is_not_a_number_changes_nothing(instructions, name):
    """NaN or infinity in one configuration is NaN there and leaves the bits of every other one alone."""
    f = Features(seed=8, joints=6, kinds=("revolute", "helical"))
    chain, q = chain_of(f.model()), f.configurations(19)
    also = inputs(name, q)
    with kernels.use(instructions):
        expected = call(chain, name, q, also)
        for where, poison in ((0, np.nan), (7, np.inf), (11, -np.inf), (18, np.nan)):
            spoilt = q.copy()
            spoilt[where, 2] = poison
            found = call(chain, name, spoilt, also)
            others = np.arange(19) != where
            np.testing.assert_array_equal(found[others], expected[others])
            assert np.isnan(found[where]).any()
            if name in ("manipulability", "singular_values", "damped_rates"):
                assert np.all(np.isnan(found[where]))


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize("name", QUANTITIES)
def test_threads_are_serial(instructions, name):
    """Threads split a batch without changing a bit, whatever their number."""
    f = Features(seed=12, joints=5, tree=True, mimic=True)
    model = f.model()
    chain, q = chain_of(model), f.configurations(4099)
    also = inputs(name, q)
    with kernels.use(instructions):
        serial = call(chain, name, q, also)
        for threads in (2, 3, 4, 100):
            np.testing.assert_array_equal(call(chain, name, q, also, threads=threads), serial)


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize("name", ["jacobian", "jacobian_rate", "hessian", "pose", "gravity_torques", "joint_torques"])
def test_large_results_are_small_ones_at_every_alignment(instructions, name):
    """Results above the streaming size have the bits of small ones at every offset of a cache line, and stay in place."""
    f = Features(seed=21, joints=7, mimic=True)
    model = f.model()
    chain = chain_of(model, body=True)
    one = call(chain, name, f.configurations(1), inputs(name, f.configurations(1)))
    count = 900_000 // (8 * one.size) + 5  # more than 800 kB, and not a whole number of blocks
    q = f.configurations(count)
    also = inputs(name, q)
    with kernels.use(instructions):
        pieces = [call(chain, name, q[i : i + 512], part(also, slice(i, i + 512))) for i in range(0, count, 512)]
        expected = np.concatenate(pieces)
        memory = np.empty(expected.size + 32)
        first = (-memory.ctypes.data // 8) % 8  # so that shift 0 begins a cache line
        for shift in range(first, first + 8):
            memory[:] = 7.25
            out = memory[shift : shift + expected.size].reshape(expected.shape)
            assert call(chain, name, q, also, out=out, threads=1 + shift % 2) is out
            np.testing.assert_array_equal(out, expected)
            assert np.all(memory[:shift] == 7.25)
            assert np.all(memory[shift + expected.size :] == 7.25)


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize("frame", FRAMES, ids=["tip", "spatial", "body", "base origin in tip axes"])
def test_a_thousand_configurations_are_the_definition(instructions, frame):
    """Batches of 1000, in every frame, of a tree with mimic and helical joints."""
    body, spatial = frame
    f = Features(seed=33, joints=9, tree=True, mimic=True)
    model = f.model()
    tip, base = model.link("tip"), model.link("base")
    target = Target(tip, tip if body else base, base if spatial else tip)
    q, xp = as_array(f.configurations(1000))
    qd = second("rate", q)
    chain = chain_of(model, body, spatial)
    with kernels.use(instructions):
        assert_close(chain.jacobian(q), definition.jacobian(model, q, target, xp), ROUNDING)
        assert_close(chain.jacobian_rate(q, qd), definition.jacobian_rate(model, q, qd, target, xp), ROUNDING)
        assert_close(chain.hessian(q), definition.hessian(model, q, target, xp), ROUNDING)


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize(
    "gravity", [(0, 0, -9.81), (0, 0, 9.81), (9.81, 0, 0), (0, -1e-3, 0), (3, -4, 5), (0, 0, 0), (1e-9, 0, -9.81)], ids=str
)
def test_gravity_points_anywhere(instructions, gravity):
    """Up, down, sideways, nearly down, and not at all."""
    for seed in range(12):
        f = Features(seed=seed, joints=6, tree=seed % 2 == 0, mimic=seed % 3 == 0, right_angles=seed % 4 == 0)
        model = f.model()
        q, xp = as_array(f.configurations(10))
        with kernels.use(instructions):
            found = chain_of(model, gravity=gravity).gravity_torques(q)
        expected = definition.gravity_torques(model, q, np.array(gravity, dtype=float), xp)
        leverage = model.masses.sum() * (1 + np.abs(q).max()) * 10 * max(np.linalg.norm(gravity), 1e-300)
        assert np.abs(found - expected).max(initial=0.0) <= 1e-15 * model.n * leverage


@pytest.mark.parametrize("name", QUANTITIES)
def test_single_precision_is_double_precision_rounded(name):
    """float32 in gives float32 out: the double result of the same numbers, rounded once."""
    f = Features(seed=14, joints=6)
    chain = chain_of(f.model())
    q = f.configurations(9).astype(np.float32)
    also = inputs(name, q)
    found = call(chain, name, q, also)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, call(chain, name, q.astype(np.float64), also).astype(np.float32))


@pytest.mark.parametrize("instructions", SETS)
def test_a_singular_arm_has_no_manipulability_and_finite_damped_rates(instructions):
    """At an exact singularity σ_min and w are zero to rounding; damped rates stay below |twist| / (2 damping)."""
    zero = np.zeros(6)
    f = Features(seed=2, joints=6, kinds=("prismatic",))  # six sliders: rank 3
    chain = chain_of(f.model())
    q = f.configurations(13)
    with kernels.use(instructions):
        sigma = chain.singular_values(q)
        assert np.all(sigma[:, 3:] <= 1e-15 * sigma[:, :1])
        assert np.all(chain.manipulability(q) <= 1e-15 * sigma[:, 0] ** 6)
        twist = np.random.default_rng(0).normal(size=(13, 6))
        for damping in (1e-6, 1e-2, 1.0):
            rates = chain.damped_rates(q, twist, damping)
            assert np.all(np.linalg.norm(rates, axis=-1) <= np.linalg.norm(twist, axis=-1) / (2 * damping) * (1 + 1e-12))
        assert np.all(chain.damped_rates(q, zero, 0.1) == 0)
