"""Generated benchmark scenarios match their specification."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from live.agents.scenarios.generate import SCENARIOS, dart_throwing

COUNTS = {
    "headon-2": 2,
    "sym-4": 4,
    "circle-20": 20,
    "circle-50": 50,
    "circle-100": 100,
    "cross-50": 50,
    "cross-100": 100,
    "corridor-50": 50,
    "corridor-100": 100,
    "bottleneck-60": 60,
    "door-20-20": 40,
    "door-30-10": 40,
    "formation-hung": 50,
    "random-100": 100,
}


DURATIONS = {"headon-2": 30, "sym-4": 30, "bottleneck-60": 120, "door-20-20": 120, "door-30-10": 120}


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenario_has_specified_agents_without_initial_overlap(name):
    scenario = SCENARIOS[name](0)
    assert scenario.agent_count == COUNTS[name]
    assert (scenario.radius, scenario.preferred_speed, scenario.max_speed, scenario.goal_radius) == (
        0.25,
        1.3,
        1.8,
        0.3,
    )
    assert scenario.duration == DURATIONS.get(name, 60)
    assert pdist(scenario.start).min() > 0.5
    again, other = SCENARIOS[name](0), SCENARIOS[name](1)
    np.testing.assert_array_equal(scenario.start, again.start)
    np.testing.assert_array_equal(scenario.last_goal, again.last_goal)
    assert (name in ("headon-2", "sym-4")) == bool((scenario.start == other.start).all())


@pytest.mark.parametrize(("name", "ring"), [("circle-20", 4), ("circle-50", 8), ("circle-100", 16)])
def test_circle_goals_are_exact_antipodes(name, ring):
    scenario = SCENARIOS[name](2)
    np.testing.assert_allclose(np.linalg.norm(scenario.last_goal, axis=1), ring)
    jitter = np.abs(scenario.start + scenario.last_goal)
    assert 0.005 < jitter.max() <= 0.01


@pytest.mark.parametrize(("name", "spacing"), [("cross-50", 0.9), ("cross-100", 0.72)])
def test_crossing_goals_are_mirrored_starts(name, spacing):
    scenario = SCENARIOS[name](1)
    np.testing.assert_array_equal(scenario.last_goal, scenario.start * (-1, 1))
    left = scenario.start[scenario.start[:, 0] < 0]
    assert len(left) == scenario.agent_count // 2
    assert pdist(left).min() >= spacing
    assert np.abs(scenario.start).min(axis=0)[0] >= 1.0
    assert (np.abs(scenario.start).max(axis=0) <= (7.5, 4.5)).all()


def test_formation_goals_are_a_grid_by_shortest_assignment():
    scenario = SCENARIOS["formation-hung"](0)
    goal = scenario.last_goal
    assert {tuple(place) for place in goal} == {(x - 4.5, z - 2.0) for x in range(10) for z in range(5)}
    length = scenario.straight_distance.sum()
    chance = np.random.default_rng(0)
    for _ in range(300):  # no two can change places and go less
        swapped = goal.copy()
        pair = chance.choice(50, 2, replace=False)
        swapped[pair] = goal[pair[::-1]]
        assert np.linalg.norm(swapped - scenario.start, axis=1).sum() >= length - 1e-9


def test_bottleneck_rule_targets_gap_only_from_inside():
    scenario = SCENARIOS["bottleneck-60"](0)
    rule = scenario.rule()
    target = np.zeros((4, 2))
    places = np.array([[0, 2.0], [3.59, -0.1], [4.0, 0.5], [4.5, 0.2]])
    padded, targets = np.vstack([places, scenario.start[4:]]), np.vstack([target, scenario.start[4:] * 0])
    rule(padded, targets)
    np.testing.assert_allclose(targets[:3], [[3.8, 0.3], [3.8, -0.1], [4.6, 0.3]])
    np.testing.assert_array_equal(targets[3], scenario.last_goal[3])
    assert len(scenario.walls) == 9


def test_new_goals_are_independent_of_other_agents():
    scenario = SCENARIOS["random-100"](0)
    alone, together = scenario.rule(), scenario.rule()
    goals = scenario.last_goal
    one, all_ = goals.copy(), goals.copy()
    far = goals + 5.0
    for _ in range(3):
        here = far.copy()
        here[7] = one[7]
        alone(here, one)
        together(all_.copy(), all_)
    np.testing.assert_array_equal(one[7], all_[7])
    np.testing.assert_array_equal(one[8], goals[8])
    assert (np.abs(all_) <= np.sqrt(200) / 2).all()


def test_dart_throwing_of_too_many_points_is_refused():
    with pytest.raises(ValueError, match="do not fit"):
        dart_throwing(np.random.default_rng(0), 10, 1.0, (0.0, 0.0), (1.0, 1.0))
