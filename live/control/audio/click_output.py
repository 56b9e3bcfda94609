"""Click output: plays a click on every beat of the Timeline, on a separate audio output for the performers."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32
from live.base.errors import PersonError
from live.clock.sample_clock import SampleClock
from live.clock.time_source import Clock
from live.clock.timeline import Timeline, phase
from live.control.audio.block_stamps import BlockStamps
from live.control.audio.channel_mixer import Channels
from live.control.audio.devices import SoundDevice, close_stream, find_again, find_device, open_stream, refresh
from live.control.worker_thread import WorkerThread

MAX_LATE: Final = 0.040
"""A beat up to this late [s] for a block is clicked at the block's start; an older one is skipped."""

MAX_BEAT_JUMP: Final = 1.5
"""If the next beat differs from the Timeline's by more than this [beats], counting restarts."""


class ClickTrack:
    """Fills mono blocks with one click per beat, even if the Timeline jumps; it never goes back.

    During a count-in, the accents follow the counted measures, and the click sounds even if it is off. Thread: `fill`
    in the callback, without allocation; `show` and `on` in one other.
    """

    def __init__(self, accent: Float32, beat: Float32, *, on: bool = True) -> None:
        """`accent` and `beat`: the sounds of a measure's first beat and of all others, mono, full scale 1."""
        self.voices = (accent, beat)
        """Accent and beat; changed only while nothing is playing."""
        self._timeline: tuple[Timeline, float] | None = None
        self._sounding: Float32 = beat
        self._played = len(beat)
        self._next: int | None = None
        self.on = on
        """False: clicks only during a count-in."""
        self.clicks = 0
        """Clicks since the start."""
        self.missed = 0
        """Beats known too late to be clicked."""

    def set_timeline(self, timeline: Timeline, one: float = -math.inf) -> None:
        """Set the Timeline; `one`: the beat at which a count-in ends, if there is one."""
        self._timeline = (timeline, one)

    def fill(self, out: Float32, begin: float, seconds: float) -> None:
        """Fill a block, shape (n,), that is heard from `begin` on [s of the show] and lasts `seconds`."""
        out[:] = 0.0
        self._continue_click(out, 0)
        shown = self._timeline
        if shown is None:
            return
        timeline, one = shown
        first = timeline.beat_at(begin)
        if self._next is None or abs(self._next - first) > MAX_BEAT_JUMP:
            self._next = math.ceil(first)
        end = timeline.beat_at(begin + seconds)
        while self._next < end:
            number, self._next = self._next, self._next + 1
            late = begin - timeline.time_at(number)
            if late > MAX_LATE:
                self.missed += 1
            elif self.on or number <= one:
                self._start_click(out, number, timeline, one, max(-late, 0.0) / seconds)

    def _start_click(self, out: Float32, number: int, timeline: Timeline, one: float, share: float) -> None:
        """Start a click at this `share` of the block."""
        origin = one if number <= one else timeline.measure_origin
        accented = phase(number - origin, timeline.beats_per_measure) == 0.0
        self._sounding, self._played = self.voices[0 if accented else 1], 0
        self.clicks += 1
        self._continue_click(out, min(round(share * out.shape[0]), out.shape[0] - 1))

    def _continue_click(self, out: Float32, start: int) -> None:
        """Continue the present click in the block from frame `start` on."""
        count = min(out.shape[0] - start, len(self._sounding) - self._played)
        if count > 0:
            part = out[start : start + count]
            np.add(part, self._sounding[self._played : self._played + count], out=part)
            self._played += count


MakeVoices = Callable[[int], tuple[Float32, Float32]]
"""Factory, for a sample rate [Hz], of the sounds of a measure's first beat and of the others."""

