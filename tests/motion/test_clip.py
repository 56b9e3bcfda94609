"""Tests of clip resampling: common samples are kept, others are interpolated, and the ends are kept."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from live.motion.clip import Clip, resample
from live.motion.skeleton import JOINT_COUNT


def made_clip(samples: int, rate: float, seed: int = 0) -> Clip:
    rng = np.random.default_rng(seed)
    turns = np.concatenate((np.ones((samples, JOINT_COUNT, 1)), rng.normal(size=(samples, JOINT_COUNT, 3))), axis=-1)
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    root = rng.normal(size=(samples, 3))
    contact = rng.random((samples, 2)) < 0.5
    return Clip("made", root.astype(np.float32), turns.astype(np.float32), rate, contact)


def test_resampling_at_same_rate_returns_same_clip() -> None:
    clip = made_clip(9, 60.0)
    assert resample(clip, 60.0) is clip


@pytest.mark.parametrize(("rate", "step"), [(30.0, 2), (20.0, 3), (12.0, 5)])
def test_divided_rate_keeps_every_nth_sample(rate: float, step: int) -> None:
    clip = made_clip(31, 60.0)
    fewer = resample(clip, rate)
    assert (fewer.sample_rate, fewer.seconds) == (rate, clip.seconds)
    np.testing.assert_allclose(fewer.root_position, clip.root_position[::step], atol=1e-6)
    dots = np.abs(np.sum(fewer.rotation * clip.rotation[::step], axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-6)
    np.testing.assert_array_equal(fewer.contact, clip.contact[::step])


def test_joints_are_slerped_and_root_is_linear_between_samples() -> None:
    clip = made_clip(13, 60.0)
    part = resample(clip, 100.0, first=2.25, last=9.75)
    at = 2.25 + np.arange(part.sample_count) * 0.6
    assert at[-1] <= 9.75 < at[-1] + 0.6
    for axis in range(3):
        expected = np.interp(at, np.arange(13), clip.root_position[:, axis])
        np.testing.assert_allclose(part.root_position[:, axis], expected, atol=1e-5)
    for joint in (0, 7, 21):
        turns = Rotation.from_quat(clip.rotation[:, joint][:, [1, 2, 3, 0]])
        got = Rotation.from_quat(part.rotation[:, joint][:, [1, 2, 3, 0]])
        assert (got * Slerp(np.arange(13), turns)(at).inv()).magnitude().max() < 2e-3  # float32


def test_one_sample_is_accepted_and_outside_ranges_are_refused() -> None:
    one = made_clip(1, 60.0)
    assert resample(one, 30.0).sample_count == 1
    for first, last in ((-0.1, 3.0), (4.0, 3.0), (0.0, 8.1)):
        with pytest.raises(ValueError, match="within 0 to 8 expected"):
            resample(made_clip(9, 60.0), 30.0, first=first, last=last)
