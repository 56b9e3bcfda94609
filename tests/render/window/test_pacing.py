"""Pacing with a clock and a sleep made for the test."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from live.render.frame_stats import Pacer


class World:
    """A clock that goes on when it is read and when somebody sleeps (`oversleep` longer than asked)."""

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


def starts(world: World, pacer: Pacer, count: int, work: Callable[[int], float]) -> list[float]:
    """Times at which `count` frames start when frame number n takes work(n) seconds."""
    times: list[float] = []
    for number in range(count):
        times.append(pacer.wait())
        world.time += work(number)
    return times


def test_quick_frames_start_on_the_grid() -> None:
    world = World()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = starts(world, pacer, 601, lambda _: 0.004)
    assert times[0] == pytest.approx(100.0, abs=1e-5)
    for number, time in enumerate(times):
        assert 0.0 <= time - times[0] - number / 60.0 < 50e-6
    assert (pacer.frames, pacer.late) == (601, 0)


def test_it_sleeps_but_wakes_a_millisecond_early_and_yields_for_the_rest() -> None:
    world = World()
    pacer = Pacer(50.0, world.now, world.sleep)
    starts(world, pacer, 2, lambda _: 0.005)
    long = [seconds for seconds in world.sleeps if seconds > 0.0]
    assert long == [pytest.approx(0.020 - 0.005 - 0.001, abs=1e-4)]
    assert 30 < world.sleeps.count(0.0) < 60  # 1 ms of yields of 20 µs


def test_a_sleep_that_ends_late_does_not_add_up() -> None:
    world = World(oversleep=0.003)
    pacer = Pacer(60.0, world.now, world.sleep)
    times = starts(world, pacer, 601, lambda _: 0.004)
    assert times[-1] - times[0] == pytest.approx(600 / 60.0, abs=0.003)
    assert pacer.late == 0


def test_a_late_frame_is_counted_and_not_made_up_for() -> None:
    world = World()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = starts(world, pacer, 12, lambda number: 0.100 if number == 4 else 0.002)
    gaps = [after - before for before, after in pairwise(times)]
    assert gaps[4] == pytest.approx(0.100, abs=1e-4)
    assert gaps[5:] == [pytest.approx(1 / 60.0, abs=1e-4)] * 6, "no burst after the stall"
    assert pacer.late == 1


def test_a_frame_just_over_the_period_is_no_late_frame() -> None:
    world = World()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = starts(world, pacer, 12, lambda number: 0.020 if number == 4 else 0.002)
    assert times[-1] - times[0] == pytest.approx(11 / 60.0, abs=1e-4), "back on the grid"
    assert pacer.late == 0


def test_a_machine_that_is_always_too_slow_never_sleeps() -> None:
    world = World()
    pacer = Pacer(60.0, world.now, world.sleep)
    times = starts(world, pacer, 50, lambda _: 0.030)
    assert world.sleeps == []
    assert times[-1] - times[0] == pytest.approx(49 * 0.030, abs=1e-3)
    assert pacer.late == 49


@pytest.mark.parametrize("display_hz", [59.94, 60.0, 60.02])
def test_a_display_that_paces_is_not_disturbed_by_a_pacer_a_little_faster(display_hz: float) -> None:
    world = World()
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
def test_impossible_rates_are_refused(fps: float) -> None:
    with pytest.raises(ValueError, match="1 to 1000"):
        Pacer(fps, lambda: 0.0, lambda _: None)
