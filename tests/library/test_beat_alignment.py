"""Offline beat tracking of audio files: generated clicks at known times, and songs with annotated beats."""

import wave
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.library.beat_alignment import song_beats
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


@pytest.mark.parametrize("bpm", [96.0, 124.0, 140.0])
@pytest.mark.parametrize("begin", [0.3, 2.0])
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
@pytest.mark.parametrize("name", ["o03_band_104", "o07_band_186", "o12_drums_punk_144", "o16_pop_keys_116"])
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
