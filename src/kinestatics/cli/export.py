"""`kinestatics export ROBOT`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import UnknownNameError, nearest
from ..frames import BASE, TIP, Frame
from .app import app, show, show_json
from .arguments import AllowXacro, Base, Hold, Json, Link, Robot, Roots, Tip, read_robot
from .completion import words
from .progress import on_terminal

_QUANTITIES = (
    *("pose", "jacobian", "velocity", "acceleration", "gravity_torques", "joint_torques"),
    *("determinant", "minors"),
)
_LANGUAGES = ("text", "latex", "steps", "numpy", "jax", "c", "cpp", "matlab", "octave")
_FRAMES = ("geometric", "body", "spatial", "auto")
_OF_NO_FRAME = ("pose", "gravity_torques", "determinant", "minors")


@app.command("export")
def command(
    robot: Robot,
    quantity: Annotated[
        str, typer.Option(help=f"What is wanted: {', '.join(_QUANTITIES)}.", autocompletion=words(*_QUANTITIES))
    ] = "jacobian",
    language: Annotated[
        str,
        typer.Option(
            "--as",
            help="text, latex, steps (a derivation in LaTeX), numpy, jax, c, cpp, matlab or octave.",
            autocompletion=words(*_LANGUAGES),
        ),
    ] = "text",
    base: Base = None,
    tip: Tip = None,
    link: Link = TIP,
    frame: Annotated[
        str,
        typer.Option(
            help="geometric, body, spatial, or auto: the shortest of them and of the links between.",
            autocompletion=words(*_FRAMES),
        ),
    ] = "geometric",
    task: Annotated[
        str | None,
        typer.Option(
            help="Rows, as in analyze; default all, of determinants those that move.",
            autocompletion=words("auto", "full", "position", "orientation"),
        ),
    ] = None,
    named: Annotated[bool, typer.Option("--named", help="Names for lengths: a2, d4, ... after Denavit-Hartenberg.")] = False,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write to this file.")] = None,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """The arm's formulas in their shortest form: as text, LaTeX, a derivation, or code."""
    from ..symbolic.closed_form import closed_form
    from ..symbolic.code import generate_code
    from ..symbolic.latex import to_latex

    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    if language not in _LANGUAGES:
        raise UnknownNameError("KS395", f"nothing is written as {language!r}", nearest(language, _LANGUAGES))
    wanted = _frame(frame, link) if quantity not in _OF_NO_FRAME else "auto"
    with on_terminal("finding the shortest form"):
        form = closed_form(quantity, model, at=link, frame=wanted, task=task, lengths="symbols" if named else "numbers")
        if language == "text":
            text = str(form)
        elif language in ("latex", "steps"):
            text = to_latex(form, steps=language == "steps")
        else:
            text = generate_code(form, language)
    if output is not None:
        output.write_text(text.rstrip("\n") + "\n", encoding="utf-8")
    if as_json:
        show_json({**form.to_dict(), "as": language, "text": text})
    elif output is None:
        show(text.rstrip("\n"), model)


def _frame(name: str, link: str) -> Frame | str:
    """The frame by its word."""
    if name not in _FRAMES:
        raise UnknownNameError("KS393", f"frame {name!r} is not known", nearest(name, _FRAMES) or ", ".join(_FRAMES))
    frames: dict[str, Frame | str] = {"geometric": Frame(BASE, link), "body": Frame.body(link), "spatial": Frame.spatial()}
    return frames.get(name, name)
