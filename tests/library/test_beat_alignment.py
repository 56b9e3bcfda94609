"""Offline beat tracking of audio files: generated clicks at known times, and songs with annotated beats."""

import wave
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.library.beat_alignment import SyncRequest, find_sync, song_beats
from tests.fixtures.mostly_long import mostly_long
from tests.motion.beats.test_claps import palm_distance
from tests.motion.formats.made_bvh import body_bvh, column
from tests.motion.retarget.made_source import clapping_values
from tests.places import SHARED

SONGS = SHARED / "beats" / "open"
RATE = 44_100


def click_track(path: Path, times: np.ndarray, seconds: float) -> Path:
    """Short bursts of noise at `times` [s], as a WAV file."""
    random = np.random.default_rng(1)
    sound = np.zeros(round(seconds * RATE))
    burst = random.normal(0.0, 0.3, 1500) * np.exp(-np.arange(1500) / 200.0)
    for time in times:
        start = round(float(time) * RATE)
        sound[start : start + burst.size] += burst[: max(0, sound.size - start)]
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(sound, -1.0, 1.0) * 32_000).astype("<i2").tobytes())
    return path


@mostly_long("bpm", [96.0, 124.0, 140.0], quick=[2])
@mostly_long("begin", [0.3, 2.0], quick=[0])
def test_click_track_is_tracked_from_first_beat(tmp_path: Path, bpm: float, begin: float) -> None:
    truth = begin + 60.0 / bpm * np.arange(int(38.0 * bpm / 60.0))
    found = song_beats(click_track(tmp_path / "click.wav", truth, 40.0))
    assert found.steady
    assert found.bpm == pytest.approx(bpm, rel=5e-4)
    np.testing.assert_allclose(found.beats[: truth.size], truth, atol=0.012)


def test_accelerating_music_is_not_steady(tmp_path: Path) -> None:
    gaps = np.linspace(0.65, 0.42, 70)
    truth = 0.5 + np.cumsum(gaps)
    found = song_beats(click_track(tmp_path / "faster.wav", truth, float(truth[-1]) + 1.0))
    assert not found.steady
    assert (np.diff(found.beats) > 0.2).all()


def test_files_without_music_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PersonError, match="no such file"):
        song_beats(tmp_path / "none.wav")
    text = tmp_path / "text.wav"
    text.write_text("not a sound")
    with pytest.raises(PersonError, match="cannot be read"):
        song_beats(text)
    with pytest.raises(PersonError, match="no steady beat") as error:
        song_beats(click_track(tmp_path / "silence.wav", np.zeros(0), 5.0))
    assert error.value.remedy is not None


@pytest.mark.shared
@mostly_long("name", ["o03_band_104", "o07_band_186", "o12_drums_punk_144", "o16_pop_keys_116"], quick=[2])
def test_beats_of_steady_songs_match_annotations(name: str) -> None:
    """Annotated beats of real songs: nine of ten within 40 ms."""
    if not (SONGS / f"{name}.ogg").is_file():
        pytest.skip(f"needs {SONGS / name}.ogg")
    truth = np.array([float(line.split()[0]) for line in (SONGS / f"{name}.beats").read_text().splitlines() if line])
    found = song_beats(SONGS / f"{name}.ogg")
    assert found.steady
    assert found.bpm == pytest.approx(60.0 / float(np.median(np.diff(truth))), rel=2e-3)
    late = np.abs(truth[:, None] - found.beats).min(axis=1)
    assert np.mean(late < 0.04) > 0.9


def stepping_recording(path: Path, claps: np.ndarray, bpm: float, *, begin: float = 0.0, seconds: float = 16.0) -> Path:
    """A body that lifts one knee and then the other on each beat from `begin` on [s], and claps at `claps` [s]."""
    values = clapping_values(palm_distance(claps), seconds, 60.0)
    beat = (np.arange(len(values)) / 60.0 - begin) * bpm / 60.0
    for number, side in enumerate(("Left", "Right")):
        lift = np.where(beat < 0.0, 0.0, np.maximum(np.sin(np.pi * (beat + number)), 0.0) ** 2)
        values[:, column(f"{side}UpLeg", "X")] = -40.0 * lift
        values[:, column(f"{side}Leg", "X")] = 70.0 * lift
    path.write_text(body_bvh(values, fps=60.0))
    return path


def test_touches_that_contradict_feet_are_no_claps(tmp_path: Path) -> None:
    """Seven even touches at 57 bpm of a body that steps at 130 bpm: the feet's tempo is taken, and the note tells."""
    path = stepping_recording(tmp_path / "dance.bvh", 2.0 + 60.0 / 57.0 * np.arange(7), 130.0)
    found = find_sync(SyncRequest(path))
    octave = np.log2(found.reference.bpm / 130.0)
    assert abs(octave - round(octave)) < 0.02
    assert (found.reference.source, found.guessed) == ("feet", True)
    assert "57.0 bpm are no count" in found.reference.note


@mostly_long(("clapped", "begin"), [(65.0, 0.0), (130.0, 0.0), (97.5, 9.0)], quick=[0, 1])
def test_claps_that_fit_feet_are_a_count(tmp_path: Path, clapped: float, begin: float) -> None:
    """At an octave of the feet's tempo anywhere; at another simple ratio only before the dance, standing still."""
    times = 1.0 + 60.0 / clapped * np.arange(8)
    found = find_sync(SyncRequest(stepping_recording(tmp_path / "dance.bvh", times, 130.0, begin=begin, seconds=24.0)))
    assert found.reference.source == "claps"
    assert found.reference.bpm == pytest.approx(clapped, rel=0.005)
    assert found.reference.first_beat_s == pytest.approx(1.0, abs=0.02)


def test_three_claps_leave_tempo_to_feet(tmp_path: Path) -> None:
    path = stepping_recording(tmp_path / "dance.bvh", 2.0 + 0.6 * np.arange(3), 120.0)
    assert find_sync(SyncRequest(path)).reference.source == "feet"
