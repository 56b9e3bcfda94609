"""Standby on other machines: they follow the leader's lines over TLS, and one of them takes over when it dies.

`leadership` decides who leads, `peers` holds the links, and `peer_messages` defines the messages; this module connects
them to the engines of this machine. A show's lines are numbered within a *stream* (all lines of one leader), so that a
machine whose link broke resumes where it was.
"""

import os
import secrets
import signal
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Final

from live import __version__
from live.show.journal.skipped_events import LEFT_OUT, MOST
from live.supervisor.engine_failover import Engines
from live.supervisor.heartbeat import Phase
from live.supervisor.network.leadership import Action, Dark, Drop, Follow, Lead, Leadership, Role, Send
from live.supervisor.network.leadership import Claim as ClaimMessage
from live.supervisor.network.peer_messages import (
    Cannot,
    GiveShow,
    Hello,
    Senseless,
    ShowComes,
    SignedClaim,
    line_of,
    message_of,
    read_line,
    said,
    signed_claim,
    verified,
)
from live.supervisor.network.peers import Link, Peers
from live.supervisor.process import ROUND, Starter
from live.supervisor.supervisor_config import Orders, Report

LONGEST_WHY: Final = 400
"""Most characters of a reason from another machine."""
PARTING: Final = 2.0
"""Seconds for which a machine that cannot stand by waits at its end until the leader has read the reason."""
TURN: Final = 2.5 * ROUND
"""Longest turn that counts [s]: in a longer one this process did not run and could not listen."""
BEATS_WITHIN: Final = 1.0
"""Greatest age of its last heartbeat for an engine that follows to be ready [s]."""
RECENT: Final = 8 * 1024 * 1024
"""Most bytes of recent lines that are kept for machines that reconnect, ..."""
RECENT_LINES: Final = 8192
"""... and most lines: about a minute."""
MOST_TICKS: Final = 64 * 600
"""Lines farther ahead of all before are refused: ten minutes."""
LATEST_TICK: Final = 64 * 86400 * 30
MOST_OF_SHOW: Final = 64 * 1024 * 1024
"""Most bytes of lines since the last snapshot that are accepted from another machine."""
LINE_COSTS: Final = 200
"""Bytes of memory per line besides its text."""


