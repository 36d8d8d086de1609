"""One source file for NumPy, JAX, PyTorch and SymPy: the same numbers, and their own derivatives."""

import numpy as np
import pytest
import sympy as sp

import kinestatics as ks
from strategies import Features, assert_close

jax = pytest.importorskip("jax", reason="a judge of the dev extra")
torch = pytest.importorskip("torch", reason="a judge of the dev extra")
jax.config.update("jax_enable_x64", True)

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*torch.jit.script. is deprecated:DeprecationWarning"
)  # raised inside PyTorch

MECHANISMS = [
    Features(seed=3, joints=6),
    Features(seed=4, joints=5, tree=True, mimic=True),
    Features(seed=5, joints=4, right_angles=True, other_base=True),
]
IDS = ["chain", "tree with mimic", "right angles, other base"]
FRAMES = [ks.Frame(), ks.Frame.body(), ks.Frame.spatial(), ks.Frame("l1", "l2", (0.1, 0.2, 0.3))]
ROUNDING = 1e-13


@pytest.mark.parametrize("f", MECHANISMS, ids=IDS)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_jax_gives_the_same_numbers(f, frame):
    """Jacobian, Hessian, rate under jit and vmap."""
    model, q = f.model(), f.configurations(3)
    jacobian = jax.jit(lambda x: ks.jacobian(model, x, frame=frame).array)
    expected = ks.jacobian(model, q, frame=frame).array
    assert_close(jacobian(jax.numpy.asarray(q)), expected, ROUNDING)
    assert_close(jax.vmap(jacobian)(jax.numpy.asarray(q)), expected, ROUNDING)
    hessian = ks.hessian(model, jax.numpy.asarray(q), frame=frame).array
    assert_close(hessian, ks.hessian(model, q, frame=frame).array, 10 * ROUNDING)
    rate = ks.jacobian_rate(model, jax.numpy.asarray(q), q, frame=frame).array
    assert_close(rate, ks.jacobian_rate(model, q, q, frame=frame).array, 100 * ROUNDING)


@pytest.mark.parametrize("f", MECHANISMS, ids=IDS)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_jax_derivatives_are_the_hessian(f, frame):
    """The derivative that JAX takes of the Jacobian is the Hessian of the kernels: no step size, no tolerance to choose."""
    model, q = f.model(), f.configurations()
    derivative = jax.jacfwd(lambda x: ks.jacobian(model, x, frame=frame).array)(jax.numpy.asarray(q))
    assert_close(ks.hessian(model, q, frame=frame).array, derivative, 10 * ROUNDING)


@pytest.mark.parametrize("f", MECHANISMS, ids=IDS)
def test_jax_derivative_of_the_position_is_the_jacobian(f):
    """jacfwd of the tip's position is J.linear; grad of the potential energy is the gravity torque."""
    model, q = f.model(), f.configurations()
    derivative = jax.jacfwd(lambda x: ks.pose(model, x).translation)(jax.numpy.asarray(q))
    assert_close(ks.jacobian(model, q).linear, derivative, ROUNDING)

    def energy(x):
        heights = [
            ks.pose(model, x, at=n, point=tuple(c)).array[2, 3]
            for n, c in zip(model.link_names, model.centers_of_mass, strict=True)
        ]
        return 9.81 * sum(m * h for m, h in zip(model.masses, heights, strict=True))

    assert_close(ks.gravity_torques(model, q), jax.grad(energy)(jax.numpy.asarray(q)), ROUNDING)
    assert_close(ks.gravity_torques(model, jax.numpy.asarray(q)), ks.gravity_torques(model, q), ROUNDING)


@pytest.mark.parametrize("f", MECHANISMS, ids=IDS)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_torch_gives_the_same_numbers_and_derivatives(f, frame):
    """Jacobian on tensors, and torch.func.jacfwd of it."""
    model, q = f.model(), f.configurations()
    tensor = torch.tensor(q)
    J = ks.jacobian(model, tensor, frame=frame)
    assert_close(J.array.numpy(), ks.jacobian(model, q, frame=frame).array, ROUNDING)
    derivative = torch.func.jacfwd(lambda x: ks.jacobian(model, x, frame=frame).array)(tensor)
    assert_close(ks.hessian(model, q, frame=frame).array, derivative.numpy(), 10 * ROUNDING)
    batch = torch.tensor(f.configurations(4))
    assert_close(
        torch.func.vmap(lambda x: ks.jacobian(model, x, frame=frame).array)(batch).numpy(),
        ks.jacobian(model, batch.numpy(), frame=frame).array,
        ROUNDING,
    )
    assert J.to_array(order="angular-linear").shape == (6, model.n)


