"""Refusals of incoming messages, as values and as counts. Nothing here raises.

The reasons are a fixed list, so that no sender can make the table grow; their texts appear in the status line.
"""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Final


class Reason(StrEnum):
    """Why a packet or a control was refused."""

    PACKET_SIZE = "packet empty or too large"
    ALIGNMENT = "length not a multiple of 4"
    ADDRESS = "malformed address"
    WILDCARD = "unusable pattern"
    UNTERMINATED = "string too long or without end"
    PADDING = "padding not zero"
    TEXT = "text not UTF-8"
    NO_TYPES = "no type tags"
    UNKNOWN_TYPE = "unknown type tag"
    MANY_ARGUMENTS = "too many arguments"
    TRUNCATED = "value cut off"
    TRAILING = "bytes left over"
    BLOB = "blob size"
    NOT_FINITE = "not a finite number"
    ELEMENT_SIZE = "bundle element size"
    DEPTH = "bundles nested too deep"
    MANY_MESSAGES = "too many messages"
    UNKNOWN_ADDRESS = "unknown address"
    MISSING = "missing argument"
    EXTRA = "extra argument"
    WRONG_TYPE = "wrong type"
    OUT_OF_RANGE = "out of range"
    NAME = "unusable name"
    FORM = "unusable text"
    ROLE = "not for this port's role"
    FLOOD = "flood of one sender, not read"
    SUBSCRIBERS = "too many subscribers"
    SENDER = "sender not allowed"
    SOCKET = "socket error"
    INTERNAL = "internal error"


@dataclass(frozen=True, slots=True)
class Rejection:
    """A refused message: the reason, its address as received, the allowed values and the one received."""

    reason: Reason
    address: str
    expected: str = ""
    """The allowed values as text."""
    received: object = None
    """The value that was refused."""

    def __str__(self) -> str:
        text = f"{_shorten(self.address)}: {self.reason}"
        if self.expected:
            received = _describe(self.received) if self.reason is Reason.WRONG_TYPE else _shorten(self.received)
            found = "the next one is" if self.reason is Reason.EXTRA else "received"
            text += f": expected {self.expected}, {found} {received}"
        return text


def _describe(value: object) -> str:
    """Describe a value of the wrong type, and how to write the right one."""
    shown = _shorten(value)
    if isinstance(value, str):
        return f'the text "{shown[1:-1]}"' + ("; write the number without quotes" if _NUMBER.fullmatch(value) else "")
    if isinstance(value, bool):
        return f"the switch {'true' if value else 'false'}"
    if isinstance(value, int | float):
        return f"the number {value:.10g}; write a text in quotes"
    return shown


_NUMBER: Final = re.compile(r"\s*[+-]?[0-9]{1,9}(\.[0-9]{0,9})?\s*")


def _shorten(value: object) -> str:
    """Return an untrusted value as one short line: no control characters, at most 60 characters."""
    text = ascii(value)[:61]
    return text if len(text) <= 60 else text[:59] + "…"


class Tally:
    """Number of refusals by reason.

    Call `count` from one thread, the reading methods from any (the keys of the table never change).
    """

    def __init__(self) -> None:
        self._counts: dict[Reason, int] = dict.fromkeys(Reason, 0)
        self.total = 0
        """Number of all refusals."""

    def count(self, reason: Reason) -> None:
        """Count one refusal for `reason`."""
        self._counts[reason] += 1
        self.total += 1

    def as_dict(self) -> dict[str, int]:
        """Return the nonzero counts by reason, in the order of `Reason`."""
        return {str(reason): count for reason, count in self._counts.items() if count}
