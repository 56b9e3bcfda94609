"""Reduction of several gateways to one audience: merged voices, shared groups, lights and votes.

A gateway that is late or gone fades as a lifted finger does, with its phones, so that the force does not jump. What a
gateway claims is bounded by the phones that it may have, and counted where it exceeds them.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from live import __version__
from live.control.audience.admission import CROWD_SECONDS
from live.control.audience.bans import exported
from live.control.audience.participant_state import FADE_HALF_LIFE, FRESH_SECONDS, MIN_FRESHNESS
from live.control.audience.session_state import ROW_KEPT_SECONDS, SPARE_ROWS, Rules
from live.control.audience.voice_report import HIGHLIGHT_SECONDS, VoiceReport, is_light
from live.control.audience.voice_sketch import UNIT, VoiceSketch, grid_of, merge
from live.control.message_codec import PacketError, decode_packet, encode_packet
from live.control.shards.messages import (
    PROTOCOL,
    VOICES,
    ShardChanges,
    ShardHello,
    ShardNumbers,
    ShardPing,
    ShardPlan,
    ShardRefused,
    ShardShown,
    SharedState,
    unpack_voices,
)
from live.control.shards.shard_facts import TurnedAway, checked_facts, connected_row, merged_facts
from live.control.shards.shared_groups import SharedGroups

MAX_SHARDS: Final = 64
"""Most gateways of a show."""
STATE_EVERY: Final = 0.25
"""Interval of `SharedState` [s]."""
NUMBERS_AT_ONCE: Final = 256
"""Numbers for new phones that a gateway gets when it asks, at most once per `STATE_EVERY`."""
MOST_AHEAD: Final = 1 << 20
"""A gateway may know of numbers so far above the reducer's own, which was restarted."""
ORDER_TIMEOUT: Final = 0.5
"""Time for gateways to follow an operator's command [s]; the voices of one that has not do not count then."""
CLOCKS_APART: Final = 5.0
"""A gateway's clock may be so far off [s]."""
TOLERANCE: Final = 1.01
"""Sums may exceed their bound by so much: they are rounded."""


@dataclass(slots=True, eq=False)
class Shard:
    """A gateway, as the reducer knows it."""

    name: str
    where: str
    """The machine it runs on."""
    capacity: int
    send: Callable[[bytes], object]
    close: Callable[[], None]
    report: VoiceReport | None = None
    heard_at: float = 0.0
    """Time of its last report [s] ..."""
    gone: bool = False
    """... which stays a while after its connection has ended."""
    peak: int = 0
    peak_at: float = 0.0
    """Most phones it had lately, and when: voices stay a moment longer than their phones."""
    lights: tuple[Any, ...] = ()
    votes: tuple[int, ...] = ()
    visible: int = 0
    debt: float = 0.0
    """Lights that it is owed from earlier turns."""
    wants_numbers: bool = False
    facts: dict[str, Any] = field(default_factory=dict)
    lies: int = 0
    """Packets in which it claimed more than it may have, or that could not be read."""

    def freshness(self, now: float) -> float:
        """Return the share of its weight that its voices have left."""
        fresh = 0.5 ** (max(now - self.heard_at - FRESH_SECONDS, 0.0) / FADE_HALF_LIFE)
        return fresh if fresh >= MIN_FRESHNESS else 0.0


