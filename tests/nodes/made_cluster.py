"""A leader and its nodes in one process: a bus of queues with delays and losses, on a clock that the test sets."""

import base64
import heapq
import json
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from live.base.jit import KERNEL_SET
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events.events import ControlEvent
from live.nodes.bus import End, Question, Receive, nothing
from live.nodes.coming_show import Aside
from live.nodes.follower import NodeFollower, NodeIdentity, Presentation
from live.nodes.leader import NodeLeader
from live.nodes.signed_bus import SignedBus
from live.show.journal.journal import event_line
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import snapshot
from live.supervisor.network.identity import Identity, Pairings, load_identity
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.supervisor_config import Report
from tests.show.made_show import GRAPH, PATCH

ORIGIN = 5.0
"""The show begins then, on the leader's clock [s]."""
AHEAD = 0.08
STEP = 0.004
"""Seconds from one turn of everything to the next."""


def made_loaded(patch: str = PATCH) -> LoadedShow:
    """The small show of the tests."""
    return LoadedShow(Path("test.toml"), parse_patch(patch, "test.toml"), GRAPH)


class MadeNetwork:
    """Delivers what the buses send, later. A place in `cut` is cut off from the leaders."""

    def __init__(self, clock: ManualClock, *, jitter: float = 0.0, loss: float = 0.0) -> None:
        self.clock, self._jitter, self._loss = clock, jitter, loss
        self._random = random.Random(4)
        self._queue: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        self._last: dict[tuple[str, str], float] = {}
        self.cut: set[str] = set()
        self.receivers: list[tuple[str, str, Receive]] = []
        self.servers: dict[str, tuple[str, Callable[[Question], None]]] = {}

    def post(self, source: str, target: str, act: Callable[[], None], *, lossy: bool = True) -> bool:
        """Deliver after a delay, in order between two places, unless it is lost or one of them is cut off."""
        if source != target and ({source, target} & self.cut):
            return False
        if lossy and self._random.random() < self._loss:
            return False
        at = self.clock.now() + 0.001 + self._random.random() * self._jitter
        at = self._last[source, target] = max(at, self._last.get((source, target), 0.0))
        self._count += 1
        heapq.heappush(self._queue, (at, self._count, act))
        return True

    def deliver(self) -> None:
        """Deliver what is due."""
        while self._queue and self._queue[0][0] <= self.clock.now():
            heapq.heappop(self._queue)[2]()


class MadeBus:
    """One place on that network."""

    def __init__(self, network: MadeNetwork, place: str) -> None:
        self._network, self.place = network, place

    def publish(self, key: str, data: bytes, *, bulk: bool = False) -> None:
        for place, wanted, act in list(self._network.receivers):
            if wanted == key and place != self.place:
                self._network.post(self.place, place, lambda act=act: act(data))

    def receive(self, key: str, act: Receive) -> None:
        self._network.receivers.append((self.place, key, act))

    def serve(self, key: str, act: Callable[[Question], None]) -> None:
        self._network.servers[key] = self.place, act

    def ask(
        self, key: str, data: bytes, act: Receive, *, timeout: float, bulk: bool = False, end: End = nothing
    ) -> None:  # fmt: skip
        if key not in self._network.servers:
            end()
            return
        place, serve = self._network.servers[key]
        question = MadeQuestion(self._network, self.place, place, data, act, end)
        if not self._network.post(self.place, place, lambda: serve(question)):
            end()

    def close(self) -> None:
        self._network.receivers = [each for each in self._network.receivers if each[0] != self.place]


@dataclass
class MadeQuestion:
    network: MadeNetwork
    asker: str
    place: str
    data: bytes
    act: Receive
    end: End = nothing
    arrived: float = 0.0

    def answer(self, data: bytes) -> None:
        def hear() -> None:
            self.act(data)
            self.end()

        if not self.network.post(self.place, self.asker, hear):
            self.end()


