"""Wire: lines both ways between two processes, never waited for by the show."""

import contextlib
import json
import socket
import time
from collections import deque
from typing import Any, Final

BUFFER: Final = 4 * 1024 * 1024
"""What the system is asked to hold of each direction."""
BACKLOG: Final = 256 * 1024 * 1024
"""Bytes that may wait on our own side before lines are dropped: a peer that reads no more."""
LONGEST: Final = 64 * 1024 * 1024
"""Bytes of one line; whoever sends a longer one is no peer of ours."""
PIECE: Final = 1 << 18


class WireBroken(Exception):
    """What came over the wire is not of this protocol."""


class Wire:
    """One end of a stream socket that carries lines.

    A line that has been taken by the system is read by the peer even when this process is killed at the next
    instruction: that is why events go through here before they act. Thread: one.
    """

    def __init__(self, sock: socket.socket, *, backlog: int = BACKLOG, longest: int | None = None) -> None:
        """`backlog`: bytes that may wait to be sent; `longest`: bytes of a line that comes."""
        _make_room(sock)
        self.socket = sock
        self.dropped = 0
        """Lines that were lost, because the peer is gone or reads no more."""
        self.ended = False
        """Whether the peer is gone."""
        self.taken, self.heard = 0, 0
        """Lines that were taken to be sent, and that were read and handed on: how two ends speak of the same line."""
        self._waiting: deque[bytes] = deque()
        self._waiting_bytes = 0
        self._most, self._longest = backlog, LONGEST if longest is None else longest
        self._part = bytearray()

    def renew(self, sock: socket.socket) -> None:
        """Go on with another peer, over another socket: all that is not sent or read yet is forgotten."""
        self.socket.close()
        _make_room(sock)
        self.socket = sock
        self.ended = False
        self.taken = self.heard = 0
        self._waiting.clear()
        self._waiting_bytes = 0
        self._part.clear()

    @property
    def behind(self) -> int:
        """Bytes that wait to be sent."""
        return self._waiting_bytes

    def fileno(self) -> int:
        """For selectors."""
        return self.socket.fileno()

    def put(self, line: str) -> None:
        """Send one line, without its end; what the system does not take at once waits for `flush`."""
        self._put((line + "\n").encode())

    def tell(self, **values: Any) -> None:
        """Send one JSON object."""
        self.put(json.dumps(values, separators=(",", ":")))

    def flush(self) -> bool:
        """Send what waits, as far as it can be sent now; whether nothing waits any more."""
        while self._waiting and not self.ended:
            data = self._waiting[0]
            sent = self._send(data)
            self._waiting_bytes -= sent
            if sent < len(data):
                self._waiting[0] = data[sent:]
                break
            self._waiting.popleft()
        return not self._waiting

    def lines(self) -> list[str]:
        """The whole lines that have arrived; never waits. After the last one `ended` may be true."""
        found: list[str] = []
        got = 0
        while (data := self._receive(got)) is not None:
            if not data:
                self.ended = True
                break
            got += len(data)
            self._part += data
            if b"\n" in data:
                *whole, rest = bytes(self._part).split(b"\n")
                self._part = bytearray(rest)
                found += [line.decode("utf-8", "replace") for line in whole]
            if len(self._part) > self._longest:
                raise WireBroken(f"a line of more than {self._longest} bytes")
        return found

    def part(self, seconds: float) -> None:
        """Close this end for good, once the peer has read what was put, or after `seconds`.

        A peer that still sends finds a stream that is closed broken, and would read no more from it.
        """
        deadline = time.monotonic() + seconds
        with contextlib.suppress(OSError):
            self.flush()
            self.socket.shutdown(socket.SHUT_WR)
            while (left := deadline - time.monotonic()) > 0.0:
                self.socket.settimeout(left)
                if not self.socket.recv(PIECE):
                    break
        self.close()

    def close(self) -> None:
        """Close this end."""
        self.ended = True
        self.socket.close()

    def _put(self, data: bytes) -> None:
        if self.ended or self._waiting_bytes + len(data) > self._most:
            self.dropped += 1
            return
        self.taken += 1
        if self.flush():
            sent = self._send(data)
            data = data[sent:]
        if data and not self.ended:
            self._waiting.append(data)
            self._waiting_bytes += len(data)

    def _receive(self, got: int) -> bytes | None:
        """What has come; None if that is all for now, nothing if the peer is gone. `got`: bytes so far, of these
        lines."""
        if got % PIECE:
            return None
        try:
            return self.socket.recv(PIECE)
        except (BlockingIOError, InterruptedError):
            return None
        except OSError:
            return b""

    def _send(self, data: bytes) -> int:
        try:
            return self.socket.send(data, socket.MSG_NOSIGNAL)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError:
            self.ended = True
            return 0


def _make_room(sock: socket.socket) -> None:
    sock.setblocking(False)
    for which in (socket.SO_SNDBUF, socket.SO_RCVBUF):
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, which, BUFFER)
