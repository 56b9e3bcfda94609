"""MIDI input port: puts clocks, notes and mapped controls into the inbox.

The port's thread time-stamps messages and queues them. A second thread decodes them, checks that the port still exists,
and opens it again by name.
"""

import contextlib
import queue
from collections.abc import Mapping, Sequence
from typing import Any, Final

from live.base.event_queue import EventQueue, PriorityQueue
from live.clock.midi.midi_clock import MessageClock, MidiClock
from live.clock.note_energy import NoteEnergy
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.midi import midi_ports
from live.control.midi.midi_decoder import MidiEventDecoder
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_ports import Open, PortThread, error_text, open_port
from live.control.midi.midi_streams import Port

CHECK_INTERVAL: Final = 0.2
"""Seconds between quick checks of an open port: a device that was plugged in again may keep its name but have no
connection."""

QUEUE_TIMEOUT: Final = 0.05
"""Seconds without a message after which the decoding thread advances the time."""

MAX_WAITING: Final = 4096
"""Maximum number of messages waiting to be decoded; more are counted and dropped."""


def _open_input(name: str) -> Port:
    return open_port("input", name)


class MidiInput(MidiEventDecoder, PortThread):
    """Decodes the messages of a port, opened by name, into the inbox."""

    def __init__(
        self,
        name: str,
        inbox: EventQueue[ControlEvent] | PriorityQueue[ControlEvent],
        clock: Clock,
        *,
        decoder: MidiClock | None = None,
        clocks: Mapping[str, MessageClock] | None = None,
        midi_map: MidiMap | None = None,
        notes: NoteEnergy | None = None,
        follow_clock: bool = True,
        open_by_name: Open = _open_input,
    ) -> None:
        """Open nothing yet. `open_by_name` may raise any exception if the port is missing.

        For the other parameters see `MidiEventDecoder`.
        """
        MidiEventDecoder.__init__(
            self, inbox, decoder=decoder, clocks=clocks, midi_map=midi_map, notes=notes, follow_clock=follow_clock
        )
        PortThread.__init__(self, name, "midi in", open_by_name)
        self.dropped = 0
        """Number of messages dropped because the queue was full."""
        self.failed = 0
        """Number of exceptions in the decoder ..."""
        self.failure = ""
        """... and the last one as text."""
        self._checked_messages = 0
        self._clock = clock
        self._arrived: queue.SimpleQueue[tuple[float, Sequence[int]]] = queue.SimpleQueue()

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        train = self.decoder.train
        return super().status() | {
            "messages": self.messages,
            "bad": self.decoder.rejected + self.dropped + self.failed,
            "failure": self.failure,
            "lost_clocks": train.lost,
            "clock_noise_ms": round(1e3 * train.curve.noise, 2) if train.curve.count else None,
        }

    def receive(self, message: Sequence[int]) -> None:
        """Queue a message that has arrived. Call from any thread; never blocks."""
        now = self._clock.now()
        if self._arrived.qsize() >= MAX_WAITING:
            self.dropped += 1
            return
        self._arrived.put((now, message))

    def _decode_safely(self, message: Sequence[int], time: float) -> None:
        """Decode a message; an exception is counted."""
        try:
            self.decode(message, time)
        except Exception as error:
            self._fail(" ".join(f"{byte:02x}" for byte in message[:8]), error)

    def _fail(self, where: str, error: Exception) -> None:
        self.failed += 1
        self.failure = f"{where}: {type(error).__name__}: {error}"

    def _advance_safely(self, now: float) -> None:
        """Advance the decoder's time; an exception is counted."""
        try:
            self.advance(now)
        except Exception as error:
            self._fail("nothing came", error)

    def _run(self) -> None:
        due = quick = self._clock.now()
        try:
            while not self._stop.is_set():
                with contextlib.suppress(queue.Empty):
                    time, message = self._arrived.get(timeout=QUEUE_TIMEOUT)
                    self._decode_safely(message, time)
                now = self._clock.now()
                self._advance_safely(now)
                if now >= quick:
                    quick = now + CHECK_INTERVAL
                    if not self._check_open():
                        due = now
                if now >= due:
                    due = now + midi_ports.RETRY_INTERVAL
                    self._maintain()
        finally:
            self._close()

    def _check_open(self) -> bool:
        """Check the open port and close it if it is gone; return False only then, True also without a port."""
        problem = ""
        try:
            if self._port is None or self._port.exists:
                return True
        except Exception as error:
            problem = error_text(error)
        self._disconnect(problem)
        return False

    def _is_alive(self, port: Port) -> bool:
        """Whether the port exists; if no message came since the last check, also whether its system runs."""
        quiet, self._checked_messages = self._checked_messages == self.messages, self.messages
        return port.exists and (not quiet or port.system_runs)

    def _on_open(self, port: Port) -> None:
        self._checked_messages = self.messages
        port.listen(self.receive)

    def _disconnect(self, problem: str) -> None:
        now, was_open = self._clock.now(), self._port is not None
        super()._disconnect(problem)
        if was_open:
            self.unplugged(now)
