"""The dancer's body as limbs with elliptical cross-sections, for contact with cloth and hair.

A *limb* is a line fixed to a joint. At each place along it the cross-section has a half-width to the sides, in front
and behind (a calf bulges behind only), and both ends are rounded. Their inverses are polynomials, because contact
divides by them. `live/render/body/body_limbs.py` fits these to the surface of each body that is drawn.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.motion.skeleton import SKELETON

DEGREE: Final = 3
"""Degree of the polynomials."""
COEFFICIENTS: Final = DEGREE + 1
SECTION_COLUMNS: Final = 3 * COEFFICIENTS + 2
"""Numbers of a limb [1/m]: coefficients of the inverse half-widths to the sides, in front and behind, from the constant
on, and the inverse of how far the rounded ends reach beyond start and end."""
_Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Limb:
    """A limb: its joint, its line in the rest pose [m], directions of its sides and of its front, both unit vectors."""

    name: str
    joint: int
    start: _Point
    end: _Point
    side: _Point
    front: _Point

    @property
    def length(self) -> float:
        """Length of its line [m]."""
        return float(np.linalg.norm(np.subtract(self.end, self.start)))

    def axes(self) -> Float64:
        """Return side, direction along the line and front as columns, (3, 3)."""
        along = np.subtract(self.end, self.start) / self.length
        side = np.array(self.side) - along * float(np.dot(self.side, along))
        side /= np.linalg.norm(side)
        front = np.cross(side, along)
        front *= np.sign(np.dot(front, self.front))
        return np.stack([side, along, front], axis=1)


_X: Final = (1.0, 0.0, 0.0)
_Y: Final = (0.0, 1.0, 0.0)
_Z: Final = (0.0, 0.0, 1.0)


def _limb(name: str, joint: str, start: _Point, end: _Point, side: _Point = _X, front: _Point = _Z) -> Limb:
    return Limb(name, SKELETON.index(joint), start, end, side, front)


def _both(name: str, joint: str, start: _Point, end: _Point, side: _Point, front: _Point) -> tuple[Limb, Limb]:
    other = (-start[0], *start[1:]), (-end[0], *end[1:])
    return (
        _limb(f"left {name}", f"left{joint}", start, end, side, front),
        _limb(f"right {name}", f"right{joint}", other[0], other[1], (-side[0], *side[1:]), front),
    )


LIMBS: Final[tuple[Limb, ...]] = (
    _limb("pelvis", "hips", (0.0, 0.875, 0.0), (0.0, 1.03, 0.0)),
    _limb("waist", "spine", (0.0, 1.03, 0.0), (0.0, 1.15, 0.0)),
    _limb("chest", "chest", (0.0, 1.15, 0.0), (0.0, 1.275, 0.0)),
    _limb("shoulders", "upperChest", (0.0, 1.275, 0.0), (0.0, 1.385, 0.0)),
    _limb("neck", "neck", (0.0, 1.40, -0.005), (0.0, 1.50, -0.002)),
    _limb("head", "head", (0.0, 1.535, 0.0), (0.0, 1.635, 0.0)),
    *_both("upper arm", "UpperArm", (0.150, 1.380, -0.010), (0.430, 1.380, -0.010), _Y, _Z),
    *_both("forearm", "LowerArm", (0.430, 1.380, -0.010), (0.675, 1.380, -0.010), _Y, _Z),
    *_both("hand", "Hand", (0.690, 1.379, -0.009), (0.830, 1.366, -0.008), _Y, _Z),
    *_both("thigh", "UpperLeg", (0.090, 0.850, 0.0), (0.090, 0.475, 0.0), _X, _Z),
    *_both("shin", "LowerLeg", (0.090, 0.475, 0.0), (0.090, 0.085, 0.0), _X, _Z),
    *_both("foot", "Foot", (0.090, 0.040, -0.030), (0.090, 0.022, 0.140), _X, _Y),
)
"""The limbs of every body."""
LIMB_COUNT: Final = len(LIMBS)
LIMB_NAMES: Final = tuple(limb.name for limb in LIMBS)


BRIDGES: Final[dict[str, tuple[str, str]]] = {
    "between thighs": ("left thigh", "right thigh"),
    "between shins": ("left shin", "right shin"),
}
"""What fills the gap between two limbs, so that cloth is not caught there: an ellipse from one to the other."""


def limb_index(name: str) -> int:
    """Return the index of a limb; ValueError for an unknown name."""
    return LIMB_NAMES.index(name)


def half_widths(section: Float32, place: float) -> tuple[float, float, float]:
    """Return the half-widths to the sides, in front and behind [m] of a limb at `place`, 0 at its start, 1 at its end.

    section (SECTION_COLUMNS,): its numbers.
    """
    powers = place ** np.arange(COEFFICIENTS)
    three = section[: 3 * COEFFICIENTS].reshape(3, COEFFICIENTS) @ powers
    return 1.0 / float(three[0]), 1.0 / float(three[1]), 1.0 / float(three[2])
