"""Join tickets: limits the number of devices per displayed code, and issues vouchers to waiting phones.

A code admits a limited number of devices. It is fully valid while it is displayed and for a short time after, because
pages load slowly. Then it admits only a few devices at a time until it expires.

The operator's invitation is one key that is valid as long as the show runs, until the operator makes a new one. Whoever
has it gets the ticket of the moment, at a low rate: it is for a team, and of little use to a crowd.
"""

import secrets
from typing import Final

from live.control.audience.phone_registry import (
    MOST_SERIAL,
    Voucher,
    find_ticket,
    is_invitation,
    ticket_key,
    verify_voucher,
    voucher_text,
)
from live.control.audience.rate_limit import TokenBucket

PAGE_LOAD_SECONDS: Final = 20.0
"""Maximum time from reading a code to loading the page [s]."""
LATE_RATE: Final = 1.0
LATE_BURST: Final = 8.0
"""Devices per second, and at once, admitted by a code that has been off display for longer than that."""
INVITED_RATE: Final = 1.0 / 15.0
INVITED_BURST: Final = 12.0
"""Devices per second, and at once, admitted by the operator's invitation."""
VOUCHER_SECONDS: Final = 180.0
"""Validity of a voucher after it was issued, or after its slot [s]; a returning phone gets a new one."""
MOST_USED: Final = 65_536


class JoinTickets:
    """Issued tickets and vouchers. Thread: the gateway's loop."""

    def __init__(self, secret: bytes, shown: float, grace: float, devices: int) -> None:
        """`shown`: how long a code is displayed [s]; `grace`: how long it is valid after that [s]; `devices`: its
        limit."""
        self._secret, self._shown, self._grace, self._devices = secret, shown, max(grace, PAGE_LOAD_SECONDS), devices
        self._spent: dict[int, int] = {}
        self._late: dict[int, TokenBucket] = {}
        self._used: dict[int, float] = {}
        self._invitation, self._invited = 1, TokenBucket(INVITED_RATE, INVITED_BURST)

    def newest(self, now: float) -> int:
        """Return the ticket displayed at `now` [s of the show]."""
        return int(max(now, 0.0) // self._shown)

    def key(self, now: float) -> str:
        """Return the displayed ticket's key."""
        return ticket_key(self._secret, self.newest(now))

    def find(self, key: str, now: float) -> int:
        """Return the valid ticket with that key; -1 if there is none."""
        valid = int(self._grace // self._shown) + 1
        found = find_ticket(self._secret, key, self.newest(now), valid)
        return found if found >= 0 and self._expired_for(found, now) < self._grace else -1

    def set_invitation(self, number: int) -> None:
        """Set the number of the invitation that is valid; the one before is void."""
        if number != self._invitation:
            self._invitation, self._invited = number, TokenBucket(INVITED_RATE, INVITED_BURST)

    def is_invitation(self, key: str) -> bool:
        """Whether a key is that of the operator's invitation."""
        return is_invitation(self._secret, key, self._invitation)

    def use_invitation(self, now: float) -> bool:
        """Use the invitation for one device; return whether its rate allows that now."""
        return self._invited.try_take(now)

    def _expired_for(self, ticket: int, now: float) -> float:
        """Return how long a ticket has been off display [s]."""
        return now - (ticket + 1) * self._shown

    def is_rate_limited(self, ticket: int, now: float) -> bool:
        """Whether a ticket has been off display so long that its join rate is limited, and the limit is reached."""
        if self._expired_for(ticket, now) <= PAGE_LOAD_SECONDS:
            return False
        if ticket not in self._late:
            known = sorted(self._late)
            for old in known[: len(known) - 256]:
                del self._late[old]
            self._late[ticket] = TokenBucket(LATE_RATE, LATE_BURST)
        return not self._late[ticket].try_take(now)

    def use(self, ticket: int) -> bool:
        """Use a ticket for one device; return whether any uses were left."""
        spent = self._spent.get(ticket, 0)
        if spent >= self._devices:
            return False
        self._spent[ticket] = spent + 1
        while len(self._spent) > 4096:
            del self._spent[min(self._spent)]
        return True

    # -- vouchers ------------------------------------------------------------------------------------------------

    def issue_voucher(self, ticket: int, slot: float, now: float, serial: int = 0) -> str:
        """Issue a voucher for the `slot` [s of the show; 0: none]; `serial`: that of the voucher it replaces."""
        until = max(slot, now) + VOUCHER_SECONDS
        serial = serial or 1 + secrets.randbelow(MOST_SERIAL - 1)
        return voucher_text(self._secret, Voucher(ticket, round(1e3 * slot), round(1e3 * until), serial))

    def find_voucher(self, text: str, now: float) -> Voucher | None:
        """Return the voucher if it is unused and has not expired."""
        found = verify_voucher(self._secret, text)
        return None if found is None or now > found.until_ms / 1e3 or found.serial in self._used else found

    def redeem(self, voucher: Voucher) -> None:
        """Mark a voucher as used."""
        self._used[voucher.serial] = voucher.until_ms / 1e3 + VOUCHER_SECONDS
        if len(self._used) > MOST_USED:
            for serial in sorted(self._used, key=self._used.__getitem__)[: MOST_USED // 2]:
                del self._used[serial]

    def expire(self, now: float) -> None:
        """Delete expired records."""
        self._used = {serial: until for serial, until in self._used.items() if now < until}
        oldest = self.newest(now) - int(self._grace // self._shown) - 2
        self._spent = {ticket: spent for ticket, spent in self._spent.items() if ticket >= oldest}
        self._late = {ticket: bucket for ticket, bucket in self._late.items() if ticket >= oldest}
