"""Tests of the motion recorder: results frame by frame against the whole motion at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.quality.metrics import largest_at_samples, mean_speed, skating_frames
from live.motion.quality.motion_recorder import MotionRecorder


@pytest.mark.long
@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(5, 300), st.sampled_from([24.0, 30.0, 60.0]))
def test_recorded_frames_equal_whole_motion(seed, count, rate):
    chance = np.random.default_rng(seed)
    motion = np.cumsum(chance.normal(0.0, 0.02, (count, 3, 22, 3)), axis=0).astype(np.float32)
    trace = MotionRecorder(rate)
    for picture in motion:
        trace.add(picture)
    change, acceleration = largest_at_samples(motion, rate)
    found = trace.largest()
    np.testing.assert_allclose(found[0], change, atol=1e-9)
    np.testing.assert_allclose(found[1], acceleration, atol=1e-9)
    np.testing.assert_allclose(trace.speeds(), mean_speed(motion, rate), atol=1e-9)
    frames = skating_frames(motion, rate)
    if len(frames):
        assert trace.skating_ratio() == pytest.approx(float(frames.mean()), abs=1.5 / frames.size)


def test_recorder_copies_frames():
    trace, picture = MotionRecorder(60.0), np.zeros((1, 22, 3), np.float32)
    for _ in range(10):
        trace.add(picture)
        picture += 1.0  # a show reuses the same array
    assert trace.speeds() == pytest.approx(np.sqrt(3.0) * 60.0)


def test_single_frame_has_no_results():
    trace = MotionRecorder(60.0)
    trace.add(np.zeros((2, 22, 3), np.float32))
    assert trace.skating_ratio() is None
    assert trace.speeds().size == 0
    assert trace.largest()[0].shape[0] == 1
