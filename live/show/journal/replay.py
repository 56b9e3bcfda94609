"""Replay: run a journal again, from its beginning or from a snapshot, and compare the state hash of every measure."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from live.clock.ticks import TICK
from live.control.events.events import TicksSkipped
from live.show.acting import act
from live.show.core import Show
from live.show.journal.journal_reading import Journal, JournalLine
from live.show.journal.replay_start import ReplayError, Start, reload, starts
from live.show.load import LoadedShow

__all__ = ["ReplayError", "Replayed", "Replaying", "reload", "replay"]

KEPT_DIFFERENCES: Final = 1000
"""Differences that are kept; a journal that differs from one measure on differs in all."""


@dataclass(slots=True)
class Replayed:
    """What a replay found."""

    ticks: int = 0
    """The tick at which it ended."""
    begun: int = 0
    """The tick from which it ran."""
    measures: int = 0
    """Measures compared."""
    different: int = 0
    """Measures whose state differs ..."""
    differences: tuple[tuple[int, int, str, str], ...] = ()
    """... and the first of them: measure, tick, then, now."""
    lacking: list[tuple[int, int]] = field(default_factory=list)
    """The measures between that could not be compared, first and last of each row: their lines could not be written or
    read, or they fell into ticks that the show left out."""
    last: int | None = None
    """The measure that was compared last."""
    failed: int = 0
    """Events that ended in an error of the program, and were refused, then as now."""
    problems: list[str] = field(default_factory=list)
    """What of the journal could not be used, in words."""

    def note(self, measures: Iterable[int], *, compared: bool = True) -> None:
        """Note that `measures` of the journal are compared now, or that those after the last one never will be."""
        latest = max(measures, default=0)
        lacks = latest - 1 if compared else latest
        if self.last is not None and lacks > self.last:
            self.lacking.append((self.last + 1, lacks))
        self.last = max(latest, self.last or 0)


class Replaying:
    """Runs a show through the lines of a journal, as far as it is asked to."""

    def __init__(
        self, show: Show, lines: Iterator[JournalLine], *, tick: int = 0, compare: bool = True, to: int | None = None
    ) -> None:
        """`show` stands after `tick`. With `compare` the hash of each measure is; `to`: it ends with that measure."""
        self.show = show
        self.tick = tick
        self.over = False
        """Whether there is nothing more to run."""
        self.damaged: float | None = None
        """The tick up to which something is lost, if it has come to a damaged line and stands before it."""
        self.found = Replayed(ticks=tick, begun=tick)
        self._lines = lines
        self._line: JournalLine | None = None
        self._compare, self._to = compare, to
        self._begun = tick
        self._hash: tuple[int, str] | None = None
        self._take()

    def _take(self) -> None:
        """Read the next line that counts."""
        for line in self._lines:
            if line.tick < self._begun or (line.tick == self._begun and line.measure is not None):
                continue  # what was before the snapshot, and its own measure line
            self._line = line
            return
        self._line, self.over = None, True

    def advance(self, until: float) -> None:
        """Run up to the tick `until`, if the journal goes so far; events at that tick itself wait for the next call."""
        while not self.over and self.damaged is None:
            line = self._line
            assert line is not None
            if line.tick > self.tick:
                if self.tick >= until:
                    break
                self._run_tick()
            elif line.measure is None and self.tick >= until:
                break
            else:
                self._act(line)
        self.found.ticks = self.tick

    def advance_to(self, measure: int) -> None:
        """Run until `measure` (from 1) begins, if the journal goes so far."""
        while not self.over and self.damaged is None and self.show.span.number + 1 < measure:
            self.advance(self.tick + 1)

    def _run_tick(self) -> None:
        self.tick += 1
        if not self.show.tick(self.tick * TICK):
            return
        if self._to is not None and self.show.span.number >= self._to:
            self.over = True
        if self._compare:
            self._hash = self.tick, self.show.state_hash()

    def _act(self, line: JournalLine) -> None:
        if line.damaged is not None:
            self._stop(line)
            return
        if line.event is not None and not line.left_out:
            self.found.failed += act(self.show, line.event) is None
            if isinstance(line.event, TicksSkipped):
                self.tick += line.event.count
        elif line.measure is not None and line.state is not None and self._compare:
            self._compare_with(line)
        self._take()

    def _stop(self, line: JournalLine | None) -> None:
        """Stop before a damaged line: what was in it acted at the tick of the next whole line, at the latest."""
        while line is not None and line.damaged is not None:
            self.found.problems.append(line.damaged)
            line = next(self._lines, None)
        self.damaged = math.inf if line is None else line.tick

    def _compare_with(self, line: JournalLine) -> None:
        found, measure = self.found, line.measure or 0
        found.note([measure])
        found.measures += 1
        now = "no measure began here" if self._hash is None or self._hash[0] != line.tick else self._hash[1]
        if now == line.state:
            return
        found.different += 1
        if len(found.differences) < KEPT_DIFFERENCES:
            found.differences += ((measure, line.tick, line.state or "", now),)


def replay(show: Show, journal: Journal) -> Replayed:
    """Run `show` (fresh, of the journal's patch and seed) through the journal, as fast as the machine can."""
    return run_from(Start(show, 0), journal)


def run_from(start: Start, journal: Journal, *, loaded: LoadedShow | None = None, to: int | None = None) -> Replayed:
    """The same from any start; `to`: the replay ends with that measure (from 1).

    Where a line is damaged it goes on from the next snapshot, if `loaded` is given and there is one.
    """
    running = Replaying(start.show, journal.usable(), tick=start.tick, to=to)
    found = running.found
    while True:
        running.advance(math.inf)
        if running.damaged is None:
            return found
        after = None if loaded is None else next(starts(journal, loaded, running.damaged, found.problems), None)
        if after is None:
            found.note((line.measure for line in journal.usable() if line.measure), compared=False)
            return found
        found.problems.append(f"the replay goes on from the snapshot in measure {after.show.span.number + 1}")
        running = Replaying(after.show, journal.usable(), tick=after.tick, to=to)
        running.found = found
