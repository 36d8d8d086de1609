"""A line that says where a long job is, on a terminal only: nothing of it reaches a file or a pipe."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from ..progress import Progress

_AFTER, _EVERY, _TICK = 1.0, 0.1, 0.5  # [s]
_WIDTH = 40


@contextmanager
def on_terminal(what: str = "working") -> Iterator[Progress | None]:
    """Shows progress on the error stream from the first second on, and takes it away at the end.

    Args:
        what: said until the job says more; of one that never does, with the seconds that it has taken so far.
    """
    if not sys.stderr.isatty():
        yield None
        return
    line = _Line(what, sys.stderr)
    ticking = threading.Thread(target=line.tick, daemon=True)
    ticking.start()
    try:
        yield line.tell
    finally:
        line.ended.set()
        ticking.join()
        line.clear()


class _Line:
    """The line: what is being done, which share of it is, and since when."""

    def __init__(self, what: str, stream: TextIO) -> None:
        self.what, self.stream = what, stream
        self.share: float | None = None
        self.began = self.shown = time.monotonic()
        self.ended, self.turn = threading.Event(), threading.Lock()

    def tell(self, what: str, share: float | None) -> None:
        """A job's word."""
        self.what, self.share = what, share
        self.draw()

    def tick(self) -> None:
        """Shows that time passes, also while the job says nothing."""
        while not self.ended.wait(_TICK):
            self.draw()

    def draw(self) -> None:
        """Writes the line, unless it is too early or was written just now."""
        with self.turn:
            now = time.monotonic()
            if now - self.began < _AFTER or now - self.shown < _EVERY:
                return
            self.shown = now
            share = "" if self.share is None else f" {self.share:4.0%}"
            text = f"{self.what[: _WIDTH - 14]}{share}  {now - self.began:.0f} s"
            self.stream.write(f"\r{text:<{_WIDTH}.{_WIDTH}}")
            self.stream.flush()

    def clear(self) -> None:
        """Takes the line away, if it was ever written."""
        if self.shown != self.began:
            self.stream.write(f"\r{'':<{_WIDTH}}\r")
            self.stream.flush()
