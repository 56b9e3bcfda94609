"""Watching: a journal that looks at the show after every tick, and says what must never happen.

Proving: the journal of a long run is replayed, from its start and from snapshots; states must be the same.
"""

import math
import time as _time
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.events.events import TicksSkipped
from live.rehearse.failure import Failure
from live.show.journal.journal import JournalWriter
from live.show.journal.journal_reader import JournalError, read_journal
from live.show.journal.replay import ReplayError, first_start, loaded_by, run_from, start_before
from live.show.show import Show

PICTURED: Final = ("joint_position", "joint_rotation", "element_position", "element_level", "element_corner", "picture")
"""What of a picture is looked at."""
BACK: Final = 1e-6
"""Danced beats that rounding may take back."""
MOST: Final = 50
"""Problems that are kept in words; all are counted."""


class Watching(JournalWriter):
    """A `JournalWriter` that counts measure lines, and values that are no numbers."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.problems: list[str] = []
        """The first of what went wrong."""
        self.count = 0
        """How much went wrong."""
        self.lines = 0
        """Measure lines crossed."""
        self.leapt = 0
        """Measures that fell into ticks which the machine left out."""
        self.told: dict[str, int] = {}
        """Events by kind."""
        self._measure: int | None = None
        self._danced = -math.inf
        self._skipped = 0.0

    def event(self, tick: int, event: ControlEvent) -> None:
        """Write and count an event."""
        kind = type(event).__name__
        self.told[kind] = self.told.get(kind, 0) + 1
        if isinstance(event, TicksSkipped):
            self._skipped += event.count * TICK
        super().event(tick, event)

    def keep(self, show: Show, tick: int, *, begins: bool) -> None:
        """To be called after each tick."""
        self._measures(show, tick, begins)
        state = show.state
        for name in ("position", "velocity", "acceleration"):
            if not np.isfinite(getattr(state, name)).all():
                self.add(f"tick {tick}: agents' {name} is no number")
        if not math.isfinite(show.timeline.beat_at(show.time)):
            self.add(f"tick {tick}: the beat is no number")
        super().keep(show, tick, begins=begins)

    def _measures(self, show: Show, tick: int, begins: bool) -> None:
        """Each measure begins once, right after the one before it, and runs while its beats do."""
        number, last = show.span.number, self._measure
        self._measure = number
        danced, before = show.danced, self._danced
        self._danced = danced
        if not danced >= before - BACK:
            self.add(f"tick {tick}: the dance goes back from beat {before:.6f} to {danced:.6f}")
        if last is None:
            return
        step = number - last
        self.lines += max(step, 0)
        if step < 0:
            self.add(f"tick {tick}: measure {number + 1} is danced again after {last + 1}")
        elif (step > 0) != begins:
            self.add(f"tick {tick}: measure {number + 1} begins, and is not told (or the other way round)")
        elif step > 1:
            if self._skipped > 0.0:
                self.leapt += step - 1
            else:
                self.add(f"tick {tick}: measures {last + 2} to {number} are missed")
        if step <= 1 and begins:
            self._skipped = 0.0

    def resume(self, show: Show, tick: int) -> None:
        """Another engine goes on with `show`, which stands after `tick`: it may have crossed one line on the way."""
        number, last = show.span.number, self._measure
        if last is not None and not last <= number <= last + 1:
            self.add(f"tick {tick}: another engine goes on in measure {number + 1}, the last one was in {last + 1}")
        self.lines += 0 if last is None else max(number - last, 0)
        self._measure, self._danced = number, show.danced

    def look(self, view: StageView, tick: int) -> None:
        """Look at a picture's values."""
        for name in PICTURED:
            array = getattr(view, name)
            if array is not None and not np.isfinite(array).all():
                rows = np.unique(np.argwhere(~np.isfinite(array))[:, 0])
                where = f"in rows {', '.join(map(str, rows[:8]))} of {len(array)}, {len(rows)} in all"
                self.add(
                    f"tick {tick}: the picture's {name} is no number {where}; {view.phase:.3f} beats of its measure"
                )

    def add(self, words: str) -> None:
        """Note a problem."""
        self.count += 1
        if len(self.problems) < MOST:
            self.problems.append(words)


SALT = 0x9E91
STRETCH = 24
"""Measures that are replayed from a snapshot."""


def prove(path: Path, *, seed: int = 0, stretches: int = 3, whole: bool = True) -> dict[str, Any]:
    """Replay a journal: the `whole` of it, and so many stretches from the snapshot before a measure drawn by `seed`.

    Counts of measures compared and different, the first differences (measure, tick, then, now), problems in words: a
    replay that ends in an exception is one, too, for a report has to come whatever happens.
    """
    begin = _time.perf_counter()
    facts: dict[str, Any] = {"measures": 0, "different": 0, "differences": [], "problems": [], "stretches": 0}
    problems: list[str] = facts["problems"]
    try:
        journal = read_journal(path)
        loaded = loaded_by(journal)
        if whole:
            found = run_from(first_start(journal, loaded), journal, loaded=loaded)
            _add(facts, found.measures, found.different, found.differences, found.problems)
            facts["speed"] = (found.ticks - found.begun) / 64.0 / max(_time.perf_counter() - begin, 1e-9)
        last = max((line.measure or 0 for line in journal.usable()), default=0)
        chance = np.random.default_rng([seed, SALT])
        for measure in sorted(int(m) for m in chance.integers(2, max(3, last), stretches if last > 2 else 0)):
            start = start_before(journal, loaded, measure, problems)
            found = run_from(start, journal, loaded=loaded, to=start.show.span.number + STRETCH)
            _add(facts, found.measures, found.different, found.differences, found.problems)
            facts["stretches"] += 1
    except (JournalError, ReplayError) as error:
        problems.append(str(error))
    except Exception as error:  # the replay meets what ended the show: that is what the report is for
        failure = Failure.of(error)
        problems.append(f"the replay ends in an exception: {failure}")
        facts["failure"] = failure.facts()
    facts["took"] = _time.perf_counter() - begin
    return facts


def _add(
    facts: dict[str, Any], measures: int, different: int, differences: tuple[Any, ...], problems: list[str]
) -> None:
    facts["measures"] += measures
    facts["different"] += different
    facts["differences"] += list(differences)[: 20 - len(facts["differences"])]
    facts["problems"] += problems
