"""MidiOutput: messages to one MIDI port by name, by a thread of its own, so that no frame waits for a cable."""

import contextlib
import queue
import threading
from collections.abc import Callable
from typing import Any, Final

from live.clock.source import Clock
from live.control.midi_ports import open_output
from live.control.midi_streams import Port

RETRY: Final = 2.0
"""Seconds between two attempts to open a port that is not there ..."""
LOOK: Final = 0.2
"""... or whether an open one still is."""
WAITING_MAX: Final = 512
"""Messages that may wait; more are counted and dropped."""
WAITS: Final = 0.1


class MidiOutput:
    """Thread: `send` from the show's; `start` and `stop` from the one that made it."""

    def __init__(self, name: str, clock: Clock, *, open_by_name: Callable[[str], Port] = open_output) -> None:
        """Nothing is opened yet; a port that is not there is waited for."""
        self.name = name
        self.connected = ""
        """The whole name of the port that is open; empty while there is none."""
        self.problem = ""
        """Why no port is open."""
        self.opened = 0
        """How often it was opened: who is there now has heard nothing of what was sent before."""
        self.sent = 0
        self.dropped = 0
        """Messages that waited too long, or were sent into nothing."""
        self._clock = clock
        self._open_by_name = open_by_name
        self._waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._port: Port | None = None

    def start(self) -> None:
        """Begin."""
        self._stop.clear()
        self._thread = threading.Thread(target=self._run, name=f"midi out {self.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def send(self, message: bytes) -> None:
        """Send a message soon; never blocks."""
        if self._waiting.qsize() >= WAITING_MAX:
            self.dropped += 1
            return
        self._waiting.put(message)

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return {
            "port": self.connected or self.name,
            "problem": self.problem,
            "sent": self.sent,
            "dropped": self.dropped,
        }

    def _run(self) -> None:
        due = self._clock.now()
        try:
            while not self._stop.is_set():
                if self._clock.now() >= due:
                    self._care()
                    due = self._clock.now() + (RETRY if self._port is None else LOOK)
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
            self._lose(" ".join(str(error).split()))

    def _care(self) -> None:
        """See that the port is open; whatever goes wrong, there is another time."""
        try:
            if self._port is not None and not self._port.there:
                self._lose("the port is gone")
            if self._port is None:
                self._port = self._open_by_name(self.name)
                self.connected, self.problem = self._port.name, ""
                self.opened += 1
        except Exception as error:  # MIDI systems come and go: no error of theirs may end the show
            self._lose(" ".join(str(error).split()))

    def _lose(self, problem: str) -> None:
        port, self._port, self.connected, self.problem = self._port, None, "", problem
        if port is not None:
            port.close()
