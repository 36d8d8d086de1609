"""`kinestatics explore ROBOT`."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app, show
from .arguments import (
    AllowXacro,
    At,
    Base,
    Hold,
    Mount,
    Payloads,
    Robot,
    Roots,
    Seed,
    Tip,
    read_configuration,
    read_mounting,
    read_robot,
    with_payloads,
)


@app.command("explore")
def command(
    robot: Robot,
    base: Base = None,
    tip: Tip = None,
    at: At = "home",
    seed: Seed = 0,
    payload: Payloads = None,
    mount: Mount = "floor",
    host: Annotated[
        str, typer.Option(help="Address to listen at; other machines reach it only if you give one.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="TCP port; 0 takes a free one.")] = 0,
    known_as: Annotated[
        list[str] | None,
        typer.Option(help="Further name under which people reach it, with :port where that differs. May be repeated."),
    ] = None,
    open_page: Annotated[bool, typer.Option("--open/--no-open", help="Open the page in your browser.")] = True,
    hold: Hold = None,
    package_root: Roots = None,
    allow_xacro: AllowXacro = False,
) -> None:
    """A page in your browser: move the arm, and see what it can do, what it has lost, and what its joints must hold."""
    from ..explorer import explore
    from ..scene.guard_gate import is_loopback

    model = with_payloads(read_robot(robot, base, tip, hold, package_root, allow_xacro), payload)
    q, gravity = read_configuration(model, at, seed), read_mounting(mount)
    names = known_as or ()
    explorer = explore(
        model, q, gravity=gravity, package_roots=package_root or (), host=host, port=port, also_known_as=names
    )
    try:
        if not is_loopback(host):
            typer.echo(f"warning: {_who_can_reach(host)}", err=True)
        show(f"{model.name} at {explorer.address}\nwho has this address can use the page; stop with Ctrl-C", model)
        if open_page and not explorer.open_in_browser():
            typer.echo("no browser was found: open the address yourself", err=True)
        explorer.wait()
    except KeyboardInterrupt:
        typer.echo("\nstopped", err=True)
    finally:
        explorer.stop()


def _who_can_reach(host: str) -> str:
    """What it means to listen beyond this machine."""
    everywhere = host in ("0.0.0.0", "::")
    where = "every network this machine is in" if everywhere else f"the network of {host}"
    others = "; others open it with this machine's address in place of the one shown" if everywhere else ""
    return (
        f"the page can be reached from {where}{others}. What is sent is not encrypted: "
        "whoever reads along there learns the token, and can use the page too"
    )
