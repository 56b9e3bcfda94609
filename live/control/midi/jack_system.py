"""MIDI ports of JACK (also PipeWire's), through JACK-Client, which no process of the show loads.

A process of its own (`jack_process.py`) lists the ports, and each open one lives in another, which ends with its
server, its other side or us. So neither the show nor JACK's real-time thread ever waits for the other.
"""

import contextlib
import os
import select
import subprocess
import sys
import time
from typing import Final

from live.control.midi.midi_streams import Direction, MidiTokenizer, Receive
from live.control.midi.midi_system import MidiUnavailable, foreign
from live.control.worker_thread import WorkerThread

NOT_OPENED, PORT_GONE, SYSTEM_GONE = 3, 4, 5
"""Exit codes of the process."""
PROCESS: Final = (sys.executable, "-m", "live.control.midi.jack_process")
LIST_TIMEOUT: Final = 5.0
"""Longest wait for the list of ports [s]."""
OPEN_TIMEOUT: Final = 10.0
"""Longest wait for the process to connect [s] ..."""
CLOSE_TIMEOUT: Final = 1.0
"""... and to end."""
READ_SIZE: Final = 65536
"""Size of a pipe."""


class JackSystem:
    """JACK. Thread: any."""

    name = "JACK"

    def port_names(self, direction: Direction) -> list[str]:
        """Return the MIDI ports of others; MidiUnavailable if no server runs."""
        try:
            done = subprocess.run(
                [*PROCESS, direction], timeout=LIST_TIMEOUT, check=False, start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise MidiUnavailable("JACK does not answer") from None
        except OSError as error:
            raise MidiUnavailable(f"JACK: {error}") from None
        said = done.stdout.decode(errors="replace")
        if done.returncode:
            raise MidiUnavailable(said or "the process that lists JACK's ports ended at once")
        return foreign([name for name in said.split("\0") if name])

    def open_port(self, direction: Direction, name: str) -> "JackPort":
        """Connect to a port; OSError if that fails."""
        return JackPort(direction, name)


class JackPort:
    """One connection: our end of the pipes. Create, use and close it in one thread; messages arrive on its own."""

    def __init__(self, direction: Direction, name: str) -> None:
        """Connect to the port; OSError if that fails."""
        self.name = name
        self._tokens = MidiTokenizer()
        self._early = b""  # what came with the first answer
        self._receive: Receive = lambda message: None
        self._worker = WorkerThread("midi in", self._read)
        self._process = subprocess.Popen(
            [*PROCESS, direction, name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, bufsize=0,
            start_new_session=True,  # Ctrl-C ends the show, which then ends this process
        )  # fmt: skip
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._in, self._out = self._process.stdin, self._process.stdout
        os.set_blocking(self._in.fileno(), False)
        try:
            self._wait_until_open()
        except BaseException:
            self.close()
            raise

    def _wait_until_open(self) -> None:
        """Wait for the first line: empty, or why it is not open."""
        said, end = b"", time.monotonic() + OPEN_TIMEOUT
        while b"\n" not in said:
            if not select.select([self._out], [], [], max(0.0, end - time.monotonic()))[0]:
                raise OSError("JACK does not answer")
            data = os.read(self._out.fileno(), READ_SIZE)
            if not data:
                raise OSError("the process for JACK's port ended at once")
            said += data
        problem, _, self._early = said.partition(b"\n")
        if problem:
            raise OSError(problem.decode(errors="replace"))

    def listen(self, receive: Receive) -> None:
        """Pass every message, including clock, active sensing and system exclusive, to `receive` as it arrives."""
        self._receive = receive
        self._worker.start()

    def _read(self) -> None:
        """Read until the process has ended."""
        data, self._early = self._early or os.read(self._out.fileno(), READ_SIZE), b""
        while data:
            for message in self._tokens.feed(data):
                self._receive(message)
            data = os.read(self._out.fileno(), READ_SIZE)

    def send(self, message: bytes) -> None:
        """Send one message at JACK's next cycle; OSError if the port is closed or JACK does not take any more."""
        if self._in.closed:
            raise OSError("the MIDI port is closed")
        if os.write(self._in.fileno(), message) < len(message):
            raise OSError("JACK takes no more messages")

    @property
    def exists(self) -> bool:
        """Whether the other side still exists."""
        return self._process.poll() is None

    @property
    def system_runs(self) -> bool:
        """Whether the server runs, as far as this port knows."""
        return self._process.poll() != SYSTEM_GONE

    def close(self) -> None:
        """Close the port, after what was sent has left."""
        with contextlib.suppress(OSError):
            self._in.close()
        try:
            self._process.wait(CLOSE_TIMEOUT)
        except subprocess.TimeoutExpired:  # the server hangs
            self._process.kill()
            self._process.wait()
        if self._worker.stop():
            self._out.close()
