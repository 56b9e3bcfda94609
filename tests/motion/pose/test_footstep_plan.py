"""Tests of footstep plans: feet take their part of a correction while they swing, hips stay between, legs reach."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.editing.foot_correction import LEG_LENGTH
from live.motion.pose.footstep_kernels import foot_shift
from live.motion.pose.footstep_plan import (
    LENGTH_BUFFER,
    MAX_FOOT_SPEED,
    MAX_HIP_SPEED,
    PELVIS_DROP,
    SAMPLES,
    STANDING_MARGIN,
    compute_reach_margin,
    initial_hold_shares,
    plan_footsteps,
)
from live.motion.pose.root_warp_kernels import DIRECTIONS, margin_towards
from live.motion.pose.warp_curve_kernels import KNOTS, SWING_END, WARP_RATE, warp_share

LAST = 0.8125
BEATS = 4
PLACES = np.linspace(0, 1, SAMPLES)
LEFT, RIGHT = range(2)


def contacts_of(*swings):
    """Contacts of a measure in which foot k is in the air from share a to b, for each (k, a, b)."""
    contact = np.ones((SAMPLES, 2), np.bool_)
    for foot, begin, end in swings:
        contact[(begin <= PLACES) & (end > PLACES), foot] = False
    return contact


def plan_of(contact):
    return plan_footsteps(contact, beats=BEATS, last=LAST)


def shares(curve):
    return np.array([warp_share(np.ascontiguousarray(curve[:, :2]), place) for place in PLACES])


def stances(contact):
    """Foot, first sample and end of all contact intervals."""
    found = []
    for foot in range(2):
        edges = np.flatnonzero(np.diff(contact[:, foot].astype(np.int8), prepend=0, append=0))
        found += [(foot, begin, end) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
    return found


WALK = contacts_of((LEFT, 0.05, 0.2), (RIGHT, 0.3, 0.45), (LEFT, 0.55, 0.7))
SWINGS = st.lists(st.tuples(st.integers(0, 1), st.floats(0, 0.9), st.floats(0.05, 0.3)), max_size=6)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(SWINGS)
def test_hips_rise_monotonically_to_the_whole_before_the_blend(swings):
    plan = plan_of(contacts_of(*((foot, begin, begin + size) for foot, begin, size in swings)))
    share = shares(plan.root)
    assert share[0] == 0.0
    assert share[-1] == pytest.approx(1.0)
    assert (np.diff(share) >= -1e-12).all()
    assert share[LAST <= PLACES] == pytest.approx(1.0)
    for place in (np.arange(KNOTS - 1) + 0.37) / (KNOTS - 1):  # the rate, which is continuous, is the derivative
        slope = (warp_share(plan.root, place + 1e-4) - warp_share(plan.root, place - 1e-4)) / 2e-4
        assert slope == pytest.approx(np.interp(place, np.linspace(0, 1, KNOTS), plan.root[:, WARP_RATE]), abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(SWINGS)
def test_standing_feet_stay_and_every_lifted_foot_gets_its_whole_part(swings):
    """A foot moves only while it swings in the clip, or in one inserted step that begins and ends on the floor."""
    contact = contacts_of(*((foot, begin, begin + size) for foot, begin, size in swings))
    plan = plan_of(contact)
    for foot in range(2):
        share = shares(plan.feet[foot])
        assert share[-1] == pytest.approx(1.0) or not share.any()
        moves = np.diff(share) > 1e-9
        stands = contact[1:, foot] & contact[:-1, foot]
        if (moves & stands).any():  # inserted: the other foot stands all the while
            assert contact[1:][moves].all()
        else:
            assert not (moves & stands).any()


def test_hips_stay_between_the_feet_of_a_walk():
    plan = plan_of(WALK)
    feet = np.stack([shares(plan.feet[foot]) for foot in range(2)])
    root = shares(plan.root)
    assert (root >= feet.min(axis=0) - 1e-9).all()
    assert (root <= feet.max(axis=0) + 1e-9).all()
    assert np.abs(feet - root).max() < 0.51  # three landings share the way
    lands = [float(PLACES[np.argmax(shares(plan.feet[foot]) > 0.999)]) for foot in (RIGHT, LEFT)]
    assert lands[0] < lands[1] < LAST


def test_dancer_who_stands_takes_two_steps_that_land_on_beats():
    plan = plan_of(contacts_of())
    assert plan.steps
    landings = [PLACES[np.argmax(shares(plan.feet[foot]) > 0.999999)] * BEATS for foot in range(2)]
    assert landings == pytest.approx([1.0, 2.0], abs=0.1)
    assert not ((np.diff(shares(plan.feet[0])) > 1e-9) & (np.diff(shares(plan.feet[1])) > 1e-9)).any()


def test_foot_under_a_measure_on_one_leg_stays():
    """The other foot is in the air all the time, so nothing can be stepped: the standing foot is held."""
    contact = contacts_of((LEFT, 0.0, 1.1))
    plan = plan_of(contact)
    assert not plan.feet[RIGHT, :, WARP_RATE].any()
    assert shares(plan.root)[-1] == pytest.approx(1.0)
    assert initial_hold_shares(standing_legs()[1], contact, plan)[RIGHT] == pytest.approx(1.0)


def test_lift_of_a_planned_step_is_smooth_and_grows_with_its_way():
    plan = plan_of(contacts_of())
    curve = np.ascontiguousarray(plan.feet[LEFT])
    begin, end = curve[curve[:, SWING_END] > 0, SWING_END - 1][0], curve[:, SWING_END].max()
    heights = {}
    for way in (0.0, 0.1, 0.6):
        lifts = np.array([foot_shift(curve, t, np.zeros(6), way, 0.0)[2] for t in np.linspace(0, 1, 1001)])
        inside = (np.linspace(0, 1, 1001) > begin) & (np.linspace(0, 1, 1001) < end)
        assert not lifts[~inside].any()
        assert np.abs(np.diff(lifts, n=2)).max() < 2e-4  # no kink: a straight leg would bend with a jerk
        heights[way] = lifts.max()
    assert heights[0.0] == 0.0 < heights[0.1] < heights[0.6] < 0.1


def standing_legs(ahead=0.0):
    hip, ankle = np.zeros((2, SAMPLES, 2, 3), np.float32)
    hip[..., 1], ankle[..., 1], ankle[..., 2] = 0.83, 0.09, ahead
    return hip, ankle


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(st.floats(-0.2, 0.2))
def test_legs_reach_within_the_margin_and_nothing_gets_too_fast(ahead):
    """Brute force over all samples, with the correction's margin in any direction."""
    plan, (hip, ankle) = plan_of(WALK), standing_legs(ahead)
    give = compute_reach_margin(hip, ankle, WALK, plan)
    assert (give > 0.05).all()
    root, feet = shares(plan.root), [shares(plan.feet[foot]) for foot in range(2)]
    longest = max(LEG_LENGTH - LENGTH_BUFFER, np.hypot(0.74, ahead))
    tight = False
    for k in range(DIRECTIONS):
        angle = 2 * np.pi * k / DIRECTIONS
        way = np.array([np.sin(angle), np.cos(angle)])
        reach = 0.0
        for foot, begin, end in stances(WALK):
            leg = (ankle - hip)[begin:end, foot].astype(np.float64)
            leg[:, (0, 2)] += ((feet[foot] - root)[begin:end] * give[k])[:, None] * way
            leg[:, 1] += PELVIS_DROP
            reach = max(reach, np.linalg.norm(leg, axis=1).max())
        assert reach <= longest + 1e-3
        speed = plan.root[:, WARP_RATE].max() * give[k]
        quick = plan.feet[..., WARP_RATE].max() * give[k]
        assert speed <= MAX_HIP_SPEED + 1e-6
        assert quick <= MAX_FOOT_SPEED + 1e-6
        tight |= reach > longest - 1e-3 or speed > MAX_HIP_SPEED - 1e-3 or quick > MAX_FOOT_SPEED - 1e-3
    assert tight  # the margin is not smaller than it must be


