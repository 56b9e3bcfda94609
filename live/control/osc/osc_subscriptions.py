"""OSC subscriptions to changed values, bounded in number, duration and data rate."""

import ipaddress
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from live.control.osc.osc_codec import bundles, encode
from live.control.registry.control import ArgumentValue
from live.control.registry.registry import READABLE, REGISTRY, Rows, Values

MAX_SUBSCRIBERS: Final = 16
MAX_PREFIXES: Final = 16
"""Maximum number of addresses per subscriber."""
MAX_SECONDS: Final = 3600.0
"""Maximum duration of a subscription [s]; after it the subscriber has to renew it."""
UPDATE_INTERVAL: Final = 1 / 30
"""Minimum interval between two updates of one subscriber [s] ..."""
MAX_VALUES: Final = 48
"""... with at most so many values; each is sent as it is at that time."""
ECHO_DELAY: Final = 1.0
"""Seconds for which the sender of a value is not notified of it, until it has taken effect."""
TOLERANCE: Final = 1e-4
"""Relative tolerance between a number that was set and the show's, which is rounded in transit."""

SocketAddress = tuple[Any, ...]
"""Host and port, and for IPv6 also flow and scope."""
_ORDER: Final = {address: place for place, address in enumerate(READABLE)}


@dataclass(slots=True)
class _Subscriber:
    where: SocketAddress
    source: SocketAddress
    """The address it sends from; many clients receive at another port."""
    prefixes: dict[str, float] = field(default_factory=dict)
    """Subscribed address prefixes, each with the time when it expires."""
    next: float = 0.0
    due: dict[str, float] = field(default_factory=dict)
    """Changed addresses, each with the earliest time to send it."""
    last_sent: dict[str, Rows] = field(default_factory=dict)

    def is_subscribed(self, address: str) -> bool:
        """Whether it has subscribed to an address."""
        return any(_under(address, part) for part in self.prefixes)


@dataclass(frozen=True, slots=True)
class _Setter:
    """The last sender that set a value."""

    source: SocketAddress
    values: tuple[object, ...]
    until: float
    """Time until which the value may not have taken effect yet."""


class Subscribers:
    """The subscribers of one port. Use from the port's thread; `active` from any thread."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self.by_address: dict[SocketAddress, _Subscriber] = {}
        """The subscribers by the address that they receive at."""
        self._setters: dict[str, _Setter] = {}
        self.refused = 0
        """Number of subscriptions refused for lack of room."""
        self.sent = 0
        """Number of values sent."""

    @property
    def active(self) -> int:
        """The number of subscribers."""
        return len(self.by_address)

    def add(self, where: SocketAddress, source: SocketAddress, prefix: str, seconds: float, now: float) -> bool:
        """Subscribe `where` to an address prefix for `seconds`, starting with all current values; False: no room.

        `source`: the address it sends from; it is not notified of values that it set itself.
        """
        self._expire(now)
        one = self.by_address.get(where)
        full = (
            len(self.by_address) >= MAX_SUBSCRIBERS
            if one is None
            else prefix not in one.prefixes and len(one.prefixes) >= MAX_PREFIXES
        )
        if full:
            self.refused += 1
            return False
        if one is None:
            one = self.by_address[where] = _Subscriber(where, source)
        if prefix not in one.prefixes:
            one.due |= {address: now for address in READABLE if address in self._values and _under(address, prefix)}
        one.source, one.prefixes[prefix] = source, now + min(seconds, MAX_SECONDS)
        return True

    def remove(self, where: SocketAddress) -> None:
        """End its subscription; does nothing if there is none."""
        self.by_address.pop(where, None)

    def record_setter(self, source: SocketAddress, address: str, values: tuple[object, ...], now: float) -> None:
        """Record that `source` sets a value; it is notified only if the show's value turns out different."""
        if self.by_address and address in self._values:
            self._setters[address] = _Setter(source, values, now + ECHO_DELAY)
            for one in self.by_address.values():
                if one.source == source and one.is_subscribed(address):
                    one.due[address] = now + ECHO_DELAY

    def mark_changed(self, addresses: Iterable[str], now: float) -> None:
        """Mark addresses as changed."""
        for address in addresses:
            for one in self.by_address.values():
                if one.is_subscribed(address):
                    one.due.setdefault(address, now)

    def seconds_to_next(self) -> float | None:
        """Return the seconds until `send_due` should be called again; None: no subscribers."""
        return UPDATE_INTERVAL if self.by_address else None

    def send_due(self, now: float, send: Callable[[bytes, SocketAddress], None]) -> None:
        """Send the updates that are due."""
        self._expire(now)
        for one in self.by_address.values():
            if one.due and now >= one.next:
                one.next = now + UPDATE_INTERVAL
                for datagram in bundles(self._updates(one, now)):
                    send(datagram, one.where)

    def _updates(self, one: _Subscriber, now: float) -> Iterator[bytes]:
        ready = [address for address, time in one.due.items() if time <= now]
        for address in sorted(ready, key=lambda address: _ORDER.get(address, 0))[:MAX_VALUES]:
            setter = self._setters.get(address)
            if setter is not None and setter.source != one.source:
                setter = None
            if setter is not None and setter.until > now:
                one.due[address] = setter.until
                continue
            del one.due[address]
            rows = self._values.rows(address)
            told = one.last_sent.get(address, ())
            known = told == rows if setter is None else _matches_set_value(address, rows, setter.values, told)
            one.last_sent[address] = rows
            if setter is not None:
                del self._setters[address]
            if not known:
                self.sent += len(rows)
                for where, values in self._values.messages(address):
                    yield encode(where, values)

    def _expire(self, now: float) -> None:
        for where, one in list(self.by_address.items()):
            for part in [part for part, until in one.prefixes.items() if until <= now]:
                del one.prefixes[part]
            if not one.prefixes:
                del self.by_address[where]
        if not self.by_address:
            self._setters.clear()


def _under(address: str, prefix: str) -> bool:
    return address == prefix or address.startswith(prefix if prefix.endswith("/") else prefix + "/")


def _matches_set_value(address: str, rows: Rows, said: tuple[object, ...], told: Rows) -> bool:
    """Whether the rows equal what was set; for a named control its row was set and all others are as last sent."""
    control = REGISTRY.find(address)
    if control is None or not control.named:
        return all(_are_close(now, said) for _, now in rows)
    before = dict(told)
    return all(_are_close(now, said[1:]) if name == said[0] else before.get(name) == now for name, now in rows)


def _are_close(now: tuple[ArgumentValue, ...], said: tuple[object, ...]) -> bool:
    return len(said) >= len(now) and all(map(_is_close, now, said))


def _is_close(now: ArgumentValue, said: object) -> bool:
    if isinstance(now, str) or not isinstance(said, int | float):
        return now == said
    return abs(float(now) - said) <= TOLERANCE * max(abs(float(now)), 1.0)


def is_local_network(host: str) -> bool:
    """Whether a host is this machine or in a local network.

    Other hosts never get more bytes than they sent, so that a forged sender address cannot amplify traffic.
    """
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return False
    mapped = getattr(address, "ipv4_mapped", None)
    return (mapped or address).is_private or address.is_link_local
