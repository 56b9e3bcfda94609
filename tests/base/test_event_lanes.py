"""Priority queues: the last value of a key remains, order is kept, and a flood starves no other sender."""

import threading

from hypothesis import given
from hypothesis import strategies as st

from live.base.event_queue import EventQueue, PriorityQueue

actions_of_two = st.lists(st.one_of(st.none(), st.sampled_from("abcx")), max_size=60)


@given(actions_of_two, st.integers(4, 9))
def test_reader_ends_with_the_last_value_of_every_key(actions, capacity):
    """None takes one item; x has no key. Without drops, a reader ends with the same values of all keys."""
    lane, taken, put = PriorityQueue(capacity), [], []
    for number, action in enumerate(actions):
        if action is None:
            taken.append(lane.pop())
        else:
            put.append((action, number))
            lane.put(put[-1], None if action == "x" else action)
    while (item := lane.pop()) is not None:
        taken.append(item)
    taken = [item for item in taken if item is not None]
    assert len(taken) + lane.dropped + lane.replaced == len(put)
    if not lane.dropped:
        assert dict(taken) == dict(put)
        for row in (taken, put):  # x are all there, and what was put between two of them is taken between them
            before = 0
            for name, number in row:
                before = number if name == "x" else before
                assert number >= before
        assert [item for item in taken if item[0] == "x"] == [item for item in put if item[0] == "x"]


def test_value_does_not_overtake_items_put_between():
    lane = PriorityQueue()
    for item, key in (("light 0", "light"), ("scene", None), ("light 1", "light"), ("light 2", "light")):
        lane.put(item, key)
    assert [lane.pop() for _ in range(4)] == ["light 0", "scene", "light 2", None]
    assert lane.replaced == 1


def test_last_value_survives_concurrent_writer_and_reader():
    lane, last = PriorityQueue(), 30_000
    writer = threading.Thread(target=lambda: [lane.put((key, k), key) for k in range(last + 1) for key in "ab"])
    writer.start()
    seen, counts = {}, 0
    while writer.is_alive() or len(lane):
        item = lane.pop()
        if item is not None:
            counts += 1
            assert item[1] >= seen.get(item[0], 0)
            seen[item[0]] = item[1]
    writer.join()
    assert seen == {"a": last, "b": last}
    assert lane.dropped == 0
    assert counts >= 2


def test_flooding_queue_starves_no_other_queue():
    inbox = EventQueue()
    flood, quiet = inbox.add_queue(100), inbox.add_queue(100)
    for number in range(1000):
        flood.put(("flood", number))
    quiet.put("quiet")
    inbox.put("key")
    assert inbox.drain(3) == ["key", ("flood", 900), "quiet"]
    assert inbox.dropped == 900
    assert len(inbox) == 99
    assert inbox.drain() == [("flood", number) for number in range(901, 1000)]
