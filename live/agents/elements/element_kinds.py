"""Constants of elements shared by elements, kernels and drawing: kinds, kinds of flow, and limits."""

from typing import Final

from live.base.stage_snapshot import (
    ATTRACTOR,
    CROSSING,
    DRAWN,
    ELEMENT_CAPACITY,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    GRID,
    PARTICIPANT,
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VORTEX,
    WANDER,
)

KIND_COUNT: Final = 12

EVERYBODY: Final = (1 << 64) - 1
"""Group mask that addresses all dancers, including those of no group."""
MAX_VERTICES: Final = 64
"""Largest number of vertices kept for a drawn line; longer lines are simplified."""
MAX_POINTS: Final = 4096
"""Largest number of points of a drawn line."""

__all__ = [
    "ATTRACTOR",
    "CROSSING",
    "DRAWN",
    "ELEMENT_CAPACITY",
    "EVADE",
    "EVERYBODY",
    "FLOCK",
    "FLOW",
    "FOLLOW",
    "GRID",
    "KIND_COUNT",
    "MAX_POINTS",
    "MAX_VERTICES",
    "PARTICIPANT",
    "PATH",
    "PURSUE",
    "RADIAL",
    "REPULSOR",
    "SPREADER",
    "UNIFORM",
    "VORTEX",
    "WANDER",
]
