"""Words of the stage: places, directions and sides as a dancer says them who faces the audience."""

import math
from typing import Final

NEAR_M: Final = 0.05
"""A distance that rounds to nothing [m]."""
DIRECTIONS: Final = (
    "down stage", "down stage left", "stage left", "up stage left",
    "up stage", "up stage right", "stage right", "down stage right",
)  # fmt: skip
"""Directions by eighths, from the audience (+z) over the dancer's left (+x)."""
FACINGS: Final = (
    "the audience", "down stage left", "stage left", "up stage left",
    "up stage", "up stage right", "stage right", "down stage right",
)  # fmt: skip


def place_words(x: float, z: float) -> str:
    """Return a place [m] in words: `2.5 m left of centre, 1.0 m down stage`."""
    across = "on the centre line" if abs(x) < NEAR_M else f"{abs(x):.1f} m {'left' if x > 0 else 'right'} of centre"
    along = "at mid stage" if abs(z) < NEAR_M else f"{abs(z):.1f} m {'down' if z > 0 else 'up'} stage"
    return "on the centre" if abs(x) < NEAR_M and abs(z) < NEAR_M else f"{across}, {along}"


def place_numbers(x: float, z: float) -> str:
    """Return a place as the coordinates of the stage [m]: `x +2.5, z +1.0`."""
    return f"x {_signed(x)}, z {_signed(z)}"


def _signed(value: float) -> str:
    shown = f"{value:+.1f}".replace("-", "−")
    return "0.0" if shown in ("+0.0", "−0.0") else shown


def direction_words(dx: float, dz: float) -> str:
    """Return the direction of a way: `up stage left`."""
    return DIRECTIONS[_eighth(math.atan2(dx, dz))]


def facing_words(heading: float) -> str:
    """Return what somebody with this heading [rad] faces."""
    return FACINGS[_eighth(heading)]


def _eighth(angle: float) -> int:
    return round(angle / (math.pi / 4.0)) % 8


def side_words(heading: float, dx: float, dz: float) -> str:
    """Return on which side of a dancer with this heading [rad] another is who stands (dx, dz) [m] from her."""
    angle = math.remainder(math.atan2(dx, dz) - heading, 2.0 * math.pi)
    if abs(angle) < math.pi / 6.0:
        return "in front of you"
    if abs(angle) > 5.0 * math.pi / 6.0:
        return "behind you"
    return "on your left" if angle > 0.0 else "on your right"
