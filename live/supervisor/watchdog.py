"""Watchdog that distinguishes a hung process from one that gets no processor time.

A process hangs when `HANGS_AFTER` seconds *of its own* pass without a heartbeat. Time in which it ran, or could have
run, is its own. Time in which it waited for a processor is not. Time in which it waited for something else counts less
the slower the machine is, because the other process or device is slowed down too. The limit therefore grows with the
overload, stays short on a quiet machine, and is bounded by `MAX_SILENCE`. Nothing here reads a clock or a file: see
`live.supervisor.process_stats`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Final

from live.supervisor.restart_policy import HANGS_AFTER, LATE_AFTER, MAX_SILENCE

MAX_OWN_STEP: Final = 0.1
"""Most seconds between two updates that count as a process' own: a watcher that updates less often is starved itself.
"""
MAX_COUNTED_STEP: Final = 0.5
"""Most seconds between two updates that count at all: in a longer gap the machine was asleep."""
READ_EVERY: Final = 0.1
"""Seconds between two readings of a silent process. The first one is made after it has been silent for this long."""
COMPARE_EVERY: Final = 1.0
"""Seconds between two readings of a process that is not silent."""
MIN_WAIT_SHARE: Final = 0.25
"""Least share of non-processor waiting time that counts as a process' own: a process that sleeps for long hangs. The
same share counts for an uninterruptible wait in the kernel (state D: a disk, a driver)."""
ACTIVE_SHARE: Final = 0.5
"""Threads that run or wait for a processor for at least this share of the time count as active."""
HALFLIFE: Final = 2.0
"""Half-life of the running averages [s]."""
MAX_SLOWDOWN: Final = MAX_SILENCE / HANGS_AFTER
"""Largest slow-down that is measured."""
NOTICEABLE_GAP: Final = 0.1
"""Gap between two heartbeats, or lateness of the supervisor [s], from which an overload is noticeable."""
OVERLOAD_SLOWDOWN: Final = 2.0
"""Slow-down from which a noticeable gap counts as an overload."""
FULL_OVERLOAD_SLOWDOWN: Final = 4.0
"""Slow-down that counts as full overload."""


class Verdict(Enum):
    """Judgement on a process."""

    FINE = "fine"
    LATE = "late"
    """Silent for more than `LATE_AFTER` by its own fault."""
    OVERLOADED = "overloaded"
    """Silent, but most of that time was not its own."""
    HUNG = "hung"


@dataclass(frozen=True, slots=True)
class Usage:
    """Usage counters of a process since its start."""

    state: str
    """State of its main thread, which sends the heartbeat: R, S, D, T as in proc(5)."""
    run: float
    """Seconds for which that thread has run."""
    delay: float | None
    """Seconds for which it has waited for a processor; None if the system does not report it."""
    others_run: float = 0.0
    others_delay: float = 0.0
    """Sums over all its other threads."""


@dataclass(frozen=True, slots=True)
class MachineReading:
    """Load of the machine at a moment; None where the system does not report it."""

    runnable: float | None = None
    """Runnable threads per processor, this one not counted."""
    cpu_stall: float | None = None
    memory_stall: float | None = None
    memory_full: float | None = None
    io_full: float | None = None
    """Pressure-stall information: seconds since the start in which some thread (`full`: every non-idle thread) waited
    for a processor, for memory, or for input or output."""


class MachineLoad:
    """Slow-down of the machine against a quiet one: the worst of several measures.

    - Lateness of the watcher's own rounds, in rounds.
    - Threads per processor, weighted by the share of time in which some thread waits for one.
    - Share of time in which work stalls for lack of memory or of a disk.
    """

    def __init__(self, round_s: float) -> None:
        """`round_s` [s]: duration of a watcher's round that is not late."""
        self._round = round_s
        self._late = self._contention = self._stalled = 1.0
        self._lateness = 0.0
        self._last: tuple[float, MachineReading] | None = None

    @property
    def slowdown(self) -> float:
        """1 on a quiet machine, `SLOWEST` at most."""
        return min(max(self._late, self._contention, self._stalled), MAX_SLOWDOWN)

    @property
    def lateness(self) -> float:
        """Recent lateness of the watcher's wake-ups [s]."""
        return self._lateness

    def record_wakeup(self, late: float, took: float) -> None:
        """Record a round of the watcher that was `late` [s] and `took` [s] in all."""
        kept = 0.5 ** (took / HALFLIFE)
        self._late = kept * self._late + (1.0 - kept) * (1.0 + late / self._round)
        self._lateness = max(late, kept * self._lateness)

    def record_reading(self, now: float, reading: MachineReading) -> None:
        """Record a reading of the machine, some tenths of a second after the last one."""
        before, self._last = self._last, (now, reading)
        if before is None or now <= before[0]:
            return
        seconds = now - before[0]
        kept = 0.5 ** (seconds / HALFLIFE)

        def share(after: float | None, earlier: float | None) -> float | None:
            return None if after is None or earlier is None else min(max((after - earlier) / seconds, 0.0), 1.0)

        was = before[1]
        waits = share(reading.cpu_stall, was.cpu_stall)
        crowd = 1.0
        if reading.runnable is not None:
            crowd += (1.0 if waits is None else waits) * max(reading.runnable - 1.0, 0.0)
        self._contention = kept * self._contention + (1.0 - kept) * crowd
        full = max(share(reading.memory_full, was.memory_full) or 0.0, share(reading.io_full, was.io_full) or 0.0)
        stalled = max(full, 0.5 * (share(reading.memory_stall, was.memory_stall) or 0.0))
        self._stalled = kept * self._stalled + (1.0 - kept) / max(1.0 - stalled, 1.0 / MAX_SLOWDOWN)


