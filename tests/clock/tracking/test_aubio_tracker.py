"""AubioTracker: clicks at known times, any sample rate, any block size, and invalid samples."""

import numpy as np
import pytest

from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.tracking.aubio_tracker import SILENT_AFTER, AubioTracker
from tests.clock.clicks import clicks, groove
from tests.fixtures.mostly_long import mostly_long

RATE = 44_100


def feed(tracker: AubioTracker, sound: Samples, block: int = 512) -> list[BeatEstimate]:
    return [beat for start in range(0, sound.size, block) for beat in tracker.feed(sound[start : start + block])]


def lateness(beats: list[BeatEstimate], times: np.ndarray) -> np.ndarray:
    """Error of each estimate relative to the nearest true beat [s]."""
    return np.array([beat.position - times[np.argmin(np.abs(times - beat.position))] for beat in beats])


@mostly_long("bpm", [60, 80, 96, 112, 126, 140, 160, 180], quick=[0, 4])
def test_clicks_are_detected_without_bias(bpm: int) -> None:
    sound, times = clicks(bpm, RATE, 20.0)
    beats = [beat for beat in feed(AubioTracker(RATE), sound) if 5.0 < beat.position < times[-1] + 0.1]
    late = lateness(beats, times)
    assert len(beats) >= 0.9 * np.count_nonzero(times > 5.0)
    assert abs(np.mean(late)) < 0.003
    assert np.percentile(np.abs(late), 95) < 0.012
    assert 60.0 / np.median([beat.period for beat in beats]) == pytest.approx(bpm, rel=0.01)


@mostly_long("rate", [16_000, 22_050, 32_000, 48_000, 96_000, 192_000], quick=[0, 3])
def test_beats_are_found_at_any_sample_rate(rate: int) -> None:
    sound, times = clicks(120, rate, 15.0)
    tracker = AubioTracker(rate)
    assert 0.008 <= tracker.hop / rate <= 0.0165
    late = lateness([beat for beat in feed(tracker, sound) if 5.0 < beat.position < times[-1] + 0.1], times)
    assert late.size >= 15
    assert abs(np.mean(late)) < 0.005


@pytest.mark.parametrize("block", [1, 100, 441, 512, 4096, 1_000_000])
def test_beats_are_independent_of_block_size(block: int) -> None:
    sound, _ = clicks(120, 8_000, 6.0)
    assert feed(AubioTracker(8_000), sound, block) == feed(AubioTracker(8_000), sound, 64)


def test_tracker_is_causal() -> None:
    sound, _ = clicks(126, RATE, 12.0)
    whole = feed(AubioTracker(RATE), sound)
    cut = feed(AubioTracker(RATE), sound[: 7 * RATE])
    assert cut == [beat for beat in whole if beat.fed <= 7.0]
    assert all(beat.position < beat.fed + 0.05 for beat in whole)


def test_loud_hi_hats_on_offbeats_are_not_beats() -> None:
    beats = [beat for beat in feed(AubioTracker(RATE), groove(118, RATE, 20.0)) if beat.position > 8.0]
    off = np.array([(beat.position * 118 / 60.0 + 0.5) % 1.0 - 0.5 for beat in beats])
    assert len(beats) > 15
    assert np.mean(np.abs(off) < 0.15) > 0.9


def test_invalid_samples_are_counted_and_silenced() -> None:
    sound, times = clicks(120, RATE, 20.0)
    hurt = sound.copy()
    hurt[1000:40_000:977] = np.nan
    hurt[200_000] = np.inf
    hurt[300_000] = -np.inf
    hurt[400_000] = 1e30
    tracker = AubioTracker(RATE)
    beats = [beat for beat in feed(tracker, hurt) if 10.0 < beat.position < times[-1] + 0.1]
    assert tracker.bad_samples == len(range(1000, 40_000, 977)) + 3
    assert np.percentile(np.abs(lateness(beats, times)), 95) < 0.012
    assert hurt[400_000] == np.float32(1e30), "the caller's samples are not touched"


def test_sound_of_only_nan_gives_no_beats() -> None:
    tracker = AubioTracker(RATE)
    assert feed(tracker, np.full(5 * RATE, np.nan, np.float32)) == []
    assert tracker.bad_samples >= 5 * RATE - tracker.hop
    assert tracker.silent


def test_silence_is_detected_and_new_music_is_tracked() -> None:
    first, _ = clicks(120, RATE, 8.0)
    second, times = clicks(97, RATE, 12.0)
    tracker = AubioTracker(RATE)
    feed(tracker, first)
    assert not tracker.silent
    assert feed(tracker, np.zeros(int(0.5 * RATE), np.float32)) is not None
    assert not tracker.silent
    feed(tracker, np.zeros(int((SILENT_AFTER - 0.4) * RATE), np.float32))
    assert tracker.silent
    assert feed(tracker, np.zeros(4 * RATE, np.float32)) == []
    begin = tracker.position
    late = lateness([b for b in feed(tracker, second) if begin + 4.0 < b.position < begin + times[-1]], begin + times)
    assert late.size >= 10
    assert np.percentile(np.abs(late), 95) < 0.012


def test_quiet_noise_floor_is_silence() -> None:
    tracker = AubioTracker(RATE)
    feed(tracker, np.random.default_rng(0).normal(0.0, 3e-4, 2 * RATE).astype(np.float32))
    assert tracker.silent
    assert 1e-4 < tracker.level < 1e-3


@pytest.mark.parametrize("rate", [0.0, -44_100.0, 1e9, float("nan")])
def test_absurd_sample_rates_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="sample rate"):
        AubioTracker(rate)


def test_multichannel_sound_is_refused() -> None:
    with pytest.raises(ValueError, match="one channel"):
        AubioTracker(RATE).feed(np.zeros((512, 2), np.float32))
