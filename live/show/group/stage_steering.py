"""Stage steering: what a patch says of its stage's gates, and of how agents are steered on it."""

import math

from live.agents.crowd.agent_state import Steering
from live.agents.entrances.gate import Gate, wings
from live.show.patch.patch import Patch


def gates_of(patch: Patch, half_width: float, half_depth: float) -> tuple[Gate, ...]:
    """The gates of a patch on a stage of these half sizes [m]; the usual wings if it names none."""
    named = tuple(
        Gate.at_edge(gate.name, gate.at, gate.width, half_width=half_width, half_depth=half_depth)
        for gate in patch.gate
    )
    return named or wings(half_width, half_depth)


def steering_of(patch: Patch) -> Steering:
    """The parameters of a patch's steering."""
    section = patch.steering
    return Steering(
        half_width=patch.stage.width / 2,
        half_depth=patch.stage.depth / 2,
        avoidance=section.avoidance,
        acceleration=section.acceleration,
        turn_rate=math.radians(section.turn_deg_s),
        d_s=section.near,
        d_f=section.far,
    )
