"""What is measured, and the goal of each ratio. A section takes a robot, the C++ peer, the write limit and the rounds."""

from __future__ import annotations

import ctypes
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from compiled import PinocchioLoop
from harness import Contestant, Row, interleaved
from robots import Subject

import kinestatics as ks
import peers

BATCH_GOAL = {"avx512": 20.0, "avx2": 15.0, "baseline": 6.0}
LARGE, MEDIUM = 1_000_000, 10_000


def fastest() -> str:
    """The instruction set in use."""
    return ks.kernels.instruction_set()


def accuracy(robot: Subject) -> str:
    """Largest differences to independent computations, in a sentence."""
    q = robot.configurations(2000, seed=3)
    J = robot.evaluator.jacobian(q)
    expected = np.empty_like(J)
    own = np.ascontiguousarray(q[:, robot.order])
    peers.pinocchio_python(robot, own, expected)()
    expected = expected[:, :, np.argsort(robot.order)]
    reach = max(1.0, ks.characteristic_length(robot.arm))
    rows = list(robot.evaluator.task.rows)
    w = np.prod(np.linalg.svd(J[:, rows], compute_uv=False), axis=-1)
    sigma = np.abs(robot.evaluator.singular_values(q) - np.linalg.svd(J[:, rows], compute_uv=False)).max()
    return (
        f"J against Pinocchio {np.abs(J - expected).max() / reach:.1e} per metre of reach, "
        f"manipulability {np.abs(robot.evaluator.manipulability(q) - w).max():.1e}, singular values {sigma:.1e} (absolute)"
    )


def batch_jacobian(robot: Subject, loop: PinocchioLoop | None, limit: ctypes.CDLL | None, rounds: int) -> list[Row]:
    """The Jacobian of many configurations, for each instruction set, against everything that could be picked instead."""
    rows: list[Row] = []
    for count in (MEDIUM, LARGE):
        q, out = robot.configurations(count), np.empty((count, 6, robot.arm.n))
        ns = interleaved(_contestants(robot, loop, limit if count == LARGE else None, q, out), rounds)
        rows += _batch_rows(robot, f"J, N = {count:.0e}".replace("e+0", "e"), ns, large=count == LARGE)
    return rows


def _contestants(
    robot: Subject, loop: PinocchioLoop | None, limit: ctypes.CDLL | None, q: Any, out: Any
) -> dict[str, Contestant]:
    count = len(q)
    found: dict[str, Contestant] = {}
    for name in ks.kernels.instruction_sets():
        found[name] = (_using(name, lambda: robot.evaluator.jacobian(q, out=out)), count)
    found["allocated"] = (lambda: robot.evaluator.jacobian(q), count)
    found |= _peers_of_the_jacobian(robot, loop, q)
    if limit is not None:
        start = (-out.ctypes.data % 64) // 8
        size = (out.size - start) // 8 * 64
        address = ctypes.c_void_p(out.ctypes.data + 8 * start)
        found["write limit"] = (lambda: limit.write_limit(address, ctypes.c_size_t(size)), count)
    return found


def _batch_rows(robot: Subject, size: str, ns: dict[str, float], large: bool) -> list[Row]:
    small_arm, best = robot.arm.n < 10, fastest()
    rows: list[Row] = []
    for name in ks.kernels.instruction_sets():
        if "C++" in ns:
            goal = BATCH_GOAL[name] if small_arm else None
            rows.append(Row(robot.name, size, f"{name}, out=", "C++ Pinocchio", ns[name], ns["C++"], goal))
    ours = f"{best}, out="
    rows.append(Row(robot.name, size, ours, "Python loop of Pinocchio", ns[best], ns["Python"], 45.0 if small_arm else None))
    if "JAX" in ns:
        rows.append(Row(robot.name, size, ours, "JAX vmap + jit", ns[best], ns["JAX"]))
    if "write limit" in ns:
        rows.append(Row(robot.name, size, ours, "write limit, one core", ns[best], ns["write limit"], 0.5))
    at_most = 1.3 if large else None
    rows.append(Row(robot.name, size, f"{best}, allocated", "with out=", ns["allocated"], ns[best], at_most, at_most=True))
    return rows


def _using(name: str, call: Callable[[], object]) -> Callable[[], object]:
    def run() -> object:
        with ks.kernels.use(name):
            return call()

    return run


