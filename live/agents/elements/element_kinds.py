"""Kinds of procedural elements, kinds of flow, and bounds: the numbers that elements, kernels and drawing share."""

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
"""The words of patches, scores and addresses."""

FLOW_NAMES: Final = {"uniform": UNIFORM, "radial": RADIAL, "vortex": VORTEX, "drawn": DRAWN, "grid": GRID}

EVERYBODY: Final = (1 << 64) - 1
"""The group mask of an element that addresses all dancers, also those who belong to no group."""
VERTEX_COUNT: Final = 64
"""Corners that the kernels keep of a drawn line; a longer one is simplified."""
POINT_LIMIT: Final = 4096
"""Points that a line may be drawn with."""

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
