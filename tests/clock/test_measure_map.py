"""Measure map: beats over time and back, corrections, and what a map may not be."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.clock.measure_map import MeasureLine, MeasureMap, Phrase, steady_map

LINES = [
    MeasureLine(2.0, 1, 4), MeasureLine(4.0, 2, 3), MeasureLine(6.0, 3, 4, "ramp"), MeasureLine(7.6, 4, 4),
    MeasureLine(9.0, 5, 4),
]  # fmt: skip


def test_every_line_lies_at_its_beat() -> None:
    found = MeasureMap(LINES)
    for index, (line, beat) in enumerate(zip(LINES, (0, 4, 7, 11, 15), strict=True)):
        assert found.line_beat(index) == beat
        assert found.time_at(beat) == pytest.approx(line.time_s, abs=1e-12)
        assert found.beat_at(line.time_s) == pytest.approx(beat, abs=1e-12)


def test_the_tempo_goes_on_before_and_after() -> None:
    found = MeasureMap(LINES)
    assert found.beat_at(1.0) == pytest.approx(-2.0)
    assert found.time_at(-4.0) == pytest.approx(0.0)
    assert found.time_at(19.0) == pytest.approx(9.0 + 1.4)
    assert MeasureMap([MeasureLine(3.0, 1)]).beat_at(4.0) == pytest.approx(2.0)  # 120 bpm


def test_a_ramp_begins_with_the_tempo_before_it_and_runs_evenly() -> None:
    found = MeasureMap(LINES)

    def tempo(time: float) -> float:
        return (found.beat_at(time + 1e-6) - found.beat_at(time - 1e-6)) / 2e-6

    assert tempo(5.0) == pytest.approx(1.5)
    assert tempo(6.0001) == pytest.approx(1.5, abs=1e-3)
    assert tempo(7.5999) == pytest.approx(2 * 4 / 1.6 - 1.5, abs=1e-3)
    assert tempo(6.8) == pytest.approx(4 / 1.6, abs=1e-3)  # halfway the mean


@given(
    st.lists(st.tuples(st.floats(0.1, 9), st.integers(1, 12), st.sampled_from(["step", "ramp"])), min_size=1),
    st.floats(0, 50),
    st.floats(-20, 250),
)
def test_times_and_beats_are_inverse_and_rise(rows: list[tuple[float, int, str]], begin: float, beat: float) -> None:
    lines, time = [], begin
    for number, (length, beats, run) in enumerate(rows, start=1):
        lines.append(MeasureLine(time, number, beats, run))  # type: ignore[arg-type]
        time += length
    found = MeasureMap(lines)
    assert found.beat_at(found.time_at(beat)) == pytest.approx(beat, abs=1e-6)
    assert found.time_at(beat + 0.25) > found.time_at(beat)


def test_a_steady_map_is_a_tempo() -> None:
    found = steady_map(96.0, 1.25, 3, 40)
    assert found.bpm == pytest.approx(96.0)
    assert found.time_at(30.0) == pytest.approx(1.25 + 30 * 60 / 96)


def test_a_line_can_be_inserted_and_removed() -> None:
    found = MeasureMap(LINES, [Phrase(3, "B"), Phrase(1, "A")])
    more = found.with_line(5.0)
    assert [(line.time_s, line.measure, line.beats) for line in more.lines[1:4]] == [
        (4.0, 2, 2),
        (5.0, 3, 1),
        (6.0, 4, 4),
    ]
    assert [(line.time_s, line.beats) for line in more.without_line(2).lines] == [
        (line.time_s, line.beats) for line in LINES
    ]
    assert [line.time_s for line in found.with_line(0.5).lines][:2] == [0.5, 2.0]
    assert found.with_line(0.5).lines[0].beats == 3
    assert found.with_line(11.0).lines[-1] == MeasureLine(11.0, 6, 4)
    assert [phrase.name for phrase in more.phrases] == ["A", "B"]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "a map needs a measure line"),
        ([MeasureLine(1.0, 1), MeasureLine(1.0, 2)], "lines go forward"),
        ([MeasureLine(2.0, 1), MeasureLine(1.0, 2)], "measure 2 begins at 1 s"),
        ([MeasureLine(1.0, 1), MeasureLine(2.0, 3)], "counted on by one"),
    ],
)
def test_impossible_maps_are_refused(lines: list[MeasureLine], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        MeasureMap(lines)


def test_the_only_line_stays() -> None:
    with pytest.raises(ValueError, match="cannot be removed"):
        MeasureMap([MeasureLine(1.0, 1)]).without_line(0)
    assert math.isfinite(MeasureMap([MeasureLine(1.0, 1)]).bpm)
