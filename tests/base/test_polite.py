"""Polite work is the same work, and gives the interpreter away while it lasts."""

import sys
import threading

from live.base import polite as module
from live.base.polite import polite


def _count(number):
    return number + 1


def _work(calls):
    number = 0
    for _ in range(calls):
        number = _count(number)
    return number


def test_the_work_is_done_and_the_thread_is_as_before(monkeypatch):
    rests = []
    monkeypatch.setattr(module.time, "sleep", rests.append)
    before = sys.getprofile()
    with polite():
        assert _work(20_000) == 20_000
    assert sys.getprofile() is before
    assert len(rests) >= 2
    assert set(rests) == {module.RESTS_S}
    count = len(rests)
    _work(20_000)
    assert len(rests) == count


def test_an_error_passes_and_other_threads_are_not_touched():
    seen = []

    def other():
        seen.append(sys.getprofile())

    before = sys.getprofile()
    try:
        with polite():
            thread = threading.Thread(target=other)
            thread.start()
            thread.join()
            raise KeyError("x")
    except KeyError:
        pass
    assert seen == [None]
    assert sys.getprofile() is before
