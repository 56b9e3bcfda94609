"""Admission: who may come in, when, and with what part of a voice: by what the hall's network is like.

Phones are told apart by groups: those of one network card or address are one group.

- *own wifi*: each phone has an address of its own. A group has one voice, however many phones it says that it has.
  Where the machine sees whose network card an address belongs to (`neighbours`), the card is the group: forty addresses
  of one laptop are one. A group from which many join within a minute is a crowd, and has no voice until it rests.
- *behind nat*: all share an address, and nothing in the network tells them apart. Each phone has a voice; how fast they
  join is limited, and each code on the wall lets in so many.
- *proxy*: as own wifi, by the addresses that the proxies forward.

Phones that have joined in one group stay one wherever they go: a group mints no voices for other ones.
"""

import random
from dataclasses import dataclass
from typing import Final

from live.control.audience.join_tickets import Tickets
from live.control.audience.phone_registry import Phone, Phones
from live.control.audience.rate_limit import ALL_JOINS, Bucket, Line, Why

OWN_WIFI: Final = "own wifi"
BEHIND_NAT: Final = "behind nat"
PROXY: Final = "proxy"
NETWORKS: Final = (OWN_WIFI, BEHIND_NAT, PROXY)
JOIN_RATE: Final = 20.0
JOIN_BURST: Final = 40.0
"""Behind nat: phones of one address that join a second, and at once; whoever is later waits for her turn."""
HORIZON: Final = 120.0
"""Turns are reserved so far ahead [s]."""
DEVICES: Final = 4.0
"""Own wifi: so many phones that join from a group are no crowd: another browser, a private window ..."""
RECOVERS: Final = 15.0
"""... and one more after each so many seconds."""
CROWDED: Final = 60.0
"""Who is a crowd has no voice until so long [s] after nobody more than that has come."""
MOST_GROUPS: Final = 16_384
EARLY: Final = 0.05
"""Whoever comes so much before her turn [s] has come at it: clocks differ."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What is said to somebody who wants to come in."""

    why: Why | None = None
    """Why not; None: she may."""
    wait: float = 0.0
    """When she may ask again [s from now]; 0: not with what she has."""
    voucher: str = ""
    ticket: int = 0


class Admission:
    """Thread: the gateway's loop."""

    def __init__(self, phones: Phones, tickets: Tickets, network: str, per_group: int, secret: bytes) -> None:
        """`per_group`: phones of a group at a time, where phones have groups of their own."""
        self._phones, self._tickets = phones, tickets
        self.apart = network != BEHIND_NAT
        """Whether each phone has a group of its own."""
        self._per_group = per_group if self.apart else phones.most
        self._all = Line(ALL_JOINS, ALL_JOINS)
        self._lines: dict[int, Line] = {}
        self._joins: dict[int, Bucket] = {}
        self._crowded: dict[int, float] = {}
        self._chance = random.Random(secret)

    # -- who is one with whom --------------------------------------------------------------------------------------

    def part(self, phone: Phone, now: float) -> float:
        """Which part of a voice a phone has."""
        if not self.apart:
            return 1.0
        if self._is_crowded(phone.group, now) or self._is_crowded(phone.origin, now):
            return 0.0
        return 1.0 / self._phones.relatives(phone)

    @property
    def crowded(self) -> int:
        """How many groups are a crowd."""
        return len(self._crowded)

    def calmed(self, now: float) -> list[int]:
        """The groups that have rested since the last call, and are no crowd any more."""
        found = [group for group, until in self._crowded.items() if now > until]
        for group in found:
            del self._crowded[group]
        return found

    def _is_crowded(self, group: int, now: float) -> bool:
        return now <= self._crowded.get(group, -1.0)

    def _is_one_too_many(self, group: int, now: float) -> bool:
        """Whether a phone that joins makes its group a crowd."""
        if not self.apart:
            return False
        bucket = self._joins.get(group)
        if bucket is None:
            if len(self._joins) >= MOST_GROUPS:
                for old in list(self._joins)[: MOST_GROUPS // 2]:
                    del self._joins[old]
            bucket = self._joins[group] = Bucket(1.0 / RECOVERS, DEVICES)
        if bucket.take(now):
            return False
        if group in self._crowded or len(self._crowded) < MOST_GROUPS:
            self._crowded[group] = now + CROWDED
        return True

    # -- who may come in -------------------------------------------------------------------------------------------

    def known(self, group: int, now: float) -> Answer:
        """Somebody who has joined before, and is not connected."""
        if self._phones.is_full(now, fresh=False):
            return self._later(Why.FULL, 2.0, 6.0)
        if len(self._phones.of(group)) >= self._per_group:
            return self._later(Why.ADDRESS, 15.0, 30.0)
        wait = self._all.wait(now)
        if wait > 0.0:
            return self._later(Why.JOINS, wait, wait + 1.0)
        self._all.reserve(now)
        return Answer()

    def fresh(self, key: str, voucher: str, group: int, now: float) -> Answer:
        """Somebody who comes by a code's `key`, or by the `voucher` that she was given before."""
        held = self._tickets.redeemable(voucher, now) if voucher else None
        ticket = held.ticket if held is not None else self._tickets.of(key, now) if key else -1
        if ticket < 0:
            return Answer(Why.LINK if key or voucher else Why.TOKEN)
        if held is None:
            if self._is_one_too_many(group, now):
                return self._later(Why.ADDRESS, 30.0, 60.0)
            if self._tickets.is_late(ticket, now):
                return self._later(Why.JOINS, 2.0, 6.0)
            if not self._tickets.spend(ticket):
                return Answer(Why.SPENT)
        serial = 0 if held is None else held.serial
        if self._phones.is_full(now, fresh=True):
            return self._later(Why.FULL, 3.0, 8.0, self._tickets.voucher(ticket, 0.0, now, serial))
        if len(self._phones.of(group)) >= self._per_group:
            return self._later(Why.ADDRESS, 15.0, 30.0, self._tickets.voucher(ticket, 0.0, now, serial))
        slot = 0.0 if held is None else held.slot_ms / 1e3
        if slot and now < slot - EARLY:
            return self._later(Why.JOINS, slot - now, slot - now + 0.5, voucher)
        if not slot:
            wait = self._reserved(group, now)
            if wait:
                at = now + wait if wait <= HORIZON else 0.0
                low, high = (wait, wait + 0.5) if at else (HORIZON / 4.0, HORIZON / 2.0)
                return self._later(Why.JOINS, low, high, self._tickets.voucher(ticket, at, now, serial))
        if held is not None:
            self._tickets.redeem(held)
        return Answer(ticket=ticket)

    def _reserved(self, group: int, now: float) -> float:
        """How long somebody has to wait for her turn [s], which is hers then; beyond `HORIZON` it is not."""
        lines = [self._all]
        if not self.apart:
            if group not in self._lines:
                if len(self._lines) >= MOST_GROUPS:
                    self._lines.clear()
                self._lines[group] = Line(JOIN_RATE, JOIN_BURST)
            lines.append(self._lines[group])
        wait = max(line.wait(now) for line in lines)
        if wait <= HORIZON:
            for line in lines:
                line.reserve(now)
        return wait

    def _later(self, why: Why, low: float, high: float, voucher: str = "") -> Answer:
        """Not now; again after `low` to `high` seconds, so that not all come at once."""
        return Answer(why, self._chance.uniform(low, high), voucher)
