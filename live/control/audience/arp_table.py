"""Reader for the kernel's neighbour table: the network card (link-layer address) of a local IP address.

A device that requests forty addresses by DHCP still has one radio. The table is read over netlink (RFC 3549,
rtnetlink(7)) with one dump for IPv4 and IPv6. No card is found where there is no such table: other systems than Linux,
networks behind a router, this machine itself. Cards are kept as keyed hashes, in memory only.
"""

import asyncio
import hashlib
import hmac
import ipaddress
import socket
import struct
import time
from collections.abc import Iterator
from typing import Final

from live.control.audience.client_address import Address

RTM_NEWNEIGH: Final = 28
RTM_GETNEIGH: Final = 30
NLMSG_ERROR: Final = 2
NLMSG_DONE: Final = 3
_DUMP: Final = 0x301
"""NLM_F_REQUEST | NLM_F_DUMP."""
_NDA_DST: Final = 1
_NDA_LLADDR: Final = 2
_FAILED: Final = 0x20 | 0x01
"""NUD_FAILED, NUD_INCOMPLETE: the address did not answer."""
_MESSAGE: Final = struct.Struct("=IHHII")
_NEIGHBOUR: Final = struct.Struct("=BxHiHBB")
_ATTRIBUTE: Final = struct.Struct("=HH")
MAX_ENTRIES: Final = 65_536
"""Maximum entries read."""
TIMEOUT: Final = 0.2
"""Time-out for the kernel's answer [s]."""
READ_TIME_RATIO: Final = 10.0
"""Reading takes at most one part in this many of the time."""
STALE: Final = 2.0
"""A table older than this [s] is read again."""


def parse_neighbours(data: bytes) -> Iterator[tuple[Address, bytes] | None]:
    """Return (address, link-layer address) of each entry of a dump, then None at its end; a broken message ends it."""
    begin = 0
    while begin + _MESSAGE.size <= len(data):
        size, kind, *_ = _MESSAGE.unpack_from(data, begin)
        if kind in (NLMSG_DONE, NLMSG_ERROR) or not _MESSAGE.size <= size <= len(data) - begin:
            yield None
            return
        if kind == RTM_NEWNEIGH:
            found = _parse_neighbour(data[begin + _MESSAGE.size : begin + size])
            if found is not None:
                yield found
        begin += (size + 3) & ~3


def _parse_neighbour(body: bytes) -> tuple[Address, bytes] | None:
    if len(body) < _NEIGHBOUR.size:
        return None
    _, _, _, state, _, _ = _NEIGHBOUR.unpack_from(body)
    address: Address | None = None
    card, begin = b"", _NEIGHBOUR.size
    while begin + _ATTRIBUTE.size <= len(body):
        size, kind = _ATTRIBUTE.unpack_from(body, begin)
        if size < _ATTRIBUTE.size or begin + size > len(body):
            return None
        value = body[begin + _ATTRIBUTE.size : begin + size]
        if kind == _NDA_DST and len(value) in (4, 16):
            address = ipaddress.ip_address(value)
        elif kind == _NDA_LLADDR:
            card = value
        begin += (size + 3) & ~3
    if address is None or not any(card) or state & _FAILED:
        return None
    return address, card


class ArpTable:
    """Cached copy of the neighbour table. Thread: the gateway's loop."""

    def __init__(self, secret: bytes) -> None:
        self._secret = secret
        self._cards: dict[Address, bytes] = {}
        self._read_at = -1e9
        self._rest = 0.0
        self._available = hasattr(socket, "AF_NETLINK")

    async def card_of(self, address: Address) -> str:
        """Return an identifier of the network card with this address; empty if it is unknown.

        The kernel's table contains every recent sender, so a missing address causes another read.
        """
        if address.is_loopback or not self._available:
            return ""
        if address not in self._cards or time.monotonic() > self._read_at + max(STALE, self._rest):
            wait = self._read_at + self._rest - time.monotonic()
            if wait > 0.0:
                await asyncio.sleep(wait)
            if time.monotonic() >= self._read_at + self._rest:  # otherwise another waiting task has read it
                self._read()
        card = self._cards.get(address, b"")
        return "card " + hmac.new(self._secret, b"card " + card, hashlib.sha256).hexdigest()[:16] if card else ""

    def _read(self) -> None:
        began = time.monotonic()
        found: dict[Address, bytes] = {}
        try:
            for entry in _dump():
                found[entry[0]] = entry[1]
        except TimeoutError:
            pass
        except OSError:
            self._available = False  # a system without such a table is not asked again
        self._cards = found
        self._read_at = time.monotonic()
        self._rest = READ_TIME_RATIO * (self._read_at - began)


def _dump() -> Iterator[tuple[Address, bytes]]:
    """Return the kernel's table; OSError if there is none."""
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0) as asking:  # 0: NETLINK_ROUTE
        asking.settimeout(TIMEOUT)
        body = _NEIGHBOUR.pack(0, 0, 0, 0, 0, 0)
        asking.send(_MESSAGE.pack(_MESSAGE.size + len(body), RTM_GETNEIGH, _DUMP, 1, 0) + body)
        count = 0
        while count < MAX_ENTRIES:
            for entry in parse_neighbours(asking.recv(1 << 17)):
                if entry is None:
                    return
                yield entry
                count += 1
