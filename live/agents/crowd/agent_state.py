"""Agent data: constant model, state per tick, and steering parameters; one agent per dancer."""

import math
from dataclasses import dataclass, fields
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32

Avoidance = Literal["predictive", "thesis"]
AVOIDANCES: Final[tuple[Avoidance, ...]] = ("predictive", "thesis")

STATE_COLUMNS: Final = 8
"""Numbers per agent state: position 2, velocity 2, acceleration 2, rest, heed."""


@dataclass(frozen=True, slots=True)
class Steering:
    """Parameters of the steering behaviours, in metres, seconds and radians, in the order of the kernels' parameter
    vector.

    Numbers from a paper cite it; all others were tuned on the scenarios of `live bench crowd`.
    """

    half_width: float | None = 6.0
    """Half the stage width [m]; None: unbounded."""
    half_depth: float | None = 4.0
    """Half the stage depth [m]; None: unbounded."""
    avoidance: Avoidance = "predictive"
    """Collision avoidance: by time to collision, or by the two distances of T108."""
    acceleration: float = 6.0
    """Largest acceleration [m/s²]."""
    turn_rate: float = 5.0
    """Largest turn rate of the walking direction [rad/s]."""
    relaxation: float = 0.5
    """Time constant [s] towards the preferred velocity (T081: force = desired - current velocity)."""
    horizon: float = 3.0
    """Look-ahead of the predictive mode [s]: τ0, and the cut-off of the power law (2014: τ0 = 3 s, no cut-off)."""
    strength: float = 2.5
    """k of the power law [m²/s²] of Karamouzas, Skinner & Guy (2014: 1.5, measured on pedestrians)."""
    side: float = 0.1
    """Angle [rad] by which neighbours are shifted to the left in perception, so all keep to the right; < 0: to the
    left.
    """
    d_s: float = 0.8
    """T108, thesis mode [m]: below this distance all other behaviours are ignored and the speed is limited."""
    d_f: float = 2.0
    """T108, thesis mode [m]: between d_s and this all forces are combined; no avoidance beyond it."""
    edge: float = 0.25
    """Minimum time [s] to reach a stage edge, wall or obstacle; limits the speed towards it."""

    lag: float = 0.06
    """Time constant [s] of the acceleration; keeps the jerk low."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in ("avoidance", "half_width", "half_depth", "side"):
                continue
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{field.name} has to be a number of at least 0")
        if self.avoidance not in AVOIDANCES:
            raise ValueError(f"avoidance has to be one of {', '.join(AVOIDANCES)}")

    def vector(self) -> Float32:
        """Return all parameters in order, shape (13,); an unbounded side is inf."""
        values: list[float] = []
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "avoidance":
                value = float(AVOIDANCES.index(value))
            values.append(math.inf if value is None else value)
        return np.array(values, np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class AgentModel:
    """Data of A agents that is constant during a show."""

    radius: Float32
    """Body radius [m], shape (A,)."""
    responsibility: Float32
    """Share of collision avoidance, shape (A,): 1 usual, 0 for a soloist with right of way."""
    steering: Steering
    seed: int

    def __post_init__(self) -> None:
        if self.responsibility.shape != self.radius.shape:
            raise ValueError("every agent needs a radius and a responsibility")
        if not (np.isfinite(self.radius).all() and (self.radius > 0).all()):
            raise ValueError("every agent needs a radius above 0 m")
        if not ((self.responsibility >= 0).all() and (self.responsibility <= 1).all()):
            raise ValueError("responsibilities are between 0 and 1")

    @property
    def agent_count(self) -> int:
        """Number of agents A."""
        return len(self.radius)


class AgentState:
    """State of A agents at one tick; the arrays are contiguous views of `flat`, which the kernels read."""

    __slots__ = ("acceleration", "flat", "position", "rest", "rest_separation", "velocity")

    def __init__(self, agent_count: int) -> None:
        a = agent_count
        self.flat: Float32 = np.zeros(STATE_COLUMNS * a, np.float32)
        """All fields below, concatenated, shape (8 A,)."""
        self.position: Float32 = self.flat[: 2 * a].reshape(a, 2)
        """Stage position (x, z) [m], shape (A, 2)."""
        self.velocity: Float32 = self.flat[2 * a : 4 * a].reshape(a, 2)
        """Velocity [m/s], shape (A, 2)."""
        self.acceleration: Float32 = self.flat[4 * a : 6 * a].reshape(a, 2)
        """Low-pass filtered acceleration [m/s²], shape (A, 2)."""
        self.rest: Float32 = self.flat[6 * a : 7 * a]
        """Time without motion [s], shape (A,); the agent sleeps from SLEEP_TIME on."""
        self.rest_separation: Float32 = self.flat[7 * a :]
        """Separation [m] at which the agent came to rest, shape (A,); a different value wakes it."""

    @staticmethod
    def at_rest(position: npt.NDArray[np.floating]) -> "AgentState":
        """Return agents at rest at `position` [m], shape (A, 2)."""
        state = AgentState(len(position))
        state.position[:] = position
        return state

    def copy_from(self, other: "AgentState") -> None:
        """Copy the values of another state of the same size."""
        self.flat[:] = other.flat