POLL: Final = 0.010
LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the output counts as lost …"""

START_TIMEOUT: Final = 3.0
"""… and the same after opening (sound servers fill their buffers and pause)."""

RETRY: Final = 2.0
"""Seconds between attempts to reopen it."""

SETTLED: Final = 1.0
"""Clicks start when the line fitted through the callbacks was stable for this many seconds of samples and of time …"""

STEADY: Final = 0.020
"""… within this tolerance [s]. A sound server may request samples at once, and then pause for two seconds."""

BUFFER_SECONDS: Final = 0.080
"""Buffer requested from the device [s]: a callback may be this late without a dropout."""

MAX_BLOCK: Final = 16384
"""Maximum frames of a block; any further requested frames stay silent."""


class ClickOutput:
    """Plays a ClickTrack. A lost output is reopened by name; the show never waits for it.

    The time of a sample is the sum of a line fitted through the callbacks' times against their sample counts (as for
    music), the device's reported latency, and `extra_delay`, which is set by ear or by measurement.
    """

    def __init__(
        self,
        device: str | int | None,
        clock: Clock,
        voices: MakeVoices,
        *,
        channels: Channels = Channels(),  # noqa: B008 - frozen
        extra_delay: float = 0.0,
        on: bool = True,
    ) -> None:
        """`device` as for `find_device`; `extra_delay` [s]: additional delay beyond the device's reported latency.

        Raises SoundUnavailable or UnknownDevice, and PersonError if the device lacks the channels.
        """
        self.device: SoundDevice = find_device(device, "output")
        missing = channels.missing(self.device.channels)
        if missing:
            raise PersonError(f"{self.device.name}: {missing}", "choose others, see `live devices`")
        self.extra_delay = extra_delay
        """Additional delay [s]; it may be changed at any time."""
        self.problem = ""
        """Description of why nothing clicks; empty if it does."""
        self.reopened = 0
        """Number of times the output was reopened."""
        self._make_voices = voices
        self._rate = self.device.sample_rate
        self.track = ClickTrack(*voices(round(self._rate)), on=on)
        self._clock = clock
        self._wanted = channels
        self._channels = channels.select(self.device.channels)
        self._block = np.zeros(MAX_BLOCK, np.float32)
        self._stream: Any = None
        self._worker = WorkerThread("click", self.poll, part="the click", every=POLL, end=self._close)
        self._reported = 0.0
        self._opened_at = self._alive_at = -math.inf
        self._reset()

    def set_timeline(self, timeline: Timeline, one: float = -math.inf) -> None:
        """Set the Timeline and the beat at which a count-in ends, if any; called each frame."""
        self.track.set_timeline(timeline, one)

    def status(self) -> dict[str, Any]:
        """Return facts for the operator's status. Thread: any."""
        return {
            "device": self.device.name,
            "state": "open" if self._stream is not None else "lost",
            "on": self.track.on,
            "latency_ms": round(1000.0 * self.delay, 2),
            "clicks": self.track.clicks,
            "missed": self.track.missed,
            "reopened": self.reopened,
            "problem": self.problem,
        }

    @property
    def delay(self) -> float:
        """Delay from handing over a sample until it is heard [s]."""
        return self._reported + self.extra_delay

    def start(self) -> None:
        """Open the output and start; raises sounddevice.PortAudioError if it refuses now."""
        self.open()
        self._worker.start()

    def stop(self) -> None:
        """Stop the click and close the output."""
        self._worker.stop()

    def _reset(self) -> None:
        """Reset all state that depends on the present device."""
        if self._rate != self.device.sample_rate:
            self._rate = self.device.sample_rate
            self.track.voices = self._make_voices(round(self._rate))
        self._channels = self._wanted.select(self.device.channels)
        self._line = SampleClock(self._rate)
        self._stamps = BlockStamps()
        self._frames_requested = 0
        self._place: tuple[float, float] | None = None  # time at which frame 0 is handed over, and seconds per frame
        self._steady: tuple[float, float, float] | None = None  # the line's offset, valid since which sample and time

    def open(self) -> None:
        """Open the output; called by `start` and by its thread."""
        self._reset()
        self._stream = open_stream(
            "output",
            device=self.device.index,
            samplerate=self._rate,
            channels=max(self._channels) + 1,
            dtype="float32",
            latency=BUFFER_SECONDS,
            callback=self._callback,
        )
        reported = float(self._stream.latency)
        self._reported = reported if 0.0 <= reported <= 1.0 else 0.0  # some hosts report nonsense
        self._opened_at = self._alive_at = self._clock.now()

    def _callback(self, out: npt.NDArray[np.float32], frames: int, _times: Any, _status: Any) -> None:
        self._stamps.add(self._frames_requested, self._clock.now())
        out[:] = 0.0
        place = self._place
        if place is not None:
            block = self._block[: min(frames, MAX_BLOCK)]
            begin = place[0] + self._frames_requested * place[1] + self.delay
            self.track.fill(block, begin, block.shape[0] * place[1])
            for channel in self._channels:
                out[: block.shape[0], channel] = block
        self._frames_requested += frames

    def poll(self) -> None:
        """Update the sample line and check the output once; never raises. Thread: the click's."""
        now = self._clock.now()
        if self._stream is not None:
            try:
                self._watch(now)
            except Exception as error:  # the output is reopened, and the click's thread continues
                self._lose(now, f"the click failed: {type(error).__name__}: {error}")
        elif now - self._alive_at >= RETRY:
            self._reopen(now)

    def _watch(self, now: float) -> None:
        while (stamp := self._stamps.pop()) is not None:
            self._line.observe(*stamp)
            self._alive_at = max(self._alive_at, stamp[1])
        if self._stamps.popped:
            self._place_samples()
        patience = LOST_AFTER if now - self._opened_at > START_TIMEOUT else START_TIMEOUT
        if now - self._alive_at > patience:
            self._lose(now, f"{self.device.name} went away")

    def _place_samples(self) -> None:
        """Set the samples' time once it is known."""
        asked = float(self._frames_requested)
        handed_over = self._line.time_of(asked)
        lies = handed_over - asked / self._rate
        if self._steady is None or abs(lies - self._steady[0]) > STEADY:
            self._steady = (lies, asked, self._alive_at)
        _, since, then = self._steady
        if self._place is not None or min((asked - since) / self._rate, self._alive_at - then) >= SETTLED:
            step = (self._line.time_of(asked + self._rate) - handed_over) / self._rate
            self._place = (handed_over - asked * step, step)

    def _lose(self, now: float, why: str) -> None:
        self.problem, self._alive_at = why, now
        self._close()

    def _close(self) -> None:
        if self._stream is not None:
            stream, self._stream = self._stream, None
            close_stream(stream)

    def _reopen(self, now: float) -> None:
        """Look for the output by name and open it; after any failure, try again later."""
        self._alive_at = now
        try:
            refresh()
            self.device = find_again(self.device, "output")
            self.open()
        except Exception as error:  # errors of an unstable sound system must not end the click
            self._stream = None
            self.problem = str(error)
            return
        self.problem = self._wanted.missing(self.device.channels)
        self.reopened += 1
