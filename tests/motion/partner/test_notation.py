"""Notation of made walks and turns: supports alternate, directions and eighths of turns are those that were made."""

from itertools import pairwise

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.partner.couple_states import recognise_states
from live.motion.partner.notation import DIRECTIONS, CountNotation, notate, notation_text
from live.motion.partner.units import Hold
from tests.motion.partner.made_couples import RATE, dancer, ramp, reaching
from tests.motion.partner.made_walks import CYCLE_S, walk

SECONDS = 6.0
COUNT = round(SECONDS * RATE) + 1
BEATS = np.arange(0.0, SECONDS, 0.5 * CYCLE_S) * RATE


def notated(leader: Clip, follower: Clip, holds: tuple[Hold, ...] = (), first: int = 0) -> tuple[CountNotation, ...]:
    return notate(leader, follower, recognise_states(leader, follower, holds=holds), BEATS, counts=8, first=first)


@pytest.mark.parametrize("eighth", range(8))
def test_direction_is_that_in_which_the_weight_moves_as_the_dancer_faces(eighth: int) -> None:
    way, heading = eighth * np.pi / 4.0, 0.7
    far = 0.8 * np.arange(COUNT) / RATE
    moving = dancer(far * np.sin(heading + way), far * np.cos(heading + way), heading, COUNT)
    found = notated(dancer(3.0, 0.0, 0.0, COUNT), moving)
    assert {one.follower.direction for one in found} == {DIRECTIONS[eighth]}
    assert {one.leader.direction for one in found} == {"place"}
    assert {one.leader.support for one in found} == {"hold"}


def test_a_walk_steps_left_and_right_in_turn_forward() -> None:
    walker = walk("walk", [], SECONDS)
    found = notated(walker, walker)
    supports = [one.follower.support for one in found[1:]]
    assert set(supports) == {"left", "right"}
    assert all(one != other for one, other in pairwise(supports))
    assert {one.follower.direction for one in found} == {"forward"}
    assert [one.leader for one in found] == [one.follower for one in found]


@pytest.mark.parametrize("turns", [1.0, -1.0, 2.0])
def test_eighths_of_turns_add_up_to_the_turn(turns: float) -> None:
    turning = dancer(0.0, 1.0, np.pi + ramp(COUNT, 1.0, 5.0, 2.0 * np.pi * turns), COUNT)
    found = notated(dancer(0.0, 0.0, 0.0, COUNT), turning)
    assert sum(one.follower.turn for one in found) == pytest.approx(8 * turns, abs=1)
    assert all(one.follower.turn * turns >= 0 for one in found)
    assert any(one.turn for one in found)


def test_levels_are_of_the_hips_against_their_usual_height() -> None:
    bent = dancer(0.0, 1.0, np.pi, COUNT)
    root = bent.root_position.copy()
    root[round(1.0 * RATE) : round(1.5 * RATE), 1] -= 0.1
    root[round(3.0 * RATE) : round(3.5 * RATE), 1] += 0.06
    found = notated(dancer(0.0, 0.0, 0.0, COUNT), Clip("bent", root, bent.rotation.copy(), RATE, bent.contact.copy()))
    levels = [one.follower.level for one in found]
    assert levels[2] == "low"
    assert levels[6] == "high"
    assert levels[4] == "middle"


def test_counts_hands_and_lines_of_the_text() -> None:
    couple = reaching(dancer(0.0, 0.0, 0.0, COUNT)), dancer(0.0, 0.5, np.pi, COUNT)
    found = notated(*couple, (Hold(0, 1, 0.0, 2.0 * RATE), Hold(1, 1, 2.0 * RATE, 10.0 * RATE)), first=2)
    assert [one.count for one in found[:4]] == [7, 8, 1, 2]
    assert [one.hands for one in found][:2] == ["left-right", "left-right"]
    assert found[-1].hands == "right-right"
    assert found[-1].stance.words == "closed crosshand"
    text = notation_text(found, names=[f"unit {n}" for n in range(len(found))])
    assert len(text.splitlines()) == len(found) + 1
    assert text.splitlines()[-1].endswith(f"unit {len(found) - 1}")
    assert notate(*couple, recognise_states(*couple), np.zeros(0), counts=8) == ()
