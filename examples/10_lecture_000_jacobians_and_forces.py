"""What does a Jacobian say about forces? (lecture 000)

The planar RR and the spherical arm of MEAM 520, lecture 17, "Jacobians and Forces": singularities, the pseudoinverse,
manipulability, the torques of a push, and gravity compensation, in the lecture's order. Two of its practice questions are
left open there: when there is no solution to the inverse kinematics, and what the ellipsoid of the spherical arm looks
like "in the zero configuration" (docs/errata.md, E000-6).

Law: virtual work, τ · q̇ = F · v for every q̇, hence τ = Jᵀ F. What no joint feels is null(Jᵀ), at right angles to all
velocities.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

try:
    import sympy as sp
except ModuleNotFoundError:
    print("SymPy is not installed: numbers without the lecture's formulas")
else:
    a1, a2, d1, t1, t2, d3 = sp.symbols("a1 a2 d1 theta1 theta2 d3")
    rr = ks.from_dh([(a1, 0, 0, 0), (a2, 0, 0, 0)], convention="standard")
    rows = sp.simplify(sp.Matrix(ks.jacobian(rr, [t1, t2]).linear[:2]))
    print("planar RR:  J_v =", *(f"\n    {list(rows.row(k))}" for k in range(2)))
    print(f"    det J_v = {sp.simplify(rows.det())}")
    up, down = sp.pi / 2, -sp.pi / 2
    table = [(0, down, d1, 0), (0, up, 0, up), (0, 0, 0, 0)]
    spherical = ks.from_dh(table, convention="standard", types="RRP")
    rows = sp.simplify(sp.Matrix(ks.jacobian(spherical, [t1, t2, d3]).linear))
    print("spherical:  J_v =", *(f"\n    {list(rows.row(k))}" for k in range(3)))
    print(f"    det J_v = {sp.simplify(rows.det())}")

arm = ks.from_dh(
    [(0.5, 0, 0, 0), (0.4, 0, 0, 0)],
    convention="standard",
    masses=[2.0, 1.0],
    centers_of_mass=[(-0.25, 0, 0), (-0.2, 0, 0)],  # halfway back from the far ends
)
print("\nplanar RR, a1 = 0.5 m, a2 = 0.4 m: what a push of 1 N takes, and what gravity does [N m]")
print(f"{'posture':12s}{'a1 a2 |sin θ2|':>15s}{'push along x':>16s}{'along y':>16s}{'by gravity':>16s}{'motors':>16s}")
for name, q in (("(0, π/2)", [0, np.pi / 2]), ("(0, 0)", [0, 0.0])):
    J = ks.jacobian(arm, q)
    along = [ks.joint_torques(J, ks.Wrench.on_environment(force=f)) for f in ((1, 0, 0), (0, 1, 0))]
    weights = zip(ks.com_jacobians(arm, q).values(), arm.masses[1:], strict=True)
    produced = sum(C.T @ [0, -m * 9.81, 0] for C, m in weights)  # the lecture's τ = Σ Jᵀ F_g
    motors = ks.gravity_torques(arm, q, gravity=(0, -9.81, 0))  # its τ_app: the opposite
    held = ", ".join(screw.text for screw in ks.analyze(arm, q).free_wrenches) or "nothing"
    cells = [" ".join(f"{x:z6.2f}" for x in row) for row in (*along, produced, motors)]
    print(f"{name:12s}{ks.manipulability(J):15.2f}" + "".join(f"{cell:>16s}" for cell in cells))
    print(f"{'':12s}held for free: {held}")
    np.testing.assert_allclose(motors, -produced, atol=1e-14)
    np.testing.assert_allclose(ks.manipulability(J), 0.2 * abs(np.sin(q[1])), atol=1e-15)

seven = ks.load("iiwa_14")
J = ks.jacobian(seven, seven.home)
xi = ks.Twist.of(linear=(0.1, 0, 0), angular=(0, 0, 0.2))
found = ks.joint_rates(J, xi)
rates, others = found.array, found.member(np.ones(7))
print("\nseven joints, one twist of the tip: |q̇| [rad/s]")
print(f"    J⁺ξ {np.linalg.norm(rates):.4f}, J⁺ξ + (I - J⁺J) b {np.linalg.norm(others):.4f}")
np.testing.assert_allclose((J @ others).array, xi.array, atol=1e-14)
np.testing.assert_allclose(rates, J.array.T @ np.linalg.solve(J.array @ J.array.T, xi.array), atol=1e-14)
assert np.linalg.norm(rates) < np.linalg.norm(others)

ball = ks.load("rrp_note_000")  # d1 = 0.3 m
torques = ks.joint_torques(ks.jacobian(ball, [np.pi / 4, 0, 1]), ks.Wrench.on_environment(force=(0, 2, 2)))
print(f"\nspherical at (π/4, 0, 1 m), push (0, 2, 2) N: {torques[0]:.4f} N m, {torques[1]:.4f} N m, {torques[2]:.4f} N")
np.testing.assert_allclose(torques, [np.sqrt(2), -2, np.sqrt(2)], atol=1e-15)

print("\nspherical: which velocities have a solution, and the ellipsoid")
print(f"{'(θ1, θ2, d3)':16s}{'det J_v':>9s}  {'half-axes [m/s]':18s}{'v = x':>8s}{'v = y':>8s}{'v = z':>8s}")
free = float("nan")  # a component that may be anything
for q in ([0, 0, 1.0], [0, 0, 0.5], [0, 0, 0.0], [0, np.pi / 2, 0.5]):
    J = ks.jacobian(ball, q)
    shape = ks.velocity_ellipsoid(J.linear)
    verdicts = []
    for v in np.eye(3):
        found = ks.joint_rates(J, ks.Twist.of(linear=v, angular=(free, free, free)))
        verdicts.append("yes" if found.reachable else "no")
    det = np.linalg.det(J.linear)
    radii = " ".join(f"{r:.2f}" for r in shape.radii)
    print(f"{f'(0, {q[1]:.2f}, {q[2]:.1f} m)':16s}{det:z9.3f}  {radii:18s}" + "".join(f"{word:>8s}" for word in verdicts))
    np.testing.assert_allclose(shape.axes @ np.diag(shape.radii**2) @ shape.axes.T, J.linear @ J.linear.T, atol=1e-14)
    assert ("no" in verdicts) == (abs(det) < 1e-12)
print("d3 = 0 or θ2 = π/2 + kπ: there some velocities have none. Positions always have one while d3 is free.")

if len(sys.argv) > 1:  # a folder for the picture
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    axes = ks.plots.velocity_ellipsoid(ball, [0, 0, 0.5])
    axes.figure.savefig(Path(sys.argv[1]) / "lecture_000.png")
