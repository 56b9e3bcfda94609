"""mDNS announcement of OSCQuery and OSC, by zeroconf.

A server at one address is announced there only. By default zeroconf listens on the wildcard address regardless of
`interfaces`, so that the machine's other networks reach it. Here it gets sockets bound to that address and to the
multicast group.
"""

import asyncio
import contextlib
import ipaddress
import socket
import struct
from typing import TYPE_CHECKING, Any, Final

from live.base.system.channel import share_port

if TYPE_CHECKING:
    from zeroconf.asyncio import AsyncZeroconf

PORT: Final = 5353
GROUP: Final = {4: "224.0.0.251", 6: "ff02::fb"}
HOPS: Final = 255
IP_MULTICAST_ALL: Final = 49
IPV6_MULTICAST_ALL: Final = 29
"""Linux: when enabled (the default), a socket receives groups on all interfaces that any program has joined."""
WILDCARDS: Final = ("0.0.0.0", "::")


def service_host(port: int) -> str:
    """Return the host name of the announced services."""
    return f"live-{port}.local"


class Announcement:
    """Announcement of one server. Thread: the loop's."""

    def __init__(self, name: str, http: tuple[str, int], osc_port: int) -> None:
        """`http`: the server's address; "0.0.0.0" is announced in all networks, another address in its own."""
        self._name = "".join(c for c in name if c.isalnum() or c in " -_")[:40].strip() or "Live"
        self._http, self._osc_port = http, osc_port
        self._zeroconf: AsyncZeroconf | None = None

    async def start(self) -> str:
        """Announce the services; return a description of a failure (no multicast, another program). HTTP
        works anyway."""
        try:
            from zeroconf.asyncio import AsyncServiceInfo

            host, port = self._http
            self._zeroconf = _zeroconf(host)
            addresses = _own_addresses() if host in WILDCARDS else [host]
            found = [
                AsyncServiceInfo(
                    kind, f"{self._name}.{kind}", parsed_addresses=addresses, port=at, server=f"{service_host(port)}."
                )
                for kind, at in (("_oscjson._tcp.local.", port), ("_osc._udp.local.", self._osc_port))
            ]
            register = self._zeroconf.async_register_service
            await asyncio.gather(*(register(info, allow_name_change=True) for info in found))
        except Exception as error:  # any network error
            await self.stop()
            return f"not announced by zeroconf: {type(error).__name__}: {error}"
        return ""

    async def stop(self) -> None:
        """Withdraw the announcement."""
        if self._zeroconf is not None:
            with contextlib.suppress(Exception):
                await self._zeroconf.async_unregister_all_services()
                await self._zeroconf.async_close()
            self._zeroconf = None


def _zeroconf(host: str) -> "AsyncZeroconf":
    """Return zeroconf for all networks, or only for the network of an address."""
    from zeroconf import InterfaceChoice, Zeroconf
    from zeroconf.asyncio import AsyncZeroconf

    if host in WILDCARDS:
        return AsyncZeroconf(interfaces=InterfaceChoice.All)

    class AtOneAddress(Zeroconf):
        """A unicast instance, which is bound to the address alone, with multicast sockets added."""

        def start(self) -> None:
            engine: Any = self.engine
            for made in engine._respond_sockets:
                made.close()
            engine._listen_socket, sender = sockets_at(host)
            engine._respond_sockets = [sender]
            self.unicast = False
            super().start()

    return AsyncZeroconf(zc=AtOneAddress(interfaces=[host], unicast=True))


def sockets_at(address: str) -> tuple[socket.socket, socket.socket]:
    """Return a socket that receives the multicast group only on the interface of `address`, and a sender socket."""
    version = ipaddress.ip_address(address).version
    group = GROUP[version]
    if version == 4:
        listening, sender = _shared_socket(socket.AF_INET), _shared_socket(socket.AF_INET)
        here = socket.inet_aton(address)
        with contextlib.suppress(OSError):  # Linux only
            listening.setsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL, 0)
        listening.bind((group, PORT))
        listening.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group) + here)
        sender.bind((address, PORT))
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, here)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, HOPS)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
    else:
        listening, sender = _shared_socket(socket.AF_INET6), _shared_socket(socket.AF_INET6)
        index = _interface_of(address)
        with contextlib.suppress(OSError):
            listening.setsockopt(socket.IPPROTO_IPV6, IPV6_MULTICAST_ALL, 0)
        listening.bind((group, PORT, 0, index))
        member = socket.inet_pton(socket.AF_INET6, group) + struct.pack("@I", index)
        listening.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, member)
        sender.bind((address, PORT))
        sender.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, index)
        sender.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, HOPS)
        sender.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_LOOP, 1)
    return listening, sender


def _shared_socket(family: socket.AddressFamily) -> socket.socket:
    """Return a datagram socket that shares its port with other mDNS programs."""
    made = socket.socket(family, socket.SOCK_DGRAM)
    made.setblocking(False)
    share_port(made)
    if family == socket.AF_INET6:
        made.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
    return made


def _interface_of(address: str) -> int:
    """Return the index of the interface with this IPv6 address."""
    import ifaddr

    wanted = ipaddress.ip_address(address)
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            if ip.is_IPv6 and ipaddress.ip_address(ip.ip[0]) == wanted and adapter.index is not None:
                return int(adapter.index)
    raise OSError(f"no interface has the address {address}")


def _own_addresses() -> list[str]:
    import ifaddr

    found = [str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
    return [address for address in found if not address.startswith("127.")] or ["127.0.0.1"]
