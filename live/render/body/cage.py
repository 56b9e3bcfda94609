"""Coarse cage of the dancer's body: quadrilaterals that follow the skeleton, with skin weights at the corners.

Edge loops across every limb let joints bend softly, and every subdivision of the cage is closed.
The left half (x >= 0) is built and mirrored; corners at x = 0 are shared by both halves.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.render.body.drawn_joints import DRAWN_COUNT, DRAWN_MIRROR, DRAWN_NAMES

Point = tuple[float, float, float]
JointWeights = dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Cage:
    """A closed mesh of quadrilaterals, counter-clockwise seen from outside (V corners, F faces, J drawn joints)."""

    points: Float64
    """Corners [m], shape (V, 3)."""
    weights: Float64
    """Skin weights of each corner, rows sum to 1, shape (V, J)."""
    faces: Int64
    """Corner indices, shape (F, 4)."""


class _HalfBuilder:
    """Builder of the left half; rings are lists of four corners, ordered around the direction of extrusion."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.weights: list[Float64] = []
        self.faces: list[tuple[int, int, int, int]] = []

    def ring(self, points: list[Point], weights: JointWeights | list[JointWeights]) -> list[int]:
        bonds = weights if isinstance(weights, list) else [weights] * len(points)
        first = len(self.points)
        self.points += points
        self.weights += [_weights(one) for one in bonds]
        return list(range(first, first + len(points)))

    def bridge(self, a: list[int], b: list[int], skip: int | None = None, *, open_: bool = False) -> None:
        """Faces between two rings; `open_` leaves the seam at x = 0, `skip` leaves a hole for a limb."""
        count = len(a)
        for i in range(count - 1 if open_ else count):
            if i != skip:
                j = (i + 1) % count
                self.faces.append((a[i], a[j], b[j], b[i]))

    def cap(self, ring: list[int]) -> None:
        self.faces.append((ring[0], ring[1], ring[2], ring[3]))


def _weights(bond: JointWeights) -> Float64:
    row = np.zeros(DRAWN_COUNT)
    for name, weight in bond.items():
        row[DRAWN_NAMES.index(name)] = weight
    return np.asarray(row / row.sum())


# Torso, neck and head from the hip crease up: y [m], half-width, front, back, shift in z, weights.
_TRUNK: Final[tuple[tuple[float, float, float, float, JointWeights], ...]] = (
    (0.940, 0.140, 0.085, -0.100, {"hips": 0.90, "leftUpperLeg": 0.10}),
    (1.045, 0.100, 0.082, -0.065, {"hips": 0.28, "spine": 0.62, "chest": 0.10}),
    (1.140, 0.108, 0.085, -0.070, {"spine": 0.35, "chest": 0.60, "upperChest": 0.05}),
    (1.240, 0.122, 0.102, -0.082, {"chest": 0.50, "upperChest": 0.50}),
    (1.310, 0.128, 0.088, -0.090, {"chest": 0.08, "upperChest": 0.84, "leftShoulder": 0.08}),
    (1.415, 0.105, 0.030, -0.072, {"upperChest": 0.55, "leftShoulder": 0.45}),
    (1.450, 0.046, 0.034, -0.064, {"upperChest": 0.42, "neck": 0.58}),
)
_SHOULDER_ROW: Final = 5

# Head rows: the four corners (front middle, front, back, back middle).
_HEAD: Final[tuple[tuple[tuple[Point, Point, Point, Point], JointWeights], ...]] = (
    (
        ((0.0, 1.492, 0.074), (0.040, 1.508, 0.040), (0.044, 1.530, -0.050), (0.0, 1.530, -0.072)),
        {"neck": 0.45, "head": 0.55},
    ),
    (((0.0, 1.535, 0.090), (0.052, 1.550, 0.055), (0.064, 1.575, -0.058), (0.0, 1.570, -0.088)), {"head": 1.0}),
    (((0.0, 1.585, 0.100), (0.058, 1.600, 0.060), (0.070, 1.620, -0.052), (0.0, 1.620, -0.092)), {"head": 1.0}),
    (((0.0, 1.655, 0.080), (0.048, 1.662, 0.055), (0.052, 1.670, -0.052), (0.0, 1.672, -0.075)), {"head": 1.0}),
)

