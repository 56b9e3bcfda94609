"""Wants: what every agent is asked to do at a tick; choreography writes it, steering makes it safe (T080, T083).

Reynolds' action selection ends here: elements and evolutions have said what they want of each agent, as a desired
velocity and as weights of what an agent does with her neighbours; `Advance` turns that into motion without collisions.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]

# columns of Wants.rows, for the kernels
VX: Final = 0
VZ: Final = 1
SPEED: Final = 2
SEPARATION: Final = 3
ALIGNMENT: Final = 4
COHESION: Final = 5
FIRM: Final = 6
PRESENCE: Final = 7
WANT_COLUMNS: Final = 8

ABSENT: Final = 0.0
"""Not on the stage: does not move, and nobody sees her."""
ON_STAGE: Final = 1.0
"""The stage edges keep her in."""
PASSING: Final = 2.0
"""She enters or leaves through wings or a gate: the stage edges let her pass."""


class Wants:
    """What A agents are asked to do now; the arrays are views of `rows` (A, 8), which the kernels take."""

    def __init__(self, agent_count: int) -> None:
        self.rows: Float32 = np.zeros((agent_count, WANT_COLUMNS), np.float32)
        self.rows[:, PRESENCE] = ON_STAGE
        self._bits = self.rows.reshape(-1).view(np.uint32)
        kept = np.zeros((agent_count, WANT_COLUMNS), np.uint32)
        kept[:, [SPEED, PRESENCE]] = 0xFFFFFFFF
        self._kept = kept.reshape(-1)

    @property
    def velocity(self) -> Float32:
        """Desired velocity [m/s], shape (A, 2); longer than `speed` means as fast as she may."""
        return self.rows[:, VX : VZ + 1]

    @property
    def speed(self) -> Float32:
        """Top speed now [m/s], shape (A,)."""
        return self.rows[:, SPEED]

    @property
    def separation(self) -> Float32:
        """Distance between centres [m] under which neighbours push each other away, shape (A,); 0: never."""
        return self.rows[:, SEPARATION]

    @property
    def alignment(self) -> Float32:
        """Weight of going where the neighbours go, shape (A,); 0: not at all, 1: as much as everything else."""
        return self.rows[:, ALIGNMENT]

    @property
    def cohesion(self) -> Float32:
        """Weight of going to the middle of the neighbours, shape (A,)."""
        return self.rows[:, COHESION]

    @property
    def firm(self) -> Float32:
        """0 to 1, shape (A,): how strictly the desired velocity is to be kept.

        At 1 (an evolution, which has been planned) separation, alignment and cohesion say nothing and the velocity
        is taken up at once; only a collision that is really coming still turns her aside.
        """
        return self.rows[:, FIRM]

    @property
    def presence(self) -> Float32:
        """ABSENT, ON_STAGE or PASSING, shape (A,)."""
        return self.rows[:, PRESENCE]

    def rest(self) -> None:
        """Nobody wants anything; presence and top speeds stay."""
        np.bitwise_and(self._bits, self._kept, self._bits)  # one pass over all columns, four times as fast
