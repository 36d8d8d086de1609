"""Which joint rates make the gripper move as I want, and what if none do? (lab of lecture 000)

The velocity lab that goes with the lecture, on its Lynxmotion AL5D of five joints and on a Panda of seven. Forward: the
velocity of the tip and of every joint between. Inverse: a component of the twist that may be anything is NaN; where no
rates make the twist, the result is the closest by least squares (metres and radians alike), with the residual and the
reason; where many do, it is the smallest. Then both arms follow a circle by resolved rates.

Law: forward ξ = J q̇; inverse q̇ = J⁺ ξ, and all others are q̇ + (I - J⁺J) b. Solvable where rank J = rank [J | ξ].
"""

import sys
from pathlib import Path

import numpy as np

import kinestatics as ks

half = np.pi / 2
lynx = ks.from_dh(  # lengths and limits as in published solutions of the lab; ks.load("al5d") is one measured by others
    [(0, -half, 0.0762, 0), (0.14605, 0, 0, -half), (0.187325, 0, 0, half), (0, -half, 0, -half), (0, 0, 0.0762, 0)],
    convention="standard",
    name="lynx",
    joint_names=["base", "shoulder", "elbow", "wrist", "roll"],
    limits=[(-1.4, 1.4), (-1.2, 1.4), (-1.8, 1.7), (-1.9, 1.7), (-2.0, 1.5)],
)
panda = ks.load("panda")
free = float("nan")  # a component that may be anything
q = np.array([0.3, 0.2, -0.3, 0.4, 0.1])

rates = np.array([0.5, 0.0, 0.4, 0.0, 0.0])
print("forward, Lynx, base at 0.5 and elbow at 0.4 rad/s: how each joint's frame moves")
print(f"{'frame':10s}{'v [m/s]':>26s}{'omega [rad/s]':>26s}")
for link in lynx.link_names[1:]:
    twist = ks.jacobian(lynx, q, at=link) @ rates
    print(f"{link:10s}" + "".join(f"{' '.join(f'{x:z7.3f}' for x in part):>26s}" for part in (twist.linear, twist.angular)))
    ahead, behind = (ks.pose(lynx, q + s * 1e-6 * rates, at=link).translation for s in (1, -1))
    np.testing.assert_allclose(twist.linear, (ahead - behind) / 2e-6, atol=1e-9)

print("\ninverse, v in m/s and omega in rad/s, * = free")
print(f"{'arm':7s}{'v':>10s}{'omega':>10s}{'|q̇| [rad/s]':>14s}{'residual':>11s}{'rank J':>9s}{'rank [J|ξ]':>12s}")
hand = panda.home
for arm, posture, v, omega in (
    (lynx, q, (0.1, 0, 0), (free, free, free)),
    (lynx, q, (0.1, free, free), (free, free, 0.5)),
    (lynx, q, (0.1, 0, 0), (0, 0, 0.5)),
    (lynx, 0 * q, (0, 0.1, 0), (0.2, 0, 0)),
    (panda, hand, (0.1, 0, 0), (0, 0, 0.5)),
    (panda, hand, (0.1, 0, 0), (0, 0, free)),
    (panda, hand, (free, free, free), (free, free, free)),
):
    J = ks.jacobian(arm, posture)
    found = ks.joint_rates(J, ks.Twist.of(linear=v, angular=omega))
    shown = [" ".join("*" if np.isnan(x) else f"{x:g}" for x in part) for part in (v, omega)]
    size = np.linalg.norm(found.residual.array)
    ranks = f"{found.rank:9d}{found.rank_augmented:12d}"
    print(f"{arm.name[:5]:7s}{shown[0]:>10s}{shown[1]:>10s}{np.linalg.norm(found.array):14.3f}{size:11.4f}{ranks}")
    asked = ~np.isnan(np.r_[v, omega])
    wanted, rows = np.r_[v, omega][asked], J.array[asked]
    np.testing.assert_allclose(found.array, np.linalg.pinv(rows, rcond=1e-9) @ wanted, atol=1e-12)
    assert found.reachable == (size < 1e-9)
print("\nthe fourth of them in full, the arm in its zero posture:")
print(ks.joint_rates(ks.jacobian(lynx, 0 * q), ks.Twist.of(linear=(0, 0.1, 0), angular=(0.2, 0, 0))))

J = ks.jacobian(panda, hand)
found = ks.joint_rates(J, ks.Twist.of(linear=(0.1, 0, 0)))
other = found.member([0, 0, 1, 0, 0, 0, 0])
sizes = [np.linalg.norm(x) for x in (found.array, other)]
print(f"\nPanda, the same twist with the elbow swung by null motion: |q̇| {sizes[1]:.3f} instead of {sizes[0]:.3f} rad/s")
np.testing.assert_allclose((J @ other).array, found.achieved.array, atol=1e-14)
assert sizes[1] > sizes[0]


def follow(arm, q, omega, radius=0.05, seconds=4.0, dt=0.01, gain=20.0):
    """Resolved rates around a circle in the y-z plane: errors of position [m] and turning of the tip [rad], each period."""
    start = ks.pose(arm, q)
    errors, turned = [], []
    for t in np.arange(0.0, seconds, dt):
        here = ks.pose(arm, q)
        phase = 2 * np.pi * t / seconds
        wanted = start.translation + radius * np.array([0, np.sin(phase), np.cos(phase) - 1])
        speed = 2 * np.pi * radius / seconds * np.array([0, np.cos(phase), -np.sin(phase)])
        off = wanted - here.translation
        tilt = 0.5 * np.cross(here.rotation.T, start.rotation.T).sum(axis=0)  # axis times sine of the angle to turn back
        errors.append(np.linalg.norm(off))
        turned.append(np.arcsin(np.linalg.norm(tilt)))
        twist = ks.Twist.of(linear=speed + gain * off, angular=gain * tilt + omega)
        q = q + dt * ks.joint_rates(ks.jacobian(arm, q), twist).array
        assert np.all((arm.lower <= q) & (q <= arm.upper))
    return np.array(errors), np.array(turned), q


print("\na circle of 50 mm radius in 4 s, resolved rates at 100 Hz")
print(f"{'arm, what is asked':40s}{'RMS [mm]':>10s}{'largest [mm]':>14s}{'tip turned by [rad]':>21s}")
ends = {}
for name, arm, begin, omega in (
    ("Lynx, position", lynx, q, (free, free, free)),
    ("Lynx, position and orientation", lynx, q, (0, 0, 0)),
    ("Panda, position and orientation", panda, hand, (0, 0, 0)),
    ("Panda, position, turning about z free", panda, hand, (0, 0, free)),
):
    errors, turned, ends[name] = follow(arm, begin, omega)
    print(f"{name:40s}{1e3 * np.sqrt(np.mean(errors**2)):10.3f}{1e3 * errors.max():14.3f}{turned.max():21.4f}")
    assert (errors.max() < 1e-3) == (name != "Lynx, position and orientation")
print("Five joints cannot keep six numbers: there the arm does the best of both, and neither is kept.")

if len(sys.argv) > 1:  # a folder for the picture
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    for arm, name in ((lynx, "Lynx, position"), (panda, "Panda, position and orientation")):
        ks.plots.arm(arm, ends[name]).figure.savefig(Path(sys.argv[1]) / f"lab_{arm.name}.png")
