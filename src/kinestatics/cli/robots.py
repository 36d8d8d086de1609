"""`kinestatics robots`."""

from __future__ import annotations

import json

from ..robots.catalogue import catalogue_entries
from .app import app, show
from .arguments import Json


@app.command("robots")
def command(as_json: Json = False) -> None:
    """The arms of the catalogue, with the source of their numbers."""
    entries = catalogue_entries()
    if as_json:
        show(json.dumps([entry._asdict() for entry in entries], indent=2))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table("name", "robot", "joints", "source", box=None, pad_edge=False)
    for entry in entries:
        table.add_row(entry.name, entry.title, str(entry.joints), entry.source)
    Console().print(table)
