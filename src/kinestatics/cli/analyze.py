"""`kinestatics analyze ROBOT`."""

from __future__ import annotations

from typing import Annotated

import typer

from ..frames import TIP
from .app import app, show, show_json
from .arguments import (
    AllowXacro,
    At,
    Base,
    Hold,
    Json,
    Robot,
    Roots,
    Seed,
    Tip,
    read_configuration,
    read_loads,
    read_mounting,
    read_robot,
    with_payloads,
)

_SIX = "fx,fy,fz or fx,fy,fz,mx,my,mz [N, N m] in base axes"


@app.command("analyze", short_help="What can this arm do, here?")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    load: Annotated[list[str] | None, typer.Option(help=f"Load on the robot: {_SIX}; or link=... May be repeated.")] = None,
    push: Annotated[
        list[str] | None, typer.Option(help="What the robot exerts on its surroundings; as --load. May be repeated.")
    ] = None,
    wrench_at: Annotated[str, typer.Option(help="Link at whose origin loads and pushes act, where they name none.")] = TIP,
    payload: Annotated[
        list[str] | None,
        typer.Option(help="What the tip holds: mass or mass,x,y,z of its centre [kg, m]; or link=... May be repeated."),
    ] = None,
    mount: Annotated[str, typer.Option(help="How the base stands: floor, ceiling, wall, or roll,pitch,yaw.")] = "floor",
    task: Annotated[str, typer.Option(help="auto, full, position, orientation, or rows such as vx,vy,wz.")] = "auto",
    singularities: Annotated[bool, typer.Option(help="Find the arm's singularities, and how far they are.")] = True,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """What can this arm do, here? Pose, Jacobian, rank, lost directions, speeds, forces, torques, limits."""
    from ..analysis import analyze

    model = with_payloads(read_robot(robot, base, tip, hold, package_root, allow_xacro), payload)
    q, loads, gravity = read_configuration(model, at, seed), read_loads(load, push, wrench_at), read_mounting(mount)
    result = analyze(model, q, loads or None, task, gravity=gravity, singularities=singularities)
    show_json(result.to_dict()) if as_json else show(str(result), model)
