"""Tracker: sound to beats ahead of time, at any rate and block size; silence, faults, seeds, no look ahead."""

import numpy as np
import pytest

from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.silence import SILENT_AFTER
from live.clock.tracking.beat_tracker import BeatTracker
from live.clock.tracking.onset_strength import OnsetActivation
from tests.clock.clicks import clicks

RATE = 44_100


def make(rate: float = RATE) -> BeatTracker:
    """Plain onsets: what is tested here does not depend on what was learned."""
    return BeatTracker(rate, OnsetActivation())


def feed(tracker: BeatTracker, sound: Samples, block: int = 512) -> list[BeatEstimate]:
    return [beat for start in range(0, sound.size, block) for beat in tracker.feed(sound[start : start + block])]


def lateness(beats: list[BeatEstimate], times: np.ndarray) -> np.ndarray:
    return np.array([beat.position - times[np.argmin(np.abs(times - beat.position))] for beat in beats])


@pytest.mark.parametrize(("rate", "block"), [(22_050, 300), (48_000, 4096), (192_000, 1_000_000)])
def test_clicks_are_named_ahead_at_any_rate_and_block_size(rate: int, block: int) -> None:
    sound, times = clicks(113, rate, 9.0)
    beats = [beat for beat in feed(make(rate), sound, block) if 4.0 < beat.position < 8.5]
    assert len(beats) >= 8
    assert np.ptp(lateness(beats, times)) < 0.03
    assert 60.0 / np.median([beat.period for beat in beats]) == pytest.approx(113, rel=0.01)
    assert all(0.0 < beat.position - beat.fed < 0.1 for beat in beats)


def test_block_sizes_change_nothing() -> None:
    sound, _ = clicks(120, 22_050, 5.0)
    assert feed(make(22_050), sound, 64) == feed(make(22_050), sound, 5000) != []


def test_nothing_from_the_future_is_used() -> None:
    sound, _ = clicks(126, RATE, 8.0)
    whole = feed(make(), sound)
    cut = feed(make(), sound[: 5 * RATE])
    assert cut == [beat for beat in whole if beat.fed <= 5.0] != []


def test_what_is_no_sound_is_counted_and_nothing_but_nonsense_gives_no_beat() -> None:
    tracker = make()
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


def test_before_any_sound_there_are_no_beats() -> None:
    tracker = make()
    assert feed(tracker, np.zeros(3 * RATE, np.float32)) == []
    assert tracker.silent
    assert tracker.position == pytest.approx(3.0)


def test_through_silence_the_grid_runs_on_and_another_one_is_found_after_it() -> None:
    first, times = clicks(118, RATE, 8.0)
    tracker = make()
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


def test_a_seed_is_obeyed_a_one_ahead_waits_for_its_time() -> None:
    sound, times = clicks(140, RATE, 14.0)
    tracker = make()
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
        make(rate)


def test_only_one_channel_is_taken() -> None:
    with pytest.raises(ValueError, match="one channel"):
        make().feed(np.zeros((512, 2), np.float32))
