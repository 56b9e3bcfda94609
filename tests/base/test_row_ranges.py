"""Tests of ranges of rows: they cover all rows once, at block boundaries, and serve the installed runner."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.row_ranges import cut_rows, row_runner, run_rows


@given(st.integers(0, 5000), st.integers(1, 40), st.integers(1, 64))
def test_ranges_cover_all_rows_once_from_block_to_block(count, pieces, block):
    ranges = cut_rows(count, pieces, block)
    assert [row for begin, end in ranges for row in range(begin, end)] == list(range(count))
    assert all(begin % block == 0 and end > begin for begin, end in ranges)
    assert len(ranges) <= pieces
    sizes = [end - begin for begin, end in ranges]
    assert not sizes or max(sizes) - min(sizes) < 2 * block


class Recorder:
    def __init__(self, threads):
        self.threads, self.ranges = threads, []

    def run(self, part, ranges):
        self.ranges.append(list(ranges))
        for begin, end in ranges:
            part(begin, end)


@pytest.mark.parametrize(("threads", "count", "pieces"), [(1, 9999, 0), (2, 199, 0), (2, 250, 2), (2, 9999, 8)])
def test_rows_are_cut_only_where_that_is_worth_it(threads, count, pieces):
    recorder, done = Recorder(threads), []
    with row_runner(recorder):
        run_rows(lambda begin, end: done.extend(range(begin, end)), count, least=100)
    assert sum(map(len, recorder.ranges)) == pieces
    assert done == list(range(count))


def test_runner_serves_its_block_only():
    recorder = Recorder(2)
    with row_runner(recorder), pytest.raises(ZeroDivisionError):
        run_rows(lambda begin, end: 1 // 0, 10, least=1)
    run_rows(lambda begin, end: None, 10, least=1)
    assert len(recorder.ranges) == 1