# Arm rings along x: x, half-height, half-depth, weights; centre line at the height of the shoulder joint.
_ARM_LINE: Final = (1.380, -0.010)
_ARM: Final[tuple[tuple[float, float, float, JointWeights], ...]] = (
    (0.215, 0.042, 0.040, {"leftShoulder": 0.14, "leftUpperArm": 0.86}),
    (0.335, 0.028, 0.029, {"leftUpperArm": 1.0}),
    (0.430, 0.025, 0.026, {"leftUpperArm": 0.50, "leftLowerArm": 0.50}),
    (0.515, 0.025, 0.027, {"leftLowerArm": 1.0}),
    (0.655, 0.015, 0.019, {"leftLowerArm": 0.80, "leftHand": 0.20}),
    (0.705, 0.013, 0.026, {"leftLowerArm": 0.02, "leftHand": 0.98}),
    (0.765, 0.011, 0.030, {"leftHand": 1.0}),
    (0.848, 0.005, 0.014, {"leftHand": 1.0}),
)
_THUMB_RING: Final = 6
"""The thumb grows from the front of the band that ends with this ring."""

# Leg rings down y: y, half-width, front, back, weights; centre line under the hip joint.
_LEG_X: Final = 0.090
_LEG: Final[tuple[tuple[float, float, float, float, JointWeights], ...]] = (
    (0.760, 0.062, 0.066, -0.068, {"hips": 0.08, "leftUpperLeg": 0.92}),
    (0.590, 0.042, 0.050, -0.046, {"leftUpperLeg": 1.0}),
    (0.475, 0.035, 0.039, -0.036, {"leftUpperLeg": 0.50, "leftLowerLeg": 0.50}),
    (0.365, 0.035, 0.030, -0.050, {"leftLowerLeg": 1.0}),
    (0.165, 0.021, 0.023, -0.026, {"leftLowerLeg": 1.0}),
    (0.085, 0.022, 0.034, -0.034, {"leftLowerLeg": 0.42, "leftFoot": 0.58}),
)
_HEEL: Final[tuple[Point, ...]] = (
    (0.066, 0.004, 0.030),
    (0.066, 0.004, -0.056),
    (0.114, 0.004, -0.056),
    (0.114, 0.004, 0.030),
)
# Foot rings forward z: z, low y, high y, inner x, outer x, weights.
_FOOT: Final[tuple[tuple[float, float, float, float, float, JointWeights], ...]] = (
    (0.120, 0.002, 0.038, 0.056, 0.126, {"leftFoot": 0.52, "leftToes": 0.48}),
    (0.184, 0.003, 0.020, 0.066, 0.110, {"leftToes": 1.0}),
)
_BUN: Final = ((0.0, 1.668, -0.094), 0.030)


def _trunk(half: _HalfBuilder) -> list[list[int]]:
    crease: list[Point] = [(0.0, 0.812, 0.034), (0.150, 0.862, 0.060), (0.140, 0.828, -0.085), (0.0, 0.808, -0.050)]
    side = {"hips": 0.50, "leftUpperLeg": 0.50}
    rows = [half.ring(crease, [{"hips": 1.0}, side, {"hips": 0.42, "leftUpperLeg": 0.58}, {"hips": 1.0}])]
    for y, width, front, back, bond in _TRUNK:
        middle = {name: weight for name, weight in bond.items() if not name.startswith("left")}
        corners: list[Point] = [(0.0, y, front), (width, y, front * 0.72), (width, y, back * 0.72), (0.0, y, back)]
        rows.append(half.ring(corners, [middle, bond, bond, middle]))
    for corners_, bond in _HEAD:
        rows.append(half.ring(list(corners_), bond))
    for index in range(len(rows) - 1):
        socket = 1 if index == _SHOULDER_ROW else None
        half.bridge(rows[index], rows[index + 1], socket, open_=True)
    half.cap(rows[-1])
    return rows


