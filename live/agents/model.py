"""AgentModel and AgentState: what stays and what changes of the agents; one agent per dancer."""

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Steering:
    """Parameters of the steering behaviours; metres, seconds. The order is the order in the kernels' vector."""

    half_width: float = 6.0
    """Half the stage width [m]."""
    half_depth: float = 4.0
    """Half the stage depth [m]."""
    acceleration: float = 2.5
    """Largest acceleration [m/s²]."""
    attract_decay: float = 1.2
    """Decay length [m] of f(d) = exp(-d / decay); attraction is 1 - f (T105)."""
    repel_decay: float = 1.6
    """Decay length [m] of the repulsion f (T105)."""
    separation: float = 1.25
    """Distance [m] under which neighbours push each other away (T082)."""
    near: float = 0.75
    """d_s of T108 [m]: closer than this only the neighbour counts, and the speed is limited."""
    far: float = 1.2
    """d_f of T108 [m]: farther than this the neighbour does not weaken the other behaviours."""
    horizon: float = 2.0
    """Seconds that unaligned collision avoidance looks ahead (T082)."""
    edge: float = 0.5
    """Width [m] of the strip along the stage edges that pushes back in."""
    cell: float = 2.0
    """Size [m] of the spreaders' cells (T109)."""
    wander: float = 0.25
    """Share of the speed that wandering may take while agents spread (T109)."""
    leash: float = 0.9
    """An agent farther than this [m] from its dancer slows down until the dancer has followed."""

    def vector(self) -> Float64:
        """All parameters in their order, shape (13,)."""
        return np.array([getattr(self, field.name) for field in fields(self)], np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class AgentModel:
    """What does not change during a show (A agents)."""

    radius: Float32
    """Body radius [m], shape (A,)."""
    steering: Steering
    seed: int

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius).all() and (self.radius > 0).all()):
            raise ValueError("every agent needs a radius above 0 m")

    @property
    def agent_count(self) -> int:
        """Number of agents A."""
        return len(self.radius)


@dataclass(slots=True, eq=False)
class AgentState:
    """The agents at one tick (A agents)."""

    position: Float32
    """Stage position (x, z) [m], shape (A, 2)."""
    velocity: Float32
    """Velocity [m/s], shape (A, 2)."""

    @staticmethod
    def at(position: npt.NDArray[np.floating]) -> "AgentState":
        """Agents at rest at `position` [m], shape (A, 2)."""
        return AgentState(np.ascontiguousarray(position, np.float32), np.zeros(position.shape, np.float32))

    def copy_from(self, other: "AgentState") -> None:
        """Take over the values of another state of the same size."""
        self.position[:] = other.position
        self.velocity[:] = other.velocity
