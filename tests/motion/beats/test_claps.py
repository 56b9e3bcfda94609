"""Claps: made hands whose touches are known to the microsecond are found within 5 ms (T018)."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from live.motion.beats.clap_sync import find_claps
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_motion
from tests.motion.retarget.made_source import NAMES, clapping, source

Apart = Callable[[np.ndarray], np.ndarray]


def hands(times: np.ndarray, *, faster: float = 1.0, hold: float = 0.0, touch_cm: float = 6.0) -> Apart:
    """Distance of the palms [cm]: arcs between claps; `faster` over 1 closes quicker than it opens; `hold` rests."""

    def apart(time: np.ndarray) -> np.ndarray:
        starts = np.concatenate(([times[0] - 1.0], times + hold))
        ends = np.concatenate((times, [times[-1] + hold + 1.0]))
        arc = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(starts) - 1)
        part = np.clip((time - starts[arc]) / (ends[arc] - starts[arc]), 0.0, 1.0)
        distance = touch_cm + 45.0 * np.sin(np.pi * part**faster)
        still = (time < starts[0] + 0.5) | (time > ends[-1] - 0.5)
        return np.where(still, touch_cm + 45.0, distance)

    return apart


def shaken(motion: SourceMotion, millimetres: float, seed: int = 1) -> SourceMotion:
    """The same with noise on both lower arms' and hands' places."""
    random = np.random.default_rng(seed)
    translation = motion.translation.copy()
    arms = [NAMES.index(side + joint) for side in ("Left", "Right") for joint in ("ForeArm", "Hand")]
    translation[:, arms] += 0.1 * millimetres * random.normal(size=(len(translation), 4, 3))
    return replace(motion, translation=translation)


def uneven(seed: int = 0) -> np.ndarray:
    """Eight claps that a person makes to a click of 120 bpm: 12 ms about it."""
    return 1.5 + 0.5 * np.arange(8) + np.random.default_rng(seed).normal(0.0, 0.012, 8)


@pytest.mark.parametrize("fps", [60.0, 100.0, 120.0])
@pytest.mark.parametrize(("faster", "limit"), [(1.0, 0.0005), (1.3, 0.005), (0.85, 0.005)])
def test_times(fps: float, faster: float, limit: float) -> None:
    truth = uneven()
    found = find_claps(body_tracks(source(clapping(hands(truth, faster=faster), 8.0, fps), fps)))
    assert len(found) == len(truth)
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=limit)
    assert all(clap.distance_m < 0.16 for clap in found)


@pytest.mark.parametrize("fps", [60.0, 100.0, 120.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_times_in_noise(fps: float, seed: int) -> None:
    truth = uneven(seed)
    motion = shaken(source(clapping(hands(truth), 8.0, fps), fps), 1.0, seed)
    found = find_claps(body_tracks(motion))
    assert len(found) == len(truth)
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=0.005)


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_hands_that_rest_on_each_other_met_when_they_met(fps: float) -> None:
    truth = uneven()
    found = find_claps(body_tracks(source(clapping(hands(truth, hold=0.1), 8.0, fps), fps)))
    np.testing.assert_allclose([clap.time_s for clap in found], truth, atol=0.005)


def test_times_count_from_the_first_frame_that_is_kept() -> None:
    motion = source(clapping(hands(uneven()), 8.0, 60.0), 60.0)
    all_of_it, kept = find_claps(body_tracks(motion)), find_claps(body_tracks(motion), 30)
    np.testing.assert_allclose([c.time_s for c in kept], [c.time_s - 0.5 for c in all_of_it], atol=1e-9)


def test_the_true_rate_scales_times() -> None:
    motion = source(clapping(hands(uneven()), 8.0, 60.0), 60.0)
    lying = replace(motion, frame_time=1.0 / 120.0)
    found = find_claps(body_tracks(lying, fps=60.0))
    np.testing.assert_allclose([clap.time_s for clap in found], uneven(), atol=0.0005)


def test_folding_the_hands_is_no_clap() -> None:
    """They come together slowly and stay."""

    def folded(time: np.ndarray) -> np.ndarray:
        return 6.0 + 40.0 * np.clip(np.abs(time - 4.0) - 1.0, 0.0, 1.0)

    slow = source(clapping(lambda time: np.minimum(folded(time), 46.0), 8.0, 60.0), 60.0)
    assert find_claps(body_tracks(slow)) == []


def test_swinging_hands_that_stay_apart_are_no_claps() -> None:
    far = source(clapping(hands(uneven(), touch_cm=30.0), 8.0, 60.0), 60.0)
    assert find_claps(body_tracks(far)) == []


def test_hands_that_pass_each_other_are_no_claps() -> None:
    motion = source(clapping(hands(uneven()), 8.0, 60.0), 60.0)
    tracks = body_tracks(motion)
    random = np.random.default_rng(4)
    time = np.arange(480) / 60.0
    left = np.stack((0.6 * np.sin(2.0 * np.pi * time), np.full(480, 1.2), np.full(480, 0.3)), axis=1)
    right = left * (-1.0, 1.0, 1.0) + (0.0, 0.04, 0.0) + 1e-4 * random.normal(size=(480, 3))
    crossing = replace(tracks, palms=np.stack((left, right), axis=1))
    assert find_claps(crossing) == []


def test_short_recordings() -> None:
    for frames in (1, 2, 5, 9):
        assert find_claps(body_tracks(source(clapping(hands(uneven()), 8.0, 60.0)[:frames], 60.0))) == []


@pytest.mark.shared
@pytest.mark.parametrize("name", ["walk/cmu_12_01_walk.bvh", "walk/figure8_MS2_8Walk_M.bvh", "walk/131_01_styled.bvh"])
def test_walkers_do_not_clap(name: str) -> None:
    assert find_claps(body_tracks(mocap_motion(name))) == []
