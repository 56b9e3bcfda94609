"""Measure lines: how often a tracker has to say a line until it is danced, counted statement by statement."""

import math
from collections.abc import Callable

import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK

PERIOD, FIRST = 0.5, 0.3


class Tracker:
    """Says beat after beat of even music, each with its number in the measure."""

    def __init__(self, *, follow_metre: bool = False) -> None:
        self.follower = TimelineFollower(tempo=120.0, follow_metre=follow_metre)
        self.metre, self.offset = 4, 0
        self._beat = self._tick = 0

    def say(self, beats: int) -> list[tuple[float, int]]:
        """So many beats; (the line's place in the tracker's beats, beats of a measure) as danced after each."""
        found = []
        for _ in range(beats):
            time = FIRST + self._beat * PERIOD
            while self._tick * TICK < time:
                self._advance()
            self.follower.observe(
                time, PERIOD, 0.8, self._tick * TICK, beat=(self._beat - self.offset) % self.metre,
                beats_per_measure=self.metre,
            )  # fmt: skip
            self._beat += 1
            self._advance()
            self._advance()
            found.append(self.line())
        return found

    def line(self) -> tuple[float, int]:
        timeline = self.follower.timeline
        size = timeline.beats_per_measure
        zero = round(timeline.beat_at(self._tick * TICK) - (self._tick * TICK - FIRST) / PERIOD)
        return (timeline.measure_origin - zero) % size, size

    def _advance(self) -> None:
        self._tick += 1
        self.follower.advance(self._tick * TICK)

    def one_now(self) -> None:
        """The hand: the beat that was said last is the first."""
        self.follower.set_downbeat(FIRST + (self._beat - 1) * PERIOD)


def until_taken(tracker: Tracker, change: Callable[[], None]) -> int:
    """How many statements after `change` the line that is danced is another."""
    before = tracker.line()
    change()
    for count in range(1, 60):
        if tracker.say(1)[0] != before:
            return count
    return 0


def shifted(tracker: Tracker, by: int) -> Callable[[], None]:
    def change() -> None:
        tracker.offset += by

    return change


@pytest.mark.parametrize("by", [1, 2, 3])
def test_another_line_is_danced_when_a_whole_measure_has_said_so(by: int) -> None:
    tracker = Tracker()
    assert set(tracker.say(24)[12:]) == {(0.0, 4)}
    assert until_taken(tracker, shifted(tracker, by)) == 4
    assert tracker.line() == (float(by), 4)


def test_three_beats_of_another_line_change_nothing() -> None:
    tracker = Tracker()
    tracker.say(24)
    for by in (1, 2, 3, 1, 2):
        tracker.offset = by
        assert set(tracker.say(3)) == {(0.0, 4)}
        tracker.offset = 0
        assert set(tracker.say(8)) == {(0.0, 4)}


@pytest.mark.parametrize("by", [1, 3])
def test_the_hands_line_holds_until_the_tracker_has_agreed_and_insists_for_four_measures(by: int) -> None:
    tracker = Tracker()
    tracker.say(26)
    tracker.one_now()
    hand = tracker.line()
    assert hand != (0.0, 4)
    assert set(tracker.say(60)) == {hand}, "it has never agreed"
    tracker.offset = int(hand[0])
    assert set(tracker.say(8)) == {hand}
    assert until_taken(tracker, shifted(tracker, by)) == 16


@pytest.mark.parametrize(("metre", "taken"), [(3, True), (7, True), (11, True), (13, False)])
def test_a_metre_is_taken_after_two_measures_where_music_may_change_it(metre: int, taken: bool) -> None:
    tracker = Tracker(follow_metre=True)
    tracker.say(4 * metre)

    def change() -> None:
        tracker.metre = metre

    assert until_taken(tracker, change) == (2 * metre if taken else 0)
    assert tracker.line()[1] == (metre if taken else 4)


def test_where_music_may_not_change_it_the_metre_stays() -> None:
    tracker = Tracker()
    tracker.say(24)
    tracker.metre = 3
    assert {size for _, size in tracker.say(30)} == {4}


@pytest.mark.parametrize(("since", "patience"), [(5.0, 2.0), (14.0, 8.0), (40.0, 8.0)])
@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_another_level_of_the_same_music_is_followed_sooner_in_the_first_ten_seconds(
    since: float, patience: float, factor: float
) -> None:
    """A tracker that takes every second beat for the beat, or the half beats, is obeyed when it insists: with the first
    statement that comes later than `patience` after those two that told of it."""
    follower, period = TimelineFollower(tempo=100.0), 0.6
    time, beat, now, switched, obeyed = FIRST, 0, 0.0, 0.0, 0.0
    while not obeyed and now < since + 20.0:
        now += TICK
        if now >= time:
            follower.observe(time, period, 0.8, now, beat=beat % 4, beats_per_measure=4)
            if not switched and now > since and beat % 4 == 0:
                switched, period = now, period * factor
            time, beat = time + period, beat + 1
        follower.advance(now)
        if switched and follower.tempo == pytest.approx(100.0 / factor, rel=0.02):
            obeyed = now - switched
        assert follower.tempo == pytest.approx(100.0, rel=0.02) or obeyed or now < 4.0
    due = (2 + math.floor(patience / period) + 1) * period
    assert obeyed == pytest.approx(due, abs=0.05)


def test_nudges_add_up_to_half_a_second_at_most() -> None:
    tracker = Tracker()
    tracker.say(24)
    follower = tracker.follower
    before = follower._slewed.goal
    for _ in range(4):
        follower.nudge(0.2, before.time)
    tracker.say(8)
    goal = follower._slewed.goal
    assert (goal.time - before.time) % PERIOD == pytest.approx(0.0, abs=0.005), "0.5 s, a whole beat here"
    follower.nudge(-0.3, goal.time)
    tracker.say(8)
    assert (follower._slewed.goal.time - before.time) % PERIOD == pytest.approx(0.2, abs=0.005)
