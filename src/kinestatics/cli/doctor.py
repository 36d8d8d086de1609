"""`kinestatics doctor`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from .app import app, show_json
from .arguments import Json
from .progress import on_terminal
from .terminal import hanging, line_width, paint, printable

if TYPE_CHECKING:
    from ..installation import ExtraState, Installation, PackageState

_LABEL = 12  # columns


@app.command("doctor")
def command(as_json: Json = False) -> None:
    """What is installed here, and does it work?

    Versions, extras and how to install them, the instruction set of the kernels, a self-test of them against the
    definition, and whether a browser can be opened. Exit code: 0, or 1 where something is broken.
    """
    from ..installation import examine

    with on_terminal("looking at packages") as progress:
        found = examine(progress)
    show_json(found.to_dict()) if as_json else typer.echo(_text(found))
    raise typer.Exit(1 if found.faults else 0)


def _text(found: Installation) -> str:
    kernels = found.kernels
    lines = [
        _entry("kinestatics", found.version or "not installed as a package: run from its sources"),
        _entry("python", f"{found.python} ({found.system}), {found.executable}"),
        *(_entry(package.name, _state(package)) for package in found.base),
        "",
        _entry("kernels", f"{kernels.used or 'none'} in use; this machine offers {', '.join(kernels.offered) or 'none'}"),
        _entry("threads", f"{kernels.processors} processors; a call uses one unless threads= asks for more"),
        _entry("self-test", _self_test(found)),
        _entry("browser", _browser(found)),
        "",
        "extras",
        *(line for extra in found.extras for line in _extra(extra)),
        "",
        *(paint(hanging(f"broken: {fault}", 2, line_width(), first=0), "error") for fault in found.faults),
    ]
    if not found.faults:
        lines.append(paint("nothing is broken", "good"))
    return "\n".join(lines)


def _entry(label: str, text: str) -> str:
    """A label and what is said of it, wrapped beneath itself."""
    return hanging(f"{label:{_LABEL}s} {printable(text)}", _LABEL + 1, line_width(), first=0)


def _state(package: PackageState) -> str:
    wanted = f" ({package.bounds})" if package.bounds else ""
    return f"{package.version or 'not installed'}{wanted}" + (f": {package.fault}" if package.fault else "")


def _self_test(found: Installation) -> str:
    kernels = found.kernels
    if kernels.fault:
        return kernels.fault
    sets = f"{len(kernels.offered)} instruction sets" if len(kernels.offered) != 1 else "the instruction set"
    return (
        f"passed: {kernels.checked} Jacobians of ur5e with {sets} agree with the definition to {kernels.difference:.1e} "
        "(relative to the largest entry)"
    )


def _browser(found: Installation) -> str:
    opens = "can be opened from here" if found.browser else "cannot be opened from here: copy addresses by hand"
    return opens + (f" (Chromium: {found.chromium})" if found.chromium else "")


def _extra(extra: ExtraState) -> list[str]:
    """What it is for, which of its packages are there, and what installs the others."""
    there = [f"{package.name} {package.version}" for package in extra.packages if package.version is not None]
    missing = [package.name for package in extra.packages if package.version is None]
    broken = any(package.fault for package in extra.packages)
    word, kind = ("ready", "good") if extra.ready else ("broken", "error") if broken else ("missing", "warning")
    about = ", ".join(there) + ("; " if there and missing else "") + ("without " if missing else "") + ", ".join(missing)
    width = line_width()
    head = hanging(f"{extra.name:{_LABEL - 2}s} {word:8s} {extra.purpose}", _LABEL + 9, width, first=2)
    lines = [head.replace(word, paint(word, kind), 1), hanging(about, _LABEL + 9, width)]
    return lines if extra.ready else [*lines, " " * (_LABEL + 9) + extra.command]
