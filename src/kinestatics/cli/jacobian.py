"""`kinestatics jacobian ROBOT`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..frames import BASE, TIP, Frame
from .app import app, show, show_json
from .arguments import AllowXacro, At, Base, Hold, Json, Robot, Roots, Seed, Tip, read_configuration, read_robot
from .completion import conventions, links_or_ends

if TYPE_CHECKING:
    from ..namespaces import Array


@app.command("jacobian")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    axes: Annotated[
        str, typer.Option(help="Link whose axes are used: base, tip or any link.", autocompletion=links_or_ends)
    ] = BASE,
    origin: Annotated[
        str,
        typer.Option(
            help="Link at whose origin the linear part is taken: base, tip or any link.", autocompletion=links_or_ends
        ),
    ] = TIP,
    convention: Annotated[
        str | None,
        typer.Option(
            help="Write it as another library does, for example pinocchio.WORLD or modern_robotics.body.",
            autocompletion=conventions,
        ),
    ] = None,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
    as_json: Json = False,
) -> None:
    """The Jacobian of the tip, in any axes, at any point, in any library's convention."""
    import numpy as np

    from ..conventions import find_convention
    from ..errors import ConfigurationError
    from ..kinematics import jacobian

    if convention is not None and (axes, origin) != (BASE, TIP):
        hint = "leave out --axes and --origin, or --convention"
        raise ConfigurationError("KS319", f"convention {convention!r} already says axes and origin", hint)
    model = read_robot(robot, base, tip, hold, package_root, allow_xacro)
    J = jacobian(model, read_configuration(model, at, seed), frame=Frame(axes, origin))
    if convention is not None:
        array = J.to_array(convention=convention)
        c = find_convention(convention)
        if as_json:
            said = {"convention": c.name, "order": c.order, "axes": c.axes, "origin": c.origin, "layout": c.layout}
            show_json({"robot": model.name, **said, "joints": list(J.joint_names), "array": array.tolist()})
        else:
            show(f"{c.name}: {c.order} rows, axes of {c.axes}, at the origin of {c.origin}, {c.layout}")
            rounded: Array = np.round(array, 6) + 0.0  # no minus before a rounded zero
            show(np.array2string(rounded, precision=6, suppress_small=True, max_line_width=1000, threshold=10**9))
        return
    if not as_json:
        show(str(J), model)
        return
    output = {
        "robot": model.name,
        "joints": list(J.joint_names),
        "array": np.asarray(J).tolist(),
        "axes": J.frame.axes,
        "origin": J.frame.origin,
        "rows": list(J.rows),
    }
    show_json(output)
