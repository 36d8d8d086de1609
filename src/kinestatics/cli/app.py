"""The command line as a whole: commands, and one place where errors become text and exit code 2."""

from __future__ import annotations

import io
import json
import sys
import warnings
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import KinestaticsError, KinestaticsWarning

if TYPE_CHECKING:
    from ..model import RobotModel

app = typer.Typer(
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: no frames to break at 80 columns, no colour codes, and 0.07 s less to import
    context_settings={"help_option_names": ["--help", "-h"]},
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
    from . import analyze, export, jacobian, robots, singularities  # noqa: F401 - each registers its command


def main() -> None:
    """Entry point: runs a command; an error of ours becomes its message on stderr and exit code 2, never a traceback."""
    _load_commands()
    if isinstance(sys.stdout, io.TextIOWrapper):  # a terminal that cannot show a robot's name gets it with escapes
        sys.stdout.reconfigure(errors="backslashreplace")
    with warnings.catch_warnings():
        warnings.simplefilter("always", KinestaticsWarning)
        warnings.showwarning = _show_warning
        try:
            app(prog_name="kinestatics")
        except KinestaticsError as error:
            typer.echo(_printable(str(error)), err=True)
            sys.exit(2)
        except OSError as error:
            typer.echo(_printable(f"error KS346: {error.strerror or error}: {error.filename or 'output'}"), err=True)
            sys.exit(2)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"warning: {_printable(str(message))}", err=True)


def _printable(text: str) -> str:
    """Text from robot files without control characters that could drive a terminal."""
    return "".join(c if c == "\n" or c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def show_json(data: Any) -> None:
    """Print strict JSON to stdout: no NaN, no infinity, and every character beyond printable ASCII escaped."""
    typer.echo(json.dumps(data, indent=2, allow_nan=False))


def show(text: str, model: RobotModel | None = None) -> None:
    """Print to stdout, safe for the names of a model from a file: none can drive the terminal or forge a line."""
    names = (model.name, *model.joint_names, *model.link_names) if model is not None else ()
    for name in sorted((name for name in names if "\n" in name), key=len, reverse=True):
        text = text.replace(name, name.replace("\n", "\\n"))
    typer.echo(_printable(text))
