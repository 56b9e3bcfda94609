"""Connections to children over loopback TCP, for systems on which a child inherits no socket.

The parent listens at a free port of loopback. The child connects and shows a token, which it got through its standard
input: no other process sees it. Whoever else connects is refused.
"""

import contextlib
import hmac
import secrets
import select
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Any, Final

from live.base.system.process_control import own_session

CONNECT_TIMEOUT: Final = 30.0
"""Seconds for a child to start and connect, on a busy machine."""
TOKEN_TIMEOUT: Final = 2.0
"""Seconds for a connection to show its token."""
TOKEN_BYTES: Final = 32
MAX_GUESTS: Final = 8
"""Most connections that have not shown a token yet; further ones wait."""
LOOPBACK: Final = "127.0.0.1"


class ChildConnection:
    """The connection that a child will make, within `CONNECT_TIMEOUT`. Thread: one; nothing waits but `wait`."""

    def __init__(self, command: Sequence[str], words: Sequence[str], options: dict[str, Any]) -> None:
        """Start the command with a word for its end (`connect_to_parent`) and `words`; OSError if it cannot be."""
        self._deadline = time.monotonic() + CONNECT_TIMEOUT
        self._token = secrets.token_hex(TOKEN_BYTES // 2).encode()
        self.listening = socket.create_server((LOOPBACK, 0), backlog=4)
        """The socket at which it will arrive."""
        self.listening.setblocking(False)
        self._guests: list[tuple[float, socket.socket, bytearray]] = []
        where = f"tcp:{self.listening.getsockname()[1]}"
        try:
            self.process: subprocess.Popen[bytes] = subprocess.Popen(
                [*command, where, *words], stdin=subprocess.PIPE, **own_session(), **options
            )
        except BaseException:
            self.listening.close()
            raise
        assert self.process.stdin is not None
        with contextlib.suppress(OSError), self.process.stdin as to_child:  # one that has ended is noticed by `accept`
            to_child.write(self._token + b"\n")

    def fileno(self) -> int:
        """Return the descriptor of the socket that listens."""
        return self.listening.fileno()

    def accept(self) -> socket.socket | None:
        """Return the child's connection once it is there; OSError if the child has ended or takes too long."""
        now = time.monotonic()
        if len(self._guests) < MAX_GUESTS:
            with contextlib.suppress(OSError):
                sock, _ = self.listening.accept()
                sock.setblocking(False)
                self._guests.append((now, sock, bytearray()))
        for guest in list(self._guests):
            if (sock_or_none := self._check(guest, now)) is not None:
                self.close()
                sock_or_none.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return sock_or_none
        if self.process.poll() is not None:
            raise ConnectionError("the process ended before it connected")
        if now > self._deadline:
            raise TimeoutError("the process did not connect")
        return None

    def _check(self, guest: tuple[float, socket.socket, bytearray], now: float) -> socket.socket | None:
        since, sock, shown = guest
        try:
            data = sock.recv(TOKEN_BYTES - len(shown))
        except (BlockingIOError, InterruptedError):
            if now - since < TOKEN_TIMEOUT:
                return None
            data = b""
        except OSError:
            data = b""
        shown += data
        if data and len(shown) < TOKEN_BYTES:
            return None
        self._guests.remove(guest)
        if hmac.compare_digest(bytes(shown), self._token):
            return sock
        sock.close()
        return None

    def wait(self) -> socket.socket:
        """Wait for the child's connection; OSError, and the child is killed, if it does not come."""
        try:
            while (sock := self.accept()) is None:
                select.select([self.listening, *(guest[1] for guest in self._guests)], [], [], 0.05)
            return sock
        except BaseException:
            self.close()
            self.process.kill()
            self.process.wait()
            raise

    def close(self) -> None:
        """Accept nobody any more."""
        self.listening.close()
        for _, sock, _ in self._guests:
            sock.close()
        self._guests.clear()


def connect_to_parent(word: str) -> socket.socket:
    """Return a child's end of its connection; OSError if the parent has gone."""
    token = sys.stdin.readline().strip().encode()
    sock = socket.create_connection((LOOPBACK, int(word.removeprefix("tcp:"))), timeout=CONNECT_TIMEOUT)
    sock.setblocking(True)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.sendall(token)
    return sock
