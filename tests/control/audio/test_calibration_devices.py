"""Calibration through devices: a loopback of known length, and a real PulseAudio."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.time_source import ManualClock, SystemClock
from live.control.audio import latency_sweep
from live.control.audio.channel_mixer import Channels
from live.control.audio.devices import SoundDevice, find_device
from live.control.audio.latency_sweep import Microphone, RoundTrip, measure, play_and_record, sweep_train
from tests.control.conftest import PulseSink
from tests.fixtures.mostly_long import mostly_long

BLOCK = 480
RATE = 48_000.0
DEVICE = SoundDevice(0, "loop", "ALSA", 2, RATE, True)


class Loopback:
    """An output that is connected to an input with `delay` frames; `wait` lets time pass."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, delay: int) -> None:
        self.clock = ManualClock(3.0)
        self.callbacks: dict[str, Any] = {}
        self._wire = np.zeros((delay, 2), np.float32)
        self.latency = 0.02
        monkeypatch.setattr(latency_sweep, "open_stream", self.open)
        monkeypatch.setattr(latency_sweep, "close_stream", lambda stream: None)

    def open(self, kind: str, **options: Any) -> "Loopback":
        self.callbacks[kind] = options["callback"]
        return self

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds * RATE / BLOCK)):
            self.clock.advance(BLOCK / RATE)
            out = np.zeros((BLOCK, 2), np.float32)
            if "output" in self.callbacks:
                self.callbacks["output"](out, BLOCK, None, None)
            self._wire = np.concatenate([self._wire, out])
            self.callbacks["input"](self._wire[:BLOCK], BLOCK, None, None)
            self._wire = self._wire[BLOCK:]


@mostly_long("delay", [600, 4_801, 24_000], quick=[0, 1])
def test_loopback_delay_is_measured_to_the_sample(monkeypatch: pytest.MonkeyPatch, delay: int) -> None:
    loop, train = Loopback(monkeypatch, delay), sweep_train(RATE, 8)
    microphone = Microphone(DEVICE, Channels(), 30.0, loop.clock)
    loop.wait(0.5)
    recording, reported = play_and_record(train, DEVICE, microphone, loop.clock, loop.wait)
    # a block is handed over when it begins and is there at the input when it is complete
    assert measure(train, recording).seconds == pytest.approx((delay - BLOCK) / RATE, abs=1.0 / RATE)
    assert reported == 0.02


def test_silent_output_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = Loopback(monkeypatch, 600)
    microphone = Microphone(DEVICE, Channels(), 30.0, loop.clock)
    with pytest.raises(PersonError, match="loop plays nothing"):
        play_and_record(sweep_train(RATE, 3), DEVICE, microphone, loop.clock, loop.clock.advance)


def test_device_refusal_is_a_person_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(kind: str, **options: Any) -> None:
        raise RuntimeError("Device unavailable")

    monkeypatch.setattr(latency_sweep, "open_stream", refuse)
    with pytest.raises(PersonError, match="input 'loop' refuses: Device unavailable"):
        Microphone(DEVICE, Channels(), 1.0, ManualClock())
    with pytest.raises(PersonError, match="no channel 7 among 2"):
        Microphone(DEVICE, Channels.parse("7"), 1.0, ManualClock())


def measure_pulse(inserted: float) -> RoundTrip:
    """The round trip over PulseAudio, with inserted silence [s] that is unknown to the measurement."""
    clock, pulse = SystemClock(), find_device("pulse")
    train = sweep_train(pulse.sample_rate, 3)
    later = np.concatenate([np.zeros(int(inserted * pulse.sample_rate), np.float32), train.sound])
    microphone = Microphone(pulse, Channels(), 30.0, clock)
    try:
        played = replace(train, sound=later)
        recording, _ = play_and_record(played, find_device("pulse", "output"), microphone, clock)
    finally:
        microphone.close()
    return measure(train, recording)


@pytest.mark.long
@pytest.mark.pulse
def test_inserted_delay_is_measured_over_pulseaudio(pulse_sink: PulseSink) -> None:
    first, second = measure_pulse(0.0), measure_pulse(0.060)
    assert 0.002 < first.seconds < 0.150
    assert second.seconds - first.seconds == pytest.approx(0.060, abs=0.006)
