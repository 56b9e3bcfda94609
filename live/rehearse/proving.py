"""Proving: the journal of a long run is replayed, from its start and from snapshots; states must be the same."""

import time as _time
from pathlib import Path
from typing import Any

import numpy as np

from live.rehearse.failure import Failure
from live.show.journal.journal_reading import JournalError, read_journal
from live.show.journal.replay import ReplayError, run_from
from live.show.journal.replay_start import first_start, loaded_by, start_before

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
