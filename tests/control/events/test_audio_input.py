"""AudioInput on devices made by hand: lost, changed, wrong in every way, and never the end of the show."""

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

Sound = npt.NDArray[np.float32]
PERIOD = 0.5


class Desk:
    """An AudioInput at a fake sound system; `turn` is what its thread would do."""

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


def music(rate: float, channel: int = 0, channels: int = 2, seconds: float = 30.0) -> Callable[[int, int], Sound]:
    """Clicks at 120 bpm on one channel of some; the first beat is at 0."""
    track, _ = clicks(60.0 / PERIOD, int(rate), seconds, 0.0)

    def fill(start: int, count: int) -> Sound:
        sound = np.zeros((count, channels), np.float32)
        sound[:, channel] = np.take(track, range(start, start + count), mode="wrap")
        return sound

    return fill


def silence(channels: int = 2) -> Callable[[int, int], Sound]:
    return lambda start, count: np.zeros((count, channels), np.float32)


def off_the_grid(beats: list[float], begin: float) -> float:
    """Median distance [s] of beats to the clicks that began at `begin`."""
    phase = (np.array(beats) - begin) / PERIOD
    return float(np.median(np.abs(phase - np.round(phase)))) * PERIOD


@pytest.fixture
def sound(monkeypatch: pytest.MonkeyPatch) -> FakeSound:
    return fake_sound_system(monkeypatch)


@pytest.mark.parametrize(("rate", "block"), [(22_050.0, 64), (44_100.0, 1000), (96_000.0, 512), (192_000.0, 4096)])
def test_beats_lie_on_the_clicks_at_any_rate_and_block(sound: FakeSound, rate: float, block: int) -> None:
    sound.plug(sound.devices[0], sample_rate=rate)
    desk = Desk(sound, latency=0.030)
    desk.feed(music(rate), 12.0, block=block)
    assert len(desk.beats) >= 8
    assert off_the_grid(desk.beats[3:], -0.030) < 0.012


def test_another_tracker_than_was_asked_for_is_told(sound: FakeSound) -> None:
    sound.plug(sound.devices[0], sample_rate=11_025.0)  # the network needs more
    assert "aubio is used instead" in Desk(sound).input.status()["problem"]


def test_one_channel_of_32_is_heard(sound: FakeSound) -> None:
    desk = Desk(sound, channels=Channels.parse("17"))
    assert sound.streams[-1].options["channels"] == 17
    desk.feed(music(48_000.0, 16, 17), 6.0)
    assert desk.beats
    other = Desk(sound, channels=Channels.parse("3"))
    other.feed(music(48_000.0, 1, 3), 6.0)
    assert not other.beats


def test_a_channel_that_is_not_there_is_refused_at_the_start(sound: FakeSound) -> None:
    sound.plug(sound.devices[0], channels=2)
    with pytest.raises(PersonError, match="no channel 5, 6 among 2"):
        Desk(sound, channels=Channels.parse("5,6"))


def test_a_device_that_refuses_its_rate_is_opened_at_another(sound: FakeSound) -> None:
    sound.refuses = {48_000.0, 44_100.0}
    desk = Desk(sound)
    assert sound.streams[-1].samplerate == 96_000.0
    desk.feed(music(96_000.0), 8.0)
    assert off_the_grid(desk.beats[3:], 0.0) < 0.012


def test_a_device_that_refuses_everything_says_so(sound: FakeSound) -> None:
    sound.refuses = {48_000.0, 44_100.0, 96_000.0, 192_000.0, 32_000.0, 22_050.0}
    with pytest.raises(RuntimeError, match="Invalid sample rate"):
        Desk(sound)


def test_a_device_that_opens_at_another_rate_is_followed(sound: FakeSound) -> None:
    sound.opens_at = 44_100.0
    desk = Desk(sound)
    assert desk.input.status()["sample_rate"] == 44_100.0
    desk.feed(music(44_100.0), 10.0)
    assert np.median(np.diff(desk.beats)) == pytest.approx(PERIOD, abs=0.005)


def test_a_device_that_lies_about_its_rate_is_found_out(sound: FakeSound) -> None:
    desk = Desk(sound)
    desk.feed(music(44_100.0), 20.0, rate=44_100.0)
    assert desk.input.status()["sample_rate"] == 44_100.0
    assert off_the_grid(desk.beats[-8:], 0.0) < 0.012
    assert "lost" not in desk.changes


def test_unplugged_and_back_with_another_rate_and_fewer_channels(sound: FakeSound) -> None:
    desk = Desk(sound, channels=Channels.parse("5,6"))
    desk.feed(music(48_000.0, 5, 6), 5.0)
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
    desk.feed(music(44_100.0), 10.0)
    assert [state for state in desk.changes if state != "silent"] == ["lost", "found"]
    assert desk.input.reopened == 1
    assert desk.input.problem == "no channel 5, 6 among 2"
    assert off_the_grid(desk.beats[-6:], begin) < 0.012


def test_plugged_in_again_as_another_card_it_is_the_same(sound: FakeSound) -> None:
    sound.devices = [SoundDevice(0, "USB box: Audio (hw:1,0)", "ALSA", 2, 48_000.0, True)]
    desk = Desk(sound)
    sound.unplug()
    sound.wait(5.0, desk.turn)
    sound.devices = [
        SoundDevice(0, "HDMI (hw:0,3)", "ALSA", 2, 48_000.0, True),
        SoundDevice(1, "USB box: Audio (hw:2,0)", "ALSA", 2, 48_000.0, False),
    ]
    sound.wait(2.5, desk.turn)
    assert desk.input.device.index == 1