class Remote:
    """Leader and standby side; without either it does nothing. Thread: the supervisor's."""

    def __init__(
        self, orders: Orders, starter: Starter, engines: Engines, report: Report, say: Callable[[str], None]
    ) -> None:
        self._starter, self._engines, self._report, self._say = starter, engines, report, say
        self._now = self._turn = 0.0
        self._before: float | None = None
        self._delayed = run_delay()
        self._commanded = self._parting = False
        self._ready: object = None  # the engine that reported itself ready
        self._danced: float | None = None
        self._stream, self._number = secrets.token_hex(8), 0
        self._recent: deque[str] = deque()
        self._recent_bytes = 0
        self._theirs, self._their_number, self._taken = "", 0, 0
        self._from = ""  # the link whose lines are the show's
        self._peers: Peers | None = None
        who = "" if orders.identity is None else orders.identity.fingerprint[:16]
        role = Role.LEADS if orders.follow is None else Role.FOLLOWS
        self._lead = Leadership(f"{who}-{secrets.token_hex(4)}", role)
        if orders.follow is not None:
            report.follows = "{}:{}".format(*orders.follow)
            engines.role = "standby"
        if orders.lead is None and orders.follow is None:
            return
        assert orders.identity is not None
        assert orders.pairings is not None
        self._peers = Peers(
            starter, orders.identity, orders.pairings, door=orders.lead, upstream=orders.follow, say=say
        )  # fmt: skip
        self._peers.on_link, self._peers.on_line, self._peers.on_end = self._greet, self._hear, self._ended
        self._peers.on_nobody = lambda: self._act(self._lead.gone(ready=self._is_ready()))
        signal.signal(signal.SIGUSR1, self._command)

    def look(self, now: float) -> None:
        """Update links and leadership, and act on the result."""
        if self._peers is None:
            return
        turn = min(now - (now if self._before is None else self._before), TURN)
        delay = run_delay()
        self._before, self._now, self._delayed, waited = now, now, delay, delay - self._delayed
        self._peers.look(now)
        if self._engines.code is not None:
            return  # the show is over; only pending data is sent
        if self._commanded:
            self._commanded = False
            self.take_over("on command")
        ready, lead = self._is_ready(), self._lead
        self._act(lead.look(now, max(0.0, turn - waited), ready=ready, idle=self._idle(now)))
        report = self._report
        report.followers = sum(link.takes_show for link in self._peers.links.values())
        report.ready, report.is_deputy, report.epoch = ready and not lead.leads, lead.is_deputy, lead.term.epoch
        report.deputy = "" if lead.deputy is None else lead.deputy.rpartition(" #")[0]
        report.strangers, report.expired, report.claims_refused = (
            self._peers.strangers,
            self._peers.expired,
            lead.refused,
        )

    def take_over(self, why: str) -> None:
        """Take over, if this machine stands by and has received a show."""
        if self._peers is None or self._lead.leads:
            return
        if not self._engines.log.header:
            self._say("this machine cannot take over: it has not received a show yet")
            return
        self._act(self._lead.take_over(why))

    def told_following(self, ready: bool) -> None:
        """Record whether the engine could resume the show now."""
        self._ready = self._engines.engine if ready else None

    def pass_on(self, line: str) -> None:
        """Send a line of the show to all followers."""
        if self._peers is None or self._report.fenced:
            return
        self._number += 1
        self._recent.append(line)
        self._recent_bytes += len(line)
        while self._recent_bytes > RECENT or len(self._recent) > RECENT_LINES:
            self._recent_bytes -= len(self._recent.popleft())
        for link in self._peers.links.values():
            if link.takes_show:
                link.wire.put(line)

    def cannot(self, why: str) -> None:
        """Report to the leader that this machine cannot stand by."""
        leader = self._leader()
        if leader is not None:
            leader.wire.put(line_of(Cannot(why)))
            self._parting = True

    def close(self) -> None:
        """Close all links."""
        if self._peers is not None:
            self._peers.close(PARTING if self._parting else 0.0)

    def _command(self, _number: int, _frame: object) -> None:
        self._commanded = True

    # -- inputs of the decision ------------------------------------------------------------------------------------

    def _leader(self) -> Link | None:
        return None if self._peers is None else self._peers.links.get(self._lead.leader or "")

    def _is_ready(self) -> bool:
        engine = self._engines.engine
        return (
            engine is not None and self._engines.code is None and self._ready is engine
            and engine.phase is Phase.RUNNING and self._now - engine.heart.last < BEATS_WITHIN
            and bool(self._engines.log.header)
        )  # fmt: skip

    def _idle(self, now: float) -> float | None:
        """Return the seconds since an engine last ran here; None before the first one."""
        engine = self._engines.engine
        if engine is not None and engine.phase is Phase.RUNNING and self._engines.since is not None:
            self._danced = max(self._danced or 0.0, engine.heart.last)
        elif engine is not None and engine.phase is Phase.LEAVING and self._danced is not None:
            self._danced = now  # the show ends
        return None if self._danced is None else max(0.0, now - self._danced)

    # -- actions ---------------------------------------------------------------------------------------------------

    def _act(self, actions: Iterable[Action]) -> None:
        for action in actions:
            match action:
                case Send():
                    self._send(action)
                case Lead():
                    self._begin_to_lead(action)
                case Dark():
                    self._go_dark(action.why)
                case Follow():
                    self._ask_for_show(action.link)
                case Drop():
                    assert self._peers is not None
                    if (link := self._peers.links.get(action.link)) is not None:
                        self._peers.drop(link)

    def _send(self, action: Send) -> None:
        assert self._peers is not None
        link = self._peers.links.get(action.link)
        if link is None or link.theirs is None:
            return
        if isinstance(action.message, ClaimMessage):
            link.number += 1
            line = signed_claim(self._peers.identity, link.peer, link.theirs, link.number, action.message)
            link.wire.put(line)
        else:
            link.wire.put(line_of(action.message))

    def _begin_to_lead(self, action: Lead) -> None:
        report, why = self._report, action.why
        report.silent_s = round(action.silent, 3)
        report.follows, report.fenced, report.epoch = "", False, self._lead.term.epoch
        self._engines.role, self._danced, self._ready = "heir", self._now, None
        self._say(f"this machine takes over {why} (epoch {report.epoch})")
        self._engines.go()

    def _go_dark(self, why: str) -> None:
        self._report.fenced = True
        self._danced = None
        self._say(why)
        if self._engines.engine is not None:
            self._engines.engine.wire.tell(alive="facts", facts=self._engines.facts())

    def _ask_for_show(self, name: str) -> None:
        assert self._peers is not None
        link = self._peers.links.get(name)
        if link is None:
            return
        self._report.follows = link.peer.name
        link.takes_show = False
        link.wire.put(line_of(GiveShow(self._theirs or "-", self._their_number)))

    # -- received messages -----------------------------------------------------------------------------------------

    def _greet(self, link: Link) -> None:
        link.wire.put(line_of(Hello(__version__, self._lead.me, link.challenge)))

    def _ended(self, link: Link) -> None:
        self._lead.left(link.name)

    def _hear(self, link: Link, line: str) -> None:
        told = read_line(line)
        if "alive" not in told:
            self._hear_show(link, told, line)
            return
        try:
            message = said(told)
        except Senseless:
            self._refuse(link)
            return
        if isinstance(message, Hello):
            self._meet(link, message)
        elif link.theirs is None:
            self._refuse(link)
        elif isinstance(message, SignedClaim):
            self._check(link, message)
        elif isinstance(message, GiveShow):
            self._give_show(link, message)
        elif isinstance(message, ShowComes):
            self._show_comes(link, message)
        elif isinstance(message, Cannot):
            self._say(f"another machine cannot stand by: {one_line(message.why)}")
            self._drop(link)
        elif (decided := message_of(message)) is not None:
            self._act(self._lead.heard(link.name, decided, self._now))

    def _refuse(self, link: Link) -> None:
        """Count an invalid message and drop its sender."""
        self._report.lines_refused += 1
        self._drop(link)

    def _drop(self, link: Link) -> None:
        assert self._peers is not None
        self._peers.drop(link)

    def _meet(self, link: Link, hello: Hello) -> None:
        assert self._peers is not None
        if link.theirs is not None or hello.me == self._lead.me:
            self._refuse(link)
            return
        if hello.version != __version__:
            why = f"the other machine is of version {hello.version}, this one of {__version__}"
            if link.upstream and not self._lead.leads:
                link.wire.put(line_of(Cannot(why)))
                self._parting = True
                self._say(f"{why}: it cannot be followed; install the same version on both")
                self._engines.code = 2
            else:
                self._drop(link)
            return
        for other in [other for other in self._peers.links.values() if other.me == hello.me]:
            self._drop(other)  # a broken link that this machine has not noticed yet
        link.theirs, link.me = hello.challenge, hello.me
        self._act(self._lead.joined(link.name, self._now, upstream=link.upstream))

    def _check(self, link: Link, signed: SignedClaim) -> None:
        assert self._peers is not None
        claim = verified(signed, link.peer, self._peers.identity, link.challenge, link.heard)
        if claim is None:
            self._lead.refused += 1
            self._drop(link)
            return
        link.heard = signed.number
        self._act(self._lead.heard(link.name, claim, self._now))

    # -- the show --------------------------------------------------------------------------------------------------

    def _give_show(self, link: Link, wanted: GiveShow) -> None:
        """Let a machine follow: from where it was after a short break of its link, else from the last snapshot."""
        link.takes_show = True
        first = self._number - len(self._recent)
        anew = wanted.stream != self._stream or not first <= wanted.number <= self._number
        number = self._number if anew else wanted.number
        link.wire.put(line_of(ShowComes(self._stream, number, anew)))
        lines = self._engines.log.since() if anew else list(self._recent)[number - first :]
        for line in lines:
            link.wire.put(line)

    def _show_comes(self, link: Link, told: ShowComes) -> None:
        if link is not self._leader():
            return
        if told.anew:
            self._begin_anew()
        elif (told.stream, told.number) != (self._theirs, self._their_number):
            self._refuse(link)
            return
        self._theirs, self._their_number, self._from = told.stream, told.number, link.name

    def _begin_anew(self) -> None:
        """Follow another show from its first line; followers of this machine do so, too."""
        if self._engines.log.header or self._engines.role != "standby":
            self._engines.stand_by()
        report = self._report
        report.fenced, self._ready, self._taken = False, None, 0
        report.compared = report.different = report.repaired = 0
        self._stream, self._number, self._recent_bytes = secrets.token_hex(8), 0, 0
        self._recent.clear()
        assert self._peers is not None
        for link in self._peers.links.values():
            if link.takes_show:
                link.wire.put(line_of(ShowComes(self._stream, 0, True)))

    def _hear_show(self, link: Link, told: dict[str, Any], line: str) -> None:
        if link is not self._leader() or link.name != self._from:
            if not told:
                self._refuse(link)
            return  # late lines of a former leader
        if not self._is_of_show(told):
            self._report.lines_refused += 1
            return
        self._taken = len(line) if "snapshot" in told else self._taken + len(line) + LINE_COSTS
        if self._taken > MOST_OF_SHOW:
            self._say(f"{link.peer.name} sends more data than a show can have: it is not followed any more")
            self._refuse(link)
            return
        self._their_number += 1
        if "journal" in told and self._engines.log.header:
            return
        if told.get("end"):
            self._say("the leader has ended the show")
            self._engines.code = 0
            return
        self._engines.take(line)
        if self._engines.engine is not None:
            self._engines.engine.wire.put(line)

    def _is_of_show(self, told: dict[str, Any]) -> bool:
        """Return whether a line can belong to the followed show."""
        if "journal" in told:
            return True
        tick = told.get("tick")
        if not isinstance(tick, int) or isinstance(tick, bool) or not 0 <= tick <= LATEST_TICK:
            return False
        log = self._engines.log
        if not log.header or (log.tick and tick > log.tick + MOST_TICKS):
            return False
        kinds = (("event", dict), ("measure", int), ("hash", str), ("snapshot", str), (LEFT_OUT, int))
        if not all(isinstance(told[key], kind) for key, kind in kinds if key in told):
            return False
        return ("measure" in told) <= ("hash" in told) and 0 <= told.get(LEFT_OUT, 0) <= MOST


def run_delay() -> float:
    """Return the seconds this process has waited for a processor; 0 if the kernel does not count them (schedstat of
    proc(5))."""
    try:
        with open(f"/proc/{os.getpid()}/schedstat", encoding="ascii") as file:
            return int(file.read().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def one_line(words: object) -> str:
    """Return text of another machine as one short line without control characters."""
    return "".join(mark if mark.isprintable() else " " for mark in str(words)[:LONGEST_WHY])