def _peers_of_the_jacobian(robot: Subject, loop: PinocchioLoop | None, q: Any) -> dict[str, Contestant]:
    n, few = robot.arm.n, min(len(q), 2000)
    own = np.ascontiguousarray(q[:few, robot.order])
    scratch = np.empty((few, 6, n))
    found: dict[str, Contestant] = {"Python": (peers.pinocchio_python(robot, own[:500], scratch[:500]), 500)}
    if loop is not None:
        found["C++"] = (lambda: loop("jacobian", own, scratch), few)
    if n < 10 and (jax := peers.jax_jacobian(robot)) is not None:
        many = q[:MEDIUM]
        found["JAX"] = (lambda: jax(many), len(many))
    return found


def other_quantities(robot: Subject, loop: PinocchioLoop | None, limit: ctypes.CDLL | None, rounds: int) -> list[Row]:
    """Pose, gravity, rate, Hessian, manipulability against C++ Pinocchio; singular values and damped rates against NumPy."""
    del limit
    count, n, ev = 16_000, robot.arm.n, robot.evaluator
    q, qd, twist = (
        robot.configurations(count),
        robot.configurations(count, 1),
        np.random.default_rng(2).normal(size=(count, 6)),
    )
    few = 2000
    own, rates = (np.ascontiguousarray(x[:few, robot.order]) for x in (q, qd))
    goals = {"pose": 17.0, "gravity": 20.0, "rate": 14.0, "hessian": 7.5, "manipulability": 18.0}
    shapes = {"pose": (4, 4), "gravity": (n,), "rate": (6, n), "hessian": (6, n, n), "manipulability": ()}
    ours = {
        "pose": lambda out: ev.pose(q, out=out),
        "gravity": lambda out: ev.gravity_torques(q, out=out),
        "rate": lambda out: ev.jacobian_rate(q, qd, out=out),
        "hessian": lambda out: ev.hessian(q, out=out),
        "manipulability": lambda out: ev.manipulability(q, out=out),
    }
    contestants: dict[str, Contestant] = {}
    for name, call in ours.items():
        out = np.empty((count, *shapes[name]))
        contestants[name] = (lambda call=call, out=out: call(out), count)  # type: ignore[misc]
        if loop is not None:
            to = np.empty((few, *shapes[name]))
            contestants[f"C++ {name}"] = (lambda name=name, to=to: loop(name, own, to, rates), few)  # type: ignore[misc]
    contestants |= _linear_algebra(robot, q, twist)
    ns = interleaved(contestants, rounds)
    set_name = f"{fastest()}, out="
    rows = []
    for name, goal in goals.items():
        if loop is not None:
            rows.append(
                Row(robot.name, name, set_name, "C++ Pinocchio", ns[name], ns[f"C++ {name}"], goal if n < 10 else None)
            )
    few_rows = n < 10
    rows.append(
        Row(
            robot.name,
            "singular values",
            set_name,
            "np.linalg.svd, J given",
            ns["svd"],
            ns["np svd"],
            8.0 if few_rows else None,
        )
    )
    rows.append(
        Row(
            robot.name,
            "damped rates",
            set_name,
            "np.linalg.solve, J given",
            ns["damped"],
            ns["np solve"],
            12.0 if few_rows else None,
        )
    )
    return rows


def _linear_algebra(robot: Subject, q: Any, twist: Any) -> dict[str, Contestant]:
    """Ours from q; NumPy's batched functions on Jacobians that are already there."""
    count, few, ev = len(q), 4000, robot.evaluator
    J = ev.jacobian(q[:few])
    sigma, out = np.empty((count, min(6, robot.arm.n))), np.empty((count, robot.arm.n))
    damping = 0.05

    def solve() -> Any:
        A = J @ J.swapaxes(-1, -2) + damping**2 * np.eye(6)
        return J.swapaxes(-1, -2) @ np.linalg.solve(A, twist[:few, :, None])

    return {
        "svd": (lambda: ev.singular_values(q, out=sigma), count),
        "np svd": (lambda: np.linalg.svd(J, compute_uv=False), few),
        "damped": (lambda: ev.damped_rates(q, twist, damping, out=out), count),
        "np solve": (solve, few),
    }


