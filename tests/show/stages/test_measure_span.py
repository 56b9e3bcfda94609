"""MeasureSpan: fractions never decrease, while measure lines can move."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.timeline import Timeline
from live.show.stages.measure_span import MeasureSpan


def test_fractions_and_next_measure_are_computed():
    timeline = Timeline(tempo=120, beats_per_measure=3)
    span = MeasureSpan.at(timeline, 4.0)
    assert (span.number, span.end) == (1, 6.0)
    assert [span.fraction(b) for b in (2.0, 3.0, 4.5, 6.0, 9.0)] == [0, 0, 0.5, 1, 1]
    following = span.next(timeline)
    assert (following.number, following.end) == (2, 9.0)


@given(st.floats(0.0, 7.9), st.integers(0, 3), st.integers(2, 7))
def test_moved_line_is_reached_with_increasing_fractions(press, shift, size):
    timeline = Timeline(tempo=120, beats_per_measure=size)
    span = MeasureSpan.at(timeline, press)
    before = span.fraction(press)
    moved = Timeline(tempo=120, beats_per_measure=size, measure_origin=float(shift))
    changed = span.follow(moved, press, shortest=0.5)
    assert changed == (shift % size != 0)
    assert span.fraction(press) == pytest.approx(before, abs=1e-9)
    assert span.end >= press + 0.5 - 1e-9 or not changed
    assert (span.end - shift) % size == pytest.approx(0, abs=1e-6) or (span.end - shift) % size == pytest.approx(size)
    beats = [press + k * (span.end - press) / 50 for k in range(51)]
    fractions = [span.fraction(b) for b in beats]
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)
    assert not span.follow(moved, press, shortest=0.5)


def test_tiny_line_shift_skips_or_repeats_no_measure():
    span = MeasureSpan(0, 0.0, 4.0)
    nearly = Timeline(beats_per_measure=4, measure_origin=1e-5)
    assert span.next(nearly).end == pytest.approx(8.0, abs=1e-3)


@given(st.floats(0.0, 7.95), st.floats(0.001, 0.999), st.integers(0, 3), st.integers(2, 7))
def test_beat_jump_keeps_the_danced_fraction(beat, leap, shift, size):
    timeline = Timeline(tempo=120, beats_per_measure=size)
    span = MeasureSpan.at(timeline, beat)
    before, number, after = span.fraction(beat), span.number, beat + leap
    moved = Timeline(tempo=120, beats_per_measure=size, measure_origin=float(shift))
    span.jump(moved, beat, after, shortest=0.5)
    span.follow(moved, after, shortest=0.5)
    assert span.number == number
    assert span.fraction(after) == pytest.approx(before, abs=1e-9)
    assert span.end > after
    assert (span.end - moved.measure_origin) % size == pytest.approx(0.0, abs=1e-6)


def test_beat_jump_over_line_ends_the_measure():
    timeline = Timeline(tempo=120)
    span = MeasureSpan.at(timeline, 3.9)
    span.jump(timeline, 4.05, 4.6, shortest=0.5)
    assert span.fraction(4.6) == 1.0
    following = span.next(timeline)
    assert following.fraction(4.6) == 0.0
    assert following.end == 8.0


@given(st.floats(0.0, 6.9), st.floats(0.0, 500.0), st.integers(2, 16), st.integers(2, 7))
def test_danced_beats_never_decrease_after_stall(begin, far, metre, size):
    """The music's measures may have other beats than the dance's: seven are danced in the time of four."""
    timeline = Timeline(tempo=120, beats_per_measure=metre)
    span, beat = MeasureSpan.at(timeline, begin), begin + far
    danced = span.danced_beats(begin, size)
    while True:
        assert span.danced_beats(beat, size) >= danced - 1e-9
        danced = span.danced_beats(beat, size)
        if beat < span.end:
            break
        span = span.next(timeline)
    assert danced == pytest.approx(size * beat / metre, abs=1e-6)


@given(
    st.floats(5.5, 2000.0), st.sampled_from((-3.7, -0.2, 0.0, 0.4, 7.3)), st.floats(0.0, 7.0), st.integers(2, 7),
    st.integers(2, 7),
)  # fmt: skip
def test_danced_beats_never_decrease_for_beat_jump_after_stall(late, leap, origin, size, other):
    span = MeasureSpan.at(Timeline(tempo=120, beats_per_measure=size), 0.0)
    before, after = size + late, size + late + leap
    danced = span.danced_beats(before, 4)
    moved = Timeline(tempo=120, beats_per_measure=other, measure_origin=origin)
    span.jump(moved, before, after, shortest=0.5)
    span.follow(moved, after, shortest=0.5)
    assert danced - 1e-6 <= span.danced_beats(after, 4) <= danced + 4 + 1e-6
    while span.end < after:
        now, span = span.danced_beats(after, 4), span.next(moved)
        assert span.danced_beats(after, 4) == pytest.approx(now, abs=1e-4)
