"""Registry of connected phones by number and group, and the signed credentials of phones. In memory only.

Tickets, tokens and vouchers are numbers signed with the show's secret; they contain no personal data. A restarted
gateway has the secret and can verify them. A ticket is in the displayed link and is replaced periodically; old tickets
stay valid for a while. A phone that joins gets a token with its number, its ticket and its original group (see
`admission`) as a keyed hash. A voucher reserves a place for later.
"""

import base64
import hashlib
import hmac
from collections import deque
from dataclasses import dataclass
from typing import Any, Final

from live.control.audience.rate_limit import BURST

MAX_MALFORMED: Final = 4
"""Malformed messages before a phone is disconnected."""
MAX_FAST: Final = 300
"""Rate-limited messages before a phone is disconnected."""
PLACE_KEPT_SECONDS: Final = 60.0
"""Time for which a disconnected phone keeps its place [s]."""


@dataclass(slots=True, eq=False)
class Phone:
    """A connected phone that has identified itself."""

    number: int
    row: int
    group: int
    """Group of phones with the same address or network card: see `admission`."""
    ws: Any
    transport: Any
    origin: int = 0
    """The group in which it first joined."""
    tokens_left: float = BURST
    """Messages that it could still send at once …"""
    last_message_at: float = 0.0
    """… at the time [s] of its last one."""
    malformed: int = 0
    fast: int = 0
    disconnected: Any = None
    """Future that is done when the connection is lost."""
    vote: tuple[int, int] = (0, 0)
    """Number of the vote, and the choice."""
    left_by_itself: bool = False
    """Whether the phone closed the connection itself; its place is then not kept."""


class Numbers:
    """Numbers for new phones. Thread: one."""

    def __init__(self, first: int, end: int) -> None:
        """Numbers from `first` up to `end`, which is not one of them."""
        self._ranges = deque([(first, end)])

    def __len__(self) -> int:
        return sum(end - first for first, end in self._ranges)

    def take(self) -> int | None:
        """Return a number that no phone had before; None if there is none left."""
        while self._ranges:
            first, end = self._ranges.popleft()
            if first < end:
                self._ranges.appendleft((first + 1, end))
                return first
        return None

    def add(self, first: int, end: int) -> None:
        """Add numbers from `first` up to `end`."""
        self._ranges.append((first, end))


@dataclass(frozen=True, slots=True)
class GroupElsewhere:
    """What other gateways have of a group: see `Phones.elsewhere`."""

    phones: int = 0
    joined: int = 0
    """Phones that joined in it, wherever they are now."""
    crowded_until: float = -1.0
    """Time [s of the show] until which it is crowded there."""


NOWHERE: Final = GroupElsewhere()


class Phones:
    """All connected phones. Thread: one."""

    def __init__(self, most: int, first: int) -> None:
        """`most`: maximum at a time; `first`: number of the next phone."""
        self.by_number: dict[int, Phone] = {}
        self.most, self.numbers = most, Numbers(first, MOST_NUMBER)
        self.most_in_all = most
        """Maximum at a time of all gateways together."""
        self.total_elsewhere = 0
        """Phones of the other gateways of this show."""
        self.elsewhere: dict[int, GroupElsewhere] = {}
        """Groups that other gateways have phones of as well."""
        self.changed_groups: set[int] | None = None
        """Groups that changed since somebody last looked; None: nobody looks."""
        self.changed_numbers: dict[int, bool] = {}
        """Numbers that came (True) or went since then."""
        self._of_group: dict[int, dict[Phone, None]] = {}
        self._of_origin: dict[int, dict[Phone, None]] = {}
        self._kept: dict[int, float] = {}

    def __len__(self) -> int:
        return len(self.by_number)

    def is_full(self, now: float, *, fresh: bool) -> bool:
        """Whether all places are taken. Places of recently disconnected phones are closed to fresh phones."""
        kept = 0
        if fresh:
            for number in [number for number, until in self._kept.items() if now > until]:
                del self._kept[number]
            kept = len(self._kept)
        here = len(self.by_number) + kept
        return here >= self.most or here + self.total_elsewhere >= self.most_in_all

    def in_group(self, group: int) -> list[Phone]:
        """Return the phones of a group, in order of arrival."""
        return list(self._of_group.get(group, ()))

    def related(self, *groups: int) -> list[Phone]:
        """Return the phones that are in one of the groups or joined in one."""
        found: dict[Phone, None] = {}
        for group in groups:
            found |= self._of_group.get(group, {}) | self._of_origin.get(group, {})
        return list(found)

    def related_count(self, phone: Phone) -> int:
        """Return the size of the phone's group, or of the group in which it joined if that is larger, with the phones
        of other gateways."""
        here, joined = self.count(phone.group)[0], self.count(phone.origin)[1]
        there = self.elsewhere.get(phone.group, NOWHERE).phones, self.elsewhere.get(phone.origin, NOWHERE).joined
        return max(here + there[0], joined + there[1], 1)

    def count(self, group: int) -> tuple[int, int]:
        """Return how many phones here are in a group, and how many joined in it."""
        return len(self._of_group.get(group, ())), len(self._of_origin.get(group, ()))

    def count_in_group(self, group: int) -> int:
        """Return the size of a group, with the phones of other gateways."""
        return self.count(group)[0] + self.elsewhere.get(group, NOWHERE).phones

    def _note(self, phone: Phone, *, here: bool) -> None:
        if self.changed_groups is not None:
            self.changed_groups |= {phone.group, phone.origin}
            self.changed_numbers[phone.number] = here

    def add(self, phone: Phone) -> Phone | None:
        """Add a phone; return the one that had its number (another tab, a stale socket)."""
        before = self.by_number.get(phone.number)
        self.by_number[phone.number] = phone
        self._of_group.setdefault(phone.group, {})[phone] = None
        self._of_origin.setdefault(phone.origin, {})[phone] = None
        self._kept.pop(phone.number, None)
        self._note(phone, here=True)
        return before

    def remove(self, phone: Phone, now: float) -> bool:
        """Remove a phone; return whether its number is unused now."""
        for of, key in ((self._of_group, phone.group), (self._of_origin, phone.origin)):
            left = of.get(key, {})
            left.pop(phone, None)
            if not left:
                of.pop(key, None)
        self._note(phone, here=self.by_number.get(phone.number, phone) is not phone)
        if self.by_number.get(phone.number) is phone:
            del self.by_number[phone.number]
            if not phone.left_by_itself and len(self._kept) < self.most:
                self._kept[phone.number] = now + PLACE_KEPT_SECONDS
            return True
        return False


