"""Line channel: exchanges lines between two processes over a stream socket without blocking the show."""

import contextlib
import json
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from live.base.system.packet_socket import NO_SIGNAL

if TYPE_CHECKING:
    from live.base.system.loopback import ChildConnection

BUFFER: Final = 4 * 1024 * 1024
"""Requested size of the socket's buffers."""
BACKLOG: Final = 256 * 1024 * 1024
"""Most bytes waiting to be sent before lines are dropped, because the peer has stopped reading."""
MAX_LINE_BYTES: Final = 64 * 1024 * 1024
"""Most bytes of a received line; a longer one violates the protocol."""
CHUNK_BYTES: Final = 1 << 18


class ChannelError(Exception):
    """Received data violates the protocol, or the peer never came."""


class LineChannel:
    """One end of a stream socket that carries lines.

    The peer receives a line once the system has accepted it, even if this process is killed at the next instruction.
    That is why events are sent here before they are applied. Thread: one.
    """

    def __init__(
        self, sock: "socket.socket | ChildConnection", *, backlog: int = BACKLOG, longest: int | None = None
    ) -> None:
        """`sock`: a connection, or one that a child will make: `read_lines` looks for it, and until then lines wait;
        `backlog`: most bytes waiting to be sent; `longest`: most bytes of a received line."""
        self._awaited = None if isinstance(sock, socket.socket) else sock
        self.socket = sock if isinstance(sock, socket.socket) else sock.listening
        """The connection; before it is there, the socket that listens for it."""
        _prepare_socket(self.socket)
        self.dropped = 0
        """Lines dropped because the peer is gone or has stopped reading."""
        self.ended = False
        """Whether the peer is gone."""
        self.before_close: Callable[[], None] = lambda: None
        """Called before this end is closed: a selector must not keep a descriptor that is used again."""
        self.sent, self.received = 0, 0
        """Lines accepted for sending, and lines received and handed on: both ends use these counts to identify a line.
        """
        self._pending: deque[bytes] = deque()
        self._pending_bytes = 0
        self._most, self._longest = backlog, MAX_LINE_BYTES if longest is None else longest
        self._partial = bytearray()

    def reconnect(self, sock: socket.socket) -> None:
        """Continue with another peer over another socket; everything not sent or read yet is dropped."""
        self.before_close()
        self.socket.close()
        _prepare_socket(sock)
        self.socket = sock
        self.ended = False
        self.sent = self.received = 0
        self._pending.clear()
        self._pending_bytes = 0
        self._partial.clear()

    @property
    def connected(self) -> bool:
        """Whether the peer has come."""
        return self._awaited is None

    def _connect(self, awaited: "ChildConnection") -> None:
        try:
            sock = awaited.accept()
        except OSError as error:
            raise ChannelError(str(error)) from None
        if sock is not None:
            _prepare_socket(sock)
            self.socket, self._awaited = sock, None
            self.flush()

    @property
    def pending_bytes(self) -> int:
        """Bytes waiting to be sent."""
        return self._pending_bytes

    def fileno(self) -> int:
        """Return the socket's descriptor, for selectors."""
        return self.socket.fileno()

    def send_line(self, line: str) -> None:
        """Send one line, without its line end; the part the system does not accept at once waits for `flush`."""
        self._send_data((line + "\n").encode())

    def send_json(self, **values: Any) -> None:
        """Send one JSON object."""
        self.send_line(json.dumps(values, separators=(",", ":")))

    def flush(self) -> bool:
        """Send pending data as far as possible; return whether nothing is pending any more."""
        while self._pending and not self.ended:
            data = self._pending[0]
            sent = self._send(data)
            self._pending_bytes -= sent
            if sent < len(data):
                self._pending[0] = data[sent:]
                break
            self._pending.popleft()
        return not self._pending

    def read_lines(self) -> list[str]:
        """Return the complete lines that have arrived; never waits. After the last one `ended` may be true."""
        if self._awaited is not None:
            self._connect(self._awaited)
        found: list[str] = []
        got = 0
        while (data := self._receive(got)) is not None:
            if not data:
                self.ended = True
                break
            got += len(data)
            self._partial += data
            if b"\n" in data:
                *whole, rest = bytes(self._partial).split(b"\n")
                self._partial = bytearray(rest)
                found += [line.decode("utf-8", "replace") for line in whole]
            if len(self._partial) > self._longest:
                raise ChannelError(f"a line of more than {self._longest} bytes")
        return found

    def drain_and_close(self, seconds: float) -> None:
        """Send pending data, wait until the peer has read it, at most `seconds`, and close this end.

        Closing at once would reset the connection of a peer that still sends, and it would lose unread lines.
        """
        deadline = time.monotonic() + seconds
        with contextlib.suppress(OSError):
            self.flush()
            self.socket.shutdown(socket.SHUT_WR)
            while (left := deadline - time.monotonic()) > 0.0:
                self.socket.settimeout(left)
                if not self.socket.recv(CHUNK_BYTES):
                    break
        self.close()

    def close(self) -> None:
        """Close this end."""
        self.before_close()
        self.ended = True
        self.socket.close()
        if self._awaited is not None:
            self._awaited.close()

    def _send_data(self, data: bytes) -> None:
        if self.ended or self._pending_bytes + len(data) > self._most:
            self.dropped += 1
            return
        self.sent += 1
        if self.flush():
            sent = self._send(data)
            data = data[sent:]
        if data and not self.ended:
            self._pending.append(data)
            self._pending_bytes += len(data)

    def _receive(self, got: int) -> bytes | None:
        """Return received data; None if nothing is pending, empty if the peer is gone. `got`: bytes so far in this
        call."""
        if got % CHUNK_BYTES or self._awaited is not None:
            return None
        try:
            return self.socket.recv(CHUNK_BYTES)
        except (BlockingIOError, InterruptedError):
            return None
        except OSError:
            return b""

    def _send(self, data: bytes) -> int:
        if self._awaited is not None:
            return 0
        try:
            return self.socket.send(data, NO_SIGNAL)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError:
            self.ended = True
            return 0


def _prepare_socket(sock: socket.socket) -> None:
    sock.setblocking(False)
    for which in (socket.SO_SNDBUF, socket.SO_RCVBUF):
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, which, BUFFER)
