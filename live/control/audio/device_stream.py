"""Audio stream of one open device, from callback through ring buffer and mixer to the analysis."""

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.clock.sample_clock import RateEstimator, SampleClock
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.block_stamps import BlockStamps
from live.control.audio.channel_mixer import ChannelMixer, Channels
from live.control.audio.devices import SoundDevice, close_stream, open_stream
from live.control.events.events import ControlEvent


class RingBuffer:
    """Lock-free ring buffer of frames between two threads, with the time of each block. It allocates nothing.

    Thread: `write` from the callback only, all else from one other thread. Each side writes only its own counters.
    """

    def __init__(self, frames: int, channels: int) -> None:
        self._sound = np.zeros((frames, channels), np.float32)
        self._out = np.zeros((frames // 2, channels), np.float32)
        self.stamps = BlockStamps()
        """Frames written and the time of each block."""
        self.longest = frames // 2
        """Maximum frames of one `read`."""
        self.written = 0
        """Frames written since the start."""
        self.read_frames = 0
        """Frames read or skipped since the start."""
        self.overrun = 0
        """Frames overwritten before they were read."""

    def write(self, block: npt.NDArray[np.float32], time: float) -> None:
        """Copy a block, shape (n, channels), completed at `time` [s]; of a block that is too long the end is kept."""
        size = self._sound.shape[0]
        if block.shape[0] > size:
            self.written += block.shape[0] - size
            block = block[-size:]
        start = self.written % size
        first = min(size - start, block.shape[0])
        self._sound[start : start + first] = block[:first]
        self._sound[: block.shape[0] - first] = block[first:]
        self.written += block.shape[0]
        self.stamps.add(self.written, time)

    def read(self) -> npt.NDArray[np.float32]:
        """Return all unread frames, shape (n, channels), valid until the next call.

        At most half the buffer, as the writer may be overwriting the older half; lost frames are counted in `overrun`.
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
"""Rates [Hz] to try when a device refuses its own."""


class DeviceStream:
    """Stream of one device with its analysis; made by `open_device`.

    Thread: the callback writes into the ring; everything else belongs to one other thread.
    """

    def __init__(self, device: SoundDevice, channels: Channels, clock: Clock, analysis: MakeAnalysis) -> None:
        chosen = channels.select(device.channels)
        self.device = device
        self.opened_channels = max(chosen) + 1
        """Channels requested from the device: up to the last selected one."""
        self.missing = channels.missing(device.channels)
        """Description of the requested channels that the device lacks; empty if it has all."""
        self._clock = clock
        self._make_analysis = analysis
        self._chosen = chosen
        self._stream: Any = None
        self.sample_rate = device.sample_rate
        self.ring: RingBuffer
        self.rate_watch: RateEstimator
        self.sample_clock: SampleClock
        self.mixer: ChannelMixer
        self.analysis: AudioAnalysis

    def reset(self, sample_rate: float) -> None:
        """Make a new ring, line, mixer and analysis for this rate [Hz]; called by `open`."""
        self.ring = RingBuffer(int(RING_SECONDS * sample_rate), self.opened_channels)
        self.rate_watch = RateEstimator(sample_rate)
        self._set_rate(sample_rate)

    def _set_rate(self, sample_rate: float) -> None:
        """Make a new line, mixer and analysis; the ring is kept, as the callback writes into it."""
        self.sample_rate = sample_rate
        self.sample_clock = SampleClock(sample_rate)
        self.mixer = ChannelMixer(self._chosen, sample_rate, self.ring.longest)
        self.begin_analysis(self.ring.read_frames)

    def begin_analysis(self, frame: int) -> None:
        """Make a new analysis that starts at frame number `frame`."""
        self.analysis = self._make_analysis(self.sample_rate)
        self._skipped = frame

    def open(self) -> None:
        """Open the stream; PortAudioError (or SoundUnavailable) if the device refuses."""
        refusal: Exception | None = None
        for rate in dict.fromkeys((self.device.sample_rate, *OTHER_RATES)):
            self.reset(rate)
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
            except Exception as error:  # PortAudioError, whose class exists only with PortAudio
                refusal = refusal or error
                if "sample rate" not in str(error).lower():
                    raise
                continue
            opened = float(getattr(self._stream, "samplerate", rate))
            if opened != rate and 0.0 < opened < 1e6:  # it opened, but at another rate
                self.rate_watch = RateEstimator(opened)
                self._set_rate(opened)
            return
        assert refusal is not None
        raise refusal

    @property
    def problem(self) -> str:
        """Description of deviations from the request (missing channels, another tracker); empty if none."""
        return "; ".join(words for words in (self.missing, self.analysis.note) if words)

    def callback(self, ring: RingBuffer) -> Callable[[npt.NDArray[np.float32], int, Any, Any], None]:
        """Return the callback for the sound system, which only copies and stamps a block."""
        now = self._clock.now

        def heard(block: npt.NDArray[np.float32], _frames: int, _times: Any, _status: Any) -> None:
            ring.write(block, now())

        return heard

    def close(self) -> None:
        """Close the stream, if one is open; a hung device is abandoned after a while."""
        if self._stream is not None:
            stream, self._stream = self._stream, None
            close_stream(stream)

    def update_clock(self) -> float | None:
        """Update the sample line from new block times; return the last one's time [s], None if there is none."""
        last = None
        while (stamp := self.ring.stamps.pop()) is not None:
            frame, time = stamp
            self.sample_clock.observe(frame, time)
            last = time if last is None else max(last, time)
            rate = self.rate_watch.observe(frame, time)
            if rate is not None:  # it delivers at another rate than it reports
                self._set_rate(rate)
        return last

    def events(self, latency: float, now: float) -> Iterator[ControlEvent]:
        """Return the events found in the unread sound; their times are corrected by `latency` [s]."""
        missed = self.ring.overrun
        sound = self.ring.read()
        if self.ring.overrun != missed:  # the analysis was blocked for a second and the sound in between is lost
            self.begin_analysis(self.ring.read_frames - sound.shape[0])
        rate, skipped, line = self.sample_rate, self._skipped, self.sample_clock
        with np.errstate(invalid="ignore", over="ignore"):  # bad samples are detected and counted
            mono = self.mixer.mix(sound)
        return iter(
            self.analysis.feed(mono[:, None], lambda position: line.time_of(position * rate + skipped) - latency, now)
        )


def open_device(device: SoundDevice, channels: Channels, clock: Clock, analysis: MakeAnalysis) -> DeviceStream:
    """Open a device; PortAudioError or SoundUnavailable if it refuses."""
    listening = DeviceStream(device, channels, clock, analysis)
    listening.open()
    return listening
