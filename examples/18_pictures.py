"""How do I draw an arm, what it can do and what it must hold?

One call, one picture, at true scale and ready for a paper: the arm at a posture, the ellipsoids and polytopes of its tip,
the directions it has lost, the loads and the torques that hold them, a measure along a motion, or a posture on one page. A
velocity ellipsoid has the singular values for radii, the force ellipsoid their reciprocals along the same axes; where a
posture is singular the one is flat and the other has no end, and the picture shows it. Name a folder on the command line to
have the pictures there.

Law: what is drawn is what was computed. Every point of the two ellipses, less the tip and divided by the stated scale, is a
velocity of joint speeds |q̇| = 1, or a force of torques |τ| = 1.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else None


def keep(name, picture):
    """Writes a picture if a folder was named, and says what it shows."""
    figure = getattr(picture, "figure", picture)
    if FOLDER:
        FOLDER.mkdir(parents=True, exist_ok=True)
        figure.savefig(FOLDER / f"{name}.png", dpi=200)
    legend = None if figure is picture else picture.get_legend()
    lines = [text.get_text().replace("\n", " ").partition(", $")[0] for text in legend.get_texts()] if legend else []
    words = "; ".join(lines)
    print(f"{name:18s}{figure.get_figwidth():.2f} x {figure.get_figheight():.2f} in  {words}")


planar, ur5e, panda = ks.load("planar_2r"), ks.load("ur5e"), ks.load("panda")
bent, straight = [0.4, 0.9], [0.4, 0.0]

keep("arm", ks.plots.arm(ur5e, labels=True))  # in space: cylinders turn, boxes slide
keep("arm_in_a_plane", ks.plots.arm(planar, bent, labels=["$q_1$", "$q_2$"]))  # an arm that moves in a plane is drawn in it

both = ks.plots.velocity_ellipsoid(planar, bent, scale=0.5)
ks.plots.force_ellipsoid(planar, bent, scale=0.2, ax=both, with_arm=False)  # onto the same axes
keep("ellipses", both)
keep("ellipsoid", ks.plots.velocity_ellipsoid(panda))
keep("held_without_end", ks.plots.force_ellipsoid(planar, straight))  # along a straight arm no motor feels a force
keep("lost_and_free", ks.plots.lost_and_free(planar, straight))
keep("velocity_polytope", ks.plots.velocity_polytope(ur5e))
keep("force_polytope", ks.plots.force_polytope(ur5e))

load = ks.Wrench.on_robot(force=(0, 0, -50))
keep("load", ks.plots.load(ur5e, None, load))
bars = ks.plots.torque_bars(ur5e, None, load)
keep("torques", bars)

motion = np.linspace([0.4, 2.2], [0.1, -0.5], 40)  # a motion that straightens the elbow and bends it the other way
along = ks.plots.measure_along(planar, motion, times=np.linspace(0.0, 2.0, 40))
keep("measure_along", along)
keep("page", ks.plots.analysis(ks.analyze(ur5e, ur5e.home, load)))

J, tip = ks.jacobian(planar, bent).array[:2], ks.pose(planar, bent).translation[:2]
curves = [line.get_xydata() for line in both.lines if len(line.get_xydata()) > 50]
velocities, forces = (curves[0] - tip) / 0.5, (curves[1] - tip) / 0.2
speeds = np.linalg.norm(velocities @ np.linalg.inv(J).T, axis=1)  # |q̇| of every velocity drawn
torques = np.linalg.norm(forces @ J, axis=1)  # |τ| of every force drawn
print(f"\nalong the ellipses |q̇| is 1 to {np.abs(speeds - 1).max():.0e} and |τ| to {np.abs(torques - 1).max():.0e}")
np.testing.assert_allclose(speeds, 1, atol=1e-12)
np.testing.assert_allclose(torques, 1, atol=1e-12)

reach = np.linalg.norm(velocities, axis=1).max(), np.linalg.norm(forces, axis=1).min()
print(f"longest velocity {reach[0]:.4f} m/s, shortest force {reach[1]:.4f} N: their product is 1")
assert abs(reach[0] * reach[1] - 1) < 1e-2  # the curves are drawn through points that miss the very ends a little

drawn = sum(np.array([bar.get_width() for bar in part]) for part in bars.containers)
np.testing.assert_allclose(drawn, ks.analyze(ur5e, ur5e.home, load).holding_torques, atol=1e-12)

curve, least = along.lines[0].get_ydata(), along.lines[1].get_ydata()[0]
np.testing.assert_allclose(curve, ks.manipulability(ks.jacobian(planar, motion)), atol=1e-12)
assert least == curve.min()
