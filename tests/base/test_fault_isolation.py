"""Fault isolation: failed work restarts after growing pauses; failing callbacks are skipped, retried and reported."""

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


class FailingCall:
    """A callable that fails a given number of times, then works."""

    def __init__(self, times):
        self.left, self.calls = times, 0

    def __call__(self, *values):
        self.calls += 1
        if self.left:
            self.left -= 1
            raise IndexError("list index out of range")
        return values or "done"


def test_failed_work_restarts_after_growing_pauses_until_it_returns():
    faults, work, pauses = FaultLog(), FailingCall(8), []

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


def test_stopping_thread_does_not_restart_work():
    work = FailingCall(8)
    keep_running("", work, lambda seconds: True, faults=FaultLog())
    assert work.calls == 1


def test_keyboard_interrupt_ends_the_work():
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        keep_running("", stop, lambda seconds: False, faults=FaultLog())


def test_callback_that_failed_once_is_called_again():
    faults = FaultLog()
    calls, act = Bulkhead(faults), FailingCall(1)
    assert calls.call("click", act, 1) is None
    assert calls.call("click", act, 1) == (1,)
    assert faults.counts == {"click": 1}
    assert faults.problem() == ""


def test_repeatedly_failing_callback_is_skipped_and_retried():
    faults = FaultLog()
    calls, bad, good = Bulkhead(faults), FailingCall(FAILURES_BEFORE_SKIP + 1), FailingCall(0)
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


def test_always_failing_callback_has_bounded_calls_and_notices():
    faults, told = FaultLog(), set()
    calls, bad = Bulkhead(faults), FailingCall(1 << 30)
    for _ in range(100_000):
        calls.call("click", bad)
        told.add(faults.last_notice())
    assert bad.calls < 50
    assert len(told) < 60
    for number in range(100):
        calls.call(f"part {number}", bad)
    assert len(faults.counts) <= 33


def test_run_once_returns_whether_work_succeeded():
    faults = FaultLog()
    assert run_once("a", FailingCall(0), faults=faults)
    assert not run_once("a", FailingCall(1), faults=faults)
    assert faults.total == 1


def test_callback_names_are_readable():
    class WebPart:
        def frame(self):
            """Does nothing."""

    assert callback_name(WebPart().frame) == "web part"
    assert callback_name(lambda: None) == "test callback names are readable"
