"""Singular sets in time and to the letter: `python benchmarks/singular_sets.py --proof`.

Times are CPU time of this process, medians of three warm runs with SymPy's cache cleared before each; the command line is a
process of its own. `--proof` puts every robot of tests/golden/singular_robots.json, and redundant arms besides, before the
judges of `singular_proofs.py`. Seeds are fixed.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import math
import os
import platform
import statistics
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from singular_proofs import Found, judge_distances, judge_minima, judge_points, values_at

import kinestatics as ks

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from singular_robots import DATA, ROBOTS, expected, numeric, random_lengths, symbolic, task_of

FACTORED = ("ur5", "puma560", "stanford_SHV", "kuka_kr5", "abb_irb140", "anthropomorphic_6R", "elbow_RRR")
OFFSETS = "generic_6R_orthogonal_offsets"
RUNS, Q, MINIMA, POSTURES, STARTS = 3, 1000, 200, 50, 100
HEAD = "| what | measured | goal | |\n|---|---|---|---|"


def verdict(reached: bool) -> str:
    """The last column."""
    return "reached" if reached else "short"


def seconds(call: Callable[[], Any]) -> tuple[float, Any]:
    """Median CPU time of RUNS warm calls, nothing remembered by SymPy; and what the last returned."""
    from sympy.core.cache import clear_cache

    call()
    times = []
    for _ in range(RUNS):
        clear_cache()
        began = time.process_time()
        answer = call()
        times.append(time.process_time() - began)
    return statistics.median(times), answer


def whole(arm: ks.RobotModel, task: Any = "auto", **options: Any) -> Any:
    """A singular set with everything that is put off until it is asked for: determinant, samples, names."""
    found = ks.singularities(arm, task, **options)
    str(found)
    return found


def of_file(pattern: str, tip: str) -> ks.RobotModel | None:
    """An arm of the package example-robot-data; None where it is not installed."""
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    path = next((Path(str(file.locate())) for file in files if str(file).endswith(pattern)), None)
    return None if path is None else ks.load(path.resolve(), tip=tip)


def timed() -> list[str]:
    """The rows of the table of times."""
    lines = []

    def row(what: str, spent: float, goal: float, more: str = "") -> None:
        lines.append(f"| {what} | {spent:.3f} s{more} | < {goal:g} s | {verdict(spent < goal)} |")
        print(lines[-1], flush=True)

    for name in FACTORED:
        arm, task = symbolic(ROBOTS[name]), task_of(ROBOTS[name])
        spent, found = seconds(lambda arm=arm, task=task: whole(arm, task))
        factors = sum(bool(equation.columns) for equation, _ in found.factors)
        operations = sp.count_ops(found.determinant)
        row(f"{name}, symbols for lengths", spent, 0.5, f"; {factors} factors, {operations} operations")
        if name == "ur5":
            lines.append(f"| ur5, operations | {operations} | <= 25 | {verdict(operations <= 25)} |")
    offsets = symbolic(ROBOTS[OFFSETS])
    spent, text = seconds(lambda: ks.to_latex(ks.singularities(offsets, "full").determinant))
    row("orthogonal 6R, all offsets, symbols, with LaTeX", spent, 2.0, f"; {len(text)} characters")
    symbols = [sp.symbols(f"{letter}1:7", real=True) for letter in ("a", "alpha", "d")]
    general = ks.from_dh([(*row, 0) for row in zip(*symbols, strict=True)], convention="standard")
    spent, form = seconds(lambda: ks.closed_form("determinant", general))
    row("general 6R, all a, alpha, d symbols: closed_form", spent, 3.0, f"; {form.operations} operations")
    spent, found = seconds(lambda: ks.singularities(general, "full"))
    row("general 6R, all symbols: singularities", spent, 3.0, f"; {len(found.factors)} factor")
    for name, task in (("iiwa_SRS", "full"), ("panda_FR3", "full")):
        spent, found = seconds(lambda name=name, task=task: whole(numeric(ROBOTS[name]), task))
        row(f"{name}, components", spent, 3.0, f"; {len(found.components)}, complete {found.complete}")
    for name in ("iiwa_14", "panda", "gen3"):
        spent, found = seconds(lambda name=name: whole(ks.load(name)))
        row(f"catalogue {name}, components", spent, 3.0, f"; {len(found.components)}, complete {found.complete}")
    arm = of_file("ur_description/urdf/ur5_robot.urdf", "tool0")
    if arm is None:
        lines.append("| UR5 from its URDF of floats | example-robot-data is not installed | < 1 s | |")
    else:
        spent, found = seconds(lambda: whole(arm))
        row("UR5 from its URDF of floats", spent, 1.0, f"; {', '.join(c.name for c in found.components)}")
    rounded = ks.from_dh(_rounded(), convention="standard")
    spent, found = seconds(lambda: whole(rounded))
    row("UR5 with 1.570796 for right angles", spent, 1.0, f"; {', '.join(c.name for c in found.components)}")
    used, wall = cold("puma_560")
    row("cold: kinestatics singularities puma_560, CPU", used, 4.0, f" ({wall:.2f} s by the clock)")
    return lines


def _rounded() -> list[tuple[float, float, float, float]]:
    known = ROBOTS["ur5"]["params"]
    angles = {90: 1.570796, -90: -1.570796, 0: 0.0}
    rows = ROBOTS["ur5"]["dh"]["rows"]
    return [(float(known.get(a, 0.0)), angles[alpha], float(known.get(d, 0.0)), 0.0) for a, alpha, d, *_ in rows]


def cold(robot: str) -> tuple[float, float]:
    """User and system time of the command line, and the clock's, medians of RUNS."""
    command = [
        sys.executable,
        "-c",
        "from kinestatics.cli import main; import sys; sys.exit(main())",
        "singularities",
        robot,
    ]
    used, walls = [], []
    for _ in range(RUNS):
        before, began = os.times(), time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        after = os.times()
        walls.append(time.perf_counter() - began)
        used.append(after.children_user + after.children_system - before.children_user - before.children_system)
    return statistics.median(used), statistics.median(walls)


