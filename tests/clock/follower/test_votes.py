"""Measure line voting: observations required before a tracker's measure line is adopted."""

import math
from collections.abc import Callable

import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from tests.fixtures.mostly_long import mostly_long

PERIOD, FIRST = 0.5, 0.3


class Tracker:
    """Reports steady beats, each with its number in the measure."""

    def __init__(self, *, follow_metre: bool = False) -> None:
        self.follower = TimelineFollower(tempo=120.0, follow_metre=follow_metre)
        self.metre, self.offset = 4, 0
        self.runner_up = (0, 0.0)
        self._beat = self._tick = 0

    def say(self, beats: int) -> list[tuple[float, int]]:
        """Reports beats; returns (measure line in the tracker's beats, beats per measure) after each."""
        found = []
        for _ in range(beats):
            time = FIRST + self._beat * PERIOD
            while self._tick * TICK < time:
                self._advance()
            self.follower.observe(
                time, PERIOD, 0.8, self._tick * TICK, beat=(self._beat - self.offset) % self.metre,
                beats_per_measure=self.metre, runner_up=self.runner_up[0], runner_up_share=self.runner_up[1],
            )  # fmt: skip
            self._beat += 1
            self._advance()
            self._advance()
            found.append(self.line())
        return found

    @property
    def time(self) -> float:
        """The last tick [s]."""
        return self._tick * TICK

    def line(self) -> tuple[float, int]:
        timeline = self.follower.timeline
        size = timeline.beats_per_measure
        zero = round(timeline.beat_at(self._tick * TICK) - (self._tick * TICK - FIRST) / PERIOD)
        return (timeline.measure_origin - zero) % size, size

    def _advance(self) -> None:
        self._tick += 1
        self.follower.advance(self._tick * TICK)

    def one_now(self) -> None:
        """Marks the latest reported beat as the downbeat."""
        self.follower.set_downbeat(FIRST + (self._beat - 1) * PERIOD)


def observations_until_change(tracker: Tracker, change: Callable[[], None]) -> int:
    """Number of observations after `change` until the measure line changes; 0 if it never does."""
    before = tracker.line()
    change()
    for count in range(1, 60):
        if tracker.say(1)[0] != before:
            return count
    return 0


def offset_change(tracker: Tracker, by: int) -> Callable[[], None]:
    def change() -> None:
        tracker.offset += by

    return change


@pytest.mark.parametrize("by", [1, 2, 3])
def test_new_measure_line_is_adopted_after_one_measure(by: int) -> None:
    tracker = Tracker()
    assert set(tracker.say(24)[12:]) == {(0.0, 4)}
    assert observations_until_change(tracker, offset_change(tracker, by)) == 4
    assert tracker.line() == (float(by), 4)


def test_three_beats_of_another_line_change_nothing() -> None:
    tracker = Tracker()
    tracker.say(24)
    for by in (1, 2, 3, 1, 2):
        tracker.offset = by
        assert set(tracker.say(3)) == {(0.0, 4)}
        tracker.offset = 0
        assert set(tracker.say(8)) == {(0.0, 4)}


@mostly_long("by", [1, 2, 3], quick=[0, 1])
def test_manual_line_never_moves_and_the_operator_is_asked_after_eight_measures(by: int) -> None:
    tracker = Tracker()
    tracker.say(26)
    tracker.one_now()
    hand = tracker.line()
    tracker.offset = int(hand[0])
    assert set(tracker.say(8)) == {hand}
    tracker.offset += by
    for beat in range(120):
        assert set(tracker.say(1)) == {hand}
        assert not tracker.follower.asks or beat >= 60  # 8 measures until it is likely, then 8 more
    assert tracker.follower.asks
    assert tracker.follower.runner_up == (by, 1.0)
    tracker.follower.take_runner_up(tracker.time)
    assert tracker.line() == ((hand[0] + by) % 4, 4)
    tracker.say(1)
    assert not tracker.follower.asks


