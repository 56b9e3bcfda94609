"""Tests of music files: decoding, refusals with reasons, looping, and offline analysis."""

import math
import wave
from collections import deque
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from live.clock.follower.manual_control import TrackerHint
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.audio import music_file
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.music_file import Music, MusicFileError, OfflineMusic, read_music, tempo_in_name
from live.control.events.events import BeatHeard, ControlEvent, One, SourceChanged
from tests.clock.clicks import clicks

RATE = 44_100


def write_wav(path: Path, sound: np.ndarray, rate: int = RATE) -> Path:
    """Samples (n,) or (n, channels) as 16-bit PCM."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1 if sound.ndim == 1 else sound.shape[1])
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((np.clip(sound, -1.0, 1.0) * 32767.0).astype("<i2").tobytes())
    return path


def follow_states(music: OfflineMusic, follower: TimelineFollower, seconds: float) -> list[str]:
    states = []
    for tick in range(1, int(seconds / TICK) + 1):
        now = tick * TICK
        for event in music.events_until(now):
            assert event.time <= now
            if isinstance(event, BeatHeard):
                follower.observe(event.beat_time, event.period, event.confidence, now)
            elif isinstance(event, SourceChanged):
                getattr(follower, event.state)(now)
        follower.advance(now)
        states.append(follower.state)
    return states


@pytest.mark.parametrize(("channels", "kept"), [(1, 1), (2, 2), (6, 2)])
def test_file_samples_match_written_samples(tmp_path: Path, channels: int, kept: int) -> None:
    sound = np.random.default_rng(0).uniform(-0.5, 0.5, (RATE, channels)).astype(np.float32)
    music = read_music(write_wav(tmp_path / "noise.wav", sound))
    assert music.samples.shape == (RATE, kept)
    assert (music.samples.dtype, music.sample_rate, music.duration) == (np.float32, RATE, 1.0)
    if channels == kept:
        assert np.max(np.abs(music.samples - sound)) < 1e-4


def test_sample_rate_of_file_is_kept(tmp_path: Path) -> None:
    music = read_music(write_wav(tmp_path / "slow.wav", np.zeros(22_050, np.float32), 22_050))
    assert (music.sample_rate, music.duration) == (22_050, 1.0)


def refusal(path: Path) -> str:
    with pytest.raises(MusicFileError) as caught:
        read_music(path)
    assert path.name in str(caught.value)
    return str(caught.value)


def test_invalid_music_files_are_refused_with_reason(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "nothing.ogg")
    assert "folder" in refusal(tmp_path)
    text = tmp_path / "letter.mp3"
    text.write_text("Dear Sir or Madam, this is no music. " * 50)
    assert "cannot be read as music" in refusal(text)
    empty = tmp_path / "empty.wav"
    empty.touch()
    assert "cannot be read as music" in refusal(empty)
    noise = tmp_path / "noise.flac"
    noise.write_bytes(np.random.default_rng(0).bytes(20_000))
    refusal(noise)
    assert "0.00 s of sound" in refusal(write_wav(tmp_path / "short.wav", np.zeros(10, np.float32)))


@pytest.mark.parametrize(
    ("name", "tempo"),
    [
        ("Waltz 90 bpm", 90.0), ("92.5BPM_groove", 92.5), ("loop-128-bpm", 128.0), ("bpm 70", 70.0), ("track 07", None),
        ("bpm", None), ("1120 bpm", None), ("20 bpm", None), ("300bpm", None), ("12.5.130 bpm", None),
    ],
)  # fmt: skip
def test_tempo_is_read_from_name(name: str, tempo: float | None) -> None:
    assert tempo_in_name(name) == tempo


def test_unsupported_sample_rate_is_refused(tmp_path: Path) -> None:
    assert "sample rate" in refusal(write_wav(tmp_path / "telephone.wav", np.zeros(4_000, np.float32), 4_000))


def test_image_file_is_refused_without_sound(tmp_path: Path) -> None:
    from PIL import Image

    path = tmp_path / "picture.png"
    Image.new("RGB", (64, 64)).save(path)
    assert "no sound" in refusal(path)


def test_truncated_file_is_read_to_its_end(tmp_path: Path) -> None:
    whole = write_wav(tmp_path / "whole.wav", np.zeros(RATE, np.float32)).read_bytes()
    cut = tmp_path / "cut.wav"
    cut.write_bytes(whole[: len(whole) // 2])
    assert read_music(cut).duration == pytest.approx(0.5, abs=0.05)


def test_too_long_music_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(music_file, "MAX_DURATION", 0.5)
    assert "longer than" in refusal(write_wav(tmp_path / "long.wav", np.zeros(RATE, np.float32)))


def test_too_long_stream_without_duration_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import av

    path = write_wav(tmp_path / "long.wav", np.zeros(4 * RATE, np.float32))
    monkeypatch.setattr(music_file, "MAX_DURATION", 0.5)
    with av.open(str(path)) as container:
        silent_about_it = SimpleNamespace(streams=container.streams, duration=None, decode=container.decode)
        with pytest.raises(MusicFileError, match="longer than"):
            music_file._decode(silent_about_it, path)


def test_looped_blocks_wrap_to_the_beginning() -> None:
    music = Music(np.arange(10, dtype=np.float32)[:, None], RATE)
    assert music.block(8, 5)[:, 0].tolist() == [8, 9, 0, 1, 2]
    assert music.block(28, 25)[:, 0].tolist() == [8, 9, *range(10), *range(10), 0, 1, 2]


def make_click_music(bpm: float, seconds: float, first: float = 0.0) -> Music:
    return Music(clicks(bpm, RATE, seconds, first)[0][:, None], RATE)


@pytest.mark.long
def test_offline_events_are_independent_of_query_step() -> None:
    music = make_click_music(126.0, 9.0)

    def events(step: float) -> list[ControlEvent]:
        offline, found, time = OfflineMusic(music), [], 0.0
        while time < 20.0:
            time = min(time + step, 20.0)
            found += offline.events_until(time)
        return found

    assert events(TICK) == events(0.1) == events(20.0)
    assert sum(isinstance(event, BeatHeard) for event in events(20.0)) > 30


@pytest.mark.long
def test_beat_continues_over_loop_seam() -> None:
    follower = TimelineFollower()
    states = follow_states(OfflineMusic(make_click_music(120.0, 8.0)), follower, 40.0)
    assert set(states[10 * 64 :]) == {"locked"}
    assert follower.tempo == pytest.approx(120.0, rel=0.005)
    off = follower.timeline.beat_at(40.0) % 1.0
    assert min(off, 1.0 - off) < 0.05


@pytest.mark.long
def test_known_downbeat_is_relative_to_music_start() -> None:
    follower = TimelineFollower(tempo=120.0)
    offline = OfflineMusic(make_click_music(100.0, 30.0, 0.25), begin=2.3, one_at=0.25 + 0.6)
    for tick in range(1, 20 * 64):
        for event in offline.events_until(tick * TICK):
            if isinstance(event, BeatHeard):
                follower.observe(event.beat_time, event.period, event.confidence, event.time)
            elif isinstance(event, One):
                follower.set_downbeat(event.time)
        follower.advance(tick * TICK)
    phase = follower.timeline.phase_at(2.3 + 0.85 + 6 * 2.4)
    assert min(phase, 4.0 - phase) < 0.05


@pytest.mark.long
def test_later_begin_shifts_all_events() -> None:
    music = make_click_music(120.0, 6.0)
    now = OfflineMusic(music).events_until(8.0)
    later = OfflineMusic(music, begin=10.0).events_until(18.0)
    assert [event.time + 10.0 for event in now] == pytest.approx([event.time for event in later])
    assert OfflineMusic(music, begin=10.0).events_until(9.0) == []


@pytest.mark.long
def test_known_downbeat_reaches_tracker_in_music_time() -> None:
    """Clicks without accents can be numbered only from the known downbeat; show time differs from music time."""
    music = make_click_music(100.0, 12.0, 0.25)
    offline = OfflineMusic(music, begin=2.3, one_at=0.25 + 2 * 0.6, analysis=analysis_in_four)
    beats = [event for event in offline.events_until(14.0) if isinstance(event, BeatHeard)]
    after = [(round((event.beat_time - 2.3 - 0.25) / 0.6) - 2, event) for event in beats if event.beat_time > 4.5]
    assert len(after) > 10
    assert all((event.beat, event.beats_per_measure) == (number % 4, 4) for number, event in after)


def analysis_in_four(rate: float) -> AudioAnalysis:
    return AudioAnalysis(rate, seeds=deque([TrackerHint("metre", 0.0, 4.0), TrackerHint("tempo", math.nan, 100.0)]))