class MadeLeader:
    """A show that runs `AHEAD` of its schedule, with the leader's side of the bus."""

    def __init__(
        self, cluster: "MadeCluster", place: str, loaded: LoadedShow, *, epoch: int = 1, header: str | None = None
    ) -> None:  # fmt: skip
        self.cluster, self.loaded, self.place = cluster, loaded, place
        self.said: list[str] = []
        bus = SignedBus(MadeBus(cluster.network, place), cluster.identity, cluster.pairings)
        self.nodes = NodeLeader(bus, self.said.append, ahead=AHEAD, now=cluster.clock.now)
        self.log, self.report = RecoveryLog(), Report()
        self.report.origin, self.report.epoch = ORIGIN, epoch
        self.show = loaded.start(seed=5)
        self.tick, self.hashes = 0, dict[int, str]()
        told = {"journal": 2, "origin": ORIGIN, **loaded.header(self.show, tempo=None), "seed": 5}
        self.line(header or json.dumps(told))
        self.running = True

    def line(self, line: str) -> None:
        self.log.add_line(line)
        self.nodes.add_line(line)

    def apply(self, event: ControlEvent) -> None:
        self.line(event_line(self.tick, event))
        self.show.apply(event)

    def turn(self) -> None:
        while self.running and (self.tick + 1) * TICK <= self.cluster.clock.now() + AHEAD - ORIGIN:
            self.tick += 1
            crossed = self.show.tick(self.tick * TICK)
            if crossed:
                self.hashes[self.tick] = self.show.state_hash()
                number = self.show.span.number + 1
                self.line(json.dumps({"tick": self.tick, "measure": number, "hash": self.hashes[self.tick]}))
                state = base64.b64encode(snapshot(self.show, self.tick)).decode()
                self.line(json.dumps({"tick": self.tick, "snapshot": state}))
            self.line(json.dumps({"tick": self.tick}))
        self.nodes.update(self.log, self.report)


def do_now(task: Callable[[], None]) -> None:
    """Do what a node does in a thread at once, so that a test does not depend on a thread's speed."""
    task()


class MadeNode:
    """A node with a clock of its own."""

    def __init__(
        self, cluster: "MadeCluster", name: str, loaded: LoadedShow, *, offset: float = 0.0, drift: float = 0.0,
        kernels: str = KERNEL_SET, aside: Aside = do_now,
    ) -> None:  # fmt: skip
        self.cluster, self.said, self.place = cluster, list[str](), f"{name}-{len(cluster.nodes)}"
        bus = SignedBus(MadeBus(cluster.network, self.place), cluster.identity, cluster.pairings)
        me = NodeIdentity(name, self.place, kernels)
        self.follower = NodeFollower(
            me, loaded, bus, self.said.append, now=lambda: cluster.clock.now() * (1.0 + drift) + offset, aside=aside
        )
        self.presented: list[tuple[float, Presentation]] = []
        self.first: float | None = None
        cluster.nodes.append(self)

    def turn(self) -> None:
        self.follower.update()
        shown = self.follower.present(0.0)
        if shown is not None:
            self.presented.append((self.cluster.clock.now(), shown))
            self.first = self.first or self.cluster.clock.now()

    def wrong_ticks(self, since: float, tolerance: float = 0.002) -> list[tuple[float, int]]:
        """Frames that did not show the tick of the schedule within the tolerance [s]."""
        return [
            (at, shown.tick) for at, shown in self.presented
            if at >= since
            and not int((at - ORIGIN - tolerance) / TICK) <= shown.tick <= int((at - ORIGIN + tolerance) / TICK)
        ]  # fmt: skip

    def stop(self) -> None:
        self.cluster.nodes.remove(self)
        self.follower._bus.close()

    @property
    def hash(self) -> Any:
        following = self.follower.following
        assert following is not None
        assert following.show is not None
        return following.tick, following.show.state_hash()


@dataclass
class MadeCluster:
    """Everything, and the time."""

    folder: Path
    jitter: float = 0.0
    loss: float = 0.0
    clock: ManualClock = field(default_factory=lambda: ManualClock(ORIGIN))
    leaders: list[MadeLeader] = field(default_factory=list)
    nodes: list[MadeNode] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.network = MadeNetwork(self.clock, jitter=self.jitter, loss=self.loss)
        self.identity: Identity = load_identity(self.folder)
        self.pairings = Pairings(self.folder)

    def lead(self, loaded: LoadedShow, **how: Any) -> MadeLeader:
        self.leaders.append(MadeLeader(self, f"leader-{len(self.leaders)}", loaded, **how))
        return self.leaders[-1]

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
        """Run for so long, or until something is the case; return how long."""
        begun = self.clock.now()
        while self.clock.now() < begun + seconds and not until():
            self.clock.advance(STEP)
            self.network.deliver()
            for one in (*self.leaders, *list(self.nodes)):
                one.turn()
        return self.clock.now() - begun
