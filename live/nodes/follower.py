"""The node's side of the bus: follows a leader's show bit by bit, and says which tick is due at which moment.

A node never leads. It runs a tick only once the leader has run it, so that all events before it are known; the leader
runs ahead of its schedule for that. If nothing comes any more, the node goes on alone: without events the show is
deterministic. What it has drawn alone may differ from the leader's show. Then it takes a snapshot when the leader is
back, and draws on meanwhile.
"""

import enum
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from live import __version__
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.message_codec import PacketError
from live.nodes import messages
from live.nodes.coming_show import Aside, ComingShow, do_in_thread, feed
from live.nodes.leader_clock import Exchange, LeaderClock
from live.nodes.messages import ClockAsked, ClockTold, Join, Joined, Lines, NodeState, Order, Pulse, Refused
from live.nodes.signed_bus import SignedBus
from live.show.journal.replay import ReplayError
from live.show.loader import LoadedShow
from live.show.show import Show
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.network.leadership import MAX_EPOCHS_AHEAD
from live.supervisor.state_follower import StateFollower, cannot_run

FIRST_EXCHANGES: Final = 16
"""Exchanges of time stamps in quick succession, ..."""
QUICK, USUAL = 0.03, 0.25
"""... and seconds between those and all later ones."""
JOIN_AGAIN: Final = 0.5
"""Seconds after which the show is asked for again, ..."""
MISSED_AGAIN: Final = 0.1
"""... and lines that were lost, once no answer can come any more, ..."""
LONGEST_ANSWER: Final = 60.0
"""... or none has come in this time: it may have the whole show, and some networks are slow."""
ALONE_AFTER: Final = 0.5
"""Seconds by which the leader may be late before the node goes on alone. An engine that takes over needs 0.3 s."""
MUTE_AFTER: Final = 0.6
"""Seconds without a pulse after which another leader of the same show is followed, ..."""
ANY_AFTER: Final = 10.0
"""... and any leader."""
REPAIR_EVERY: Final = 2.0
"""Shortest time between two snapshots that are taken because the state differs [s]."""
STATE_EVERY: Final = 0.5
FRAME_WORK: Final = 0.012
"""Seconds of a frame in which ticks are run; what is left waits for the next frame."""
JOIN_WORK: Final = 0.006
"""The same for a show that is prepared behind the one that is drawn, ..."""
FIRST_WORK: Final = 0.048
"""... and before the first is drawn."""
FAR_BEHIND: Final = 2.0
"""A node that is farther behind [s] takes a snapshot instead of running all the ticks."""
ENDED: Final = "the leader has ended the show"
MOST_WAITING: Final = 4096
"""Messages that wait; beyond that the oldest are lost, and the show is asked for again."""


class Phase(enum.Enum):
    """What a node does; reported to the leader by its value."""

    SEARCHES = "searches"
    JOINS = "joins"
    FOLLOWS = "follows"
    ALONE = "alone"
    REFUSED = "refused"
    ENDED = "ended"


@dataclass(frozen=True, slots=True)
class NodeIdentity:
    """Who this node is."""

    name: str
    process: str
    kernels: str
    discipline: str = ""
    outputs: str = ""


@dataclass(frozen=True, slots=True)
class Presentation:
    """What is to be drawn now."""

    show: Show
    tick: int
    """The last tick run."""
    due: int
    """The tick that is due; a later one than `tick` if the leader or this node is late."""
    time: float
    """Time of the picture [s of the show]."""


@dataclass(slots=True)
class _Request:
    """A request for the show that waits for its answer."""

    anew: bool
    """From the last snapshot; otherwise the lines that were missed."""
    due: float = -math.inf
    """When it is sent; infinite while an answer may come."""


