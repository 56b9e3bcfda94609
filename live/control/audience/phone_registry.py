"""Phones: everybody who is connected, by number and by group, with what each may send; in memory alone.

Tokens: tickets in the link on the projector, devices that have joined by one, and vouchers for a place later on.

All are numbers, signed with the show's secret; nothing of a person is in them. Whoever knows the secret, as a gateway
that was started again does, knows them again. A ticket is what the code on the wall holds: another one follows it after
a while, and old ones let in for a while. Who joins gets a token: her number, the ticket that she came by, and the group
(see `admission`) that she came from, as a keyed hash.
"""

import base64
import hashlib
import hmac
from dataclasses import dataclass
from typing import Any, Final

from live.control.audience.rate_limit import BURST

PATIENCE: Final = 4
"""Malformed messages of a phone before it is sent away."""
TOO_FAST: Final = 300
"""Messages that were too fast before it is."""
KEEPS: Final = 60.0
"""Who has lost its connection has its place for so long [s], before anybody fresh gets it."""


@dataclass(slots=True, eq=False)
class Phone:
    """One phone that has said who it is."""

    number: int
    row: int
    group: int
    """Who shares its address, or its network card: see `admission`."""
    ws: Any
    transport: Any
    origin: int = 0
    """The group in which it joined first."""
    left: float = BURST
    """Messages that it may still send at once ..."""
    at: float = 0.0
    """... at the time [s] of its last one."""
    malformed: int = 0
    fast: int = 0
    gone: Any = None
    """Done once its connection is lost."""
    lit: bool = False
    """Whether it knows that its light is seen."""
    vote: tuple[int, int] = (0, 0)
    """Number of the vote, and its choice."""
    left_by_itself: bool = False
    """Whether it said that it goes: nobody keeps its place then."""


class Phones:
    """Thread: one."""

    def __init__(self, most: int, first: int) -> None:
        """`most`: so many at a time; `first`: the next phone's number."""
        self.by_number: dict[int, Phone] = {}
        self.most, self.next = most, first
        self._of_group: dict[int, dict[Phone, None]] = {}
        self._of_origin: dict[int, dict[Phone, None]] = {}
        self._kept: dict[int, float] = {}

    def __len__(self) -> int:
        return len(self.by_number)

    def is_full(self, now: float, *, fresh: bool) -> bool:
        """Whether there is no place left. Places of those who have just lost their connection are theirs alone."""
        kept = 0
        if fresh:
            for number in [number for number, until in self._kept.items() if now > until]:
                del self._kept[number]
            kept = len(self._kept)
        return len(self.by_number) + kept >= self.most

    def of(self, group: int) -> list[Phone]:
        """The phones that are in a group, as they came."""
        return list(self._of_group.get(group, ()))

    def related(self, *groups: int) -> list[Phone]:
        """The phones that are in one of the groups, or have joined there."""
        found: dict[Phone, None] = {}
        for group in groups:
            found |= self._of_group.get(group, {}) | self._of_origin.get(group, {})
        return list(found)

    def relatives(self, phone: Phone) -> int:
        """How many phones are one with it at most: those in its group, or those that have joined where it has."""
        return max(len(self._of_group.get(phone.group, ())), len(self._of_origin.get(phone.origin, ())), 1)

    def add(self, phone: Phone) -> Phone | None:
        """It is there; returns the one that had its number until now (another tab, a socket that fell asleep)."""
        before = self.by_number.get(phone.number)
        self.by_number[phone.number] = phone
        self._of_group.setdefault(phone.group, {})[phone] = None
        self._of_origin.setdefault(phone.origin, {})[phone] = None
        self._kept.pop(phone.number, None)
        return before

    def remove(self, phone: Phone, now: float) -> bool:
        """It has gone; whether nobody else has its number now."""
        for of, key in ((self._of_group, phone.group), (self._of_origin, phone.origin)):
            left = of.get(key, {})
            left.pop(phone, None)
            if not left:
                of.pop(key, None)
        if self.by_number.get(phone.number) is phone:
            del self.by_number[phone.number]
            if not phone.left_by_itself and len(self._kept) < self.most:
                self._kept[phone.number] = now + KEEPS
            return True
        return False


