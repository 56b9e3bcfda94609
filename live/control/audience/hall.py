"""Hall: everybody who plays, what they said last, and what the show lets them: what all parts of the gateway share."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from live.control.audience import wire
from live.control.audience.phones import PATIENCE, TOO_FAST, Phone, Phones
from live.control.audience.refused import ALL_BURST, ALL_RATE, BURST, RATE, Why
from live.control.audience.rules import Beat, Rules
from live.control.audience.together import Together
from live.control.audience.voices import Voices

RESTS = 5.0
"""The voice of a phone that is cut off fades; its row is free after so long [s]."""
SILENT = 50.0
"""A phone says something every 20 s, and be it only a ping; who does not for so long [s] is not there."""
SPARE = 64
"""Rows for those who have just gone."""


class Hall:
    """Thread: the gateway's loop."""

    def __init__(self, plan: dict[str, Any]) -> None:
        most = int(plan["most"])
        self._origin = float(plan["origin"])
        self.phones = Phones(most, int(plan["per_address"]), int(plan["first"]))
        self.voices = Voices(most + SPARE)
        self.together = Together(self.voices, int(plan["visible"]))
        self.rules, self.beat = Rules(), Beat()
        self.refused: Counter[str] = Counter()
        self.messages = 0
        self.due = 0.0
        """When [s] all are gathered next."""
        self.gather: Callable[[], None] = lambda: None
        self._left, self._filled = ALL_BURST, 0.0
        self._parted: dict[int, tuple[int, float]] = {}

    def now(self) -> float:
        """Seconds of the show."""
        return time.perf_counter() - self._origin

    def rule(self, rules: Rules) -> None:
        """These are the rules from now on."""
        self.rules = rules
        self.voices.rule(rules.weights, rules.banned, rules.half)
        self.together.order = rules.order

    # -- who is there --------------------------------------------------------------------------------------------

    def enter(self, number: int, region: int, address: str, ws: Any, transport: Any) -> Phone | None:
        """A phone has said who it is: with the voice that it had, if it was there; None if there is no room."""
        region = min(region, max(len(self.rules.regions) - 1, 0))
        row, _ = self._parted.pop(number, (-1, 0.0))
        before = self.phones.by_number.get(number)
        if before is not None:
            row, before.row = before.row, -1
        if row < 0:
            row = self.voices.add(number, region, heard=number not in self.rules.banned)
        if row < 0:
            return None
        self.voices.region[row] = region
        phone = Phone(number, row, address, ws, transport, at=self.now())
        self.phones.add(phone)
        if before is not None:
            before.transport.abort()
        self._share(address)
        return phone

    def _share(self, address: str) -> None:
        phones, part = self.phones.parts(address)
        for phone in phones:
            if phone.row >= 0:
                self.voices.part[phone.row] = part

    def part(self, phone: Phone) -> None:
        """A phone is cut off: its finger is lifted, its voice fades; it may come again."""
        self.phones.remove(phone)
        self._share(phone.address)
        if phone.row >= 0:  # else somebody else has it
            self.voices.held[phone.row] = False
            self._parted[phone.number] = (phone.row, self.now())

    def sweep(self) -> None:
        """Free the rows of those who have gone for good, and cut off who has fallen silent."""
        now = self.now()
        for phone in list(self.phones.by_number.values()):
            if now - phone.at > SILENT:
                phone.transport.abort()
        for number, (row, since) in list(self._parted.items()):
            if now - since > RESTS:
                del self._parted[number]
                self.voices.remove(row)

    # -- what they say -------------------------------------------------------------------------------------------

    def hear(self, phone: Phone, data: bytes, now: float) -> bytes | None:
        """One message: its answer, or none (empty); None if the phone must leave. Twenty thousand come a second."""
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
        """Count something amiss; whether the phone may stay."""
        self.refused[why] += 1
        if why is Why.FAST:
            phone.fast += 1
        else:
            phone.malformed += 1
        return phone.fast < TOO_FAST and phone.malformed < PATIENCE

    def _take(self, phone: Phone, data: bytes, now: float) -> None:
        """A vote, a region, a shake."""
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

    # -- what all want -------------------------------------------------------------------------------------------

    def turn(self, now: float) -> tuple[Any, ...] | None:
        """What the show is to be told at `now` [s]; None if nothing is new."""
        self._left = min(max(self._left, 0.0) + (now - self._filled) * ALL_RATE, ALL_BURST)
        self._filled = now
        self.voices.take_up()
        return self.together.turn(now, len(self.phones), self.rules.open, self._votes)

    def _votes(self) -> str:
        """The number of the vote that runs, and the voices for each choice in hundredths; empty if none runs."""
        vote = self.rules.vote
        if vote is None:
            return ""
        counts = [0.0] * len(vote[2])
        weights, banned = self.rules.weights or (1.0,), set(self.rules.banned)
        for phone in self.phones.by_number.values():
            if phone.vote[0] == vote[0] and phone.number not in banned and phone.row >= 0:
                region = min(int(self.voices.region[phone.row]), len(weights) - 1)
                counts[phone.vote[1]] += weights[region] * float(self.voices.part[phone.row])
        return " ".join(map(str, (vote[0], *(round(100 * count) for count in counts))))

    def facts(self) -> dict[str, Any]:
        """For the status: nothing of anybody."""
        return {
            "phones": len(self.phones), "messages": self.messages,
            "refused": dict(self.refused), "ways_ms": self.together.ways(),
        }  # fmt: skip
