"""Chaos run in virtual time: a soak test in which every call site of the tick fails in turn, once, three times, always.

Runs in one process: where an engine would end, another one takes over by the program's own recovery
(`live.supervisor.recovery`), from the log that a supervisor would have. As there is no real waiting, hundreds of engine
failures take minutes.
"""

import gc
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.control.events.system import ResetBreaker
from live.rehearse.chaos.call_sites import CallSite, CallSiteTracer, ExceptionInjector, replaced_tick
from live.rehearse.failure import Failure
from live.rehearse.invariants import check_replay
from live.rehearse.soak_test import SoakOptions, SoakTest
from live.show.engine import Engine
from live.show.patch.hot_reload import PatchWatch
from live.show.state.snapshot import CapturedSnapshot
from live.show.view.status import Status
from live.supervisor.engine_deaths import DeathHistory
from live.supervisor.recovery import Death, Recovery
from live.supervisor.recovery_log import JournalDisk, RecoveryLog
from live.supervisor.state_follower import StateFollower

SALT: Final = 0xC4A0
REPETITIONS: Final = {"once": 1, "three times": 3, "always": 1 << 30}
TRACE_SECONDS: Final = 24.0
"""Show time in which call sites are recorded [s]."""
MAX_WAIT: Final = 12.0
"""Maximum show time for which an armed site is waited for [s]; some are passed only in few measures."""
PAUSE: Final = 1.0
"""Show time from a failure to the next [s]."""
MAX_DEATHS: Final = 12
"""Number of ended engines above which a site is reported as a loop. No cause may end a fourth engine, and a stage, its
simpler form and the whole tick are three causes."""


class MemorySink:
    """Journal sink that acts as a supervisor: a recovery log in memory, and the journal on disk."""

    def __init__(self, path: Path) -> None:
        self.log, self._disk = RecoveryLog(), JournalDisk(path)
        self._snapshots = 0

    def put(self, line: str) -> None:
        """Store a line of the show."""
        if self.log.add_line(line):
            self._disk.write(line)

    def snapshot(self, taken: CapturedSnapshot) -> None:
        """Store a snapshot, as an engine sends it."""
        import base64
        import json

        data = base64.b64encode(taken.seal()).decode()
        self.put(json.dumps({"tick": taken.tick, "snapshot": data}, separators=(",", ":")))
        self._snapshots += 1

    def facts(self) -> dict[str, int]:
        """Return the figures of a journal's file."""
        return {"lines": 0, "dropped": 0, "bytes": 0, "behind": 0, "missing": 0, **self._disk.facts()}

    def close(self) -> None:
        """Write the pending lines."""
        self._disk.close()


class RecoveringSoakTest(SoakTest):
    """A soak test whose show recovers from failures, as a supervised one does."""

    def __init__(self, plan: SoakOptions, folder: Path) -> None:
        self._sink = MemorySink(folder / "journal.jsonl")
        super().__init__(plan, folder, sink=self._sink)
        self.deaths = DeathHistory()
        self.breaker_expected = False
        """Whether a stage was disabled because several engines ended in it."""
        self.notes: list[str] = []
        """Notes that the operator would have read."""

    def _frame(self) -> None:
        try:
            super()._frame()
        except Exception as error:  # an engine would end here
            self.recover(error)

    def recover(self, error: Exception) -> None:
        """Let another engine take over after an engine has ended. Raises the recovery's exception if it fails."""
        now = self.clock.now()
        running = self.show.breakers.running
        tick = self.engine.ticks.index
        lesson = self.deaths.record(now, tick, running)
        self.breaker_expected = self.breaker_expected or lesson.trip
        following = StateFollower(self.loaded)
        for line in self._sink.log.replay_lines():
            following.add_line(line)
        while following.advance():
            pass
        recovered = Recovery(following, Death.from_message(lesson.as_dict())).run()
        for line in recovered.lines:
            self._sink.put(line)
        self.notes += recovered.notes
        self._resume(recovered.show, following.tick)
        error.__traceback__ = None
        gc.collect()  # the failed show has reference cycles; a real engine frees its memory when it ends

    def _resume(self, show: Any, tick: int) -> None:
        self.show = show
        self.journal.resume(show, tick)
        self.journal.prepare(show)
        was = self.status
        self.status = Status(show, rejected=lambda: self._rejected, memory=self._memory)  # type: ignore[arg-type,return-value]
        self.status.frames, self.status.extra_figures = was.frames, was.extra_figures
        index = self.engine.ticks
        self.engine = Engine(show, clock=self.clock, inbox=self.inbox, status=self.status, journal=self.journal)
        self.engine.ticks.index, self.engine.ticks.skipped = tick, index.skipped
        self.patch_watch = PatchWatch(self.loaded, show, post=self.inbox.put, now=self.clock.now)


