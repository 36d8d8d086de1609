"""How does a wrench look from another frame, and what is in a column of the Jacobian? (lecture 002)

"Lesson 13" after Murray, Li, Sastry (MLS 2.5 and 3.4): power, equivalent wrenches, and the two manipulator Jacobians from a
product of exponentials. The formula the lesson ends with, for the body Jacobian, is not right (docs/errata.md, E002-1);
here both formulas run beside the velocity itself.

Law: power is the same in every frame, F_c · V_c = F_b · V_b; hence V_b = Ad(g_bc) V_c and F_c = Ad(g_bc)ᵀ F_b.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

twist = ks.Twist.of(linear=(-1, 0, 0), angular=(0, 0, 1))  # the warm-up: V = (-1, 0, 0, 0, 0, 1)
print("warm-up, power of a wrench on a body with V = (-1, 0, 0, 0, 0, 1)")
for words, force, torque, expected in (
    ("force along y", (0, 1, 0), (0, 0, 0), 0),  # the wrench of the slide did not survive; its answer, 0, did
    ("force along x", (1, 0, 0), (0, 0, 0), -1),
    ("moment about z", (0, 0, 0), (0, 0, 1), 1),
    ("both of these", (1, 0, 0), (0, 0, 1), 0),
):
    watts = ks.power(ks.Wrench.on_robot(force, torque), twist)
    print(f"  {words:16s}{watts:z5.1f} W")
    assert watts == expected

T_b_c = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1.0]])  # frame c seen from b; numbers of our own
F_b = ks.Wrench.on_robot(force=(1, 0, 0), torque=(0, 0, 1), frame=ks.Frame.body("b"))
F_c = F_b.change_frame(ks.Frame.body("c"), T_b_c)
V_c = ks.Twist.of(linear=(0.2, -0.1, 0.4), angular=(0.3, 0.5, -0.2), frame=ks.Frame.body("c"))
V_b = V_c.change_frame(ks.Frame.body("b"), np.linalg.inv(T_b_c))
print(f"\nF_b  {F_b}\nF_c  {F_c}")
print(f"F_b · V_b = {ks.power(F_b, V_b):.4f} W, F_c · V_c = {ks.power(F_c, V_c):.4f} W")
np.testing.assert_allclose(F_c.array, ks.adjoint(T_b_c).T @ F_b.array, atol=1e-15)
np.testing.assert_allclose(F_c.array, [0, -1, 0, -3, 0, 3], atol=1e-15)
np.testing.assert_allclose(ks.power(F_b, V_b), ks.power(F_c, V_c), atol=1e-15)

arm = ks.load("ur5e")
q = np.array([0.4, -1.2, 1.5, -0.8, -1.3, 0.6])
held = ks.Wrench.on_robot(force=(0, 0, -20), torque=(0.5, 0, 0))  # base axes, at the tip
spatial, body = (ks.change_frame(arm, q, held, frame) for frame in (ks.Frame.spatial(), ks.Frame.body()))
g = ks.pose(arm, q).array
np.testing.assert_allclose(body.array, ks.adjoint(g).T @ spatial.array, atol=1e-13)  # F^b = Ad(g)ᵀ F^s
torques = [ks.joint_torques(ks.jacobian(arm, q, frame=w.frame), w) for w in (held, spatial, body)]
print("\nmotors that hold one wrench, written at the tip, as spatial and as body wrench [N m]")
for words, row in zip(("geometric", "spatial", "body"), torques, strict=True):
    print(f"  {words:10s}" + "".join(f"{x:z9.3f}" for x in row))
    np.testing.assert_allclose(row, torques[0], atol=1e-13)

# Columns: e¹ … eⁱ is the motion of link i away from where it is at zero.
links = arm.link_names[1:7]
motion = [np.eye(4)]
for link in links:
    motion.append(ks.pose(arm, q, at=link).array @ np.linalg.inv(ks.pose(arm, 0 * q, at=link).array))
screws = ks.jacobian(arm, 0 * q, frame=ks.Frame.spatial()).array.T  # ξ_i: the axes at zero
xi_spatial = np.array([ks.adjoint(motion[i]) @ screws[i] for i in range(6)]).T
xi_body = np.array([ks.adjoint(np.linalg.inv(g) @ motion[i]) @ screws[i] for i in range(6)]).T
xi_printed = np.array([ks.adjoint(np.linalg.inv(motion[i])) @ screws[i] for i in range(6)]).T
J_spatial, J_body = (ks.jacobian(arm, q, frame=frame).array for frame in (ks.Frame.spatial(), ks.Frame.body()))
step = 1e-6 * np.eye(6)
slopes = [np.linalg.inv(g) @ (ks.pose(arm, q + e).array - ks.pose(arm, q - e).array) / 2e-6 for e in step]
measured = np.array([[*V[:3, 3], V[2, 1], V[0, 2], V[1, 0]] for V in slopes]).T  # (g⁻¹ ∂g/∂θ_i)ᵛ

print("\nlargest error of each column against the velocity itself, (∂g/∂θ_i g⁻¹)ᵛ or (g⁻¹ ∂g/∂θ_i)ᵛ")
print(f"{'column':>8s}{'Ad(e¹…eⁱ⁻¹) ξ, spatial':>26s}{'Ad⁻¹(eⁱ…eⁿ g(0)) ξ, body':>28s}{'Ad⁻¹(e¹…eⁱ⁻¹) ξ, printed':>28s}")
rows = zip(
    np.abs(xi_spatial - ks.adjoint(g) @ measured).max(0),
    np.abs(xi_body - measured).max(0),
    np.abs(xi_printed - measured).max(0),
    strict=True,
)
for i, (first, second, third) in enumerate(rows, start=1):
    print(f"{i:8d}{first:26.0e}{second:28.0e}{third:28.2f}")
np.testing.assert_allclose(J_spatial, xi_spatial, atol=1e-14)
np.testing.assert_allclose(J_body, xi_body, atol=1e-14)
np.testing.assert_allclose(J_body, measured, atol=1e-8)
assert np.abs(xi_printed - J_body).max() > 0.5
turned = ks.jacobian(arm, [*q[:5], q[5] + 1.0], frame=ks.Frame.spatial()).array
np.testing.assert_allclose(turned, J_spatial, atol=1e-15)  # the spatial Jacobian never depends on the last angle

if len(sys.argv) > 1:  # a folder for the picture
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    axes = ks.plots.load(arm, q, held)
    axes.figure.savefig(Path(sys.argv[1]) / "lecture_002.png")
