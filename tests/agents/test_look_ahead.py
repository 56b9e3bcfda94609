"""CrowdPrediction: the same motion as the stepper it copies, for any batch size."""

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.prediction import CrowdPrediction


def write_commands(wants, state, time):
    """Commands every agent to (2, 1)."""
    wants.clear()
    wants.speed[:] = 0.8
    wants.separation[:] = 1.0
    way = np.array([2.0, 1.0]) - state.position
    wants.velocity[:] = way * np.minimum(1.0, 0.8 / np.maximum(np.hypot(*way.T), 1e-6))[:, None]


def scene(count=15):
    model = AgentModel(np.full(count, 0.25, np.float32), np.ones(count, np.float32), Steering(), 1)
    chance = np.random.default_rng(2)
    surroundings = Surroundings()
    surroundings.set_obstacle("box", 0.5, 0.0, 0.4)
    state = AgentState.at_rest(chance.uniform(-3, 3, (count, 2)))
    return state, CrowdStepper(model), surroundings


def test_prediction_is_independent_of_batch_size():
    results = []
    for piece in (1, 3, 1000):
        state, advance, surroundings = scene()
        look = CrowdPrediction(15, advance, surroundings, write_commands)
        look.begin(state, time=0.0, seconds=[1.3, 2.6])
        while not look.done:
            look.run(piece)
        results.append(np.array(look.positions))
    assert (results[0] == results[1]).all()
    assert (results[0] == results[2]).all()
    assert np.abs(results[0][0] - results[0][1]).max() > 0.1


def test_prediction_is_accurate_and_leaves_state_unchanged():
    state, advance, surroundings = scene()
    before = state.flat.copy()
    look = CrowdPrediction(15, advance, surroundings, write_commands)
    look.begin(state, time=0.0, seconds=[2.5])
    look.run(10**6)
    assert (state.flat == before).all()
    spare, wants = AgentState.at_rest(state.position), AgentCommand(15)
    for tick in range(160):
        write_commands(wants, state, tick / 64)
        advance(state, spare, commands=wants, surroundings=surroundings, time=tick / 64, dt=1 / 64)
        state, spare = spare, state
    assert np.hypot(*(look.positions[0] - state.position).T).mean() < 0.15


def test_prediction_accepts_zero_agents():
    state, advance, surroundings = scene(0)
    look = CrowdPrediction(0, advance, surroundings, write_commands)
    look.begin(state, time=0.0, seconds=[1.0])
    look.run(100)
    assert look.done
