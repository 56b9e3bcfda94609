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
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VOICE,
    VORTEX,
    WANDER,
)

KIND_COUNT: Final = 12

KIND_NAMES: Final = {
    "attract": ATTRACTOR,
    "repel": REPULSOR,
    "spread": SPREADER,
    "cross": CROSSING,
    "flow": FLOW,
    "wander": WANDER,
    "flock": FLOCK,
    "follow": FOLLOW,
    "pursue": PURSUE,
    "evade": EVADE,
    "path": PATH,
}
"""Names used in patches, scores and OSC addresses."""

FLOW_NAMES: Final = {"uniform": UNIFORM, "radial": RADIAL, "vortex": VORTEX, "drawn": DRAWN, "grid": GRID}

EVERYBODY: Final = (1 << 64) - 1
"""Group mask that addresses all dancers, including those of no group."""
VERTEX_COUNT: Final = 64
"""Largest number of vertices kept for a drawn line; longer lines are simplified."""
POINT_LIMIT: Final = 4096
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
    "FLOW_NAMES",
    "FOLLOW",
    "GRID",
    "KIND_COUNT",
    "KIND_NAMES",
    "PATH",
    "POINT_LIMIT",
    "PURSUE",
    "RADIAL",
    "REPULSOR",
    "SPREADER",
    "UNIFORM",
    "VERTEX_COUNT",
    "VOICE",
    "VORTEX",
    "WANDER",
]
