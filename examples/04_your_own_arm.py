"""How do I describe my own arm, in numbers or in symbols?

Three ways in, one model out. A Denavit-Hartenberg table: standard and modified tables look alike, so the convention must be
said. Screws: the axis of each joint at the zero configuration and the pose of the tip there. Or a file. With SymPy symbols
for the lengths and angles, the same functions return formulas.

Law: T(q) = exp(S1 q1) ... exp(Sn qn) M, whichever way the arm was described; and for the planar 2R arm det J = l1 l2 sin q2,
which is zero where the elbow is straight or folded.
"""

import math

import numpy as np

import kinestatics as ks

half = math.pi / 2
standard = [(0.0, half, 0.3, 0.0), (0.5, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0)]  # a, alpha, d, theta of each row
modified = [(0.0, 0.0, 0.3, 0.0), (0.0, half, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0)]  # the same arm: alpha and a come first
tool = np.eye(4)
tool[0, 3] = 0.4  # a modified table ends at the last axis
axes = [
    ks.screw_axis((0, 0, 1)),
    ks.screw_axis((0, -1, 0), point=(0, 0, 0.3)),
    ks.screw_axis((0, -1, 0), point=(0.5, 0, 0.3)),
]
home = np.array([[1, 0, 0, 0.9], [0, 0, -1, 0], [0, 1, 0, 0.3], [0, 0, 0, 1]])

arms = {
    "standard rows": ks.from_dh(standard, convention="standard"),
    "modified rows": ks.from_dh(modified, convention="modified", tool=tool),
    "screws": ks.from_screws(axes, home, order="linear-angular"),
}
q = [0.4, -0.3, 1.1]
for name, arm in arms.items():
    print(f"{name:15s} tip at {np.array2string(ks.pose(arm, q).translation, precision=6)}")
    np.testing.assert_allclose(ks.pose(arm, q).array, ks.pose(arms["screws"], q).array, atol=1e-15)
    np.testing.assert_allclose(ks.jacobian(arm, q).array, ks.jacobian(arms["screws"], q).array, atol=1e-15)

wrong = ks.from_dh(standard, convention="modified")
print(f"{'taken wrongly':15s} tip at {np.array2string(ks.pose(wrong, q).translation, precision=6)}")
assert np.linalg.norm(ks.pose(wrong, q).translation - ks.pose(arms["screws"], q).translation) > 0.1

try:
    import sympy as sp
except ImportError:
    print("\nSymPy is not installed: no formulas (pip install 'kinestatics[symbolic]')")
else:
    q1, q2, l1, l2 = sp.symbols("q1 q2 l1 l2", real=True)
    planar = ks.from_dh([(l1, 0, 0, 0), (l2, 0, 0, 0)], convention="standard")
    J = sp.simplify(sp.Matrix(ks.jacobian(planar, [q1, q2]).linear[:2]))
    determinant = sp.simplify(J.det())
    print("\nplanar 2R, rows vx and vy:")
    sp.pprint(J)
    print("determinant:", determinant)
    assert sp.simplify(determinant - l1 * l2 * sp.sin(q2)) == 0
