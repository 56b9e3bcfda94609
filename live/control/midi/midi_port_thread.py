"""PortThread: a MIDI port by its name, opened whenever it is there, by a thread of its own."""

import threading
from collections.abc import Callable
from typing import Any, Final

from live.base.fault_isolation import keep_running
from live.control.midi.midi_streams import Port

RETRY: Final = 2.0
"""Seconds between two attempts to open a port that is not there, and between two looks whether it still is."""

Open = Callable[[str], Port]


class PortThread:
    """No frame waits for a cable. Subclasses say in `_run` what the thread does, and `_care` there from time to time.

    Thread: `start` and `stop` belong to the one that made it, all that touches the port to its own.
    """

    def __init__(self, name: str, what: str, open_by_name: Open) -> None:
        """Nothing is opened yet. `what` the thread is called; `open_by_name` raises whatever it likes where there is no
        such port (yet)."""
        self.name = name
        self.connected = ""
        """The whole name of the port that is open; empty while there is none."""
        self.problem = ""
        """Why no port is open."""
        self.opened = 0
        """How often it was opened: who is there now has heard nothing of what was sent before."""
        self._what = what
        self._open_by_name = open_by_name
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._port: Port | None = None

    def start(self) -> None:
        """Begin; a port that is not there is waited for."""
        self._stop.clear()
        self._thread = threading.Thread(target=self._keep_running, name=f"{self._what} {self.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End; a port that hangs is left to its thread after two seconds."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return {"port": self.connected or self.name, "problem": self.problem}

    def _keep_running(self) -> None:
        keep_running(f"{self._what} {self.name}", self._run, self._stop.wait)

    def _run(self) -> None:
        """Work until `_stop`, and `_close` in the end whatever happens."""
        raise NotImplementedError

    def _care(self) -> None:
        """See that the port is open; whatever goes wrong, there is another time."""
        try:
            if self._port is not None and not self._lives(self._port):
                self._lose("the port is gone")
            if self._port is None:
                self._open()
        except Exception as error:  # MIDI systems come and go: no error of theirs may end the show
            self._lose(words_of(error))

    def _lives(self, port: Port) -> bool:
        """Whether the port that is open still is there."""
        return port.there

    def _open(self) -> None:
        """Open it; raises whatever the system does."""
        self._port = self._open_by_name(self.name)
        self._begin(self._port)
        self.connected, self.problem = self._port.name, ""
        self.opened += 1

    def _begin(self, port: Port) -> None:
        """What is to be done with a port that was opened just now."""

    def _lose(self, problem: str) -> None:
        """Give the port up, if one is open, for this reason."""
        self.problem = problem
        self._close()

    def _close(self) -> None:
        port, self._port, self.connected = self._port, None, ""
        if port is not None:
            port.close()


def words_of(error: Exception) -> str:
    """What an error says, on one line."""
    return " ".join(str(error).split())
