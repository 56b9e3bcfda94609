"""Connection between a gateway and the reducer: packets of bytes over TLS 1.3 with pinned certificates on both sides.

Whoever uses it knows `publish`, `on_packet` and `on_end` only, so that another bus can take its place.
"""

import asyncio
import contextlib
import hashlib
import socket
import ssl
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

from live.base.fault_isolation import FAULTS
from live.control.tls import pinned_context

MAX_LINK_PACKET: Final = 1 << 18
"""Longest packet."""
MAX_UNSENT: Final = 8 << 20
"""Most bytes that wait to be sent; a peer that is further behind is cut off, and may connect again."""
MAX_UNSENT_FLEETING: Final = 1 << 16
"""With more unsent bytes a packet is left out that the next one replaces."""
HANDSHAKE_TIMEOUT: Final = 5.0
CONNECT_TIMEOUT: Final = 3.0


class Link(Protocol):
    """An end of a connection that carries packets."""

    on_packet: Callable[[bytes], None]
    on_end: Callable[[], None]

    def publish(self, packet: bytes, *, fleeting: bool = False) -> bool:
        """Send a packet; return whether that was possible. `fleeting`: it may be left out if the peer is behind."""

    def close(self) -> None:
        """End the connection."""


@dataclass(frozen=True, slots=True)
class LinkKeys:
    """By what both ends of a connection know each other."""

    identity: bytes = field(repr=False)
    """This machine's key and certificate (PEM)."""
    peers: tuple[bytes, ...]
    """Certificates (DER) of the machines that may be at the other end, with its own."""

    def names(self) -> dict[str, int]:
        """Return the fingerprints of these machines, each with its index."""
        return {hashlib.sha256(each).hexdigest(): index for index, each in enumerate(self.peers)}


class PacketLink(asyncio.Protocol):
    """A connection of packets, each with its length before it (u32, big-endian). Thread: the loop's."""

    def __init__(self, keys: LinkKeys, on_link: Callable[["PacketLink"], None] = lambda link: None) -> None:
        self._keys, self._on_link = keys, on_link
        self._transport: Any = None
        self._data = bytearray()
        self.on_packet: Callable[[bytes], None] = lambda packet: None
        self.on_end: Callable[[], None] = lambda: None
        self.fingerprint = ""
        """Of the certificate of the machine at the other end."""
        self.left_out = 0
        """Packets that were left out."""

    def connection_made(self, transport: Any) -> None:
        """Check who is at the other end."""
        self._transport = transport
        secure = transport.get_extra_info("ssl_object")
        found = None if secure is None else secure.getpeercert(binary_form=True)
        self.fingerprint = "" if found is None else hashlib.sha256(found).hexdigest()
        if self.fingerprint not in self._keys.names():
            transport.abort()
            return
        sock = transport.get_extra_info("socket")
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._on_link(self)

    def data_received(self, data: bytes) -> None:
        """Hand on whole packets."""
        buffer = self._data
        buffer += data
        begin = 0
        while len(buffer) - begin >= 4:
            size = int.from_bytes(buffer[begin : begin + 4], "big")
            if size > MAX_LINK_PACKET:
                self.close()
                return
            end = begin + 4 + size
            if len(buffer) < end:
                break
            packet = bytes(buffer[begin + 4 : end])
            begin = end
            try:
                self.on_packet(packet)
            except Exception as error:
                FAULTS.record("a packet between gateways", error)
        del buffer[:begin]

    def publish(self, packet: bytes, *, fleeting: bool = False) -> bool:
        """Send a packet; return whether that was possible."""
        transport = self._transport
        if transport is None or transport.is_closing():
            return False
        waiting = transport.get_write_buffer_size()
        if fleeting and waiting > MAX_UNSENT_FLEETING:
            self.left_out += 1
            return False
        if waiting > MAX_UNSENT:
            transport.abort()
            return False
        transport.write(len(packet).to_bytes(4, "big") + packet)
        return True

    def close(self) -> None:
        """End the connection."""
        if self._transport is not None:
            self._transport.abort()

    def connection_lost(self, error: Exception | None) -> None:
        """Tell whoever uses it."""
        self.on_end()


async def connect(where: tuple[str, int], keys: LinkKeys) -> PacketLink:
    """Connect to the reducer; OSError or ssl.SSLError if that fails."""
    context = pinned_context(ssl.PROTOCOL_TLS_CLIENT, keys.identity, keys.peers)
    made: asyncio.Future[PacketLink] = asyncio.get_running_loop().create_future()

    def take(link: PacketLink) -> None:
        if not made.done():
            made.set_result(link)

    async with asyncio.timeout(CONNECT_TIMEOUT):
        transport, _ = await asyncio.get_running_loop().create_connection(
            lambda: PacketLink(keys, take), *where, ssl=context, server_hostname="",
            ssl_handshake_timeout=HANDSHAKE_TIMEOUT,
        )  # fmt: skip
    if not made.done():
        transport.close()
        raise ConnectionError("the machine there is not paired")
    return made.result()
