"""How fast is the tip, and how does it accelerate?

The twist of the tip is J q̇ and its acceleration J q̈ + J̇ q̇: the tip accelerates even where no joint does. J̇ is the Hessian
contracted with q̇. Each is checked here against differences of the pose, which know nothing of Jacobians.

Law: v = dp/dt and [ω]× = dR/dt Rᵀ; a = d²p/dt²; J̇ = Σ_k ∂J/∂q_k q̇_k.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("panda")
q, qd, qdd = arm.home, np.linspace(0.5, -0.4, 7), np.linspace(-1.0, 1.5, 7)


def at_time(t):
    """The pose of the tip on the path q + q̇ t + q̈ t²/2."""
    return ks.pose(arm, q + qd * t + qdd * t**2 / 2)


J = ks.jacobian(arm, q)
twist = J @ qd
acceleration = ks.acceleration(arm, q, qd, qdd)

h = 1e-4  # seconds; central differences are wrong by about h²
before, now, after = at_time(-h), at_time(0.0), at_time(h)
velocity = (after.translation - before.translation) / (2 * h)
second = (after.translation - 2 * now.translation + before.translation) / h**2
turning = (after.rotation - before.rotation) / (2 * h) @ now.rotation.T  # [ω]×
spin = np.array([turning[2, 1], turning[0, 2], turning[1, 0]])


def row(name, ours, differences):
    """A line of the table."""
    print(f"{name:28s}{np.array2string(ours, precision=5, suppress_small=True, sign=' '):32s}", end="")
    print(f"{np.abs(ours - differences).max():10.1e}")


print(f"{'':28s}{'kinestatics':32s}{'off from differences':>10s}")
row("velocity [m/s]", twist.linear, velocity)
row("angular velocity [rad/s]", twist.angular, spin)
row("acceleration [m/s²]", acceleration.linear, second)
row("  of it J̇ q̇", ks.jacobian_rate(arm, q, qd).array[:3] @ qd, second - J.linear @ qdd)

np.testing.assert_allclose(twist.linear, velocity, atol=1e-7)
np.testing.assert_allclose(twist.angular, spin, atol=1e-7)
np.testing.assert_allclose(acceleration.linear, second, atol=1e-6)
H = ks.hessian(arm, q).array
np.testing.assert_allclose(ks.jacobian_rate(arm, q, qd).array, H @ qd, atol=1e-14)
