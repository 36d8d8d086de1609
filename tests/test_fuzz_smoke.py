"""A few seconds of the fuzzer in every test run; `python tests/fuzz_readers.py --minutes 20` is the real thing."""

from dataclasses import replace

import numpy as np
import pytest

import fuzz_readers
import kinestatics as ks


def test_readers_keep_their_contract(tmp_path):
    """The first inputs of a fixed seed: no exception but ours, and accepted models are finite."""
    counts = {"accepted": 0, "refused": 0}
    for index in range(1200):
        one = fuzz_readers.made(20261124, index)
        result, why = fuzz_readers.outcome(one, tmp_path)
        assert result != "broken", f"{one.reader} {index}: {why}\n{one.value!r}"
        counts["accepted" if result == "accepted" else "refused"] += 1
    assert min(counts.values()) > 100


def test_inputs_can_be_made_again():
    """An input depends on its seed and index alone."""
    for index in range(50):
        assert repr(fuzz_readers.made(7, index)) == repr(fuzz_readers.made(7, index))
    assert repr(fuzz_readers.made(7, 0)) != repr(fuzz_readers.made(8, 0))


@pytest.mark.parametrize(
    ("failure", "why"),
    [
        (ValueError("not ours"), "ValueError: not ours"),
        (MemoryError(), "MemoryError"),
        (RecursionError(), "RecursionError"),
        (RuntimeWarning("overflow"), "RuntimeWarning: overflow"),
    ],
)
def test_the_fuzzer_sees_a_foreign_exception(monkeypatch, tmp_path, failure, why):
    """An exception that is not ours breaks the contract, and its traceback is kept."""

    def reader(*_):
        raise failure

    monkeypatch.setattr(fuzz_readers, "parse_urdf", reader)
    result, reason = fuzz_readers.outcome(fuzz_readers.Input("urdf", b"<robot/>"), tmp_path)
    assert result == "broken"
    assert why in reason


def test_the_fuzzer_sees_what_is_not_finite():
    """An accepted model with a length that is no number, or a screw that is not unit, breaks the contract."""
    arm = ks.load("planar_2r")
    fuzz_readers.check_model(arm)
    far = arm.placements.copy()
    far[-1, 0, 3] = np.nan
    with pytest.raises(AssertionError, match="finite"):
        fuzz_readers.check_model(replace(arm, placements=far))
    with pytest.raises(AssertionError, match="unit"):
        fuzz_readers.check_model(replace(arm, screws=2 * arm.screws))


def test_the_fuzzer_survives_its_worker(monkeypatch):
    """A worker that dies at an input costs that input only: it is kept as the offender, and another goes on behind it."""
    monkeypatch.setattr(fuzz_readers, "work", dies_at_third)
    tally = fuzz_readers.fuzz(60, seed=1, most=8)
    assert [offender["index"] for offender in tally.offenders] == [3]
    assert tally.inputs == 8
    assert "offenders: 1" in str(tally)


def dies_at_third(pipe, seed, start, mjcf, folder):
    """A worker that reports every input as accepted, and leaves without a word at number 3."""
    del seed, mjcf, folder
    for index in range(start, 100):
        if index == 3:
            raise SystemExit(3)
        pipe.send((index, "urdf", "accepted", ""))
