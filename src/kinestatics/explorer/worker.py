"""Slow questions beside the page: only the latest of each kind is answered, and not before the page has come to rest."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

QUIET = 0.25
"""Seconds without a new question before an answer is looked for."""


class LatestWorker:
    """One thread that answers the latest question; those that came before it and were not begun are dropped.

    Args:
        name: of the thread; failed: what is told of an exception that a question ended with.
    """

    def __init__(self, name: str, failed: Callable[[Exception], None]) -> None:
        self._failed = failed
        self._wake = threading.Condition()
        self._question: Callable[[], None] | None = None
        self._asked, self._over, self._busy = 0.0, False, False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def ask(self, question: Callable[[], None], quiet: float = QUIET) -> None:
        """Answers a question after `quiet` seconds without another."""
        with self._wake:
            self._question, self._asked = question, time.monotonic() + quiet
            self._wake.notify()

    def stop(self) -> None:
        """Ends after the question at hand."""
        with self._wake:
            self._over = True
            self._wake.notify()

    def wait(self, seconds: float = 60.0) -> bool:
        """Waits until nothing is left to answer; whether that was in time."""
        with self._wake:
            return self._wake.wait_for(lambda: self._question is None and not self._busy, seconds)

    def _next(self) -> Callable[[], None] | None:
        """The question that has come to rest; None where the work is over."""
        with self._wake:
            while not self._over:
                left = self._asked - time.monotonic()
                if self._question is not None and left <= 0:
                    question, self._question, self._busy = self._question, None, True
                    return question
                self._wake.wait(left if self._question is not None else None)
        return None

    def _run(self) -> None:
        while (question := self._next()) is not None:
            try:
                question()
            except Exception as error:  # a page must not die of one answer; what it was is told
                self._failed(error)
            with self._wake:
                self._busy = False
                self._wake.notify_all()
