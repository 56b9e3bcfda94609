"""Leader election between machines, as a pure function of messages and time.

The invariants. *A machine leads* when its state is the show: it plays, sends, and its state counts; a follower may draw
the same picture in lockstep. Machines that can reach each other have one leader. The show stops for 3 s at most while
one machine is healthy: it runs, is not starved, and leads, or is the deputy and ready, or has led before and reaches no
leader. Two machines lead only while they cannot reach each other, and for at most MEET seconds after they can: with two
machines and no third one to ask, a broken link and a dead machine look alike, and of consistency and availability
(Gilbert and Lynch, 2002) a show needs the second. Each projector then continues; when the machines meet again, exactly
one of them keeps the lead.

The protocol. Each leader has a *term*: an epoch and the leader's identity. A machine that takes over increments the
epoch; the greater term rules (identities break ties), and a machine that receives a signed claim to a greater one goes
dark at once and follows. The leader sends a pulse to its followers every PULSE, also while its engine hangs or is
replaced: its own supervisor handles that first. If that takes too long, it hands over to its *deputy*: the first
follower that is ready. Only the deputy takes silence for death, and only if it is ready (it has compared hashes). Only
seconds count in which it ran itself: it measures these as `turn` (`live.supervisor.network.remote_standby`).

The class is pure: no clock, no socket. `live.supervisor.network.remote_standby` drives it, and so does the model in
`tests/supervisor/network/test_leadership.py`, which checks the invariants under loss, delay, partitions, crashes and
stalls.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import Final

PULSE: Final = 0.1
"""Seconds between two pulses."""
LEADER_TIMEOUT: Final = 1.5
"""Seconds of silence after which a deputy takes its leader for dead. A supervisor that merely shares its processor is
late by tenths of a second."""
FORMER_LEADER_TIMEOUT: Final = 2.2
"""The same for a machine that led before and is not ready yet: it knows the show, but others may have a newer state."""
HAND_OVER_AFTER: Final = 2.6
"""Seconds without a running engine after which a leader hands over. A spare engine takes over within 0.3 s of a death,
and within 2.5 s of a hang on a quiet machine."""
MAX_PULSE_AGE: Final = 0.5
"""Greatest age of a follower's last message for a hand-over [s]."""
LINK_TIMEOUT: Final = 3.0
"""Seconds without a message after which a link is closed; the side that opened it reconnects."""
MERGE_TIMEOUT: Final = 2.5
"""Seconds within which machines that can reach each other again have one leader."""
MAX_EPOCHS_AHEAD: Final = 16
"""Claims to an epoch farther ahead are ignored: so many changes of leader cannot have been missed."""


class Role(Enum):
    """Role of a machine."""

    LEADS = "leads"
    FOLLOWS = "follows"


@dataclass(frozen=True, slots=True, order=True)
class Term:
    """Leader and epoch; the greater term rules."""

    epoch: int
    leader: str


@dataclass(frozen=True, slots=True)
class Pulse:
    """Regular sign of life."""

    term: Term
    leads: bool
    ready: bool = False
    """Of a follower: whether it could resume the show now."""
    deputy: bool = False
    """Of a leader: whether the receiver is its deputy."""
    other_deputy: bool = False
    """Of a leader: whether another machine is its deputy."""
    silent: float | None = 0.0
    """Seconds since the leader's own last message, as far as this machine knows; None: it follows no machine."""
    idle: float = 0.0
    """Of a leader: seconds since an engine last ran."""


@dataclass(frozen=True, slots=True)
class Claim:
    """Claim that this term rules; a receiver with a lower term follows. The signature is checked before."""

    term: Term


@dataclass(frozen=True, slots=True)
class HandOver:
    """Request to the deputy to lead, because no engine runs on the leader."""

    term: Term


Message = Pulse | Claim | HandOver


@dataclass(frozen=True, slots=True)
class Send:
    """Send a message over a link."""

    link: str
    message: Message


@dataclass(frozen=True, slots=True)
class Lead:
    """Start to lead."""

    why: str
    silent: float
    """Seconds of silence before that."""


@dataclass(frozen=True, slots=True)
class StepDown:
    """Stop leading: nothing is shown, sent or played until this machine follows or leads."""

    why: str


@dataclass(frozen=True, slots=True)
class Follow:
    """Follow the show from that link."""

    link: str


@dataclass(frozen=True, slots=True)
class Drop:
    """Close a link."""

    link: str


Action = Send | Lead | StepDown | Follow | Drop


