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


def start_on_loopback(
    command: Sequence[str], *words: str, **options: Any
) -> "tuple[socket.socket, subprocess.Popen[bytes]]":
    """Start a process and return the connection to it, and the process; OSError if it does not connect."""
    token = secrets.token_hex(TOKEN_BYTES // 2).encode()
    with socket.create_server(("127.0.0.1", 0), backlog=4) as listening:
        listening.setblocking(False)
        port = listening.getsockname()[1]
        process = subprocess.Popen(
            [*command, f"tcp:{port}", *words], stdin=subprocess.PIPE, **own_session(), **options
        )  # fmt: skip
        try:
            assert process.stdin is not None
            with process.stdin as to_child:
                to_child.write(token + b"\n")
            return _accept(listening, token, process), process
        except BaseException:
            process.kill()
            process.wait()
            raise


def _accept(listening: socket.socket, token: bytes, process: "subprocess.Popen[bytes]") -> socket.socket:
    """Return the connection of the child that shows the token; any other is closed."""
    deadline = time.monotonic() + CONNECT_TIMEOUT
    while (left := deadline - time.monotonic()) > 0.0:
        if process.poll() is not None:
            raise ConnectionError("the process ended at once")
        if not select.select([listening], [], [], min(left, 0.1))[0]:
            continue
        with contextlib.suppress(OSError):
            sock, _ = listening.accept()
            try:
                if hmac.compare_digest(_read_token(sock), token):
                    sock.setblocking(True)
                    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    return sock
            except OSError:
                pass
            sock.close()
    raise TimeoutError("the process did not connect")


def _read_token(sock: socket.socket) -> bytes:
    deadline, data = time.monotonic() + TOKEN_TIMEOUT, b""
    while len(data) < TOKEN_BYTES:
        sock.settimeout(max(deadline - time.monotonic(), 0.001))
        piece = sock.recv(TOKEN_BYTES - len(data))
        if not piece:
            break
        data += piece
    return data


def connect_to_parent(port: int) -> socket.socket:
    """Return a child's end of its connection; OSError if the parent has gone."""
    token = sys.stdin.readline().strip().encode()
    sock = socket.create_connection(("127.0.0.1", port), timeout=CONNECT_TIMEOUT)
    sock.setblocking(True)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.sendall(token)
    return sock
