"""Per-agent steering commands: preferred velocity, speed limit and neighbour weights for one tick (T080, T083).

Choreography (elements and evolutions) writes the commands; this is Reynolds' action selection. `Advance` turns them
into collision-free motion.
"""

from typing import Final

import numpy as np

from live.base.arrays import Float32

# columns of Wants.rows, used by the kernels
VX: Final = 0
VZ: Final = 1
SPEED: Final = 2
SEPARATION: Final = 3
ALIGNMENT: Final = 4
COHESION: Final = 5
FIRM: Final = 6
PRESENCE: Final = 7
COMMAND_COLUMNS: Final = 8

LEASH: Final = 0.6
"""Largest distance of an agent from its dancer on the stage, outside evolutions [m]."""
LONG_LEASH: Final = 0.9
"""Largest distance of an agent from its dancer while entering or leaving [m]."""

ABSENT: Final = 0.0
"""Not on the stage: the agent does not move and is not drawn."""
ON_STAGE: Final = 1.0
"""The agent is kept within the stage edges."""
PASSING: Final = 2.0
"""The agent enters or leaves through wings or a gate and may cross the stage edges."""


class AgentCommand:
    """Steering commands of A agents; all array properties are views of `rows` (A, 8), which the kernels read."""

    def __init__(self, agent_count: int) -> None:
        self.rows: Float32 = np.zeros((agent_count, COMMAND_COLUMNS), np.float32)
        self.rows[:, PRESENCE] = ON_STAGE
        self._bits = self.rows.reshape(-1).view(np.uint32)
        kept = np.zeros((agent_count, COMMAND_COLUMNS), np.uint32)
        kept[:, [SPEED, PRESENCE]] = 0xFFFFFFFF
        self._kept = kept.reshape(-1)

    def reset(self, speed: Float32, separation: float) -> None:
        """Reset all commands except presence; set the speed limit to `speed` (A,) [m/s] and `separation` [m]."""
        self.rows[:, :PRESENCE] = 0.0
        self.rows[:, SPEED], self.rows[:, SEPARATION] = speed, separation

    def raise_firm_speeds(self, speed: Float32, factor: float) -> None:
        """Raise the speed limit of agents with a firm command to `factor` times `speed` (A,) [m/s]."""
        firm = self.rows[:, FIRM] > 0.0
        self.rows[firm, SPEED] = speed[firm] * np.float32(factor)

    @property
    def velocity(self) -> Float32:
        """Preferred velocity [m/s], shape (A, 2); clamped to `speed`."""
        return self.rows[:, VX : VZ + 1]

    @property
    def speed(self) -> Float32:
        """Current speed limit [m/s], shape (A,)."""
        return self.rows[:, SPEED]

    @property
    def separation(self) -> Float32:
        """Distance between centres [m] below which neighbours repel each other, shape (A,); 0 disables it."""
        return self.rows[:, SEPARATION]

    @property
    def alignment(self) -> Float32:
        """Weight of matching the neighbours' velocity, shape (A,); 0 disables it, 1 equals all other behaviours
        together.
        """
        return self.rows[:, ALIGNMENT]

    @property
    def cohesion(self) -> Float32:
        """Weight of moving to the neighbours' centre, shape (A,)."""
        return self.rows[:, COHESION]

    @property
    def firmness(self) -> Float32:
        """Strictness of the preferred velocity, 0 to 1, shape (A,).

        At 1 (a planned evolution) separation, alignment and cohesion are ignored and the velocity applies at once; only
        a predicted collision still turns the agent aside.
        """
        return self.rows[:, FIRM]

    @property
    def presence(self) -> Float32:
        """ABSENT, ON_STAGE or PASSING, shape (A,)."""
        return self.rows[:, PRESENCE]

    def clear(self) -> None:
        """Clear all commands; presence and speed limits stay."""
        np.bitwise_and(self._bits, self._kept, self._bits)  # one pass over all columns: four times as fast
