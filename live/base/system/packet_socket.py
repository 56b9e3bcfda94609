"""Packets over a stream, for systems without sockets of packets (SOCK_SEQPACKET of unix(7))."""

import contextlib
import socket
import struct
import threading
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from live.base.system.loopback import ChildConnection

MAX_BYTES: Final = 1 << 20
"""Longest packet that is received, a longer one ends the connection; and most bytes that wait to be sent."""
NO_SIGNAL: Final = getattr(socket, "MSG_NOSIGNAL", 0)
"""Flag of `send`: a connection that has ended is an error and no signal."""
_LENGTH: Final = struct.Struct("<I")


class PacketSocket:
    """`send` and `recv` as of a non-blocking socket of packets. Threads: one that receives, any that send."""

    def __init__(self, where: "socket.socket | ChildConnection") -> None:
        """`where`: a connection, or one that a child will make; until then packets wait."""
        self._where: socket.socket | ChildConnection = where
        self._blocks = False
        self._received = bytearray()
        self._unsent = bytearray()
        self._using = threading.Lock()
        if isinstance(where, socket.socket):
            where.setblocking(False)

    @property
    def connected(self) -> bool:
        """Whether the other end is there."""
        return isinstance(self._where, socket.socket)

    @property
    def unsent(self) -> int:
        """Bytes that `recv` or the next `send` will send."""
        return len(self._unsent)

    def fileno(self) -> int:
        """Return the descriptor, for `select` once it is connected; `recv` reads no further than its packet."""
        return self._where.fileno()

    def setblocking(self, blocks: bool) -> None:
        """Whether `send` and `recv` wait."""
        self._blocks = blocks
        if isinstance(self._where, socket.socket):
            self._where.setblocking(blocks)

    def _connected(self) -> socket.socket:
        """Return the connection; BlockingIOError if there is none yet, ConnectionError if there will be none."""
        if not isinstance(self._where, socket.socket):
            sock = self._where.wait() if self._blocks else self._where.accept()
            if sock is None:
                raise BlockingIOError
            sock.setblocking(self._blocks)
            self._where = sock
        return self._where

    def send(self, data: bytes) -> int:
        """Send a packet; BlockingIOError if those before do not fit yet, another OSError if the peer has gone."""
        with self._using:
            self._flush()
            waits = not self.connected and len(self._unsent) + len(data) < MAX_BYTES
            if self._unsent and not waits:
                raise BlockingIOError
            self._unsent += _LENGTH.pack(len(data)) + data
            self._flush()
        return len(data)

    def _flush(self) -> None:
        while self._unsent:
            try:
                sent = self._connected().send(self._unsent, NO_SIGNAL)
            except (BlockingIOError, InterruptedError):
                return
            del self._unsent[:sent]

    def recv(self, most: int = MAX_BYTES) -> bytes:
        """Return the next packet, empty if the peer has gone; BlockingIOError if none has arrived whole.

        `most`: the bytes of a longer packet after these are lost, as with any socket of packets.
        """
        with self._using:
            sock = self._connected()
            with contextlib.suppress(OSError):  # of a peer that has gone, the last packets are read first
                self._flush()
        while missing := self._missing_bytes():
            data = sock.recv(missing)
            if not data:
                return b""
            self._received += data
        packet = bytes(self._received[_LENGTH.size : _LENGTH.size + most])
        self._received.clear()
        return packet

    def _missing_bytes(self) -> int:
        """Return how many bytes of the next packet have not arrived, as far as is known."""
        if len(self._received) < _LENGTH.size:
            return _LENGTH.size - len(self._received)
        (length,) = _LENGTH.unpack_from(self._received)
        if length > MAX_BYTES:
            raise ConnectionAbortedError("a packet is too long")
        return _LENGTH.size + int(length) - len(self._received)

    def close(self) -> None:
        """Close the connection."""
        self._where.close()
