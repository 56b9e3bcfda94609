"""Tests of refusals: a count and the last reason."""

from live.show.desk.refusals import Refusals


def test_refusals_are_counted_and_last_reason_is_kept() -> None:
    refusals = Refusals()
    assert (refusals.count, refusals.last_reason) == (0, "")
    refusals.add("no such step")
    refusals.add("no such group")
    assert (refusals.count, refusals.last_reason) == (2, "no such group")
