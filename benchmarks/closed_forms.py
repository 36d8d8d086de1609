"""Determinants of six-joint arms: `python benchmarks/closed_forms.py`, ours against the routes SymPy offers.

CPU time of one process each route, warm; a route that takes longer than the time limit is stopped there. Operations are
SymPy's count. SymPy's own Jacobian is that of the same model at symbols, in the base frame, as textbooks write it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import sympy as sp

import kinestatics as ks

RIGHT = sp.pi / 2
a1, a2, a3, d1, d3, d4, d5, d6 = sp.symbols("a1 a2 a3 d1 d3 d4 d5 d6", real=True)
TABLES = {
    "ur5": [(0, RIGHT, d1, 0), (a2, 0, 0, 0), (a3, 0, 0, 0), (0, RIGHT, d4, 0), (0, -RIGHT, d5, 0), (0, 0, d6, 0)],
    "puma": [(0, RIGHT, d1, 0), (a2, 0, 0, 0), (a3, -RIGHT, d3, 0), (0, RIGHT, d4, 0), (0, -RIGHT, 0, 0), (0, 0, d6, 0)],
}


def ours(arm: ks.RobotModel) -> Any:
    """Factored, in the frame of a middle link."""
    return ks.singularities(arm, "full").determinant


def charpoly(arm: ks.RobotModel) -> Any:
    """SymPy's ring of polynomials in cosines and sines, in the base frame, expanded."""
    J = sp.Matrix(ks.jacobian(arm, ks.joint_symbols(arm)).array)
    return sp.expand(J.det(method="berkowitz"))


def simplified(arm: ks.RobotModel) -> Any:
    """simplify of the Jacobian's determinant."""
    J = sp.Matrix(ks.jacobian(arm, ks.joint_symbols(arm)).array).applyfunc(sp.trigsimp)
    return sp.simplify(J.det(method="berkowitz"))


ROUTES: dict[str, Callable[[ks.RobotModel], Any]] = {
    "ks.singularities": ours,
    "SymPy det, expanded": charpoly,
    "SymPy trigsimp, det, simplify": simplified,
}


def run(route: str, robot: str, answer: Any) -> None:
    """One route in a process of its own, the second of two runs; sends seconds and operations."""
    arm = ks.from_dh(TABLES[robot], convention="standard")
    if route == "ks.singularities":
        ROUTES[route](arm)
    began = time.process_time()
    found = ROUTES[route](arm)
    answer.send((time.process_time() - began, int(sp.count_ops(found))))


def measured(route: str, robot: str, limit: float) -> tuple[str, str]:
    """Seconds and operations as text; "> limit" where it was stopped."""
    here, there = multiprocessing.get_context("spawn").Pipe(duplex=False)
    process = multiprocessing.get_context("spawn").Process(target=run, args=(route, robot, there))
    process.start()
    if not here.poll(limit):
        process.terminate()
        return f"> {limit:g}", "-"
    seconds, operations = here.recv()
    process.join()
    return f"{seconds:.3f}", str(operations)


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds after which a route is stopped")
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    lines = ["| robot | route | CPU s | operations |", "|---|---|---|---|"]
    for robot in TABLES:
        for route in ROUTES:
            seconds, operations = measured(route, robot, arguments.limit)
            lines.append(f"| {robot} | {route} | {seconds} | {operations} |")
            print(lines[-1], flush=True)
    text = (
        f"Python {platform.python_version()}, SymPy {sp.__version__}, {time.strftime('%Y-%m-%d')}\n\n"
        + "\n".join(lines)
        + "\n"
    )
    if arguments.markdown:
        arguments.markdown.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
