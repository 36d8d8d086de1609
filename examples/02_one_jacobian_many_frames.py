"""In which frame is this Jacobian?

A Jacobian maps joint rates to a twist (v, ω), and a twist needs two words: whose axes, and the velocity of which point. Two
words cover all Jacobians in use: geometric (base axes, at the tip; the default), body (tip axes, at the tip) and spatial
(base axes, the point of the tip's body that is now at the base origin). Other libraries order the rows otherwise and call
the same thing by other names; `to_array(convention=...)` writes theirs, `which_convention` recognises it.

Law: a change of frame is a change of coordinates and nothing else. v_B = Rᵀ (v_A + ω × p) and ω_B = Rᵀ ω, there and back
is the identity, and the singular values of the angular rows do not change.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("planar_2r")  # two links of 1 m
q = [0.3, 0.5]
geometric = ks.jacobian(arm, q)
body = geometric.change_frame(ks.Frame.body())
spatial = geometric.change_frame(ks.Frame.spatial())
for J in (geometric, body, spatial):
    print(J, "\n")

at_elbow = ks.jacobian(arm, q, frame=ks.Frame(axes="link1", origin="tip"))  # axes of the first link
print(at_elbow)

R, p = ks.pose(arm, q).rotation, ks.pose(arm, q).translation
v, w = spatial.linear, spatial.angular
np.testing.assert_allclose(geometric.linear, v + np.cross(w.T, p).T, atol=1e-15)  # v_tip = v_0 + ω × p
np.testing.assert_allclose(body.linear, R.T @ geometric.linear, atol=1e-15)
np.testing.assert_allclose(body.change_frame(ks.Frame.spatial()).array, spatial.array, atol=1e-15)
np.testing.assert_allclose(spatial.change_frame(geometric.frame).array, geometric.array, atol=1e-15)

print("\nfirst column, as other libraries write it")
names = ("pinocchio.WORLD", "pinocchio.LOCAL", "pinocchio.LOCAL_WORLD_ALIGNED", "modern_robotics.body", "drake")
for name in names:
    array = geometric.to_array(convention=name)
    print(f"  {name:30s}", np.array2string(array[:, 0], precision=3, suppress_small=True))
    found = ks.which_convention(array, arm, q)
    assert name in found.matches
print("\nan unlabelled array, recognised:", ks.which_convention(geometric.to_array(convention="mujoco"), arm, q))

refusal = None
try:  # mixing frames is an error that names both, and the remedy
    ks.joint_torques(body, ks.Wrench.on_robot(force=(0, -10, 0)))
except ks.FrameMismatchError as error:
    refusal = error
print(f"\n{refusal}")
assert refusal.code == "KS330"
