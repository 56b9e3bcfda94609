"""Soak: hours of a show with a made-up band, made-up players and faults, in virtual time; nothing may go wrong.

The show is what `live play` runs: engine, inbox, journal with snapshots, watch of the patch's files. Only the clock is
moved by hand, and frames are drawn nowhere.
"""

import gc
import json
import time as _time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import psutil

from live.base.inbox import Inbox
from live.clock.source import ManualClock
from live.control.events import BeatHeard, ControlEvent, MusicHeard, RestartAudio, SourceChanged
from live.control.osc_decode import OscRejected, decode
from live.control.registry import REGISTRY
from live.rehearse.band import FakeBand
from live.rehearse.edits import Edits
from live.rehearse.faults import Fault, faults
from live.rehearse.players import Call, FakePlayers
from live.rehearse.watching import Watching
from live.rehearse.words import HOSTILE, Words
from live.show.engine import Engine
from live.show.load import LoadedShow, load_show
from live.show.patch_watch import PatchWatch
from live.show.status import Status

SALT: Final = 0x50AC
MEMORY_EVERY: Final = 60.0
"""Seconds of the show from one look at memory to the next."""
FLOOD: Final = 6000
"""Events of the largest flood: more than the inbox holds."""
GROWTH_MB: Final = 20.0
"""So much memory may change after the first hour (or the first third of a shorter run)."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is run."""

    patch: Path
    seed: int = 0
    hours: float = 1.0
    fps: float = 16.0
    """Frames per second of the show, on the average."""
    players: int = 8
    calls: float = 6.0
    """What each player does in a minute."""
    faults: float = 1.0
    """How often things go wrong; 1: about once a minute."""


@dataclass(slots=True)
class Report:
    """What came of it."""

    plan: Plan
    seconds: float = 0.0
    """Of the show."""
    took: float = 0.0
    """Of the machine [s]."""
    measures: int = 0
    leapt: int = 0
    frames: int = 0
    skipped: int = 0
    problems: list[str] = field(default_factory=list)
    count: int = 0
    """Problems in all."""
    events: dict[str, int] = field(default_factory=dict)
    refused: dict[str, int] = field(default_factory=dict)
    faults: dict[str, int] = field(default_factory=dict)
    band: dict[str, int] = field(default_factory=dict)
    edits: dict[str, int] = field(default_factory=dict)
    frames_ms: list[dict[str, float]] = field(default_factory=list)
    """In real time: CPU time of frames [ms], late frames and memory, in rows of some seconds."""
    memory: list[tuple[float, float]] = field(default_factory=list)
    """Seconds of the show, resident memory [MB]."""
    objects: list[tuple[float, int]] = field(default_factory=list)
    journal: dict[str, Any] = field(default_factory=dict)
    replay: dict[str, Any] = field(default_factory=dict)
    status: dict[str, Any] = field(default_factory=dict)
    """The last figures of the show."""

    @property
    def growth(self) -> float | None:
        """Largest change of memory [MB] after the first hour, or the first third of a shorter run."""
        begin = min(3600.0, self.seconds / 3.0)
        later = [size for time, size in self.memory if time >= begin]
        return max(abs(size - later[0]) for size in later) if later else None

    @property
    def ok(self) -> bool:
        """Whether nothing went wrong."""
        grown = self.growth
        different = self.replay.get("different", 0) or self.replay.get("problems")
        return not self.count and not different and (grown is None or grown <= GROWTH_MB)

    def as_json(self) -> dict[str, Any]:
        """For `--report`."""
        plan = {"patch": str(self.plan.patch), "seed": self.plan.seed, "hours": self.plan.hours, "fps": self.plan.fps}
        facts = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "plan"}
        speed = self.seconds / self.took if self.took else None
        return {"ok": self.ok, **plan, "speed": speed, "memory_growth_mb": self.growth, **facts}