def test_nobody_is_led_far_whose_feet_cannot_be_lifted():
    """The only room for a step lies in the blend."""
    plan = plan_footsteps(contacts_of(), beats=BEATS, last=0.1)
    assert not plan.steps
    assert compute_reach_margin(*standing_legs(), contacts_of(), plan).max() <= STANDING_MARGIN


def test_foot_dragged_in_the_clip_does_not_limit_the_margin():
    plan, (hip, ankle) = plan_footsteps(contacts_of(), beats=BEATS, last=0.1), standing_legs()
    ankle[..., 0] = hip[..., 0] = PLACES[:, None]
    assert compute_reach_margin(hip, ankle, contacts_of(), plan).min() > STANDING_MARGIN
    assert not initial_hold_shares(ankle, contacts_of(), plan).any()


def test_trailing_leg_has_smaller_margin_ahead_and_shortening_is_easy():
    """A walk is shortened much farther than it is lengthened."""
    hip, ankle = standing_legs()
    hip[..., 2] = ankle[..., 2] = 1.6 * PLACES[:, None]
    for foot, begin, end in stances(WALK):  # planted ahead of the hips, lifted behind them
        ankle[begin:end, foot, 2] = 1.6 * PLACES[begin:end].mean() - 0.03
    give = compute_reach_margin(hip, ankle, WALK, plan_of(WALK))
    assert margin_towards(give, 0.0, -1.0) > 2.0 * margin_towards(give, 0.0, 1.0)
    assert margin_towards(give, 0.0, 1.0) == pytest.approx(give[0])
