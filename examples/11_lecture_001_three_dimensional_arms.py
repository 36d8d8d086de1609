"""How does an arm in three dimensions move, and what does it hold? (lecture 001)

The RRP arm of "Kinematics using the Jacobian, part 2": its Jacobian built column by column as the lecture builds it, the two
velocity questions, and the weight of 10 kg. The lecture leaves the second question open and gives the torque of the last
the wrong sign (docs/errata.md, E001-3); both answers are here. Its "-π/2 degrees" are radians (E001-2).

Law: a revolute joint moves the tip by z × (o_n - o) and turns it about z; a prismatic one moves it along z and turns
nothing. What holds a weight is the gradient of its energy, -Jᵀ F for the force F of the weight.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

arm = ks.load("rrp_note_001")  # rows (a, alpha, d) = (0, -π/2, 3), (0, -π/2, 0), (0, 0, q3)
q = np.array([0.0, -np.pi / 2, 2.0])


def by_hand(q):
    """The lecture's columns: z and o of the frame before each joint, from the pose of the link before it."""
    tip, columns = ks.pose(arm, q).translation, []
    for link, kind in zip(("base", "link1", "link2"), "RRP", strict=True):
        before = ks.pose(arm, q, at=link)
        z, o = before.rotation[:, 2], before.translation
        columns.append([*np.cross(z, tip - o), *z] if kind == "R" else [*z, 0.0, 0.0, 0.0])
    return np.array(columns).T


J = ks.jacobian(arm, q)
print(J, "\n")
for posture in (q, [0.3, 0.8, 1.5], arm.home):
    np.testing.assert_allclose(ks.jacobian(arm, posture).array, by_hand(posture), atol=1e-15)

print(f"{'posture (q1, q2, q3)':24s}{'rates':16s}{'v [m/s]':>16s}{'omega [rad/s]':>18s}")
for posture, rates, v, omega in (
    ([0, -np.pi / 2, 5], [2, 1, 0], None, [0, 1, 2]),  # the lecture asks for ω and gives it
    ([0, -np.pi / 2, 2], [2, -1, 0], [0, 4, 2], None),  # it asks for v and leaves the answer to you
):
    twist = ks.jacobian(arm, posture) @ rates
    shown = [" ".join(f"{x:z.0f}" for x in half) for half in (twist.linear, twist.angular)]
    print(f"{'(0, -π/2, ' + str(posture[2]) + ' m)':24s}{rates!s:16s}{shown[0]:>16s}{shown[1]:>18s}")
    for found, right in ((twist.linear, v), (twist.angular, omega)):
        np.testing.assert_allclose(found, found if right is None else right, atol=1e-14)

weight = ks.Wrench.on_robot(force=(0, 0, -100))  # the lecture's 10 kg, at g = 10 m/s²
hold = ks.joint_torques(J, weight)
product = J.linear.T @ weight.force
exact = ks.joint_torques(J, ks.Wrench.on_robot(force=(0, 0, -10 * 9.81)))
print(f"\n{'10 kg at the tip':18s}{'JᵀF, by the weight':>20s}{'motors, 100 N':>16s}{'motors, 98.1 N':>16s}")
for name, unit, *row in zip(arm.joint_names, ("N m", "N m", "N"), product, hold, exact, strict=True):
    print(f"{name:18s}" + "".join(f"{x:z{width}.1f} {unit:3s}" for x, width in zip(row, (16, 12, 12), strict=True)))
np.testing.assert_allclose(hold, [0, -200, 0], atol=1e-13)  # not +200: a positive q2 lowers the tip here
np.testing.assert_allclose(product, -hold, atol=1e-13)

step = 1e-6 * np.eye(3)
heights = [[ks.pose(arm, q + sign * e).translation[2] for e in step] for sign in (1, -1)]
slope = 100 * (np.array(heights[0]) - heights[1]) / 2e-6
print("energy of the 100 N by each joint:", " ".join(f"{x:z.1f}" for x in slope), "(what the motors supply)")
np.testing.assert_allclose(slope, hold, atol=1e-6)

print(f"\n{'q2':>8s}{'det J_v = q3² sin q2':>24s}{'manipulability':>18s}")
for q2 in (-np.pi / 2, -1.0, -0.5, -0.1, 0.0):
    rows = ks.jacobian(arm, [0.0, q2, 2.0]).linear
    print(f"{q2:8.3f}{np.linalg.det(rows):z24.4f}{ks.manipulability(rows):18.4f}")
    np.testing.assert_allclose(np.linalg.det(rows), 4 * np.sin(q2), atol=1e-14)

if len(sys.argv) > 1:  # a folder for the picture
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    axes = ks.plots.load(arm, q, weight)
    axes.figure.savefig(Path(sys.argv[1]) / "lecture_001.png")
