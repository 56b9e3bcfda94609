"""Corners of a stage's floor, on the stage and in a projector's picture."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError

CORNERS: Final = ("back left", "back right", "front right", "front left")
"""The order of a stage's corners, as the audience sees them."""
MIN_CORNER_AREA: Final = 1e-4
"""Corners that span less than this share of the picture are degenerate."""


def floor_corners(width: float, depth: float) -> Float64:
    """Return the corners (x, z) [m] of a stage's floor in the order of `CORNERS`, shape (4, 2)."""
    x, z = 0.5 * width, 0.5 * depth
    return np.array([[-x, -z], [x, -z], [x, z], [-x, z]])


def check_corners(corners: Sequence[Sequence[float]]) -> None:
    """PersonError unless four corners (u, v) are those of a convex quadrilateral, in the order of `CORNERS`."""
    around = np.roll(np.asarray(corners, np.float64), -1, axis=0) - corners
    turns = np.array([around[i - 1, 0] * around[i, 1] - around[i - 1, 1] * around[i, 0] for i in range(4)])
    order = ", ".join(CORNERS)
    if (turns > 0.0).any() and (turns < 0.0).any():
        raise PersonError("the corners' lines cross, or one corner lies within the others", f"in this order: {order}")
    if np.abs(turns).min() < MIN_CORNER_AREA:
        raise PersonError("three of the corners lie on a line: they span no floor", f"in this order: {order}")
    if (turns < 0.0).all():
        raise PersonError(
            "the corners go around the other way: left and right are exchanged", f"in this order: {order}"
        )
