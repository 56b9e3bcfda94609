"""A fake sound system: devices that are plugged in, unplugged and fed by hand."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from live.clock.time_source import ManualClock
from live.control.audio import device_stream, devices
from live.control.audio.devices import SoundDevice

Fill = Callable[[int, int], npt.NDArray[np.float32]]
"""(first frame, frames) -> sound, shape (frames, channels)."""


@dataclass(eq=False)
class FakeStream:
    """The stream that `open_stream` returned: its options, and whether it was closed."""

    options: dict[str, Any]
    samplerate: float
    frames: int = 0
    closed: bool = False


@dataclass(eq=False)
class FakeSound:
    """Fake sound devices. `clock` advances as sound is fed."""

    clock: ManualClock = field(default_factory=ManualClock)
    devices: list[SoundDevice] = field(
        default_factory=lambda: [SoundDevice(4, "stage box", "ALSA", 32, 48_000.0, True)]
    )
    streams: list[FakeStream] = field(default_factory=list)
    refuses: set[float] = field(default_factory=set)
    """Rates that no device opens at."""
    opens_at: float | None = None
    """The rate that a stream really has, whatever was asked."""

    def open(self, kind: str, **options: Any) -> FakeStream:
        if not any(device.index == options["device"] for device in self.devices):
            raise RuntimeError("Invalid device")
        if options["samplerate"] in self.refuses:
            raise RuntimeError("Invalid sample rate [PaErrorCode -9997]")
        self.streams.append(FakeStream(options, self.opens_at or options["samplerate"]))
        return self.streams[-1]

    def close(self, stream: FakeStream) -> None:
        stream.closed = True

    def unplug(self) -> list[SoundDevice]:
        gone, self.devices = self.devices, []
        return gone

    def plug(self, device: SoundDevice, **changed: Any) -> None:
        self.devices = [replace(device, **changed)]

    def feed(
        self, fill: Fill, seconds: float, *, rate: float | None = None, block: int = 512, each: Callable[[], None]
    ) -> None:
        """Feed the newest stream for `seconds`, and call `each` after every block."""
        stream = self.streams[-1]
        until = self.clock.now() + seconds
        while self.clock.now() < until - 1e-9:
            self.clock.advance(block / (rate or stream.samplerate))
            if not stream.closed:
                sound = np.ascontiguousarray(fill(stream.frames, block), np.float32)
                assert sound.shape == (block, stream.options["channels"])
                stream.frames += block
                stream.options["callback"](sound, block, None, None)
            each()

    def wait(self, seconds: float, each: Callable[[], None]) -> None:
        """Let time pass without sound."""
        for _ in range(round(seconds / 0.05)):
            self.clock.advance(0.05)
            each()


def fake_sound_system(monkeypatch: pytest.MonkeyPatch) -> FakeSound:
    """A FakeSound in place of PortAudio, for audio inputs."""
    fake = FakeSound()
    monkeypatch.setattr(devices, "_list", lambda kind: fake.devices)
    monkeypatch.setattr("live.control.audio.audio_input.refresh", lambda: True)
    monkeypatch.setattr(device_stream, "open_stream", fake.open)
    monkeypatch.setattr(device_stream, "close_stream", fake.close)
    return fake
