"""Kept journals of past failures (`live soak --minimise`): none of them fails again."""

import pytest

from live.rehearse.journal_minimiser import Trial, entries_of, load_for_journal
from live.show.journal.journal_reader import read_journal
from tests.fixtures.mostly_long import mostly_long
from tests.places import ROOT

KEPT = ROOT / "tests" / "journals"
MORE = 256
"""Ticks that the show runs on after the former failure."""


@pytest.mark.parametrize("path", sorted(KEPT.glob("*.jsonl")), ids=lambda path: path.stem)
@mostly_long("snapshots", [False, True], quick=[0], ids=["run through", "from a snapshot"])
def test_kept_journal_does_not_fail_again(path, snapshots):
    journal = read_journal(path)
    entries, end = entries_of(journal)
    assert entries
    assert end > 0
    trial = Trial(load_for_journal(journal), journal.header, snapshots=snapshots)
    assert trial.run(entries, end + MORE) is None
    assert len(trial.measure_ticks) >= 2
