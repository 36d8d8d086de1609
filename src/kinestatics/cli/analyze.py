"""`kinestatics analyze ROBOT`."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ConfigurationError
from ..frames import TIP
from .app import app, show, show_json
from .arguments import (
    AllowXacro,
    At,
    Base,
    Hold,
    Json,
    Loads,
    Mount,
    Payloads,
    Pushes,
    Robot,
    Roots,
    Seed,
    Task,
    Tip,
    WrenchAt,
    read_configuration,
    read_loads,
    read_mounting,
    read_robot,
    with_payloads,
)
from .progress import on_terminal

if TYPE_CHECKING:
    from ..analysis import Analysis

_ENDINGS = (".html", ".htm", ".pdf")


@app.command("analyze")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    load: Loads = None,
    push: Pushes = None,
    wrench_at: WrenchAt = TIP,
    payload: Payloads = None,
    mount: Mount = "floor",
    task: Task = "auto",
    singularities: Annotated[bool, typer.Option(help="Find the arm's singularities, and how far they are.")] = True,
    report: Annotated[Path | None, typer.Option(help="Write a report to this file: a page (.html) or .pdf.")] = None,
    interactive: Annotated[
        bool, typer.Option("--interactive", help="Figures to turn in the report: 5 MB, and script.")
    ] = False,
    scene: Annotated[bool, typer.Option("--scene", help="The arm in 3-D in the report: some MB, and script.")] = False,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """What can this arm do, here? Pose, Jacobian, rank, lost directions, speeds, forces, torques, limits."""
    from ..analysis import analyze

    _check_report(report, interactive, scene)
    model = with_payloads(read_robot(robot, base, tip, hold, package_root, allow_xacro), payload)
    q, loads, gravity = read_configuration(model, at, seed), read_loads(load, push, wrench_at), read_mounting(mount)
    with on_terminal("analyzing"):
        result = analyze(model, q, loads or None, task, gravity=gravity, singularities=singularities)
        told = "" if report is None else _write_report(result, report, interactive, scene, seed if at == "random" else None)
    show_json(result.to_dict()) if as_json else show(told or str(result), model)


def _check_report(report: Path | None, interactive: bool, scene: bool) -> None:
    """Before anything is computed: whether a report could be written.

    Raises:
        ConfigurationError: KS410, KS411, KS413, KS414.
    """
    if report is None:
        if interactive or scene:
            option = "--interactive" if interactive else "--scene"
            raise ConfigurationError("KS414", f"{option} is of a report", "add --report out.html")
        return
    if report.suffix.lower() not in _ENDINGS:
        raise ConfigurationError("KS410", f"--report {report}: a report is a page or PDF", "end its name in .html or .pdf")
    if report.is_dir():
        raise ConfigurationError("KS411", f"--report {report}: is a folder", f"--report {report / 'out.html'}")
    if not report.parent.is_dir():
        raise ConfigurationError("KS411", f"--report {report}: there is no folder {report.parent}", "make it first")
    if report.suffix.lower() == ".pdf" and (interactive or scene):
        raise ConfigurationError("KS413", "a PDF stands still: it has no figures to turn and no scene", "--report out.html")


def _write_report(result: Analysis, file: Path, interactive: bool, scene: bool, seed: int | None) -> str:
    """Writes the report; says where it is, and what it found."""
    from .. import report
    from ..report.findings import remarks_of

    command = _question(sys.argv[1:])
    if file.suffix.lower() == ".pdf":
        data = report.pdf(result, command=command, seed=seed)
    else:
        data = report.html(result, interactive=interactive, scene=scene, command=command, seed=seed).encode()
    part = file.with_name(f".{file.name}.{os.getpid()}.part")  # readers see the old report or the new one, and no half
    try:
        part.write_bytes(data)
        os.replace(part, file)
    finally:
        part.unlink(missing_ok=True)
    found = [f"  {remark.severity}: {remark.title}" for remark in remarks_of(result)]
    size = f"{len(data) / 1e6:.1f} MB" if len(data) >= 1e6 else f"{len(data) / 1e3:.0f} kB"
    return "\n".join([f"report: {file} ({size})", *(found or ["  no findings: nothing is near a limit or missing"])])


def _question(words: list[str]) -> str:
    """What was typed, without where the report goes: the same question makes the same page."""
    kept, skip = [], False
    for word in words:
        if not skip and word != "--report" and not word.startswith("--report="):
            kept.append(word)
        skip = word == "--report" and not skip
    return f"kinestatics {shlex.join(kept)}"
