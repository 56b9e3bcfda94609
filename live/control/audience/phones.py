"""Phones: everybody who is connected, by number and by group, with what each may send; in memory alone."""

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
