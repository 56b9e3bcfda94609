"""Agreement of an answer with the real follower: all of it with herself, counts that are known, labels of a person."""

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.partner.couple_comparison import (
    ComparedDance,
    Count,
    LabelSpan,
    compare_couples,
    danced_labels,
    transition_cuts,
)
from live.motion.partner.couple_states import recognise_states, transitions
from live.motion.partner.decoder import Reading
from live.motion.partner.units import Hold
from tests.motion.partner.made_couples import RATE, dancer, facing_couple, ramp
from tests.motion.partner.made_examples import made_units

COUNT = 960
CUTS = np.arange(0.0, COUNT, 2.0 * RATE)


def danced(leader: Clip, follower: Clip, holds: tuple[Hold, ...] = ()) -> ComparedDance:
    states = recognise_states(leader, follower, holds=holds)
    return ComparedDance(follower, states, transitions(states, CUTS))


def test_an_answer_that_is_the_real_follower_agrees_in_all() -> None:
    leader, follower = facing_couple(COUNT, 1.2 - ramp(COUNT, 4.2, 5.0, 0.7), ramp(COUNT, 2.2, 3.4, 2.0 * np.pi))
    one = danced(leader, follower)
    told = compare_couples(leader, one, one)
    assert (told.joint_m, told.facing_deg, told.turned_share) == (0.0, 0.0, 0.0)
    for count in (told.stance, told.embrace, told.turns, told.turn_kinds, told.transitions, told.pattern_count):
        assert count.of > 0
        assert count.same == count.of
    assert not told.labelled
    assert len(told.patterns) == len(one.transitions) // 2


def test_what_differs_is_counted_where_it_differs() -> None:
    """The answer turns the other way and stays open for the second half; her place is 0.3 m off."""
    leader, follower = facing_couple(COUNT, 1.2 - ramp(COUNT, 8.2, 8.6, 0.7), ramp(COUNT, 2.2, 3.4, 2.0 * np.pi))
    answer = dancer(0.3, 1.2, np.pi - ramp(COUNT, 2.2, 3.4, 2.0 * np.pi), COUNT)
    hold = (Hold(0, 1, 0.0, COUNT - 1.0),)
    told = compare_couples(leader, danced(leader, follower, hold), danced(leader, answer, hold))
    assert told.turns == Count(0, 2)
    assert told.turn_kinds == Count(0, 0)
    assert told.turn_kinds.share is None
    assert told.stance.share == pytest.approx(8.45 / 16.0, abs=0.02)
    assert [one.same for one in told.patterns] == [False, True, False]  # turn; the same; closed
    assert told.patterns[1].joint_m == pytest.approx(0.3, abs=1e-3)


def spans(*labels: str | None, seconds: float = 2.0) -> list[LabelSpan]:
    return [LabelSpan(n * seconds, (n + 1) * seconds, label) for n, label in enumerate(labels)]


def test_labels_are_compared_as_the_paper_compares_patterns() -> None:
    leader, follower = facing_couple(COUNT, 1.0)
    one = danced(leader, follower)
    real = spans("basic", "turn", "basic", seconds=4.0)
    answer = [
        *spans("basic", "basic", "turn", "basic", "turn", "turn", "turn", None, "basic", "basic", "basic", "turn",
               seconds=1.0),
    ]  # fmt: skip
    told = compare_couples(leader, one, one, real, answer)
    assert told.labelled
    assert [(each.real, each.answer, each.same, each.whole) for each in told.patterns] == [
        ("basic", "basic", True, False), ("turn", "turn", True, False), ("basic", "basic", True, False),
    ]  # fmt: skip
    assert told.units == Count(3 + 3 + 3, 11)  # the one without a label does not count
    whole = compare_couples(leader, one, one, real, spans(*"bbbb", seconds=1.0))
    assert whole.pattern_count == Count(0, 1)  # of the others it cannot be told
    assert [each.known for each in whole.patterns] == [True, False, False]
    assert [each.answer for each in whole.patterns][1:] == ["no label", "no label"]
    same = compare_couples(leader, one, one, real, real)
    assert same.whole_count == Count(3, 3)


def test_units_carry_the_labels_of_their_recordings() -> None:
    units = made_units(5, 6)
    order = np.array([4, 0, 3])
    middles = (units.start + 0.5 * units.length) / units.rate
    duration = np.array([40, 50, 45])
    start = np.array([0, 40, 90])
    reading = Reading(
        order, start, duration, np.ones(3, np.complex128), np.zeros(3, np.complex128), np.zeros(3), np.zeros(2),
        0.0, 60.0,
    )  # fmt: skip
    asked: list[tuple[str, float]] = []

    def label_at(name: str, time: float) -> str | None:
        asked.append((name, time))
        return {0: "x", 3: None, 4: "y"}[int(np.argmin(np.abs(middles - time)))]

    found = danced_labels(reading, units, label_at)
    assert [one.label for one in found] == ["y", "x", None]
    assert [(one.begin, one.end) for one in found] == [(0.0, 40 / 60), (40 / 60, 1.5), (1.5, 2.25)]
    assert [name for name, _ in asked] == ["made"] * 3
    np.testing.assert_allclose([time for _, time in asked], middles[order])


def test_cuts_are_every_nth_beat_from_a_one_on_that_lie_inside() -> None:
    beats = np.arange(-1.0, 20.0)
    assert transition_cuts(beats, 15.0, first=2, beats_each=4).tolist() == [1.0, 5.0, 9.0, 13.0]
    assert transition_cuts(beats, 15.0, first=6, beats_each=4).tolist() == [1.0, 5.0, 9.0, 13.0]
    assert transition_cuts(np.zeros(0), 15.0, first=0, beats_each=4).tolist() == []