def test_torch_gradients_flow():
    """backward() through the position of the tip is J.linearᵀ."""
    model, q = MECHANISMS[0].model(), MECHANISMS[0].configurations()
    x = torch.tensor(q, requires_grad=True)
    weights = torch.tensor([0.3, -1.0, 2.0], dtype=torch.float64)
    (ks.pose(model, x).translation * weights).sum().backward()
    assert_close(x.grad.numpy(), ks.jacobian(model, q).linear.T @ weights.numpy(), ROUNDING)
    assert str(ks.jacobian(model, x)).startswith("Jacobian")


def test_sympy_gives_the_same_numbers():
    """Symbols put into a general arm, numbers put into the symbols."""
    model = Features(seed=9, joints=3, kinds=("revolute", "prismatic", "helical")).model()
    symbols = np.array(sp.symbols(f"q1:{model.n + 1}"), dtype=object)
    q = np.random.default_rng(2).normal(size=model.n)
    values = dict(zip(symbols, q, strict=True))
    for frame in FRAMES[:3]:
        J = ks.jacobian(model, symbols, frame=frame).array
        found = np.array([[float(x.subs(values)) for x in row] for row in J])
        assert_close(found, ks.jacobian(model, q, frame=frame).array, 1e-12)
    H = ks.hessian(model, symbols).array
    derivative = np.array(
        [[[sp.diff(x, s).subs(values) for s in symbols] for x in row] for row in ks.jacobian(model, symbols).array]
    )
    assert_close(np.vectorize(lambda x: float(x.subs(values)))(H), derivative.astype(float), 1e-12)


def test_symbolic_lengths_stay_exact():
    """The textbook Jacobian of a planar 2R arm, to the letter."""
    l1, l2, q1, q2 = sp.symbols("l1 l2 q1 q2")
    arm = ks.from_dh([(l1, 0, 0, 0), (l2, 0, 0, 0)], convention="standard")
    J = sp.Matrix(ks.jacobian(arm, [q1, q2]).linear[:2]).applyfunc(sp.simplify)
    assert (
        sp.Matrix(
            [
                [-l1 * sp.sin(q1) - l2 * sp.sin(q1 + q2), -l2 * sp.sin(q1 + q2)],
                [l1 * sp.cos(q1) + l2 * sp.cos(q1 + q2), l2 * sp.cos(q1 + q2)],
            ]
        )
        == J
    )
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        ks.Evaluator(arm)


def test_mixing_libraries_is_an_error():
    """q of one library and qd of another is refused; a NumPy qd goes with any q."""
    model = MECHANISMS[0].model()
    q = MECHANISMS[0].configurations()
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        ks.jacobian_rate(model, jax.numpy.asarray(q), torch.tensor(q))
    assert ks.jacobian_rate(model, torch.tensor(q), q).array.shape == (6, model.n)


@pytest.mark.parametrize("frame", [ks.Frame(), ks.Frame.body()], ids=str)
def test_wrenches_of_every_library(frame):
    """A wrench made of JAX, PyTorch or SymPy parts gives the torques of the same numbers, and gradients flow through it."""
    model, q = MECHANISMS[0].model(), MECHANISMS[0].configurations(1)[0]
    force, torque = np.array([1.0, -2.0, 0.5]), np.array([0.1, 0.2, -0.3])
    J = ks.jacobian(model, q, frame=frame)
    expected = ks.joint_torques(J, ks.Wrench.on_robot(force, torque, frame))

    def torques(f):
        return ks.joint_torques(J, ks.Wrench.on_robot(f, torque, frame))

    assert_close(jax.jit(torques)(jax.numpy.asarray(force)), expected, ROUNDING)
    assert_close(jax.jacobian(torques)(jax.numpy.asarray(force)), -J.linear.T, ROUNDING)
    tensor = torch.tensor(force, requires_grad=True)
    assert_close(torques(tensor).detach().numpy(), expected, ROUNDING)
    torques(tensor).sum().backward()
    assert_close(tensor.grad.numpy(), -J.linear.sum(1), ROUNDING)
    fx = sp.Symbol("fx")
    symbolic = torques([fx, -2.0, 0.5])
    assert_close(np.array([float(t.subs(fx, 1)) for t in symbolic]), expected, ROUNDING)
