"""Music through a PulseAudio null sink into the input device: the clock locks on and measures change."""

import wave
from pathlib import Path

import numpy as np
import pytest

from live.control.audio.music_file import read_music
from live.show.patch.patch_search_path import PATCHES
from tests.end_to_end.conftest import children


def _as_wav(path: Path, seconds: float) -> Path:
    music = read_music(PATCHES / "music" / "first_show.ogg")
    start = int(17.2 * music.sample_rate)  # where the groove is in full swing
    samples = music.samples[start : start + int(seconds * music.sample_rate)]
    with wave.open(str(path), "wb") as file:
        file.setnchannels(samples.shape[1])
        file.setsampwidth(2)
        file.setframerate(music.sample_rate)
        file.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())
    return path


@pytest.mark.pulse
def test_music_from_input_device_changes_measures(play, patch: Path, pulse_sink, tmp_path: Path):
    """The patch begins at 90 bpm in its own clock; the music's 112 bpm comes only from the input. `--alone` means one
    process for listening and dancing.
    """
    patch.write_text("clock = {bpm = 90}\n" + patch.read_text())
    running = play(
        str(patch), "--headless", "--audio", "pulse", "--seconds", "90", "--osc", "127.0.0.1:0", "--alone",
        env=dict(pulse_sink.env),
    )  # fmt: skip
    running.wait_for(lambda line: line["frames"] > 10, 30)
    assert "alive" not in running.lines()[-1]
    assert children(running, "process") == []
    pulse_sink.play(_as_wav(tmp_path / "music.wav", 40.0))
    # the first seconds may be taken for another tempo; what counts is that it settles on the music's
    locked = running.wait_for(
        lambda line: (line["source"], line["clock_state"]) == ("audio", "locked") and abs(line["bpm"] - 112.0) < 2.3, 30
    )
    later = running.wait_for(lambda line: line["measure"] >= locked["measure"] + 3, 20)
    assert later["time"] - locked["time"] == pytest.approx(3 * 4 * 60 / 112.0, abs=2.5)
    pulse_sink.kill()  # the sound system goes away: the show goes on
    free = running.wait_for(lambda line: line["clock_state"] == "freewheel" and line["time"] > later["time"], 15)
    running.wait_for(lambda line: line["measure"] >= free["measure"] + 2, 15)
    assert "Traceback" not in running.stop()
