"""Tests of the task queue: all tasks run in order within the available ticks, each tick near its share."""

import numpy as np

from live.show.background_work import MAX_SHARE, TaskQueue


def test_tasks_run_in_order_and_evenly():
    chance = np.random.default_rng(4)
    weights, done = chance.uniform(1.0, 40.0, 60), []
    pieces = TaskQueue()
    pieces.extend((weight, lambda n=n: done.append(n)) for n, weight in enumerate(weights))
    ticks, left, before = 20, weights.sum(), 0
    for tick in range(ticks):
        share = left / (ticks - tick)
        pieces.run_share(ticks - tick)
        of_tick = weights[before : len(done)]
        if len(of_tick) > 1 and tick < ticks - 1:
            assert of_tick.sum() <= MAX_SHARE * share + 1e-9
        left, before = left - of_tick.sum(), len(done)
    assert done == list(range(60))
    assert not pieces


def test_remaining_tasks_run_at_once():
    done = []
    pieces = TaskQueue()
    pieces.extend((1.0, lambda n=n: done.append(n)) for n in range(5))
    pieces.run_share(5)
    assert done == [0]
    assert pieces
    pieces.run_all()
    assert done == list(range(5))


def test_cleared_tasks_never_run():
    done = []
    pieces = TaskQueue()
    pieces.extend((2.0, lambda n=n: done.append(n)) for n in range(5))
    pieces.run_share(5)
    pieces.clear()
    assert not pieces
    assert pieces.remaining == 0.0
    pieces.extend([(3.0, lambda: done.append("new"))])
    assert pieces.remaining == 3.0
    pieces.run_all()
    assert done == [0, "new"]


def test_inserted_pieces_come_before_those_that_wait_and_count_in_the_share():
    done, queue = [], TaskQueue()
    queue.extend([(1.0, lambda: queue.insert([(4.0, lambda: done.append("a")), (4.0, lambda: done.append("b"))]))])
    queue.extend([(1.0, lambda: done.append("last"))])
    queue.run_share(2)
    assert not done
    assert queue.remaining == 9.0
    queue.run_share(2)
    assert done == ["a"]
    assert queue.remaining == 5.0
    queue.run_all()
    assert done == ["a", "b", "last"]
    assert queue.remaining == 0.0
