"""Long jobs: the time they may take, and word of where they are. Floor 1."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from .errors import ConfigurationError

Progress = Callable[[str, float | None], None]
"""Called now and then with what is being done and the share of it that is done, None where that is not known. An exception
raised in it ends the job."""


@dataclass(frozen=True)
class Job:
    """A long job.

    Attributes:
        deadline: time.monotonic() at which it hands back what it has.
        progress: who is told.
    """

    deadline: float = math.inf
    progress: Progress | None = None

    @classmethod
    def of(cls, budget: float, progress: Progress | None = None) -> Job:
        """A job that begins now.

        Raises:
            ConfigurationError: KS353 where the budget is no positive number of seconds.
        """
        if isinstance(budget, bool) or not isinstance(budget, int | float) or not budget > 0:
            raise ConfigurationError("KS353", f"budget is {budget!r}", "a positive number of seconds; math.inf for no end")
        return cls(time.monotonic() + budget, progress)

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() > self.deadline

    def within(self, share: float) -> Job:
        """The same job with a share of the time that is left."""
        left = self.deadline - time.monotonic()
        return Job(time.monotonic() + share * max(left, 0.0), self.progress)

    def tell(self, what: str, share: float | None = None) -> None:
        """Says what is being done."""
        if self.progress is not None:
            self.progress(what, share)
