"""Tests of the click output: a simulated card, and PulseAudio's null sink whose monitor is recorded."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.time_source import ManualClock, SystemClock
from live.clock.timeline import Timeline
from live.control.audio import click_output
from live.control.audio.channel_mixer import Channels
from live.control.audio.click_output import ClickOutput
from live.control.audio.devices import SoundDevice, UnknownDevice, find_device
from live.control.audio.latency_sweep import Microphone
from live.show.sound.soundtrack import ACCENT_HZ, BEAT_HZ, click_voices
from tests.control.conftest import PulseSink
from tests.control.waiting import wait_for

TEMPO = 200.0


def find_clicks(sound: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Seconds into a recording at which clicks start, and their frequencies [Hz]."""
    loud = np.flatnonzero(np.abs(sound) > 0.05)
    begins = loud[np.flatnonzero(np.diff(loud, prepend=-rate) > 0.1 * rate)]
    begins = begins[begins < len(sound) - 0.03 * rate]
    hertz = []
    for begin in begins:
        spectrum = np.abs(np.fft.rfft(sound[begin : begin + int(0.025 * rate)], 1 << 14))
        hertz.append(np.argmax(spectrum) * rate / (1 << 14))
    return begins / rate, np.array(hertz)


@dataclass
class FakeCard:
    """A fake sound card: it takes some samples at once, pauses, and then plays at its own rate."""

    clock: ManualClock
    rate: float
    pause: float = 1.7
    buffered: int = 2048
    latency: float = 0.0
    options: dict[str, Any] = field(default_factory=dict)

    def open(self, _kind: str, **options: Any) -> "FakeCard":
        self.options = options
        return self

    def played_at(self, frame: float) -> float:
        """When a frame is played [s]."""
        return self.pause + frame / self.rate

    def run(self, seconds: float, click: ClickOutput, chance: np.random.Generator) -> np.ndarray:
        """All requested samples; callbacks run when the buffer has room, or late, and in bursts when late."""
        blocks, frame, due = [], 0, 0.0
        while due < seconds:
            due = max(due, self.played_at(frame - self.buffered) if frame >= self.buffered else 0.0)
            late = chance.exponential(0.002) + (0.08 if chance.random() < 0.005 else 0.0)
            self.clock.set(max(self.clock.now(), due + late))
            block = np.zeros((512, self.options["channels"]), np.float32)
            self.options["callback"](block, 512, None, None)
            blocks.append(block)
            frame += 512
            click.poll()
        return np.concatenate(blocks)