@dataclass(slots=True)
class _Link:
    last_message: float
    """When its last message came [s]."""
    upstream: bool
    """Whether this machine was configured to follow that one."""
    ready: bool = False
    term: Term | None = None
    claim_sent_at: float = -1e9
    """When the current term was last sent to it."""


@dataclass(slots=True)
class Leadership:
    """State of one machine in the election. Times [s] are of any monotonic clock. Thread: one."""

    name: str
    """Unique name of this machine."""
    role: Role
    term: Term = field(init=False)
    leader: str | None = None
    """Link to the machine that is followed."""
    deputy: str | None = None
    """While leading: link to the deputy. There is only one, so that two machines never take over at once."""
    is_deputy: bool = False
    """While following: whether the leader's last pulse named this machine as deputy."""
    silent: float = 0.0
    """Seconds for which this machine has listened and received nothing from a leader."""
    refused: int = 0
    """Claims and other messages that were rejected."""
    has_led: bool = False
    """Whether this machine has run a show as leader."""
    _other_deputy: bool = False
    _idle: float = 0.0
    _links: dict[str, _Link] = field(default_factory=dict)
    _pulse_at: float = -1e9

    def __post_init__(self) -> None:
        """Start in epoch 1 as a leader; a follower has no term of its own yet."""
        self.term = Term(1, self.name) if self.leads else Term(0, "")

    @property
    def leads(self) -> bool:
        """Whether this machine leads."""
        return self.role is Role.LEADS

    def is_ready(self, link: str) -> bool:
        """Whether the machine behind a link could resume the show, as it last said."""
        there = self._links.get(link)
        return there is not None and there.ready

    def silence(self, link: str, now: float) -> float:
        """Return the seconds since the last message of a link; 0 for one that is not known."""
        there = self._links.get(link)
        return 0.0 if there is None else now - there.last_message

    def link_opened(self, link: str, now: float, *, upstream: bool = False) -> list[Action]:
        """A link to a paired machine is open. `upstream`: this machine was configured to follow it."""
        self._links[link] = _Link(now, upstream)
        return [Send(link, self._pulse(link))]

    def link_closed(self, link: str) -> None:
        """A link has closed; the machine behind it may still run."""
        self._links.pop(link, None)
        if link == self.deputy:
            self.deputy = None
        if link == self.leader:
            self.leader = None

    def leader_gone(self, *, ready: bool) -> list[Action]:
        """The followed machine refuses connections, so no supervisor runs there. Promote at once if this is the ready
        deputy."""
        if self.leads or self.leader is not None or not (self.is_deputy and ready):
            return []
        return self.promote("because its leader has gone")

    def handle(self, link: str, message: Message, now: float) -> list[Action]:
        """Handle a message."""
        there = self._links.get(link)
        if there is None:
            return []
        there.last_message = now
        if isinstance(message, Claim):
            return self._handle_claim(link, message.term)
        if isinstance(message, HandOver):
            if self.leads or link != self.leader or message.term != self.term:
                self.refused += 1
                return []
            return self.promote("because no engine ran on the other machine")
        there.term, there.ready = message.term, message.ready
        if self.leads:
            # a machine with a greater term sends a signed claim
            return self._send_claim(link, there, now) if message.term < self.term else []
        return self._handle_pulse(link, there, message, now)

    def update(self, now: float, turn: float, *, ready: bool, idle: float | None = None) -> list[Action]:
        """Update; to be called every few hundredths of a second.

        `turn` [s]: time since the last call in which this process ran; `ready`: whether this machine could resume the
        show; `idle` [s]: time since an engine last ran here, None before the first one.
        """
        found: list[Action] = []
        for link, there in list(self._links.items()):
            if now - there.last_message > LINK_TIMEOUT:
                self.link_closed(link)
                found.append(Drop(link))
        if self.leads:
            self.has_led = self.has_led or idle is not None
            found += self._update_leading(now, idle or 0.0)
        else:
            self.silent += turn
            if self._may_take_over(ready):
                found += self.promote(f"after {self.silent:.1f} s of silence")
        if now - self._pulse_at >= PULSE:
            self._pulse_at = now
            found += [Send(link, self._pulse(link, ready, idle or 0.0)) for link in self._links]
        return found

    def promote(self, why: str) -> list[Action]:
        """Start to lead, on command or after silence."""
        if self.leads:
            return []
        self.role, self.leader, self.is_deputy, self._other_deputy = Role.LEADS, None, False, False
        self.term = Term(self.term.epoch + 1, self.name)
        silent, self.deputy, self.silent, self._pulse_at = self.silent, None, 0.0, -1e9
        return [Lead(why, silent), *(Send(link, Claim(self.term)) for link in self._links)]

    # -- parts of it ---------------------------------------------------------------------------------------------

    def _pulse(self, link: str, ready: bool = False, idle: float = 0.0) -> Pulse:
        if self.leads:
            mine = link == self.deputy
            return Pulse(
                self.term, True, deputy=mine, other_deputy=self.deputy is not None and not mine, idle=round(idle, 3)
            )  # fmt: skip
        return Pulse(self.term, False, ready=ready, silent=None if self.leader is None else round(self.silent, 3))

    def _send_claim(self, link: str, there: _Link, now: float) -> list[Action]:
        """Send the current term to a machine that has an older one, at most every FRESH."""
        if now - there.claim_sent_at < MAX_PULSE_AGE:
            return []
        there.claim_sent_at = now
        return [Send(link, Claim(self.term))]

    def _update_leading(self, now: float, idle: float) -> list[Action]:
        able = [
            link for link, there in self._links.items()
            if there.ready and there.term == self.term and now - there.last_message < MAX_PULSE_AGE
        ]  # fmt: skip
        kept = self._links.get(self.deputy or "")
        if kept is None or not kept.ready or kept.term != self.term:
            self.deputy = next(iter(able), None)
        if idle <= HAND_OVER_AFTER or self.deputy not in able:
            return []
        deputy = self.deputy
        self._step_down(deputy)
        words = "no engine ran here for too long: the standby machine takes over"
        return [StepDown(words), Send(deputy, HandOver(self.term)), Follow(deputy)]

    def _may_take_over(self, ready: bool) -> bool:
        # a leader without a running engine before it fell silent was about to hand over
        hung = self.silent > MAX_PULSE_AGE and self._idle + self.silent > HAND_OVER_AFTER
        if self.is_deputy and ready:
            return self.silent > LEADER_TIMEOUT or hung
        return self.has_led and not self._other_deputy and (self.silent > FORMER_LEADER_TIMEOUT or hung)

    def _handle_pulse(self, link: str, there: _Link, pulse: Pulse, now: float) -> list[Action]:
        """Handle a pulse of the followed machine, of one to follow from now on, or of one with an older term."""
        alive = pulse.leads or (pulse.silent is not None and pulse.silent < MAX_PULSE_AGE)
        found: list[Action] = []
        if link != self.leader:
            if self.leader is not None:
                return self._send_claim(link, there, now) if pulse.leads and pulse.term < self.term else []
            if not (alive and self._would_follow(there, pulse)):
                return []
            self.leader, self.is_deputy, self._other_deputy = link, False, False
            found.append(Follow(link))
        if alive or pulse.silent is not None:
            self.silent = min(self.silent, 0.0 if pulse.leads else (pulse.silent or 0.0) + PULSE)
        if alive:
            self.term, self.is_deputy, self._other_deputy, self._idle = (
                pulse.term,
                pulse.deputy,
                pulse.other_deputy,
                pulse.idle,
            )
        return found

    def _would_follow(self, there: _Link, pulse: Pulse) -> bool:
        """Whether to follow a machine without a claim. A leader of the same show in an older term, or of another show
        in the same term, is followed only if this machine cannot take over itself."""
        known = pulse.term == self.term or pulse.term.epoch > self.term.epoch
        if known and (pulse.leads or there.upstream):
            return True
        waits = self.has_led or (self.is_deputy and self.silent < FORMER_LEADER_TIMEOUT)
        return there.upstream and not waits

    def _handle_claim(self, link: str, term: Term) -> list[Action]:
        if term == self.term:
            return []
        if term < self.term or term.epoch - self.term.epoch > MAX_EPOCHS_AHEAD:
            self.refused += 1
            tells = self.leads or self.leader is not None
            return [Send(link, Claim(self.term))] if tells and term < self.term else []
        led = self.leads
        self.term = term
        self._step_down(link)
        words = f"another machine leads now (epoch {term.epoch}): this one goes dark"
        return [*([StepDown(words)] if led else []), Follow(link)]

    def _step_down(self, link: str) -> None:
        self.role, self.leader, self.deputy = Role.FOLLOWS, link, None
        self.is_deputy, self._other_deputy, self.silent, self._idle = False, False, 0.0, 0.0
