"""Advance: one fixed tick of the crowd."""

import numpy as np

from live.agents.crowd.kernels import advance_crowd
from live.agents.crowd.model import AgentModel, AgentState
from live.agents.crowd.surroundings import Surroundings
from live.agents.wants import Wants


class Advance:
    """Advances states of the agents of `model`; holds scratch arrays, no state of its own."""

    def __init__(self, model: AgentModel) -> None:
        count = model.agent_count
        self._numbers_of_model = np.ascontiguousarray(np.stack([model.radius, model.responsibility], 1), np.float32)
        self._params = model.steering.vector()
        self._seed = model.seed
        self._rows = np.zeros((45, count + 32), np.float32)
        self._numbers = np.zeros((20, count + 32), np.int32)
        self._start = np.zeros(4 * count + 66, np.int32)

    def __call__(
        self,
        current: AgentState,
        out: AgentState,
        *,
        wants: Wants,
        surroundings: Surroundings,
        time: float,
        dt: float,
    ) -> None:
        """Read `current`, write `out` (another object), `dt` [s] later; `time` [s] is that of `current`."""
        advance_crowd(
            out.flat,
            current.flat,
            self._numbers_of_model,
            wants.rows,
            surroundings.walls,
            surroundings.wall_count,
            surroundings.obstacles,
            surroundings.obstacle_count,
            self._params,
            self._seed,
            time,
            dt,
            self._rows,
            self._numbers,
            self._start,
        )
