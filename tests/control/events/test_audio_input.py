"""Tests of AudioInput on fake devices: lost, changed, misconfigured and failing devices."""

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.audio_input import AudioInput
from live.control.audio.channel_mixer import Channels
from live.control.audio.devices import SoundDevice
from live.control.events.events import BeatHeard, ChooseAudio, ControlEvent, RestartAudio, SourceChanged
from tests.clock.clicks import clicks
from tests.control.audio.fake_sound import FakeSound, fake_sound_system
from tests.fixtures.mostly_long import mostly_long

Sound = npt.NDArray[np.float32]
PERIOD = 0.5


class InputDriver:
    """An AudioInput on a fake sound system; `turn` does one turn of its thread."""

    def __init__(self, sound: FakeSound, **options: Any) -> None:
        self.sound = sound
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        self.input = AudioInput(None, self.inbox, sound.clock, **options)
        self.input._open(self.input._watchdog.stop_event)
        self.events: list[ControlEvent] = []

    def turn(self) -> None:
        self.input.poll()
        self.events += self.inbox.drain()

    def feed(self, fill: Callable[[int, int], Sound], seconds: float, **how: Any) -> None:
        self.sound.feed(fill, seconds, each=self.turn, **how)

    @property
    def changes(self) -> list[str]:
        return [event.state for event in self.events if isinstance(event, SourceChanged)]

    @property
    def beats(self) -> list[float]:
        return [event.beat_time for event in self.events if isinstance(event, BeatHeard)]


def click_source(
    rate: float, channel: int = 0, channels: int = 2, seconds: float = 30.0
) -> Callable[[int, int], Sound]:
    """Clicks at 120 bpm on one of several channels; the first beat is at 0."""
    track, _ = clicks(60.0 / PERIOD, int(rate), seconds, 0.0)

    def fill(start: int, count: int) -> Sound:
        sound = np.zeros((count, channels), np.float32)
        sound[:, channel] = np.take(track, range(start, start + count), mode="wrap")
        return sound

    return fill


def silent_source(channels: int = 2) -> Callable[[int, int], Sound]:
    return lambda start, count: np.zeros((count, channels), np.float32)


def click_offset(beats: list[float], begin: float) -> float:
    """Median distance [s] of beats from the clicks that start at `begin`."""
    phase = (np.array(beats) - begin) / PERIOD
    return float(np.median(np.abs(phase - np.round(phase)))) * PERIOD


@pytest.fixture
def sound(monkeypatch: pytest.MonkeyPatch) -> FakeSound:
    return fake_sound_system(monkeypatch)


@mostly_long(("rate", "block"), [(22_050.0, 64), (44_100.0, 1000), (96_000.0, 512), (192_000.0, 4096)], quick=[])
def test_beats_match_clicks_at_any_rate_and_block(sound: FakeSound, rate: float, block: int) -> None:
    sound.plug(sound.devices[0], sample_rate=rate)
    desk = InputDriver(sound, latency=0.030)
    desk.feed(click_source(rate), 12.0, block=block)
    assert len(desk.beats) >= 8
    assert click_offset(desk.beats[3:], -0.030) < 0.012


def test_fallback_tracker_is_reported(sound: FakeSound) -> None:
    sound.plug(sound.devices[0], sample_rate=11_025.0)  # the network needs more
    assert "aubio is used instead" in InputDriver(sound).input.status()["problem"]


@pytest.mark.long
def test_only_chosen_channel_of_32_is_analyzed(sound: FakeSound) -> None:
    desk = InputDriver(sound, channels=Channels.parse("17"))
    assert sound.streams[-1].options["channels"] == 17
    desk.feed(click_source(48_000.0, 16, 17), 6.0)
    assert desk.beats
    other = InputDriver(sound, channels=Channels.parse("3"))
    other.feed(click_source(48_000.0, 1, 3), 6.0)
    assert not other.beats


def test_missing_channel_is_refused_at_start(sound: FakeSound) -> None:
    sound.plug(sound.devices[0], channels=2)
    with pytest.raises(PersonError, match="no channel 5, 6 among 2"):
        InputDriver(sound, channels=Channels.parse("5,6"))


@pytest.mark.long
def test_device_refusing_its_rate_opens_at_another(sound: FakeSound) -> None:
    sound.refuses = {48_000.0, 44_100.0}
    desk = InputDriver(sound)
    assert sound.streams[-1].samplerate == 96_000.0
    desk.feed(click_source(96_000.0), 8.0)
    assert click_offset(desk.beats[3:], 0.0) < 0.012


