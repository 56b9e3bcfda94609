"""Tests of one crowd tick: no overlaps, stage bounds, limits, sleep and independence of agent order."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.agent_command import ABSENT, PASSING
from tests.agents.crowd.made_crowd import CrowdHarness, smallest_distance


def _circle_positions(count, radius):
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], 1)


@pytest.mark.parametrize("count", [2, 3, 4, 12])
def test_symmetric_circle_resolves_without_overlap(count):
    start = _circle_positions(count, 4.0)
    crowd = CrowdHarness(start, -start)
    track = crowd.run(12.0)
    assert np.abs(track[-1] + start).max() < 0.3
    assert smallest_distance(track) > 0.495


def test_head_on_agents_pass_on_the_right():
    crowd = CrowdHarness([[-3, 0], [3, 0]], [[3, 0], [-3, 0]])
    track = crowd.run(2.5)
    assert track[:, 0, 1].max() > 0.1  # an agent moving toward +x has the audience (+z) at the right
    assert track[:, 1, 1].min() < -0.1
    mirrored = CrowdHarness([[-3, 0], [3, 0]], [[3, 0], [-3, 0]], side=-0.1)
    assert np.abs(mirrored.run(2.5) * [1, -1] - track).max() < 1e-4


def test_rotated_scene_gives_rotated_motion():
    chance = np.random.default_rng(3)
    start, goal = chance.uniform(-4, 4, (2, 12, 2))
    one, other = CrowdHarness(start, goal).run(1.0), CrowdHarness(-start, -goal).run(1.0)
    assert np.abs(one + other).max() < 2e-3


def test_motion_is_independent_of_agent_order():
    chance = np.random.default_rng(4)
    start, goal = chance.uniform(-4, 4, (2, 20, 2))
    order = chance.permutation(20)
    track = CrowdHarness(start, goal).run(1.0)
    assert np.abs(CrowdHarness(start[order], goal[order]).run(1.0) - track[:, order]).max() < 2e-3


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 30), st.integers(0, 2**32 - 1), st.sampled_from(["predictive", "thesis"]), st.booleans())
def test_random_commands_keep_agents_finite_and_on_stage(count, seed, avoidance, walls):
    chance = np.random.default_rng(seed)
    start = chance.uniform(-3, 3, (count, 2)).round(chance.integers(0, 3))  # rounded: many in one place
    crowd = CrowdHarness(start, avoidance=avoidance, half_width=3.0, half_depth=3.0, tick=1 / 16)
    crowd.wants.rows[:, :7] = chance.choice([0.0, 0.3, 1.0, -1.0, 30.0], (count, 7))
    crowd.wants.rows[:, 6] = np.clip(crowd.wants.rows[:, 6], 0, 1)
    if walls:
        crowd.surroundings.set_wall("w", *chance.uniform(-3, 3, 4))
        crowd.surroundings.set_obstacle("o", *chance.uniform(-3, 3, 2), 0.5, 1.0, -1.0)
    crowd.run(1.5)
    assert np.isfinite(crowd.state.flat).all()
    assert np.abs(crowd.state.position).max(initial=0) <= 3.0


def test_soloist_has_right_of_way():
    start = [[-4, 0.0], [4, 0.05], [0, 2.0], [1, -3]]
    crowd = CrowdHarness(start, [[4, 0], [-4, 0], [0, -3], [0.5, 3]], responsibility=[0, 1, 1, 1])
    track = crowd.run(5.0)
    assert np.abs(track[:, 0, 1]).max() < 0.02
    assert smallest_distance(track) > 0.495


def test_agent_at_goal_gives_way_and_returns():
    crowd = CrowdHarness([[-4, 0], [0, 0]], [[4, 0], [0, 0]])
    track = crowd.run(10.0)
    assert np.abs(track[-1] - crowd.goal).max() < 0.1
    assert np.hypot(*track[:, 1].T).max() > 0.2
    assert smallest_distance(track) > 0.495


def test_firm_agent_keeps_velocity_until_collision():
    crowd = CrowdHarness([[-3, 0], [0, 1.2], [0, -1.2], [4, 0]])
    crowd.wants.velocity[0] = (1.0, 0.0)
    crowd.wants.firmness[0] = 1.0
    track = crowd.run(4.0)
    straight = -3 + np.arange(len(track)) / 64
    assert np.abs(track[:, 0, 0] - straight).max() < 1e-4
    assert np.abs(track[:, 0, 1]).max() == 0.0
    crowd.wants.firmness[:] = 1.0
    assert smallest_distance(crowd.run(4.0)) > 0.495  # a firm standing agent blocks the path


def test_absent_agents_are_ignored_and_stay_put():
    start, goal = [[-3, 0], [0, 0]], [[3, 0], [5, 5]]
    alone, crowd = CrowdHarness(start[:1], goal[:1]), CrowdHarness(start, goal)
    crowd.wants.presence[1] = ABSENT
    track = crowd.run(4.0)
    assert (track[:, 1] == 0).all()
    assert (track[:, 0] == alone.run(4.0)[:, 0]).all()


def test_only_passing_agent_leaves_the_stage():
    crowd = CrowdHarness([[1, 0], [1, 1]], [[6, 0], [6, 1]], half_width=2.0, half_depth=2.0)
    crowd.wants.presence[0] = PASSING
    track = crowd.run(6.0)
    assert track[-1, 0, 0] > 5
    assert track[:, 1, 0].max() <= 2.0
    crowd.wants.presence[0] = 1.0  # called back, the agent walks, without a jump
    crowd.goal[0] = (0, 0)
    back = crowd.run(8.0)
    assert np.abs(np.diff(back[:, 0], axis=0)).max() < 2.0 / 64
    assert np.abs(back[-1, 0]).max() <= 2.0


def test_agent_keeps_speed_and_turn_rate_limits():
    crowd = CrowdHarness([[0, 0]], acceleration=3.0, turn_rate=2.0)
    crowd.wants.velocity[0] = (9.0, 0.0)
    crowd.run(2.0)
    velocities = [crowd.state.velocity[0].copy()]
    crowd.wants.velocity[0] = (0.0, 9.0)
    crowd.run(2.0, lambda state: velocities.append(state.velocity[0].copy()))
    velocity = np.array(velocities, float)
    speed, heading = np.hypot(*velocity.T), np.unwrap(np.arctan2(velocity[:, 0], velocity[:, 1]))
    assert speed.max() <= 1.8 + 1e-5
    assert np.abs(np.diff(heading)).max() <= 2.0 / 64 * 1.01
    assert speed[-1] > 1.7
    assert heading[-1] == pytest.approx(0.0, abs=0.1)


def test_walls_stop_and_obstacles_divert_agents():
    crowd = CrowdHarness([[0, 0], [-3, 3.0]], [[4, 0], [3, 3.1]])
    crowd.surroundings.set_wall("w", 2.0, -5.0, 2.0, 2.0)
    crowd.surroundings.set_obstacle("pillar", 0.0, 3.0, 0.6)
    track = crowd.run(9.0)
    assert track[:, 0, 0].max() <= 1.751
    assert np.hypot(*(track[:, 1] - [0, 3]).T).min() > 0.849
    assert track[-1, 1, 0] > 2.5
    crowd.surroundings.remove("w")
    assert crowd.run(6.0)[-1, 0, 0] > 3.7


def test_tracked_dancer_pushes_agent_aside():
    crowd = CrowdHarness([[0, 0]])
    for step in range(200):
        x = -3.0 + step / 64
        crowd.surroundings.set_obstacle("real", x, 0.0, 0.3, vx=1.0)
        crowd.run(1 / 64)
        assert np.hypot(*(crowd.state.position[0] - [x, 0])) > 0.53


def test_sleeping_agents_stay_still_until_an_agent_approaches():
    start = [[0, 0], [1.6, 0], [0, 1.7], [-7, 0.1]]
    crowd = CrowdHarness(start)
    crowd.wants.separation[:] = 1.0
    crowd.run(2.0)
    assert (crowd.state.rest >= 0.5).all()
    assert (crowd.state.position == np.float32(start)).all()
    crowd.wants.velocity[3] = (1.2, 0.0)
    track = crowd.run(6.0)
    assert np.hypot(*(track[:, 0] - start[0]).T).max() > 0.05
    assert smallest_distance(track) > 0.495
    crowd.wants.velocity[3] = 0.0
    crowd.run(8.0)
    assert (crowd.state.rest >= 0.5).all()
    crowd.wants.separation[:] = 2.5  # a larger separation moves the agents
    before = crowd.state.position.copy()
    crowd.run(2.0)
    assert np.abs(crowd.state.position - before).max() > 0.2


def test_coincident_agents_separate():
    crowd = CrowdHarness(np.zeros((6, 2)))
    crowd.run(4.0)
    assert smallest_distance(crowd.state.position[None]) > 0.495


def test_crowds_of_zero_and_one_agent_run():
    assert CrowdHarness(np.zeros((0, 2))).run(0.125).shape == (9, 0, 2)
    crowd = CrowdHarness([[0, 0]], [[1, 0]])
    assert np.abs(crowd.run(8.0)[-1] - [1, 0]).max() < 0.02


def test_repeated_run_is_bit_identical():
    chance = np.random.default_rng(7)
    start, goal = chance.uniform(-5, 5, (2, 40, 2))
    assert (CrowdHarness(start, goal).run(2.0) == CrowdHarness(start, goal).run(2.0)).all()
