"""Do these fingers hold this object, and how hard must they press?

A contact says where a finger touches, into which direction it pushes, and what it transmits: a push alone, a push with
friction, or that and a moment about the normal, as soft fingertips do. The grasp matrix adds their forces up to a wrench on
the object; what it adds up to nothing is squeeze, which moves nothing and makes room for friction. Closure and least forces
need SciPy: pip install 'kinestatics[grasp]'.

Law: the motors' power is the power that lifts the load, to which squeeze adds nothing.
"""

import numpy as np

import kinestatics as ks

HALF, FRICTION, TORSION, MASS = 0.03, 0.5, 0.004, 0.4  # a box of 6 cm; soft tips, 4 mm of moment per newton; kg
ON_OBJECT = ks.Frame.body("object")
places = [((HALF, 0, 0), (-1, 0, 0)), ((-HALF, 0, 0), (1, 0, 0))]  # in the object's axes: x across, y up

hard = [ks.Contact.with_friction(p, n, FRICTION) for p, n in places]
soft = [ks.Contact.soft(p, n, FRICTION, TORSION) for p, n in places]
for name, contacts in (("two hard fingers", hard), ("two soft fingers", soft)):
    print(f"{name}\n{ks.force_closure(contacts, length=HALF)}\n")
assert not ks.force_closure(hard, accuracy=None).closed  # no moment about the line through both contacts
assert ks.force_closure(soft, accuracy=None).closed
assert ks.force_closure(hard, rows="planar", accuracy=None).closed

load = ks.Wrench.on_robot(force=(0, -MASS * 9.81, 0), frame=ON_OBJECT)  # the hand carries it, through the object
least = ks.grasp_equilibrium(soft, load)
firm = ks.grasp_equilibrium(soft, load, safety=1.5)
print(f"as little as friction allows: {least}\n\nwith half as much again: {firm}\n")
np.testing.assert_allclose(least.normal, MASS * 9.81 / (2 * FRICTION))
np.testing.assert_allclose(firm.friction_used, 1 / 1.5)
np.testing.assert_allclose(ks.contact_wrench(soft, firm.stacked).force, [0, MASS * 9.81, 0], atol=1e-12)

aside = ks.Wrench.on_robot(force=(0, -MASS * 9.81, 0), frame=ks.Frame("object", "object", (0.0, 0.0, 0.01)))
turning, slipping = (ks.grasp_equilibrium(contacts, aside, limit=15) for contacts in (soft, hard))
print(f"gripped 1 cm beside the centre of mass: {turning}\n\nthe same with hard fingers: {slipping.reason}\n")
np.testing.assert_allclose(turning.torsion_used.max(), 0.01 * MASS * 9.81 / (2 * TORSION * turning.normal[0]))
assert turning.feasible
assert not slipping.feasible

REACH, HEIGHT, SPREAD = (0.10, 0.08), 0.14, 0.06  # links of a finger [m]; the box's height over the palm; half the palm
finger = ks.from_dh([(length, 0, 0, 0) for length in REACH], convention="standard")


def bent(x, y, side):
    """Joint angles that take the fingertip to (x, y), the knuckle turned outwards."""
    a, b = REACH
    inner = side * np.arccos((x * x + y * y - a * a - b * b) / (2 * a * b))
    return np.array([np.arctan2(y, x) - np.arctan2(b * np.sin(inner), a + b * np.cos(inner)), inner])


power, upwards = 0.0, np.array([0.0, 0.1, 0.0])  # the box rises with 0.1 m/s
squeeze = ks.force_closure(soft, accuracy=None).squeeze
print(f"{'finger':10s}{'force on the box [N]':>26s}{'torques [N m]':>22s}{'a squeeze of 1 N [N m]':>28s}")
power_of_squeeze = 0.0
for k, wrench in enumerate(firm.wrenches):
    side = 1 if k == 0 else -1
    x, y = side * HALF - side * SPREAD, HEIGHT  # the contact, from the finger's base
    J = ks.jacobian(finger, bent(x, y, side))
    torques = ks.joint_torques(J, ks.Wrench.on_environment(force=wrench.force, frame=J.frame))  # both have level axes
    inwards = squeeze[4 * k + 2] * soft[k].normal
    squeezing = ks.joint_torques(J, ks.Wrench.on_environment(force=inwards, frame=J.frame))
    rates = np.linalg.solve(J.linear[:2], upwards[:2])
    power, power_of_squeeze = power + torques @ rates, power_of_squeeze + squeezing @ rates
    cells = [np.array2string(v.round(4) + 0.0, precision=4, suppress_small=True) for v in (wrench.force, torques, squeezing)]
    print(f"{k:<10d}{cells[0]:>26s}{cells[1]:>22s}{cells[2]:>28s}")

print(
    f"\npower of the motors {power:.4f} W, of the load {MASS * 9.81 * 0.1:.4f} W, of the squeeze {power_of_squeeze:z.4f} W"
)
np.testing.assert_allclose(power, MASS * 9.81 * 0.1)
np.testing.assert_allclose(power_of_squeeze, 0, atol=1e-12)
