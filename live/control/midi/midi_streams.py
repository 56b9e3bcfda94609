"""MIDI byte streams over TCP (as mido's sockets send them), raw devices and pipes, and their tokenizer.

`tcp:HOST:PORT`: an input listens there, an output connects. `raw:PATH`: a kernel device (/dev/snd/midiC1D0, a
configured serial line) or a named pipe. Bridges add to `SCHEMES`. `MidiTokenizer` splits bytes into messages by the
MIDI 1.0 specification; mido 1.3.3's parser loses running status and every message that a real-time byte interrupts, and
buffers exclusive messages without limit.
"""

import contextlib
import os
import select
import socket
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Final, Literal, Protocol

from live.control.worker_thread import WorkerThread

SYSEX, SYSEX_END = 0xF0, 0xF7
REAL_TIME: Final = 0xF8
UNDEFINED: Final = frozenset((0xF4, 0xF5, 0xF9, 0xFD))
MAX_SYSEX: Final = 4096
"""Maximum size of an exclusive message; longer ones are dropped."""

_CHANNEL_LENGTH: Final = (3, 3, 3, 3, 2, 2, 3)
"""Size of a channel message by its kind, from note-off (8) on."""
_COMMON_LENGTH: Final = {0xF1: 2, 0xF2: 3, 0xF3: 2, 0xF6: 1}


class MidiTokenizer:
    """Splits one sender's bytes into messages. No I/O; use from one thread at a time.

    A real-time byte is returned at once, also within another message. Data bytes without a status use the running
    status, until a system common or exclusive message. A message cut off by another status is dropped and counted.
    """

    def __init__(self) -> None:
        self.stray = 0
        """Number of data bytes without a status."""
        self.cut_off = 0
        """Number of messages cut off by another status byte, including exclusive ones."""
        self.undefined = 0
        """Number of undefined status bytes."""
        self.too_long = 0
        """Number of exclusive messages beyond `MAX_SYSEX`."""
        self._running = 0
        self._message = bytearray()  # the incomplete message
        self._length = 0  # its full length; 0: no message, or an exclusive one
        self._skipping = False  # skipping the rest of an exclusive message that is too long

    @property
    def rejected(self) -> int:
        """Number of all rejected bytes and messages."""
        return self.stray + self.cut_off + self.undefined + self.too_long

    def feed(self, data: Iterable[int]) -> Iterator[bytes]:
        """Yield the messages completed by `data` (0 to 255 each), each with its status byte first."""
        for byte in data:
            found = self._data(byte) if byte < 0x80 else self._status(byte)
            if found:
                yield found

    def reset(self) -> None:
        """Drop the incomplete message and the running status, because the sender is gone."""
        self._drop_partial()
        self._running = 0

    def _data(self, byte: int) -> bytes:
        message = self._message
        if not message:
            if not self._running:
                self.stray += not self._skipping
                return b""
            message.append(self._running)
            self._length = _CHANNEL_LENGTH[(self._running >> 4) - 8]
        message.append(byte)
        if message[0] == SYSEX:
            if len(message) >= MAX_SYSEX:
                self.too_long += 1
                message.clear()
                self._skipping = True
            return b""
        return self._complete() if len(message) == self._length else b""

    def _status(self, status: int) -> bytes:
        if status >= REAL_TIME:
            if status in UNDEFINED:
                self.undefined += 1
                return b""
            return bytes((status,))
        if status == SYSEX_END:
            return self._end_sysex()
        self._drop_partial()
        self._running = status if status < SYSEX else 0
        if status in UNDEFINED:
            self.undefined += 1
            return b""
        self._message.append(status)
        self._length = _CHANNEL_LENGTH[(status >> 4) - 8] if status < SYSEX else _COMMON_LENGTH.get(status, 0)
        return self._complete() if self._length == 1 else b""

    def _end_sysex(self) -> bytes:
        skipped, self._skipping = self._skipping, False
        if self._message[:1] == b"\xf0":
            self._message.append(SYSEX_END)
            return self._complete()
        if not skipped:
            self._drop_partial()
            self.undefined += 1  # an end without a start
        self._running = 0
        return b""

    def _drop_partial(self) -> None:
        self.cut_off += bool(self._message)
        self._message.clear()
        self._skipping = False

    def _complete(self) -> bytes:
        found = bytes(self._message)
        self._message.clear()
        return found


Direction = Literal["input", "output"]
Receive = Callable[[Sequence[int]], None]

TCP: Final = "tcp:"
RAW: Final = "raw:"
MAX_SENDERS: Final = 8
"""Maximum number of connections; more are refused."""
BYTES_PER_SECOND: Final = 62_500
"""Maximum rate read from one sender (twenty MIDI cables); the rest waits at the sender."""
READ_SIZE: Final = 1024
CHECK_INTERVAL: Final = 0.1
"""Seconds between checks whether to stop."""
TIMEOUT: Final = 2.0


class Port(Protocol):
    """An open MIDI port of any kind."""

    name: str

    def listen(self, receive: Receive) -> None:
        """Pass every message to `receive` as it arrives, from any thread."""
        ...

    def send(self, message: bytes) -> None:
        """Send one message; OSError if that fails."""
        ...

    @property
    def exists(self) -> bool:
        """Whether the other side still exists."""
        ...

    @property
    def system_runs(self) -> bool:
        """Whether the MIDI system that it belongs to runs."""
        ...

    def close(self) -> None:
        """Close the port."""
        ...


