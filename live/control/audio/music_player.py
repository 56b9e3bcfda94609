"""MusicPlayer: plays music and follows exactly what is heard of it at this moment."""

import threading
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.event_queue import Inbox
from live.base.fault_isolation import keep_running
from live.clock.sample_clock import SampleClock
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.devices import SoundUnavailable, close_stream, find_device, open_stream
from live.control.audio.music_file import TOLD_AHEAD, Music
from live.control.events.events import BeatHeard, ControlEvent, One, SourceChanged

POLL: Final = 0.010
LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the output counts as gone."""

FIRST_SOUND: Final = 3.0
"""Seconds after the start in which a sound server may still fill its buffers and then pause."""

STEADY_AFTER: Final = 1.0
"""Seconds after which it can be said when a sample will be heard, if the server does not pause again;"""
ONE_OFF: Final = 0.02
"""what was said is said anew if it was wrong by so much [s]."""

STAMPS: Final = 512
CATCH_UP: Final = 1.0
"""A stall longer than this [s] is not analysed afterwards, but left out."""

ANEW_AFTER: Final = 1.0
"""Seconds after a failure of the analysis until it is begun anew."""


class MusicPlayer:
    """Plays through a sound output if there is one, else silently by the clock; events are the same either way.

    If the output goes away the music runs on unheard: the dancers do not stop because a cable came loose.
    """

    def __init__(
        self,
        music: Music,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        loop: bool = True,
        output: bool | str | int = True,
        latency: float | None = None,
        one_at: float | None = None,
        analysis: MakeAnalysis = AudioAnalysis,
    ) -> None:
        """`output`: True = the default device, False = none, else as for `find_device`.

        `one_at` [s of the music] is the first downbeat, where that is known: it is told as One, TOLD_AHEAD before, or
        as soon as it is known when it is heard; and once more with the first beat after it, if that has changed.

        `latency` [s]: from a sample handed over until it is heard; None: what the device says.
        Raises UnknownDevice for an output that was named and is not there.
        """
        self._music = music
        self._inbox = inbox
        self._clock = clock
        self._loop = loop
        self.latency = latency
        """From a sample handed over until it is heard [s], None: what the device says; it may be changed meanwhile."""
        self._one_at = one_at
        self._one_told: float | None = None
        self.output_problem = ""
        """Why the music is not heard; empty if it is."""
        self.crashes = 0
        """How often the analysis failed and was begun anew ..."""
        self.failure = ""
        """... and the last failure in words."""
        self.ended = False
        """Whether the music is over (never, if it loops)."""
        self._device = self._find(output)
        self._stream: Any = None
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._line = SampleClock(music.sample_rate)
        self._stamp_frame = np.zeros(STAMPS, np.int64)
        self._stamp_time = np.zeros(STAMPS)
        self._stamps = self._stamps_read = self._played = self._fed = 0
        self._begin = self._alive_at = self._reported = 0.0
        self._make_analysis = analysis
        self._analysis = analysis(music.sample_rate)
        if one_at is not None:
            self._analysis.know_one(one_at)
        self._skipped = 0
        self._anew_at: float | None = None

    @property
    def audible(self) -> bool:
        """Whether an output plays the music. Thread: any."""
        return self._stream is not None

    @property
    def _delay(self) -> float:
        """From a sample handed over until it is heard [s]."""
        return self._reported if self.latency is None else self.latency

    def facts(self) -> dict[str, Any]:
        """What the operator is told of the output, for the status. Thread: any."""
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
        """Play from the beginning, or go on with what `begun` [s] then, unheard since.

        An output that refuses is no error: see `output_problem`.
        """
        now = self._alive_at = self._clock.now()
        self._begin = now if begun is None else begun
        self._played = max(int((now - self._begin) * self._music.sample_rate), 0)
        if self._device is not None:
            self._open()
        self._stop.clear()
        self._thread = threading.Thread(target=self._run, name="music analysis", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop playing."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def position(self, time: float) -> float:
        """Seconds of the music heard until `time` [s], not less than 0; it goes on counting in loops. Thread: any."""
        if self._stream is None or self._stamps_read < 1:
            return max(time - self._begin, 0.0)
        # What was never handed to the device is not heard, wherever the line points while a server fills its buffers.
        return min(max(self._line.frame_at(time - self._delay), 0.0), float(self._played)) / self._music.sample_rate

    def _find(self, output: bool | str | int) -> Any:
        if output is False:
            self.output_problem = "no output was asked for"
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
            # Stamped first: the callback asks for `frames` more when those before have been handed over.
            slot = self._stamps % STAMPS
            self._stamp_frame[slot], self._stamp_time[slot] = self._played, self._clock.now()
            self._stamps += 1
            block = self._music.block(self._played, frames, self._loop)
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
        except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
            self.output_problem = f"{self._device.name} does not play: {error}"
            return
        reported = float(self._stream.latency)
        self._reported = reported if 0.0 <= reported <= 1.0 else 0.0  # some hosts report nonsense

    def _run(self) -> None:
        try:
            keep_running("the music's player", self._turns, self._stop.wait)
        finally:
            self._close()

    def _turns(self) -> None:
        while not self._stop.wait(POLL):
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
        until = self._stamps
        for index in range(max(self._stamps_read, until - STAMPS // 2), until):
            time = float(self._stamp_time[index % STAMPS])
            self._line.observe(float(self._stamp_frame[index % STAMPS]), time)
            self._alive_at = max(self._alive_at, time)
        self._stamps_read = until
        if now - self._alive_at > (LOST_AFTER if now - self._begin > FIRST_SOUND else FIRST_SOUND):
            self._begin = now - self.position(now)
            self._close()
            self.output_problem = f"{self._device.name} went away; the music runs on unheard"
            for state in ("lost", "found"):
                self._inbox.put(SourceChanged(time=now, source="audio", state=state, detail=self.output_problem))

    def _analyse_safely(self, now: float) -> None:
        """Analyse; when that fails the music plays on, and what is heard a second later is analysed anew."""
        if self._anew_at is not None and now < self._anew_at:
            return
        try:
            self._analyse(now)
        except Exception as error:
            self.crashes += 1
            self.failure = f"the analysis failed: {type(error).__name__}: {error}"
            self._anew_at = now + ANEW_AFTER

    def _analyse(self, now: float) -> None:
        if self.ended:
            return
        rate = self._music.sample_rate
        wanted = int(self.position(now) * rate)
        if wanted - self._fed > CATCH_UP * rate or self._anew_at is not None:
            self._anew_at = None
            self._fed = self._skipped = wanted
            self._analysis = self._make_analysis(rate)
        if wanted <= self._fed:
            return
        block = self._music.block(self._fed, wanted - self._fed, self._loop)
        self._fed = wanted
        self._tell_one(now, heard=False)
        for event in self._analysis.feed(block, self._time_of, now):
            if isinstance(event, BeatHeard):
                self._tell_one(now, heard=True)
            self._inbox.put(event)
        if not self._loop and self._fed >= self._music.samples.shape[0]:
            self.ended = True
            self._inbox.put(SourceChanged(time=now, source="audio", state="silent", detail="the music is over"))

    def _tell_one(self, now: float, *, heard: bool) -> None:
        """When the known downbeat will be heard, before the score begins with it; `heard`: a beat was."""
        if self._one_at is None:
            return
        position = self.position(now)
        time = self._time_of(self._one_at - self._skipped / self._music.sample_rate)
        if self._one_told is None:
            if position < self._one_at - TOLD_AHEAD or (self._stream is not None and now - self._begin < STEADY_AFTER):
                return
        elif not heard or position < self._one_at:
            return
        else:
            self._one_at = None  # that was the last word
        if self._one_told is None or abs(time - self._one_told) > ONE_OFF:
            self._inbox.put(One(time=time, source="audio"))
        self._one_told = time

    def _time_of(self, position: float) -> float:
        frame = position * self._music.sample_rate + self._skipped
        if self._stream is None:
            return self._begin + frame / self._music.sample_rate
        return self._line.time_of(frame) + self._delay
