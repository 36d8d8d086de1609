"""Symbolic Jacobians and determinants of six-joint arms: `python benchmarks/closed_forms.py`, ours against peers.

Every route runs in a process of its own, with a limit on its CPU time. Imports, and one call of each route of ours, are
before the clock runs; SymPy's cache is cleared before every run, so that no answer is remembered. Operations are SymPy's
count. What a route returns is put into numbers and compared with NumPy's. A peer is looked for in the interpreter that runs
the script, or in one named by `--toolbox` or `--moro`.
"""

from __future__ import annotations

import argparse
import json
import platform
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from functools import reduce
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

RIGHT = sp.pi / 2
a2, a3, d1, d3, d4, d5, d6 = LENGTHS = sp.symbols("a2 a3 d1 d3 d4 d5 d6", real=True)
JOINTS = sp.symbols("q1:7", real=True)
TABLES = {  # rows (a, alpha, d) of Denavit and Hartenberg's standard table
    "ur5": [(0, RIGHT, d1), (a2, 0, 0), (a3, 0, 0), (0, RIGHT, d4), (0, -RIGHT, d5), (0, 0, d6)],
    "puma": [(0, RIGHT, d1), (a2, 0, 0), (a3, -RIGHT, d3), (0, RIGHT, d4), (0, -RIGHT, 0), (0, 0, d6)],
}
NUMBERS = dict(
    zip((*JOINTS, *LENGTHS), (0.3, -0.9, 0.7, 1.1, -0.4, 0.6, 0.43, 0.37, 0.13, 0.15, 0.41, 0.09, 0.08), strict=True)
)
RUNS = 3


def model(robot: str) -> Any:
    """The arm, with symbols for its lengths."""
    import kinestatics as ks

    return ks.from_dh([(*row, 0) for row in TABLES[robot]], convention="standard")


