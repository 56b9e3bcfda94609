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
from live.rehearse.chaos.call_sites import Injector, Looker, Site, instead_of_tick
from live.rehearse.failure import Failure
from live.rehearse.invariants import prove
from live.rehearse.soak_test import Plan, Soak
from live.show.engine import Engine
from live.show.patch.hot_reload import PatchWatch
from live.show.state.snapshot import Taken
from live.show.status import Status
from live.supervisor.engine_deaths import Deaths
from live.supervisor.recovery import Death, Recovery
from live.supervisor.recovery_log import Disk, Log
from live.supervisor.state_follower import Following

SALT: Final = 0xC4A0
TIMES: Final = {"once": 1, "three times": 3, "always": 1 << 30}
LOOKS_FOR: Final = 24.0
"""Show time in which call sites are recorded [s]."""
PATIENCE: Final = 12.0
"""Maximum show time for which an armed site is waited for [s]; some are passed only in few measures."""
AFTER: Final = 1.0
"""Show time from a failure to the next [s]."""
MOST_DEATHS: Final = 12
"""Number of ended engines above which a site is reported as a loop. No cause may end a fourth engine, and a stage, its
simpler form and the whole tick are three causes."""


class MemorySink:
    """Journal sink that acts as a supervisor: a recovery log in memory, and the journal on disk."""

    def __init__(self, path: Path) -> None:
        self.log, self._disk = Log(), Disk(path)
        self._snapshots = 0

    def put(self, line: str) -> None:
        """Store a line of the show."""
        if self.log.take(line):
            self._disk.put(line)

    def snapshot(self, taken: Taken) -> None:
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


class RecoveringSoak(Soak):
    """A soak test whose show recovers from failures, as a supervised one does."""

    def __init__(self, plan: Plan, folder: Path) -> None:
        self._sink = MemorySink(folder / "journal.jsonl")
        super().__init__(plan, folder, sink=self._sink)
        self.deaths = Deaths()
        self.foreseen = False
        """Whether a stage was disabled because several engines ended in it."""
        self.notes: list[str] = []
        """Notes that the operator would have read."""

    def _frame(self) -> None:
        try:
            super()._frame()
        except Exception as error:  # an engine would end here
            self.die(error)

    def die(self, error: Exception) -> None:
        """Let another engine take over after an engine has ended. Raises the recovery's exception if it fails."""
        now = self.clock.now()
        running = self.show.breakers.running
        tick = self.engine.ticks.index
        lesson = self.deaths.note(now, tick, running)
        self.foreseen = self.foreseen or lesson.trip
        following = Following(self.loaded)
        for line in self._sink.log.since():
            following.take(line)
        while following.advance():
            pass
        recovered = Recovery(following, Death.of(lesson.told())).run()
        for line in recovered.lines:
            self._sink.put(line)
        self.notes += recovered.notes
        self._go_on(recovered.show, following.tick)
        error.__traceback__ = None
        gc.collect()  # the failed show has reference cycles; a real engine frees its memory when it ends

    def _go_on(self, show: Any, tick: int) -> None:
        self.show = show
        self.journal.resume(show, tick)
        self.journal.prepare(show)
        was = self.status
        self.status = Status(show, rejected=lambda: self._rejected, memory=self._memory)  # type: ignore[arg-type,return-value]
        self.status.frames, self.status.more = was.frames, was.more
        index = self.engine.ticks
        self.engine = Engine(show, clock=self.clock, inbox=self.inbox, status=self.status, journal=self.journal)
        self.engine.ticks.index, self.engine.ticks.skipped = tick, index.skipped
        self.watch = PatchWatch(self.loaded, show, post=self.inbox.put, now=self.clock.now)