def determinants(name: str, result: Found) -> int:
    """The determinant against NumPy's and the file's formula, at the file's lengths and three sets of others."""
    robot, rng = ROBOTS[name], np.random.default_rng(11)
    model, sets = symbolic(robot), 0
    for lengths in [robot["params"], *(random_lengths(robot, rng) for _ in range(3 if robot["params"] else 0))]:
        arm = numeric(robot, lengths)
        found = ks.singularities(model or arm, task_of(robot), lengths=lengths if model else "auto")
        q = found.space.random(Q, int(rng.integers(1 << 31)))
        known = dict(lengths) if model else {str(s): float(v) for s, v in found.lengths.items()}
        ours = values_at(found.determinant, arm.n, q, known)
        truth = np.linalg.det(ks.jacobian(arm, q, check_finite=False).array[:, list(found.task.rows)])
        scale = np.abs(truth).max()
        result.determinant = max(result.determinant or 0.0, float(np.abs(ours - truth).max() / scale))
        formula = np.abs(expected(robot["det"], lengths, q) - truth).max() / scale
        result.formula = max(result.formula or 0.0, float(formula))
        sets += 1
    return sets


def proved(name: str, arm: ks.RobotModel, task: Any, distances: bool = True) -> tuple[Found, Any]:
    """Everything the judges say of one arm; what they contradict is printed."""
    found, result = ks.singularities(arm, task), Found()
    judge_points(result, found, MINIMA, 1)
    if not found.never:
        for posture in judge_minima(result, found, MINIMA, 2):
            print(f"  {name}: no component at {posture.tolist()}", flush=True)
    if distances and found.components:
        for wrong in judge_distances(result, found, POSTURES, STARTS, 3):
            print(f"  {name}: component, q, ours, bound, shortest: {wrong}", flush=True)
    return result, found


