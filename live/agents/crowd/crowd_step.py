"""One fixed simulation tick of the crowd."""

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.obstacles import Surroundings
from live.agents.crowd.step_kernels import CELL_ROWS, NUMBERS, ROWS, SPARE_COLUMNS, advance_crowd


class CrowdStepper:
    """Advances states of the agents of `model`; holds parameters and scratch arrays, no agent state."""

    def __init__(self, model: AgentModel) -> None:
        count = model.agent_count
        self._agent_count = count
        of_agents = np.stack([model.radius, model.responsibility], 1, dtype=np.float32)
        self._fixed = np.concatenate([of_agents.ravel(), model.steering.vector()])
        self._rows = np.zeros((ROWS, count + SPARE_COLUMNS), np.float32)
        self._numbers = np.zeros(NUMBERS * (count + SPARE_COLUMNS) + CELL_ROWS * (8 * count + 258), np.int32)

    def resize(self, half_width: float, half_depth: float) -> None:
        """Set the stage's half sizes [m]; agents outside move in."""
        begin = 2 * self._agent_count
        self._fixed[begin : begin + 2] = half_width, half_depth

    def set_steering(self, steering: Steering) -> None:
        """Replace the steering parameters except the stage size."""
        begin = 2 * self._agent_count
        self._fixed[begin + 2 :] = steering.vector()[2:]

    def set_responsibility(self, rows: npt.NDArray[np.integer], responsibility: npt.NDArray[np.floating]) -> None:
        """Set the responsibility (n,) of the agents `rows` (n,)."""
        self._fixed[2 * rows + 1] = responsibility

    def __call__(
        self,
        current: AgentState,
        out: AgentState,
        *,
        commands: AgentCommand,
        surroundings: Surroundings,
        time: float,
        dt: float,
    ) -> None:
        """Read `current`, write `out` (another object), `dt` [s] later; `time` [s] is that of `current`.

        The kernel has few arguments, since each costs as much as one agent.
        """
        advance_crowd(
            out.flat, current.flat, self._fixed, commands.rows, surroundings.flat, dt, self._rows, self._numbers
        )
