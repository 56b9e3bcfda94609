"""Client addresses of phones, also behind proxies, and the grouping of addresses.

Forwarded addresses (X-Forwarded-For, and Forwarded of RFC 7239) are read only from requests of proxies that the venue
configured. Each proxy appends the address that it saw. The phone's address is therefore the rightmost one that belongs
to no configured proxy; anything that a phone wrote itself is left of it.
"""

import ipaddress
import re
from collections.abc import Callable, Sequence
from typing import Final

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

MOST_HOPS: Final = 32
"""Maximum entries read, from the right."""
MAX_HEADER_CHARS: Final = 4096
"""Maximum characters of a header read, from the right."""
PREFIX: Final = 64
"""Bits of an IPv6 address that identify a subscriber's network; a device chooses the others freely."""
_ELEMENT: Final = re.compile(r'(?:[^,"]|"(?:[^"\\]|\\.)*"|")+')
_FOR: Final = re.compile(r'(?:^|;)\s*for\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^;"\s]+))\s*(?=;|$)', re.IGNORECASE)
_WITH_PORT: Final = re.compile(r"\[([^\]]+)\](?::\d{1,5})?|([\d.]+):\d{1,5}")


def parse_address(text: str) -> Address | None:
    """Parse an address of a peer or header, with or without a port or a zone; None if it is no address.

    An IPv4 address mapped into IPv6 (`::ffff:192.0.2.1`) is returned as IPv4.
    """
    text = text.strip()
    match = _WITH_PORT.fullmatch(text)
    if match is not None:
        text = match[1] or match[2]
    try:
        found = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    mapped = found.ipv4_mapped if isinstance(found, ipaddress.IPv6Address) else None
    return mapped if mapped is not None else found


def group_of(address: Address | None) -> str:
    """Return the group of an address: an IPv4 address is its own group, and IPv6 addresses of one /64 are one group."""
    if address is None:
        return ""
    if isinstance(address, ipaddress.IPv4Address):
        return str(address)
    return f"{ipaddress.IPv6Address(int(address) >> (128 - PREFIX) << (128 - PREFIX))}/{PREFIX}"


class Proxies:
    """The venue's proxies, and the sender address in their requests."""

    def __init__(self, networks: Sequence[str] = ()) -> None:
        """`networks`: addresses, or networks like `10.0.0.0/24`."""
        self._networks: tuple[Network, ...] = tuple(ipaddress.ip_network(each, strict=False) for each in networks)

    def is_proxy(self, address: Address | None) -> bool:
        """Whether an address belongs to a proxy."""
        return address is not None and any(
            address in network for network in self._networks if network.version == address.version
        )

    def sender(self, peer: str, forwarded_for: Sequence[str], forwarded: Sequence[str]) -> Address | None:
        """Return the sender of a request: `peer`, or the address in its proxies' header values.

        If the headers cannot be read, or the two headers differ, the proxy's own address is returned: one of them is
        then forged, and it is unknown which.
        """
        address = parse_address(peer)
        if not self.is_proxy(address):
            return address
        chains = [each for each in (_hops(forwarded_for, _plain_hops), _hops(forwarded, _rfc_hops)) if each]
        found = {self._rightmost(chain) for chain in chains}
        return next(iter(found)) or address if len(found) == 1 else address

    def _rightmost(self, chain: Sequence[Address | None]) -> Address | None:
        """Return the rightmost address that is no proxy's; the leftmost if all are; None for an unreadable one."""
        for hop in reversed(chain):
            if not self.is_proxy(hop):
                return hop
        return chain[0]


def _plain_hops(text: str) -> list[str]:
    """Return the entries of X-Forwarded-For."""
    return text.split(",")


def _rfc_hops(text: str) -> list[str]:
    """Return the `for=` value of each element of Forwarded; empty where there is none."""
    found = []
    for element in _ELEMENT.findall(text):
        match = _FOR.search(element)
        quoted, token = match.groups() if match is not None else (None, None)
        found.append(re.sub(r"\\(.)", r"\1", quoted) if quoted is not None else token or "")
    return found


def _hops(values: Sequence[str], entries: Callable[[str], list[str]]) -> list[Address | None]:
    """Return the last addresses of a header that may be repeated, from left to right; None for invalid ones."""
    text = ",".join(values)
    if not text.strip():
        return []
    return [parse_address(entry) for entry in entries(text[-MAX_HEADER_CHARS:])[-MOST_HOPS:]]
