"""Prefilter for datagrams before they are decoded, so that a flood costs little.

Datagrams that cannot be OSC are counted and dropped. Of plain values that arrive together only the last one of each
control is passed on. A sender of mostly invalid datagrams is ignored for a while.
"""

from collections.abc import Callable
from typing import Any, Final

from live.control.osc.osc_codec import MAX_PACKET_BYTES, MAX_STRING_BYTES
from live.control.registry.control import Control
from live.control.registry.registry import Registry
from live.control.registry.rejections import Reason, Rejection, Tally

MOST_HEADERS: Final = 2048
ROUND: Final = 0.25
RUBBISH: Final = 250
"""Surplus of refused over good datagrams in a `ROUND` [s] after which the sender is ignored for the rest of it."""
GATHER: Final = 0.015
"""Maximum seconds for which values wait for later ones while there is more to read."""
MOST_SENDERS: Final = 4096
_NUMBERS: Final = frozenset(b"fidhTF")
_SLASH, _HASH = ord("/"), ord("#")

Pass = Callable[[bytes, Any], bool]
"""Handles a datagram; returns whether nothing in it was refused."""


class OscSieve:
    """Prefilter of one port. Use from the port's thread."""

    def __init__(self, registry: Registry, on: Pass, rejected: Tally) -> None:
        """`on`: receives the datagrams that pass; the others are counted in `rejected`."""
        self._registry, self._on, self._rejected = registry, on, rejected
        self._plain: dict[bytes, bool] = {}
        self._waiting: dict[bytes, tuple[bytes, Any]] = {}
        self._rubbish: dict[Any, int] = {}
        self._round_ends = self._release_at = 0.0
        self.replaced = 0
        """Number of values that a later one of their control replaced before they were decoded."""

    @property
    def waits(self) -> bool:
        """Whether values are held back for later ones."""
        return bool(self._waiting)

    def take(self, datagrams: list[tuple[bytes, Any]], now: float, *, more: bool = False) -> Rejection | None:
        """Filter datagrams received together at `now` [s]; return the last refusal made by the prefilter itself.

        `more`: there is more to read, so values may be held back a little.
        """
        if now >= self._round_ends:
            self._round_ends = now + ROUND
            self._rubbish.clear()
        self._refused: Rejection | None = None
        waiting, plain, rubbish = self._waiting, self._plain, self._rubbish
        for data, sender in datagrams:
            if rubbish and rubbish.get(sender, 0) >= RUBBISH:
                self._rejected.count(Reason.FLOOD)
                continue
            reason = _no_osc(data)
            if reason is not None:
                self._rejected.count(reason)
                self._refused = Rejection(reason, "", "an OSC packet", data[:16])
                self._note_rubbish(sender)
                continue
            header = _header(data)
            known = plain.get(header)
            if known is None:
                known = self._learn(header)
            if known:
                if header in waiting:
                    self.replaced += 1
                waiting[header] = (data, sender)
                continue
            self._release()
            self._hand_on(data, sender)
        if not more or now >= self._release_at:
            self._release_at = now + GATHER
            self._release()
        return self._refused

    def _release(self) -> None:
        """Pass on the values that were held back."""
        if self._waiting:
            waiting = list(self._waiting.values())
            self._waiting.clear()
            for data, sender in waiting:
                self._hand_on(data, sender)

    def _hand_on(self, data: bytes, sender: Any) -> None:
        if not self._on(data, sender):
            self._refused = None  # the handler's own refusal is the later one
            self._note_rubbish(sender)
        elif sender in self._rubbish:
            self._rubbish[sender] = max(self._rubbish[sender] - 1, 0)

    def _note_rubbish(self, sender: Any) -> None:
        if sender in self._rubbish or len(self._rubbish) < MOST_SENDERS:
            self._rubbish[sender] = self._rubbish.get(sender, 0) + 1

    def _learn(self, header: bytes) -> bool:
        """Whether messages with this header set a control's value by numbers only, so that the last one counts."""
        if len(self._plain) >= MOST_HEADERS:
            self._plain.clear()
        address, _, tags = header.partition(b",")
        control: Control | None = None
        if address.isascii() and tags:
            control = self._registry.find(address.rstrip(b"\0").decode())
        tags = tags.rstrip(b"\0")
        plain = control is not None and control.value > 0 and len(tags) > 0 and _NUMBERS.issuperset(tags)
        if plain or control is not None:  # unknown addresses are unbounded in number and are not cached
            self._plain[header] = plain
        return plain


def _no_osc(data: bytes) -> Reason | None:
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
    comma = data.find(b",", 0, MAX_STRING_BYTES)
    return b"" if comma < 0 else data[: (data.find(b"\0", comma) + 4) & ~3]
