"""How do I differentiate through the kinematics?

The functions of the earlier examples take arrays of JAX and PyTorch as they take NumPy's: the library is read off the
argument, and the result is one of its arrays. So `jit`, `vmap`, `grad` and `backward` work, and an optimiser or a network
can have the arm in its loss. A library that is not installed is left out.

Law: the gradient of a point's coordinate is a row of its Jacobian, whoever differentiates.
"""

import importlib.util

import numpy as np

import kinestatics as ks

arm = ks.load("panda")
q = arm.home
exact = ks.jacobian(arm, q)


def height(x):
    """How high the tip is [m]."""
    return ks.pose(arm, x).translation[2]


print(f"{'NumPy':10s} row vz of J   ", np.array2string(exact.array[2], precision=6, suppress_small=True))

if importlib.util.find_spec("jax") is None:
    print("JAX is not installed")
else:
    import jax

    jax.config.update("jax_enable_x64", True)
    batch = np.concatenate([[q], arm.random_configurations(999, seed=0)])
    slopes = jax.jit(jax.vmap(jax.grad(height)))(jax.numpy.asarray(batch))
    print(f"{'JAX':10s} grad of height", np.array2string(np.asarray(slopes[0]), precision=6, suppress_small=True))
    np.testing.assert_allclose(slopes, ks.jacobian(arm, batch).array[:, 2], atol=1e-13)
    print(f"{'':10s} jit, vmap and grad over {len(slopes)} configurations agree with the Jacobians of NumPy")

if importlib.util.find_spec("torch") is None:
    print("PyTorch is not installed")
else:
    import torch

    x = torch.tensor(q, requires_grad=True)
    height(x).backward()
    print(f"{'PyTorch':10s} grad of height", np.array2string(x.grad.numpy(), precision=6, suppress_small=True))
    np.testing.assert_allclose(x.grad.numpy(), exact.array[2], atol=1e-14)

    x = torch.tensor(q)  # the tip is to rise by 10 cm and move no other way: Newton's method, with the Jacobian as a tensor
    start = torch.tensor(ks.pose(arm, q).translation)
    goal = start + torch.tensor([0.0, 0.0, 0.1], dtype=start.dtype)
    for _ in range(5):
        away = goal - ks.pose(arm, x).translation
        x = x + torch.linalg.pinv(ks.jacobian(arm, x).linear) @ away
    left = float(torch.linalg.vector_norm(goal - ks.pose(arm, x).translation))
    print(f"{'':10s} after 5 steps of Newton the tip is {left:.0e} m from its goal")
    assert left < 1e-12
