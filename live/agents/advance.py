"""Advance: one fixed tick of the group's motion, and the look-ahead on a copy that the dancers plan with."""

import numpy as np

from live.agents.elements import ElementField
from live.agents.kernels import NEIGHBOUR_RANGE, advance_agents, cell_count, part_positions
from live.agents.model import AgentModel, AgentState, Float32


class Advance:
    """Advances a state of the agents of `model`; holds the scratch arrays, no state of its own."""

    def __init__(self, model: AgentModel) -> None:
        self._model = model
        steering = model.steering
        self._params = steering.vector()
        width, depth = 2.0 * steering.half_width, 2.0 * steering.half_depth
        cells = cell_count(width, NEIGHBOUR_RANGE) * cell_count(depth, NEIGHBOUR_RANGE)
        self._cell_start = np.zeros(cells + 1, np.int32)
        self._order = np.zeros(model.agent_count, np.int32)
        self._population = np.zeros(cell_count(width, steering.cell) * cell_count(depth, steering.cell), np.int32)

    def __call__(
        self,
        current: AgentState,
        out: AgentState,
        *,
        speed: Float32,
        dancer: Float32,
        field: ElementField,
        time: float,
        dt: float,
    ) -> None:
        """Read `current`, write `out` (another object), `dt` [s] later.

        `speed` (A,) is each agent's top speed [m/s], `dancer` (A, 2) where its dancer stands [m].
        """
        advance_agents(
            out.position,
            out.velocity,
            current.position,
            current.velocity,
            self._model.radius,
            speed,
            dancer,
            field.kind,
            field.position,
            field.strength,
            field.count,
            self._params,
            self._model.seed,
            time,
            dt,
            self._cell_start,
            self._order,
            self._population,
        )


class Parting:
    """Keeps places apart from each other: the ends of the dancers' next measures must not fall onto one spot."""

    ROUNDS = 6

    def __init__(self, model: AgentModel, gap: float) -> None:
        """`gap` [m]: how far apart two dancers shall be."""
        self._model = model
        self._gap = gap
        steering = model.steering
        self._cell_start = np.zeros(
            cell_count(2.0 * steering.half_width, NEIGHBOUR_RANGE)
            * cell_count(2.0 * steering.half_depth, NEIGHBOUR_RANGE)
            + 1,
            np.int32,
        )
        self._order = np.zeros(model.agent_count, np.int32)

    def __call__(self, position: Float32, anchor: Float32, most: float) -> None:
        """Move `position` (A, 2) apart in place, nobody farther than `most` [m] from its `anchor` (A, 2)."""
        steering = self._model.steering
        part_positions(
            position,
            anchor,
            self._gap,
            most,
            steering.half_width,
            steering.half_depth,
            self.ROUNDS,
            self._model.seed,
            self._cell_start,
            self._order,
        )


class LookAhead:
    """Where the agents will be: the same kernel on a copy, in coarse steps spread over several ticks.

    A beat before a measure ends its dancers choose their next step by where their agents will stand when the *next*
    measure ends. Running all of it in one tick would make that frame late; so `work` does a few steps at a time.
    """

    STEP = 1.0 / 16.0
    """Seconds of one coarse step."""

    def __init__(self, model: AgentModel, advance: Advance) -> None:
        self._advance = advance
        self._state = AgentState.at(np.zeros((model.agent_count, 2)))
        self._spare = AgentState.at(np.zeros((model.agent_count, 2)))
        self._left = 0.0
        self._time = 0.0

    def begin(self, state: AgentState, *, time: float, seconds: float) -> None:
        """Start from `state` at `time` [s]; look `seconds` ahead."""
        self._state.copy_from(state)
        self._left = seconds
        self._time = time

    @property
    def done(self) -> bool:
        """Whether the copy has reached its end."""
        return self._left <= 1e-9

    def work(self, steps: int, *, speed: Float32, field: ElementField) -> None:
        """Do at most `steps` coarse steps. The copies are on no leash: their dancers are taken to keep up."""
        for _ in range(steps):
            if self.done:
                return
            dt = min(self.STEP, self._left)
            self._advance(
                self._state,
                self._spare,
                speed=speed,
                dancer=self._state.position,
                field=field,
                time=self._time,
                dt=dt,
            )
            self._state, self._spare = self._spare, self._state
            self._left -= dt
            self._time += dt

    @property
    def position(self) -> Float32:
        """Predicted positions [m], shape (A, 2)."""
        return self._state.position
