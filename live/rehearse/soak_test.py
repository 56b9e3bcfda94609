"""Soak test: hours of a show with simulated band, simulated players and injected faults, in virtual time.

The show is the same as in `live play`: engine, event queue, journal with snapshots, hot reload of the patch. Only the
clock is manual, and frames are not drawn.
"""

import gc
import json
import time as _time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import psutil

from live.base.event_queue import EventQueue
from live.base.fault_isolation import FAULTS
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard
from live.control.registry.registry import REGISTRY
from live.rehearse.failure import Failure
from live.rehearse.fault_injection import Fault, FaultInjector, PatchEditor, fault_schedule
from live.rehearse.invariants import CheckingJournalWriter
from live.rehearse.simulated_band import SimulatedBand
from live.rehearse.simulated_players import ArgumentGenerator, Call, SimulatedPlayers
from live.show.engine import Engine
from live.show.journal.journal import JournalSink
from live.show.loader import LoadedShow, load_show
from live.show.patch.hot_reload import PatchWatch
from live.show.view.status import Status

GROWTH_MB: Final = 20.0
"""Maximum change of memory after the first hour (or the first third of a shorter run)."""


@dataclass(frozen=True, slots=True)
class SoakOptions:
    """The options of a run."""

    patch: Path
    seed: int = 0
    hours: float = 1.0
    fps: float = 16.0
    """Mean frame rate of the show."""
    players: int = 8
    calls: float = 6.0
    """Calls of each player per minute."""
    faults: float = 1.0
    """Rate of faults; 1: about one per minute."""


@dataclass(slots=True)
class SoakReport:
    """The result of a run."""

    plan: SoakOptions
    seconds: float = 0.0
    """Duration in show time."""
    took: float = 0.0
    """Duration in real time [s]."""
    measures: int = 0
    leapt: int = 0
    frames: int = 0
    skipped: int = 0
    problems: list[str] = field(default_factory=list)
    count: int = 0
    """Total number of problems."""
    events: dict[str, int] = field(default_factory=dict)
    refused: dict[str, int] = field(default_factory=dict)
    faults: dict[str, int] = field(default_factory=dict)
    band: dict[str, int] = field(default_factory=dict)
    edits: dict[str, int] = field(default_factory=dict)
    frames_ms: list[dict[str, float]] = field(default_factory=list)
    """For runs in real time: CPU time of frames [ms], late frames and memory, each row for some seconds."""
    memory: list[tuple[float, float]] = field(default_factory=list)
    """Show time [s], resident memory [MB]."""
    objects: list[tuple[float, int]] = field(default_factory=list)
    journal: dict[str, Any] = field(default_factory=dict)
    failures: list[dict[str, Any]] = field(default_factory=list)
    """Exceptions with place and traceback (`Failure.facts`)."""
    replay: dict[str, Any] = field(default_factory=dict)
    status: dict[str, Any] = field(default_factory=dict)
    """The last status of the show."""

    def record_failure(self, failure: Failure, what: str = "") -> None:
        """Record an exception: one line in `problems`, all of it in `failures`."""
        self.count += 1
        self.problems.append(f"{what}{failure}")
        self.failures.append(failure.facts())

    @property
    def growth(self) -> float | None:
        """The largest change of memory [MB] after the first hour, or the first third of a shorter run."""
        begin = min(3600.0, self.seconds / 3.0)
        later = [size for time, size in self.memory if time >= begin]
        return max(abs(size - later[0]) for size in later) if later else None

    @property
    def ok(self) -> bool:
        """Whether there were no problems."""
        grown = self.growth
        different = self.replay.get("different", 0) or self.replay.get("problems")
        return not self.count and not different and (grown is None or grown <= GROWTH_MB)

    def as_json(self) -> dict[str, Any]:
        """Return the report for `--report`."""
        plan = {"patch": str(self.plan.patch), "seed": self.plan.seed, "hours": self.plan.hours, "fps": self.plan.fps}
        facts = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "plan"}
        speed = self.seconds / self.took if self.took else None
        return {"ok": self.ok, **plan, "speed": speed, "memory_growth_mb": self.growth, **facts}


SALT: Final = 0x50AC
MEMORY_INTERVAL: Final = 60.0
"""Interval of memory measurements [s of the show]."""


