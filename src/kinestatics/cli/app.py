"""The command line as a whole: commands, and one place where errors become text and exit code 2."""

from __future__ import annotations

import sys
import warnings
from typing import Annotated

import typer

from ..errors import KinestaticsError

app = typer.Typer(
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Differential kinematics and statics of robot arms: what can this arm do, here?",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(version("kinestatics"))
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Options before the command."""
    del version


def _load_commands() -> None:
    from . import analyze, jacobian, robots  # noqa: F401 - each registers its command


def main() -> None:
    """Entry point: runs a command; an error of ours becomes its message on stderr and exit code 2, never a traceback."""
    _load_commands()
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning = _show_warning
        try:
            app()
        except KinestaticsError as error:
            typer.echo(_printable(str(error)), err=True)
            sys.exit(2)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"warning: {_printable(str(message))}", err=True)


def _printable(text: str) -> str:
    """Text from robot files without control characters that could drive a terminal."""
    return "".join(c if c == "\n" or c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def show(text: str) -> None:
    """Print to stdout, safe for names from files."""
    typer.echo(_printable(text))
