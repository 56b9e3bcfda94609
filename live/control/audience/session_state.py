"""State of the gateway: connected phones, their latest input, and the rules and beat received from the show."""

import math
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.control.audience import phone_protocol as wire
from live.control.audience.admission import OWN_WIFI, Admission
from live.control.audience.bans import Bans
from live.control.audience.join_tickets import JoinTickets
from live.control.audience.participant_state import Hearing, Voices
from live.control.audience.phone_registry import MAX_FAST, MAX_MALFORMED, Device, Phone, Phones
from live.control.audience.rate_limit import ALL_BURST, ALL_RATE, BURST, RATE, RefusalReason
from live.control.audience.voice_report import VoiceReport, VoiceReporter
from live.control.audience.voice_sketch import UNIT
from live.control.message_codec import registered

CLOCK_TOLERANCE: Final = 0.010
"""Phones get a new clock message when their beat would be wrong by this much [s] …"""
CLOCK_HORIZON: Final = 2.0
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
    invitation: int = 1
    """Number of the operator's invitation that is valid."""


@registered("beat")
@dataclass(frozen=True, slots=True)
class BeatClock:
    """Beat clock: `beat` at `time` [s of the show], tempo and measure."""

    time: float = 0.0
    beat: float = 0.0
    tempo: float = 120.0
    beats_per_measure: int = 4
    line: float = 0.0
    """Beat of a measure line."""

    def beat_at(self, time: float) -> float:
        """Return the beat at `time` [s]."""
        return self.beat + (time - self.time) * self.tempo / 60.0

    def differs(self, other: "BeatClock", now: float) -> bool:
        """Whether `other` differs noticeably from this beat, now or soon."""
        apart = max(abs(self.beat_at(t) - other.beat_at(t)) for t in (now, now + CLOCK_HORIZON)) * 60.0 / self.tempo
        metre = self.beats_per_measure != other.beats_per_measure
        turned = (self.line - other.line) % self.beats_per_measure
        return metre or apart > CLOCK_TOLERANCE or min(turned, self.beats_per_measure - turned) > 0.01


ROW_KEPT_SECONDS = 5.0
"""Time after which the row of a disconnected phone is freed [s]; its voice fades meanwhile."""
SILENCE_TIMEOUT = 50.0
"""A phone sends at least a ping every 20 s; one that is silent for this long [s] is disconnected."""
MIN_JOINS_PER_CODE: Final = 200
"""A code admits twice the maximum of simultaneous phones, as some wait, and at least this number."""
SHOW_SILENCE: Final = 5.0
"""The show sends its beat every second; without a packet for this long [s] phones are not heard."""
SPARE_ROWS = 64
"""Additional rows for phones that have just disconnected."""