class Reduction:
    """All gateways of one show. Thread: one."""

    def __init__(self, plan: dict[str, Any]) -> None:
        """`plan`: what the show says of its audience, as for a gateway that is alone."""
        self._plan = plan
        self._visible = int(plan["visible"])
        self.rules = Rules()
        self._rules_at = 0.0
        self.shards: dict[str, Shard] = {}
        self.groups = SharedGroups()
        self.next_number = int(plan["first"])
        self._bans: dict[int, Any] = {int(row[0]): row for row in plan.get("bans", ())}
        self._show_packets: dict[str, bytes] = {}
        self._state_at = self._lights_at = 0.0
        self.refused: Counter[str] = Counter()
        self.turned_away = TurnedAway()
        self._tally: tuple[int, ...] = ()

    # -- the show ------------------------------------------------------------------------------------------------

    def update_rules(self, rules: Rules, now: float) -> None:
        """Take new rules of the show, and pass them on."""
        if rules.order != self.rules.order:
            self._rules_at = now
        self.rules = rules
        self._bans = {number: row for number, row in self._bans.items() if number in rules.banned}
        self.pass_on("rules", encode_packet(rules))

    def pass_on(self, what: str, packet: bytes) -> None:
        """Send a packet of the show to all gateways; those that come later get the last of each kind."""
        self._show_packets[what] = packet
        for shard in self._there():
            shard.send(packet)

    def _there(self) -> list[Shard]:
        return [shard for shard in self.shards.values() if not shard.gone]

    # -- gateways --------------------------------------------------------------------------------------------------

    def enter(
        self, hello: Any, where: str, send: Callable[[bytes], object], close: Callable[[], None], now: float
    ) -> Shard | None:
        """Let a gateway in that says hello from the machine `where`; None if it does not fit: it is told why."""
        why = ""
        if not isinstance(hello, ShardHello):
            why = "a gateway's hello expected"
        elif hello.protocol != PROTOCOL:
            why = f"this gateway is of version {hello.version[:40]}, the show of {__version__}: install the same"
        elif not hello.capacity > 0 or not 0 < len(hello.name) <= 64 or not hello.name.isprintable():
            why = "a name and room for phones expected"
        elif len(self._there()) >= MAX_SHARDS and hello.name not in self.shards:
            why = f"there are {MAX_SHARDS} gateways already"
        elif hello.name in self.shards and self.shards[hello.name].where != where:
            why = "a gateway of another machine has this name"
        if why:
            self.refused["gateway: does not fit"] += 1
            if isinstance(hello, ShardHello):
                self.turned_away.add(hello.name, where, hello.version, why, now)
            send(encode_packet(ShardRefused(why)))
            return None
        self.turned_away.remove(hello.name)
        plan, before = self._plan, self.shards.get(hello.name)
        capacity = min(hello.capacity, int(plan["most"]))
        shard = Shard(hello.name, where, capacity, send, close)
        if before is not None:  # the same gateway on a new connection: it goes on from what it had
            before.close()
            shard = replace(before, send=send, close=close, where=where, capacity=capacity, gone=False)
            self.groups.remove(hello.name)
        self.shards[hello.name] = shard
        if 0 <= hello.highest < self.next_number + MOST_AHEAD:
            self.next_number = max(self.next_number, hello.highest + 1)
        send(encode_packet(ShardPlan(
            time=now, secret=plan["secret"], link=plan["link"], most=capacity, most_in_all=int(plan["most"]),
            per_address=int(plan["per_address"]), network=plan["network"], proxies=tuple(plan["proxies"]),
            by_card=bool(plan["by_card"]), code_s=float(plan["code_s"]), grace_s=float(plan["grace_s"]),
            joins_per_code=int(plan["joins_per_code"] or 0),
        )))  # fmt: skip
        for packet in self._show_packets.values():
            send(packet)
        if self._bans:
            send(encode_packet(("bans", list(self._bans.values()))))
        self._give_numbers(shard)
        self._share_state(now)
        return shard

    def restart(self, name: str) -> None:
        """Let a gateway start again: its phones come back at the others meanwhile."""
        shard = self.shards.get(name)
        if shard is not None and not shard.gone:
            shard.send(encode_packet(("restart",)))

    def leave(self, shard: Shard) -> None:
        """Handle the end of a gateway's connection: what it said fades."""
        if self.shards.get(shard.name) is shard:
            shard.gone = True
            self.groups.remove(shard.name)

    def handle(self, shard: Shard, data: bytes, now: float) -> None:
        """Handle a packet of a gateway."""
        try:
            if data[:1] == bytes((VOICES,)):
                self._hear(shard, unpack_voices(data), now)
            else:
                self._handle_object(shard, decode_packet(data), now)
        except (PacketError, ValueError, TypeError, LookupError, ArithmeticError, AttributeError):
            self._count_lie(shard, 1)

    def _handle_object(self, shard: Shard, packet: Any, now: float) -> None:
        most = shard.capacity + SPARE_ROWS
        match packet:
            case ShardShown():
                self._show(shard, packet)
            case ShardChanges():
                latest = now + CROWD_SECONDS + CLOCKS_APART
                self._count_lie(shard, self.groups.update_groups(shard.name, packet.groups, most, latest))
                self._count_lie(shard, self.groups.update_numbers(shard.name, packet.came, packet.went, most))
            case ShardPing():
                shard.send(encode_packet(ShardPing(packet.sent, now)))
            case ("numbers",):
                shard.wants_numbers = True
            case ("bans", rows):
                self._share_bans(shard, rows)
            case dict():
                shard.facts = checked_facts(packet)
            case _:
                self._count_lie(shard, 1)

    def _count_lie(self, shard: Shard, count: int) -> None:
        if count:
            shard.lies += count
            self.refused["gateway: claims too much"] += count

    def _hear(self, shard: Shard, report: VoiceReport, now: float) -> None:
        """Take what a gateway hears, within its bounds."""
        phones = min(report.phones, shard.capacity)
        if phones >= shard.peak or now - shard.peak_at > ROW_KEPT_SECONDS + 1.0:
            shard.peak, shard.peak_at = phones, now
        sketch, fits = bounded(report.sketch, max(shard.peak, phones) * UNIT, self._most_weight())
        if not fits or phones != report.phones:
            self._count_lie(shard, 1)
        shard.report = VoiceReport(report.order, phones, min(report.speaking, phones), sketch)
        shard.heard_at = now

    def _most_weight(self) -> float:
        """Return the largest weight of a voice by the rules."""
        return max(self.rules.weights or (1.0,))

    def _show(self, shard: Shard, packet: ShardShown) -> None:
        """Take a gateway's lights and votes, within its bounds."""
        lights = tuple(row for row in packet.lights if is_light(row))
        most = max(shard.peak, 1) * UNIT * self._most_weight() * TOLERANCE
        fits = all(votes >= 0 for votes in packet.votes) and sum(packet.votes[1:]) <= most
        self._count_lie(shard, (not fits) + (len(packet.lights) > self._visible) + len(packet.lights) - len(lights))
        shard.lights = lights[: shard.visible]
        if fits:
            shard.votes = packet.votes

    def _give_numbers(self, shard: Shard) -> None:
        first, self.next_number = self.next_number, self.next_number + NUMBERS_AT_ONCE
        shard.wants_numbers = False
        shard.send(encode_packet(ShardNumbers(first, self.next_number)))

    def _share_bans(self, shard: Shard, rows: Any) -> None:
        """Pass on what a gateway knows of banned phones."""
        known = [row for row in exported(rows) if row[0] in self.rules.banned]
        for row in known:
            before = self._bans.get(row[0])
            if before is not None:
                _, groups, browser, ticket, until, held = before
                row = [row[0], sorted({*groups, *row[1]})[:8], browser or row[2], ticket, until,
                       list(dict.fromkeys((*held, *row[5])))[-16:]]  # fmt: skip
            self._bans[row[0]] = row
        if known:
            packet = encode_packet(("bans", known))
            for other in self._there():
                if other is not shard:
                    other.send(packet)

    # -- each tick -------------------------------------------------------------------------------------------------

    def report(self, now: float) -> VoiceReport:
        """Return what all gateways hear at `now` [s], and tell them what they have to know."""
        self._forget_faded(now)
        for shard in self._there():
            others = self.groups.pop_others(shard.name)
            if others is not None:
                shard.send(encode_packet(others))
        counted = self._counted(now)
        parts = [(shard, shard.report, shard.freshness(now)) for shard in counted if shard.report is not None]
        sketch = merge(grid_of(self.rules.half), (
            told.sketch if fresh == 1.0 else told.sketch.scaled(fresh) for _, told, fresh in parts
        ))  # fmt: skip
        order = min((told.order for _, told, _ in parts), default=self.rules.order)
        found = VoiceReport(
            order, round(sum(told.phones * fresh for _, told, fresh in parts)),
            sum(told.speaking for _, told, _ in parts),
            sketch if self.rules.open else merge(sketch.grid, ()),
            tuple(light for shard in counted for light in shard.lights)[: self._visible], self._votes(counted),
        )  # fmt: skip
        self._tally = found.tally
        if now - self._state_at >= STATE_EVERY:
            self._share_state(now)
        return found

    def _counted(self, now: float) -> list[Shard]:
        """Return the gateways whose voices count, in an order that does not depend on who came first."""
        late = now - self._rules_at > ORDER_TIMEOUT
        return [
            shard for _, shard in sorted(self.shards.items())
            if shard.report is not None and (shard.report.order == self.rules.order or not (late or shard.gone))
        ]  # fmt: skip

    def _votes(self, counted: list[Shard]) -> tuple[int, ...]:
        """Return the votes of all gateways for the open vote."""
        vote = self.rules.vote
        if vote is None:
            return ()
        told = [shard.votes[1:] for shard in counted if shard.votes[:1] == vote[:1] and not shard.gone]
        fitting = [votes for votes in told if len(votes) == len(vote[2])]
        return (vote[0], *(sum(votes) for votes in zip(*fitting, strict=True))) if fitting else (
            vote[0], *(0 for _ in vote[2])
        )  # fmt: skip

    def _forget_faded(self, now: float) -> None:
        for name, shard in list(self.shards.items()):
            if shard.gone and not shard.freshness(now):
                del self.shards[name]

    def _share_state(self, now: float) -> None:
        """Tell all gateways how many phones there are, how many lights each has, and how the vote stands."""
        self._state_at = now
        there = self._there()
        self._share_lights(there, now)
        phones = {shard.name: 0 if shard.report is None else shard.report.phones for shard in there}
        total = sum(phones.values())
        for shard in there:
            if shard.wants_numbers:
                self._give_numbers(shard)
            shard.send(encode_packet(SharedState(total - phones[shard.name], shard.visible, self._tally)))

    def _share_lights(self, there: list[Shard], now: float) -> None:
        """Divide the lights among gateways by the phones that speak there; who got too few gets more the next time."""
        speaking = {shard.name: 0 if shard.report is None else shard.report.speaking for shard in there}
        total = sum(speaking.values())
        next_turn = now - self._lights_at >= HIGHLIGHT_SECONDS
        wanted = {shard.name: min(self._visible * speaking[shard.name] / max(total, 1), speaking[shard.name])
                  for shard in there}  # fmt: skip
        if next_turn:
            self._lights_at = now
            for shard in there:
                shard.debt = min(max(shard.debt + wanted[shard.name] - shard.visible, -1.0), 1.0)
        left = self._visible
        for shard in there:
            shard.visible = min(int(wanted[shard.name]), left)
            left -= shard.visible
        owed = sorted(there, key=lambda shard: (-(wanted[shard.name] % 1.0 + shard.debt), shard.name))
        for shard in owed * 2:  # then the rest, to those that are owed most
            if left and shard.visible < speaking[shard.name]:
                shard.visible += 1
                left -= 1
        if not total and there:  # the first finger anywhere has its light at once
            for shard in there:
                shard.visible = max(self._visible // len(there), 1)

    # -- status ----------------------------------------------------------------------------------------------------

    def facts(self, now: float) -> dict[str, Any]:
        """Return facts for the status, without personal data; those of the slowest gateway where there is no sum."""
        there = [shard for _, shard in sorted(self.shards.items())]
        rows = [
            connected_row(
                shard.name, shard.where, shard.facts, phones=0 if shard.report is None else shard.report.phones,
                most=shard.capacity, silent=now - shard.heard_at, gone=shard.gone, lies=shard.lies,
            )
            for shard in there
        ]  # fmt: skip
        return {
            **merged_facts([shard.facts for shard in there if not shard.gone], self.refused),
            "bans": list(self._bans.values()), "next": self.next_number,
            "gateways": [*rows, *self.turned_away.rows(now)],
        }  # fmt: skip


def bounded(sketch: VoiceSketch, most: int, most_weight: float) -> tuple[VoiceSketch, bool]:
    """Return a sketch reduced to `most` voices (in `UNIT`) of at most `most_weight` each, and whether it was within."""
    total = sketch.total()
    people = min(sketch.people, most)
    limit = people * most_weight
    if sketch.people <= most * TOLERANCE and total <= limit * TOLERANCE + UNIT and sketch.shaken <= sketch.people:
        return sketch, True
    found = sketch
    if total > limit:
        sums = (found.sums * (limit / total)).astype(np.int64)
        found = replace(found, cells=found.cells[sums[0] > 0], sums=sums[:, sums[0] > 0])
    return replace(found, people=people, shaken=min(sketch.shaken, people)), False
