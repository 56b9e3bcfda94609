"""Tests of motion beats and beat alignment: a pendulum with known turning points, both directions of the score."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.quality.metrics import beat_alignment, beat_offsets, mean_speed, motion_beats

times = st.lists(st.floats(0.0, 30.0), min_size=0, max_size=20)


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
def test_pendulum_beats_at_turning_points(rate):
    """One joint swings with a period of 2 s from the time 0.3 s on: it stands still every second."""
    time = np.arange(int(8 * rate)) / rate
    position = np.zeros((len(time), 1, 3))
    position[:, 0, 0] = np.cos(math.pi * (time - 0.3))
    found = motion_beats(mean_speed(position, rate), rate)
    np.testing.assert_allclose(found, 0.3 + np.arange(8), atol=1.0 / rate)
    np.testing.assert_allclose(motion_beats(mean_speed(position, rate), rate, 5.0), found + 5.0)


def test_still_or_short_motion_has_no_beats():
    assert len(motion_beats(np.zeros(100), 60.0)) == 0
    assert len(motion_beats(np.ones(2), 60.0)) == 0


@given(times, times)
def test_beat_offsets_equal_loop_result(beats, others):
    found = beat_offsets(np.array(beats), np.array(others))
    if not beats or not others:
        assert len(found) == 0
        return
    for beat, offset in zip(beats, found, strict=True):
        assert abs(offset) == pytest.approx(min(abs(other - beat) for other in others))
        assert min(abs(beat + offset - other) for other in others) < 1e-9


def test_alignment_directions_differ():
    """Every beat of the music has a motion beat, but only every second motion beat is on a music beat."""
    music, motion = np.arange(10.0), np.arange(0.0, 9.6, 0.5)
    assert beat_alignment(music, motion) == pytest.approx(1.0)
    assert beat_alignment(motion, music) == pytest.approx(0.5, abs=1e-6)


def test_alignment_kernel_is_50_ms_wide():
    assert beat_alignment(np.array([1.0]), np.array([1.05])) == pytest.approx(math.exp(-0.5))
    assert beat_alignment(np.array([1.0]), np.zeros(0)) == 0.0
    assert beat_alignment(np.zeros(0), np.array([1.0])) is None
