"""Standby on other machines: they follow the leader's lines over TLS, and one of them takes over when it dies.

`leadership` decides who leads, `peers` holds the links, and `peer_messages` defines the messages; this module connects
them to the engines of this machine. A show's lines are numbered within a *stream* (all lines of one leader), so that a
machine whose link broke resumes where it was.
"""

import os
import secrets
from collections.abc import Callable, Iterable
from typing import Any, Final

from live import __version__
from live.base.system.process_control import RESTART_CODE, on_promotion_signal
from live.supervisor.engine_failover import EngineFailover
from live.supervisor.heartbeat import Phase
from live.supervisor.network.follower_reports import FollowerReports, one_line, order_restart
from live.supervisor.network.leadership import Action, Drop, Follow, Lead, Leadership, Role, Send, StepDown
from live.supervisor.network.leadership import Claim as ClaimMessage
from live.supervisor.network.peer_messages import (
    CannotFollow,
    FollowerState,
    FollowRequest,
    Hello,
    InvalidMessage,
    PeerMessage,
    Restart,
    ShowKeys,
    SignedClaim,
    StreamStart,
    format_message,
    leadership_message,
    parse_message,
    read_line,
    signed_claim,
    verified,
)
from live.supervisor.network.peers import Link, Peers
from live.supervisor.network.show_stream import ShowStream, is_show_line
from live.supervisor.process import ROUND, ProcessManager
from live.supervisor.supervisor_config import Report, SupervisorConfig

DRAIN_TIMEOUT: Final = 2.0
"""Seconds for which a machine that cannot stand by waits at its end until the leader has read the reason."""
MAX_TURN: Final = 2.5 * ROUND
"""Longest turn that counts [s]: in a longer one this process did not run and could not listen."""
MAX_BEAT_AGE: Final = 1.0
"""Greatest age of its last heartbeat for an engine that follows to be ready [s]."""
MAX_SHOW_BYTES: Final = 64 * 1024 * 1024
"""Most bytes of lines since the last snapshot that are accepted from another machine."""
LINE_OVERHEAD_BYTES: Final = 200
"""Bytes of memory per line besides its text."""


DEPUTY_NOTE: Final = "this machine is the deputy: it leads if the leader falls silent"
"""Shown to the person: of several machines that stand by only one takes silence for death."""


