"""Urgency: whatever the system refuses, the thread runs on, and its timers are exact."""

import ctypes
import os
import sys
import threading
from typing import Any

import pytest

from live.control import realtime_priority as urgency

PR_GET_TIMERSLACK = 30


def in_a_thread(act: Any) -> Any:
    """What `act` gives in a thread of its own, whose priorities end with it."""
    given: list[Any] = []
    thread = threading.Thread(target=lambda: given.append(act()))
    thread.start()
    thread.join(timeout=60.0)
    return given[0]


def refused(*_: Any) -> None:
    raise PermissionError(1, "not allowed")


@pytest.mark.skipif(sys.platform != "linux", reason="Linux' own calls")
def test_without_any_right_timers_are_exact_and_slices_short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refused)
    monkeypatch.setattr(os, "setpriority", refused)

    def hurried() -> tuple[bool, int, int, int]:
        before = os.getpriority(os.PRIO_PROCESS, 0)
        done = urgency.request_realtime()
        slack = ctypes.CDLL(None).prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0)
        return done, slack, os.sched_getscheduler(0), os.getpriority(os.PRIO_PROCESS, 0) - before

    assert in_a_thread(hurried) == (False, 1, os.SCHED_OTHER, 0)


def test_a_system_that_has_none_of_it_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refused)
    monkeypatch.setattr(os, "setpriority", refused)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert in_a_thread(urgency.request_realtime) is False
