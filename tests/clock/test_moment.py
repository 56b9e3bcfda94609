"""Moment: one reading of a timeline."""

import pytest

from live.clock.timeline import Moment, Timeline


def test_moment_contains_beat_measure_and_phase() -> None:
    moment = Moment.of(Timeline(tempo=120.0, measure_origin=1.0), 3.0, confidence=0.5)
    assert (moment.time, moment.beat, moment.measure, moment.phase) == (3.0, 6.0, 1, 1.0)
    assert (moment.tempo, moment.confidence) == (120.0, 0.5)


def test_measure_before_the_first_is_negative() -> None:
    moment = Moment.of(Timeline(tempo=60.0), -0.5)
    assert moment.measure == -1
    assert moment.phase == pytest.approx(3.5)
