"""A soak in real time: a headless show, and people, a band and floods that reach it as they would in a hall."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from live.app.session import Session
from live.app.session_sound import Sound
from live.app.wish import Wish
from live.base.fault_isolation import FAULTS
from live.control.events.events import ControlEvent
from live.rehearse.band import FakeBand
from live.rehearse.edits import Edits
from live.rehearse.failure import Failure
from live.rehearse.faults import Fault, faults
from live.rehearse.network_sender import Outlet, Timed, packet_of, packets, send_all
from live.rehearse.players import FakePlayers
from live.rehearse.soak_report import Plan, Report
from live.rehearse.words import Words
from live.render.pacing import Pacer

EACH_S: Final = 20.0
"""Seconds of one row of figures."""
FLOOD: Final = 3000
GROWTH: Final = 1.5
"""The last third's p99.9 of frame CPU time may be so many times that of the first third ..."""
SLACK_MS: Final = 2.0
"""... and so much more."""


class Figures:
    """Frame CPU times [ms] in rows of EACH_S."""

    def __init__(self) -> None:
        self.rows: list[dict[str, float]] = []
        self._times: list[float] = []
        self._end = EACH_S
        self.late = 0

    def add(self, time: float, seconds: float, late: int, memory: float) -> None:
        """One frame at `time` that took `seconds`."""
        self._times.append(seconds * 1e3)
        if time >= self._end:
            self.close(time, late, memory)
            self._end = time + EACH_S

    def close(self, time: float, late: int, memory: float) -> None:
        """End the row."""
        if self._times:
            p50, p99, p999 = np.percentile(self._times, (50, 99, 99.9))
            self.rows.append(
                {"time": time, "p50": float(p50), "p99": float(p99), "p999": float(p999), "late": late - self.late,
                 "frames": len(self._times), "rss_mb": memory}
            )  # fmt: skip
        self._times, self.late = [], late

    def grown(self) -> tuple[float, float] | None:
        """Medians of p99.9 in the first and the last third of all rows; None while there are too few."""
        third = len(self.rows) // 3
        if third < 1:
            return None
        first, last = ([row["p999"] for row in part] for part in (self.rows[:third], self.rows[-third:]))
        return float(np.median(first)), float(np.median(last))


def soak_real(plan: Plan, folder: Path, console: Console) -> tuple[Report, Path]:
    """Run it; the report, and where the journal is. Growing frame times are a problem, late frames a figure."""
    edits = Edits(plan.patch, folder / "patch", plan.seed)
    journal = folder / "journal.jsonl"
    wish = Wish(
        patch=str(edits.path), seed=plan.seed, osc=("127.0.0.1", 0), journal=journal, seconds=plan.hours * 3600.0,
        fps=plan.fps,
    )  # fmt: skip
    session = Session(wish, wish.load(), Sound())
    report, figures, failed = Report(plan), Figures(), dict(FAULTS.counts)
    with session.running():
        people = _People(session, plan, edits, report)
        people.start()
        try:
            _loop(session, plan, figures)
        finally:
            people.stop()
    report.seconds = report.took = session.clock.now()
    _sum_up(session, report, figures, edits, failed)
    return report, journal


def _loop(session: Session, plan: Plan, figures: Figures) -> None:
    from live.app.memory import resident_megabytes

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


def _sum_up(session: Session, report: Report, figures: Figures, edits: Edits, faults: dict[str, int]) -> None:
    status = session.status
    report.status = status.snapshot(session.clock.now())
    report.measures = session.show.span.number
    report.frames, report.skipped = status.frames, status.skipped_ticks
    report.refused = dict(report.status["events_rejected"])
    report.events = {"accepted": status.events_accepted}
    report.edits = edits.saved
    report.memory = [(row["time"], row["rss_mb"]) for row in figures.rows]
    report.journal = report.status.get("journal", {})
    report.frames_ms = figures.rows
    grown = figures.grown()
    if grown is not None and grown[1] > GROWTH * grown[0] + SLACK_MS:
        report.problems.append(f"p99.9 of frame CPU time grows from {grown[0]:.1f} to {grown[1]:.1f} ms")
    if status.faults:
        report.problems.append(f"{status.faults} frames could not be drawn")
    if report.journal.get("dropped"):
        report.problems.append(f"{report.journal['dropped']} lines of the journal were dropped")
    report.problems += FAULTS.since(faults)
    report.count = len(report.problems)


class _People:
    """Everybody outside of the show: a thread that sends."""

    def __init__(self, session: Session, plan: Plan, edits: Edits, report: Report) -> None:
        self._session, self._edits, self._report = session, edits, report
        patch = session.show.patch
        words = Words(patch, session.show.graph.library.steps)
        self._band = FakeBand(plan.seed, bpm=patch.clock.bpm, beats_per_measure=patch.clock.beats_per_measure)
        self._players = FakePlayers(plan.seed, words, count=plan.players, rate=plan.calls)
        self._faults = faults(plan.seed, rate=plan.faults, start=5.0)
        self._chance = np.random.default_rng([plan.seed, 0x9EA1])
        self._deaf_until = 0.0
        self._ended = threading.Event()
        self._outlet = Outlet("127.0.0.1", session.osc.port)
        self._until = plan.hours * 3600.0
        self._pending: dict[bytes, ControlEvent | Fault] = {}
        self._thread = threading.Thread(target=self._run, name="people", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End."""
        self._ended.set()
        self._thread.join(5.0)
        self._outlet.close()
        self._report.band = self._band.did

    def _run(self) -> None:
        streams: list[Any] = [
            (packets(self._players.calls()), self._outlet.send),
            (self._keyed(self._band.events()), self._hear),
            (self._keyed(self._faults), self._do),
        ]
        try:
            send_all(streams, now=self._session.clock.now, wait=self._ended.wait, until=self._until)
        except Exception as error:  # a report has to come
            self._report.fail(Failure.of(error), "the people of the soak end: ")

    def _keyed(self, things: Iterator[Any]) -> Iterator[Timed]:
        """Things with times, as what `send_all` sends: each under a key."""
        for number, thing in enumerate(things):
            key = f"{id(things)} {number}".encode()
            self._pending[key] = thing
            yield thing.time, key

    def _hear(self, key: bytes) -> None:
        event = self._pending.pop(key)
        assert isinstance(event, ControlEvent)
        if event.time >= self._deaf_until:
            self._session.inbox.put(event)

    def _do(self, key: bytes) -> None:
        fault = self._pending.pop(key)
        assert isinstance(fault, Fault)
        acts: dict[str, Callable[[Fault], None]] = {
            "flood": self._flood, "garbage": self._garbage, "source lost": self._lose,
            "good edit": lambda fault: self._edits.good(), "bad edit": lambda fault: self._edits.bad(),
            "edit back": lambda fault: self._edits.back(),
        }  # fmt: skip
        act = acts.get(fault.kind)
        if act is not None:
            self._report.faults[fault.kind] = self._report.faults.get(fault.kind, 0) + 1
            with contextlib.suppress(OSError):
                act(fault)

    def _lose(self, fault: Fault) -> None:
        self._deaf_until = fault.time + 2.0 + 20.0 * fault.size

    def _flood(self, fault: Fault) -> None:
        from live.rehearse.players import Call

        packet = packet_of(Call(fault.time, "/dance/attract", [1.0, 0.5, 0.5, 1.0], "flood"))
        assert packet is not None
        for _ in range(int(FLOOD * fault.size)):
            self._outlet.send(packet)

    def _garbage(self, fault: Fault) -> None:
        for _ in range(50):
            self._outlet.send(self._chance.bytes(int(self._chance.integers(1, 1200))))
