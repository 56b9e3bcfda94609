"""MidiInput: one MIDI port: clock, time code and what hands and feet do, into the inbox.

rtmidi's thread stamps what arrives and hands it over; a thread of ours decodes, looks whether the port is still there,
and opens it again by name.
"""

import contextlib
import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any, Final

from live.base.inbox import Inbox
from live.clock.midi_clock import ClockBeat, ClockState, MidiClock, News
from live.clock.source import Clock
from live.clock.time_code import TimeCodeClock
from live.control.events import BeatHeard, ControlEvent, SourceChanged
from live.control.midi_map import MidiMap
from live.control.midi_ports import OpenPort, open_port
from live.control.rejections import Rejection

RETRY: Final = 2.0
"""Seconds between two attempts to open a port that is not there, and between two looks whether it still is."""

WAITS: Final = 0.05
"""Seconds after which the decoding thread looks at the time though nothing came."""

WAITING_MAX: Final = 4096
"""Messages that may wait to be decoded; more are counted and dropped."""

Open = Callable[[str], OpenPort]


def _open_input(name: str) -> OpenPort:
    return open_port("input", name)


class MidiInput:
    """Listens to a port by name and puts BeatHeard, SourceChanged and the map's events into the inbox."""

    def __init__(
        self,
        name: str,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        decoder: MidiClock | None = None,
        time_code: TimeCodeClock | None = None,
        midi_map: MidiMap | None = None,
        open_by_name: Open = _open_input,
    ) -> None:
        """Nothing is opened yet. `open_by_name` raises whatever it likes where there is no such port (yet)."""
        self.name = name
        self.connected = ""
        """The whole name of the port that is open; empty while there is none."""
        self.problem = ""
        """Why no port is open."""
        self.reopened = 0
        self.messages = 0
        self.dropped = 0
        """Messages that waited too long."""
        self.failed = 0
        """Messages, and looks at the time, that a decoder failed at ..."""
        self.failure = ""
        """... and the last failure in words."""
        self.last_rejection: Rejection | None = None
        """What the map last refused."""
        self.decoder = decoder if decoder is not None else MidiClock()
        self.time_code = time_code
        self._counted = 0
        self._map = midi_map
        self._inbox = inbox
        self._clock = clock
        self._open_by_name = open_by_name
        self._arrived: queue.SimpleQueue[tuple[float, Sequence[int]]] = queue.SimpleQueue()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._port: OpenPort | None = None

    @property
    def beats_per_measure(self) -> int:
        """Beats of a measure; MIDI does not tell."""
        return self.decoder.beats_per_measure

    @beats_per_measure.setter
    def beats_per_measure(self, beats: int) -> None:
        self.decoder.beats_per_measure = beats
        if self.time_code is not None:
            self.time_code.beats_per_measure = beats

    def start(self) -> None:
        """Begin; a port that is not there is waited for."""
        self._stop.clear()
        self._thread = threading.Thread(target=self._run, name=f"midi in {self.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End; a port that hangs is left to its thread after two seconds."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        train = self.decoder.train
        return {
            "port": self.connected or self.name,
            "problem": self.problem,
            "messages": self.messages,
            "bad": self.decoder.rejected + self.dropped + self.failed,
            "failure": self.failure,
            "lost_clocks": train.lost,
            "clock_noise_ms": round(1e3 * train.curve.noise, 2) if train.curve.count else None,
        }

    def take_map(self, midi_map: MidiMap) -> None:
        """Notes and controllers do something else from now on. Thread: any."""
        self._map = midi_map

    def receive(self, message: Sequence[int]) -> None:
        """A message arrived. Thread: any; never blocks."""
        now = self._clock.now()
        if self._arrived.qsize() >= WAITING_MAX:
            self.dropped += 1
            return
        self._arrived.put((now, message))

    def decode(self, message: Sequence[int], time: float) -> None:
        """Decode one message that arrived at `time` [s of the show]. Thread: ours, or a test's."""
        self.messages += 1
        self._put("midi", self.decoder.receive(message, time))
        if self.time_code is not None:
            self._put("mtc", self.time_code.receive(message, time))
        if self._map is None:
            return
        for made in self._map.events(message, time):
            if isinstance(made, Rejection):
                self.last_rejection = made
            else:
                self._inbox.put(made)

    def _decode_safely(self, message: Sequence[int], time: float) -> None:
        """Decode; a message that no decoder foresaw is counted, and the show goes on."""
        try:
            self.decode(message, time)
        except Exception as error:
            self._fail(" ".join(f"{byte:02x}" for byte in message[:8]), error)

    def _fail(self, where: str, error: Exception) -> None:
        self.failed += 1
        self.failure = f"{where}: {type(error).__name__}: {error}"

    def _look_safely(self, now: float) -> None:
        """Look; a decoder that fails at it is counted, and its port is listened to on."""
        try:
            self.look(now)
        except Exception as error:
            self._fail("nothing came", error)

    def look(self, now: float) -> None:
        """What is known at `now` because nothing came."""
        self._put("midi", self.decoder.advance(now))
        if self.time_code is not None:
            self._put("mtc", self.time_code.advance(now))

    def _put(self, source: str, news: list[News]) -> None:
        for item in news:
            self._inbox.put(event_of(item, source, self.decoder.beats_per_measure))

    def _run(self) -> None:
        due = self._clock.now()
        try:
            while not self._stop.is_set():
                with contextlib.suppress(queue.Empty):
                    time, message = self._arrived.get(timeout=WAITS)
                    self._decode_safely(message, time)
                now = self._clock.now()
                self._look_safely(now)
                if now >= due:
                    due = now + RETRY
                    self._care(now)
        finally:
            if self._port is not None:
                self._port.close()

    def _care(self, now: float) -> None:
        """See that the port is open; whatever goes wrong, there is another time."""
        try:
            quiet, self._counted = self._counted == self.messages, self.messages
            if self._port is not None and not (self._port.there and (not quiet or self._port.system_runs)):
                self._lose(now)
            if self._port is None:
                self._port = self._open_by_name(self.name)
                self._port.listen(self.receive)
                self.connected, self.problem = self._port.name, ""
                self.reopened += 1
        except Exception as error:  # MIDI systems come and go: no error of theirs may end the listening
            self.problem = " ".join(str(error).split())
            if self._port is not None:
                self._lose(now)

    def _lose(self, now: float) -> None:
        port, self._port, self.connected = self._port, None, ""
        if port is not None:
            port.close()
        self._put("midi", self.decoder.unplugged(now))
        if self.time_code is not None:
            self._put("mtc", self.time_code.unplugged(now))


def event_of(item: News, source: str, beats_per_measure: int) -> ControlEvent:
    """What a decoder tells, as an event of the show."""
    if isinstance(item, ClockState):
        return SourceChanged(time=item.time, source=source, state=item.state, detail=item.detail)
    beat: ClockBeat = item
    return BeatHeard(
        time=beat.time,
        source=source,
        beat_time=beat.beat_time,
        period=beat.period,
        confidence=beat.confidence,
        beat=beat.beat,
        beats_per_measure=beats_per_measure if beat.anchored else 0,
        measure=beat.measure,
        jump=beat.jump,
        anchored=beat.anchored,
    )
