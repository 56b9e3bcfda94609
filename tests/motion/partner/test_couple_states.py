"""Stances and turns of synthetic couples whose states are known; what is no state of a couple changes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.partner.couple_states import CoupleStates, Stance, recognise_states, transitions
from live.motion.partner.units import Hold
from live.motion.skeleton import SKELETON
from tests.motion.partner.made_couples import RATE, dancer, facing_couple, ramp, reaching

COUNT = 600
TURN = (3.0, 4.5)


def states_of(couple: tuple[Clip, Clip], holds: tuple[Hold, ...] = ()) -> CoupleStates:
    return recognise_states(*couple, holds=holds)


def held(leader: int, follower: int, begin: float = 0.0, end: float = 10.0) -> tuple[Hold, ...]:
    return (Hold(leader, follower, begin * RATE, end * RATE - 1.0),)


def test_a_couple_is_closed_while_it_is_in_embrace() -> None:
    distance = 1.2 - ramp(COUNT, 2.0, 3.0, 0.7) + ramp(COUNT, 6.0, 7.0, 0.7)
    found = states_of(facing_couple(COUNT, distance))
    closed = found.stance == Stance.CLOSED
    assert closed[round(3.0 * RATE) : round(6.0 * RATE)].all()
    assert not closed[: round(2.0 * RATE)].any()
    assert not closed[round(7.0 * RATE) :].any()
    away = facing_couple(COUNT, 0.5, np.pi)
    assert (states_of(away).stance == Stance.OPEN).all()  # near, back to front
    apart = dancer(0.0, 0.0, 0.0, COUNT), dancer(0.0, 0.5, np.pi, COUNT)
    assert (states_of(apart).stance == Stance.OPEN).all()  # near, face to face, and no hand at her back


def test_crosshand_is_right_hand_in_right_hand() -> None:
    couple = facing_couple(COUNT, 0.5)
    for leader, follower in ((0, 0), (0, 1), (1, 0), (1, 1)):
        found = states_of(couple, held(leader, follower, 2.0, 5.0))
        cross = found.stance >= Stance.OPEN_CROSSHAND
        assert cross.any() == (leader == follower == 1)
        if cross.any():
            assert np.flatnonzero(cross)[[0, -1]].tolist() == [round(2.0 * RATE), round(5.0 * RATE) - 1]
            assert set(found.stance[cross].tolist()) == {int(Stance.CLOSED_CROSSHAND)}


def test_palms_that_meet_are_found_without_written_holds() -> None:
    """Arms stretched to the sides: opposite each other, left meets right."""
    leader = dancer(0.0, 0.0, 0.0, COUNT)
    other = dancer(0.0, 0.1, np.pi, COUNT)
    pairs = {(one.leader_hand, one.follower_hand) for one in recognise_states(leader, other).holds}
    assert pairs == {(0, 1), (1, 0)}
    beside = dancer(0.0, 0.1, 0.0, COUNT)
    assert {(one.leader_hand, one.follower_hand) for one in recognise_states(leader, beside).holds} == {(0, 0), (1, 1)}


@pytest.mark.parametrize(("hand", "to_left", "kind"), [
    (1, True, "inside"), (1, False, "outside"), (0, True, "outside"), (0, False, "inside"), (None, True, "free"),
])  # fmt: skip
def test_a_turn_is_named_by_the_hand_that_is_held(hand: int | None, *, to_left: bool, kind: str) -> None:
    turn = ramp(COUNT, *TURN, 2.0 * np.pi if to_left else -2.0 * np.pi)
    found = states_of(facing_couple(COUNT, 0.9, turn), () if hand is None else held(0, hand))
    (one,) = found.turns
    assert one.kind == kind
    assert one.turns == (1.0 if to_left else -1.0)
    assert TURN[0] * RATE <= one.begin < one.end <= TURN[1] * RATE


@pytest.mark.parametrize("many", [1, 2, 3])
def test_whole_turns_are_counted(many: int) -> None:
    (one,) = states_of(facing_couple(COUNT, 0.9, ramp(COUNT, 2.0, 2.0 + 1.2 * many, 2.0 * np.pi * many))).turns
    assert one.turns == many


def test_a_hand_released_before_the_turn_has_led_it_and_one_long_before_has_not() -> None:
    couple = facing_couple(COUNT, 0.9, ramp(COUNT, *TURN, 2.0 * np.pi))
    assert states_of(couple, held(0, 1, 0.0, 2.8)).turns[0].kind == "inside"
    assert states_of(couple, held(0, 1, 0.0, 2.0)).turns[0].kind == "free"


def test_a_turn_is_raised_if_the_held_palm_is_as_high_as_the_head() -> None:
    leader, follower = facing_couple(COUNT, 0.9, ramp(COUNT, *TURN, 2.0 * np.pi))
    assert not states_of((leader, follower), held(0, 1)).turns[0].raised
    rotation = follower.rotation.copy()
    rotation[:, SKELETON.index("rightUpperArm")] = (np.cos(-np.pi / 4), 0.0, 0.0, np.sin(-np.pi / 4))  # arm up
    up = replace(follower, rotation=rotation)
    assert states_of((leader, up), held(0, 1)).turns[0].raised
    assert not states_of((leader, up), held(0, 0)).turns[0].raised  # the other hand is held


def test_a_couple_that_revolves_in_embrace_does_not_turn() -> None:
    angle = ramp(COUNT, 1.0, 8.0, 4.0 * np.pi)
    leader = reaching(dancer(0.0, 0.0, angle, COUNT))
    follower = dancer(0.5 * np.sin(angle), 0.5 * np.cos(angle), angle + np.pi, COUNT)
    found = states_of((leader, follower), held(0, 1))
    assert found.turns == ()
    assert (found.stance == Stance.CLOSED).all()


def test_a_leader_who_walks_around_her_and_a_cross_body_lead_are_no_turns() -> None:
    angle = ramp(COUNT, 2.0, 6.0, 2.0 * np.pi)
    around = dancer(np.sin(angle), np.cos(angle), angle + np.pi, COUNT)
    assert states_of((around, dancer(0.0, 0.0, 0.0, COUNT))).turns == ()
    leader = dancer(0.0, 0.0, ramp(COUNT, *TURN, np.pi), COUNT)  # she passes at his side and faces him again
    passes = ramp(COUNT, *TURN, np.pi)
    follower = dancer(0.6 * np.sin(passes), 0.6 * np.cos(passes), np.pi + passes, COUNT)
    assert states_of((leader, follower)).turns == ()


def test_where_and_which_way_a_couple_dances_does_not_matter() -> None:
    turn = ramp(COUNT, *TURN, 2.0 * np.pi)
    distance = 1.2 - ramp(COUNT, 6.0, 7.0, 0.7)
    one = states_of(facing_couple(COUNT, distance, turn), held(1, 1))
    yaw, x, z = 2.1, 3.0, -2.0
    leader = reaching(dancer(x, z, yaw, COUNT))
    follower = dancer(x + distance * np.sin(yaw), z + distance * np.cos(yaw), yaw + np.pi + turn, COUNT)
    other = states_of((leader, follower), held(1, 1))
    assert (one.stance == other.stance).mean() > 0.99
    assert [(each.kind, each.turns, each.begin) for each in one.turns] == [
        (each.kind, each.turns, each.begin) for each in other.turns
    ]


def test_a_mirrored_couple_turns_the_other_way_by_the_same_name() -> None:
    turn = ramp(COUNT, *TURN, 2.0 * np.pi)
    one = states_of(facing_couple(COUNT, 0.9, turn), held(0, 1)).turns[0]
    other = states_of(facing_couple(COUNT, 0.9, -turn), held(1, 0)).turns[0]
    assert (one.kind, one.turns) == (other.kind, -other.turns)


def test_transitions_name_the_stances_at_their_ends_and_the_turn_between() -> None:
    distance = 1.2 - ramp(COUNT, 4.4, 4.9, 0.7)
    found = states_of(facing_couple(COUNT, distance, ramp(COUNT, 2.8, 4.2, 2.0 * np.pi)), held(0, 1))
    cuts = np.array([0.5, 2.5, 5.5, 8.5]) * RATE
    assert [one.words for one in transitions(found, cuts)] == [
        "open, step, open", "open, inside turn, closed", "closed, step, closed",
    ]  # fmt: skip
    assert transitions(found, cuts[:1]) == ()
