"""EventQueue: capacity, order, counts, and concurrent writers."""

import threading

from hypothesis import given
from hypothesis import strategies as st

from live.base.event_queue import EventQueue


@given(st.lists(st.one_of(st.integers(0, 99), st.none()), max_size=60), st.integers(1, 8))
def test_every_lost_item_is_counted(actions, capacity):
    """None drains, a number is put: always put = drained + waiting + dropped, and order is kept."""
    inbox = EventQueue(capacity)
    put, drained = 0, []
    for action in actions:
        if action is None:
            drained += inbox.drain()
        else:
            inbox.put((put, action))
            put += 1
    assert put == len(drained) + len(inbox) + inbox.dropped
    assert drained == sorted(drained)
    assert len(inbox) <= capacity


def test_drain_limit_leaves_the_rest():
    inbox = EventQueue(10)
    for number in range(5):
        inbox.put(number)
    assert inbox.drain(2) == [0, 1]
    assert inbox.drain() == [2, 3, 4]
    assert inbox.drain() == []


def test_quiet_queue_is_drained_before_full_queues():
    inbox = EventQueue()
    lanes, quiet = [inbox.add_queue() for _ in range(40)], inbox.add_queue()
    for number in range(30):
        for lane in lanes:
            lane.put(number)
    assert inbox.drain(100).count(0) == 40
    quiet.put("operator")
    assert inbox.drain(1) == ["operator"]
    quiet.put("once more")
    assert inbox.drain(80).count("once more") == 1  # in its turn
    assert len(inbox.drain()) == 40 * 30 + 2 - 181


def test_value_limit_does_not_hold_back_events():
    inbox = EventQueue()
    flooded, taps = inbox.add_queue(), inbox.add_queue()
    for number in range(5):
        flooded.put(number, key=number)
        taps.put(f"tap {number}")
    flooded.put("after the values")
    assert [item for _, item in inbox.drain_keyed(None, 0.0, 2)] == [0, "tap 0", 1, "tap 1", "tap 2", "tap 3", "tap 4"]
    assert [item for _, item in inbox.drain_keyed(None, 0.0, 0)] == []
    assert [item for _, item in inbox.drain_keyed(None, 0.0, 9)] == [2, 3, 4, "after the values"]
    assert inbox.received_count == 11


def test_concurrent_writers_keep_their_order():
    inbox = EventQueue(1000)
    writers = [threading.Thread(target=lambda w=w: [inbox.put((w, k)) for k in range(5000)]) for w in range(4)]
    taken = []
    for writer in writers:
        writer.start()
    while any(writer.is_alive() for writer in writers):
        taken += inbox.drain()
    taken += inbox.drain()
    assert len(taken) + inbox.dropped == 20000
    for w in range(4):
        own = [k for writer, k in taken if writer == w]
        assert own == sorted(own)
