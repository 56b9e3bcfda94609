"""What a journal holds: how long, how many measures, which events from whom, what is damaged; read in one go."""

from array import array
from collections import Counter
from dataclasses import dataclass, field

from live.clock.ticks import TICK
from live.control.events.events import TicksSkipped
from live.show.journal.journal_reading import Journal

KEPT_PROBLEMS = 1000
"""Problems that are kept in words; all are counted."""


@dataclass(slots=True)
class Survey:
    """Figures of one journal. Ticks of measures and of events are kept, a few bytes each."""

    journal: Journal
    ticks: int = 0
    """The last tick there is a line of."""
    skipped: int = 0
    """Ticks left out in stalls."""
    measure_tick: "array[int]" = field(default_factory=lambda: array("q"))
    """When each measure began ..."""
    measure: "array[int]" = field(default_factory=lambda: array("q"))
    """... and which it is, from 1."""
    events: "dict[tuple[str, str], array[int]]" = field(default_factory=dict)
    """Ticks of the events, by source and type."""
    damaged: int = 0
    problems: list[str] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """Length of the show."""
        return self.ticks * TICK

    @property
    def counts(self) -> Counter[tuple[str, str]]:
        """How many events there are, by source and type."""
        return Counter({key: len(ticks) for key, ticks in self.events.items()})

    def tempo(self) -> list[tuple[int, float]]:
        """Tick and mean tempo [bpm] of each whole measure, in the patch's metre."""
        clock = self.journal.patch.get("clock")
        beats = clock.get("beats_per_measure") if isinstance(clock, dict) else None
        beats = beats if isinstance(beats, int) and 2 <= beats <= 12 else 4
        rows = zip(self.measure_tick, self.measure_tick[1:], self.measure, self.measure[1:], strict=False)
        return [
            (begin, 60.0 * beats * (number - first) / ((end - begin) * TICK))
            for begin, end, first, number in rows
            if end > begin and number > first
        ]


def survey(journal: Journal) -> Survey:
    """Read all lines of a journal once."""
    found = Survey(journal)
    for line in journal.usable():
        found.ticks = max(found.ticks, line.tick)
        if line.damaged is not None:
            found.damaged += 1
            if len(found.problems) < KEPT_PROBLEMS:
                found.problems.append(line.damaged)
        elif line.event is not None:
            key = line.event.source, type(line.event).__name__
            found.events.setdefault(key, array("q")).append(line.tick)
            if isinstance(line.event, TicksSkipped):
                found.skipped += line.event.count
        elif line.measure is not None:
            found.measure_tick.append(line.tick)
            found.measure.append(line.measure)
    return found
