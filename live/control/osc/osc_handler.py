"""Dispatcher for the messages of one OSC port: each becomes an event for the show, an answer or a counted refusal.

It has no socket and can be tested without one; `osc_server` reads the datagrams and sends the answers.
"""

import time as _time
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from live.base.event_queue import PriorityQueue
from live.control.events.events import ControlEvent
from live.control.events.system import Get, Ping, Subscribe, Unsubscribe
from live.control.osc.osc_codec import IMMEDIATELY, Message, OscRejected, Value, bundles, decode, encode
from live.control.osc.osc_pattern import WILDCARDS, BadPattern, Matcher
from live.control.osc.osc_scheduler import TimedQueue
from live.control.osc.osc_subscriptions import SocketAddress, Subscribers, is_local_network
from live.control.registry.control import ROLE_RANKS, Control, Query, Role
from live.control.registry.registry import READABLE, REGISTRY, Registry, Values
from live.control.registry.rejections import Reason, Rejection, Tally

SOURCE: Final = "osc"
MUSICIANS_SOURCE: Final = "osc musician"
PATTERNS_PER_SECOND: Final = 20
"""New patterns that are looked up; recent ones are cached and not counted."""
MAX_LANES: Final = 32
MAX_LANES_PER_HOST: Final = 8
"""Maximum number of lanes for one host, over all its source ports."""
LANE_TIMEOUT: Final = 10.0
"""Seconds for which a silent sender keeps its lane."""
MAX_ANSWERS: Final = 64
"""Maximum number of values in the answer to one query."""
PONG: Final = "/dance/pong"
_NTP_SECONDS_AT_1970: Final = 2_208_988_800


