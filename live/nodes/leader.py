"""The leader's side of the bus: it sends lines and schedule to its nodes, lets nodes in, and knows how all parts of the
show are.

It lives in the supervisor, which has all lines of the show and survives its engines. A machine that stands by holds the
same lines; it sends nothing until it leads.
"""

import hashlib
import json
import secrets
import socket
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from live import __version__
from live.control.message_codec import PacketError
from live.nodes import messages
from live.nodes.bus import Question
from live.nodes.messages import ClusterStatus, Join, Joined, Lines, Member, NodeState, Order, Pulse, Refused
from live.nodes.signed_bus import SignedBus
from live.supervisor.network.show_stream import ShowStream
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.supervisor_config import Report

PULSE: Final = 0.1
"""Seconds between two pulses."""
GONE_AFTER: Final = 5.0
"""Seconds of silence after which a node is told to have gone, ..."""
FORGET_AFTER: Final = 600.0
"""... and after which it is forgotten."""
NAME_FREE_AFTER: Final = 1.5
"""Seconds of silence after which another process may have a node's name."""
MAX_NODES: Final = 64
LONGEST_NAME: Final = 64
LONGEST_STATE: Final = 1 << 14
"""Longer reports of nodes [bytes] are refused."""
MOST_QUESTIONS: Final = 64
"""Questions that wait; further ones are dropped, and asked again."""


class NodeLeader:
    """Serves the nodes of one show. Thread: the supervisor's; clock questions are answered by the bus's threads."""

    def __init__(
        self, bus: SignedBus, say: Callable[[str], None], *, ahead: float, now: Callable[[], float] = time.perf_counter
    ) -> None:  # fmt: skip
        """`ahead` [s]: how far the engine runs ahead for its nodes; `say`: prints a line for the person."""
        self.name = f"{socket.gethostname()[:32]}-{secrets.token_hex(6)}"
        self._bus, self._say, self._ahead, self._now = bus, say, ahead, now
        self._stream = ShowStream()
        self._unsent: list[str] = []
        self._header = self._show = ""
        self._pulse_at = 0.0
        self._leads, self._epoch, self._tick = False, 0, 0
        self._questions: deque[tuple[str, Question]] = deque(maxlen=MOST_QUESTIONS)
        self._states: deque[tuple[float, bytes]] = deque(maxlen=16 * MAX_NODES)
        self._nodes: dict[str, tuple[float, NodeState]] = {}
        self._told: dict[str, str] = {}
        self.refused = 0
        """Messages that were invalid."""
        self.on_restart: Callable[[str, str, str], None] = lambda kind, name, process: None
        """Called with kind, name and process of a standby, gateway or reducer that an operator wants to start again."""
        bus.serve(messages.question_key(self.name, messages.CLOCK), self._tell_time, anyone=True)
        for what in (messages.JOIN, messages.STATUS, messages.COMMAND):
            bus.serve(messages.question_key(self.name, what), partial(self._queue, what))
        bus.receive(messages.STATE, self._take_state)

    # -- by threads of the bus -------------------------------------------------------------------------------------

    def _tell_time(self, asked: Question) -> None:
        try:
            question = messages.decode(asked.data, messages.ClockAsked)
        except PacketError:
            self.refused += 1
            return
        received = asked.arrived if self._now is time.perf_counter else self._now()
        asked.answer(messages.encode(messages.ClockTold(question.sent, received, self._now())))

    def _take_state(self, data: bytes) -> None:
        if len(data) > LONGEST_STATE:
            self.refused += 1
        else:
            self._states.append((self._now(), data))

    def _queue(self, what: str, asked: Question) -> None:
        self._questions.append((what, asked))

    # -- by the supervisor -----------------------------------------------------------------------------------------

    def add_line(self, line: str) -> None:
        """Take one line of the show. Snapshots are not sent on: a node that needs one asks."""
        if line.startswith('{"journal"'):
            self._stream.restart()
            self._unsent.clear()
        elif '"snapshot":' not in line[:64]:
            self._stream.add(line)
            self._unsent.append(line)

    def update(self, log: RecoveryLog, report: Report) -> None:
        """Send what has come, answer who asks, and look at the nodes."""
        now = self._now()
        self._bus.refresh()
        self._leads = not report.follows and not report.fenced and report.origin is not None and bool(log.header)
        self._epoch, self._tick = report.epoch, log.tick
        if log.header != self._header:
            self._header = log.header
            self._show = hashlib.sha256(log.header.encode()).hexdigest()[:16]
        if self._unsent and self._leads:
            first = self._stream.number - len(self._unsent) + 1
            lines = Lines(self._stream.name, first, tuple(self._unsent))
            self._bus.publish(messages.LINES, messages.encode(lines))
        self._unsent.clear()
        if self._leads and now >= self._pulse_at:
            self._pulse_at = now + PULSE
            assert report.origin is not None
            pulse = Pulse(
                self.name, report.epoch, self._show, self._stream.name, self._stream.number, report.origin, self._ahead
            )
            self._bus.publish(messages.PULSE, messages.encode(pulse))
        while self._states:
            self._hear(*self._states.popleft())
        while self._questions:
            what, asked = self._questions.popleft()
            if what == messages.STATUS:
                asked.answer(messages.encode(self._status(report, now)))
            elif what == messages.COMMAND:
                self._pass_on(asked)
            elif self._leads:
                self._answer_join(log, asked, now)
        self._look_at_nodes(now)
        report.nodes = self.facts(now)

    def facts(self, now: float) -> dict[str, Any]:
        """Return state and lateness of each node, by name, for the status."""
        return {
            name: {
                "state": one_line(told.state) if now - heard < GONE_AFTER else "gone", "why": one_line(told.why),
                "late": told.late, "late_ms": told.late_ms, "offset_ms": told.offset_ms, "different": told.different,
            }
            for name, (heard, told) in sorted(self._nodes.items())
        }  # fmt: skip

    def close(self) -> None:
        """Close the bus."""
        self._bus.close()

    # -- nodes -----------------------------------------------------------------------------------------------------

    def _hear(self, at: float, data: bytes) -> None:
        try:
            told = messages.decode(data, NodeState)
        except PacketError:
            self.refused += 1
            return
        if not is_name(told.name) or (told.name not in self._nodes and len(self._nodes) >= MAX_NODES):
            self.refused += 1
            return
        held = self._nodes.get(told.name)
        if held is not None and held[1].process != told.process and at - held[0] < NAME_FREE_AFTER:
            return  # it is refused when it joins
        self._nodes[told.name] = at, told

    def _look_at_nodes(self, now: float) -> None:
        """Tell the person what changes."""
        for name, (heard, told) in list(self._nodes.items()):
            state = told.state if now - heard < GONE_AFTER else "gone"
            if now - heard > FORGET_AFTER:
                del self._nodes[name]
                self._told.pop(name, None)
                continue
            if state not in ("follows", "alone", "gone", "refused") or self._told.get(name) == state:
                continue
            self._told[name] = state
            words = f": {one_line(told.why)}" if told.why else ""
            self._say(f"node {name}: {state}{words}")

    def _pass_on(self, asked: Question) -> None:
        """Send an operator's order on: an operator's bus reaches only the leader."""
        try:
            order = messages.decode(asked.data, Order)
        except PacketError:
            self.refused += 1
            return
        if order.kind == "node":
            self._bus.publish(messages.ORDER, messages.encode(order))
        else:
            self.on_restart(order.kind, order.name, order.process)
        asked.answer(messages.encode(order))

    def _status(self, report: Report, now: float) -> ClusterStatus:
        nodes = [self._nodes[name] for name in sorted(self._nodes)]
        members = [*map(standby_member, report.standbys), *filter(None, map(gateway_member, report.gateways))]
        return ClusterStatus(
            self.name, __version__, self._epoch, self._tick, self._leads,
            tuple(messages.encode(told) for _, told in nodes), tuple(round(now - heard, 3) for heard, _ in nodes),
            tuple(map(messages.encode, members)), self.refused, self._bus.strangers,
        )  # fmt: skip

    def _answer_join(self, log: RecoveryLog, asked: Question, now: float) -> None:
        try:
            wanted = messages.decode(asked.data, Join)
        except PacketError:
            self.refused += 1
            return
        refused = self._refusal(wanted, log, now)
        if refused is not None:
            asked.answer(messages.encode(refused))
            return
        _, restart, lines = self._stream.resume(wanted.stream, wanted.number, log)
        asked.answer(messages.encode(Joined(self._stream.name, self._stream.number, restart, tuple(lines))))

    def _refusal(self, wanted: Join, log: RecoveryLog, now: float) -> Refused | None:
        """Return why a node cannot join; None if it can."""
        if not is_name(wanted.name):
            return Refused("its name is not one", "a name of letters, digits, - and _", True)
        if wanted.version != __version__:
            why = f"node {wanted.name} has version {one_line(wanted.version)}, the leader {__version__}"
            return self._report_refusal(wanted.name, Refused(why, "install the same version on both", True))
        kernels = json.loads(log.header).get("kernels")
        if isinstance(kernels, str) and wanted.kernels != kernels:
            why = f"node {wanted.name} has the kernels {one_line(wanted.kernels)}, the leader {one_line(kernels)}"
            remedy = "start leader and nodes with LIVE_KERNEL_TARGET=x86-64-v2, and the same Python packages"
            return self._report_refusal(wanted.name, Refused(why, remedy, True))
        held = self._nodes.get(wanted.name)
        if held is not None and held[1].process != wanted.process and now - held[0] < NAME_FREE_AFTER:
            return Refused(f"another node is called {wanted.name}", "give each node a name of its own", False)
        return None

    def _report_refusal(self, name: str, refused: Refused) -> Refused:
        if self._told.get(name) != refused.why:
            self._told[name] = refused.why
            self._say(f"{refused.why}: it is refused ({refused.remedy})")
        return refused


