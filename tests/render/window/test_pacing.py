"""Tests of the pacer with a simulated clock and sleep."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from live.render.timing.frame_stats import Pacer


class FakeClock:
    """A clock that advances when it is read and by each sleep (`oversleep` longer than requested)."""

    def __init__(self, *, tick: float = 1e-6, oversleep: float = 0.0) -> None:
        self.time = 100.0
        self.tick = tick
        self.oversleep = oversleep
        self.sleeps: list[float] = []

    def now(self) -> float:
        self.time += self.tick
        return self.time

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.sleeps.append(seconds)
        if seconds > 0.0:
            self.time += seconds + self.oversleep
        else:
            self.time += 20e-6  # a yield takes its time too


def frame_starts(world: FakeClock, pacer: Pacer, count: int, work: Callable[[int], float]) -> list[float]:
    """Start times of `count` frames when frame n takes work(n) seconds."""
    times: list[float] = []
    for number in range(count):
        times.append(pacer.wait())
        world.time += work(number)
    return times


def test_fast_frames_start_on_grid() -> None:
    world = FakeClock()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = frame_starts(world, pacer, 601, lambda _: 0.004)
    assert times[0] == pytest.approx(100.0, abs=1e-5)
    for number, time in enumerate(times):
        assert 0.0 <= time - times[0] - number / 60.0 < 50e-6
    assert (pacer.frames, pacer.late) == (601, 0)


def test_pacer_wakes_one_millisecond_early_and_then_yields() -> None:
    world = FakeClock()
    pacer = Pacer(50.0, world.now, world.sleep)
    frame_starts(world, pacer, 2, lambda _: 0.005)
    long = [seconds for seconds in world.sleeps if seconds > 0.0]
    assert long == [pytest.approx(0.020 - 0.005 - 0.001, abs=1e-4)]
    assert 30 < world.sleeps.count(0.0) < 60  # 1 ms of yields of 20 µs


def test_late_wakeups_do_not_accumulate() -> None:
    world = FakeClock(oversleep=0.003)
    pacer = Pacer(60.0, world.now, world.sleep)
    times = frame_starts(world, pacer, 601, lambda _: 0.004)
    assert times[-1] - times[0] == pytest.approx(600 / 60.0, abs=0.003)
    assert pacer.late == 0


def test_late_frame_is_counted_without_catching_up() -> None:
    world = FakeClock()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = frame_starts(world, pacer, 12, lambda number: 0.100 if number == 4 else 0.002)
    gaps = [after - before for before, after in pairwise(times)]
    assert gaps[4] == pytest.approx(0.100, abs=1e-4)
    assert gaps[5:] == [pytest.approx(1 / 60.0, abs=1e-4)] * 6, "no burst after the stall"
    assert pacer.late == 1


def test_frame_just_over_period_is_not_late() -> None:
    world = FakeClock()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = frame_starts(world, pacer, 12, lambda number: 0.020 if number == 4 else 0.002)
    assert times[-1] - times[0] == pytest.approx(11 / 60.0, abs=1e-4), "back on the grid"
    assert pacer.late == 0


def test_too_slow_machine_never_sleeps() -> None:
    world = FakeClock()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = frame_starts(world, pacer, 50, lambda _: 0.030)
    assert world.sleeps == []
    assert times[-1] - times[0] == pytest.approx(49 * 0.030, abs=1e-3)
    assert pacer.late == 49


@pytest.mark.parametrize("display_hz", [59.94, 60.0, 60.02])
def test_slightly_faster_pacer_skips_no_display_refresh(display_hz: float) -> None:
    world = FakeClock()
    pacer = Pacer(60.0 * 1.05, world.now, world.sleep)
    shown: list[int] = []
    for _ in range(3000):
        pacer.wait()
        world.time += 0.003
        refresh = int(world.time * display_hz) + 1  # the swap waits for the next refresh of the display
        world.time = refresh / display_hz + 1e-5
        shown.append(refresh)
    assert [after - before for before, after in pairwise(shown)] == [1] * 2999
    assert pacer.late == 0


@pytest.mark.parametrize("fps", [0.0, -60.0, float("nan"), float("inf")])
def test_invalid_rate_is_refused(fps: float) -> None:
    with pytest.raises(ValueError, match="1 to 1000"):
        Pacer(fps, lambda: 0.0, lambda _: None)
