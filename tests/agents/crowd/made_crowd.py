"""Crowds for tests: agents, their goals and a run of ticks."""

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings


class CrowdHarness:
    """Agents that walk to their goals at 1.3 m/s and slow down near them."""

    def __init__(self, position, goal=None, *, responsibility=None, radius=0.25, tick=1 / 64, **steering):
        position = np.asarray(position, float).reshape(-1, 2)
        count = len(position)
        unbounded = {"half_width": None, "half_depth": None}
        share = np.ones(count) if responsibility is None else responsibility
        model = AgentModel(
            np.full(count, radius, np.float32),
            np.asarray(share, np.float32),
            Steering(**{**unbounded, **steering}),
            seed=1,
        )
        self.advance = CrowdStepper(model)
        self.state, self.spare = AgentState.at_rest(position), AgentState(count)
        self.goal = None if goal is None else np.asarray(goal, float).reshape(-1, 2)
        self.wants, self.surroundings = AgentCommand(count), Surroundings()
        self.wants.speed[:] = 1.8
        self.tick, self.time = tick, 0.0

    def run(self, seconds, look=None):
        """Advances; calls `look(state)` after every tick; returns all positions (T, A, 2)."""
        track = [self.state.position.copy()]
        for _ in range(round(seconds / self.tick)):
            if self.goal is not None:
                way = self.goal - self.state.position
                distance = np.hypot(way[:, 0], way[:, 1])
                self.wants.velocity[:] = way * (np.minimum(1.3, distance) / np.maximum(distance, 1e-9))[:, None]
            self.advance(
                self.state,
                self.spare,
                commands=self.wants,
                surroundings=self.surroundings,
                time=self.time,
                dt=self.tick,
            )
            self.state, self.spare = self.spare, self.state
            self.time += self.tick
            track.append(self.state.position.copy())
            if look is not None:
                look(self.state)
        return np.array(track)


def smallest_distance(track):
    """The smallest distance between any two agents at any time [m]; track (T, A, 2)."""
    gap = np.hypot(*(track[:, :, None] - track[:, None]).transpose(3, 0, 1, 2))
    gap[:, np.arange(track.shape[1]), np.arange(track.shape[1])] = np.inf
    return gap.min()
