"""Tests of the hands that a live follower holds: those that probably hold, one hand for each, without flicker."""

import numpy as np
import pytest

from live.motion.partner.units import Hold
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.follower_moments import HOLDS
from live.motion.partner_live.online_player import NOBODY, RELEASE_HOLD, TAKE_HOLD, LivePartner
from tests.motion.partner_live.led_pairs import follow, led_pair

BETWEEN = 0.5 * (TAKE_HOLD + RELEASE_HOLD)


@pytest.fixture(scope="module")
def partner() -> LivePartner:
    return LivePartner(FollowerFilter(led_pair(61)[1], rate=30.0))


def hands_after(partner: LivePartner, *likely: tuple[float, float, float, float]) -> tuple[int, int]:
    """The held hands after these probabilities: the leader's left with left and right, his right with both."""
    partner.hands = (NOBODY, NOBODY)
    for values in likely:
        partner.filter.expected[HOLDS] = values
        partner._update_hands()
    return partner.hands


def test_likely_hold_is_taken_and_kept_until_unlikely(partner: LivePartner) -> None:
    assert hands_after(partner, (0.0, 0.9, 0.0, 0.0)) == (NOBODY, 0)
    assert hands_after(partner, (0.0, BETWEEN, 0.0, 0.0)) == (NOBODY, NOBODY)
    assert hands_after(partner, (0.0, 0.9, 0.0, 0.0), (0.0, BETWEEN, 0.0, 0.0)) == (NOBODY, 0)
    assert hands_after(partner, (0.0, 0.9, 0.0, 0.0), (0.0, 0.9 * RELEASE_HOLD, 0.0, 0.0)) == (NOBODY, NOBODY)


def test_each_hand_holds_one_hand(partner: LivePartner) -> None:
    assert hands_after(partner, (0.9, 0.0, 0.0, 0.8)) == (0, 1)
    assert hands_after(partner, (0.9, 0.8, 0.0, 0.0)) == (0, NOBODY)
    assert hands_after(partner, (0.7, 0.8, 0.0, 0.0)) == (NOBODY, 0)


def test_recorded_holds_are_held_when_the_leader_dances_as_recorded() -> None:
    """One hold of three seconds, in the middle of twelve: it is held then, and not for long at any other time."""
    leader, units = led_pair(62, 720, (Hold(0, 1, 240.0, 420.0),))
    held = np.array([partner.hands[1] == 0 for partner in follow(leader, units)])
    time = np.arange(len(held)) / 30.0
    assert held[(time > 4.3) & (time < 6.7)].mean() > 0.9
    assert held[(time < 3.5) | (time > 7.5)].mean() < 0.1
