"""A gateway that is one of several: it tells the reducer what its phones say, and hears from it about the show.

Its phones stay while the reducer is gone; it connects again until the show has ended.
"""

import asyncio
import contextlib
import secrets
import socket
import ssl
import sys
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, Final

from live import __version__
from live.control.audience.gateway import Gateway, prepare_process
from live.control.audience.phone_registry import MOST_NUMBER, NOWHERE, GroupElsewhere
from live.control.audience.session_state import SessionState
from live.control.audience.voice_report import VoiceReport
from live.control.helper_process import HelperChannel
from live.control.message_codec import PacketError, decode_packet, encode_packet
from live.control.shards.messages import (
    MAX_ROWS,
    PROTOCOL,
    ShardChanges,
    ShardHello,
    ShardNumbers,
    ShardOthers,
    ShardPing,
    ShardPlan,
    ShardRefused,
    ShardShown,
    SharedState,
    pack_voices,
)
from live.control.shards.packet_link import Link, LinkKeys, connect
from live.control.web.task_guard import keep_task, loop_factory

RETRY_INTERVAL: Final = 0.25
"""Pause between two attempts to reach the reducer [s]."""
REFUSED_INTERVAL: Final = 5.0
"""The pause after it refused this gateway."""
NUMBERS_LEFT: Final = 128
"""With fewer numbers for new phones it asks for more, ..."""
ASK_EVERY: Final = 0.25
"""... but not more often than that [s]."""
PINGS: Final = 24
"""Recent pings by which the show's time is estimated; the quickest quarter counts."""
CLOCK_STEP: Final = 0.0005
"""The show's time is corrected from this error on [s]."""


