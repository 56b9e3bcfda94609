"""Gateways that share an audience: whether they do as one would, what reducing costs, and a load on real sockets."""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median
from typing import Any, Final

import numpy as np
import psutil

from live.app.launch_options import LaunchOptions
from live.app.services.gateway_shards import GatewayShards
from live.base.system.channel import hand_over
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.clock.time_source import SystemClock
from live.control.audience.broadcaster import touch_seconds
from live.control.audience.phone_registry import Device
from live.control.audience.session_state import BeatClock, Rules, SessionState
from live.control.audience.stage_lights import STAGE_EVERY
from live.control.audience.voice_report import VoiceReport
from live.control.audience.voice_sketch import UNIT
from live.control.audience.websocket_reader import WebSocketReader
from live.control.helper_process import HelperProcess
from live.control.message_codec import decode_packet, encode_packet
from live.control.shards.messages import (
    PROTOCOL,
    ShardChanges,
    ShardHello,
    ShardOthers,
    ShardPlan,
    ShardShown,
    pack_voices,
)
from live.control.shards.reduction import Reduction, Shard

VOTE: Final = (7, "step", ("sway", "spin", "glide"), 64.0)
RULES: Final = Rules(regions=("left", "right"), weights=(1.0, 0.5), vote=VOTE)
PLAN: Final[dict[str, Any]] = {
    "secret": b"bench" * 7, "first": 1, "link": "http://127.0.0.1", "most": 100_000, "per_address": 8, "visible": 24,
    "network": "own wifi", "proxies": [], "by_card": False, "code_s": 600.0, "grace_s": 120.0,
    "joins_per_code": 100_000, "bans": [], "origin": 0.0, "certificate": None,
}  # fmt: skip
VOICES: Final = 6250
JOINS: Final = 150.0
"""Phones that join per second: those of two thousand in a quarter of a minute."""
FRAME: Final = bytes((6, 0, 24, 0)) + bytes(72)
"""The stage with 24 dancers."""


class _Silent:
    """A connection of a phone that nobody listens to."""

    def abort(self) -> None:
        """Nothing."""

    def write(self, data: bytes) -> None:
        """Nothing."""


class Shards:
    """K gateways and a reducer in this process, on a clock that stands."""

    def __init__(self, count: int, most: int) -> None:
        self.time = 100.0
        self.reduction = Reduction({**PLAN, "most": most * count})
        self.reduction.update_rules(RULES, self.time)
        self.told: list[list[bytes]] = [[] for _ in range(count)]
        self.shards: list[tuple[SessionState, Shard]] = []
        for index, told in enumerate(self.told):
            hello = ShardHello(PROTOCOL, "bench", f"shard {index:02}", most, 0)
            shard = self.reduction.enter(hello, "here", told.append, lambda: None, self.time)
            assert shard is not None
            plan = next(packet for packet in map(decode_packet, told) if isinstance(packet, ShardPlan))
            session = SessionState({**PLAN, "most": plan.most})
            session.now = lambda: self.time  # type: ignore[method-assign]
            session.phones.changed_groups = set()
            session.update_rules(RULES)
            session.reporter.highlights.most = 24
            self.shards.append((session, shard))

    def enter(self, index: int, number: int, group: int, x: float, z: float, mode: int, choice: int) -> None:
        """A phone of gateway `index` touches (x, z) [shares of the stage], and votes."""
        session, _ = self.shards[index]
        phone = session.enter(Device(number, 0, group), number % 2, group, 1, None, _Silent(), fresh=True)
        assert phone is not None
        place = b"".join(round(65535 * value).to_bytes(2, "little") for value in (x, z))
        session.handle_message(phone, bytes((1, mode)) + place, self.time)
        session.handle_message(phone, bytes((3, VOTE[0], choice)), self.time)

    def share(self) -> None:
        """Carry what gateways have to know of each other's phones."""
        for session, shard in self.shards:
            keys = session.phones.changed_groups or set()
            rows = tuple((key, *session.phones.count(key), -1.0) for key in keys)
            for begin in range(0, len(rows), 512):
                changes = ShardChanges(rows[begin : begin + 512])
                self.reduction.handle(shard, encode_packet(changes), self.time)
        from live.control.audience.phone_registry import GroupElsewhere

        for session, shard in self.shards:
            while (others := self.reduction.groups.pop_others(shard.name)) is not None:
                assert isinstance(others, ShardOthers)
                for key, phones, joined, until in others.groups:
                    session.phones.elsewhere[key] = GroupElsewhere(phones, joined, until)
                session.update_shares(*(row[0] for row in others.groups))

    def packets(self) -> list[tuple[Shard, bytes]]:
        """What each gateway tells in a tick; its votes are told at once."""
        found = []
        for session, shard in self.shards:
            report = session.report(self.time)
            self.reduction.handle(shard, encode_packet(ShardShown((), report.votes)), self.time)
            found.append((shard, pack_voices(report)))
        return found

    def reduce(self, packets: list[tuple[Shard, bytes]]) -> VoiceReport:
        """Take the packets, and say what all hear."""
        for shard, packet in packets:
            self.reduction.handle(shard, packet, self.time)
        return self.reduction.report(self.time)


