"""`kinestatics jacobian ROBOT`."""

from __future__ import annotations

import json
from typing import Annotated

import numpy as np
import typer

from ..frames import BASE, TIP, Frame
from ..kinematics import jacobian
from .app import app, show
from .arguments import AllowXacro, At, Base, Hold, Json, Robot, Roots, Seed, Tip, read_configuration, read_robot


@app.command("jacobian")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    axes: Annotated[str, typer.Option(help="Link whose axes are used: base, tip or any link.")] = BASE,
    origin: Annotated[str, typer.Option(help="Link at whose origin the linear part is taken: base, tip or any link.")] = TIP,
    convention: Annotated[
        str | None,
        typer.Option(help="Write it as another library does, for example pinocchio.WORLD or modern_robotics.body."),
    ] = None,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """The Jacobian of the tip, in any axes, at any point, in any library's convention."""
    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    J = jacobian(model, read_configuration(model, at, seed), frame=Frame(axes, origin))
    if convention is not None:
        array = J.to_array(convention=convention)
        output = {"convention": convention, "joints": list(J.joint_names), "array": array.tolist()}
        show(json.dumps(output, indent=2) if as_json else np.array2string(array, precision=6, suppress_small=True))
        return
    output = {
        "robot": model.name,
        "joints": list(J.joint_names),
        "array": np.asarray(J).tolist(),
        "axes": J.frame.axes,
        "origin": J.frame.origin,
        "rows": list(J.rows),
    }
    show(json.dumps(output, indent=2) if as_json else str(J))