KEY_BYTES: Final = 9
"""72 bits, and no padding in base64."""
MOST_NUMBER: Final = 1 << 31
MOST_SERIAL: Final = 1 << 48


@dataclass(frozen=True, slots=True)
class Device:
    """A phone that has joined."""

    number: int
    ticket: int = 0
    """By which code ..."""
    origin: int = 0
    """... and from which group."""


@dataclass(frozen=True, slots=True)
class Voucher:
    """A place that somebody with a good ticket waits for."""

    ticket: int
    slot_ms: int
    """When she comes in [ms of the show]; 0: whenever there is room."""
    until_ms: int
    """How long it is good [ms of the show]."""
    serial: int


def _signed(secret: bytes, words: str) -> str:
    digest = hmac.new(secret, words.encode(), hashlib.sha256).digest()[:KEY_BYTES]
    return base64.urlsafe_b64encode(digest).decode()


def _fits(secret: bytes, words: str, signature: str) -> bool:
    return hmac.compare_digest(_signed(secret, words).encode(), signature.encode("utf-8", "replace"))


def _numbers(text: str, count: int) -> tuple[int, ...] | None:
    """So many whole numbers with points between them; None for anything else. Each is written in one way only."""
    words = text.split(".")
    if len(words) != count or not all(word.isascii() and word.isdecimal() and len(word) <= 15 for word in words):
        return None
    found = tuple(int(word) for word in words)
    return found if ".".join(map(str, found)) == text else None


def ticket_key(secret: bytes, ticket: int) -> str:
    """A ticket's key, as it stands in the link."""
    return _signed(secret, f"link {ticket}")


def ticket_of(secret: bytes, key: str, newest: int, valid: int) -> int:
    """Which of the `newest` ticket and the `valid` ones before it has that key; -1 for none of them."""
    found = -1
    for ticket in range(max(newest - valid, 0), newest + 1):  # all of them, whichever fits: time tells nothing
        if _fits(secret, f"link {ticket}", key):
            found = ticket
    return found


def group_number(secret: bytes, group: str) -> int:
    """A group as a number that tells nothing of its address."""
    return int.from_bytes(hmac.new(secret, f"group {group}".encode(), hashlib.sha256).digest()[:6], "big")


def token_of(secret: bytes, device: Device) -> str:
    """The token of a phone."""
    words = f"{device.number}.{device.ticket}.{device.origin}"
    return f"{words}.{_signed(secret, f'phone {words}')}"


def device_of(secret: bytes, token: str) -> Device | None:
    """The phone; None for a token that nobody has given."""
    words, _, signature = token.rpartition(".")
    found = _numbers(words, 3)
    if found is None or not 0 < found[0] < MOST_NUMBER or not _fits(secret, f"phone {words}", signature):
        return None
    return Device(*found)


def voucher_text(secret: bytes, voucher: Voucher) -> str:
    """A voucher as phones keep it."""
    words = f"{voucher.ticket}.{voucher.slot_ms}.{voucher.until_ms}.{voucher.serial}"
    return f"{words}.{_signed(secret, f'voucher {words}')}"


def voucher_of(secret: bytes, text: str) -> Voucher | None:
    """The voucher; None for what nobody has given."""
    words, _, signature = text.rpartition(".")
    found = _numbers(words, 4)
    return None if found is None or not _fits(secret, f"voucher {words}", signature) else Voucher(*found)


def hue_of(number: int) -> int:
    """A phone's colour: hue in thousandths; those who join one after the other differ much (golden ratio)."""
    return int(number * 618.034) % 1000
