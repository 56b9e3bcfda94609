"""TickCounter: identical ticks at any frame rate."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.ticks import STALL, TICK, FrameGrid, TickCounter


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


@pytest.mark.parametrize("fps", [1.0, 12.5, 24000 / 1001, 30.0, 60.0, 60000 / 1001, 64.0, 120.0, 480.0])
def test_frame_grid_and_ticks_agree(fps: float) -> None:
    grid, ticks = FrameGrid(fps), TickCounter()
    for frame in range(500):
        for _ in due(ticks, grid.time(frame)):
            pass
        assert grid.tick(frame) == ticks.index
        assert grid.tick(grid.first_from(ticks.index)) >= ticks.index
        assert grid.first_from(ticks.index) <= frame
        assert grid.first_from(ticks.index + 1) > frame
    assert grid.count(10.0) == pytest.approx(10.0 * fps, abs=1.0)