@pytest.mark.parametrize("by", [1, 2, 3])
def test_the_tracker_names_a_runner_up_beside_the_line_by_hand(by: int) -> None:
    """The tracker keeps the line by hand and says what the music suggests: asked once that is likely for 8 measures."""
    tracker = Tracker()
    tracker.say(24)
    tracker.one_now()
    hand = tracker.line()
    tracker.offset = int(hand[0])
    tracker.runner_up = (by, 0.5)
    assert set(tracker.say(60)) == {hand}
    assert tracker.follower.runner_up == (by, 0.5)
    assert not tracker.follower.asks
    tracker.runner_up = (by, 0.95)
    assert set(tracker.say(31)) == {hand}
    assert not tracker.follower.asks
    tracker.say(3)
    assert tracker.follower.asks
    tracker.follower.hold(True, tracker.time)
    assert not tracker.follower.asks
    tracker.follower.hold(False, tracker.time)
    tracker.runner_up = (by, 0.6)
    tracker.say(2)
    assert not tracker.follower.asks


def test_without_a_hand_nobody_is_asked() -> None:
    tracker = Tracker()
    tracker.runner_up = (2, 0.99)
    tracker.say(80)
    assert tracker.follower.runner_up == (2, 0.99)
    assert not tracker.follower.asks


def test_without_a_runner_up_taking_it_is_refused() -> None:
    tracker = Tracker()
    tracker.say(24)
    before = tracker.line()
    tracker.follower.take_runner_up(tracker.time)
    assert tracker.line() == before
    assert "no other measure line" in tracker.follower.refusal


def test_after_the_end_of_the_music_other_music_moves_the_manual_line_after_four_measures() -> None:
    tracker = Tracker()
    tracker.say(26)
    tracker.one_now()
    hand = tracker.line()
    tracker.offset = int(hand[0])
    tracker.say(8)
    tracker.follower.silent(tracker.time)
    tracker.follower.found(tracker.time)
    assert set(tracker.say(20)) == {hand}
    assert observations_until_change(tracker, offset_change(tracker, 2)) == 16


@pytest.mark.parametrize("words", [{"runner_up": 4}, {"runner_up": -1}, {"runner_up_share": 1.5},
                                   {"runner_up_share": math.nan}])  # fmt: skip
def test_impossible_runner_ups_are_counted_and_ignored(words: dict[str, float]) -> None:
    tracker = Tracker()
    tracker.say(24)
    rejected = tracker.follower.rejected
    tracker.follower.observe(tracker.time, PERIOD, 0.8, tracker.time, beat=0, beats_per_measure=4, **words)  # type: ignore[arg-type]
    assert tracker.follower.rejected == rejected + 1


@pytest.mark.parametrize(("metre", "taken"), [(3, True), (7, True), (11, True), (13, False)])
def test_followed_metre_is_adopted_after_two_measures(metre: int, taken: bool) -> None:
    tracker = Tracker(follow_metre=True)
    tracker.say(4 * metre)

    def change() -> None:
        tracker.metre = metre

    assert observations_until_change(tracker, change) == (2 * metre if taken else 0)
    assert tracker.line()[1] == (metre if taken else 4)


def test_fixed_metre_is_not_changed_by_tracker() -> None:
    tracker = Tracker()
    tracker.say(24)
    tracker.metre = 3
    assert {size for _, size in tracker.say(30)} == {4}


@mostly_long(("since", "patience"), [(5.0, 2.0), (14.0, 8.0), (40.0, 8.0)], quick=[0, 1])
@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_new_tempo_level_is_adopted_sooner_in_first_ten_seconds(since: float, patience: float, factor: float) -> None:
    """A tracker that persistently reports half or double tempo is followed: with the first observation later than
    `patience` after the first two at that level.
    """
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


def test_sum_of_nudges_is_limited_to_half_a_second() -> None:
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