def standby_member(row: dict[str, Any]) -> Member:
    """Return a machine that stands by (`RemoteStandby.standbys`) as it is told to operators. Its version is this one:
    another is refused."""
    refused = row["state"] == "refused"
    return Member(
        "standby", row["name"], row["process"], "" if refused else __version__, row["state"], row["why"], row["name"],
        late_ms=row.get("late_ms", 0.0), silent_ms=row["silent_ms"],
        load="" if refused else f"{row['different']} of {row['compared']} measures differed",
    )  # fmt: skip


def gateway_member(row: dict[str, Any]) -> Member | None:
    """Return a gateway or the reducer, as the engine reports it (`AudienceService.gateways`), as it is told to
    operators; None for what is none."""
    try:
        return Member(
            str(row["kind"]), str(row["name"]), str(row["process"]), str(row["version"]), str(row["state"]),
            str(row["why"]), str(row["machine"])[:64], float(row["clock_ms"]), float(row["late_ms"]),
            float(row["silent_ms"]), str(row["load"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError):
        return None


def is_name(name: str) -> bool:
    """Whether this can be a node's name, as in a venue's file."""
    return 0 < len(name) <= LONGEST_NAME and all(mark.isalnum() or mark in "-_" for mark in name) and name.isascii()


def one_line(words: str) -> str:
    """Return text of another machine as one short line."""
    return "".join(mark if mark.isprintable() else " " for mark in words[:200])