class OscHandler:
    """Handler for the messages of one port. Use from one thread; counters and `values` may be used from any thread."""

    def __init__(
        self, shared_lane: PriorityQueue[ControlEvent], *, registry: Registry = REGISTRY, role: Role = "operator",
        wall_clock: Callable[[], float] = _time.time,
        make_lane: Callable[[], PriorityQueue[ControlEvent]] | None = None,
    ) -> None:  # fmt: skip
        """`role`: the permissions at this port; `wall_clock` [s since 1970]: the clock of time tags; `make_lane`: makes
        a lane for each sender (without it all share `shared_lane`)."""
        self._make_lane, self._lanes = make_lane, dict[SocketAddress, PriorityQueue[ControlEvent]]()
        self._last_message: dict[SocketAddress, float] = {}
        self._shared_lane, self._registry, self._role, self._wall_clock = shared_lane, registry, role, wall_clock
        self._source = SOURCE if role == "operator" else MUSICIANS_SOURCE
        self._matcher = Matcher(READABLE)
        self._tokens, self._tokens_at = float(PATTERNS_PER_SECOND), 0.0
        self._for_all: dict[str, bool] = {}
        self.values = Values()
        """The current values, as published by the show."""
        self.subscribers = Subscribers(self.values)
        self.schedule: TimedQueue[tuple[Message, SocketAddress]] = TimedQueue()
        self.accepted = 0
        """Number of messages that became an event, an answer or a request."""
        self.rejected = Tally()
        """Refused packets and messages by reason."""
        self.future_timetags = 0
        """Number of messages with a time tag too far ahead, which acted at once."""
        self.delayed = 0
        """Number of messages that were held until their time tag."""
        self.last_rejection: Rejection | None = None
        """The most recent refusal, for the operator's overlay."""

    @property
    def replaced(self) -> int:
        """Number of values that later ones replaced before the show read them."""
        return self._shared_lane.replaced + sum(lane.replaced for lane in list(self._lanes.values()))

    def handle(self, packet: memoryview, sender: SocketAddress, time: float) -> Iterator[bytes]:
        """Handle a datagram received at `time` [s of the show]; yield the answers to its sender."""
        try:
            messages = decode(packet)
        except OscRejected as rejected:
            self.reject(Rejection(rejected.reason, "", "an OSC packet", bytes(packet[:16])))
            return
        answers: list[bytes] = []
        wall = self._wall_clock()  # read once, so that a bundle keeps its order
        for message in messages:
            if message.timetag != IMMEDIATELY and (ahead := _seconds_ahead(message.timetag, wall)) > 0.0:
                if self.schedule.put(time + ahead, time, (message, sender)):
                    continue
                self.future_timetags += 1
            self._handle_message(message.address, message.arguments, sender, time, answers)
        yield from self._limit_answers(answers, len(packet), sender)

    def _limit_answers(self, answers: list[bytes], received: int, sender: SocketAddress) -> Iterator[bytes]:
        """Yield the answers in datagrams; a distant sender gets one at most, no longer than its own datagram."""
        if not answers:
            return
        if is_local_network(sender[0]):
            yield from bundles(answers)
        elif len(answers[0]) <= received:
            yield answers[0]

    def handle_due(self, time: float) -> None:
        """Handle the delayed messages that are due by `time`; their answers are dropped."""
        for due, (message, sender) in self.schedule.pop_due(time):
            self.delayed += 1
            self._handle_message(message.address, message.arguments, sender, due, [])

    def _handle_message(
        self, address: str, values: Sequence[Value], sender: SocketAddress, time: float, answers: list[bytes]
    ) -> None:
        if WILDCARDS.isdisjoint(address):
            rejection = self._call(address, values, sender, time, answers)
            if rejection is not None:
                self.reject(rejection)
            return
        found = self._find(address, time)
        if isinstance(found, Rejection):
            self.reject(found)
            return
        if _is_empty(values):
            self._answer(found, answers)
            return
        refused = [self._call(each, values, sender, time, answers) for each in found]
        if found and all(refused):  # a pattern counts as refused only if no address accepts the values
            assert refused[0] is not None
            self.reject(refused[0])

    def _find(self, pattern: str, time: float) -> tuple[str, ...] | Rejection:
        """Return the readable addresses that match a pattern; one-time commands such as panic need their full name."""
        if not self._matcher.is_cached(pattern):
            grown = self._tokens + max(time - self._tokens_at, 0.0) * PATTERNS_PER_SECOND
            self._tokens, self._tokens_at = min(grown, PATTERNS_PER_SECOND), time
            if self._tokens < 1.0:
                return Rejection(Reason.WILDCARD, pattern, f"at most {PATTERNS_PER_SECOND} new patterns a second", "")
            self._tokens -= 1.0
        try:
            found = self._matcher.find(pattern)
        except BadPattern:
            return Rejection(Reason.WILDCARD, pattern, "a pattern as in OSC 1.0", pattern)
        return found or Rejection(Reason.UNKNOWN_ADDRESS, pattern)

    def _call(
        self, address: str, values: Sequence[Value], sender: SocketAddress, time: float, answers: list[bytes]
    ) -> Rejection | None:
        control, names = self._registry.resolve(address)
        if _is_empty(values) and (address in READABLE if control is None else control.is_query(address)):
            return self._answer((address,), answers)
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        if ROLE_RANKS[control.role] > ROLE_RANKS[self._role]:
            return Rejection(Reason.ROLE, address, f"an {control.role}", self._role)
        all_values = [*names, *values]
        result = control.call(all_values, time, self._source)
        match result:
            case Rejection():
                return result
            case Query():
                return self._serve(result, sender, time, answers)
            case ControlEvent():
                self._put(result, control, all_values, sender)
                if self.subscribers.by_address:
                    named = control.named and names
                    stored_at, stored = (control.address, all_values) if named else (address, values)
                    self.subscribers.record_setter(sender, stored_at, tuple(stored), time)
        self.accepted += 1
        return None

    def _lane(self, sender: SocketAddress, time: float) -> PriorityQueue[ControlEvent]:
        """Return the sender's lane, or the shared lane if there is none left."""
        lane = self._lanes.get(sender)
        if lane is None:
            if self._make_lane is None:
                return self._shared_lane
            host = [other for other in self._lanes if other[0] == sender[0]]
            if len(host) < MAX_LANES_PER_HOST and len(self._lanes) < MAX_LANES:
                lane = self._make_lane()
            else:
                among = host if len(host) >= MAX_LANES_PER_HOST else self._lanes
                oldest = min(among, key=self._last_message.__getitem__)
                if time - self._last_message[oldest] < LANE_TIMEOUT or len(self._lanes[oldest]):
                    return self._shared_lane
                lane = self._lanes.pop(oldest)
                del self._last_message[oldest]
            self._lanes[sender] = lane
        self._last_message[sender] = time
        return lane

    def _put(self, event: ControlEvent, control: Control, values: Sequence[object], sender: SocketAddress) -> None:
        """Queue an event; a value replaces an unread earlier value of the same control."""
        lane = self._lane(sender, event.time)
        if control.kind == "event":
            lane.put(event)
            return
        whom = control.addressees(values)
        whole = control.named or not whom or whom[-1].strip() in ("", "*")
        flipped = self._for_all.get(control.address, whole) != whole  # keeps the order of all, then one, then all again
        self._for_all[control.address] = whole
        lane.put(event, (control.address, *whom), ordered=flipped)

    def _serve(self, query: Query, sender: SocketAddress, time: float, answers: list[bytes]) -> Rejection | None:
        match query:
            case Ping():
                if encode(PONG) not in answers:
                    answers.append(encode(PONG))
            case Get():
                exact = WILDCARDS.isdisjoint(query.address)
                found = (query.address,) if exact else self._find(query.address, time)
                return found if isinstance(found, Rejection) else self._answer(found, answers)
            case Unsubscribe():
                self.subscribers.remove(_receiver(sender, query.port))
            case Subscribe():
                where = _receiver(sender, query.port)
                if not is_local_network(sender[0]):
                    return Rejection(Reason.SENDER, query.address, "a sender in a local network", sender[0])
                if not self.subscribers.add(where, sender, query.address, query.seconds, time):
                    return Rejection(Reason.SUBSCRIBERS, query.address)
        self.accepted += 1
        return None

    def _answer(self, addresses: Sequence[str], answers: list[bytes]) -> Rejection | None:
        """Append the current values of these addresses; reply `no_value` if none of them has a value."""
        known = [address for address in addresses if address in self.values]
        for address in known[:MAX_ANSWERS]:
            answers += [encode(where, values) for where, values in self.values.messages(address)]
        if not known:
            address = addresses[0]
            if address not in READABLE and self._registry.resolve(address)[0] is None:
                return Rejection(Reason.UNKNOWN_ADDRESS, address)
            answers.append(encode("/dance/no_value", (address,)))
        self.accepted += 1
        return None

    def reject(self, rejection: Rejection) -> None:
        """Count a refusal and keep it as the last one."""
        self.rejected.count(rejection.reason)
        self.last_rejection = rejection


def _receiver(sender: SocketAddress, port: int) -> SocketAddress:
    """Return where a sender receives; port 0: the port it sends from."""
    return (sender[0], port or sender[1], *sender[2:])


def _seconds_ahead(timetag: int, wall: float) -> float:
    """Return how far ahead an NTP time tag lies [s], 0 if in the past; correct across the NTP era's end in 2036."""
    now = int((wall + _NTP_SECONDS_AT_1970) * 2.0**32)
    ahead = (timetag - now) % 2**64
    return ahead / 2.0**32 if ahead < 2**63 else 0.0


def _is_empty(values: Sequence[Value]) -> bool:
    return all(value is None for value in values)
