"""Goals and waypoints against plain formulas."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.agent_command import AgentCommand
from live.agents.goals.goal_kernels import ARRIVE, ATTRACT, segments_cross
from live.agents.goals.goals import Goals, WayPoints


def goal_velocity(position, target, **options):
    position = np.array(position, np.float32).reshape(-1, 2)
    wants = AgentCommand(len(position))
    reached = Goals(target, 1.3, **options)(wants, position)
    return wants.velocity.astype(float), list(reached)


@given(st.integers(0, 2**31 - 1), st.integers(0, 33), st.floats(0.2, 4.0))
@settings(max_examples=50, deadline=None)
def test_arrive_speed_is_proportional_to_distance(seed, count, rate):
    chance = np.random.default_rng(seed)
    position, target = chance.uniform(-9, 9, (2, count, 2)).astype(np.float32)
    velocity, reached = goal_velocity(position, target, law=ARRIVE, rate=rate)
    way = target.astype(float) - position
    distance = np.linalg.norm(way, axis=1)
    expected = way / distance[:, None] * np.minimum(1.3, rate * distance)[:, None]
    np.testing.assert_allclose(velocity, expected, rtol=1e-4, atol=1e-5)
    assert reached == list(np.flatnonzero(distance <= 0.3))


@given(st.integers(0, 2**31 - 1), st.integers(0, 33), st.floats(0.2, 4.0))
@settings(max_examples=50, deadline=None)
def test_attract_speed_follows_one_minus_exponential(seed, count, rate):
    """T105: 1 - f(d), f(d) = exp(-d / decay), from millimetres to a hundred metres."""
    chance = np.random.default_rng(seed)
    angle, distance = chance.uniform(0, 7, count), 10 ** chance.uniform(-3, 2, count)
    target = np.stack([np.sin(angle), np.cos(angle)], 1) * distance[:, None]
    velocity, _ = goal_velocity(np.zeros((count, 2)), target, law=ATTRACT, rate=rate)
    expected = target / distance[:, None] * 1.3 * (1 - np.exp(-rate * distance))[:, None]
    np.testing.assert_allclose(velocity, expected, atol=4e-6)


@pytest.mark.parametrize("law", [ARRIVE, ATTRACT])
def test_agent_at_its_goal_stands_still(law):
    velocity, reached = goal_velocity([[2, 1], [5, 5]], [[2, 1], [5, 5.2]], law=law)
    assert (velocity[0] == 0).all()
    assert velocity[1, 1] > 0
    assert reached == [0, 1]


def test_goals_accept_zero_agents():
    velocity, reached = goal_velocity(np.zeros((0, 2)), np.zeros((0, 2)))
    assert velocity.shape == (0, 2)
    assert reached == []


def walk(way, start, gate=0.9):
    """Indices of the waypoints targeted while walking straight from one to the next in steps of 5 cm."""
    ways = WayPoints([way])
    goals = Goals(ways.current, 1.0)
    ways.begin(goals)
    place, seen = np.array([start], np.float32), [0]
    for _ in range(400):
        ways(goals, place, 0.1, gate)
        if ways.at[0] != seen[-1]:
            seen.append(int(ways.at[0]))
        wants = AgentCommand(1)
        goals(wants, place)
        place = place + wants.velocity * np.float32(0.05)
    return seen, place[0]


def test_waypoints_are_visited_in_order_and_the_last_is_kept():
    seen, place = walk([[0, 0], [2, 0], [2, 3], [0, 0]], [-3, 0])
    assert seen == [0, 1, 2, 3]
    np.testing.assert_allclose(place, [0, 0], atol=1e-3)


def test_agent_slows_down_only_at_last_waypoint():
    way = WayPoints([[[1, 0], [1.5, 0]]], rate=1.0)
    goals, wants = Goals(way.current, 1.3), AgentCommand(1)
    way.begin(goals)
    place = np.array([[0.9, 0.0]], np.float32)
    goals(wants, place)
    np.testing.assert_allclose(wants.velocity, [[1.3, 0]], rtol=1e-5)
    way(goals, place, 0.3, 0.9)
    goals(wants, place)
    np.testing.assert_allclose(wants.velocity, [[0.6, 0]], rtol=1e-5)


def test_agent_pushed_past_waypoint_continues_to_next():
    way = WayPoints([[[0, 0], [4, 0]]] * 4)
    goals = Goals(way.current, 1.0)
    # beside and past; beside, not yet past; past, but too far aside; on the waypoint
    place = np.array([[0.1, 0.6], [-0.1, 0.6], [0.1, 1.5], [-0.05, 0.05]], np.float32)
    way(goals, place, 0.3, 0.9)
    assert list(way.heading_to_last) == [True, False, False, True]
    np.testing.assert_array_equal(goals.target[:, 0], [4, 0, 0, 4])


def test_waypoint_behind_wall_is_not_skipped():
    door = np.array([[0.05, -5.0, 0.05, 0.3]])  # the waypoint is at the door's edge, the agent behind the wall
    way = WayPoints([[[0, 0.5], [4, 0.5]]], np.concatenate([door, [[0.05, 0.7, 0.05, 5.0]]]))
    goals = Goals(way.current, 1.0)
    way(goals, np.array([[0.01, 0.0]], np.float32), 0.1, 0.9)
    assert not way.heading_to_last[0]
    way(goals, np.array([[0.01, 0.55]], np.float32), 0.01, 0.9)
    assert way.heading_to_last[0]


def test_segment_crossing_matches_shapely():
    from shapely import LineString

    ends = np.random.default_rng(5).uniform(-1, 1, (300, 8))
    for end in ends:
        expected = LineString([end[:2], end[2:4]]).intersects(LineString([end[4:6], end[6:]]))
        assert segments_cross(*end) == expected
