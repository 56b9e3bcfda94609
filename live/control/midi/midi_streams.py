"""MIDI as a stream of bytes: over TCP, as mido's sockets send it, and of raw devices and pipes.

`tcp:HOST:PORT`: to hear, we listen there and others connect; to tell, we connect. `raw:PATH`: a device of the kernel
(/dev/snd/midiC1D0, a serial line that is set up) or a named pipe. Bytes are cut into messages here (`MidiTokens`).
`rtp:HOST:PORT`, over RTP, is `rtp_port.py`'s.

MidiTokens: a stream of MIDI bytes cut into messages, as the MIDI 1.0 specification has them.

For bytes of a wire, a raw device, a socket or a network packet. mido 1.3.3's parser loses running status and every
message that a real-time byte falls into, and keeps exclusive messages without end; so these bytes are cut here.
"""

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, Literal, Protocol

from live.base.fault_isolation import keep_running

SYSEX, SYSEX_END = 0xF0, 0xF7
REAL_TIME: Final = 0xF8
UNDEFINED: Final = frozenset((0xF4, 0xF5, 0xF9, 0xFD))
SYSEX_MOST: Final = 4096
"""Bytes of an exclusive message at most; of a longer one nothing is kept."""

_CHANNEL_LENGTH: Final = (3, 3, 3, 3, 2, 2, 3)
"""Bytes of a channel message by its kind, from note-off (8) on."""
_COMMON_LENGTH: Final = {0xF1: 2, 0xF2: 3, 0xF3: 2, 0xF6: 1}


class MidiTokens:
    """Cuts one sender's bytes. Pure; thread: one at a time.

    A real-time byte is told at once, wherever it stands. Data bytes without a status use the last channel status
    again, until a system common or exclusive message. What is cut off by another status is dropped and counted.
    """

    def __init__(self) -> None:
        self.stray = 0
        """Data bytes that belong to nothing."""
        self.cut_off = 0
        """Messages that another status byte cut off, exclusive ones too."""
        self.undefined = 0
        """Status bytes that mean nothing."""
        self.too_long = 0
        """Exclusive messages that were longer than is kept."""
        self._running = 0
        self._message = bytearray()  # what has begun and is not whole
        self._length = 0  # of it when it is whole; 0: none has begun, or an exclusive one
        self._skips = False  # the rest of an exclusive message that is too long

    @property
    def rejected(self) -> int:
        """All that could not be used."""
        return self.stray + self.cut_off + self.undefined + self.too_long

    def feed(self, data: Iterable[int]) -> Iterator[bytes]:
        """The messages that are whole with `data` (0 to 255 each), each with its status byte first."""
        for byte in data:
            found = self._data(byte) if byte < 0x80 else self._status(byte)
            if found:
                yield found

    def end(self) -> None:
        """The sender has gone: what has begun is dropped, and running status with it."""
        self._cut()
        self._running = 0

    def _data(self, byte: int) -> bytes:
        message = self._message
        if not message:
            if not self._running:
                self.stray += not self._skips
                return b""
            message.append(self._running)
            self._length = _CHANNEL_LENGTH[(self._running >> 4) - 8]
        message.append(byte)
        if message[0] == SYSEX:
            if len(message) >= SYSEX_MOST:
                self.too_long += 1
                message.clear()
                self._skips = True
            return b""
        return self._whole() if len(message) == self._length else b""

    def _status(self, status: int) -> bytes:
        if status >= REAL_TIME:
            if status in UNDEFINED:
                self.undefined += 1
                return b""
            return bytes((status,))
        if status == SYSEX_END:
            return self._end_sysex()
        self._cut()
        self._running = status if status < SYSEX else 0
        if status in UNDEFINED:
            self.undefined += 1
            return b""
        self._message.append(status)
        self._length = _CHANNEL_LENGTH[(status >> 4) - 8] if status < SYSEX else _COMMON_LENGTH.get(status, 0)
        return self._whole() if self._length == 1 else b""

    def _end_sysex(self) -> bytes:
        skipped, self._skips = self._skips, False
        if self._message[:1] == b"\xf0":
            self._message.append(SYSEX_END)
            return self._whole()
        if not skipped:
            self._cut()
            self.undefined += 1  # the end of what never began
        self._running = 0
        return b""

    def _cut(self) -> None:
        self.cut_off += bool(self._message)
        self._message.clear()
        self._skips = False

    def _whole(self) -> bytes:
        found = bytes(self._message)
        self._message.clear()
        return found


Direction = Literal["input", "output"]
Receive = Callable[[Sequence[int]], None]

TCP: Final = "tcp:"
RAW: Final = "raw:"
RTP: Final = "rtp:"
MOST_SENDERS: Final = 8
"""Who may be connected at once; more are turned away."""
BYTES_PER_SECOND: Final = 62_500
"""What is read of one sender at most, twenty cables' worth; the rest waits with the sender."""
BLOCK: Final = 1024
LOOK: Final = 0.1
"""Seconds after which it is looked whether to end."""
PATIENCE: Final = 2.0


