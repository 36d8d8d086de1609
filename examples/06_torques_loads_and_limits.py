"""What must the motors supply, and what can the arm carry?

Signs are where most mistakes are made. A wrench therefore says who acts on whom: `Wrench.on_robot` is a load on the arm,
`Wrench.on_environment` what the arm exerts; they are opposite, and so are their torques. `joint_torques` and
`gravity_torques` both return what the motors must supply to hold still, so that they may be added and compared with limits.

Law: holding torques are the gradient of the potential energy: Σ m g h for the arm itself, and -F · p for a dead load F at p.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("ur5e")
q = np.array([0.0, -0.6, 0.9, -1.2, -1.57, 0.0])
J = ks.jacobian(arm, q)
weight = 5.0 * 9.81  # the rated payload of 5 kg, hanging at the flange
load = ks.Wrench.on_robot(force=(0, 0, -weight))
push = ks.Wrench.on_environment(force=(0, 0, -weight))  # the arm presses down on a table as hard
by_gravity = ks.gravity_torques(arm, q)
by_load = ks.joint_torques(J, load)
total = by_gravity + by_load

print(f"{'joint':22s}{'gravity':>10s}{'load':>10s}{'both':>10s}{'limit':>8s}{'used':>7s}")
for row in zip(arm.joint_names, by_gravity, by_load, total, arm.effort_limits, strict=True):
    print(f"{row[0]:22s}{row[1]:z10.2f}{row[2]:z10.2f}{row[3]:z10.2f}{row[4]:8.0f}{abs(row[3]) / row[4]:7.0%}")

np.testing.assert_allclose(ks.joint_torques(J, push), -by_load, atol=1e-12)
assert np.all(np.abs(total) < arm.effort_limits)

room = np.where(by_load > 0, arm.effort_limits - by_gravity, -arm.effort_limits - by_gravity)
with np.errstate(divide="ignore"):
    most = np.where(np.abs(by_load) > 1e-9, room / by_load, np.inf)
first = int(np.argmin(most))
print(f"\nstatically, in this posture: {5 * most[first]:.1f} kg, where {arm.joint_names[first]} reaches its limit")
at_limit = by_gravity + most[first] * by_load
np.testing.assert_allclose(abs(at_limit[first]), arm.effort_limits[first], rtol=1e-12)
assert np.all(np.abs(at_limit) <= arm.effort_limits * (1 + 1e-12))


def potential(x):
    """Energy of the arm's masses and of the dead load [J]."""
    energy = weight * ks.pose(arm, x).translation[2]
    for name, mass, center in zip(arm.link_names, arm.masses, arm.centers_of_mass, strict=True):
        energy += mass * 9.81 * ks.pose(arm, x, at=arm.link_name(arm.link_names.index(name)), point=center).translation[2]
    return energy


step = 1e-5 * np.eye(6)
gradient = np.array([(potential(q + e) - potential(q - e)) / 2e-5 for e in step])
print("gradient of the energy:", np.array2string(gradient, precision=2, suppress_small=True))
np.testing.assert_allclose(gradient, total, atol=1e-7)

by_link = ks.gravity_torques(arm, q, by_link=True)
print(f"\n{'which link weighs on the shoulder':36s}{'[N m]':>8s}")
for name, torque in zip(arm.link_names, by_link[:, 1], strict=True):
    print(f"  {name:34s}{torque:z8.2f}")
np.testing.assert_allclose(by_link.sum(axis=0), by_gravity, atol=1e-12)
