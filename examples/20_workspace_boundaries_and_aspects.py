"""How far does this arm reach, which regions do its singular postures separate, and how near does a motion come to them?

The tip's places by distance from axis 1 and height along it are a cross-section of the workspace. Where it ends, the arm is
singular (a barrier: bending it moves the tip back) or at a joint limit; inside lie places of singular postures that it
can cross. In joint space singular postures separate aspects: between two of one aspect there is a motion that is never
singular, between two aspects there is none. Name a folder on the command line to have the pictures there.

Law: at a place where the workspace ends, with outward normal u, every joint has u · dw/dq_j = 0, or is at a limit and
u · dw/dq_j leads beyond it.
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else None


def keep(name, picture):
    """Writes a picture if a folder was named."""
    if FOLDER:
        FOLDER.mkdir(parents=True, exist_ok=True)
        picture.figure.savefig(FOLDER / f"{name}.png", dpi=200)


puma = ks.load("puma_560")
section = ks.singularities(puma, "position").workspace_section(cells=32, image=100)
print(section)
keep("workspace", ks.plots.workspace_section(section))

q = puma.random_configurations(100_000, seed=1)
p = ks.pose(puma, q).translation
places = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2] - section.origin[2]], axis=-1)  # axis 1 is z of base
np.testing.assert_allclose(places, section.place(q), atol=1e-12)
share = section.covers(places).mean()
print(f"\n{100 * share:.2f} % of 100,000 random postures are inside; the others miss by less than the tolerance")
assert share > 0.99
assert not section.covers([[0.5, -2.0], [0.1, 0.0]]).any()  # below, and within the shoulder's offset from axis 1

(outline,) = section.outlines
singular = outline.postures[np.array(outline.kinds) == "barrier"]
sigma = np.linalg.svd(ks.jacobian(puma, singular).linear, compute_uv=False)
print(f"least singular value at the {len(singular)} places that are barriers: {sigma[:, -1].max():.0e} m at most")
assert sigma[:, -1].max() < 1e-6

found = ks.singularities(puma)
turning, limited = found.aspects(300), found.aspects(300, limits=True)
print(f"\n{turning}\n{limited}")
assert turning.count == 8
assert set(limited.signs) == {-1, 1}
assert np.all((limited.representatives >= puma.lower) & (limited.representatives <= puma.upper))
keep("aspects", ks.plots.aspect_regions(found, ["joint2", "joint3"], limits=True))

motion = np.linspace([0.0, 0.5, -1.0, 0.3, 0.6, 0.0], [0.0, 0.2, -0.4, 0.3, -0.2, 0.0], 5)
distances = ks.plots.singular_distances(found, motion, times=np.linspace(0.0, 2.0, 5))
keep("distances", distances)
shoulder, elbow, wrist = (line.get_ydata() for line in distances.lines)
print("\nalong a motion, the distance [deg] from")
for name, degrees in (("shoulder", shoulder), ("elbow", elbow), ("wrist", wrist)):
    print(f"  {name:9s}{' '.join(f'{value:5.1f}' for value in degrees)}")
np.testing.assert_allclose(wrist, np.degrees(np.abs(motion[:, 4])), atol=1e-9)  # the wrist is singular at q5 = 0