class Port(Protocol):
    """A MIDI port that is open, of whatever kind."""

    name: str

    def listen(self, receive: Receive) -> None:
        """Hand every message over as it arrives, from any thread."""
        ...

    def send(self, message: bytes) -> None:
        """Send one message; OSError if that cannot be."""
        ...

    @property
    def there(self) -> bool:
        """Whether the other side still exists."""
        ...

    @property
    def system_runs(self) -> bool:
        """Whether the system that it belongs to does."""
        ...

    def close(self) -> None:
        """Free it."""
        ...


def is_stream(name: str) -> bool:
    """Whether a name means a stream and no port of a MIDI system."""
    return name.startswith((TCP, RAW, RTP))


class StreamPort:
    """One open stream. Thread: made, used and closed by one; what arrives is handed over on its own."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        self.name = name
        self.there = True
        self.rejected = 0
        """Bytes and messages of senders that have gone that could not be used."""
        self._listener: socket.socket | None = None
        self._senders: dict[int, _Sender] = {}
        self._out = -1
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        if name.startswith(RAW):
            path = name.removeprefix(RAW)
            if direction == "output":
                self._out = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
            else:  # to write as well keeps a pipe open whose writer goes
                flags = os.O_RDWR if os.path.exists(path) and not os.path.isfile(path) else os.O_RDONLY
                self._add(os.open(path, flags | os.O_NONBLOCK), None)
            return
        where = address_of(name)
        if direction == "output":
            self._connection = socket.create_connection(where, timeout=PATIENCE)
            self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._connection.setblocking(False)
            self._out = self._connection.fileno()
        else:
            family = socket.AF_INET6 if ":" in where[0] else socket.AF_INET
            self._listener = socket.create_server(where, family=family, backlog=MOST_SENDERS)
            self._listener.setblocking(False)

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens: the port that the system chose for 0."""
        assert self._listener is not None
        host, port = self._listener.getsockname()[:2]
        return str(host), int(port)

    def listen(self, receive: Receive) -> None:
        """Begin to hand over what comes."""
        self._thread = threading.Thread(target=self._run, args=(receive,), name=self.name, daemon=True)
        self._thread.start()

    def send(self, message: bytes) -> None:
        """Send one message whole; OSError where the other side has gone or takes nothing any more."""
        if self._out < 0:
            raise OSError("the MIDI port is closed")
        try:
            if os.write(self._out, message) < len(message):
                raise OSError("the other side takes nothing any more")
        except OSError:
            self.there = False
            raise

    def close(self) -> None:
        """Free it."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=PATIENCE)
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
        self.there = False

    def _add(self, number: int, connection: socket.socket | None) -> None:
        self._senders[number] = _Sender(number, connection)

    def _run(self, receive: Receive) -> None:
        keep_running(f"MIDI at {self.name}", lambda: self._hear(receive), self._stop.wait)
        self.there = False

    def _hear(self, receive: Receive) -> None:
        while not self._stop.is_set():
            now = time.monotonic()
            ready = [number for number, sender in self._senders.items() if sender.may_read(now)]
            listener = [] if self._listener is None else [self._listener.fileno()]
            waits = LOOK if len(ready) == len(self._senders) else BLOCK / BYTES_PER_SECOND
            try:
                found, _, _ = select.select([*listener, *ready], [], [], waits)
            except (OSError, ValueError):
                break
            for number in found:
                if listener and number == listener[0]:
                    self._accept()
                elif not self._senders[number].read(receive):
                    sender = self._senders.pop(number)
                    sender.close()
                    self.rejected += sender.tokens.rejected
            if self._listener is None and not self._senders:
                break

    def _accept(self) -> None:
        assert self._listener is not None
        with contextlib.suppress(OSError):  # it has gone again
            connection, _ = self._listener.accept()
            if len(self._senders) >= MOST_SENDERS:
                connection.close()
                return
            connection.setblocking(False)
            self._add(connection.fileno(), connection)


class _Sender:
    """One who sends: where its bytes come from, and what of a message has come."""

    def __init__(self, number: int, connection: socket.socket | None) -> None:
        self.tokens = MidiTokens()
        self._number, self._connection = number, connection
        self._again = 0.0

    def may_read(self, now: float) -> bool:
        """Whether it has not sent more than is read of one."""
        return now >= self._again

    def read(self, receive: Receive) -> bool:
        """Hand over what has come; False if the sender has gone."""
        try:
            data = os.read(self._number, BLOCK)
        except BlockingIOError:
            return True
        except OSError:
            return False
        self._again = max(self._again, time.monotonic() - 1.0) + len(data) / BYTES_PER_SECOND
        for message in self.tokens.feed(data):
            receive(message)
        return bool(data)

    def close(self) -> None:
        """Free it."""
        self.tokens.end()
        if self._connection is not None:
            self._connection.close()
        else:
            os.close(self._number)


def address_of(name: str) -> tuple[str, int]:
    """Host and port of `tcp:HOST:PORT`; ValueError with what is expected."""
    kind = name[:4]
    host, _, port = name.removeprefix(kind).rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise ValueError(f"{kind}HOST:PORT expected, as in {kind}127.0.0.1:9080, found {name!r}")
    return host.strip("[]"), int(port)
