"""Leadership: which machine leads a show, decided from messages and time alone.

What the law is. *A machine leads* when its dance is the show: it plays, sends, and its state is the one that counts;
who stands by may draw the same picture, in lockstep. Machines that hear each other have one leader. Nobody dances for
3 s at most while a machine is healthy: it runs and is not starved, and leads, or is the deputy and ready, or has led
before and hears nobody who does. Two lead only while they cannot hear each other, and for at most MEET seconds after
they can: with two machines and no third one to ask, a cut wire and a dead machine look alike, and of consistency and
availability (Gilbert and Lynch, 2002) a show needs the second. Each projector goes on; when the machines meet,
exactly one of them goes on leading.

How. Each leader has a *term*: an epoch and the leader's identity. Who takes over counts the epoch on; the greater
term rules (identities break ties), and who hears a signed claim to a greater one goes dark at once and follows. The
leader tells followers every PULSE that it is there, also while its engine hangs or is replaced: that is not death,
its own supervisor takes over first. If that takes too long it hands over to its *deputy*: the first follower that is
ready. Only the deputy takes silence for death, only if it is ready (it has compared hashes), and only seconds count
in which it ran itself: `turn` is what it measured of its own (`live.supervisor.network.remote_standby`).

The class is pure: no clock, no socket. `live.supervisor.network.remote_standby` drives it, and so does the model in
`tests/supervisor/network/test_leadership.py`, which checks the law under loss, delay, partitions, crashes and stalls.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import Final

PULSE: Final = 0.1
"""Seconds between two signs of a machine's life."""
SILENCE: Final = 1.5
"""Seconds of listening in silence after which a deputy takes its leader for dead. A supervisor that merely shares its
processor with much else is late by tenths of a second."""
RETURN: Final = 2.2
"""The same for a machine that led before and is not ready yet: it knows the show, but others may know it better."""
HAND_OVER: Final = 2.6
"""Seconds in which nobody dances after which a leader hands over. A spare takes over within 0.3 s of a death, and of a
hang on a quiet machine within 2.5 s."""
FRESH: Final = 0.5
"""Seconds since its last sign within which a machine can be handed over to."""
LOST: Final = 3.0
"""Seconds without a sign after which a link is given up; who reached the other machine reaches out anew."""
MEET: Final = 2.5
"""Seconds within which machines that can hear each other again have one leader."""
MOST_AHEAD: Final = 16
"""A claim to an epoch farther ahead than this is no claim: so many machines have not taken over since."""


class Role(Enum):
    """What a machine does."""

    LEADS = "leads"
    FOLLOWS = "follows"


@dataclass(frozen=True, slots=True, order=True)
class Term:
    """Who leads since when; the greater one rules."""

    epoch: int
    leader: str


@dataclass(frozen=True, slots=True)
class Pulse:
    """I live."""

    term: Term
    leads: bool
    ready: bool = False
    """Of a follower: it could go on with the show now."""
    deputy: bool = False
    """Of a leader: you are the one who is to take over from me."""
    other: bool = False
    """Of a leader: another machine is."""
    silent: float | None = 0.0
    """Seconds since the leader itself gave a sign, as far as this machine knows; None: it follows nobody."""
    idle: float = 0.0
    """Of a leader: seconds for which nobody has danced."""


@dataclass(frozen=True, slots=True)
class Claim:
    """This term rules; who hears it with a lower one follows. Only ever heard with a signature that was checked."""

    term: Term


@dataclass(frozen=True, slots=True)
class HandOver:
    """Nobody dances here: lead, if you can."""

    term: Term


Message = Pulse | Claim | HandOver


@dataclass(frozen=True, slots=True)
class Send:
    """Send a message over a link."""

    link: str
    message: Message


@dataclass(frozen=True, slots=True)
class Lead:
    """Lead from now on."""

    why: str
    silent: float
    """Seconds of silence before."""


@dataclass(frozen=True, slots=True)
class Dark:
    """Lead no more: nothing is shown, sent or played here, until this machine follows or leads."""

    why: str


@dataclass(frozen=True, slots=True)
class Follow:
    """Take the show from that link."""

    link: str


