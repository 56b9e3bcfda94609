"""Tests of clap sync (T018): claps matched to a click, a song or no music, despite missed claps and other touches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.beats.clap_sync import Clap, sync_to_claps, sync_to_click, sync_to_song
from live.motion.beats.music_reference import MusicReference, apply_manual


def claps(times: np.ndarray | list[float]) -> list[Clap]:
    return [Clap(float(time), 0.06, 4.0) for time in sorted(times)]


@pytest.mark.long
@given(st.floats(0.2, 5.0), st.floats(60.0, 190.0), st.integers(0, 10_000))
def test_eight_claps_are_synced_to_click(first: float, bpm: float, seed: int) -> None:
    """With 12 ms of scatter the mean of eight claps is right to 15 ms, with high confidence."""
    random = np.random.default_rng(seed)
    times = first + 60.0 / bpm * np.arange(8) + np.clip(random.normal(0.0, 0.012, 8), -0.03, 0.03)
    found = sync_to_click(claps(times), bpm, 8)
    assert found is not None
    assert found.reference.first_beat_s == pytest.approx(first, abs=0.02)
    assert found.reference.bpm == bpm
    assert found.reference.source == "click"
    assert found.reference.confidence > 0.6
    assert [one.beat for one in found.claps] == list(range(1, 9))
    mean = float(np.mean(times - 60.0 / bpm * np.arange(8)))
    assert found.reference.first_beat_s == pytest.approx(mean, abs=1e-9)


def test_sync_tolerates_missed_clap_and_extra_touch() -> None:
    beats = 2.0 + 0.5 * np.arange(8)
    found = sync_to_click(claps([*np.delete(beats, 3), 2.74]), 120.0, 8)
    assert found is not None
    assert found.reference.first_beat_s == pytest.approx(2.0, abs=1e-9)
    assert [one.beat for one in found.claps] == [1, 2, None, 3, 5, 6, 7, 8]
    assert 0.5 < found.reference.confidence < 0.85
    assert "1 other touches" in found.reference.note
    assert found.claps[2].residual_ms == pytest.approx(240.0)


def test_claps_later_in_dance_are_ignored() -> None:
    count, dance = 1.0 + 0.5 * np.arange(4), 20.13 + 0.5 * np.arange(4)
    found = sync_to_click(claps([*count, *dance]), 120.0, 4)
    assert found is not None
    assert found.reference.first_beat_s == pytest.approx(1.0, abs=1e-9)


def test_confidence_falls_with_scatter_and_misses() -> None:
    beats = 1.0 + 0.5 * np.arange(8)
    random = np.random.default_rng(2)
    confidences = []
    for times in (beats, beats + random.normal(0.0, 0.03, 8), beats[[0, 2, 3, 6]], beats[[2]]):
        found = sync_to_click(claps(times), 120.0, 8)
        assert found is not None
        confidences.append(found.reference.confidence)
    assert confidences == sorted(confidences, reverse=True)
    assert confidences[0] > 0.8
    assert confidences[-1] < 0.1


def test_wrong_frame_rate_is_noted() -> None:
    found = sync_to_click(claps(1.0 + 0.25 * np.arange(8)), 163.0, 8)
    assert found is not None
    assert "240.0 bpm: is the frame rate right?" in found.reference.note
    assert found.reference.confidence < 0.2


def test_claps_without_music_give_tempo() -> None:
    found = sync_to_claps(claps([3.0, 3.484, 3.968, 4.452, 12.0]))
    assert found is not None
    assert found.reference.source == "claps"
    assert found.reference.bpm == pytest.approx(60.0 / 0.484, rel=1e-3)
    assert found.reference.first_beat_s == pytest.approx(3.0, abs=0.002)
    assert sync_to_claps(claps([3.0, 3.5, 4.0])) is None
    assert sync_to_claps([]) is None


@pytest.mark.parametrize(
    "touches",
    [
        [2.0, 4.1, 9.35, 14.6, 15.65, 16.7, 19.85],  # seven of seventeen beats at 57 bpm
        [3.0, 3.5, 3.66, 4.0, 4.22, 4.5, 4.7],  # as many touches off the beat as on it
        [1.0, 1.56, 1.94, 2.56, 2.95],  # about a beat, but 60 ms off
    ],
)
def test_touches_of_dance_are_no_count(touches: list[float]) -> None:
    assert sync_to_claps(claps(touches)) is None


def test_uneven_song_fixes_clap_offset() -> None:
    """A song that slows down and speeds up: the pattern of intervals fixes the offset, whichever beats are clapped."""
    random = np.random.default_rng(7)
    beats = 0.4 + np.concatenate(
        ([0.0], np.cumsum(0.5 + 0.06 * np.sin(np.arange(60)) + random.uniform(-0.04, 0.04, 60)))
    )
    times = beats[5:13] + 2.75 + random.normal(0.0, 0.006, 8)
    found = sync_to_song(claps(np.append(np.delete(times, 2), times[4] + 0.22)), beats)
    assert found is not None
    assert [one.beat for one in found.claps if one.beat is not None] == [6, 7, 9, 10, 11, 12, 13]
    assert "+2.7" in found.reference.note
    assert "even" not in found.reference.note


def test_even_song_starts_at_first_clap() -> None:
    beats = 0.2 + 0.5 * np.arange(100)
    found = sync_to_song(claps(3.1 + 0.5 * np.arange(4)), beats)
    assert found is not None
    assert found.reference.first_beat_s == pytest.approx(3.1, abs=1e-6)
    assert found.reference.bpm == pytest.approx(120.0, abs=1e-6)
    assert "even" in found.reference.note
    assert found.reference.source == "song"


def test_song_started_before_recording_is_aligned_to_measure() -> None:
    beats = 0.5 * np.arange(100) + np.where(np.arange(100) % 7 == 3, 0.04, 0.0)
    found = sync_to_song(claps(beats[6:14] - 2.0), beats)
    assert found is not None
    assert found.reference.first_beat_s >= 0.0
    assert (found.reference.first_beat_s + 2.0) / 2.0 == pytest.approx(
        round((found.reference.first_beat_s + 2.0) / 2.0), abs=0.02
    )


def test_manual_values_override_found_reference() -> None:
    found = MusicReference(1.2, 118.0, 0.7, "claps", "8 beats clapped")
    assert apply_manual(found) is found
    both = apply_manual(found, anchor_s=3.21, bpm=124.0)
    assert both is not None
    assert (both.first_beat_s, both.bpm, both.confidence, both.source) == (3.21, 124.0, 1.0, "hand")
    anchor = apply_manual(found, anchor_s=3.21)
    assert anchor is not None
    assert (anchor.first_beat_s, anchor.bpm, anchor.confidence) == (3.21, 118.0, 0.7)
    tempo = apply_manual(found, bpm=60.0)
    assert tempo is not None
    assert (tempo.first_beat_s, tempo.bpm) == (1.2, 60.0)
    assert apply_manual(None, bpm=60.0) is None
    assert apply_manual(None, anchor_s=0.0, bpm=60.0) is not None


@pytest.mark.long
def test_hour_of_random_touches_has_low_confidence() -> None:
    random = np.random.default_rng(5)
    many = claps(np.cumsum(random.uniform(0.13, 0.9, 7000)))
    beats = 0.5 * np.arange(7000)
    for found in (sync_to_click(many, 120.0), sync_to_claps(many), sync_to_song(many, beats)):
        assert found is None or found.reference.confidence < 0.5
