"""How long should the links be?

One metre of arm is to be shared between upper arm and forearm. Each share is one arm, measured in the same 20 000 random
postures: by Yoshikawa's manipulability w, and by the inverse condition number 1/κ, which is 1 where the arm is equally fast
in all directions. First an arm in the plane, then one in space, with a third joint that turns the whole arm about the
vertical. The two measures do not choose the same arm: w asks for much motion, 1/κ for even motion.

Law: in the plane w = a1 a2 |sin θ2|, whose mean over all postures, (2/π) a1 a2, is largest for equal links; in space the
mean is 2/(3π²) ((a1 + a2)³ - |a1 - a2|³), largest for equal links too, but hardly less for others. A posture with 1/κ = 1
exists for a1 = √2 a2 only: the elbow bent by 135° and, in space, the hand level with the shoulder.

    python examples/16_how_long_should_the_links_be.py [folder]        the picture needs matplotlib
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

TOTAL, POSTURES = 1.0, 20_000
EVEN = np.sqrt(2) / (1 + np.sqrt(2))  # the share of the upper arm with which a1 = √2 a2
shares = np.linspace(0.1, 0.9, 17)
q = np.random.default_rng(13).uniform(-np.pi, np.pi, (POSTURES, 3))


def planar(share):
    """Two parallel joints."""
    return ks.from_dh([(share * TOTAL, 0, 0, 0), ((1 - share) * TOTAL, 0, 0, 0)], convention="standard")


def spatial(share):
    """The same arm standing upright on a waist."""
    rows = [(0, np.pi / 2, 0, 0), (share * TOTAL, 0, 0, 0), ((1 - share) * TOTAL, 0, 0, 0)]
    return ks.from_dh(rows, convention="standard")


def measured(make, share):
    """Mean of w, and mean and best of 1/κ over the postures: one batch through the kernels."""
    ev = ks.Evaluator(make(share))
    sigma = ev.singular_values(q[:, -ev.model.n :])
    even = sigma[:, -1] / sigma[:, 0]
    return sigma.prod(axis=-1).mean(), even.mean(), even.max()


def best_share(make, column):
    """The best share by one of the measures: golden sections of the interval, in the same postures all the time."""
    low, high, golden = 0.3, 0.8, (np.sqrt(5) - 1) / 2
    for _ in range(16):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if measured(make, left)[column] > measured(make, right)[column]:
            high = right
        else:
            low = left
    return (low + high) / 2


def mean_in_the_plane(a1, a2):
    return 2 / np.pi * a1 * a2


def mean_in_space(a1, a2):
    return 2 / (3 * np.pi**2) * ((a1 + a2) ** 3 - np.abs(a1 - a2) ** 3)


found = {}
for name, make, formula in (("the plane", planar, mean_in_the_plane), ("space", spatial, mean_in_space)):
    table = np.array([measured(make, share) for share in shares])
    found[name] = table
    exact = formula(shares * TOTAL, (1 - shares) * TOTAL)
    print(f"an arm in {name}, upper arm and forearm of {TOTAL:g} m together, {POSTURES} postures")
    print(f"{'upper arm':>11s}{'mean w':>10s}{'formula':>10s}{'mean 1/κ':>11s}{'best 1/κ':>11s}")
    for share, (w, even, best), law in list(zip(shares, table, exact, strict=True))[::2]:
        print(f"{share:9.2f} m{w:10.4f}{law:10.4f}{even:11.4f}{best:11.4f}  {'#' * round(60 * even)}")
    np.testing.assert_allclose(table[:, 0], exact, rtol=0.02)
    by_w, by_even = best_share(make, 0), best_share(make, 1)
    print(f"best upper arm by the mean of w {by_w:.3f} m, by the mean of 1/κ {by_even:.3f} m\n")
    assert abs(by_w - 0.5) < 0.05
    assert 0.55 < by_even < 0.62

isotropic = ks.jacobian(spatial(EVEN), [0.3, -np.pi / 4, 3 * np.pi / 4])
ball = ks.velocity_ellipsoid(isotropic)
print(f"with an upper arm of {EVEN:.4f} m and the elbow at 135°: condition {ks.condition_number(isotropic):.6f},")
print(f"and the velocity ellipsoid is a ball of radius {ball.radii[0]:.4f} m/s, the forearm's length")
np.testing.assert_allclose(ball.radii, (1 - EVEN) * TOTAL, rtol=1e-12)
assert found["the plane"][:, 2].argmax() == np.abs(shares - EVEN).argmin()

if len(sys.argv) > 1:  # a folder for the picture
    try:
        import matplotlib as mpl
    except ImportError:
        sys.exit("matplotlib is not installed: pip install 'kinestatics[plot]'")
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    for ax, (name, table) in zip(axes, found.items(), strict=True):
        ax.plot(shares, table[:, 0] / table[:, 0].max(), label="mean w, of its largest")
        ax.plot(shares, table[:, 1], label="mean 1/κ")
        ax.plot(shares, table[:, 2], label="best 1/κ")
        ax.axvline(EVEN, color="gray", linestyle=":")
        ax.set(title=f"in {name}", xlabel="upper arm [m] of 1 m", ylim=(0, 1.05))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize="small")
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    figure.savefig(Path(sys.argv[1]) / "link_lengths.png", dpi=150)
