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
from live.base.lane import Lane
from live.clock.midi_clock import MidiClock
from live.clock.note_energy import NoteEnergy
from live.clock.source import Clock
from live.clock.time_code import TimeCodeClock
from live.control.events import ControlEvent
from live.control.midi_decoding import MidiDecoding
from live.control.midi_map import MidiMap
from live.control.midi_ports import open_port
from live.control.midi_streams import Port

RETRY: Final = 2.0
"""Seconds between two attempts to open a port that is not there, and between two looks whether it still is."""

LOOK: Final = 0.2
"""Seconds from one quick look to the next whether an open port still is: what is plugged in again may have its old
name, and be connected to nobody."""

WAITS: Final = 0.05
"""Seconds after which the decoding thread looks at the time though nothing came."""

WAITING_MAX: Final = 4096
"""Messages that may wait to be decoded; more are counted and dropped."""

Open = Callable[[str], Port]


def _open_input(name: str) -> Port:
    return open_port("input", name)


class MidiInput(MidiDecoding):
    """Listens to a port by name and puts what it says into the inbox."""

    def __init__(
        self,
        name: str,
        inbox: Inbox[ControlEvent] | Lane[ControlEvent],
        clock: Clock,
        *,
        decoder: MidiClock | None = None,
        time_code: TimeCodeClock | None = None,
        midi_map: MidiMap | None = None,
        notes: NoteEnergy | None = None,
        clocked: bool = True,
        open_by_name: Open = _open_input,
    ) -> None:
        """Nothing is opened yet. `open_by_name` raises whatever it likes where there is no such port (yet).

        The others are those of `MidiDecoding`.
        """
        super().__init__(inbox, decoder=decoder, time_code=time_code, midi_map=midi_map, notes=notes, clocked=clocked)
        self.name = name
        self.connected = ""
        """The whole name of the port that is open; empty while there is none."""
        self.problem = ""
        """Why no port is open."""
        self.reopened = 0
        self.dropped = 0
        """Messages that waited too long."""
        self.failed = 0
        """Messages, and looks at the time, that a decoder failed at ..."""
        self.failure = ""
        """... and the last failure in words."""
        self._counted = 0
        self._clock = clock
        self._open_by_name = open_by_name
        self._arrived: queue.SimpleQueue[tuple[float, Sequence[int]]] = queue.SimpleQueue()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._port: Port | None = None

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

    def receive(self, message: Sequence[int]) -> None:
        """A message arrived. Thread: any; never blocks."""
        now = self._clock.now()
        if self._arrived.qsize() >= WAITING_MAX:
            self.dropped += 1
            return
        self._arrived.put((now, message))

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

    def _run(self) -> None:
        due = quick = self._clock.now()
        try:
            while not self._stop.is_set():
                with contextlib.suppress(queue.Empty):
                    time, message = self._arrived.get(timeout=WAITS)
                    self._decode_safely(message, time)
                now = self._clock.now()
                self._look_safely(now)
                if now >= quick:
                    quick = now + LOOK
                    if not self._is_there(now):
                        due = now
                if now >= due:
                    due = now + RETRY
                    self._care(now)
        finally:
            if self._port is not None:
                self._port.close()

    def _is_there(self, now: float) -> bool:
        """Whether the port that is open still is; lost if not. No port at all is none that has gone."""
        try:
            if self._port is None or self._port.there:
                return True
        except Exception as error:
            self.problem = " ".join(str(error).split())
        self._lose(now)
        return False

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
        self.unplugged(now)
