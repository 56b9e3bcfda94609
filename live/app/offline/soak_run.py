"""Runs of `live soak`: soak tests in real or virtual time, campaigns, their reports, and journal minimisation.

A real-time soak is a headless show with simulated players, band and packet floods over the network.
"""

import contextlib
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.session import Session
from live.app.session_audio import AudioChoice
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.base.system.features import LINUX
from live.control.events.events import ControlEvent
from live.rehearse.campaign import Campaign, Facts, Job, problem_lines, report_lines, run_safely
from live.rehearse.failure import Failure
from live.rehearse.fault_injection import Fault, PatchEditor, fault_schedule
from live.rehearse.invariants import check_replay
from live.rehearse.network_sender import TimedPacket, UdpSender, osc_packets, packet_of, send_all
from live.rehearse.simulated_band import SimulatedBand
from live.rehearse.simulated_players import ArgumentGenerator, SimulatedPlayers
from live.rehearse.soak_test import SoakOptions, SoakReport, SoakTest
from live.render.timing.frame_stats import Pacer
from live.show.patch.patch_search_path import MAIN_FILE, PATCHES, find_patch

ROW_SECONDS: Final = 20.0
"""Duration of one row of figures [s]."""
FLOOD: Final = 3000
GROWTH_FACTOR: Final = 1.5
"""Allowed growth factor of the p99.9 of frame CPU time from the first to the last third of the run."""
GROWTH_MARGIN_MS: Final = 2.0
"""Further growth allowed [ms]."""


class FrameTimeStats:
    """Statistics of frame CPU times [ms] in rows of ROW_SECONDS."""

    def __init__(self) -> None:
        self.rows: list[dict[str, float]] = []
        self._times: list[float] = []
        self._end = ROW_SECONDS
        self.late = 0

    def add(self, time: float, seconds: float, late: int, memory: float) -> None:
        """Add a frame at `time` that took `seconds`."""
        self._times.append(seconds * 1e3)
        if time >= self._end:
            self.close(time, late, memory)
            self._end = time + ROW_SECONDS

    def close(self, time: float, late: int, memory: float) -> None:
        """Finish the row."""
        if self._times:
            p50, p99, p999 = np.percentile(self._times, (50, 99, 99.9))
            self.rows.append(
                {"time": time, "p50": float(p50), "p99": float(p99), "p999": float(p999), "late": late - self.late,
                 "frames": len(self._times), "rss_mb": memory}
            )  # fmt: skip
        self._times, self.late = [], late

    def growth(self) -> tuple[float, float] | None:
        """Return the medians of p99.9 in the first and last third of all rows; None if there are too few."""
        third = len(self.rows) // 3
        if third < 1:
            return None
        first, last = ([row["p999"] for row in part] for part in (self.rows[:third], self.rows[-third:]))
        return float(np.median(first)), float(np.median(last))


def soak_real(plan: SoakOptions, folder: Path, console: Console) -> tuple[SoakReport, Path]:
    """Run the soak; return the report and the journal's path. Growing frame times are a problem, late ones are not."""
    edits = PatchEditor(plan.patch, folder / "patch", plan.seed)
    journal = folder / "journal.jsonl"
    options = LaunchOptions(
        patch=str(edits.path), seed=plan.seed, osc=("127.0.0.1", 0), journal=journal, seconds=plan.hours * 3600.0,
        fps=plan.fps,
    )  # fmt: skip
    session = Session(options, options.load(), AudioChoice())
    report, figures, failed = SoakReport(plan), FrameTimeStats(), dict(FAULTS.counts)
    with session.running():
        people = _SimulatedPeople(session, plan, edits, report)
        people.start()
        try:
            _loop(session, plan, figures)
        finally:
            people.stop()
    report.seconds = report.took = session.clock.now()
    _sum_up(session, report, figures, edits, failed)
    return report, journal


def _loop(session: Session, plan: SoakOptions, figures: FrameTimeStats) -> None:
    from live.app.session_records import resident_megabytes

    memory = resident_megabytes()
    pacer = Pacer(plan.fps, session.clock.now, time.sleep)
    previous = session.clock.now()
    while not session.finished(previous):
        started = pacer.wait()
        session.before_frame()
        before = time.thread_time()
        session.engine.frame(lambda view: None)
        used = time.thread_time() - before
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        figures.add(started, used, pacer.late, memory() if started >= figures._end else 0.0)
        previous = started
    figures.close(previous, pacer.late, memory())


