"""Timeline: bijection of beats and times, and positions of the measures."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.timeline import Timeline, next_phase_match, phase

tempi = st.floats(20.0, 400.0)
times = st.floats(-1e4, 1e5)
beats = st.floats(-1e5, 1e5)
timelines = st.builds(
    Timeline,
    tempo=tempi,
    beat_origin=beats,
    time_origin=times,
    beats_per_measure=st.integers(1, 12),
    measure_origin=st.floats(-1e4, 1e4),
)


@given(timelines, times)
def test_beat_and_time_are_inverse(timeline: Timeline, time: float) -> None:
    assert timeline.time_at(timeline.beat_at(time)) == pytest.approx(time, abs=1e-6)


@given(timelines, times)
def test_measure_and_phase_make_up_the_beat(timeline: Timeline, time: float) -> None:
    whole = timeline.measure_at(time) * timeline.beats_per_measure + timeline.measure_origin
    assert whole + timeline.phase_at(time) == pytest.approx(timeline.beat_at(time), abs=1e-6)
    assert 0.0 <= timeline.phase_at(time) < timeline.beats_per_measure


@given(timelines, tempi, times, times)
def test_tempo_change_keeps_the_current_beat(timeline: Timeline, tempo: float, change: float, later: float) -> None:
    changed = timeline.with_tempo(tempo, change)
    assert changed.beat_at(change) == timeline.beat_at(change)
    assert changed.beat_at(change + 60.0 / tempo) == pytest.approx(timeline.beat_at(change) + 1.0, abs=1e-6)
    assert (changed.beats_per_measure, changed.measure_origin) == (timeline.beats_per_measure, timeline.measure_origin)


@given(timelines, times)
def test_downbeat_is_set_at_the_nearest_beat(timeline: Timeline, time: float) -> None:
    marked = timeline.with_downbeat_at(time)
    off = marked.phase_at(time)
    assert min(off, marked.beats_per_measure - off) <= 0.5 + 1e-6
    assert marked.beat_at(time) == timeline.beat_at(time)
    assert abs(marked.measure_origin - timeline.measure_origin) <= timeline.beats_per_measure / 2 + 0.5 + 1e-9
    assert marked.with_downbeat_at(time) == marked


@given(beats, st.sampled_from([1.0, 2.0, 3.0, 4.0, 7.0, 0.5]))
def test_phase_lies_in_the_quantum(beat: float, quantum: float) -> None:
    assert 0.0 <= phase(beat, quantum) < quantum
    assert phase(beat + quantum, quantum) == pytest.approx(phase(beat, quantum), abs=1e-6) or math.isclose(
        abs(phase(beat + quantum, quantum) - phase(beat, quantum)), quantum, abs_tol=1e-6
    )


def test_phase_just_before_the_measure_line_is_zero() -> None:
    assert phase(-1e-18, 4.0) == 0.0
    assert Timeline(tempo=60.0).measure_at(-1e-18) == 0


@given(beats, beats, st.integers(1, 8))
def test_next_phase_match_lies_ahead_within_one_quantum(beat: float, target: float, quantum: int) -> None:
    match = next_phase_match(beat, target, quantum)
    assert beat <= match <= beat + quantum
    turns = (match - target) / quantum
    assert turns == pytest.approx(round(turns), abs=1e-6)


def test_waltz_measures_have_three_beats() -> None:
    waltz = Timeline(tempo=180.0, beats_per_measure=3)
    assert [waltz.measure_at(second) for second in (0.0, 0.99, 1.0, 1.99, -0.01)] == [0, 0, 1, 1, -1]
    assert waltz.phase_at(1.5) == pytest.approx(1.5)


@pytest.mark.parametrize("tempo", [19.9, 400.1, math.nan, math.inf, 0.0, -120.0])
def test_absurd_tempo_is_refused(tempo: float) -> None:
    with pytest.raises(ValueError, match="bpm"):
        Timeline(tempo=tempo)


def test_measure_without_beats_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        Timeline(beats_per_measure=0)
