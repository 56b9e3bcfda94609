"""Polite work lets others in soon while it lasts, and only then."""

import sys
import threading

import pytest

from live.show.background_work import SWITCH_INTERVAL_S, short_switch_interval


def test_others_are_let_in_soon_until_the_last_one_is_done():
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


def test_an_error_passes():
    before = sys.getswitchinterval()
    with pytest.raises(KeyError), short_switch_interval():
        raise KeyError("x")
    assert sys.getswitchinterval() == before
