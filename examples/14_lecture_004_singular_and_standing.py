"""Why are straight legs easy to stand on and hard to move? (lecture 004)

"Differential kinematics" and "Statics in 2D" on one arm of two links: near the stretched posture the joints must run fast
for a slow tip, and for the same reason a small torque holds a large force. The leg of the lecture's last example is that
arm, with links of 0.43 m and 75 kg on the hip. The lecture's final line, τ2 = -m g L cos θ1, is right; two of the matrices
before it are not (docs/errata.md, E004-5 and E004-6).

Law: v = J q̇ and τ = Jᵀ F. Each half-axis of the force ellipsoid is one over a half-axis of the velocity ellipsoid, in the
same direction: what moves slowly pushes hard.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

free = float("nan")  # a component of a twist that may be anything
two = ks.from_dh([(1.0, 0, 0, 0), (1.0, 0, 0, 0)], convention="standard", name="two links of 1 m")
print("two links of 1 m at (0, θ2): joint rates for 1 m/s along and across the arm")
print(f"{'θ2 [rad]':>9s}{'det J':>9s}{'σ_min':>9s}{'along x: q̇ [rad/s]':>24s}{'across y: q̇ [rad/s]':>23s}")
for t2 in (1.0, 0.1, 0.01, 0.0):
    J = ks.jacobian(two, [0, t2])
    cells = []
    for direction in ((1, 0, free), (0, 1, free)):
        rates = ks.joint_rates(J, ks.Twist.of(linear=direction, angular=(free, free, free)))
        cells.append(" ".join(f"{x:z.3f}" for x in rates.array) if rates.reachable else "impossible")
    sigma = ks.singular_values(J.linear[:2])
    print(f"{t2:9.2f}{np.linalg.det(J.linear[:2]):9.4f}{sigma[-1]:9.4f}{cells[0]:>24s}{cells[1]:>23s}")
    if t2 == 0.01:  # the lecture's numbers
        np.testing.assert_allclose([float(x) for x in cells[0].split()], [99.9967, -199.998], atol=1e-3)
    assert (cells[0] == "impossible") == (t2 == 0)

L, mass, g = 0.43, 75.0, 9.81
leg = ks.from_dh([(L, 0, 0, 0), (L, 0, 0, 0)], convention="standard", name="leg", joint_names=["ankle", "knee"])
body = ks.Wrench.on_robot(force=(0, -mass * g, 0))  # the lecture's F = (0, m g) is what the leg exerts: the opposite
print(f"\nthe leg: links of {L} m, {mass:.0f} kg on the hip, the hip above the ankle")
head = ("knee bent by", "ankle [N m]", "knee [N m]", "-mgL cos θ1", "σ_min [m]", "250 N m hold [N]")
print("".join(f"{word:>{width}s}" for word, width in zip(head, (12, 13, 12, 13, 11, 18), strict=True)))
for degrees in (0, 10, 30, 60, 90):
    flexion = np.radians(degrees)
    q = np.array([np.pi / 2 - flexion / 2, flexion])
    J = ks.jacobian(leg, q)
    ankle, knee = ks.joint_torques(J, body)
    formula = -mass * g * L * np.cos(q[0])
    sigma = ks.singular_values(J.linear[:2])
    most = 250 * mass * g / abs(knee) if abs(knee) > 1e-9 else np.inf
    print(f"{degrees:10d} °{ankle:z13.1f}{knee:z12.1f}{formula:z13.1f}{sigma[-1]:z11.3f}{most:18.0f}")
    np.testing.assert_allclose([ankle, knee], [0, formula], atol=1e-10)
    straight_up = ks.joint_torques(J, ks.Wrench.on_environment(force=(0, 1, 0)))
    np.testing.assert_allclose(straight_up, [0, -L * np.sin(flexion / 2)], atol=1e-15)

q = np.array([np.pi / 2 - np.pi / 18, np.pi / 9])  # bent by 20°
rows = ks.jacobian(leg, q).linear[:2]
velocity, force = ks.velocity_ellipsoid(rows), ks.force_ellipsoid(rows)
print("\nbent by 20°: half-axes, and the direction of each")
print(f"{'direction':>16s}{'velocity [m/s per rad/s]':>27s}{'force [N per N m]':>20s}{'product':>10s}")
for radius, axis in zip(velocity.radii, velocity.axes.T, strict=True):
    k = int(np.argmax(np.abs(force.axes.T @ axis)))  # the force axis that lies along it
    direction = f"({axis[0]:z.2f}, {axis[1]:z.2f})"
    print(f"{direction:>16s}{radius:27.4f}{force.radii[k]:20.4f}{radius * force.radii[k]:10.4f}")
    np.testing.assert_allclose(np.abs(force.axes[:, k] @ axis), 1, atol=1e-12)
    np.testing.assert_allclose(radius * force.radii[k], 1, atol=1e-12)

if len(sys.argv) > 1:  # a folder for the pictures
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    for name, picture in (("velocity", ks.plots.velocity_ellipsoid), ("force", ks.plots.force_ellipsoid)):
        picture(leg, q).figure.savefig(Path(sys.argv[1]) / f"lecture_004_{name}.png")
