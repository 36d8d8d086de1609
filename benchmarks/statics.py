"""Statics in the table: torques that hold a wrench, and weight and wrench together, against Pinocchio and NumPy."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from compiled import PinocchioLoop
from harness import Contestant, Row, interleaved
from robots import Subject

import kinestatics as ks


def static_torques(robot: Subject, loop: PinocchioLoop | None, limit: ctypes.CDLL | None, rounds: int) -> list[Row]:
    """Jᵀ w of a batch, and what holds one posture: weight and a wrench at the tip."""
    del loop, limit
    count, few, n, ev = 16_000, 500, robot.arm.n, robot.evaluator
    q, wrench = robot.configurations(count), np.random.default_rng(4).normal(size=(count, 6))
    out, J = np.empty((count, n)), ev.jacobian(q[:4000])
    own, one = np.ascontiguousarray(q[:few, robot.order]), np.array(q[0])
    load = ks.Wrench.on_robot(force=wrench[0, :3], torque=wrench[0, 3:])
    contestants: dict[str, Contestant] = {
        "ours": (lambda: ev.joint_torques(q, wrench, out=out), count),
        "numpy": (lambda: (J.swapaxes(-1, -2) @ wrench[:4000, :, None])[..., 0], 4000),
        "pin": (_pinocchio_loop(robot, own, wrench), few),
        "holding": (lambda: ks.holding_torques(robot.arm, one, load), 1),
        "pin holding": (_pinocchio_holding(robot, np.ascontiguousarray(own[0]), wrench[0]), 1),
    }
    ns = interleaved(contestants, rounds)
    return [
        Row(robot.name, "J^T w", "Evaluator, out=", "Python loop of Pinocchio", ns["ours"], ns["pin"]),
        Row(robot.name, "J^T w", "Evaluator, out=", "NumPy matmul, J given", ns["ours"], ns["numpy"]),
        Row(
            robot.name,
            "weight and load, one call",
            "ks.holding_torques (typed)",
            "Pinocchio: gravity and J^T w",
            ns["holding"],
            ns["pin holding"],
            None,
            at_most=True,
        ),
    ]


def _pinocchio_loop(robot: Subject, q: Any, wrench: Any) -> Callable[[], None]:
    model, data, tool, frame = robot.model, robot.data, robot.tool, pin.LOCAL_WORLD_ALIGNED
    out = np.empty((len(q), robot.arm.n))

    def run() -> None:
        for i in range(len(q)):
            out[i] = pin.computeFrameJacobian(model, data, q[i], tool, frame).T @ wrench[i]

    return run


def _pinocchio_holding(robot: Subject, q: Any, wrench: Any) -> Callable[[], object]:
    model, data, tool, frame = robot.model, robot.data, robot.tool, pin.LOCAL_WORLD_ALIGNED

    def run() -> object:
        own = pin.computeGeneralizedGravity(model, data, q)
        return own - pin.computeFrameJacobian(model, data, q, tool, frame).T @ wrench

    return run
