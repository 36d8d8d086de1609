"""`kinestatics analyze ROBOT`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from ..analysis import analyze
from .app import app, show
from .arguments import AllowXacro, At, Base, Hold, Json, Robot, Roots, Seed, Tip, read_configuration, read_robot, read_wrench


@app.command("analyze")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    load: Annotated[
        str | None, typer.Option(help="Load on the robot: fx,fy,fz or fx,fy,fz,mx,my,mz [N, N m], base axes at the tip.")
    ] = None,
    push: Annotated[str | None, typer.Option(help="What the robot exerts on its surroundings; as --load.")] = None,
    task: Annotated[str, typer.Option(help="auto, full, position, orientation, or rows such as vx,vy,wz.")] = "auto",
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """What can this arm do, here? Pose, Jacobian, rank, lost directions, torques, limits."""
    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    rows = task if "," not in task else [row.strip() for row in task.split(",")]
    result = analyze(model, read_configuration(model, at, seed), read_wrench(load, push), rows)
    show(json.dumps(result.to_dict(), indent=2) if as_json else str(result))