def test_card_pause_latency_and_rate_do_not_shift_clicks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = ManualClock()
    card = FakeCard(clock, 48_000.0 * 1.00008)
    monkeypatch.setattr(click_output, "find_device", lambda *_: SoundDevice(0, "drummer", "ALSA", 4, 48_000.0, True))
    monkeypatch.setattr(click_output, "open_stream", card.open)
    monkeypatch.setattr(click_output, "close_stream", lambda stream: None)
    click = ClickOutput("drummer", clock, click_voices, channels=Channels.parse("3"), extra_delay=2048 / 48_000.0)
    timeline = Timeline(tempo=171.3, beat_origin=0.4)
    click.set_timeline(timeline)
    click.open()
    sound = card.run(40.0, click, np.random.default_rng(2))
    assert not sound[:, :2].any()
    begins, _ = find_clicks(sound[:, 2], 48_000.0)
    times = np.array([card.played_at(begin * 48_000.0) for begin in begins])
    assert times[0] < 5.0
    beats = np.array([timeline.beat_at(at) for at in times])
    assert np.array_equal(np.diff(np.round(beats)), np.ones(len(beats) - 1))
    off = beat_offsets(times, timeline)
    assert np.abs(off).max() < 0.005
    assert np.abs(off[len(off) // 3 :]).max() < 0.003
    assert click.track.missed == 0


@pytest.mark.long
@pytest.mark.pulse
def test_recorded_clicks_match_beats_and_measure_accents(pulse_sink: PulseSink) -> None:
    for _ in range(2):  # a machine that stands still for a tenth of a second loses sound: then once more
        clock, timeline = SystemClock(), Timeline(tempo=TEMPO)
        click = ClickOutput("pulse", clock, click_voices)
        click.set_timeline(timeline)
        times, hertz = click_times(record_clicks(click, clock))
        off = beat_offsets(times, timeline)
        first, rest = off[:6], off[6:]
        if np.quantile(np.abs(rest - np.median(first)), 0.8) <= 0.005:
            break
    assert len(rest) >= 12
    assert np.quantile(np.abs(rest - np.median(first)), 0.8) <= 0.005
    assert abs(np.median(off)) < 0.05  # what the device said of its latency is nearly all of it
    assert click.track.missed == 0
    for at, frequency in zip(times, hertz, strict=True):
        wanted = ACCENT_HZ if round(timeline.beat_at(at)) % 4 == 0 else BEAT_HZ
        assert frequency == pytest.approx(wanted, abs=40.0)


def record_clicks(click: ClickOutput, clock: SystemClock) -> Microphone:
    """Records about 20 clicks; nothing else runs meanwhile, because callbacks need the interpreter."""
    microphone = Microphone(find_device("pulse"), Channels(), 30.0, clock)
    click.start()
    try:
        assert wait_for(lambda: click.track.clicks >= 22, 28.0), click.status()
    finally:
        click.stop()
        microphone.close()
    return microphone


def click_times(microphone: Microphone) -> tuple[np.ndarray, np.ndarray]:
    """Show times [s] of recorded clicks, and their frequencies [Hz]."""
    begins, hertz = find_clicks(microphone.sound(), microphone.sample_rate)
    return microphone.time_of(begins), hertz


def beat_offsets(times: np.ndarray, timeline: Timeline) -> np.ndarray:
    """The lateness [s] of each time against its nearest beat."""
    beats = np.array([timeline.beat_at(at) for at in times])
    return (beats - np.round(beats)) * 60.0 / timeline.tempo


def test_missing_output_or_channel_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object) -> None:
        raise UnknownDevice("no sound output 'drummer'; there are: …")

    monkeypatch.setattr(click_output, "find_device", unknown)
    with pytest.raises(UnknownDevice, match="drummer"):
        ClickOutput("drummer", SystemClock(), click_voices)
    monkeypatch.setattr(click_output, "find_device", lambda *_: SoundDevice(0, "drummer", "ALSA", 2, 48_000.0, True))
    with pytest.raises(PersonError, match="no channel 3"):
        ClickOutput("drummer", SystemClock(), click_voices, channels=Channels.parse("3"))


def test_lost_output_is_reopened(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[dict[str, object]] = []

    class Stream:
        latency = 0.02

    def open_stream(_kind: str, **options: object) -> Stream:
        if len(opened) == 1:
            opened.append({})
            raise RuntimeError("Invalid device")
        opened.append(options)
        return Stream()

    monkeypatch.setattr(click_output, "find_device", lambda *_: SoundDevice(0, "drummer", "ALSA", 2, 48_000.0, True))

    def fail(_now: float) -> None:
        failed.append(click.reopened)
        raise ArithmeticError("no line")

    failed: list[int] = []
    monkeypatch.setattr(click_output, "find_again", lambda *_: SoundDevice(0, "drummer", "ALSA", 2, 48_000.0, True))
    monkeypatch.setattr(click_output, "open_stream", open_stream)
    monkeypatch.setattr(click_output, "close_stream", lambda stream: None)
    monkeypatch.setattr(click_output, "refresh", lambda: True)
    for name, value in (("START_TIMEOUT", 0.05), ("LOST_AFTER", 0.05), ("RETRY", 0.05)):
        monkeypatch.setattr(click_output, name, value)
    click = ClickOutput("drummer", SystemClock(), click_voices)
    click.start()
    try:
        assert wait_for(lambda: click.problem == "Invalid device", 5.0)
        assert wait_for(lambda: click.reopened >= 1, 5.0)
        monkeypatch.setattr(click, "_watch", fail)
        assert wait_for(lambda: len(set(failed)) >= 2, 5.0), "a failure is no end: it is opened anew, and fails again"
        assert click.problem in ("", "the click failed: ArithmeticError: no line")
        assert (click.delay, click.status()["device"]) == (0.02, "drummer")
        click.extra_delay = 0.005
        assert click.delay == pytest.approx(0.025)
    finally:
        click.stop()
