"""What is lost in a singular posture, and what is gained?

Where the rank of J falls, some directions of motion are lost, and with each a wrench is gained that the structure holds
without any joint torque. `lost_twists` and `free_wrenches` give both; `analyze` says them in words. Near such a posture
the joints must run fast for a slow tip: the smallest singular value says how fast.

Law: free wrenches span null(Jᵀ): Jᵀ w = 0; and they do no work on any motion the arm can make: w · (J q̇) = 0.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("puma_560")
print("puma 560, wrist bent by q5; the wrist is singular at q5 = 0")
print(f"{'q5 [rad]':>10s}{'rank':>6s}{'smallest singular value':>26s}{'joint rate for 0.1 rad/s':>27s}")
for q5 in (0.5, 0.1, 0.01, 0.001, 0.0):
    q = np.array([0.1, 0.4, -1.0, 0.3, q5, 0.2])
    here = ks.analyze(arm, q)
    axis = np.cross(here.jacobian.angular[:, 3], ks.jacobian(arm, q * [1, 1, 1, 1, 0, 1]).angular[:, 4])  # lost at q5 = 0
    wanted = np.concatenate([np.zeros(3), 0.1 * axis / np.linalg.norm(axis)])
    rates = np.linalg.lstsq(here.jacobian.array, wanted, rcond=1e-9)[0]
    residual = np.linalg.norm(here.jacobian.array @ rates - wanted)
    fast = f"{np.abs(rates).max():.3g} rad/s" if residual < 1e-6 else "impossible"
    print(f"{q5:10.3f}{here.rank:6d}{here.singular_values[-1]:26.6f}{fast:>27s}")
    assert here.rank == (5 if q5 == 0 else 6)
    assert here.is_singular == (q5 == 0)

print("\nlost here: ", *(screw.text for screw in here.lost_twists))
print("free here: ", *(screw.text for screw in here.free_wrenches))

free = ks.free_wrenches(here.jacobian)
torques = ks.joint_torques(here.jacobian, ks.Wrench.on_environment(free[0, :3], free[0, 3:]))
print("torques for the free wrench [N m]:", np.array2string(np.abs(torques).max(), precision=1))
np.testing.assert_allclose(torques, 0, atol=1e-14)
for qd in np.random.default_rng(0).normal(size=(20, 6)):
    np.testing.assert_allclose(free @ (here.jacobian @ qd).array, 0, atol=1e-13)

straight = ks.analyze(ks.load("planar_2r"), [0.5, 0.0])  # an arm of two joints: its rows in play are found, vx and vy
print(f"\nplanar 2R, elbow straight: rank {straight.rank} of {straight.task.rank} in {', '.join(straight.task.row_names)}")
print("lost:", straight.lost_twists[0].text)
print("free:", straight.free_wrenches[0].text)
assert (straight.rank, straight.task.row_names) == (1, ("vx", "vy"))
along = np.array([np.cos(0.5), np.sin(0.5), 0])
np.testing.assert_allclose(np.abs(straight.lost_twists[0].direction @ along), 1, atol=1e-12)