def _people(count: int, seed: int) -> Iterator[tuple[int, int, float, float, int, int, int]]:
    """Number, group, x, z, mode, choice and a chance of each phone."""
    chance = np.random.default_rng(seed)
    centre = chance.uniform(0.1, 0.9, (4, 2))
    for number in range(1, count + 1):
        kind = int(chance.choice(4, p=(0.4, 0.3, 0.2, 0.1)))
        x, z = np.clip(chance.normal(centre[kind], 0.05), 0.0, 1.0)
        group = 5_000_000 + number // 10 if number % 10 < 3 else number
        yield number, group, float(x), float(z), 1 + (kind == 1), int(chance.integers(3)), int(chance.integers(1 << 20))


def agreement_rows() -> list[Row]:
    """Gateways together against one alone; one address on all; a griefer and a liar."""
    reports = {}
    for count in (0, 1, 4, 16):
        hall = Shards(max(count, 1), 4000)
        for number, group, x, z, mode, choice, at in _people(3000, 11):
            hall.enter(at % max(count, 1), number, group, x, z, mode, choice)
        hall.share()
        reports[count] = hall.shards[0][0].report(hall.time) if count == 0 else hall.reduce(hall.packets())
    wanted, rows = reports.pop(0).sketch.force(), []
    votes = {count: report.tally for count, report in reports.items()}
    for count, report in reports.items():
        force = report.sketch.force()
        pairs = list(zip(force.places, wanted.places, strict=True))
        away = max(float(np.hypot(a.x - b.x, a.z - b.z)) for a, b in pairs)
        weight = max(abs(a.weight / b.weight - 1.0) for a, b in pairs)
        rows += [
            Row(f"{count} gateways against one alone, 3,000 voices: places apart", 100.0 * away, "cm", 5.0),
            Row(f"{count} gateways against one alone: weights apart", 100.0 * weight, "%", 2.0,
                peers={"votes that differ": sum(a != b for a, b in zip(votes[count], votes[1], strict=True))}),
        ]  # fmt: skip
    hall = Shards(16, 400)
    for k in range(32):
        hall.enter(k % 16, k + 1, 100 + k, 0.2, 0.5, 1, 0)
    before = hall.reduce(hall.packets()).sketch.people
    for k in range(64):
        hall.enter(k % 16, 1000 + k, 7, 0.9, 0.5, 1, 0)
    hall.share()
    grown = hall.reduce(hall.packets()).sketch.people - before
    return [*rows, Row("one address with four sockets at each of 16 gateways: its voices", grown / UNIT, "", 1.01)]


def cost_rows() -> list[Row]:
    """What reducing costs, and a gateway's handling of a message without its sockets."""
    hall = Shards(16, VOICES)
    for number, group, x, z, mode, choice, _ in _people(16 * VOICES, 12):
        hall.enter(number % 16, number, group, x, z, mode, choice)
    packets, spent = hall.packets(), []
    for _ in range(100):
        began = time.process_time()
        hall.reduce(packets).sketch.force()
        spent.append(time.process_time() - began)
    making, session = [], hall.shards[0][0]
    for _ in range(20):
        began = time.process_time()
        pack_voices(session.report(hall.time))
        making.append(time.process_time() - began)
    return [
        Row("16 gateways of 6,250 voices reduced to places", 1e3 * median(spent), "ms", 1.5,
            peers={"least of 100": 1e3 * min(spent), "load average": psutil.getloadavg()[0],
                   "a gateway's sketch [ms]": 1e3 * median(making),
                   "bytes of a sketch, most": max(len(packet) for _, packet in packets)}),
        Row("a gateway's handling of a touch, without its socket", 1e6 * _message_cost(session), "us", 17.0),
    ]  # fmt: skip