def _sum_up(
    session: Session, report: SoakReport, figures: FrameTimeStats, edits: PatchEditor, faults: dict[str, int]
) -> None:
    status = session.status
    report.status = status.snapshot(session.clock.now())
    report.measures = session.show.span.number
    report.frames, report.skipped = status.frames, status.skipped_ticks
    report.refused = dict(report.status["events_rejected"])
    report.events = {"accepted": status.events_accepted}
    report.edits = edits.edit_counts
    report.memory = [(row["time"], row["rss_mb"]) for row in figures.rows]
    report.journal = report.status.get("journal", {})
    report.frames_ms = figures.rows
    grown = figures.growth()
    if grown is not None and grown[1] > GROWTH_FACTOR * grown[0] + GROWTH_MARGIN_MS:
        report.problems.append(f"p99.9 of frame CPU time grows from {grown[0]:.1f} to {grown[1]:.1f} ms")
    if status.faults:
        report.problems.append(f"{status.faults} frames could not be drawn")
    if report.journal.get("dropped"):
        report.problems.append(f"{report.journal['dropped']} lines of the journal were dropped")
    report.problems += FAULTS.failures_since(faults)
    report.count = len(report.problems)


class _SimulatedPeople:
    """Simulated people outside the show: a thread that sends."""

    def __init__(self, session: Session, plan: SoakOptions, edits: PatchEditor, report: SoakReport) -> None:
        self._session, self._edits, self._report = session, edits, report
        patch = session.show.patch
        words = ArgumentGenerator(patch, session.show.graph.library.steps)
        self._band = SimulatedBand(plan.seed, bpm=patch.clock.bpm, beats_per_measure=patch.clock.beats_per_measure)
        self._players = SimulatedPlayers(plan.seed, words, count=plan.players, rate=plan.calls)
        self._faults = fault_schedule(plan.seed, rate=plan.faults, start=5.0)
        self._chance = np.random.default_rng([plan.seed, 0x9EA1])
        self._deaf_until = 0.0
        self._ended = threading.Event()
        self._outlet = UdpSender("127.0.0.1", session.osc.port)
        self._until = plan.hours * 3600.0
        self._pending: dict[bytes, ControlEvent | Fault] = {}
        self._thread = threading.Thread(target=self._run, name="people", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread."""
        self._ended.set()
        self._thread.join(5.0)
        self._outlet.close()
        self._report.band = self._band.counts

    def _run(self) -> None:
        streams: list[Any] = [
            (osc_packets(self._players.calls()), self._outlet.send),
            (self._with_keys(self._band.events()), self._put_event),
            (self._with_keys(self._faults), self._inject_fault),
        ]
        try:
            send_all(streams, now=self._session.clock.now, wait=self._ended.wait, until=self._until)
        except Exception as error:  # a report has to come
            self._report.record_failure(Failure.from_exception(error), "the people of the soak end: ")

    def _with_keys(self, things: Iterator[Any]) -> Iterator[TimedPacket]:
        """Yield time and key of each thing, for `send_all`; the thing is stored under the key."""
        for number, thing in enumerate(things):
            key = f"{id(things)} {number}".encode()
            self._pending[key] = thing
            yield thing.time, key

    def _put_event(self, key: bytes) -> None:
        event = self._pending.pop(key)
        assert isinstance(event, ControlEvent)
        if event.time >= self._deaf_until:
            self._session.inbox.put(event)

    def _inject_fault(self, key: bytes) -> None:
        fault = self._pending.pop(key)
        assert isinstance(fault, Fault)
        acts: dict[str, Callable[[Fault], None]] = {
            "flood": self._flood, "garbage": self._garbage, "source lost": self._lose_source,
            "good edit": lambda fault: self._edits.save_valid(), "bad edit": lambda fault: self._edits.save_invalid(),
            "edit back": lambda fault: self._edits.restore(),
        }  # fmt: skip
        act = acts.get(fault.kind)
        if act is not None:
            self._report.faults[fault.kind] = self._report.faults.get(fault.kind, 0) + 1
            with contextlib.suppress(OSError):
                act(fault)

    def _lose_source(self, fault: Fault) -> None:
        self._deaf_until = fault.time + 2.0 + 20.0 * fault.severity

    def _flood(self, fault: Fault) -> None:
        from live.rehearse.simulated_players import Call

        packet = packet_of(Call(fault.time, "/dance/attract", [1.0, 0.5, 0.5, 1.0], "flood"))
        assert packet is not None
        for _ in range(int(FLOOD * fault.severity)):
            self._outlet.send(packet)

    def _garbage(self, fault: Fault) -> None:
        for _ in range(50):
            self._outlet.send(self._chance.bytes(int(self._chance.integers(1, 1200))))


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Options of a run besides its plan."""

    chaos: bool = False
    virtual: bool = True
    replay: bool = True
    sites: int = 0
    """Number of randomly chosen call sites of the tick that fail; 0: all."""


def patches_of(names: list[str] | None, *, every: bool) -> list[Path]:
    """Return the patches with these names, or all; raise PersonError for a missing one."""
    if every:
        folders = sorted(PATCHES.glob(f"*/{MAIN_FILE}"))
        return [*folders, *(path for path in sorted(PATCHES.glob("*.toml")) if not path.stem.endswith(".midi"))]
    return [find_patch(name) for name in names or [None]]  # type: ignore[list-item]


def run_one(plan: SoakOptions, folder: Path | None, console: Console, wanted: RunOptions) -> Facts:
    """Run one soak; without a folder its files are kept only if it failed."""
    there = folder or Path(tempfile.mkdtemp(prefix="live-soak-"))
    there.mkdir(parents=True, exist_ok=True)
    facts = run_safely(Job("", lambda into: run(plan, into, console, wanted)), there)
    return _clean_up(facts, there, folder)


def run_all(plans: list[SoakOptions], folder: Path | None, console: Console, wanted: RunOptions) -> Facts:
    """Run all soaks except those already finished in `folder`."""
    there = folder or Path(tempfile.mkdtemp(prefix="live-soak-"))
    first = plans[0]
    what = {"hours": first.hours, "fps": first.fps, "players": first.players, "faults": first.faults, **asdict(wanted)}

    def tell(words: str) -> None:
        console.print(words, soft_wrap=True, markup=False)

    campaign = Campaign(there, what, tell)
    jobs = [Job(name_of(plan), lambda into, plan=plan: run(plan, into, console, wanted)) for plan in plans]  # type: ignore[misc]
    try:
        facts = campaign.run(jobs)
    except (KeyboardInterrupt, SystemExit):
        facts = campaign.report([job.name for job in jobs])
    return _clean_up(facts, there, folder)


def _clean_up(facts: Facts, there: Path, folder: Path | None) -> Facts:
    if folder is None and facts["ok"]:
        shutil.rmtree(there, ignore_errors=True)
    else:
        facts["folder"] = str(there)
    return facts


def name_of(plan: SoakOptions) -> str:
    """Return the name of a run: patch and seed."""
    patch = plan.patch.parent.name if plan.patch.name == MAIN_FILE else plan.patch.stem
    return f"{patch}-{plan.seed}"


def run(plan: SoakOptions, folder: Path, console: Console, wanted: RunOptions) -> Facts:
    """Run one soak with its files in `folder`; return the facts of its report."""
    if wanted.chaos and wanted.virtual:
        from live.rehearse.chaos.virtual_run import virtual_chaos

        return virtual_chaos(
            plan, folder, sites=wanted.sites, on_progress=lambda words: console.print(words, style="dim")
        )
    if wanted.chaos and not LINUX:
        raise PersonError("chaos stops and ends the processes of a show, which needs Linux", "add --virtual")
    if wanted.chaos:
        from live.rehearse.chaos.real_run import real_chaos

        return real_chaos(plan, folder, lambda words: console.print(words, style="dim", soft_wrap=True, markup=False))

    def progress(time: float, report: SoakReport) -> None:
        speed = time / report.took if report.took else 0.0
        words = f"{time / 60.0:.0f} min, {speed:.1f} times real time, {report.memory[-1][1]:.0f} MB"
        console.print(words, style="dim")

    report = SoakReport(plan)
    try:
        if wanted.virtual:
            running = SoakTest(plan, folder)
            report, journal = running.report, running.journal_path
            running.run(progress)
        else:
            report, journal = soak_real(plan, folder, console)
        if wanted.replay:
            console.print("replaying its journal ...", style="dim")
            report.replay = check_replay(journal, seed=plan.seed)
    except PersonError:
        raise
    except (KeyboardInterrupt, SystemExit):  # Ctrl-C, or `kill`
        report.count += 1
        report.problems.append("interrupted")
    except Exception as error:
        report.record_failure(Failure.from_exception(error), "the harness itself failed: ")
    return {**report.as_json(), "summary": summary(report)}


def summary(report: SoakReport) -> list[str]:
    """Return a summary of a run."""
    replayed = report.replay
    words = [f"{report.seconds / 60.0:.1f} min, {report.measures} measures, {sum(report.faults.values())} faults"]
    if replayed:
        words.append(f"{replayed['measures']} measures replayed, {replayed['different']} differ")
    return words


def print_summary(facts: Facts) -> None:
    """Print the summary."""
    console = Console(highlight=False)
    for words in facts["summary"]:
        console.print(words, soft_wrap=True, markup=False)


def print_campaign(facts: Facts) -> None:
    """Print a line for each run, and the failures."""
    console = Console(highlight=False)
    for words in report_lines(facts):
        console.print(words, soft_wrap=True, markup=False)
    _print_end(facts, console)


def print_run(facts: Facts) -> None:
    """Print the details of one run."""
    console = Console(highlight=False)
    lines = []
    if "seconds" in facts:
        grown, replay = facts["memory_growth_mb"], facts["replay"]
        lines += [
            f"{facts['seconds'] / 3600.0:.2f} h of the show, {facts['measures']} measures, "
            f"{sum(facts['events'].values())} events, {sum(facts['faults'].values())} faults; {facts['skipped']} ticks "
            "left out in stalls",
            "memory: " + ("not long enough to say" if grown is None else f"within {grown:.1f} MB after the beginning"),
        ]
        if replay:
            lines.append(
                f"replay: {replay['measures']} measures compared, {replay['different']} differ (the whole of it, and "
                f"{replay['stretches']} stretches from snapshots)"
            )
    for words in lines:
        console.print(words, soft_wrap=True, markup=False)
    for words in problem_lines(facts, ""):
        console.print(words, style="red", soft_wrap=True, markup=False)
    _print_end(facts, console)


def _print_end(facts: dict[str, Any], console: Console) -> None:
    if "folder" in facts:
        console.print(f"journals: {facts['folder']}", soft_wrap=True, markup=False)
    console.print("[green]nothing went wrong[/]" if facts["ok"] else "[red]failed[/]")


MINIMISED_SUFFIX = ".min.jsonl"
"""File name suffix of a minimised journal."""


def minimise_journal(path: Path, target: Path | None, seconds: float, console: Console) -> dict[str, Any]:
    """Minimise a failing journal to one that fails in the same way; return the report's facts.

    `target`: the file to write; None: next to the journal.
    """
    from live.rehearse.journal_minimiser import minimise
    from live.show.journal.journal_reader import JournalError
    from live.show.journal.replay import ReplayError

    def tell(words: str) -> None:
        console.print(words, style="dim", soft_wrap=True, markup=False)

    try:
        found = minimise(path, seconds=seconds, on_progress=tell)
    except (JournalError, ReplayError) as error:
        raise PersonError(str(error)) from None
    if found is None:
        return {"ok": True, "fails": False, "summary": [f"{path} does not fail: nothing to minimise"]}
    target = target or path.with_name(path.name.removesuffix(".jsonl") + MINIMISED_SUFFIX)
    try:
        found.write(target)
    except OSError as error:
        raise PersonError(f"cannot write {target}: {error.strerror}") from None
    events, ticks = found.original_size
    words = f"{events} events in {ticks / 64.0:.1f} s became {len(found.entries)} in {found.end / 64.0:.1f} s: {target}"
    return {
        "ok": False, "fails": True, "journal": str(target), "failure": found.failure.facts(),
        "tried": found.trial_count, "events": [events, len(found.entries)], "ticks": [ticks, found.end],
        "summary": [str(found.failure), words],
    }  # fmt: skip
