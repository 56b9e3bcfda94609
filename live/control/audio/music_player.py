"""Music player with analysis in sync with the audible position."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.event_queue import EventQueue
from live.clock.sample_clock import SampleClock
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.block_stamps import BlockStamps
from live.control.audio.devices import SoundUnavailable, close_stream, find_device, open_stream
from live.control.audio.music_file import DOWNBEAT_LEAD, Music
from live.control.events.events import BeatHeard, ControlEvent, One, SourceChanged
from live.control.worker_thread import WorkerThread

POLL: Final = 0.010
LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the output counts as lost."""

START_TIMEOUT: Final = 3.0
"""Seconds after the start in which a sound server may fill its buffers and pause."""

SETTLE_SECONDS: Final = 1.0
"""Seconds until a sample's time can be predicted, if the server does not pause again."""
DOWNBEAT_TOLERANCE: Final = 0.02
"""The prediction is repeated if it was wrong by this much [s]."""

CATCH_UP: Final = 1.0
"""Sound missed in a stall longer than this [s] is not analysed."""

RESTART_AFTER: Final = 1.0
"""Seconds from a failure of the analysis to its restart."""


class MusicPlayer:
    """Plays through an audio output if there is one, else silently by the clock; the events are the same.

    If the output is lost, the music continues silently, so that the dancers do not stop for a loose cable.
    """

    def __init__(
        self,
        music: Music,
        inbox: EventQueue[ControlEvent],
        clock: Clock,
        *,
        output: bool | str | int = True,
        latency: float | None = None,
        one_at: float | None = None,
        begun: float | None = None,
        analysis: MakeAnalysis = AudioAnalysis,
    ) -> None:
        """`output`: True = the default device, False = none, else as for `find_device`.

        `one_at` [s of the music]: the first downbeat, if known. It is announced as One DOWNBEAT_LEAD seconds before, or
        as soon as its time is known; and once more with the first beat after it, if the time has changed.

        `begun` [s]: when music that goes on has begun; None: it begins with `start`.

        `latency` [s]: delay from handing over a sample until it is heard; None: the device's reported latency. Raises
        UnknownDevice for a named output that is absent.
        """
        self._music = music
        self._inbox = inbox
        self._clock = clock
        self.latency = latency
        """Delay from handing over a sample until it is heard [s]; None: the device's. It may be changed at any time."""
        self._one_at = one_at
        self._announced_downbeat: float | None = None
        self.output_problem = ""
        """Description of why the music is not audible; empty if it is."""
        self.crashes = 0
        """Number of times the analysis failed and was restarted …"""
        self.failure = ""
        """… and the latest failure."""
        self._device = self._find(output)
        self._stream: Any = None
        self._worker = WorkerThread(
            "music analysis", self._poll, part="the music's player", every=POLL, end=self._close
        )
        self._line = SampleClock(music.sample_rate)
        self._stamps = BlockStamps()
        self._played = self._fed = 0
        self.began = begun
        """When the music began [s]; None before it does."""
        self._begin = self._alive_at = self._reported = 0.0
        self._make_analysis = analysis
        self._analysis = analysis(music.sample_rate)
        if one_at is not None:
            self._analysis.set_downbeat(one_at)
        self._skipped = 0
        self._restart_at: float | None = None

    @property
    def audible(self) -> bool:
        """Whether an output plays the music. Thread: any."""
        return self._stream is not None

    @property
    def _delay(self) -> float:
        """Delay from handing over a sample until it is heard [s]."""
        return self._reported if self.latency is None else self.latency

    def status(self) -> dict[str, Any]:
        """Return facts on the output for the operator's status. Thread: any."""
        return {
            "device": None if self._device is None else self._device.name,
            "sample_rate": self._music.sample_rate,
            "state": "open" if self.audible else "unheard",
            "latency_ms": round(1000.0 * self._delay, 2),
            "problem": self.output_problem,
            "crashes": self.crashes,
            "failure": self.failure,
            "note": self._analysis.note,
        }

    def start(self, begun: float | None = None) -> None:
        """Play from the beginning, or continue silently elapsed music that began at `begun` [s].

        An output that refuses is no error: see `output_problem`.
        """
        now = self._alive_at = self._clock.now()
        begun = self.began if begun is None else begun
        self._begin = self.began = now if begun is None else begun
        self._played = max(int((now - self._begin) * self._music.sample_rate), 0)
        if self._device is not None:
            self._open()
        self._worker.start()

    def stop(self) -> None:
        """Stop playing."""
        self._worker.stop()

    def position(self, time: float) -> float:
        """Return the seconds of music heard until `time` [s], at least 0; in loops it keeps counting. Thread: any."""
        if self._stream is None or not self._stamps.popped:
            return max(time - self._begin, 0.0)
        # Limited to samples handed to the device: the line is unreliable while a server fills its buffers.
        return min(max(self._line.frame_at(time - self._delay), 0.0), float(self._played)) / self._music.sample_rate

    def _find(self, output: bool | str | int) -> Any:
        if output is False:
            self.output_problem = "no output was requested"
            return None
        try:
            return find_device(None if output is True else output, "output")
        except SoundUnavailable as error:
            self.output_problem = str(error)
        except ValueError as error:
            if output is not True:
                raise
            self.output_problem = str(error)
        return None

    def _open(self) -> None:
        channels = self._music.samples.shape[1]
        played = min(channels, self._device.channels)

        def callback(out: npt.NDArray[np.float32], frames: int, _times: Any, _status: Any) -> None:
            # Stamped first: the callback requests `frames` more once the previous ones are handed over.
            self._stamps.add(self._played, self._clock.now())
            block = self._music.block(self._played, frames)
            out[: block.shape[0]] = block[:, :played]
            out[block.shape[0] :] = 0.0
            self._played += frames

        try:
            self._stream = open_stream(
                "output",
                device=self._device.index,
                samplerate=self._music.sample_rate,
                channels=played,
                dtype="float32",
                latency="high",
                callback=callback,
            )
        except Exception as error:  # PortAudioError, whose class exists only with PortAudio
            self.output_problem = f"{self._device.name} does not play: {error}"
            return
        reported = float(self._stream.latency)
        self._reported = reported if 0.0 <= reported <= 1.0 else 0.0  # some hosts report nonsense

    def _poll(self) -> None:
        now = self._clock.now()
        self._follow_output(now)
        self._analyse_safely(now)

    def _close(self) -> None:
        if self._stream is not None:
            stream, self._stream = self._stream, None
            close_stream(stream)

    def _follow_output(self, now: float) -> None:
        if self._stream is None:
            return
        while (stamp := self._stamps.pop()) is not None:
            self._line.observe(*stamp)
            self._alive_at = max(self._alive_at, stamp[1])
        if now - self._alive_at > (LOST_AFTER if now - self._begin > START_TIMEOUT else START_TIMEOUT):
            self._begin = now - self.position(now)
            self._close()
            self.output_problem = f"{self._device.name} was lost; the music continues silently"
            for state in ("lost", "found"):
                self._inbox.put(SourceChanged(time=now, source="audio", state=state, detail=self.output_problem))

    def _analyse_safely(self, now: float) -> None:
        """Analyse; after a failure the music plays on, and analysis restarts a second later."""
        if self._restart_at is not None and now < self._restart_at:
            return
        try:
            self._analyse(now)
        except Exception as error:
            self.crashes += 1
            self.failure = f"the analysis failed: {type(error).__name__}: {error}"
            self._restart_at = now + RESTART_AFTER

    def _analyse(self, now: float) -> None:
        rate = self._music.sample_rate
        wanted = int(self.position(now) * rate)
        if wanted - self._fed > CATCH_UP * rate or self._restart_at is not None:
            self._restart_at = None
            self._fed = self._skipped = wanted
            self._analysis = self._make_analysis(rate)
            self._analysis.origin = self._skipped / rate
        if wanted <= self._fed:
            return
        block = self._music.block(self._fed, wanted - self._fed)
        self._fed = wanted
        self._announce_downbeat(now, heard=False)
        for event in self._analysis.feed(block, self._time_of, now):
            if isinstance(event, BeatHeard):
                self._announce_downbeat(now, heard=True)
            self._inbox.put(event)

    def _announce_downbeat(self, now: float, *, heard: bool) -> None:
        """Announce the time of the known downbeat before it is heard; `heard`: a beat was heard."""
        if self._one_at is None:
            return
        position = self.position(now)
        time = self._time_of(self._one_at - self._skipped / self._music.sample_rate)
        if self._announced_downbeat is None:
            if position < self._one_at - DOWNBEAT_LEAD or (
                self._stream is not None and now - self._begin < SETTLE_SECONDS
            ):
                return
        elif not heard or position < self._one_at:
            return
        else:
            self._one_at = None  # this was the final announcement
        if self._announced_downbeat is None or abs(time - self._announced_downbeat) > DOWNBEAT_TOLERANCE:
            self._inbox.put(One(time=time, source="audio"))
        self._announced_downbeat = time

    def _time_of(self, position: float) -> float:
        frame = position * self._music.sample_rate + self._skipped
        if self._stream is None:
            return self._begin + frame / self._music.sample_rate
        return self._line.time_of(frame) + self._delay
