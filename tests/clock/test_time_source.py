"""Clocks start at 0 and are monotonic."""

import math
import time

import pytest

from live.clock.time_source import ManualClock, SystemClock


def test_manual_clock_moves_only_when_set() -> None:
    clock = ManualClock()
    assert clock.now() == clock.now() == 0.0
    clock.advance(1.5)
    clock.set(1.5)
    assert clock.now() == 1.5


@pytest.mark.parametrize("past", [1.0, -1.0, math.nan])
def test_manual_clock_refuses_earlier_times(past: float) -> None:
    clock = ManualClock(2.0)
    with pytest.raises(ValueError, match="cannot go back"):
        clock.set(past)
    assert clock.now() == 2.0


def test_system_clock_starts_at_zero_and_is_monotonic() -> None:
    clock = SystemClock()
    readings = [clock.now() for _ in range(1000)]
    assert 0.0 <= readings[0] < 60.0
    assert readings == sorted(readings)


def test_system_clocks_with_one_origin_agree() -> None:
    origin = time.perf_counter()
    early, late = SystemClock(origin), SystemClock(origin)
    first, second = early.now(), late.now()
    assert 0.0 <= second - first < 60.0


def test_system_date_change_does_not_move_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SystemClock()
    before = clock.now()
    monkeypatch.setattr(time, "time", lambda: 0.0)
    assert 0.0 <= clock.now() - before < 60.0
