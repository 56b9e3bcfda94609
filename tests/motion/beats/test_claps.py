"""Tests of clap detection (T018): synthetic hand touches with exactly known times are found within 5 ms."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from live.motion.beats.clap_sync import find_claps
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_motion
from tests.motion.retarget.made_source import NAMES, clapping_values, source

Apart = Callable[[np.ndarray], np.ndarray]


def palm_distance(times: np.ndarray, *, faster: float = 1.0, hold: float = 0.0, touch_cm: float = 6.0) -> Apart:
    """Distance of the palms [cm]: arcs between claps; `faster` over 1 closes faster than it opens; `hold` rests."""

    def apart(time: np.ndarray) -> np.ndarray:
        starts = np.concatenate(([times[0] - 1.0], times + hold))
        ends = np.concatenate((times, [times[-1] + hold + 1.0]))
        arc = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(starts) - 1)
        part = np.clip((time - starts[arc]) / (ends[arc] - starts[arc]), 0.0, 1.0)
        distance = touch_cm + 45.0 * np.sin(np.pi * part**faster)
        still = (time < starts[0] + 0.5) | (time > ends[-1] - 0.5)
        return np.where(still, touch_cm + 45.0, distance)

    return apart


def add_arm_noise(motion: SourceMotion, millimetres: float, seed: int = 1) -> SourceMotion:
    """Motion with noise added to the translations of both lower arms and hands."""
    random = np.random.default_rng(seed)
    translation = motion.translation.copy()
    arms = [NAMES.index(side + joint) for side in ("Left", "Right") for joint in ("ForeArm", "Hand")]
    translation[:, arms] += 0.1 * millimetres * random.normal(size=(len(translation), 4, 3))
    return replace(motion, translation=translation)


def scattered_clap_times(seed: int = 0) -> np.ndarray:
    """Eight clap times at a click of 120 bpm, with 12 ms of scatter."""
    return 1.5 + 0.5 * np.arange(8) + np.random.default_rng(seed).normal(0.0, 0.012, 8)


@pytest.mark.parametrize("fps", [60.0, 100.0, 120.0])
@pytest.mark.parametrize(("faster", "limit"), [(1.0, 0.0005), (1.3, 0.005), (0.85, 0.005)])
def test_clap_times_are_found_within_limit(fps: float, faster: float, limit: float) -> None:
    truth = scattered_clap_times()
    found = find_claps(body_tracks(source(clapping_values(palm_distance(truth, faster=faster), 8.0, fps), fps)))
    assert len(found) == len(truth)
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=limit)
    assert all(clap.distance_m < 0.16 for clap in found)


@pytest.mark.parametrize("fps", [60.0, 100.0, 120.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_clap_times_are_found_in_noise(fps: float, seed: int) -> None:
    truth = scattered_clap_times(seed)
    motion = add_arm_noise(source(clapping_values(palm_distance(truth), 8.0, fps), fps), 1.0, seed)
    found = find_claps(body_tracks(motion))
    assert len(found) == len(truth)
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=0.005)


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_resting_hands_count_from_first_contact(fps: float) -> None:
    truth = scattered_clap_times()
    found = find_claps(body_tracks(source(clapping_values(palm_distance(truth, hold=0.1), 8.0, fps), fps)))
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=0.005)


def test_clap_times_count_from_first_kept_frame() -> None:
    motion = source(clapping_values(palm_distance(scattered_clap_times()), 8.0, 60.0), 60.0)
    all_of_it, kept = find_claps(body_tracks(motion)), find_claps(body_tracks(motion), 30)
    np.testing.assert_allclose([c.time_s for c in kept], [c.time_s - 0.5 for c in all_of_it], atol=1e-9)


def test_true_frame_rate_scales_clap_times() -> None:
    motion = source(clapping_values(palm_distance(scattered_clap_times()), 8.0, 60.0), 60.0)
    wrong_rate = replace(motion, frame_time=1.0 / 120.0)
    found = find_claps(body_tracks(wrong_rate, fps=60.0))
    np.testing.assert_allclose([clap.time_s for clap in found], scattered_clap_times(), atol=0.0005)


def test_folding_hands_is_not_a_clap() -> None:
    """The hands come together slowly and stay."""

    def folded(time: np.ndarray) -> np.ndarray:
        return 6.0 + 40.0 * np.clip(np.abs(time - 4.0) - 1.0, 0.0, 1.0)

    slow = source(clapping_values(lambda time: np.minimum(folded(time), 46.0), 8.0, 60.0), 60.0)
    assert find_claps(body_tracks(slow)) == []


def test_distant_swinging_hands_are_not_claps() -> None:
    far = source(clapping_values(palm_distance(scattered_clap_times(), touch_cm=30.0), 8.0, 60.0), 60.0)
    assert find_claps(body_tracks(far)) == []


def test_passing_hands_are_not_claps() -> None:
    motion = source(clapping_values(palm_distance(scattered_clap_times()), 8.0, 60.0), 60.0)
    tracks = body_tracks(motion)
    random = np.random.default_rng(4)
    time = np.arange(480) / 60.0
    left = np.stack((0.6 * np.sin(2.0 * np.pi * time), np.full(480, 1.2), np.full(480, 0.3)), axis=1)
    right = left * (-1.0, 1.0, 1.0) + (0.0, 0.04, 0.0) + 1e-4 * random.normal(size=(480, 3))
    crossing = replace(tracks, palms=np.stack((left, right), axis=1))
    assert find_claps(crossing) == []


def test_short_recordings_have_no_claps() -> None:
    for frames in (1, 2, 5, 9):
        assert (
            find_claps(
                body_tracks(source(clapping_values(palm_distance(scattered_clap_times()), 8.0, 60.0)[:frames], 60.0))
            )
            == []
        )


@pytest.mark.shared
@pytest.mark.parametrize("name", ["walk/cmu_12_01_walk.bvh", "walk/figure8_MS2_8Walk_M.bvh", "walk/131_01_styled.bvh"])
def test_walking_recordings_have_no_claps(name: str) -> None:
    assert find_claps(body_tracks(mocap_motion(name))) == []
