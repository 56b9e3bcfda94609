"""Frame times on simulated displays: even steps at any refresh rate and with late wake-ups."""

import numpy as np
import pytest

from live.render.timing.frame_stats import DisplayGrid, Pacer

RATES = pytest.mark.parametrize("rate", [50.0, 59.94, 60.0, 120.0])


class SimulatedDisplay:
    """A display with vertical synchronization at `rate` Hz, and a machine that wakes late.

    Each refresh shows the frame swapped before it; the swap returns at that time.
    """

    def __init__(self, rate, *, seed=1):
        self.rate, self.time = rate, 3.0
        self.random, self.stray = np.random.default_rng(seed), 0.08 / rate

    def now(self):
        self.time += 1e-6
        return self.time

    def sleep(self, seconds):
        self.time += max(seconds, 20e-6)

    def swap(self):
        """Wait for the next refresh; returns its time."""
        shown = (np.floor(self.time * self.rate) + 1.0) / self.rate
        # the machine goes on a little later, sometimes much
        self.time = shown + self.random.exponential(self.stray)
        return shown


def run_frame_loop(display, said, seconds, work=lambda number: 0.002):
    """Frames as in the live loop: return time of the last swap, its aligned time, and time of display."""
    pacer = Pacer(said * 1.05, display.now, display.sleep)
    grid = DisplayGrid(said)
    rows = []
    end = display.time + seconds
    swapped = display.now()
    while display.time < end:
        pacer.wait()
        began, at = swapped, grid.align(swapped)
        display.time += work(len(rows))
        rows.append((began, at, display.swap()))
        swapped = display.now()
    return np.array(rows), grid


@RATES
def test_aligned_times_are_even_when_frames_start_unevenly(rate):
    rows, grid = run_frame_loop(SimulatedDisplay(rate), round(rate), 30.0)
    started, at, shown = rows[int(rate) :].T  # after a second
    raw, even = (times - shown for times in (started, at))
    assert raw.std() > 0.05 / rate
    assert even.std() < 0.02 / rate
    assert even.std() < 0.3 * raw.std()
    assert grid.period == pytest.approx(1.0 / rate, rel=1e-3)


@RATES
def test_aligned_steps_match_display_without_drift(rate):
    """No drift between frame times and the display, and no interference of 60 with 59.94 Hz (one in 17 s)."""
    rows, _ = run_frame_loop(SimulatedDisplay(rate), round(rate), 40.0)
    _, at, shown = rows[int(2 * rate) :].T
    off = at - shown
    per_second = off[: len(off) // int(rate) * int(rate)].reshape(-1, int(rate)).mean(axis=1)
    assert np.ptp(per_second) < 0.05 / rate
    assert abs(np.polyfit(np.arange(len(per_second)), per_second, 1)[0]) < 20e-6
    steps = np.diff(at) * rate
    assert np.abs(steps - np.round(steps)).max() < 0.08
    assert np.array_equal(np.round(steps), np.round(np.diff(shown) * rate))


@RATES
def test_late_frame_is_one_longer_step(rate):
    rows, _ = run_frame_loop(
        SimulatedDisplay(rate), round(rate), 10.0, lambda number: 2.4 / rate if number % 200 == 199 else 0.003
    )
    _, at, shown = rows[int(rate) :].T
    steps, due = np.diff(at) * rate, np.round(np.diff(shown) * rate)
    assert due.max() >= 3
    assert np.abs(steps - np.round(steps)).max() < 0.12
    off = (at - shown)[np.r_[True, due == 1]]  # a late frame itself is shown late, nothing else is
    assert off.std() < 0.03 / rate


def test_grid_restarts_after_stall_and_time_never_goes_back():
    display = SimulatedDisplay(60.0)
    rows, _ = run_frame_loop(display, 60.0, 20.0, lambda number: 2.0 if number == 300 else 0.004)
    _, at, _ = rows.T
    assert (np.diff(at) >= 0.0).all()
    assert np.abs(at - rows[:, 0]).max() < 0.010


def test_loop_without_vertical_sync_keeps_nominal_period():
    display = SimulatedDisplay(1e6)  # swaps at once
    pacer, grid = Pacer(30.0, display.now, display.sleep), DisplayGrid(30.0)
    at = []
    for _ in range(300):
        at.append(grid.align(pacer.wait()))
        display.time += 0.012
    assert np.diff(at[30:]) == pytest.approx(np.full(269, 1.0 / 30.0), abs=0.2e-3)
