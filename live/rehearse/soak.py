"""Soak: hours of a show with a made-up band, made-up players and faults, in virtual time; nothing may go wrong.

The show is what `live play` runs: engine, inbox, journal with snapshots, watch of the patch's files. Only the clock is
moved by hand, and frames are drawn nowhere.
"""

import gc
import json
import time as _time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import numpy as np
import psutil

from live.base.fault_isolation import FAULTS
from live.base.inbox import Inbox
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard
from live.control.registry.registry import REGISTRY
from live.rehearse.band import FakeBand
from live.rehearse.edits import Edits
from live.rehearse.failure import Failure
from live.rehearse.faults import Fault, faults
from live.rehearse.mishaps import Mishaps
from live.rehearse.players import Call, FakePlayers
from live.rehearse.soak_report import Plan, Report
from live.rehearse.watching import Watching
from live.rehearse.words import Words
from live.show.engine import Engine
from live.show.journal.journal import JournalSink
from live.show.load import LoadedShow, load_show
from live.show.patch.hot_reload import PatchWatch
from live.show.status import Status

SALT: Final = 0x50AC
MEMORY_EVERY: Final = 60.0
"""Seconds of the show from one look at memory to the next."""


class Soak:
    """One run."""

    def __init__(self, plan: Plan, folder: Path, *, sink: JournalSink | None = None) -> None:
        """`folder`: where the copy of the patch and the journal go; `sink`: who writes the journal there. PersonError
        for a patch that does not start."""
        self.plan = plan
        self._chance = np.random.default_rng([plan.seed, SALT])
        self.edits = Edits(plan.patch, folder / "patch", plan.seed)
        self.loaded: LoadedShow = load_show(self.edits.path)
        self.show = self.loaded.start(seed=plan.seed)
        self.clock, self.inbox = ManualClock(), Inbox[ControlEvent]()
        process = psutil.Process()
        self._memory: Callable[[], float] = lambda: float(process.memory_info().rss / 1e6)
        self.report = Report(plan)
        self._rejected: dict[str, int] = self.report.refused
        self.status = Status(self.show, rejected=lambda: self._rejected, memory=self._memory)  # type: ignore[arg-type,return-value]
        self.journal_path = folder / "journal.jsonl"
        header = self.loaded.header(self.show, tempo=None)
        self.journal = Watching(self.journal_path, header, sink=sink)
        self.journal.prepare(self.show)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=self.status, journal=self.journal)
        self.watch = PatchWatch(self.loaded, self.show, post=self.inbox.put, now=self.clock.now)
        self.status.more["journal"] = self.journal.facts
        self.status.more["patch"] = self.watch.facts
        patch = self.show.patch
        words = Words(patch, self.loaded.graph.library.steps)
        beats = patch.clock.beats_per_measure
        self.band = FakeBand(plan.seed, bpm=patch.clock.bpm, beats_per_measure=beats)
        self.players = FakePlayers(plan.seed, words, count=plan.players, rate=plan.calls)
        self._heard = self.band.events()
        self._calls: Iterator[Call] = self.players.calls()
        self._faults: Iterator[Fault] = faults(plan.seed, rate=plan.faults)
        self._next_heard = next(self._heard)
        self._next_call = next(self._calls, None)
        self._next_fault = next(self._faults, None)
        self.mishaps = Mishaps(
            put=self.inbox.put, call=self.call, refuse=self._refuse, calls=self._calls, edits=self.edits,
            band=self.band, beats_per_measure=beats, chance=self._chance,
        )  # fmt: skip
        self._look = 0.0
        self._failed_before = dict(FAULTS.counts)
        self.between: Callable[[], None] = lambda: None
        """Done before each frame."""
        self.until: Callable[[], bool] = lambda: False
        """Whether the run may end before its time."""
        self.failure: Failure | None = None
        """What ended the run before its time."""

    def run(self, tell: Callable[[float, Report], None] | None = None) -> Report:
        """Run it all; `tell` hears of it once a minute of the show. An exception is noted, and ends the run;
        the report holds what was found whatever ends it, Ctrl-C too."""
        report, begin, end = self.report, _time.perf_counter(), self.plan.hours * 3600.0
        gc.collect()
        gc.freeze()
        gc.disable()
        told = 0.0
        try:
            while self.clock.now() < end and not self.until():
                self.between()
                self._frame()
                if self.clock.now() >= told:
                    told += MEMORY_EVERY
                    self._measure_memory()
                    report.took = _time.perf_counter() - begin
                    if tell is not None:
                        tell(self.clock.now(), report)
        except Exception as error:
            self.failure = Failure.of(error, self.engine.ticks.index)
        finally:
            gc.enable()
            gc.unfreeze()
            self.journal.close(self.engine.ticks.index)
            report.took = _time.perf_counter() - begin
            self._sum_up()
        return report

    def _sum_up(self) -> None:
        report = self.report
        report.seconds = self.clock.now()
        report.measures, report.leapt = self.journal.lines, self.journal.leapt
        report.frames, report.skipped = self.status.frames, self.engine.ticks.skipped
        report.problems, report.count = list(self.journal.problems), self.journal.count
        if self.failure is not None:
            report.fail(self.failure, "the show ends: ")
        report.faults = self.mishaps.done
        report.events, report.band, report.edits = self.journal.told, self.band.did, self.edits.saved
        report.journal = {**self.journal.facts(), "bytes_an_hour": self._bytes_an_hour()}
        for words in FAULTS.since(self._failed_before):
            report.count += 1
            report.problems.append(words)
        if report.journal["dropped"]:
            report.count += 1
            report.problems.append(f"{report.journal['dropped']} lines of the journal were dropped")
        if report.journal.get("snapshots_failed"):
            report.count += 1
            report.problems.append(f"{report.journal['snapshots_failed']} snapshots could not be taken")

    def _bytes_an_hour(self) -> float:
        hours = self.clock.now() / 3600.0
        return self.journal_path.stat().st_size / hours if hours else 0.0

    def _measure_memory(self) -> None:
        now = self.clock.now()
        self.report.memory.append((now, round(self._memory(), 1)))
        self.report.objects.append((now, len(gc.get_objects())))

    def _frame(self) -> None:
        """One frame, and all that arrives before it."""
        now = self.clock.now() + float(self._chance.uniform(0.5, 1.5)) / self.plan.fps + self.mishaps.stands_for
        self.mishaps.stands_for = 0.0
        while self._next_heard.time <= now:
            self._hear(self._next_heard)
            self._next_heard = next(self._heard)
        while self._next_call is not None and self._next_call.time <= now:
            self.call(self._next_call)
            self._next_call = next(self._calls, None)
        while self._next_fault is not None and self._next_fault.time <= now:
            self.mishaps.do(self._next_fault)
            self._next_fault = next(self._faults, None)
        if now >= self._look:
            self._look = now + 0.1
            self.watch.look()
            self.watch.tidy()
        self.clock.set(now)
        self.engine.frame(lambda view: self.journal.look(view, self.engine.ticks.index))
        gc.collect(0)
        self._say(now)

    def _say(self, now: float) -> None:
        """The status must always be plain JSON."""
        if self.status.frames % round(self.plan.fps):
            return
        self.report.status = self.status.snapshot(now)
        try:
            json.dumps(self.report.status, allow_nan=False)
        except ValueError as error:
            self.journal.add(f"tick {self.engine.ticks.index}: the status is no JSON: {error}")

    def _hear(self, event: ControlEvent) -> None:
        if event.time < self.mishaps.deaf_until and isinstance(event, (BeatHeard, MusicHeard)):
            return
        self.inbox.put(event)

    def call(self, call: Call) -> None:
        """What a player sends."""
        event = REGISTRY.call(call.address, call.values, call.time, call.source)
        if isinstance(event, ControlEvent):
            self.inbox.put(event)
        else:
            self._refuse(type(event).__name__)

    def _refuse(self, reason: str) -> None:
        self._rejected[reason] = self._rejected.get(reason, 0) + 1
