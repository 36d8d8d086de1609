"""The command line as a whole: commands, and one place where errors become text and exit code 2."""

from __future__ import annotations

import gc
import io
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ..errors import KinestaticsError, KinestaticsWarning, nearest
from .terminal import paint, printable

if TYPE_CHECKING:
    from ..model import RobotModel

COMMANDS = {
    "analyze": "What can this arm do, here?",
    "explore": "Drag, turn and load the arm on a page in the browser.",
    "jacobian": "The Jacobian, in any axes, at any point.",
    "singularities": "Where is this arm singular, and what is lost there?",
    "export": "The arm's formulas, as text, LaTeX or code.",
    "check": "What is wrong in a robot file, and where?",
    "robots": "The arms of the catalogue, with their sources.",
    "doctor": "What is installed here, and does it work?",
}
"""Each lies in the module of its name, which is imported when it is asked for: `--help` needs none of them."""


class Commands(TyperGroup):
    """The commands by name."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Flags that are not given are False: None would be handed to a validator that takes 0.1 s to import."""
        for option in self.get_params(ctx):
            if getattr(option, "is_flag", False) and option.default is None:
                option.default = False
        return super().parse_args(ctx, args)

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002 - what Typer calls
        """All of them, in the order in which help shows them."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
        """The command of that name, or None."""
        if cmd_name not in COMMANDS:
            return None
        import_module(f".{cmd_name}", __package__)
        alone = typer.Typer(add_completion=False, rich_markup_mode=None, context_settings=_SETTINGS)
        alone.registered_commands += [found for found in app.registered_commands if found.name == cmd_name]
        command = typer.main.get_command(alone)
        command.short_help = COMMANDS[cmd_name]
        return command

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
        """Their list in the help, from the table alone."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the arguments begin with; of an unknown one the nearest is named."""
        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            hint = nearest(name, COMMANDS)
            ctx.fail(f"No such command {name!r}. {hint[:1].upper()}{hint[1:]}")
        return super().resolve_command(ctx, args)


_SETTINGS = {"help_option_names": ["--help", "-h"]}
app = typer.Typer(
    cls=Commands,
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: no frames to break at 80 columns, no colour codes, and 0.07 s less to import
    context_settings=_SETTINGS,
    help="Differential kinematics and statics of robot arms: what can this arm do, here?",
    epilog="`kinestatics COMMAND --help` says more of each.",
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


_COLLECTED = (200_000, 50, 100)
"""When to look for garbage. A command soon ends, and SymPy keeps what it makes: by default a quarter of the time of
`analyze` goes into looking for garbage that is none."""


def main() -> None:
    """Entry point: runs a command; an error of ours becomes its message on stderr and exit code 2, never a traceback."""
    gc.set_threshold(*_COLLECTED)
    if isinstance(sys.stdout, io.TextIOWrapper):  # a terminal that cannot show a robot's name gets it with escapes
        sys.stdout.reconfigure(errors="backslashreplace")
    with warnings.catch_warnings():
        warnings.simplefilter("always", KinestaticsWarning)
        warnings.showwarning = _warning_shower()
        try:
            app(prog_name="kinestatics")
        except KinestaticsError as error:
            _show_error(str(error), f"error {error.code}:")
            sys.exit(2)
        except OSError as error:
            _show_error(f"error KS346: {error.strerror or error}: {error.filename or 'output'}", "error KS346:")
            sys.exit(2)


def _show_error(text: str, painted: str) -> None:
    typer.echo(printable(text).replace(painted, paint(painted, "error", sys.stderr), 1), err=True)


def _warning_shower() -> Callable[..., None]:
    """What shows warnings of one command: each once, however many steps of it come upon the same."""
    seen: set[str] = set()

    def show_warning(message: Warning | str, *_: object, **__: object) -> None:
        if (text := printable(str(message))) not in seen:
            seen.add(text)
            typer.echo(f"{paint('warning:', 'warning', sys.stderr)} {text}", err=True)

    return show_warning


def show_json(data: Any) -> None:
    """Print strict JSON to stdout: no NaN, no infinity, and every character beyond printable ASCII escaped."""
    import json

    typer.echo(json.dumps(data, indent=2, allow_nan=False))


def show(text: str, model: RobotModel | None = None) -> None:
    """Print to stdout, safe for the names of a model from a file: none can drive the terminal or forge a line."""
    names = (model.name, *model.joint_names, *model.link_names) if model is not None else ()
    for name in sorted((name for name in names if "\n" in name), key=len, reverse=True):
        text = text.replace(name, name.replace("\n", "\\n"))
    typer.echo(printable(text))