def single_calls(robot: Subject, loop: PinocchioLoop | None, limit: ctypes.CDLL | None, rounds: int) -> list[Row]:
    """One configuration at a time, and small batches, through Python."""
    del loop, limit
    n, ev, arm = robot.arm.n, robot.evaluator, robot.arm
    q = robot.configurations(100)
    eight = np.array(q[:8])
    one, out, own = np.array(q[0]), np.zeros((6, n)), np.ascontiguousarray(q[0][list(robot.order)])
    to = np.empty((100, 6, n))
    model, data, tool, frame = robot.model, robot.data, robot.tool, pin.LOCAL_WORLD_ALIGNED
    contestants: dict[str, Contestant] = {
        "pin": (lambda: pin.computeFrameJacobian(model, data, own, tool, frame), 1),
        "call": (lambda: ev.jacobian(one), 1),
        "out": (lambda: ev.jacobian(one, out=out), 1),
        "friendly": (lambda: ks.jacobian(arm, one), 1),
        "eight": (lambda: ev.jacobian(eight), 8),
        "hundred": (lambda: ev.jacobian(q), 100),
        "loop": (peers.pinocchio_python(robot, np.ascontiguousarray(q[:, robot.order]), to), 100),
        "loop of eight": (peers.pinocchio_python(robot, np.ascontiguousarray(q[:8, robot.order]), to[:8]), 8),
    }
    if n < 10 and (toolbox := peers.toolbox_jacobian(robot)) is not None:
        contestants["RTB"] = (lambda: toolbox(one), 1)
    ns = interleaved(contestants, rounds)
    goal = n < 10
    rows = [
        Row(
            robot.name,
            "J, one call",
            "Evaluator",
            "Pinocchio, one call",
            ns["call"],
            ns["pin"],
            0.25 if goal else None,
            at_most=True,
        ),
        Row(
            robot.name,
            "J, one call",
            "Evaluator, out=",
            "Pinocchio, one call",
            ns["out"],
            ns["pin"],
            0.16 if goal else None,
            at_most=True,
        ),
        Row(robot.name, "J, one call", "ks.jacobian (typed)", "Evaluator", ns["friendly"], ns["call"], None, at_most=True),
        Row(
            robot.name,
            "J, N = 8",
            "Evaluator",
            "Python loop of Pinocchio",
            ns["eight"],
            ns["loop of eight"],
            20.0 if goal else None,
        ),
        Row(
            robot.name,
            "J, N = 100",
            "Evaluator",
            "Python loop of Pinocchio",
            ns["hundred"],
            ns["loop"],
            45.0 if goal else None,
        ),
    ]
    if "RTB" in ns:
        rows.append(Row(robot.name, "J, one call", "Evaluator", "Robotics Toolbox ETS", ns["call"], ns["RTB"]))
    return rows


def threads(robot: Subject, rounds: int) -> list[Row]:
    """Two threads against one, by the wall clock: needs two idle cores to mean anything."""
    count = 200_000
    q, out = robot.configurations(count), np.empty((count, 6, robot.arm.n))
    w = np.empty(count)
    ns = interleaved(
        {
            "one": (lambda: robot.evaluator.jacobian(q, out=out), count),
            "two": (lambda: robot.evaluator.jacobian(q, out=out, threads=2), count),
            "w one": (lambda: robot.evaluator.manipulability(q, out=w), count),
            "w two": (lambda: robot.evaluator.manipulability(q, out=w, threads=2), count),
        },
        2 * rounds,
        time.perf_counter,
    )
    return [
        Row(robot.name, "J, N = 2e5, wall", "two threads", "one thread", ns["two"], ns["one"], 1.8),
        Row(robot.name, "manipulability, N = 2e5, wall", "two threads", "one thread", ns["w two"], ns["w one"], 1.8),
    ]


def imports(rounds: int) -> list[Row]:
    """CPU time of `import kinestatics` over `import numpy` [ns]: fresh interpreters, taking turns, compiled modules kept."""
    codes = {"numpy": "import numpy", "ours": "import numpy, kinestatics"}
    times: dict[str, list[float]] = {name: [] for name in codes}
    clock = "import time; began = time.thread_time(); {}; print(time.thread_time() - began)"
    with tempfile.TemporaryDirectory() as folder:
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | {
            "PYTHONPYCACHEPREFIX": folder
        }
        for turn in range(max(rounds, 5) + 1):
            for name, code in codes.items():
                command = [sys.executable, "-c", clock.format(code)]
                done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
                if turn:  # the first one compiles
                    times[name].append(float(done.stdout) * 1e9)
    numpy, ours = (statistics.median(times[name]) for name in ("numpy", "ours"))
    return [Row("", "import, over NumPy [ns]", "kinestatics", "goal: 60 ms", ours - numpy, 60e6, 1.0, at_most=True)]


SECTIONS = (batch_jacobian, other_quantities, single_calls)
