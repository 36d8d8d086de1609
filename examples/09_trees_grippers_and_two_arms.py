"""What about a gripper, a side branch, or two arms?

A file may hold a tree. Named a base and a tip, `load` gives the chain between them, in either direction and from any link;
joints off the way are held where you say, and keep their weight. `whole_tree=True` keeps every joint as a column, and
`relative_jacobian` tells how one moving link moves as seen from another: one hand from the other. Fingers that follow
another joint (mimic) share its column, so that nothing moves that no motor drives.

Law: the relative Jacobian is the derivative of T_left_right, and turning a chain round inverts its pose.
"""

import tempfile
from pathlib import Path

import numpy as np

import kinestatics as ks

ARM = """
  <link name="{s}_upper"/><link name="{s}_fore"/><link name="{s}_hand"><inertial><mass value="1"/></inertial></link>
  <link name="{s}_thumb"/><link name="{s}_finger"/>
  <joint name="{s}_shoulder" type="revolute"><parent link="torso"/><child link="{s}_upper"/><origin xyz="0 {y} 0"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="2"/></joint>
  <joint name="{s}_elbow" type="revolute"><parent link="{s}_upper"/><child link="{s}_fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="30" velocity="2"/></joint>
  <joint name="{s}_wrist" type="fixed"><parent link="{s}_fore"/><child link="{s}_hand"/><origin xyz="0.3 0 0"/></joint>
  <joint name="{s}_grip" type="prismatic"><parent link="{s}_hand"/><child link="{s}_thumb"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.05" effort="10" velocity="1"/></joint>
  <joint name="{s}_follow" type="prismatic"><parent link="{s}_hand"/><child link="{s}_finger"/><axis xyz="0 1 0"/>
    <mimic joint="{s}_grip" multiplier="-1"/><limit lower="-0.05" upper="0" effort="10" velocity="1"/></joint>"""
TEXT = '<robot name="two_arms"><link name="base"/><link name="torso"><inertial><mass value="9"/></inertial></link>'
TEXT += '<joint name="waist" type="continuous"><parent link="base"/><child link="torso"/><axis xyz="0 0 1"/></joint>'
TEXT += ARM.format(s="left", y=0.2) + ARM.format(s="right", y=-0.2) + "</robot>"

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "two_arms.urdf"
    path.write_text(TEXT, encoding="utf-8")
    try:
        ks.load(path)
    except ks.RobotDefinitionError as error:
        print(error, "\n")
    arm = ks.load(path, tip="left_hand", joints={"right_shoulder": 0.5})  # one arm; the other is held, and weighs
    fingers = ks.load(path, base="left_thumb", tip="left_finger")
    across = ks.load(path, base="left_hand", tip="right_hand")
    turned = ks.load(path, base="right_hand", tip="left_hand")
    tree = ks.load(path, whole_tree=True)

print(arm, "\n")
print(fingers)
print("the finger seen from the thumb, a column for one motor:", ks.jacobian(fingers, [0.01]).linear[:, 0], "\n")
np.testing.assert_array_equal(ks.jacobian(fingers, [0.01]).linear[:, 0], [0, -2, 0])

print(across)
value = {"waist": 0.2, "left_shoulder": 0.4, "left_elbow": 0.6, "right_shoulder": -0.3, "right_elbow": -0.9}
q = np.array([value.get(name, 0.0) for name in tree.joint_names])
J = ks.relative_jacobian(tree, q, at="right_hand", relative_to="left_hand")
print("\nthe right hand seen from the left; the waist moves neither:")
print(J)

q_across = np.array([value[name] for name in across.joint_names])
columns = [tree.joint_names.index(name) for name in across.joint_names]
np.testing.assert_allclose(J.array[:, columns], ks.jacobian(across, q_across).array, atol=1e-15)
np.testing.assert_allclose(J.array[:, tree.joint_names.index("waist")], 0, atol=1e-15)


def T_left_right(x):
    """The right hand seen from the left."""
    return np.linalg.inv(ks.pose(tree, x, at="left_hand").array) @ ks.pose(tree, x, at="right_hand").array


for k, step in enumerate(1e-6 * np.eye(tree.n)):
    velocity = (T_left_right(q + step) - T_left_right(q - step))[:3, 3] / 2e-6
    np.testing.assert_allclose(J.linear[:, k], velocity, atol=1e-9)

q_turned = np.array([value[name] for name in turned.joint_names])
round_trip = ks.pose(across, q_across).array @ ks.pose(turned, q_turned).array
np.testing.assert_allclose(round_trip, np.eye(4), atol=1e-15)
print("\nthere and back is the identity to", f"{np.abs(round_trip - np.eye(4)).max():.0e}")