def test_device_refusing_every_rate_raises_error(sound: FakeSound) -> None:
    sound.refuses = {48_000.0, 44_100.0, 96_000.0, 192_000.0, 32_000.0, 22_050.0}
    with pytest.raises(RuntimeError, match="Invalid sample rate"):
        InputDriver(sound)


@pytest.mark.long
def test_device_opened_at_another_rate_is_followed(sound: FakeSound) -> None:
    sound.opens_at = 44_100.0
    desk = InputDriver(sound)
    assert desk.input.status()["sample_rate"] == 44_100.0
    desk.feed(click_source(44_100.0), 10.0)
    assert np.median(np.diff(desk.beats)) == pytest.approx(PERIOD, abs=0.005)


@pytest.mark.long
def test_wrong_device_rate_is_detected(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    desk.feed(click_source(44_100.0), 20.0, rate=44_100.0)
    assert desk.input.status()["sample_rate"] == 44_100.0
    assert click_offset(desk.beats[-8:], 0.0) < 0.012
    assert "lost" not in desk.changes


@pytest.mark.long
def test_replugged_device_with_other_format_is_reopened(sound: FakeSound) -> None:
    desk = InputDriver(sound, channels=Channels.parse("5,6"))
    desk.feed(click_source(48_000.0, 5, 6), 5.0)
    (device,) = sound.unplug()
    unplugged = sound.clock.now()
    sound.wait(6.0, desk.turn)
    lost = next(e for e in desk.events if isinstance(e, SourceChanged) and e.state == "lost")
    assert lost.time - unplugged <= 0.6
    assert sound.streams[0].closed
    assert desk.input.status()["state"] == "lost"
    assert desk.input.problem
    sound.plug(device, index=9, sample_rate=44_100.0, channels=2)
    sound.wait(2.0, desk.turn)
    begin = sound.clock.now()
    desk.feed(click_source(44_100.0), 10.0)
    assert [state for state in desk.changes if state != "silent"] == ["lost", "found"]
    assert desk.input.reopened == 1
    assert desk.input.problem == "no channel 5, 6 among 2"
    assert click_offset(desk.beats[-6:], begin) < 0.012


def test_replugged_device_with_new_card_number_is_found(sound: FakeSound) -> None:
    sound.devices = [SoundDevice(0, "USB box: Audio (hw:1,0)", "ALSA", 2, 48_000.0, True)]
    desk = InputDriver(sound)
    sound.unplug()
    sound.wait(5.0, desk.turn)
    sound.devices = [
        SoundDevice(0, "HDMI (hw:0,3)", "ALSA", 2, 48_000.0, True),
        SoundDevice(1, "USB box: Audio (hw:2,0)", "ALSA", 2, 48_000.0, False),
    ]
    sound.wait(2.5, desk.turn)
    assert desk.input.device.index == 1


def test_only_long_callback_stall_is_a_loss(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    desk.feed(click_source(48_000.0), 3.0)
    sound.wait(0.4, desk.turn)  # a hiccup
    desk.feed(click_source(48_000.0), 1.0)
    assert "lost" not in desk.changes
    sound.wait(0.7, desk.turn)
    assert desk.changes[-1] == "lost"


@pytest.mark.long
def test_zero_and_nan_samples_are_silent(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    desk.feed(silent_source(), 3.0)
    assert desk.changes[-1] == "silent"
    desk.feed(lambda start, count: np.full((count, 2), np.nan, np.float32), 3.0)
    assert desk.changes[-1] == "silent"
    assert desk.input.bad_samples >= 2 * 48_000
    assert desk.input.level < 1e-4
    begin = sound.clock.now() - sound.streams[-1].frames / 48_000.0
    desk.feed(click_source(48_000.0), 8.0)
    assert desk.changes[-1] == "found"
    assert click_offset(desk.beats[3:], begin) < 0.012


class FailingAnalysis(AudioAnalysis):
    """Fails once after a second, or always."""

    always = False
    made = 0

    def __init__(self, rate: float) -> None:
        super().__init__(rate)
        type(self).made += 1

    def feed(self, *arguments: Any) -> list[ControlEvent]:
        if self.always or (type(self).made == 1 and self.tracker.position > 1.0):
            raise ArithmeticError("a bug in the tracker")
        return super().feed(*arguments)


@pytest.mark.long
def test_failed_analysis_is_restarted_and_counted(sound: FakeSound, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FailingAnalysis, "made", 0)
    desk = InputDriver(sound, analysis=FailingAnalysis)
    desk.feed(click_source(48_000.0), 10.0)
    assert desk.input.crashes == 1
    assert desk.input.status()["failure"] == "the analysis failed: ArithmeticError: a bug in the tracker"
    assert desk.input.problem == "", "it has gone well for long"
    assert "lost" not in desk.changes
    assert click_offset(desk.beats[3:], 0.0) < 0.012


def test_source_is_lost_when_analysis_cannot_restart(sound: FakeSound) -> None:
    made: list[AudioAnalysis] = []

    class Once(AudioAnalysis):
        def feed(self, *arguments: Any) -> list[ControlEvent]:
            raise ArithmeticError("a bug in the tracker")

    def make(rate: float) -> AudioAnalysis:
        if made:
            raise MemoryError("no room")
        made.append(Once(rate))
        return made[0]

    desk = InputDriver(sound, analysis=make)
    desk.feed(click_source(48_000.0), 1.0)
    assert desk.changes == ["lost"]
    assert desk.input.problem == "the analysis cannot be started: MemoryError: no room"
    sound.wait(5.0, desk.turn)
    assert desk.input.problem == "no room"  # asked again now and then


def test_permanently_failing_analysis_is_retried_rarely(sound: FakeSound, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FailingAnalysis, "always", True)
    desk = InputDriver(sound, analysis=FailingAnalysis)
    for _ in range(4):
        desk.feed(click_source(48_000.0), 3.0)
    assert desk.changes[0] == "lost"
    assert desk.input.crashes < 20  # tried again now and then, not at every block


@pytest.mark.long
def test_manual_restart_reopens_the_device(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    desk.feed(click_source(48_000.0), 4.0)
    desk.input.handle(RestartAudio(time=0.0, source="osc"))
    desk.turn()
    assert [stream.closed for stream in sound.streams] == [True, False]
    desk.feed(click_source(48_000.0), 2.0)
    assert desk.changes == ["lost", "found"]
    assert desk.input.reopened == 1


@pytest.mark.long
def test_running_input_changes_device(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    sound.devices = [*sound.devices, SoundDevice(7, "Zoom H4n", "ALSA", 4, 44_100.0, False)]
    desk.input.handle(ChooseAudio(time=0.0, source="osc", device="zoom", channels="4"))
    desk.turn()
    assert desk.input.status()["device"] == "Zoom H4n"
    assert sound.streams[-1].options["device"] == 7
    desk.feed(click_source(44_100.0, 3, 4), 8.0)
    assert desk.beats
    assert desk.input.problem == ""


def test_device_and_channels_from_separate_events_are_applied(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    sound.devices = [*sound.devices, SoundDevice(7, "Zoom H4n", "ALSA", 4, 44_100.0, False)]
    for words in ({"device": "zoom"}, {"channels": "4"}):  # two messages of one bundle
        desk.input.handle(ChooseAudio(time=0.0, source="osc", **words))
    desk.turn()
    assert (desk.input.device.name, str(desk.input.channels)) == ("Zoom H4n", "4")
    assert len(sound.streams) == 2


def test_replaced_thread_opens_no_stream(sound: FakeSound, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = InputDriver(sound)
    desk.feed(silent_source(), 1.0)
    sound.wait(1.0, desk.turn)

    def hang() -> bool:  # meanwhile somebody restarts the listening
        desk.input._watchdog.stop_event = threading.Event()
        return True

    monkeypatch.setattr("live.control.audio.audio_input.refresh", hang)
    sound.wait(2.5, desk.turn)
    assert len(sound.streams) == 1


@mostly_long(
    ("device", "channels", "why"),
    [("organ", "", "organ"), ("", "40", "no channel 40"), ("", "left", "channels 'left'")],
    quick=[1],
)
def test_invalid_choice_keeps_current_device(sound: FakeSound, device: str, channels: str, why: str) -> None:
    desk = InputDriver(sound)
    desk.feed(click_source(48_000.0), 2.0)
    desk.input.handle(ChooseAudio(time=0.0, source="osc", device=device, channels=channels))
    desk.turn()
    assert why in desk.input.problem
    assert (desk.input.device.name, str(desk.input.channels)) == ("stage box", "1,2")
    desk.feed(click_source(48_000.0), 1.0)
    assert desk.changes[-1] == "found"


def test_hung_thread_is_replaced(sound: FakeSound) -> None:
    desk = InputDriver(sound)
    desk.input._watchdog.start()
    hung = desk.input._watchdog.thread
    sound.clock.advance(60.0)
    desk.input._watchdog.called_at = 0.0  # it has not come round since then
    desk.input.handle(RestartAudio(time=60.0, source="key"))
    try:
        assert desk.input._watchdog.thread is not hung
    finally:
        desk.input.stop()
    assert hung is not None
    hung.join(2.0)
    assert not hung.is_alive()
