"""BeatTracker: sound to beats ahead of time, any rate and block size; silence, faults, hints, causality."""

import numpy as np
import pytest

from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.silence import SILENT_AFTER
from live.clock.tracking.beat_tracker import BeatTracker
from tests.clock.clicks import clicks
from tests.clock.tracking.plain_onsets import OnsetActivation
from tests.fixtures.mostly_long import mostly_long

RATE = 44_100


def make_tracker(rate: float = RATE) -> BeatTracker:
    """A tracker with plain onsets: the tests do not depend on trained weights."""
    return BeatTracker(rate, OnsetActivation())


def feed(tracker: BeatTracker, sound: Samples, block: int = 512) -> list[BeatEstimate]:
    return [beat for start in range(0, sound.size, block) for beat in tracker.feed(sound[start : start + block])]


def lateness(beats: list[BeatEstimate], times: np.ndarray) -> np.ndarray:
    return np.array([beat.position - times[np.argmin(np.abs(times - beat.position))] for beat in beats])


@mostly_long(("rate", "block"), [(22_050, 300), (48_000, 4096), (192_000, 1_000_000)], quick=[0])
def test_clicks_are_predicted_at_any_rate_and_block_size(rate: int, block: int) -> None:
    sound, times = clicks(113, rate, 9.0)
    beats = [beat for beat in feed(make_tracker(rate), sound, block) if 4.0 < beat.position < 8.5]
    assert len(beats) >= 8
    assert np.ptp(lateness(beats, times)) < 0.03
    assert 60.0 / np.median([beat.period for beat in beats]) == pytest.approx(113, rel=0.01)
    assert all(0.0 < beat.position - beat.fed < 0.1 for beat in beats)


def test_beats_are_independent_of_block_size() -> None:
    sound, _ = clicks(120, 22_050, 5.0)
    assert feed(make_tracker(22_050), sound, 64) == feed(make_tracker(22_050), sound, 5000) != []


def test_tracker_is_causal() -> None:
    sound, _ = clicks(126, RATE, 8.0)
    whole = feed(make_tracker(), sound)
    cut = feed(make_tracker(), sound[: 5 * RATE])
    assert cut == [beat for beat in whole if beat.fed <= 5.0] != []


def test_invalid_samples_are_counted_and_give_no_beats() -> None:
    tracker = make_tracker()
    assert feed(tracker, np.full(2 * RATE, np.nan, np.float32)) == []
    assert tracker.bad_samples >= 2 * RATE - tracker.wanted
    assert tracker.silent
    sound, times = clicks(120, RATE, 8.0)
    hurt = sound.copy()
    hurt[1000:40_000:977] = np.inf
    hurt[200_000] = 1e30
    beats = [beat for beat in feed(tracker, hurt) if 6.0 < beat.position < 9.8]
    assert np.percentile(np.abs(lateness(beats, times + 2.0)), 90) < 0.03
    assert hurt[200_000] == np.float32(1e30), "the caller's samples are not touched"


def test_silence_before_any_sound_gives_no_beats() -> None:
    tracker = make_tracker()
    assert feed(tracker, np.zeros(3 * RATE, np.float32)) == []
    assert tracker.silent
    assert tracker.position == pytest.approx(3.0)


@pytest.mark.long
def test_grid_continues_through_silence_and_new_music_is_found() -> None:
    first, times = clicks(118, RATE, 8.0)
    tracker = make_tracker()
    feed(tracker, first)
    assert not tracker.silent
    on = feed(tracker, np.zeros(8 * RATE, np.float32))
    assert tracker.silent
    grid = times[0] + np.arange(80) * 60.0 / 118
    inside = [beat for beat in on if 8.0 + SILENT_AFTER < beat.position < 15.9]
    assert len(inside) == pytest.approx(6.7 * 118 / 60, abs=1.5)
    assert np.max(np.abs(lateness(inside, grid))) < 0.06
    assert all(beat.confidence == 0.0 for beat in inside)
    other, times = clicks(97, RATE, 6.0)
    back = [beat for beat in feed(tracker, other) if 18.5 < beat.position < 21.5]
    assert len(back) >= 4
    assert np.max(np.abs(lateness(back, 16.0 + times))) < 0.04


@pytest.mark.long
def test_manual_downbeat_ahead_and_tapped_tempo_are_obeyed() -> None:
    sound, times = clicks(140, RATE, 14.0)
    tracker = make_tracker()
    tracker.set_metre(4)
    tracker.set_downbeat(float(times[9]))
    early = feed(tracker, sound[: 5 * RATE])
    assert early
    late = [beat for beat in feed(tracker, sound[5 * RATE : 9 * RATE]) if beat.position > 5.2]
    assert all(beat.beat == (int(np.argmin(np.abs(times - beat.position))) - 9) % 4 for beat in late)
    tracker.tap(70.0)
    slow = [beat for beat in feed(tracker, sound[9 * RATE :]) if beat.position > 10.0]
    assert 60.0 / np.median([beat.period for beat in slow]) == pytest.approx(70.0, rel=0.02)
    tracker.clear_manual()


@pytest.mark.parametrize("rate", [0.0, -44_100.0, 1e9, float("nan")])
def test_absurd_sample_rates_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="sample rate"):
        make_tracker(rate)


def test_multichannel_sound_is_refused() -> None:
    with pytest.raises(ValueError, match="one channel"):
        make_tracker().feed(np.zeros((512, 2), np.float32))
