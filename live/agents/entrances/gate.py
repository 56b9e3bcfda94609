"""Gates: openings in the stage's edge through which dancers enter and leave."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64

WAITING_DISTANCE: Final = 0.7
"""Distance [m] outside the edge at which the first dancer waits, out of sight."""
WAITING_SPACING: Final = 0.8
"""Distance [m] of waiting dancers within and between rows."""


@dataclass(frozen=True, slots=True)
class Gate:
    """An opening of `width` [m] around (x, z) [m] on the stage's edge; (out_x, out_z) points off the stage."""

    name: str
    x: float
    z: float
    width: float
    out_x: float
    out_z: float

    @staticmethod
    def at_edge(name: str, at: tuple[float, float], width: float, *, half_width: float, half_depth: float) -> "Gate":
        """Return the gate at the point of the stage's edge nearest to `at` [m], no wider than that edge.

        ValueError if `at` or `width` is not finite or the width is not above zero.
        """
        x, z = at
        if not (math.isfinite(x) and math.isfinite(z) and math.isfinite(width)) or width <= 0.0:
            raise ValueError(f"gate {name!r}: its place and width must be numbers, the width above 0")
        if half_width - abs(x) <= half_depth - abs(z):  # nearer to a side than to the back or the front
            side, width = math.copysign(1.0, x), min(width, 2.0 * half_depth)
            room = half_depth - width / 2.0
            return Gate(name, side * half_width, min(max(z, -room), room), width, side, 0.0)
        side, width = math.copysign(1.0, z), min(width, 2.0 * half_width)
        room = half_width - width / 2.0
        return Gate(name, min(max(x, -room), room), side * half_depth, width, 0.0, side)

    def waiting_places(self, count: int) -> Float64:
        """Return waiting places outside for `count` dancers, in rows from the stage outwards, (count, 2) [m]."""
        across = max(1, math.floor(self.width / WAITING_SPACING))
        row, column = np.divmod(np.arange(count), across)
        in_row = np.minimum(count - row * across, across)
        aside = (column - (in_row - 1) / 2.0) * WAITING_SPACING
        out = WAITING_DISTANCE + row * WAITING_SPACING
        return np.stack(
            [self.x + self.out_x * out - self.out_z * aside, self.z + self.out_z * out + self.out_x * aside], 1
        )


def default_gates(half_width: float, half_depth: float) -> tuple[Gate, ...]:
    """Return the default gates: left, right (as the audience sees it) and back, each half an edge wide."""
    return tuple(
        Gate.at_edge(name, at, width, half_width=half_width, half_depth=half_depth)
        for name, at, width in (
            ("left", (-half_width, 0.0), half_depth),
            ("right", (half_width, 0.0), half_depth),
            ("back", (0.0, -half_depth), half_width),
        )
    )
