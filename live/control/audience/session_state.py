"""State of the gateway: connected phones, their latest input, and the rules and beat received from the show."""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from live.control.audience import phone_protocol as wire
from live.control.audience.admission import OWN_WIFI, Admission
from live.control.audience.aggregator import Together
from live.control.audience.bans import Bans
from live.control.audience.join_tickets import Tickets
from live.control.audience.participant_state import Voices
from live.control.audience.phone_registry import PATIENCE, TOO_FAST, Device, Phone, Phones
from live.control.audience.rate_limit import ALL_BURST, ALL_RATE, BURST, RATE, Why
from live.control.message_codec import registered

SLIPS: Final = 0.010
"""Phones get a new clock message when their beat would be wrong by this much [s] …"""
AHEAD: Final = 2.0
"""… within this time [s]."""


@registered("rules")
@dataclass(frozen=True, slots=True)
class Rules:
    """The show's rules for phones. Beats are the Timeline's."""

    order: int = 0
    open: bool = True
    muted: bool = False
    shake: bool = True
    half: tuple[float, float] = (6.0, 4.0)
    """Half sizes of the stage [m]."""
    regions: tuple[str, ...] = ()
    weights: tuple[float, ...] = ()
    """Present weight of each region's voices."""
    banned: tuple[int, ...] = ()
    turn: tuple[int, float, float] | None = None
    """Region, first beat and last beat."""
    vote: tuple[int, str, tuple[str, ...], float] | None = None
    """Number, subject, choices, and the beat at which it closes."""
    won: tuple[int, str] = (0, "")


@registered("beat")
@dataclass(frozen=True, slots=True)
class Beat:
    """Beat clock: `beat` at `time` [s of the show], tempo and measure."""

    time: float = 0.0
    beat: float = 0.0
    tempo: float = 120.0
    beats_per_measure: int = 4
    line: float = 0.0
    """Beat of a measure line."""

    def at(self, time: float) -> float:
        """Return the beat at `time` [s]."""
        return self.beat + (time - self.time) * self.tempo / 60.0

    def slipped(self, other: "Beat", now: float) -> bool:
        """Whether `other` differs noticeably from this beat, now or soon."""
        apart = max(abs(self.at(t) - other.at(t)) for t in (now, now + AHEAD)) * 60.0 / self.tempo
        metre = self.beats_per_measure != other.beats_per_measure
        turned = (self.line - other.line) % self.beats_per_measure
        return metre or apart > SLIPS or min(turned, self.beats_per_measure - turned) > 0.01


RESTS = 5.0
"""Time after which the row of a disconnected phone is freed [s]; its voice fades meanwhile."""
SILENT = 50.0
"""A phone sends at least a ping every 20 s; one that is silent for this long [s] is disconnected."""
LEAST_JOINS: Final = 200
"""A code admits twice the maximum of simultaneous phones, as some wait, and at least this number."""
SPARE = 64
"""Additional rows for phones that have just disconnected."""


