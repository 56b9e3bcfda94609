"""Leadership under loss, delay, partitions, crashes and stalls: a model that drives the product's own class.

Invariant: machines that have exchanged messages for MERGE_TIMEOUT seconds have one leader; and while one machine has
been healthy for 3 s (it runs, and leads, or is a ready deputy, or has led before) no gap without a dancing machine
exceeds 3 s.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from live.supervisor.network.leadership import (
    HAND_OVER_AFTER,
    LEADER_TIMEOUT,
    LINK_TIMEOUT,
    MAX_EPOCHS_AHEAD,
    MAX_PULSE_AGE,
    MERGE_TIMEOUT,
    Action,
    Claim,
    Drop,
    Follow,
    HandOver,
    Lead,
    Leadership,
    Message,
    Pulse,
    Role,
    Send,
    StepDown,
    Term,
)

STEP = 0.05
DIAL = 0.5
"""Seconds between two attempts to reach another machine."""
PREPARES = 2.0
"""Seconds of following after which a follower is ready."""
ABSENT = 3.0
WAITS = st.sampled_from([0.0, 0.05, 0.2, 0.6, 1.5, 3.0, 6.0])
"""Seconds until the next thing happens."""


@dataclass
class Machine:
    """The environment of a Leadership in the product: an engine, links, a processor that may stall."""

    name: str
    dials: str | None
    up: bool = True
    stalled_until: float = 0.0
    hung_until: float = 0.0
    danced: float = 0.0
    born: int = 0
    leadership: Leadership = field(init=False)
    follows_since: float | None = None
    began: float = 0.0
    dial_at: float = 0.0
    healthy_since: float | None = None

    def begin(self, now: float) -> None:
        self.born += 1
        role = Role.LEADS if self.dials is None else Role.FOLLOWS
        self.leadership = Leadership(f"{self.name}{self.born}", role)
        self.up, self.follows_since, self.began, self.dial_at = True, None, now, now
        self.stalled_until, self.hung_until, self.danced = 0.0, 0.0, now

    def runs(self, now: float) -> bool:
        return self.up and now >= self.stalled_until

    def ready(self, now: float) -> bool:
        since = self.follows_since
        return not self.leadership.leads and since is not None and now - since > PREPARES and now >= self.hung_until

    def dances(self, now: float) -> bool:
        return self.runs(now) and self.leadership.leads and now >= self.hung_until

    def healthy(self, now: float) -> bool:
        lead = self.leadership
        able = lead.leads or (lead.is_deputy and self.ready(now)) or (lead.has_led and lead.silent > MAX_PULSE_AGE)
        return self.runs(now) and now >= self.hung_until and able


@dataclass
class Wire:
    """A connection with its messages in flight, in order. A partition delays them and does not close it."""

    ends: tuple[str, str]
    number: int
    under_way: list[tuple[float, str, Message]] = field(default_factory=list)

    @property
    def link(self) -> str:
        return f"{self.ends[0]}-{self.ends[1]}-{self.number}"


class World:
    """Machines, the connections between them, and time."""

    def __init__(self, dials: dict[str, str | None]) -> None:
        self.now = 0.0
        self.machines = {name: Machine(name, to) for name, to in dials.items()}
        self.wires: list[Wire] = []
        self.cut: set[frozenset[str]] = set()
        self.delay = 0.0
        self.apart: dict[frozenset[str], float] = {}
        self.danced = 0.0
        self.dark: list[tuple[float, str]] = []
        self._number = 0
        for machine in self.machines.values():
            machine.begin(0.0)

    def pairs(self) -> Iterator[frozenset[str]]:
        for name, machine in self.machines.items():
            if machine.dials is not None:
                yield frozenset((name, machine.dials))

    def crash(self, name: str) -> None:
        self.machines[name].up = False
        for wire in [wire for wire in self.wires if name in wire.ends]:
            if frozenset(wire.ends) not in self.cut:
                self.wires.remove(wire)  # the system closes what a process had open
                other = self.machines[wire.ends[wire.ends[0] == name]]
                other.leadership.link_closed(wire.link)

    def end_wire(self, wire: Wire) -> None:
        if wire in self.wires:
            self.wires.remove(wire)
            for name in wire.ends:
                self.machines[name].leadership.link_closed(wire.link)

    def advance(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.step()
            self.check()

    def step(self) -> None:
        self.now = round(self.now + STEP, 6)
        for machine in self.machines.values():
            if machine.runs(self.now):
                self._hear(machine)
                self._dial(machine)
                if machine.dances(self.now):
                    machine.danced = self.now
                idle, ready = self.now - machine.danced, machine.ready(self.now)
                self._act(machine, machine.leadership.update(self.now, STEP, ready=ready, idle=idle))

    def hang(self, name: str, seconds: float) -> None:
        machine = self.machines[name]
        machine.hung_until = max(machine.hung_until, self.now + seconds)

    def _hear(self, machine: Machine) -> None:
        for wire in list(self.wires):
            if machine.name not in wire.ends or frozenset(wire.ends) in self.cut:
                continue
            while due := next((one for one in wire.under_way if one[1] == machine.name), None):
                if due[0] > self.now:
                    break
                wire.under_way.remove(due)
                self._act(machine, machine.leadership.handle(wire.link, due[2], self.now))

    def _dial(self, machine: Machine) -> None:
        if machine.dials is None or self.now < machine.dial_at:
            return
        joined = any(machine.name in wire.ends and machine.dials in wire.ends for wire in self.wires)
        if joined or frozenset((machine.name, machine.dials)) in self.cut:
            return
        machine.dial_at = self.now + DIAL
        there = self.machines[machine.dials]
        if not there.up:
            self._act(machine, machine.leadership.leader_gone(ready=machine.ready(self.now)))
            return
        self._number += 1
        wire = Wire((machine.name, machine.dials), self._number)
        self.wires.append(wire)
        self._act(machine, machine.leadership.link_opened(wire.link, self.now, upstream=True))
        self._act(there, there.leadership.link_opened(wire.link, self.now))

    def _act(self, machine: Machine, actions: list[Action]) -> None:
        for action in actions:
            if isinstance(action, Send):
                wire = next((wire for wire in self.wires if wire.link == action.link), None)
                if wire is not None:
                    other = wire.ends[wire.ends[0] == machine.name]
                    wire.under_way.append((self.now + self.delay, other, action.message))
            elif isinstance(action, Lead):
                machine.follows_since, machine.danced = None, self.now
            elif isinstance(action, StepDown):
                self.dark.append((self.now, machine.name))
            elif isinstance(action, Follow):
                machine.follows_since = self.now
            elif isinstance(action, Drop):
                for wire in [wire for wire in self.wires if wire.link == action.link]:
                    self.end_wire(wire)

    def check(self) -> None:
        for pair in self.pairs():
            able = pair not in self.cut and all(self.machines[name].runs(self.now) for name in pair)
            if not able or pair not in self.apart:
                self.apart[pair] = self.now
            leading = [name for name in pair if self.machines[name].leadership.leads]
            if len(leading) > 1:
                assert self.now - self.apart[pair] <= MERGE_TIMEOUT, f"{leading} lead, and hear each other"
        if any(machine.dances(self.now) for machine in self.machines.values()):
            self.danced = self.now
        for machine in self.machines.values():
            if not machine.healthy(self.now):
                machine.healthy_since = None
            elif machine.healthy_since is None:
                machine.healthy_since = self.now
            else:
                since = max(self.danced, machine.healthy_since)
                assert self.now - since <= ABSENT, f"nobody dances, though {machine.name} could"

    def leading(self) -> list[str]:
        return [name for name, machine in self.machines.items() if machine.up and machine.leadership.leads]


class TwoMachines(RuleBasedStateMachine):
    """The invariants hold under any sequence of faults."""

    DIALS: ClassVar[dict[str, str | None]] = {"A": None, "B": "A"}

    @initialize()
    def begin(self) -> None:
        self.world = World(self.DIALS)
        self.names = list(self.DIALS)
        self.world.advance(4.0)

    def machine(self, which: int) -> Machine:
        return self.world.machines[self.names[which % len(self.names)]]

    @rule(then=WAITS, which=st.integers(0, 5))
    def crash(self, which: int, then: float) -> None:
        self.world.crash(self.machine(which).name)
        self.world.advance(then)

    @rule(then=WAITS, which=st.integers(0, 5))
    def restart(self, which: int, then: float) -> None:
        self.begin_anew(self.machine(which))
        self.world.advance(then)

    def begin_anew(self, machine: Machine) -> None:
        if not machine.up:
            for wire in [wire for wire in self.world.wires if machine.name in wire.ends]:
                self.world.end_wire(wire)
            machine.begin(self.world.now)
            for pair in self.world.pairs():
                if machine.name in pair:
                    self.world.apart[pair] = self.world.now

    @rule(then=WAITS, which=st.integers(0, 5), seconds=st.sampled_from([0.3, 1.0, 2.0, 5.0]))
    def stall(self, which: int, seconds: float, then: float) -> None:
        machine = self.machine(which)
        machine.stalled_until = max(machine.stalled_until, self.world.now + seconds)
        self.world.advance(then)

    @rule(then=WAITS, which=st.integers(0, 5), seconds=st.sampled_from([0.3, 2.0, 2.3, 9.0]))
    def hang(self, which: int, seconds: float, then: float) -> None:
        self.world.hang(self.machine(which).name, seconds)
        self.world.advance(then)

    @rule(then=WAITS, which=st.integers(0, 5))
    def cut(self, which: int, then: float) -> None:
        pairs = sorted(self.world.pairs(), key=sorted)
        self.world.cut.add(pairs[which % len(pairs)])
        self.world.advance(then)

    @rule(then=WAITS)
    def heal(self, then: float) -> None:
        for pair in self.world.cut:
            for wire in [wire for wire in self.world.wires if frozenset(wire.ends) == pair]:
                if not all(self.world.machines[name].up for name in wire.ends):
                    self.world.end_wire(wire)
        self.world.cut.clear()
        self.world.advance(then)

    @rule(then=WAITS)
    def lose_wires(self, then: float) -> None:
        for wire in list(self.world.wires):
            self.world.end_wire(wire)
        self.world.advance(then)

    @rule(then=WAITS, seconds=st.sampled_from([0.0, 0.05, 0.2]))
    def slow(self, seconds: float, then: float) -> None:
        self.world.delay = seconds
        self.world.advance(then)

    @invariant()
    def epochs_are_sane(self) -> None:
        if hasattr(self, "world"):
            for machine in self.world.machines.values():
                assert machine.leadership.term.epoch < 200

    def teardown(self) -> None:
        """Once all faults are over, exactly one machine leads and every other one follows it."""
        if not hasattr(self, "world"):
            return
        self.heal(0.0)
        self.world.delay = 0.0
        for machine in self.world.machines.values():
            machine.stalled_until = machine.hung_until = 0.0
            self.begin_anew(machine)
        self.world.advance(10.0)
        leading = self.world.leading()
        assert len(leading) == 1, f"{leading} lead in the end"
        for name, machine in self.world.machines.items():
            assert name in leading or machine.leadership.leader is not None, f"{name} stays dark"


TestTwoMachines = TwoMachines.TestCase
TestTwoMachines.settings = settings(max_examples=30, stateful_step_count=20, deadline=None)


class ThreeMachines(TwoMachines):
    """A second standby machine never takes over beside the deputy."""

    DIALS: ClassVar[dict[str, str | None]] = {"A": None, "B": "A", "C": "A"}


TestThreeMachines = ThreeMachines.TestCase
TestThreeMachines.settings = settings(max_examples=20, stateful_step_count=20, deadline=None)


def two_machines() -> World:
    """A leader and its deputy."""
    world = World({"A": None, "B": "A"})
    world.advance(4.0)
    assert world.machines["B"].leadership.is_deputy
    return world


def test_stalled_leader_is_replaced_and_follows_after_resuming():
    world = two_machines()
    world.machines["A"].stalled_until = world.now + 5.0
    world.advance(LEADER_TIMEOUT + 0.3)
    assert world.leading() == ["A", "B"]  # one of them does not run
    world.advance(4.0)
    assert world.leading() == ["B"]
    assert world.dark[-1][1] == "A"
    assert world.machines["A"].leadership.leader is not None


def test_partitioned_machines_have_one_leader_soon_after_healing():
    world = two_machines()
    world.cut.add(frozenset("AB"))
    world.advance(20.0)
    assert world.leading() == ["A", "B"]  # each has its own projector
    world.cut.clear()
    world.advance(MERGE_TIMEOUT)
    assert world.leading() == ["B"]


def test_leader_hands_over_only_when_engine_stays_away_too_long():
    for seconds, leads in ((2.3, "A"), (9.0, "B")):
        world = two_machines()
        world.hang("A", seconds)
        world.advance(HAND_OVER_AFTER + 0.3)
        assert world.leading() == [leads]


def test_fenced_leader_leads_again_if_new_leader_dies_first():
    world = two_machines()
    world.machines["A"].stalled_until = world.now + 2.0
    world.advance(2.5)
    assert world.leading() == ["B"]
    assert not world.machines["A"].ready(world.now)
    world.crash("B")
    world.advance(ABSENT)
    assert world.leading() == ["A"]
    assert world.machines["A"].leadership.term.epoch == 3


def test_partitioned_follower_takes_over_in_time_when_leader_dies():
    world = two_machines()
    world.cut.add(frozenset("AB"))
    world.advance(0.2)
    world.crash("A")
    world.advance(ABSENT)
    assert "B" in world.leading()


def test_claims_to_old_or_absurd_epochs_are_refused_and_counted():
    one = Leadership("A", Role.LEADS)
    one.link_opened("b", 0.0)
    for term in (Term(0, "B"), Term(1 + MAX_EPOCHS_AHEAD + 1, "B"), Term(99, "B"), Term(1, "@")):
        one.handle("b", Claim(term), 0.1)
        assert one.leads
    assert one.refused == 4
    assert one.handle("nobody", Claim(Term(2, "B")), 0.1) == []
    actions = one.handle("b", Claim(Term(2, "B")), 0.2)
    assert [type(action) for action in actions] == [StepDown, Follow]
    assert not one.leads
    assert one.handle("b", HandOver(Term(1, "A")), 0.3) == []  # of a term that is over
    assert one.refused == 5


def test_exactly_one_of_two_leaders_of_same_epoch_remains():
    one, other = Leadership("A", Role.LEADS), Leadership("B", Role.LEADS)
    for machine in (one, other):
        machine.link_opened("x", 0.0)
    claims = [*one.handle("x", Pulse(other.term, True), 0.1), *other.handle("x", Pulse(one.term, True), 0.1)]
    (claim,) = [action.message for action in claims if isinstance(action, Send)]
    one.handle("x", claim, 0.2)
    other.handle("x", claim, 0.2)
    assert (one.leads, other.leads) == (False, True)


def test_silence_counts_only_while_machine_runs_and_follower_is_ready():
    for turn, ready, leads in ((0.05, True, True), (0.0, True, False), (0.05, False, False)):
        one = Leadership("B", Role.FOLLOWS)
        one.link_opened("a", 0.0, upstream=True)
        one.handle("a", Pulse(Term(1, "A"), True, deputy=True), 0.0)
        for step in range(1, 50):
            for action in one.update(step * 0.05, turn, ready=ready):
                assert not isinstance(action, Lead) or leads
        assert one.leads is leads
    assert LINK_TIMEOUT > LEADER_TIMEOUT
