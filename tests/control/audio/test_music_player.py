"""Tests of MusicPlayer: following of its own music, audible or inaudible."""

from typing import Any

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import SystemClock
from live.control.audio import music_player
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.audio_input import AudioInput
from live.control.audio.devices import SoundUnavailable, UnknownDevice
from live.control.audio.music_file import Music, OfflineMusic
from live.control.audio.music_player import MusicPlayer
from live.control.events.events import BeatHeard, ControlEvent, One
from tests.clock.clicks import clicks, groove
from tests.control.conftest import PulseSink
from tests.control.waiting import wait_for

RATE = 44_100
STEP = 0.1


class SteppingClock:
    """Advances by 100 ms at each read: faster than real time, and independent of stalls of the machine."""

    def __init__(self) -> None:
        self._time = 0.0

    def now(self) -> float:
        self._time += STEP
        return self._time


def make_click_music(bpm: float, seconds: float) -> Music:
    return Music(clicks(bpm, RATE, seconds, 0.0)[0][:, None], RATE)


@pytest.mark.long
def test_inaudible_music_is_followed_by_clock() -> None:
    inbox: EventQueue[ControlEvent] = EventQueue()
    music = make_click_music(120.0, 6.0)
    player = MusicPlayer(music, inbox, SteppingClock(), output=False, one_at=0.5)
    events: list[ControlEvent] = []
    player.start()
    try:
        assert wait_for(lambda: bool(events.extend(inbox.drain())) or len(events) >= 20, 15.0)
    finally:
        player.stop()
    assert not player.audible
    assert player.output_problem
    begin = player._begin
    beats = [event.beat_time - begin for event in events if isinstance(event, BeatHeard)]
    offline = [e.beat_time for e in OfflineMusic(music, one_at=0.5).events_until(60.0) if isinstance(e, BeatHeard)]
    assert [event.time - begin for event in events if isinstance(event, One)] == [pytest.approx(0.5)]
    assert beats == pytest.approx(offline[: len(beats)], abs=1e-6)


@pytest.mark.long
def test_failed_analysis_is_restarted_during_playback() -> None:
    made: list[AudioAnalysis] = []

    class Breaks(AudioAnalysis):
        def feed(self, *arguments: Any) -> list[ControlEvent]:
            if self is made[0] and self.tracker.position > 1.0:
                raise ArithmeticError("a bug in the tracker")
            return super().feed(*arguments)

    def make(rate: float) -> AudioAnalysis:
        made.append(Breaks(rate))
        return made[-1]

    inbox: EventQueue[ControlEvent] = EventQueue()
    player = MusicPlayer(make_click_music(120.0, 20.0), inbox, SteppingClock(), output=False, analysis=make)
    player.start()
    beats: list[float] = []
    try:
        assert wait_for(
            lambda: (
                bool(beats.extend(e.beat_time for e in inbox.drain() if isinstance(e, BeatHeard))) or len(beats) > 16
            ),
            15.0,
        )
    finally:
        player.stop()
    assert (player.crashes, len(made)) == (1, 2)
    assert player.status()["failure"] == "the analysis failed: ArithmeticError: a bug in the tracker"
    off = (np.array(beats[8:]) - player._begin) * 2.0  # the first beats of both analyses are guesses
    assert np.median(np.abs(off - np.round(off))) < 0.05


def test_music_without_portaudio_is_inaudible(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object) -> None:
        raise SoundUnavailable("no sound devices: install PortAudio")

    monkeypatch.setattr(music_player, "find_device", missing)
    player = MusicPlayer(make_click_music(120.0, 3.0), EventQueue(), SteppingClock())
    assert "PortAudio" in player.output_problem


def test_missing_named_output_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object) -> None:
        raise UnknownDevice("no sound output 'organ'; there are: …")

    monkeypatch.setattr(music_player, "find_device", unknown)
    with pytest.raises(UnknownDevice, match="organ"):
        MusicPlayer(make_click_music(120.0, 3.0), EventQueue(), SteppingClock(), output="organ")
    assert MusicPlayer(make_click_music(120.0, 3.0), EventQueue(), SteppingClock()).output_problem


def test_refusing_output_leaves_music_inaudible(monkeypatch: pytest.MonkeyPatch) -> None:
    from live.control.audio.devices import SoundDevice

    def refuse(*_: object, **__: object) -> None:
        raise RuntimeError("device is busy")

    monkeypatch.setattr(music_player, "find_device", lambda *_: SoundDevice(0, "organ", "ALSA", 2, 48_000.0, True))
    monkeypatch.setattr(music_player, "open_stream", refuse)
    inbox: EventQueue[ControlEvent] = EventQueue()
    player = MusicPlayer(make_click_music(120.0, 6.0), inbox, SteppingClock())
    player.start()
    try:
        assert wait_for(lambda: len(inbox) > 4, 10.0)
    finally:
        player.stop()
    assert "organ does not play: device is busy" in player.output_problem


@pytest.mark.long
@pytest.mark.pulse
def test_played_beats_match_recorded_beats(pulse_sink: PulseSink) -> None:
    """The player's play times against a microphone at the sink it plays to."""
    clock = SystemClock()
    played: EventQueue[ControlEvent] = EventQueue()
    recorded: EventQueue[ControlEvent] = EventQueue()
    player = MusicPlayer(Music(groove(120.0, RATE, 8.0)[:, None], RATE), played, clock, output="pulse")
    listener = AudioInput("pulse", recorded, clock)
    player.start()
    listener.start()
    try:
        assert wait_for(lambda: len(recorded) >= 24, 25.0)
    finally:
        player.stop()
        listener.stop()
    assert player.audible or not player.output_problem
    ours = np.array([event.beat_time for event in played.drain() if isinstance(event, BeatHeard)])
    theirs = np.array([event.beat_time for event in recorded.drain() if isinstance(event, BeatHeard)])[-10:]
    late = np.array([(beat - ours[np.argmin(np.abs(ours - beat))]) for beat in theirs])
    assert np.median(np.abs(late)) < 0.03
