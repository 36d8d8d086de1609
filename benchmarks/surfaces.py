"""How long the surfaces take; needs the dev extra and Chromium: `python benchmarks/surfaces.py` writes surfaces.md.

Beside every figure stands the time of a plain loop of Python, taken in between: machines differ, and one machine from
minute to minute.
"""

import statistics
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import numpy as np

import kinestatics as ks
from kinestatics.explorer import explore

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from browser import chromium, wait_until  # noqa: E402

SHARE = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share"
PANDA = SHARE / "example-robot-data" / "robots" / "panda_description" / "urdf" / "panda.urdf"
COMMAND = str(Path(sys.executable).with_name("kinestatics"))
RUNS = 5


def loop():
    """Seconds of a million additions."""
    began, total = time.thread_time(), 0
    for k in range(1_000_000):
        total += k
    return time.thread_time() - began


def refresh(model, home):
    """Milliseconds of processor time from a changed joint to all that is sent, tables aside, and of these."""
    with explore(model, home, wrench=ks.Wrench.on_robot(force=(0, 0, -50))) as explorer:
        explorer.page.singular.worker.wait(120)
        explorer.page.singular.worker.stop()
        session, q = explorer.session, np.array(explorer.session.situation.q)
        changes, tables = [], []
        for k in range(200):
            moved = q.copy()
            moved[k % len(q)] += 1e-3 * np.sin(0.1 * k)
            began = time.thread_time()
            session.change(q=moved)
            changes.append(time.thread_time() - began)
            explorer.page.writer.wait(5)
            began = time.thread_time()
            explorer.page._write()
            tables.append(time.thread_time() - began)
    return 1e3 * statistics.median(changes), 1e3 * statistics.median(tables)


def commands():
    """Seconds of processor time and by the clock of whole commands, interleaved."""
    with tempfile.TemporaryDirectory() as folder:
        asked = {
            "python -c pass": [sys.executable, "-c", "pass"],
            "kinestatics --help": [COMMAND, "--help"],
            "kinestatics analyze --help": [COMMAND, "analyze", "--help"],
            "kinestatics analyze ur5e": [COMMAND, "analyze", "ur5e"],
            "kinestatics analyze ur5e --report": [COMMAND, "analyze", "ur5e", "--report", f"{folder}/a.html"],
            "kinestatics analyze panda --report": [COMMAND, "analyze", "panda", "--report", f"{folder}/b.html"],
        }
        taken = {name: [] for name in asked}
        for _ in range(RUNS):
            for name, words in asked.items():
                before, began = getrusage(RUSAGE_CHILDREN), time.perf_counter()
                subprocess.run(words, check=True, capture_output=True)
                after = getrusage(RUSAGE_CHILDREN)
                used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
                taken[name].append((used, time.perf_counter() - began))
    return {name: tuple(map(statistics.median, zip(*pairs, strict=True))) for name, pairs in taken.items()}


def page():
    """Seconds until a page is usable, and until a key on a slider shows; drawn in software."""
    usable, shown = [], []
    with explore(ks.load("ur5e")) as explorer, chromium() as browser:
        explorer.page.singular.worker.wait(120)
        for _ in range(RUNS):
            began = time.perf_counter()
            tab = browser.page_of(explorer.address + "&fixedDpr=0.5")
            tab.page.locator("[data-quantity=ready]").wait_for(state="attached", timeout=120_000)
            usable.append(time.perf_counter() - began)
            tab.page.wait_for_timeout(3000)
            verdict, slider = tab.page.locator("[data-quantity=verdict]"), tab.page.locator("[role=slider]").nth(1)
            for _ in range(5):
                before, began = verdict.get_attribute("data-least"), time.perf_counter()
                slider.press("ArrowRight")
                wait_until(lambda v=verdict, b=before: v.get_attribute("data-least") != b, pause=lambda: None)
                shown.append(time.perf_counter() - began)
            browser.close_pages()
    return statistics.median(usable), statistics.median(shown)


def main():
    lines = ["# How long the surfaces take", "", f"Written by `benchmarks/surfaces.py`; medians of {RUNS} runs or more.", ""]
    lines += ["| what | processor | by the clock | a million additions then |", "|---|---|---|---|"]
    arms = {
        "ur5e": (ks.load("ur5e"), None),
        "panda, meshes": (
            ks.load(PANDA, tip="panda_hand_tcp", package_roots=[SHARE]),
            [0, -0.785, 0, -2.356, 0, 1.571, 0.785],
        ),
        "planar_2r": (ks.load("planar_2r"), None),
    }
    for name, (model, home) in arms.items():
        beside = loop()
        change, tables = refresh(model, home)
        lines.append(f"| explorer, a joint changed, {name} | {change:.1f} ms | | {1e3 * (beside + loop()) / 2:.0f} ms |")
        lines.append(f"| its tables, written after that | {tables:.1f} ms | | |")
    beside = loop()
    for name, (used, clock) in commands().items():
        lines.append(f"| `{name}` | {used:.2f} s | {clock:.2f} s | {1e3 * beside:.0f} ms |")
    beside = loop()
    usable, shown = page()
    lines.append(f"| explorer usable in the browser, software rendering | | {usable:.1f} s | {1e3 * beside:.0f} ms |")
    lines.append(f"| a key on a slider until the verdict has changed | | {shown:.2f} s | {1e3 * loop():.0f} ms |")
    text = "\n".join(lines) + "\n"
    (ROOT / "benchmarks" / "surfaces.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
