"""The sound devices while they are calibrated: opened as a show opens them, and all that is heard is kept."""

import time
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.clock.sample_clock import SampleClock
from live.clock.time_source import Clock
from live.control.audio.calibration import Recording, Train
from live.control.audio.channel_mixer import Channels, Mixer
from live.control.audio.listening import BLOCK
from live.control.audio.sound_devices import SoundDevice, close_stream, open_stream

BEGINS_WITHIN: Final = 5.0
"""Seconds that devices may take until they begin."""

Stamps = list[tuple[int, float]]


class Microphone:
    """Records an input from being opened to being closed, for `seconds` at most."""

    def __init__(self, device: SoundDevice, channels: Channels, seconds: float, clock: Clock) -> None:
        """Opens it; PersonError if it refuses or lacks the channels."""
        missing = channels.missing(device.channels)
        if missing:
            raise PersonError(f"{device.name}: {missing}", "choose others with --audio-channel, see `live devices`")
        chosen = channels.among(device.channels)
        self._chosen = chosen
        self._sound = np.zeros((int(seconds * device.sample_rate), len(chosen)), np.float32)
        self._count = 0
        self.stamps: Stamps = []
        self.sample_rate = device.sample_rate

        def heard(block: npt.NDArray[np.float32], _frames: int, _times: Any, _status: Any) -> None:
            now = clock.now()
            fitting = block[: len(self._sound) - self._count, list(chosen)]
            self._sound[self._count : self._count + len(fitting)] = fitting
            self._count += len(fitting)
            self.stamps.append((self._count, now))

        self._stream = _opened(
            "input",
            device,
            channels=max(chosen) + 1,
            samplerate=device.sample_rate,
            blocksize=BLOCK,
            latency="low",
            callback=heard,
        )
        self.latency = _reported(self._stream)

    def close(self) -> None:
        """Stop recording."""
        close_stream(self._stream)

    @property
    def full(self) -> bool:
        """Whether no more fits."""
        return self._count >= len(self._sound)

    def sound(self) -> npt.NDArray[np.float32]:
        """What was heard so far, as one channel, shape (n,)."""
        mixer = Mixer(range(len(self._chosen)), self.sample_rate, BLOCK)
        blocks = [self._sound[at : min(at + BLOCK, self._count)] for at in range(0, self._count, BLOCK)]
        return np.concatenate([mixer.mix(block).copy() for block in blocks] or [np.zeros(0, np.float32)])

    def time_of(self, seconds: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """When what lies at `seconds` of the sound was there [s of the clock]."""
        line, at, times = SampleClock(self.sample_rate), 0, np.zeros(len(seconds))
        for index, frame in enumerate(seconds * self.sample_rate):
            while at < len(self.stamps) and self.stamps[at][0] < frame + self.sample_rate:
                line.observe(*self.stamps[at])
                at += 1
            times[index] = line.time_of(frame)
        return times


def play_and_record(
    train: Train, output: SoundDevice, microphone: Microphone, clock: Clock, wait: Callable[[float], None] = time.sleep
) -> tuple[Recording, float | None]:
    """Play the train and record it meanwhile; also the output's own idea of its delay [s], None if it has no sane one.

    PersonError if the output refuses, or a device delivers nothing.
    """
    played: Stamps = []
    at = 0

    def callback(out: npt.NDArray[np.float32], frames: int, _times: Any, _status: Any) -> None:
        nonlocal at
        played.append((at, clock.now()))
        block = train.sound[at : at + frames]
        out[: len(block)] = block[:, None]
        out[len(block) :] = 0.0
        at += frames

    stream = _opened(
        "output",
        output,
        channels=min(output.channels, 2),
        samplerate=train.sample_rate,
        latency="high",
        callback=callback,
    )
    try:
        latency = _reported(stream)
        deadline = clock.now() + BEGINS_WITHIN + len(train.sound) / train.sample_rate
        while at < len(train.sound) and not microphone.full:
            if clock.now() > deadline:
                raise PersonError(
                    f"{output.name} plays nothing" if at < len(train.sound) else "no sound arrives",
                    "see `live devices`; name others with --output and --audio",
                )
            wait(0.05)
    finally:
        close_stream(stream)
    return Recording(microphone.sound(), microphone.sample_rate, microphone.stamps, played), latency


def _opened(kind: str, device: SoundDevice, **options: Any) -> Any:
    try:
        return open_stream(kind, device=device.index, dtype="float32", **options)
    except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
        raise PersonError(f"the sound {kind} {device.name!r} refuses: {error}", "see `live devices`") from None


def _reported(stream: Any) -> float | None:
    """What a device says of its delay [s]; None for the nonsense that some say."""
    latency = float(stream.latency)
    return latency if 0.0 < latency < 1.0 else None
