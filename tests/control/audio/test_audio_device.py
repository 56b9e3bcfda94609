"""Tests of a real audio input over PulseAudio: with music, without music, and with a killed server."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.time_source import SystemClock
from live.control.audio.audio_input import AudioInput
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.show.sound.clock_commands import apply_clock_event
from tests.clock.clicks import groove
from tests.control.audio.test_music_file import write_wav
from tests.control.conftest import PulseSink
from tests.control.waiting import wait_for


class Listener:
    """An AudioInput with a follower at its queue."""

    def __init__(self, clock: SystemClock) -> None:
        self.clock = clock
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        self.input = AudioInput("pulse", self.inbox, clock)
        self.follower = TimelineFollower()
        self.changes: list[str] = []
        self.beats: list[float] = []
        self.loudest = 0.0

    def turn(self) -> None:
        """One turn of a show."""
        for event in self.inbox.drain():
            if isinstance(event, BeatHeard):
                self.beats.append(event.beat_time)
            elif isinstance(event, SourceChanged):
                self.changes.append(event.state)
            apply_clock_event(self.follower, event)
        self.follower.advance(self.clock.now())
        self.loudest = max(self.loudest, self.input.level)

    def dances(self, bpm: float) -> bool:
        """Whether, after a turn, it is locked at this tempo and the last ten beats are whole or half beats to 20 ms."""
        self.turn()
        steps = np.diff(self.beats[-11:]) * bpm / 30.0  # half beats
        even = np.percentile(np.abs(steps - np.round(steps)), 90) < 0.02 * bpm / 30.0 if steps.size == 10 else False
        return bool(even) and self.follower.state == "locked" and abs(self.follower.tempo / bpm - 1.0) < 0.01

    def hears(self, state: str, seconds: float) -> bool:
        """Whether the follower reaches a state, or the source changes to it, in time."""

        def reached() -> bool:
            self.turn()
            return self.follower.state == state or self.changes[-1:] == [state]

        return wait_for(reached, seconds)


@pytest.fixture
def listener(pulse_sink: PulseSink) -> Iterator[Listener]:
    listener = Listener(SystemClock())
    listener.input.start()
    yield listener
    listener.input.stop()
    pulse_sink.stop_players()


@pytest.mark.long
@pytest.mark.pulse
def test_follower_locks_to_recorded_music(pulse_sink: PulseSink, listener: Listener, tmp_path: Path) -> None:
    """On a busy machine that loses sound, the lock comes a few seconds later."""
    pulse_sink.play(write_wav(tmp_path / "groove.wav", groove(120.0, 48_000, 60.0), 48_000))
    assert wait_for(lambda: listener.dances(120.0), 50.0)
    assert listener.follower.source == "audio"
    assert listener.loudest > 0.01


@pytest.mark.pulse
def test_silence_is_reported(listener: Listener) -> None:
    assert listener.hears("silent", 10.0)
    assert listener.follower.state == "internal"


@pytest.mark.long
@pytest.mark.pulse
def test_killed_server_is_lost_then_found_with_other_format(
    pulse_sink: PulseSink, listener: Listener, tmp_path: Path
) -> None:
    pulse_sink.play(write_wav(tmp_path / "groove.wav", groove(120.0, 48_000, 30.0), 48_000))
    assert listener.hears("locked", 20.0)
    beat = listener.follower.timeline.beat_at(listener.clock.now())
    pulse_sink.kill()
    assert listener.hears("lost", 5.0)
    assert listener.follower.state == "freewheel"
    assert wait_for(lambda: listener.turn() or listener.follower.timeline.beat_at(listener.clock.now()) > beat + 4, 5.0)
    pulse_sink.restart(rate=44_100, channels=1)
    assert listener.hears("found", 12.0)
    assert listener.input.reopened >= 1
    heard = len(listener.beats)
    pulse_sink.play(tmp_path / "groove.wav")
    assert wait_for(lambda: listener.turn() or len(listener.beats) >= heard + 4, 12.0)
    assert listener.input.crashes == 0
