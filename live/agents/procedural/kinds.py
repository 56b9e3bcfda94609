"""Kinds of procedural elements, kinds of flow, and bounds: the numbers that elements, kernels and drawing share."""

from typing import Final

from live.base.stage_view import ATTRACTOR, ELEMENT_CAPACITY, REPULSOR, SPREADER

CROSSING: Final = 3
FLOW: Final = 4
WANDER: Final = 5
FLOCK: Final = 6
FOLLOW: Final = 7
PURSUE: Final = 8
EVADE: Final = 9
PATH: Final = 10
VOICE: Final = 11
"""In the arrays only: an attractor with `fair` set, one of an audience's many."""
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

UNIFORM: Final = 0
RADIAL: Final = 1
VORTEX: Final = 2
DRAWN: Final = 3
GRID: Final = 4
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
