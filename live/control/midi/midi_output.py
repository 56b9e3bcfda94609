"""MidiOutput: messages to one MIDI port by name, sent by its thread."""

import contextlib
import queue
from typing import Any, Final

from live.clock.time_source import Clock
from live.control.midi import midi_port_thread
from live.control.midi.midi_port_thread import Open, PortThread, words_of
from live.control.midi.midi_ports import open_output

LOOK: Final = 0.2
"""Seconds between two looks whether an open port still is."""
WAITING_MAX: Final = 512
"""Messages that may wait; more are counted and dropped."""
WAITS: Final = 0.1


class MidiOutput(PortThread):
    """Thread: `send` from the show's; `start` and `stop` from the one that made it."""

    def __init__(self, name: str, clock: Clock, *, open_by_name: Open = open_output) -> None:
        """Nothing is opened yet; a port that is not there is waited for."""
        super().__init__(name, "midi out", open_by_name)
        self.sent = 0
        self.dropped = 0
        """Messages that waited too long, or were sent into nothing."""
        self._clock = clock
        self._waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def send(self, message: bytes) -> None:
        """Send a message soon; never blocks."""
        if self._waiting.qsize() >= WAITING_MAX:
            self.dropped += 1
            return
        self._waiting.put(message)

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return super().facts() | {"sent": self.sent, "dropped": self.dropped}

    def _run(self) -> None:
        due = self._clock.now()
        try:
            while not self._stop.is_set():
                if self._clock.now() >= due:
                    self._care()
                    due = self._clock.now() + (midi_port_thread.RETRY if self._port is None else LOOK)
                with contextlib.suppress(queue.Empty):
                    self._say(self._waiting.get(timeout=WAITS))
        finally:
            self._lose("")

    def _say(self, message: bytes) -> None:
        if self._port is None:
            self.dropped += 1
            return
        try:
            self._port.send(message)
            self.sent += 1
        except Exception as error:  # the port has gone
            self.dropped += 1
            self._lose(words_of(error))
