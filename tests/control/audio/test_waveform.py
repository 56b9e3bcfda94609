"""The waveform of a music file."""

from pathlib import Path

import numpy as np
import pytest

from live.control.audio.music_file import MusicFileError
from live.control.audio.waveform import PEAKS_PER_SECOND, read_waveform
from tests.control.audio.test_music_file import write_wav


def test_peaks_follow_the_sound(tmp_path: Path) -> None:
    rate, seconds = 48_000, 21
    time = np.arange(rate * seconds) / rate
    sound = np.where(time < 10.0, 0.5, 1.0) * np.sin(2 * np.pi * 440.0 * time)
    ticks: list[int] = []
    peaks = read_waveform(write_wav(tmp_path / "a.wav", sound.astype(np.float32), rate), lambda: ticks.append(1))
    assert len(peaks) == pytest.approx(PEAKS_PER_SECOND * seconds, abs=1)
    assert peaks[100:1900] == pytest.approx(128, abs=8)
    assert peaks[2100:4100] == pytest.approx(255, abs=8)
    assert len(ticks) > 4


def test_what_is_no_music_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ogg").write_bytes(b"no music")
    for name in ("a.ogg", "none.ogg"):
        with pytest.raises(MusicFileError):
            read_waveform(tmp_path / name)
