"""One connection to a JACK MIDI port in a process of its own, whose standard streams carry the MIDI bytes.

Without a port's name it lists the ports and ends. A server that hangs or crashes stops nothing else.

JACK calls `_receive` and `_send` in its real-time thread, once in a cycle of 1 to 20 ms. A cycle later the messages are
overwritten. In the show's process that thread would wait for the interpreter: beside three busy threads 58 of 500
messages arrived, beside one each came twice. Here no other thread runs Python meanwhile, and nothing that is called
waits. The process ends when its standard input does, or JACK's server, or the other port.
"""

import gc
import os
import select
import signal
import sys
import threading
import time
from collections import deque
from typing import Any, Final

from live.control.midi.jack_system import NOT_OPENED, PORT_GONE, READ_SIZE, SYSTEM_GONE
from live.control.midi.midi_streams import MidiTokenizer
from live.control.midi.midi_system import CLIENT_NAME, MidiUnavailable

IN, OUT = 0, 1
MAX_WAITING: Final = 1 << 20
"""Maximum number of bytes that wait for a show that does not read; then all are dropped."""
LAST_TIMEOUT: Final = 0.2
"""Longest wait until the last messages have left [s]."""
ATTEMPTS: Final = 5
"""The server refuses a client while it tells others of it that have just died ..."""
ATTEMPT_INTERVAL: Final = 0.05
"""... until it has noticed that [s]."""


def jack_client() -> Any:
    """Return a new client; MidiUnavailable without JACK's library or server.

    No server is started, and nothing is printed to the terminal.
    """
    try:
        import jack
    except (ImportError, OSError) as error:
        raise MidiUnavailable(f"JACK: {error}") from None
    jack.set_error_function(_ignore)  # once in a process: the library's threads may be within the one before
    jack.set_info_function(_ignore)
    for attempt in range(ATTEMPTS):
        if attempt:
            time.sleep(ATTEMPT_INTERVAL)
        try:
            return jack.Client(CLIENT_NAME, no_start_server=True)
        except jack.JackOpenError as error:
            status = error.status
            if status.server_failed:
                raise MidiUnavailable("no JACK server runs") from None
    raise MidiUnavailable(f"JACK: {status}")


def _ignore(message: str) -> None:
    """Take a message of JACK's library."""


class JackConnection:
    """Moves bytes between the standard streams and a port of JACK."""

    def __init__(self, direction: str, name: str) -> None:
        """Connect to the port; raise any error of JACK-Client."""
        self.why = 0
        """Exit code, once `ended` is readable."""
        self.told = False
        """Whether the first line is written; messages follow it."""
        self.ended, self._end = os.pipe()
        self.sent = threading.Event()
        """Set when the last message of the standard input has left."""
        self._name = name
        self._arrived = bytearray()
        self._tokens = MidiTokenizer()
        self._leaving: deque[bytes] = deque()
        self._client = client = jack_client()
        reads = direction == "input"
        self._port: Any = client.midi_inports.register("in") if reads else client.midi_outports.register("out")
        client.set_process_callback(self._receive if reads else self._send)
        client.set_shutdown_callback(lambda _status, _reason: self._finish(SYSTEM_GONE))
        client.set_port_registration_callback(self._on_registration, only_available=False)
        client.activate()
        client.connect(*((name, self._port) if reads else (self._port, name)))

    def close(self) -> None:
        """Leave JACK."""
        self._client.deactivate()
        self._client.close()

    def _finish(self, why: int) -> None:
        self.why = self.why or why
        os.write(self._end, b".")

    def _on_registration(self, port: Any, registered: bool) -> None:
        """Note that a port came or went; one that is unknown by now was not there long."""
        if not registered and port is not None and port.name == self._name:
            self._finish(PORT_GONE)

    def _receive(self, _frames: int) -> None:
        arrived = self._arrived
        for _, event in self._port.incoming_midi_events():
            arrived += bytes(event)
        if arrived and self.told:
            try:
                del arrived[: os.write(OUT, arrived)]
            except OSError:  # the pipe is full, or nobody reads any more
                if len(arrived) > MAX_WAITING:
                    arrived.clear()

    def _send(self, _frames: int) -> None:
        self._port.clear_buffer()
        leaving, room = self._leaving, True
        if not leaving:
            try:
                data = os.read(IN, READ_SIZE)
            except BlockingIOError:
                return
            if not data:
                self.sent.set()
                return
            leaving.extend(self._tokens.feed(data))
        written = 0
        while leaving and room:
            room = self._write(leaving[0])
            if room or not written:  # one that does not fit into an empty buffer never will
                leaving.popleft()
                written += 1

    def _write(self, message: bytes) -> bool:
        """Put a message into the buffer of this cycle; return whether there was room."""
        room = self._port.reserve_midi_event(0, len(message))
        if not len(room):
            return False
        room[:] = message
        return True


def list_ports(direction: str) -> int:
    """Write the names of all MIDI ports, each with a zero byte behind it, or why not; return the exit code."""
    code = 0
    try:
        client = jack_client()
        reads = direction == "input"
        names = [port.name for port in client.get_ports(is_midi=True, is_output=reads, is_input=not reads)]
        client.close()
        said = "".join(f"{name}\0" for name in names)
    except MidiUnavailable as error:
        code, said = NOT_OPENED, str(error)
    except Exception as error:  # a port went away meanwhile, or its name is no text
        code, said = NOT_OPENED, f"JACK: {error}"
    os.write(OUT, said.encode())
    return code


def main(direction: str, name: str = "") -> int:
    """Run the process; return its exit code."""
    if not name:
        return list_ports(direction)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.disable()  # there are no reference cycles here, and a collection would delay messages
    os.set_blocking(IN, False)
    os.set_blocking(OUT, False)
    try:
        connection = JackConnection(direction, name)
    except Exception as error:
        os.write(OUT, " ".join(str(error).split()).encode() + b"\n")
        return NOT_OPENED
    os.write(OUT, b"\n")
    connection.told = True
    wait = select.poll()
    wait.register(IN, 0)  # its end is always told
    wait.register(connection.ended, select.POLLIN)
    wait.poll()
    if connection.why == SYSTEM_GONE:
        return SYSTEM_GONE
    if direction == "output" and not connection.why:
        connection.sent.wait(LAST_TIMEOUT)
    connection.close()
    return connection.why


if __name__ == "__main__":
    code = 1
    try:
        code = main(*sys.argv[1:])
    finally:
        os._exit(code)  # whatever state JACK's library is in
