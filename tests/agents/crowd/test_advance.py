"""The laws of a tick: nobody overlaps, leaves, wakes for nothing, or depends on anybody's number."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.agent_command import ABSENT, PASSING
from tests.agents.crowd.made_crowd import MadeCrowd, nearest


def _circle(count, radius):
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], 1)


@pytest.mark.parametrize("count", [2, 3, 4, 12])
def test_an_exactly_symmetric_circle_dissolves_without_overlap(count):
    start = _circle(count, 4.0)
    crowd = MadeCrowd(start, -start)
    track = crowd.run(12.0)
    assert np.abs(track[-1] + start).max() < 0.3
    assert nearest(track) > 0.495


def test_head_on_both_keep_to_the_right():
    crowd = MadeCrowd([[-3, 0], [3, 0]], [[3, 0], [-3, 0]])
    track = crowd.run(2.5)
    assert track[:, 0, 1].max() > 0.1  # who goes towards +x has the audience (+z) at the right
    assert track[:, 1, 1].min() < -0.1
    mirrored = MadeCrowd([[-3, 0], [3, 0]], [[3, 0], [-3, 0]], side=-0.1)
    assert np.abs(mirrored.run(2.5) * [1, -1] - track).max() < 1e-4


def test_a_scene_turned_about_gives_the_same_turned():
    chance = np.random.default_rng(3)
    start, goal = chance.uniform(-4, 4, (2, 12, 2))
    one, other = MadeCrowd(start, goal).run(1.0), MadeCrowd(-start, -goal).run(1.0)
    assert np.abs(one + other).max() < 2e-3


def test_the_order_of_the_agents_does_not_matter():
    chance = np.random.default_rng(4)
    start, goal = chance.uniform(-4, 4, (2, 20, 2))
    order = chance.permutation(20)
    track = MadeCrowd(start, goal).run(1.0)
    assert np.abs(MadeCrowd(start[order], goal[order]).run(1.0) - track[:, order]).max() < 2e-3


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 30), st.integers(0, 2**32 - 1), st.sampled_from(["predictive", "thesis"]), st.booleans())
def test_whatever_is_asked_nobody_is_lost_or_leaves_the_stage(count, seed, avoidance, walls):
    chance = np.random.default_rng(seed)
    start = chance.uniform(-3, 3, (count, 2)).round(chance.integers(0, 3))  # rounded: many in one place
    crowd = MadeCrowd(start, avoidance=avoidance, half_width=3.0, half_depth=3.0, tick=1 / 16)
    crowd.wants.rows[:, :7] = chance.choice([0.0, 0.3, 1.0, -1.0, 30.0], (count, 7))
    crowd.wants.rows[:, 6] = np.clip(crowd.wants.rows[:, 6], 0, 1)
    if walls:
        crowd.surroundings.set_wall("w", *chance.uniform(-3, 3, 4))
        crowd.surroundings.set_obstacle("o", *chance.uniform(-3, 3, 2), 0.5, 1.0, -1.0)
    crowd.run(1.5)
    assert np.isfinite(crowd.state.flat).all()
    assert np.abs(crowd.state.position).max(initial=0) <= 3.0


def test_a_soloist_has_right_of_way():
    start = [[-4, 0.0], [4, 0.05], [0, 2.0], [1, -3]]
    crowd = MadeCrowd(start, [[4, 0], [-4, 0], [0, -3], [0.5, 3]], responsibility=[0, 1, 1, 1])
    track = crowd.run(5.0)
    assert np.abs(track[:, 0, 1]).max() < 0.02
    assert nearest(track) > 0.495


def test_who_stands_at_her_goal_gives_way_and_comes_back():
    crowd = MadeCrowd([[-4, 0], [0, 0]], [[4, 0], [0, 0]])
    track = crowd.run(10.0)
    assert np.abs(track[-1] - crowd.goal).max() < 0.1
    assert np.hypot(*track[:, 1].T).max() > 0.2
    assert nearest(track) > 0.495


def test_a_firm_agent_keeps_her_velocity_exactly_until_a_collision_comes():
    crowd = MadeCrowd([[-3, 0], [0, 1.2], [0, -1.2], [4, 0]])
    crowd.wants.velocity[0] = (1.0, 0.0)
    crowd.wants.firmness[0] = 1.0
    track = crowd.run(4.0)
    straight = -3 + np.arange(len(track)) / 64
    assert np.abs(track[:, 0, 0] - straight).max() < 1e-4
    assert np.abs(track[:, 0, 1]).max() == 0.0
    crowd.wants.firmness[:] = 1.0
    assert nearest(crowd.run(4.0)) > 0.495  # now one who stands firm is in her way


def test_the_absent_are_not_seen_and_do_not_move():
    start, goal = [[-3, 0], [0, 0]], [[3, 0], [5, 5]]
    alone, crowd = MadeCrowd(start[:1], goal[:1]), MadeCrowd(start, goal)
    crowd.wants.presence[1] = ABSENT
    track = crowd.run(4.0)
    assert (track[:, 1] == 0).all()
    assert (track[:, 0] == alone.run(4.0)[:, 0]).all()


def test_who_passes_leaves_the_stage_and_nobody_follows():
    crowd = MadeCrowd([[1, 0], [1, 1]], [[6, 0], [6, 1]], half_width=2.0, half_depth=2.0)
    crowd.wants.presence[0] = PASSING
    track = crowd.run(6.0)
    assert track[-1, 0, 0] > 5
    assert track[:, 1, 0].max() <= 2.0
    crowd.wants.presence[0] = 1.0  # called back, she walks, she is not put
    crowd.goal[0] = (0, 0)
    back = crowd.run(8.0)
    assert np.abs(np.diff(back[:, 0], axis=0)).max() < 2.0 / 64
    assert np.abs(back[-1, 0]).max() <= 2.0


def test_limits_of_speed_acceleration_and_turn_are_kept():
    crowd = MadeCrowd([[0, 0]], acceleration=3.0, turn_rate=2.0)
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


def test_walls_and_obstacles_stop_and_turn_aside():
    crowd = MadeCrowd([[0, 0], [-3, 3.0]], [[4, 0], [3, 3.1]])
    crowd.surroundings.set_wall("w", 2.0, -5.0, 2.0, 2.0)
    crowd.surroundings.set_obstacle("pillar", 0.0, 3.0, 0.6)
    track = crowd.run(9.0)
    assert track[:, 0, 0].max() <= 1.751
    assert np.hypot(*(track[:, 1] - [0, 3]).T).min() > 0.849
    assert track[-1, 1, 0] > 2.5
    crowd.surroundings.remove("w")
    assert crowd.run(6.0)[-1, 0, 0] > 3.7


def test_a_tracked_dancer_who_walks_at_an_agent_moves_her():
    crowd = MadeCrowd([[0, 0]])
    for step in range(200):
        x = -3.0 + step / 64
        crowd.surroundings.set_obstacle("real", x, 0.0, 0.3, vx=1.0)
        crowd.run(1 / 64)
        assert np.hypot(*(crowd.state.position[0] - [x, 0])) > 0.53


def test_sleepers_lie_still_bit_for_bit_and_wake_for_who_comes():
    start = [[0, 0], [1.6, 0], [0, 1.7], [-7, 0.1]]
    crowd = MadeCrowd(start)
    crowd.wants.separation[:] = 1.0
    crowd.run(2.0)
    assert (crowd.state.rest >= 0.5).all()
    assert (crowd.state.position == np.float32(start)).all()
    crowd.wants.velocity[3] = (1.2, 0.0)
    track = crowd.run(6.0)
    assert np.hypot(*(track[:, 0] - start[0]).T).max() > 0.05
    assert nearest(track) > 0.495
    crowd.wants.velocity[3] = 0.0
    crowd.run(8.0)
    assert (crowd.state.rest >= 0.5).all()
    crowd.wants.separation[:] = 2.5  # asked for more room, they take it
    before = crowd.state.position.copy()
    crowd.run(2.0)
    assert np.abs(crowd.state.position - before).max() > 0.2


def test_those_in_one_place_part():
    crowd = MadeCrowd(np.zeros((6, 2)))
    crowd.run(4.0)
    assert nearest(crowd.state.position[None]) > 0.495


def test_nobody_and_one_alone():
    assert MadeCrowd(np.zeros((0, 2))).run(0.125).shape == (9, 0, 2)
    crowd = MadeCrowd([[0, 0]], [[1, 0]])
    assert np.abs(crowd.run(8.0)[-1] - [1, 0]).max() < 0.02


def test_the_same_again_is_bit_identical():
    chance = np.random.default_rng(7)
    start, goal = chance.uniform(-5, 5, (2, 40, 2))
    assert (MadeCrowd(start, goal).run(2.0) == MadeCrowd(start, goal).run(2.0)).all()
