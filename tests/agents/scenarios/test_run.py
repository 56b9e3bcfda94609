"""The crowd on scenarios: arrival, separation, stage bounds and independence of tick batches."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.scenarios.generate import SCENARIOS
from live.agents.scenarios.metrics import measure
from live.agents.scenarios.run import TICK, Simulation, simulate, ticks_in
from live.agents.scenarios.scenario import Scenario
from tests.fixtures.mostly_long import mostly_long


def scenario(start, goals, *, duration=10.0, **options):
    ways = tuple(np.array(way, float).reshape(-1, 2) for way in goals)
    values = {"radius": 0.25, "preferred_speed": 1.3, "max_speed": 1.8, "goal_radius": 0.3} | options
    return Scenario(duration, start=np.array(start, float).reshape(-1, 2), goals=ways, **values)


def test_scenarios_of_zero_and_one_agent_run():
    time, position, arrived = simulate(scenario([], [], duration=1.0))
    assert (len(time), position.shape, arrived.shape) == (65, (65, 0, 2), (0,))
    time, position, arrived = simulate(scenario([[0, 0]], [[3, 4]]))
    assert position.dtype == np.float64
    np.testing.assert_array_equal(position[0], [[0, 0]])
    np.testing.assert_allclose(position[-1], [[3, 4]], atol=0.02)
    expected = time[np.linalg.norm(position[:, 0] - [3, 4], axis=1) <= 0.3][0]
    assert arrived[0] == expected
    speed = np.linalg.norm(np.diff(position[:, 0], axis=0), axis=1) / TICK
    assert speed[0] < 0.3  # from rest
    assert speed.max() <= 1.3 * 1.02
    assert speed[-1] < 0.01


def test_waypoints_are_visited_in_order_around_a_wall():
    walls = np.array([[0.0, -1.0, 0.0, 3.0]])
    once = scenario([[-1, 0]], [[[-1, -2], [1, -2], [1, 0]]], walls=walls)
    _, position, arrived = simulate(once)
    assert np.isfinite(arrived).all()
    way = position[:, 0]
    crossing = np.flatnonzero(np.diff(np.sign(way[:, 0])))
    assert (way[crossing, 1] < -1.2).all()  # around the end of the wall, one body away


def test_agent_starting_at_last_goal_arrives_only_after_its_path():
    _, _, arrived = simulate(scenario([[0, 0]], [[[2, 0], [0, 0]]]))
    assert 2.5 < arrived[0] < 6.0


def test_off_center_stage_gives_the_same_run():
    """Off center by a number that is exact in binary, the run is equal except for rounding."""
    plain = simulate(scenario([[-2, 0.1], [2, 0]], [[2, 0], [-2, 0]], stage=(-4.0, -3.0, 4.0, 3.0)))
    moved = simulate(scenario([[98, 50.1], [102, 50]], [[102, 50], [98, 50]], stage=(96.0, 47.0, 104.0, 53.0)))
    np.testing.assert_allclose(moved[1] - [100, 50], plain[1], atol=1e-3)
    assert np.isfinite(plain[2]).all()


@pytest.mark.parametrize("avoidance", ["predictive", "thesis"])
@pytest.mark.parametrize("name", ["circle-20", "bottleneck-60", "random-100"])
def test_ticks_are_identical_at_any_frame_rate(name, avoidance):
    """At 25, 60 and 144 frames per second ticks run in different batches: the paths are bit-identical."""
    made = replace(SCENARIOS[name](0), duration=3.0)
    _, whole, arrived = simulate(made, avoidance=avoidance)
    for frames_per_second in (25, 60, 144):
        run, ticks = Simulation(made, avoidance=avoidance), [made.start]
        for frame in range(1, 3 * frames_per_second + 1):
            while run.time + TICK <= frame / frames_per_second + 1e-9:
                run.tick()
                ticks.append(run.position)
        np.testing.assert_array_equal(np.array(ticks[1:]), whole[1:])
        np.testing.assert_array_equal(run.arrived, arrived)


def test_two_simulations_are_independent():
    made = replace(SCENARIOS["random-100"](1), duration=2.0)
    one, other = Simulation(made), Simulation(made)
    for _ in range(100):
        one.tick()
    for _ in range(100):
        other.tick()
    np.testing.assert_array_equal(one.position, other.position)


def test_run_is_independent_of_agent_order():
    """For the first 1.5 s; later the rounding of sums, which depends on order, grows as in every crowd."""
    made = replace(SCENARIOS["circle-20"](0), duration=1.5)
    order = np.random.default_rng(3).permutation(20)
    shuffled = scenario(made.start[order], [made.goals[i] for i in order], duration=1.5)
    _, position, _ = simulate(made)
    np.testing.assert_allclose(simulate(shuffled)[1], position[:, order], atol=1e-4)
    alone = [scenario(made.start[i], [made.goals[i]], duration=1.5) for i in range(20)]
    freely = np.concatenate([simulate(one)[1] for one in alone], axis=1)
    assert np.abs(freely - position).max() > 0.01  # agents do avoid each other


@mostly_long("name", ["headon-2", "sym-4", "circle-20", "cross-50", "corridor-50", "formation-hung"], quick=[0, 3])
def test_all_agents_arrive_without_overlaps(name):
    made = SCENARIOS[name](0)
    time, position, arrived = simulate(made, stop_when_settled=True)
    figures = measure(made, time, position)
    assert figures.done == 1
    assert figures.overlaps == 0
    assert np.isfinite(arrived).all()


PLACE = st.tuples(*[st.one_of(st.floats(-6, 6), st.sampled_from([-6.0, 0.0, 1.0, 6.0]))] * 2)


@pytest.mark.long
@given(
    st.lists(st.tuples(PLACE, PLACE), max_size=24),
    st.lists(st.tuples(PLACE, PLACE), max_size=4),
    st.sampled_from([None, (-6.0, -6.0, 6.0, 6.0), (-0.1, -6.0, 0.1, 6.0), (-0.05, -0.05, 0.05, 0.05)]),
    st.sampled_from([0.01, 0.25, 2.0]),
    st.sampled_from(["predictive", "thesis"]),
)
@settings(max_examples=60, deadline=None)
def test_random_scenarios_keep_agents_finite_and_on_stage(agents, walls, stage, radius, avoidance):
    """Coincident starts, goals on walls and off the stage, walls without length, stages smaller than a body."""
    start = np.array([start for start, _ in agents], float).reshape(-1, 2)
    if stage is not None:
        start = np.clip(start, stage[:2], stage[2:])
    ends = np.array(walls, float).reshape(-1, 4)
    made = scenario(start, [goal for _, goal in agents], duration=2.0, radius=radius, stage=stage, walls=ends)
    time, position, _ = simulate(made, avoidance=avoidance)
    assert np.isfinite(position).all()
    if stage is not None and len(agents):
        assert (position.min(axis=(0, 1)) >= np.array(stage[:2]) - 1e-5).all()
        assert (position.max(axis=(0, 1)) <= np.array(stage[2:]) + 1e-5).all()
    measure(made, time, position)


def test_overfull_crowd_stays_on_stage():
    chance = np.random.default_rng(4)
    start = chance.uniform(-1, 1, (60, 2))
    made = scenario(start, chance.uniform(-1, 1, (60, 2)), duration=4.0, stage=(-1.0, -1.0, 1.0, 1.0))
    for avoidance in ("predictive", "thesis"):
        _, position, _ = simulate(made, avoidance=avoidance)
        assert np.isfinite(position).all()
        assert np.abs(position).max() <= 1.0 + 1e-5


def test_tick_count_covers_the_duration():
    assert (ticks_in(1.0), ticks_in(1.001), ticks_in(TICK / 2)) == (64, 65, 1)
