"""Tickets: how many devices may come in by each code that was on the wall, and vouchers for those who wait.

One code is good for so many devices and no more. It is shown for a while; until a while after that it is as good as
new, for pages load slowly; then few at a time come in by it until it is worth nothing.
"""

import secrets
from typing import Final

from live.control.audience.phone_registry import MOST_SERIAL, Voucher, ticket_key, ticket_of, voucher_of, voucher_text
from live.control.audience.rate_limit import Bucket

LOADS: Final = 20.0
"""A page has loaded so soon [s] after its code was read."""
LATE_RATE: Final = 1.0
LATE_BURST: Final = 8.0
"""Devices a second, and at once, that come in by a code that has left the wall for longer than that."""
VOUCHER_HOLDS: Final = 180.0
"""A voucher is good for so long [s] after it was given, or after its turn; who comes again gets a fresh one."""
MOST_USED: Final = 65_536


class Tickets:
    """Thread: the gateway's loop."""

    def __init__(self, secret: bytes, shown: float, grace: float, devices: int) -> None:
        """A code is `shown` so long [s], and lets in for `grace` [s] after that; each lets in so many `devices`."""
        self._secret, self._shown, self._grace, self._devices = secret, shown, max(grace, LOADS), devices
        self._spent: dict[int, int] = {}
        self._late: dict[int, Bucket] = {}
        self._used: dict[int, float] = {}

    def newest(self, now: float) -> int:
        """The ticket that is on the wall at `now` [s of the show]."""
        return int(max(now, 0.0) // self._shown)

    def key(self, now: float) -> str:
        """Its key."""
        return ticket_key(self._secret, self.newest(now))

    def of(self, key: str, now: float) -> int:
        """The ticket with that key, if it still lets in; -1 otherwise."""
        valid = int(self._grace // self._shown) + 1
        found = ticket_of(self._secret, key, self.newest(now), valid)
        return found if found >= 0 and self._gone(found, now) < self._grace else -1

    def _gone(self, ticket: int, now: float) -> float:
        """For how long a ticket has been off the wall [s]."""
        return now - (ticket + 1) * self._shown

    def is_late(self, ticket: int, now: float) -> bool:
        """Whether a ticket has been off the wall for so long that somebody else must wait before it lets in again."""
        if self._gone(ticket, now) <= LOADS:
            return False
        if ticket not in self._late:
            known = sorted(self._late)
            for old in known[: len(known) - 256]:
                del self._late[old]
            self._late[ticket] = Bucket(LATE_RATE, LATE_BURST)
        return not self._late[ticket].take(now)

    def spend(self, ticket: int) -> bool:
        """One device comes in by a ticket, or waits to; whether that is still possible."""
        spent = self._spent.get(ticket, 0)
        if spent >= self._devices:
            return False
        self._spent[ticket] = spent + 1
        while len(self._spent) > 4096:
            del self._spent[min(self._spent)]
        return True

    # -- vouchers ------------------------------------------------------------------------------------------------

    def voucher(self, ticket: int, slot: float, now: float, serial: int = 0) -> str:
        """A voucher for the `slot` [s of the show; 0: none]; `serial`: that of the one that it follows."""
        until = max(slot, now) + VOUCHER_HOLDS
        serial = serial or 1 + secrets.randbelow(MOST_SERIAL - 1)
        return voucher_text(self._secret, Voucher(ticket, round(1e3 * slot), round(1e3 * until), serial))

    def redeemable(self, text: str, now: float) -> Voucher | None:
        """The voucher, if nobody has come in by it yet and it has not expired."""
        found = voucher_of(self._secret, text)
        return None if found is None or now > found.until_ms / 1e3 or found.serial in self._used else found

    def redeem(self, voucher: Voucher) -> None:
        """Somebody has come in by it: it is worth nothing any more."""
        self._used[voucher.serial] = voucher.until_ms / 1e3 + VOUCHER_HOLDS
        if len(self._used) > MOST_USED:
            for serial in sorted(self._used, key=self._used.__getitem__)[: MOST_USED // 2]:
                del self._used[serial]

    def tidy(self, now: float) -> None:
        """Forget what is over."""
        self._used = {serial: until for serial, until in self._used.items() if now < until}
        oldest = self.newest(now) - int(self._grace // self._shown) - 2
        self._spent = {ticket: spent for ticket, spent in self._spent.items() if ticket >= oldest}
        self._late = {ticket: bucket for ticket, bucket in self._late.items() if ticket >= oldest}
