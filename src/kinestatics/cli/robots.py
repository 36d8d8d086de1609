"""`kinestatics robots`."""

from __future__ import annotations

import textwrap

from .app import app, show, show_json
from .arguments import Json

_WIDTH = 80


@app.command("robots", short_help="The arms of the catalogue, with their sources.")
def command(as_json: Json = False) -> None:
    """The arms of the catalogue, with the source of their numbers."""
    from ..robots.catalogue import catalogue_entries

    entries = catalogue_entries()
    if as_json:
        show_json([entry._asdict() for entry in entries])
        return
    width = max(len(entry.name) for entry in entries)
    margin = " " * (width + 10)
    lines = [f"{'name':{width}s}  joints  robot, and the first source of its numbers"]
    for entry in entries:
        lines += textwrap.wrap(
            entry.title, _WIDTH, initial_indent=f"{entry.name:{width}s}  {entry.joints:6d}  ", subsequent_indent=margin
        )
        lines += textwrap.wrap(entry.source, _WIDTH, initial_indent=margin + "  ", subsequent_indent=margin + "  ")
    show("\n".join(lines))
