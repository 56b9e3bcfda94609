"""Part faults: work is begun again after pauses that grow; callbacks rest and are tried again; people read of it."""

import pytest

from live.base.fault_isolation import (
    FAILURES_BEFORE_SKIP,
    FIRST_SKIP,
    Bulkhead,
    FaultLog,
    callback_name,
    keep_running,
    run_once,
)


class Breaks:
    """Fails so many times, then works."""

    def __init__(self, times):
        self.left, self.calls = times, 0

    def __call__(self, *values):
        self.calls += 1
        if self.left:
            self.left -= 1
            raise IndexError("list index out of range")
        return values or "done"


def test_work_is_begun_again_after_pauses_that_grow_and_ends_when_it_returns():
    faults, work, pauses = FaultLog(), Breaks(8), []

    def wait(seconds):
        pauses.append(seconds)
        return False

    keep_running("the OSC port", work, wait, faults=faults)
    assert work.calls == 9
    assert pauses == [0.05, 0.1, 0.2, 0.4, 0.8, 1.0, 1.0, 1.0]
    assert faults.facts()["failed"] == {"the OSC port": 8}
    assert (
        faults.last_notice()
        == "the OSC port failed and continues (8 times by now): IndexError: list index out of range"
    )


def test_a_thread_that_is_to_end_is_not_begun_again():
    work = Breaks(8)
    keep_running("", work, lambda seconds: True, faults=FaultLog())
    assert work.calls == 1


def test_what_is_no_fault_of_the_work_ends_it():
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        keep_running("", stop, lambda seconds: False, faults=FaultLog())


def test_a_callback_that_fails_once_is_called_again_at_once():
    faults = FaultLog()
    calls, act = Bulkhead(faults), Breaks(1)
    assert calls.call("click", act, 1) is None
    assert calls.call("click", act, 1) == (1,)
    assert faults.counts == {"click": 1}
    assert faults.problem() == ""


def test_one_that_fails_again_and_again_rests_and_comes_back_and_others_never_do():
    faults = FaultLog()
    calls, bad, good = Bulkhead(faults), Breaks(FAILURES_BEFORE_SKIP + 1), Breaks(0)
    frames = 0
    while bad.left:
        calls.call("click", bad)
        calls.call("link", good)
        frames += 1
    assert frames == FAILURES_BEFORE_SKIP + FIRST_SKIP + 1
    assert good.calls == frames
    assert "click fails repeatedly and is skipped" in faults.problem()
    for _ in range(2 * FIRST_SKIP):
        assert calls.call("click", bad) is None
    assert calls.call("click", bad) == "done"
    assert faults.problem() == ""
    assert faults.last_notice() == "click works again"


def test_a_part_that_fails_in_every_call_costs_little_and_fills_no_terminal():
    faults, told = FaultLog(), set()
    calls, bad = Bulkhead(faults), Breaks(1 << 30)
    for _ in range(100_000):
        calls.call("click", bad)
        told.add(faults.last_notice())
    assert bad.calls < 50
    assert len(told) < 60
    for number in range(100):
        calls.call(f"part {number}", bad)
    assert len(faults.counts) <= 33


def test_run_once_says_whether_it_went_well():
    faults = FaultLog()
    assert run_once("a", Breaks(0), faults=faults)
    assert not run_once("a", Breaks(1), faults=faults)
    assert faults.total == 1


def test_names_are_for_people():
    class WebPart:
        def frame(self):
            """Nothing."""

    assert callback_name(WebPart().frame) == "web part"
    assert callback_name(lambda: None) == "test names are for people"
