"""Measures of the left hand's fingers in the rest pose, and how they bend.

The rest pose is a flat hand, palm down, fingers along +x, a little apart, the thumb in front. Lengths of the phalanges
follow Buryanov and Kotiuk (2010), scaled to a hand of 0.18 m.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Finger:
    """A finger of the left hand [m, rad]."""

    name: str
    places: tuple[Vector, Vector, Vector, Vector]
    """Its three joints, and its tip."""
    wide: float
    """Half-width at the middle joint, …"""
    thick: float
    """… and half-thickness."""
    curl: tuple[Vector, Vector, Vector]
    """Rotation vector of each joint for a fist, in the axes of the rest pose."""
    spread: Vector
    """Rotation vector of the first joint for fingers spread wide; reversed, the fingers touch."""

    def direction(self, phalanx: int) -> Float64:
        """Return the unit direction of a phalanx, 0 to 2."""
        along = np.subtract(self.places[phalanx + 1], self.places[phalanx])
        return np.asarray(along / np.linalg.norm(along))


_FIST: Final = (1.54, 1.90, 1.28)
"""How far the three joints of a finger bend in a fist [rad]."""


def _finger(
    name: str, knuckle: Vector, aside: float, lengths: Vector, wide: float, thick: float, fist: float = 1.0
) -> Finger:
    """Return a straight finger that points `aside` [rad] of +x, towards the thumb."""
    along = np.array([np.cos(aside), -0.035, np.sin(aside)])
    far = [np.add(knuckle, along * reach) for reach in np.cumsum(lengths)]
    across = np.array([np.sin(aside), 0.0, -np.cos(aside)])
    places = (knuckle, *(_vector(place) for place in far))
    turns = [_vector(across * bend) for bend in (_FIST[0] * fist, *_FIST[1:])]
    return Finger(name, places, wide, thick, (turns[0], turns[1], turns[2]), (0.0, -1.3 * aside, 0.0))  # type: ignore[arg-type]


def _vector(values: Float64) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])


FINGERS: Final = (
    Finger(
        "Thumb",
        ((0.702, 1.371, 0.012), (0.736, 1.363, 0.040), (0.761, 1.358, 0.058), (0.783, 1.354, 0.071)),
        0.0098,
        0.0088,
        ((0.66, -0.34, 0.19), (0.80, 0.00, -0.54), (1.02, -0.06, -0.82)),
        (0.0, -0.25, 0.07),
    ),
    _finger("Index", (0.764, 1.3790, 0.022), 0.115, (0.038, 0.023, 0.021), 0.0085, 0.0082, 0.98),
    _finger("Middle", (0.768, 1.3800, 0.001), 0.015, (0.042, 0.026, 0.022), 0.0087, 0.0084),
    _finger("Ring", (0.763, 1.3790, -0.019), -0.095, (0.039, 0.025, 0.021), 0.0082, 0.0079, 1.02),
    _finger("Little", (0.755, 1.3765, -0.0375), -0.215, (0.030, 0.019, 0.019), 0.0072, 0.0070, 1.04),
)
"""The fingers in the order of `live.base.body.expression.FINGERS`."""
PHALANGES: Final = ("Proximal", "Intermediate", "Distal")
"""Names of a finger's joints; the thumb's first is that of its metacarpal bone."""
