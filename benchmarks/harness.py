"""Timing that means something on a noisy machine: contestants take turns in one process, CPU time, medians.

Ratios of one run are what counts; absolute times move by tens of per cent between runs and machines.
"""

from __future__ import annotations

import gc
import os
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

Contestant = tuple[Callable[[], object], int]
"""What to call, and how many configurations one call computes."""


@dataclass(frozen=True)
class Row:
    """A line of the table.

    Attributes:
        robot, quantity: what was computed.
        ours, peer: names; ours_ns, peer_ns: medians for one configuration [ns].
        goal: the ratio peer / ours to reach (or, where `at_most`, not to exceed), None where there is none.
        at_most: whether a smaller ratio is better (ours / peer is shown then).
    """

    robot: str
    quantity: str
    ours: str
    peer: str
    ours_ns: float
    peer_ns: float
    goal: float | None = None
    at_most: bool = False

    @property
    def ratio(self) -> float:
        """peer / ours, or ours / peer where less is better."""
        return self.ours_ns / self.peer_ns if self.at_most else self.peer_ns / self.ours_ns

    @property
    def verdict(self) -> str:
        """ "reached", "short" or "" where no goal was set."""
        if self.goal is None:
            return ""
        reached = self.ratio <= self.goal if self.at_most else self.ratio >= self.goal
        return "reached" if reached else "short"


def pin_to_one_core() -> None:
    """Keeps this process on one core, where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def interleaved(
    contestants: Mapping[str, Contestant], rounds: int = 11, clock: Callable[[], float] = time.process_time
) -> dict[str, float]:
    """Median time of one configuration [ns]; in every round each contestant runs once, for at least a few milliseconds."""
    repeats = {name: _repeats(call, clock) for name, (call, _) in contestants.items()}
    times: dict[str, list[float]] = {name: [] for name in contestants}
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, (call, count) in contestants.items():
                began = clock()
                for _ in range(repeats[name]):
                    call()
                times[name].append((clock() - began) / repeats[name] / count * 1e9)
    finally:
        gc.enable()
    return {name: statistics.median(values) for name, values in times.items()}


def _repeats(call: Callable[[], object], clock: Callable[[], float], least: float = 4e-3) -> int:
    """How often to call, after warming up, so that a round is long against the clock's resolution."""
    call()
    repeats = 1
    while True:
        began = clock()
        for _ in range(repeats):
            call()
        if (spent := clock() - began) >= least:
            return repeats
        repeats = max(repeats * 2, int(repeats * least / max(spent, 1e-6)))


def table(rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = ["| robot | quantity | ours | ns | peer | ns | ratio | goal | |", "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        goal = "" if row.goal is None else f"{'<=' if row.at_most else '>='} {row.goal:g}"
        lines.append(
            f"| {row.robot} | {row.quantity} | {row.ours} | {row.ours_ns:.1f} | {row.peer} | {row.peer_ns:.1f} "
            f"| {row.ratio:.3g}{'' if row.at_most else ' x'} | {goal} | {row.verdict} |"
        )
    return "\n".join(lines)
