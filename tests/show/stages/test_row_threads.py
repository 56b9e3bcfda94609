"""Tests of threads that share rows: every row is done once, errors arrive, nobody waits for a thread without work."""

import os
import threading

import numpy as np
import pytest

from bench._show import crowd
from live.clock.ticks import TICK
from live.show.stages.row_threads import RowThreads, row_threads

DEADLINE = 20.0


@pytest.fixture
def runner():
    with row_threads(3) as found:
        yield found


def test_every_row_is_done_once(runner):
    done = np.zeros(1000, np.int64)

    def part(begin, end):
        done[begin:end] += 1

    for each in range(1, 200):
        runner.run(part, [(begin, begin + 100) for begin in range(0, 1000, 100)])
        assert (done == each).all()


def test_ranges_run_at_the_same_time(runner):
    meeting = threading.Barrier(3)
    runner.run(lambda begin, end: meeting.wait(DEADLINE), [(0, 1), (1, 2), (2, 3)])  # raises unless three threads come


def test_error_of_a_range_arrives_after_all_others_are_done(runner):
    done = []

    def part(begin, end):
        if begin == 3:
            raise ValueError("three")
        done.append(begin)

    with pytest.raises(ValueError, match="three"):
        runner.run(part, [(begin, begin + 1) for begin in range(20)])
    assert sorted(done) == [begin for begin in range(20) if begin != 3]
    runner.run(part, [(50, 51), (51, 52)])
    assert {50, 51} < set(done)


def test_call_within_a_range_and_beside_a_long_one_is_done_by_its_own_thread(runner):
    inner, own = [], threading.get_ident()
    entered, free = threading.Event(), threading.Event()

    def long(begin, end):
        entered.set()
        runner.run(lambda begin, end: inner.append(begin), [(7, 8), (8, 9)])
        assert free.wait(DEADLINE)

    other = threading.Thread(target=lambda: runner.run(long, [(0, 1), (1, 2)]))
    other.start()
    assert entered.wait(DEADLINE)
    who = []
    runner.run(lambda begin, end: who.append(threading.get_ident()), [(0, 1), (1, 2)])
    assert who == [own, own]
    free.set()
    other.join(DEADLINE)
    assert sorted(inner) == [7, 7, 8, 8]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork is there on POSIX only")
def test_forked_process_does_all_rows_without_the_threads_it_lost():
    runner = RowThreads(3)
    child = os.fork()
    if child == 0:  # only the forking thread exists here
        done = []
        for _ in range(10):
            runner.run(lambda begin, end: done.append(begin), [(0, 1), (1, 2), (2, 3)])
        os._exit(0 if sorted(done) == [0] * 10 + [1] * 10 + [2] * 10 else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    runner.close()


@pytest.mark.long
def test_show_has_the_same_bits_for_any_number_of_threads():
    hashes = []
    for threads in (1, 2, 3):
        with row_threads(threads):
            show, found = crowd(600), []
            for tick in range(1, 161):
                if show.tick(tick * TICK) or tick % 40 == 0:
                    found.append(show.state_hash())
        hashes.append(found)
    assert len(hashes[0]) > 4
    assert hashes[0] == hashes[1] == hashes[2]
