"""Which of the two body Jacobians of lecture 003 is right, and when is an arm singular? (lecture 003)

The example of "Velocities and Jacobian, and Singularities" (EECS C106A, section 5) has three joints, given by their axes at
θ = 0. The lecture prints its body Jacobian twice, differently; its own check tells which one holds (docs/errata.md, E003-1).
Then its three tests for a singularity, on arms that fit what the lecture says of them (the figures did not survive).

Law: J_body = Ad(g⁻¹) J_spatial, and J̄ = [[I, -p^], [0, I]] J_spatial; both factors are invertible, so all three Jacobians
have one rank.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

L1, L2 = 0.7, 0.4  # the lecture leaves them symbols
axes = [
    ks.screw_axis((0, 0, 1), (0, 0, 0)),  # direction, a point on it
    ks.screw_axis((0, -1, 0), (L1, 0, 0)),
    ks.screw_axis((1, 0, 0), (0, 0, -L2)),
]
home = np.array([[0, 0, 1, L1], [0, 1, 0, 0], [-1, 0, 0, -L2], [0, 0, 0, 1.0]])
arm = ks.from_screws(axes, home, order="linear-angular")
zero = np.zeros(3)
spatial = ks.jacobian(arm, zero, frame=ks.Frame.spatial())
body = ks.jacobian(arm, zero, frame=ks.Frame.body())
np.testing.assert_array_equal(spatial.array, np.transpose(axes))  # at θ = 0 the columns are the screws themselves

first = [[0, 0, 0], [L1, 0, 0], [0, L2, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]
second = [[0, -L2, 0], [0, 0, 0], [-L1, 0, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]
by_check = ks.adjoint(np.linalg.inv(home)) @ spatial.array
print(f"{'':6s}{'J_spatial':>18s}{'J_body':>18s}{'1st print':>18s}{'2nd print':>18s}")
for k, name in enumerate(spatial.rows):
    cells = [" ".join(f"{x:z5.1f}" for x in rows[k]) for rows in (spatial.array, body.array, first, second)]
    print(f"{name:6s}" + "".join(f"{cell:>18s}" for cell in cells))
for name, printed in (("first", first), ("second", second)):
    print(f"Ad(g⁻¹) J_spatial minus the {name} print: at most {np.abs(by_check - printed).max():.1f}")
np.testing.assert_allclose(body.array, by_check, atol=1e-15)
np.testing.assert_allclose(body.array, first, atol=1e-15)
points = np.array([[0, 0, -L1], [-L2, 0, 0], [0, 0, 0]])  # the lecture's q†, and its ω†
print("the second print has q† where -ω† × q† belongs:", np.array_equal(np.array(second)[:3], points.T))
np.testing.assert_allclose(-np.cross(body.angular.T, points), body.linear.T, atol=1e-15)

bar = ks.jacobian(arm, [0.2, 0.3, 0.4])  # the default: velocity of the tip, base axes
moved = bar.change_frame(ks.Frame.spatial())
x, y, z = ks.pose(arm, [0.2, 0.3, 0.4]).translation
hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
np.testing.assert_allclose(bar.linear, moved.linear - hat @ moved.angular, atol=1e-15)
ranks = [np.linalg.matrix_rank(J.array) for J in (bar, moved, bar.change_frame(ks.Frame.body()))]
print(f"ranks of J̄, J_spatial, J_body at (0.2, 0.3, 0.4): {', '.join(map(str, ranks))}\n")
assert ranks == [3, 3, 3]

# Six joints, elbow stretched along y, wrist axes through one point: MLS's elbow manipulator.
shoulder, elbow, wrist = (0, 0, 0.3), (0, 0.5, 0.3), (0, 0.9, 0.3)
lines = [((0, 0, 1), shoulder), ((-1, 0, 0), shoulder), ((-1, 0, 0), elbow)]
lines += [((0, 0, 1), wrist), ((-1, 0, 0), wrist), ((0, 1, 0), wrist)]
at_wrist = np.eye(4)
at_wrist[:3, 3] = wrist
six = ks.from_screws([ks.screw_axis(*line) for line in lines], at_wrist, order="linear-angular", name="elbow arm")
planar = ks.load("planar_2r")


def shared_axes(model, q):
    """Pairs of joints whose axes lie on one line: equal or opposite columns of the spatial Jacobian."""
    columns = ks.jacobian(model, q, frame=ks.Frame.spatial()).array.T
    pairs = [(i, j) for j in range(len(columns)) for i in range(j)]
    same = [min(np.abs(columns[i] - s * columns[j]).max() for s in (1, -1)) < 1e-9 for i, j in pairs]
    return [f"{i + 1} and {j + 1}" for (i, j), one in zip(pairs, same, strict=True) if one]


print(f"{'arm, posture':38s}{'rank':>8s}{'vy lost':>9s}   {'axes on one line':18s}{'singular'}")
cases = (
    ("elbow arm, zero", six, np.zeros(6), "full"),
    ("elbow arm, general", six, np.array([0.2, 0.5, 0.8, 0.3, 0.6, 0.1]), "full"),
    ("elbow arm, θ2 = π/2", six, np.array([0, np.pi / 2, 0, 0, 0, 0]), "full"),
    ("two joints along y, as 2 freedoms", planar, np.array([np.pi / 2, 0]), "full"),
    ("two joints along y, in x and y", planar, np.array([np.pi / 2, 0]), "position"),
    ("ur5e, elbow straight", ks.load("ur5e"), np.array([0.2, -0.9, 0, 0.5, 0.8, 0.1]), "full"),
)
for name, model, q, task in cases:
    here = ks.analyze(model, q, task=task)
    lost = bool(np.linalg.norm(here.jacobian.linear[1]) < 1e-9)
    together = ", ".join(shared_axes(model, q)) or "none"
    rank = f"{here.rank} of {here.task.rank}"
    print(f"{name:38s}{rank:>8s}{'yes' if lost else 'no':>9s}   {together:18s}{'yes' if here.is_singular else 'no'}")
    assert here.is_singular == (name not in ("elbow arm, general", "two joints along y, as 2 freedoms"))
print("Axes on one line suffice, a lost direction does where the arm has 6 freedoms; neither is needed (E003-7).")

if len(sys.argv) > 1:  # a folder for the picture
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    axes = ks.plots.arm(six, np.zeros(6))
    axes.figure.savefig(Path(sys.argv[1]) / "lecture_003.png")
