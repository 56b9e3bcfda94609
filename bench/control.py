"""OSC under floods: what is lost, what the frame notices, and how long a message takes to the simulation; what
captured performers cost, and MIDI clock with jitter.

A show of 24 dancers runs at 60 frames/s without drawing, in turns undisturbed and flooded, in one run; the senders are
processes of their own and share the machine's cores.
"""

import gc
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
import psutil

from bench import _midi_jitter
from bench._audience import audience_rows
from bench._mocap import mocap_rows
from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent, Signal
from live.control.osc.osc_codec import encode
from live.control.osc.osc_process import OscRemote
from live.control.osc.osc_server import OscInput
from live.render.timing.frame_stats import Pacer
from live.show.engine import Engine
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.view.status import Status

FPS: Final = 60.0
VALUES_PER_SECOND: Final = 40_000
GARBAGE_PER_SECOND: Final = 100_000
OPERATOR_PER_SECOND: Final = 50
WITHIN: Final = 0.050
WARM: Final = 3.0


@dataclass(slots=True)
class Phase:
    """What was measured in a stretch of the show."""

    work: list[float] = field(default_factory=list)
    """CPU time of the frames [s]."""
    behind: list[float] = field(default_factory=list)
    """How far the last tick of a frame lay behind what the picture shows [s]."""
    ways: list[float] = field(default_factory=list)
    """From an operator's sending to the show [s]."""
    sent: int = 0
    asked: int = 0
    received: int = 0
    lost: int = 0
    skipped: int = 0
    receiver: float = 0.0
    """Share of a core that the receiving process took."""


class Stage:
    """A show with an OSC port, driven frame by frame; OSC is received by a process of its own, which is what a show
    with a supervisor does that is not told otherwise, or by a thread of the show's."""

    def __init__(self, *, own_process: bool) -> None:
        loaded = load_show(DEFAULT_PATCH)
        self.show = loaded.start()
        self.clock = SystemClock()
        inbox: EventQueue[ControlEvent] = EventQueue()
        self.osc: OscInput | OscRemote = (
            OscRemote("127.0.0.1", 0, inbox.add_queue(), self.clock)
            if own_process
            else OscInput("127.0.0.1", 0, inbox.add_queue(), self.clock, make_lane=inbox.add_queue)
        )
        self.status = Status(self.show, rejected=lambda: Counter(self.osc.refused()), memory=lambda: 0.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=inbox, status=self.status)
        self.engine.refuse_failing = True
        self.engine.event_listeners.append(self._hear)
        self._ways: list[float] = []
        self.operated = 0

    @property
    def received(self) -> int:
        """Datagrams that were read, a quarter of a second ago."""
        return int(self.osc.status().get("received", 0))

    def _cpu(self) -> float:
        """CPU time that the receiving process, or thread, has taken [s]."""
        if isinstance(self.osc, OscRemote):
            times = psutil.Process(self.osc.pid).cpu_times()
            return float(times.user + times.system)
        threads = {one.native_id for one in threading.enumerate() if one.name == "osc"}
        return float(sum(t.user_time + t.system_time for t in psutil.Process().threads() if t.id in threads))

    def _hear(self, event: ControlEvent) -> None:
        if isinstance(event, Signal):
            self._ways.append(time.perf_counter() - float(event.name))

    def phase(self, seconds: float, *, flood: str = "", rate: float = 0.0) -> Phase:
        """So many seconds of the show, flooded or not, with an operator who sends messages."""
        found, self._ways = Phase(), []
        before = (self.received, self.osc.lost)
        process = None
        if flood:
            words = [sys.executable, "-m", "bench._osc_flood", flood, str(self.osc.port), str(rate), str(seconds + 1.0)]
            process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
            while self.received + self.osc.lost < before[0] + before[1] + 1000:
                self._frame(None)
        skipped = self.status.skipped_ticks  # not those while the sender's process began
        stop = threading.Event()
        operator = threading.Thread(target=self._operate, args=(stop, found))
        operator.start()
        pacer = Pacer(FPS, self.clock.now, time.sleep)
        wall, spent = time.perf_counter(), self._cpu()
        while time.perf_counter() - wall < seconds:
            pacer.wait()
            self._frame(found)
        found.receiver = (self._cpu() - spent) / (time.perf_counter() - wall)
        found.skipped = self.status.skipped_ticks - skipped
        stop.set()
        operator.join()
        if process is not None:
            said, _ = process.communicate()
            found.sent = int(said)
        rest = time.perf_counter()
        while time.perf_counter() - rest < 0.5:
            self._frame(None)
        found.received = self.received - before[0]
        found.lost = self.osc.lost - before[1]
        found.ways = self._ways
        return found

    def _frame(self, found: Phase | None) -> None:
        began = time.thread_time()
        if isinstance(self.osc, OscRemote):
            self.osc.frame()
        self.engine.frame(lambda view: None)
        gc.collect(0)
        if found is None:
            time.sleep(0.01)
            return
        found.work.append(time.thread_time() - began)
        found.behind.append(max(self.clock.now() + TICK - self.engine.ticks.time, 0.0))

    def _operate(self, stop: threading.Event, found: Phase) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            while not stop.wait(1.0 / OPERATOR_PER_SECOND):
                sock.sendto(encode("/dance/signal", (repr(time.perf_counter()),)), ("127.0.0.1", self.osc.port))
                found.asked += 1