def test_a_callback_that_stalls_is_a_loss_and_its_return_none(sound: FakeSound) -> None:
    desk = Desk(sound)
    desk.feed(music(48_000.0), 3.0)
    sound.wait(0.4, desk.turn)  # a hiccup
    desk.feed(music(48_000.0), 1.0)
    assert "lost" not in desk.changes
    sound.wait(0.7, desk.turn)
    assert desk.changes[-1] == "lost"


def test_silence_and_nan_are_silence(sound: FakeSound) -> None:
    desk = Desk(sound)
    desk.feed(silence(), 3.0)
    assert desk.changes[-1] == "silent"
    desk.feed(lambda start, count: np.full((count, 2), np.nan, np.float32), 3.0)
    assert desk.changes[-1] == "silent"
    assert desk.input.bad_samples >= 2 * 48_000
    assert desk.input.level < 1e-4
    begin = sound.clock.now() - sound.streams[-1].frames / 48_000.0
    desk.feed(music(48_000.0), 8.0)
    assert desk.changes[-1] == "found"
    assert off_the_grid(desk.beats[3:], begin) < 0.012


class Breaks(AudioAnalysis):
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


def test_an_analysis_that_fails_is_begun_anew_and_counted(sound: FakeSound, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Breaks, "made", 0)
    desk = Desk(sound, analysis=Breaks)
    desk.feed(music(48_000.0), 10.0)
    assert desk.input.crashes == 1
    assert desk.input.status()["failure"] == "the analysis failed: ArithmeticError: a bug in the tracker"
    assert desk.input.problem == "", "it has gone well for long"
    assert "lost" not in desk.changes
    assert off_the_grid(desk.beats[3:], 0.0) < 0.012


def test_an_analysis_that_cannot_even_be_begun_leaves_the_source_lost(sound: FakeSound) -> None:
    made: list[AudioAnalysis] = []

    class Once(AudioAnalysis):
        def feed(self, *arguments: Any) -> list[ControlEvent]:
            raise ArithmeticError("a bug in the tracker")

    def make(rate: float) -> AudioAnalysis:
        if made:
            raise MemoryError("no room")
        made.append(Once(rate))
        return made[0]

    desk = Desk(sound, analysis=make)
    desk.feed(music(48_000.0), 1.0)
    assert desk.changes == ["lost"]
    assert desk.input.problem == "the analysis cannot be started: MemoryError: no room"
    sound.wait(5.0, desk.turn)
    assert desk.input.problem == "no room"  # asked again now and then


def test_one_that_always_fails_leaves_the_source_lost_and_the_show_alone(
    sound: FakeSound, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Breaks, "always", True)
    desk = Desk(sound, analysis=Breaks)
    for _ in range(4):
        desk.feed(music(48_000.0), 3.0)
    assert desk.changes[0] == "lost"
    assert desk.input.crashes < 20  # tried again now and then, not at every block


def test_restart_by_hand_opens_the_device_anew(sound: FakeSound) -> None:
    desk = Desk(sound)
    desk.feed(music(48_000.0), 4.0)
    desk.input.handle(RestartAudio(time=0.0, source="osc"))
    desk.turn()
    assert [stream.closed for stream in sound.streams] == [True, False]
    desk.feed(music(48_000.0), 2.0)
    assert desk.changes == ["lost", "found"]
    assert desk.input.reopened == 1


def test_another_device_while_it_runs(sound: FakeSound) -> None:
    desk = Desk(sound)
    sound.devices = [*sound.devices, SoundDevice(7, "Zoom H4n", "ALSA", 4, 44_100.0, False)]
    desk.input.handle(ChooseAudio(time=0.0, source="osc", device="zoom", channels="4"))
    desk.turn()
    assert desk.input.status()["device"] == "Zoom H4n"
    assert sound.streams[-1].options["device"] == 7
    desk.feed(music(44_100.0, 3, 4), 8.0)
    assert desk.beats
    assert desk.input.problem == ""


def test_device_and_channels_chosen_one_by_one_are_both_taken(sound: FakeSound) -> None:
    desk = Desk(sound)
    sound.devices = [*sound.devices, SoundDevice(7, "Zoom H4n", "ALSA", 4, 44_100.0, False)]
    for words in ({"device": "zoom"}, {"channels": "4"}):  # two messages of one bundle
        desk.input.handle(ChooseAudio(time=0.0, source="osc", **words))
    desk.turn()
    assert (desk.input.device.name, str(desk.input.channels)) == ("Zoom H4n", "4")
    assert len(sound.streams) == 2


def test_a_thread_that_comes_back_after_another_took_its_place_opens_nothing(
    sound: FakeSound, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(sound)
    desk.feed(silence(), 1.0)
    sound.wait(1.0, desk.turn)

    def hang() -> bool:  # meanwhile somebody restarts the listening
        desk.input._watchdog.stop_event = threading.Event()
        return True

    monkeypatch.setattr("live.control.audio.audio_input.refresh", hang)
    sound.wait(2.5, desk.turn)
    assert len(sound.streams) == 1


@pytest.mark.parametrize(
    ("device", "channels", "why"),
    [("organ", "", "organ"), ("", "40", "no channel 40"), ("", "left", "channels 'left'")],
)
def test_a_choice_that_cannot_be_leaves_the_device_there_is(
    sound: FakeSound, device: str, channels: str, why: str
) -> None:
    desk = Desk(sound)
    desk.feed(music(48_000.0), 2.0)
    desk.input.handle(ChooseAudio(time=0.0, source="osc", device=device, channels=channels))
    desk.turn()
    assert why in desk.input.problem
    assert (desk.input.device.name, str(desk.input.channels)) == ("stage box", "1,2")
    desk.feed(music(48_000.0), 1.0)
    assert desk.changes[-1] == "found"


def test_a_thread_that_hangs_in_the_sound_system_is_left_behind(sound: FakeSound) -> None:
    desk = Desk(sound)
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