class NodeFollower:
    """Follows a leader. Thread: the one that draws; the bus's threads only put messages into queues."""

    def __init__(
        self, me: NodeIdentity, loaded: LoadedShow, bus: SignedBus, say: Callable[[str], None], *,
        heartbeat: Heartbeat | None = None, now: Callable[[], float] = time.perf_counter, aside: Aside = do_in_thread,
    ) -> None:  # fmt: skip
        """`say`: prints a line for the person; `now`: this machine's monotonic clock [s]; `aside`: does what a frame
        must not wait for."""
        self._me, self._loaded, self._bus, self._say, self._heartbeat, self._now = me, loaded, bus, say, heartbeat, now
        self._aside = aside
        self.clock, self._coming_clock = LeaderClock(), LeaderClock()
        self.phase = Phase.SEARCHES
        self.why = ""
        """What the operator has to know of this node."""
        self.restart_asked = False
        """Whether an operator wants this process to start again."""
        self.frames = self.late_frames = self.joins = self.refused = self.others = 0
        """Frames, those that showed an older tick than was due, snapshots taken, invalid messages, pulses of leaders
        that are not followed."""
        self._late_most = 0.0
        self._times: deque[tuple[str, float, bytes]] = deque(maxlen=64)
        self._answers: deque[bytes] = deque(maxlen=8)
        self._unanswered: deque[_Request] = deque(maxlen=64)
        self._published: deque[tuple[type, bytes]] = deque(maxlen=MOST_WAITING)
        self._pulse: Pulse | None = None
        self._origin = 0.0
        self._pulsed = self._clock_at = self._state_at = self._repair_at = -math.inf
        self._quick = 0
        self._shown: StateFollower | None = None
        self._coming: ComingShow | None = None
        self._request: _Request | None = None
        self._stream, self._number = "-", 0
        self._tick = self._due = 0
        self._said: set[str] = set()
        bus.receive(messages.LINES, lambda data: self._published.append((Lines, data)))
        bus.receive(messages.PULSE, lambda data: self._published.append((Pulse, data)))
        bus.receive(messages.ORDER, lambda data: self._published.append((Order, data)))

    @property
    def following(self) -> StateFollower | None:
        """The state that is drawn; None before the first."""
        return self._shown

    # -- the show ------------------------------------------------------------------------------------------------

    def present(self, lead: float) -> Presentation | None:
        """Run the ticks that are due for a picture that is seen `lead` [s] later; None before the show is there.

        PersonError if this machine cannot draw the show.
        """
        if not self.clock.ready or self.phase in (Phase.ENDED, Phase.REFUSED):
            return None
        start = self._now()
        time = self.clock.leader(start) + lead - self._origin
        due = self._due = math.floor(time / TICK)
        try:
            if self._coming is not None:
                self._prepare(self._coming, due, start)
            shown = self._shown
            if shown is None or shown.show is None:
                return None
            if self.phase is Phase.FOLLOWS and (due - shown.granted) * TICK > ALONE_AFTER:
                self._set_phase(Phase.ALONE, "the leader is silent")
            shown.run_until(due, start + FRAME_WORK, ahead=self.phase is Phase.ALONE, now=self._now)
        except ReplayError as error:
            raise cannot_run(error) from None
        assert shown.show is not None
        self._tick = shown.tick
        self.frames += 1
        if shown.tick < due:
            self.late_frames += 1
            self._late_most = max(self._late_most, time - shown.tick * TICK)
        seen = min(max(time, shown.tick * TICK), (shown.tick + 1) * TICK)
        return Presentation(shown.show, shown.tick, due, seen)

    def until_next_tick(self, lead: float) -> float:
        """Return the seconds until the next tick is due."""
        time = self.clock.leader(self._now()) + lead - self._origin
        return max((self._due + 1) * TICK - time, 0.0)

    def _prepare(self, coming: ComingShow, due: int, start: float) -> None:
        """Run the show that has been sent behind the one that is drawn, and change over once it is there."""
        if not coming.built:
            return
        work = FIRST_WORK if self._shown is None else JOIN_WORK
        done = coming.run_until(due, start + work, now=self._now)
        differs = not done and coming.following.differs
        if not (done or differs or coming.ended):
            return
        self._coming = None
        self.refused += coming.refused
        if coming.ended:
            self._set_phase(Phase.ENDED, ENDED)
        elif differs:
            self._stream, self._request = "-", _Request(anew=True, due=start + REPAIR_EVERY)
        else:
            self._shown = coming.following
            self._set_phase(Phase.FOLLOWS, "")

    def _set_phase(self, phase: Phase, why: str) -> None:
        if phase is not self.phase:
            self._say(f"this node {'is alone' if phase is Phase.ALONE else phase.value}{f': {why}' if why else ''}")
        self.phase, self.why = phase, why

    # -- messages ------------------------------------------------------------------------------------------------

    def update(self) -> None:
        """Read what has come, and send what is due. Called once a frame, before `present`.

        PersonError if the leader refuses this machine, or its show cannot be drawn here.
        """
        now = self._now()
        self._bus.refresh()
        while self._times:
            self._hear_time(*self._times.popleft())
        while self._answers:
            self._hear_answer(self._answers.popleft())
        while self._unanswered:
            ended = self._unanswered.popleft()
            ended.due = now + (JOIN_AGAIN if ended.anew else MISSED_AGAIN)
        while self._published:
            kind, data = self._published.popleft()
            try:
                told: object = messages.decode(data, kind)
            except PacketError:
                self.refused += 1
                continue
            if isinstance(told, Pulse):
                self._hear_pulse(told, now)
            elif isinstance(told, Lines):
                self._hear_lines(told)
            elif isinstance(told, Order) and told.name == self._me.name:
                self.restart_asked = True
        self._repair(now)
        self._ask(now)
        if now - self._state_at >= STATE_EVERY:
            self._state_at = now
            self._bus.publish(messages.STATE, messages.encode(self.state()))
            self._late_most = 0.0

    def state(self) -> NodeState:
        """Return the report to the leader."""
        clock, shown = self.clock, self._shown
        return NodeState(
            self._me.name, self._me.process, __version__, self.phase.value, self.why[:400], self._tick,
            round(1e3 * clock.offset(self._now()), 3), round(1e6 * clock.rate, 2), round(1e3 * clock.error, 3),
            round(1e3 * clock.round_trip, 3), self._me.discipline, self.frames, self.late_frames,
            round(1e3 * self._late_most, 2), self.joins, 0 if shown is None else shown.compared,
            0 if shown is None else shown.differences, self.refused, self._me.outputs,
        )  # fmt: skip

    def report_refused(self, why: str) -> None:
        """Tell the leader that this node cannot draw its show."""
        self._set_phase(Phase.REFUSED, why)
        self._bus.publish(messages.STATE, messages.encode(self.state()))

    def _ask(self, now: float) -> None:
        """Ask the leader for its time, and for the show."""
        pulse = self._pulse
        if pulse is None:
            return
        if now - self._clock_at >= (QUICK if self._quick > 0 else USUAL):
            self._clock_at, self._quick = now, self._quick - 1
            leader = pulse.leader
            self._bus.ask(
                messages.question_key(leader, messages.CLOCK), messages.encode(ClockAsked(self._now())),
                lambda data: self._times.append((leader, self._now(), data)), timeout=1.0, anyone=True,
            )  # fmt: skip
        request = self._request
        if request is not None and now >= request.due:
            request.due = math.inf
            stream, number = ("-", 0) if request.anew else (self._stream, self._number)
            asked = Join(self._me.name, self._me.process, __version__, self._me.kernels, stream, number)
            self._bus.ask(
                messages.question_key(pulse.leader, messages.JOIN), messages.encode(asked), self._answers.append,
                timeout=LONGEST_ANSWER, bulk=True, end=lambda: self._unanswered.append(request),
            )  # fmt: skip

    def _want(self, *, anew: bool) -> None:
        """Ask for the show, if that has not been done yet."""
        if self._request is None or (anew and not self._request.anew):
            self._request = _Request(anew)

    def _repair(self, now: float) -> None:
        """Ask for a snapshot if the state that is drawn differs, or this machine has fallen far behind."""
        if now - self._pulsed > MUTE_AFTER or now - self._repair_at < REPAIR_EVERY or self._coming is not None:
            return
        shown = self._shown
        behind = self.phase is Phase.FOLLOWS and (self._due - self._tick) * TICK > FAR_BEHIND
        if shown is None or shown.differs or behind:
            self._repair_at = now
            self._want(anew=True)

    def _hear_time(self, leader: str, arrived: float, data: bytes) -> None:
        try:
            told = messages.decode(data, ClockTold)
        except PacketError:
            self.refused += 1
            return
        if self._pulse is None or leader != self._pulse.leader:
            return
        clock = self._coming_clock
        clock.add(Exchange.of(told.sent, told.received, told.answered, arrived))
        if clock.ready:
            self.clock, self._origin = clock, self._pulse.origin

    def _hear_pulse(self, pulse: Pulse, now: float) -> None:
        held = self._pulse
        if held is None or pulse.leader != held.leader:
            if held is not None and not self._should_change(held, pulse, now):
                self.others += 1
                self._say_once(f"two leaders: {pulse.leader} (epoch {pulse.epoch}) is not followed, {held.leader} is")
                return
            self._say(f"follows {pulse.leader} (epoch {pulse.epoch})")
            self._coming_clock, self._quick, self._clock_at = LeaderClock(), FIRST_EXCHANGES, -math.inf
            if self._request is not None:
                self._request = _Request(self._request.anew)  # the one that was asked may be dead
        self._pulse, self._pulsed = pulse, now
        if self.clock is self._coming_clock:
            self._origin = pulse.origin
        if pulse.stream != self._stream:
            if self.phase in (Phase.SEARCHES, Phase.ENDED):
                self._shown = None
                self._set_phase(Phase.JOINS, "")
            self._want(anew=True)
        elif pulse.number > self._number:
            self._want(anew=False)

    def _should_change(self, held: Pulse, pulse: Pulse, now: float) -> bool:
        """Whether another leader than the one that is followed rules."""
        if 0 < pulse.epoch - held.epoch <= MAX_EPOCHS_AHEAD:
            return True
        silent = now - self._pulsed
        same = pulse.show == held.show and pulse.epoch >= held.epoch
        return silent > ANY_AFTER or (same and silent > MUTE_AFTER) or self.phase is Phase.ENDED

    def _hear_answer(self, data: bytes) -> None:
        try:
            told = messages.decode(data, Joined)
        except PacketError:
            self._hear_refusal(data)
            return
        if self._request is None:
            return  # the second answer, of a request that was sent twice
        if told.restart:
            self._coming = ComingShow(self._loaded, told.lines, heartbeat=self._heartbeat, aside=self._aside)
            self.joins += 1
            if self._shown is not None and self.phase is not Phase.ENDED:
                self._set_phase(Phase.ALONE, "the show is taken anew")
        elif told.stream != self._stream or told.number - len(told.lines) != self._number or not self._takes_lines:
            return  # of another moment: it is asked for again if need be
        self._request = None
        self._stream, self._number = told.stream, told.number
        if not told.restart:
            self._take(told.lines)

    def _hear_refusal(self, data: bytes) -> None:
        try:
            told = messages.decode(data, Refused)
        except PacketError:
            self.refused += 1
            return
        if told.final:
            raise PersonError(told.why[:400], told.remedy[:400])
        self.why = told.why[:400]
        self._say_once(f"{told.why[:400]} ({told.remedy[:400]})")

    def _hear_lines(self, told: Lines) -> None:
        skip = self._number + 1 - told.first
        if told.stream != self._stream or not self._takes_lines or skip >= len(told.lines):
            return
        if skip < 0:  # some were lost on the way
            self._want(anew=False)
            return
        self._number += len(told.lines) - skip
        self._take(told.lines[skip:])

    @property
    def _takes_lines(self) -> bool:
        """Whether there is a show for the lines that come."""
        return self._coming is not None or self._shown is not None

    def _take(self, lines: Sequence[str]) -> None:
        """Give lines to the show that comes, or to the one that is drawn."""
        coming, shown = self._coming, self._shown
        for line in lines:
            if coming is not None:
                coming.add_line(line)
            elif shown is not None:
                try:
                    if feed(shown, line):
                        self._set_phase(Phase.ENDED, ENDED)
                except PacketError:
                    self.refused += 1
        if self.phase is Phase.ALONE and coming is None and shown is not None:
            self._return(shown)

    def _return(self, shown: StateFollower) -> None:
        """Go on with the leader that is heard again, if nothing has happened meanwhile; else see `_repair`."""
        if (self._due - shown.granted) * TICK > ALONE_AFTER / 2:
            return
        shown.run_until(shown.tick, now=self._now)
        if not shown.differs:
            self._set_phase(Phase.FOLLOWS, "")

    def _say_once(self, words: str) -> None:
        if words not in self._said and len(self._said) < 64:
            self._said.add(words)
            self._say(words)
