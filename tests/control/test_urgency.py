"""Tests of urgency: refused system calls do not stop the thread, and timers are exact."""

import ctypes
import os
import sys
import threading
from typing import Any

import pytest

from live.control import realtime_priority as urgency

PR_GET_TIMERSLACK = 30


def run_in_thread(act: Any) -> Any:
    """The result of `act` in a thread of its own, whose priorities end with it."""
    given: list[Any] = []
    thread = threading.Thread(target=lambda: given.append(act()))
    thread.start()
    thread.join(timeout=60.0)
    return given[0]


def refuse(*_: Any) -> None:
    raise PermissionError(1, "not allowed")


@pytest.mark.skipif(sys.platform != "linux", reason="Linux' own calls")
def test_unprivileged_thread_gets_exact_timers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "setpriority", refuse)

    def hurried() -> tuple[bool, int, int, int]:
        before = os.getpriority(os.PRIO_PROCESS, 0)
        done = urgency.request_realtime()
        slack = ctypes.CDLL(None).prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0)
        return done, slack, os.sched_getscheduler(0), os.getpriority(os.PRIO_PROCESS, 0) - before

    assert run_in_thread(hurried) == (False, 1, os.SCHED_OTHER, 0)


def test_unsupported_system_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "setpriority", refuse)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert run_in_thread(urgency.request_realtime) is False