def _message_cost(session: SessionState) -> float:
    """Processor time of a message from its frame to the voice [s]."""
    import asyncio

    async def spend() -> float:
        phones = list(session.phones.by_number.values())[:2000]
        readers = [WebSocketReader(session, phone, None) for phone in phones]
        mask = b"\x11\x22\x33\x44"
        touch = bytes((0x82, 0x86)) + mask + bytes(b ^ mask[i & 3] for i, b in enumerate(b"\x01\x01\x00\x50\x00\x60"))
        clock = [200.0]
        session.now = lambda: clock[0]  # type: ignore[method-assign]
        session.due = np.inf
        began = time.process_time()
        for _ in range(10):
            clock[0] += 0.5
            session.report(clock[0])
            for reader in readers:
                reader.data_received(touch)
        return (time.process_time() - began) / (10 * len(readers))

    return asyncio.run(spend())


# -- real sockets ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Load:
    """What a load of phones took, while they played."""

    phones: int
    joined: int
    rate: float
    """Messages per second of all phones."""
    gateways: float
    """Cores that all gateways took."""
    reducer: float
    """Cores that the reducer took; 0 for a gateway that is alone."""
    memory: float
    """Of the largest gateway [MB]."""
    frames: float
    """Frames of the stage per second of each phone."""
    frame_bytes: float
    trips: tuple[float, float]
    """A ping there and back, median and 99th percentile [ms]."""
    waits: tuple[float, float]
    """A message's wait for the tick, median and 99th percentile [ms]."""
    late: float
    """How late ticks were, 99th percentile [ms]."""
    phones_cpu: float
    lost: int


class BareHall:
    """Gateways as a show starts them, and the show's end of their channel without a show."""

    def __init__(self, gateways: int, most: int, *, stage: bool) -> None:
        """0: one gateway alone. `stage`: whether phones are sent the stage."""
        self.clock, self.link = SystemClock(), ""
        self._folder = tempfile.TemporaryDirectory()
        os.environ["LIVE_CONFIG_DIR"] = self._folder.name
        options = LaunchOptions(audience=("127.0.0.1", 0), gateways=gateways or 1, gateways_listen=("127.0.0.1", 0))
        self.shards = GatewayShards(options, most, self.clock, resumes=False)
        self.port = self.shards.port
        alone = gateways == 0
        sock = self.shards._sockets[0] if alone else self.shards.reducer_socket
        http, inherit = hand_over(sock)
        plan = {**PLAN, "http": http, "most": most, **self.shards.keys}
        module = "live.control.audience.gateway" if alone else "live.control.shards.reducer"
        self.helper = HelperProcess(module, self.clock, plan, self._tell, *inherit, on_packet=self._hear)
        self.helper.start()
        if not alone:
            self.shards.start(None)
        self._stage_at, self._beat_at = 0.0 if stage else np.inf, 0.0

    def _tell(self) -> None:
        self.helper.send(Rules(half=(6.0, 4.0)))

    def _hear(self, packet: tuple[Any, ...]) -> None:
        if packet[0] == "code":
            self.link = packet[1]

    def frame(self) -> None:
        """What a show does in a frame."""
        now = self.clock.now()
        self.helper.frame()
        self.shards.frame()
        if now >= self._stage_at:
            self._stage_at = now + STAGE_EVERY
            self.helper.send(("stage", FRAME, ("#ffffff",)))
        if now >= self._beat_at:
            self._beat_at = now + 1.0
            self.helper.send(BeatClock(now, 2.0 * now))
        time.sleep(TICK)

    def ready(self, gateways: int) -> None:
        """Wait until phones can come."""
        while not self.link or len(self.helper.status().get("gateways", ())) < gateways:
            self.frame()

    def pids(self) -> list[int]:
        """Of the gateways."""
        found = self.shards.pids or [self.helper.pid]
        return [pid for pid in found if pid is not None]

    def stop(self) -> None:
        """End all."""
        self.helper.stop()
        self.shards.stop()
        self._folder.cleanup()