class Hall:
    """Session state of the gateway. Thread: the gateway's loop."""

    def __init__(self, plan: dict[str, Any]) -> None:
        most = int(plan["most"])
        self._origin = float(plan["origin"])
        secret, network = bytes(plan.get("secret", b"")), str(plan.get("network", OWN_WIFI))
        devices = int(plan.get("joins_per_code") or max(2 * most, LEAST_JOINS))
        self.phones = Phones(most, int(plan["first"]))
        self.tickets = Tickets(secret, float(plan.get("code_s", 30.0)), float(plan.get("grace_s", 120.0)), devices)
        self.admission = Admission(self.phones, self.tickets, network, int(plan["per_address"]), secret)
        self.bans = Bans(apart=self.admission.apart, told=plan.get("bans", ()))
        self.voices = Voices(most + SPARE)
        self.together = Together(self.voices, int(plan["visible"]))
        self.rules, self.beat = Rules(), Beat()
        self.refused: Counter[str] = Counter()
        self.messages = 0
        self.due = 0.0
        """Time [s] of the next aggregate."""
        self.gather: Callable[[], None] = lambda: None
        self._left, self._filled = ALL_BURST, 0.0
        self._parted: dict[int, tuple[int, float]] = {}

    def now(self) -> float:
        """Return the time of the show [s]."""
        return time.perf_counter() - self._origin

    def rule(self, rules: Rules) -> None:
        """Apply new rules."""
        self.rules = rules
        now = self.now()
        if self.bans.rule(rules.banned, self.tickets.newest(now), now):
            self.bans.spread((one.number, one.group, one.origin) for one in self.phones.by_number.values())
        self.voices.rule(rules.weights, sorted(self.bans.numbers()), rules.half)
        self.together.order = rules.order

    # -- connections ---------------------------------------------------------------------------------------------

    def enter(
        self, device: Device, region: int, group: int, browser: int, ws: Any, transport: Any, *, fresh: bool
    ) -> Phone | None:
        """Connect an identified phone, with its previous voice if it had one; None if there is no room.

        `browser`: keyed hash of its browser's identification; `fresh`: it has just joined.
        """
        number, now = device.number, self.now()
        region = min(region, max(len(self.rules.regions) - 1, 0))
        row, _ = self._parted.pop(number, (-1, 0.0))
        before = self.phones.by_number.get(number)
        if before is not None:
            row, before.row = before.row, -1
        heard = not self.bans.enters(device, group, browser, now, fresh=fresh)
        if row < 0:
            row = self.voices.add(number, region, heard=heard)
        if row < 0:
            return None
        self.voices.region[row], self.voices.heard[row] = region, heard
        phone = Phone(number, row, group, ws, transport, device.origin, at=now)
        self.phones.add(phone)
        if before is not None:
            before.transport.abort()
        self.share(phone.group, phone.origin)
        return phone

    def share(self, *groups: int) -> None:
        """Update the fractions of a voice of all phones in these groups."""
        now = self.now()
        for one in self.phones.related(*groups) if self.admission.apart else ():
            if one.row >= 0:
                self.voices.part[one.row] = self.admission.part(one, now)

    def part(self, phone: Phone) -> None:
        """Handle a disconnection: lift the finger and let the voice fade; the phone may reconnect."""
        now = self.now()
        self.phones.remove(phone, now)
        self.share(phone.group, phone.origin)
        if phone.row >= 0:  # otherwise another connection has it
            self.voices.held[phone.row] = False
            self._parted[phone.number] = (phone.row, now)

    def sweep(self) -> None:
        """Free the rows of phones that are gone, and disconnect silent ones."""
        now = self.now()
        for phone in list(self.phones.by_number.values()):
            if now - phone.at > SILENT:
                self.refused[Why.IDLE] += 1
                phone.transport.abort()
        for number, (row, since) in list(self._parted.items()):
            if now - since > RESTS:
                del self._parted[number]
                self.voices.remove(row)
        for group in self.admission.calmed(now):
            self.share(group)
        self.tickets.tidy(now)

    # -- messages ------------------------------------------------------------------------------------------------

    def hear(self, phone: Phone, data: bytes, now: float) -> bytes | None:
        """Handle one message; return its answer (may be empty), or None if the phone must leave. About 20,000 per
        second."""
        self.messages += 1
        if now >= self.due:
            self.gather()
        left = phone.left + (now - phone.at) * RATE
        phone.at = now
        if left < 1.0:
            phone.left = left
            return b"" if self.amiss(phone, Why.FAST) else None
        phone.left = BURST - 1.0 if left > BURST else left - 1.0
        self._left -= 1.0
        if self._left < 0.0:
            self.refused[Why.BUSY] += 1
            return b""
        if len(data) == 6 and data[0] == wire.TOUCH and data[1] <= wire.REPEL:
            if phone.row >= 0:
                self.voices.said_now[phone.row] = (data, now)
            return b""
        if not wire.is_well_formed(data):
            return b"" if self.amiss(phone, Why.MALFORMED) else None
        if data[0] == wire.PING:
            return wire.pong(data, now)
        self._take(phone, data, now)
        return b""

    def amiss(self, phone: Phone, why: Why) -> bool:
        """Count a fault; return whether the phone may stay."""
        self.refused[why] += 1
        if why is Why.FAST:
            phone.fast += 1
        else:
            phone.malformed += 1
        return phone.fast < TOO_FAST and phone.malformed < PATIENCE

    def _take(self, phone: Phone, data: bytes, now: float) -> None:
        """Handle a vote, a region or a shake."""
        verb, vote, row = data[0], self.rules.vote, phone.row
        if row < 0:
            return
        if verb == wire.VOTE:
            if vote is not None and data[1] == vote[0] % 256 and data[2] < len(vote[2]):
                phone.vote = (vote[0], data[2])
        elif verb == wire.REGION:
            self.voices.region[row] = min(data[1], max(len(self.rules.regions) - 1, 0))
        elif self.rules.shake:
            self.voices.shook[row] = now

    # -- aggregate -----------------------------------------------------------------------------------------------

    def turn(self, now: float) -> tuple[Any, ...] | None:
        """Return the event for the show at `now` [s]; None if nothing is new."""
        self._left = min(max(self._left, 0.0) + (now - self._filled) * ALL_RATE, ALL_BURST)
        self._filled = now
        self.voices.take_up()
        return self.together.turn(now, len(self.phones), self.rules.open, self._votes)

    def _votes(self) -> str:
        """Return the open vote's number and the voices for each choice in hundredths; empty if there is no vote."""
        vote = self.rules.vote
        if vote is None:
            return ""
        counts = [0.0] * len(vote[2])
        weights = self.rules.weights or (1.0,)
        for phone in self.phones.by_number.values():
            if phone.vote[0] == vote[0] and phone.row >= 0 and self.voices.heard[phone.row]:
                region = min(int(self.voices.region[phone.row]), len(weights) - 1)
                counts[phone.vote[1]] += weights[region] * float(self.voices.part[phone.row])
        return " ".join(map(str, (vote[0], *(round(100 * count) for count in counts))))

    def facts(self) -> dict[str, Any]:
        """Return facts for the status, without personal data."""
        return {
            "phones": len(self.phones), "messages": self.messages, "crowded": self.admission.crowded,
            "voices": round(self.voices.people(), 2),
            "held": self.bans.held(), "bans": self.bans.tell(),
            "refused": dict(self.refused), "ways_ms": self.together.ways(),
        }  # fmt: skip
