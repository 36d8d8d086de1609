"""How a result asks to be shown: it names a surface, which is imported when it is asked for. Floor 1.

Surfaces (reports, notebooks, scenes) stand on the floors above all results, so no result can import them; yet a reader
expects `analysis.to_html()` and a table in a notebook. This is the one place where a lower floor speaks of a higher one.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

SURFACES = ("report", "notebook")


def surface(name: str) -> Any:
    """The module of a surface, one of SURFACES.

    Raises:
        ValueError: for another name; a mistake in the house, not of a user.

    Example:
        >>> surface("report").__name__
        'kinestatics.report'
    """
    if name not in SURFACES:
        raise ValueError(f"no surface is called {name!r}; there are {', '.join(SURFACES)}")
    return import_module(f".{name}", __package__)
