"""Phones: everybody who is connected, by number, with what each may send; addresses are counted in memory alone."""

from dataclasses import dataclass
from typing import Any, Final

from live.control.audience.refused import ALL_JOINS, BURST, JOIN_BURST, JOIN_RATE, Bucket, Why

PATIENCE: Final = 4
"""Malformed messages of a phone before it is sent away."""
TOO_FAST: Final = 300
"""Messages that were too fast before it is."""
VOICES: Final = 4
"""Voices that the phones of one address have together at most, as many as are needed for all of the force."""
MOST_ADDRESSES: Final = 16384


@dataclass(slots=True, eq=False)
class Phone:
    """One phone that has said who it is."""

    number: int
    row: int
    address: str
    ws: Any
    transport: Any
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


class Phones:
    """Thread: one."""

    def __init__(self, most: int, per_address: int, first: int) -> None:
        """`first`: the next phone's number."""
        self.by_number: dict[int, Phone] = {}
        self.most, self.per_address, self.next = most, per_address, first
        self._of_address: dict[str, dict[Phone, None]] = {}
        self._together = float(VOICES) if per_address < most else float(most)
        self._joins: dict[str, Bucket] = {}
        self._all = Bucket(ALL_JOINS, ALL_JOINS)

    def __len__(self) -> int:
        return len(self.by_number)

    def may_join(self, address: str, now: float, *, fresh: bool) -> Why | None:
        """Why not another phone of this address; None if it may. `fresh`: it has no token yet."""
        if len(self.by_number) >= self.most:
            return Why.FULL
        if len(self._of_address.get(address, ())) >= self.per_address:
            return Why.ADDRESS
        if not self._all.take(now):
            return Why.JOINS
        if not fresh:
            return None
        bucket = self._joins.get(address)
        if bucket is None:
            if len(self._joins) >= MOST_ADDRESSES:
                self._joins.clear()
            many = max(self.per_address / 16.0, 1.0)
            bucket = self._joins[address] = Bucket(JOIN_RATE * many, JOIN_BURST * many + 6.0)
        return None if bucket.take(now) else Why.JOINS

    def add(self, phone: Phone) -> Phone | None:
        """It is there; returns the one that had its number until now (another tab, a socket that fell asleep)."""
        before = self.by_number.get(phone.number)
        self.by_number[phone.number] = phone
        self._of_address.setdefault(phone.address, {})[phone] = None
        return before

    def parts(self, address: str) -> tuple[list[Phone], float]:
        """The phones of an address, and which part of a voice each has: together they have no more than `VOICES`.

        Somebody with a hundred tabs is no crowd. Where all may come through one address there is no such limit.
        """
        phones = list(self._of_address.get(address, ()))
        return phones, min(1.0, self._together / max(len(phones), 1))

    def remove(self, phone: Phone) -> bool:
        """It has gone; whether nobody else has its number now."""
        left = self._of_address.get(phone.address, {})
        left.pop(phone, None)
        if not left:
            self._of_address.pop(phone.address, None)
        if self.by_number.get(phone.number) is phone:
            del self.by_number[phone.number]
            return True
        return False