class SoakTest:
    """One soak test run."""

    def __init__(self, plan: SoakOptions, folder: Path, *, sink: JournalSink | None = None) -> None:
        """`folder`: for the copy of the patch and the journal; `sink`: writer of the journal. Raises PersonError for a
        patch that does not start."""
        self.plan = plan
        self._rng = np.random.default_rng([plan.seed, SALT])
        self.edits = PatchEditor(plan.patch, folder / "patch", plan.seed)
        self.loaded: LoadedShow = load_show(self.edits.path)
        self.show = self.loaded.start(seed=plan.seed)
        self.clock, self.inbox = ManualClock(), EventQueue[ControlEvent]()
        process = psutil.Process()
        self._memory: Callable[[], float] = lambda: float(process.memory_info().rss / 1e6)
        self.report = SoakReport(plan)
        self._rejected: dict[str, int] = self.report.refused
        self.status = Status(self.show, rejected=lambda: self._rejected, memory=self._memory)  # type: ignore[arg-type,return-value]
        self.journal_path = folder / "journal.jsonl"
        header = self.loaded.header(self.show, tempo=None)
        self.journal = CheckingJournalWriter(self.journal_path, header, sink=sink)
        self.journal.prepare(self.show)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=self.status, journal=self.journal)
        self.patch_watch = PatchWatch(self.loaded, self.show, post=self.inbox.put, now=self.clock.now)
        self.status.extra_figures["journal"] = self.journal.facts
        self.status.extra_figures["patch"] = self.patch_watch.status
        patch = self.show.patch
        words = ArgumentGenerator(patch, self.loaded.graph.library.steps)
        beats = patch.clock.beats_per_measure
        self.band = SimulatedBand(plan.seed, bpm=patch.clock.bpm, beats_per_measure=beats)
        self.players = SimulatedPlayers(plan.seed, words, count=plan.players, rate=plan.calls)
        self._band_events = self.band.events()
        self._calls: Iterator[Call] = self.players.calls()
        self._faults: Iterator[Fault] = fault_schedule(plan.seed, rate=plan.faults)
        self._next_band_event = next(self._band_events)
        self._next_call = next(self._calls, None)
        self._next_fault = next(self._faults, None)
        self.fault_injector = FaultInjector(
            put=self.inbox.put, call=self.call, refuse=self._count_rejection, calls=self._calls, edits=self.edits,
            band=self.band, beats_per_measure=beats, chance=self._rng,
        )  # fmt: skip
        self._next_patch_check = 0.0
        self._fault_counts_before = dict(FAULTS.counts)
        self.before_frame: Callable[[], None] = lambda: None
        """Called before each frame."""
        self.should_stop: Callable[[], bool] = lambda: False
        """Returns True to end the run early."""
        self.failure: Failure | None = None
        """The failure that ended the run early."""

    def run(self, on_progress: Callable[[float, SoakReport], None] | None = None) -> SoakReport:
        """Run the whole test; `on_progress` is called once a minute of show time. An exception is recorded and ends it.
        The report is completed however the run ends, also by Ctrl-C."""
        report, begin, end = self.report, _time.perf_counter(), self.plan.hours * 3600.0
        gc.collect()
        gc.freeze()
        gc.disable()
        told = 0.0
        try:
            while self.clock.now() < end and not self.should_stop():
                self.before_frame()
                self._frame()
                if self.clock.now() >= told:
                    told += MEMORY_INTERVAL
                    self._measure_memory()
                    report.took = _time.perf_counter() - begin
                    if on_progress is not None:
                        on_progress(self.clock.now(), report)
        except Exception as error:
            self.failure = Failure.from_exception(error, self.engine.ticks.index)
        finally:
            gc.enable()
            gc.unfreeze()
            self.journal.close(self.engine.ticks.index)
            report.took = _time.perf_counter() - begin
            self._complete_report()
        return report

    def _complete_report(self) -> None:
        report = self.report
        report.seconds = self.clock.now()
        report.measures, report.leapt = self.journal.measure_count, self.journal.skipped_measures
        report.frames, report.skipped = self.status.frames, self.engine.ticks.skipped
        report.problems, report.count = list(self.journal.problems), self.journal.problem_count
        if self.failure is not None:
            report.record_failure(self.failure, "the show ends: ")
        report.faults = self.fault_injector.counts
        report.events, report.band, report.edits = self.journal.event_counts, self.band.counts, self.edits.edit_counts
        report.journal = {**self.journal.facts(), "bytes_an_hour": self._bytes_an_hour()}
        for words in FAULTS.failures_since(self._fault_counts_before):
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
        """Deliver all inputs that are due, then run one frame."""
        now = self.clock.now() + float(self._rng.uniform(0.5, 1.5)) / self.plan.fps + self.fault_injector.stall_seconds
        self.fault_injector.stall_seconds = 0.0
        while self._next_band_event.time <= now:
            self._deliver(self._next_band_event)
            self._next_band_event = next(self._band_events)
        while self._next_call is not None and self._next_call.time <= now:
            self.call(self._next_call)
            self._next_call = next(self._calls, None)
        while self._next_fault is not None and self._next_fault.time <= now:
            self.fault_injector.execute(self._next_fault)
            self._next_fault = next(self._faults, None)
        if now >= self._next_patch_check:
            self._next_patch_check = now + 0.1
            self.patch_watch.poll()
            self.patch_watch.free_replaced()
        self.clock.set(now)
        self.engine.frame(lambda view: self.journal.check_view(view, self.engine.ticks.index))
        gc.collect(0)
        self._check_status(now)

    def _check_status(self, now: float) -> None:
        """Check once a second that the status is valid JSON."""
        if self.status.frames % round(self.plan.fps):
            return
        self.report.status = self.status.snapshot(now)
        try:
            json.dumps(self.report.status, allow_nan=False)
        except ValueError as error:
            self.journal.add_problem(f"tick {self.engine.ticks.index}: the status is not valid JSON: {error}")

    def _deliver(self, event: ControlEvent) -> None:
        if event.time < self.fault_injector.deaf_until and isinstance(event, (BeatHeard, MusicHeard)):
            return
        self.inbox.put(event)

    def call(self, call: Call) -> None:
        """Deliver a call of a player."""
        event = REGISTRY.call(call.address, call.values, call.time, call.source)
        if isinstance(event, ControlEvent):
            self.inbox.put(event)
        else:
            self._count_rejection(type(event).__name__)

    def _count_rejection(self, reason: str) -> None:
        self._rejected[reason] = self._rejected.get(reason, 0) + 1
