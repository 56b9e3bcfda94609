"""Neighbours are traced together."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from live.show.dancers.root_correction import consecutive_slices


@given(st.sets(st.integers(0, 60)))
def test_runs_hold_everybody_once_and_nobody_else(who):
    rows = np.array(sorted(who), np.int64)
    found = consecutive_slices(rows)
    assert [n for run in found for n in range(run.start, run.stop)] == sorted(who)
    assert all(one.stop < other.start for one, other in pairwise(found))
