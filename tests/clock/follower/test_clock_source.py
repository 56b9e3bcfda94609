"""Parts of the follower: tempo levels, the beat filter, measure lines and observations."""

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.follower.beat_kalman_filter import BeatFilter
from live.clock.follower.clock_source import BeatMapping, BeatObservation
from live.clock.follower.phase_correction import LEAP_BEATS, SlewedTimeline
from live.clock.follower.tracker_inputs import BarPointerInput
from live.clock.timeline import Grid, Timeline

grids = st.builds(Grid, st.floats(-100.0, 1e4), st.floats(0.2, 2.0), st.integers(-1000, 100_000))


@given(grids, st.lists(st.tuples(st.sampled_from([0.5, 2.0]), st.integers(-50, 500)), max_size=6), st.floats(0.0, 1e4))
def test_beat_mapping_is_continuous_at_every_pivot(grid: Grid, scales: list[tuple[float, int]], time: float) -> None:
    level = BeatMapping()
    for factor, pivot in scales:
        before = level.map_grid(grid)
        if level.scale(factor, float(pivot)):
            after = level.map_grid(grid)
            at = before.time + (pivot - before.number) * before.period
            assert after.beat_at(at) == pytest.approx(pivot, abs=1e-5)
            assert after.period == pytest.approx(before.period / factor)
    assert 0.25 <= level.factor <= 4.0
    assert level.map_grid(grid).beat_at(time) == pytest.approx(level.map_beat(grid.beat_at(time)), abs=1e-4)


@given(st.floats(20.0, 400.0), st.floats(40.0, 90.0))
def test_tempo_is_folded_into_the_range(tempo: float, lowest: float) -> None:
    level = BeatMapping()
    level.fold(tempo, lowest, 2.1 * lowest)
    assert lowest <= tempo * level.factor <= 2.1 * lowest or level.factor in (0.25, 4.0)


def test_beat_filter_is_as_accurate_as_least_squares() -> None:
    """Against an ordinary least squares line over the last eight beats, the optimum for steady music."""
    generator, errors = random.Random(5), []
    for _ in range(30):
        said = [0.5 * k + generator.gauss(0.0, 0.010) for k in range(30)]
        beats = BeatFilter(said[0], 0.5, 0.7)
        assert all(beats.update(time, 0.5, 0.7) for time in said[1:])
        slope, begin = np.polyfit(range(22, 30), said[22:], 1)
        errors.append((beats.grid.time + beats.grid.period - 15.0, begin + 30.0 * slope - 15.0))
    ours, line = np.sqrt(np.mean(np.square(errors), axis=0))
    assert ours < 1.1 * line
    assert ours < 0.010


def test_repeated_observation_replaces_the_previous_one() -> None:
    once, twice = BeatFilter(0.0, 0.5, 0.8), BeatFilter(0.0, 0.5, 0.8)
    for k in range(1, 12):
        twice.update(0.5 * k + 0.02, 0.52, 0.8)
        assert once.update(0.5 * k, 0.5, 0.8)
        assert twice.update(0.5 * k, 0.5, 0.8)
        assert twice.grid == once.grid
    assert once.updates == twice.updates == 12


def test_inconsistent_observation_changes_nothing() -> None:
    beats = BeatFilter(0.0, 0.5, 0.8)
    for k in range(1, 12):
        beats.update(0.5 * k, 0.5, 0.8)
    before = beats.grid
    assert not beats.update(6.12, 0.5, 0.8)
    assert not beats.update(6.0, 0.6, 0.8)
    assert beats.grid == before
    assert beats.update(6.0, 0.5, 0.8)
    assert beats.grid.number == before.number + 1


@given(
    st.lists(
        st.tuples(st.floats(-0.2, 3.0), st.floats(0.15, 4.0), st.floats(0.0, 1.0), st.integers(-1, 6)), max_size=60
    )
)
def test_input_keeps_a_finite_grid_with_increasing_numbers(rows: list[tuple[float, float, float, int]]) -> None:
    ear, time, number = BarPointerInput(), 0.0, 0
    for step, period, confidence, beat in rows:
        time += step
        ear.observe(BeatObservation(time, period, confidence, beat, 4 if 0 <= beat < 4 else 0))
        assert ear.grid is not None
        assert math.isfinite(ear.grid.time)
        assert 0.05 < ear.grid.period < 8.0
        assert ear.grid.number >= number - 1
        number = max(number, ear.grid.number)
        assert 0.0 <= ear.share <= 1.0


@given(
    st.floats(20.0, 400.0), st.integers(1, 12), st.integers(1, 12), st.integers(-20, 20), st.integers(-50, 50),
    st.floats(0.0, 500.0),
)  # fmt: skip
def test_moved_measure_line_keeps_beat_and_measure_number(
    tempo: float, size: int, new: int, origin: int, line: int, time: float
) -> None:
    before = Timeline(tempo=tempo, beats_per_measure=size, measure_origin=float(origin))
    after = before.with_measure_line(float(line), time, beats_per_measure=new)
    assert (after.measure_origin - line) % new == 0.0
    assert after.beats_per_measure == new
    assert after.beat_at(time) == before.beat_at(time)
    number = before.measure_at(time)
    assert number <= after.measure_at(time) <= number + 1
    here, there = before.phase_at(time) / size, after.phase_at(time) / new
    assert abs(after.measure_at(time) + there - number - here) < 1.0


@given(st.floats(0.0, 100.0), st.floats(-3.0, 3.0), st.floats(0.2, 1.5))
def test_leap_moves_forward_less_than_a_beat_to_goal_phase(now: float, off: float, period: float) -> None:
    timeline = Timeline(tempo=60.0 / period)
    run = SlewedTimeline(timeline, Grid(now - off * period, period, math.floor(timeline.beat_at(now))))
    before = run.beat(now)
    wanted = run.goal.beat_at(now)
    run.request_leap("start")
    run.follow_goal(now, slew=0.2)
    forward = run.beat(now) - before
    assert 0.0 <= forward < 1.0
    assert (run.jumps == 1) == (forward > 0.0)
    left = (wanted - run.beat(now) + 0.5) % 1.0 - 0.5
    assert abs(left) < (1e-6 if forward else LEAP_BEATS + 1e-6)


@pytest.mark.parametrize(
    "said",
    [
        BeatObservation(math.nan, 0.5, 0.5), BeatObservation(10.0, math.inf, 0.5), BeatObservation(10.0, 0.5, math.nan),
        BeatObservation(10.0, 0.1, 0.5), BeatObservation(10.0, 5.0, 0.5), BeatObservation(30.0, 0.5, 0.5),
        BeatObservation(-1e300, 0.5, 0.5), BeatObservation(10.0, 0.5, 0.5, 4, 4), BeatObservation(10.0, 0.5, 0.5, -2),
        BeatObservation(10.0, 0.5, 0.5, 0, -1), BeatObservation(10.0, 0.5, 0.5, 0, 4, -2),
    ],
)  # fmt: skip
def test_invalid_observation_is_not_plausible(said: BeatObservation) -> None:
    assert not said.plausible(10.0)
    assert BeatObservation(10.1, 0.5, 0.5, 3, 4, 17).plausible(10.0)


def test_first_downbeat_is_counted_back_along_slow_beats() -> None:
    run = SlewedTimeline(Timeline(tempo=20.0, beats_per_measure=4), Grid(10.0, 3.9, 5))
    run.count_from(2.2, 10.0)  # two beats back: beat 3
    assert (run.timeline.measure_origin - 3.0) % 4.0 == 0.0
