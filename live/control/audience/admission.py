"""Admission of phones: whether and when a phone may join, and the weight of its voice.

Phones are grouped by network card or address. The rules depend on the venue's network:

- *own wifi*: each phone has its own address. A group has one voice, divided among its phones. Where the machine sees
  the network card of an address (`arp_table`), the card is the group: forty addresses of one laptop are one group. A
  group in which many phones join within a minute is crowded, and has no voice until it has rested.
- *behind nat*: all phones share an address, and nothing in the network tells them apart. Each phone has a voice. The
  rate of joins is limited, and each displayed code admits a limited number.
- *proxy*: as own wifi, by the addresses that the proxies forward.

Phones that joined in one group stay related in whatever group they are later, so a group cannot create voices for other
groups.
"""

import random
from dataclasses import dataclass
from typing import Final

from live.control.audience.join_tickets import JoinTickets
from live.control.audience.phone_registry import NOWHERE, Phone, Phones
from live.control.audience.rate_limit import ALL_JOINS, RefusalReason, TokenBucket, WaitingLine

OWN_WIFI: Final = "own wifi"
BEHIND_NAT: Final = "behind nat"
PROXY: Final = "proxy"
JOIN_RATE: Final = 20.0
JOIN_BURST: Final = 40.0
"""Behind nat: joins per second of one address, and joins at once; later phones get a reserved time slot."""
MAX_RESERVED_WAIT: Final = 120.0
"""Slots are reserved at most this far ahead [s]."""
GROUP_BURST: Final = 4.0
"""Own wifi: joins at once from a group that do not make it crowded (another browser, a private window …)."""
GROUP_RECOVERY: Final = 15.0
"""One more such join is allowed after each interval of this length [s]."""
CROWD_SECONDS: Final = 60.0
"""A crowded group has no voice until this long [s] after its last excess join."""
INVITED_WAIT: Final = 10.0
"""Shortest wait [s] of a phone while the invitation admits nobody."""
MOST_GROUPS: Final = 16_384
SLOT_TOLERANCE: Final = 0.05
"""A phone may be this early [s] for its slot, because clocks differ."""


@dataclass(frozen=True, slots=True)
class JoinAnswer:
    """Answer to a request to join."""

    why: RefusalReason | None = None
    """Reason of the refusal; None: the phone may join."""
    wait: float = 0.0
    """Seconds until the next attempt; 0: never with these credentials."""
    voucher: str = ""
    ticket: int = 0


