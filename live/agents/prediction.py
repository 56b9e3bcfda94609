"""Prediction of agent positions: the same steering runs on a copy, in coarse steps spread over several ticks."""

from collections.abc import Callable, Sequence
from typing import Final, Protocol

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState
from live.agents.crowd.obstacles import Surroundings
from live.base.arrays import Float32

CommandSource = Callable[[AgentCommand, AgentState, float], None]
"""Fills the commands of agents in a state at a time [s]; must have no other effect."""


class CrowdAdvance(Protocol):
    """Callable that advances agents by one step, such as `Advance` or the pair simulation."""

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
        """Read `current`, write `out`, `dt` [s] later."""


class CrowdPrediction:
    """Incremental prediction of agent positions.

    One beat before a measure ends, the next step is chosen from the predicted positions at the end of the *next*
    measure. Computing this in one tick would delay the frame, so `run` runs a few steps at a time.
    """

    STEP: Final = 1.0 / 16.0
    """Length of a coarse step [s]."""

    def __init__(
        self, agent_count: int, advance: CrowdAdvance, surroundings: Surroundings, fill_commands: CommandSource
    ) -> None:
        self._advance, self._surroundings, self._fill_commands = advance, surroundings, fill_commands
        self._commands = AgentCommand(agent_count)
        self._state = AgentState(agent_count)
        self._spare = AgentState(agent_count)
        self._stops: list[float] = []
        self._time = 0.0
        self.positions: list[Float32] = []
        """Predicted positions [m] at each requested moment reached so far, shape (A, 2) each."""

    def begin(self, state: AgentState, *, time: float, seconds: Sequence[float]) -> None:
        """Start from `state` at `time` [s]; predict for each of `seconds` ahead, ascending and not below 0."""
        self._state.copy_from(state)
        self._stops = [time + ahead for ahead in seconds]
        self._time = time
        self.positions = []

    @property
    def done(self) -> bool:
        """Whether all requested moments are predicted."""
        return len(self.positions) == len(self._stops)

    def run(self, steps: int) -> None:
        """Run at most `steps` coarse steps. No leash applies: the dancers are assumed to keep up."""
        for _ in range(steps):
            while not self.done and self._stops[len(self.positions)] - self._time <= 1e-9:
                self.positions.append(self._state.position.copy())
            if self.done:
                return
            dt = min(self.STEP, self._stops[len(self.positions)] - self._time)
            self._fill_commands(self._commands, self._state, self._time)
            self._advance(
                self._state,
                self._spare,
                commands=self._commands,
                surroundings=self._surroundings,
                time=self._time,
                dt=dt,
            )
            self._state, self._spare = self._spare, self._state
            self._time += dt
