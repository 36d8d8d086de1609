"""Long jobs: deadlines, words of progress, and the line on a terminal that leaves nothing behind."""

import io
import math
import sys
import time

import pytest

from kinestatics.cli import progress as line
from kinestatics.errors import ConfigurationError
from kinestatics.progress import Job


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_job_is_late_after_its_budget():
    assert not Job.of(math.inf).late
    assert not Job.of(60.0).late
    job = Job.of(1e-6)
    time.sleep(0.01)
    assert job.late
    assert job.within(0.5).late or job.within(0.5).deadline >= job.deadline


@pytest.mark.parametrize("budget", [0, -1.0, math.nan, True, "60"])
def test_a_budget_is_a_positive_number(budget):
    with pytest.raises(ConfigurationError, match=r"(?s)KS353.*seconds"):
        Job.of(budget)


def test_a_share_of_a_job_ends_earlier():
    job = Job.of(100.0)
    part = job.within(0.25)
    assert 20.0 < part.deadline - time.monotonic() < 26.0
    assert part.progress is job.progress


def test_the_line_appears_on_a_terminal_and_goes_again(monkeypatch):
    """Nothing in the first second; then words and a share, overwritten by blanks at the end."""
    monkeypatch.setattr(sys, "stderr", Terminal())
    with line.on_terminal() as tell:
        tell("determinants", 0.5)
    assert sys.stderr.getvalue() == ""
    monkeypatch.setattr(line, "_AFTER", 0.0)
    monkeypatch.setattr(line, "_EVERY", 0.0)
    with line.on_terminal() as tell:
        tell("determinants", 0.5)
        tell("splitting conditions", None)
    shown = sys.stderr.getvalue()
    assert "determinants  50%" in shown
    assert "splitting conditions" in shown
    assert shown.endswith("\r")
    assert shown.split("\r")[-2].strip() == ""


def test_no_line_where_there_is_no_terminal(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with line.on_terminal() as tell:
        assert tell is None
    assert sys.stderr.getvalue() == ""