class Row:
    """Lets one site after the other fail, in one show."""

    def __init__(self, soak: RecoveringSoak, sites: list[tuple[Site, str]]) -> None:
        self._soak, self._coming = soak, list(reversed(sites))
        self.injector = Injector()
        self.now: tuple[Site, str] | None = None
        """The site that fails now, and how often (key of TIMES)."""
        self._begun = self._quiet_at = 0.0
        self._deaths = 0
        self.tried = 0
        self.never: list[str] = []
        """Sites that no tick passed while they were armed."""
        self.worst = 0
        """Maximum number of engines that one site ended."""

    @property
    def over(self) -> bool:
        """Whether all sites are done."""
        return self.now is None and not self._coming

    def frame(self) -> None:
        """Arm or end a site; called between two frames."""
        soak, now = self._soak, self._soak.clock.now()
        if self.now is None:
            if self._coming and now >= self._quiet_at:
                self.now = self._coming.pop()
                self._begun, self._deaths = now, soak.deaths.count
                self.injector.arm(self.now[0], TIMES[self.now[1]], now)
            return
        died = soak.deaths.count - self._deaths
        if died > MOST_DEATHS:
            soak.journal.add(f"{self.words()}: {died} engines ended, endless loop")
        passed = self.injector.raised > 0
        used = self.injector.left <= 0 or (passed and now - self._begun > 2.0 * AFTER)
        if died > MOST_DEATHS or used or now - self._begun > PATIENCE:
            self._end(now, died, passed)

    def words(self) -> str:
        assert self.now is not None
        return f"{self.now[0]} ({self.now[1]})"

    def _end(self, now: float, died: int, passed: bool) -> None:
        soak, site = self._soak, self.now
        assert site is not None
        self.tried += 1
        self.worst = max(self.worst, died)
        if not passed:
            self.never.append(self.words())
        self.injector.disarm()
        if soak.show.breakers.why:  # reset the breakers, so that all stages are enabled for the next site
            if site[1] == "once" and not soak.foreseen:
                soak.journal.add(f"{self.words()}: one exception disabled {', '.join(soak.show.breakers.why)}")
            soak.inbox.put(ResetBreaker(time=now, source="osc", name=""))
        self.now, self._quiet_at, soak.foreseen = None, now + AFTER, False


def find_sites(plan: Plan, folder: Path, *, deep: bool = False) -> list[Site]:
    """Return the call sites that this patch passes, sorted by name."""
    folder.mkdir(parents=True, exist_ok=True)
    looker = Looker(deep=deep)
    soak = Soak(plan, folder)
    with instead_of_tick(looker.run):
        while soak.clock.now() < min(LOOKS_FOR, plan.hours * 3600.0):
            soak._frame()
    soak.journal.close(soak.engine.ticks.index)
    return sorted(looker.sites)


def virtual_chaos(
    plan: Plan, folder: Path, *, sites: int = 0, deep: bool = False, tell: Callable[[str], None] = lambda words: None
) -> dict[str, Any]:
    """Let `sites` call sites, drawn by the plan's seed (0: all), fail once, three times and always; return the report.
    The show lasts as long as that takes, at most the plan's length."""
    chance = np.random.default_rng([plan.seed, SALT])
    found = find_sites(plan, folder / "looking", deep=deep)
    drawn = found if not sites else [found[int(i)] for i in sorted(chance.permutation(len(found))[:sites])]
    row = [(site, times) for site in drawn for times in TIMES if not (site.of_the_mechanism and times == "always")]
    tell(f"{len(found)} call sites, {len(row)} failures of {len(drawn)}")
    soak = RecoveringSoak(plan, folder)
    turns = Row(soak, row)
    last = [0.0]

    def progress(time: float, report: Any) -> None:
        if time - last[0] >= 300.0:
            last[0] = time
            tell(f"{time / 60.0:.0f} min: {turns.tried} of {len(row)}, {soak.deaths.count} engines ended")

    soak.between = turns.frame
    soak.until = lambda: turns.over
    with instead_of_tick(turns.injector.run):
        report = soak.run(progress)
    if soak.failure is not None and turns.now is not None:
        report.problems.append(f"failing at that time: {turns.words()}")
    if not turns.over:
        tell(f"{len(row) - turns.tried} failures were not tried: the show ended before")
    try:
        report.replay = prove(soak.journal_path, seed=plan.seed, stretches=2)
    except Exception as error:
        report.fail(Failure.of(error), "the replay: ")
    facts = report.as_json()
    facts |= {
        "sites": len(found), "tried": turns.tried, "wanted": len(row), "deaths": soak.deaths.count,
        "worst": turns.worst, "never": turns.never, "notes": sorted(set(soak.notes))[:50],
    }  # fmt: skip
    facts["summary"] = [
        f"{turns.tried} of {len(row)} failures at {len(found)} call sites, {soak.deaths.count} engines ended, "
        f"at most {turns.worst} by one; {len(turns.never)} sites not passed again",
        f"{report.measures} measures; {report.replay.get('measures', 0)} replayed, "
        f"{report.replay.get('different', 0)} differ",
    ]
    return facts