class Watchdog:
    """Judges the heartbeat of one process. Each update gets the time of the last beat."""

    def __init__(self) -> None:
        self.late = 0
        """How often it was silent for more than `LATE_AFTER`, since the start."""
        self.overload_silences = 0
        """How often it was silent for more than `HANGS_AFTER` because of an overload."""
        self.slowdown = 1.0
        """Slow-down of its main thread by waiting for a processor, over the last second."""
        self.verdict = Verdict.FINE
        self.limit_factor = 1.0
        """Factor on the usual limits for silence."""
        self._updated_at: float | None = None
        self._beat = 0.0
        self._silence = self._own_silence = self._unjudged = 0.0  # seconds of silence: total, its own, not judged yet
        self._gap = 0.0
        self._usage: Usage | None = None
        self._read_at = -math.inf
        self._compared: tuple[float, Usage] | None = None

    @property
    def own_silence(self) -> float:
        """Seconds of that silence that were its own."""
        return self._own_silence

    @property
    def gap(self) -> float:
        """The longest recent silence [s]."""
        return max(self._gap, self._silence)

    def update(self, now: float, last_beat: float, usage: Callable[[], Usage | None], slowdown: float) -> Verdict:
        """Return the verdict at `now` [s] on a process whose last beat was at `last_beat` [s].

        `usage`: reads the usage counters (None: not available); called seldom. `slowdown`: of the machine.
        """
        step = 0.0 if self._updated_at is None else max(now - self._updated_at, 0.0)
        self._updated_at = now
        self._compare(now, usage)
        self._gap *= 0.5 ** (step / HALFLIFE)
        if last_beat != self._beat:
            self._gap = max(self._gap, self._silence)
            self._beat, self._silence, self._own_silence, self._unjudged, self._usage = last_beat, 0.0, 0.0, 0.0, None
            step = min(step, max(now - last_beat, 0.0))
        was = self._silence
        self._silence += min(step, MAX_COUNTED_STEP)
        self._unjudged += min(step, MAX_OWN_STEP)
        if self._silence > READ_EVERY and now - self._read_at >= READ_EVERY:
            self._judge(now, usage(), slowdown)
        self.late += was <= LATE_AFTER < self._silence
        self.verdict = self._current_verdict()
        self.overload_silences += was <= HANGS_AFTER < self._silence and self.verdict is not Verdict.HUNG
        return self.verdict

    def _current_verdict(self) -> Verdict:
        if self._own_silence > HANGS_AFTER * self.limit_factor or self._silence > MAX_SILENCE * self.limit_factor:
            return Verdict.HUNG
        if self._silence <= LATE_AFTER:
            return Verdict.FINE
        return Verdict.OVERLOADED if self._own_silence < 0.5 * self._silence else Verdict.LATE

    def _judge(self, now: float, usage: Usage | None, slowdown: float) -> None:
        """Add the process' own part of the time since the last reading."""
        share = 1.0 / max(slowdown, 1.0)
        if usage is not None and self._usage is not None and now > self._read_at:
            share = own_share(self._usage, usage, now - self._read_at, slowdown)
        elif usage is not None and usage.state in ("T", "t"):
            share = 1.0
        self._own_silence += share * self._unjudged
        self._unjudged, self._usage, self._read_at = 0.0, usage, now

    def _compare(self, now: float, usage: Callable[[], Usage | None]) -> None:
        """Measure once a second how much slower it runs than it would alone."""
        if self._compared is not None and now - self._compared[0] < COMPARE_EVERY:
            return
        before, told = self._compared, usage()
        self._compared = None if told is None else (now, told)
        if before is None or told is None or told.delay is None or before[1].delay is None:
            return
        run, delay = told.run - before[1].run, told.delay - before[1].delay
        self.slowdown = min((run + delay) / run, MAX_SLOWDOWN) if run > 0.0 and delay >= 0.0 else 1.0


def own_share(before: Usage, after: Usage, seconds: float, slowdown: float) -> float:
    """Return the share, 0 to 1, of the `seconds` between two readings that was the process' own."""
    if after.state in ("T", "t"):  # stopped by a signal, not by an overload
        return 1.0
    run = max(after.run - before.run, 0.0)
    if after.delay is None or before.delay is None:
        if after.state == "R":
            return min(run / seconds, 1.0)
    else:
        delay = max(after.delay - before.delay, 0.0)
        if after.state == "R" and run + delay < ACTIVE_SHARE * seconds:  # `delay` grows only once it runs
            return min(run / seconds, 1.0)
        if run + delay >= ACTIVE_SHARE * seconds:
            return max(1.0 - delay / seconds, 0.0)
    if after.state == "D":
        return MIN_WAIT_SHARE
    # asleep, perhaps waiting for its own threads, which may get no processor
    run = max(after.others_run - before.others_run, 0.0)
    delay = max(after.others_delay - before.others_delay, 0.0)
    others = run / (run + delay) if run + delay >= ACTIVE_SHARE * seconds else 1.0
    return min(others, max(1.0 / max(slowdown, 1.0), MIN_WAIT_SHARE))


def overload(load: MachineLoad, watched: Watchdog | None) -> float:
    """Return the overload of the machine, 0 to 1; 0 while it is not noticeable."""
    slowdown, gap = load.slowdown, load.lateness
    if watched is not None:
        slowdown, gap = max(slowdown, watched.slowdown), max(gap, watched.gap)
    if gap < NOTICEABLE_GAP or slowdown < OVERLOAD_SLOWDOWN:
        return 0.0
    return min((slowdown - 1.0) / (FULL_OVERLOAD_SLOWDOWN - 1.0), 1.0)