class StreamPort:
    """One open stream. Create, use and close it in one thread; messages arrive on its own thread."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        self.name = name
        self.exists = True
        self.rejected = 0
        """Number of rejected bytes and messages of senders that are gone."""
        self._listener: socket.socket | None = None
        self._senders: dict[int, _Sender] = {}
        self._out = -1
        self._receive: Receive = lambda message: None
        self._worker = WorkerThread(name, self._read_loop, part=f"MIDI at {name}", end=self._end)
        if name.startswith(RAW):
            path = name.removeprefix(RAW)
            if direction == "output":
                self._out = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
            else:  # a pipe opened for writing, too, stays open when its writer goes
                flags = os.O_RDWR if os.path.exists(path) and not os.path.isfile(path) else os.O_RDONLY
                self._add(os.open(path, flags | os.O_NONBLOCK), None)
            return
        where = parse_address(name)
        if direction == "output":
            self._connection = socket.create_connection(where, timeout=TIMEOUT)
            self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._connection.setblocking(False)
            self._out = self._connection.fileno()
        else:
            family = socket.AF_INET6 if ":" in where[0] else socket.AF_INET
            self._listener = socket.create_server(where, family=family, backlog=MAX_SENDERS)
            self._listener.setblocking(False)

    @property
    def address(self) -> tuple[str, int]:
        """The listening address, with the port that the system chose for 0."""
        assert self._listener is not None
        host, port = self._listener.getsockname()[:2]
        return str(host), int(port)

    def listen(self, receive: Receive) -> None:
        """Start to pass messages to `receive`."""
        self._receive = receive
        self._worker.start()

    def send(self, message: bytes) -> None:
        """Send one complete message; OSError if the other side is gone or does not read."""
        if self._out < 0:
            raise OSError("the MIDI port is closed")
        try:
            if os.write(self._out, message) < len(message):
                raise OSError("the other side does not read any more")
        except OSError:
            self.exists = False
            raise

    def close(self) -> None:
        """Close the stream and all connections."""
        self._worker.stop(TIMEOUT)
        for sender in self._senders.values():
            sender.close()
        if self._listener is not None:
            self._listener.close()
        if self._out >= 0:
            out, self._out = self._out, -1
            if self.name.startswith(TCP):
                self._connection.close()
            else:
                os.close(out)
        self.exists = False

    def _add(self, number: int, connection: socket.socket | None) -> None:
        self._senders[number] = _Sender(number, connection)

    def _end(self) -> None:
        self.exists = False

    def _read_loop(self) -> None:
        while not self._worker.stopping.is_set():
            now = time.monotonic()
            ready = [number for number, sender in self._senders.items() if sender.may_read(now)]
            listener = [] if self._listener is None else [self._listener.fileno()]
            waits = CHECK_INTERVAL if len(ready) == len(self._senders) else READ_SIZE / BYTES_PER_SECOND
            try:
                found, _, _ = select.select([*listener, *ready], [], [], waits)
            except (OSError, ValueError):
                break
            for number in found:
                if listener and number == listener[0]:
                    self._accept()
                elif not self._senders[number].read(self._receive):
                    sender = self._senders.pop(number)
                    sender.close()
                    self.rejected += sender.tokens.rejected
            if self._listener is None and not self._senders:
                break

    def _accept(self) -> None:
        assert self._listener is not None
        with contextlib.suppress(OSError):  # the client is gone already
            connection, _ = self._listener.accept()
            if len(self._senders) >= MAX_SENDERS:
                connection.close()
                return
            connection.setblocking(False)
            self._add(connection.fileno(), connection)


class _Sender:
    """One sender: its descriptor and its tokenizer."""

    def __init__(self, number: int, connection: socket.socket | None) -> None:
        self.tokens = MidiTokenizer()
        self._number, self._connection = number, connection
        self._next_read = 0.0

    def may_read(self, now: float) -> bool:
        """Whether it is below its rate limit."""
        return now >= self._next_read

    def read(self, receive: Receive) -> bool:
        """Read and pass on messages; return False if the sender is gone."""
        try:
            data = os.read(self._number, READ_SIZE)
        except BlockingIOError:
            return True
        except OSError:
            return False
        self._next_read = max(self._next_read, time.monotonic() - 1.0) + len(data) / BYTES_PER_SECOND
        for message in self.tokens.feed(data):
            receive(message)
        return bool(data)

    def close(self) -> None:
        """Close its descriptor."""
        self.tokens.reset()
        if self._connection is not None:
            self._connection.close()
        else:
            os.close(self._number)


Opener = Callable[[Direction, str], Port]
"""Opens the port of a name; ValueError for a wrong address, OSError if it cannot be opened."""
SCHEMES: Final[Mapping[str, Opener]] = {"tcp": StreamPort, "raw": StreamPort}
"""Openers of ports that belong to no MIDI system, by the scheme before the first colon of their names."""


def parse_address(name: str) -> tuple[str, int]:
    """Return host and port of a name such as `tcp:HOST:PORT`; ValueError names the expected form."""
    scheme, _, address = name.partition(":")
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise ValueError(f"{scheme}:HOST:PORT expected, as in {scheme}:127.0.0.1:9080, found {name!r}")
    return host.strip("[]"), int(port)
