"""Prefilter for datagrams before they are decoded, so that a flood costs little.

Datagrams that cannot be OSC are counted and dropped. Of plain values that arrive together only the last one of each
control is passed on. A sender of mostly invalid datagrams is ignored for a while.
"""

from collections.abc import Callable
from typing import Any, Final

from live.control.osc.osc_codec import MAX_ADDRESS_BYTES, MAX_PACKET_BYTES
from live.control.registry.control import Control
from live.control.registry.registry import Registry
from live.control.registry.rejections import Reason, Rejection, Tally

MAX_HEADERS: Final = 2048
FLOOD_WINDOW: Final = 0.25
MAX_INVALID_SURPLUS: Final = 250
"""Surplus of refused over good datagrams in a `ROUND` [s] after which the sender is ignored for the rest of it."""
MAX_DELAY: Final = 0.015
"""Maximum seconds for which values wait for later ones while there is more to read."""
MAX_SENDERS: Final = 4096
_NUMBERS: Final = frozenset(b"fidhTF")
_SLASH, _HASH = ord("/"), ord("#")

HandleDatagram = Callable[[bytes, Any], bool]
"""Handles a datagram; returns whether nothing in it was refused."""


class OscPrefilter:
    """Prefilter of one port. Use from the port's thread."""

    def __init__(self, registry: Registry, handle: HandleDatagram, rejected: Tally) -> None:
        """`handle`: receives the datagrams that pass; the others are counted in `rejected`."""
        self._registry, self._handle, self._rejected = registry, handle, rejected
        self._plain_headers: dict[bytes, bool] = {}
        self._pending: dict[bytes, tuple[bytes, Any]] = {}
        self._invalid_surplus: dict[Any, int] = {}
        self._round_ends = self._release_at = 0.0
        self.replaced = 0
        """Number of values that a later one of their control replaced before they were decoded."""

    @property
    def has_pending(self) -> bool:
        """Whether values are held back for later ones."""
        return bool(self._pending)

    def process(self, datagrams: list[tuple[bytes, Any]], now: float, *, more: bool = False) -> Rejection | None:
        """Filter datagrams received together at `now` [s]; return the last refusal made by the prefilter itself.

        `more`: there is more to read, so values may be held back a little.
        """
        if now >= self._round_ends:
            self._round_ends = now + FLOOD_WINDOW
            self._invalid_surplus.clear()
        self._refused: Rejection | None = None
        waiting, plain, rubbish = self._pending, self._plain_headers, self._invalid_surplus
        for data, sender in datagrams:
            if rubbish and rubbish.get(sender, 0) >= MAX_INVALID_SURPLUS:
                self._rejected.count(Reason.FLOOD)
                continue
            reason = _rejection_reason(data)
            if reason is not None:
                self._rejected.count(reason)
                self._refused = Rejection(reason, "", "an OSC packet", data[:16])
                self._count_invalid(sender)
                continue
            header = _header(data)
            known = plain.get(header)
            if known is None:
                known = self._is_plain_value(header)
            if known:
                if header in waiting:
                    self.replaced += 1
                waiting[header] = (data, sender)
                continue
            self._release()
            self._pass_on(data, sender)
        if not more or now >= self._release_at:
            self._release_at = now + MAX_DELAY
            self._release()
        return self._refused

    def _release(self) -> None:
        """Pass on the values that were held back."""
        if self._pending:
            waiting = list(self._pending.values())
            self._pending.clear()
            for data, sender in waiting:
                self._pass_on(data, sender)

    def _pass_on(self, data: bytes, sender: Any) -> None:
        if not self._handle(data, sender):
            self._refused = None  # the handler's own refusal is the later one
            self._count_invalid(sender)
        elif sender in self._invalid_surplus:
            self._invalid_surplus[sender] = max(self._invalid_surplus[sender] - 1, 0)

    def _count_invalid(self, sender: Any) -> None:
        if sender in self._invalid_surplus or len(self._invalid_surplus) < MAX_SENDERS:
            self._invalid_surplus[sender] = self._invalid_surplus.get(sender, 0) + 1

    def _is_plain_value(self, header: bytes) -> bool:
        """Whether messages with this header set a control's value by numbers only, so that the last one counts."""
        if len(self._plain_headers) >= MAX_HEADERS:
            self._plain_headers.clear()
        address, _, tags = header.partition(b",")
        control: Control | None = None
        if address.isascii() and tags:
            control = self._registry.find(address.rstrip(b"\0").decode())
        tags = tags.rstrip(b"\0")
        plain = control is not None and control.value > 0 and len(tags) > 0 and _NUMBERS.issuperset(tags)
        if plain or control is not None:  # unknown addresses are unbounded in number and are not cached
            self._plain_headers[header] = plain
        return plain


def _rejection_reason(data: bytes) -> Reason | None:
    """Return why a datagram cannot be OSC; None if it may be."""
    size = len(data)
    if not 0 < size <= MAX_PACKET_BYTES:
        return Reason.PACKET_SIZE
    if size & 3:
        return Reason.ALIGNMENT
    return None if data[0] == _SLASH or data[0] == _HASH else Reason.ADDRESS


def _header(data: bytes) -> bytes:
    """Return the address and type tags of a message; empty for anything else."""
    if data[0] != _SLASH:
        return b""
    comma = data.find(b",", 0, MAX_ADDRESS_BYTES)
    return b"" if comma < 0 else data[: (data.find(b"\0", comma) + 4) & ~3]
