"""Tests of the frame time statistics: sums, percentiles and the cause of late frames."""

import numpy as np
import pytest

from live.render.timing.frame_stats import GRAPH_FRAMES, HISTORY_FRAMES, PARTS, WAITING, FrameTimes

USUAL = {"events": 0.2, "simulation": 3.0, "poses": 1.0, "upload": 0.3, "draw": 4.0, "rest": 0.5, "swap": 6.0}


class FrameLoop:
    def __init__(self):
        self.time = 5.0
        self.times = FrameTimes(lambda: self.time)

    def frame(self, wait=0.0, **others):
        """One frame with the usual durations except `others` [ms]."""
        self.time += wait * 1e-3
        self.times.begin()
        for part in PARTS:
            self.time += (USUAL | others)[part] * 1e-3
            self.times.mark(part)
        self.times.end()
        return self.times

    def usual(self, count=200):
        """A number of usual frames in time."""
        for _ in range(count):
            self.frame().record_cause(1.0 / 50.0, late=False)
        return self


def test_part_and_frame_times_match_durations():
    world = FrameLoop()
    for _ in range(100):
        world.frame(wait=1.0)
    facts = world.times.facts()
    for part, took in USUAL.items():
        assert facts["parts"][part] == [pytest.approx(took, abs=0.002)] * 3
    out = np.zeros(GRAPH_FRAMES, np.float32)
    assert world.times.copy_recent(out) == 99
    assert out[:99] == pytest.approx(np.full(99, sum(USUAL.values()) + 1.0), abs=0.01)
    assert world.times.load(1.0 / 50.0) == pytest.approx((sum(USUAL.values()) - USUAL["swap"]) / 20.0, abs=0.001)


def test_percentiles_separate_rare_from_usual_durations():
    world = FrameLoop()
    for number in range(1000):
        world.frame(draw=40.0 if number % 50 == 0 else 4.0)
    assert world.times.facts()["parts"]["draw"] == [pytest.approx(4.0, abs=0.01)] + [pytest.approx(40.0, abs=0.01)] * 2


@pytest.mark.parametrize("part", PARTS)
def test_slowest_part_against_usual_is_recorded_as_cause(part):
    world = FrameLoop().usual()
    assert world.frame(**{part: USUAL[part] + 15.0}).record_cause(1.0 / 60.0, late=True) == part
    assert world.times.facts()["late_by"] == {part: 1}


def test_late_wakeup_is_recorded_as_waiting():
    world = FrameLoop().usual()
    assert world.frame(wait=20.0).record_cause(1.0 / 50.0, late=True) == WAITING


def test_persistently_slow_part_stays_recorded_as_cause():
    world = FrameLoop().usual(300)
    blamed = {world.frame(draw=30.0).record_cause(1.0 / 60.0, late=True) for _ in range(20)}
    assert blamed == {"draw"}


def test_frame_history_wraps_around():
    world = FrameLoop()
    for number in range(HISTORY_FRAMES + 300):
        world.frame(draw=float(number % 7))
    out = np.zeros(GRAPH_FRAMES, np.float32)
    assert world.times.copy_recent(out) == GRAPH_FRAMES
    assert out[-1] == pytest.approx(sum(USUAL.values()) - 4.0 + (HISTORY_FRAMES + 298) % 7, abs=0.01)
    assert FrameTimes(lambda: 0.0).copy_recent(out) == 0
    assert FrameTimes(lambda: 0.0).record_cause(0.02, late=True) == ""


def test_longest_part_is_cause_without_any_timely_frame():
    world = FrameLoop()
    assert {world.frame(draw=90.0, simulation=20.0).record_cause(0.02, late=True) for _ in range(50)} == {"draw"}
