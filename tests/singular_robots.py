"""The robots of golden/singular_robots.json as models: with symbols for lengths, or with numbers.

The file is the project's study of published singularity conditions (the sources are in its entries), checked there against
NumPy and Pinocchio.
"""

import json
from pathlib import Path

import numpy as np
import sympy

import kinestatics as ks

DATA = json.loads((Path(__file__).parent / "golden" / "singular_robots.json").read_text(encoding="utf-8"))
ROBOTS = {robot["id"]: robot for robot in DATA["robots"] if "ops" in robot}
TASKS = {
    "xy": ("vx", "vy"),
    "xyz": "position",
    "xy+wz": ("vx", "vy", "wz"),
    "xyz+wz": ("vx", "vy", "vz", "wz"),
    "w": "orientation",
}
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def task_of(robot):
    return TASKS.get(robot["task"], "full")


def number(entry, lengths):
    if not isinstance(entry, str):
        return float(entry)
    name = entry.lstrip("-")
    if name not in lengths:
        return float(entry)
    return -lengths[name] if entry.startswith("-") else lengths[name]


def random_lengths(robot, rng):
    """Other lengths of the same robot: two decimals, so that they are exact, and all different."""
    values = rng.permutation(np.arange(11, 90))[: len(robot["params"])] / 100
    return dict(zip(robot["params"], values.tolist(), strict=True))


def numeric(robot, lengths=None):
    """The robot with numbers, from its chain of elementary steps."""
    lengths = robot["params"] if lengths is None else lengths
    T, screws = np.eye(4), []
    for kind, axis, value in robot["ops"]:
        direction = np.array(AXES[axis[-1]], dtype=float) * (-1 if axis[0] == "-" else 1)
        if kind in "RP":
            z, p = T[:3, :3] @ direction, T[:3, 3]
            screws.append(np.r_[np.cross(p, z), z] if kind == "R" else np.r_[z, 0, 0, 0])
        elif kind == "t":
            T[:3, 3] += T[:3, :3] @ direction * number(value, lengths)
        else:
            angle, K = np.radians(value), np.cross(direction, np.eye(3)).T
            T[:3, :3] = np.round(T[:3, :3] @ (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K), 12)
    return ks.from_screws(screws, T, order="linear-angular", name=robot["id"])


def symbolic(robot):
    """The robot with symbols for its lengths, from its table; None for one without a table that holds all of them."""
    if robot.get("dh") is None or set(robot["params"]) - {str(x).lstrip("-") for row in robot["dh"]["rows"] for x in row}:
        return None

    def entry(x):
        if isinstance(x, str):
            try:
                return sympy.Rational(x)
            except (TypeError, ValueError):
                return sympy.Symbol(x, real=True) if x[0] != "-" else -sympy.Symbol(x[1:], real=True)
        return sympy.Rational(str(x))

    columns = robot["dh"]["rows"]
    rows = [
        (entry(a), sympy.pi * entry(alpha) / 180, entry(d), sympy.pi * entry((*rest, 0)[0]) / 180)
        for a, alpha, d, *rest in columns
    ]
    convention = "standard" if robot["dh"]["convention"] == "std_dh" else "modified"
    return ks.from_dh(rows, convention=convention, types=robot.get("joint_types"), name=robot["id"])


def expected(text, lengths, q):
    """A formula of the file at configurations (k, n)."""
    joints = sympy.symbols(f"q1:{q.shape[1] + 1}", real=True)
    names = {str(s): s for s in joints} | {name: sympy.Symbol(name, real=True) for name in lengths}
    expression = sympy.parse_expr(text, local_dict=names)
    function = sympy.lambdify([*joints, *(names[name] for name in lengths)], expression, "numpy")
    return np.broadcast_to(function(*q.T, *lengths.values()), len(q))
