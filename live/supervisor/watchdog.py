"""Watchdog: tells a hung process from one that is merely not let run. Readings go in, a verdict comes out.

A process hangs when it has had `HANGS_AFTER` seconds *of its own* without a heartbeat: seconds in which it ran, or
could have. Seconds in which it waited for a processor are not its own; those in which it waited for something else
count the less the slower the machine is, for what it waits for is as slow. So the limit grows with the overload and is
as short as ever on a quiet machine; `CEILING` bounds it. Nothing here reads a clock or a file: see
`live.supervisor.process_stats`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Final

from live.supervisor.restart_policy import CEILING, HANGS_AFTER, LATE_AFTER

MOST_OWN: Final = 0.1
"""Seconds between two looks that count as a process' own at most: who looks more seldom is starved itself."""
MOST_SEEN: Final = 0.5
"""Seconds between two looks that count at all: over more than that the machine slept."""
READ_EVERY: Final = 0.1
"""Seconds between two readings of a process that is silent; none is made before it has been silent for so long."""
COMPARE_EVERY: Final = 1.0
"""Seconds between two readings of one that is not."""
WAITS_SHARE: Final = 0.25
"""Of time in which a process waits, and not for a processor, at least so much is its own: who sleeps for long hangs. So
much, too, where it waits in the kernel without a way out (state D: a disk, a driver)."""
ACTIVE: Final = 0.5
"""Threads that want the processor for this share of the time are at work."""
HALFLIFE: Final = 2.0
"""After so many seconds what was measured counts half."""
SLOWEST: Final = CEILING / HANGS_AFTER
"""A slow-down that is not measured any further."""
FELT: Final = 0.1
"""Seconds between two heartbeats, or by which the supervisor wakes late, from which on an overload is felt."""
HEAVY: Final = 2.0
"""Twice as slow: from here on an overload that is felt is one."""
FULL: Final = 4.0
"""So many times as slow: all the overload that is told."""


class Verdict(Enum):
    """What silence means."""

    FINE = "fine"
    LATE = "late"
    """Silent for more than `LATE_AFTER`, and that is its own affair."""
    OVERLOADED = "overloaded"
    """Silent, but most of that time was not its own."""
    HUNG = "hung"


@dataclass(frozen=True, slots=True)
class Usage:
    """What the system says of a process, since its start."""

    state: str
    """Of its main thread, which gives the heartbeat: R, S, D, T as in proc(5)."""
    run: float
    """Seconds that thread has run ..."""
    delay: float | None
    """... and has waited for a processor; None: the system does not say."""
    others_run: float = 0.0
    others_delay: float = 0.0
    """The same of all its other threads together."""


@dataclass(frozen=True, slots=True)
class MachineReading:
    """What the system says of the machine at a moment; None where it does not."""

    runnable: float | None = None
    """Threads that run or want to, this one left out, for each processor."""
    cpu_stall: float | None = None
    memory_stall: float | None = None
    memory_full: float | None = None
    io_full: float | None = None
    """Pressure-stall information: seconds since the start in which some thread (`full`: every thread that was not idle)
    waited for a processor, for memory, for input or output."""


class MachineLoad:
    """How many times slower everything is than on a quiet machine, by several measures; the worst counts.

    - How late the watcher's own rounds come back, in rounds.
    - How many threads there are for each processor, in the share of time in which some thread waits for one.
    - The share of time in which nothing goes on for want of memory, or of a disk.
    """

    def __init__(self, round_s: float) -> None:
        """`round_s` [s]: how long a round of the watcher takes that is not late."""
        self._round = round_s
        self._late = self._crowd = self._stalled = 1.0
        self._lateness = 0.0
        self._last: tuple[float, MachineReading] | None = None

    @property
    def slowdown(self) -> float:
        """1 on a quiet machine, `SLOWEST` at most."""
        return min(max(self._late, self._crowd, self._stalled), SLOWEST)

    @property
    def lateness(self) -> float:
        """How late the watcher has woken lately [s]."""
        return self._lateness

    def woke(self, late: float, took: float) -> None:
        """A round of the watcher came back `late` [s] and `took` so long in all."""
        kept = 0.5 ** (took / HALFLIFE)
        self._late = kept * self._late + (1.0 - kept) * (1.0 + late / self._round)
        self._lateness = max(late, kept * self._lateness)

    def read(self, now: float, reading: MachineReading) -> None:
        """A reading of the machine, some tenths of a second after the last one."""
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
        self._crowd = kept * self._crowd + (1.0 - kept) * crowd
        full = max(share(reading.memory_full, was.memory_full) or 0.0, share(reading.io_full, was.io_full) or 0.0)
        stalled = max(full, 0.5 * (share(reading.memory_stall, was.memory_stall) or 0.0))
        self._stalled = kept * self._stalled + (1.0 - kept) / max(1.0 - stalled, 1.0 / SLOWEST)


