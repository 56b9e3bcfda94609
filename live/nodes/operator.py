"""What an operator asks of a cluster: how its nodes are, and to start some of them again, one after another."""

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError
from live.control.message_codec import PacketError
from live.nodes import messages
from live.nodes.messages import ClusterStatus, NodeState, Order, Pulse
from live.nodes.signed_bus import SignedBus

ANSWERS_WITHIN: Final = 3.0
"""Seconds in which a leader is heard, and in which it answers."""
BACK_WITHIN: Final = 60.0
"""Seconds in which a node that was started again follows."""
LOOK_EVERY: Final = 0.25


@dataclass(frozen=True, slots=True)
class SeenNode:
    """A node as its leader knows it."""

    told: NodeState
    age: float
    """Seconds since it was heard."""


@dataclass(frozen=True, slots=True)
class SeenCluster:
    """A leader and its nodes."""

    status: ClusterStatus
    nodes: tuple[SeenNode, ...]


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
        except PacketError as error:
            raise PersonError(
                f"{leader} sends what is no status: {error}", "install the same version on both"
            ) from None
        return SeenCluster(told, tuple(map(SeenNode, nodes, told.ages)))

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

    def restart(self, leader: str, names: list[str], sleep: Callable[[float], None] = time.sleep) -> Iterator[str]:
        """Start nodes again, one after another, each once the one before follows; yield the name of each that is back.

        PersonError for a node that is not known, or does not come back: the others are left as they are then.
        """
        known = {seen.told.name: seen.told for seen in self.status(leader).nodes}
        for name in names:
            if name not in known:
                there = ", ".join(sorted(known)) or "none"
                raise PersonError(f"there is no node {name!r}; nodes: {there}", "live cluster status")
        for name in names:
            self._ask(leader, messages.COMMAND, messages.encode(Order(name)))
            for _ in range(int(BACK_WITHIN / LOOK_EVERY)):
                sleep(LOOK_EVERY)
                found = next((seen.told for seen in self.status(leader).nodes if seen.told.name == name), None)
                if found is not None and found.process != known[name].process and found.state == "follows":
                    break
            else:
                raise PersonError(f"node {name} has not come back within {BACK_WITHIN:.0f} s", "look at that machine")
            yield name
