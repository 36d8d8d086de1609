"""A line that says where a long job is, on a terminal only: nothing of it reaches a file or a pipe."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from ..progress import Progress

_AFTER, _EVERY = 1.0, 0.1  # [s]
_WIDTH = 40


@contextmanager
def on_terminal() -> Iterator[Progress | None]:
    """Shows progress on the error stream from the first second on, and takes it away at the end."""
    if not sys.stderr.isatty():
        yield None
        return
    began = shown = time.monotonic()

    def tell(what: str, share: float | None) -> None:
        nonlocal shown
        now = time.monotonic()
        if now - began >= _AFTER and now - shown >= _EVERY:
            shown = now
            text = what if share is None else f"{what} {share:4.0%}"
            sys.stderr.write(f"\r{text:<{_WIDTH}.{_WIDTH}}")
            sys.stderr.flush()

    try:
        yield tell
    finally:
        if shown != began:
            sys.stderr.write(f"\r{'':<{_WIDTH}}\r")
            sys.stderr.flush()
