"""Round obstacles are bypassed, also head on; agents with a goal inside rest beside them; walls stop agents."""

import numpy as np
import pytest

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings


def walk(start, goal, surroundings, firm=0.0, seconds=9.0):
    """Runs agents from `start` to `goal`; returns their positions and the smallest distance to (0, 0)."""
    count, goal = len(start), np.array(goal, float)
    model = AgentModel(np.full(count, 0.25, np.float32), np.ones(count, np.float32), Steering(), 1)
    state, advance, wants = AgentState.at_rest(np.array(start, float)), CrowdStepper(model), AgentCommand(count)
    spare, nearest = AgentState.at_rest(state.position), np.inf
    for tick in range(round(seconds * 64)):
        wants.clear()
        wants.speed[:], way = 1.2, goal - state.position
        far = np.maximum(np.hypot(*way.T), 1e-6)
        wants.velocity[:] = way * (np.minimum(1.2, far) / far)[:, None]
        wants.firmness[:] = firm
        advance(state, spare, commands=wants, surroundings=surroundings, time=tick / 64, dt=1 / 64)
        state, spare = spare, state
        nearest = min(nearest, float(np.hypot(*state.position.T).min()))
    return state.position, nearest


@pytest.mark.parametrize("firm", [0.0, 1.0])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_agent_bypasses_obstacle_on_its_path(firm, angle):
    surroundings = Surroundings()
    surroundings.set_obstacle("box", 0.0, 0.0, 0.6)
    begin = 3.0 * np.array([np.sin(angle), np.cos(angle)])
    end, nearest = walk([begin], [-begin], surroundings, firm)
    assert end[0] == pytest.approx(-begin, abs=0.05)
    assert nearest > 0.85 - 0.01


def test_agent_with_goal_inside_obstacle_rests_beside_it():
    surroundings = Surroundings()
    surroundings.set_obstacle("singer", 0.0, 0.0, 0.6)
    start = [(0.0, 3.0), (3.0, 0.0), (-3.0, 0.1)]
    before, _ = walk(start, [(0.0, 0.0)] * 3, surroundings)
    after, _ = walk(start, [(0.0, 0.0)] * 3, surroundings, seconds=12.0)
    assert np.hypot(*before.T) == pytest.approx(0.85, abs=0.02)
    assert np.abs(after - before).max() < 0.05


def test_wall_stops_agents():
    surroundings = Surroundings()
    surroundings.set_wall("wall", -4.0, 0.0, 4.0, 0.0)
    end, _ = walk([(0.0, 2.0), (1.0, 2.0)], [(0.0, -2.0), (1.0, -2.0)], surroundings)
    assert (end[:, 1] >= 0.25 - 1e-3).all()
