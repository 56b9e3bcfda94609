"""What an operator asks of a cluster: how all parts of its show are, and to start some again, one after another."""

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError
from live.control.message_codec import PacketError
from live.nodes import messages
from live.nodes.messages import ClusterStatus, Member, NodeState, Order, Pulse
from live.nodes.signed_bus import SignedBus

ANSWERS_WITHIN: Final = 3.0
"""Seconds in which a leader is heard, and in which it answers."""
BACK_WITHIN: Final = 60.0
"""Seconds in which a node that was started again follows."""
LOOK_EVERY: Final = 0.25
GONE_AFTER: Final = 3.0
"""Seconds of silence after which a node counts as gone."""
WORKING: Final = ("ready", "serves")
"""States of a `Member` that does what it is there for."""
ORDER_OF_KINDS: Final = ("gateway", "reducer", "node", "standby")
"""Kinds of parts, in the order in which they are started again."""


@dataclass(frozen=True, slots=True)
class SeenNode:
    """A node as its leader knows it."""

    told: NodeState
    age: float
    """Seconds since it was heard."""

    @property
    def state(self) -> str:
        """Its state; gone, if it is silent for too long."""
        return self.told.state if self.age < GONE_AFTER else "gone"


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a show that can be started again: a node, a gateway, the reducer, a machine that stands by."""

    kind: str
    name: str
    process: str
    works: bool
    """Whether it does what it is there for."""


@dataclass(frozen=True, slots=True)
class SeenCluster:
    """A leader and all other parts of its show."""

    status: ClusterStatus
    nodes: tuple[SeenNode, ...]
    members: tuple[Member, ...]

    @property
    def parts(self) -> tuple[Part, ...]:
        """All parts besides the leader, in the order in which they are started again."""
        nodes = [Part("node", one.told.name, one.told.process, one.state == "follows") for one in self.nodes]
        others = [Part(one.kind, one.name, one.process, one.state in WORKING) for one in self.members]
        return tuple(sorted((*nodes, *others), key=lambda part: (ORDER_OF_KINDS.index(part.kind), part.name)))

    @property
    def works(self) -> bool:
        """Whether all parts do what they are there for."""
        return all(part.works for part in self.parts)


class Operator:
    """Asks the leaders that a bus reaches. Thread: one."""

    def __init__(self, bus: SignedBus) -> None:
        self._bus = bus
        self._leaders: dict[str, Pulse] = {}
        self._heard = threading.Event()
        bus.receive(messages.PULSE, self._hear)

    def _hear(self, data: bytes) -> None:
        try:
            pulse = messages.decode(data, Pulse)
        except PacketError:
            return
        self._leaders[pulse.leader] = pulse
        self._heard.set()

    def leader(self) -> str:
        """Return the leader with the highest epoch; PersonError if none is heard."""
        if not self._heard.wait(ANSWERS_WITHIN):
            raise PersonError(
                "no leader with nodes is heard",
                "is it started with --nodes, is its address right, and are the machines paired (live pair --list)?",
            )
        time.sleep(2 * LOOK_EVERY)  # for others
        return max(self._leaders.values(), key=lambda pulse: (pulse.epoch, pulse.leader)).leader

    def status(self, leader: str) -> SeenCluster:
        """Return what a leader knows; PersonError if it does not answer."""
        try:
            told = messages.decode(self._ask(leader, messages.STATUS, b""), ClusterStatus)
            nodes = [messages.decode(each, NodeState) for each in told.nodes]
            members = [messages.decode(each, Member) for each in told.members]
        except PacketError as error:
            raise PersonError(
                f"{leader} sends what is no status: {error}", "install the same version on both"
            ) from None
        known = tuple(one for one in members if one.kind in ORDER_OF_KINDS)
        return SeenCluster(told, tuple(map(SeenNode, nodes, told.ages)), known)

    def _ask(self, leader: str, what: str, data: bytes) -> bytes:
        """Return a leader's answer; PersonError if it does not answer."""
        answers: list[bytes] = []
        came = threading.Event()

        def hear(data: bytes) -> None:
            answers.append(data)
            came.set()

        self._bus.ask(messages.question_key(leader, what), data, hear, timeout=ANSWERS_WITHIN)
        if not came.wait(ANSWERS_WITHIN):
            raise PersonError(f"{leader} does not answer", "look at the machine that leads")
        return answers[0]

    def restart(
        self, leader: str, names: list[str], sleep: Callable[[float], None] = time.sleep
    ) -> Iterator[Part]:  # fmt: skip
        """Start parts again, one after another, each once the one before works again; yield each that is back.

        `names`: of nodes, gateways, standby machines, or `reducer`; several of one name are started in turn; none: all.
        PersonError for one that is not known, or does not come back: the others are left as they are then.
        """
        seen = self.status(leader)
        parts = [part for part in seen.parts if part.works or part.name in names]
        if names:
            for name in names:
                if name in (leader, seen.status.leader):
                    raise PersonError(
                        "the leader is not started again: the show would stop",
                        "/dance/takeover at a machine that stands by, then start this one again as its standby",
                    )
                if not any(name in (part.name, f"{part.name} {part.process}") for part in parts):
                    there = ", ".join(sorted({part.name for part in parts})) or "none"
                    raise PersonError(f"there is no {name!r} in this show; parts: {there}", "live cluster status")
            parts = [
                part for name in names for part in parts if name in (part.name, f"{part.name} {part.process}")
            ]  # fmt: skip
        for part in dict.fromkeys(parts):
            before = {
                one.process for one in self.status(leader).parts if (one.kind, one.name) == (part.kind, part.name)
            }
            if part.process not in before:
                continue  # it has gone meanwhile, or has started again by itself
            order = Order(part.name, part.kind, part.process)
            self._ask(leader, messages.COMMAND, messages.encode(order))
            for _ in range(int(BACK_WITHIN / LOOK_EVERY)):
                sleep(LOOK_EVERY)
                if any(
                    (one.kind, one.name) == (part.kind, part.name) and one.works and one.process not in before
                    for one in self.status(leader).parts
                ):
                    break
            else:
                raise PersonError(
                    f"{part.kind} {part.name} has not come back within {BACK_WITHIN:.0f} s", "look at that machine"
                )
            yield part
