"""Muscles and rolling skin: detail joints that angles of the skeleton drive, so that limbs keep their shape when they
bend and twist, and the places that they move. All of the left side, in the rest pose [m].
"""

from dataclasses import dataclass
from math import pi
from typing import Final

from live.render.body.fingers import Vector


@dataclass(frozen=True, slots=True)
class Driver:
    """How far a joint of the skeleton is turned about an axis, beside its parent: the twist of its swing-twist
    decomposition (Dobrowolski 2015) [rad], from `least` to pi."""

    joint: str
    axis: Vector
    """Unit, in the axes of the rest pose."""
    least: float = -pi


@dataclass(frozen=True, slots=True)
class Muscle:
    """A detail joint that an angle of a bone turns."""

    name: str
    parent: str
    pivot: Vector
    driver: Driver
    turn: Vector
    """Rotation vector for an angle of one radian."""
    centre: Vector | None = None
    """Middle of the skin that it moves; None: the cage says what it moves."""
    radii: Vector = (0.0, 0.0, 0.0)
    """How far from there it still moves skin."""
    share: float = 0.8
    """Its weight in the middle."""


_X: Final = (1.0, 0.0, 0.0)
_Y: Final = (0.0, 1.0, 0.0)
_Z: Final = (0.0, 0.0, 1.0)

MUSCLES: Final = (
    # skin near a joint follows only a part of a bone's turn about its own axis, or the whole limb would twist there
    Muscle("ArmRoll", "UpperArm", (0.165, 1.380, -0.010), Driver("UpperArm", _X), (-0.75, 0.0, 0.0)),
    Muscle("ForearmRoll", "LowerArm", (0.430, 1.380, -0.010), Driver("Hand", _X), (0.60, 0.0, 0.0)),
    Muscle("ThighRoll", "UpperLeg", (0.090, 0.890, 0.000), Driver("UpperLeg", _Y), (0.0, -0.70, 0.0)),
    # muscles that shorten: far pivots, so that they glide outwards more than they turn
    Muscle(
        "Biceps", "UpperArm", (0.090, 1.380, 0.020), Driver("LowerArm", _Y), (0.0, 0.024, 0.0),
        (0.300, 1.382, 0.026), (0.085, 0.050, 0.040),
    ),
    Muscle(
        "Calf", "LowerLeg", (0.090, 0.560, -0.060), Driver("Foot", _X), (0.035, 0.0, 0.0),
        (0.090, 0.355, -0.058), (0.060, 0.100, 0.050),
    ),
    # a raised arm takes the side of the back along, and turns the shoulder blade
    Muscle(
        "Back", "upperChest", (0.160, 1.180, 0.000), Driver("UpperArm", _Z, 0.0), (0.0, 0.0, -0.09),
        (0.116, 1.282, -0.020), (0.070, 0.110, 0.085), 0.65,
    ),
    Muscle(
        "Blade", "upperChest", (0.070, 1.350, -0.080), Driver("UpperArm", _Z, 0.0), (0.0, 0.0, 0.35),
        (0.082, 1.290, -0.090), (0.070, 0.090, 0.056), 0.6,
    ),
)  # fmt: skip
"""All muscles of the left side."""
