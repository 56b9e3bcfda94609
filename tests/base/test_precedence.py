"""Precedence: the value of a higher rank is kept, but only while its sender is active."""

from hypothesis import given
from hypothesis import strategies as st

from live.base.event_queue import PRECEDENCE_HOLD, EventQueue, Precedence

SET = st.lists(st.tuples(st.sampled_from("ab"), st.integers(0, 2), st.floats(0.0, 0.2)), max_size=40)


@given(SET)
def test_value_is_refused_only_after_recent_higher_rank(sets):
    """Against the rule evaluated over the whole history."""
    precedence, history, now, outranked = Precedence(), [], 0.0, 0
    for key, rank, pause in sets:
        now += pause
        last = next((item for item in reversed(history) if item[0] == key), None)
        counts = last is None or rank >= last[1] or now - last[2] >= PRECEDENCE_HOLD
        assert precedence.accepts(key, rank, now) == counts
        outranked += not counts
        if counts:
            history.append((key, rank, now))
    assert precedence.outranked == outranked


def test_operator_value_wins_in_any_order():
    for operator_first in (True, False):
        inbox = EventQueue()
        lanes = [inbox.add_queue(rank=rank) for rank in ((2, 1) if operator_first else (1, 2))]
        for lane in lanes:
            lane.put(f"{lane.rank}", "level")
            lane.put(f"other {lane.rank}", ("level", lane.rank))
            lane.put(f"once {lane.rank}")
        taken = inbox.drain(now=5.0)
        assert [item for item in taken if item in ("1", "2")][-1] == "2"
        assert {"other 1", "other 2", "once 1", "once 2"} <= set(taken), "nothing else gives way"
        assert inbox.outranked == operator_first
        lanes[operator_first].put("1 again", "level")
        assert inbox.drain(now=5.0 + PRECEDENCE_HOLD * 0.9) == []
        lanes[operator_first].put("1 again", "level")
        assert inbox.drain(now=5.0 + PRECEDENCE_HOLD * 1.1) == ["1 again"]


def test_precedence_memory_is_bounded():
    precedence = Precedence()
    for number in range(20_000):
        assert precedence.accepts(number, 2, 1.0)
    assert len(precedence._set) <= 4096
