"""Background work shortens the thread switch interval only while it lasts."""

import sys
import threading

import pytest

from live.show.background_work import SWITCH_INTERVAL_S, short_switch_interval


def test_switch_interval_is_short_until_last_worker_ends():
    before = sys.getswitchinterval()
    inside, leave = threading.Event(), threading.Event()

    def other():
        with short_switch_interval():
            inside.set()
            leave.wait(10.0)

    thread = threading.Thread(target=other)
    with short_switch_interval():
        assert sys.getswitchinterval() == pytest.approx(SWITCH_INTERVAL_S)
        thread.start()
        assert inside.wait(10.0)
    assert sys.getswitchinterval() == pytest.approx(SWITCH_INTERVAL_S)
    leave.set()
    thread.join()
    assert sys.getswitchinterval() == before


def test_exception_restores_the_switch_interval():
    before = sys.getswitchinterval()
    with pytest.raises(KeyError), short_switch_interval():
        raise KeyError("x")
    assert sys.getswitchinterval() == before
