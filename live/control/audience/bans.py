"""Bans of phones, including attempts to return as a new phone.

The operator bans a phone by its number; its token stays banned. A ban also covers phones that are the same device as
far as the network shows. Where phones have groups of their own (see `admission`), these are the phones in its group and
in the group in which it joined. Behind nat, these are phones that join again from its address with a code displayed
before the ban or, for some minutes, with the same browser and languages. Groups and browsers are keyed hashes, kept in
memory only. Banned phones are not notified.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Final

from live.control.audience.phone_registry import Device

BROWSER_BAN_SECONDS: Final = 600.0
"""Behind nat, a ban covers new phones with the same browser for this long [s]."""
MOST_KNOWN: Final = 16_384
MAX_COVERED: Final = 64
"""Maximum of other phones covered by one ban, by number; the latest are kept."""
MAX_EXPORTED: Final = 128
"""Maximum of bans that the show keeps for the next gateway; the latest are kept."""


@dataclass(frozen=True, slots=True)
class PhoneIdentity:
    """Known data of a phone that has joined."""

    device: Device
    group: int
    browser: int


@dataclass(slots=True)
class Ban:
    """One ban, with the phones it covers."""

    groups: set[int] = field(default_factory=set)
    browser: int = 0
    ticket: int = -1
    """The newest ticket displayed when the ban began."""
    until: float = 0.0
    """End of the ban on its browser [s of the show]."""
    covered: dict[int, None] = field(default_factory=dict)
    """Numbers of the other phones covered."""


class Bans:
    """All bans. Thread: the gateway's loop."""

    def __init__(self, *, has_groups: bool, exported: Iterable[Any] = ()) -> None:
        """`has_groups`: whether phones have groups of their own; `exported`: `export` of the previous gateway."""
        self._has_groups = has_groups
        self._known: dict[int, PhoneIdentity] = {}
        self._bans: dict[int, Ban] = {}
        self._before = _imported(exported)

    def set_banned(self, numbers: Iterable[int], ticket: int, now: float) -> bool:
        """Replace the banned numbers; return whether they changed. `ticket`: the newest."""
        wanted = dict.fromkeys(numbers)
        if wanted.keys() == self._bans.keys():
            return False
        for number in self._bans.keys() - wanted.keys():
            del self._bans[number]
        for number in wanted:
            if number not in self._bans:
                known = self._before.pop(number, None)
                self._bans[number] = known or Ban(ticket=ticket, until=now + BROWSER_BAN_SECONDS)
                if number in self._known:
                    self._add_traits(self._bans[number], self._known[number])
        self._before.clear()
        return True

    def _add_traits(self, ban: Ban, trace: PhoneIdentity) -> None:
        ban.groups |= {trace.group, trace.device.origin}
        ban.browser = ban.browser or trace.browser

    def check_entry(self, device: Device, group: int, browser: int, now: float, *, fresh: bool) -> bool:
        """Record a phone that joins; return whether a ban covers it. `fresh`: it has just joined."""
        trace = PhoneIdentity(device, group, browser)
        self._known.pop(device.number, None)
        self._known[device.number] = trace
        if len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        for number, ban in self._bans.items():
            if number == device.number or device.number in ban.covered:
                self._add_traits(ban, trace)
                return True
            if self._matches(ban, trace, now, fresh=fresh):
                self._cover(ban, trace)
                return True
        return False

    def _matches(self, ban: Ban, trace: PhoneIdentity, now: float, *, fresh: bool) -> bool:
        if not ban.groups & {trace.group, trace.device.origin}:
            return False
        same_browser = bool(ban.browser) and trace.browser == ban.browser and now < ban.until
        return self._has_groups or (fresh and (trace.device.ticket <= ban.ticket or same_browser))

    def _cover(self, ban: Ban, trace: PhoneIdentity) -> None:
        ban.covered[trace.device.number] = None
        if self._has_groups:
            self._add_traits(ban, trace)
        while len(ban.covered) > MAX_COVERED:
            del ban.covered[next(iter(ban.covered))]

    def spread(self, there: Iterable[tuple[int, int, int]]) -> None:
        """Extend bans to connected phones (number, group, origin) of the banned groups.

        This applies only where phones have groups of their own.
        """
        if not self._has_groups:
            return
        for number, group, origin in there:
            for banned, ban in self._bans.items():
                if number != banned and ban.groups & {group, origin}:
                    self._cover(ban, PhoneIdentity(Device(number, 0, origin), group, 0))

    def merge(self, exported: Iterable[Any]) -> bool:
        """Take over what other gateways know of the banned phones (`export`); return whether anything is new.

        ValueError or TypeError for anything else.
        """
        new = False
        for number, other in _imported(exported).items():
            ban = self._bans.get(number)
            if ban is None:
                self._before[number] = other  # if it is banned here in a moment
                continue
            groups = len(ban.groups), len(ban.covered), ban.browser
            ban.groups |= other.groups
            ban.browser = ban.browser or other.browser
            ban.covered.update(dict.fromkeys(list(other.covered)[-MAX_COVERED:]))
            while len(ban.covered) > MAX_COVERED:
                del ban.covered[next(iter(ban.covered))]
            while len(ban.groups) > MAX_COVERED:
                ban.groups.pop()
            new |= groups != (len(ban.groups), len(ban.covered), ban.browser)
        return new

    def numbers(self) -> set[int]:
        """Return the numbers of all banned and covered phones."""
        return {*self._bans, *(number for ban in self._bans.values() for number in ban.covered)}

    def covered(self) -> dict[str, list[int]]:
        """Return the phones covered by each ban, by banned number, for the operator."""
        return {str(number): list(ban.covered)[-8:] for number, ban in list(self._bans.items())[-16:] if ban.covered}

    def export(self) -> list[Any]:
        """Return the bans as rows of plain values, for the next gateway."""
        return _rows(self._bans)


def exported(rows: Iterable[Any]) -> list[Any]:
    """Return rows of `Bans.export` that came from another process; ValueError or TypeError if they are none."""
    return _rows(_imported(rows))


def _rows(bans: dict[int, Ban]) -> list[Any]:
    return [[number, sorted(ban.groups)[:8], ban.browser, ban.ticket, ban.until, list(ban.covered)[-16:]]
            for number, ban in list(bans.items())[-MAX_EXPORTED:]]  # fmt: skip


def _imported(rows: Iterable[Any]) -> dict[int, Ban]:
    return {int(number): Ban(set(map(int, groups)), int(browser), int(ticket), float(until),
                             dict.fromkeys(map(int, held)))
            for number, groups, browser, ticket, until, held in rows}  # fmt: skip
