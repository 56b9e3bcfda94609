"""A known map: the beats of the piece in order, and a timeline that follows them to 5 ms."""

import numpy as np
import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.map_clock import MapBeat, MapClock
from live.clock.measure_map import MeasureLine, MeasureMap, TempoRun, steady_map
from tests.fixtures.mostly_long import mostly_long

TICK = 1 / 64


def played(clock: MapClock, seconds: float, step: float = 0.05) -> list[MapBeat]:
    return [beat for k in range(round(seconds / step)) for beat in clock.until(k * step)]


def test_beats_come_once_in_order_with_their_exact_times() -> None:
    beats = played(MapClock(steady_map(120.0, 1.25, 3, 8), 60.0), 6.0)
    assert [beat.position for beat in beats] == pytest.approx([-0.25 + 0.5 * k for k in range(len(beats))])
    assert [beat.beat for beat in beats[:8]] == [0, 1, 2, 0, 1, 2, 0, 1]  # the first line is the fourth of them
    assert {beat.beats_per_measure for beat in beats} == {3}
    assert not any(beat.jump for beat in beats)


def test_a_piece_that_repeats_begins_its_measures_again() -> None:
    beats = played(MapClock(steady_map(120.0, 0.0, 4, 5), 9.25), 20.0)
    jumps = [beat for beat in beats if beat.jump]
    assert [beat.position for beat in jumps] == pytest.approx([9.25, 18.5])
    assert [beat.beat for beat in jumps] == [0, 0]


def human_map(seed: int, run: TempoRun) -> MeasureMap:
    """Return measures whose tempo drifts as a band's does, with a ramp of 20 % over eight of them."""
    rng = np.random.default_rng(seed)
    lines, time, tempo = [], 1.4, 2.0
    for number in range(1, 60):
        lines.append(MeasureLine(time, number, 4, run))
        tempo *= 1.0 + rng.normal(0.0, 0.004)
        tempo *= 1.025 if 20 <= number < 28 else 1.0
        time += 4.0 / tempo
    return MeasureMap(lines)


@pytest.mark.parametrize("run", ["step", "ramp"])
@mostly_long("seed", range(3), quick=[1])
def test_the_timeline_follows_a_band_within_5_ms(seed: int, run: TempoRun) -> None:
    measures = human_map(seed, run)
    follower = TimelineFollower(one_at=1.4, known_tempo=120.0)
    clock = MapClock(measures, 600.0)
    worst = 0.0
    for tick in range(int(100 / TICK)):
        now = tick * TICK
        for beat in clock.until(now):
            follower.observe(
                beat.position, beat.period, 1.0, now, source="map", beat=beat.beat,
                beats_per_measure=beat.beats_per_measure, jump=beat.jump,
            )  # fmt: skip
        timeline = follower.advance(now)
        if now > 4.0:
            wanted = measures.beat_at(now)
            error = (timeline.beat_at(now) - timeline.measure_origin - wanted + 2.0) % 4.0 - 2.0
            worst = max(worst, abs(error) * 60.0 / timeline.tempo)
    assert follower.source == "map"
    assert worst < 0.005


def test_a_corrected_map_is_told_from_then_on() -> None:
    clock = MapClock(None, 60.0)
    assert list(clock.until(1.0)) == []
    assert not clock.is_known
    clock.replace(steady_map(120.0, 0.0, 4, 20))
    assert [beat.position for step in (2.0, 2.6) for beat in clock.until(step)] == [2.0, 2.5]
    clock.replace(steady_map(120.0, 0.0, 4, 20))  # the same: nothing is told again
    assert list(clock.until(2.9)) == []
    clock.replace(steady_map(120.0, 0.3, 3, 20))
    beats = [beat for step in (2.9, 3.4) for beat in clock.until(step)]
    assert [beat.position for beat in beats] == pytest.approx([2.8, 3.3])
    assert [(beat.beat, beat.beats_per_measure) for beat in beats] == [(2, 3), (0, 3)]
    clock.replace(None)
    assert list(clock.until(4.0)) == []
