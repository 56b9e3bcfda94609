"""Addresses: which network address a phone has, behind proxies too, and which addresses are one group.

Forwarded addresses (X-Forwarded-For, and Forwarded of RFC 7239) are read only where a proxy that the venue names sent
the request. Each proxy adds the address that it saw at the right end; so the phone's is the rightmost that is no named
proxy's, and whatever a phone wrote there itself stands left of it.
"""

import ipaddress
import re
from collections.abc import Callable, Sequence
from typing import Final

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

MOST_HOPS: Final = 32
"""Entries that are read, from the right."""
LONGEST: Final = 4096
"""Characters of a header that are read, from the right."""
PREFIX: Final = 64
"""Bits of an IPv6 address that name a subscriber's network; the others a device chooses, as often as it likes."""
_ELEMENT: Final = re.compile(r'(?:[^,"]|"(?:[^"\\]|\\.)*"|")+')
_FOR: Final = re.compile(r'(?:^|;)\s*for\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^;"\s]+))\s*(?=;|$)', re.IGNORECASE)
_WITH_PORT: Final = re.compile(r"\[([^\]]+)\](?::\d{1,5})?|([\d.]+):\d{1,5}")


def address_of(text: str) -> Address | None:
    """An address as peers and headers write it, with or without a port or a zone; None for what is none.

    An IPv4 address in IPv6 (`::ffff:192.0.2.1`) is that IPv4 address.
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
    """Addresses of one group are as one: an IPv4 address is its own, IPv6 addresses of one /64 are one."""
    if address is None:
        return ""
    if isinstance(address, ipaddress.IPv4Address):
        return str(address)
    return f"{ipaddress.IPv6Address(int(address) >> (128 - PREFIX) << (128 - PREFIX))}/{PREFIX}"


class Proxies:
    """The proxies that a venue names, and what their requests say of whom they come from."""

    def __init__(self, networks: Sequence[str] = ()) -> None:
        """`networks`: addresses, or networks like `10.0.0.0/24`."""
        self._networks: tuple[Network, ...] = tuple(ipaddress.ip_network(each, strict=False) for each in networks)

    def names(self, address: Address | None) -> bool:
        """Whether an address is a proxy's."""
        return address is not None and any(
            address in network for network in self._networks if network.version == address.version
        )

    def sender(self, peer: str, forwarded_for: Sequence[str], forwarded: Sequence[str]) -> Address | None:
        """Who sent a request: `peer`, or whom its proxies name in their headers' values.

        The proxy's own address where its headers say nothing that can be read, or where the two headers differ: then
        one of them is the phone's own invention, and nobody knows which.
        """
        address = address_of(peer)
        if not self.names(address):
            return address
        chains = [each for each in (_hops(forwarded_for, _plain_hops), _hops(forwarded, _rfc_hops)) if each]
        found = {self._rightmost(chain) for chain in chains}
        return next(iter(found)) or address if len(found) == 1 else address

    def _rightmost(self, chain: Sequence[Address | None]) -> Address | None:
        """The rightmost that is no proxy's; the leftmost of nothing but proxies; None for what cannot be read."""
        for hop in reversed(chain):
            if not self.names(hop):
                return hop
        return chain[0]


def _plain_hops(text: str) -> list[str]:
    """The entries of X-Forwarded-For."""
    return text.split(",")


def _rfc_hops(text: str) -> list[str]:
    """What `for=` says in each element of Forwarded; empty where it says nothing."""
    found = []
    for element in _ELEMENT.findall(text):
        match = _FOR.search(element)
        quoted, token = match.groups() if match is not None else (None, None)
        found.append(re.sub(r"\\(.)", r"\1", quoted) if quoted is not None else token or "")
    return found


def _hops(values: Sequence[str], entries: Callable[[str], list[str]]) -> list[Address | None]:
    """The last addresses of a header, which may come several times, from left to right; None for what is none."""
    text = ",".join(values)
    if not text.strip():
        return []
    return [address_of(entry) for entry in entries(text[-LONGEST:])[-MOST_HOPS:]]
