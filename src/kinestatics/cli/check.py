"""`kinestatics check FILE...`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .app import app, show_json
from .arguments import AllowXacro, Base, Json, Roots
from .completion import robots
from .progress import on_terminal
from .terminal import hanging, line_width, paint, printable

if TYPE_CHECKING:
    from ..robots.inspection import Inspection

_CLEAN, _FAULTY, _UNREAD = 0, 1, 2


@app.command("check")
def command(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE", help="Robot files: .urdf, .xml (MJCF), .xacro.", autocompletion=robots)
    ],
    strict: Annotated[bool, typer.Option("--strict", help="Warnings count as errors, for the exit code.")] = False,
    notes: Annotated[bool, typer.Option(help="Show notes too: what is no mistake but good to know.")] = True,
    base: Base = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """What is wrong in a robot file, and where? Each remark with file:line:column, a code and a remedy.

    An error stops the file from being read; a warning is probably a mistake: a misspelt word, a unit, a joint that cannot
    move, a missing limit, mass or mesh. Exit code: 0 nothing wrong, 1 errors (or warnings, with --strict), 2 a file that
    could not be opened.
    """
    from ..robots.inspection import inspect_robot

    found = []
    with on_terminal() as progress:
        for k, file in enumerate(files):
            if progress is not None:
                progress(f"file {k + 1} of {len(files)}", k / len(files))
            found.append(inspect_robot(file, base=base, package_roots=package_root or (), allow_xacro=allow_xacro))
    if as_json:
        show_json({"files": [inspection.to_dict() for inspection in found], **_totals(found)})
    else:
        typer.echo("\n\n".join(_text(inspection, notes) for inspection in found))
        if len(found) > 1:
            typer.echo(f"\n{_summary(found)}")
    raise typer.Exit(max(_exit_code(inspection, strict) for inspection in found))


def _exit_code(inspection: Inspection, strict: bool) -> int:
    if not inspection.opened:
        return _UNREAD
    faults = inspection.count("error") + (inspection.count("warning") if strict else 0)
    return _FAULTY if faults else _CLEAN


def _text(inspection: Inspection, notes: bool) -> str:
    """The remarks of one file, each remedy where it is first needed, and what they come to."""
    width, lines, told = line_width(), [], set()
    for remark in inspection.remarks:
        if remark.severity == "note" and not notes:
            continue
        head = f"{remark.place}: {remark.severity} {remark.code}:"
        text = hanging(_one_line(f"{head} {remark.message}"), 4, width, first=0)
        painted = paint(f"{remark.severity} {remark.code}:", remark.severity)
        lines.append(text.replace(f"{remark.severity} {remark.code}:", painted, 1))
        if remark.remedy and remark.remedy not in told:
            lines.append(hanging(_one_line(f"hint: {remark.remedy}"), 8, width, first=2))
            told.add(remark.remedy)
    about = "" if inspection.robot is None else f" ({inspection.robot}: {_counted(inspection.links, 'link')}, "
    about += "" if inspection.robot is None else f"{_counted(inspection.joints, 'joint')})"
    kind = next((kind for kind in ("error", "warning") if inspection.count(kind)), "good")
    lines.append(hanging(_one_line(f"{inspection.file}: {inspection.verdict}{about}"), 4, width, first=0))
    lines[-1] = lines[-1].replace(inspection.verdict, paint(inspection.verdict, kind), 1)
    if not inspection.complete and inspection.opened:
        lines.append("  more may come to light once this is mended")
    return "\n".join(lines)


def _one_line(text: str) -> str:
    """Safe for a terminal, and for a reader of lines: a name cannot begin a new one."""
    return printable(text.replace("\n", "\\n"))


def _counted(n: int, word: str) -> str:
    return f"{n} {word}{'s' * (n != 1)}"


def _totals(found: list[Inspection]) -> dict[str, int]:
    return {f"{severity}s": sum(one.count(severity) for one in found) for severity in ("error", "warning", "note")}


def _summary(found: list[Inspection]) -> str:
    """One line about all files."""
    clean = sum(not one.count("error") for one in found)
    counts = ", ".join(_counted(n, word.removesuffix("s")) for word, n in _totals(found).items())
    return f"{_counted(len(found), 'file')}, {clean} without errors: {counts}"