def real_load(gateways: int, phones: int, seconds: float, rate: float | None = None, *, stage: bool = True) -> Load:
    """Load gateways (0: one alone, without a reducer) with phones on real sockets at the told rate, or another one."""
    hall = BareHall(gateways, max(phones + 200, 1000), stage=stage)
    try:
        hall.ready(gateways)
        rate = rate or 1.0 / touch_seconds(phones)
        words = [hall.port, hall.link.partition("#")[2], phones, max(phones / JOINS, 1.0), seconds, rate, 1, 0, 0.6]
        process = subprocess.Popen(
            [sys.executable, "-m", "bench._phones", *map(str, words)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        lines: list[str] = []
        reader = threading.Thread(target=lambda out: lines.extend(iter(out.readline, "")), args=(process.stdout,))
        reader.start()
        while not lines and process.poll() is None:
            hall.frame()
        before, began = _cores(hall), time.perf_counter()
        spent, memory, waits = before, [0.0], []
        while process.poll() is None and time.perf_counter() - began < seconds:
            hall.frame()
            spent = _cores(hall)
            if time.perf_counter() - began > 0.7 * seconds:
                facts = hall.helper.status()
                waits.append((*facts.get("ways_ms", (0.0, 0.0)), facts.get("late_ms", (0.0, 0.0))[-1]))
        took = time.perf_counter() - began
        with contextlib.suppress(psutil.Error):
            memory = [psutil.Process(pid).memory_info().rss / 1e6 for pid in hall.pids()]
        while process.poll() is None:
            hall.frame()
        reader.join()
        told = json.loads(lines[-1])
        middle, wait, late = (float(value) for value in np.median(waits or [(0.0, 0.0, 0.0)], axis=0))
        return Load(
            phones=phones, joined=told["joined"], rate=told["rate"], gateways=(spent[0] - before[0]) / took,
            reducer=(spent[1] - before[1]) / took, memory=max(memory), frames=told["frames"],
            frame_bytes=told["frame_bytes"], trips=(told["trip_p50_ms"], told["trip_p99_ms"]), waits=(middle, wait),
            late=late, phones_cpu=told["cpu"], lost=told["lost"],
        )  # fmt: skip
    finally:
        hall.stop()


def _cores(hall: BareHall) -> tuple[float, float]:
    """Processor time of the gateways, and of the reducer [s]."""
    found = []
    for pids in (hall.pids(), [hall.helper.pid] if hall.shards.pids else []):
        total = 0.0
        for pid in pids:
            with contextlib.suppress(psutil.Error):
                times = psutil.Process(pid).cpu_times()
                total += times.user + times.system
        found.append(total)
    return found[0], found[1]


def socket_rows(full: bool) -> list[Row]:
    """A gateway with as many phones as may be, on real sockets; 10,000 take a minute."""
    count = 10_000 if full else 2000
    load = real_load(1, count, 15.0 if full else 5.0)
    per_message = 1e6 * load.gateways / max(load.rate, 1.0)
    return [
        Row(f"{count:,} sockets at one gateway: held", load.joined - load.lost, "", count, "at least",
            peers={"messages/s": load.rate, "cores": load.gateways, "memory [MB]": load.memory,
                   "frames of the stage [1/s]": load.frames, "load average": psutil.getloadavg()[0]}),
        Row("a gateway's processor time for each message, with all it sends", per_message, "us",
            peers={"a ping there and back, median [ms]": load.trips[0], "p99 [ms]": load.trips[1],
                   "waits for the tick, p99 [ms]": load.waits[1], "ticks late, p99 [ms]": load.late}),
    ]  # fmt: skip


def shard_rows(full: bool) -> list[Row]:
    """All rows of gateways that share an audience."""
    return [*agreement_rows(), *cost_rows(), *socket_rows(full)]