class Admission:
    """Admission control. Thread: the gateway's loop."""

    def __init__(self, phones: Phones, tickets: JoinTickets, network: str, per_group: int, secret: bytes) -> None:
        """`per_group`: maximum of simultaneous phones in a group, where phones have groups of their own."""
        self._phones, self._tickets = phones, tickets
        self.has_groups = network != BEHIND_NAT
        """Whether each phone has its own group."""
        self._per_group = per_group if self.has_groups else phones.most
        self._all = WaitingLine(ALL_JOINS, ALL_JOINS)
        self._lines: dict[int, WaitingLine] = {}
        self._joins: dict[int, TokenBucket] = {}
        self._crowded: dict[int, float] = {}
        self._random = random.Random(secret)

    # -- groups ----------------------------------------------------------------------------------------------------

    def voice_share(self, phone: Phone, now: float) -> float:
        """Return the phone's fraction of a voice."""
        if not self.has_groups:
            return 1.0
        if self._is_crowded(phone.group, now) or self._is_crowded(phone.origin, now):
            return 0.0
        return 1.0 / self._phones.related_count(phone)

    @property
    def crowded(self) -> int:
        """Number of crowded groups."""
        return len(self._crowded)

    def expire_crowds(self, now: float) -> list[int]:
        """Return the groups that stopped being crowded since the last call."""
        found = [group for group, until in self._crowded.items() if now > until]
        for group in found:
            del self._crowded[group]
        if self._phones.changed_groups is not None:
            self._phones.changed_groups.update(found)
        return found

    def _is_crowded(self, group: int, now: float) -> bool:
        there = self._phones.elsewhere.get(group, NOWHERE).crowded_until
        return now <= max(self._crowded.get(group, -1.0), there)

    def crowded_until(self, group: int) -> float:
        """Return the time until which a group is crowded here [s of the show]; below 0: it is not."""
        return self._crowded.get(group, -1.0)

    def _makes_crowd(self, group: int, now: float) -> bool:
        """Whether a further join makes the group crowded."""
        if not self.has_groups:
            return False
        bucket = self._joins.get(group)
        if bucket is None:
            if len(self._joins) >= MOST_GROUPS:
                for old in list(self._joins)[: MOST_GROUPS // 2]:
                    del self._joins[old]
            bucket = self._joins[group] = TokenBucket(1.0 / GROUP_RECOVERY, GROUP_BURST)
        if bucket.try_take(now):
            return False
        if group in self._crowded or len(self._crowded) < MOST_GROUPS:
            self._crowded[group] = now + CROWD_SECONDS
            if self._phones.changed_groups is not None:
                self._phones.changed_groups.add(group)
        return True

    # -- joining ---------------------------------------------------------------------------------------------------

    def admit_known(self, group: int, now: float) -> JoinAnswer:
        """Answer a phone that has joined before and is not connected."""
        if self._phones.is_full(now, fresh=False):
            return self._refuse_for_now(RefusalReason.FULL, 2.0, 6.0)
        if self._phones.count_in_group(group) >= self._per_group:
            return self._refuse_for_now(RefusalReason.ADDRESS, 15.0, 30.0)
        wait = self._all.wait(now)
        if wait > 0.0:
            return self._refuse_for_now(RefusalReason.JOINS, wait, wait + 1.0)
        self._all.reserve(now)
        return JoinAnswer()

    def admit_new(self, key: str, voucher: str, group: int, now: float) -> JoinAnswer:
        """Answer a new phone, which has the `key` of a code or of the invitation, or an earlier `voucher`."""
        tickets = self._tickets
        held = tickets.find_voucher(voucher, now) if voucher else None
        if held is None:
            ticket, refusal = self._check_key(key, had_voucher=bool(voucher), group=group, now=now)
            if refusal is not None:
                return refusal
        else:
            ticket = held.ticket
        serial = 0 if held is None else held.serial
        if self._phones.is_full(now, fresh=True):
            return self._refuse_for_now(RefusalReason.FULL, 3.0, 8.0, tickets.issue_voucher(ticket, 0.0, now, serial))
        if self._phones.count_in_group(group) >= self._per_group:
            return self._refuse_for_now(
                RefusalReason.ADDRESS, 15.0, 30.0, tickets.issue_voucher(ticket, 0.0, now, serial)
            )
        slot = 0.0 if held is None else held.slot_ms / 1e3
        if slot and now < slot - SLOT_TOLERANCE:
            return self._refuse_for_now(RefusalReason.JOINS, slot - now, slot - now + 0.5, voucher)
        if not slot:
            wait = self._reserve(group, now)
            if wait:
                at = now + wait if wait <= MAX_RESERVED_WAIT else 0.0
                low, high = (wait, wait + 0.5) if at else (MAX_RESERVED_WAIT / 4.0, MAX_RESERVED_WAIT / 2.0)
                return self._refuse_for_now(
                    RefusalReason.JOINS, low, high, tickets.issue_voucher(ticket, at, now, serial)
                )
        if held is not None:
            tickets.redeem(held)
        return JoinAnswer(ticket=ticket)

    def _check_key(self, key: str, *, had_voucher: bool, group: int, now: float) -> tuple[int, JoinAnswer | None]:
        """Use a key for one device; return its ticket, and the refusal if there is one."""
        tickets = self._tickets
        invited = bool(key) and tickets.is_invitation(key)
        ticket = tickets.newest(now) if invited else tickets.find(key, now) if key else -1
        if ticket < 0:
            return -1, JoinAnswer(RefusalReason.LINK if key or had_voucher else RefusalReason.TOKEN)
        if self._makes_crowd(group, now):
            return -1, self._refuse_for_now(RefusalReason.ADDRESS, 30.0, 60.0)
        if invited:
            allowed = tickets.use_invitation(now)
            return ticket, None if allowed else self._refuse_for_now(
                RefusalReason.JOINS, INVITED_WAIT, 2.0 * INVITED_WAIT
            )
        if tickets.is_rate_limited(ticket, now):
            return -1, self._refuse_for_now(RefusalReason.JOINS, 2.0, 6.0)
        return (ticket, None) if tickets.use(ticket) else (-1, JoinAnswer(RefusalReason.SPENT))

    def _reserve(self, group: int, now: float) -> float:
        """Reserve a slot and return the wait for it [s]; beyond `HORIZON` nothing is reserved."""
        lines = [self._all]
        if not self.has_groups:
            if group not in self._lines:
                if len(self._lines) >= MOST_GROUPS:
                    self._lines.clear()
                self._lines[group] = WaitingLine(JOIN_RATE, JOIN_BURST)
            lines.append(self._lines[group])
        wait = max(line.wait(now) for line in lines)
        if wait <= MAX_RESERVED_WAIT:
            for line in lines:
                line.reserve(now)
        return wait

    def _refuse_for_now(self, why: RefusalReason, low: float, high: float, voucher: str = "") -> JoinAnswer:
        """Refuse for now, with a random delay of `low` to `high` seconds so that phones do not return all at once."""
        return JoinAnswer(why, self._random.uniform(low, high), voucher)