class Watchdog:
    """Judges the heartbeat of one process. Told at each look when the last beat was."""

    def __init__(self) -> None:
        self.late = 0
        """How often it was silent for more than `LATE_AFTER`, since the start."""
        self.spared = 0
        """How often it was silent for more than `HANGS_AFTER`, and could not help it."""
        self.slowdown = 1.0
        """How many times as long its main thread takes because it waits for a processor, by the last second."""
        self.verdict = Verdict.FINE
        self.patience = 1.0
        """How long silence may last, in the usual limits."""
        self._looked: float | None = None
        self._beat = 0.0
        self._seen = self._own = self._due = 0.0  # seconds of silence: in all, its own, not yet judged
        self._gap = 0.0
        self._usage: Usage | None = None
        self._read_at = -math.inf
        self._compared: tuple[float, Usage] | None = None

    @property
    def silent(self) -> float:
        """Seconds without a heartbeat, as far as they were looked at."""
        return self._seen

    @property
    def own(self) -> float:
        """How many of those were its own."""
        return self._own

    @property
    def gap(self) -> float:
        """The longest silence lately [s]."""
        return max(self._gap, self._seen)

    def look(self, now: float, last: float, usage: Callable[[], Usage | None], slowdown: float) -> Verdict:
        """What a process whose last beat was at `last` is like at `now` [s].

        `usage`: reads what the system says of it (None: nothing), which is done seldom; `slowdown`: the machine's.
        """
        step = 0.0 if self._looked is None else max(now - self._looked, 0.0)
        self._looked = now
        self._compare(now, usage)
        self._gap *= 0.5 ** (step / HALFLIFE)
        if last != self._beat:
            self._gap = max(self._gap, self._seen)
            self._beat, self._seen, self._own, self._due, self._usage = last, 0.0, 0.0, 0.0, None
            step = min(step, max(now - last, 0.0))
        was = self._seen
        self._seen += min(step, MOST_SEEN)
        self._due += min(step, MOST_OWN)
        if self._seen > READ_EVERY and now - self._read_at >= READ_EVERY:
            self._judge(now, usage(), slowdown)
        self.late += was <= LATE_AFTER < self._seen
        self.verdict = self._found()
        self.spared += was <= HANGS_AFTER < self._seen and self.verdict is not Verdict.HUNG
        return self.verdict

    def _found(self) -> Verdict:
        if self._own > HANGS_AFTER * self.patience or self._seen > CEILING * self.patience:
            return Verdict.HUNG
        if self._seen <= LATE_AFTER:
            return Verdict.FINE
        return Verdict.OVERLOADED if self._own < 0.5 * self._seen else Verdict.LATE

    def _judge(self, now: float, usage: Usage | None, slowdown: float) -> None:
        """Count the part of the seconds since the last reading that was its own."""
        share = 1.0 / max(slowdown, 1.0)
        if usage is not None and self._usage is not None and now > self._read_at:
            share = own_share(self._usage, usage, now - self._read_at, slowdown)
        elif usage is not None and usage.state in ("T", "t"):
            share = 1.0
        self._own += share * self._due
        self._due, self._usage, self._read_at = 0.0, usage, now

    def _compare(self, now: float, usage: Callable[[], Usage | None]) -> None:
        """How much slower it is than it would be alone, from second to second."""
        if self._compared is not None and now - self._compared[0] < COMPARE_EVERY:
            return
        before, told = self._compared, usage()
        self._compared = None if told is None else (now, told)
        if before is None or told is None or told.delay is None or before[1].delay is None:
            return
        run, delay = told.run - before[1].run, told.delay - before[1].delay
        self.slowdown = min((run + delay) / run, SLOWEST) if run > 0.0 and delay >= 0.0 else 1.0


def own_share(before: Usage, after: Usage, seconds: float, slowdown: float) -> float:
    """Which part, 0 to 1, of the `seconds` between two readings was a process' own."""
    if after.state in ("T", "t"):  # somebody stopped it: no machine is slow enough for that
        return 1.0
    run = max(after.run - before.run, 0.0)
    if after.delay is None or before.delay is None:
        if after.state == "R":
            return min(run / seconds, 1.0)
    else:
        delay = max(after.delay - before.delay, 0.0)
        if after.state == "R" and run + delay < ACTIVE * seconds:  # it waits still, and that is told when it runs
            return min(run / seconds, 1.0)
        if run + delay >= ACTIVE * seconds:
            return max(1.0 - delay / seconds, 0.0)
    if after.state == "D":
        return WAITS_SHARE
    # it sleeps: does it wait for threads of its own that get no processor?
    run = max(after.others_run - before.others_run, 0.0)
    delay = max(after.others_delay - before.others_delay, 0.0)
    others = run / (run + delay) if run + delay >= ACTIVE * seconds else 1.0
    return min(others, max(1.0 / max(slowdown, 1.0), WAITS_SHARE))


def overload(load: MachineLoad, watched: Watchdog | None) -> float:
    """How much too much the machine has to do for a show, 0 to 1: 0 as long as nothing of it is felt."""
    slowdown, gap = load.slowdown, load.lateness
    if watched is not None:
        slowdown, gap = max(slowdown, watched.slowdown), max(gap, watched.gap)
    if gap < FELT or slowdown < HEAVY:
        return 0.0
    return min((slowdown - 1.0) / (FULL - 1.0), 1.0)