def by_hand(robot: str, link: int = 0, origin: int = 6) -> sp.Matrix:
    """(6, 6) from products of matrices, as textbooks write it: axes of a link, 0 the base, at the origin of another."""
    frames = [sp.eye(4)]
    for (a, alpha, d), q in zip(TABLES[robot], JOINTS, strict=True):
        turn = sp.Matrix([[sp.cos(q), -sp.sin(q), 0, 0], [sp.sin(q), sp.cos(q), 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])
        c, s = sp.cos(alpha), sp.sin(alpha)
        frames.append(frames[-1] * turn * sp.Matrix([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]))
    if link:  # inverse of a product: the axes and origins before the link, seen from it, stay short
        R, p = frames[link][:3, :3].T, frames[link][:3, 3]
        frames = [sp.Matrix.vstack(sp.Matrix.hstack(R * T[:3, :3], R * (T[:3, 3] - p)), sp.eye(4)[3:, :]) for T in frames]
    tip = frames[origin][:3, 3]
    return sp.Matrix.hstack(*[sp.Matrix.vstack(T[:3, 2].cross(tip - T[:3, 3]), T[:3, 2]) for T in frames[:6]])


def in_ring(robot: str, half: bool) -> Any:
    """SymPy's ring of polynomials over the rationals, c² = 1 - s², axes of link 3 at the wrist, factored.

    `half`: after the determinant, in sines and cosines of half angles, where products are found that sines and cosines hide.
    """
    sines, cosines = sp.symbols("s2:6", real=True), sp.symbols("c2:6", real=True)
    ring, *_ = sp.ring((*cosines, *sines, *LENGTHS), sp.QQ)
    names = {f(q): x for f, xs in ((sp.sin, sines), (sp.cos, cosines)) for q, x in zip(JOINTS[1:5], xs, strict=True)}
    names |= {sp.sin(q): 0 for q in (JOINTS[0], JOINTS[5])} | {sp.cos(q): 1 for q in (JOINTS[0], JOINTS[5])}
    circle = [ring(c) ** 2 + ring(s) ** 2 - 1 for c, s in zip(cosines, sines, strict=True)]

    def reduced(p: Any) -> Any:
        return p.rem(circle)

    J = [[reduced(ring.from_expr(sp.expand(x.subs(names)))) for x in row] for row in by_hand(robot, 3, 4).tolist()]

    def laplace(rows: tuple[int, ...], column: int, known: dict[Any, Any]) -> Any:
        if column == 6:
            return ring(1)
        if rows not in known:
            terms = [(k, J[r][column]) for k, r in enumerate(rows) if J[r][column] != 0]
            minors = ((-1) ** k * x * laplace(rows[:k] + rows[k + 1 :], column + 1, known) for k, x in terms)
            known[rows] = reduced(sum(minors, ring(0)))
        return known[rows]

    whole = laplace(tuple(range(6)), 0, {})
    if not half:
        coefficient, factors = whole.factor_list()
        back = {x: f for f, x in names.items() if x not in (0, 1)}
        return sp.Mul(sp.nsimplify(coefficient), *[f.as_expr().subs(back) ** m for f, m in factors])
    return _in_half_angles(whole, ring, len(cosines))


def _in_half_angles(whole: Any, ring: Any, count: int) -> Any:
    """Factors of a polynomial in c, s after c = u² - t², s = 2 t u, 1 = t² + u²; even ones put back into c and s."""
    degrees = [max(e[k] + e[count + k] for e in whole) for k in range(count)]
    lifted = ring(0)
    for exponents, coefficient in whole.items():
        term = ring({(*[0] * 2 * count, *exponents[2 * count :]): coefficient})
        for k in range(count):
            u, t = ring.gens[k], ring.gens[count + k]
            c, s = exponents[k], exponents[count + k]
            term *= (u**2 - t**2) ** c * (2 * t * u) ** s * (u**2 + t**2) ** (degrees[k] - c - s)
        lifted += term
    coefficient, factors = lifted.factor_list()
    found = [sp.Rational(int(coefficient.numerator), int(coefficient.denominator))]
    for factor, times in factors:
        expression = factor.as_expr()
        for k, q in enumerate(JOINTS[1 : count + 1]):
            expression = expression.subs({ring.symbols[k]: sp.cos(q / 2), ring.symbols[count + k]: sp.sin(q / 2)})
        found.append(sp.trigsimp(expression) ** times if len(factor) < 60 else expression**times)
    return reduce(lambda a, b: a * b, found)


def toolbox(robot: str) -> sp.Matrix:
    """jacob0 of the Robotics Toolbox for Python at symbols, from the same table."""
    import roboticstoolbox as rtb

    arm = rtb.DHRobot([rtb.RevoluteDH(a=a, alpha=alpha, d=d) for a, alpha, d in TABLES[robot]], symbolic=True)
    return sp.Matrix(arm.jacob0(np.array(JOINTS)))


def moro(robot: str) -> sp.Matrix:
    """Robot.J of moro at symbols, from the same table; it simplifies by itself."""
    from moro import Robot

    return sp.Matrix(Robot(*[(*row, q) for row, q in zip(TABLES[robot], JOINTS, strict=True)]).J)


def our_jacobian(robot: str, frame: str) -> Any:
    """ks.closed_form of the Jacobian."""
    import kinestatics as ks

    return ks.closed_form("jacobian", model(robot), frame=ks.Frame("base", "tip") if frame == "base" else frame)


def our_determinant(robot: str) -> Any:
    """ks.singularities: factored, in the frame of a middle link."""
    import kinestatics as ks

    return ks.singularities(model(robot), "full").determinant


Route = tuple[str, str, Callable[[str], Any]]
ROUTES: dict[str, Route] = {
    "ks.closed_form, axes of the base": ("J", "kinestatics", lambda robot: our_jacobian(robot, "base")),
    "ks.closed_form, shortest frame": ("J", "kinestatics", lambda robot: our_jacobian(robot, "auto")),
    "SymPy by hand": ("J", "sympy", by_hand),
    "SymPy by hand, simplify": ("J", "sympy", lambda robot: sp.simplify(by_hand(robot))),
    "Robotics Toolbox jacob0": ("J", "roboticstoolbox-python", toolbox),
    "Robotics Toolbox jacob0, simplify": ("J", "roboticstoolbox-python", lambda robot: sp.simplify(toolbox(robot))),
    "moro J (simplifies)": ("J", "moro", moro),
    "ks.singularities": ("det", "kinestatics", our_determinant),
    "SymPy ring in c, s, link 3": ("det", "sympy", lambda robot: in_ring(robot, half=False)),
    "SymPy ring, link 3, factored in half angles": ("det", "sympy", lambda robot: in_ring(robot, half=True)),
    "SymPy by hand, det, expand": ("det", "sympy", lambda robot: sp.expand(by_hand(robot).det(method="berkowitz"))),
    "SymPy by hand, trigsimp, det, simplify": (
        "det",
        "sympy",
        lambda robot: sp.simplify(by_hand(robot).applyfunc(sp.trigsimp).det(method="berkowitz")),
    ),
    "Robotics Toolbox jacob0, det, simplify": (
        "det",
        "roboticstoolbox-python",
        lambda robot: sp.simplify(toolbox(robot).det(method="berkowitz")),
    ),
    "moro J, det, simplify": ("det", "moro", lambda robot: sp.simplify(moro(robot).det(method="berkowitz"))),
}


def truth(robot: str, frame: Any = None) -> np.ndarray[Any, Any]:
    """The Jacobian at NUMBERS: base axes at the tip, by NumPy alone; in another frame by ks.jacobian."""
    if frame is not None:
        import kinestatics as ks

        rows = [
            (float(sp.sympify(a).subs(NUMBERS)), float(alpha), float(sp.sympify(d).subs(NUMBERS)), 0.0)
            for a, alpha, d in TABLES[robot]
        ]
        return np.array(
            ks.jacobian(ks.from_dh(rows, convention="standard"), [NUMBERS[q] for q in JOINTS], frame=frame).array
        )
    T, frames = np.eye(4), [np.eye(4)]
    for (a, alpha, d), q in zip(TABLES[robot], JOINTS, strict=True):
        length, height = (float(sp.sympify(x).subs(NUMBERS)) for x in (a, d))
        c, s, ca, sa = np.cos(NUMBERS[q]), np.sin(NUMBERS[q]), np.cos(float(alpha)), np.sin(float(alpha))
        row = [[c, -s * ca, s * sa, length * c], [s, c * ca, -c * sa, length * s], [0, sa, ca, height], [0, 0, 0, 1]]
        T = T @ np.array(row)
        frames.append(T)
    columns = [np.r_[np.cross(F[:3, 2], T[:3, 3] - F[:3, 3]), F[:3, 2]] for F in frames[:6]]
    return np.array(columns).T


def one(route: str, robot: str) -> dict[str, Any]:
    """A route, in this process: seconds (median of RUNS, one where a run takes over 10 s), operations, error."""
    from sympy.core.cache import clear_cache

    kind, package, call = ROUTES[route]
    try:
        release = version(package)
    except PackageNotFoundError:
        return {"absent": True}
    if package == "kinestatics":
        call(robot)
    times: list[float] = []
    while len(times) < RUNS and sum(times) < 10:
        clear_cache()
        began = time.process_time()
        found = call(robot)
        times.append(time.process_time() - began)
    expression = getattr(found, "expression", found)
    values = np.array(sp.Matrix([expression]).subs(NUMBERS).evalf(), dtype=float) if kind == "det" else None
    if kind == "J":
        expected = truth(robot, getattr(found, "frame", None))
        error = np.abs(np.array(expression.subs(NUMBERS).evalf(), dtype=float) - expected).max()
    else:
        expected = np.linalg.det(truth(robot))
        error = abs(float(np.ravel(values)[0]) / expected - 1)
    return {
        "seconds": statistics.median(times),
        "runs": len(times),
        "operations": int(sp.count_ops(expression)),
        "error": float(error),
        "version": release,
        "sympy": sp.__version__,
    }


def measured(python: str, route: str, robot: str, limit: float) -> dict[str, Any]:
    """The same in a process of its own, stopped at the limit (CPU time; three times that by the clock)."""
    import resource

    command = [python, str(Path(__file__).resolve()), "--one", route, robot]
    stop = int(limit) + 2

    def capped() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (stop, stop + 1))

    try:
        ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=3 * stop, preexec_fn=capped)
    except (subprocess.TimeoutExpired, OSError) as problem:
        return {"late": True} if isinstance(problem, subprocess.TimeoutExpired) else {"absent": True}
    if ran.returncode == -signal.SIGXCPU:
        return {"late": True}
    if ran.returncode:
        return {"failed": (ran.stderr.strip().splitlines() or [f"signal {-ran.returncode}"])[-1]}
    return dict(json.loads(ran.stdout.splitlines()[-1]))


