"""`kinestatics robots`."""

from __future__ import annotations

import textwrap

from .app import app, show, show_json
from .arguments import Json
from .terminal import line_width

_WIDTH = 80


@app.command("robots")
def command(as_json: Json = False) -> None:
    """The arms of the catalogue, with the source of their numbers."""
    from ..robots.catalogue import catalogue_entries

    entries = catalogue_entries()
    if as_json:
        show_json([entry._asdict() for entry in entries])
        return
    width = max(len(entry.name) for entry in entries)
    margin = " " * (width + 10)
    columns = min(line_width() or _WIDTH, _WIDTH)
    lines = [f"{'name':{width}s}  joints  robot, and the first source of its numbers"]
    for entry in entries:
        lines += textwrap.wrap(
            entry.title, columns, initial_indent=f"{entry.name:{width}s}  {entry.joints:6d}  ", subsequent_indent=margin
        )
        lines += textwrap.wrap(entry.source, columns, initial_indent=margin + "  ", subsequent_indent=margin + "  ")
    show("\n".join(lines))
