"""Tests of consecutive slices, by which neighboring rows are corrected together."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from live.show.dancers.root_correction import consecutive_slices


@given(st.sets(st.integers(0, 60)))
def test_slices_contain_each_row_exactly_once(who):
    rows = np.array(sorted(who), np.int64)
    found = consecutive_slices(rows)
    assert [n for run in found for n in range(run.start, run.stop)] == sorted(who)
    assert all(one.stop < other.start for one, other in pairwise(found))
