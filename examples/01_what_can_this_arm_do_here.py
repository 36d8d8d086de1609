"""What can this arm do, here?

The question one asks first: at this configuration, where is the tip, how does it move when the joints move, is a direction
lost, what must the motors hold? `analyze` answers all of it and prints it in words; every number is also an attribute.

Law: power is the same at the joints and at the tip. The torques that hold a load w are τ = -Jᵀ w, so that for any joint
rates q̇ the power of the motors and the power of the load add up to nothing: τ · q̇ + w · (J q̇) = 0.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("ur5e")  # a bundled arm; a path to a .urdf, .xml (MJCF) or .xacro file is loaded in the same way
load = ks.Wrench.on_robot(force=(0, 0, -50))  # 50 N hang on the tip; base axes, at the tip
answer = ks.analyze(arm, arm.home, wrench=load)
print(answer)

qd = np.array([0.1, -0.2, 0.3, 0.1, 0.0, 0.5])  # any joint rates [rad/s]
twist = answer.jacobian @ qd
by_motors = answer.joint_torques @ qd
by_load = load.array @ twist.array
print(f"\npower at the joints {by_motors:.4f} W, power of the load {by_load:.4f} W")

assert abs(by_motors + by_load) < 1e-12
assert answer.rank == 6
assert not answer.is_singular
assert not answer.lost_twists
