"""How dexterous is an arm over its whole workspace?

One call computes one configuration or a batch; an `Evaluator` keeps the target, the frame and the rows in play, and takes
and returns bare arrays: `out=` writes into memory you own, `threads=` splits the batch. Here it maps the manipulability of
a planar arm over the distance from its base, where the answer is known, and of a UR5e, where it is not.

Law: for the planar 2R arm w = l1 l2 |sin q2| at every q1, and with r² = l1² + l2² + 2 l1 l2 cos q2 it is largest at r = √2
for links of 1 m. The bits do not depend on the size of the batch or on the number of threads.
"""

import time

import numpy as np

import kinestatics as ks

rng = np.random.default_rng(0)
planar = ks.Evaluator(ks.load("planar_2r"))
q = rng.uniform(-np.pi, np.pi, (200_000, 2))
w = planar.manipulability(q)
np.testing.assert_allclose(w, np.abs(np.sin(q[:, 1])), atol=1e-14)
radius = np.linalg.norm(planar.pose(q)[:, :2, 3], axis=1)
print("planar 2R: manipulability by distance from the base")
edges = np.linspace(0, 2, 11)
ring = np.clip(np.digitize(radius, edges) - 1, 0, 9)
means = np.array([w[ring == k].mean() for k in range(10)])
for k in range(10):
    print(f"  {edges[k]:.1f} to {edges[k + 1]:.1f} m  {means[k]:.3f}  {'#' * round(40 * means[k])}")
assert edges[np.argmax(means)] <= np.sqrt(2) <= edges[np.argmax(means) + 1]

arm = ks.load("ur5e")
ev = ks.Evaluator(arm)
q = rng.uniform(-np.pi, np.pi, (500_000, 6))
J, w = np.empty((len(q), 6, 6)), np.empty(len(q))


def timed(name, compute):
    """The result and the shortest of three runs, in nanoseconds a configuration."""
    best = np.inf
    for _ in range(3):
        began = time.perf_counter()
        result = compute()
        best = min(best, time.perf_counter() - began)
    print(f"  {name:32s}{1e9 * best / len(q):8.0f} ns each, {best:.3f} s in all")
    return result


print(f"\nUR5e, {len(q)} configurations ({ks.kernels.instruction_set()}):")
timed("jacobian, out=", lambda: ev.jacobian(q, out=J))
timed("manipulability, out=", lambda: ev.manipulability(q, out=w))
two = timed("manipulability, threads=2", lambda: ev.manipulability(q, threads=2))
assert np.array_equal(two, w)
assert np.array_equal(J[12345], ev.jacobian(q[12345]))
np.testing.assert_allclose(w[:1000], np.abs(np.linalg.det(J[:1000])), atol=1e-12)

tip = ev.pose(q)[:, :3, 3]
reach = np.linalg.norm(tip - [0, 0, 0.1625], axis=1)  # from the shoulder
print("\nUR5e: best manipulability found at each distance from the shoulder")
for low in np.arange(0, 1.0, 0.1):
    here = w[(reach >= low) & (reach < low + 0.1)]
    print(f"  {low:.1f} to {low + 0.1:.1f} m  {here.max():.4f}  {'#' * round(400 * here.max())}")
