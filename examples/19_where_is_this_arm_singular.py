"""Where is this arm singular, what kind is it, and how far is it from here?

`singularities` gives the determinant in factors, a component for each way to lose rank, and what each is called: wrist,
elbow, shoulder. `.at(q)` is the card of a posture, `.distance(q)` how far it is from each component, `.certify_free` a proof
that a box or a path holds none.

Law: rank J(q) < rank at almost every q. The determinant of a six-joint arm is the same in all frames, so it is computed in
the frame of a middle link, where it is short, and factored in sines and cosines of half angles, where factors are unique.
"""

import numpy as np

import kinestatics as ks

arm = ks.load("puma_560")
found = ks.singularities(arm)
print(found)
assert [component.name for component in found.components] == ["shoulder", "elbow", "wrist"]

q = np.array([0.1, 0.4, -1.0, 0.3, 0.6, 0.2])
print(f"\nat q = {q}")
for distance in found.distance(q):
    print(f"  {distance}")
    J = ks.jacobian(arm, distance.nearest).array
    assert np.linalg.matrix_rank(J, rtol=1e-9) == 5  # the nearest posture is singular
    assert distance.at_least <= distance.value  # and none is nearer than the bound

wrist = np.array([0.1, 0.4, -1.0, 0.3, 0.0, 0.2])
print(f"\nthe card of q = {wrist}")
card = found.at(wrist, boundary=True)
print(card)
assert card.on == ("wrist",)

path = np.array([q, q + np.array([0.3, 0.2, 0.3, 0.2, 0.3, 0.0])])
proof = found.certify_free(path=path)
print(f"\nthe path from there: {proof}")
assert proof.verdict == "free"
crossing = found.certify_free(path=np.array([q, q * [1, 1, 1, 1, -1, 1]]))
print(f"with the wrist turned over: {crossing.verdict}, q5 = {crossing.witness[4]:.1e} rad")
assert crossing.verdict == "singular"
print(found.aspects())

print("\na redundant arm has components of several equations:")
panda = ks.singularities(ks.load("panda"))
print(f"{'equations':>9s}{'freedoms taken':>16s}{'inside the limits':>19s}   joints")
for component in panda.components:
    inside = {True: "yes", False: "no", None: "not seen"}[component.within_limits]
    short = ", ".join(name.removeprefix("panda_") for name in component.joints)
    print(f"{len(component.equations):9d}{component.codimension:16d}{inside:>19s}   {short}")
assert panda.complete
assert all(component.sound for component in panda.components)
