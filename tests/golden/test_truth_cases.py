"""Numbers printed by other libraries and books: tests/golden/truth_cases.json, each case with its source and tolerance.

Every case that is a pose, a Jacobian, a Hessian, a velocity, an inverse velocity, a static torque or a measure of a Jacobian
goes through the public functions. Asada's measure needs rotor inertias beside the robot (tests/test_manipulability.py).
Inverse kinematics and exponentials and logarithms of poses have no public function; they are listed.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.robots.assemble import assemble
from kinestatics.robots.description import JointDescription, LinkDescription, RobotDescription
from kinestatics.spatial import rpy_to_rotation

CASES = json.loads((Path(__file__).parent / "truth_cases.json").read_text(encoding="utf-8"))["cases"]
NOT_YET = ("Newton-Raphson", "Asada", "SO(3)", "SE(3)")
COVERED = [case for case in CASES if not any(word in case["quantity"] for word in NOT_YET)]


def pose_of(R=None, p=(0, 0, 0)):
    T = np.eye(4)
    T[:3, :3] = np.eye(3) if R is None else R
    T[:3, 3] = p
    return T


def from_dh(robot):
    rows = robot["rows"]
    numbers = [(r.get("a", 0), r.get("alpha", 0), r.get("d", 0), r.get("theta", 0) + r.get("offset", 0)) for r in rows]
    types = "".join(r.get("joint", "R") for r in rows)
    for k, (row, letter) in enumerate(zip(rows, types, strict=True)):
        if letter == "P":  # the offset of a prismatic row belongs to d
            numbers[k] = (row.get("a", 0), row.get("alpha", 0), row.get("d", 0) + row.get("offset", 0), row.get("theta", 0))
    masses = [r.get("m", 0) for r in rows]
    centers = [r.get("com", (0, 0, 0)) for r in rows]
    matrices = {word: np.array(robot[word]) if robot.get(word) is not None else None for word in ("base", "tool")}
    options = {"types": types, "masses": masses, "centers_of_mass": centers}
    return ks.from_dh(numbers, convention=robot["convention"], **options, **matrices)


def elementary(kind, value):
    axis = np.eye(3)["xyz".index(kind[1])]
    if kind[0] == "t":
        return pose_of(p=value * axis)
    angles = dict.fromkeys("xyz", 0.0) | {kind[1]: value}
    return pose_of(rpy_to_rotation(angles["x"], angles["y"], angles["z"]))


def from_elements(robot):
    links, joints, fixed = [LinkDescription("base")], [], np.eye(4)
    for element in robot["elements"]:
        kind = element["et"]
        if "value" in element:
            fixed = fixed @ elementary(kind, element["value"])
            continue
        axis = np.eye(3)["xyz".index(kind[1])] * (-1 if element.get("flip") else 1)
        screw = np.r_[axis, np.zeros(3)] if kind[0] == "t" else np.r_[np.zeros(3), axis]
        name = f"link{len(links)}"
        joints.append(
            JointDescription(f"j{name}", "prismatic" if kind[0] == "t" else "continuous", links[-1].name, name, fixed, screw)
        )
        links.append(LinkDescription(name))
        fixed = np.eye(4)
    joints.append(JointDescription("end", "fixed", links[-1].name, "tool", fixed))
    links.append(LinkDescription("tool"))
    return assemble(RobotDescription("ets", tuple(links), tuple(joints), tip="tool"))


def from_chain(robot):
    links, joints = [LinkDescription("base")], []
    moving = [j for j in robot["joints"] if j["type"] != "fixed"]
    masses, coms = robot.get("masses"), robot.get("coms")
    for j in robot["joints"]:
        k = moving.index(j) if j in moving else None
        axis = np.array(j.get("axis", (0, 0, 1)), dtype=float)
        screw = {"fixed": np.zeros(6), "prismatic": np.r_[axis, 0, 0, 0]}.get(j["type"], np.r_[0, 0, 0, axis])
        name = f"link{len(links)}"
        placement = pose_of(rpy_to_rotation(*j.get("rpy", (0, 0, 0))), j.get("xyz", (0, 0, 0)))
        joints.append(JointDescription(f"j{name}", j["type"], links[-1].name, name, placement, screw))
        mass = {"mass": masses[k], "center_of_mass": np.array(coms[k])} if masses and k is not None else {}
        links.append(LinkDescription(name, **mass))
    return assemble(RobotDescription("chain", tuple(links), tuple(joints), tip=links[-1].name))


def from_poe(robot):
    frame = {"space": "spatial", "body": "body"}[robot["frame"]]
    return ks.from_screws(robot["S"], robot["M"], order="angular-linear", frame=frame)


BUILD = {"dh": from_dh, "ets": from_elements, "chain": from_chain, "poe": from_poe}


def jacobian_in_convention(arm, q, case):
    c = case["convention"]
    frame = {
        ("base", "tip"): ks.Frame(),
        ("tool", "tip"): ks.Frame.body(),
        ("body", "body-frame origin"): ks.Frame.body(),
        ("space", "space origin (spatial/fixed twist)"): ks.Frame.spatial(),
    }[c["axes"], c["point"].replace(" + offset", "")]
    order = {"linear_first": "linear-angular", "angular_first": "angular-linear"}[c["order"]]
    return ks.jacobian(arm, q, point=case["inputs"].get("offset_tip")).to_array(
        order=order, frame=None if "offset_tip" in case["inputs"] else frame
    )


def angular_first(matrix):
    """A (6, 6) of six-vectors with both of its orders exchanged."""
    return np.roll(matrix, (3, 3), axis=(0, 1))


def rows_of(quantity):
    return slice(0, 3) if "trans" in quantity else slice(3, 6) if "rot" in quantity else slice(0, 6)


def compute(arm, q, case):
    quantity = case["quantity"]
    if "axis from point" in quantity:
        i = case["inputs"]
        return np.roll(ks.screw_axis(i["s"], i["q"], i["h"]), 3)
    if quantity == "Adjoint matrix of T":
        return angular_first(ks.adjoint(np.array(case["inputs"]["T"], dtype=float)))
    if quantity.startswith("ad (Lie bracket)"):
        return angular_first(ks.bracket_matrix(ks.Twist.from_array(case["inputs"]["V"], order="angular-linear")))
    if quantity.startswith("gradient of"):
        return ks.manipulability_gradient(arm, q, task="orientation" if "axes=rot" in quantity else "full")
    if quantity.startswith("pose of link frame"):
        return np.asarray(ks.pose(arm, q, at=f"link{case['inputs']['link']}"))
    if quantity == "forward kinematics pose":
        return np.asarray(ks.pose(arm, q))
    if quantity == "tip position":
        return ks.pose(arm, q).translation
    if "gravity" in quantity:
        return ks.gravity_torques(arm, q, gravity=case["convention"]["g"])
    if "Hessian slice" in quantity:
        k = int(quantity.partition("dq_")[2][0]) - 1
        return ks.hessian(arm, q).array[..., k]
    if "reacting" in quantity:
        w = case["inputs"]["w_tool"]
        J = ks.jacobian(arm, q, frame=ks.Frame.body())
        return ks.joint_torques(J, ks.Wrench.on_robot(w[:3], w[3:], frame=ks.Frame.body()))
    J = jacobian_in_convention(arm, q, case)
    return measure(J, quantity, case)


def measure(J, quantity, case):
    rows = J[rows_of(quantity)]
    if "minimum-norm" in quantity:
        return ks.joint_rates(J[:2], case["inputs"]["v"]).array
    if "planar manipulability" in quantity:
        return ks.manipulability(J[:2])
    if "Yoshikawa" in quantity:
        return ks.manipulability(rows)
    if "inverse condition" in quantity:
        return 1 / ks.condition_number(rows)
    if "condition number" in quantity:
        return ks.condition_number(rows)
    if "smallest singular" in quantity:
        return ks.singular_values(rows)[-1]
    if "numerical rank" in quantity:
        return np.linalg.matrix_rank(rows)
    if "angular part of Jacobian column" in quantity:
        return J[3:, int(quantity[-1]) - 1]
    if "linear part of Jacobian column" in quantity:
        return J[:3, int(quantity[-1]) - 1]
    if quantity.startswith("planar Jacobian rows"):
        return J[[0, 1, 5]]
    if "2x2" in quantity or "2x3" in quantity:
        return J[:2]
    assert "Jacobian" in quantity
    return J


@pytest.mark.parametrize("case", COVERED, ids=[case["id"] for case in COVERED])
def test_printed_number_is_reproduced(case):
    """Each printed number is reproduced to the digits it was printed with."""
    robot = case["robot"]
    arm = BUILD[robot["type"]](robot) if robot["type"] != "none" and "link_com_home" not in robot else None
    found = gravity_of_screws(robot, case) if "link_com_home" in robot else compute(arm, case["q"], case)
    tolerance = case["tolerance"]
    expected = np.array(case["expected"], dtype=float)
    assert np.shape(found) == expected.shape
    np.testing.assert_allclose(found, expected, atol=tolerance["atol"], rtol=tolerance["rtol"])


def gravity_of_screws(robot, case):
    """Holding torques of screws that need not be unit: one of size s moves s times as far, for s times the torque."""
    links, joints, sizes = [LinkDescription("base")], [], []
    for i, (S, mass, home) in enumerate(zip(robot["S"], robot["masses"], robot["link_com_home"], strict=True)):
        sizes.append(np.linalg.norm(S[:3]))
        links.append(LinkDescription(f"link{i + 1}", mass, np.array(home)[:3, 3]))
        screw = np.roll(np.array(S) / sizes[-1], 3)
        joints.append(JointDescription(f"j{i}", "continuous", f"link{i}" if i else "base", f"link{i + 1}", np.eye(4), screw))
    arm = assemble(RobotDescription("poe", tuple(links), tuple(joints)))
    gravity = case["convention"]["g"]
    return ks.gravity_torques(arm, np.array(case["q"]) * sizes, gravity=gravity) * sizes


def test_nothing_is_left_out_unnoticed():
    """All but the listed kinds are covered."""
    assert len(CASES) == 73
    assert len(CASES) - len(COVERED) == 9