class ShardUplink:
    """The way of a gateway to the show by the reducer. Thread: the loop's."""

    def __init__(self, name: str, capacity: int) -> None:
        """`capacity`: most phones at a time."""
        self._name, self._capacity = f"{name} {secrets.token_hex(3)}"[:64], capacity
        self._link: Link | None = None
        self._session: SessionState | None = None
        self._handle: Callable[[Any], None] | None = None
        self._waiting: deque[Any] = deque(maxlen=64)
        self._answered = False
        self.plan: dict[str, Any] = {}
        """What the gateway needs to know of the show; empty before the first answer."""
        self.on_plan: Callable[[], None] = lambda: None
        """Called when the plan has changed: another show runs."""
        self.restart_asked = False
        """Whether the show wants this process to start again; ..."""
        self.on_restart: Callable[[], None] = lambda: None
        """... called then."""
        self.refusal = ""
        """Why the reducer refused this gateway the last time."""
        self._shown = ShardShown((), ())
        self._bans: list[Any] = []
        self._tally: tuple[int, ...] = ()
        self._pings: deque[tuple[float, float]] = deque(maxlen=PINGS)
        self._clock_error = self._asked_at = 0.0
        self._highest = 0

    @property
    def connected(self) -> bool:
        """Whether the reducer is there."""
        return self._link is not None

    def attach(self, link: Link) -> None:
        """Use a new connection."""
        self._link, self._answered = link, False
        link.on_packet, link.on_end = self.receive, self._detach
        self._pings.clear()
        link.publish(encode_packet(ShardHello(PROTOCOL, __version__, self._name, self._capacity, self._highest)))

    def _detach(self) -> None:
        self._link = None
        if not self._answered:
            self.refusal = self.refusal or "the machine there does not know this one: pair the two with live pair"

    # -- the gateway's side ------------------------------------------------------------------------------------------

    def use(self, session: SessionState) -> None:
        """Tell of the phones of this session from now on."""
        self._session = session
        session.phones.changed_groups = set()
        self._dispatch_waiting()

    def start(self, handle: Callable[[Any], None], end: Callable[[], None]) -> None:
        """Call `handle` with each packet of the show; who has made the gateway ends it."""
        self._handle = handle
        self._dispatch_waiting()

    def _dispatch_waiting(self) -> None:
        for _ in range(len(self._waiting)):
            self._dispatch(self._waiting.popleft())

    def publish(self, report: VoiceReport, now: float) -> tuple[int, ...]:
        """Tell what the phones say, and what has changed; return the tally of all gateways."""
        link, session = self._link, self._session
        if link is None or session is None:
            return self._tally
        link.publish(pack_voices(report), fleeting=True)
        shown = ShardShown(report.lights, report.votes)
        if shown != self._shown and link.publish(encode_packet(shown)):
            self._shown = shown
        changes = self._pop_changes(session)
        if changes is not None:
            link.publish(encode_packet(changes))
        if len(session.phones.numbers) < NUMBERS_LEFT and now - self._asked_at > ASK_EVERY:
            self._asked_at = now
            link.publish(encode_packet(("numbers",)))
        return self._tally

    @staticmethod
    def _pop_changes(session: SessionState) -> ShardChanges | None:
        """Return changed groups and numbers, `MAX_ROWS` of each at most; None if nothing has changed."""
        phones = session.phones
        groups, numbers = phones.changed_groups, phones.changed_numbers
        if not groups and not numbers:
            return None
        keys = [groups.pop() for _ in range(min(len(groups), MAX_ROWS))] if groups else []
        some = [(number, numbers.pop(number)) for number in list(numbers)[:MAX_ROWS]]
        rows = tuple((key, *phones.count(key), session.admission.crowded_until(key)) for key in keys)
        for key in keys:
            if not any(phones.count(key)):
                phones.elsewhere.pop(key, None)
        return ShardChanges(
            rows, tuple(number for number, here in some if here), tuple(number for number, here in some if not here)
        )

    def report_facts(self, facts: dict[str, Any], now: float) -> None:
        """Tell figures, bans and the clock, about twice a second."""
        link, session = self._link, self._session
        if link is None or session is None:
            return
        bans = facts.pop("bans")
        if bans and bans != self._bans and link.publish(encode_packet(("bans", bans))):
            self._bans = bans
        link.publish(encode_packet({**facts, "version": __version__, "clock_ms": round(1e3 * self._clock_error, 3)}))
        link.publish(encode_packet(ShardPing(time.perf_counter())))
        rested = [key for key, there in session.phones.elsewhere.items() if 0.0 < there.crowded_until < now]
        for key in rested:
            there = session.phones.elsewhere[key]
            session.phones.elsewhere[key] = GroupElsewhere(there.phones, there.joined)
        session.update_shares(*rested)

    # -- the reducer's side ------------------------------------------------------------------------------------------

    def receive(self, data: bytes) -> None:
        """Handle a packet of the reducer."""
        try:
            packet = decode_packet(data)
        except PacketError:
            return
        self._dispatch(packet)

    def _dispatch(self, packet: Any) -> None:
        session = self._session
        match packet:
            case ShardPlan():
                self._take_plan(packet)
            case ShardRefused():
                self.refusal = packet.why
                if self._link is not None:
                    self._link.close()
            case ("restart",):
                self.restart_asked = True
                self.on_restart()
            case ShardPing():
                self._correct_clock(packet, time.perf_counter())
            case _ if session is None:
                self._waiting.append(packet)  # until the gateway has been made
            case ShardOthers():
                self._take_others(packet, session)
            case SharedState():
                session.phones.total_elsewhere = packet.elsewhere
                session.reporter.highlights.most = packet.visible
                self._tally = packet.tally
            case ShardNumbers():
                session.phones.numbers.add(packet.first, packet.end)
                self._highest = max(self._highest, packet.end)
            case ("bans", rows):
                self._take_bans(rows, session)
            case _ if self._handle is None:
                self._waiting.append(packet)
            case _:
                self._handle(packet)

    def _take_plan(self, packet: ShardPlan) -> None:
        """Take the plan of the show; after a break tell everything again."""
        plan = asdict(packet)
        shown = plan.pop("time")
        plan["joins_per_code"] = packet.joins_per_code or None
        same = {key: value for key, value in self.plan.items() if key in plan} == plan
        self.refusal, self._answered = "", True
        if not same or self._session is None:
            self.plan = plan | {"origin": time.perf_counter() - shown, "first": MOST_NUMBER, "visible": 0, "bans": ()}
            self._session = self._handle = None
            self._waiting.clear()
            self._shown, self._bans, self._tally = ShardShown((), ()), [], ()
            self.on_plan()
            return
        phones = self._session.phones
        known = {group for one in phones.by_number.values() for group in (one.group, one.origin)}
        phones.changed_groups = known
        phones.changed_numbers = dict.fromkeys(phones.by_number, True)
        groups = list(phones.elsewhere)
        phones.elsewhere.clear()
        self._session.update_shares(*groups)
        self._shown, self._bans = ShardShown((), ()), []

    def _take_others(self, packet: ShardOthers, session: SessionState) -> None:
        for key, phones, joined, until in packet.groups:
            there = GroupElsewhere(phones, joined, until)
            if there != NOWHERE and any(session.phones.count(key)):
                session.phones.elsewhere[key] = there
            else:
                session.phones.elsewhere.pop(key, None)
        session.update_shares(*(row[0] for row in packet.groups))
        for number in packet.gone:
            session.give_up(number)

    def _take_bans(self, rows: Any, session: SessionState) -> None:
        with contextlib.suppress(ValueError, TypeError):
            session.merge_bans(rows)

    def _correct_clock(self, packet: ShardPing, received: float) -> None:
        """Estimate the show's time as phones do: of the quickest answers the median."""
        trip = received - packet.sent
        if self._session is None or not 0.0 <= trip < 10.0:
            return
        self._pings.append((trip, packet.show + 0.5 * trip - received))
        quick = sorted(self._pings)[: max(len(self._pings) // 4, 1)]
        wanted = sorted(offset for _, offset in quick)[len(quick) // 2]
        self._clock_error = wanted - (self._session.now() - time.perf_counter())
        if abs(self._clock_error) > CLOCK_STEP:
            self._session.shift_clock(self._clock_error)


async def run_shard(
    uplink: ShardUplink, where: tuple[str, int], keys: LinkKeys, listening: socket.socket, ended: asyncio.Event,
    certificate: tuple[bytes, bytes] | None, say: Callable[[str], None],
) -> None:  # fmt: skip
    """Serve phones at a listening socket until `ended`, for the show whose reducer is at `where`.

    `say` is called with what a person should know. On an operator's order it ends, too (`uplink.restart_asked`).
    """
    changed = asyncio.Event()
    uplink.on_plan, uplink.on_restart = changed.set, ended.set
    calling = keep_task("the way to the show", lambda: _keep_connected(uplink, where, keys, say))
    ending = asyncio.ensure_future(ended.wait())
    try:
        while not ended.is_set():
            waiting = asyncio.ensure_future(changed.wait())
            await asyncio.wait((ending, waiting), return_when=asyncio.FIRST_COMPLETED)
            waiting.cancel()
            changed.clear()
            if ended.is_set():
                return
            gateway = Gateway(uplink, uplink.plan | {"certificate": certificate})
            uplink.use(gateway.session)
            serving = asyncio.ensure_future(gateway.run(listening.dup()))
            again = asyncio.ensure_future(changed.wait())
            await asyncio.wait((ending, again, serving), return_when=asyncio.FIRST_COMPLETED)
            again.cancel()
            gateway.end()
            await serving
    finally:
        calling.cancel()
        ending.cancel()


async def _keep_connected(
    uplink: ShardUplink, where: tuple[str, int], keys: LinkKeys, say: Callable[[str], None]
) -> None:
    """Connect to the reducer, and again whenever the connection has ended, forever."""
    told = ""
    while True:
        why = ""
        if not uplink.connected:
            try:
                link = await connect(where, keys)
            except ssl.SSLCertVerificationError:
                why = f"the machine at {where[0]} is not paired with this one: live pair {where[0]}"
            except (OSError, TimeoutError) as error:
                why = f"no show with gateways at {where[0]}:{where[1]}: {error}"
            else:
                uplink.attach(link)
        if uplink.refusal:
            why = uplink.refusal
        if why and why != told:
            say(why)
        told = why if why else told if not uplink.connected else ""
        await asyncio.sleep(REFUSED_INTERVAL if uplink.refusal else RETRY_INTERVAL)


async def _run_local(told: HelperChannel) -> None:
    """Serve as one of the gateways that a show has started on its own machine, until the show ends."""
    plan, ended = told.plan, asyncio.Event()
    loop = asyncio.get_running_loop()

    def receive() -> None:
        for _ in told.packets():
            pass
        if told.closed:
            loop.remove_reader(told.socket)
            ended.set()

    loop.add_reader(told.socket, receive)
    host, port = plan["reducer"]
    await run_shard(
        ShardUplink(str(plan["name"]), int(plan["most"])), (str(host), int(port)),
        LinkKeys(bytes(plan["identity"]), tuple(plan["peers"])), told.listening_socket(), ended, plan["certificate"],
        lambda words: print(f"note: a gateway for phones: {words}", file=sys.stderr),
    )  # fmt: skip


def main() -> None:
    """Serve until the show ends."""
    told = HelperChannel(sys.argv[1])
    prepare_process(int(told.plan["most"]))
    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        runner.run(_run_local(told))


if __name__ == "__main__":
    main()
