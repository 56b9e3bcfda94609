"""AudioInput: a sound device that is listened to: callback → ring → analysis thread → inbox."""

import threading
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.inbox import Inbox
from live.clock.sample_clock import SampleClock
from live.clock.source import Clock
from live.control.audio_analysis import AudioAnalysis
from live.control.events import ControlEvent, SourceChanged
from live.control.sound_devices import SoundDevice, close_stream, find_device, open_stream, refresh

LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the device counts as lost."""

FIRST_SOUND: Final = 3.0
"""Seconds that a device just opened may take until its first callback (sound servers take one or two)."""

RETRY: Final = 2.0
"""Seconds between attempts to open a lost device again."""

POLL: Final = 0.010
BLOCK: Final = 512
RING_SECONDS: Final = 2.0
CHANNELS: Final = 2
STAMPS: Final = 512


class Ring:
    """Sound between two threads: the callback writes, the analysis reads; nobody waits.

    Thread: `write` from the callback only, `read` from one other thread. Each side moves only its own counter.
    """

    def __init__(self, frames: int, channels: int) -> None:
        self._sound = np.zeros((frames, channels), np.float32)
        self._stamp_frame = np.zeros(STAMPS, np.int64)
        self._stamp_time = np.zeros(STAMPS)
        self.written = 0
        """Frames written since the start."""
        self._stamps = 0
        self._stamps_read = 0
        self.read_frames = 0
        """Frames read (or given up) since the start."""
        self.overrun = 0
        """Frames that were overwritten before anybody read them."""

    def write(self, block: npt.NDArray[np.float32], time: float) -> None:
        """Copy a block, shape (n, channels), that was complete at `time` [s]."""
        size = self._sound.shape[0]
        block = block[-size:]
        start = self.written % size
        first = min(size - start, block.shape[0])
        self._sound[start : start + first] = block[:first]
        self._sound[: block.shape[0] - first] = block[first:]
        self.written += block.shape[0]
        self._stamp_frame[self._stamps % STAMPS] = self.written
        self._stamp_time[self._stamps % STAMPS] = time
        self._stamps += 1

    def stamps(self) -> list[tuple[int, float]]:
        """(frames written by then, time [s]) of each block since the last call."""
        until = self._stamps
        since = max(self._stamps_read, until - STAMPS // 2)
        self._stamps_read = until
        return [(int(self._stamp_frame[i % STAMPS]), float(self._stamp_time[i % STAMPS])) for i in range(since, until)]

    def read(self) -> npt.NDArray[np.float32]:
        """All frames not yet read, shape (n, channels), as a copy; what was overwritten counts as `overrun`."""
        size, until = self._sound.shape[0], self.written
        if until - self.read_frames > size // 2:  # the writer may already be at work in the older half
            self.overrun += until - size // 2 - self.read_frames
            self.read_frames = until - size // 2
        block = np.take(self._sound, np.arange(self.read_frames, until) % size, axis=0)
        self.read_frames = until
        return block


class AudioInput:
    """Listens to a device and puts BeatHeard and SourceChanged events into an inbox.

    When no sound arrives for half a second the source is "lost", and the device is opened again, by name, every
    two seconds until it is "found". Samples that are NaN become silence. The device's own sample rate is used.
    """

    def __init__(
        self,
        device: str | int | None,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        latency: float = 0.0,
        source: str = "audio",
    ) -> None:
        """`device` as for `find_device`; `latency` [s] is how long sound takes until it is here (measured by ear).

        Raises SoundUnavailable or UnknownDevice.
        """
        self.device: SoundDevice = find_device(device)
        self.latency = latency
        self.reopened = 0
        """How often the device was opened again."""
        self._inbox = inbox
        self._clock = clock
        self._source = source
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._stream: Any = None
        self._level = 0.0
        self._lost = False
        self._alive_at = self._patience = 0.0
        self._begin_session()

    @property
    def level(self) -> float:
        """RMS of what was heard last, full scale = 1 (for a meter). Thread: any."""
        return self._level

    @property
    def bad_samples(self) -> int:
        """Samples that were no sound (NaN, infinite, absurd) since the device was opened. Thread: any."""
        return self._analysis.tracker.bad_samples

    def start(self) -> None:
        """Open the device and begin to listen; raises sounddevice.PortAudioError if it refuses now."""
        self._open()
        self._stop.clear()
        self._thread = threading.Thread(target=self._listen, name="audio analysis", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End; a device that hangs is left to its thread after two seconds."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def _begin_session(self) -> None:
        """A fresh ring, line and tracker for the device as it is now."""
        channels = min(self.device.channels, CHANNELS)
        self._ring = Ring(int(RING_SECONDS * self.device.sample_rate), channels)
        self._line = SampleClock(self.device.sample_rate)
        self._analysis = AudioAnalysis(self.device.sample_rate, self._source)
        self._skipped = 0

    def _open(self) -> None:
        self._begin_session()
        ring, clock = self._ring, self._clock

        def callback(block: npt.NDArray[np.float32], _frames: int, _times: Any, _status: Any) -> None:
            ring.write(block, clock.now())

        self._stream = open_stream(
            "input",
            device=self.device.index,
            samplerate=self.device.sample_rate,
            blocksize=BLOCK,
            channels=min(self.device.channels, CHANNELS),
            dtype="float32",
            latency="low",
            callback=callback,
        )
        self._alive_at = self._clock.now()
        self._patience = FIRST_SOUND

    def _close(self) -> None:
        if self._stream is not None:
            stream, self._stream = self._stream, None
            close_stream(stream)

    def _listen(self) -> None:
        try:
            while not self._stop.wait(POLL):
                now = self._clock.now()
                if self._stream is None:
                    if now - self._alive_at >= RETRY:
                        self._try_again(now)
                    continue
                self._analyse(now)
                if now - self._alive_at > self._patience:
                    self._lose(now)
        finally:
            self._close()

    def _analyse(self, now: float) -> None:
        stamps = self._ring.stamps()
        for frame, time in stamps:
            self._line.observe(frame, time)
            self._alive_at = max(self._alive_at, time)
        if not stamps:
            return
        self._patience = LOST_AFTER
        if self._lost:
            self._lost = False
            self._put("found", now, self.device.name)
        missed = self._ring.overrun
        block = self._ring.read()
        if self._ring.overrun != missed:  # this thread stood still for a second: the sound in between is gone
            self._analysis = AudioAnalysis(self.device.sample_rate, self._source)
            self._skipped = self._ring.read_frames - block.shape[0]
        rate, skipped = self.device.sample_rate, self._skipped
        for event in self._analysis.feed(
            block, lambda position: self._line.time_of(position * rate + skipped) - self.latency, now
        ):
            self._inbox.put(event)
        self._level = self._analysis.tracker.level

    def _lose(self, now: float) -> None:
        if not self._lost:
            self._lost = True
            self._put("lost", now, self.device.name)
        self._level = 0.0
        self._close()
        self._alive_at = now

    def _try_again(self, now: float) -> None:
        """Look for the device by its name and open it; whatever goes wrong, there is another time."""
        self._alive_at = now
        try:
            refresh()
            self.device = find_device(self.device.name)
            self._open()
        except Exception:  # the sound system is coming and going: no error of its may end the listening
            self._stream = None
            return
        self.reopened += 1

    def _put(self, state: str, time: float, detail: str) -> None:
        self._inbox.put(SourceChanged(time=time, source=self._source, state=state, detail=detail))
