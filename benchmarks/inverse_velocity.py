"""Inverse velocity: part of run.py, and alone `python benchmarks/inverse_velocity.py [--quick] [--markdown FILE]`.

One process, one core, contestants in turns, CPU time, medians, as in run.py; needs the dev extra. The arm is the Panda.
Pink and mink are compared where they are installed.

The steps are those of a closed loop that asks for more than the limits allow in most periods: 2,000 configurations with
their twists, recorded once, and for the bare solver the matrices that belong to them.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import importlib.util
import itertools
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import daqp
import numpy as np
from harness import Contestant, Row, interleaved, pin_to_one_core, table
from robots import Subject, subject

import kinestatics as ks

DT, STEPS, DAMPING, ACCELERATION = 0.001, 2000, 1e-3, 10.0
STEP_GOAL = 1.5
Loop = tuple[list[Any], list[Any], list[tuple[Any, ...]], float]
"""Configurations, twists, (H, f, upper, lower) of each, and the share of the steps in which a limit binds."""


def twists(k: int) -> Any:
    """The twist of a period: fast circles and turns, faster than the arm can go."""
    t = k * DT
    phases = np.array([6.0, 9.0, 15.0, 6.0, 9.0, 12.0]) * t + np.array([0, np.pi / 2, 0, np.pi / 2, 0, np.pi / 2])
    return np.array([1.2, 1.8, 0.9, 0.75, 1.2, 1.5]) * np.cos(phases)


def closed_loop(robot: Subject, acceleration: float | None) -> Loop:
    """One run of the loop, and the problems its steps were."""
    solver, q = ks.RateSolver(robot.arm, dt=DT, acceleration=acceleration, damping=DAMPING), start(robot)
    previous = np.zeros(robot.arm.n)
    qs, vs, problems, bound = [], [], [], 0
    for k in range(STEPS):
        v = twists(k)
        rates = solver.step(q, v)
        lower, upper = solver.bounds
        J = ks.jacobian(robot.arm, q).array
        limits = ks.RateLimits.of(robot.arm, q, dt=DT, **with_accelerations(acceleration, previous))
        assert np.abs(upper - limits.upper).max() < 1e-6  # the same problem: RateLimits.of and the solver agree
        problems.append((J.T @ J + DAMPING**2 * np.eye(robot.arm.n), -J.T @ v, upper, lower))
        bound += bool(np.any((rates > upper - 1e-8) | (rates < lower + 1e-8)))
        qs.append(q)
        vs.append(v)
        q, previous = q + DT * rates, rates
    return qs, vs, problems, bound / STEPS


def with_accelerations(acceleration: float | None, previous: Any) -> dict[str, Any]:
    """Arguments of RateLimits.of."""
    return {} if acceleration is None else {"acceleration": acceleration, "previous": previous}


def start(robot: Subject) -> Any:
    """A bent posture: the middle of the limits."""
    return 0.5 * (robot.arm.lower + robot.arm.upper)


def in_turn(call: Callable[[int], object]) -> Contestant:
    """A contestant that takes the recorded steps one after the other."""
    steps = itertools.cycle(range(STEPS))
    return (lambda: call(next(steps)), 1)


def steps(robot: Subject, rounds: int) -> list[Row]:
    """One period of a control loop against the bare solver on the same matrices, and against the libraries people use."""
    rows: list[Row] = []
    for name, acceleration in (("velocity, position", None), ("velocity, position, acceleration", ACCELERATION)):
        qs, vs, problems, bound = closed_loop(robot, acceleration)
        solver = ks.RateSolver(robot.arm, dt=DT, acceleration=acceleration, damping=DAMPING)
        A, sense, n = np.zeros((0, robot.arm.n)), np.zeros(robot.arm.n, dtype=np.intc), robot.arm.n
        solver.step(qs[0], vs[0])
        solver.reset(np.zeros(n))

        def bare(k: int, problems: Any = problems, A: Any = A, sense: Any = sense) -> object:
            H, f, upper, lower = problems[k]
            return daqp.solve(H, f, A, upper, lower, sense)

        contestants = {
            "ours": in_turn(lambda k, s=solver, qs=qs, vs=vs: s.step(qs[k], vs[k])),  # type: ignore[misc]
            "daqp": in_turn(bare),
        }
        if acceleration is None:
            contestants |= others(robot, qs, vs)
        ns = interleaved(contestants, rounds)
        quantity = f"bounded step, {name}, {bound:.0%} bind"
        rows.append(
            Row("panda", quantity, "RateSolver.step", "bare daqp.solve", ns["ours"], ns["daqp"], STEP_GOAL, at_most=True)
        )
        rows += [
            Row("panda", quantity, "RateSolver.step", other, ns["ours"], ns[other]) for other in ns.keys() - {"ours", "daqp"}
        ]
    return rows


def others(robot: Subject, qs: list[Any], vs: list[Any]) -> dict[str, Contestant]:
    """solve_ik of Pink and mink with the same twists, limits and solver; kinematics included, as in our step."""
    found = {}
    if importlib.util.find_spec("pink") is not None:
        found["pink.solve_ik"] = in_turn(pink_step(robot, qs, vs))
    if importlib.util.find_spec("mink") is not None:
        found["mink.solve_ik"] = in_turn(mink_step(robot, qs, vs))
    return found


def pink_step(robot: Subject, qs: list[Any], vs: list[Any]) -> Callable[[int], object]:
    """Pink wants a pose to go to: the one that the twist reaches in a period."""
    import pinocchio as pin
    from pink import Configuration, solve_ik
    from pink.tasks import FrameTask

    own = [np.ascontiguousarray(q[list(robot.order)]) for q in qs]
    configuration = Configuration(robot.model, robot.data, own[0])
    task = FrameTask(robot.model.frames[robot.tool].name, position_cost=1.0, orientation_cost=1.0)
    targets = []
    for q, v in zip(own, vs, strict=True):
        configuration.update(q)
        here = configuration.get_transform_frame_to_world(task.frame)
        R = pin.exp3(v[3:] * DT) @ here.rotation
        targets.append(pin.SE3(R, here.translation + v[:3] * DT))

    def step(k: int) -> object:
        configuration.update(own[k])
        task.set_target(targets[k])
        return solve_ik(configuration, [task], DT, solver="daqp", damping=DAMPING**2)

    return step


def mink_step(robot: Subject, qs: list[Any], vs: list[Any]) -> Callable[[int], object]:
    """mink on the same arm as an MJCF file, with its configuration and velocity limits."""
    import mink
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf(robot.arm))
    configuration = mink.Configuration(model, qs[0])
    task = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=1.0)
    speeds = dict(zip(robot.arm.joint_names, robot.arm.velocity_limits.tolist(), strict=True))
    limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, speeds)]
    targets = []
    for q, v in zip(qs, vs, strict=True):
        configuration.update(q)
        here = configuration.get_transform_frame_to_world("tip", "site")
        there = mink.SO3.exp(v[3:] * DT) @ here.rotation()
        targets.append(mink.SE3.from_rotation_and_translation(there, here.translation() + v[:3] * DT))

    def step(k: int) -> object:
        configuration.update(qs[k])
        task.set_target(targets[k])
        return mink.solve_ik(configuration, [task], DT, solver="daqp", damping=DAMPING**2, limits=limits)

    return step


def mjcf(arm: ks.RobotModel) -> str:
    """A chain of revolute joints as MJCF, with a site at the tip."""

    def pose(T: Any) -> str:
        x, y = T[:3, 0], T[:3, 1]
        return f'pos="{" ".join(map(repr, T[:3, 3].tolist()))}" xyaxes="{" ".join(map(repr, [*x.tolist(), *y.tolist()]))}"'

    text = ""
    for i, name in enumerate(arm.moving_names):
        axis = " ".join(map(repr, arm.screws[i][3:].tolist()))
        ends = f"{arm.lower[i]!r} {arm.upper[i]!r}".replace("np.float64(", "").replace(")", "")
        text += f'<body {pose(arm.placements[i])}><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        text += f'<joint name="{name}" axis="{axis}" range="{ends}" limited="true"/>'
    text += f'<site name="tip" {pose(arm.link_placements[arm.link("tip")])}/>' + "</body>" * arm.n
    return f'<mujoco><compiler angle="radian"/><worldbody>{text}</worldbody></mujoco>'


def inverses(robot: Subject, rounds: int) -> list[Row]:
    """One Jacobian and a thousand, against what NumPy offers for them."""
    rows: list[Row] = []
    rng = np.random.default_rng(0)
    for count in (1, 1000):
        q = robot.configurations(count)
        J, v = robot.evaluator.jacobian(q), rng.normal(size=(count, 6))
        if count == 1:
            J, v = J[0], v[0]
        ns = interleaved(inverse_contestants(J, v, count), rounds)
        size = "one J" if count == 1 else f"{count} J"
        rows += [
            Row("panda", size, "pseudoinverse", "np.linalg.pinv", ns["pseudoinverse"], ns["pinv"]),
            Row("panda", size, "qr", "np.linalg.pinv", ns["qr"], ns["pinv"]),
            Row("panda", size, "damped", "np.linalg.solve (squares)", ns["damped"], ns["solve"]),
            Row("panda", size, "adaptive", "np.linalg.pinv", ns["adaptive"], ns["pinv"]),
            Row("panda", size, "priorities, two tasks", "np.linalg.pinv, twice", ns["priorities"], 2 * ns["pinv"]),
        ]
        if count == 1:
            rows.append(Row("panda", size, "pseudoinverse", "np.linalg.lstsq", ns["pseudoinverse"], ns["lstsq"]))
            rows.append(Row("panda", size, "qp inside limits", "bare daqp.solve", ns["qp"], ns["daqp"]))
    return rows


def inverse_contestants(J: Any, v: Any, count: int) -> dict[str, Contestant]:
    """Every method, and NumPy's functions on the same arrays."""
    n, limits = J.shape[-1], (np.full(J.shape[-1], -0.3), np.full(J.shape[-1], 0.3))

    def solve() -> object:
        A = J @ J.swapaxes(-1, -2) + 0.01 * np.eye(6)
        return J.swapaxes(-1, -2) @ np.linalg.solve(A, v[..., None])

    found: dict[str, Contestant] = {
        "pseudoinverse": (lambda: ks.joint_rates(J, v).array, count),
        "qr": (lambda: ks.joint_rates(J, v, "qr").array, count),
        "damped": (lambda: ks.joint_rates(J, v, "damped", damping=0.1).array, count),
        "adaptive": (lambda: ks.joint_rates(J, v, "adaptive").array, count),
        "priorities": (
            lambda: ks.prioritized_rates([(J[..., :3, :], v[..., :3]), (J[..., 3:, :], v[..., 3:])]).array,
            count,
        ),
        "pinv": (lambda: np.linalg.pinv(J) @ v[..., None], count),
        "solve": (solve, count),
    }
    if count == 1:
        H, f, sense = J.T @ J + DAMPING**2 * np.eye(n), -J.T @ v, np.zeros(n, dtype=np.intc)
        found["lstsq"] = (lambda: np.linalg.lstsq(J, v, rcond=None), 1)
        found["qp"] = (lambda: ks.joint_rates(J, v, "qp", limits=limits, damping=DAMPING).array, 1)
        found["daqp"] = (lambda: daqp.solve(H, f, np.zeros((0, n)), limits[1], limits[0], sense), 1)
    return found


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a fifth of the rounds: a look, not a result")
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    pin_to_one_core()
    rounds = 5 if arguments.quick else 25
    robot = subject("panda")
    rows = steps(robot, rounds) + inverses(robot, rounds)
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}, {time.strftime('%Y-%m-%d')}"
    text = f"{versions}\n\n{table(rows)}\n"
    print(text)
    if arguments.markdown:
        arguments.markdown.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