class SessionState:
    """Session state of the gateway. Thread: the gateway's loop."""

    def __init__(self, plan: dict[str, Any]) -> None:
        most = int(plan["most"])
        self._origin = float(plan["origin"])
        secret, network = bytes(plan.get("secret", b"")), str(plan.get("network", OWN_WIFI))
        devices = int(plan.get("joins_per_code") or max(2 * most, MIN_JOINS_PER_CODE))
        self.phones = Phones(most, int(plan["first"]))
        self.phones.most_in_all = int(plan.get("most_in_all", most))
        self.tickets = JoinTickets(secret, float(plan.get("code_s", 30.0)), float(plan.get("grace_s", 120.0)), devices)
        self.admission = Admission(self.phones, self.tickets, network, int(plan["per_address"]), secret)
        self.bans = Bans(has_groups=self.admission.has_groups, exported=plan.get("bans", ()))
        self.voices = Voices(most + SPARE_ROWS)
        self.reporter = VoiceReporter(self.voices, int(plan["visible"]))
        self.rules, self.beat = Rules(), BeatClock()
        self.refused: Counter[str] = Counter()
        self.tally: tuple[int, ...] = ()
        """The open vote's number and the votes for each choice in hundredths; empty: there is no vote."""
        self.heard_show_at = -math.inf
        """Time [s] of the show's last packet."""
        self.messages = 0
        self.due = 0.0
        """Time [s] of the next aggregate."""
        self.gather: Callable[[], None] = lambda: None
        self._tokens_left, self._filled = ALL_BURST, 0.0
        self._disconnected: dict[int, tuple[int, float]] = {}

    def now(self) -> float:
        """Return the time of the show [s]."""
        return time.perf_counter() - self._origin

    def shift_clock(self, seconds: float) -> None:
        """Let the time of the show be so much later."""
        self._origin -= seconds

    def update_rules(self, rules: Rules) -> None:
        """Apply new rules."""
        self.rules = rules
        now = self.now()
        if self.bans.set_banned(rules.banned, self.tickets.newest(now), now):
            self.bans.spread((one.number, one.group, one.origin) for one in self.phones.by_number.values())
        self._apply_bans()
        self.tickets.set_invitation(rules.invitation)

    def merge_bans(self, exported: Any) -> None:
        """Take over what other gateways know of banned phones (`Bans.export`); ValueError or TypeError for anything
        else."""
        if self.bans.merge(exported):
            self.bans.spread((one.number, one.group, one.origin) for one in self.phones.by_number.values())
            self._apply_bans()

    def _apply_bans(self) -> None:
        self.voices.update_rules(self.rules.weights, sorted(self.bans.numbers()), self.rules.half)

    # -- connections ---------------------------------------------------------------------------------------------

    def enter(
        self, device: Device, region: int, group: int, browser: int, ws: Any, transport: Any, *, fresh: bool
    ) -> Phone | None:
        """Connect an identified phone, with its previous voice if it had one; None if there is no room.

        `browser`: keyed hash of its browser's identification; `fresh`: it has just joined.
        """
        number, now = device.number, self.now()
        region = min(region, max(len(self.rules.regions) - 1, 0))
        row, _ = self._disconnected.pop(number, (-1, 0.0))
        before = self.phones.by_number.get(number)
        if before is not None:
            row, before.row = before.row, -1
        heard = not self.bans.check_entry(device, group, browser, now, fresh=fresh)
        if row < 0:
            row = self.voices.add(number, region, allowed=heard)
        if row < 0:
            return None
        self.voices.region[row], self.voices.allowed[row] = region, heard
        self.voices.told_hearing[row] = Hearing.SILENT
        phone = Phone(number, row, group, ws, transport, device.origin, last_message_at=now)
        self.phones.add(phone)
        if before is not None:
            before.transport.abort()
        self.update_shares(phone.group, phone.origin)
        return phone

    def update_shares(self, *groups: int) -> None:
        """Update the fractions of a voice of all phones in these groups."""
        now = self.now()
        for one in self.phones.related(*groups) if self.admission.has_groups else ():
            if one.row >= 0:
                self.voices.share[one.row] = self.admission.voice_share(one, now)

    def disconnect(self, phone: Phone) -> None:
        """Handle a disconnection: lift the finger and let the voice fade; the phone may reconnect."""
        now = self.now()
        self.phones.remove(phone, now)
        self.update_shares(phone.group, phone.origin)
        if phone.row >= 0:  # otherwise another connection has it
            self.voices.touching[phone.row] = False
            self._disconnected[phone.number] = (phone.row, now)

    def give_up(self, number: int) -> None:
        """Cut off a phone that is connected to another gateway by now; its voice is there."""
        phone = self.phones.by_number.get(number)
        if phone is not None:
            row, phone.row, phone.left_by_itself = phone.row, -1, True
            if row >= 0:
                self.voices.remove(row)
            phone.transport.abort()

    def sweep(self) -> None:
        """Free the rows of phones that are gone, and disconnect silent ones."""
        now = self.now()
        for phone in list(self.phones.by_number.values()):
            if now - phone.last_message_at > SILENCE_TIMEOUT:
                self.refused[RefusalReason.IDLE] += 1
                phone.transport.abort()
        for number, (row, since) in list(self._disconnected.items()):
            if now - since > ROW_KEPT_SECONDS:
                del self._disconnected[number]
                self.voices.remove(row)
        for group in self.admission.expire_crowds(now):
            self.update_shares(group)
        self.tickets.expire(now)

    # -- messages ------------------------------------------------------------------------------------------------

    def handle_message(self, phone: Phone, data: bytes, now: float) -> bytes | None:
        """Handle one message; return its answer (may be empty), or None if the phone must leave. About 20,000 per
        second."""
        self.messages += 1
        if now >= self.due:
            self.gather()
        left = phone.tokens_left + (now - phone.last_message_at) * RATE
        phone.last_message_at = now
        if left < 1.0:
            phone.tokens_left = left
            return b"" if self.count_fault(phone, RefusalReason.FAST) else None
        phone.tokens_left = BURST - 1.0 if left > BURST else left - 1.0
        self._tokens_left -= 1.0
        if self._tokens_left < 0.0:
            self.refused[RefusalReason.BUSY] += 1
            return b""
        if len(data) == 6 and data[0] == wire.TOUCH and data[1] <= wire.REPEL:
            if phone.row >= 0:
                self.voices.pending_touches[phone.row] = (data, now)
            return b""
        if not wire.is_well_formed(data):
            return b"" if self.count_fault(phone, RefusalReason.MALFORMED) else None
        if data[0] == wire.PING:
            return wire.pong(data, now)
        self._handle_verb(phone, data, now)
        return b""

    def count_fault(self, phone: Phone, why: RefusalReason) -> bool:
        """Count a fault; return whether the phone may stay."""
        self.refused[why] += 1
        if why is RefusalReason.FAST:
            phone.fast += 1
        else:
            phone.malformed += 1
        return phone.fast < MAX_FAST and phone.malformed < MAX_MALFORMED

    def _handle_verb(self, phone: Phone, data: bytes, now: float) -> None:
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
            self.voices.shake_time[row] = now

    # -- aggregate -----------------------------------------------------------------------------------------------

    def report(self, now: float) -> VoiceReport:
        """Return what the phones say at `now` [s]."""
        self._tokens_left = min(max(self._tokens_left, 0.0) + (now - self._filled) * ALL_RATE, ALL_BURST)
        self._filled = now
        self.voices.apply_touches()
        return self.reporter.report(
            now, self.rules.order, len(self.phones.by_number), self.rules.open, self._count_votes
        )

    def changed_hearing(self, now: float) -> list[tuple[Phone, int]]:
        """Return the phones that have to be told another `Hearing`; they count as told."""
        voices, turn = self.voices, self.rules.turn
        found = voices.hearing(
            now, self.reporter.highlights.rows, turn=-1 if turn is None else turn[0],
            answers=now - self.heard_show_at < SHOW_SILENCE,
        )  # fmt: skip
        if not self.rules.open:
            found[:] = Hearing.SILENT
        changed = np.flatnonzero(found != voices.told_hearing)
        voices.told_hearing[changed] = found[changed]
        phones = ((self.phones.by_number.get(int(voices.number[row])), int(found[row])) for row in changed)
        return [(phone, hearing) for phone, hearing in phones if phone is not None]

    def _count_votes(self) -> tuple[int, ...]:
        """Return the open vote's number and the weight of the votes for each choice in `UNIT`."""
        vote = self.rules.vote
        if vote is None:
            return ()
        counts = [0] * len(vote[2])
        weights = self.rules.weights or (1.0,)
        for phone in self.phones.by_number.values():
            if phone.vote[0] == vote[0] and phone.row >= 0 and self.voices.allowed[phone.row]:
                region = min(int(self.voices.region[phone.row]), len(weights) - 1)
                counts[phone.vote[1]] += round(UNIT * weights[region] * float(self.voices.share[phone.row]))
        return (vote[0], *counts)

    def facts(self) -> dict[str, Any]:
        """Return facts for the status, without personal data."""
        return {
            "phones": len(self.phones), "messages": self.messages, "crowded": self.admission.crowded,
            "voices": round(self.voices.people(), 2),
            "held": self.bans.covered(), "bans": self.bans.export(),
            "refused": dict(self.refused), "ways_ms": self.reporter.wait_times(),
        }  # fmt: skip