def run(full: bool, shared: Path | None) -> list[Row]:
    """OSC in a process of its own, then in the show's; then everybody else who plays."""
    rows = [row for own_process in (True, False) for row in _flooded(20.0 if full else 6.0, own_process)]
    rows += _midi_jitter.rows(full)
    rows += mocap_rows(load_show(DEFAULT_PATCH))
    return rows + audience_rows(full)


def _flooded(seconds: float, own_process: bool) -> list[Row]:
    """Undisturbed, flooded with values, undisturbed, flooded with garbage."""
    stage = Stage(own_process=own_process)
    stage.osc.start()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        stage.phase(WARM)
        quiet = stage.phase(seconds)
        values = stage.phase(seconds, flood="values", rate=VALUES_PER_SECOND)
        again = stage.phase(seconds)
        garbage = stage.phase(seconds, flood="garbage", rate=GARBAGE_PER_SECOND)
        facts = stage.osc.status()
    finally:
        gc.enable()
        gc.unfreeze()
        stage.osc.stop()
    rows = [*_values(quiet, again, values, facts["replaced"]), *_garbage(garbage)]
    where = "" if own_process else "OSC in the show's process, "
    return [replace(row, name=where + row.name) for row in rows]


def _p99(row: list[float]) -> float:
    return float(np.percentile(row, 99)) * 1e3


def _values(quiet: Phase, again: Phase, flood: Phase, replaced: int) -> list[Row]:
    alone, with_it = _p99(quiet.work + again.work), _p99(flood.work)
    late, late_alone = _p99(flood.behind), _p99(quiet.behind + again.behind)
    seconds = flood.sent / VALUES_PER_SECOND
    return [
        Row("40,000 values/s: lost", 100.0 * flood.lost / max(flood.sent, 1), "%", 1.0,
            peers={"sent/s": flood.sent / seconds if seconds else 0.0, "sent": flood.sent, "replaced": replaced}),
        Row("40,000 values/s: p99 of a frame's CPU time, with the flood over without", with_it / alone, "", 1.25,
            peers={"with [ms]": with_it, "without [ms]": alone}),
        Row("40,000 values/s: p99 of how far ticks lie behind", late, "ms", peers={"without [ms]": late_alone}),
        Row("40,000 values/s: skipped ticks", flood.skipped, "", 0.0, peers={"without": quiet.skipped + again.skipped}),
        Row("40,000 values/s: the receiver's share of a core", flood.receiver, "", peers={"without": quiet.receiver}),
        Row("from an operator's message to the simulation, p99, under 40,000 values/s", _p99(flood.ways), "ms",
            1e3 * (1.0 / FPS + TICK), peers={"median [ms]": float(np.median(flood.ways)) * 1e3,
                                            "p99 undisturbed [ms]": _p99(quiet.ways + again.ways)}),
    ]  # fmt: skip


def _garbage(flood: Phase) -> list[Row]:
    within = 100.0 * sum(way <= WITHIN for way in flood.ways) / max(flood.asked, 1)
    return [
        Row("100,000 rubbish datagrams/s: an operator's messages within 50 ms", within, "%", 99.0, "at least",
            peers={"sent": flood.sent, "lost": flood.lost, "p99 [ms]": _p99(flood.ways)}),
        Row("100,000 rubbish datagrams/s: skipped ticks", flood.skipped, "", 0.0),
        Row("100,000 rubbish datagrams/s: the receiver's share of a core", flood.receiver, ""),
    ]  # fmt: skip
