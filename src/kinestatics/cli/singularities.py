"""`kinestatics singularities ROBOT`."""

from __future__ import annotations

from typing import Annotated

import typer

from ..frames import TIP
from .app import app, show, show_json
from .arguments import (
    AllowXacro,
    Base,
    Hold,
    Json,
    Link,
    Robot,
    Roots,
    Seed,
    Task,
    Tip,
    read_configuration,
    read_robot,
)
from .completion import words
from .progress import on_terminal


@app.command("singularities")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    link: Link = TIP,
    task: Task = "auto",
    at: Annotated[
        list[str] | None,
        typer.Option(
            help="Posture whose card is wanted: home, random, or numbers. May be repeated.",
            autocompletion=words("home", "zero", "random"),
        ),
    ] = None,
    boundary: Annotated[bool, typer.Option(help="Search other branches for the workspace boundary, 5 s a card.")] = False,
    tolerance: Annotated[float, typer.Option(help="Angles [rad] this close to right ones are taken for them.")] = 1e-5,
    budget: Annotated[
        float, typer.Option(help="Seconds after which redundant arms' conditions are no longer split.")
    ] = 20.0,
    seed: Seed = 0,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """Where is this arm singular? The determinant in factors, each singularity by name, and cards of postures."""
    from ..singular_sets import singularities

    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    with on_terminal("looking for singularities") as progress:
        found = singularities(model, task, at=link, tolerance=tolerance, budget=budget, progress=progress)
    with on_terminal("drawing up cards"):
        cards = [found.at(read_configuration(model, posture, seed), boundary=boundary) for posture in at or ()]
    if as_json:
        show_json({**found.to_dict(), "cards": [card.to_dict() for card in cards]})
    else:
        show("\n\n".join(map(str, [found, *cards])), model)