KEY_BYTES: Final = 9
"""72 bits, which need no base64 padding."""
MOST_NUMBER: Final = 1 << 31
MOST_SERIAL: Final = 1 << 48


@dataclass(frozen=True, slots=True)
class Device:
    """Identity of a phone that has joined."""

    number: int
    ticket: int = 0
    """The ticket used …"""
    origin: int = 0
    """… and the group from which it joined."""


@dataclass(frozen=True, slots=True)
class Voucher:
    """Reserved place of a phone with a valid ticket."""

    ticket: int
    slot_ms: int
    """Time of entry [ms of the show]; 0: as soon as there is room."""
    until_ms: int
    """Expiry [ms of the show]."""
    serial: int


def _sign(secret: bytes, words: str) -> str:
    digest = hmac.new(secret, words.encode(), hashlib.sha256).digest()[:KEY_BYTES]
    return base64.urlsafe_b64encode(digest).decode()


def _is_signature(secret: bytes, words: str, signature: str) -> bool:
    return hmac.compare_digest(_sign(secret, words).encode(), signature.encode("utf-8", "replace"))


def _parse_numbers(text: str, count: int) -> tuple[int, ...] | None:
    """Parse exactly `count` whole numbers separated by dots in canonical form; None for anything else."""
    words = text.split(".")
    if len(words) != count or not all(word.isascii() and word.isdecimal() and len(word) <= 15 for word in words):
        return None
    found = tuple(int(word) for word in words)
    return found if ".".join(map(str, found)) == text else None


def ticket_key(secret: bytes, ticket: int) -> str:
    """Return a ticket's key as used in the link."""
    return _sign(secret, f"link {ticket}")


def invitation_key(secret: bytes, number: int) -> str:
    """Return the key of the operator's invitation of this number; the dot tells it from a ticket's."""
    return f"i.{_sign(secret, f'invitation {number}')}"


def is_invitation(secret: bytes, key: str, number: int) -> bool:
    """Whether a key is that of the invitation of this number."""
    return key.startswith("i.") and _is_signature(secret, f"invitation {number}", key[2:])


def find_ticket(secret: bytes, key: str, newest: int, valid: int) -> int:
    """Return the ticket with that key among `newest` and the `valid` ones before it; -1 if none matches."""
    found = -1
    for ticket in range(max(newest - valid, 0), newest + 1):  # all are compared, so that timing reveals nothing
        if _is_signature(secret, f"link {ticket}", key):
            found = ticket
    return found


def group_number(secret: bytes, group: str) -> int:
    """Return a number for a group that does not reveal its address."""
    return int.from_bytes(hmac.new(secret, f"group {group}".encode(), hashlib.sha256).digest()[:6], "big")


def token_of(secret: bytes, device: Device) -> str:
    """Return the token of a phone."""
    words = f"{device.number}.{device.ticket}.{device.origin}"
    return f"{words}.{_sign(secret, f'phone {words}')}"


def verify_token(secret: bytes, token: str) -> Device | None:
    """Verify a token and return its device; None if it is not genuine."""
    words, _, signature = token.rpartition(".")
    found = _parse_numbers(words, 3)
    if found is None or not 0 < found[0] < MOST_NUMBER or not _is_signature(secret, f"phone {words}", signature):
        return None
    return Device(*found)


def voucher_text(secret: bytes, voucher: Voucher) -> str:
    """Return the text of a voucher."""
    words = f"{voucher.ticket}.{voucher.slot_ms}.{voucher.until_ms}.{voucher.serial}"
    return f"{words}.{_sign(secret, f'voucher {words}')}"


def verify_voucher(secret: bytes, text: str) -> Voucher | None:
    """Verify the text of a voucher; None if it is not genuine."""
    words, _, signature = text.rpartition(".")
    found = _parse_numbers(words, 4)
    return None if found is None or not _is_signature(secret, f"voucher {words}", signature) else Voucher(*found)


def hue_of(number: int) -> int:
    """Return a phone's hue in thousandths; successive numbers differ strongly (golden ratio)."""
    return int(number * 618.034) % 1000