class RemoteStandby:
    """Leader and standby side; without either it does nothing. Thread: the supervisor's."""

    def __init__(
        self,
        config: SupervisorConfig,
        starter: ProcessManager,
        engines: EngineFailover,
        report: Report,
        say: Callable[[str], None],
    ) -> None:
        self._starter, self._engines, self._report, self._say = starter, engines, report, say
        self._now = 0.0
        self._updated_at: float | None = None
        self._run_delay = run_delay()
        self._promote_requested = self._drain_on_close = False
        self._ready_engine: object = None  # the engine that reported itself ready
        self._last_run: float | None = None
        self._stream = ShowStream()
        self._leader_stream, self._leader_line, self._received_bytes = "", 0, 0
        self._source_link = ""  # the link whose lines are the show's
        self._keys, self._with_keys = dict(config.keys), config.with_keys
        self._reports = FollowerReports()
        self._peers: Peers | None = None
        who = "" if config.identity is None else config.identity.fingerprint[:16]
        role = Role.LEADS if config.follow is None else Role.FOLLOWS
        self._leadership = Leadership(f"{who}-{secrets.token_hex(4)}", role)
        if config.follow is not None:
            report.follows = "{}:{}".format(*config.follow)
            engines.role = "standby"
        if config.lead is None and config.follow is None:
            return
        assert config.identity is not None
        assert config.pairings is not None
        self._peers = Peers(
            starter, config.identity, config.pairings, listener=config.lead, upstream=config.follow, say=say
        )  # fmt: skip
        self._peers.on_link, self._peers.on_line, self._peers.on_end = (
            self._send_hello,
            self._receive,
            self._link_closed,
        )
        self._peers.on_refused = lambda: self._act(self._leadership.leader_gone(ready=self._is_ready()))
        on_promotion_signal(self._request_promotion)

    def update(self, now: float) -> None:
        """Update links and leadership, and act on the result."""
        if self._peers is None:
            return
        turn = min(now - (now if self._updated_at is None else self._updated_at), MAX_TURN)
        delay = run_delay()
        self._updated_at, self._now, self._run_delay, waited = now, now, delay, delay - self._run_delay
        self._peers.update(now)
        if self._engines.code is not None:
            return  # the show is over; only pending data is sent
        if self._promote_requested:
            self._promote_requested = False
            self.promote("on command")
        ready, lead = self._is_ready(), self._leadership
        self._act(lead.update(now, max(0.0, turn - waited), ready=ready, idle=self._idle(now)))
        if (leader := self._leader()) is not None and self._source_link:
            self._reports.tell(leader, self._engines.engine, self._report, now)
        report = self._report
        report.followers = sum(link.follows for link in self._peers.links.values())
        if ready and lead.is_deputy and not report.is_deputy:
            self._say(DEPUTY_NOTE)
        report.ready, report.is_deputy, report.epoch = ready and not lead.leads, lead.is_deputy, lead.term.epoch
        report.deputy = "" if lead.deputy is None else lead.deputy.rpartition(" #")[0]
        report.strangers, report.expired, report.claims_refused = (
            self._peers.strangers,
            self._peers.expired,
            lead.refused,
        )

    def promote(self, why: str) -> None:
        """Take over, if this machine stands by and has received a show."""
        if self._peers is None or self._leadership.leads:
            return
        if not self._engines.log.header:
            self._say("this machine cannot take over: it has not received a show yet")
            return
        self._act(self._leadership.promote(why))

    def set_ready(self, ready: bool) -> None:
        """Record whether the engine could resume the show now."""
        self._ready_engine = self._engines.engine if ready else None

    def broadcast(self, line: str) -> None:
        """Send a line of the show to all followers."""
        if self._peers is None or self._report.fenced:
            return
        self._stream.add(line)
        for link in self._peers.links.values():
            if link.follows:
                link.channel.send_line(line)

    def report_cannot_follow(self, why: str) -> None:
        """Report to the leader that this machine cannot stand by."""
        leader = self._leader()
        if leader is not None:
            leader.channel.send_line(format_message(CannotFollow(why)))
            self._drain_on_close = True

    def close(self) -> None:
        """Close all links."""
        if self._peers is not None:
            self._peers.close(DRAIN_TIMEOUT if self._drain_on_close else 0.0)

    def _request_promotion(self, _number: int, _frame: object) -> None:
        self._promote_requested = True

    # -- inputs of the decision ------------------------------------------------------------------------------------

    def _leader(self) -> Link | None:
        return None if self._peers is None else self._peers.links.get(self._leadership.leader or "")

    def _is_ready(self) -> bool:
        engine = self._engines.engine
        return (
            engine is not None and self._engines.code is None and self._ready_engine is engine
            and engine.phase is Phase.RUNNING and self._now - engine.heartbeat.last < MAX_BEAT_AGE
            and bool(self._engines.log.header)
        )  # fmt: skip

    def _idle(self, now: float) -> float | None:
        """Return the seconds since an engine last ran here; None before the first one."""
        engine = self._engines.engine
        if engine is not None and engine.phase is Phase.RUNNING and self._engines.running_since is not None:
            self._last_run = max(self._last_run or 0.0, engine.heartbeat.last)
        elif engine is not None and engine.phase is Phase.LEAVING and self._last_run is not None:
            self._last_run = now  # the show ends
        return None if self._last_run is None else max(0.0, now - self._last_run)

    # -- actions ---------------------------------------------------------------------------------------------------

    def _act(self, actions: Iterable[Action]) -> None:
        for action in actions:
            match action:
                case Send():
                    self._send(action)
                case Lead():
                    self._start_leading(action)
                case StepDown():
                    self._go_dark(action.why)
                case Follow():
                    self._request_show(action.link)
                case Drop():
                    assert self._peers is not None
                    if (link := self._peers.links.get(action.link)) is not None:
                        self._peers.drop(link)

    def _send(self, action: Send) -> None:
        assert self._peers is not None
        link = self._peers.links.get(action.link)
        if link is None or link.peer_challenge is None:
            return
        if isinstance(action.message, ClaimMessage):
            link.claims_sent += 1
            line = signed_claim(self._peers.identity, link.peer, link.peer_challenge, link.claims_sent, action.message)
            link.channel.send_line(line)
        else:
            link.channel.send_line(format_message(action.message))

    def _start_leading(self, action: Lead) -> None:
        report, why = self._report, action.why
        report.silent_s = round(action.silent, 3)
        report.follows, report.fenced, report.epoch = "", False, self._leadership.term.epoch
        self._engines.role, self._last_run, self._ready_engine = "heir", self._now, None
        self._say(f"this machine takes over {why} (epoch {report.epoch})")
        self._engines.promote_engine()

    def _go_dark(self, why: str) -> None:
        self._report.fenced = True
        self._last_run = None
        self._say(why)
        if self._engines.engine is not None:
            self._engines.engine.channel.send_json(alive="facts", facts=self._engines.facts())

    def _request_show(self, name: str) -> None:
        assert self._peers is not None
        link = self._peers.links.get(name)
        if link is None:
            return
        self._report.follows = link.peer.name
        link.follows = False
        link.channel.send_line(format_message(FollowRequest(self._leader_stream or "-", self._leader_line)))

    # -- received messages -----------------------------------------------------------------------------------------

    def _send_hello(self, link: Link) -> None:
        link.channel.send_line(format_message(Hello(__version__, self._leadership.name, link.challenge)))

    def _link_closed(self, link: Link) -> None:
        self._leadership.link_closed(link.name)

    def _receive(self, link: Link, line: str) -> None:
        told = read_line(line)
        if "alive" not in told:
            self._receive_show_line(link, told, line)
            return
        try:
            message = parse_message(told)
        except InvalidMessage:
            self._reject(link)
            return
        if isinstance(message, Hello):
            self._handle_hello(link, message)
        elif link.peer_challenge is None:
            self._reject(link)
        elif isinstance(message, SignedClaim):
            self._handle_claim(link, message)
        elif isinstance(message, FollowRequest):
            self._serve_show(link, message)
        elif isinstance(message, StreamStart):
            self._handle_stream_start(link, message)
        elif isinstance(message, CannotFollow):
            self._reports.note_cannot(link.peer.name, one_line(message.why), self._now)
            self._say(f"{link.peer.name} cannot stand by: {one_line(message.why)}")
            self._drop(link)
        elif (decided := leadership_message(message)) is not None:
            self._act(self._leadership.handle(link.name, decided, self._now))
        else:
            self._receive_standby_message(link, message)

    def _receive_standby_message(self, link: Link, message: PeerMessage) -> None:
        """Handle what a machine that stands by tells its leader, or is told by it."""
        if isinstance(message, FollowerState):
            link.state, link.state_tick = message, self._engines.log.tick
        elif link is not self._leader():
            self._report.lines_refused += 1  # of a former leader, or of one who claims to be one
        elif isinstance(message, ShowKeys):
            self._take_keys(link, message)
        elif isinstance(message, Restart):
            self._say(f"{link.peer.name} orders this machine, which stands by, to start again")
            self._engines.code = RESTART_CODE

    def _reject(self, link: Link) -> None:
        """Count an invalid message and drop its sender."""
        self._report.lines_refused += 1
        self._drop(link)

    def _drop(self, link: Link) -> None:
        assert self._peers is not None
        self._peers.drop(link)

    def _handle_hello(self, link: Link, hello: Hello) -> None:
        assert self._peers is not None
        if link.peer_challenge is not None or hello.sender == self._leadership.name:
            self._reject(link)
            return
        if hello.version != __version__:
            why = f"the other machine is of version {hello.version}, this one of {__version__}"
            if link.upstream and not self._leadership.leads:
                link.channel.send_line(format_message(CannotFollow(why)))
                self._drain_on_close = True
                self._say(f"{why}: it cannot be followed; install the same version on both")
                self._engines.code = 2
            else:
                self._reports.note_cannot(
                    link.peer.name, f"version {hello.version}, the leader {__version__}", self._now
                )
                self._drop(link)
            return
        for other in [other for other in self._peers.links.values() if other.peer_name == hello.sender]:
            self._drop(other)  # a broken link that this machine has not noticed yet
        link.peer_challenge, link.peer_name = hello.challenge, hello.sender
        self._act(self._leadership.link_opened(link.name, self._now, upstream=link.upstream))

    def _handle_claim(self, link: Link, signed: SignedClaim) -> None:
        assert self._peers is not None
        claim = verified(signed, link.peer, self._peers.identity, link.challenge, link.last_claim)
        if claim is None:
            self._leadership.refused += 1
            self._drop(link)
            return
        link.last_claim = signed.number
        self._act(self._leadership.handle(link.name, claim, self._now))

    # -- machines that stand by ------------------------------------------------------------------------------------

    def standbys(self) -> list[dict[str, Any]]:
        """Return state and lateness of each machine that stands by for this one."""
        if self._peers is None or not self._leadership.leads:
            return []
        return self._reports.rows(self._peers.links.values(), self._leadership, self._now)

    def restart_follower(self, name: str, process: str) -> None:
        """Order a machine that stands by to start again."""
        if self._peers is not None and self._leadership.leads:
            order_restart(self._peers.links.values(), name, process)

    def _take_keys(self, link: Link, told: ShowKeys) -> None:
        try:
            self._engines.show = self._with_keys(self._engines.show, dict(told.keys))
        except ValueError:
            self._reject(link)
            return
        self._keys = dict(told.keys)

    # -- the show --------------------------------------------------------------------------------------------------

    def _serve_show(self, link: Link, wanted: FollowRequest) -> None:
        """Let a machine follow: from where it was after a short break of its link, else from the last snapshot."""
        link.follows = True
        number, restart, lines = self._stream.resume(wanted.stream, wanted.number, self._engines.log)
        link.channel.send_line(format_message(ShowKeys(tuple(self._keys.items()))))
        link.channel.send_line(format_message(StreamStart(self._stream.name, number, restart)))
        for line in lines:
            link.channel.send_line(line)

    def _handle_stream_start(self, link: Link, told: StreamStart) -> None:
        if link is not self._leader():
            return
        if told.restart:
            self._restart_stream()
        elif (told.stream, told.number) != (self._leader_stream, self._leader_line):
            self._reject(link)
            return
        self._leader_stream, self._leader_line, self._source_link = told.stream, told.number, link.name

    def _restart_stream(self) -> None:
        """Follow another show from its first line; followers of this machine do so, too."""
        if self._engines.log.header or self._engines.role != "standby":
            self._engines.stand_by()
        report = self._report
        report.fenced, self._ready_engine, self._received_bytes = False, None, 0
        report.compared = report.different = report.repaired = 0
        self._stream.restart()
        assert self._peers is not None
        for link in self._peers.links.values():
            if link.follows:
                link.channel.send_line(format_message(StreamStart(self._stream.name, 0, True)))

    def _receive_show_line(self, link: Link, told: dict[str, Any], line: str) -> None:
        if link is not self._leader() or link.name != self._source_link:
            if not told:
                self._reject(link)
            return  # late lines of a former leader
        log = self._engines.log
        if not is_show_line(told, begun=bool(log.header), tick=log.tick):
            self._report.lines_refused += 1
            return
        self._received_bytes = (
            len(line) if "snapshot" in told else self._received_bytes + len(line) + LINE_OVERHEAD_BYTES
        )
        if self._received_bytes > MAX_SHOW_BYTES:
            self._say(f"{link.peer.name} sends more data than a show can have: it is not followed any more")
            self._reject(link)
            return
        self._leader_line += 1
        if "journal" in told and self._engines.log.header:
            return
        if told.get("end"):
            self._say("the leader has ended the show")
            self._engines.code = 0
            return
        self._engines.handle_line(line)
        if self._engines.engine is not None:
            self._engines.engine.channel.send_line(line)


def run_delay() -> float:
    """Return the seconds this process has waited for a processor; 0 if the kernel does not count them (schedstat of
    proc(5))."""
    try:
        with open(f"/proc/{os.getpid()}/schedstat", encoding="ascii") as file:
            return int(file.read().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0
