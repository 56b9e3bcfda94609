"""Tokens: tickets in the link on the projector, devices that have joined by one, and vouchers for a place later on.

All are numbers, signed with the show's secret; nothing of a person is in them. Whoever knows the secret, as a gateway
that was started again does, knows them again. A ticket is what the code on the wall holds: another one follows it after
a while, and old ones let in for a while. Who joins gets a token: her number, the ticket that she came by, and the group
(see `admission`) that she came from, as a keyed hash.
"""

import base64
import hashlib
import hmac
from dataclasses import dataclass
from typing import Final

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
