"""`kinestatics analyze ROBOT`."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app, show, show_json
from .arguments import AllowXacro, At, Base, Hold, Json, Robot, Roots, Seed, Tip, read_configuration, read_robot, read_wrench


@app.command("analyze", short_help="What can this arm do, here?")
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
    from ..analysis import analyze

    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    result = analyze(model, read_configuration(model, at, seed), read_wrench(load, push), task)
    show_json(result.to_dict()) if as_json else show(str(result), model)