class SiteSequence:
    """Lets one site after the other fail, in one show."""

    def __init__(self, soak: RecoveringSoakTest, sites: list[tuple[CallSite, str]]) -> None:
        self._soak, self._pending = soak, list(reversed(sites))
        self.injector = ExceptionInjector()
        self.current: tuple[CallSite, str] | None = None
        """The site that fails now, and how often (key of REPETITIONS)."""
        self._begun = self._next_start = 0.0
        self._deaths = 0
        self.tried_count = 0
        self.never_reached: list[str] = []
        """Sites that no tick passed while they were armed."""
        self.max_deaths = 0
        """Maximum number of engines that one site ended."""

    @property
    def is_done(self) -> bool:
        """Whether all sites are done."""
        return self.current is None and not self._pending

    def before_frame(self) -> None:
        """Arm or end a site; called between two frames."""
        soak, now = self._soak, self._soak.clock.now()
        if self.current is None:
            if self._pending and now >= self._next_start:
                self.current = self._pending.pop()
                self._begun, self._deaths = now, soak.deaths.count
                self.injector.arm(self.current[0], REPETITIONS[self.current[1]], now)
            return
        died = soak.deaths.count - self._deaths
        if died > MAX_DEATHS:
            soak.journal.add_problem(f"{self.description()}: {died} engines ended, endless loop")
        passed = self.injector.raised_count > 0
        used = self.injector.remaining <= 0 or (passed and now - self._begun > 2.0 * PAUSE)
        if died > MAX_DEATHS or used or now - self._begun > MAX_WAIT:
            self._end(now, died, passed)

    def description(self) -> str:
        assert self.current is not None
        return f"{self.current[0]} ({self.current[1]})"

    def _end(self, now: float, died: int, passed: bool) -> None:
        soak, site = self._soak, self.current
        assert site is not None
        self.tried_count += 1
        self.max_deaths = max(self.max_deaths, died)
        if not passed:
            self.never_reached.append(self.description())
        self.injector.disarm()
        if soak.show.breakers.reasons:  # reset the breakers, so that all stages are enabled for the next site
            if site[1] == "once" and not soak.breaker_expected:
                soak.journal.add_problem(
                    f"{self.description()}: one exception disabled {', '.join(soak.show.breakers.reasons)}"
                )
            soak.inbox.put(ResetBreaker(time=now, source="osc", name=""))
        self.current, self._next_start, soak.breaker_expected = None, now + PAUSE, False


def find_sites(plan: SoakOptions, folder: Path) -> list[CallSite]:
    """Return the call sites that this patch passes, sorted by name."""
    folder.mkdir(parents=True, exist_ok=True)
    looker = CallSiteTracer()
    soak = SoakTest(plan, folder)
    with replaced_tick(looker.run):
        while soak.clock.now() < min(TRACE_SECONDS, plan.hours * 3600.0):
            soak._frame()
    soak.journal.close(soak.engine.ticks.index)
    return sorted(looker.sites)


def virtual_chaos(
    plan: SoakOptions,
    folder: Path,
    *,
    sites: int = 0,
    on_progress: Callable[[str], None] = lambda words: None,
) -> dict[str, Any]:
    """Let `sites` call sites, drawn by the plan's seed (0: all), fail once, three times and always; return the report.
    The show lasts as long as that takes, at most the plan's length."""
    chance = np.random.default_rng([plan.seed, SALT])
    found = find_sites(plan, folder / "looking")
    drawn = found if not sites else [found[int(i)] for i in sorted(chance.permutation(len(found))[:sites])]
    row = [(site, times) for site in drawn for times in REPETITIONS if not (site.is_breaker and times == "always")]
    on_progress(f"{len(found)} call sites, {len(row)} failures of {len(drawn)}")
    soak = RecoveringSoakTest(plan, folder)
    turns = SiteSequence(soak, row)
    last = [0.0]

    def progress(time: float, report: Any) -> None:
        if time - last[0] >= 300.0:
            last[0] = time
            on_progress(f"{time / 60.0:.0f} min: {turns.tried_count} of {len(row)}, {soak.deaths.count} engines ended")

    soak.before_frame = turns.before_frame
    soak.should_stop = lambda: turns.is_done
    with replaced_tick(turns.injector.run):
        report = soak.run(progress)
    if soak.failure is not None and turns.current is not None:
        report.problems.append(f"failing at that time: {turns.description()}")
    if not turns.is_done:
        on_progress(f"{len(row) - turns.tried_count} failures were not tried: the show ended before")
    try:
        report.replay = check_replay(soak.journal_path, seed=plan.seed, parts=2)
    except Exception as error:
        report.record_failure(Failure.from_exception(error), "the replay: ")
    facts = report.as_json()
    facts |= {
        "sites": len(found), "tried": turns.tried_count, "wanted": len(row), "deaths": soak.deaths.count,
        "worst": turns.max_deaths, "never": turns.never_reached, "notes": sorted(set(soak.notes))[:50],
    }  # fmt: skip
    facts["summary"] = [
        f"{turns.tried_count} of {len(row)} failures at {len(found)} call sites, {soak.deaths.count} engines ended, "
        f"at most {turns.max_deaths} by one; {len(turns.never_reached)} sites not passed again",
        f"{report.measures} measures; {report.replay.get('measures', 0)} replayed, "
        f"{report.replay.get('different', 0)} differ",
    ]
    return facts