def line(route: str, robot: str, answer: dict[str, Any], limit: float) -> str:
    """A row of the table."""
    if "seconds" not in answer:
        what = (
            "not installed" if "absent" in answer else f"> {limit:g}" if "late" in answer else f"failed: {answer['failed']}"
        )
        return f"| {robot} | {ROUTES[route][0]} | {route} | {what} | - | - |"
    right = "yes" if answer["error"] < 1e-9 else f"off by {answer['error']:.1e}"
    return f"| {robot} | {ROUTES[route][0]} | {route} | {answer['seconds']:.3f} | {answer['operations']} | {right} |"


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of CPU time after which a route is stopped")
    parser.add_argument("--toolbox", default=sys.executable, help="interpreter that has roboticstoolbox-python")
    parser.add_argument("--moro", default=sys.executable, help="interpreter that has moro")
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    parser.add_argument("--one", nargs=2, metavar=("ROUTE", "ROBOT"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(*arguments.one)))
        return
    pythons = {"roboticstoolbox-python": arguments.toolbox, "moro": arguments.moro}
    versions = {"SymPy": sp.__version__}
    lines = ["| robot | what | route | CPU s | operations | right |", "|---|---|---|---|---|---|"]
    print("\n".join(lines))
    for kind in ("J", "det"):
        for robot in TABLES:
            for route in [name for name in ROUTES if ROUTES[name][0] == kind]:
                package = ROUTES[route][1]
                answer = measured(pythons.get(package, sys.executable), route, robot, arguments.limit)
                versions |= {package: answer["version"]} if "version" in answer and package != "sympy" else {}
                lines.append(line(route, robot, answer, arguments.limit))
                print(lines[-1], flush=True)
    used = ", ".join(f"{name} {number}" for name, number in versions.items())
    head = (
        f"Python {platform.python_version()}, {used}, {time.strftime('%Y-%m-%d')}; limit {arguments.limit:g} s of CPU time"
    )
    if arguments.markdown:
        arguments.markdown.write_text(f"{head}\n\n" + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
