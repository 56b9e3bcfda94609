"""Refusals are counted and the last is kept in words."""

from live.show.desk.refusals import Refusals


def test_they_are_counted_and_the_last_is_kept() -> None:
    refusals = Refusals()
    assert (refusals.count, refusals.last_reason) == (0, "")
    refusals.add("no such step")
    refusals.add("no such group")
    assert (refusals.count, refusals.last_reason) == (2, "no such group")