@dataclass(frozen=True, slots=True)
class Drop:
    """Give up a link."""

    link: str


Action = Send | Lead | Dark | Follow | Drop


@dataclass(slots=True)
class _Link:
    heard: float
    """When it gave the last sign [s]."""
    upstream: bool
    """Whether this machine was told to follow that one."""
    ready: bool = False
    term: Term | None = None
    told_at: float = -1e9
    """When it was last told which term rules."""


@dataclass(slots=True)
class Leadership:
    """One machine's part. Times [s] are of any clock that does not go back. Thread: one."""

    me: str
    """This machine, as no other one is called."""
    role: Role
    term: Term = field(init=False)
    leader: str | None = None
    """The link to the machine that is followed."""
    deputy: str | None = None
    """While leading: the link to who takes over. Only one does, so that two never take over from one."""
    is_deputy: bool = False
    """While following: whether the leader said so last."""
    silent: float = 0.0
    """Seconds that this machine has listened to nobody who leads."""
    refused: int = 0
    """Claims and other messages that counted for nothing."""
    led: bool = False
    """Whether this machine has danced a show that it led."""
    _other: bool = False
    _idle: float = 0.0
    _links: dict[str, _Link] = field(default_factory=dict)
    _pulse_at: float = -1e9

    def __post_init__(self) -> None:
        """A machine that begins to lead does so in epoch 1; who follows has none of its own yet."""
        self.term = Term(1, self.me) if self.leads else Term(0, "")

    @property
    def leads(self) -> bool:
        """Whether this machine leads."""
        return self.role is Role.LEADS

    def joined(self, link: str, now: float, *, upstream: bool = False) -> list[Action]:
        """A link to a machine that may take part is there; `upstream`: this machine was told to follow it."""
        self._links[link] = _Link(now, upstream)
        return [Send(link, self._pulse(link))]

    def left(self, link: str) -> None:
        """A link has ended, which says nothing of the machine behind it."""
        self._links.pop(link, None)
        if link == self.deputy:
            self.deputy = None
        if link == self.leader:
            self.leader = None

    def gone(self, *, ready: bool) -> list[Action]:
        """The machine that was followed says itself that nobody is there any more: its port refuses. No need to wait
        in silence."""
        if self.leads or self.leader is not None or not (self.is_deputy and ready):
            return []
        return self.take_over("for its leader has gone")

    def heard(self, link: str, message: Message, now: float) -> list[Action]:
        """A message came."""
        there = self._links.get(link)
        if there is None:
            return []
        there.heard = now
        if isinstance(message, Claim):
            return self._claim(link, message.term)
        if isinstance(message, HandOver):
            if self.leads or link != self.leader or message.term != self.term:
                self.refused += 1
                return []
            return self.take_over("for nobody danced on the other machine")
        there.term, there.ready = message.term, message.ready
        if self.leads:
            # one with a greater term claims that, with a signature
            return self._tell(link, there, now) if message.term < self.term else []
        return self._follows(link, there, message, now)

    def look(self, now: float, turn: float, *, ready: bool, idle: float | None = None) -> list[Action]:
        """To be called every few hundredths of a second. `turn` [s]: since the last time, as far as this machine ran
        itself; `ready`: it could go on with the show; `idle` [s]: for how long nobody has danced here, None before
        anybody has."""
        found: list[Action] = []
        for link, there in list(self._links.items()):
            if now - there.heard > LOST:
                self.left(link)
                found.append(Drop(link))
        if self.leads:
            self.led = self.led or idle is not None
            found += self._look_leading(now, idle or 0.0)
        else:
            self.silent += turn
            if self._may_take_over(ready):
                found += self.take_over(f"after {self.silent:.1f} s of silence")
        if now - self._pulse_at >= PULSE:
            self._pulse_at = now
            found += [Send(link, self._pulse(link, ready, idle or 0.0)) for link in self._links]
        return found

    def take_over(self, why: str) -> list[Action]:
        """Lead from now on, as somebody commands or the silence does."""
        if self.leads:
            return []
        self.role, self.leader, self.is_deputy, self._other = Role.LEADS, None, False, False
        self.term = Term(self.term.epoch + 1, self.me)
        silent, self.deputy, self.silent, self._pulse_at = self.silent, None, 0.0, -1e9
        return [Lead(why, silent), *(Send(link, Claim(self.term)) for link in self._links)]

    # -- parts of it ---------------------------------------------------------------------------------------------

    def _pulse(self, link: str, ready: bool = False, idle: float = 0.0) -> Pulse:
        if self.leads:
            mine = link == self.deputy
            return Pulse(
                self.term, True, deputy=mine, other=self.deputy is not None and not mine, idle=round(idle, 3)
            )  # fmt: skip
        return Pulse(self.term, False, ready=ready, silent=None if self.leader is None else round(self.silent, 3))

    def _tell(self, link: str, there: _Link, now: float) -> list[Action]:
        """Tell a machine that does not know it yet which term rules."""
        if now - there.told_at < FRESH:
            return []
        there.told_at = now
        return [Send(link, Claim(self.term))]

    def _look_leading(self, now: float, idle: float) -> list[Action]:
        able = [
            link for link, there in self._links.items()
            if there.ready and there.term == self.term and now - there.heard < FRESH
        ]  # fmt: skip
        kept = self._links.get(self.deputy or "")
        if kept is None or not kept.ready or kept.term != self.term:
            self.deputy = next(iter(able), None)
        if idle <= HAND_OVER or self.deputy not in able:
            return []
        deputy = self.deputy
        self._give_way(deputy)
        words = "nobody danced here for too long: the machine that stands by takes over"
        return [Dark(words), Send(deputy, HandOver(self.term)), Follow(deputy)]

    def _may_take_over(self, ready: bool) -> bool:
        # a leader in whose place nobody danced when it fell silent was about to hand over
        hung = self.silent > FRESH and self._idle + self.silent > HAND_OVER
        if self.is_deputy and ready:
            return self.silent > SILENCE or hung
        return self.led and not self._other and (self.silent > RETURN or hung)

    def _follows(self, link: str, there: _Link, pulse: Pulse, now: float) -> list[Action]:
        """A sign of the machine that is followed, of one that is to be followed, or of one that has to be told whom."""
        alive = pulse.leads or (pulse.silent is not None and pulse.silent < FRESH)
        found: list[Action] = []
        if link != self.leader:
            if self.leader is not None:
                return self._tell(link, there, now) if pulse.leads and pulse.term < self.term else []
            if not (alive and self._would_follow(there, pulse)):
                return []
            self.leader, self.is_deputy, self._other = link, False, False
            found.append(Follow(link))
        if alive or pulse.silent is not None:
            self.silent = min(self.silent, 0.0 if pulse.leads else (pulse.silent or 0.0) + PULSE)
        if alive:
            self.term, self.is_deputy, self._other, self._idle = pulse.term, pulse.deputy, pulse.other, pulse.idle
        return found

    def _would_follow(self, there: _Link, pulse: Pulse) -> bool:
        """Whether to follow a machine without being told so by a claim. One that leads the same show in an older term,
        or began another one in the same, is followed only once it is sure that nobody takes over here."""
        known = pulse.term == self.term or pulse.term.epoch > self.term.epoch
        if known and (pulse.leads or there.upstream):
            return True
        waits = self.led or (self.is_deputy and self.silent < RETURN)
        return there.upstream and not waits

    def _claim(self, link: str, term: Term) -> list[Action]:
        if term == self.term:
            return []
        if term < self.term or term.epoch - self.term.epoch > MOST_AHEAD:
            self.refused += 1
            tells = self.leads or self.leader is not None
            return [Send(link, Claim(self.term))] if tells and term < self.term else []
        led = self.leads
        self.term = term
        self._give_way(link)
        words = f"another machine leads now (epoch {term.epoch}): this one is dark"
        return [*([Dark(words)] if led else []), Follow(link)]

    def _give_way(self, link: str) -> None:
        self.role, self.leader, self.deputy = Role.FOLLOWS, link, None
        self.is_deputy, self._other, self.silent, self._idle = False, False, 0.0, 0.0