class Soak:
    """One run."""

    def __init__(self, plan: Plan, folder: Path) -> None:
        """`folder`: where the copy of the patch and the journal go. PersonError for a patch that does not start."""
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
        self.journal = Watching(self.journal_path, header)
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
        self._deaf_until = 0.0
        self._other_until = 0.0
        self._stall = 0.0
        self._look = 0.0

    def run(self, tell: Callable[[float, Report], None] | None = None) -> Report:
        """Run it all; `tell` hears of it once a minute of the show. An exception is noted, and ends the run."""
        report, begin, end = self.report, _time.perf_counter(), self.plan.hours * 3600.0
        gc.collect()
        gc.freeze()
        gc.disable()
        told = 0.0
        try:
            while self.clock.now() < end:
                self._frame()
                if self.clock.now() >= told:
                    told += MEMORY_EVERY
                    self._measure_memory()
                    report.took = _time.perf_counter() - begin
                    if tell is not None:
                        tell(self.clock.now(), report)
        except Exception:
            self.journal.add(f"tick {self.engine.ticks.index}: {traceback.format_exc()}")
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
        report.events, report.band, report.edits = self.journal.told, self.band.did, self.edits.saved
        report.journal = {**self.journal.facts(), "bytes_an_hour": self._bytes_an_hour()}
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
        now = self.clock.now() + float(self._chance.uniform(0.5, 1.5)) / self.plan.fps + self._stall
        self._stall = 0.0
        while self._next_heard.time <= now:
            self._hear(self._next_heard)
            self._next_heard = next(self._heard)
        while self._next_call is not None and self._next_call.time <= now:
            self.call(self._next_call)
            self._next_call = next(self._calls, None)
        while self._next_fault is not None and self._next_fault.time <= now:
            self._do(self._next_fault)
            self._next_fault = next(self._faults, None)
        if now >= self._look:
            self._look = now + 0.1
            self.watch.look()
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
        if event.time < self._deaf_until and isinstance(event, (BeatHeard, MusicHeard)):
            return
        self.inbox.put(event)

    def call(self, call: Call) -> None:
        """What a player sends."""
        event = REGISTRY.call(call.address, call.values, call.time, call.source)
        if isinstance(event, ControlEvent):
            self.inbox.put(event)
        else:
            key = type(event).__name__
            self._rejected[key] = self._rejected.get(key, 0) + 1

    def _do(self, fault: Fault) -> None:
        report = self.report
        report.faults[fault.kind] = report.faults.get(fault.kind, 0) + 1
        FAULTS[fault.kind](self, fault)

    # -- faults ------------------------------------------------------------------------------------------------

    def lose_source(self, fault: Fault) -> None:
        """The sound is gone, for up to a minute."""
        self._deaf_until = fault.time + 2.0 + 60.0 * fault.size
        for time, state in ((fault.time, "lost"), (self._deaf_until, "found")):
            self.inbox.put(SourceChanged(time=time, source="audio", state=state))

    def stall(self, fault: Fault) -> None:
        """The machine stands still: for a moment mostly, seldom for half a minute."""
        self._stall = 0.3 + 3.0 * fault.size + (30.0 if fault.size > 0.97 else 0.0)

    def flood(self, fault: Fault) -> None:
        """Thousands of messages at once."""
        for number in range(int(FLOOD * fault.size)):
            x = -4.0 + 8.0 * (number % 97) / 97.0
            self.call(Call(fault.time, "/dance/attract", [x, fault.size, 1.0, 1.0], "osc"))

    def crowd_of_calls(self, fault: Fault) -> None:
        """What all players do in five minutes, within a frame."""
        for call, _ in zip(self._calls, range(int(200 * fault.size)), strict=False):
            self.call(Call(fault.time, call.address, call.values, call.source))
        # the calls' own times have gone on: nothing is played until they are reached, as after a rush

    def garbage(self, fault: Fault) -> None:
        """Packets that are none."""
        for _ in range(20):
            packet = self._chance.bytes(int(self._chance.integers(1, 400)))
            try:
                for message in decode(b"/dance/" + packet if fault.size > 0.5 else packet):
                    self.call(Call(fault.time, message.address, list(message.arguments), "osc"))
            except OscRejected:
                self._rejected["garbage"] = self._rejected.get("garbage", 0) + 1

    def jump_tempo(self, fault: Fault) -> None:
        """Somebody says another tempo, or the music leaps."""
        bpm = 60.0 + 120.0 * fault.size
        if fault.size < 0.5:
            self.call(Call(fault.time, "/dance/clock/tempo", [bpm], "osc"))
        else:
            self.call(Call(fault.time, "/dance/clock/half" if fault.size < 0.75 else "/dance/clock/double", [], "osc"))
        self.band.bpm = bpm

    def impossible(self, fault: Fault) -> None:
        """A source that says what no source can."""
        for value in HOSTILE:
            if isinstance(value, float | int):
                number = float(value)
                self.inbox.put(
                    BeatHeard(time=fault.time, source="midi", beat_time=number, period=fault.size, confidence=1.0)
                )
                self.inbox.put(
                    BeatHeard(time=fault.time, source="midi", beat_time=fault.time, period=number, confidence=number)
                )

    def other_source(self, fault: Fault) -> None:
        """Another clock speaks for a while, with a grid of its own; and is chosen, or not."""
        period, source = 0.35 + 0.5 * fault.size, "midi"
        self.inbox.put(SourceChanged(time=fault.time, source=source, state="started"))
        for beat in range(16):
            time = fault.time + 0.001 * beat
            self.inbox.put(
                BeatHeard(
                    time=time,
                    source=source,
                    beat_time=fault.time + beat * period,
                    period=period,
                    confidence=0.9,
                    beat=beat % 4,
                    beats_per_measure=4,
                    measure=beat // 4,
                    jump=beat == 0,
                )
            )
        choice = ("midi", "auto", "internal", "audio")[int(fault.size * 4.0) % 4]
        self.call(Call(fault.time, "/dance/clock/source", [choice], "osc"))

    def restart_device(self, fault: Fault) -> None:
        """Sound is opened again."""
        self.inbox.put(RestartAudio(time=fault.time, source="key"))

    def rest(self, fault: Fault) -> None:
        """Everything is set back: what players of an hour have done does not pile up for ever."""
        beats = self.show.patch.clock.beats_per_measure
        for address, values in (
            ("/dance/clear", []), ("/dance/blackout", [0]), ("/dance/hold", [0]), ("/dance/hold/score", [0]),
            ("/dance/practice", []), ("/dance/clock/hold", [0]), ("/dance/clock/source", ["auto"]),
            ("/dance/clock/metre", [beats]), ("/dance/clock/tempo", [self.band.bpm]),
        ):  # fmt: skip
            self.call(Call(fault.time, address, list(values), "osc"))


FAULTS: Final[dict[str, Callable[[Soak, Fault], None]]] = {
    "source lost": Soak.lose_source,
    "stall": Soak.stall,
    "flood": Soak.flood,
    "garbage": Soak.garbage,
    "good edit": lambda soak, fault: soak.edits.good(),
    "bad edit": lambda soak, fault: soak.edits.bad(),
    "edit back": lambda soak, fault: soak.edits.back(),
    "tempo jump": Soak.jump_tempo,
    "impossible beats": Soak.impossible,
    "device again": Soak.restart_device,
    "other source": Soak.other_source,
    "crowd of calls": Soak.crowd_of_calls,
    "rest": Soak.rest,
}
"""What each kind of fault does."""