def proofs() -> list[str]:
    """The table of the judges, a line for each arm."""
    lines = [
        "| robot | det: off NumPy's | file's formula | components | points that keep rank | minima missed, furthest "
        "| distances: longer and shorter, largest gap | bounds above | ms a posture |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, robot in ROBOTS.items():
        tasks = [("", robot["params"])]
        tasks += [(" at other lengths", random_lengths(robot, np.random.default_rng(5)))] if robot["params"] else []
        for which, lengths in tasks:
            result, found = proved(name + which, numeric(robot, lengths), task_of(robot), not which)
            if robot.get("det") and not which:
                determinants(name, result)
            lines.append(_judged(name + which, result, found))
            print(lines[-1], flush=True)
    others = {name: ks.load(name) for name in ("iiwa_14", "panda", "gen3")}
    others["baxter, left arm"] = of_file("baxter_description/urdf/baxter.urdf", "left_wrist")
    for name, arm in others.items():
        if arm is None:
            lines.append(f"| {name} | example-robot-data is not installed |" + " |" * 7)
            continue
        result, found = proved(name, arm, "auto")
        lines.append(_judged(name, result, found))
        print(lines[-1], flush=True)
    return lines


def _judged(name: str, r: Found, found: Any) -> str:
    det, formula = (("-" if x is None else f"{x:.1e}") for x in (r.determinant, r.formula))
    some = f"{r.longer} and {r.shorter} of {r.asked}, {r.gap:.0e}" if r.asked else "-"
    complete = "" if found.complete else ", time ran out"
    return (
        f"| {name} | {det} | {formula} | {len(found.components)}{complete} | {r.unsound} of {r.points} ({r.worst:.0e}) "
        f"| {r.missed} of {r.minima}, {r.apart:.0e} | {some} | {r.over} | {1e3 * r.seconds:.1f} |"
    )


def classes() -> list[str]:
    """Second-order classes: those of the file's components at samples, and the planar arms posture by posture."""
    lines = ["| posture | class | the study's |", "|---|---|---|"]
    for name, robot in ROBOTS.items():
        if not robot.get("det"):
            continue
        found = ks.singularities(numeric(robot), task_of(robot))
        for component in found.components:
            kinds = Counter(_class(found.at(q, tolerance=1e-8)) for q in component.points)
            texts = [c for c in robot["components"] if c["real_points_found"]]
            match = [c for c in texts if np.abs(expected(c["equations"][0], robot["params"], component.points)).max() < 1e-9]
            known = match[0]["second_order_type_counts"] if match else {}
            lines.append(f"| {name}, {component.label} | {_counts(kinds)} | {_counts(known)} |")
            print(lines[-1], flush=True)
    for lengths, known in ROBOTS["planar3R_position_only"]["second_order"].items():
        a = [float(x) for x in lengths.partition("(")[2].rstrip(")").split(",")]
        found = ks.singularities(ks.from_dh([(x, 0, 0, 0) for x in a], convention="standard"), ("vx", "vy"))
        for angles, kind in known.items():
            posture = [math.pi * (text == "pi") for text in angles.strip("()").split(",")]
            second = found.at([0.3, *posture]).second_order
            values = ", ".join(f"{x:.4f}" for x in second.scale * second.eigenvalues)
            lines.append(f"| planar 3R {lengths}, (q2, q3) = {angles} | {second.kind} ({values}) | {kind} |")
            print(lines[-1], flush=True)
    return lines


def _class(card: Any) -> str:
    second = card.second_order
    if second is None:
        return "regular"
    return (
        f"{second.kind}{'' if second.corank == 1 else f' (corank {second.corank})'}{'' if second.decided else ' undecided'}"
    )


def _counts(kinds: Any) -> str:
    return ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items()))


def counted() -> list[str]:
    """Cusps and aspects."""
    lines = [HEAD]

    def row(what: str, measured: str, goal: str, reached: bool) -> None:
        lines.append(f"| {what} | {measured} | {goal} | {verdict(reached)} |")
        print(lines[-1], flush=True)

    found = ks.singularities(numeric(ROBOTS["orthogonal_3R_cuspidal"]), "position")
    began = time.process_time()
    cusps, listed = found.cusps(), DATA["facts"]["cuspidal_3R"]["cusps_rho_z"]
    spent = time.process_time() - began
    off = max(min(math.hypot(c.radius - r, c.height - h) for c in cusps) for r, h in listed)
    rest = max(c.residual for c in cusps)
    places = "; ".join(f"({c.radius:.6f}, {c.height:.6f})" for c in cusps)
    text = f"{len(cusps)} in {spent:.2f} s: {places}; residual {rest:.0e}, {off:.3f} from the study's"
    row(
        "cusps of the orthogonal 3R (r, z)", text, "4, residual < 1e-9, 0.02", len(cusps) == 4 and rest < 1e-9 and off < 0.02
    )
    for name, count in (("puma560", 8), ("ur5", 8), ("kuka_kr5", 8), ("fanuc_crx10ia_l", 2), ("orthogonal_3R_cuspidal", 2)):
        found = ks.singularities(numeric(ROBOTS[name]), task_of(ROBOTS[name]))
        began = time.process_time()
        aspects = found.aspects()
        spent = time.process_time() - began
        text = f"{aspects.count} in {spent:.1f} s, {'proved' if aspects.proved else 'measured'}"
        row(f"aspects, {name}", text, f"{count}, < 60 s", aspects.count == count and spent < 60)
    return lines


PARTS: dict[str, tuple[str, Callable[[], list[str]]]] = {
    "times": ("Times", lambda: [HEAD, *timed()]),
    "counts": ("Cusps and aspects", counted),
    "classes": ("Second order", classes),
    "judges": ("Judges", proofs),
}


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--proof", action="store_true", help="the judges too: about a quarter of an hour of CPU time")
    parser.add_argument("--parts", nargs="+", choices=PARTS, help="these alone")
    parser.add_argument("--markdown", type=Path, help="also write the tables to this file")
    arguments = parser.parse_args()
    versions = {"Python": platform.python_version(), "NumPy": np.__version__, "SymPy": sp.__version__}
    used = ", ".join(f"{name} {number}" for name, number in versions.items())
    text = [f"{used}, kinestatics {importlib.metadata.version('kinestatics')}, {time.strftime('%Y-%m-%d')}"]
    for part in arguments.parts or (PARTS if arguments.proof else ["times"]):
        title, table = PARTS[part]
        text += [f"## {title}", "\n".join(table())]
    if arguments.markdown:
        arguments.markdown.write_text("# Singular sets, measured\n\n" + "\n\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
