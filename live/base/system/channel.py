"""Connections between a process and the children that it starts.

On Linux a child inherits its end of a socket pair. Elsewhere the parent listens on loopback, the child connects and
shows a token that it got through its standard input, which no other process sees.
"""

import contextlib
import os
import socket
import struct
import subprocess
import threading
from collections.abc import Sequence
from typing import Any, Final

from live.base.system.features import LINUX
from live.base.system.process_control import own_session

MAX_PACKET_BYTES: Final = 1 << 20
"""Longest packet; a longer one violates the protocol and ends the connection."""
_LENGTH: Final = struct.Struct("<I")
NO_SIGNAL: Final = getattr(socket, "MSG_NOSIGNAL", 0)
"""Flag of `send`: a connection that has ended is an error and no signal."""


class PacketSocket:
    """Packets over a stream: `send` and `recv` as of a socket of packets. Threads: one that receives, any that send."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._received = bytearray()
        self._unsent = b""
        self._sending = threading.Lock()

    def fileno(self) -> int:
        """Return the descriptor, for `select`: `recv` reads no further than its packet."""
        return self._socket.fileno()

    def setblocking(self, blocking: bool) -> None:
        """Whether `recv` waits; `send` never does."""
        self._socket.setblocking(blocking)

    def send(self, data: bytes) -> int:
        """Send a packet; BlockingIOError if the one before does not fit yet, another OSError if the peer has gone."""
        with self._sending:
            self._flush()
            if self._unsent:
                raise BlockingIOError
            self._unsent = _LENGTH.pack(len(data)) + data
            self._flush()
        return len(data)

    def _flush(self) -> None:
        while self._unsent:
            try:
                sent = self._socket.send(self._unsent, NO_SIGNAL)
            except (BlockingIOError, InterruptedError):
                return
            self._unsent = self._unsent[sent:]

    def recv(self, _most: int = MAX_PACKET_BYTES) -> bytes:
        """Return the next packet, empty if the peer has gone; BlockingIOError if none has arrived whole."""
        if self._unsent:
            with self._sending, contextlib.suppress(OSError):
                self._flush()
        while missing := self._missing_bytes():
            data = self._socket.recv(missing)
            if not data:
                return b""
            self._received += data
        packet = bytes(self._received[_LENGTH.size :])
        self._received.clear()
        return packet

    def _missing_bytes(self) -> int:
        """Return how many bytes of the next packet have not arrived, as far as is known."""
        if len(self._received) < _LENGTH.size:
            return _LENGTH.size - len(self._received)
        (length,) = _LENGTH.unpack_from(self._received)
        if length > MAX_PACKET_BYTES:
            raise ConnectionAbortedError("a packet is too long")
        return _LENGTH.size + int(length) - len(self._received)

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


Packets = socket.socket | PacketSocket
"""An end of a connection of packets."""


def start_child(
    command: Sequence[str], *words: str, packets: bool = False, inherit: Sequence[int] = (), **options: Any
) -> "tuple[socket.socket, subprocess.Popen[bytes]]":
    """Start a process with a connection to it; return this end, and the process. OSError if it cannot be started.

    The command gets a word for its end (`stream_of_argument`, `packets_of_argument`) and `words` as its last arguments.
    `packets`: a connection of whole packets, where Linux has them (see `packet_end`); `inherit`: descriptors that it
    inherits under the same numbers, on Linux; `options`: of `subprocess.Popen`.
    """
    if not LINUX:
        from live.base.system.loopback import start_on_loopback

        return start_on_loopback(command, *words, **options)
    mine, theirs = packet_pair() if packets else socket.socketpair()
    try:
        with theirs:
            return mine, subprocess.Popen(
                [*command, str(theirs.fileno()), *words],
                stdin=subprocess.DEVNULL, pass_fds=(theirs.fileno(), *inherit), **own_session(), **options,
            )  # fmt: skip
    except BaseException:
        mine.close()
        raise


def packet_pair() -> tuple[socket.socket, socket.socket]:
    """Return both ends of a connection of packets, for several processes to inherit (Linux)."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def packet_end(sock: socket.socket) -> Packets:
    """Return the parent's end of a connection of packets."""
    return sock if LINUX else PacketSocket(sock)


async def receive_packet(channel: Packets) -> bytes:
    """Return the next packet of a channel that does not block, empty if the peer has gone."""
    import asyncio

    loop = asyncio.get_running_loop()
    while True:
        with contextlib.suppress(BlockingIOError):
            return channel.recv(MAX_PACKET_BYTES)
        ready = asyncio.Event()
        loop.add_reader(channel, ready.set)
        try:
            await ready.wait()
        finally:
            loop.remove_reader(channel)


def stream_of_argument(word: str) -> socket.socket:
    """Return a child's end of its connection; OSError if the parent has gone."""
    if word.isdecimal():
        return socket.socket(fileno=int(word))
    from live.base.system.loopback import connect_to_parent

    return connect_to_parent(int(word.removeprefix("tcp:")))


def packets_of_argument(word: str) -> Packets:
    """Return a child's end of its connection of packets; OSError if the parent has gone."""
    sock = stream_of_argument(word)
    return sock if word.isdecimal() else PacketSocket(sock)


def hand_over(sock: socket.socket) -> tuple[int | list[Any], tuple[int, ...]]:
    """Return how a child finds a listening socket (`listening_socket_of`), and the descriptors that it has to inherit.

    Where there are none the socket is closed, because the child listens at its address itself.
    """
    if LINUX:
        return sock.fileno(), (sock.fileno(),)
    where = sock.getsockname()[:2]
    sock.close()
    return list(where), ()


def listening_socket_of(found: int | Sequence[Any]) -> socket.socket:
    """Return in a child the listening socket that its parent handed over; OSError if the port is in use by now."""
    if isinstance(found, int):
        return socket.socket(fileno=found)
    family = socket.AF_INET6 if ":" in found[0] else socket.AF_INET
    return create_server((str(found[0]), int(found[1])), family=family, backlog=1024)


def create_server(where: tuple[str, int], *, family: int, backlog: int) -> socket.socket:
    """Return a listening socket whose port other processes of this user may share, where the system allows that."""
    return socket.create_server(
        where, family=family, backlog=backlog, reuse_port=LINUX and hasattr(socket, "SO_REUSEPORT")
    )


def share_port(sock: socket.socket) -> None:
    """Let other sockets bind the same port, for groups that several programs listen to (multicast)."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if hasattr(socket, "SO_REUSEPORT"):
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)


def parent_has_gone() -> bool:
    """Whether this process has lost its parent (Linux gives it to process 1; elsewhere its connection ends)."""
    return LINUX and os.getppid() == 1
