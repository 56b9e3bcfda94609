"""Tests of redirecting corrections to new goals: continuous shifts, reached goals, and bounded late changes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.pose.footstep_kernels import foot_shift
from live.motion.pose.footstep_plan import plan_footsteps
from live.motion.pose.root_warp_kernels import DIRECTIONS, limit_corrections, limit_goals, redirect_dancers
from live.motion.pose.warp_curve_kernels import warp_share, warped_shift

CONTACT = np.ones((257, 2), np.bool_)
CONTACT[20:80, 0] = CONTACT[100:190, 1] = False
PLAN = plan_footsteps(CONTACT, beats=4, last=0.8)
RISE, FEET = PLAN.root[None].copy(), PLAN.feet[None].copy()
NODE = np.zeros(1, np.int32)
LEAST = 0.15


def shift_at(correction, aimed, place):
    share = warp_share(RISE[0], place)
    return np.array([warped_shift(share, aimed[0, 2], aimed[0, c], correction[0, c]) for c in range(2)])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), min_size=1, max_size=6))
def test_shift_is_continuous_and_ends_at_last_goal(goals):
    correction, aimed, feet = np.array([[0.2, -0.1, 0.4]]), np.zeros((1, 3)), np.zeros((1, 2, 6))
    for place, goal in zip(np.linspace(0.05, 0.9, len(goals)), goals, strict=True):
        before = shift_at(correction, aimed, place)
        taken = 1.0 - warp_share(RISE[0], place) > LEAST
        redirect_dancers(correction, aimed, feet, np.array([goal]), np.array([place]), NODE, RISE, FEET, LEAST, 0, 1)
        assert shift_at(correction, aimed, place) == pytest.approx(before, abs=1e-12)
        if taken:
            assert correction[0, :2] == pytest.approx(goal)
    assert shift_at(correction, aimed, 1.0) == pytest.approx(correction[0, :2])
    assert correction[0, 2] == 0.4  # the turn is left alone


def test_smoothly_moving_goal_gives_smooth_shift():
    """Redirected every 1/137 of the measure, the speed changes by no more than the warp's own and the goal's."""
    places = np.linspace(0.0, 1.0, 138)
    ways = {}
    for moving in (False, True):
        correction, aimed, feet = np.array([[0.2, 0.0, 0.0]]), np.zeros((1, 3)), np.zeros((1, 2, 6))
        way = []
        for place in places:
            goal = 0.2 - (0.1 * np.sin(np.pi * min(place, 0.5)) if moving else 0.0)
            redirect_dancers(
                correction, aimed, feet, np.array([[goal, 0.0]]), np.array([place]), NODE, RISE, FEET, LEAST, 0, 1
            )
            way.append(shift_at(correction, aimed, place)[0])
        ways[moving] = np.abs(np.diff(way, n=2)).max()
    assert ways[True] < 1.5 * ways[False]


@settings(max_examples=60, deadline=None)
@given(st.floats(0, 1), st.floats(-2, 2), st.floats(-2, 2), st.floats(0.02, 0.4))
def test_late_goal_is_limited_to_remaining_share(place, x, z, most):
    correction, aimed, goal = np.array([[0.05, 0.0, 0.0]]), np.zeros((1, 3)), np.array([[x, z]])
    share = warp_share(RISE[0], place)
    now = shift_at(correction, aimed, place)
    limit_goals(goal, correction, aimed, np.array([place]), NODE, RISE, np.array([most]), LEAST)
    rest = np.hypot(*(goal[0] - now))
    assert rest <= max((1.0 - share) * most, np.hypot(*(correction[0, :2] - now))) + 1e-9
    if 1.0 - share <= LEAST:
        assert goal[0] == pytest.approx(correction[0, :2])


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_corrections_are_shortened_and_never_rotated(seed):
    chance = np.random.default_rng(seed)
    way, yaw = chance.normal(0, 0.3, (8, 2)), chance.uniform(-3, 3, 8)
    asked, node = way.copy(), chance.integers(0, 3, 8).astype(np.int32)
    gives, holds = chance.uniform(0, 0.4, (3, DIRECTIONS)), chance.uniform(0, 1, (3, 2))
    held, share = chance.normal(0, 0.08, (8, 2, 2)), chance.uniform(0.3, 1, 8)
    limit_corrections(way, yaw, node, gives, holds, held, share, 0.35, 0.15)
    size, before = np.hypot(*way.T), np.hypot(*asked.T)
    assert (size <= np.minimum(before, 0.35) + 1e-12).all()
    assert np.abs(way[:, 0] * asked[:, 1] - way[:, 1] * asked[:, 0]).max() < 1e-12
    assert ((way * asked).sum(axis=1) >= -1e-12).all()
    assert (size <= share * gives[node].max(axis=1) + 1e-12).all()
    after = np.linalg.norm(held - holds[node][..., None] * way[:, None], axis=2)
    assert (after <= np.maximum(np.linalg.norm(held, axis=2), 0.15) + 1e-9).all()


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), min_size=1, max_size=6))
def test_feet_are_led_on_continuously_and_landed_feet_stay(goals):
    """Whatever the goals, no foot jumps when they change; one that has landed for good keeps its place."""
    correction, aimed, feet = np.array([[0.2, -0.1, 0.4]]), np.zeros((1, 3)), np.zeros((1, 2, 6))

    def shifts(place):
        x, z = correction[0, :2]
        return np.array([foot_shift(FEET[0, foot], place, feet[0, foot], x, z)[:2] for foot in range(2)])

    for place, goal in zip(np.linspace(0.05, 0.9, len(goals)), goals, strict=True):
        before = shifts(place)
        landed = [warp_share(np.ascontiguousarray(FEET[0, foot, :, :2]), place) >= 1.0 for foot in range(2)]
        ends = shifts(1.0)
        redirect_dancers(correction, aimed, feet, np.array([goal]), np.array([place]), NODE, RISE, FEET, LEAST, 0, 1)
        np.testing.assert_allclose(shifts(place), before, atol=1e-12)
        for foot in range(2):
            if landed[foot]:
                np.testing.assert_allclose(shifts(1.0)[foot], ends[foot], atol=1e-12)
