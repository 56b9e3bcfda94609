"""Listening: one sound device that is open: callback → ring → mixer → analysis.

Ring: sound between two threads: the callback writes, the analysis reads; nobody waits, nothing is allocated.
"""

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.clock.sample_clock import RateWatch, SampleClock
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.channel_mixer import Channels, Mixer
from live.control.audio.devices import SoundDevice, close_stream, open_stream
from live.control.events.events import ControlEvent

STAMPS: Final = 512
"""Blocks whose times are kept; half of them can be read."""


class Ring:
    """Frames of sound, and when each block was there.

    Thread: `write` from the callback only, all else from one other thread. Each side moves only its own counters.
    """

    def __init__(self, frames: int, channels: int) -> None:
        self._sound = np.zeros((frames, channels), np.float32)
        self._out = np.zeros((frames // 2, channels), np.float32)
        self._stamp_frame = np.zeros(STAMPS, np.int64)
        self._stamp_time = np.zeros(STAMPS)
        self.longest = frames // 2
        """Frames that one `read` gives at most."""
        self.written = 0
        """Frames written since the start."""
        self.read_frames = 0
        """Frames read (or given up) since the start."""
        self.overrun = 0
        """Frames that were overwritten before anybody read them."""
        self._stamps = 0
        self._stamps_read = 0

    def write(self, block: npt.NDArray[np.float32], time: float) -> None:
        """Copy a block, shape (n, channels), that was complete at `time` [s]; of one too long the end is kept."""
        size = self._sound.shape[0]
        if block.shape[0] > size:
            self.written += block.shape[0] - size
            block = block[-size:]
        start = self.written % size
        first = min(size - start, block.shape[0])
        self._sound[start : start + first] = block[:first]
        self._sound[: block.shape[0] - first] = block[first:]
        self.written += block.shape[0]
        slot = self._stamps % STAMPS
        self._stamp_frame[slot], self._stamp_time[slot] = self.written, time
        self._stamps += 1

    def stamp(self) -> tuple[int, float] | None:
        """(frames written by then, time [s]) of the next block whose time was not read yet; None if there is none."""
        until = self._stamps
        if self._stamps_read >= until:
            return None
        self._stamps_read = max(self._stamps_read, until - STAMPS // 2)
        slot = self._stamps_read % STAMPS
        self._stamps_read += 1
        return int(self._stamp_frame[slot]), float(self._stamp_time[slot])

    def read(self) -> npt.NDArray[np.float32]:
        """All frames not yet read, shape (n, channels), valid until the next call.

        At most half a ring: the writer may already be at work in the older half; what is lost counts as `overrun`.
        """
        size, until = self._sound.shape[0], self.written
        late = until - self.read_frames - self.longest
        if late > 0:
            self.overrun += late
            self.read_frames += late
        start, count = self.read_frames % size, until - self.read_frames
        first = min(size - start, count)
        self._out[:first] = self._sound[start : start + first]
        self._out[first:count] = self._sound[: count - first]
        self.read_frames = until
        return self._out[:count]


BLOCK: Final = 512
RING_SECONDS: Final = 2.0

OTHER_RATES: Final = (48_000.0, 44_100.0, 96_000.0, 192_000.0, 32_000.0, 22_050.0)
"""Rates [Hz] that are tried when a device refuses its own."""


class Listening:
    """A device from being opened to being closed. Made by `open_device`.

    Thread: the callback writes into the ring; everything else belongs to one other thread.
    """

    def __init__(self, device: SoundDevice, channels: Channels, clock: Clock, analysis: MakeAnalysis) -> None:
        chosen = channels.among(device.channels)
        self.device = device
        self.opened_channels = max(chosen) + 1
        """Channels that are asked of the device: up to the last that is chosen."""
        self.missing = channels.missing(device.channels)
        """Which of the channels wished for the device does not have, in words; empty if it has all."""
        self._clock = clock
        self._make = analysis
        self._chosen = chosen
        self._stream: Any = None
        self.sample_rate = device.sample_rate
        self.ring: Ring
        self.watch: RateWatch
        self.line: SampleClock
        self.mixer: Mixer
        self.analysis: AudioAnalysis

    def begin(self, sample_rate: float) -> None:
        """A fresh ring, line, mixer and analysis for this rate [Hz]; `open` does it."""
        self.ring = Ring(int(RING_SECONDS * sample_rate), self.opened_channels)
        self.watch = RateWatch(sample_rate)
        self._listen_at(sample_rate)

    def _listen_at(self, sample_rate: float) -> None:
        """A fresh line, mixer and analysis; the ring goes on, for the callback writes into it."""
        self.sample_rate = sample_rate
        self.line = SampleClock(sample_rate)
        self.mixer = Mixer(self._chosen, sample_rate, self.ring.longest)
        self.begin_analysis(self.ring.read_frames)

    def begin_analysis(self, frame: int) -> None:
        """A fresh analysis of what comes from frame number `frame` on."""
        self.analysis = self._make(self.sample_rate)
        self._skipped = frame

    def open(self) -> None:
        """Open the stream; PortAudioError (or SoundUnavailable) if the device refuses."""
        refusal: Exception | None = None
        for rate in dict.fromkeys((self.device.sample_rate, *OTHER_RATES)):
            self.begin(rate)
            try:
                self._stream = open_stream(
                    "input",
                    device=self.device.index,
                    samplerate=rate,
                    blocksize=BLOCK,
                    channels=self.opened_channels,
                    dtype="float32",
                    latency="low",
                    callback=self.callback(self.ring),
                )
            except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
                refusal = refusal or error
                if "sample rate" not in str(error).lower():
                    raise
                continue
            opened = float(getattr(self._stream, "samplerate", rate))
            if opened != rate and 0.0 < opened < 1e6:  # it opened, but at a rate of its own
                self.watch = RateWatch(opened)
                self._listen_at(opened)
            return
        assert refusal is not None
        raise refusal

    @property
    def problem(self) -> str:
        """What is not as it was wished, in words: channels that are missing, another tracker; empty if nothing is."""
        return "; ".join(words for words in (self.missing, self.analysis.note) if words)

    def callback(self, ring: Ring) -> Callable[[npt.NDArray[np.float32], int, Any, Any], None]:
        """What the sound system calls: it copies and stamps, and nothing else."""
        now = self._clock.now

        def heard(block: npt.NDArray[np.float32], _frames: int, _times: Any, _status: Any) -> None:
            ring.write(block, now())

        return heard

    def close(self) -> None:
        """Close the stream, if one is open; a device that hangs is left alone after a while."""
        if self._stream is not None:
            stream, self._stream = self._stream, None
            close_stream(stream)

    def observe(self) -> float | None:
        """Take up when blocks came; returns the time of the last one [s], None if none has come."""
        last = None
        while (stamp := self.ring.stamp()) is not None:
            frame, time = stamp
            self.line.observe(frame, time)
            last = time if last is None else max(last, time)
            rate = self.watch.observe(frame, time)
            if rate is not None:  # it delivers at another rate than it says
                self._listen_at(rate)
        return last

    def events(self, latency: float, now: float) -> Iterator[ControlEvent]:
        """What the analysis finds in the sound not yet read; its times are `latency` [s] before those measured."""
        missed = self.ring.overrun
        sound = self.ring.read()
        if self.ring.overrun != missed:  # the analysis stood still for a second: the sound in between is gone
            self.begin_analysis(self.ring.read_frames - sound.shape[0])
        rate, skipped, line = self.sample_rate, self._skipped, self.line
        with np.errstate(invalid="ignore", over="ignore"):  # bad samples are found and counted
            mono = self.mixer.mix(sound)
        return iter(
            self.analysis.feed(mono[:, None], lambda position: line.time_of(position * rate + skipped) - latency, now)
        )


def open_device(device: SoundDevice, channels: Channels, clock: Clock, analysis: MakeAnalysis) -> Listening:
    """The device, open; PortAudioError or SoundUnavailable if it refuses."""
    listening = Listening(device, channels, clock, analysis)
    listening.open()
    return listening
