"""OscSieve: before datagrams are taken apart, so that a flood costs little: what is plainly no OSC is counted, of plain
values that arrive together the last one of each control goes on, and who sends nothing but rubbish is not read for a
while.
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
"""So many more refused datagrams than good ones of a sender in a `ROUND` [s]: the rest of the round is not read."""
GATHER: Final = 0.015
"""Seconds for which values wait at most for later ones, while there is more to be read."""
MOST_SENDERS: Final = 4096
_NUMBERS: Final = frozenset(b"fidhTF")
_SLASH, _HASH = ord("/"), ord("#")

Pass = Callable[[bytes, Any], bool]
"""Takes a datagram apart; whether nothing in it was refused."""


class OscSieve:
    """One port's. Thread: the port's."""

    def __init__(self, registry: Registry, on: Pass, rejected: Tally) -> None:
        """`on`: what goes on goes there; what does not is counted in `rejected`."""
        self._registry, self._on, self._rejected = registry, on, rejected
        self._plain: dict[bytes, bool] = {}
        self._waiting: dict[bytes, tuple[bytes, Any]] = {}
        self._rubbish: dict[Any, int] = {}
        self._round_ends = self._release_at = 0.0
        self.replaced = 0
        """Values that a later one of their control replaced before anybody had looked at them."""

    @property
    def waits(self) -> bool:
        """Whether values wait here for later ones."""
        return bool(self._waiting)

    def take(self, datagrams: list[tuple[bytes, Any]], now: float, *, more: bool = False) -> Rejection | None:
        """Let what came together at `now` [s] pass; returns the last refusal of this sieve's own.

        `more`: there is more to be read, with which this may wait a little.
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
        """What has waited goes on."""
        if self._waiting:
            waiting = list(self._waiting.values())
            self._waiting.clear()
            for data, sender in waiting:
                self._hand_on(data, sender)

    def _hand_on(self, data: bytes, sender: Any) -> None:
        if not self._on(data, sender):
            self._refused = None  # this one is the last
            self._note_rubbish(sender)
        elif sender in self._rubbish:
            self._rubbish[sender] = max(self._rubbish[sender] - 1, 0)

    def _note_rubbish(self, sender: Any) -> None:
        if sender in self._rubbish or len(self._rubbish) < MOST_SENDERS:
            self._rubbish[sender] = self._rubbish.get(sender, 0) + 1

    def _learn(self, header: bytes) -> bool:
        """Whether messages that begin so say the value of a control with numbers alone: the last one counts."""
        if len(self._plain) >= MOST_HEADERS:
            self._plain.clear()
        address, _, tags = header.partition(b",")
        control: Control | None = None
        if address.isascii() and tags:
            control = self._registry.find(address.rstrip(b"\0").decode())
        tags = tags.rstrip(b"\0")
        plain = control is not None and control.value > 0 and len(tags) > 0 and _NUMBERS.issuperset(tags)
        if plain or control is not None:  # of addresses that there are not there is no end
            self._plain[header] = plain
        return plain


def _no_osc(data: bytes) -> Reason | None:
    """Why a datagram is plainly none."""
    size = len(data)
    if not 0 < size <= MAX_PACKET_BYTES:
        return Reason.PACKET_SIZE
    if size & 3:
        return Reason.ALIGNMENT
    return None if data[0] == _SLASH or data[0] == _HASH else Reason.ADDRESS


def _header(data: bytes) -> bytes:
    """Address and type tags of a message, empty for whatever is not one."""
    if data[0] != _SLASH:
        return b""
    comma = data.find(b",", 0, MAX_STRING_BYTES)
    return b"" if comma < 0 else data[: (data.find(b"\0", comma) + 4) & ~3]
