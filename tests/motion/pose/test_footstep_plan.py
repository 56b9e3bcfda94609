"""Tests of root warp: shifts come in during swings, shared among stances; reach margins keep legs within reach."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.pose.root_warp import LEG_LENGTH, compute_reach_margin, compute_warp_curve, initial_hold_shares
from live.motion.pose.root_warp_kernels import DIRECTIONS, KNOTS, WARP_RATE, WARP_SHARE, margin_towards, warp_share
from live.motion.pose.warp_curve_kernels import (
    LENGTH_BUFFER,
    MAX_HELD_SHIFT,
    PELVIS_DROP,
    STANDING_MARGIN,
)

LAST = 0.8125
COUNT = 4 * (KNOTS - 1) + 1
PLACES = np.linspace(0, 1, COUNT)


def contacts_of(*swings):
    """Contacts of a measure in which foot k is in the air from share a to b, for each (k, a, b)."""
    contact = np.ones((COUNT, 2), np.bool_)
    for foot, begin, end in swings:
        contact[(begin <= PLACES) & (end > PLACES), foot] = False
    return contact


def stances(contact):
    """Foot, first sample and end of all contact intervals."""
    found = []
    for foot in range(2):
        edges = np.flatnonzero(np.diff(contact[:, foot].astype(np.int8), prepend=0, append=0))
        found += [(foot, begin, end) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
    return found


WALK = contacts_of((0, 0.05, 0.2), (1, 0.3, 0.45), (0, 0.55, 0.7), (1, 0.8, 0.95))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 1), st.floats(0, 0.9), st.floats(0.05, 0.3)), max_size=6))
def test_warp_curve_rises_monotonically_to_one(swings):
    rise, _ = compute_warp_curve(contacts_of(*((foot, begin, begin + size) for foot, begin, size in swings)), last=LAST)
    share = np.array([warp_share(rise, place) for place in PLACES])
    assert share[0] == 0.0
    assert share[-1] == pytest.approx(1.0)
    assert (np.diff(share) >= -1e-12).all()
    late = PLACES >= LAST + 1.5 / (KNOTS - 1)
    assert share[late] == pytest.approx(1.0)  # nothing within the blend
    for place in (np.arange(KNOTS - 1) + 0.37) / (KNOTS - 1):  # the rate, which is continuous, is the derivative
        slope = (warp_share(rise, place + 1e-4) - warp_share(rise, place - 1e-4)) / 2e-4
        assert slope == pytest.approx(np.interp(place, np.linspace(0, 1, KNOTS), rise[:, WARP_RATE]), abs=1e-6)


def test_warp_curve_rises_only_in_single_support():
    rise, follows = compute_warp_curve(WALK, last=LAST)
    assert follows
    both = WALK.all(axis=1)
    edge = 1.5 / (KNOTS - 1)
    deep = np.array([both[np.abs(PLACES - place) <= edge].all() for place in PLACES])
    share = np.array([warp_share(rise, place) for place in PLACES])
    assert np.diff(share)[deep[1:] & deep[:-1]].max() < 1e-9
    assert np.diff(share)[~both[1:] & (PLACES[1:] < 0.6)].sum() > 0.5


def test_stances_share_shift_evenly():
    """Left and right swing in turn: three stretches in all, so no foot is held against more than half the shift."""
    rise, _ = compute_warp_curve(WALK, last=LAST)
    share = np.array([warp_share(rise, place) for place in PLACES])
    held = [share[end - 1] - share[begin] for _, begin, end in stances(WALK)]
    assert max(held) < 0.5
    holds = initial_hold_shares(standing_legs()[1], WALK, rise)
    assert holds[0] == pytest.approx(0.0, abs=0.01)  # the left foot is lifted before anything comes in


def test_standing_gives_ease_curve_with_small_margin():
    rise, follows = compute_warp_curve(contacts_of(), last=LAST)
    assert not follows
    assert warp_share(rise, 0.5 * LAST) == pytest.approx(0.5, abs=0.02)
    assert compute_reach_margin(*standing_legs(), contacts_of(), rise, follows_feet=False).max() <= STANDING_MARGIN


def standing_legs(ahead=0.0):
    hip, ankle = np.zeros((2, COUNT, 2, 3))
    hip[..., 1], ankle[..., 1], ankle[..., 2] = 0.85, 0.09, ahead
    return hip, ankle


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.2, 0.2))
def test_legs_reach_within_given_margin(ahead):
    """Brute force: with the margin's shift in any direction no standing leg exceeds its length limit."""
    rise, _ = compute_warp_curve(WALK, last=LAST)
    hip, ankle = standing_legs(ahead)
    give = compute_reach_margin(hip, ankle, WALK, rise, follows_feet=True)
    assert (give > 0.05).all()
    share = np.array([warp_share(rise, place) for place in PLACES])
    for k in range(DIRECTIONS):
        angle = 2 * np.pi * k / DIRECTIONS
        way = give[k] * np.array([np.sin(angle), np.cos(angle)])
        for foot, begin, end in stances(WALK):
            moved = (share[begin:end] - share[begin])[:, None] * way
            assert np.hypot(*moved.T).max() <= MAX_HELD_SHIFT + 1e-9
            leg = ankle[begin:end, foot] - hip[begin:end, foot]
            leg[:, (0, 2)] -= moved
            leg[:, 1] += PELVIS_DROP
            assert np.linalg.norm(leg, axis=1).max() <= max(LEG_LENGTH - LENGTH_BUFFER, np.hypot(0.76, ahead)) + 1e-6


def test_dragged_foot_does_not_limit_margin():
    rise, _ = compute_warp_curve(contacts_of(), last=LAST)
    hip, ankle = standing_legs()
    ankle[..., 0] = hip[..., 0] = PLACES[:, None]
    assert compute_reach_margin(hip, ankle, contacts_of(), rise, follows_feet=False).min() > 4 * STANDING_MARGIN
    assert not initial_hold_shares(ankle, contacts_of(), rise).any()


def test_trailing_leg_has_smaller_margin_ahead():
    rise, _ = compute_warp_curve(WALK, last=LAST)
    give = compute_reach_margin(*standing_legs(ahead=-0.22), WALK, rise, follows_feet=True)
    assert margin_towards(give, 0.0, 1.0) < margin_towards(give, 0.0, -1.0)
    assert margin_towards(give, 0.0, 1.0) == pytest.approx(give[0])
    assert rise[-1, WARP_SHARE] == pytest.approx(1.0)