def _arm(half: _HalfBuilder, low: list[int], high: list[int]) -> None:
    y, z = _ARM_LINE
    previous = [high[2], high[1], low[1], low[2]]
    for number, (x, tall, deep, bond) in enumerate(_ARM):
        drop = 0.012 * max(0.0, (x - 0.76) / 0.09)  # fingers hang a little
        corners: list[Point] = [
            (x, y + tall - drop, z - deep),
            (x, y + tall - drop, z + deep),
            (x, y - tall - drop, z + deep),
            (x, y - tall - drop, z - deep),
        ]
        ring = half.ring(corners, bond)
        half.bridge(previous, ring, 1 if number == _THUMB_RING else None)
        if number == _THUMB_RING:
            _thumb(half, previous, ring)
        previous = ring
    half.cap(previous)


def _thumb(half: _HalfBuilder, near: list[int], far: list[int]) -> None:
    base = [far[2], far[1], near[1], near[2]]
    tip: list[Point] = [
        (0.782, 1.356, 0.050),
        (0.778, 1.368, 0.054),
        (0.762, 1.368, 0.066),
        (0.764, 1.356, 0.066),
    ]
    ring = half.ring(tip, {"leftHand": 1.0})
    half.bridge(base, ring)
    half.cap(ring)


def _leg(half: _HalfBuilder, crease: list[int]) -> None:
    previous = [crease[0], crease[3], crease[2], crease[1]]
    for y, width, front, back, bond in _LEG:
        inner, outer = _LEG_X - width, _LEG_X + width
        corners: list[Point] = [(inner, y, front), (inner, y, back), (outer, y, back), (outer, y, front)]
        ring = half.ring(corners, bond)
        half.bridge(previous, ring)
        previous = ring
    heel = half.ring(list(_HEEL), {"leftFoot": 1.0})
    half.bridge(previous, heel, 3)
    half.cap(heel)
    across = [heel[3], previous[3], previous[0], heel[0]]
    for z, low, high, inner, outer, bond in _FOOT:
        ring = half.ring([(outer, low, z), (outer, high, z), (inner, high, z), (inner, low, z)], bond)
        half.bridge(across, ring)
        across = ring
    half.cap(across)


def _mirrored(half: _HalfBuilder) -> Cage:
    points = np.array(half.points)
    weights = np.array(half.weights)
    faces = np.array(half.faces, np.int64)
    middle = points[:, 0] == 0.0
    other = np.arange(len(points))
    other[~middle] = len(points) + np.arange(int((~middle).sum()))
    swapped = weights[:, list(DRAWN_MIRROR)]
    weights[middle] = 0.5 * (weights[middle] + swapped[middle])
    reflected = points[~middle] * np.array([-1.0, 1.0, 1.0])
    # reversed, and turned so that a face and its mirror image start at the same corner
    mirrored_faces = other[faces][:, [0, 3, 2, 1]]
    return Cage(
        np.concatenate([points, reflected]),
        np.concatenate([weights, swapped[~middle]]),
        np.concatenate([faces, mirrored_faces]),
    )


def build_cage() -> Cage:
    """Return the cage of the body without its hair bun, in the rest pose."""
    half = _HalfBuilder()
    rows = _trunk(half)
    _leg(half, rows[0])
    _arm(half, rows[_SHOULDER_ROW], rows[_SHOULDER_ROW + 1])
    return _mirrored(half)


def build_bun_cage() -> Cage:
    """Return the cage of the hair bun: a cube on the back of the head."""
    (x, y, z), r = _BUN
    signs = np.array(
        [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    )
    faces = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2]], np.int64)
    weights = np.tile(_weights({"head": 1.0}), (8, 1))
    return Cage(np.array([x, y, z]) + signs * r, weights, faces)
