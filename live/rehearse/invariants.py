"""Invariant checks for long runs: after every tick by a checking journal writer, and by replay of the journal.

The replay starts from the beginning and from snapshots; states have to be the same.
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
from live.show.journal.replay import ReplayError, first_start, load_journal, run_from, start_before
from live.show.show import Show

CHECKED_ARRAYS: Final = (
    "joint_position",
    "joint_rotation",
    "element_position",
    "element_level",
    "element_corner",
    "picture",
)
"""Checked arrays of the snapshot for drawing."""
BEAT_TOLERANCE: Final = 1e-6
"""Tolerance for rounding in the monotonicity check of danced beats."""
MAX_PROBLEMS: Final = 50
"""Maximum number of stored problems; all are counted."""


class CheckingJournalWriter(JournalWriter):
    """A `JournalWriter` that checks measures, and that all values are finite."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.problems: list[str] = []
        """The first problems."""
        self.problem_count = 0
        """Number of problems."""
        self.measure_count = 0
        """Number of measure lines crossed."""
        self.skipped_measures = 0
        """Number of measures in skipped ticks."""
        self.event_counts: dict[str, int] = {}
        """Number of events by kind."""
        self._measure: int | None = None
        self._last_danced_beat = -math.inf
        self._skipped_seconds = 0.0

    def record_event(self, tick: int, event: ControlEvent) -> None:
        """Write and count an event."""
        kind = type(event).__name__
        self.event_counts[kind] = self.event_counts.get(kind, 0) + 1
        if isinstance(event, TicksSkipped):
            self._skipped_seconds += event.count * TICK
        super().record_event(tick, event)

    def take_snapshot(self, show: Show, tick: int, *, begins: bool) -> None:
        """Check the show after a tick; called after each one."""
        self._check_measures(show, tick, begins)
        state = show.state
        for name in ("position", "velocity", "acceleration"):
            if not np.isfinite(getattr(state, name)).all():
                self.add_problem(f"tick {tick}: agents' {name} is not finite")
        if not math.isfinite(show.timeline.beat_at(show.time)):
            self.add_problem(f"tick {tick}: the beat is not finite")
        super().take_snapshot(show, tick, begins=begins)

    def _check_measures(self, show: Show, tick: int, begins: bool) -> None:
        """Check that each measure begins once, in order, and that beats do not go back."""
        number, last = show.span.number, self._measure
        self._measure = number
        danced, before = show.danced_beats, self._last_danced_beat
        self._last_danced_beat = danced
        if not danced >= before - BEAT_TOLERANCE:
            self.add_problem(f"tick {tick}: the dance goes back from beat {before:.6f} to {danced:.6f}")
        if last is None:
            return
        step = number - last
        self.measure_count += max(step, 0)
        if step < 0:
            self.add_problem(f"tick {tick}: measure {number + 1} begins again after {last + 1}")
        elif (step > 0) != begins:
            self.add_problem(f"tick {tick}: measure {number + 1}: its begin and the reported begin do not match")
        elif step > 1:
            if self._skipped_seconds > 0.0:
                self.skipped_measures += step - 1
            else:
                self.add_problem(f"tick {tick}: measures {last + 2} to {number} are missed")
        if step <= 1 and begins:
            self._skipped_seconds = 0.0

    def resume(self, show: Show, tick: int) -> None:
        """Continue with the show of another engine, which is after `tick`; it may have crossed one measure line."""
        number, last = show.span.number, self._measure
        if last is not None and not last <= number <= last + 1:
            self.add_problem(
                f"tick {tick}: another engine resumes in measure {number + 1}, the last one was in {last + 1}"
            )
        self.measure_count += 0 if last is None else max(number - last, 0)
        self._measure, self._last_danced_beat = number, show.danced_beats

    def check_view(self, view: StageView, tick: int) -> None:
        """Check that the values of a snapshot for drawing are finite."""
        for name in CHECKED_ARRAYS:
            array = getattr(view, name)
            if array is not None and not np.isfinite(array).all():
                rows = np.unique(np.argwhere(~np.isfinite(array))[:, 0])
                where = f"in rows {', '.join(map(str, rows[:8]))} of {len(array)}, {len(rows)} in all"
                self.add_problem(
                    f"tick {tick}: the picture's {name} is not finite {where}; {view.phase:.3f} beats into the measure"
                )

    def add_problem(self, words: str) -> None:
        """Record a problem."""
        self.problem_count += 1
        if len(self.problems) < MAX_PROBLEMS:
            self.problems.append(words)


SALT = 0x9E91
REPLAYED_MEASURES = 24
"""Number of measures that are replayed from a snapshot."""


def check_replay(path: Path, *, seed: int = 0, parts: int = 3) -> dict[str, Any]:
    """Replay a journal: the whole of it, and as many `parts` from the snapshot before a measure drawn by `seed`.

    Returns the numbers of compared and different measures, the first differences (measure, tick, then, now), and
    problems as text. An exception of the replay is recorded as a problem, so there is always a report.
    """
    begin = _time.perf_counter()
    facts: dict[str, Any] = {"measures": 0, "different": 0, "differences": [], "problems": [], "stretches": 0}
    problems: list[str] = facts["problems"]
    try:
        journal = read_journal(path)
        loaded = load_journal(journal)
        found = run_from(first_start(journal, loaded), journal, loaded=loaded)
        _add_result(facts, found.measures, found.different, found.differences, found.problems)
        facts["speed"] = (found.ticks - found.first_tick) / 64.0 / max(_time.perf_counter() - begin, 1e-9)
        last = max((line.measure or 0 for line in journal.lines_with_damage()), default=0)
        chance = np.random.default_rng([seed, SALT])
        for measure in sorted(int(m) for m in chance.integers(2, max(3, last), parts if last > 2 else 0)):
            start = start_before(journal, loaded, measure, problems)
            found = run_from(start, journal, loaded=loaded, to=start.show.span.number + REPLAYED_MEASURES)
            _add_result(facts, found.measures, found.different, found.differences, found.problems)
            facts["stretches"] += 1
    except (JournalError, ReplayError) as error:
        problems.append(str(error))
    except Exception as error:  # the replay may raise the exception that ended the show: report it
        failure = Failure.from_exception(error)
        problems.append(f"the replay ends in an exception: {failure}")
        facts["failure"] = failure.facts()
    facts["took"] = _time.perf_counter() - begin
    return facts


def _add_result(
    facts: dict[str, Any], measures: int, different: int, differences: tuple[Any, ...], problems: list[str]
) -> None:
    facts["measures"] += measures
    facts["different"] += different
    facts["differences"] += list(differences)[: 20 - len(facts["differences"])]
    facts["problems"] += problems
