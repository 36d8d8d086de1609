"""One command, one table: `python benchmarks/run.py [--robots ur10,panda] [--quick] [--markdown FILE]`.

Everything runs in one process, interleaved, on one core, in CPU time; medians. Needs the dev extra; the C++ peer needs a
compiler and Eigen's headers besides (Debian: libeigen3-dev), the Robotics Toolbox is compared where it is installed.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import argparse
import platform
import sys
import time
from pathlib import Path

import compiled
import inverse_velocity
import measurements
import numpy as np
import statics
from harness import Row, pin_to_one_core, table
from robots import subject

import kinestatics as ks


def machine() -> str:
    """What this ran on, in a line."""
    model = platform.processor() or platform.machine()
    cpu = Path("/proc/cpuinfo")
    if cpu.is_file():
        model = next(
            (line.partition(":")[2].strip() for line in cpu.read_text().splitlines() if "model name" in line), model
        )
    sets = ", ".join(ks.kernels.instruction_sets())
    return f"{model}, {os.cpu_count()} cores, {sets}; Python {platform.python_version()}, NumPy {np.__version__}"


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", default="ur10,panda", help="of ur10, panda, talos")
    parser.add_argument("--quick", action="store_true", help="a tenth of the rounds: a look, not a result")
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    pin_to_one_core()
    rounds = 3 if arguments.quick else 15
    library, limit = compiled.pinocchio_library(), compiled.write_limit()
    began = time.time()
    rows: list[Row] = []
    print(f"machine: {machine()}")
    for name in arguments.robots.split(","):
        robot = subject(name)
        loop = compiled.PinocchioLoop(library, robot.model, robot.tool) if library is not None else None
        print(f"{name}: {measurements.accuracy(robot)}")
        for section in (*measurements.SECTIONS, statics.static_torques):
            found = section(robot, loop, limit, rounds)
            rows += found
            print("\n".join(table(found).splitlines()[2:]), flush=True)
        if name == "panda":
            rows += inverse_velocity.steps(robot, rounds) + inverse_velocity.inverses(robot, rounds)
    if len(cores) > 1:
        os.sched_setaffinity(0, cores)
        rows += measurements.threads(subject("panda"), rounds)
    rows += measurements.imports(rounds)
    text = f"{machine()}; {time.strftime('%Y-%m-%d')}, {time.time() - began:.0f} s\n\n{table(rows)}\n"
    print(f"\n{text}")
    if library is None:
        print("the C++ peer is missing: no compiler, or no headers of Pinocchio or Eigen", file=sys.stderr)
    if arguments.markdown:
        arguments.markdown.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
