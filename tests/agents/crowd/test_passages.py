"""Narrow passages: found between walls, used in one direction at a time, passed by all."""

import numpy as np
import pytest

from live.agents.crowd.obstacles import Surroundings
from live.agents.scenarios.generate import bottleneck, corridor, door, one_point
from live.agents.scenarios.run import TICK, Simulation, simulate
from tests.agents.crowd.made_crowd import CrowdHarness
from tests.fixtures.mostly_long import mostly_long


def passages_between(walls):
    """The passages (P, 6) between walls given as x1, z1, x2, z2 [m]."""
    surroundings = Surroundings()
    for number, ends in enumerate(walls):
        assert surroundings.set_wall(str(number), *ends)
    return surroundings.passages


@pytest.mark.parametrize(
    ("walls", "middle", "length", "width"),
    [
        (door(1, 1, 0.8, 0).walls, (0.0, 0.0), 0.0, 0.8),
        (bottleneck(2, 0).walls, (4.2, 0.0), 0.4, 1.2),
        ([(-2, -0.4, 2, -0.4), (-2, 0.4, 2, 0.4)], (0.0, 0.0), 4.0, 0.8),
        ([(-2, -0.4, 0, -0.4), (0, -0.4, 2, -0.4), (-2, 0.4, 2, 0.4)], (0.0, 0.0), 4.0, 0.8),
    ],
)
def test_gap_between_walls_is_one_passage(walls, middle, length, width):
    passages = passages_between(walls)
    assert len(passages) == 1
    assert passages[0, :2] == pytest.approx(middle, abs=1e-5)
    assert np.abs(passages[0, 2:4]) == pytest.approx([1.0, 0.0], abs=1e-5)
    assert 2.0 * passages[0, 4:] == pytest.approx([length, width], abs=1e-5)


@pytest.mark.parametrize(
    "walls", [corridor(5, 0).walls, [(-4, -0.2, 4, -0.2), (-4, 0.2, 4, 0.2)], [(-2, -1, 2, -1), (-2, 1, 2, 1)]]
)
def test_wide_corridor_or_thick_wall_is_no_passage(walls):
    assert len(passages_between(walls)) == 0


def test_removed_wall_leaves_no_passage():
    surroundings = Surroundings()
    surroundings.set_wall("upper", 0, 0.4, 0, 3)
    surroundings.set_wall("lower", 0, -0.4, 0, -3)
    assert len(surroundings.passages) == 1
    assert surroundings.remove("upper")
    assert len(surroundings.passages) == 0


@mostly_long("seed", [0, 1], quick=[1])
def test_narrow_door_used_both_ways_is_passed_by_all(seed):
    scenario = door(20, 20, 0.8, seed)
    _, position, _ = simulate(scenario, stop_when_settled=True)
    assert (np.linalg.norm(position[-1] - scenario.last_goal, axis=1) < scenario.goal_radius).all()


def test_those_who_wait_leave_the_way_out_free():
    # one comes out of the door while another one wants in: they meet a metre and more beside the door, not in it
    crowd = CrowdHarness([[-0.3, 0.0], [1.0, 0.0]], [[4.0, 0.0], [-4.0, 0.0]])
    for name, z in (("upper", 0.4), ("lower", -0.4)):
        crowd.surroundings.set_wall(name, 0.0, z, 0.0, 5.0 * z)
    first, second = crowd.run(10.0).transpose(1, 0, 2)
    assert np.linalg.norm(first[-1] - [4.0, 0.0]) < 0.3
    assert np.linalg.norm(second[-1] - [-4.0, 0.0]) < 0.3
    assert np.argmax(first[:, 0] > 0.3) < np.argmax(second[:, 0] < -0.3)
    assert np.hypot(*(first - second).T).min() > 0.55


def test_commands_are_not_changed():
    crowd = CrowdHarness([[-0.5, 0.0], [0.5, 0.0]])
    for name, z in (("upper", 0.4), ("lower", -0.4)):
        crowd.surroundings.set_wall(name, 0.0, z, 0.0, 5.0 * z)
    crowd.wants.velocity[:] = [[1.0, 0.0], [-1.0, 0.0]]
    before = crowd.wants.rows.copy()
    crowd.run(0.5)
    assert np.array_equal(crowd.wants.rows, before)


@mostly_long("seed", [0, 1], quick=[0])
def test_crowd_sent_to_one_point_comes_to_rest(seed):
    run = Simulation(one_point(40, seed))
    for _ in range(round(20.0 / TICK)):
        run.tick()
    before = run.position
    for _ in range(round(2.0 / TICK)):
        run.tick()
    assert np.abs(run.position - before).max() < 0.005
    assert np.linalg.norm(run.position, axis=1).max() < 3.0
