"""A stage for tests: agents, commands, a field of elements and ticks of the crowd."""

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.elements.element_field import ElementField

TICK = 1.0 / 64.0
SPEED = 1.3


class StageHarness:
    """A agents at `position`; a beat lasts half a second; elements are added before or during the run."""

    def __init__(self, position, *elements, size=(12.0, 8.0), seed=1, groups=None, combine="blended", separation=1.0):
        position = np.atleast_2d(np.asarray(position, np.float32))
        self.count = len(position)
        half = (size[0] / 2, size[1] / 2)
        self.state, self.spare = AgentState.at_rest(position), AgentState.at_rest(position)
        self.wants = AgentCommand(self.count)
        self.wants.speed[:] = SPEED
        self.groups = np.zeros(self.count, np.uint64) if groups is None else np.array(groups, np.uint64)
        self.field = ElementField(
            self.count, half_width=half[0], half_depth=half[1], seed=seed, combine=combine, separation=separation
        )
        for element in elements:
            assert self.field.add(element)
        steering = Steering(half_width=half[0], half_depth=half[1])
        ones = np.ones(self.count, np.float32)
        self.advance = CrowdStepper(AgentModel(0.25 * ones, ones, steering, seed))
        self.surroundings = Surroundings()
        self.ticks = 0

    def wish(self, beat=8.0, *, planned=None, time=None):
        """Commanded velocities after one call at `beat`, as shares of the top speed, shape (A, 2)."""
        self.wants.clear()
        if planned is not None:
            self.wants.velocity[:] = planned
            self.wants.firmness[:] = 1.0
        self.field.refresh(beat, self.wants, self.state, self.groups)
        self.field.apply(self.wants, self.state, self.groups, time=beat / 2 if time is None else time)
        return self.wants.velocity / SPEED

    def run(self, seconds):
        """Advances the crowd; returns the positions at every eighth tick, shape (T, A, 2)."""
        kept = []
        for _ in range(round(seconds / TICK)):
            time = self.ticks * TICK
            self.wish(time * 2.0)
            self.advance(
                self.state, self.spare, commands=self.wants, surroundings=self.surroundings, time=time, dt=TICK
            )
            self.state, self.spare = self.spare, self.state
            self.ticks += 1
            if self.ticks % 8 == 0:
                kept.append(self.state.position.copy())
        return np.array(kept)
