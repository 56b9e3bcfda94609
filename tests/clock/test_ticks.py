"""TickCounter: identical ticks at any frame rate."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.ticks import STALL, TICK, TickCounter


def due(ticks: TickCounter, target: float) -> Iterator[float]:
    """Yield the times of the ticks after the last one, up to `target` [s]."""
    while ticks.is_due(target):
        yield ticks.advance()


@given(st.lists(st.floats(0.0, STALL), min_size=1, max_size=60))
def test_every_tick_is_issued_once_and_on_time(frames: list[float]) -> None:
    ticks, target, seen = TickCounter(), 0.0, []
    for frame in frames:
        target += frame
        for time in due(ticks, target):
            assert time <= target
            seen.append(time)
        assert target - ticks.time < TICK
    assert seen == [(index + 1) / 64 for index in range(len(seen))]


@pytest.mark.parametrize("rate", [25, 60, 144])
def test_ticks_are_independent_of_frame_rate(rate: int) -> None:
    ticks = TickCounter()
    seen = [time for frame in range(1, 10 * rate + 1) for time in due(ticks, frame / rate)]
    assert seen == [index / 64 for index in range(1, 641)]


def test_stalled_ticks_are_skipped_and_counted() -> None:
    ticks = TickCounter()
    assert ticks.stalled(STALL) == 0
    missed = ticks.stalled(2.0)
    ticks.skip(missed)
    assert ticks.skipped == missed == 127
    assert list(due(ticks, 2.0)) == [2.0]
    assert ticks.stalled(2.0 + STALL) == 0
